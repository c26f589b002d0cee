/* Gouraud interpolation of vertex attributes, perspective-correct, once for each visible pixel. */
#include <string.h>

#include "base/parallel.h"
#include "raster/resolve.h"

enum { STRIP = 16384 }; /* pixels of a task */

typedef struct {
    const sl_raster *raster;
    sl_pass_view view;
    const uint32_t *id;
    const float *attributes;
    size_t channels;
    float *out;
    size_t pixels;
} gouraud;

static void fetch_channel(const gouraud *g, const sl_resolve_block *block, size_t channel, sl_run_corners value) {
    const sl_raster_mesh *mesh = &g->raster->mesh;
    for (uint32_t r = 0; r < block->runs; r++) {
        uint32_t triangle = sl_run_triangle(block, r);
        for (int k = 0; k < 3; k++) {
            bool hit = triangle != SL_NO_INDEX;
            value[k][r] = hit ? g->attributes[mesh->vertex[k][triangle] * g->channels + channel] : 0.0f;
        }
    }
}

static void interpolate_strip(void *context, size_t index, unsigned worker) {
    (void)worker;
    const gouraud *g = context;
    size_t first = index * STRIP, end = g->pixels - first < STRIP ? g->pixels : first + STRIP;
    sl_resolve_block block;
    sl_run_corners value;
    float plane[SL_RESOLVE_ROOM];
    memset(&block, 0, sizeof block);
    for (; first < end; first += block.count) {
        sl_resolve_next(g->raster, &g->view, end - first, first, NULL, g->id + first, &block);
        for (size_t c = 0; c < g->channels; c++) {
            fetch_channel(g, &block, c, value);
            g->raster->kernels->resolve->interpolate(&block, value, plane);
            sl_resolve_put(g->out + c * g->pixels, g->pixels, first, plane, block.count);
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
