/* Front to back: the visible clusters sorted by their distance, roughly, since the picture does not depend on
 * it. One counting sort over the logarithm of the distance, 16 steps an octave, whose bits a float's bits
 * are. */
#include <string.h>

#include "raster/pipeline.h"

enum { BUCKETS = 256, STEP_BITS = 19 };

static uint32_t step_of(float distance) { /* >= 0 and finite */
    uint32_t bits;
    memcpy(&bits, &distance, sizeof bits);
    return bits >> STEP_BITS;
}

void sl_visible_sort(sl_visible *v) {
    uint32_t start[BUCKETS + 1] = {0}, farthest = BUCKETS - 1;
    for (uint32_t n = 0; n < v->count; n++) {
        uint32_t step = step_of(v->distance[n]);
        farthest = step > farthest ? step : farthest;
    }
    const uint32_t base = farthest - (BUCKETS - 1);
    for (uint32_t n = 0; n < v->count; n++) {
        uint32_t step = step_of(v->distance[n]);
        start[(step > base ? step - base : 0) + 1]++;
    }
    for (int b = 0; b < BUCKETS; b++) start[b + 1] += start[b];
    for (uint32_t n = 0; n < v->count; n++) {
        uint32_t step = step_of(v->distance[n]);
        v->order[start[step > base ? step - base : 0]++] = n;
    }
}
