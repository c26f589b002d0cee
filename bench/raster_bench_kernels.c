#include "raster_bench_kernels.h"

static void SL_KERNEL(triad)(float *restrict out, const float *restrict a, const float *restrict b, float s,
                             size_t count) {
#pragma omp simd
    for (size_t i = 0; i < count; i++) out[i] = a[i] + s * b[i];
}

static void SL_KERNEL(transform)(const float *restrict x, const float *restrict y, const float *restrict z,
                                 const float matrix[4][4], float *restrict out, size_t count) {
    float m[4][4];
    for (int i = 0; i < 16; i++) m[i / 4][i % 4] = matrix[i / 4][i % 4];
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        float cx = ((m[0][0] * x[i] + m[0][1] * y[i]) + m[0][2] * z[i]) + m[0][3];
        float cy = ((m[1][0] * x[i] + m[1][1] * y[i]) + m[1][2] * z[i]) + m[1][3];
        float cw = ((m[3][0] * x[i] + m[3][1] * y[i]) + m[3][2] * z[i]) + m[3][3];
        float over = 1.0f / cw;
        out[i] = cx * over * 500.0f + 500.0f;
        out[count + i] = cy * over * 500.0f + 500.0f;
        out[2 * count + i] = over;
    }
}

extern const bench_kernels SL_KERNEL(bench_kernel_table);
const bench_kernels SL_KERNEL(bench_kernel_table) = {SL_KERNEL(triad), SL_KERNEL(transform)};
