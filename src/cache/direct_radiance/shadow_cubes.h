/* Pass 1: a depth cube around every light point, and what it says: a receiver is lit if its reciprocal planar depth is
 * at least the stored one, less the most by which two points of the receiver's own plane in one texel can differ. */
#ifndef SL_CACHE_DIRECT_RADIANCE_SHADOW_CUBES_H
#define SL_CACHE_DIRECT_RADIANCE_SHADOW_CUBES_H

#include "cache/direct_radiance/lights.h"
#include "raster/raster.h"

typedef struct sl_shadow_cubes sl_shadow_cubes;

/* A depth cube for every light point, a parallel map for a directional one; size texels a side of a face (of a
 * spot that fits in one face, over its cone alone), and less where an area light is
 * divided (its n x n cubes together have n times the texels of one) or lights are so many that their cubes would take more than 128 MiB.
 * Faces that no receiver can need (behind a one-sided area light, outside a spot's cone, without geometry) are not drawn, and counted as
 * skipped. */
sl_status sl_shadow_cubes_render(const sl_scene *scene, const sl_raster *raster, const sl_map_lights *lights, int size, unsigned threads,
                                 sl_shadow_cubes **cubes, sl_counters *counters, sl_error *error);
void sl_shadow_cubes_destroy(sl_shadow_cubes *cubes);
size_t sl_shadow_cubes_bytes(const sl_shadow_cubes *cubes);

/* 1 where the light point is seen, 0 where it is not, in between at a shadow's edge. p, and the receiver's geometric normal n (unit, on
 * the lit side) are arrays of count; lit[i] is multiplied. Points where lit is 0 already stay so. cubes may be NULL: all lit. */
void sl_shadow_cubes_lit(const sl_shadow_cubes *cubes, size_t light_point, size_t count, const float *px, const float *py, const float *pz,
                         const float *nx, const float *ny, const float *nz, float *lit, sl_counters *counters);

#endif
