/* A picture that is the mean of two independent halves a and b, as the reference tracers' are, knows its own
 * error: it has no bias, and the variance of (a + b)/2 is estimated by (a - b)^2 / 4. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/audit/audit.h"

#include <math.h>
#include <stdlib.h>

static sl_status half_planes(const sl_image *image, const float *halves[2][3], sl_error *error) {
    static const char *const names[2][3] = {{"even.R", "even.G", "even.B"}, {"odd.R", "odd.G", "odd.B"}};
    for (int half = 0; half < 2; half++) {
        for (int c = 0; c < 3; c++) {
            halves[half][c] = sl_image_channel(image, names[half][c]);
            if (!halves[half][c])
                return sl_fail(error, SL_ERROR_INPUT,
                               "the image has no layer %s: only those of path and bidirectional do",
                               names[half][c]);
        }
    }
    return SL_OK;
}

/* s = ((a - b)/2)^2 for each value, which has a variance of 2 s^2 at most, were the three channels' noise
 * one. A firefly that no pixel has met may be in any. */
static sl_audit_pixel audit_pixel(const float *const halves[2][3], size_t i) {
    sl_audit_pixel a = {.weight = 1.0};
    for (int c = 0; c < 3; c++) {
        double d = 0.5 * ((double)halves[0][c][i] - (double)halves[1][c][i]);
        a.square += d * d / 3.0;
        a.difference += d / 3.0; /* nothing but noise: 0 in the mean */
    }
    a.square_variance = a.square * a.square;
    a.difference_variance = a.difference * a.difference;
    a.difference = 0.0;
    a.noise = 2.0 * a.square;
    a.unseen = a.square;
    return a;
}

/* After one sample the second half is black, and means nothing. */
static bool has_two_halves(const sl_image *image) {
    const char *batches = sl_image_metadata(image, "softlux.batches");
    return !batches || strtoull(batches, NULL, 10) >= 2;
}

sl_status sl_error_estimate_from_halves(const sl_image *image, const sl_image *mask,
                                        sl_error_estimate *estimate, sl_error *error) {
    const float *halves[2][3];
    sl_audit_view view;
    if (estimate) *estimate = (sl_error_estimate){0};
    if (!image || !estimate) return sl_fail_null(error, "an image and a place for an estimate");
    sl_status status = sl_audit_view_of(image, mask, &view, error);
    if (status == SL_OK) status = half_planes(image, halves, error);
    if (status != SL_OK) return status;
    size_t count = 0;
    sl_audit_pixel *list = sl_allocate_unset(view.judged + 1, sizeof *list);
    if (!list) return sl_fail_memory(error, "an estimate of an error");
    for (size_t i = 0; i < view.pixels; i++) {
        if (sl_audit_is_judged(&view, i)) list[count++] = audit_pixel(halves, i);
    }
    estimate->probes = count;
    estimate->nonfinite = view.nonfinite;
    sl_audit_conclude(list, count, (double)count, view.mean, estimate);
    sl_free(list);
    if (!has_two_halves(image))
        estimate->rel_rmse = estimate->bound = estimate->rmse = INFINITY, estimate->least = 0.0;
    return SL_OK;
}
