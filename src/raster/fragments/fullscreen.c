/* Full-screen passes. Every pixel is one thread's, and a run of pixels is cut at the same places at any number of
 * threads, so even a program that sums along its run gives the same bits. */
#include "raster/fragments/fullscreen.h"

#include "base/counters.h"
#include "base/parallel.h"

/* Wide, so that rows are long enough for vector loops; low, so that a two-megapixel target still gives each thread
 * many. */
enum { TILE_WIDTH = 512, TILE_HEIGHT = 8, WORKERS_MAX = 256 };

typedef struct {
    int width, height;
    size_t tiles_x;
    sl_fullscreen_program *program;
    void *context;
    uint64_t shaded[WORKERS_MAX]; /* whole numbers: their sum does not depend on the order */
} fullscreen;

static void shade_tile(void *context, size_t tile, unsigned worker) {
    fullscreen *f = context;
    int x0 = (int)(tile % f->tiles_x) * TILE_WIDTH, y0 = (int)(tile / f->tiles_x) * TILE_HEIGHT;
    int x1 = x0 + TILE_WIDTH < f->width ? x0 + TILE_WIDTH : f->width;
    int y1 = y0 + TILE_HEIGHT < f->height ? y0 + TILE_HEIGHT : f->height;
    uint64_t shaded = 0;
    for (int y = y0; y < y1; y++) shaded += f->program(f->context, x0, x1, y);
    f->shaded[worker] += shaded;
}

void sl_raster_fullscreen(int width, int height, unsigned threads, sl_fullscreen_program *program, void *context,
                          sl_counters *counters) {
    if (width < 1 || height < 1) return;
    size_t tiles_x = ((size_t)width + TILE_WIDTH - 1) / TILE_WIDTH, tiles_y = ((size_t)height + TILE_HEIGHT - 1) / TILE_HEIGHT;
    fullscreen f = {.width = width, .height = height, .tiles_x = tiles_x, .program = program, .context = context};
    sl_parallel_for(sl_thread_count(threads), tiles_x * tiles_y, shade_tile, &f);
    uint64_t shaded = 0;
    for (size_t i = 0; i < WORKERS_MAX; i++) shaded += f.shaded[i];
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, shaded);
}
