/* Occlusion: the coarse depth of a tile, the farthest depth in every cell of 8 x 8 pixels (Greene, Kass and Miller 1993,
 * "Hierarchical Z-buffer visibility", with one level). What lies behind it cannot be seen.
 *
 * A cell's value is made again only when it is asked for and something was drawn over it since; an old one is farther, so
 * it is safe to use. */
#include <math.h>
#include <string.h>

#include "raster/internal.h"

/* The cell is 2 x 2 blocks, the rows of blocks apart in memory. */
static float farthest_in(const sl_tile *tile, int cell_x, int cell_y, bool larger_is_nearer) {
    const float *restrict low = tile->depth + (size_t)((2 * cell_y) * tile->blocks_x + 2 * cell_x) * SL_LANES;
    const float *restrict high = low + (size_t)tile->blocks_x * SL_LANES;
    float lane[SL_LANES];
    if (larger_is_nearer) {
#pragma omp simd
        for (int l = 0; l < SL_LANES; l++) {
            float a = low[l] < low[l + SL_LANES] ? low[l] : low[l + SL_LANES];
            float b = high[l] < high[l + SL_LANES] ? high[l] : high[l + SL_LANES];
            lane[l] = a < b ? a : b;
        }
        for (int n = SL_LANES / 2; n; n /= 2) {
            for (int l = 0; l < n; l++) lane[l] = lane[l] < lane[l + n] ? lane[l] : lane[l + n];
        }
    } else {
#pragma omp simd
        for (int l = 0; l < SL_LANES; l++) {
            float a = low[l] > low[l + SL_LANES] ? low[l] : low[l + SL_LANES];
            float b = high[l] > high[l + SL_LANES] ? high[l] : high[l + SL_LANES];
            lane[l] = a > b ? a : b;
        }
        for (int n = SL_LANES / 2; n; n /= 2) {
            for (int l = 0; l < n; l++) lane[l] = lane[l] > lane[l + n] ? lane[l] : lane[l + n];
        }
    }
    return lane[0];
}

bool SL_KERNEL(sl_raster_occluded)(const sl_pass_view *view, const sl_tile *tile, int x0, int y0, int x1, int y1,
                                   float nearest);
bool SL_KERNEL(sl_raster_occluded)(const sl_pass_view *view, const sl_tile *tile, int x0, int y0, int x1, int y1,
                                   float nearest) {
    const bool larger_is_nearer = view->inverse_w;
    int cell_x0 = (x0 - tile->left) / SL_CELL, cell_x1 = (x1 - tile->left) / SL_CELL;
    int cell_y0 = (y0 - tile->low) / SL_CELL, cell_y1 = (y1 - tile->low) / SL_CELL;
    for (int y = cell_y0; y <= cell_y1; y++) {
        for (int x = cell_x0; x <= cell_x1; x++) {
            int cell = y * tile->cells_x + x;
            if (tile->stale[cell]) {
                tile->farthest[cell] = farthest_in(tile, x, y, larger_is_nearer);
                tile->stale[cell] = 0;
            }
            bool hidden = larger_is_nearer ? nearest < tile->farthest[cell] : nearest > tile->farthest[cell];
            if (!hidden) return false;
        }
    }
    return true;
}

void SL_KERNEL(sl_raster_make_stale)(const sl_tile *tile, int x0, int y0, int x1, int y1);
void SL_KERNEL(sl_raster_make_stale)(const sl_tile *tile, int x0, int y0, int x1, int y1) {
    int cell_x0 = (x0 - tile->left) / SL_CELL, cell_x1 = (x1 - tile->left) / SL_CELL;
    int cell_y0 = (y0 - tile->low) / SL_CELL, cell_y1 = (y1 - tile->low) / SL_CELL;
    for (int y = cell_y0; y <= cell_y1; y++) {
        memset(tile->stale + y * tile->cells_x + cell_x0, 1, (size_t)(cell_x1 - cell_x0 + 1));
    }
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
    const int cells = tile->cells_x * tile->cells_y;
    for (int c = 0; c < cells; c++) tile->farthest[c] = far;
    memset(tile->stale, 0, (size_t)cells);
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
