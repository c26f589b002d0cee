/* Gouraud interpolation of vertex attributes, perspective-correct, once for each visible pixel. */
#include <string.h>

#include "base/parallel.h"
#include "raster/internal.h"

enum { STRIP = 1024 };

typedef struct {
    const sl_raster *raster;
    const sl_view *view;
    const uint32_t *id;
    const float *attributes;
    int channels;
    float *out;
    size_t pixels;
} gouraud;

static void interpolate_pixel(const gouraud *g, size_t i, uint32_t triangle, float w1, float w2) {
    const sl_raster_mesh *mesh = &g->raster->mesh;
    size_t channels = (size_t)g->channels;
    const float *a = g->attributes + mesh->vertex[0][triangle] * channels;
    const float *b = g->attributes + mesh->vertex[1][triangle] * channels;
    const float *c = g->attributes + mesh->vertex[2][triangle] * channels;
    float w0 = (1.0f - w1) - w2;
    for (size_t k = 0; k < channels; k++) g->out[k * g->pixels + i] = (w0 * a[k] + w1 * b[k]) + w2 * c[k];
}

static void interpolate_strip(void *context, size_t index, unsigned worker) {
    (void)worker;
    const gouraud *g = context;
    size_t first = index * STRIP, count = g->pixels - first < STRIP ? g->pixels - first : STRIP;
    uint32_t pixel[STRIP] = {0};
    float w1[STRIP], w2[STRIP];
    for (size_t n = 0; n < count; n++) pixel[n] = (uint32_t)(first + n);
    sl_raster_barycentrics(g->raster, g->view, count, pixel, g->id + first, w1, w2);
    for (size_t n = 0; n < count; n++) {
        uint32_t triangle = g->id[first + n];
        if (triangle != SL_NO_INDEX) {
            interpolate_pixel(g, first + n, triangle, w1[n], w2[n]);
        } else {
            for (size_t k = 0; k < (size_t)g->channels; k++) g->out[k * g->pixels + first + n] = 0.0f;
        }
    }
}

void sl_raster_gouraud(const sl_raster *raster, const sl_view *view, unsigned threads, const uint32_t *id,
                       const float *attributes, int channels, float *out, sl_counters *counters) {
    gouraud g = {raster, view, id, attributes, channels, out, (size_t)view->width * (size_t)view->height};
    sl_parallel_for(sl_thread_count(threads), (g.pixels + STRIP - 1) / STRIP, interpolate_strip, &g);
    uint64_t shaded = 0;
    for (size_t i = 0; i < g.pixels; i++) shaded += id[i] != SL_NO_INDEX;
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, shaded);
}
