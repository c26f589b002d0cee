/* Without memory a live show does not start, a window does not open, and nothing is left behind. */
#include "patch_support.h"

#include <stdio.h>

#include "cache/shading_cache/display.h"
#include "failing_memory.h"
#include "rendering.h"
#include "scene/copy.h"

/* Shown and stopped at once; updates have memory again. */
static sl_status show(void *context) {
    sl_settings settings = small_settings("shading-cache", 12, 12);
    settings.threads = 1;
    settings.shading_cache.indirect = SL_INDIRECT_NONE;
    sl_live *live;
    sl_error error = {0};
    sl_status status = sl_live_start(context, &settings, &live, &error);
    allocations_left = -1;
    if (status != SL_OK) assert_null(live);
    sl_live_stop(live, NULL);
    return status;
}

static void a_show_that_cannot_start_leaves_nothing_behind(void **state) {
    (void)state;
    sl_scene *scene = load_scene("scenes/vase.json");
    uint64_t hash = sl_scene_hash(scene);
    assert_true(until_it_succeeds(show, scene, false, NULL) > 50);
    assert_int_equal(sl_scene_hash(scene), hash);
    sl_scene_destroy(scene);
}

typedef struct looking {
    hierarchy h;
    sl_display *display;
    sl_scene *scene_copy;
    sl_window *window;
    sl_counters counters;
} looking;

static sl_status open_window(void *context) {
    looking *l = context;
    sl_status status = sl_scene_copy(l->h.scene, &l->scene_copy, NULL);
    if (status == SL_OK) status = sl_window_create(l->display, l->scene_copy, &l->window, NULL);
    if (status != SL_OK) sl_scene_copy_destroy(l->scene_copy);
    return status;
}

static sl_status draw(void *context) {
    looking *l = context;
    static float plane[3][32 * 32];
    float *planes[3] = {plane[0], plane[1], plane[2]};
    return sl_window_draw(l->display, l->window, 1, planes, &l->counters, NULL);
}

/* A frame that fails gives its copy back: the next builds do not wait for it. */
static void a_window_without_memory_is_not_there_and_a_frame_without_is_drawn_later(void **state) {
    (void)state;
    looking l = {.h = hierarchy_of(load_scene("scenes/vase.json"), false)};
    sl_display_settings settings = {32, 32, {1, 1, 1}, 1};
    assert_int_equal(sl_display_create(l.h.scene, l.h.primitives, &settings, &l.display, NULL), SL_OK);
    assert_true(until_it_succeeds(open_window, &l, false, NULL) > 10);
    for (int k = 0; k < 3; k++)
        assert_int_equal(sl_display_build(l.display, l.h.patches, &l.counters, NULL), SL_OK);
    assert_true(sl_camera_look_at(&l.scene_copy->camera, sl_v3(260, 200, -100), sl_v3(260, 150, 270),
                                  sl_v3(0, 1, 0), 0.9f));
    assert_true(until_it_succeeds(draw, &l, true, NULL) > 3); /* surfaces are to be cut anew */
    for (int k = 0; k < 3; k++)
        assert_int_equal(sl_display_build(l.display, l.h.patches, &l.counters, NULL), SL_OK);
    sl_window_destroy(l.window);
    sl_scene_copy_destroy(l.scene_copy);
    sl_display_destroy(l.display);
    hierarchy_discard(&l.h);
    assert_int_equal(blocks_held, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_show_that_cannot_start_leaves_nothing_behind),
        cmocka_unit_test(a_window_without_memory_is_not_there_and_a_frame_without_is_drawn_later),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
