/* Drawing: all of what is in view, and nothing twice; an incremental picture is that of drawing it all, bit
 * by bit, with any threads. */
#include <stdio.h>

#include "multi_mesh_field.h"

/* Some vertices lie inside other geometry. */
static sl_rgb stripes_with_holes(const void *context, sl_vec3 p) {
    float s = p.x * 3.1f - p.y * 2.7f + p.z * 2.9f;
    return s - floorf(s) < 0.1f ? sl_grey(NAN) : stripes(context, p);
}

static sl_rgb smooth(const void *context, sl_vec3 p) {
    return (sl_rgb){0.5f + 0.1f * p.x * p.y, 0.6f + 0.05f * p.z * p.z, 0.4f + 0.1f * p.y};
}

static const sl_rgb PAINT = {0.3f, 0.70000005f, 1.0f / 3.0f};
static sl_rgb painted(const void *context, sl_vec3 p) {
    return PAINT;
}

enum { WIDTH = 160, HEIGHT = 120, PIXELS = WIDTH * HEIGHT };

static void blank(rig *r) {
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < PIXELS; i++) r->plane[c][i] = -1.0f;
    }
}

/* Splits leaves at random, whatever their edges say, about as often on one side of an edge as not. */
typedef struct random_splits {
    rig *r;
    uint64_t key, draws;
    float share;
} random_splits;
static void split_maybe(void *context, const sl_patch_place *leaf) {
    random_splits *s = context;
    if (sl_random_unit(s->key, s->draws++) < s->share)
        assert_int_equal(sl_mesh_split(s->r->mesh->mesh, leaf, NULL), SL_OK);
}
static void split_at_random(rig *r, uint64_t seed, int rounds) {
    random_splits s = {.r = r, .key = sl_random_key(seed, 0), .share = 0.4f};
    for (int i = 0; i < rounds; i++) visit_leaves(r->mesh, split_maybe, &s);
    for (uint32_t v = 0; v < r->mesh->mesh->vertex_count; v++) {
        if (sl_mesh_state(r->mesh->mesh, v) != SL_VERTEX_KNOWN) rig_sample(r, &v, 1);
    }
    rig_look(r, NULL, 1);
}

static void a_mesh_of_one_colour_split_at_random_has_neither_holes_nor_steps(void **state) {
    rig r = rig_in_view(striped_room(), (field){painted, NULL}, WIDTH, HEIGHT);
    for (uint64_t round = 0; round < 3; round++) {
        split_at_random(&r, round, 2);
        blank(&r);
        rig_draw(&r, 1);
        for (size_t i = 0; i < PIXELS; i++) {
            bool shown = r.id[i] != SL_NO_INDEX;
            assert_true(r.plane[0][i] == (shown ? PAINT.r : -1.0f));
            assert_true(r.plane[1][i] == (shown ? PAINT.g : -1.0f));
            assert_true(r.plane[2][i] == (shown ? PAINT.b : -1.0f));
        }
    }
    assert_true(r.mesh->mesh->leaves_alive > 8 * roots_in_view(r.mesh));
    rig_discard(&r);
}

/* The largest step between neighbouring pixels of a square, for a mesh split at random. */
static float largest_step(bool hanging) {
    sl_displayed_settings settings = usual_settings();
    settings.hanging = hanging;
    sl_scene *scene = square_scene();
    rig r = rig_of(scene, (field){smooth, NULL}, &settings, WIDTH, HEIGHT);
    rig_look(&r, NULL, 1);
    split_at_random(&r, 4, 5);
    rig_draw(&r, 1);
    float most = 0.0f;
    for (size_t y = 0; y < HEIGHT; y++) {
        for (size_t x = 1; x < WIDTH; x++) {
            size_t i = y * WIDTH + x;
            if (r.id[i] == SL_NO_INDEX || r.id[i - 1] == SL_NO_INDEX) continue;
            most = fmaxf(most, fabsf(r.plane[0][i] - r.plane[0][i - 1]));
        }
    }
    rig_discard(&r);
    return most;
}

static void colours_do_not_jump_where_one_side_of_an_edge_is_split_and_the_other_is_not(void **state) {
    float step = largest_step(true), torn = largest_step(false);
    /* A pixel is 2/120 wide, the field's slope at most 0.1 but for what a fan's corners add. */
    assert_true(step < 4.0f * 0.1f * 2.0f / 120.0f);
    assert_true(torn > 2.0f * step);
}

static void copy_planes(const rig *r, float *copy[3]) {
    for (int c = 0; c < 3; c++) {
        copy[c] = malloc(PIXELS * sizeof(float));
        assert_non_null(copy[c]);
        memcpy(copy[c], r->plane[c], PIXELS * sizeof(float));
    }
}

static void release_planes(float *copy[3]) {
    for (int c = 0; c < 3; c++) free(copy[c]);
}

static void assert_same_planes(const rig *r, float *copy[3]) {
    for (int c = 0; c < 3; c++) assert_memory_equal(r->plane[c], copy[c], PIXELS * sizeof(float));
}

static void incremental_drawing_equals(field f, bool hanging) {
    sl_displayed_settings settings = usual_settings();
    settings.hanging = hanging;
    rig r = rig_of(striped_room(), f, &settings, WIDTH, HEIGHT);
    rig_look(&r, NULL, 1);
    rig_draw(&r, 1);
    uint64_t all = r.counters.value[SL_COUNT_PIXELS_REDRAWN];
    assert_int_equal(all, r.pixels->count);
    size_t batches[] = {1, 1, 2, 5, 32, 32};
    for (size_t step = 0; rig_step(&r, batches[step % 6]) > 0; step++) {
        if (step % 5 != 4 && step > 20) continue;
        uint64_t before = r.counters.value[SL_COUNT_PIXELS_REDRAWN];
        rig_draw(&r, 1);
        if (step < 20) assert_true(r.counters.value[SL_COUNT_PIXELS_REDRAWN] - before < all);
        if (step % 40 != 19) continue;
        float *incremental[3];
        copy_planes(&r, incremental);
        blank(&r);
        r.mesh->dirty_all = true;
        rig_draw(&r, 1);
        for (size_t i = 0; i < PIXELS; i++)
            incremental[0][i] = r.id[i] == SL_NO_INDEX ? -1.0f : incremental[0][i];
        assert_same_planes(&r, incremental);
        release_planes(incremental);
    }
    assert_true(r.counters.value[SL_COUNT_SPLITS] > 1000);
    rig_discard(&r);
}

static void a_picture_redrawn_leaf_by_leaf_equals_one_drawn_at_once(void **state) {
    incremental_drawing_equals((field){stripes, NULL}, true);
    incremental_drawing_equals((field){stripes, NULL}, false);
}

static void so_it_does_where_samples_are_of_no_use(void **state) {
    incremental_drawing_equals((field){stripes_with_holes, NULL}, true);
}

static void a_drawn_pixel_has_the_value_that_the_mesh_has_there(void **state) {
    rig r = rig_in_view(striped_room(), (field){stripes, NULL}, WIDTH, HEIGHT);
    for (int i = 0; i < 60; i++) rig_step(&r, 32);
    rig_draw(&r, 1);
    for (size_t e = 0; e < r.pixels->face_count; e++) {
        for (uint32_t i = r.pixels->face[e].first; i < r.pixels->face[e].first + r.pixels->face[e].count;
             i++) {
            float value[3];
            assert_true(
                sl_mesh_value(r.mesh->mesh, r.pixels->face[e].face, r.pixels->w1[i], r.pixels->w2[i], value));
            /* Weights are rounded differently, and so is the border between two leaves. */
            for (int c = 0; c < 3; c++) assert_true(fabsf(value[c] - r.plane[c][r.pixels->pixel[i]]) < 2e-3f);
        }
    }
    rig_discard(&r);
}

static void leaves_without_values_show_what_stands_in(void **state) {
    rig r = rig_in_view(striped_room(), (field){stripes, NULL}, WIDTH, HEIGHT);
    for (uint32_t v = 0; v < r.mesh->mesh->vertex_count; v++)
        sl_mesh_set_state(r.mesh->mesh, v, SL_VERTEX_UNKNOWN);
    rig_draw(&r, 1);
    for (size_t i = 0; i < PIXELS; i++) assert_true(r.id[i] == SL_NO_INDEX || r.plane[2][i] == 0.25f);
    rig_fill_missing(&r); /* now they are known, and drawn without being asked */
    rig_draw(&r, 1);
    for (size_t i = 0; i < PIXELS; i++) assert_true(r.id[i] == SL_NO_INDEX || r.plane[2][i] != 0.25f);
    rig_discard(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_of_one_colour_split_at_random_has_neither_holes_nor_steps),
        cmocka_unit_test(colours_do_not_jump_where_one_side_of_an_edge_is_split_and_the_other_is_not),
        cmocka_unit_test(a_picture_redrawn_leaf_by_leaf_equals_one_drawn_at_once),
        cmocka_unit_test(so_it_does_where_samples_are_of_no_use),
        cmocka_unit_test(a_drawn_pixel_has_the_value_that_the_mesh_has_there),
        cmocka_unit_test(leaves_without_values_show_what_stands_in),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
