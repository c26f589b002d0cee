#include "app/bench/judge.h"
#include "base/error.h"
#include "image/tone.h"

#include <math.h>
#include <string.h>

sl_status sl_judge_noise(const sl_image *reference, double *noise, double *mean, sl_error *error) {
    sl_error_estimate e;
    sl_status status = sl_error_estimate_from_halves(reference, NULL, &e, error);
    *mean = e.mean;
    *noise = e.mean > 0.0 ? e.rmse / e.mean : 0.0;
    return status;
}

typedef struct squares {
    double less_noise; /* the mean of (x-A)(x-B) */
    double deviation;            /* standard, of the first, by the noise of A and B */
} squares;

/* Var (x-A)(x-B) = 2 e^2 s^2 + s^4 where the error is e and A and B have the variance s^2; and that is what
 * (x-R)^2 (A-B)^2 is on average. A pixel's three channels count as one value, since their noise is mostly
 * one. */
static squares squared_errors(const float *const x[3], size_t pixels, const float *const even[3],
                              const float *const odd[3]) {
    double product = 0.0, count = 0.0, variance = 0.0;
    for (size_t i = 0; i < pixels; i++) {
        double spread = 0.0;
        for (int k = 0; k < 3; k++) {
            double a = (double)even[k][i], b = (double)odd[k][i], v = (double)x[k][i], r = 0.5 * (a + b);
            if (!isfinite(v) || !isfinite(r)) continue;
            product += (v - a) * (v - b);
            spread += fabs((v - r) * (a - b));
            count += 1.0;
        }
        variance += spread * spread;
    }
    if (!(count > 0.0)) return (squares){0.0, 0.0};
    return (squares){product / count, sqrt(variance) / count};
}

/* Two standard deviations: 95 % confidence. */
static const double confidence = 2.0;

sl_status sl_judge_quickly(const sl_image *picture, const sl_image *reference, sl_bench_error *e,
                           sl_error *error) {
    const float *x[3], *even[3], *odd[3];
    double mean;
    memset(e, 0, sizeof *e);
    sl_status status = sl_judge_noise(reference, &e->noise, &mean, error);
    bool alike = sl_layer_planes(reference, "even", even) && sl_layer_planes(reference, "odd", odd) &&
                 picture->width == reference->width && picture->height == reference->height &&
                 sl_layer_planes(picture, NULL, x);
    if (status == SL_OK && !alike)
        status =
            sl_fail(error, SL_ERROR_INPUT, "a picture without R, G, B or of another size than its reference");
    if (status != SL_OK || !(mean > 0.0)) return status;
    squares s = squared_errors(x, (size_t)picture->width * (size_t)picture->height, even, odd);
    double doubt = confidence * s.deviation,
           most = sqrt(fmax(s.less_noise, 0.0) + doubt) / mean; /* a lucky draw lowers no bound */
    e->known = true;
    e->lost = !(s.less_noise > doubt);
    e->rel_rmse = e->lost ? most : sqrt(s.less_noise) / mean;
    e->doubt = e->lost ? most : most - e->rel_rmse;
    return SL_OK;
}

sl_status sl_judge(const sl_image *picture, const sl_image *reference, sl_bench_error *e,
                   sl_image **difference, sl_error *error) {
    sl_comparison c;
    sl_status status = sl_judge_quickly(picture, reference, e, error);
    if (status == SL_OK) status = sl_image_compare(picture, reference, NULL, &c, difference, error);
    if (status != SL_OK) return status;
    e->rel_mse = c.rel_mse - c.rel_mse_noise > 0.0 ? c.rel_mse - c.rel_mse_noise : 0.0;
    e->bias = c.bias;
    e->flip = c.flip;
    e->nonfinite = c.nonfinite;
    return SL_OK;
}
