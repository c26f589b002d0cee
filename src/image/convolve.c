/* Separable convolution. Tap by tap over whole rows, so that the inner loops are element-wise and vectorise
 * without changing the order of any sum. */
#include "image/metrics.h"

#include "base/math.h"

#include <string.h>

static int clamp_index(int i, int count) { return i < 0 ? 0 : i >= count ? count - 1 : i; }

static void accumulate(double *restrict sum, const double *restrict row, double weight, int width) {
#pragma omp simd
    for (int x = 0; x < width; x++) sum[x] += weight * row[x];
}

static void convolve_row(const double *in, int width, const double *kernel, int radius, double *padded,
                         double *out) {
    for (int x = 0; x < width + 2 * radius; x++) padded[x] = in[clamp_index(x - radius, width)];
    memset(out, 0, (size_t)width * sizeof *out);
    for (int k = 0; k <= 2 * radius; k++) accumulate(out, padded + k, kernel[k], width);
}

size_t sl_convolve_margin(int width, int radius) { return (size_t)width + 2 * (size_t)radius; }

void sl_convolve(const double *in, int width, int height, const double *row_kernel,
                 const double *column_kernel, int radius, double *scratch, double *out) {
    size_t stride = (size_t)width;
    double *padded = scratch + stride * (size_t)height;
    for (int y = 0; y < height; y++)
        convolve_row(in + stride * (size_t)y, width, row_kernel, radius, padded,
                     scratch + stride * (size_t)y);
    for (int y = 0; y < height; y++) {
        double *sum = out + stride * (size_t)y;
        memset(sum, 0, stride * sizeof *sum);
        for (int k = 0; k <= 2 * radius; k++)
            accumulate(sum, scratch + stride * (size_t)clamp_index(y + k - radius, height), column_kernel[k],
                       width);
    }
}

double sl_gaussian_kernel(double sigma, int radius, double *kernel) {
    double sum = 0.0;
    for (int i = 0; i <= 2 * radius; i++) {
        double d = i - radius;
        kernel[i] = sl_exp(-d * d / (2.0 * sigma * sigma));
        sum += kernel[i];
    }
    for (int i = 0; i <= 2 * radius; i++) kernel[i] /= sum;
    return sum;
}
