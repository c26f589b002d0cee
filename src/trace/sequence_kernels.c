#include "trace/sequence.h"

void SL_KERNEL(sl_sequence_points)(const sl_sequence *sequence, size_t count, const uint64_t *key,
                                   uint32_t set, uint32_t index, float *const u[3]) {
    const uint64_t *restrict k = key;
    float *restrict u0 = u[0], *restrict u1 = u[1], *restrict u2 = u[2];
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        u0[i] = sl_sequence_number(sequence, k[i], set, index, 0);
        u1[i] = sl_sequence_number(sequence, k[i], set, index, 1);
        u2[i] = sl_sequence_number(sequence, k[i], set, index, 2);
    }
}
