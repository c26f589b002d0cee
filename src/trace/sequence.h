/* Well-spread sample points: a Sobol' sequence of three dimensions, Owen-scrambled and shuffled by hashing
 * (Burley, "Practical Hash-based Owen Scrambling", 2020). Every decision of a path (pixel, light, direction
 * at each vertex) takes points of its own, padded together by independent scrambles. All is a function of
 * (key, set, index), there is no state. */
#pragma once

#include "base/isa.h"
#include "base/random.h"

#include <stddef.h>
#include <stdint.h>

/* The generator matrices, applied a byte of the index at a time; what they give has its bits in reverse, as
 * the scramble wants them. Dimension 0 is the radical inverse, whose reverse is the index: it needs none. */
typedef struct sl_sequence {
    uint32_t by_byte[2][4][256];
} sl_sequence;

void sl_sequence_make(sl_sequence *sequence);

static inline uint32_t sl_sobol_reversed(const sl_sequence *s, int dimension, uint32_t i) {
    const uint32_t(*table)[256] = s->by_byte[dimension];
    return table[0][i & 255] ^ table[1][i >> 8 & 255] ^ table[2][i >> 16 & 255] ^ table[3][i >> 24];
}

/* A hash in which a bit depends on lower bits only (Laine and Karras 2011). */
static inline uint32_t sl_permute_upwards(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* Owen's nested uniform scramble of a fraction x / 2^32, given by its bits in reverse: each bit is flipped or
 * not, as the bits above it say. */
static inline uint32_t sl_scramble_reversed(uint32_t reversed, uint32_t seed) {
    return sl_van_der_corput(sl_permute_upwards(reversed, seed));
}

/* Number `dimension` of point `index` of the points (key, set), in [0,1); the first two are spread best
 * together. */
static inline float sl_sequence_number(const sl_sequence *sequence, uint64_t key, uint32_t set,
                                       uint32_t index, int dimension) {
    const uint64_t a = sl_hash64(key ^ ((uint64_t)set * 0xd1342543de82ef95u)), b = sl_hash64(a);
    /* The same permutation of the index itself only reorders points inside every aligned block of 2^k of
     * them. */
    const uint32_t i = sl_scramble_reversed(sl_van_der_corput(index), (uint32_t)a);
    if (dimension == 0) return sl_unit_of_bits(sl_scramble_reversed(i, (uint32_t)(a >> 32)));
    return sl_unit_of_bits(sl_scramble_reversed(sl_sobol_reversed(sequence, dimension - 1, i),
                                                (uint32_t)(dimension == 1 ? b : b >> 32)));
}

/* All three numbers of a point. */
static inline void sl_sequence_point(const sl_sequence *sequence, uint64_t key, uint32_t set, uint32_t index,
                                     float point[3]) {
    for (int d = 0; d < 3; d++) point[d] = sl_sequence_number(sequence, key, set, index, d);
}

/* Point `index` of the points (key[i], set) for `count` keys: number d is u[d][i]. */
SL_KERNELS(void, sl_sequence_points, (const sl_sequence *sequence, size_t count, const uint64_t *key,
                                      uint32_t set, uint32_t index, float *const u[3]));
