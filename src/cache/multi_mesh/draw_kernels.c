/* Pixels of a leaf from a fan of six triangles. With w_c the largest weight and w_e the smallest, a point lies in the triangle of the centre, corner
 * c and the middle of the edge opposite to corner e, and there the value is linear:
 *     centre + (1 - 3 w_e) (corner_c - centre) + 2 (w_other - w_e) (middle_e - corner_c),
 * all differences, so that one colour stays that colour in every bit. */
#include "cache/multi_mesh/draw_kernels.h"

enum { BLOCK = 64 };

static inline float clamp01(float x) {
    float above = x > 0.0f ? x : 0.0f;
    return above < 1.0f ? above : 1.0f;
}

static inline float choose(int which, float a, float b, float c) { return which == 0 ? a : which == 1 ? b : c; }

/* One channel needs its seven values alone. */
static inline float in_fan(const sl_simple_fan *f, int channel, int c, int e, float out, float along) {
    float corner = choose(c, f->corner[0][channel], f->corner[1][channel], f->corner[2][channel]);
    float middle = choose(e, f->middle[0][channel], f->middle[1][channel], f->middle[2][channel]);
    return f->centre[channel] + out * (corner - f->centre[channel]) + along * (middle - corner);
}

void SL_KERNEL(sl_draw)(const sl_simple_fan *fan, size_t count, const uint32_t *restrict pixel, const float *restrict w1,
                        const float *restrict w2, float *const planes[3]) {
    const sl_simple_fan f = *fan;
    float red[BLOCK], green[BLOCK], blue[BLOCK];
    for (size_t at = 0; at < count; at += BLOCK) {
        size_t n = count - at < BLOCK ? count - at : BLOCK;
#pragma omp simd
        for (size_t i = 0; i < n; i++) {
            float p = w1[at + i] - f.p, q = w2[at + i] - f.q;
            float b = clamp01(p * f.b_of_p + q * f.b_of_q), c = clamp01(p * f.c_of_p + q * f.c_of_q), a = clamp01(1.0f - b - c);
            float bc_low = b < c ? b : c, bc_high = b < c ? c : b, least = a < bc_low ? a : bc_low, most = a > bc_high ? a : bc_high;
            int nearest = a == most ? 0 : b == most ? 1 : 2, opposite = a == least ? 0 : b == least ? 1 : 2;
            float other = a > bc_high ? bc_high : a > bc_low ? a : bc_low;
            float out = clamp01(1.0f - 3.0f * least), along = 2.0f * (other - least);
            red[i] = in_fan(&f, 0, nearest, opposite, out, along);
            green[i] = in_fan(&f, 1, nearest, opposite, out, along);
            blue[i] = in_fan(&f, 2, nearest, opposite, out, along);
        }
        for (size_t i = 0; i < n; i++) {
            planes[0][pixel[at + i]] = red[i];
            planes[1][pixel[at + i]] = green[i];
            planes[2][pixel[at + i]] = blue[i];
        }
    }
}
