/* The error of a picture from values of single pixels, each known twice over: what a pixel tells, and what some tell of all. */
#ifndef SL_CACHE_AUDIT_AUDIT_H
#define SL_CACHE_AUDIT_AUDIT_H

#include "softlux.h"

/* Means over a pixel's three values x of a picture, where two independent estimates of the true r are p and q. */
typedef struct sl_audit_pixel {
    double square;            /* (x - p)(x - q): an unbiased estimate of (x - r)^2, which may be negative */
    double square_variance;   /* by the noise of p and q */
    double difference;        /* x - (p + q)/2 */
    double difference_variance;
    double noise;             /* (p - q)^2 / 2, of p's and q's own error squared */
    double weight;            /* for how many pixels it stands: 1 over the probability that it was chosen, >= 1 */
    double unseen;            /* the square of all pixels for which it stands, itself not counted */
} sl_audit_pixel;

sl_audit_pixel sl_audit_pixel_of(const double x[3], const double p[3], const double q[3], double weight);

/* rel_rmse, bound, least, rmse, mean and noise. population: of how many pixels these are some; mean_image: of all their values. */
void sl_audit_conclude(const sl_audit_pixel *pixels, size_t count, double population, double mean_image, sl_error_estimate *estimate);

/* The mean of all values of the pixels whose three are finite, and how many pixels are not so. */
double sl_audit_mean(const float *const planes[3], size_t pixels, uint64_t *nonfinite);
bool sl_audit_is_finite(const float *const planes[3], size_t pixel);

#endif
