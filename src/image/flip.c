/* LDR-FLIP: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild, "FLIP: a difference evaluator
 * for alternating images", 2020. How different two pictures look when one flips between them, seen from a
 * distance at which a degree is 67 pixels wide. Section numbers are the paper's.
 *
 * The pictures come in linear RGB; the paper's XYZ, YCxCz and L*a*b* are all relative to the D65 white, so X,
 * Y and Z are divided by white's from the start, and YCxCz is y = Y, cx = X - Y, cz = Y - Z: without its
 * factors 116, 500, 200 and offset 16, which commute with convolutions by kernels of sum 1. */
#include "image/metrics.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/vec.h"

#include <math.h>

static const double pixels_per_degree = 67.0;

/* ---- colour spaces --------------------------------------------------------------------------- */

/* From linear Rec. 709 RGB to X, Y, Z over those of white, and back: from the primaries (0.64, 0.33), (0.30,
 * 0.60), (0.15, 0.06) and white (0.3127, 0.3290). Rows sum to 1. */
static const double xyz_of_rgb[3][3] = {
    {0.43388734556603986, 0.3762240091374987, 0.18988864529646141},
    {0.21263900587151036, 0.71516867876775592, 0.072192315360733714},
    {0.01775004007097326, 0.10944762085523849, 0.87280233907378824},
};
static const double rgb_of_xyz[3][3] = {
    {3.0803990906794647, -1.5373831775700935, -0.54301591310937103},
    {-0.92122335886027695, 1.8759675015077206, 0.0452558573525563},
    {0.052873938970364444, -0.20397695888897657, 1.1511030199186121},
};

typedef struct {
    double v[3];
} triple;

static triple transform(const double m[3][3], triple a) {
    triple b;
    for (int i = 0; i < 3; i++) b.v[i] = m[i][0] * a.v[0] + m[i][1] * a.v[1] + m[i][2] * a.v[2];
    return b;
}

/* x^(1/3) for x in [0.0088, 1.1] to the last bits: Newton's iteration from a straight line, off by 80 % at
 * worst. */
static double cube_root(double x) {
    double y = 0.36 + 0.68 * x;
    for (int i = 0; i < 6; i++) y = (2.0 * y + x / (y * y)) * (1.0 / 3.0);
    return y;
}

/* CIE L*a*b*'s compression, with its straight part near black. */
static double lab_curve(double t) {
    const double delta = 6.0 / 29.0;
    return t > delta * delta * delta ? cube_root(t) : t / (3.0 * delta * delta) + 4.0 / 29.0;
}

/* L*a*b* of a linear RGB colour, with Hunt's effect (section 4.1.2): chroma looks weaker where it is darker.
 */
static triple hunt_adjusted_lab(triple rgb) {
    triple xyz = transform(xyz_of_rgb, rgb);
    double fx = lab_curve(xyz.v[0]), fy = lab_curve(xyz.v[1]), fz = lab_curve(xyz.v[2]);
    double lightness = 116.0 * fy - 16.0;
    return (triple){
        {lightness, 0.01 * lightness * (500.0 * (fx - fy)), 0.01 * lightness * (200.0 * (fy - fz))}};
}

/* The HyAB distance (section 4.1.3): city blocks between lightness and chroma, Euclid within chroma. */
static double hyab(triple a, triple b) {
    double da = a.v[1] - b.v[1], db = a.v[2] - b.v[2];
    return fabs(a.v[0] - b.v[0]) + sqrt(da * da + db * db);
}

/* ---- kernels --------------------------------------------------------------------------------- */

enum { COLOR_RADIUS = 10, FEATURE_RADIUS = 9 };

typedef struct {
    double achromatic[2 * COLOR_RADIUS + 1], red_green[2 * COLOR_RADIUS + 1];
    double blue_yellow[2][2 * COLOR_RADIUS + 1], blue_yellow_weight[2];
    double feature_gaussian[2 * FEATURE_RADIUS + 1], edge[2 * FEATURE_RADIUS + 1],
        point[2 * FEATURE_RADIUS + 1];
} kernels;

/* A term a sqrt(pi/b) exp(-pi^2 d^2 / b) of the contrast sensitivity, d in degrees (section 4.1.1), as a
 * Gaussian in pixels. Returns the sum of the whole kernel without its factor a. */
static double sensitivity_kernel(double b, double *kernel) {
    double sum = sl_gaussian_kernel(pixels_per_degree * sqrt(b / 2.0) / SL_PI, COLOR_RADIUS, kernel);
    return sqrt(SL_PI / b) * sum * sum;
}

/* Positive values are scaled to the sum 1, negative ones to -1 (section 4.2). */
static void balance(double *kernel) {
    double positive = 0.0, negative = 0.0;
    for (int i = 0; i <= 2 * FEATURE_RADIUS; i++) *(kernel[i] > 0.0 ? &positive : &negative) += kernel[i];
    for (int i = 0; i <= 2 * FEATURE_RADIUS; i++) kernel[i] /= kernel[i] > 0.0 ? positive : -negative;
}

/* The radii are ceil(3 sigma) of the widest Gaussian: 3 * 67 * sqrt(0.04 / (2 pi^2)) = 9.05 for colour, and
 * 3 * 67 * 0.082 / 2 = 8.24 for features. */
static void make_kernels(kernels *k) {
    sensitivity_kernel(0.0047, k->achromatic);
    sensitivity_kernel(0.0053, k->red_green);
    double wide = 34.1 * sensitivity_kernel(0.04, k->blue_yellow[0]);
    double narrow = 13.5 * sensitivity_kernel(0.025, k->blue_yellow[1]);
    k->blue_yellow_weight[0] = wide / (wide + narrow);
    k->blue_yellow_weight[1] = narrow / (wide + narrow);
    /* section 4.2: the width of an edge that the eye detects, in degrees */
    double sigma = 0.5 * 0.082 * pixels_per_degree;
    sl_gaussian_kernel(sigma, FEATURE_RADIUS, k->feature_gaussian);
    for (int i = 0; i <= 2 * FEATURE_RADIUS; i++) {
        double d = i - FEATURE_RADIUS, g = k->feature_gaussian[i];
        k->edge[i] = -d * g;
        k->point[i] = (d * d / (sigma * sigma) - 1.0) * g;
    }
    balance(k->edge);
    balance(k->point);
}

/* ---- what one picture looks like ------------------------------------------------------------- */

typedef struct {
    double *lab[3];      /* filtered by the contrast sensitivity, Hunt-adjusted */
    double *edge, *point; /* strength of edges and points in the achromatic channel */
} appearance;

typedef struct {
    int width, height;
    size_t pixels;
    kernels kernel;
    double *opponent, *temporary, *scratch;
} workspace;

/* One of y, cx, cz of the whole picture. */
static void opponent_plane(const workspace *w, const double *rgb, int channel, double *out) {
    for (size_t i = 0; i < w->pixels; i++) {
        triple xyz = transform(xyz_of_rgb, (triple){{rgb[i], rgb[w->pixels + i], rgb[2 * w->pixels + i]}});
        out[i] = channel == 0 ? xyz.v[1] : channel == 1 ? xyz.v[0] - xyz.v[1] : xyz.v[1] - xyz.v[2];
    }
}

static void filter_color(const workspace *w, const double *in, const double *kernel, double *out) {
    sl_convolve(in, w->width, w->height, kernel, kernel, COLOR_RADIUS, w->scratch, out);
}

/* The length of the gradient (or of the two second derivatives): derivative along one axis, Gaussian along
 * the other. */
static void detect_features(const workspace *w, const double *y, const double *derivative, double *out) {
    const double *gaussian = w->kernel.feature_gaussian;
    sl_convolve(y, w->width, w->height, derivative, gaussian, FEATURE_RADIUS, w->scratch, out);
    sl_convolve(y, w->width, w->height, gaussian, derivative, FEATURE_RADIUS, w->scratch, w->temporary);
    for (size_t i = 0; i < w->pixels; i++) out[i] = sqrt(out[i] * out[i] + w->temporary[i] * w->temporary[i]);
}


/* Filtered y, cx, cz to L*a*b*; filtering can leave the gamut, so the colour is clamped on the way
 * (section 4.1.1). */
static void perceive_color(const workspace *w, const appearance *a) {
    for (size_t i = 0; i < w->pixels; i++) {
        double y = a->lab[0][i];
        triple rgb = transform(rgb_of_xyz, (triple){{y + a->lab[1][i], y, y - a->lab[2][i]}});
        for (int c = 0; c < 3; c++) rgb.v[c] = sl_clamp_unit(rgb.v[c]);
        triple lab = hunt_adjusted_lab(rgb);
        for (int c = 0; c < 3; c++) a->lab[c][i] = lab.v[c];
    }
}

static void perceive(const workspace *w, const double *rgb, const appearance *a) {
    const kernels *k = &w->kernel;
    opponent_plane(w, rgb, 0, w->opponent);
    filter_color(w, w->opponent, k->achromatic, a->lab[0]);
    detect_features(w, w->opponent, k->edge, a->edge);
    detect_features(w, w->opponent, k->point, a->point);
    opponent_plane(w, rgb, 1, w->opponent);
    filter_color(w, w->opponent, k->red_green, a->lab[1]);
    opponent_plane(w, rgb, 2, w->opponent);
    filter_color(w, w->opponent, k->blue_yellow[0], a->lab[2]);
    filter_color(w, w->opponent, k->blue_yellow[1], w->temporary);
    for (size_t i = 0; i < w->pixels; i++)
        a->lab[2][i] = k->blue_yellow_weight[0] * a->lab[2][i] + k->blue_yellow_weight[1] * w->temporary[i];
    perceive_color(w, a);
}

/* ---- the difference -------------------------------------------------------------------------- */

/* The largest colour distance, between pure green and pure blue, to the power that all distances get. */
static double largest_color_error(double exponent) {
    triple green = hunt_adjusted_lab((triple){{0.0, 1.0, 0.0}}),
           blue = hunt_adjusted_lab((triple){{0.0, 0.0, 1.0}});
    return sl_pow(hyab(green, blue), exponent);
}

/* Section 4.1.3: large distances are compressed, so that those below 0.4 of the largest take [0, 0.95]. */
static double color_error(const appearance *a, const appearance *b, size_t i, double exponent,
                          double largest) {
    const double knee = 0.4 * largest, knee_value = 0.95;
    double distance = hyab((triple){{a->lab[0][i], a->lab[1][i], a->lab[2][i]}},
                           (triple){{b->lab[0][i], b->lab[1][i], b->lab[2][i]}});
    double error = sl_pow(distance, exponent);
    if (error < knee) return knee_value / knee * error;
    return knee_value + (error - knee) / (largest - knee) * (1.0 - knee_value);
}

/* Section 4.2: the feature that differs more, edge or point; in [0,1] since each strength is at most sqrt(2).
 */
static double feature_error(const appearance *a, const appearance *b, size_t i) {
    double edge = fabs(a->edge[i] - b->edge[i]), point = fabs(a->point[i] - b->point[i]);
    return sqrt(sl_clamp_unit((edge > point ? edge : point) * sqrt(0.5)));
}

/* Section 4.3: a feature that differs raises the colour error. */
static double mean_error(const sl_picture_pair *pictures, size_t pixels, const appearance *a,
                         const appearance *b) {
    const double exponent = 0.7, largest = largest_color_error(exponent);
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < pixels; i++) {
        if (!pictures->use[i]) continue;
        sum += sl_clamp_unit(
            sl_pow(sl_clamp_unit(color_error(a, b, i, exponent, largest)), 1.0 - feature_error(a, b, i)));
        count += 1.0;
    }
    return sum / count;
}

sl_status sl_flip(const sl_picture_pair *pictures, double *mean, sl_error *error) {
    size_t pixels = (size_t)pictures->width * (size_t)pictures->height;
    double *planes =
        sl_allocate(13 * pixels + sl_convolve_margin(pictures->width, COLOR_RADIUS), sizeof *planes);
    if (!planes) return sl_fail_memory(error, "the FLIP metric");
    appearance seen[2];
    for (size_t s = 0; s < 2; s++) {
        double *first = planes + 5 * s * pixels;
        seen[s] =
            (appearance){{first, first + pixels, first + 2 * pixels}, first + 3 * pixels, first + 4 * pixels};
    }
    workspace w = {.width = pictures->width, .height = pictures->height, .pixels = pixels};
    w.opponent = planes + 10 * pixels;
    w.temporary = planes + 11 * pixels;
    w.scratch = planes + 12 * pixels;
    make_kernels(&w.kernel);
    perceive(&w, pictures->image, &seen[0]);
    perceive(&w, pictures->reference, &seen[1]);
    *mean = mean_error(pictures, pixels, &seen[0], &seen[1]);
    sl_free(planes);
    return SL_OK;
}
