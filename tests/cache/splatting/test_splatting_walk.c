/* The walk-through: a frame ends after so many new records, what is there is kept, and what is still to come
 * is filled in from around. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "rendering.h"

enum { SIDE = 96, BUDGET = 40, FRAMES_MAX = 200 };

static sl_settings walk_settings(void) {
    sl_settings settings = small_settings("splatting", SIDE, SIDE);
    settings.records_per_frame = BUDGET;
    return settings;
}

/* Updates to the end of a frame; returns whether anything is left to refine. */
static bool finish_frame(sl_method *method) {
    sl_progress progress = {0};
    while (!progress.frame_done) assert_int_equal(sl_method_update(method, &progress, NULL), SL_OK);
    return !progress.done;
}

static void a_frame_gets_as_many_new_records_as_it_may_and_no_more(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    sl_settings settings = walk_settings();
    sl_method *method = created_method(scene, &settings);
    uint64_t before = 0;
    bool more = true;
    int frames = 0;
    for (; more; frames++) {
        more = finish_frame(method);
        uint64_t new_records = count_of(method, SL_COUNT_RECORDS) - before;
        assert_true(more ? new_records == BUDGET : new_records <= BUDGET);
        before = count_of(method, SL_COUNT_RECORDS);
        assert_true(frames < FRAMES_MAX);
    }
    assert_true(frames > 5);
    destroy_method(method, scene);
}

static void a_still_walk_ends_with_the_picture_of_a_single_frame(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    sl_settings by_frames = walk_settings(), at_once = by_frames;
    at_once.records_per_frame = 1000000000;
    sl_method *walk = created_method(scene, &by_frames), *whole = created_method(scene, &at_once);
    while (finish_frame(walk)) sl_image_destroy(resolved_picture(walk)); /* every frame is shown */
    while (finish_frame(whole)) {}
    sl_image *a = resolved_picture(walk), *b = resolved_picture(whole);
    assert_true(same_picture(a, b));
    destroy_pictures(a, b);
    sl_method_destroy(walk);
    destroy_method(whole, scene);
}

/* Mean absolute difference of a layer. */
static double change_of(const char *layer, const sl_image *a, const sl_image *b) {
    const float *x = sl_image_channel(a, layer), *y = sl_image_channel(b, layer);
    double sum = 0.0;
    for (int i = 0; i < SIDE * SIDE; i++) sum += fabs((double)x[i] - (double)y[i]);
    return sum / (SIDE * SIDE);
}

static double change(const sl_image *a, const sl_image *b) { return change_of("indirect.G", a, b); }

static void after_a_step_direct_light_is_interleaved_and_in_full_at_the_end(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings walks = walk_settings(), stands = walks;
    walks.direct = stands.direct = SL_DIRECT_SHADOW_MAPS;
    stands.records_per_frame = 1000000000;
    sl_method *walk = created_method(scene, &walks), *still = created_method(scene, &stands);
    while (finish_frame(walk)) {}
    good(sl_method_edit(walk, SL_CHANGED_CAMERA, NULL), NULL);
    assert_true(finish_frame(walk));
    sl_image *first = resolved_picture(walk);
    while (finish_frame(walk)) {}
    while (finish_frame(still)) {}
    sl_image *last = resolved_picture(walk), *truth = resolved_picture(still);
    const double interleaved = change_of("direct.G", first, truth),
                 at_rest = change_of("direct.G", last, truth);
    print_message("direct light: %g interleaved, %g at rest\n", interleaved, at_rest);
    assert_true(interleaved > 5e-5 && interleaved < 1e-3 && at_rest == 0.0);
    destroy_pictures(first, last);
    sl_image_destroy(truth);
    sl_method_destroy(walk);
    destroy_method(still, scene);
}

/* A room whose floor is full of thin fins: what is gathered between them reaches far less than what is
 * gathered beside them, so that neighbours would shrink much of it. */
static sl_scene *room_of_fins(void) {
    enum { FINS = 12 };
    char obj[4096] = "v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 3 -2\nv -2 3 2\nv 2 3 2\nv 2 3 -2\n"
                     "v -0.5 2.99 -0.5\nv 0.5 2.99 -0.5\nv 0.5 2.99 0.5\nv -0.5 2.99 0.5\n"
                     "usemtl wall\nf 1 2 3 4\nf 5 8 7 6\nf 1 4 8 5\nf 1 5 6 2\nf 4 3 7 8\nusemtl lamp\nf 9 "
                     "10 11 12\nusemtl wall\n";
    size_t n = strlen(obj);
    for (int i = 0; i < FINS; i++) {
        double x = -1.2 + 0.2 * i, height = 0.1 + 0.03 * (i % 4);
        n += (size_t)snprintf(obj + n, sizeof obj - n,
                              "v %g 0 -1\nv %g 0 1\nv %g %g 1\nv %g %g -1\nf -4 -3 -2 -1\n", x, x, x, height,
                              x, height);
    }
    return scene_from_text("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"materials\": "
                           "{\"wall\": {\"diffuse\": 0.6, \"two_sided\": true}, "
                           "\"lamp\": {\"diffuse\": 0, \"emission\": 10}},\n \"camera\": {\"eye\": [0.4, 2, "
                           "3.5], \"target\": [0, 0.6, 0], \"fov_deg\": 55}}",
                           obj);
}

/* Records are added and never shrink: what a pixel has of them only grows. And so the change of the picture
 * from frame to frame falls to the last, over windows of frames and but for a quarter, since a frame's records
 * may all lie where few pixels see them, or many. */
static void in_a_still_walk_no_record_shrinks_and_changes_fall_to_the_end(void **state) {
    enum { WINDOW = 4 };
    sl_scene *scene = room_of_fins();
    sl_settings settings = walk_settings();
    settings.accuracy = 0.5;
    settings.records_per_frame = 8;
    sl_method *method = created_method(scene, &settings);
    double changes[FRAMES_MAX] = {0.0}, before = 0.0, first = 0.0;
    sl_image *last = NULL;
    int count = 0;
    for (bool more = true; more; count++) {
        assert_true(count < FRAMES_MAX);
        more = finish_frame(method);
        sl_image *image = resolved_picture(method);
        const float *weight = sl_image_channel(image, "weight.Y"),
                    *old = last ? sl_image_channel(last, "weight.Y") : weight;
        for (int i = 0; i < SIDE * SIDE; i++) assert_true(weight[i] >= old[i]);
        if (last) changes[count - 1] = change(image, last);
        sl_image_destroy(last);
        last = image;
    }
    assert_true(count > 4 * WINDOW);
    for (int from = (count - 1) % WINDOW; from + WINDOW < count; from += WINDOW) {
        double sum = 0.0;
        for (int i = from; i < from + WINDOW; i++) sum += changes[i];
        print_message("frames %d to %d: change %.6f\n", from + 1, from + WINDOW, sum);
        assert_true(from < WINDOW || sum < 1.25 * before);
        if (from < WINDOW) first = sum;
        before = sum;
    }
    assert_true(before < 0.1 * first);
    sl_image_destroy(last);
    destroy_method(method, scene);
}

static void look(sl_scene *scene, sl_method *method, float x) {
    const float eye[3] = {x, 273, -800}, target[3] = {278, 273, 0}, up[3] = {0, 1, 0};
    assert_int_equal(sl_scene_set_camera(scene, eye, target, up, 0.686f, NULL), SL_OK);
    assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
}

static void a_step_aside_needs_few_new_records_and_a_step_back_none(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    sl_settings settings = walk_settings();
    sl_method *method = created_method(scene, &settings);
    while (finish_frame(method)) {}
    uint64_t first = count_of(method, SL_COUNT_RECORDS);
    look(scene, method, 300);
    while (finish_frame(method)) {}
    uint64_t second = count_of(method, SL_COUNT_RECORDS);
    assert_true(second - first < first / 3);
    look(scene, method, 278);
    while (finish_frame(method)) {}
    uint64_t third = count_of(method, SL_COUNT_RECORDS);
    assert_true(third - second <= (second - first) / 2); /* only what neighbour clamping has uncovered */
    look(scene, method, 278);
    while (finish_frame(method)) {}
    assert_int_equal(count_of(method, SL_COUNT_RECORDS), third);
    destroy_method(method, scene);
}

static sl_image *walk_picture(unsigned threads) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    sl_settings settings = walk_settings();
    settings.threads = threads;
    sl_method *method = created_method(scene, &settings);
    for (int step = 0; step < 4; step++) {
        finish_frame(method);
        look(scene, method, 278.0f + 10.0f * (float)step);
    }
    finish_frame(method);
    sl_image *image = resolved_picture(method);
    destroy_method(method, scene);
    return image;
}

static void a_walk_has_the_same_bits_at_any_number_of_threads(void **state) {
    sl_image *one = walk_picture(1), *three = walk_picture(3);
    assert_true(same_picture(one, three));
    destroy_pictures(one, three);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_gets_as_many_new_records_as_it_may_and_no_more),
        cmocka_unit_test(a_still_walk_ends_with_the_picture_of_a_single_frame),
        cmocka_unit_test(after_a_step_direct_light_is_interleaved_and_in_full_at_the_end),
        cmocka_unit_test(in_a_still_walk_no_record_shrinks_and_changes_fall_to_the_end),
        cmocka_unit_test(a_step_aside_needs_few_new_records_and_a_step_back_none),
        cmocka_unit_test(a_walk_has_the_same_bits_at_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
