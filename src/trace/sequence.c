#include "trace/sequence.h"

#include "base/random.h"

/* Direction numbers v_k = m_k 2^(32-k) by the recurrence of a primitive polynomial (Bratley and Fox 1988): x
 * + 1 with m = 1, and x^2 + x + 1 with m = 1, 3. */
static void direction_numbers(int dimension, uint32_t v[32]) {
    if (dimension == 0) {
        v[0] = 1u << 31;
        for (int k = 1; k < 32; k++) v[k] = v[k - 1] ^ (v[k - 1] >> 1);
    } else {
        v[0] = 1u << 31;
        v[1] = 3u << 30;
        for (int k = 2; k < 32; k++) v[k] = v[k - 1] ^ v[k - 2] ^ (v[k - 2] >> 2);
    }
}

void sl_sequence_make(sl_sequence *sequence) {
    for (int dimension = 0; dimension < 2; dimension++) {
        uint32_t v[32];
        direction_numbers(dimension, v);
        for (int byte = 0; byte < 4; byte++) {
            for (uint32_t value = 0; value < 256; value++) {
                uint32_t x = 0;
                for (int bit = 0; bit < 8; bit++) {
                    if (value >> bit & 1) x ^= v[8 * byte + bit];
                }
                sequence->by_byte[dimension][byte][value] = sl_van_der_corput(x);
            }
        }
    }
}

static uint32_t sobol_reversed(const sl_sequence *s, int dimension, uint32_t i) {
    const uint32_t(*table)[256] = s->by_byte[dimension];
    return table[0][i & 255] ^ table[1][i >> 8 & 255] ^ table[2][i >> 16 & 255] ^ table[3][i >> 24];
}

/* A hash in which a bit depends on lower bits only (Laine and Karras 2011). */
static uint32_t permute_upwards(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* Owen's nested uniform scramble of a fraction x / 2^32, given by its bits in reverse: each bit is flipped or
 * not, as the bits above it say. */
static uint32_t scramble_reversed(uint32_t reversed, uint32_t seed) {
    return sl_van_der_corput(permute_upwards(reversed, seed));
}

void sl_sequence_point(const sl_sequence *sequence, uint64_t key, uint32_t set, uint32_t index,
                       float point[3]) {
    const uint64_t a = sl_hash64(key ^ ((uint64_t)set * 0xd1342543de82ef95u)), b = sl_hash64(a);
    /* The same permutation of the index itself only reorders points inside every aligned block of 2^k of
     * them. */
    const uint32_t i = scramble_reversed(sl_van_der_corput(index), (uint32_t)a);
    point[0] = sl_unit_of_bits(scramble_reversed(i, (uint32_t)(a >> 32)));
    point[1] = sl_unit_of_bits(scramble_reversed(sobol_reversed(sequence, 0, i), (uint32_t)b));
    point[2] = sl_unit_of_bits(scramble_reversed(sobol_reversed(sequence, 1, i), (uint32_t)(b >> 32)));
}
