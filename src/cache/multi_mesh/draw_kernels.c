/* Pixels of a leaf from a fan around its centre. With w_e the smallest weight, a point lies s = 1 - 3 w_e of
 * the way from the centre to a point of the edge opposite to corner e, and its value is as far from the
 * centre's to that point's. All are differences, so that one colour stays that colour in every bit. */
#include "cache/multi_mesh/draw_kernels.h"

enum { BLOCK = 64 };

static inline float choose(int which, float a, float b, float c) {
    return which == 0 ? a : which == 1 ? b : c;
}

static void put(size_t count, const uint32_t *restrict pixel, float value[3][BLOCK], float *const planes[3]) {
    for (int k = 0; k < 3; k++) {
        for (size_t i = 0; i < count; i++) planes[k][pixel[i]] = value[k][i];
    }
}

/* One channel needs its seven values alone. */
static inline float in_fan(const sl_simple_fan *f, int channel, int c, int e, float out, float along) {
    float corner = choose(c, f->corner[0][channel], f->corner[1][channel], f->corner[2][channel]);
    float middle = choose(e, f->middle[0][channel], f->middle[1][channel], f->middle[2][channel]);
    return f->centre[channel] + out * (corner - f->centre[channel]) + along * (middle - corner);
}

/* With w_c the largest weight the point lies in the triangle of the centre, corner c and the middle of edge
 * e, and there the value is linear: centre + s (corner_c - centre) + 2 (w_other - w_e) (middle_e - corner_c).
 */
void SL_KERNEL(sl_draw_simple)(const sl_simple_fan *fan, size_t count, const uint32_t *pixel,
                               const float *restrict w1, const float *restrict w2, float *const planes[3]) {
    const sl_simple_fan f = *fan;
    float value[3][BLOCK];
    for (size_t at = 0; at < count; at += BLOCK) {
        size_t n = count - at < BLOCK ? count - at : BLOCK;
#pragma omp simd
        for (size_t i = 0; i < n; i++) {
            sl_fan_weights w = sl_fan_weights_at(&f.weights, w1[at + i], w2[at + i]);
            float bc_low = w.b < w.c ? w.b : w.c, bc_high = w.b < w.c ? w.c : w.b,
                  least = w.a < bc_low ? w.a : bc_low, most = w.a > bc_high ? w.a : bc_high,
                  other = w.a > bc_high  ? bc_high
                          : w.a > bc_low ? w.a
                                         : bc_low;
            int nearest = w.a == most   ? 0
                          : w.b == most ? 1
                                        : 2,
                opposite = w.a == least   ? 0
                           : w.b == least ? 1
                                          : 2;
            float out = sl_clamp01(1.0f - 3.0f * least), along = 2.0f * (other - least);
            value[0][i] = in_fan(&f, 0, nearest, opposite, out, along);
            value[1][i] = in_fan(&f, 1, nearest, opposite, out, along);
            value[2][i] = in_fan(&f, 2, nearest, opposite, out, along);
        }
        put(n, pixel + at, value, planes);
    }
}

static inline float in_full_fan(float centre, const float *edge, int step, float rest, float out) {
    float on_edge = edge[step] + rest * (edge[step + 1] - edge[step]);
    return centre + out * (on_edge - centre);
}

void SL_KERNEL(sl_draw_full)(const sl_full_fan *fan, size_t count, const uint32_t *pixel,
                             const float *restrict w1, const float *restrict w2, float *const planes[3]) {
    const sl_leaf_weights of = fan->weights;
    const float centre_r = fan->centre[0], centre_g = fan->centre[1], centre_b = fan->centre[2];
    const float *restrict red = fan->edge[0], *restrict green = fan->edge[1], *restrict blue = fan->edge[2];
    float value[3][BLOCK];
    for (size_t at = 0; at < count; at += BLOCK) {
        size_t n = count - at < BLOCK ? count - at : BLOCK;
#pragma omp simd
        for (size_t i = 0; i < n; i++) {
            sl_fan_weights w = sl_fan_weights_at(&of, w1[at + i], w2[at + i]);
            float bc_low = w.b < w.c ? w.b : w.c, least = w.a < bc_low ? w.a : bc_low;
            int opposite = w.a == least ? 0 : w.b == least ? 1 : 2;
            float first = choose(opposite, w.b, w.c, w.a) - least,
                  second = choose(opposite, w.c, w.a, w.b) - least, sum = first + second;
            float steps = (float)SL_FULL_FAN_STEPS * sl_clamp01(second / (sum > 0.0f ? sum : 1.0f));
            int whole = (int)steps, low = whole < SL_FULL_FAN_STEPS ? whole : SL_FULL_FAN_STEPS - 1;
            int step = opposite * (SL_FULL_FAN_STEPS + 1) + low;
            float rest = steps - (float)low, out = sl_clamp01(1.0f - 3.0f * least);
            value[0][i] = in_full_fan(centre_r, red, step, rest, out);
            value[1][i] = in_full_fan(centre_g, green, step, rest, out);
            value[2][i] = in_full_fan(centre_b, blue, step, rest, out);
        }
        put(n, pixel + at, value, planes);
    }
}
