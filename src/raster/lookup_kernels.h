/* The vectorised lookups' table, see texture_kernels.c; blocks of up to SL_TEXTURE_BLOCK. */
#ifndef SL_RASTER_LOOKUP_KERNELS_H
#define SL_RASTER_LOOKUP_KERNELS_H

#include "raster/internal.h"
#include "raster/textures.h"

/* Pixels that show one texture, each with its triangle. */
typedef struct sl_textured_block {
    float corner[9][SL_TEXTURE_BLOCK];    /* x y z of corners 0, 1, 2 relative to the eye */
    float s[3][SL_TEXTURE_BLOCK], t[3][SL_TEXTURE_BLOCK];
    float w1[SL_TEXTURE_BLOCK], w2[SL_TEXTURE_BLOCK];
    int32_t x[SL_TEXTURE_BLOCK], y[SL_TEXTURE_BLOCK]; /* pixel */
} sl_textured_block;

struct sl_texture_kernels {
    void (*texture)(const sl_texture_image *image, sl_sampler sampler, size_t count, const float *s, const float *t,
                    const float *lod, float *const plane[4]);
    void (*cube)(const sl_cube_map *cube, sl_sampler sampler, size_t count, const float *x, const float *y, const float *z,
                 const float *lod, float *const plane[4]);
    void (*volume)(const sl_volume *volume, sl_sampler sampler, size_t count, const float *s, const float *t, const float *r,
                   float *const plane[4]);
    void (*volume_nearest)(const sl_volume *volume, sl_sampler sampler, size_t count, const float *s, const float *t,
                           const float *r, uint32_t *bytes);
    void (*volume_fetch)(const sl_volume *volume, size_t count, const int32_t *x, const int32_t *y, const int32_t *z,
                         uint32_t *bytes);
    /* Coordinates and level of detail of a whole block. */
    void (*textured)(const sl_textured_block *block, const sl_view *view, int width, int height, sl_lod_rule rule, float *s,
                     float *t, float *lod);
};

const sl_texture_kernels *sl_texture_kernels_best(void);

#endif
