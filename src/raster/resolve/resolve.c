/* Blocks of pixels: their runs, their corners, their weights. */
#include "raster/resolve/resolve.h"

#include <string.h>

/* Neighbouring pixels may show triangles that lie far apart in memory. Asked for all together, before the
 * first is needed, they come in the time of a few. So many pixels, where triangles are so small that a
 * block's runs are all in use: as many as the next may take. */
enum { AHEAD = 128 };

static void find_vertices(const sl_raster *raster, size_t count, sl_resolve_block *block) {
    const sl_raster_mesh *mesh = &raster->mesh;
    for (uint32_t r = 0; r < block->runs; r++) {
        const uint32_t triangle = sl_run_triangle(block, r);
        for (int k = 0; k < 3; k++)
            block->vertex[k][r] = triangle == SL_NO_INDEX ? SL_NO_INDEX : mesh->vertex[k][triangle];
    }
    const size_t ahead = block->runs < SL_RESOLVE_RUNS ? 0 : AHEAD;
    for (size_t n = block->count; n < block->count + ahead && n < count; n += 2) {
        for (int k = 0; k < 3 && block->id[n] != SL_NO_INDEX; k++)
            __builtin_prefetch(mesh->vertex[k] + block->id[n]);
    }
    for (uint32_t r = 0; r < block->runs; r++) {
        for (int k = 0; k < 3 && block->vertex[k][r] != SL_NO_INDEX; k++) {
            const uint32_t v = block->vertex[k][r];
            __builtin_prefetch(mesh->x + v);
            __builtin_prefetch(mesh->y + v);
            __builtin_prefetch(mesh->z + v);
            if (block->later) __builtin_prefetch(block->later + v * block->later_bytes);
        }
    }
}

static void fetch_corners(const sl_raster *raster, sl_resolve_block *block) {
    for (uint32_t r = 0; r < block->runs; r++) {
        for (int k = 0; k < 3; k++) {
            const uint32_t v = block->vertex[k][r];
            const sl_vec3 p = v == SL_NO_INDEX ? sl_v3(0.0f, 0.0f, 0.0f) : sl_mesh_position(&raster->mesh, v);
            sl_put(block->corner.x[k], block->corner.y[k], block->corner.z[k], r, p);
        }
    }
}

size_t sl_resolve_next(const sl_raster *raster, const sl_pass_view *view, size_t count, size_t first,
                       const uint32_t *pixel, const uint32_t *id, sl_resolve_block *block) {
    if (!count) return 0;
    block->id = id;
    block->pixel = pixel;
    block->first = (uint32_t)first;
    SL_KERNEL_OF(raster->isa, sl_resolve_runs)(block, count);
    find_vertices(raster, count, block);
    fetch_corners(raster, block);
    SL_KERNEL_OF(raster->isa, sl_resolve_weights)(block, view);
    return block->count;
}

uint64_t sl_resolve_shaded(const sl_resolve_block *block) {
    uint64_t shaded = 0;
    for (uint32_t r = 0; r < block->runs; r++) {
        if (sl_run_triangle(block, r) != SL_NO_INDEX) shaded += block->start[r + 1] - block->start[r];
    }
    return shaded;
}

void sl_raster_barycentrics(const sl_raster *raster, const sl_view *view, size_t count, const uint32_t *pixel,
                            const uint32_t *id, float *w1, float *w2) {
    sl_pass_view pass = sl_pass_view_make(view, view->width, view->height);
    sl_resolve_block block;
    memset(&block, 0, sizeof block);
    for (size_t at = 0; at < count; at += block.count) {
        sl_resolve_next(raster, &pass, count - at, 0, pixel + at, id + at, &block);
        memcpy(w1 + at, block.w1, block.count * sizeof *w1);
        memcpy(w2 + at, block.w2, block.count * sizeof *w2);
    }
}
