/* As many floats as the instruction set of a *_kernels.c file holds in one register, and what plain C cannot
 * say about them: which lanes of one are greater than those of another, or differ, as bits. (A loop that
 * collects bits costs half of a triangle test.) The operators + - * work on lanes as on floats, lane by lane.
 */
#ifndef SL_TRACE_LANES_H
#define SL_TRACE_LANES_H

#include <stdint.h>
#include <string.h>

#if defined __AVX512F__
#include <immintrin.h>
enum { SL_LANES = 16 };
#elif defined __AVX2__
#include <immintrin.h>
enum { SL_LANES = 8 };
#else
#ifdef __SSE2__
#include <emmintrin.h>
#endif
enum { SL_LANES = 4 };
#endif

typedef float sl_lanes __attribute__((vector_size(4 * SL_LANES)));

static inline sl_lanes sl_lanes_load(const float *from) {
    sl_lanes a;
    memcpy(&a, from, sizeof a);
    return a;
}

static inline void sl_lanes_store(float *to, sl_lanes a) { memcpy(to, &a, sizeof a); }

/* Bit i: a[i] > b[i]. A NaN is not greater, nor is anything greater than it. */
static inline uint32_t sl_lanes_greater(sl_lanes a, sl_lanes b) {
#if defined __AVX512F__
    return (uint32_t)_mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_GT_OQ);
#elif defined __AVX2__
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps((__m256)a, (__m256)b, _CMP_GT_OQ));
#elif defined __SSE2__
    return (uint32_t)_mm_movemask_ps(_mm_cmpgt_ps((__m128)a, (__m128)b));
#else
    uint32_t bits = 0;
    for (unsigned i = 0; i < SL_LANES; i++) bits |= (uint32_t)(a[i] > b[i]) << i;
    return bits;
#endif
}

/* Bit i: integer a[i] is not b[i]. */
static inline uint32_t sl_lanes_differ(const void *a, const void *b) {
#if defined __AVX512F__
    return (uint32_t)_mm512_cmpneq_epi32_mask(_mm512_loadu_si512(a), _mm512_loadu_si512(b));
#elif defined __AVX2__
    __m256i same = _mm256_cmpeq_epi32(_mm256_loadu_si256(a), _mm256_loadu_si256(b));
    return 0xffu ^ (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(same));
#elif defined __SSE2__
    __m128i same = _mm_cmpeq_epi32(_mm_loadu_si128(a), _mm_loadu_si128(b));
    return 0xfu ^ (uint32_t)_mm_movemask_ps(_mm_castsi128_ps(same));
#else
    uint32_t bits = 0;
    for (unsigned i = 0; i < SL_LANES; i++) {
        bits |= (uint32_t)(((const uint32_t *)a)[i] != ((const uint32_t *)b)[i]) << i;
    }
    return bits;
#endif
}

#endif
