/* Hot loops over planes; see planes.h. */
#include <stddef.h>

#include "raster/fragments/planes.h"
#include "raster/raster.h"

enum { GROUP = 16 };

/* Whole groups, also at the rectangle's ends; pixels outside keep their bits. */
static void SL_KERNEL(add)(float *tile, int x0, int y0, int x1, int y1, float value) {
    float *pixels = __builtin_assume_aligned(tile, 64);
    for (int x = x0 & -GROUP; x < x1; x += GROUP) {
        const int from = x0 - x, to = x1 - x;
        const _Bool whole = from <= 0 && to >= GROUP;
        float *column = __builtin_assume_aligned(pixels + y0 * SL_SPLAT_TILE + x, 64);
        for (int y = y0; whole && y < y1; y++, column += SL_SPLAT_TILE) {
#pragma omp simd aligned(column : 64)
            for (int l = 0; l < GROUP; l++) column[l] += value;
        }
        for (int y = y0; !whole && y < y1; y++, column += SL_SPLAT_TILE) {
#pragma omp simd aligned(column : 64)
            for (int l = 0; l < GROUP; l++) {
                float old = column[l];
                column[l] = ((l >= from) & (l < to)) ? old + value : old;
            }
        }
    }
}

static void SL_KERNEL(halve)(const float *in, int width, int rows, float *out) {
    const ptrdiff_t half = width / 2;
    for (int y = 0; y < rows / 2; y++) {
        const float *restrict low = in + 2 * (ptrdiff_t)y * width, *restrict high = low + width;
        float *restrict sum = out + y * half;
#pragma omp simd
        for (ptrdiff_t x = 0; x < half; x++) sum[x] = (low[2 * x] + low[2 * x + 1]) + (high[2 * x] + high[2 * x + 1]);
    }
}

extern const sl_plane_kernels SL_KERNEL(sl_plane_kernel_table);
const sl_plane_kernels SL_KERNEL(sl_plane_kernel_table) = {SL_KERNEL(add), SL_KERNEL(halve)};
