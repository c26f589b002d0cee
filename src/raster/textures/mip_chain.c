/* MIP maps (Williams 1983, "Pyramidal parametrics"): each level the mean of the one below over its texels'
 * areas.
 *
 * Of n texels, floor(n/2) larger ones cover the same length. For even n each is two whole texels. For odd n =
 * 2m + 1 each is n/m = 2 + 1/m texels long, so texel i covers
 *
 *      2i            2i + 1      2i + 2          with shares
 *      (m - i)/n     m/n         (i + 1)/n       (their sum is 1)
 *
 * and over all i every fine texel has been used m/n altogether: none is lost, none counts twice, and the mean
 * stays. (Dropping the last row of an odd picture, as is often done, shifts it and changes its mean.) Sums
 * are in double and rounded once. */
#include "raster/textures/textures.h"

#include "base/parallel.h"

enum { ROWS = 16 }; /* a task */

typedef struct {
    int first, count; /* texels */
    double share[3];
} cover;

static cover cover_of(int i, int n) {
    int m = n / 2;
    if (n == 1) return (cover){0, 1, {1.0, 0.0, 0.0}};
    if (n % 2 == 0) return (cover){2 * i, 2, {0.5, 0.5, 0.0}};
    double size = (double)n;
    return (cover){2 * i, 3, {(double)(m - i) / size, (double)m / size, (double)(i + 1) / size}};
}

typedef struct {
    const float *from;
    float *to;
    int width, height;
} halving;

static void average(const halving *h, const cover *column, const cover *row, float *texel) {
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    for (int y = 0; y < row->count; y++) {
        const size_t at = (size_t)(row->first + y) * (size_t)h->width + (size_t)column->first;
        const float *from = h->from + 4 * at;
        for (int x = 0; x < column->count; x++) {
            double share = row->share[y] * column->share[x];
            for (int c = 0; c < 4; c++) sum[c] += share * (double)from[4 * x + c];
        }
    }
    for (int c = 0; c < 4; c++) texel[c] = (float)sum[c];
}

static void halve_rows(void *context, size_t index, unsigned worker) {
    (void)worker;
    const halving *h = context;
    int end = sl_half_size(h->height), width = sl_half_size(h->width), first = (int)index * ROWS;
    for (int y = first; y < end && y < first + ROWS; y++) {
        cover row = cover_of(y, h->height);
        for (int x = 0; x < width; x++) {
            cover column = cover_of(x, h->width);
            average(h, &column, &row, h->to + 4 * ((size_t)y * (size_t)width + (size_t)x));
        }
    }
}

void sl_mip_halve(const float *from, int width, int height, float *to, unsigned threads) {
    halving h = {from, to, width, height};
    size_t tasks = ((size_t)sl_half_size(height) + ROWS - 1) / ROWS;
    sl_parallel_for(tasks > 4 ? sl_thread_count(threads) : 1, tasks, halve_rows, &h);
}
