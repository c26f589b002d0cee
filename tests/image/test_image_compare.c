/* The metrics of sl_image_compare(): by hand where a hand can, against plain forms of their papers' formulas
 * (whole 2-D kernels, libm) elsewhere. */
#include <math.h>
#include <string.h>

#include "unit_test.h"
#include "base/random.h"
#include "rendering.h"

static sl_image *make(int width, int height, const float *rgb) {
    sl_image *image = blank_image(width, height, 3);
    if (rgb) memcpy(image->planes, rgb, (size_t)(3 * width * height) * sizeof(float));
    return image;
}

static sl_image *uniform(int width, int height, float r, float g, float b) {
    sl_image *image = make(width, height, NULL);
    float value[3] = {r, g, b};
    for (int i = 0; i < 3 * width * height; i++) image->planes[i] = value[i / (width * height)];
    return image;
}

static sl_image *noise(int width, int height, uint64_t seed) {
    sl_image *image = make(width, height, NULL);
    uint64_t key = sl_random_key(seed, 0);
    for (int i = 0; i < 3 * width * height; i++) image->planes[i] = sl_random_unit(key, (uint64_t)i);
    return image;
}

static sl_comparison compare(const sl_image *image, const sl_image *reference,
                             const sl_compare_options *options) {
    sl_comparison result;
    sl_error error;
    good(sl_image_compare(image, reference, options, &result, NULL, &error), &error);
    return result;
}

static void assert_near(double got, double expected, double tolerance) {
    if (!(fabs(got - expected) <= tolerance)) fail_msg("%.17g, expected %.17g", got, expected);
}

/* ---- single values ---- */

static void an_image_equals_itself_in_every_metric(void **state) {
    sl_image *a = noise(23, 17, 1);
    a->planes[5] = -0.25f;
    a->planes[6] = 1e30f;
    sl_comparison c = compare(a, a, NULL);
    assert_true(c.identical && c.values == 3 * 23 * 17 && c.nonfinite == 0 && c.negative == 2);
    assert_true(c.rmse == 0 && c.rel_rmse == 0 && c.rel_mse == 0 && c.rel_mse_trimmed == 0 &&
                c.max_abs == 0 && c.bias == 0);
    assert_true(c.ssim == 1.0 && c.flip == 0.0 && c.mean_image == c.mean_reference);
    sl_image_destroy(a);
}

static void errors_of_two_pixels_are_those_computed_by_hand(void **state) {
    /* R R G G B B */
    float x[] = {1.5f, 2.0f, 1.0f, 2.0f, 1.0f, 4.0f}, r[] = {1.0f, 2.0f, 1.0f, 2.0f, 1.0f, 5.0f};
    sl_image *a = make(2, 1, x), *b = make(2, 1, r);
    sl_comparison c = compare(a, b, NULL);
    assert_true(c.values == 6 && !c.identical);
    assert_near(c.rmse, sqrt((0.25 + 1.0) / 6.0), 1e-15);
    assert_near(c.mean_reference, 2.0, 1e-15);
    assert_near(c.mean_image, 11.5 / 6.0, 1e-15);
    assert_near(c.rel_rmse, sqrt(1.25 / 6.0) / 2.0, 1e-15);
    assert_near(c.rel_mse, (0.25 / (1.0 + 0.04) + 1.0 / (25.0 + 0.04)) / 6.0, 1e-15);
    assert_true(c.rel_mse_trimmed == c.rel_mse); /* a thousandth of six values is none */
    assert_true(c.max_abs == 1.0);
    assert_near(c.bias, -0.5 / 12.0, 1e-15);
    destroy_pictures(a, b);
}

static void trimming_leaves_out_a_thousandth_of_the_terms(void **state) {
    /* 6000 values: 6 go */
    sl_image *r = uniform(40, 50, 1.0f, 1.0f, 1.0f), *x = uniform(40, 50, 1.5f, 1.5f, 1.5f);
    double usual = 0.25 / 1.01;
    assert_near(compare(x, r, NULL).rel_mse_trimmed, usual, 1e-13); /* all terms equal: five thousand ties */
    size_t spikes[] = {0, 77, 2000, 3333, 5000, 5999};
    for (size_t i = 0; i < 6; i++) x->planes[spikes[i]] = 101.0f + (float)i;
    sl_comparison c = compare(x, r, NULL);
    assert_near(c.rel_mse_trimmed, usual, 1e-13);
    double spiked = usual * 5994.0;
    for (int i = 0; i < 6; i++) spiked += (100.0 + i) * (100.0 + i) / 1.01;
    assert_near(c.rel_mse, spiked / 6000.0, 1e-12);
    x->planes[1234] = 3.0f; /* the seventh largest stays */
    assert_near(compare(x, r, NULL).rel_mse_trimmed, (usual * 5993.0 + 4.0 / 1.01) / 5994.0, 1e-13);
    destroy_pictures(r, x);
}

/* A lamp at twice the white of a screen is as white as one at ten times. */
static void what_is_clipped_to_white_is_no_difference_that_is_shown(void **state) {
    sl_image *r = uniform(4, 4, 0.25f, 0.25f, 0.25f), *x = uniform(4, 4, 0.25f, 0.25f, 0.25f);
    sl_compare_options stop = {.exposure_stops = 1.0f};
    for (int channel = 0; channel < 3; channel++) {
        r->planes[channel * 16 + 5] = 10.0f;
        x->planes[channel * 16 + 5] = 2.0f;
    }
    assert_true(compare(x, r, NULL).rel_rmse_shown == 0.0 && compare(x, r, NULL).rel_rmse > 1.0);
    for (int channel = 0; channel < 3; channel++) x->planes[channel * 16] = 0.5f;
    assert_near(compare(x, r, NULL).rel_rmse_shown, sqrt(0.25 * 0.25 / 16.0) / ((15.0 * 0.25 + 1.0) / 16.0),
                1e-12);
    assert_near(compare(x, r, &stop).rel_rmse_shown, sqrt(0.5 * 0.5 / 16.0) / ((15.0 * 0.5 + 1.0) / 16.0),
                1e-12);
    destroy_pictures(r, x);
}

static void a_black_reference_gives_zero_or_infinity(void **state) {
    sl_image *black = uniform(4, 4, 0, 0, 0), *zero = uniform(4, 4, -0.0f, 0, 0),
             *grey = uniform(4, 4, 0.5f, 0.5f, 0.5f);
    sl_comparison same = compare(zero, black, NULL), other = compare(grey, black, NULL);
    assert_true(!same.identical); /* the bits of -0 are others */
    assert_true(same.rmse == 0 && same.rel_rmse == 0 && same.rel_mse == 0 && same.bias == 0 &&
                same.flip == 0 && same.ssim == 1);
    assert_true(other.rmse == 0.5 && isinf(other.rel_rmse) && isinf(other.rel_mse) && isinf(other.bias));
    destroy_pictures(black, zero);
    sl_image_destroy(grey);
}

static void values_that_are_not_finite_are_counted_and_set_aside(void **state) {
    sl_image *r = noise(12, 9, 2), *x = noise(12, 9, 2);
    size_t pixels = 12 * 9;
    x->planes[3] = NAN;                     /* pixel 3, R */
    x->planes[pixels + 3] = INFINITY;       /* pixel 3, G */
    r->planes[2 * pixels + 50] = -INFINITY; /* pixel 50, B */
    r->planes[60] = x->planes[60] = NAN;    /* pixel 60, in both */
    x->planes[70] = r->planes[70] = -1.0f;
    sl_comparison c = compare(x, r, NULL);
    assert_true(c.nonfinite == 5 && c.negative == 3 && c.values == 3 * (pixels - 3) && !c.identical);
    assert_true(c.rmse == 0 && c.max_abs == 0 && c.flip == 0 && c.ssim == 1); /* the rest is equal */
    sl_comparison self = compare(x, x, NULL);
    assert_true(self.identical && self.nonfinite == 6);
    destroy_pictures(x, r);
}

static void only_pixels_under_the_mask_count(void **state) {
    sl_image *r = uniform(10, 6, 1, 1, 1), *x = uniform(10, 6, 1, 1, 1), *mask = blank_image(10, 6, 1);
    mask->planes[0] = 1.0f;
    mask->planes[1] = 0.75f;
    mask->planes[2] = 0.5f; /* not above 0.5 */
    mask->planes[3] = NAN;
    x->planes[1] = 1.25f;
    x->planes[2] = 7.0f;
    x->planes[3] = NAN;
    x->planes[4] = -3.0f;
    sl_compare_options options = {.mask = mask};
    sl_comparison c = compare(x, r, &options);
    assert_true(c.values == 6 && c.nonfinite == 0 && c.negative == 0 && !c.identical && c.max_abs == 0.25);
    assert_near(c.rmse, sqrt(0.0625 / 6.0), 1e-15);
    mask->planes[1] = 0.0f;
    c = compare(x, r, &options);
    assert_true(c.values == 3 && c.identical && c.rmse == 0.0);
    destroy_pictures(r, x);
    sl_image_destroy(mask);
}

static void what_cannot_be_compared_is_an_error(void **state) {
    sl_image *a = noise(8, 6, 1), *b = noise(8, 5, 1), *nan = uniform(8, 6, NAN, 0, 0), *difference = a;
    sl_compare_options other_mask = {.mask = b}, no_exposure = {.exposure_stops = NAN},
                       empty = {.mask = NULL};
    sl_image *none = uniform(8, 6, 0, 0, 0);
    empty.mask = none;
    sl_comparison result;
    sl_error error;
    assert_int_equal(sl_image_compare(a, b, NULL, &result, &difference, &error), SL_ERROR_INPUT);
    assert_null(difference);
    assert_non_null(strstr(error.message, "8 x 6"));
    assert_non_null(strstr(error.message, "8 x 5"));
    assert_int_equal(sl_image_compare(a, a, &other_mask, &result, NULL, &error), SL_ERROR_INPUT);
    assert_non_null(strstr(error.message, "mask"));
    assert_int_equal(sl_image_compare(a, nan, NULL, &result, NULL, &error), SL_ERROR_INPUT);
    assert_int_equal(sl_image_compare(a, a, &empty, &result, NULL, &error), SL_ERROR_INPUT);
    assert_int_equal(sl_image_compare(a, a, &no_exposure, &result, NULL, NULL), SL_ERROR_USAGE);
    destroy_pictures(a, b);
    destroy_pictures(nan, none);
}

static void the_difference_picture_is_blue_too_dark_and_red_too_bright(void **state) {
    sl_image *r = uniform(3, 2, 1, 1, 1), *x = uniform(3, 2, 1, 1, 1), *mask = uniform(3, 2, 1, 1, 1), *d;
    x->planes[1] = 1.2525f;  /* pixel 1, R: +25 % of 1.01 */
    x->planes[6 + 2] = 0.0f; /* pixel 2, G: beyond -50 % */
    x->planes[12 + 3] = NAN; /* pixel 3, B */
    mask->planes[4] = 0.0f;
    sl_compare_options options = {.mask = mask};
    sl_comparison result;
    assert_int_equal(sl_image_compare(x, r, &options, &result, &d, NULL), SL_OK);
    float expected[6][3] = {{0, 0, 0}, {0.5f, 0, 0}, {0, 0, 1}, {0, 1, 0}, {0.1f, 0.1f, 0.1f}, {0, 0, 0}};
    assert_true(d->width == 3 && d->height == 2 && d->channels == 3);
    for (int i = 0; i < 6; i++) {
        for (int c = 0; c < 3; c++) assert_near((double)d->planes[6 * c + i], (double)expected[i][c], 1e-6);
    }
    destroy_pictures(r, x);
    destroy_pictures(mask, d);
}

/* ---- structural similarity ---- */

static double encode(double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055; }

static double clamp_unit(double x) { return fmin(fmax(x, 0.0), 1.0); }

static int edge(int i, int count) { return i < 0 ? 0 : i >= count ? count - 1 : i; }

static double plain_luminance(const sl_image *image, double factor, int x, int y) {
    int w = image->width, n = w * image->height, i = edge(y, image->height) * w + edge(x, w);
    const float *p = image->planes;
    return encode(0.2126 * clamp_unit((double)p[i] * factor) +
                  0.7152 * clamp_unit((double)p[n + i] * factor) +
                  0.0722 * clamp_unit((double)p[2 * n + i] * factor));
}

static double plain_ssim(const sl_image *a, const sl_image *b, double factor) {
    double total = 0.0;
    for (int y = 0; y < a->height; y++) {
        for (int x = 0; x < a->width; x++) {
            double sum = 0, mx = 0, my = 0, vx = 0, vy = 0, cov = 0;
            for (int pass = 0; pass < 2; pass++) {
                for (int dy = -5; dy <= 5; dy++) {
                    for (int dx = -5; dx <= 5; dx++) {
                        double weight = exp(-(dx * dx + dy * dy) / (2.0 * 1.5 * 1.5));
                        double p = plain_luminance(a, factor, x + dx, y + dy),
                               q = plain_luminance(b, factor, x + dx, y + dy);
                        if (pass == 0) {
                            sum += weight;
                            mx += weight * p;
                            my += weight * q;
                        } else {
                            vx += weight * (p - mx) * (p - mx) / sum;
                            vy += weight * (q - my) * (q - my) / sum;
                            cov += weight * (p - mx) * (q - my) / sum;
                        }
                    }
                }
                if (pass == 0) mx /= sum, my /= sum;
            }
            double c1 = 1e-4, c2 = 9e-4;
            total += (2 * mx * my + c1) * (2 * cov + c2) / ((mx * mx + my * my + c1) * (vx + vy + c2));
        }
    }
    return total / (a->width * a->height);
}

static void ssim_is_wangs_formula(void **state) {
    sl_image *a = noise(19, 14, 3), *b = noise(19, 14, 4);
    for (int i = 0; i < 3 * 19 * 14; i++) b->planes[i] = 0.7f * a->planes[i] + 0.5f * b->planes[i] - 0.1f;
    for (int stops = -2; stops <= 1; stops++) {
        sl_compare_options options = {.exposure_stops = (float)stops};
        assert_near(compare(b, a, &options).ssim, plain_ssim(b, a, exp2(stops)), 1e-6);
    }
    destroy_pictures(a, b);
}

/* ---- FLIP, as plainly as the paper writes it ---- */

typedef struct {
    double v[3];
} triple;

/* The published matrix of sRGB: four to five digits, hence the tolerance of the comparison below. */
static triple xyz_of_rgb(triple c) {
    return (triple){{0.4124564 * c.v[0] + 0.3575761 * c.v[1] + 0.1804375 * c.v[2],
                     0.2126729 * c.v[0] + 0.7151522 * c.v[1] + 0.0721750 * c.v[2],
                     0.0193339 * c.v[0] + 0.1191920 * c.v[1] + 0.9503041 * c.v[2]}};
}

static triple rgb_of_xyz(triple c) {
    return (triple){{3.2404542 * c.v[0] - 1.5371385 * c.v[1] - 0.4985314 * c.v[2],
                     -0.9692660 * c.v[0] + 1.8760108 * c.v[1] + 0.0415560 * c.v[2],
                     0.0556434 * c.v[0] - 0.2040259 * c.v[1] + 1.0572252 * c.v[2]}};
}

static const triple white = {{0.95047, 1.0, 1.08883}};

static triple ycxcz(triple rgb) {
    triple c = xyz_of_rgb(rgb);
    double x = c.v[0] / white.v[0], y = c.v[1] / white.v[1], z = c.v[2] / white.v[2];
    return (triple){{116 * y - 16, 500 * (x - y), 200 * (y - z)}};
}

static double compress(double t) {
    return t > pow(6.0 / 29.0, 3.0) ? cbrt(t) : t / (3 * pow(6.0 / 29.0, 2.0)) + 4.0 / 29.0;
}

static triple hunt_lab(triple rgb) {
    triple c = xyz_of_rgb(rgb);
    double x = compress(c.v[0] / white.v[0]), y = compress(c.v[1] / white.v[1]),
           z = compress(c.v[2] / white.v[2]);
    double l = 116 * y - 16;
    return (triple){{l, 0.01 * l * 500 * (x - y), 0.01 * l * 200 * (y - z)}};
}

static triple pixel(const sl_image *image, int x, int y) {
    int w = image->width, n = w * image->height, i = edge(y, image->height) * w + edge(x, w);
    return (triple){{clamp_unit((double)image->planes[i]), clamp_unit((double)image->planes[n + i]),
                     clamp_unit((double)image->planes[2 * n + i])}};
}

/* The contrast sensitivity of channel c at a distance of (dx, dy) pixels. */
static double sensitivity(int c, int dx, int dy) {
    const double a1[3] = {1, 1, 34.1}, b1[3] = {0.0047, 0.0053, 0.04}, pi = 3.14159265358979323846;
    double z = (dx * dx + dy * dy) / (67.0 * 67.0), s = a1[c] * sqrt(pi / b1[c]) * exp(-pi * pi * z / b1[c]);
    return c == 2 ? s + 13.5 * sqrt(pi / 0.025) * exp(-pi * pi * z / 0.025) : s;
}

static triple plain_color(const sl_image *image, int x, int y) {
    triple sum = {{0, 0, 0}}, weights = {{0, 0, 0}};
    for (int dy = -10; dy <= 10; dy++) {
        for (int dx = -10; dx <= 10; dx++) {
            triple p = ycxcz(pixel(image, x + dx, y + dy));
            for (int c = 0; c < 3; c++) {
                sum.v[c] += sensitivity(c, dx, dy) * p.v[c];
                weights.v[c] += sensitivity(c, dx, dy);
            }
        }
    }
    for (int c = 0; c < 3; c++) sum.v[c] /= weights.v[c];
    double n = (sum.v[0] + 16) / 116;
    triple xyz = {{(n + sum.v[1] / 500) * white.v[0], n, (n - sum.v[2] / 200) * white.v[2]}},
           rgb = rgb_of_xyz(xyz);
    for (int c = 0; c < 3; c++) rgb.v[c] = clamp_unit(rgb.v[c]);
    return hunt_lab(rgb);
}

static double feature_kernel(int point, int d, int across) {
    double sd = 0.5 * 0.082 * 67.0, g = exp(-(d * d + across * across) / (2 * sd * sd));
    return point ? (d * d / (sd * sd) - 1) * g : -d * g;
}

static double plain_feature(const sl_image *image, int x, int y, int point) {
    double plus = 0, minus = 0, gx = 0, gy = 0;
    for (int i = -9; i <= 9; i++) {
        for (int j = -9; j <= 9; j++) {
            double k = feature_kernel(point, i, j);
            *(k > 0 ? &plus : &minus) += fabs(k);
        }
    }
    for (int dy = -9; dy <= 9; dy++) {
        for (int dx = -9; dx <= 9; dx++) {
            double luminance = (ycxcz(pixel(image, x + dx, y + dy)).v[0] + 16) / 116;
            double kx = feature_kernel(point, dx, dy), ky = feature_kernel(point, dy, dx);
            gx += luminance * kx / (kx > 0 ? plus : minus);
            gy += luminance * ky / (ky > 0 ? plus : minus);
        }
    }
    return hypot(gx, gy);
}

static double distance(triple a, triple b) {
    return fabs(a.v[0] - b.v[0]) + hypot(a.v[1] - b.v[1], a.v[2] - b.v[2]);
}

static double plain_color_error(triple a, triple b) {
    double cmax = pow(distance(hunt_lab((triple){{0, 1, 0}}), hunt_lab((triple){{0, 0, 1}})), 0.7);
    double e = pow(distance(a, b), 0.7), knee = 0.4 * cmax;
    return e < knee ? 0.95 / knee * e : 0.95 + (e - knee) / (cmax - knee) * 0.05;
}

static double plain_flip(const sl_image *a, const sl_image *b) {
    double sum = 0;
    for (int y = 0; y < a->height; y++) {
        for (int x = 0; x < a->width; x++) {
            double color = plain_color_error(plain_color(a, x, y), plain_color(b, x, y));
            double edges = fabs(plain_feature(a, x, y, 0) - plain_feature(b, x, y, 0));
            double points = fabs(plain_feature(a, x, y, 1) - plain_feature(b, x, y, 1));
            sum += pow(color, 1 - sqrt(fmax(edges, points) / sqrt(2.0)));
        }
    }
    return sum / (a->width * a->height);
}

static void flip_is_the_papers_formula(void **state) {
    sl_image *a = noise(14, 11, 7), *b = noise(14, 11, 8);
    assert_near(compare(a, b, NULL).flip, plain_flip(a, b), 2e-4);
    for (int i = 0; i < 3 * 14 * 11; i++) { /* an edge against a ramp, with saturated colours */
        a->planes[i] = i % 14 < 7 ? 0.05f : i < 154 ? 1.0f : 0.3f;
        b->planes[i] = (float)(i % 14) / 13.0f * (i < 154 ? 0.2f : 0.9f);
    }
    double expected = plain_flip(a, b);
    assert_true(expected > 0.1 && expected < 0.95);
    assert_near(compare(a, b, NULL).flip, expected, 2e-4);
    destroy_pictures(a, b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_image_equals_itself_in_every_metric),
        cmocka_unit_test(errors_of_two_pixels_are_those_computed_by_hand),
        cmocka_unit_test(trimming_leaves_out_a_thousandth_of_the_terms),
        cmocka_unit_test(a_black_reference_gives_zero_or_infinity),
        cmocka_unit_test(values_that_are_not_finite_are_counted_and_set_aside),
        cmocka_unit_test(only_pixels_under_the_mask_count),
        cmocka_unit_test(what_cannot_be_compared_is_an_error),
        cmocka_unit_test(the_difference_picture_is_blue_too_dark_and_red_too_bright),
        cmocka_unit_test(ssim_is_wangs_formula),
        cmocka_unit_test(what_is_clipped_to_white_is_no_difference_that_is_shown),
        cmocka_unit_test(flip_is_the_papers_formula),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
