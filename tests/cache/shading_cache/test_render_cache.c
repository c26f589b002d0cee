/* bench/render_cache.c: a rival is worth comparing with if it does well what it is meant to do. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "bench/render_cache.h"
#include "base/math.h"
#include "tests/cache/shading_cache/renderer_support.h"

enum { SIZE = 64 };

typedef struct world {
    sl_scene *scene;
    sl_tracer *own;
    const sl_tracer *tracer;
    sl_sample_renderer renderer;
    render_cache *cache;
    sl_counters counters;
} world;

static world open_world(const char *path) {
    world w = {0};
    sl_error error;
    assert_int_equal(sl_scene_load(path, &w.scene, &error), SL_OK);
    w.own = tracer_of(w.scene);
    w.renderer = constant_renderer((sl_rgb){1.0f, 2.0f, 3.0f});
    return w;
}

static void make_cache(world *w, int samples, unsigned threads) {
    w->tracer = w->own;
    render_cache_settings s = {.scene = w->scene,
                               .tracer = &w->tracer,
                               .renderer = &w->renderer,
                               .renderers = 1,
                               .width = SIZE,
                               .height = SIZE,
                               .samples = samples,
                               .threads = threads,
                               .seed = 1};
    w->cache = render_cache_create(&s);
}

static void close_world(world *w) {
    render_cache_destroy(w->cache);
    w->renderer.destroy(w->renderer.state);
    sl_tracer_destroy(w->own);
    sl_scene_destroy(w->scene);
}

static void move_to(world *w, double time) {
    unsigned changes;
    sl_error error;
    assert_int_equal(sl_scene_set_time(w->scene, time, &changes, &error), SL_OK);
    sl_tracer_destroy(w->own);
    w->own = tracer_of(w->scene);
    w->tracer = w->own;
    render_cache_edit(w->cache, changes);
}

static void run_frames(world *w, int frames) {
    for (int i = 0; i < frames; i++) render_cache_frame(w->cache, &w->counters);
    render_cache_show(w->cache, false);
}

/* Returns the light along the pixel's ray, with an arithmetic of its own; object: the one hit, or
 * SL_NO_INDEX. */
static sl_rgb truth(const world *w, int x, int y, uint32_t *object) {
    const sl_camera *c = &w->scene->camera;
    double top = sl_tan(0.5 * (double)c->vertical_fov), u = top * (2.0 * (x + 0.5) / SIZE - 1.0),
           v = top * (1.0 - 2.0 * (y + 0.5) / SIZE);
    sl_vec3 d = sl_normalize_or(
        sl_sub(sl_add(sl_scale(c->right, (float)u), sl_scale(c->up, (float)v)), c->back), sl_neg(c->back));
    sl_ray16 ray = {.far = {0.0f}};
    sl_ray16_set(&ray, 0, c->eye, d, 0.0f, INFINITY, SL_NO_INDEX);
    sl_hit16 hit;
    sl_counters counters = {{0}};
    sl_trace(w->tracer, &ray, 1, false, &hit, &counters);
    *object = SL_NO_INDEX;
    if (hit.triangle[0] == SL_NO_INDEX) return (sl_rgb){0.0f, 0.0f, 0.0f};
    *object = w->scene->object_index[hit.triangle[0]];
    sl_surface s;
    sl_scene_surface(w->scene, hit.triangle[0], hit.w1[0], hit.w2[0], sl_neg(d), &s);
    sl_rgb e = sl_scene_emission(w->scene, hit.triangle[0], s.geometric_normal);
    float pi = (float)(1.0 / SL_PI);
    return (sl_rgb){e.r + s.diffuse.r * 1.0f * pi, e.g + s.diffuse.g * 2.0f * pi,
                    e.b + s.diffuse.b * 3.0f * pi};
}

static bool agrees(const world *w, int x, int y, sl_rgb t) {
    const float *p = render_cache_picture(w->cache) + y * SIZE + x;
    return fabsf(p[0] - t.r) <= 1e-5f * (1.0f + t.r) && fabsf(p[SIZE * SIZE] - t.g) <= 1e-5f * (1.0f + t.g) &&
           fabsf(p[2 * SIZE * SIZE] - t.b) <= 1e-5f * (1.0f + t.b);
}

/* Share of pixels that are right, of those whose object is `of` (SL_NO_INDEX: of all). */
static double share_right(const world *w, uint32_t of) {
    double right = 0.0, all = 0.0;
    for (int y = 0; y < SIZE; y++) {
        for (int x = 0; x < SIZE; x++) {
            uint32_t object;
            sl_rgb t = truth(w, x, y, &object);
            if (of != SL_NO_INDEX && object != of) continue;
            all += 1.0;
            right += agrees(w, x, y, t);
        }
    }
    return all > 0.0 ? right / all : 0.0;
}

static void a_view_at_rest_becomes_right_in_every_pixel(void **state) {
    world w = open_world("scenes/cornell.json");
    make_cache(&w, SIZE * SIZE / 16, 1);
    run_frames(&w, 16 + 12);
    assert_true(share_right(&w, SL_NO_INDEX) > 0.999); /* a ray along an edge may see either side of it */
    close_world(&w);
}

static void points_follow_the_camera(void **state) {
    world w = open_world("scenes/walk.json");
    make_cache(&w, SIZE * SIZE / 4, 1);
    run_frames(&w, 8);
    uint64_t samples = render_cache_samples(w.cache);
    move_to(&w, 0.1);
    render_cache_show(w.cache, false);
    assert_true(render_cache_samples(w.cache) == samples);
    assert_true(share_right(&w, SL_NO_INDEX) > 0.9);
    run_frames(&w, 12);
    assert_true(share_right(&w, SL_NO_INDEX) > 0.995);
    close_world(&w);
}

static uint32_t object_named(const world *w, const char *name) {
    for (uint32_t i = 0; i < w->scene->object_count; i++)
        if (strstr(w->scene->object_names[i], name)) return i;
    fail_msg("no object %s", name);
    return 0;
}

static void points_go_along_with_their_object(void **state) {
    world w = open_world("scenes/moving-ball.json");
    make_cache(&w, SIZE * SIZE / 4, 1);
    run_frames(&w, 8);
    move_to(&w, 0.3);
    render_cache_show(w.cache, false);
    assert_true(share_right(&w, object_named(&w, "ball")) > 0.75);
    run_frames(&w, 12);
    assert_true(share_right(&w, SL_NO_INDEX) > 0.995);
    close_world(&w);
}

/* ---- a renderer whose light goes on in one half of the room ---- */

static void render_half(const void *state, const sl_sample_request *request, unsigned worker,
                        sl_sample *sample, sl_counters *counters) {
    const bool brighter = *(const float *)state > 0.0f && request->point.position.x < 278.0f;
    sample->irradiance = sl_grey(brighter ? 5.0f : 1.0f);
}

static void samples_go_where_colours_are_found_to_change(void **state) {
    world w = open_world("scenes/cornell.json");
    sl_sample_renderer constant = w.renderer;
    float lit = 0.0f;
    w.renderer = (sl_sample_renderer){.state = &lit, .render = render_half};
    make_cache(&w, SIZE * SIZE / 32, 1);
    run_frames(&w, 60);
    lit = 1.0f;
    run_frames(&w, 16);
    int changed = 0, all = 0, left = 0; /* x grows to the left in this room's pictures */
    for (int y = 0; y < SIZE; y++) {
        for (int x = 0; x < SIZE; x++) {
            uint32_t object;
            sl_rgb t = truth(&w, x, y, &object);
            if (object == SL_NO_INDEX || t.r > 2.0f || !(t.r > 0.0f)) continue;
            float value = render_cache_picture(w.cache)[y * SIZE + x], before = t.r;
            changed += value > 2.0f * before;
            all++;
            left += x >= SIZE / 2;
        }
    }
    /* Chosen without regard to change, half as many samples as pixels would have found 0.39 of them. */
    assert_true(changed > (int)(0.6 * left) && all > SIZE * SIZE / 2);
    w.renderer = constant;
    close_world(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_view_at_rest_becomes_right_in_every_pixel),
        cmocka_unit_test(points_follow_the_camera),
        cmocka_unit_test(points_go_along_with_their_object),
        cmocka_unit_test(samples_go_where_colours_are_found_to_change),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
