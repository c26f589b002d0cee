/* Differences that an eye can tell: display levels, the threshold map. */
#include <float.h>
#include <math.h>

#include "unit_test.h"
#include "base/random.h"
#include "cache/patches/perception.h"
#include "trace_scenes.h"

static const sl_perception plain = {.exposure = 1.0f, .threshold_scale = 1.0f};

static double exact_level(double exposed) { return 255.0 * sl_pow(exposed / (1.0 + exposed), 1.0 / 2.2); }

static void levels_are_those_of_the_tone_map(void **state) {
    for (int exponent = -20; exponent <= 30; exponent++)
        for (uint64_t i = 0; i < 50; i++) {
            float radiance =
                ldexpf(1.0f + sl_random_unit(sl_random_key(3, (uint64_t)(exponent + 64)), i), exponent);
            for (float exposure = 0.25f; exposure < 20.0f; exposure *= 5.0f) {
                double wanted = exact_level((double)exposure * (double)radiance);
                assert_true(fabs((double)sl_display_level(exposure, radiance) - wanted) < 1e-4);
            }
        }
}

static void what_is_no_radiance_is_black_and_infinity_white(void **state) {
    static const float black[] = {0.0f, -0.0f, -1.0f, -INFINITY, NAN};
    for (size_t i = 0; i < 5; i++) assert_true(sl_display_level(1.0f, black[i]) == 0.0f);
    assert_true(sl_display_level(1.0f, INFINITY) == 255.0f && sl_display_level(1.0f, FLT_MAX) == 255.0f);
    assert_true(sl_display_level(1e30f, FLT_MAX) == 255.0f && sl_display_level(0.0f, 1.0f) == 0.0f);
}

static void thresholds_run_linearly_between_their_knots(void **state) {
    static const float knots[][2] = {{0, 10},  {16, 8},  {32, 6},  {48, 5},  {64, 4},   {96, 3.5f},
                                     {128, 3}, {200, 3}, {255, 3}, {-5, 10}, {NAN, 10}, {INFINITY, 3}};
    for (size_t i = 0; i < sizeof knots / sizeof knots[0]; i++) {
        assert_true(fabsf(sl_display_threshold(&plain, knots[i][0]) - knots[i][1]) < 1e-5f);
        assert_true(fabsf(sl_display_threshold(&(sl_perception){1.0f, 0.5f}, knots[i][0]) -
                          0.5f * knots[i][1]) < 1e-5f);
    }
}

/* Below 10 of 255 every pair of levels is within the threshold. */
static void nobody_tells_levels_below_10_apart(void **state) {
    float brightest = 0.0f;
    for (float radiance = 0.0f; radiance < 0.01f; radiance += 1e-6f)
        if (sl_display_level(1.0f, radiance) < 10.0f) brightest = radiance;
    /* T(D) = 10 - D / 8 there, more than 10 - D. */
    assert_true(brightest > 1e-4f);
    for (uint64_t i = 0; i < 2000; i++) {
        sl_rgb a = {brightest * sl_random_unit(sl_random_key(1, 1), 2 * i), 0, brightest},
               b = {brightest * sl_random_unit(sl_random_key(1, 1), 2 * i + 1), brightest, 0};
        assert_true(sl_display_contrast(&plain, a, b) <= 1.0f);
    }
}

static void contrast_is_the_worst_channel_over_the_darker_ones_threshold(void **state) {
    sl_rgb a = {0.2f, 0.5f, 0.0f}, b = {0.2f, 0.6f, 0.001f};
    double green = (exact_level(0.6) - exact_level(0.5)) / 3.0, blue = exact_level(0.001) / 10.0;
    assert_true(fabs((double)sl_display_contrast(&plain, a, b) - fmax(green, blue)) < 1e-4);
    assert_true(sl_display_contrast(&plain, a, b) == sl_display_contrast(&plain, b, a));
    assert_true(sl_display_contrast(&plain, a, a) == 0.0f);
    assert_true(sl_display_contrast(&plain, sl_grey(NAN), sl_grey(0.0f)) == 0.0f);
    assert_true(fabsf(sl_display_contrast(&plain, sl_grey(INFINITY), sl_grey(0.0f)) - 25.5f) < 1e-4f);
    sl_perception strict = {1.0f, 0.0f};
    assert_true(sl_display_contrast(&strict, a, b) == FLT_MAX && sl_display_contrast(&strict, a, a) == 0.0f);
}

static void the_exposure_turns_the_mean_into_middle_grey(void **state) {
    for (int lit = 0; lit < 2; lit++) {
        trace_mesh m = trace_mesh_begin();
        trace_mesh_material(&m, 0.5f, 0, 0, 0, lit ? 2.0f : 0.0f);
        trace_mesh_quad(&m, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
        sl_scene *scene = trace_mesh_build(&m);
        static const float means[] = {1e-9f, 0.01f, 3.0f, 1e7f};
        for (size_t i = 0; i < 4; i++) {
            sl_perception p = {sl_perception_exposure(scene, means[i]), 1.0f};
            if (lit) assert_true(fabsf(sl_display_level(p.exposure, means[i]) - 118.0f) < 1e-3f);
            else assert_true(p.exposure == 1.0f);
        }
        static const float none[] = {0.0f, -1.0f, NAN, INFINITY};
        for (size_t i = 0; i < 4; i++) assert_true(sl_perception_exposure(scene, none[i]) == 1.0f);
        assert_true(isfinite(sl_perception_exposure(scene, 1e-45f)) &&
                    sl_perception_exposure(scene, FLT_MAX) > 0.0f);
        sl_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(levels_are_those_of_the_tone_map),
        cmocka_unit_test(what_is_no_radiance_is_black_and_infinity_white),
        cmocka_unit_test(thresholds_run_linearly_between_their_knots),
        cmocka_unit_test(nobody_tells_levels_below_10_apart),
        cmocka_unit_test(contrast_is_the_worst_channel_over_the_darker_ones_threshold),
        cmocka_unit_test(the_exposure_turns_the_mean_into_middle_grey),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
