/* Splatting: rectangles blended additively. A tile's pixels are touched by one thread only, which runs the tile's
 * splats in index order; so every pixel adds in index order, and float sums come out the same bits at any number of
 * threads. */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "raster/internal.h"

enum { TILE = 32 };

typedef struct {
    int width, height, tiles_x, tiles_y;
    const sl_splat_rect *rects;
    sl_splat_program *program;
    void *context;
    size_t *first;      /* of each tile's splats; one more than there are tiles */
    uint32_t *splat;    /* tile by tile, in index order */
    uint64_t *blended;  /* by tile */
} splatting;

static sl_splat_rect cut(sl_splat_rect r, int x0, int y0, int x1, int y1) {
    return (sl_splat_rect){r.x0 > x0 ? r.x0 : x0, r.y0 > y0 ? r.y0 : y0, r.x1 < x1 ? r.x1 : x1, r.y1 < y1 ? r.y1 : y1};
}

/* Tiles touched by a splat, half-open; false: none. */
static bool tiles_of(const splatting *s, sl_splat_rect rect, sl_splat_rect *tiles) {
    sl_splat_rect r = cut(rect, 0, 0, s->width, s->height);
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

static void blend_tile(void *context, size_t tile, unsigned worker) {
    (void)worker;
    splatting *s = context;
    int x = (int)(tile % (size_t)s->tiles_x) * TILE, y = (int)(tile / (size_t)s->tiles_x) * TILE;
    int x_end = x + TILE < s->width ? x + TILE : s->width, y_end = y + TILE < s->height ? y + TILE : s->height;
    uint64_t blended = 0;
    for (size_t n = s->first[tile]; n < s->first[tile + 1]; n++) {
        sl_splat_rect r = cut(s->rects[s->splat[n]], x, y, x_end, y_end);
        for (int row = r.y0; row < r.y1; row++) blended += s->program(s->context, s->splat[n], r.x0, r.x1, row);
    }
    s->blended[tile] = blended;
}

sl_status sl_raster_splats(int width, int height, size_t count, const sl_splat_rect *rects, sl_splat_program *program,
                           void *context, unsigned threads, sl_counters *counters, sl_error *error) {
    if (width < 1 || height < 1 || width > SL_RASTER_MAX_SIZE || height > SL_RASTER_MAX_SIZE || count >= SL_NO_INDEX) {
        return sl_fail(error, SL_ERROR_USAGE, "splats on %d x %d pixels: from 1 to %d each way", width, height,
                       (int)SL_RASTER_MAX_SIZE);
    }
    splatting s = {width, height, (width + TILE - 1) / TILE, (height + TILE - 1) / TILE, rects, program, context, 0, 0, 0};
    size_t tiles = (size_t)s.tiles_x * (size_t)s.tiles_y;
    s.first = sl_allocate(tiles + 1, sizeof *s.first);
    s.blended = sl_allocate(tiles, sizeof *s.blended);
    bool ok = s.first && s.blended && bin_splats(&s, count);
    if (ok) {
        sl_parallel_for(sl_thread_count(threads), tiles, blend_tile, &s);
        for (size_t i = 0; i < tiles; i++) sl_count(counters, SL_COUNT_FRAGMENTS_BLENDED, s.blended[i]);
        sl_count(counters, SL_COUNT_SPLATS, count);
    }
    sl_free(s.first);
    sl_free(s.splat);
    sl_free(s.blended);
    return ok ? SL_OK : sl_fail_memory(error, "the splats' tiles");
}
