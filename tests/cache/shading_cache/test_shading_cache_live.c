/* The two loops of the shading cache beside each other: frames never wait for samples, and show what moves at
 * once. Samples come from a renderer of the tests' own, in the place of the one for area lights, which waits
 * before a gate. */
#include <limits.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "unit_test.h"
#include "base/error.h"
#include "base/math.h"
#include "base/thread.h"
#include "cache/shading_cache/renderers.h"
#include "rendering.h"
#include "scene/scene.h"

enum { W = 48, H = 40, PIXELS = W * H };

/* ---- a renderer that waits ------------------------------------------------------------------- */

static sl_monitor gate;
static bool gate_is_open, edit_fails, edits_brighten;
static int waiting, arrived, passes, edits; /* passes: of batches that a closed gate lets through */
static atomic_int batches;
static float irradiance = 2.0f * (float)SL_PI; /* behind the gate */
static float of_batch; /* as the last batch found it */

static void open_gate(bool open) {
    sl_monitor_enter(&gate);
    gate_is_open = open;
    sl_monitor_signal(&gate);
    sl_monitor_leave(&gate);
}

static void wait_until_samples_are_held_up(void) {
    sl_monitor_enter(&gate);
    while (!waiting) sl_monitor_wait(&gate);
    sl_monitor_leave(&gate);
}

static void go_through_the_gate(void *state, size_t count, const sl_sample_request *requests) {
    sl_monitor_enter(&gate);
    waiting++;
    arrived++;
    sl_monitor_signal(&gate);
    while (!gate_is_open && passes == 0) sl_monitor_wait(&gate);
    if (!gate_is_open) passes--;
    waiting--;
    of_batch = irradiance;
    sl_monitor_leave(&gate);
    atomic_fetch_add(&batches, 1);
}

static void render_as_of_then(const void *state, const sl_sample_request *request, unsigned worker,
                              sl_sample *sample, sl_counters *counters) {
    sample->irradiance = sl_grey(of_batch);
}

static sl_status edit_or_fail(void *state, sl_error *error) {
    sl_monitor_enter(&gate);
    edits++;
    if (edits_brighten) irradiance *= 2.0f;
    sl_monitor_leave(&gate);
    return edit_fails ? sl_fail(error, SL_ERROR_RESOURCES, "no light today") : SL_OK;
}

static void nothing_to_destroy(void *state) { (void)state; }

sl_status sl_area_renderer(const sl_renderer_settings *settings, sl_sample_renderer *renderer,
                           sl_error *error) {
    *renderer = (sl_sample_renderer){.prepare = go_through_the_gate,
                                     .render = render_as_of_then,
                                     .edit = edit_or_fail,
                                     .destroy = nothing_to_destroy};
    return SL_OK;
}

/* ---- shows ----------------------------------------------------------------------------------- */

static sl_settings show_settings(void) {
    sl_settings settings = small_settings("shading-cache", W, H);
    settings.threads = 1;
    settings.filter = SL_FILTER_CENTRE;
    settings.shading_cache.indirect = SL_INDIRECT_NONE;
    settings.shading_cache.updates = 12;
    settings.shading_cache.stop_size = 4.0;
    return settings;
}

static sl_live *start(sl_scene *scene, const sl_settings *settings) {
    sl_live *live;
    sl_error error = {0};
    if (sl_live_start(scene, settings, &live, &error) != SL_OK) fail_msg("%s", error.message);
    return live;
}

static sl_live_state frame_of(sl_live *live, float picture[3 * PIXELS]) {
    const sl_image *frame;
    sl_live_state state;
    sl_error error = {0};
    if (sl_live_frame(live, &frame, &state, &error) != SL_OK) fail_msg("%s", error.message);
    assert_int_equal(frame->width, W);
    assert_int_equal(frame->height, H);
    if (picture) memcpy(picture, frame->planes, 3 * PIXELS * sizeof *picture);
    return state;
}

static sl_live_state frames_until_done(sl_live *live, float picture[3 * PIXELS]) {
    sl_live_state state = frame_of(live, picture);
    while (!state.done) {
        pause_a_millisecond();
        state = frame_of(live, picture);
    }
    return frame_of(live, picture); /* drawn after the last update */
}

static int pixels_apart(const float *a, const float *b) {
    int apart = 0;
    for (int i = 0; i < PIXELS; i++) {
        bool same = true;
        for (int c = 0; c < 3; c++)
            same = same &&
                   fabsf(a[c * PIXELS + i] - b[c * PIXELS + i]) <= 1e-4f * (1e-3f + fabsf(b[c * PIXELS + i]));
        apart += !same;
    }
    return apart;
}

static const char ball[] = "scenes/moving-ball.json", walk[] = "scenes/walk.json";

/* ---- frames and samples ---------------------------------------------------------------------- */

static void frames_keep_coming_while_samples_are_held_up(void **state) {
    sl_scene *scene = load_scene(ball);
    sl_settings settings = show_settings();
    open_gate(false);
    int before = atomic_load(&batches);
    sl_live *live = start(scene, &settings);
    wait_until_samples_are_held_up();
    for (uint64_t i = 1; i <= 50; i++) {
        sl_live_state shown = frame_of(live, NULL);
        assert_int_equal(shown.frames, i);
        assert_int_equal(shown.updates, 0);
        assert_false(shown.done);
    }
    assert_int_equal(atomic_load(&batches), before);
    open_gate(true);
    static float picture[3 * PIXELS];
    sl_live_state last = frames_until_done(live, picture);
    assert_true(last.updates >= 12 && last.versions >= 12);
    sl_counters counters;
    sl_live_stop(live, &counters);
    assert_int_equal(counters.value[SL_COUNT_FRAMES_DISPLAYED], last.frames);
    assert_true(counters.value[SL_COUNT_POINTS_SHADED] > 0);
    sl_scene_destroy(scene);
}

/* All irradiance is 2 pi: a picture in which all that is seen has samples shows 2 kd. */
static void samples_catch_up_where_things_are_now_and_then_rest(void **state) {
    static float picture[3 * PIXELS];
    sl_scene *scene = load_scene(ball);
    sl_settings settings = show_settings();
    settings.shading_cache.updates = 60;
    open_gate(true);
    sl_live *live = start(scene, &settings);
    for (int step = 0; step < 5; step++) {
        assert_int_equal(sl_live_move(live, 0.7 * step, NULL), SL_OK);
        sl_live_state shown = frames_until_done(live, picture);
        assert_true(shown.time_seconds == 0.7 * step);
        for (int k = 0; k < 5; k++) {
            pause_a_millisecond();
            assert_int_equal(frame_of(live, picture).updates, shown.updates);
        }
        const float kd[4][3] = {
            {0.73f, 0.73f, 0.73f}, {0.63f, 0.065f, 0.05f}, {0.14f, 0.45f, 0.091f}, {0.75f, 0.6f, 0.2f}};
        int lit = 0, covered = 0;
        for (int i = 0; i < PIXELS; i++) {
            covered += picture[i] > 0.0f;
            for (int m = 0; m < 4; m++)
                lit += fabsf(picture[i] - 2.0f * kd[m][0]) < 2e-3f &&
                       fabsf(picture[PIXELS + i] - 2.0f * kd[m][1]) < 2e-3f;
        }
        assert_true(covered > PIXELS / 2 && lit > covered * 95 / 100);
    }
    sl_live_stop(live, NULL);
    sl_scene_destroy(scene);
}

static void light_becomes(float value) {
    sl_monitor_enter(&gate);
    irradiance = value;
    sl_monitor_leave(&gate);
}

static sl_live_state frames_until_a_change_shows(sl_live *live, uint64_t changes) {
    sl_live_state state = frame_of(live, NULL);
    while (state.changes_shown < changes) {
        pause_a_millisecond();
        state = frame_of(live, NULL);
    }
    return state;
}

/* ---- moves that wait ------------------------------------------------------------------------- */

/* Two boards on a wall; one moves in the first second, the other in the next. The light turns a little, so that
 * none of it outlives that. */
static sl_scene *two_boards(void) {
    static const char json[] =
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"transform\": {\"scale\": 3}}, "
        "{\"file\": \"mesh.obj\", \"name\": \"left\", \"keyframes\": [{\"time\": 0, \"translate\": [-1, 0, "
        "0.5]}, {\"time\": 1, \"translate\": [-1, 1, 0.5]}]}, "
        "{\"file\": \"mesh.obj\", \"name\": \"right\", \"keyframes\": [{\"time\": 1, \"translate\": [1, 0, "
        "0.5]}, {\"time\": 2, \"translate\": [1, -1, 0.5]}]}], "
        "\"lights\": [{\"type\": \"directional\", \"direction\": [0, 0, -1], \"irradiance\": 1, "
        "\"keyframes\": [{\"time\": 0, \"direction\": [0, 0, -1]}, {\"time\": 3, \"direction\": [0.1, 0, "
        "-1]}]}], "
        "\"camera\": {\"eye\": [0, 0, 6], \"target\": [0, 0, 0], \"up\": [0, 1, 0], \"fov_deg\": 40}}";
    return scene_from_text(json, "v -0.5 -0.5 0\nv 0.5 -0.5 0\nv 0.5 0.5 0\nv -0.5 0.5 0\nf 1 2 3 4\n");
}

static sl_live *start_held_up(sl_scene *scene) {
    sl_settings settings = show_settings();
    settings.shading_cache.updates = 500;
    open_gate(false);
    sl_live *live = start(scene, &settings);
    wait_until_samples_are_held_up();
    edits = 0;
    edits_brighten = true;
    return live;
}

static void stop_brightened(sl_live *live) {
    open_gate(true);
    sl_live_stop(live, NULL);
    edits_brighten = false;
    light_becomes(2.0f * (float)SL_PI);
}

/* By the default material's reflectance all pixels are either the background or of one brightness. */
static void all_shading_is_of_after_the_edit(const float picture[3 * PIXELS], float expected) {
    int lit = 0, covered = 0;
    for (int i = 0; i < PIXELS; i++)
        covered += picture[i] > 0.0f, lit += fabsf(picture[i] - expected) < 1e-3f * expected;
    assert_true(covered > PIXELS / 3 && lit == covered);
}

/* Updates need not go where things were in between, but what has moved in between has moved, and its light
 * began to change with the first of the moves. */
static void
of_moves_that_wait_the_last_is_followed_with_all_that_moved_and_the_first_tells_how_late_the_light_is(
    void **state) {
    static float before[3 * PIXELS], picture[3 * PIXELS];
    sl_scene *scene = two_boards(), *there = two_boards();
    sl_live *live = start_held_up(scene);
    frame_of(live, before);
    const double moves[3] = {0.5, 1.0, 2.0};
    for (int i = 0; i < 3; i++) {
        assert_int_equal(sl_live_move(live, moves[i], NULL), SL_OK);
        for (int k = 0; k < 2; k++) assert_int_equal(frame_of(live, NULL).updates, 0);
    }
    assert_int_equal(edits, 0);
    open_gate(true);
    sl_live_state shown = frames_until_a_change_shows(live, 1);
    assert_true(shown.change_seconds == 0.5 && shown.change_frames >= 6 && shown.time_seconds == 2.0);
    shown = frames_until_done(live, picture);
    assert_int_equal(edits, 1);
    assert_int_equal(shown.changes_shown, 1);
    float kd = scene->materials[scene->material_index[0]].diffuse.r;
    all_shading_is_of_after_the_edit(picture, 4.0f * kd);
    assert_true(pixels_apart(picture, before) > 20);
    assert_int_equal(sl_live_move(live, 1.5, NULL), SL_OK); /* nothing of the earlier ones is left over */
    shown = frames_until_done(live, picture);
    assert_true(shown.changes_shown == 2 && shown.change_seconds == 1.5);
    all_shading_is_of_after_the_edit(picture, 8.0f * kd);
    assert_int_equal(sl_live_move(live, 2.0, NULL), SL_OK);
    frames_until_done(live, picture);
    stop_brightened(live);
    assert_int_equal(sl_scene_set_time(there, 2.0, NULL, NULL), SL_OK);
    assert_int_equal(sl_scene_hash(scene), sl_scene_hash(there));
    sl_scene_destroy(scene);
    sl_scene_destroy(there);
}

static void of_methods_without_a_display_a_move_is_a_change_that_shows_with_their_finished_picture(
    void **state) {
    sl_scene *scene = load_scene(walk);
    sl_settings settings = small_settings("path", W, H);
    settings.spp = 4; /* an update is one sample of each pixel */
    sl_live *live = start(scene, &settings);
    assert_int_equal(frames_until_done(live, NULL).changes_shown, 0);
    for (uint64_t i = 1; i <= 3; i++) {
        uint64_t updates = frame_of(live, NULL).updates;
        assert_int_equal(sl_live_move(live, 0.3 * (double)i, NULL), SL_OK);
        sl_live_state shown = frames_until_a_change_shows(live, i);
        assert_true(shown.updates >= updates + settings.spp);
        assert_true(shown.changes_shown == i && shown.change_seconds == 0.3 * (double)i &&
                    shown.time_seconds == shown.change_seconds);
    }
    sl_live_stop(live, NULL);
    sl_scene_destroy(scene);
}

static void a_camera_of_ones_own_stays_whatever_moves(void **state) {
    static float first[3 * PIXELS], looked[3 * PIXELS], moved[3 * PIXELS], back[3 * PIXELS];
    const float eye[3] = {300, 400, -300}, target[3] = {270, 100, 300}, up[3] = {0, 1, 0};
    sl_scene *scene = load_scene(walk);
    sl_settings settings = show_settings();
    open_gate(false);
    sl_live *live = start(scene, &settings);
    wait_until_samples_are_held_up(); /* and no shading changes from here on */
    frame_of(live, first);
    assert_int_equal(sl_live_look(live, eye, target, up, 0.9f, NULL), SL_OK);
    frame_of(live, looked);
    assert_true(pixels_apart(first, looked) > 20);
    assert_int_equal(sl_live_move(live, 2.0, NULL), SL_OK); /* keyframes move nothing but the camera here */
    frame_of(live, moved);
    assert_memory_equal(looked, moved, sizeof looked);
    sl_error error;
    assert_int_equal(sl_live_look(live, eye, eye, up, 0.9f, &error), SL_ERROR_USAGE);
    assert_int_equal(sl_live_move(live, NAN, &error), SL_ERROR_USAGE);
    frame_of(live, back);
    assert_memory_equal(looked, back, sizeof looked);
    open_gate(true);
    frames_until_done(live, NULL);
    sl_live_stop(live, NULL);
    assert_true(scene->camera.eye.x == eye[0] && scene->camera.eye.z == eye[2]); /* as updates had it last */
    sl_scene_destroy(scene);
}

/* ---- ends ------------------------------------------------------------------------------------ */

static void open_gate_soon(void *context) {
    for (int i = 0; i < 3; i++) pause_a_millisecond();
    open_gate(true);
}

static void a_show_can_be_stopped_at_any_time_and_leaves_nothing_running(void **state) {
    sl_scene *scene = load_scene(ball);
    sl_settings settings = show_settings();
    int before = threads_left(INT_MAX);
    for (int round = 0; round < 12; round++) {
        open_gate(round % 3 != 0);
        sl_live *live = start(scene, &settings);
        for (int i = 0; i < round % 4; i++) {
            assert_int_equal(sl_live_move(live, 0.1 * round + 0.3 * i, NULL), SL_OK);
            frame_of(live, NULL);
        }
        sl_thread opener;
        bool closed = round % 3 == 0;
        if (closed) assert_true(sl_thread_start(&opener, open_gate_soon, NULL));
        sl_live_stop(live, NULL);
        if (closed) sl_thread_join(&opener);
        assert_true(threads_left(before) <= before); /* a sanitizer's own may have gone */
    }
    sl_live_stop(NULL, NULL);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_keep_coming_while_samples_are_held_up),
        cmocka_unit_test(samples_catch_up_where_things_are_now_and_then_rest),
        cmocka_unit_test(
            of_moves_that_wait_the_last_is_followed_with_all_that_moved_and_the_first_tells_how_late_the_light_is),
        cmocka_unit_test(
            of_methods_without_a_display_a_move_is_a_change_that_shows_with_their_finished_picture),
        cmocka_unit_test(a_camera_of_ones_own_stays_whatever_moves),
        cmocka_unit_test(a_show_can_be_stopped_at_any_time_and_leaves_nothing_running),
    };
    if (!sl_monitor_open(&gate)) return 1;
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    sl_monitor_close(&gate);
    return failed;
}
