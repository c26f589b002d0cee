/* Windows of the display: another thread's frames, beside builds, from where its own copy of the scene
 * stands. */
#include "shading_cache_support.h"

#include <math.h>
#include <stdatomic.h>

#include "base/math.h"
#include "base/random.h"
#include "base/thread.h"
#include "cache/patches/display/display.h"
#include "rendering.h"
#include "scene/copy.h"

enum { W = 64, H = 64, PIXELS = W * H };

typedef struct picture {
    float plane[3][PIXELS];
} picture;

static const sl_rgb guess = {0.25f, 0.25f, 0.25f};

static void draw(sl_display *display, picture *out) {
    sl_counters counters = {0};
    float *planes[6] = {out->plane[0], out->plane[1], out->plane[2]};
    assert_int_equal(sl_window_draw(&display->own, planes, &counters, NULL), SL_OK);
}

static void draw_window(sl_display *display, sl_window *window, picture *out) {
    sl_counters counters = {0};
    float *planes[6] = {out->plane[0], out->plane[1], out->plane[2]};
    assert_int_equal(sl_window_draw(window, planes, &counters, NULL), SL_OK);
}

static void look(sl_scene *scene, sl_vec3 eye, sl_vec3 target) {
    assert_true(sl_camera_look_at(&scene->camera, eye, target, sl_v3(0, 1, 0), 0.9f));
}

/* A square that fills the picture, each vertex with the same irradiance. */
static hierarchy wall(void) {
    hierarchy h = hierarchy_of(square_scene(), 0);
    look(h.scene, sl_v3(0, 0, 1), sl_v3(0, 0, 0));
    want_root(&h, 0);
    return h;
}

static void give_all(hierarchy *h, float irradiance, uint32_t update) {
    for (uint32_t v = 0; v < h->patches->vertex_count; v++) {
        sl_patch_vertex *vertex = &h->patches->vertex[v];
        if (!vertex->references) continue;
        for (int c = 0; c < 3; c++) sl_vertex_value(h->patches, v)[c] = irradiance;
        sl_vertex_mark(vertex, update);
    }
}

static void split_or_drop_at_random(hierarchy *h, uint64_t key) {
    for (uint64_t i = 0; i < 60; i++) {
        uint32_t patch = (uint32_t)(sl_random_unit(key, 2 * i) * (float)h->patches->patch_count);
        if (!sl_patch_is_alive(h->patches, patch)) continue;
        if (sl_random_unit(key, 2 * i + 1) < 0.8f) split(h, patch);
        else sl_patch_drop_children(h->patches, patch);
    }
}

/* ---- one thread builds, another one draws ---------------------------------------------------- */

/* The irradiance of build k is pi k: so each pixel shows kd k, with the number of the build that it is of. */
typedef struct beside {
    sl_display *display;
    sl_window *window;
    atomic_bool stop;
    atomic_ullong frames, builds_seen, torn, out_of_order;
} beside;

static float shown_of(uint64_t builds) {
    return builds ? 0.5f * (float)builds : 0.5f * guess.r * (float)(1.0 / SL_PI);
}

static void draw_on_and_on(void *context) {
    beside *b = context;
    static picture frame;
    uint64_t before = 0;
    while (!atomic_load(&b->stop)) {
        sl_counters counters = {0};
        float *planes[6] = {frame.plane[0], frame.plane[1], frame.plane[2]};
        bool ok = sl_window_draw(b->window, planes, &counters, NULL) == SL_OK;
        uint64_t builds = b->window->builds;
        for (int i = 0; i < PIXELS; i++) {
            for (int c = 0; c < 3; c++)
                ok = ok && fabsf(frame.plane[c][i] - shown_of(builds)) <= 1e-4f * shown_of(builds);
        }
        if (!ok) atomic_fetch_add(&b->torn, 1);
        if (builds < before) atomic_fetch_add(&b->out_of_order, 1);
        if (builds > before) atomic_fetch_add(&b->builds_seen, 1);
        before = builds;
        atomic_fetch_add(&b->frames, 1);
    }
}

static void every_frame_is_of_one_build_whole_and_none_older_than_the_last(void **state) {
    hierarchy h = wall();
    sl_scene *scene_copy;
    assert_int_equal(sl_scene_copy(h.scene, &scene_copy, NULL), SL_OK);
    beside b = {.display = display_of(&h, W, H, guess)};
    assert_int_equal(sl_window_create(b.display, scene_copy, 1, &b.window, NULL), SL_OK);
    sl_thread thread;
    assert_true(sl_thread_start(&thread, draw_on_and_on, &b));
    uint32_t update = 0;
    /* as fast as it goes: it is the builds that wait */
    for (; update < 3000 && (update < 40 || atomic_load(&b.builds_seen) < 20); update++) {
        split_or_drop_at_random(&h, sl_random_key(83, update));
        give_all(&h, (float)SL_PI * (float)(update + 1), update + 1);
        build_display(b.display, &h);
    }
    atomic_store(&b.stop, true);
    sl_thread_join(&thread);
    assert_int_equal(atomic_load(&b.torn), 0);
    assert_int_equal(atomic_load(&b.out_of_order), 0);
    assert_true(atomic_load(&b.builds_seen) >= 20);
    static picture frame;
    draw_window(b.display, b.window, &frame);
    assert_int_equal(b.window->builds, update);
    sl_window_destroy(b.window);
    sl_display_destroy(b.display);
    sl_scene_copy_destroy(scene_copy);
    hierarchy_discard(&h);
}

typedef struct two_builds {
    sl_display *display;
    hierarchy *h;
    atomic_int done;
} two_builds;

static void build_twice(void *context) {
    two_builds *t = context;
    for (uint32_t k = 1; k <= 2; k++) {
        give_all(t->h, (float)k, k);
        build_display(t->display, t->h);
        atomic_store(&t->done, (int)k);
    }
}

/* The first build writes to the hidden copy and goes through; the second one would write to what the frame
 * reads. */
static void a_build_waits_for_the_frame_that_reads_what_it_would_write_to(void **state) {
    hierarchy h = wall();
    two_builds t = {.display = display_of(&h, W, H, guess), .h = &h};
    uint64_t builds;
    const int copy = sl_copies_take(&t.display->copies, &builds); /* a frame begins */
    sl_thread thread;
    assert_true(sl_thread_start(&thread, build_twice, &t));
    while (atomic_load(&t.done) == 0) pause_a_millisecond();
    for (int i = 0; i < 30; i++) pause_a_millisecond();
    assert_int_equal(atomic_load(&t.done), 1);
    assert_int_equal(t.display->copies.shown, 1 - copy);
    sl_copies_give_back(&t.display->copies, copy);
    sl_thread_join(&thread);
    assert_int_equal(atomic_load(&t.done), 2);
    assert_int_equal(t.display->copies.builds, 2);
    assert_int_equal(t.display->copies.shown, copy);
    display_discard(t.display, &h);
}

/* ---- where the copy stands ------------------------------------------------------------------- */

static hierarchy lit(sl_scene *scene) {
    hierarchy h = hierarchy_of(scene, 0);
    for (uint32_t r = 0; r < 2 * h.primitives->count; r++) want_root(&h, r);
    for (uint32_t patch = 0, count = (uint32_t)h.patches->patch_count; patch < count; patch++) {
        if (sl_patch_is_alive(h.patches, patch)) split(&h, patch);
    }
    for (uint32_t v = 0; v < h.patches->vertex_count; v++) {
        for (int c = 0; c < 3; c++)
            sl_vertex_value(h.patches, v)[c] = sl_random_unit(sl_random_key(5, v), (uint64_t)c);
        h.patches->vertex[v].evaluated = 1;
    }
    return h;
}

/* The vase turns once and for all where the tests of animation leave it: here the camera alone moves, and its
 * surfaces are cut anew for it. */
static void curved_surfaces_in_a_window_are_cut_for_its_own_camera(void **state) {
    static picture in_window, there, near_by;
    hierarchy h = lit(load_scene("scenes/vase.json"));
    sl_display *display = display_of(&h, W, H, guess);
    sl_scene *scene_copy;
    sl_window *window;
    assert_int_equal(sl_scene_copy(h.scene, &scene_copy, NULL), SL_OK);
    assert_int_equal(sl_window_create(display, scene_copy, 1, &window, NULL), SL_OK);
    build_display(display, &h);
    look(scene_copy, sl_v3(260, 200, -100), sl_v3(260, 150, 270));
    draw_window(display, window, &near_by);
    look(h.scene, sl_v3(260, 200, -100), sl_v3(260, 150, 270));
    build_display(display, &h);
    draw(display, &there);
    draw_window(display, window, &in_window);
    assert_memory_equal(&there, &in_window, sizeof there);
    /* the first frame after a build is cut for where it is looked from */
    assert_memory_equal(&near_by, &in_window, sizeof there);
    sl_window_destroy(window);
    sl_scene_copy_destroy(scene_copy);
    display_discard(display, &h);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_frame_is_of_one_build_whole_and_none_older_than_the_last),
        cmocka_unit_test(a_build_waits_for_the_frame_that_reads_what_it_would_write_to),
        cmocka_unit_test(curved_surfaces_in_a_window_are_cut_for_its_own_camera),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
