/* Errors against a reference in two independent halves. */
#include <math.h>
#include <stdlib.h>

#include "common.h"

static int descending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

/* Mean of the terms without the largest 0.1 %. */
static double trimmed_mean(double *terms, size_t count) {
    size_t left_out = count / 1000;
    double sum = 0.0;
    qsort(terms, count, sizeof *terms, descending);
    for (size_t i = left_out; i < count; i++) sum += terms[i];
    return count > left_out ? sum / (double)(count - left_out) : 0.0;
}

bench_error bench_compare(const float *x, const bench_reference *reference, const bench_reference *scale) {
    size_t pixels = reference->count, values = 3 * pixels;
    const float *a = reference->half[0], *b = reference->half[1];
    if (!scale) scale = reference;
    bench_error e = {0};
    double *terms = calloc(pixels + 1, sizeof *terms);
    double mean = 0.0, square = 0.0, difference = 0.0, squares = 0.0;
    if (!terms) bench_fail("errors", NULL);
    for (size_t i = 0; i < values; i++)
        mean += 0.5 * ((double)scale->half[0][i] + (double)scale->half[1][i]) / (double)values;
    for (size_t i = 0; i < values; i++) {
        double s = 0.5 * ((double)scale->half[0][i] + (double)scale->half[1][i]), v = (double)x[i];
        double weight = 1.0 / (s * s + 0.01 * mean * mean), product = (v - (double)a[i]) * (v - (double)b[i]);
        double noise = 0.5 * ((double)a[i] - (double)b[i]);
        if (!isfinite(v) || !isfinite(weight)) continue;
        terms[i / 3] += product * weight / 3.0;
        e.noise += noise * noise * weight / (double)values;
        square += product / (double)values;
        difference += (v - 0.5 * ((double)a[i] + (double)b[i])) / (double)values;
    }
    for (size_t i = 0; i < pixels; i++) {
        e.rel_mse += terms[i] / (double)pixels;
        squares += terms[i] * terms[i] / (double)pixels;
    }
    e.rel_mse_spread = pixels ? sqrt(fmax(0.0, squares - e.rel_mse * e.rel_mse) / (double)pixels) : 0.0;
    e.rel_rmse = mean > 0.0 ? sqrt(fmax(0.0, square)) / mean : 0.0;
    e.bias = mean > 0.0 ? difference / mean : 0.0;
    e.noisy = !(e.noise <= 0.1 * e.rel_mse);
    e.trimmed = trimmed_mean(terms, pixels);
    free(terms);
    return e;
}

const char *bench_mse_text(const bench_error *e, char text[32]) {
    snprintf(text, 32, e->noisy ? "(%.2e)" : "%.2e", e->rel_mse);
    return text;
}
