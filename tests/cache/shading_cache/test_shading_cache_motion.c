/* Scenes that move without rest, an update a move: what is seen is refined all the while, and is near what a
 * fresh picture of it would be; what has come to rest is as good as one. Counters and pictures, no clocks. */
#include "shading_cache_support.h"

#include <math.h>
#include <string.h>

#include "cache/frame/method.h"
#include "base/sanitized.h"
#include "cache/shading_cache/state.h"
#include "rendering.h"

enum { SIZE = 16, PIXELS = SIZE * SIZE, WINDOW = 10, FRESH = 100, MOVES = SL_SANITIZED ? 100 : 400 };

static const char ball[] = "scenes/moving-ball.json", light[] = "scenes/moving-light.json";

static sl_settings motion_settings(unsigned threads) {
    sl_settings s = small_settings("shading-cache", SIZE, SIZE);
    s.threads = threads;
    s.filter = SL_FILTER_CENTRE;
    s.shading_cache.indirect_samples = 32;
    s.shading_cache.area_samples = 8;
    s.shading_cache.frames_per_update = 1;
    s.shading_cache.updates = 1000000000;
    return s;
}

static void to_the_end(sl_method *method) {
    for (int updates = 0; !update(method); updates++) assert_true(updates < 4000);
}

/* An edit, and one update. */
static void move_to(sl_scene *scene, sl_method *method, int move) {
    go_to_time(scene, method, time_of_move(move));
    update(method);
}

static double apart_from_a_fresh_one(sl_method *method, const sl_scene *scene, const sl_settings *settings) {
    sl_method *fresh = created_method(scene, settings);
    to_the_end(fresh);
    sl_image *image = resolved_picture(method), *right = resolved_picture(fresh);
    double difference = displayed_difference(image, right);
    destroy_pictures(image, right);
    sl_method_destroy(fresh);
    return difference;
}

static bool is_seen_leaf(const sl_shading_state *s, uint32_t patch) {
    return sl_patch_is_alive(s->patches, patch) && sl_patch_is_leaf(s->patches, patch);
}

/* Leaves that were seen in the last update, have all their corners, and are larger than the stop size. */
static size_t coarse_leaves(const sl_method *method) {
    const sl_shading_state *s = method->state;
    size_t coarse = 0;
    for (size_t i = 0; i < s->leaf_count; i++) {
        uint32_t leaf = s->leaf[i].patch;
        if (!is_seen_leaf(s, leaf)) continue;
        coarse += sl_patch_error(s->patches, &s->curve, leaf) > 0.0f &&
                  !sl_patch_is_finished(s->patches, &s->work, leaf);
    }
    return coarse;
}

static void moves_without_rest(const char *path, int moves, double most) {
    sl_scene *scene = load_scene(path);
    sl_settings settings = motion_settings(2);
    sl_method *method = created_method(scene, &settings);
    double worst = 0.0;
    for (int window = 0; window < moves / WINDOW; window++) {
        size_t coarse = window ? coarse_leaves(method) : 1;
        uint64_t before = count_of(method, SL_COUNT_SPLITS);
        for (int i = 0; i < WINDOW; i++) move_to(scene, method, window * WINDOW + i);
        assert_true(coarse == 0 || count_of(method, SL_COUNT_SPLITS) > before);
        if ((window + 1) * WINDOW % FRESH == 0)
            worst = fmax(worst, apart_from_a_fresh_one(method, scene, &settings));
    }
    print_message("%s: %.3f from a fresh picture at most\n", path, worst);
    assert_true(worst < most);
    destroy_method(method, scene);
}

static void while_a_ball_moves_patches_are_split_and_the_picture_is_near_a_fresh_one(void **state) {
    moves_without_rest(ball, MOVES, 0.15);
}

/* Without its shadows it would be apart by .5. */
static void while_a_light_moves_its_shadows_are_there(void **state) {
    moves_without_rest(light, MOVES, 0.25);
}

static sl_image *after_moves(const char *path, unsigned threads) {
    sl_scene *scene = load_scene(path);
    sl_settings settings = motion_settings(threads);
    sl_method *method = created_method(scene, &settings);
    for (int move = 0; move < 30; move++) move_to(scene, method, move);
    for (int i = 0; i < 5; i++) update(method);
    sl_image *image = resolved_picture(method);
    destroy_method(method, scene);
    return image;
}

typedef bool is_so(const sl_shading_state *s, uint32_t vertex);

static bool is_quick(const sl_shading_state *s, uint32_t vertex) {
    return s->patches->vertex[vertex].is_quick;
}

/* Tells whether indirect light is not by as many paths as is asked for now. */
static bool is_by_other_paths(const sl_shading_state *s, uint32_t vertex) {
    return !s->patches->vertex[vertex].extrapolated && s->layers.version[vertex] < s->same_paths;
}

/* Counts corners of leaves seen in the last update. */
static size_t corners_that_are(is_so *is, const sl_method *method) {
    const sl_shading_state *s = method->state;
    size_t count = 0;
    for (size_t i = 0; i < s->leaf_count; i++) {
        uint32_t leaf = s->leaf[i].patch;
        if (!is_seen_leaf(s, leaf)) continue;
        for (int c = 0; c < sl_patch_corners(s->patches, leaf); c++)
            count += is(s, sl_patch_corner(s->patches, leaf, c));
    }
    return count;
}

static void lights_are_sampled_quickly_while_they_move_and_in_full_at_rest(void **state) {
    sl_scene *scene = load_scene(light);
    sl_settings settings = motion_settings(1);
    sl_method *method = created_method(scene, &settings);
    for (int i = 0; i < 20; i++) update(method);
    move_to(scene, method, 1); /* a single move is sampled in full */
    assert_int_equal(corners_that_are(is_quick, method), 0);
    for (int i = 2; i < 12; i++) move_to(scene, method, i);
    assert_true(corners_that_are(is_quick, method) > 0);
    to_the_end(method);
    assert_int_equal(corners_that_are(is_quick, method), 0);
    destroy_method(method, scene);
}

static double paths_a_sample(const sl_counters *before, const sl_counters *now) {
    return (double)(now->value[SL_COUNT_SAMPLES] - before->value[SL_COUNT_SAMPLES]) /
           (double)(now->value[SL_COUNT_INDIRECT_SAMPLES] - before->value[SL_COUNT_INDIRECT_SAMPLES]);
}

static void indirect_light_is_by_half_of_the_paths_in_motion_and_by_all_again_at_rest(void **state) {
    sl_scene *scene = load_scene(light);
    sl_settings settings = motion_settings(1);
    sl_method *method = created_method(scene, &settings);
    const sl_shading_state *s = method->state;
    sl_counters before = {{0}};
    for (int i = 0; i < 20; i++) update(method);
    assert_true(paths_a_sample(&before, sl_method_counters(method)) == 32.0);
    for (int i = 1; i < 12; i++) {
        if (i == 3) before = *sl_method_counters(method);
        move_to(scene, method, i);
    }
    assert_true(paths_a_sample(&before, sl_method_counters(method)) == 16.0);
    uint32_t in_motion = s->same_paths;
    to_the_end(method);
    assert_true(s->same_paths > in_motion && corners_that_are(is_by_other_paths, method) == 0);
    destroy_method(method, scene);
}

static void motion_has_the_same_bits_at_any_number_of_threads(void **state) {
    const char *const paths[] = {ball, light};
    for (int i = 0; i < 2; i++) {
        sl_image *one = after_moves(paths[i], 1), *three = after_moves(paths[i], 3);
        assert_true(same_picture(one, three));
        destroy_pictures(one, three);
    }
}

/* Moves, and moves that undo each other, an edit in every batch: at rest nothing is left from before the last
 * one, and the picture is that of where things are, but for patches that only the other one has. */
static void an_edited_scene_that_rests_is_as_good_as_a_fresh_one(void **state) {
    static const double times[] = {0.5, 0.5, 1.5, 0.5, 3.0, 0.0, 3.0, 1.2};
    const char *const paths[] = {ball, light};
    for (int i = 0; i < 2; i++) {
        sl_scene *scene = load_scene(paths[i]);
        sl_settings settings = motion_settings(2);
        sl_method *method = created_method(scene, &settings);
        for (int k = 0; k < 8; k++) {
            go_to_time(scene, method, times[k]);
            for (int updates = 0; updates < 1 + (k == 3) * 20; updates++) update(method);
        }
        to_the_end(method);
        const sl_shading_state *inside = method->state;
        assert_int_equal(inside->stale_left, 0);
        double difference = apart_from_a_fresh_one(method, scene, &settings);
        print_message("%s: %.4f from a fresh picture\n", paths[i], difference);
        assert_true(difference < 0.04);
        destroy_method(method, scene);
    }
}

/* ---- the rate that was measured is an event ---- */

static void the_rate_settles_how_fine_patches_are_while_things_change(void **state) {
    sl_scene *scene = load_scene(light);
    sl_settings settings = motion_settings(1);
    sl_method *method = created_method(scene, &settings);
    sl_shading_state *s = method->state;
    update(method);
    sl_changes_begin(&s->changes, 0, s->now);
    float nominal = sl_shading_coarsest(s);
    assert_int_equal(sl_method_rate(method, 200.0, NULL), SL_OK);
    assert_true(nominal > 0.0f && fabsf(sl_shading_coarsest(s) / nominal - 10.0f) < 1e-3f);
    assert_int_equal(sl_method_rate(method, (double)NAN, NULL), SL_ERROR_USAGE);
    assert_int_equal(sl_method_rate(method, 0.0, NULL), SL_ERROR_USAGE);
    assert_int_equal(sl_method_rate(method, 2000.0, NULL), SL_OK);
    assert_true(sl_shading_coarsest(s) == nominal);
    destroy_method(method, scene);
}

static void what_is_made_anew_keeps_the_rate(void **state) {
    sl_scene *scene = load_scene(light);
    sl_settings settings = motion_settings(1);
    sl_method *method = created_method(scene, &settings);
    assert_int_equal(sl_method_rate(method, 200.0, NULL), SL_OK);
    assert_int_equal(sl_method_edit(method, SL_CHANGED_KINDS, NULL), SL_OK);
    assert_true(((sl_shading_state *)method->state)->settings.shading_cache.nominal_rate == 200.0);
    destroy_method(method, scene);
}

static sl_live_state next_frame(sl_live *live, const sl_image **frame) {
    sl_live_state now;
    pause_a_millisecond();
    assert_int_equal(sl_live_frame(live, frame, &now, NULL), SL_OK);
    return now;
}

static void assert_log_gives(const sl_live_event *log, size_t events, uint64_t updates,
                             const sl_image *frame) {
    sl_scene *scene = load_scene(light);
    sl_settings settings = motion_settings(3);
    sl_method *method = created_method(scene, &settings);
    size_t next = 0;
    for (uint64_t done = 0; done < updates; done++) {
        for (; next < events && log[next].updates == done; next++) {
            if (log[next].rate) assert_int_equal(sl_method_rate(method, log[next].value, NULL), SL_OK);
            else go_to_time(scene, method, log[next].value);
        }
        update(method);
    }
    assert_int_equal(next, events);
    sl_image *image = resolved_picture(method);
    assert_memory_equal(image->planes, frame->planes, 3 * PIXELS * sizeof *frame->planes);
    sl_image_destroy(image);
    destroy_method(method, scene);
}

static void a_show_is_repeated_from_its_log_to_the_bit(void **state) {
    sl_live_event log[16];
    sl_scene *scene = load_scene(light);
    sl_settings settings = motion_settings(1);
    sl_live *live;
    const sl_image *frame;
    assert_int_equal(sl_live_start(scene, &settings, &live, NULL), SL_OK);
    for (int move = 1; move <= 6; move++) {
        uint64_t before = next_frame(live, &frame).updates;
        assert_int_equal(sl_live_move(live, 0.3 * move, NULL), SL_OK);
        assert_int_equal(sl_live_rate(live, 50.0 * move, NULL), SL_OK);
        while (next_frame(live, &frame).updates == before) {}
    }
    while (!next_frame(live, &frame).done) {}
    sl_live_state last = next_frame(live, &frame);
    size_t events = sl_live_log(live, log, 16);
    assert_true(events >= 4 && events <= 12 && last.samples > 0.0);
    assert_log_gives(log, events, last.updates, frame);
    sl_live_stop(live, NULL);
    sl_scene_destroy(scene);
}

static size_t leaves_after(sl_method *method, sl_scene *scene, int first_move, int moves, int updates) {
    for (int i = 0; i < moves; i++) move_to(scene, method, first_move + i);
    for (int i = 0; i < updates; i++) update(method);
    return ((const sl_shading_state *)method->state)->leaf_count;
}

static void what_was_refined_at_rest_is_coarser_again_each_time_things_move(void **state) {
    (void)state;
    sl_scene *scene = load_scene(light);
    sl_settings settings = motion_settings(2);
    settings.shading_cache.nominal_rate = 20.0;
    sl_method *method = created_method(scene, &settings);
    size_t rest = leaves_after(method, scene, 0, 1, 100);
    for (int k = 1; k < 4; k++) {
        size_t motion = leaves_after(method, scene, 30 * k, 20, 0);
        print_message("%zu leaves at rest, %zu in motion\n", rest, motion);
        assert_true(2 * motion < rest);
        rest = leaves_after(method, scene, 30 * k + 19, 0, 100);
    }
    destroy_method(method, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(while_a_ball_moves_patches_are_split_and_the_picture_is_near_a_fresh_one),
        cmocka_unit_test(while_a_light_moves_its_shadows_are_there),
        cmocka_unit_test(lights_are_sampled_quickly_while_they_move_and_in_full_at_rest),
        cmocka_unit_test(indirect_light_is_by_half_of_the_paths_in_motion_and_by_all_again_at_rest),
        cmocka_unit_test(what_was_refined_at_rest_is_coarser_again_each_time_things_move),
        cmocka_unit_test(motion_has_the_same_bits_at_any_number_of_threads),
        cmocka_unit_test(an_edited_scene_that_rests_is_as_good_as_a_fresh_one),
        cmocka_unit_test(the_rate_settles_how_fine_patches_are_while_things_change),
        cmocka_unit_test(what_is_made_anew_keeps_the_rate),
        cmocka_unit_test(a_show_is_repeated_from_its_log_to_the_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
