/* From radiance to what an eye sees on the display, and how much of a difference it can tell. */
#include <math.h>

#include "cache/multi_mesh/perception.h"

/* x^(1/2.2) = x^(5/11) for x in [0, 1]: the product of x^(1/2^k) over the ones among the binary digits of 5/11 = 0.(0111010001) repeated. Roots and
 * products are rounded to nearest, so each is monotone, and their product is: a larger radiance never displays as darker. 40 digits leave an error of
 * 2^-40 in the exponent. */
static double display_gamma(double x) {
    static const char digits[] = "0111010001";
    double root = x, power = 1.0;
    for (int period = 0; period < 4; period++)
        for (const char *d = digits; *d != '\0'; d++) {
            root = sqrt(root);
            if (*d == '1') power *= root;
        }
    return power;
}

float sl_display_level(const sl_perception *perception, float radiance) {
    double exposed = (double)perception->exposure * (double)radiance;
    if (!(exposed > 0.0)) return 0.0f;
    return (float)(255.0 * display_gamma(1.0 - 1.0 / (1.0 + exposed))); /* L / (1 + L), each step monotone */
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
static float channel_contrast(const sl_perception *perception, float a, float b) {
    float level_a = sl_display_level(perception, a), level_b = sl_display_level(perception, b);
    float difference = fabsf(level_a - level_b), threshold = sl_display_threshold(perception, fminf(level_a, level_b));
    if (difference == 0.0f) return 0.0f;
    return threshold > 0.0f ? fminf(difference / threshold, FLT_MAX) : FLT_MAX;
}

float sl_display_contrast(const sl_perception *perception, sl_rgb a, sl_rgb b) {
    float red = channel_contrast(perception, a.r, b.r), green = channel_contrast(perception, a.g, b.g);
    return fmaxf(fmaxf(red, green), channel_contrast(perception, a.b, b.b));
}

/* 118 of 255 is the 18 % grey of sRGB. From D = 255 (L / (1 + L))^(1/2.2): L = x / (1 - x) with x = (118/255)^2.2. */
float sl_perception_exposure(const sl_scene *scene, float mean_radiance) {
    bool light = scene->emitter_count > 0 || scene->light_count > 0 || scene->environment.present;
    if (!light || !(mean_radiance > 0.0f && mean_radiance <= FLT_MAX)) return 1.0f;
    double x = sl_pow(118.0 / 255.0, 2.2), exposure = x / (1.0 - x) / (double)mean_radiance;
    return (float)fmin(fmax(exposure, 1e-30), 1e30);
}
