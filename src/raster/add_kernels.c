/* The fragments of one triangle, added to planes in the target's row order, sixteen pixels of a row at a time. */
#include "raster/internal.h"

/* The row's first group: edge functions, denominator, all linear along the row. */
typedef struct {
    int32_t e[3], a[3];
    int32_t first, last; /* lanes that may be drawn, inclusive */
    float denominator, step;
} row;

static uint32_t cover(const row *r, int lanes, int32_t *restrict inside) {
    const int32_t e0 = r->e[0], e1 = r->e[1], e2 = r->e[2], a0 = r->a[0], a1 = r->a[1], a2 = r->a[2];
    const int32_t first = r->first, last = r->last;
    int32_t count = 0;
#pragma omp simd reduction(+ : count)
    for (int l = 0; l < lanes; l++) {
        int32_t in = ((e0 + a0 * l) | (e1 + a1 * l) | (e2 + a2 * l) | (l - first) | (last - l)) >= 0 ? 1 : 0;
        inside[l] = in;
        count += in;
    }
    return (uint32_t)count;
}

static void add_values(const int32_t *restrict inside, const float *restrict over, int lanes, float first, float step,
                       float least, float most, float *restrict out) {
#pragma omp simd
    for (int l = 0; l < lanes; l++) {
        float value = (first + step * (float)l) * over[l];
        value = value > least ? value : least; /* also NaN */
        value = value < most ? value : most;
        out[l] = inside[l] ? out[l] + value : out[l];
    }
}

static uint32_t add_group(const row *r, int lanes, const sl_add_triangle *v, int channels, float dx, float dy, size_t pixel,
                          size_t plane, float *planes) {
    int32_t inside[SL_LANES];
    float over[SL_LANES];
    uint32_t count = cover(r, lanes, inside);
    if (!count) return 0;
#pragma omp simd
    for (int l = 0; l < lanes; l++) over[l] = 1.0f / (r->denominator + r->step * (float)l);
    for (int c = 0; c < channels; c++) {
        const sl_add_channel *channel = &v->channel[c];
        float first = (channel->value.c + channel->value.b * dy) + channel->value.a * dx;
        add_values(inside, over, lanes, first, channel->value.a, channel->least, channel->most, planes + (size_t)c * plane + pixel);
    }
    return count;
}

uint64_t SL_KERNEL(sl_raster_add_triangle)(const sl_pass_view *view, const sl_batch *batch, uint32_t t, const sl_add_triangle *v,
                                           int channels, float *planes);
uint64_t SL_KERNEL(sl_raster_add_triangle)(const sl_pass_view *view, const sl_batch *batch, uint32_t t, const sl_add_triangle *v,
                                           int channels, float *planes) {
    sl_wide_edges w;
    uint64_t blended = 0;
    if (!sl_widen_edges(batch, t, &w)) return 0;
    const size_t plane = (size_t)view->width * (size_t)view->height;
    for (int y = batch->y0[t]; y <= batch->y1[t]; y++) {
        for (int x = batch->x0[t] & -SL_LANES; x <= batch->x1[t]; x += SL_LANES) {
            int lanes = x + SL_LANES <= view->width ? SL_LANES : view->width - x;
            float dx = (float)(x - v->x), dy = (float)(y - v->y);
            row r = {.first = batch->x0[t] - x, .last = batch->x1[t] - x,
                     .denominator = (v->denominator.c + v->denominator.b * dy) + v->denominator.a * dx, .step = v->denominator.a};
            bool missed = false;
            for (int k = 0; k < 3; k++) {
                int64_t e = w.c[k] + w.a[k] * x + w.b[k] * y;
                missed |= e + (w.a[k] > 0 ? w.a[k] * (SL_LANES - 1) : 0) < 0;
                r.e[k] = sl_clamp_edge(e);
                r.a[k] = (int32_t)w.a[k];
            }
            if (missed) continue;
            size_t pixel = (size_t)y * (size_t)view->width + (size_t)x;
            /* The constant, so that the common case is compiled for it. */
            blended += lanes == SL_LANES ? add_group(&r, SL_LANES, v, channels, dx, dy, pixel, plane, planes)
                                         : add_group(&r, lanes, v, channels, dx, dy, pixel, plane, planes);
        }
    }
    return blended;
}
