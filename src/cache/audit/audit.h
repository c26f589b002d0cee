/* The error of a picture from values of single pixels, each known twice over: what a pixel tells, and what
 * some tell of all. */
#pragma once

#include "softlux.h"

/* Means over a pixel's three values x of a picture, where two independent estimates of the true r are p and
 * q. */
typedef struct sl_audit_pixel {
    double square;            /* (x - p)(x - q): an unbiased estimate of (x - r)^2, which may be negative */
    double square_variance;   /* by the noise of p and q */
    double difference;        /* x - (p + q)/2 */
    double difference_variance;
    double noise;             /* (p - q)^2 / 2, of p's and q's own error squared */
    double perfect_deviation; /* what `square` is off by, root mean square, of a picture without error */
    /* for how many pixels it stands: 1 over the probability that it was chosen, >= 1 */
    double weight;
    double unseen;            /* the square of all pixels for which it stands, itself not counted */
    bool masked;              /* it is one of the mask's */
} sl_audit_pixel;

sl_audit_pixel sl_audit_pixel_of(const double x[3], const double p[3], const double q[3], double weight);

/* The same values in two pictures: what the second has of squared error beyond `share` times that of the
 * first. */
sl_audit_pixel sl_audit_pixel_beyond(const double first[3], const double second[3], double share,
                                     const double p[3], const double q[3], double weight);

/* With 95 % confidence the mean of squares of some pixels out of `population` is above 0. */
bool sl_audit_is_positive(const sl_audit_pixel *pixels, size_t count, double population);

/* rel_rmse, bound, least, rmse, mean, noise and resolution. population: of how many pixels these are some;
 * mean_image: of all their values. */
void sl_audit_conclude(const sl_audit_pixel *pixels, size_t count, double population, double mean_image,
                       sl_error_estimate *estimate);

/* Some pixels: how many, and the mean of their values. */
typedef struct sl_audit_part {
    size_t count;
    double mean;
} sl_audit_part;

/* The judged part of a picture: the pixels whose three values are finite; and those of a mask (NULL: all). */
typedef struct sl_audit_view {
    const float *planes[3];
    const float *mask;
    size_t pixels;
    sl_audit_part judged, masked;
    uint64_t nonfinite; /* pixels of the whole picture */
} sl_audit_view;

/* INPUT: neither R, G, B nor Y, or a mask of another size. */
sl_status sl_audit_view_of(const sl_image *image, const sl_image *mask, sl_audit_view *view, sl_error *error);
/* Concludes of all judged pixels and of the mask's, each relative to its own mean, whichever has the larger
 * bound; true: the mask's. The pixels change their order. */
bool sl_audit_conclude_worse(sl_audit_pixel *pixels, size_t count, const sl_audit_view *view,
                             sl_error_estimate *estimate);
bool sl_audit_is_judged(const sl_audit_view *view, size_t pixel);
bool sl_audit_is_masked(const sl_audit_view *view, size_t pixel); /* ... and of the mask */
