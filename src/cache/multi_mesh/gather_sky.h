/* The environment as gathers see it where it is a picture: through a cube map, at the level that suits the
 * gather's pixels. */
#ifndef SL_MULTI_MESH_GATHER_SKY_H
#define SL_MULTI_MESH_GATHER_SKY_H

#include "cache/multi_mesh/gather_kernels.h"

typedef struct sl_gather_sky sl_gather_sky;
/* NULL with SL_OK where there is no environment, or a constant one. */
sl_status sl_gather_sky_create(const sl_environment *environment, sl_gather_sky **sky, sl_error *error);
void sl_gather_sky_destroy(sl_gather_sky *sky);
size_t sl_gather_sky_memory_bytes(const sl_gather_sky *sky);
float sl_gather_sky_brightest(const sl_gather_sky *sky);
/* The level of detail of pixels that are `step` apart on the plane at unit distance, at distance
 * sqrt(squared) from the foot of the perpendicular. */
float sl_gather_sky_lod(double step, double squared);
/* Radiance, plain and weighted, of pixels that show nothing; lod by pixel. */
void sl_gather_sky_add(const sl_gather_sky *sky, const sl_mesh_gather_pixels *pixels, const float *lod);

#endif
