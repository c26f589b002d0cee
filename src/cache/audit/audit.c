/* From some pixels to an estimate for all, and its bounds.
 *
 * Pixel i was chosen with probability 1/w_i, independently of the others (Poisson sampling). Those with w = 1
 * are known; the mean of s over the rest is estimated by m = sum w s / sum w (Hajek 1971), with a variance of
 * about
 *
 *     sum [ (w^2 - w) (s - m)^2 + w v ] / (sum w)^2,
 *
 * v being that of s itself by the noise of its two values. With each pixel's share of that as one degree of
 * freedom, so that few pixels with large shares count as few (Satterthwaite 1946), Student's t makes a bound
 * of it.
 *
 * Squared errors have heavy tails: where no pixel was chosen out of those that hold most of the error,
 * nothing in the sample tells. What is missed with a probability above 5 % stands for chosen pixels 3 at most
 * (the rule of three: e^-3 = 5 %); the bound grants it three times the largest square, with its weight, that
 * was met. And an estimate below 0, which noise can make, counts as 0: a lucky draw must not lower the bound.
 */
#include "cache/audit/audit.h"

#include "base/error.h"
#include "base/memory.h"
#include "image/metrics.h"
#include "image/tone.h"

#include <math.h>
#include <stdlib.h>

enum { RULE_OF_THREE = 3 };

/* The 95 % quantile of Student's t, between degrees of freedom in the table by their reciprocals. */
static double student_95(double degrees) {
    static const struct { double reciprocal, t; } table[] = {
        {0.0, 1.645}, {1.0 / 60, 1.671}, {1.0 / 30, 1.697}, {1.0 / 15, 1.753}, {0.1, 1.812},
        {1.0 / 6, 1.943}, {0.2, 2.015}, {0.25, 2.132}, {1.0 / 3, 2.353}, {0.5, 2.920}, {1.0, 6.314},
    };
    enum { LAST = sizeof table / sizeof table[0] - 1 };
    double r = degrees > 1.0 ? 1.0 / degrees : 1.0;
    int i = 1;
    while (i < LAST && table[i].reciprocal < r) i++;
    double f = (r - table[i - 1].reciprocal) / (table[i].reciprocal - table[i - 1].reciprocal);
    return table[i - 1].t + f * (table[i].t - table[i - 1].t);
}

static double square_of(double v) { return v * v; }
static double larger(double a, double b) { return a > b ? a : b; }

/* Var (x-p)(x-q) = 2 (x-r)^2 s2 + s2^2 with s2 for the variance of p; the three channels as if their noise
 * were one. Noise that both pictures' squares share leaves with the difference: with d and d' for their
 * differences from (p + q)/2 and l for the share, Var = 2 (d' - l d)^2 s2 + (1 - l)^2 s2^2. */
sl_audit_pixel sl_audit_pixel_beyond(const double first[3], const double second[3], double share,
                                     const double p[3], const double q[3], double weight) {
    sl_audit_pixel a = {.weight = weight};
    double deviation = 0.0;
    for (int c = 0; c < 3; c++) {
        double r = 0.5 * (p[c] + q[c]), d = second[c] - r - share * (first[c] - r),
               s2 = 0.5 * square_of(p[c] - q[c]);
        a.square +=
            ((second[c] - p[c]) * (second[c] - q[c]) - share * (first[c] - p[c]) * (first[c] - q[c])) / 3.0;
        deviation += sqrt(2.0 * d * d * s2 + square_of((1.0 - share) * s2)) / 3.0;
    }
    a.square_variance = square_of(deviation);
    a.unseen = (weight - 1.0) * larger(-a.square, 0.0);
    return a;
}

sl_audit_pixel sl_audit_pixel_of(const double x[3], const double p[3], const double q[3], double weight) {
    sl_audit_pixel a = sl_audit_pixel_beyond(x, x, 0.0, p, q, weight);
    double deviation = 0.0;
    for (int c = 0; c < 3; c++) {
        double s2 = 0.5 * square_of(p[c] - q[c]); /* an estimate of p's variance */
        a.difference += (x[c] - 0.5 * (p[c] + q[c])) / 3.0;
        a.noise += s2 / 3.0;
        deviation += sqrt(0.5 * s2) / 3.0;
    }
    a.difference_variance = square_of(deviation);
    a.perfect_deviation = a.noise; /* of the square, were the difference 0 */
    a.unseen = (weight - 1.0) * larger(a.square, 0.0);
    return a;
}

/* ---- means, and how far they are off ---- */

typedef struct estimate_of_mean {
    double mean, spread; /* spread: standard error times the quantile */
} estimate_of_mean;

typedef double value_of(const sl_audit_pixel *pixel);
static double the_square(const sl_audit_pixel *a) { return a->square; }
static double the_difference(const sl_audit_pixel *a) { return a->difference; }
static double variance_of_square(const sl_audit_pixel *a) { return a->square_variance; }
static double variance_of_difference(const sl_audit_pixel *a) { return a->difference_variance; }

/* population: of how many pixels those are some. */
static estimate_of_mean weighted_mean(const sl_audit_pixel *pixels, size_t count, double population,
                                      value_of *value, value_of *variance) {
    estimate_of_mean m = {0.0, INFINITY};
    double known = 0.0, known_sum = 0.0, weights = 0.0, sum = 0.0, shares = 0.0, squared_shares = 0.0;
    for (size_t i = 0; i < count; i++) {
        double w = pixels[i].weight, v = value(&pixels[i]);
        if (w > 1.0) {
            weights += w;
            sum += w * v;
        } else {
            known += 1.0;
            known_sum += v;
        }
    }
    double rest = population - known, rest_mean = weights > 0.0 ? sum / weights : 0.0,
           scale = weights > 0.0 ? rest / weights : 0.0;
    if (!(population > 0.0)) return m;
    m.mean = (known_sum + rest * rest_mean) / population;
    if (rest > 0.0 && !(weights > 0.0)) return m;
    for (size_t i = 0; i < count; i++) {
        double w = pixels[i].weight, share = variance(&pixels[i]), s = value(&pixels[i]) - rest_mean;
        if (w > 1.0) share = scale * scale * (w * (w - 1.0) * s * s + w * share);
        shares += share;
        squared_shares += share * share;
    }
    double degrees = squared_shares > 0.0 ? shares / squared_shares * shares : INFINITY;
    m.spread = student_95(degrees) * sqrt(shares) / population;
    return m;
}

static double most_unseen(const sl_audit_pixel *pixels, size_t count) {
    double most = 0.0;
    for (size_t i = 0; i < count; i++) most = larger(most, pixels[i].unseen);
    return most;
}

bool sl_audit_is_positive(const sl_audit_pixel *pixels, size_t count, double population) {
    estimate_of_mean m = weighted_mean(pixels, count, population, the_square, variance_of_square);
    return m.mean - m.spread > RULE_OF_THREE * most_unseen(pixels, count) / larger(population, 1.0);
}

/* As in a comparison: 0/0 is 0, no error of a black picture; anything else to 0 is infinite. What is not a
 * number promises nothing. */
static double ratio(double a, double b) {
    if (a == 0.0) return 0.0;
    double q = b > 0.0 ? a / b : INFINITY;
    return q >= 0.0 ? q : INFINITY;
}

/* Returns the bound of the mean of squares for a picture without error: the noise of the probes alone, and
 * the rule of three over the largest. */
static double perfect_square(const sl_audit_pixel *pixels, size_t count, double population) {
    double variance = 0.0, squares = 0.0, unseen = 0.0;
    for (size_t i = 0; i < count; i++) {
        double share = square_of(pixels[i].weight * pixels[i].perfect_deviation);
        variance += share;
        squares += share * share;
        unseen = larger(unseen, (pixels[i].weight - 1.0) * pixels[i].perfect_deviation);
    }
    double degrees = squares > 0.0 ? variance / squares * variance : INFINITY;
    return (student_95(degrees) * sqrt(variance) + RULE_OF_THREE * unseen) / larger(population, 1.0);
}

void sl_audit_conclude(const sl_audit_pixel *pixels, size_t count, double population, double mean_image,
                       sl_error_estimate *e) {
    double noise = 0.0, weights = 0.0;
    for (size_t i = 0; i < count; i++) {
        noise += pixels[i].weight * pixels[i].noise;
        weights += pixels[i].weight;
    }
    estimate_of_mean square = weighted_mean(pixels, count, population, the_square, variance_of_square);
    estimate_of_mean difference =
        weighted_mean(pixels, count, population, the_difference, variance_of_difference);
    double mean_square = larger(square.mean, 0.0);
    double upper =
        mean_square + square.spread + RULE_OF_THREE * most_unseen(pixels, count) / larger(population, 1.0);
    e->mean = mean_image - difference.mean;
    e->rmse = sqrt(mean_square);
    e->noise = sqrt(noise / larger(weights, 1.0));
    e->rel_rmse = ratio(e->rmse, fabs(e->mean));
    e->bound = ratio(sqrt(upper), fabs(e->mean) - difference.spread);
    e->resolution = ratio(sqrt(perfect_square(pixels, count, population)), fabs(e->mean) - difference.spread);
    e->least = ratio(sqrt(larger(square.mean - square.spread, 0.0)), fabs(e->mean) + difference.spread);
    if (e->nonfinite || !(weights > 0.0)) e->bound = INFINITY;
}

/* Moves the pixels of the mask to the front; how many there are. */
static size_t masked_first(sl_audit_pixel *pixels, size_t count) {
    size_t masked = 0;
    for (size_t i = 0; i < count; i++) {
        if (!pixels[i].masked) continue;
        sl_audit_pixel moved = pixels[i];
        pixels[i] = pixels[masked];
        pixels[masked++] = moved;
    }
    return masked;
}

bool sl_audit_conclude_worse(sl_audit_pixel *pixels, size_t count, const sl_audit_view *view,
                             sl_error_estimate *e) {
    sl_error_estimate masked = *e;
    sl_audit_conclude(pixels, count, (double)view->judged.count, view->judged.mean, e);
    if (view->masked.count == view->judged.count || view->masked.count == 0) return false;
    sl_audit_conclude(pixels, masked_first(pixels, count), (double)view->masked.count, view->masked.mean,
                      &masked);
    bool worse = masked.bound > e->bound || (masked.bound == e->bound && masked.rel_rmse > e->rel_rmse);
    if (worse) *e = masked;
    return worse;
}

static bool is_finite(const float *const planes[3], size_t i) {
    return isfinite(planes[0][i]) && isfinite(planes[1][i]) && isfinite(planes[2][i]);
}

bool sl_audit_is_judged(const sl_audit_view *v, size_t i) { return is_finite(v->planes, i); }

bool sl_audit_is_masked(const sl_audit_view *v, size_t i) {
    return (!v->mask || v->mask[i] > 0.5f) && is_finite(v->planes, i);
}

/* Adds a pixel to the sum that the mean is made of. */
static void add_to(sl_audit_part *part, const sl_audit_view *v, size_t i) {
    part->mean += (double)v->planes[0][i] + (double)v->planes[1][i] + (double)v->planes[2][i];
    part->count++;
}

static void divide(sl_audit_part *part) {
    part->mean = part->count ? part->mean / (3.0 * (double)part->count) : 0.0;
}

sl_status sl_audit_view_of(const sl_image *image, const sl_image *mask, sl_audit_view *v, sl_error *error) {
    *v = (sl_audit_view){.mask = mask ? mask->planes : NULL,
                         .pixels = (size_t)image->width * (size_t)image->height};
    sl_status status = sl_image_colour_planes(image, "image", v->planes, error);
    if (status != SL_OK) return status;
    if (mask && (mask->width != image->width || mask->height != image->height))
        return sl_fail(error, SL_ERROR_INPUT, "the mask has %d x %d pixels, the image %d x %d", mask->width,
                       mask->height, image->width, image->height);
    for (size_t i = 0; i < v->pixels; i++) {
        v->nonfinite += !is_finite(v->planes, i);
        if (sl_audit_is_judged(v, i)) add_to(&v->judged, v, i);
        if (sl_audit_is_masked(v, i)) add_to(&v->masked, v, i);
    }
    divide(&v->judged);
    divide(&v->masked);
    return SL_OK;
}

/* ---- halves ----
 *
 * A picture that is the mean of two independent halves a and b, as the reference tracers' are, knows its own
 * error: it has no bias, and the variance of (a + b)/2 is estimated by (a - b)^2 / 4. */

static sl_status half_planes(const sl_image *image, const float *halves[2][3], sl_error *error) {
    bool even = sl_layer_planes(image, "even", halves[0]);
    if (even && sl_layer_planes(image, "odd", halves[1])) return SL_OK;
    return sl_fail(error, SL_ERROR_INPUT,
                   "the image has no layer %s.R: only those of path and bidirectional do",
                   even ? "odd" : "even");
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
    sl_audit_pixel *list = sl_allocate_unset(view.judged.count + 1, sizeof *list);
    if (!list) return sl_fail_memory(error, "an estimate of an error");
    for (size_t i = 0; i < view.pixels; i++) {
        if (!sl_audit_is_judged(&view, i)) continue;
        list[count] = audit_pixel(halves, i);
        list[count++].masked = sl_audit_is_masked(&view, i);
    }
    estimate->probes = count;
    estimate->nonfinite = view.nonfinite;
    sl_audit_conclude_worse(list, count, &view, estimate);
    sl_free(list);
    if (!has_two_halves(image))
        estimate->rel_rmse = estimate->bound = estimate->rmse = INFINITY, estimate->least = 0.0;
    return SL_OK;
}
