/* A block's sixteen pixels as vectors, and the one thing that plain C cannot say about them: whether any lane is set. (With
 * arrays and loops instead, compilers keep the edge functions in memory and the rasterizer takes half as long again.) The
 * operators + - * & | and comparisons work on vectors lane by lane, a comparison giving all ones or 0; compilers cut them to
 * the instruction set's width. */
#ifndef SL_RASTER_BLOCK_H
#define SL_RASTER_BLOCK_H

#include <stdint.h>
#include <string.h>

#ifdef __SSE2__
#include <immintrin.h>
#endif

typedef int32_t sl_block_ints __attribute__((vector_size(64)));
typedef float sl_block_floats __attribute__((vector_size(64)));

/* Of each pixel within the block, row by row from the lowest. */
#define SL_BLOCK_X ((sl_block_ints){0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3})
#define SL_BLOCK_Y ((sl_block_ints){0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3})

static inline sl_block_ints sl_block_int(int32_t value) { return value - (sl_block_ints){0}; }
static inline sl_block_floats sl_block_float(float value) { return value - (sl_block_floats){0}; } /* -0 as it is */

static inline sl_block_ints sl_block_load_ints(const void *from) {
    sl_block_ints a;
    memcpy(&a, from, sizeof a);
    return a;
}
static inline sl_block_floats sl_block_load_floats(const float *from) {
    sl_block_floats a;
    memcpy(&a, from, sizeof a);
    return a;
}
static inline void sl_block_store(void *to, sl_block_ints a) { memcpy(to, &a, sizeof a); }

/* b where the mask is set, else a. */
static inline sl_block_ints sl_block_select(sl_block_ints mask, sl_block_ints a, sl_block_ints b) {
    return (a & ~mask) | (b & mask);
}
static inline sl_block_floats sl_block_select_floats(sl_block_ints mask, sl_block_floats a, sl_block_floats b) {
    return (sl_block_floats)sl_block_select(mask, (sl_block_ints)a, (sl_block_ints)b);
}

/* Four blocks side by side, as their four rows of sixteen pixels. */
static inline void sl_block_rows(const sl_block_ints block[4], sl_block_ints row[4]) {
    for (int k = 0; k < 2; k++) { /* rows 2k and 2k + 1 */
        const sl_block_ints *b = block;
        sl_block_ints left, right;
        if (k == 0) {
            left = __builtin_shufflevector(b[0], b[1], 0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
            right = __builtin_shufflevector(b[2], b[3], 0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
        } else {
            left = __builtin_shufflevector(b[0], b[1], 8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
            right = __builtin_shufflevector(b[2], b[3], 8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
        }
        row[2 * k] = __builtin_shufflevector(left, right, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23);
        row[2 * k + 1] = __builtin_shufflevector(left, right, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
    }
}

/* Whether some lane is set, of a comparison's result. */
static inline int sl_block_any(sl_block_ints mask) {
#if defined __AVX512DQ__
    return _mm512_movepi32_mask((__m512i)mask) != 0;
#elif defined __AVX2__
    __m256i half[2];
    memcpy(half, &mask, sizeof mask);
    return !_mm256_testz_si256(_mm256_or_si256(half[0], half[1]), _mm256_or_si256(half[0], half[1]));
#else
    int32_t any = 0;
    for (int l = 0; l < 16; l++) any |= mask[l];
    return any != 0;
#endif
}

/* Whether some lane is >= 0. */
static inline int sl_block_any_positive(sl_block_ints a) {
#if defined __AVX512DQ__
    return _mm512_movepi32_mask((__m512i)a) != 0xffff;
#elif defined __AVX2__
    __m256i half[2];
    memcpy(half, &a, sizeof a);
    return _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_and_si256(half[0], half[1]))) != 0xff;
#elif defined __SSE2__
    __m128i part[4];
    memcpy(part, &a, sizeof a);
    __m128i all = _mm_and_si128(_mm_and_si128(part[0], part[1]), _mm_and_si128(part[2], part[3]));
    return _mm_movemask_ps(_mm_castsi128_ps(all)) != 0xf;
#else
    int32_t all = -1;
    for (int l = 0; l < 16; l++) all &= a[l];
    return all >= 0;
#endif
}

/* Writes depth and id of the pixels where z wins: covered (outside >= 0) and nearer, or as near with the lower id. */
static inline void sl_block_write(sl_block_ints outside, sl_block_floats z, sl_block_ints id, int larger_is_nearer,
                                  uint32_t *ids, float *depths) {
#if defined __AVX512DQ__
    /* The ids are looked at only where depths are equal, and nothing is written where nothing wins. */
    const __m512 old = _mm512_loadu_ps(depths);
    const __mmask16 inside = (__mmask16)~_mm512_movepi32_mask((__m512i)outside);
    const __mmask16 equal = _mm512_mask_cmp_ps_mask(inside, (__m512)z, old, _CMP_EQ_OQ);
    __mmask16 wins = larger_is_nearer ? _mm512_mask_cmp_ps_mask(inside, (__m512)z, old, _CMP_GT_OQ)
                                      : _mm512_mask_cmp_ps_mask(inside, (__m512)z, old, _CMP_LT_OQ);
    if (equal) wins |= _mm512_mask_cmplt_epi32_mask(equal, (__m512i)id, _mm512_loadu_si512(ids));
    _mm512_mask_storeu_ps(depths, wins, (__m512)z);
    _mm512_mask_storeu_epi32(ids, wins, (__m512i)id);
#else
    const sl_block_ints old_id = sl_block_load_ints(ids);
    const sl_block_floats old = sl_block_load_floats(depths);
    const sl_block_ints nearer = larger_is_nearer ? z > old : z < old;
    const sl_block_ints wins = (outside >= 0) & (nearer | ((z == old) & (id < old_id)));
    sl_block_store(depths, sl_block_select(wins, (sl_block_ints)old, (sl_block_ints)z));
    sl_block_store(ids, sl_block_select(wins, old_id, id));
#endif
}

#endif
