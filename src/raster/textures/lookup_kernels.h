/* The vectorised lookups' table, see texture_kernels.c; blocks of up to SL_TEXTURE_BLOCK. */
#ifndef SL_RASTER_LOOKUP_KERNELS_H
#define SL_RASTER_LOOKUP_KERNELS_H

#include "raster/resolve/resolve.h"
#include "raster/textures/textures.h"

/* What the textured pass adds to a block of resolved pixels: of each run the texture (NULL: none) and its coordinates
 * at the corners; of each pixel the coordinates, level of detail and colour. */
typedef struct sl_textured_block {
    const sl_texture_image *image[SL_RESOLVE_RUNS];
    sl_run_corners corner_s, corner_t;
    float s[SL_RESOLVE_ROOM], t[SL_RESOLVE_ROOM], lod[SL_RESOLVE_ROOM];
    float color[4][SL_RESOLVE_ROOM];
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
    /* Coordinates and, if wanted, level of detail of a block's textured runs. */
    void (*textured)(const sl_resolve_block *block, const sl_view *view, sl_lod_rule rule, bool lod,
                     sl_textured_block *textured);
};

const sl_texture_kernels *sl_texture_kernels_best(void);

#endif
