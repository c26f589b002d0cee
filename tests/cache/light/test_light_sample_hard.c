/* The hard cases of a single light: each has a value that must come out, not merely no crash. */
#include <stdlib.h>

#include "light_sample_support.h"

#include "base/math.h"
#include "base/random.h"

static const sl_vec3 up = {0, 1, 0};
static const sl_light_estimator estimators[] = {SL_LIGHT_RATIO, SL_LIGHT_LOOK_AT, SL_LIGHT_RAYS};

static void set_estimator(light_world *w, sl_light_estimator estimator) {
    sl_light_sample_settings s = sl_light_sample_defaults();
    s.estimator = estimator;
    light_world_set(w, &s);
}

static uint32_t add_grey(trace_mesh *mesh) { return trace_mesh_diffuse(mesh, 0.5f); }

/* ---- near, edge-on, below ---- */

/* 1 below the inside, 1/2 below an edge, 1/4 below a corner, as h goes to 0. */
static void a_touching_light_has_its_limits(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, -1, -1, 2, 2, 1);
    trace_mesh_quad(&mesh, sl_v3(-9, -9, -9), sl_v3(0, 0, 18), sl_v3(18, 0, 0), add_grey(&mesh));
    light_world w = light_world_make(&mesh);
    for (size_t e = 0; e < 3; e++) {
        set_estimator(&w, estimators[e]);
        bool raw = estimators[e] == SL_LIGHT_LOOK_AT;
        for (float h = 1e-2f; h > 1e-6f; h *= 0.1f) {
            double room = 3.0 * (double)h + (raw ? 0.03 : 1e-6);
            assert_near(sample_light(&w, 0, sl_v3(0.1f, 1 - h, 0.2f), up), 1.0, room);
            assert_near(sample_light(&w, 0, sl_v3(1, 1 - h, 0.2f), up), 0.5, room);
            assert_near(sample_light(&w, 0, sl_v3(1, 1 - h, -1), up), 0.25, room);
        }
        assert_true(sample_light(&w, 0, sl_v3(0, 1, 0), up) == 0.0); /* on it */
        assert_true(sample_light(&w, 0, sl_v3(0, 1.001f, 0), up) == 0.0);
    }
    light_world_free(&w);
}

static void a_light_edge_on_gives_nothing_and_next_to_it_next_to_nothing(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t lamp = trace_mesh_lamp(&mesh, 1);
    trace_mesh_quad(&mesh, sl_v3(0, 1, -0.5f), sl_v3(0, 1, 0), sl_v3(0, 0, 1), lamp); /* shines along +x */
    trace_mesh_quad(&mesh, sl_v3(-9, -1, -9), sl_v3(0, 0, 18), sl_v3(18, 0, 0), add_grey(&mesh));
    light_world w = light_world_make(&mesh);
    for (size_t e = 0; e < 3; e++) {
        set_estimator(&w, estimators[e]);
        assert_true(sample_light(&w, 0, sl_v3(0, 0, 0), up) == 0.0);
        assert_true(sample_light(&w, 0, sl_v3(-0.1f, 0, 0), up) == 0.0);
        double before = 0.0;
        for (float x = 1e-5f; x < 0.5f; x *= 2.0f) { /* F grows from nothing, in proportion to x at first */
            sl_lit_point p = lit_point(sl_v3(x, 0, 0), up);
            double f = sample_light(&w, 0, p.position, up),
                   exact = sl_light_unoccluded(&w.lights->light[0], &p);
            bool raw = estimators[e] == SL_LIGHT_LOOK_AT;
            assert_share(f, exact, raw ? 0.05 : 1e-6);
            assert_true(f > before || raw);
            before = f;
        }
    }
    light_world_free(&w);
}

static void nothing_in_between_needs_no_picture(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, -1, -1, 2, 2, 1);
    trace_mesh_sphere(&mesh, sl_v3(0, 3, 0), 0.5f, 40, 0.0f, false, add_grey(&mesh)); /* above the light */
    light_world w = light_world_make(&mesh);
    assert_share(sample_light(&w, 0, sl_v3(0, 0, 0), up), 4.0 * rectangle_form(0, 1, 0, 1, 1), 1e-6);
    assert_int_equal(w.counters.value[SL_COUNT_LIGHT_SAMPLES_SKIPPED], 1);
    assert_int_equal(w.counters.value[SL_COUNT_RASTER_PASSES], 0);
    light_world_free(&w);
}

/* A tube so thin that no pixel's centre lies on it, and one that is seen from so near that pixels would be
 * too coarse. */
static void lights_thinner_than_pixels_are_hidden_as_a_whole_or_not_at_all(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t lamp = trace_mesh_lamp(&mesh, 1), a, b, c;
    a = trace_mesh_vertex(&mesh, -1, 2, 0), b = trace_mesh_vertex(&mesh, 1, 2, 0),
    c = trace_mesh_vertex(&mesh, 1, 2, 1e-5f);
    trace_mesh_triangle(&mesh, a, b, c, lamp);
    trace_mesh_quad(&mesh, sl_v3(2, 1, -9), sl_v3(0, 0, 18), sl_v3(18, 0, 0), add_grey(&mesh));
    light_world w = light_world_make(&mesh);
    for (size_t e = 0; e < 3; e++) {
        set_estimator(&w, estimators[e]);
        bool raw = estimators[e] == SL_LIGHT_LOOK_AT;
        sl_lit_point p = lit_point(sl_v3(0, 0, 0), up);
        double exact = sl_light_unoccluded(&w.lights->light[0], &p);
        assert_true(exact > 0.0);
        if (!raw) assert_share(sample_light(&w, 0, p.position, up), exact, 0.01);
        sample_light(&w, 0, p.position, up);
        assert_true(sample_light(&w, 0, sl_v3(6, 0, 0), up) == 0.0);
    }
    light_world_free(&w);
}

/* ---- occluders ---- */

/* A plate barely above the floor hides what lies beyond x = 2 of a light between x = 1 and 3 at height 2. */
static void an_occluder_that_all_but_touches_the_point_hides_what_is_behind_it(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, 1, -0.5f, 2, 1, 2);
    trace_mesh_quad(&mesh, sl_v3(0.001f, 0.001f, -9), sl_v3(9, 0, 0), sl_v3(0, 0, 18), add_grey(&mesh));
    light_world w = light_world_make(&mesh);
    for (size_t e = 0; e < 3; e++) {
        set_estimator(&w, estimators[e]);
        assert_share(sample_light(&w, 0, sl_v3(0, 0, 0), up), rectangle_form(1, 2, -0.5, 0.5, 2), 0.3);
    }
    light_world_free(&w);
}

/* A tilted floor of many triangles, its vertices rounded: wherever on it, be it a vertex or an edge that no
 * triangle owns, nothing of it is in the light's way. */
static void a_surface_does_not_hide_light_from_itself(void **unused) {
    enum { N = 20 };
    trace_mesh mesh = trace_mesh_begin();
    sl_vec3 n = sl_normalize_or(sl_v3(0.3f, 1, 0.2f), up),
            u = sl_normalize_or(sl_cross(n, sl_v3(0.1f, 0, 1)), up), v = sl_cross(u, n);
    add_ceiling_light(&mesh, 99.5f, 99.5f, 1, 1, 105);
    uint32_t grey = add_grey(&mesh), first = 0;
    const sl_vec3 corner = {100, 102, 100}; /* far from the origin, where roundings are large */
    for (int j = 0; j <= N; j++) {
        for (int i = 0; i <= N; i++) {
            sl_vec3 p = sl_mad(sl_mad(corner, 0.2f * (float)(i - N / 2), u), 0.2f * (float)(j - N / 2), v);
            uint32_t k = trace_mesh_vertex(&mesh, p.x, p.y, p.z);
            if (i == 0 && j == 0) first = k;
        }
    }
    for (uint32_t j = 0; j < N; j++) {
        for (uint32_t i = 0; i < N; i++) {
            uint32_t a = first + j * (N + 1) + i;
            trace_mesh_triangle(&mesh, a, a + 1, a + N + 2, grey);
            trace_mesh_triangle(&mesh, a, a + N + 2, a + N + 1, grey);
        }
    }
    light_world w = light_world_make(&mesh);
    for (size_t e = 0; e < 3; e += 2) {
        set_estimator(&w, estimators[e]);
        for (uint32_t t = 2; t < w.scene->triangle_count; t++) {
            sl_vec3 c[3];
            for (int k = 0; k < 3; k++) c[k] = sl_scene_position(w.scene, w.scene->vertex[k][t]);
            uint64_t key = sl_random_key(8, t);
            float a = sl_random_unit(key, 0), b = (1 - a) * sl_random_unit(key, 1);
            const sl_vec3 inside = sl_mad(sl_mad(c[0], a, sl_sub(c[1], c[0])), b, sl_sub(c[2], c[0]));
            const sl_vec3 middle = sl_scale(sl_add(c[0], c[1]), 0.5f);
            sl_lit_point points[3] = {lit_point(inside, n), lit_point(middle, n), lit_point(c[0], n)};
            points[0].triangle = t;
            for (int k = 0; k < 3; k++) {
                float f = sl_light_sample_take(w.sampling, 0, &points[k], w.scratch, &w.counters);
                assert_share((double)f, sl_light_unoccluded(&w.lights->light[0], &points[k]), 1e-6);
            }
        }
    }
    light_world_free(&w);
}

/* On the floor at the foot of a wall: the wall's plane goes through the point, and is before it by a rounding
 * or behind. */
static void a_wall_that_a_point_touches_does_not_hide_what_is_before_it(void **unused) {
    for (int turn = 0; turn < 40; turn++) {
        double angle = 0.1571 * (double)turn;
        sl_vec3 along = sl_v3((float)sl_cos(angle), 0, (float)sl_sin(angle)),
                out = sl_v3(along.z, 0, -along.x);
        trace_mesh mesh = trace_mesh_begin();
        uint32_t lamp = trace_mesh_lamp(&mesh, 1);
        sl_vec3 foot = sl_v3(3.3f, 0.7f, -2.9f);
        trace_mesh_quad(&mesh, sl_mad(foot, -2, along), sl_scale(along, 4), sl_v3(0, 3, 0), add_grey(&mesh));
        trace_mesh_quad(&mesh, sl_add(sl_mad(foot, 0.5f, out), sl_v3(0, 2, 0)), out, along, lamp);
        light_world w = light_world_make(&mesh);
        assert_true(w.lights->light[0].normal.y < -0.9f);
        for (size_t e = 0; e < 3; e += 2) {
            set_estimator(&w, estimators[e]);
            for (int k = 0; k < 20; k++) {
                sl_lit_point p = lit_point(sl_mad(foot, 0.1f * (float)k - 0.9f, along), up);
                assert_share(sample_light(&w, 0, p.position, up),
                             sl_light_unoccluded(&w.lights->light[0], &p), 1e-6);
            }
        }
        light_world_free(&w);
    }
}

static void alpha_masks_let_their_share_through(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, -0.5f, -0.5f, 1, 1, 2);
    uint32_t leaf = add_grey(&mesh);
    /* right half clear */
    uint8_t texels[16] = {255, 255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 255, 255, 255, 255, 0};
    mesh.textures[0] = (sl_texture){NULL, 2, 2, true, texels};
    mesh.texture_count = 1;
    mesh.materials[leaf].alpha_texture = 0;
    trace_mesh_quad(&mesh, sl_v3(-1, 1, -1), sl_v3(2, 0, 0), sl_v3(0, 0, 2), leaf);
    light_world w = light_world_make(&mesh);
    for (size_t e = 0; e < 3; e++) {
        set_estimator(&w, estimators[e]);
        assert_share(sample_light(&w, 0, sl_v3(0, 0, 0), up), 2.0 * rectangle_form(0, 0.5, 0, 0.5, 2), 0.02);
    }
    light_world_free(&w);
}

/* ---- kinds of lights ---- */

static void two_sided_lights_shine_to_both_sides(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, -0.5f, -0.5f, 1, 1, 0);
    mesh.materials[0].emission_two_sided = true;
    /* above x > 0, halfway up */
    trace_mesh_quad(&mesh, sl_v3(0, 1, -9), sl_v3(9, 0, 0), sl_v3(0, 0, 18), add_grey(&mesh));
    light_world w = light_world_make(&mesh);
    double open = 4.0 * rectangle_form(0, 0.5, 0, 0.5, 2);
    for (size_t e = 0; e < 3; e++) {
        set_estimator(&w, estimators[e]);
        bool raw = estimators[e] == SL_LIGHT_LOOK_AT;
        assert_share(sample_light(&w, 0, sl_v3(0, -2, 0), up), open, raw ? 0.01 : 1e-6);
        assert_share(sample_light(&w, 0, sl_v3(0, 2, 0), sl_v3(0, -1, 0)), 0.5 * open, 0.03);
    }
    light_world_free(&w);
}

/* A ball behind a sheet that covers all that lies right of the line to its middle; and seen from close by. */
static void a_solid_light_is_hidden_by_halves(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t lamp = trace_mesh_lamp(&mesh, 1);
    trace_mesh_sphere(&mesh, sl_v3(0, 2, 0), 0.3f, 24, 0.0f, false, lamp);
    trace_mesh_quad(&mesh, sl_v3(0, 1, -9), sl_v3(9, 0, 0), sl_v3(0, 0, 18), add_grey(&mesh));
    light_world w = light_world_make(&mesh);
    double ball = 0.09 / 4.0;
    for (size_t e = 0; e < 3; e++) {
        set_estimator(&w, estimators[e]);
        assert_share(sample_light(&w, 0, sl_v3(0, 0, 0), up), 0.5 * ball, 0.03);
        assert_share(sample_light(&w, 0, sl_v3(0, 2.0f - 0.303f, 0), up), 0.09 / (0.303 * 0.303), 0.03);
        assert_true(sample_light(&w, 0, sl_v3(0, 2, 0), up) == 0.0); /* within it */
    }
    light_world_free(&w);
}

/* A hollow ball that shines inwards is not convex from where it is seen: rays count it from within, and from
 * outside its back is nearest. */
static void a_hollow_light_counts_what_is_seen_of_it(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t lamp = trace_mesh_lamp(&mesh, 1);
    trace_mesh_sphere(&mesh, sl_v3(0, 0, 0), 1.0f, 8, 0.0f, true, lamp);
    light_world w = light_world_make(&mesh);
    assert_int_equal(w.lights->count, 1);
    assert_int_equal(w.lights->light[0].kind, SL_SOURCE_SOLID);
    assert_near(sample_light(&w, 0, sl_v3(0, 0, 0), up), 1.0, 0.1); /* all around: no frustum holds it */
    assert_true(sample_light(&w, 0, sl_v3(0, -3, 0), up) < 0.02);
    light_world_free(&w);
}

/* Triangles at random, some of which shine: F is finite, not negative, at most 1 of area lights (beyond
 * rounding and coarse pixels), and the same when asked again, after others were. */
static void samples_of_anything_are_finite_and_repeat(void **unused) {
    for (uint64_t seed = 0; seed < 6; seed++) {
        trace_mesh mesh = trace_mesh_begin();
        uint32_t material[4] = {add_grey(&mesh), trace_mesh_lamp(&mesh, 1), add_grey(&mesh),
                                trace_mesh_lamp(&mesh, 2)};
        mesh.materials[material[3]].emission_two_sided = true;
        uint64_t key = sl_random_key(9, seed), next = 0;
        float spread = seed % 2 ? 1e-3f : 1.0f;
        for (int t = 0; t < 120; t++) {
            uint32_t v[3];
            for (int k = 0; k < 3; k++) {
                v[k] = trace_mesh_vertex(&mesh, sl_random_unit(key, next), sl_random_unit(key, next + 1),
                                         spread * sl_random_unit(key, next + 2));
                next += 3;
            }
            trace_mesh_triangle(&mesh, v[0], v[1], v[2],
                                material[t % 40 == 0   ? 1
                                         : t % 40 == 1 ? 3
                                                       : t % 2 * 2]);
        }
        mesh.lights[0] = (sl_light){SL_LIGHT_SPOT, {0.5f, 0.5f, 0.5f}, {0, -1, 0}, {1, 1, 1}, 0.5f, 0.5f};
        mesh.light_count = 1;
        light_world w = light_world_make(&mesh);
        for (size_t e = 0; e < 3; e++) {
            set_estimator(&w, estimators[e]);
            static double first[8][150];
            assert_true(w.lights->count <= 8);
            for (int again = 0; again < 2; again++) {
                for (uint64_t i = 0; i < 150; i++) {
                    uint64_t k = again ? 149 - i : i, at = sl_random_key(10 + seed, k);
                    sl_vec3 p =
                        sl_v3(sl_random_unit(at, 0), sl_random_unit(at, 1), spread * sl_random_unit(at, 2));
                    if (k % 5 == 0) p = sl_scene_position(w.scene, (uint32_t)(k % w.scene->vertex_count));
                    sl_vec3 n = sl_v3(sl_random_unit(at, 3) - 0.5f, sl_random_unit(at, 4) - 0.5f,
                                      sl_random_unit(at, 5) - 0.5f);
                    for (size_t l = 0; l < w.lights->count; l++) {
                        double f = sample_light(&w, l, p, n);
                        if (again) assert_true(f == first[l][k]);
                        else first[l][k] = f;
                        if (estimators[e] == SL_LIGHT_RATIO && w.lights->light[l].kind == SL_SOURCE_AREA)
                            assert_true(f <= 1.0 + 1e-6);
                    }
                }
            }
        }
        light_world_free(&w);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_touching_light_has_its_limits),
        cmocka_unit_test(a_light_edge_on_gives_nothing_and_next_to_it_next_to_nothing),
        cmocka_unit_test(nothing_in_between_needs_no_picture),
        cmocka_unit_test(lights_thinner_than_pixels_are_hidden_as_a_whole_or_not_at_all),
        cmocka_unit_test(an_occluder_that_all_but_touches_the_point_hides_what_is_behind_it),
        cmocka_unit_test(a_surface_does_not_hide_light_from_itself),
        cmocka_unit_test(a_wall_that_a_point_touches_does_not_hide_what_is_before_it),
        cmocka_unit_test(alpha_masks_let_their_share_through),
        cmocka_unit_test(two_sided_lights_shine_to_both_sides),
        cmocka_unit_test(a_solid_light_is_hidden_by_halves),
        cmocka_unit_test(a_hollow_light_counts_what_is_seen_of_it),
        cmocka_unit_test(samples_of_anything_are_finite_and_repeat),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
