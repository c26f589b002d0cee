/* Occlusion: whether all that a rectangle of pixels shows already is nearer than a bound, so that nothing behind the bound
 * can be seen (Greene, Kass and Miller 1993, "Hierarchical Z-buffer visibility", without the hierarchy: a cluster covers few
 * blocks, and the first of them that has a gap ends the search). */
#include <math.h>
#include <string.h>

#include "raster/block.h"
#include "raster/internal.h"

/* Pixels, numbered from the tile's first, within [first, last] in one direction. */
static inline sl_part_ints within(sl_part_ints i, int first, int last) { return (i >= first) & (i <= last); }

/* Hidden means strictly behind: at equal depth the lower triangle index wins. */
static inline sl_part_ints open_pixels(const float *depth, sl_part_floats nearest, bool larger_is_nearer) {
    const sl_part_floats drawn = sl_part_load_floats(depth);
    return larger_is_nearer ? nearest >= drawn : nearest <= drawn;
}

/* Pixels are numbered from the tile's first. Row by row of blocks; only the outer blocks need masks. */
static inline bool shows(const sl_tile *tile, const sl_rectangle *r, float bound, bool larger_is_nearer) {
    const int bx0 = r->x0 / SL_BLOCK, bx1 = r->x1 / SL_BLOCK;
    const sl_part_floats nearest = sl_part_float(bound);
    const sl_part_ints left = within(bx0 * SL_BLOCK + sl_part_x(), r->x0, r->x1);
    const sl_part_ints right = within(bx1 * SL_BLOCK + sl_part_x(), r->x0, r->x1);
    for (int by = r->y0 / SL_BLOCK; by <= r->y1 / SL_BLOCK; by++) {
        for (int part = 0; part < SL_PARTS; part++) {
            const float *depth = tile->depth + (size_t)(by * tile->blocks_x + bx0) * SL_LANES + part * SL_PART;
            sl_part_ints shown = open_pixels(depth, nearest, larger_is_nearer) & left;
            for (int bx = bx0 + 1; bx < bx1; bx++) {
                depth += SL_LANES;
                shown |= open_pixels(depth, nearest, larger_is_nearer);
            }
            if (bx1 > bx0) shown |= open_pixels(depth + SL_LANES, nearest, larger_is_nearer) & right;
            if (sl_part_negative(shown & within(by * SL_BLOCK + part * SL_PART_ROWS + sl_part_y(), r->y0, r->y1))) return true;
        }
    }
    return false;
}

bool SL_KERNEL(sl_raster_occluded)(const sl_pass_view *view, const sl_tile *tile, sl_rectangle pixels, float nearest);
bool SL_KERNEL(sl_raster_occluded)(const sl_pass_view *view, const sl_tile *tile, sl_rectangle pixels, float nearest) {
    sl_rectangle r = {pixels.x0 - tile->left, pixels.y0 - tile->low, pixels.x1 - tile->left, pixels.y1 - tile->low};
    return view->inverse_w ? !shows(tile, &r, nearest, true) : !shows(tile, &r, nearest, false);
}

/* ---- the tile's planes ---- */

void SL_KERNEL(sl_raster_clear)(const sl_pass_view *view, const sl_tile *tile);
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
            for (; x + SL_LANES <= tile->x1; x += SL_LANES) sl_block_rows(plane + sl_tile_index(tile, x, y), to + x, width);
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
void SL_KERNEL(sl_raster_copy_out)(const sl_pass_view *view, const sl_tile *tile, uint32_t *id, float *depth) {
    if (id) copy_plane(view, tile, tile->id, id);
    if (depth) copy_plane(view, tile, (const uint32_t *)(const void *)tile->depth, (uint32_t *)(void *)depth);
}
