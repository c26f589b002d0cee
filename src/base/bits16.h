/* Comparisons of sixteen numbers at once, as bits, which plain C cannot say well: greater than a limit, at
 * most a limit, or negative. A NaN is neither. (A loop that collects bits costs more than the arithmetic
 * that it may save.) For *_kernels.c files. */
#ifndef SL_BASE_BITS16_H
#define SL_BASE_BITS16_H

#include <stdint.h>

#if defined __AVX2__
#include <immintrin.h>
#elif defined __SSE2__
#include <emmintrin.h>
#endif

/* Bit l: a[l] < 0. */
static inline uint32_t sl_bits16_negative(const int32_t *a) {
#if defined __AVX512DQ__
    return (uint32_t)_mm512_movepi32_mask(_mm512_loadu_si512(a));
#elif defined __AVX2__
    int low = _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_loadu_si256((const __m256i *)(const void *)a)));
    return (uint32_t)low | (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(
                               _mm256_loadu_si256((const __m256i *)(const void *)(a + 8))))
                               << 8;
#elif defined __SSE2__
    uint32_t bits = 0;
    for (int l = 0; l < 4; l++) {
        bits |= (uint32_t)_mm_movemask_ps(
                    _mm_castsi128_ps(_mm_loadu_si128((const __m128i *)(const void *)(a + 4 * l))))
                << (4 * l);
    }
    return bits;
#else
    uint32_t bits = 0;
    for (int l = 0; l < 16; l++) bits |= (uint32_t)(a[l] < 0) << l;
    return bits;
#endif
}

/* Bit l: a[l] > limit. The comparison is a loop that vectorizes; collecting its bits is not one. */
static inline uint32_t sl_bits16_greater(const float *a, float limit) {
    int32_t holds[16];
#pragma omp simd
    for (int l = 0; l < 16; l++) holds[l] = -(a[l] > limit);
    return sl_bits16_negative(holds);
}

/* Bit l: a[l] <= limit. */
static inline uint32_t sl_bits16_at_most(const float *a, float limit) {
    int32_t holds[16];
#pragma omp simd
    for (int l = 0; l < 16; l++) holds[l] = -(a[l] <= limit);
    return sl_bits16_negative(holds);
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

#endif
