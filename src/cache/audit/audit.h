/* The error of a picture from values of single pixels, each known twice over: what a probe adds, and what groups of probes say. */
#ifndef SL_CACHE_AUDIT_AUDIT_H
#define SL_CACHE_AUDIT_AUDIT_H

#include "softlux.h"

/* Sums over the values (three a pixel) of some pixels. Groups are independent and see the whole picture each, so the spread of their
 * means tells how far the mean of them all is off. */
typedef struct sl_audit_group {
    double squares;     /* of x - r: each an unbiased estimate, which may be negative */
    double differences; /* x - r */
    double noise;       /* squared error of a half's value */
    double largest;     /* of a pixel's mean squares */
    uint64_t values;
} sl_audit_group;

/* Value x of a picture where two independent estimates of the true one are p and q: E[(x - p)(x - q)] = (x - r)^2. */
static inline double sl_audit_square(double x, double p, double q) { return (x - p) * (x - q); }

/* rel_rmse, bound, least, rmse, mean and noise, from the groups; mean_image: of the picture's own values. */
void sl_audit_conclude(const sl_audit_group *groups, size_t count, double mean_image, sl_error_estimate *estimate);

/* The mean of all values of the pixels whose three are finite, and how many pixels are not so. */
double sl_audit_mean(const float *const planes[3], size_t pixels, uint64_t *nonfinite);

#endif
