/* The tile's planes: cleared before anything is drawn, and turned from blocks into the target's rows at the
 * end, four blocks side by side being four rows of sixteen pixels. */
#include "raster/block.h"
#include "raster/tile.h"

void SL_KERNEL(sl_raster_clear)(const sl_pass_view *view, const sl_tile *tile) {
    const float far = view->inverse_w ? 0.0f : 1.0f;
    const size_t pixels = (size_t)tile->blocks_x * (size_t)tile->blocks_y * SL_LANES;
    uint32_t *restrict id = tile->id;
    float *restrict depth = tile->depth;
#pragma omp simd
    for (size_t i = 0; i < pixels; i++) {
        id[i] = SL_NO_INDEX;
        depth[i] = far;
    }
}

/* One row's pixels [x0, x1) of the tile. */
static void copy_pixels(const sl_tile *tile, const uint32_t *plane, int y, int x0, int x1, uint32_t *row) {
    for (int x = x0; x < x1; x++) row[x] = plane[sl_tile_index(tile, x, y)];
}

static void copy_plane(const sl_pass_view *view, const sl_tile *tile, const uint32_t *plane, uint32_t *out) {
    const size_t width = (size_t)view->width;
    const int first = tile->left + (tile->x0 - tile->left + SL_BLOCK - 1) / SL_BLOCK * SL_BLOCK;
    for (int y = tile->y0; y < tile->y1;) {
        uint32_t *to = out + (size_t)y * width;
        if ((y & (SL_BLOCK - 1)) == 0 && y + SL_BLOCK <= tile->y1 && first + SL_LANES <= tile->x1) {
            int x = first;
            for (; x + SL_LANES <= tile->x1; x += SL_LANES)
                sl_block_rows(plane + sl_tile_index(tile, x, y), to + x, width);
            for (int k = 0; k < SL_BLOCK; k++) {
                copy_pixels(tile, plane, y + k, tile->x0, first, to + (size_t)k * width);
                copy_pixels(tile, plane, y + k, x, tile->x1, to + (size_t)k * width);
            }
            y += SL_BLOCK;
        } else {
            copy_pixels(tile, plane, y, tile->x0, tile->x1, to);
            y++;
        }
    }
}

void SL_KERNEL(sl_raster_copy_out)(const sl_pass_view *view, const sl_tile *tile, uint32_t *id, float *depth);
void SL_KERNEL(sl_raster_copy_out)(const sl_pass_view *view, const sl_tile *tile, uint32_t *id,
                                   float *depth) {
    if (id) copy_plane(view, tile, tile->id, id);
    if (depth) copy_plane(view, tile, (const uint32_t *)(const void *)tile->depth, (uint32_t *)(void *)depth);
}
