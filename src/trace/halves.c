#include "trace/halves.h"

#include "base/error.h"
#include "base/memory.h"

sl_status sl_halves_create(sl_halves *h, size_t pixels, sl_error *error) {
    *h = (sl_halves){.pixels = pixels};
    for (int half = 0; half < SL_HALVES; half++) {
        h->sums[half] = sl_allocate(3 * pixels, sizeof(double));
        if (!h->sums[half]) return sl_fail_memory(error, "a reference tracer's film");
    }
    return SL_OK;
}

void sl_halves_release(sl_halves *h) {
    for (int half = 0; half < SL_HALVES; half++) sl_free(h->sums[half]);
    *h = (sl_halves){0};
}

size_t sl_halves_memory_bytes(const sl_halves *h) { return SL_HALVES * 3 * h->pixels * sizeof(double); }

void sl_halves_mean(const sl_halves *h, int half, float *r, float *g, float *b) {
    float *planes[3] = {r, g, b};
    uint64_t samples = half < 0 ? h->samples[0] + h->samples[1] : h->samples[half & 1];
    double scale = samples > 0 ? 1.0 / (double)samples : 0.0;
    for (size_t channel = 0; channel < 3; channel++) {
        if (!planes[channel]) continue;
        const double *even = h->sums[0] + channel * h->pixels, *odd = h->sums[1] + channel * h->pixels;
        for (size_t i = 0; i < h->pixels; i++) {
            double sum = half < 0 ? even[i] + odd[i] : half == 0 ? even[i] : odd[i];
            planes[channel][i] = (float)(sum * scale);
        }
    }
}
