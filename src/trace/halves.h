/* Sums of a reference tracer's film: even and odd samples apart, two independent pictures whose difference is
 * the noise. */
#ifndef SL_TRACE_HALVES_H
#define SL_TRACE_HALVES_H

#include "base/vec.h"
#include "softlux.h"

enum { SL_HALVES = 2 };

typedef struct sl_halves {
    size_t pixels;
    double *sums[SL_HALVES]; /* R, G, B planes */
    uint64_t samples[SL_HALVES];
} sl_halves;

sl_status sl_halves_create(sl_halves *halves, size_t pixels, sl_error *error);
void sl_halves_release(sl_halves *halves);
size_t sl_halves_memory_bytes(const sl_halves *halves);
static inline void sl_halves_add(const sl_halves *h, unsigned half, size_t pixel, sl_rgb light) {
    double *sums = h->sums[half];
    sums[pixel] += (double)light.r;
    sums[h->pixels + pixel] += (double)light.g;
    sums[2 * h->pixels + pixel] += (double)light.b;
}
/* R, G, B planes, each may be NULL; half -1: of all samples. */
void sl_halves_mean(const sl_halves *halves, int half, float *r, float *g, float *b);

#endif
