/* Priorities of patches: display levels, the interpolation error that shows, age, and what is normal among
 * the pixels of a picture. */
#include <float.h>
#include <math.h>

#include "base/math.h"
#include "base/random.h"
#include "cache/shading_cache/priority.h"
#include "shading_cache_support.h"

static const sl_display_curve curve = {.reference = 2.0f};

/* ---- display levels ---- */

static double s_curve(double r) { return (r + 0.1) / (r + 10.0); }

static void levels_are_those_of_the_s_curve(void **state) {
    assert_true(fabs(s_curve(0.0) - 0.01) < 1e-15 && fabs(s_curve(1.0) - 0.1) < 1e-15 &&
                fabs(s_curve(3.0) * s_curve(1.0 / 3.0) - 0.01) < 1e-15);
    for (int exponent = -20; exponent <= 30; exponent++) {
        float y = ldexpf(1.3f, exponent);
        double s = s_curve((double)y / 2.0), wanted = 255.0 * sl_pow((s - 0.01) / 0.99, 1.0 / 2.2);
        assert_true(fabs((double)sl_curve_level_of(&curve, y) - wanted) < 1e-4);
    }
}

static void a_scene_and_its_reference_scaled_alike_look_the_same(void **state) {
    for (float y = 1e-4f; y < 1e4f; y *= 3.0f) {
        sl_display_curve other = {.reference = 64.0f * curve.reference},
                         third = {.reference = 1e-3f * curve.reference};
        assert_true(sl_curve_level_of(&curve, y) == sl_curve_level_of(&other, 64.0f * y));
        assert_true(fabsf(sl_curve_level_of(&curve, y) - sl_curve_level_of(&third, 1e-3f * y)) < 1e-3f);
    }
}

/* ---- the error of a patch ---- */

static void a_patch_from_black_to_very_bright_has_an_error_of_255(void **state) {
    hierarchy h = hierarchy_of(square_scene(), 0);
    uint32_t patch = want_root(&h, 0);
    evaluate_all(&h, 0.0f, 1);
    assert_true(sl_patch_error(h.patches, &curve, patch) == 0.0f);
    evaluate(&h, sl_patch_corner(h.patches, patch, 2), 1e12f, 1);
    assert_true(fabsf(sl_patch_error(h.patches, &curve, patch) - 255.0f) < 1e-3f);
    hierarchy_discard(&h);
}

static void errors_are_those_of_what_leaves_a_surface_not_of_what_arrives(void **state) {
    hierarchy h = hierarchy_of(square_scene(), 0); /* kd = 1/2 */
    uint32_t patch = want_root(&h, 0);
    evaluate_all(&h, 1.0f, 1);
    evaluate(&h, sl_patch_corner(h.patches, patch, 1), 5.0f, 1);
    float wanted =
        sl_curve_level_of(&curve, 2.5f / (float)SL_PI) - sl_curve_level_of(&curve, 0.5f / (float)SL_PI);
    assert_true(fabsf(sl_patch_error(h.patches, &curve, patch) - wanted) < 1e-3f);
    assert_true(sl_vertex_level(h.patches, &curve, sl_patch_corner(h.patches, patch, 1)) ==
                sl_curve_level_of(&curve, 2.5f / (float)SL_PI));
    hierarchy_discard(&h);
}

static sl_scene *lamp_and_gloss_scene(float emission, float specular, float exponent) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_material(&mesh, 0.5f, specular, exponent, 0, emission);
    trace_mesh_quad(&mesh, sl_v3(-1, -1, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), 0);
    return trace_mesh_build(&mesh);
}

static void a_patch_with_a_corner_never_evaluated_has_no_error(void **state) {
    hierarchy h = hierarchy_of(triangle_scene(), 0);
    uint32_t patch = want_root(&h, 0);
    for (int c = 0; c < 3; c++) {
        assert_true(sl_patch_error(h.patches, &curve, patch) == -1.0f &&
                    sl_patch_priority(h.patches, &curve, patch, 9, 8, 8) == -1.0f);
        evaluate(&h, sl_patch_corner(h.patches, patch, c), 1.0f, 1);
    }
    assert_true(sl_patch_error(h.patches, &curve, patch) == 0.0f);
    hierarchy_discard(&h);
}

static void a_vertex_found_to_differ_raises_the_priority_of_all_leaves_around_it_and_of_no_others(
    void **state) {
    hierarchy h = hierarchy_of(square_scene(), 0);
    split_levels(&h, want_root(&h, 0), 2);
    evaluate_all(&h, 1.0f, 1);
    /* its corner 2 is the middle of the square */
    sl_patch_place at = sl_patch_locate(h.patches, 0, 0.4, 0.4);
    uint32_t middle = sl_patch_corner(h.patches, at.patch, 2);
    evaluate(&h, middle, 3.0f, 2);
    int raised = 0;
    for (uint32_t i = 0; i < h.patches->patch_count; i++) {
        if (!sl_patch_is_alive(h.patches, i) || !sl_patch_is_leaf(h.patches, i)) continue;
        bool around = false;
        for (int c = 0; c < 4; c++) around |= sl_patch_corner(h.patches, i, c) == middle;
        assert_true((sl_patch_error(h.patches, &curve, i) > 0.0f) == around);
        raised += around;
    }
    assert_int_equal(raised, 4);
    hierarchy_discard(&h);
}

/* ---- age ---- */

static void only_what_was_evaluated_before_a_change_ages_and_by_its_oldest_corner(void **state) {
    hierarchy h = hierarchy_of(square_scene(), 0);
    uint32_t patch = want_root(&h, 0);
    evaluate_all(&h, 1.0f, 7);
    assert_true(sl_patch_age(h.patches, patch, 20, 0, 2.0f) == 0.0f &&
                sl_patch_age(h.patches, patch, 20, 7, 2.0f) == 0.0f);
    assert_true(sl_patch_age(h.patches, patch, 20, 8, 2.0f) == 26.0f);
    for (int c = 0; c < 3; c++) evaluate(&h, sl_patch_corner(h.patches, patch, c), 1.0f, 9);
    assert_true(sl_patch_age(h.patches, patch, 20, 8, 2.0f) == 26.0f);
    evaluate(&h, sl_patch_corner(h.patches, patch, 3), 1.0f, 9);
    assert_true(sl_patch_age(h.patches, patch, 20, 8, 2.0f) == 0.0f);
    hierarchy_discard(&h);
}

static void of_two_ages_the_larger_counts_and_no_more_than_255_levels(void **state) {
    hierarchy h = hierarchy_of(lamp_and_gloss_scene(0, 0.3f, 50.0f), KEEP_LOBES);
    uint32_t patch = want_root(&h, 0);
    evaluate_all(&h, 1.0f, 5);
    float c = sl_age_constant(sl_root_material(h.primitives, 0));
    float eye = sl_patch_priority(h.patches, &curve, patch, 10, 6, 0),
          object = sl_patch_priority(h.patches, &curve, patch, 10, 4, 8);
    assert_true(eye == 5.0f * c && object == eye &&
                sl_patch_priority(h.patches, &curve, patch, 10, 6, 8) == eye);
    assert_true(sl_patch_priority(h.patches, &curve, patch, 10000, 6, 8) == 255.0f);
    evaluate(&h, sl_patch_corner(h.patches, patch, 0), 1e12f, 5);
    /* on top of the error */
    assert_true(sl_patch_priority(h.patches, &curve, patch, 10000, 6, 8) > 255.0f + 200.0f);
    hierarchy_discard(&h);
}

static void the_glossier_a_material_the_faster_it_ages(void **state) {
    sl_material m = {.diffuse = sl_grey(0.4f)};
    assert_true(sl_age_constant(&m) == 1.0f);
    m.specular = sl_grey(0.3f);
    float last = sl_age_constant(&m);
    assert_true(last == 1.0f); /* exponent 0: nothing to be told apart in it */
    for (m.exponent = 1.0f; m.exponent < 1e6f; m.exponent *= 4.0f) {
        double wanted =
            1.0 + 8.0 * (cbrt(0.3 + 0.2) - cbrt(0.2)) * (1.0 - 1.0 / sqrt(2.0 * (double)m.exponent + 1.0));
        assert_true(sl_age_constant(&m) > last && fabs((double)sl_age_constant(&m) - wanted) < 1e-5);
        last = sl_age_constant(&m);
    }
    m.specular = sl_grey(0.5f);
    assert_true(sl_age_constant(&m) > last);
    sl_material mirror = {.mirror = sl_grey(0.9f)};
    assert_true(fabs((double)sl_age_constant(&mirror) - 1.0 - 8.0 * cbrt(0.9)) < 1e-5);
    sl_material black = {.exponent = 10.0f};
    assert_true(sl_age_constant(&black) == 1.0f);
}

/* ---- normalisation ---- */

enum { MANY = 10001 };

static double mean_total(size_t count, const sl_leaf_priority *leaves) {
    double sum = 0.0, pixels = 0.0;
    for (size_t i = 0; i < count; i++) {
        sum += (0.03 + 0.97 * (double)leaves[i].normal) * (double)leaves[i].pixels;
        pixels += (double)leaves[i].pixels;
    }
    return sum / pixels;
}

static void where_few_pixels_carry_all_error_the_others_keep_no_chance_but_epsilon(void **state) {
    for (int percent = 1; percent <= 5; percent += 4) {
        sl_leaf_priority leaves[1000] = {{0}};
        for (uint32_t i = 0; i < 1000; i++)
            leaves[i] = (sl_leaf_priority){i, 1, i < 10u * (unsigned)percent ? 40.0f : 0.0f, -1.0f};
        sl_priorities_normalise(1000, leaves, false);
        assert_true(leaves[999].normal == 0.0f && leaves[0].normal == 1.0f);
        double mean = mean_total(1000, leaves);
        assert_true(fabs(mean - (percent == 1 ? 0.040 : 0.079)) < 5e-4);
        /* as printed: nearly uniform, whatever the distribution */
        sl_priorities_normalise(1000, leaves, true);
        assert_true(fabs(mean_total(1000, leaves) - 0.515) < 0.01);
        assert_true(leaves[999].normal > 0.47f && leaves[999].normal < 0.49f);
    }
    sl_leaf_priority leaves[1000];
    for (uint32_t i = 0; i < 1000; i++) leaves[i] = (sl_leaf_priority){i, 1, (float)i, 0.0f};
    sl_priorities_normalise(1000, leaves, true);
    assert_true(fabs(mean_total(1000, leaves) - 0.515) < 1e-6);
}

/* mean + 4 sigma of values clipped to `high`, or the largest of them. */
static double next_high(const sl_leaf_priority *leaves, double high) {
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < MANY; i++) {
        double p = fmin((double)leaves[i].priority, high);
        sum += p;
        squares += p * p;
    }
    double mean = sum / MANY;
    return fmin(high, mean + 4.0 * sqrt(squares / MANY - mean * mean));
}

static void one_outlier_does_not_hide_ten_thousand_others(void **state) {
    static sl_leaf_priority leaves[MANY];
    uint64_t key = sl_random_key(11, 0);
    for (uint32_t i = 0; i < MANY; i++)
        leaves[i] = (sl_leaf_priority){i, 1, i ? sl_random_unit(key, i) : 1e6f, 0.0f};
    const double wanted[] = {40098.0, 1608.0, 65.0, 3.3, 1.66};
    double high = 1e6;
    for (int i = 0; i < 5; i++) {
        high = next_high(leaves, high);
        assert_true(fabs(high / wanted[i] - 1.0) < 0.02);
    }
    sl_priorities_normalise(MANY, leaves, false);
    assert_true(leaves[0].normal == 1.0f);
    for (int i = 1; i < MANY; i++)
        assert_true(fabs((double)leaves[i].normal - (double)leaves[i].priority / high) < 0.01);
}

static void equal_priorities_are_all_1_and_no_priorities_all_0(void **state) {
    for (int plain = 0; plain < 2; plain++) {
        for (int k = 0; k < 4; k++) {
            float p = (float[]){0.0f, 0.1f, 1e-30f, 255.0f}[k];
            sl_leaf_priority leaves[7];
            for (uint32_t i = 0; i < 7; i++) leaves[i] = (sl_leaf_priority){i, 3 + i, p, 0.5f};
            sl_priorities_normalise(7, leaves, plain);
            for (int i = 0; i < 7; i++) assert_true(leaves[i].normal == (p > 0.0f ? 1.0f : 0.0f));
        }
    }
    sl_priorities_normalise(0, NULL, false);
}

static void leaves_never_evaluated_come_first_and_leave_the_others_as_they_are(void **state) {
    sl_leaf_priority alone[50], mixed[60];
    uint64_t key = sl_random_key(5, 5);
    for (uint32_t i = 0; i < 50; i++)
        mixed[i] = alone[i] = (sl_leaf_priority){i, 1 + i % 3, 10.0f * sl_random_unit(key, i), 0.0f};
    for (uint32_t i = 50; i < 60; i++) mixed[i] = (sl_leaf_priority){i, 100, -1.0f, 0.0f};
    sl_priorities_normalise(50, alone, false);
    sl_priorities_normalise(60, mixed, false);
    for (int i = 0; i < 60; i++) assert_true(mixed[i].normal == (i < 50 ? alone[i].normal : 1.0f));
    for (int i = 0; i < 60; i++) mixed[i].priority = -1.0f;
    sl_priorities_normalise(60, mixed, false);
    for (int i = 0; i < 60; i++) assert_true(mixed[i].normal == 1.0f);
}

static void priorities_that_are_no_numbers_harm_nothing(void **state) {
    for (int plain = 0; plain < 2; plain++) {
        sl_leaf_priority leaves[MANY / 10];
        for (uint32_t i = 0; i < MANY / 10; i++) leaves[i] = (sl_leaf_priority){i, 1, (float)(i % 100), 0.0f};
        leaves[0].priority = NAN;
        leaves[1].priority = HUGE_VALF;
        leaves[2].priority = FLT_MAX;
        sl_priorities_normalise(MANY / 10, leaves, plain);
        for (int i = 0; i < MANY / 10; i++) assert_true(leaves[i].normal >= 0.0f && leaves[i].normal <= 1.0f);
        assert_true(leaves[0].normal == 1.0f && leaves[1].normal >= leaves[3].normal &&
                    leaves[2].normal == leaves[1].normal);
    }
}

/* ---- large leaves ---- */

static void a_large_leaf_of_one_colour_counts_by_the_root_of_its_area_and_the_mean_of_the_rest(void **state) {
    sl_leaf_priority leaves[4] = {{.pixels = 128, .priority = 0.0f},
                                  {.pixels = 128, .priority = 80.0f},
                                  {.pixels = 32, .priority = 0.0f},
                                  {.pixels = 512, .priority = -1.0f}};
    const double mean = 128.0 * 80.0 / 288.0;
    sl_priorities_raise(4, leaves, 16384);
    assert_true(fabs((double)leaves[0].priority - mean) < 1e-4); /* 1/128 of the picture */
    assert_true(leaves[1].priority == 80.0f);
    assert_true(fabs((double)leaves[2].priority - 0.5 * mean) < 1e-4);
    assert_true(leaves[3].priority == -1.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(levels_are_those_of_the_s_curve),
        cmocka_unit_test(a_scene_and_its_reference_scaled_alike_look_the_same),
        cmocka_unit_test(a_patch_from_black_to_very_bright_has_an_error_of_255),
        cmocka_unit_test(errors_are_those_of_what_leaves_a_surface_not_of_what_arrives),
        cmocka_unit_test(a_patch_with_a_corner_never_evaluated_has_no_error),
        cmocka_unit_test(
            a_vertex_found_to_differ_raises_the_priority_of_all_leaves_around_it_and_of_no_others),
        cmocka_unit_test(only_what_was_evaluated_before_a_change_ages_and_by_its_oldest_corner),
        cmocka_unit_test(of_two_ages_the_larger_counts_and_no_more_than_255_levels),
        cmocka_unit_test(the_glossier_a_material_the_faster_it_ages),
        cmocka_unit_test(where_few_pixels_carry_all_error_the_others_keep_no_chance_but_epsilon),
        cmocka_unit_test(one_outlier_does_not_hide_ten_thousand_others),
        cmocka_unit_test(equal_priorities_are_all_1_and_no_priorities_all_0),
        cmocka_unit_test(leaves_never_evaluated_come_first_and_leave_the_others_as_they_are),
        cmocka_unit_test(priorities_that_are_no_numbers_harm_nothing),
        cmocka_unit_test(a_large_leaf_of_one_colour_counts_by_the_root_of_its_area_and_the_mean_of_the_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
