/* Differences of radiance that an eye can tell. */
#include <math.h>

#include "cache/patches/perception.h"

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

float sl_levels_contrast(const sl_perception *perception, float a, float b) {
    float difference = fabsf(a - b), threshold = sl_display_threshold(perception, fminf(a, b));
    if (difference == 0.0f) return 0.0f;
    return threshold > 0.0f ? fminf(difference / threshold, FLT_MAX) : FLT_MAX;
}

float sl_display_contrast(const sl_perception *perception, sl_rgb a, sl_rgb b) {
    const float first[3] = {a.r, a.g, a.b}, second[3] = {b.r, b.g, b.b};
    float most = 0.0f;
    for (int c = 0; c < 3; c++) {
        float level_a = sl_display_level(perception->exposure, first[c]),
              level_b = sl_display_level(perception->exposure, second[c]);
        most = fmaxf(most, sl_levels_contrast(perception, level_a, level_b));
    }
    return most;
}

/* 118 of 255 is the 18 % grey of sRGB. From D = 255 (L / (1 + L))^(1/2.2): L = x / (1 - x) with x =
 * (118/255)^2.2. */
float sl_perception_exposure(const sl_scene *scene, float mean_radiance) {
    bool light = scene->emitter_count > 0 || scene->light_count > 0 || scene->environment.present;
    if (!light || !(mean_radiance > 0.0f && mean_radiance <= FLT_MAX)) return 1.0f;
    double x = sl_pow(118.0 / 255.0, 2.2), exposure = x / (1.0 - x) / (double)mean_radiance;
    return (float)fmin(fmax(exposure, 1e-30), 1e30);
}
