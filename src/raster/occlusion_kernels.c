/* Occlusion: whether all that a rectangle of pixels shows already is nearer than a bound, so that nothing behind the bound
 * can be seen (Greene, Kass and Miller 1993, "Hierarchical Z-buffer visibility", without the hierarchy: a cluster covers few
 * blocks, and the first of them that has a gap ends the search). */
#include <math.h>
#include <string.h>

#include "raster/internal.h"

/* Blocks [bx0, bx1] of one row, depth at the first. Pixels are numbered from the tile's first, as in the rectangle; y: of the
 * blocks' first row. Hidden means strictly behind: at equal depth the lower triangle index wins. */
static inline bool row_shows(const float *restrict depth, int bx0, int bx1, int y, const sl_rectangle *r, float nearest,
                             bool larger_is_nearer) {
    const int x0 = r->x0, x1 = r->x1, y0 = r->y0, y1 = r->y1;
    int32_t shows[SL_LANES] = {0}, any = 0;
    for (int bx = bx0; bx <= bx1; bx++, depth += SL_LANES) {
#pragma omp simd
        for (int l = 0; l < SL_LANES; l++) {
            int i = bx * SL_BLOCK + (l & 3), j = y + (l >> 2);
            int32_t outside = sl_if_negative((i - x0) | (x1 - i) | (j - y0) | (y1 - j));
            int32_t open = larger_is_nearer ? (nearest >= depth[l] ? -1 : 0) : (nearest <= depth[l] ? -1 : 0);
            shows[l] |= open & ~outside;
        }
    }
    for (int l = 0; l < SL_LANES; l++) any |= shows[l];
    return any != 0;
}

static inline bool shows(const sl_tile *tile, const sl_rectangle *r, float nearest, bool larger_is_nearer) {
    const int bx0 = r->x0 / SL_BLOCK, bx1 = r->x1 / SL_BLOCK;
    for (int by = r->y0 / SL_BLOCK; by <= r->y1 / SL_BLOCK; by++) {
        const float *depth = tile->depth + (size_t)(by * tile->blocks_x + bx0) * SL_LANES;
        if (row_shows(depth, bx0, bx1, by * SL_BLOCK, r, nearest, larger_is_nearer)) return true;
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

static void copy_plane(const sl_pass_view *view, const sl_tile *tile, const uint32_t *restrict plane, uint32_t *restrict out) {
    for (int y = tile->y0; y < tile->y1; y++) {
        const uint32_t *restrict row = plane + sl_tile_index(tile, tile->left, y);
        uint32_t *restrict to = out + (size_t)y * (size_t)view->width;
        int x = tile->x0;
        for (; x < tile->x1 && (x & 3); x++) to[x] = row[((x - tile->left) >> 2) * SL_LANES + (x & 3)];
        for (; x + SL_BLOCK <= tile->x1; x += SL_BLOCK) memcpy(to + x, row + ((x - tile->left) >> 2) * SL_LANES, 16);
        for (; x < tile->x1; x++) to[x] = row[((x - tile->left) >> 2) * SL_LANES + (x & 3)];
    }
}

void SL_KERNEL(sl_raster_copy_out)(const sl_pass_view *view, const sl_tile *tile, uint32_t *id, float *depth);
void SL_KERNEL(sl_raster_copy_out)(const sl_pass_view *view, const sl_tile *tile, uint32_t *id, float *depth) {
    if (id) copy_plane(view, tile, tile->id, id);
    if (depth) copy_plane(view, tile, (const uint32_t *)(const void *)tile->depth, (uint32_t *)(void *)depth);
}
