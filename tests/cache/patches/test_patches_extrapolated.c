/* Vertices without light of their own: inside other geometry, or where no number came. What they show, what
 * splits them, what an edit does; and samples that are no number. */
#include "shading_cache_support.h"

#include <math.h>
#include <stdio.h>

#include "cache/shading_cache/state.h"
#include "rendering.h"

static uint32_t vertex_at(const hierarchy *h, int u, int v) { /* in quarters of the root */
    sl_patch_place leaf = sl_patch_locate(h->patches, 0, u / 4.0, v / 4.0);
    for (int c = 0; c < leaf.corners; c++) {
        if (4 * leaf.u[c] == u * SL_PATCH_DYADIC && 4 * leaf.v[c] == v * SL_PATCH_DYADIC)
            return sl_patch_corner(h->patches, leaf.patch, c);
    }
    fail_msg("no vertex at (%d, %d) / 4", u, v);
    return SL_NO_INDEX;
}

/* A square of four by four leaves, all with the same light. */
static hierarchy square_of(unsigned kept, float irradiance) {
    hierarchy h = hierarchy_of(kept ? square_scene_of(0.4f) : square_scene(), kept);
    split_levels(&h, want_root(&h, 0), 2);
    evaluate_all(&h, irradiance, 1);
    return h;
}

static void give(hierarchy *h, uint32_t vertex, float irradiance) { evaluate(h, vertex, irradiance, 2); }

static float value_of(const hierarchy *h, uint32_t vertex) { return sl_vertex_value(h->patches, vertex)[1]; }

/* ---- what they show -------------------------------------------------------------------------- */

/* Around it: four at distance 1/2, in two leaves each, and four at 1/2 sqrt(2): weights 8 and 2, of 40. */
static void a_vertex_without_light_has_that_of_the_corners_around_it_the_nearer_the_more(void **state) {
    hierarchy h = square_of(KEEP_LOBES, 6.0f);
    uint32_t buried = vertex_at(&h, 2, 2);
    give(&h, vertex_at(&h, 1, 2), 12.0f);
    give(&h, vertex_at(&h, 3, 3), 18.0f);
    give(&h, vertex_at(&h, 0, 0), 1000.0f); /* in none of its leaves */
    sl_vertex_lobe(h.patches, vertex_at(&h, 2, 1))[2] = 3.0f;
    evaluate(&h, buried, 777.0f, 2);
    sl_patches_set_extrapolated(h.patches, buried);
    sl_patches_extrapolate(h.patches);
    for (int c = 0; c < 3; c++)
        assert_true(fabs((double)sl_vertex_value(h.patches, buried)[c] -
                         (6.0 + 6.0 * 8.0 / 40.0 + 12.0 * 2.0 / 40.0)) < 1e-5);
    assert_true(fabs((double)sl_vertex_lobe(h.patches, buried)[2] - 0.6) < 1e-6);
    hierarchy_discard(&h);
}

/* All sixteen leaves inside something, but for the root's corners. */
static void where_nothing_around_has_light_the_corners_of_a_patch_above_count(void **state) {
    hierarchy h = square_of(0, 100.0f);
    uint32_t buried = vertex_at(&h, 2, 2);
    for (uint32_t i = 0; i < h.patches->vertex_count; i++) {
        const sl_patch_vertex *v = &h.patches->vertex[i];
        bool corner = v->u % SL_PATCH_DYADIC == 0 && v->v % SL_PATCH_DYADIC == 0;
        if (corner) give(&h, i, v->u ? 8.0f : 4.0f);
        else sl_patches_set_extrapolated(h.patches, i);
    }
    sl_patches_extrapolate(h.patches);
    assert_true(fabsf(value_of(&h, buried) - 6.0f) < 1e-5f);
    hierarchy_discard(&h);
}

static void what_is_lent_follows_what_changes_around_it_and_nothing_else_moves_it(void **state) {
    hierarchy h = square_of(0, 6.0f);
    uint32_t buried = vertex_at(&h, 2, 2), far = vertex_at(&h, 0, 0);
    sl_patches_set_extrapolated(h.patches, buried);
    sl_patches_extrapolate(h.patches);
    const float before = value_of(&h, buried);
    give(&h, far, 60.0f);
    sl_patches_extrapolate(h.patches);
    assert_true(value_of(&h, buried) == before);
    give(&h, vertex_at(&h, 1, 2), 12.0f);
    sl_patches_extrapolate(h.patches);
    assert_true(fabsf(value_of(&h, buried) - 7.2f) < 1e-5f);
    hierarchy_discard(&h);
}

/* ---- what splits it -------------------------------------------------------------------------- */

static void a_leaf_with_a_corner_inside_something_may_be_wrong_by_all_that_it_shows(void **state) {
    hierarchy h = square_of(0, 6.0f);
    const sl_display_curve curve = {.reference = 1.0f};
    uint32_t leaf = sl_patch_locate(h.patches, 0, 0.4, 0.4).patch,
             other = sl_patch_locate(h.patches, 0, 0.9, 0.9).patch;
    assert_true(sl_patch_error(h.patches, &curve, leaf) == 0.0f);
    sl_patches_set_extrapolated(h.patches, vertex_at(&h, 2, 2));
    assert_true(sl_patch_error(h.patches, &curve, leaf) ==
                sl_vertex_level(h.patches, &curve, vertex_at(&h, 1, 1)));
    assert_true(sl_patch_error(h.patches, &curve, other) == 0.0f);
    hierarchy_discard(&h);
}

/* A box stands in the floor, the sun is straight above: the floor has the same light everywhere that it can
 * be seen, however few samples there are. */
static const char box_in_floor[] =
    "v -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\n"
    "v -0.5 -0.3 0.4\nv 0.4 -0.3 0.5\nv 0.5 -0.3 -0.4\nv -0.4 -0.3 -0.5\n"
    "v -0.5 0.3 0.4\nv 0.4 0.3 0.5\nv 0.5 0.3 -0.4\nv -0.4 0.3 -0.5\n"
    "f 1 2 3 4\nf 9 10 11 12\nf 8 7 6 5\nf 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\n";
static const char sun_above[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"name\": \"all\"}],"
    "\"lights\": [{\"type\": \"directional\", \"direction\": [0, -1, 0], \"irradiance\": 3}],"
    "\"camera\": {\"eye\": [0, 4, 0.01], \"target\": [0, 0, 0], \"up\": [0, 1, 0], \"fov_deg\": 45}}";

static void around_what_stands_in_it_a_floor_is_as_bright_as_elsewhere(void **state) {
    sl_scene *scene = scene_from_text(sun_above, box_in_floor);
    sl_settings settings = small_settings("shading-cache", 64, 64);
    settings.shading_cache.indirect = SL_INDIRECT_NONE;
    for (int updates = 2; updates <= 20; updates += 18) {
        sl_counters cost;
        settings.shading_cache.updates = (uint32_t)updates;
        sl_image *image = render(scene, &settings, &cost);
        float even = image->planes[0];
        assert_true(even > 0.1f);
        /* the box's top, too */
        for (int i = 0; i < 3 * 64 * 64; i++) assert_true(fabsf(image->planes[i] - even) < 0.004f * even);
        assert_true(cost.value[SL_COUNT_POINTS_SHADED] > 20);
        sl_image_destroy(image);
    }
    sl_scene_destroy(scene);
}

static const char light_in_box[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"name\": \"all\"}],"
    "\"lights\": [{\"type\": \"directional\", \"direction\": [0, -1, 0], \"irradiance\": 3},"
    "{\"type\": \"point\", \"position\": [0, 0.15, 0], \"intensity\": 1}],"
    "\"camera\": {\"eye\": [0, 4, 0.01], \"target\": [0, 0, 0], \"up\": [0, 1, 0], \"fov_deg\": 45}}";

static void light_that_is_shut_in_does_not_leak_out_at_the_foot(void **state) {
    sl_scene *scene = scene_from_text(light_in_box, box_in_floor);
    sl_settings settings = small_settings("shading-cache", 64, 64);
    settings.shading_cache.indirect = SL_INDIRECT_NONE;
    settings.shading_cache.updates = 10;
    sl_image *image = render(scene, &settings, NULL);
    for (int i = 0; i < 3 * 64 * 64; i++)
        assert_true(fabsf(image->planes[i] - image->planes[0]) < 0.004f * image->planes[0]);
    destroy_picture(image, scene);
}

/* Shading that concerned nobody until then is what the eye sees. */
static void an_eye_that_goes_into_the_box_sees_what_is_lit_there(void **state) {
    sl_scene *scene = scene_from_text(light_in_box, box_in_floor);
    sl_settings settings = small_settings("shading-cache", 32, 32);
    settings.shading_cache.indirect = SL_INDIRECT_NONE;
    settings.shading_cache.updates = 1000000000;
    sl_method *method = created_method(scene, &settings);
    sl_image_destroy(finished_picture(method));
    assert_true(
        sl_camera_look_at(&scene->camera, sl_v3(0, 0.28f, 0), sl_v3(0.3f, 0, 0.3f), sl_v3(0, 1, 0), 1.5f));
    assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
    sl_method *cold = created_method(scene, &settings);
    sl_image *image = finished_picture(method), *expected = finished_picture(cold);
    sl_comparison result = comparison_of(image, expected);
    printf("    %.3f %% from a cold start\n", 100.0 * result.rel_rmse);
    assert_true(result.rel_rmse < 0.02 && result.mean_reference > 1.0);
    const sl_shading_state *s = method->state;
    for (size_t i = 0; i < s->leaf_count; i++) {
        for (int c = 0; c < sl_patch_corners(s->patches, s->leaf[i].patch); c++) {
            uint32_t vertex = sl_patch_corner(s->patches, s->leaf[i].patch, c);
            assert_false(s->patches->vertex[vertex].extrapolated);
        }
    }
    destroy_pictures(image, expected);
    sl_method_destroy(method);
    destroy_method(cold, scene);
}

/* ---- samples, committed ---------------------------------------------------------------------- */

/* A cache of one square, as far as a commit needs it. */
typedef struct committing {
    hierarchy h;
    sl_shading_state s;
    sl_object_change object;
} committing;

static void begin(committing *c) {
    *c = (committing){.h = hierarchy_of(square_scene(), 0)};
    want_root(&c->h, 0);
    c->s.scene = c->h.scene;
    c->s.primitives = c->h.primitives;
    c->s.patches = c->h.patches;
    c->s.settings = sl_settings_of_papers();
    c->s.settings.width = c->s.settings.height = 16;
    sl_shading_complete(&c->s.settings);
    c->s.curve.reference = 1.0f;
    c->s.now = 5;
    c->s.changes = (sl_changes){.object_count = 1, .object = &c->object, .threshold = 2.0f, .window = 3};
    c->s.vertex = calloc(4, sizeof *c->s.vertex);
    c->s.request = calloc(4, sizeof *c->s.request);
    c->s.sample = calloc(4, sizeof *c->s.sample);
    c->s.part = calloc(4, sizeof *c->s.part);
    c->s.stale = calloc(c->h.scene->object_count, sizeof *c->s.stale);
    assert_true(c->s.vertex && c->s.request && c->s.sample && c->s.part && c->s.stale);
    for (uint32_t i = 0; i < 4; i++) c->s.vertex[i] = i, c->s.request[i].layers = SL_LAYERS_ALL;
}

static void end(committing *c) {
    free(c->s.vertex), free(c->s.request), free(c->s.sample), free(c->s.part), free(c->s.stale);
    hierarchy_discard(&c->h);
}

static const sl_sample lit = {.irradiance = {4.0f, 4.0f, 4.0f}, .valid = true}, inside = {.valid = false},
                       broken = {.broken = true};

static void commit(committing *c, const sl_sample samples[4]) {
    for (int i = 0; i < 4; i++) c->s.sample[i] = samples[i];
    sl_shading_commit(&c->s, 4);
    sl_patches_extrapolate(c->s.patches);
}

static void a_sample_that_is_no_number_leaves_the_old_value_and_is_not_asked_for_again(void **state) {
    committing c;
    begin(&c);
    evaluate_all(&c.h, 2.0f, 1);
    sl_changes_edit(&c.s.changes, SL_CHANGED_LIGHTS, NULL, c.s.now);
    const sl_sample samples[4] = {lit,
                                  {.irradiance = {NAN, 1, 1}, .valid = true},
                                  {.irradiance = {1, 1, INFINITY}, .valid = true},
                                  broken};
    commit(&c, samples);
    assert_true(value_of(&c.h, 0) == 4.0f);
    for (uint32_t i = 1; i < 4; i++) {
        const sl_patch_vertex *v = &c.h.patches->vertex[i];
        for (int k = 0; k < 3; k++) assert_true(sl_vertex_value(c.h.patches, i)[k] == 2.0f);
        assert_int_equal(v->evaluated, 5);
        assert_false(v->extrapolated);
    }
    /* the broken one's renderer has counted it */
    assert_int_equal(c.s.counters.value[SL_COUNT_NONFINITE], 2);
    assert_int_equal(c.s.counters.value[SL_COUNT_CHANGES_DETECTED], 1);
    end(&c);
}

/* A box stands on the square's lower left corner, as wide as that. */
static sl_scene *box_on_square(float width) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(-1, -1, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), 0);
    trace_mesh_box(&mesh, sl_v3(-2, -2, -0.5f), sl_v3(width - 1.0f, width - 1.0f, 0.5f), false, 0);
    return trace_mesh_build(&mesh);
}

/* By 1, 5 and 20 % of the patch that a vertex was made for, towards the middle of the root. */
static void a_vertex_inside_something_is_looked_for_beside_it_further_and_further(void **state) {
    const float width[] = {-0.01f, 0.03f, 0.1f, 0.5f};
    const double found[] = {1.0 / 256.0, 0.05, 0.2, -1.0};
    for (int i = 0; i < 4; i++) {
        hierarchy h = hierarchy_of(box_on_square(width[i]), 0);
        sl_counters counters = {{0}};
        sl_lit_point at;
        bool moved;
        sl_tracer *tracer = tracer_of(h.scene);
        split_levels(&h, want_root(&h, 0), 2);
        uint32_t corner = vertex_at(&h, 0, 0);
        sl_vertex_sample_point(h.patches, corner, &at);
        assert_int_equal(sl_leave_solid(h.patches, tracer, NULL, corner, &at, &moved, &counters), i < 3);
        assert_int_equal(moved, i == 1 || i == 2);
        if (i < 3) assert_true(fabs((double)at.position.x - (found[i] - 1.0)) < 2e-4);
        sl_tracer_destroy(tracer);
        hierarchy_discard(&h);
    }
}

static void what_comes_out_of_something_or_gets_into_it_is_a_change(void **state) {
    committing c;
    begin(&c);
    commit(&c, (const sl_sample[4]){inside, lit, lit, lit});
    assert_true(c.h.patches->vertex[0].extrapolated && value_of(&c.h, 0) == 4.0f);
    assert_int_equal(c.s.counters.value[SL_COUNT_CHANGES_DETECTED], 0); /* the first value is none */
    c.s.now++;
    commit(&c, (const sl_sample[4]){inside, lit, lit, lit});
    assert_int_equal(c.s.counters.value[SL_COUNT_CHANGES_DETECTED], 0); /* nothing has changed */
    c.s.now++;
    commit(&c, (const sl_sample[4]){lit, lit, inside, lit});
    assert_int_equal(c.s.counters.value[SL_COUNT_CHANGES_DETECTED], 2);
    assert_true(c.s.changes.object[0].changing);
    assert_true(!c.h.patches->vertex[0].extrapolated && c.h.patches->vertex[2].extrapolated);
    end(&c);
}

/* Of k sets each of variance v it is v / k. */
static void a_mean_of_sets_has_the_variance_of_one_of_them_by_their_number(void **state) {
    committing c;
    const sl_patches_settings kept = {
        .channels = 3, .max_depth = SL_PATCH_DEPTH_MAX, .shown = true, .sets = true};
    begin(&c);
    sl_patches_destroy(c.h.patches);
    assert_int_equal(sl_patches_create(c.h.primitives, &kept, &c.h.patches, NULL), SL_OK);
    want_root(&c.h, 0);
    c.s.patches = c.h.patches;
    for (uint32_t k = 0; k < 5; k++, c.s.now++) {
        const sl_sample set = {.irradiance = {(float)k, (float)k, (float)k}, .variance = 6.0f, .valid = true};
        for (int i = 0; i < 4; i++) c.s.request[i].set = k;
        commit(&c, (const sl_sample[4]){set, set, set, set});
        for (uint32_t i = 0; i < 4; i++) {
            assert_int_equal(c.h.patches->sets[i].count, k + 1);
            assert_true(fabsf(c.h.patches->sets[i].variance - 6.0f / (float)(k + 1)) < 1e-5f);
            assert_true(fabsf(value_of(&c.h, i) - 0.5f * (float)k) < 1e-5f);
        }
    }
    assert_int_equal(c.s.counters.value[SL_COUNT_CHANGES_DETECTED], 0);
    end(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_vertex_without_light_has_that_of_the_corners_around_it_the_nearer_the_more),
        cmocka_unit_test(where_nothing_around_has_light_the_corners_of_a_patch_above_count),
        cmocka_unit_test(what_is_lent_follows_what_changes_around_it_and_nothing_else_moves_it),
        cmocka_unit_test(a_leaf_with_a_corner_inside_something_may_be_wrong_by_all_that_it_shows),
        cmocka_unit_test(around_what_stands_in_it_a_floor_is_as_bright_as_elsewhere),
        cmocka_unit_test(light_that_is_shut_in_does_not_leak_out_at_the_foot),
        cmocka_unit_test(an_eye_that_goes_into_the_box_sees_what_is_lit_there),
        cmocka_unit_test(a_sample_that_is_no_number_leaves_the_old_value_and_is_not_asked_for_again),
        cmocka_unit_test(a_vertex_inside_something_is_looked_for_beside_it_further_and_further),
        cmocka_unit_test(a_mean_of_sets_has_the_variance_of_one_of_them_by_their_number),
        cmocka_unit_test(what_comes_out_of_something_or_gets_into_it_is_a_change),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
