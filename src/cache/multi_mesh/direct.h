/* Direct radiance at points of unit reflectance, from the irradiance meshes: U_dd = sum over lights of E_d /
 * pi (equation 4 without k_d), U_ds = (n + 2) / (2 pi) sum cos^n alpha E_d (equation 6 without k_s). */
#ifndef SL_MULTI_MESH_DIRECT_H
#define SL_MULTI_MESH_DIRECT_H

#include "cache/light/light_sample.h"
#include "cache/patches/mesh.h"

/* From the shares of one point's lights (sl_irradiance_at()). */
sl_rgb sl_direct_diffuse(const sl_sampled_lights *lights, const float *share);

/* Towards the eye, from the lights' directions at a point. Equation (6) shrinks an area light to a point
 * inside the lobe, which outshines the lamp itself where the lobe is narrower than it, and is black where the
 * mirror direction meets the lamp beside its middle. So cos^n alpha is its mean over the light, by the
 * irradiance that each part of it gives where nothing hides it: as dense a grid of points as the lobe is
 * narrow, 16 to an edge at most. */
sl_rgb sl_direct_specular(const sl_sampled_lights *lights, const float *share, const sl_mesh_point *point,
                          float exponent, sl_vec3 eye);

/* ---- where light is asked for: a little beside the vertices, which lie on edges and may lie inside other
 * geometry ---- */

/* Moves a point on an edge into its face, at least `inwards` from all its edges unless the face is too small.
 */
void sl_step_inside(const sl_scene *scene, double inwards, sl_mesh_point *at);

/* Nudges the point of a vertex that lies inside a solid until it does not. False: it still does, and no light
 * there is anybody's. */
bool sl_leave_solid(const sl_patches *mesh, const sl_tracer *tracer, uint32_t vertex, sl_mesh_point *at,
                    bool *moved, sl_counters *counters);

static inline sl_lit_point sl_lit_point_of(const sl_mesh_point *at) {
    return (sl_lit_point){at->position, at->normal, at->geometric_normal, at->triangle};
}

#endif
