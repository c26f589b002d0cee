/* Reduction of a pbuffer by repeated 2x2 sums (the papers' way to sum on graphics hardware), and the turn from the
 * target's row order into an image's. */
#include <string.h>

#include "base/counters.h"
#include "raster/raster.h"

static void halve(const float *restrict in, int size, float *restrict out) {
    size_t half = (size_t)size / 2;
    for (size_t y = 0; y < half; y++) {
        const float *restrict low = in + 2 * y * (size_t)size, *restrict high = low + size;
        for (size_t x = 0; x < half; x++) {
            out[y * half + x] = (low[2 * x] + low[2 * x + 1]) + (high[2 * x] + high[2 * x + 1]);
        }
    }
}

void sl_raster_reduce(const float *plane, int size, int final, float *scratch, float *out, sl_counters *counters) {
    float *pbuffer[2] = {scratch, scratch + (size_t)size * (size_t)size / 4};
    const float *from = plane;
    int now = 0;
    for (int at = size; at > final; at /= 2) {
        float *to = at / 2 == final ? out : pbuffer[now];
        halve(from, at, to);
        sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, (uint64_t)(at / 2) * (uint64_t)(at / 2));
        from = to;
        now = 1 - now;
    }
    size_t left = (size_t)final * (size_t)final;
    if (from == plane) memcpy(out, plane, left * sizeof *out);
    sl_count(counters, SL_COUNT_BYTES_READ_BACK, left * sizeof *out);
}

void sl_raster_flip(const float *plane, int width, int height, float *image_plane) {
    size_t row = (size_t)width;
    for (int y = 0; y < height; y++) {
        memcpy(image_plane + (size_t)y * row, plane + (size_t)(height - 1 - y) * row, row * sizeof *plane);
    }
}
