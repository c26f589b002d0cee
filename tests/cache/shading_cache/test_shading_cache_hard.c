/* Hard cases of the whole shading cache: nothing to be seen, light that goes away, eyes in awkward places,
 * and an end to it all; with things that move the same bits at any number of threads. */
#include <math.h>
#include <string.h>

#include "unit_test.h"
#include "rendering.h"

static const char room[] = "scenes/cornell.json";

static sl_settings cache_settings(int width, int height) {
    sl_settings settings = small_settings("shading-cache", width, height);
    settings.shading_cache.indirect = SL_INDIRECT_NONE;
    return settings;
}

static uint64_t to_the_end(sl_method *method) {
    sl_progress progress = {0};
    while (!progress.done) assert_int_equal(sl_method_update(method, &progress, NULL), SL_OK);
    return progress.batches;
}

static void look(sl_scene *scene, float x, float y, float z, float to_x, float to_y, float to_z) {
    assert_int_equal(sl_scene_set_camera(scene, (const float[]){x, y, z}, (const float[]){to_x, to_y, to_z},
                                         (const float[]){0, 1, 0}, 0.7f, NULL),
                     SL_OK);
}

static float brightest(sl_method *method) {
    float most = 0.0f;
    sl_image *image = resolved_picture(method);
    for (int i = 0; i < 3 * image->width * image->height; i++) {
        assert_true(isfinite(image->planes[i]) && image->planes[i] >= 0.0f);
        most = fmaxf(most, image->planes[i]);
    }
    sl_image_destroy(image);
    return most;
}

static void who_sees_nothing_asks_for_nothing(void **state) {
    sl_scene *scene = load_scene(room);
    sl_settings settings = cache_settings(24, 24);
    look(scene, 278, 273, -800, 278, 273, -9000);
    sl_method *method = created_method(scene, &settings);
    assert_int_equal(to_the_end(method), 1); /* there is nothing to do, and that is found out at once */
    assert_true(brightest(method) == 0.0f);
    assert_int_equal(sl_method_counters(method)->value[SL_COUNT_POINTS_SHADED], 0);
    look(scene, 278, 273, -800, 278, 273, 0);
    assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
    assert_true(to_the_end(method) > 1);
    assert_true(brightest(method) > 0.1f);
    assert_true(sl_method_counters(method)->value[SL_COUNT_POINTS_SHADED] > 0);
    destroy_method(method, scene);
}

static void refinement_comes_to_an_end_by_itself(void **state) {
    sl_scene *scene = load_scene(room);
    sl_settings settings = cache_settings(16, 16);
    settings.shading_cache.updates = 1000000;
    settings.shading_cache.area_samples = 4;
    settings.shading_cache.stop_size = 2.0;
    sl_method *method = created_method(scene, &settings);
    uint64_t updates = to_the_end(method);
    assert_true(updates > 5 && updates < 5000);
    uint64_t points = sl_method_counters(method)->value[SL_COUNT_POINTS_SHADED];
    assert_true(points > 100);
    assert_true(update(method));
    assert_int_equal(sl_method_counters(method)->value[SL_COUNT_POINTS_SHADED], points);
    destroy_method(method, scene);
}

enum { FRAMES = 6 };

static void play(const char *path, unsigned threads, sl_image *frame[FRAMES], sl_counters *counters) {
    sl_scene *scene = load_scene(path);
    sl_settings settings = small_settings("shading-cache", 32, 32);
    settings.threads = threads;
    settings.shading_cache.indirect_samples = 4;
    settings.shading_cache.area_samples = 8;
    settings.shading_cache.frames_per_update = 2;
    sl_method *method = created_method(scene, &settings);
    for (int i = 0; i < FRAMES; i++) {
        go_to_time(scene, method, 0.4 * i);
        for (int k = 0; k < 5; k++) update(method);
        frame[i] = resolved_picture(method);
    }
    *counters = *sl_method_counters(method);
    destroy_method(method, scene);
}

static void with_things_that_move_bits_do_not_depend_on_threads(void **state) {
    const char *const path[] = {"scenes/moving-ball.json", "scenes/moving-light.json", "scenes/walk.json"};
    for (int s = 0; s < 3; s++) {
        sl_image *one[FRAMES], *other[FRAMES];
        sl_counters counters, others;
        play(path[s], 1, one, &counters);
        for (unsigned threads = 2; threads <= 4; threads += 2) {
            play(path[s], threads, other, &others);
            assert_memory_equal(&counters, &others, sizeof counters);
            for (int i = 0; i < FRAMES; i++) {
                assert_true(same_picture(one[i], other[i]));
                sl_image_destroy(other[i]);
            }
        }
        assert_false(same_picture(one[0], one[FRAMES - 1]));
        for (int i = 0; i < FRAMES; i++) sl_image_destroy(one[i]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(who_sees_nothing_asks_for_nothing),
        cmocka_unit_test(refinement_comes_to_an_end_by_itself),
        cmocka_unit_test(with_things_that_move_bits_do_not_depend_on_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
