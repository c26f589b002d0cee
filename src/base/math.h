/* Elementary functions that give the same bits on every machine: libm's may differ between versions and CPUs,
 * these are built of + - * / and sqrt only. Error bounds are tested (tests/base/test_base_math.c) and hold
 * for all finite arguments in the stated ranges; guarded arguments are said per function. */
#pragma once

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#define SL_PI 3.14159265358979323846

/* |x| <= 1e5; error at most 2 ulp (tan: 3) of max(|result|, 2^-53 |x|). Beyond, x is first reduced by fmod(x,
 * 2 SL_PI): bounded, but no longer accurate. NaN for NaN or infinite x. */
double sl_sin(double x);
double sl_cos(double x);
double sl_tan(double x);
/* All x; error at most 2 ulp. */
double sl_atan(double x);
/* As C's atan2, including signed zeros (0 where both are 0 and x is +0) and infinities; error at most 2 ulp.
 */
double sl_atan2(double y, double x);
/* Arguments beyond [-1,1] are clamped: what rounding puts outside is meant to be 1. Error at most 4 ulp
 * (asin), and at most 1e-15 absolute (acos). */
double sl_asin(double x);
double sl_acos(double x);
/* Error at most 2 ulp; overflow to infinity, underflow to 0 (denormals kept). */
double sl_exp(double x);
/* x > 0: at most 2 ulp. -infinity at 0, NaN below. */
double sl_log(double x);
/* x >= 0; x^y = exp(y log x) with a compensated logarithm: relative error below 1e-14 for results in the
 * normal range. 0^0 = 1, 0^y = 0 for y > 0, as C's pow for infinities and NaN. NaN for x < 0 (C's pow takes
 * whole y there). */
double sl_pow(double x, double y);

/* Tells whether neither is more than a hundredth of the larger away from the other; both at least 0. What was
 * made for one may then stay. False for NaN. */
static inline bool sl_is_much_the_same(double a, double b) {
    return a == b || fabs(a - b) < 0.01 * fmax(a, b);
}

static inline size_t sl_fewer(size_t a, size_t b) { return a < b ? a : b; }
static inline int sl_lesser(int a, int b) { return a < b ? a : b; }
static inline int sl_greater(int a, int b) { return a > b ? a : b; }

/* Returns the first of sums that rise which is above u; the last where none is. */
static inline size_t sl_first_above(const double *sums, size_t count, double u) {
    size_t low = 0, high = count - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (u < sums[middle]) high = middle;
        else low = middle + 1;
    }
    return low;
}

/* ---- float versions for inner loops -----------------------------------------------------------
 * Inline, free of branches, tables and calls, so that loops over them vectorise; the same bits per lane as
 * alone. */

static inline uint32_t sl_float_bits(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}
static inline float sl_float_of_bits(uint32_t bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}
/* An integer whose order is that of the floats, and back. */
static inline uint32_t sl_float_key(float x) {
    uint32_t bits = sl_float_bits(x);
    return bits >> 31 ? ~bits : bits | 0x80000000u;
}
static inline float sl_float_of_key(uint32_t key) {
    return sl_float_of_bits(key >> 31 ? key & 0x7fffffffu : ~key);
}
static inline uint64_t sl_double_bits(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}
static inline double sl_double_of_bits(uint64_t bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* 1.5 * 2^23: adding it rounds to the nearest integer and leaves that integer in the low bits. */
#define SL_ROUND_FLOAT 0x1.8p23f

/* 2^x; relative error below 2e-7. x is clamped to [-126, 127], NaN counts as -126. */
static inline float sl_exp2f(float x) {
    x = x > -126.0f ? x : -126.0f;
    x = x < 127.0f ? x : 127.0f;
    float rounded = x + SL_ROUND_FLOAT;
    float f = x - (rounded - SL_ROUND_FLOAT); /* in [-1/2, 1/2], exact */
    float p = 0x1.444p-13f;                   /* (2^f - 1) / f, fitted at Chebyshev nodes */
    p = p * f + 0x1.5f089p-10f;
    p = p * f + 0x1.3b2a54p-7f;
    p = p * f + 0x1.c6af6cp-5f;
    p = p * f + 0x1.ebfbep-3f;
    p = p * f + 0x1.62e430p-1f;
    uint32_t exponent = sl_float_bits(rounded) - sl_float_bits(SL_ROUND_FLOAT) + 127u;
    return (1.0f + p * f) * sl_float_of_bits(exponent << 23);
}

/* x^n, the cosine power of a Phong lobe, for 0 <= x and 0 <= n: relative error below 2e-7 for results in the
 * normal range, 0 for results below it. 1 for n = 0; 0 for n > 0 and x = 0, negative or NaN; results above
 * 2^127 are clamped to it. The logarithm is taken in double, since its error is multiplied by n log x. */
static inline float sl_powf(float x, float n) {
    double m = x > 0.0f ? (double)x : 0.0;
    uint64_t bits = sl_double_bits(m);
    uint64_t biased = (bits + (0x3ff0000000000000u - 0x3fe6a09e667f3bcdu)) >> 52;
    double f = sl_double_of_bits(bits - (biased << 52) + 0x3ff0000000000000u) - 1.0;
    double s = f / (2.0 + f), z = s * s; /* log((1+s)/(1-s)) = 2 (s + s^3/3 + s^5/5 + ...), |s| < 0.172 */
    double p = 0x1.21b245a850e1dp-2;
    p = p * z + 0x1.4795463b406c3p-2;
    p = p * z + 0x1.a61a2ef4051f3p-2;
    p = p * z + 0x1.2776c2935a8c1p-1;
    p = p * z + 0x1.ec709dc53bfcfp-1;
    p = p * z + 0x1.71547652b8251p+1;
    /* to double, as a vector can */
    double k = sl_double_of_bits(biased | 0x4330000000000000u) - (0x1p52 + 1023.0);
    double e = (double)n * (k + p * s);
    e = m > 0.0 ? e : -1000.0;
    e = n > 0.0f ? e : 0.0;
    double clamped = e > -127.0 ? e : -127.0;
    clamped = clamped < 127.0 ? clamped : 127.0;
    double rounded = clamped + 0x1.8p52;
    float power = sl_exp2f((float)(clamped - (rounded - 0x1.8p52)));
    float scale = sl_float_of_bits(((uint32_t)sl_double_bits(rounded) + 127u) << 23);
    power = power * scale;
    return e >= -126.0 ? power : 0.0f;
}

/* sin and cos of 2 pi u for u in [0,1], error below 2e-7 absolute; exact at multiples of 1/4. */
static inline void sl_sincos_turnf(float u, float *sine, float *cosine) {
    float rounded = 4.0f * u + SL_ROUND_FLOAT;
    float r = u - 0.25f * (rounded - SL_ROUND_FLOAT); /* in [-1/8, 1/8], exact */
    float z = r * r;
    float s = 0x1.4bc85cp+5f;
    s = s * z - 0x1.32ca9ep+6f;
    s = s * z + 0x1.466bbap+6f;
    s = s * z - 0x1.4abbcep+5f;
    s = (s * z + 0x1.921fb6p+2f) * r;
    float c = 0x1.db6492p+5f;
    c = c * z - 0x1.55cb98p+6f;
    c = c * z + 0x1.03c1eap+6f;
    c = (c * z - 0x1.3bd3ccp+4f) * z + 1.0f;
    uint32_t quadrant = sl_float_bits(rounded);
    uint32_t sine_sign = (quadrant & 2u) << 30, cosine_sign = ((quadrant + 1u) & 2u) << 30;
    float a = quadrant & 1u ? c : s, b = quadrant & 1u ? s : c;
    *sine = sl_float_of_bits(sl_float_bits(a) ^ sine_sign);
    *cosine = sl_float_of_bits(sl_float_bits(b) ^ cosine_sign);
}
