/* Records and what is seen in mirrors. */
#ifndef SL_CACHE_SPLATTING_MIRRORS_H
#define SL_CACHE_SPLATTING_MIRRORS_H

#include "cache/reflect/reflect.h"

/* Pixels of a few rows and columns that show something by way of mirrors: a rectangle and the box about what
 * they show. */
typedef struct sl_mirror_block {
    sl_splat_rect rect;
    sl_vec3 low, high;
} sl_mirror_block;

typedef struct sl_mirror_blocks {
    size_t count;
    sl_mirror_block *blocks; /* none crosses the borders of a splat tile; ascending by tile */
    int width, height;
} sl_mirror_blocks;

sl_status sl_mirror_blocks_make(const sl_gbuffer *gbuffer, const sl_reflections *reflections,
                                sl_mirror_blocks *blocks, sl_error *error);
void sl_mirror_blocks_release(sl_mirror_blocks *blocks);

/* The rectangles, one a tile at most, of pixels in `seen` or in a block that the sphere reaches; just `seen`,
 * where it reaches none. Returns how many; rects may be NULL. */
size_t sl_mirror_rects(const sl_mirror_blocks *blocks, sl_vec3 centre, float reach, sl_splat_rect seen,
                       sl_splat_rect *rects);

#endif
