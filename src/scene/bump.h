/* Bump and parallax mapping: shading normals and colours as if the surface rose and fell by a height map. The
 * surface itself stays where it is: visibility, silhouettes and shadows do not change. */
#pragma once

#include "scene/scene.h"

static inline bool sl_material_is_bumpy(const sl_material *m) {
    return m->height_map != SL_NO_INDEX && m->bump_depth > 0.0f;
}

/* Where the viewer's ray would meet the raised surface, by one step with limited offset (Welsh 2004): u, v
 * are moved. Then the normal, as displacement would tilt it there (Blinn 1978, "Simulation of wrinkled
 * surfaces"). surface: position, normals, side and material are there; to_viewer need not be unit. */
void sl_bump(const sl_scene *scene, uint32_t triangle, sl_vec3 to_viewer, float *u, float *v,
             sl_surface *surface);
