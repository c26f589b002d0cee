/* A picture that is the mean of two independent halves a and b, as the reference tracers' are, knows its own error: it has no bias, and
 * the variance of (a + b)/2 is estimated by (a - b)^2 / 4. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/audit/audit.h"
#include "image/metrics.h"

#include <math.h>
#include <stdlib.h>

enum { ACROSS = 8, GROUPS = ACROSS * ACROSS }; /* every eighth pixel of every eighth row is a group */

static sl_status half_planes(const sl_image *image, const float *halves[2][3], sl_error *error) {
    static const char *const names[2][3] = {{"even.R", "even.G", "even.B"}, {"odd.R", "odd.G", "odd.B"}};
    for (int half = 0; half < 2; half++) {
        for (int c = 0; c < 3; c++) {
            halves[half][c] = sl_image_channel(image, names[half][c]);
            if (!halves[half][c]) return sl_fail(error, SL_ERROR_INPUT, "the image has no layer %s: only those of path and bidirectional do", names[half][c]);
        }
    }
    return SL_OK;
}

static void add_pixel(sl_audit_group *g, const float *const planes[3], const float *const halves[2][3], size_t i) {
    double squares = 0.0;
    for (int c = 0; c < 3; c++) {
        if (!isfinite(planes[c][i])) return;
    }
    for (int c = 0; c < 3; c++) {
        double d = 0.5 * ((double)halves[0][c][i] - (double)halves[1][c][i]);
        squares += d * d;
        g->differences += d; /* nothing but noise: 0 in the mean */
    }
    g->squares += squares;
    g->noise += 2.0 * squares;
    if (squares / 3.0 > g->largest) g->largest = squares / 3.0;
    g->values += 3;
}

/* After one sample the second half is black, and means nothing. */
static bool has_two_halves(const sl_image *image) {
    const char *batches = sl_image_metadata(image, "softlux.batches");
    return !batches || strtoull(batches, NULL, 10) >= 2;
}

sl_status sl_error_estimate_from_halves(const sl_image *image, sl_error_estimate *estimate, sl_error *error) {
    const float *planes[3], *halves[2][3];
    *estimate = (sl_error_estimate){0};
    sl_status status = sl_image_colour_planes(image, "image", planes, error);
    if (status == SL_OK) status = half_planes(image, halves, error);
    if (status != SL_OK) return status;
    sl_audit_group *groups = sl_allocate(GROUPS, sizeof *groups);
    if (!groups) return sl_fail_memory(error, "an estimate of an error");
    for (int y = 0; y < image->height; y++) {
        for (int x = 0; x < image->width; x++)
            add_pixel(&groups[y % ACROSS * ACROSS + x % ACROSS], planes, halves, (size_t)y * (size_t)image->width + (size_t)x);
    }
    size_t pixels = (size_t)image->width * (size_t)image->height;
    double mean = sl_audit_mean(planes, pixels, &estimate->nonfinite);
    estimate->probes = pixels;
    sl_audit_conclude(groups, GROUPS, mean, estimate);
    estimate->mean = mean;
    if (!has_two_halves(image)) estimate->rel_rmse = estimate->bound = estimate->rmse = INFINITY, estimate->least = 0.0;
    sl_free(groups);
    return SL_OK;
}
