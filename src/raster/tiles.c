/* Large targets: tiles of 256 x 256 pixels, each owned by one thread, which draws every cluster that touches
 * it.
 *
 * A cluster that lies across an edge is transformed in both tiles, but its triangles touch disjoint pixels
 * there, so no thread waits for another and there is nothing to merge. The tiles are the same at any number
 * of threads, and so is what each of them draws and skips. Those with most to draw come first, so that at the
 * end threads wait for little ones. */
#include <stdlib.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "raster/pipeline.h"

/* One view of those that are drawn together. */
typedef struct {
    const sl_view *view;
    const sl_target *target;
    sl_pass_view pass;
    sl_tiles tiles;
    size_t first_tile; /* of all views' */
    sl_visible *visible; /* these two are one scratch's, the view's own */
    sl_cluster_fate *fate;
} tiled_view;

typedef struct {
    uint64_t work; /* roughly */
    const tiled_view *picture;
    size_t number; /* of the tile in its view */
} tile_task;

typedef struct {
    const sl_raster *raster;
    size_t pictures, tiles;
    tiled_view *picture;
    tile_task *task;
    size_t scratches;
    /* for each worker its vertices, batch and tile; and for each view what it sees */
    sl_raster_scratch **scratch;
} tiled_passes;

/* Finds what the tiles of a view have to draw: the triangles of the clusters that touch them, and their
 * pixels. */
static void weigh_tiles(const sl_raster *raster, const tiled_view *picture, tile_task *task) {
    const sl_tiles *tiles = &picture->tiles;
    const sl_visible *v = picture->visible;
    for (int n = 0; n < tiles->columns * tiles->rows; n++) {
        sl_tile tile;
        sl_tile_place(&tile, &picture->pass, tiles->first_column + n % tiles->columns,
                      tiles->first_row + n / tiles->columns);
        task[n] = (tile_task){(uint64_t)((tile.x1 - tile.x0) * (tile.y1 - tile.y0)) / 16, picture, (size_t)n};
    }
    for (uint32_t i = 0; i < v->count; i++) {
        for (int y = v->y0[i] / SL_TILE - tiles->first_row; y <= v->y1[i] / SL_TILE - tiles->first_row; y++) {
            for (int x = v->x0[i] / SL_TILE - tiles->first_column;
                 x <= v->x1[i] / SL_TILE - tiles->first_column; x++) {
                task[y * tiles->columns + x].work += raster->triangles[v->cluster[i]];
            }
        }
    }
}

static int most_work_first(const void *a, const void *b) {
    const tile_task *s = a, *t = b;
    if (s->work != t->work) return s->work > t->work ? -1 : 1;
    size_t i = s->picture->first_tile + s->number, j = t->picture->first_tile + t->number;
    return (i > j) - (i < j);
}

static void cull_view(void *context, size_t index, unsigned worker) {
    (void)worker;
    tiled_passes *p = context;
    tiled_view *picture = &p->picture[index];
    SL_KERNEL_OF(p->raster->isa, sl_raster_cull)(p->raster, &picture->pass, picture->visible);
    sl_visible_sort(picture->visible);
    for (uint32_t i = 0; i < picture->visible->count; i++) picture->fate[i] = 0;
    weigh_tiles(p->raster, picture, p->task + picture->first_tile);
}

static void draw_tile(void *context, size_t index, unsigned worker) {
    tiled_passes *p = context;
    const tiled_view *picture = p->task[index].picture;
    int number = (int)p->task[index].number, columns = picture->tiles.columns;
    sl_raster_scratch *scratch = p->scratch[worker];
    sl_tile_place(&scratch->tile, &picture->pass, picture->tiles.first_column + number % columns,
                  picture->tiles.first_row + number / columns);
    sl_tile_draw(p->raster, picture->view, &picture->pass, picture->visible, scratch, picture->fate);
    SL_KERNEL_OF(p->raster->isa, sl_raster_copy_out)(&picture->pass, &scratch->tile, picture->target->id,
                                                     picture->target->depth);
}

static bool allocate(tiled_passes *p, unsigned threads) {
    p->scratches = threads > p->pictures ? threads : p->pictures;
    p->scratch = sl_allocate(p->scratches, sizeof *p->scratch);
    p->task = sl_allocate(p->tiles, sizeof *p->task);
    bool ok = p->scratch && p->task;
    for (size_t i = 0; ok && i < p->scratches; i++) ok = (p->scratch[i] = sl_spare_take(p->raster)) != NULL;
    for (size_t n = 0; ok && n < p->pictures; n++) {
        p->picture[n].visible = &p->scratch[n]->visible;
        p->picture[n].fate = p->scratch[n]->fate;
    }
    return ok;
}

static void release(tiled_passes *p) {
    for (size_t i = 0; p->scratch && i < p->scratches; i++) sl_spare_give(p->raster, p->scratch[i]);
    sl_free(p->scratch);
    sl_free(p->task);
}

/* Refuses a viewport that does not lie within the target. */
static sl_status check_viewport(const sl_view *view, const sl_target *target, sl_error *error) {
    bool fits = view->width >= 1 && view->height >= 1 && view->x >= 0 && view->y >= 0 &&
                target->width <= SL_RASTER_MAX_SIZE && target->height <= SL_RASTER_MAX_SIZE &&
                view->width <= target->width - view->x && view->height <= target->height - view->y;
    if (fits) return SL_OK;
    return sl_fail(error, SL_ERROR_USAGE,
                   "a viewport of %d x %d pixels at (%d, %d) of a raster target of %d x %d: within it, from "
                   "1 to %d each way",
                   view->width, view->height, view->x, view->y, target->width, target->height,
                   (int)SL_RASTER_MAX_SIZE);
}

static bool draw_pictures(tiled_passes *p, unsigned threads, sl_counters *counters) {
    threads = sl_thread_count(threads);
    if (threads > p->tiles) threads = (unsigned)p->tiles;
    bool ok = allocate(p, threads);
    if (ok) {
        sl_parallel_for(threads, p->pictures, cull_view, p);
        qsort(p->task, p->tiles, sizeof *p->task, most_work_first);
        sl_parallel_for(threads, p->tiles, draw_tile, p);
        for (size_t n = 0; n < p->pictures; n++) {
            sl_pass_count(p->raster, p->picture[n].visible, p->picture[n].fate, counters);
        }
    }
    release(p);
    return ok;
}

static void test_stencil(const sl_view *view, const sl_target *target) {
    if (!view->stencil || !target->id) return;
    for (size_t i = 0; i < (size_t)target->width * (size_t)target->height; i++)
        if (!view->stencil[i]) target->id[i] = SL_NO_INDEX;
}

sl_status sl_raster_ids(const sl_raster *raster, size_t count, const sl_view *views, unsigned threads,
                        const sl_target *targets, sl_counters *counters, sl_error *error) {
    tiled_view *pictures = sl_allocate(count, sizeof *pictures);
    if (!pictures) return sl_fail_memory(error, "a list of views");
    tiled_passes p = {.raster = raster, .pictures = count, .picture = pictures};
    sl_status status = SL_OK;
    for (size_t n = 0; n < count && status == SL_OK; n++) {
        status = check_viewport(&views[n], &targets[n], error);
        if (status != SL_OK) break;
        pictures[n] = (tiled_view){.view = &views[n], .target = &targets[n], .first_tile = p.tiles,
                                .pass = sl_pass_view_make(&views[n], targets[n].width, targets[n].height)};
        pictures[n].tiles = sl_tiles_of(&pictures[n].pass);
        p.tiles += (size_t)pictures[n].tiles.columns * (size_t)pictures[n].tiles.rows;
        if (raster->observer) raster->observer->draw(raster->observer->context, raster, &views[n], false);
    }
    if (status == SL_OK && !draw_pictures(&p, threads, counters))
        status = sl_fail_memory(error, "a render's planes");
    for (size_t n = 0; n < count && status == SL_OK; n++) test_stencil(&views[n], &targets[n]);
    sl_free(pictures);
    return status;
}

sl_status sl_raster_id(const sl_raster *raster, const sl_view *view, unsigned threads,
                       const sl_target *target, sl_counters *counters, sl_error *error) {
    return sl_raster_ids(raster, 1, view, threads, target, counters, error);
}
