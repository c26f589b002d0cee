/* The arithmetic of a bilinear lookup: where a texture coordinate falls, and how texels are mixed there. One
 * home for sl_texture_color(), one point at a time, and for the rasterizer's lanes, which therefore agree to
 * the bit. */
#pragma once

#include <math.h>
#include <stdint.h>

/* floor(x) for |x| < 2^22, without the call that floorf() is on plain x86-64: near 2^23 a float has no
 * fraction left. */
static inline float sl_whole_below(float x) {
    float nearest = (x + 0x1.8p23f) - 0x1.8p23f;
    return nearest > x ? nearest - 1.0f : nearest;
}

/* A place along one axis, repeated: the texel before it, the next one, and how far beyond the first one's
 * centre it is. */
typedef struct sl_texel_pair {
    int32_t texel, next;
    float beyond;
} sl_texel_pair;

static inline sl_texel_pair sl_texel_pair_at(float coordinate, int32_t size) {
    /* beyond, floats have hardly a fraction; also NaN */
    float within = fabsf(coordinate) < 0x1p22f ? coordinate : 0.0f;
    float turn = within - sl_whole_below(within);                   /* may round to 1 */
    float position = turn * (float)size - 0.5f, low = sl_whole_below(position);
    int32_t index = (int32_t)low;                                   /* -1 ... size - 1 */
    int32_t texel = index < 0 ? size - 1 : index;
    return (sl_texel_pair){texel, texel + 1 == size ? 0 : texel + 1, position - low};
}

static inline float sl_texel_mix(float a, float b, float t) { return a + t * (b - a); }

/* Lower left, lower right, upper left, upper right. */
static inline float sl_texel_bilinear(float a, float b, float c, float d, float right, float up) {
    return sl_texel_mix(sl_texel_mix(a, b, right), sl_texel_mix(c, d, right), up);
}
