/* Perceptual metrics on pairs of tone-mapped pictures, and the convolution that they share. */
#pragma once

#include "softlux.h"

/* Two pictures to compare: three planes each of linear R, G, B in [0,1], one behind the other. Only pixels
 * whose `use` is not 0 count in the means; all of them are seen by the neighbourhoods. */
typedef struct sl_picture_pair {
    int width, height;
    const double *image, *reference;
    const unsigned char *use;
} sl_picture_pair;

/* out = in convolved with row_kernel along x and column_kernel along y, 2 radius + 1 taps each; beyond its
 * edges the picture goes on with the value at the edge. `scratch` holds width * height values and
 * sl_convolve_margin(width, radius) more; in and out may be the same. */
void sl_convolve(const double *in, int width, int height, const double *row_kernel,
                 const double *column_kernel, int radius, double *scratch, double *out);
size_t sl_convolve_margin(int width, int radius);
/* kernel[i] = exp(-(i - radius)^2 / (2 sigma^2)), scaled to sum 1. Returns the sum before scaling. */
double sl_gaussian_kernel(double sigma, int radius, double *kernel);

/* Mean structural similarity (Wang et al. 2004, equations 13 to 17) of the sRGB-encoded Rec. 709 luminance:
 * Gaussian window of 11 x 11 pixels and sigma 1.5, C1 = 0.01^2, C2 = 0.03^2, edges continued. 1 for equal
 * pictures. */
sl_status sl_ssim(const sl_picture_pair *pictures, double *mean, sl_error *error);

/* Mean LDR-FLIP (Andersson et al. 2020) at 67 pixels per degree, in [0,1]; 0 for equal pictures. */
sl_status sl_flip(const sl_picture_pair *pictures, double *mean, sl_error *error);

/* The planes R, G, B, or, where one of them is missing, Y three times; which: what an error calls the image.
 */
sl_status sl_image_colour_planes(const sl_image *image, const char *which, const float *planes[3],
                                 sl_error *error);
