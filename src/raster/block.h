/* A block's sixteen pixels as vectors of the instruction set's own width: one part with AVX-512, two (of two
 * rows each) with AVX2, four (of a row each) with SSE2.
 *
 *      12 13 14 15     part 3          8 .. 15     part 1
 *       8  9 10 11     part 2          0 ..  7     part 0        0 .. 15   part 0
 *       4  5  6  7     part 1
 *       0  1  2  3     part 0
 *         SSE2                           AVX2                     AVX-512                    */
#pragma once

#include "base/lanes.h"

enum { SL_PARTS = 16 / SL_WIDTH, SL_PART_ROWS = SL_WIDTH / 4 };

/* The pixels within part 0, row by row from the lowest. */
static inline sl_lanes_ints sl_part_x(void) { return sl_lanes_numbers() & 3; }
static inline sl_lanes_ints sl_part_y(void) { return sl_lanes_numbers() >> 2; }

/* Writes depth and id of the pixels where z wins: covered (outside >= 0) and nearer, or as near with the
 * lower id. */
static inline void sl_part_write(sl_lanes_ints outside, sl_lanes_floats z, sl_lanes_ints id,
                                 int larger_is_nearer, uint32_t *ids, float *depths) {
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
    const sl_lanes_ints old_id = sl_lanes_load_ints(ids);
    const sl_lanes_floats old = sl_lanes_load_floats(depths);
    const sl_lanes_ints nearer = larger_is_nearer ? z > old : z < old;
    const sl_lanes_ints wins = (outside >= 0) & (nearer | ((z == old) & (id < old_id)));
    sl_lanes_store(depths, sl_lanes_select(wins, (sl_lanes_ints)old, (sl_lanes_ints)z));
    sl_lanes_store(ids, sl_lanes_select(wins, old_id, id));
#endif
}

/* Four blocks side by side, as four rows of sixteen pixels. (gcc 11 knows no __builtin_shufflevector().) */
static inline void sl_block_rows(const uint32_t *blocks, uint32_t *to, size_t stride) {
#if defined __AVX512DQ__ && __has_builtin(__builtin_shufflevector)
    sl_lanes_ints b0 = sl_lanes_load_ints(blocks), b1 = sl_lanes_load_ints(blocks + 16),
                 b2 = sl_lanes_load_ints(blocks + 32), b3 = sl_lanes_load_ints(blocks + 48);
    sl_lanes_ints low01 =
        __builtin_shufflevector(b0, b1, 0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
    sl_lanes_ints low23 =
        __builtin_shufflevector(b2, b3, 0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
    sl_lanes_ints high01 =
        __builtin_shufflevector(b0, b1, 8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
    sl_lanes_ints high23 =
        __builtin_shufflevector(b2, b3, 8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
    sl_lanes_store(
        to, __builtin_shufflevector(low01, low23, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23));
    sl_lanes_store(to + stride, __builtin_shufflevector(low01, low23, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25,
                                                        26, 27, 28, 29, 30, 31));
    sl_lanes_store(to + 2 * stride, __builtin_shufflevector(high01, high23, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17,
                                                            18, 19, 20, 21, 22, 23));
    sl_lanes_store(to + 3 * stride, __builtin_shufflevector(high01, high23, 8, 9, 10, 11, 12, 13, 14, 15, 24,
                                                            25, 26, 27, 28, 29, 30, 31));
#else
    for (size_t row = 0; row < 4; row++) {
        for (size_t k = 0; k < 4; k++) memcpy(to + row * stride + 4 * k, blocks + 16 * k + 4 * row, 16);
    }
#endif
}
