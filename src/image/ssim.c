/* Structural similarity: Wang, Bovik, Sheikh, Simoncelli, "Image quality assessment: from error visibility to
 * structural similarity", 2004. */
#include "image/metrics.h"

#include "base/error.h"
#include "base/memory.h"
#include "image/color.h"

enum { RADIUS = 5 };

static const double sigma = 1.5;
static const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03; /* (K1 L)^2 and (K2 L)^2 with the range L = 1 */

static void encoded_luminance(const double *rgb, size_t pixels, double *out) {
    for (size_t i = 0; i < pixels; i++) {
        double luminance = 0.2126 * rgb[i] + 0.7152 * rgb[pixels + i] + 0.0722 * rgb[2 * pixels + i];
        out[i] = (double)sl_srgb_encode((float)luminance);
    }
}

/* The five local moments of the two pictures: means, mean squares, mean product. */
enum { MEAN_X, MEAN_Y, SQUARE_X, SQUARE_Y, PRODUCT, MOMENTS };

/* Equation 13. Variances that rounding makes negative are no harm, c2 being much larger. */
static double similarity(const double *const moment[MOMENTS], size_t i) {
    double mx = moment[MEAN_X][i], my = moment[MEAN_Y][i];
    double variance_x = moment[SQUARE_X][i] - mx * mx, variance_y = moment[SQUARE_Y][i] - my * my;
    double covariance = moment[PRODUCT][i] - mx * my;
    return (2.0 * (mx * my) + c1) * (2.0 * covariance + c2) /
           ((mx * mx + my * my + c1) * (variance_x + variance_y + c2));
}

sl_status sl_ssim(const sl_picture_pair *pictures, double *mean, sl_error *error) {
    size_t pixels = (size_t)pictures->width * (size_t)pictures->height;
    double *planes =
        sl_allocate((MOMENTS + 1) * pixels + sl_convolve_margin(pictures->width, RADIUS), sizeof *planes);
    if (!planes) return sl_fail_memory(error, "the structural similarity");
    double *moment[MOMENTS], *scratch = planes + MOMENTS * pixels;
    for (int m = 0; m < MOMENTS; m++) moment[m] = planes + (size_t)m * pixels;
    encoded_luminance(pictures->image, pixels, moment[MEAN_X]);
    encoded_luminance(pictures->reference, pixels, moment[MEAN_Y]);
    for (size_t i = 0; i < pixels; i++) {
        double x = moment[MEAN_X][i], y = moment[MEAN_Y][i];
        moment[SQUARE_X][i] = x * x;
        moment[SQUARE_Y][i] = y * y;
        moment[PRODUCT][i] = x * y;
    }
    double kernel[2 * RADIUS + 1];
    sl_gaussian_kernel(sigma, RADIUS, kernel);
    for (int m = 0; m < MOMENTS; m++)
        sl_convolve(moment[m], pictures->width, pictures->height, kernel, kernel, RADIUS, scratch, moment[m]);
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < pixels; i++) {
        if (!pictures->use[i]) continue;
        sum += similarity((const double *const *)moment, i);
        count += 1.0;
    }
    *mean = sum / count;
    sl_free(planes);
    return SL_OK;
}
