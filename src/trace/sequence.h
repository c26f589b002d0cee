/* Well-spread sample points: a Sobol' sequence of three dimensions, Owen-scrambled and shuffled by hashing
 * (Burley, "Practical Hash-based Owen Scrambling", 2020). Every decision of a path (pixel, light, direction
 * at each vertex) takes points of its own, padded together by independent scrambles. All is a function of
 * (key, set, index), there is no state. */
#pragma once

#include <stdint.h>

/* The generator matrices, applied a byte of the index at a time; what they give has its bits in reverse, as
 * the scramble wants them. Dimension 0 is the radical inverse, whose reverse is the index: it needs none. */
typedef struct sl_sequence {
    uint32_t by_byte[2][4][256];
} sl_sequence;

void sl_sequence_make(sl_sequence *sequence);
/* Point `index` of the points (key, set): three numbers in [0,1); the first two are spread best together. */
void sl_sequence_point(const sl_sequence *sequence, uint64_t key, uint32_t set, uint32_t index,
                       float point[3]);
