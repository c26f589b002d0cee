/* From radiance to what an eye sees on the display, and how much of a difference it can tell. */
#include <math.h>

#include "cache/multi_mesh/perception.h"

enum { VALUES = 6 };

/* x^(1/2.2) = x^(5/11) for x in [0, 1]: the product of x^(1/2^k) over the ones among the binary digits of 5/11 = 0.(0111010001) repeated. Roots and
 * products are rounded to nearest, so each is monotone, and their product is: a larger radiance never displays as darker. 30 digits leave an error of
 * 2^-30 in the exponent, 2e-7 in D. Roots wait for each other: several values at once take no longer than one. */
static void display_gamma(const double x[VALUES], double power[VALUES]) {
    static const char digits[] = "0111010001";
    double root[VALUES];
    for (int i = 0; i < VALUES; i++) {
        root[i] = x[i];
        power[i] = 1.0;
    }
    for (int period = 0; period < 3; period++)
        for (const char *d = digits; *d != '\0'; d++) {
#pragma omp simd
            for (int i = 0; i < VALUES; i++) root[i] = sqrt(root[i]);
            if (*d == '0') continue;
#pragma omp simd
            for (int i = 0; i < VALUES; i++) power[i] *= root[i];
        }
}

static void display_levels(const sl_perception *perception, const float radiance[VALUES], float level[VALUES]) {
    double x[VALUES], power[VALUES];
    for (int i = 0; i < VALUES; i++) {
        double exposed = (double)perception->exposure * (double)radiance[i];
        x[i] = exposed > 0.0 ? 1.0 - 1.0 / (1.0 + exposed) : 0.0; /* L / (1 + L), each step monotone */
    }
    display_gamma(x, power);
    for (int i = 0; i < VALUES; i++) level[i] = (float)(255.0 * power[i]);
}

float sl_display_level(const sl_perception *perception, float radiance) {
    float level[VALUES];
    display_levels(perception, (const float[VALUES]){radiance}, level);
    return level[0];
}

float sl_display_threshold(const sl_perception *perception, float level) {
    static const float knot[4][2] = {{0.0f, 10.0f}, {32.0f, 6.0f}, {64.0f, 4.0f}, {128.0f, 3.0f}};
    float threshold = knot[3][1];
    if (!(level > 0.0f)) level = 0.0f;
    for (int i = 0; i < 3; i++) {
        float s = (level - knot[i][0]) / (knot[i + 1][0] - knot[i][0]);
        if (s < 1.0f) {
            threshold = knot[i][1] + s * (knot[i + 1][1] - knot[i][1]);
            break;
        }
    }
    return threshold * perception->threshold_scale;
}

/* Where nothing is tolerated any difference is the largest there is. */
static float contrast_of_levels(const sl_perception *perception, float a, float b) {
    float difference = fabsf(a - b), threshold = sl_display_threshold(perception, fminf(a, b));
    if (difference == 0.0f) return 0.0f;
    return threshold > 0.0f ? fminf(difference / threshold, FLT_MAX) : FLT_MAX;
}

float sl_display_contrast(const sl_perception *perception, sl_rgb a, sl_rgb b) {
    const float radiance[VALUES] = {a.r, a.g, a.b, b.r, b.g, b.b};
    float level[VALUES], most = 0.0f;
    display_levels(perception, radiance, level);
    for (int c = 0; c < 3; c++) most = fmaxf(most, contrast_of_levels(perception, level[c], level[3 + c]));
    return most;
}

void sl_display_colour(const sl_perception *perception, sl_rgb radiance, float level[3]) {
    float levels[VALUES];
    display_levels(perception, (const float[VALUES]){radiance.r, radiance.g, radiance.b}, levels);
    for (int c = 0; c < 3; c++) level[c] = levels[c];
}

/* 118 of 255 is the 18 % grey of sRGB. From D = 255 (L / (1 + L))^(1/2.2): L = x / (1 - x) with x = (118/255)^2.2. */
float sl_perception_exposure(const sl_scene *scene, float mean_radiance) {
    bool light = scene->emitter_count > 0 || scene->light_count > 0 || scene->environment.present;
    if (!light || !(mean_radiance > 0.0f && mean_radiance <= FLT_MAX)) return 1.0f;
    double x = sl_pow(118.0 / 255.0, 2.2), exposure = x / (1.0 - x) / (double)mean_radiance;
    return (float)fmin(fmax(exposure, 1e-30), 1e30);
}
