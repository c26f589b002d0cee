/* Whole pictures by the shading cache: the geometry from the first frame on, the path tracer on the same
 * paths, edits. */
#include <math.h>
#include <stdio.h>

#include "unit_test.h"
#include "matched.h"
#include "rendering.h"

static sl_settings cache_settings(int width, int height) {
    sl_settings s = small_settings("shading-cache", width, height);
    return s;
}

static sl_image *path_picture(const sl_scene *scene, const sl_settings *settings, uint32_t spp) {
    sl_settings reference = small_settings("path", settings->width, settings->height);
    reference.transport = "matched:shading-cache";
    reference.shading_cache = settings->shading_cache;
    reference.spp = spp;
    return render(scene, &reference, NULL);
}

static sl_comparison compared(const sl_image *ours, const sl_image *truth, const char *what) {
    sl_comparison c = comparison_of(ours, truth);
    print_message("%s: bias %.3f %%, relRMSE %.2f %%, relMSE less noise %.2e\n", what, 100.0 * c.bias,
                  100.0 * c.rel_rmse, c.rel_mse - c.rel_mse_noise);
    return c;
}

static void the_cornell_box_converges_to_what_paths_find(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = cache_settings(64, 64);
    settings.shading_cache.updates = 3;
    sl_image *truth = path_picture(scene, &settings, 256), *early = render(scene, &settings, NULL);
    settings.shading_cache.updates = 80;
    sl_image *late = render(scene, &settings, NULL);
    assert_sound_picture(early, "early");
    sl_comparison first = compared(early, truth, "3 updates"), second = compared(late, truth, "80 updates");
    assert_true(fabs(second.bias) < 0.02);
    assert_true(second.rel_rmse < 0.5 * first.rel_rmse);
    assert_true(second.rel_rmse < 0.04);
    destroy_pictures(early, late);
    destroy_picture(truth, scene);
}

static void glossy_surfaces_reflect_towards_the_eye(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    sl_settings settings = cache_settings(48, 48);
    settings.shading_cache.updates = 120;
    sl_image *truth = path_picture(scene, &settings, 512), *ours = render(scene, &settings, NULL);
    assert_sound_picture(ours, "glossy");
    sl_comparison c = compared(ours, truth, "glossy");
    assert_true(fabs(c.bias) < 0.03);
    assert_true(c.rel_rmse < 0.12);
    destroy_pictures(ours, truth);
    sl_scene_destroy(scene);
}

/* Moving things are shown where they are before any update. */
static void a_moved_object_is_shown_in_its_place_at_once(void **state) {
    sl_scene *scene = load_scene("scenes/moving-ball.json");
    sl_settings settings = cache_settings(64, 64);
    settings.shading_cache.indirect = SL_INDIRECT_NONE;
    settings.shading_cache.updates = 40;
    sl_method *method = created_method(scene, &settings);
    sl_image *before = finished_picture(method);
    uint64_t shaded = sl_method_counters(method)->value[SL_COUNT_POINTS_SHADED];
    go_to_time(scene, method, 1.0);
    sl_image *after = resolved_picture(method);
    assert_int_equal(sl_method_counters(method)->value[SL_COUNT_POINTS_SHADED], shaded);
    assert_false(same_picture(before, after));
    assert_sound_picture(after, "moved");
    destroy_pictures(before, after);
    destroy_method(method, scene);
}

static void a_still_scene_never_seems_to_change(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = cache_settings(32, 32);
    settings.shading_cache.updates = 200;
    sl_counters counters;
    sl_image_destroy(render(scene, &settings, &counters));
    assert_int_equal(counters.value[SL_COUNT_CHANGES_DETECTED], 0);
    assert_int_equal(counters.value[SL_COUNT_NONFINITE], 0);
    sl_scene_destroy(scene);
}

/* Counts a picture's memory beyond that before its first split (both copies of the display there, the list of
 * visible leaves, too), for each patch that splits have made. */
static void a_patch_takes_at_most_125_bytes_with_both_copies_of_the_display_and_all_else_that_grows(
    void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    sl_settings settings = cache_settings(384, 384);
    settings.shading_cache.indirect = SL_INDIRECT_NONE;
    settings.shading_cache.area_samples = 1;
    settings.shading_cache.points = 1024;
    settings.shading_cache.updates = 200;
    settings.shading_cache.frames_per_update = 1;
    sl_method *method = created_method(scene, &settings);
    assert_false(update(method));
    const uint64_t *count = sl_method_counters(method)->value;
    assert_int_equal(count[SL_COUNT_SPLITS], 0);
    double before = (double)sl_method_memory_bytes(method);
    while (count[SL_COUNT_SPLITS] < 5000 && !update(method)) {}
    double patches = 4.0 * (double)count[SL_COUNT_SPLITS] - (double)count[SL_COUNT_PATCHES_EVICTED];
    double bytes = ((double)sl_method_memory_bytes(method) - before) / patches;
    print_message("%.0f patches, %.1f bytes each\n", patches, bytes);
    assert_true(patches >= 20000.0 && bytes <= 125.0);
    destroy_method(method, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cornell_box_converges_to_what_paths_find),
        cmocka_unit_test(glossy_surfaces_reflect_towards_the_eye),
        cmocka_unit_test(a_moved_object_is_shown_in_its_place_at_once),
        cmocka_unit_test(a_still_scene_never_seems_to_change),
        cmocka_unit_test(
            a_patch_takes_at_most_125_bytes_with_both_copies_of_the_display_and_all_else_that_grows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
