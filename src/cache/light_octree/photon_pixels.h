/* A picture's indirect light from the photon map itself: every pixel gathers its nearest photons (Jensen
 * 1996, direct visualization), as a voxel does, and there are no lights in between. What the octree saves,
 * and what it blurs, is the difference. */
#ifndef SL_CACHE_LIGHT_OCTREE_PHOTON_PIXELS_H
#define SL_CACHE_LIGHT_OCTREE_PHOTON_PIXELS_H

#include "cache/light_octree/voxel_lights.h"
#include "raster/raster.h"

/* Radiance that a surface reflects towards a viewer (unit) of the k photons nearest to it: L = kappa / A sum
 * f_r(omega_i, v) (n . omega_i) / max(n_i . omega_i, epsilon) Phi_i. Mirrors give nothing. The lights are
 * those of voxels, whose gathers are alike; theirs need not be made. One call at a time for each worker. */
sl_rgb sl_photons_radiance(sl_voxel_lights *lights, unsigned worker, const sl_surface *surface,
                           sl_vec3 to_viewer);

/* Three planes of the G-buffer's size, all of them written. */
void sl_photons_light_pixels(const sl_scene *scene, const sl_gbuffer *gbuffer, sl_voxel_lights *lights,
                             unsigned threads, float *const indirect[3], sl_counters *counters);

#endif
