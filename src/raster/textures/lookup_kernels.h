/* The vectorised lookups' table, see texture_kernels.c; blocks of up to SL_TEXTURE_BLOCK. */
#ifndef SL_RASTER_LOOKUP_KERNELS_H
#define SL_RASTER_LOOKUP_KERNELS_H

#include "raster/textures/textures.h"

struct sl_texture_kernels {
    void (*texture)(const sl_texture_image *image, size_t count, const float *s, const float *t,
                    const float *lod, float *const plane[4]);
    void (*cube)(const sl_cube_map *cube, size_t count, const float *x, const float *y, const float *z,
                 const float *lod, float *const plane[4]);
};

const sl_texture_kernels *sl_texture_kernels_best(void);

#endif
