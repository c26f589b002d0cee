/* Reduction of a pbuffer by repeated 2x2 sums (the papers' way to sum on graphics hardware), and the turn
 * from the target's row order into an image's. */
#include <string.h>

#include "base/counters.h"
#include "raster/raster.h"

/* 2x2 sums of `rows` rows (even) of `width` pixels (even) into rows / 2 rows of width / 2. */
SL_KERNELS(void, sl_raster_halve, (const float *in, int width, int rows, float *out));

/* scratch: size*size/2, for halves in turn. */
static void reduce_plane(sl_isa isa, const float *plane, int size, int final, float *scratch, float *out) {
    float *const half[2] = {scratch, scratch + (size_t)(size / 2) * (size_t)(size / 2)};
    for (int now = 0; size > final; now = 1 - now, size /= 2) {
        float *to = size / 2 == final ? out : half[now];
        SL_KERNEL_OF(isa, sl_raster_halve)(plane, size, size, to);
        plane = to;
    }
}

void sl_raster_reduce(const float *planes, int size, int channels, int final, float *scratch, float *out,
                      sl_counters *counters) {
    const sl_isa isa = sl_isa_best();
    size_t pixels = (size_t)size * (size_t)size, left = (size_t) final * (size_t) final,
           depth = (size_t)channels;
    if (size == final) memcpy(out, planes, depth * left * sizeof *out);
    for (size_t c = 0; size > final && c < depth; c++)
        reduce_plane(isa, planes + c * pixels, size, final, scratch, out + c * left);
    /* A fragment sums all planes of its pixel. */
    for (int at = size; at > final; at /= 2)
        sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, (uint64_t)(at / 2) * (uint64_t)(at / 2));
    sl_count(counters, SL_COUNT_BYTES_READ_BACK, depth * left * sizeof *out);
}

void sl_raster_sum(const float *planes, int size, int channels, float *scratch, double *sum,
                   sl_counters *counters) {
    float left[SL_REDUCED_PLANES * SL_REDUCED * SL_REDUCED];
    const int final = size < SL_REDUCED ? size : SL_REDUCED, pixels = final * final;
    sl_raster_reduce(planes, size, channels, final, scratch, left, counters);
    for (int c = 0; c < channels; c++) {
        sum[c] = 0.0;
        for (int i = 0; i < pixels; i++) sum[c] += (double)left[c * pixels + i];
    }
}

void sl_raster_flip(const float *plane, int width, int height, float *image_plane) {
    size_t row = (size_t)width;
    for (int y = 0; y < height; y++) {
        memcpy(image_plane + (size_t)y * row, plane + (size_t)(height - 1 - y) * row, row * sizeof *plane);
    }
}
