/* Large targets: tiles of 256 x 256 pixels, each owned by one thread, which draws every cluster that touches it.
 *
 * A cluster that lies across an edge is transformed in both tiles, but its triangles touch disjoint pixels there, so no
 * thread waits for another and there is nothing to merge. The tiles are the same at any number of threads, and so is what
 * each of them draws and skips. */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "raster/internal.h"

typedef struct {
    const sl_raster *raster;
    const sl_view *view;
    const sl_target *target;
    sl_pass_view pass;
    sl_tiles tiles;
    sl_visible visible;
    sl_cluster_fate *fate;
    sl_raster_scratch *scratch; /* one a worker */
} tiled_pass;

static void draw_tile(void *context, size_t index, unsigned worker) {
    tiled_pass *p = context;
    sl_raster_scratch *scratch = &p->scratch[worker];
    int column = p->tiles.first_column + (int)index % p->tiles.columns, row = p->tiles.first_row + (int)index / p->tiles.columns;
    sl_tile_place(&scratch->tile, &p->pass, column, row);
    sl_tile_draw(p->raster, p->view, &p->pass, &p->visible, scratch, p->fate);
    p->raster->kernels->copy_out(&p->pass, &scratch->tile, p->target->id, p->target->depth);
}

static bool allocate(tiled_pass *p, unsigned threads) {
    p->fate = sl_allocate(p->raster->cluster_count, sizeof *p->fate);
    p->scratch = sl_allocate(threads, sizeof *p->scratch);
    bool ok = sl_visible_allocate(&p->visible, p->raster) && p->fate && p->scratch;
    for (unsigned i = 0; p->scratch && i < threads; i++) ok &= sl_scratch_allocate(&p->scratch[i]);
    return ok;
}

static void release(tiled_pass *p, unsigned threads) {
    for (unsigned i = 0; p->scratch && i < threads; i++) sl_scratch_free(&p->scratch[i]);
    sl_free(p->scratch);
    sl_free(p->fate);
    sl_visible_free(&p->visible);
}

sl_status sl_viewport_check(const sl_view *view, const sl_target *target, sl_error *error) {
    bool fits = view->width >= 1 && view->height >= 1 && view->x >= 0 && view->y >= 0 && target->width <= SL_RASTER_MAX_SIZE &&
                target->height <= SL_RASTER_MAX_SIZE && view->width <= target->width - view->x &&
                view->height <= target->height - view->y;
    if (fits) return SL_OK;
    return sl_fail(error, SL_ERROR_USAGE,
                   "a viewport of %d x %d pixels at (%d, %d) of a raster target of %d x %d: within it, from 1 to %d each way",
                   view->width, view->height, view->x, view->y, target->width, target->height, (int)SL_RASTER_MAX_SIZE);
}

sl_status sl_raster_id(const sl_raster *raster, const sl_view *view, unsigned threads, const sl_target *target,
                       sl_counters *counters, sl_error *error) {
    sl_status status = sl_viewport_check(view, target, error);
    if (status != SL_OK) return status;
    tiled_pass p = {.raster = raster, .view = view, .target = target,
                    .pass = sl_pass_view_make(view, target->width, target->height)};
    p.tiles = sl_tiles_of(&p.pass);
    size_t tiles = (size_t)p.tiles.columns * (size_t)p.tiles.rows;
    threads = sl_thread_count(threads);
    if (threads > tiles) threads = (unsigned)tiles;
    bool ok = allocate(&p, threads);
    if (ok) {
        raster->kernels->cull(raster, &p.pass, &p.visible);
        sl_visible_sort(&p.visible);
        sl_parallel_for(threads, tiles, draw_tile, &p);
        sl_pass_count(raster, &p.visible, p.fate, counters);
    }
    release(&p, threads);
    return ok ? SL_OK : sl_fail_memory(error, "a render's planes");
}
