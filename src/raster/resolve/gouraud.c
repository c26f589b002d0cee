/* Gouraud interpolation of vertex attributes, perspective-correct, once for each visible pixel. */
#include <string.h>

#include "base/parallel.h"
#include "raster/resolve/resolve.h"

enum { STRIP = 16384 /* pixels of a task */, TOGETHER = 4 /* channels */ };

typedef struct {
    const sl_raster *raster;
    sl_pass_view view;
    const uint32_t *id;
    const float *attributes;
    size_t channels;
    float *out;
    size_t pixels;
} gouraud;

/* Of `count` channels from `first` on, at most TOGETHER: a vertex's lie side by side. */
static void fetch_channels(const gouraud *g, const sl_resolve_block *block, size_t first, size_t count, sl_run_corners *value) {
    static const float black[TOGETHER] = {0};
    for (int k = 0; k < 3; k++) {
        for (uint32_t r = 0; r < block->runs; r++) {
            const uint32_t v = block->vertex[k][r];
            const float *attributes = v == SL_NO_INDEX ? black : g->attributes + v * g->channels + first;
            for (size_t c = 0; c < count; c++) value[c][k][r] = attributes[c];
        }
    }
}

static void put_channels(const gouraud *g, const sl_resolve_block *block, size_t pixel, size_t first, size_t count) {
    sl_run_corners value[TOGETHER];
    float plane[SL_RESOLVE_ROOM];
    if (count == 3) fetch_channels(g, block, first, 3, value); /* the constant, so that colours are compiled for it */
    else fetch_channels(g, block, first, count, value);
    for (size_t c = 0; c < count; c++) {
        g->raster->kernels->resolve->interpolate(block, value[c], plane);
        sl_resolve_put(g->out + (first + c) * g->pixels, g->pixels, pixel, plane, block->count);
    }
}

static void interpolate_strip(void *context, size_t index, unsigned worker) {
    (void)worker;
    const gouraud *g = context;
    size_t first = index * STRIP, end = g->pixels - first < STRIP ? g->pixels : first + STRIP;
    sl_resolve_block block;
    memset(&block, 0, sizeof block);
    block.later = (const char *)g->attributes;
    block.later_bytes = g->channels * sizeof *g->attributes;
    for (; first < end; first += block.count) {
        sl_resolve_next(g->raster, &g->view, end - first, first, NULL, g->id + first, &block);
        for (size_t c = 0; c < g->channels; c += TOGETHER) {
            put_channels(g, &block, first, c, g->channels - c < TOGETHER ? g->channels - c : TOGETHER);
        }
    }
    sl_stream_end();
}

void sl_raster_gouraud(const sl_raster *raster, const sl_view *view, unsigned threads, const uint32_t *id,
                       const float *attributes, int channels, float *out, sl_counters *counters) {
    gouraud g = {raster, sl_pass_view_make(view, view->width, view->height), id, attributes, (size_t)channels, out,
                 (size_t)view->width * (size_t)view->height};
    sl_parallel_for(sl_thread_count(threads), (g.pixels + STRIP - 1) / STRIP, interpolate_strip, &g);
    uint64_t shaded = 0;
    for (size_t i = 0; i < g.pixels; i++) shaded += id[i] != SL_NO_INDEX;
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, shaded);
}
