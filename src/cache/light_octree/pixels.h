/* Indirect light of a picture's pixels: from the octree, or by way of the atlas where light does
 * not depend on the view. Glossy surfaces, and what mirrors show, look into the octree in
 * either case. */
#pragma once

#include "cache/light_octree/atlas/atlas.h"
#include "cache/reflect/reflect.h"

typedef struct sl_octree_pixels {
    const sl_scene *scene;
    const sl_gbuffer *gbuffer;
    const sl_reflections *reflections; /* or NULL */
    const sl_octree_shading *shading;
    sl_atlas_canvas *canvas;           /* or NULL; its sides are filled when a pixel first sees them */
    sl_vec3 eye;
    bool moves;                        /* diffuse pixels of a triangle, 2 x 2, have one irradiance */
    unsigned threads;
} sl_octree_pixels;

/* Three planes of the G-buffer's size, all of them written; background and mirrors 0. Fails for want of
 * memory alone. */
sl_status sl_octree_light_pixels(const sl_octree_pixels *pixels, float *const indirect[3],
                                 sl_counters *counters, sl_error *error);
/* Of a pixel that shows a surface. */
sl_octree_point sl_octree_point_of_pixel(const sl_scene *scene, const sl_gbuffer *gbuffer, sl_vec3 eye,
                                         size_t pixel);

/* ---- the photon map itself: every pixel gathers its nearest photons (Jensen 1996, direct visualization), as
 * a voxel does, and there are no lights in between. What the octree saves, and what it blurs, is the
 * difference. ---- */

/* Radiance that a surface reflects towards a viewer (unit) of the k photons nearest to it: L = kappa / A sum
 * f_r(omega_i, v) (n . omega_i) / max(n_i . omega_i, epsilon) Phi_i. Mirrors give nothing. The lights are
 * those of voxels, whose gathers are alike; theirs need not be made. One call at a time for each worker. */
sl_rgb sl_photons_radiance(sl_voxel_lights *lights, unsigned worker, const sl_surface *surface,
                           sl_vec3 to_viewer, sl_counters *counters);

/* Three planes of the G-buffer's size, all of them written. */
void sl_photons_light_pixels(const sl_scene *scene, const sl_gbuffer *gbuffer, sl_voxel_lights *lights,
                             unsigned threads, float *const indirect[3], sl_counters *counters);
