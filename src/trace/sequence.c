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
