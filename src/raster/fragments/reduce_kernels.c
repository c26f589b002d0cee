/* One halving of a plane (reduce.c). */
#include <stddef.h>

#include "base/isa.h"

void SL_KERNEL(sl_raster_halve)(const float *in, int width, int rows, float *out) {
    const ptrdiff_t half = width / 2;
    for (int y = 0; y < rows / 2; y++) {
        const float *restrict low = in + 2 * (ptrdiff_t)y * width, *restrict high = low + width;
        float *restrict sum = out + y * half;
#pragma omp simd
        for (ptrdiff_t x = 0; x < half; x++)
            sum[x] = (low[2 * x] + low[2 * x + 1]) + (high[2 * x] + high[2 * x + 1]);
    }
}
