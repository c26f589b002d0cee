/* Splatting: rectangles blended additively. A tile's pixels are touched by one thread only, which runs the
 * tile's splats in index order; so every pixel adds in index order, and float sums come out the same bits at
 * any number of threads. */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/counters.h"
#include "raster/view.h"

enum { TILE = SL_SPLAT_TILE };

typedef struct {
    int width, height, tiles_x, tiles_y;
    const sl_splat_rect *rects;
    const sl_splat_program *program;
    void *context;
    char *memory;       /* the workers' tiles, tile_stride bytes each */
    size_t tile_stride;
    size_t *first;      /* of each tile's splats; one more than there are tiles */
    uint32_t *splat;    /* tile by tile, in index order */
    uint64_t *blended;  /* by tile */
} splatting;

static sl_splat_rect cut(sl_splat_rect r, sl_splat_rect to) {
    return (sl_splat_rect){r.x0 > to.x0 ? r.x0 : to.x0, r.y0 > to.y0 ? r.y0 : to.y0,
                           r.x1 < to.x1 ? r.x1 : to.x1, r.y1 < to.y1 ? r.y1 : to.y1};
}

/* Neither is empty. */
static sl_splat_rect both(sl_splat_rect r, sl_splat_rect s) {
    return (sl_splat_rect){r.x0 < s.x0 ? r.x0 : s.x0, r.y0 < s.y0 ? r.y0 : s.y0, r.x1 > s.x1 ? r.x1 : s.x1,
                           r.y1 > s.y1 ? r.y1 : s.y1};
}

/* ---- which tiles a splat touches ---- */

/* Half-open; false: none. */
static bool tiles_of(const splatting *s, sl_splat_rect rect, sl_splat_rect *tiles) {
    sl_splat_rect r = cut(rect, (sl_splat_rect){0, 0, s->width, s->height});
    if (r.x0 >= r.x1 || r.y0 >= r.y1) return false;
    *tiles = (sl_splat_rect){r.x0 / TILE, r.y0 / TILE, (r.x1 - 1) / TILE + 1, (r.y1 - 1) / TILE + 1};
    return true;
}

/* A counting sort: how many splats touch each tile, where each tile's list starts, then the lists. */
static bool bin_splats(splatting *s, size_t count) {
    size_t tiles = (size_t)s->tiles_x * (size_t)s->tiles_y;
    sl_splat_rect t;
    for (size_t i = 0; i < count; i++) {
        if (!tiles_of(s, s->rects[i], &t)) continue;
        for (int y = t.y0; y < t.y1; y++) {
            for (int x = t.x0; x < t.x1; x++) s->first[y * s->tiles_x + x + 1]++;
        }
    }
    for (size_t i = 0; i < tiles; i++) s->first[i + 1] += s->first[i];
    s->splat = sl_allocate(s->first[tiles], sizeof *s->splat);
    size_t *next = sl_allocate(tiles, sizeof *next);
    for (size_t i = 0; next && i < tiles; i++) next[i] = s->first[i];
    for (size_t i = 0; next && s->splat && i < count; i++) {
        if (!tiles_of(s, s->rects[i], &t)) continue;
        for (int y = t.y0; y < t.y1; y++) {
            for (int x = t.x0; x < t.x1; x++) s->splat[next[y * s->tiles_x + x]++] = (uint32_t)i;
        }
    }
    bool ok = next && s->splat;
    sl_free(next);
    return ok;
}

/* ---- drawing ---- */

static void blend_tile(void *context, size_t index, unsigned worker) {
    splatting *s = context;
    const sl_splat_program *program = s->program;
    size_t first = s->first[index], end = s->first[index + 1];
    if (first == end) return;
    int x = (int)(index % (size_t)s->tiles_x) * TILE, y = (int)(index / (size_t)s->tiles_x) * TILE;
    sl_splat_rect whole =
        cut((sl_splat_rect){x, y, x + TILE, y + TILE}, (sl_splat_rect){0, 0, s->width, s->height});
    sl_splat_rect region = cut(s->rects[s->splat[first]], whole);
    for (size_t n = first + 1; n < end; n++) region = both(region, cut(s->rects[s->splat[n]], whole));
    sl_splat_tile tile = {x, y, region, s->memory + worker * s->tile_stride};
    uint64_t blended = 0;
    if (program->begin) program->begin(s->context, &tile);
    for (size_t n = first; n < end; n++) {
        blended += program->shade(s->context, &tile, s->splat[n], cut(s->rects[s->splat[n]], whole));
    }
    if (program->end) program->end(s->context, &tile);
    s->blended[index] = blended;
}

sl_status sl_raster_splats(int width, int height, size_t count, const sl_splat_rect *rects,
                           const sl_splat_program *program, void *context, unsigned threads,
                           sl_counters *counters, sl_error *error) {
    if (width < 1 || height < 1 || width > SL_RASTER_MAX_SIZE || height > SL_RASTER_MAX_SIZE ||
        count >= SL_NO_INDEX) {
        return sl_fail(error, SL_ERROR_USAGE, "splats on %d x %d pixels: from 1 to %d each way", width,
                       height, (int)SL_RASTER_MAX_SIZE);
    }
    splatting s = {.width = width,
                   .height = height,
                   .tiles_x = (width + TILE - 1) / TILE,
                   .tiles_y = (height + TILE - 1) / TILE,
                   .rects = rects,
                   .program = program,
                   .context = context,
                   .tile_stride = (program->tile_bytes + 63) / 64 * 64};
    size_t tiles = (size_t)s.tiles_x * (size_t)s.tiles_y, workers = sl_thread_count(threads);
    workers = workers < tiles ? workers : tiles;
    s.memory = sl_allocate(workers, s.tile_stride);
    s.first = sl_allocate(tiles + 1, sizeof *s.first);
    s.blended = sl_allocate(tiles, sizeof *s.blended);
    bool ok = s.memory && s.first && s.blended && bin_splats(&s, count);
    if (ok) {
        sl_parallel_for((unsigned)workers, tiles, blend_tile, &s);
        for (size_t i = 0; i < tiles; i++) sl_count(counters, SL_COUNT_FRAGMENTS_BLENDED, s.blended[i]);
        sl_count(counters, SL_COUNT_SPLATS, count);
    }
    sl_free(s.memory);
    sl_free(s.first);
    sl_free(s.splat);
    sl_free(s.blended);
    return ok ? SL_OK : sl_fail_memory(error, "the splats' tiles");
}
