/* Vectors as wide as a register of the instruction set of a *_kernels.c file, and what plain C cannot say
 * about them. (With arrays and loops instead, compilers keep them in memory, and a loop that collects bits
 * costs as much as a test; vectors wider than the machine's are compared lane by lane, ten times slower.) The
 * operators + - * & | and comparisons work lane by lane, a comparison giving all ones or 0. */
#pragma once

#include <stdint.h>
#include <string.h>

#if defined __AVX512DQ__
#include <immintrin.h>
enum { SL_WIDTH = 16 };
#elif defined __AVX2__
#include <immintrin.h>
enum { SL_WIDTH = 8 };
#else
#ifdef __SSE2__
#include <emmintrin.h>
#endif
enum { SL_WIDTH = 4 };
#endif
enum { SL_LANES_ALL = (1 << SL_WIDTH) - 1 }; /* a bit for each lane */

typedef int32_t sl_lanes_ints __attribute__((vector_size(4 * SL_WIDTH)));
typedef float sl_lanes_floats __attribute__((vector_size(4 * SL_WIDTH)));

static inline sl_lanes_ints sl_lanes_load_ints(const void *from) {
    sl_lanes_ints a;
    memcpy(&a, from, sizeof a);
    return a;
}
static inline sl_lanes_floats sl_lanes_load_floats(const float *from) {
    sl_lanes_floats a;
    memcpy(&a, from, sizeof a);
    return a;
}
static inline void sl_lanes_store(void *to, sl_lanes_ints a) { memcpy(to, &a, sizeof a); }

/* The lanes' numbers. */
static inline sl_lanes_ints sl_lanes_numbers(void) {
    static const int32_t number[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    return sl_lanes_load_ints(number);
}
static inline sl_lanes_ints sl_lanes_int(int32_t value) { return value - (sl_lanes_ints){0}; }
/* -0 as it is */
static inline sl_lanes_floats sl_lanes_float(float value) { return value - (sl_lanes_floats){0}; }

/* b where the mask is set, else a. */
static inline sl_lanes_ints sl_lanes_select(sl_lanes_ints mask, sl_lanes_ints a, sl_lanes_ints b) {
    return (a & ~mask) | (b & mask);
}
static inline sl_lanes_floats sl_lanes_select_floats(sl_lanes_ints mask, sl_lanes_floats a,
                                                     sl_lanes_floats b) {
    return (sl_lanes_floats)sl_lanes_select(mask, (sl_lanes_ints)a, (sl_lanes_ints)b);
}

/* The lanes that are negative, as bits; also the lanes that a comparison has set. */
static inline uint32_t sl_lanes_negative(sl_lanes_ints a) {
#if defined __AVX512DQ__
    return (uint32_t)_mm512_movepi32_mask((__m512i)a);
#elif defined __AVX2__
    return (uint32_t)_mm256_movemask_ps((__m256)a);
#elif defined __SSE2__
    return (uint32_t)_mm_movemask_ps((__m128)a);
#else
    uint32_t bits = 0;
    for (int l = 0; l < SL_WIDTH; l++) bits |= (uint32_t)(a[l] < 0) << l;
    return bits;
#endif
}

/* The lanes where a > b, as bits. A NaN is not greater, nor is anything greater than it. */
static inline uint32_t sl_lanes_greater(sl_lanes_floats a, sl_lanes_floats b) {
#if defined __AVX512DQ__ /* without the detour of a comparison's mask by way of a vector */
    return (uint32_t)_mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_GT_OQ);
#else
    return sl_lanes_negative(a > b);
#endif
}

/* ---- sixteen numbers at once, as bits ---- */

static inline uint32_t sl_bits16_negative(const int32_t *a) {
    uint32_t bits = 0;
    for (int l = 0; l < 16; l += SL_WIDTH) bits |= sl_lanes_negative(sl_lanes_load_ints(a + l)) << l;
    return bits;
}
/* Bit l: a[l] > limit, a[l] <= limit. A NaN is neither. */
static inline uint32_t sl_bits16_greater(const float *a, float limit) {
    uint32_t bits = 0;
    for (int l = 0; l < 16; l += SL_WIDTH)
        bits |= sl_lanes_greater(sl_lanes_load_floats(a + l), sl_lanes_float(limit)) << l;
    return bits;
}
static inline uint32_t sl_bits16_at_most(const float *a, float limit) {
    uint32_t bits = 0;
    for (int l = 0; l < 16; l += SL_WIDTH)
        bits |= sl_lanes_negative(sl_lanes_load_floats(a + l) <= limit) << l;
    return bits;
}
/* Returns how many are set. */
static inline uint32_t sl_bits16_count(uint32_t bits) {
#if defined __POPCNT__
    return (uint32_t)__builtin_popcount(bits);
#else /* else a library call */
    bits = bits - (bits >> 1 & 0x5555u);
    bits = (bits & 0x3333u) + (bits >> 2 & 0x3333u);
    bits = (bits + (bits >> 4)) & 0x0f0fu;
    return (bits + (bits >> 8)) & 0x1fu;
#endif
}
