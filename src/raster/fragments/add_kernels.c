/* The fragments of a batch of triangles, added to a tile: span by span, within a span triangle by triangle, and of each
 *
 *     cover       its pixels, where edges cross the span
 *     divide      1 / denominator at each, unless that is 1 all over the triangle
 *     add         channel after channel, the quotient, which is bounded by the corners' values
 *
 * Every value comes from the triangle and the pixel alone; groups of sixteen pixels of a row only say what is done together. */
#include <string.h>

#include "base/bits16.h"
#include "raster/fragments/add.h"

enum { WIDTH = SL_ADD_WIDTH, HEIGHT = SL_ADD_HEIGHT };

/* A triangle's part of a span: pixels told from the span's first. */
typedef struct {
    int x0, y0, x1, y1; /* its box within the span, inclusive */
    int32_t a[3], b[3], e[3];
    bool whole;         /* all of the box is covered, and groups do not reach beyond it */
} part;

/* ---- spans ---- */

static sl_rectangle span_within(const sl_tile *tile, int span) {
    int x = tile->left + span % SL_ADD_COLUMNS * WIDTH, y = tile->low + span / SL_ADD_COLUMNS * HEIGHT;
    return (sl_rectangle){x > tile->x0 ? x : tile->x0, y > tile->y0 ? y : tile->y0, x + WIDTH < tile->x1 ? x + WIDTH - 1 : tile->x1 - 1,
                          y + HEIGHT < tile->y1 ? y + HEIGHT - 1 : tile->y1 - 1};
}

/* Between the target and the worker's memory. */
static void move_span(const sl_add_tile *add, const sl_tile *tile, int span, bool fetch) {
    const sl_rectangle r = span_within(tile, span);
    const size_t bytes = (size_t)(r.x1 - r.x0 + 1) * sizeof(float);
    for (int c = 0; c < add->channels; c++) {
        for (int y = r.y0; y <= r.y1; y++) {
            float *there = add->target + (size_t)c * add->plane + (size_t)y * (size_t)add->width + (size_t)r.x0;
            float *here = sl_add_plane(add, span, c) + (y & (HEIGHT - 1)) * WIDTH + (r.x0 & (WIDTH - 1));
            memcpy(fetch ? here : there, fetch ? there : here, bytes);
        }
    }
}

/* ---- cover ---- */

/* False where an edge function is negative all over the span. */
static bool find_part(const sl_wide_edges *w, sl_rectangle box, part *p) {
    const int x = box.x0 & -WIDTH, y = box.y0 & -HEIGHT;
    *p = (part){.x0 = box.x0 - x, .y0 = box.y0 - y, .x1 = box.x1 - x, .y1 = box.y1 - y};
    bool whole = p->x0 % SL_LANES == 0 && p->x1 % SL_LANES == SL_LANES - 1;
    for (int k = 0; k < 3; k++) {
        const int64_t at_first = w->c[k] + w->a[k] * x + w->b[k] * y;
        const int64_t low_x = w->a[k] * p->x0, high_x = w->a[k] * p->x1, low_y = w->b[k] * p->y0, high_y = w->b[k] * p->y1;
        if (at_first + (low_x > high_x ? low_x : high_x) + (low_y > high_y ? low_y : high_y) < 0) return false;
        const bool crosses = at_first + (low_x < high_x ? low_x : high_x) + (low_y < high_y ? low_y : high_y) < 0;
        p->a[k] = crosses ? (int32_t)w->a[k] : 0;
        p->b[k] = crosses ? (int32_t)w->b[k] : 0;
        p->e[k] = crosses ? sl_clamp_edge(at_first) : 0;
        whole &= !crosses;
    }
    p->whole = whole;
    return true;
}

static uint32_t cover_row(const part *p, int y, int32_t *restrict outside, int32_t *begin, int32_t *end) {
    const int32_t e0 = p->e[0] + p->b[0] * y, e1 = p->e[1] + p->b[1] * y, e2 = p->e[2] + p->b[2] * y;
    const int32_t a0 = p->a[0], a1 = p->a[1], a2 = p->a[2], x0 = p->x0, x1 = p->x1;
    uint32_t count = 0;
    int32_t from = WIDTH, to = 0;
    for (int32_t x = x0 & -SL_LANES; x <= x1; x += SL_LANES) {
#pragma omp simd
        for (int32_t l = x; l < x + SL_LANES; l++) outside[l] = (e0 + a0 * l) | (e1 + a1 * l) | (e2 + a2 * l) | (l - x0) | (x1 - l);
        const uint32_t inside = ~sl_bits16_negative(outside + x) & 0xffffu;
        if (!inside) continue;
        count += sl_bits16_count(inside);
        from = from < x ? from : x;
        to = x + SL_LANES;
    }
    *begin = from;
    *end = to;
    return count;
}

static uint64_t cover(const part *p, sl_add_tile *add) {
    uint64_t count = 0;
    for (int y = p->y0; y <= p->y1; y++) {
        if (p->whole) {
            add->begin[y] = p->x0;
            add->end[y] = p->x1 + 1;
        } else {
            count += cover_row(p, y, add->outside + y * WIDTH, &add->begin[y], &add->end[y]);
        }
    }
    return p->whole ? (uint64_t)(p->x1 - p->x0 + 1) * (uint64_t)(p->y1 - p->y0 + 1) : count;
}

/* ---- divide and add ---- */

/* What depends on the column alone. */
static void find_columns(const part *p, sl_value_plane v, int32_t right, float *restrict column) {
    const float a = v.a;
    for (int32_t x = p->x0 & -SL_LANES; x <= p->x1; x += SL_LANES) {
#pragma omp simd
        for (int32_t l = x; l < x + SL_LANES; l++) column[l] = a * (float)(l + right);
    }
}

static inline void divide_group(const float *restrict column, float row, float *restrict over) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) over[l] = 1.0f / (row + column[l]);
}

static void divide(const part *p, sl_value_plane v, int32_t right, int32_t up, sl_add_tile *add) {
    find_columns(p, v, right, add->column);
    for (int y = p->y0; y <= p->y1; y++) {
        const float row = v.c + v.b * (float)(y + up);
        for (int32_t x = add->begin[y]; x < add->end[y]; x += SL_LANES) divide_group(add->column + x, row, add->over + y * WIDTH + x);
    }
}

/* Sixteen pixels; these are compiled for each case. */
static inline __attribute__((always_inline)) void add_group(const int32_t *restrict outside, const float *restrict value, bool whole,
                                                            float *restrict sum) {
    if (whole) {
#pragma omp simd
        for (int l = 0; l < SL_LANES; l++) sum[l] += value[l];
    } else {
#pragma omp simd
        for (int l = 0; l < SL_LANES; l++) {
            float old = sum[l], added = old + value[l];
            sum[l] = outside[l] < 0 ? old : added;
        }
    }
}

static inline __attribute__((always_inline)) void find_group(const float *restrict column, const float *restrict over, float row, bool level,
                                                             float least, float most, float *restrict value) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float v = row + column[l];
        if (!level) v *= over[l];
        v = v > least ? v : least; /* also NaN */
        value[l] = v < most ? v : most;
    }
}

static inline __attribute__((always_inline)) void add_rows(const part *p, const sl_add_tile *add, const sl_add_channel *channel, int32_t up,
                                                           bool whole, bool level, float *plane) {
    const float b = channel->value.b, c = channel->value.c, least = channel->least, most = channel->most;
    for (int y = p->y0; y <= p->y1; y++) {
        const float row = c + b * (float)(y + up);
        const int32_t *outside = add->outside + y * WIDTH;
        const float *over = add->over + y * WIDTH;
        float *sum = plane + y * WIDTH;
        for (int32_t x = add->begin[y]; x < add->end[y]; x += SL_LANES) {
            float value[SL_LANES];
            find_group(add->column + x, over + x, row, level, least, most, value);
            add_group(outside + x, value, whole, sum + x);
        }
    }
}

static inline __attribute__((always_inline)) void add_constant(const part *p, const sl_add_tile *add, float constant, bool whole,
                                                               float *plane) {
    float value[SL_LANES];
    for (int l = 0; l < SL_LANES; l++) value[l] = constant;
    for (int y = p->y0; y <= p->y1; y++) {
        for (int32_t x = add->begin[y]; x < add->end[y]; x += SL_LANES) {
            add_group(add->outside + y * WIDTH + x, value, whole, plane + y * WIDTH + x);
        }
    }
}

static void add_channel(const part *p, sl_add_tile *add, const sl_add_channel *channel, bool level, int32_t right, int32_t up, float *plane) {
    if (channel->least == channel->most) {
        if (p->whole) add_constant(p, add, channel->least, true, plane);
        else add_constant(p, add, channel->least, false, plane);
        return;
    }
    find_columns(p, channel->value, right, add->column);
    if (level && p->whole) add_rows(p, add, channel, up, true, true, plane);
    else if (level) add_rows(p, add, channel, up, false, true, plane);
    else if (p->whole) add_rows(p, add, channel, up, true, false, plane);
    else add_rows(p, add, channel, up, false, false, plane);
}

/* ---- the batch ---- */

static uint64_t add_part(const part *p, sl_add_tile *add, uint32_t t, int span, int32_t right, int32_t up) {
    const sl_add_channel *channel = add->planes.channel + (size_t)t * (size_t)add->channels;
    const uint64_t count = cover(p, add);
    bool varies = false;
    if (!count) return 0;
    for (int c = 0; c < add->channels; c++) varies |= channel[c].least != channel[c].most;
    if (varies && !add->planes.level[t]) divide(p, add->planes.denominator[t], right, up, add);
    for (int c = 0; c < add->channels; c++) {
        add_channel(p, add, &channel[c], add->planes.level[t], right, up, sl_add_plane(add, span, c));
    }
    return count;
}

static uint64_t add_span(const sl_tile *tile, const sl_batch *batch, sl_add_tile *add, int span) {
    const sl_rectangle r = span_within(tile, span);
    const int x = r.x0 & -WIDTH, y = r.y0 & -HEIGHT;
    uint64_t blended = 0;
    for (uint32_t t = 0; t < batch->count; t++) {
        const sl_rectangle box = {batch->x0[t] > r.x0 ? batch->x0[t] : r.x0, batch->y0[t] > r.y0 ? batch->y0[t] : r.y0,
                                  batch->x1[t] < r.x1 ? batch->x1[t] : r.x1, batch->y1[t] < r.y1 ? batch->y1[t] : r.y1};
        part p;
        if (box.x0 > box.x1 || box.y0 > box.y1 || !find_part(&add->edges[t], box, &p)) continue;
        if (!(add->fetched >> span & 1)) move_span(add, tile, span, true);
        add->fetched |= UINT32_C(1) << span;
        blended += add_part(&p, add, t, span, x - add->planes.x[t], y - add->planes.y[t]);
    }
    return blended;
}

uint64_t SL_KERNEL(sl_raster_add)(const sl_tile *tile, const sl_batch *batch, sl_add_tile *add);
uint64_t SL_KERNEL(sl_raster_add)(const sl_tile *tile, const sl_batch *batch, sl_add_tile *add) {
    sl_rectangle all = {tile->x1, tile->y1, tile->x0 - 1, tile->y0 - 1};
    uint64_t blended = 0;
    for (uint32_t t = 0; t < batch->count; t++) {
        if (batch->x0[t] > batch->x1[t] || batch->y0[t] > batch->y1[t]) continue;
        all.x0 = batch->x0[t] < all.x0 ? batch->x0[t] : all.x0;
        all.y0 = batch->y0[t] < all.y0 ? batch->y0[t] : all.y0;
        all.x1 = batch->x1[t] > all.x1 ? batch->x1[t] : all.x1;
        all.y1 = batch->y1[t] > all.y1 ? batch->y1[t] : all.y1;
    }
    if (all.x0 > all.x1 || all.y0 > all.y1) return 0;
    for (int row = (all.y0 - tile->low) / HEIGHT; row <= (all.y1 - tile->low) / HEIGHT; row++) {
        for (int column = (all.x0 - tile->left) / WIDTH; column <= (all.x1 - tile->left) / WIDTH; column++) {
            blended += add_span(tile, batch, add, row * SL_ADD_COLUMNS + column);
        }
    }
    return blended;
}

void SL_KERNEL(sl_raster_add_return)(const sl_tile *tile, sl_add_tile *add);
void SL_KERNEL(sl_raster_add_return)(const sl_tile *tile, sl_add_tile *add) {
    for (int span = 0; span < SL_ADD_SPANS; span++) {
        if (add->fetched >> span & 1) move_span(add, tile, span, false);
    }
    add->fetched = 0;
}
