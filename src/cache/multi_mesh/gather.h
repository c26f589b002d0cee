/* Indirect irradiance at a point: the coarse mesh of direct diffuse light, drawn as the point sees it under
 * 160 degrees, times a weight texture, summed on the hardware.
 *
 *   gather.c             where the point looks from, the render, the sums, what lies beyond the field of view
 *   gather_kernels.c     a picture's pixels: colours between the coarse mesh's vertices, times weights
 *   gather_sky.c         ... and where they show an environment that is a picture
 *
 * Mirrors are black in it, as are the sides of faces that reflect nothing or lie inside a solid: the paper's
 * gather follows no reflections. */
#ifndef SL_MULTI_MESH_GATHER_H
#define SL_MULTI_MESH_GATHER_H

#include "cache/multi_mesh/coarse.h"
#include "raster/raster.h"

enum { SL_MESH_GATHER_LEAST = 8 }; /* pixels a side */

typedef struct sl_mesh_gather_settings {
    int size;                  /* N of N x N pixels, a power of two */
    int reduced;               /* 16 */
    float fov;                 /* radians, both ways */
} sl_mesh_gather_settings;
typedef struct sl_mesh_gather sl_mesh_gather;
/* Emitters are black in it (their light is direct light), the environment is not. Scene, raster and coarse
 * mesh must outlive it. */
sl_status sl_mesh_gather_create(const sl_scene *scene, const sl_raster *raster, const sl_coarse *coarse,
                                const sl_mesh_gather_settings *settings, sl_mesh_gather **gather,
                                sl_error *error);
void sl_mesh_gather_destroy(sl_mesh_gather *gather);
size_t sl_mesh_gather_memory_bytes(const sl_mesh_gather *gather);
typedef struct sl_mesh_gather_scratch sl_mesh_gather_scratch;
sl_status sl_mesh_gather_scratch_create(const sl_mesh_gather *gather, sl_mesh_gather_scratch **scratch,
                                        sl_error *error);
void sl_mesh_gather_scratch_destroy(sl_mesh_gather_scratch *scratch);
/* E_i in W/m^2; a pure function of the point and the coarse mesh. Counts SL_COUNT_INDIRECT_SAMPLES. */
sl_rgb sl_mesh_gather_take(const sl_mesh_gather *gather, const sl_mesh_point *point,
                           sl_mesh_gather_scratch *scratch, sl_counters *counters);
/* The picture of the last one, before weights: N x N, bottom row first; for observers and tests. */
void sl_mesh_gather_picture(const sl_mesh_gather_scratch *scratch, int *size, const float *planes[3]);
/* The frame of that picture: z the point's normal. */
sl_frame sl_mesh_gather_frame(sl_vec3 normal);

#endif
