/* Comparing a picture with a reference. The definitions are at sl_comparison in softlux.h; here is the
 * arithmetic. All sums run pixel by pixel, R G B within a pixel, in double. */

#include "base/error.h"
#include "base/grow.h"
#include "base/math.h"
#include "base/memory.h"
#include "image/metrics.h"
#include "image/tone.h"

#include <math.h>
#include <stdlib.h>

enum { OUTSIDE_MASK, NOT_FINITE, COMPARED };

typedef struct {
    int width, height;
    size_t pixels;
    const float *image[3], *reference[3];
    unsigned char *state; /* of each pixel: OUTSIDE_MASK, NOT_FINITE or COMPARED */
    double *terms;        /* relative squares of the compared values, then the tone-mapped pictures */
} comparison;

/* ---- what is compared ------------------------------------------------------------------------ */

sl_status sl_image_colour_planes(const sl_image *image, const char *which, const float *planes[3],
                                 sl_error *error) {
    if (sl_picture_planes(image, planes)) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "the %s has neither the channels R, G, B nor Y", which);
}

static sl_status check_size(const sl_image *image, const sl_image *other, const char *what, sl_error *error) {
    if (image->width == other->width && image->height == other->height) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT, "the image has %d x %d pixels, the %s has %d x %d", image->width,
                   image->height, what, other->width, other->height);
}

/* Also for NaN, which differs from itself as a number. */
static bool same_bits(float a, float b) { return sl_float_bits(a) == sl_float_bits(b); }

/* Decides which pixels are compared, and counts what is odd about the values under the mask. */
static void classify(comparison *c, const float *mask, sl_comparison *result) {
    result->identical = true;
    for (size_t i = 0; i < c->pixels; i++) {
        if (mask && !(mask[i] > 0.5f)) continue;
        c->state[i] = COMPARED;
        for (int channel = 0; channel < 3; channel++) {
            float x = c->image[channel][i], r = c->reference[channel][i];
            unsigned bad = (unsigned)!isfinite(x) + (unsigned)!isfinite(r);
            if (bad) c->state[i] = NOT_FINITE;
            result->nonfinite += bad;
            result->negative += (unsigned)(x < 0.0f) + (unsigned)(r < 0.0f);
            if (!same_bits(x, r)) result->identical = false;
        }
        if (c->state[i] == COMPARED) result->values += 3;
    }
}

/* ---- metrics of single values ---------------------------------------------------------------- */

/* a / b, with 0/0 = 0: no difference to a black reference is no relative difference. */
static double ratio(double a, double b) { return a == 0.0 ? 0.0 : a / b; }

static void absolute_metrics(const comparison *c, sl_comparison *result) {
    double squares = 0.0, differences = 0.0, images = 0.0, references = 0.0, largest = 0.0;
    for (size_t i = 0; i < c->pixels; i++) {
        if (c->state[i] != COMPARED) continue;
        for (int channel = 0; channel < 3; channel++) {
            double x = (double)c->image[channel][i], r = (double)c->reference[channel][i], d = x - r;
            squares += d * d;
            differences += d;
            images += x;
            references += r;
            if (fabs(d) > largest) largest = fabs(d);
        }
    }
    double n = (double)result->values;
    result->rmse = sqrt(squares / n);
    result->max_abs = largest;
    result->mean_image = images / n;
    result->mean_reference = references / n;
    result->rel_rmse = ratio(result->rmse, fabs(result->mean_reference));
    result->bias = ratio(differences, fabs(references));
}

static int compare_values(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* The sum of the terms without the `trimmed` largest ones; of terms equal to the smallest that is left out
 * the first ones in order are left out. */
static sl_status trimmed_sum(const double *terms, size_t count, size_t trimmed, double *sum,
                             sl_error *error) {
    double *sorted = sl_copy_of(terms, count, sizeof *sorted);
    if (!sorted) return sl_fail_memory(error, "the trimmed error");
    qsort(sorted, count, sizeof *sorted, compare_values); /* equal terms are the same */
    const double least = trimmed ? sorted[count - trimmed] : INFINITY;
    size_t equal = 0;
    while (equal < trimmed && sorted[count - trimmed + equal] == least) equal++;
    *sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (terms[i] < least || (terms[i] == least && equal == 0)) *sum += terms[i];
        else if (terms[i] == least) equal--;
    }
    sl_free(sorted);
    return SL_OK;
}

static sl_status relative_metrics(const comparison *c, sl_comparison *result, sl_error *error) {
    double floor_squared = 0.01 * result->mean_reference * result->mean_reference, sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < c->pixels; i++) {
        if (c->state[i] != COMPARED) continue;
        for (int channel = 0; channel < 3; channel++) {
            double x = (double)c->image[channel][i], r = (double)c->reference[channel][i];
            c->terms[count] = ratio((x - r) * (x - r), r * r + floor_squared);
            sum += c->terms[count++];
        }
    }
    size_t trimmed = count / 1000;
    result->rel_mse = sum / (double)count;
    sl_status status = trimmed_sum(c->terms, count, trimmed, &sum, error);
    result->rel_mse_trimmed = sum / (double)(count - trimmed);
    return status;
}

/* The variance of a reference that is the mean of two independent halves A and B is estimated by (A-B)^2 / 4.
 * Against the true picture the squared error is therefore smaller than measured by just that. Pixels whose
 * halves are not finite tell nothing. */
static void noise_of_reference(const comparison *c, const sl_image *reference, sl_comparison *result) {
    double floor_squared = 0.01 * result->mean_reference * result->mean_reference, sum = 0.0;
    const float *a[3], *b[3];
    size_t count = 0;
    if (!sl_layer_planes(reference, "even", a) || !sl_layer_planes(reference, "odd", b)) return;
    for (size_t i = 0; i < c->pixels; i++) {
        double term = 0.0;
        if (c->state[i] != COMPARED) continue;
        for (int channel = 0; channel < 3; channel++) {
            double half = 0.5 * ((double)a[channel][i] - (double)b[channel][i]),
                   r = (double)c->reference[channel][i];
            term += ratio(half * half, r * r + floor_squared);
        }
        if (!isfinite(term)) continue;
        sum += term;
        count += 3;
    }
    result->rel_mse_noise = count ? sum / (double)count : 0.0;
}

/* ---- metrics of what is seen ----------------------------------------------------------------- */

/* Exposed and clipped to [0,1]. What is not finite is black, also outside the mask, where neighbours see it.
 */
static void tone_map(const comparison *c, const float *const planes[3], double factor, double *out) {
    for (size_t channel = 0; channel < 3; channel++) {
        for (size_t i = 0; i < c->pixels; i++) {
            double v = (double)planes[channel][i];
            bool black = c->state[i] == NOT_FINITE || !isfinite(v) || v <= 0.0;
            v = black ? 0.0 : v * factor;
            out[channel * c->pixels + i] = v < 1.0 ? v : 1.0;
        }
    }
}

static void shown_metric(const comparison *c, const double *image, const double *reference,
                         sl_comparison *result) {
    double squares = 0.0, sum = 0.0;
    for (size_t i = 0; i < c->pixels; i++) {
        if (c->state[i] != COMPARED) continue;
        for (size_t k = i; k < 3 * c->pixels; k += c->pixels) {
            squares += (image[k] - reference[k]) * (image[k] - reference[k]);
            sum += reference[k];
        }
    }
    double n = (double)result->values;
    result->rel_rmse_shown = ratio(sqrt(squares / n), sum / n);
}

static sl_status perceptual_metrics(const comparison *c, float stops, sl_comparison *result,
                                    sl_error *error) {
    double factor = sl_pow(2.0, (double)stops);
    double *image = c->terms, *reference = c->terms + 3 * c->pixels;
    tone_map(c, c->image, factor, image);
    tone_map(c, c->reference, factor, reference);
    shown_metric(c, image, reference, result);
    unsigned char *use = sl_allocate(c->pixels, 1);
    if (!use) return sl_fail_memory(error, "a comparison");
    for (size_t i = 0; i < c->pixels; i++) use[i] = c->state[i] == COMPARED;
    sl_picture_pair pictures = {c->width, c->height, image, reference, use};
    sl_status status = sl_ssim(&pictures, &result->ssim, error);
    if (status == SL_OK) status = sl_flip(&pictures, &result->flip, error);
    sl_free(use);
    return status;
}

/* ---- the picture of the difference ----------------------------------------------------------- */

/* (x-r)/(|r| + 0.01 |mean r|) of the channel in which it is farthest from 0, over 50 %, in [-1,1]. */
static double signed_difference(const comparison *c, size_t i, double floor_value) {
    double farthest = 0.0;
    for (int channel = 0; channel < 3; channel++) {
        double x = (double)c->image[channel][i], r = (double)c->reference[channel][i];
        double d = ratio(x - r, fabs(r) + floor_value) / 0.5;
        if (fabs(d) > fabs(farthest)) farthest = d;
    }
    return farthest > 1.0 ? 1.0 : farthest < -1.0 ? -1.0 : farthest;
}

static sl_status paint_difference(const comparison *c, double mean_reference, sl_image **difference,
                                  sl_error *error) {
    sl_status status = sl_image_create(c->width, c->height, 3, NULL, difference, error);
    if (status != SL_OK) return status;
    float *r = (*difference)->planes, *g = r + c->pixels, *b = g + c->pixels;
    for (size_t i = 0; i < c->pixels; i++) {
        if (c->state[i] == COMPARED) {
            double d = signed_difference(c, i, 0.01 * fabs(mean_reference));
            r[i] = d > 0.0 ? (float)d : 0.0f;
            b[i] = d < 0.0 ? (float)-d : 0.0f;
        } else if (c->state[i] == NOT_FINITE) {
            g[i] = 1.0f;
        } else {
            r[i] = g[i] = b[i] = 0.1f;
        }
    }
    return SL_OK;
}

/* ---- all together ---------------------------------------------------------------------------- */

static sl_status compare(comparison *c, const sl_compare_options *options, sl_comparison *result,
                         sl_image **difference, sl_error *error) {
    const sl_image *mask = options ? options->mask : NULL;
    float stops = options ? options->exposure_stops : 0.0f;
    if (!isfinite(stops))
        return sl_fail(error, SL_ERROR_USAGE, "the exposure of a comparison must be finite");
    c->state = sl_allocate(c->pixels, 1);
    c->terms = sl_allocate(6 * c->pixels, sizeof *c->terms);
    if (!c->state || !c->terms) return sl_fail_memory(error, "a comparison");
    classify(c, mask ? mask->planes : NULL, result);
    if (result->values == 0)
        return sl_fail(error, SL_ERROR_INPUT, "nothing to compare: no pixel is finite in both images%s",
                       mask ? " and under the mask" : "");
    absolute_metrics(c, result);
    sl_status status = relative_metrics(c, result, error);
    if (status == SL_OK) status = perceptual_metrics(c, stops, result, error);
    if (status == SL_OK && difference)
        status = paint_difference(c, result->mean_reference, difference, error);
    return status;
}

sl_status sl_image_compare(const sl_image *image, const sl_image *reference,
                           const sl_compare_options *options, sl_comparison *result, sl_image **difference,
                           sl_error *error) {
    if (difference) *difference = NULL;
    if (result) *result = (sl_comparison){0};
    if (!image || !reference || !result)
        return sl_fail_null(error, "an image, a reference and a place for what is found");
    sl_status status = check_size(image, reference, "reference", error);
    if (status == SL_OK && options && options->mask) status = check_size(image, options->mask, "mask", error);
    comparison c = {.width = image->width, .height = image->height};
    c.pixels = (size_t)c.width * (size_t)c.height;
    if (status == SL_OK) status = sl_image_colour_planes(image, "image", c.image, error);
    if (status == SL_OK) status = sl_image_colour_planes(reference, "reference", c.reference, error);
    if (status == SL_OK) status = compare(&c, options, result, difference, error);
    if (status == SL_OK) noise_of_reference(&c, reference, result);
    else *result = (sl_comparison){0};
    sl_free(c.state);
    sl_free(c.terms);
    return status;
}
