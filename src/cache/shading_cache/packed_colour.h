/* Colours of the display in 8 bytes: an exponent that the three channels share, and 18 bits for each. So they
 * are off by at most 2^-18 of the largest one, less than the thousandth part of a display level; for the
 * cache itself, which goes on computing with its values, that would not do. */
#ifndef SL_SHADING_CACHE_PACKED_COLOUR_H
#define SL_SHADING_CACHE_PACKED_COLOUR_H

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef uint64_t sl_packed_colour;

enum { SL_PACKED_BITS = 18, SL_PACKED_EXPONENT_MIN = -96 };

/* 2^exponent, within the range of normal floats. */
static inline float sl_power_of_two(int exponent) {
    uint32_t bits = (uint32_t)(exponent + 127) << 23;
    float power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/* The least exponent with x < 2^exponent, at least SL_PACKED_EXPONENT_MIN; x finite, not negative. */
static inline int sl_exponent_above(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    int exponent = (int)(bits >> 23) - 126;
    return exponent > SL_PACKED_EXPONENT_MIN ? exponent : SL_PACKED_EXPONENT_MIN;
}

/* Light is not negative; what is no number is black, and what is beyond floats the largest one. */
static inline float sl_packable(float x) {
    return x > 0.0f ? (x < 0x1.fffffep127f ? x : 0x1.fffffep127f) : 0.0f;
}

static inline sl_packed_colour sl_pack_colour(const float colour[3]) {
    float c[3] = {sl_packable(colour[0]), sl_packable(colour[1]), sl_packable(colour[2])};
    float most = c[0] > c[1] ? c[0] : c[1];
    int exponent = sl_exponent_above(most > c[2] ? most : c[2]);
    double unit = (double)sl_power_of_two(exponent - SL_PACKED_BITS);
    uint64_t packed = (uint64_t)(exponent - SL_PACKED_EXPONENT_MIN);
    for (int k = 0; k < 3; k++) {
        uint64_t whole = (uint64_t)((double)c[k] / unit + 0.5), largest = (1u << SL_PACKED_BITS) - 1;
        packed = packed << SL_PACKED_BITS | (whole < largest ? whole : largest);
    }
    return packed;
}

static inline void sl_unpack_colour(sl_packed_colour packed, float colour[3]) {
    const uint32_t largest = (1u << SL_PACKED_BITS) - 1;
    float unit =
        sl_power_of_two((int)(packed >> 3 * SL_PACKED_BITS) + SL_PACKED_EXPONENT_MIN - SL_PACKED_BITS);
    colour[0] = (float)(int32_t)((uint32_t)(packed >> 2 * SL_PACKED_BITS) & largest) * unit;
    colour[1] = (float)(int32_t)((uint32_t)(packed >> SL_PACKED_BITS) & largest) * unit;
    colour[2] = (float)(int32_t)((uint32_t)packed & largest) * unit;
}

#endif
