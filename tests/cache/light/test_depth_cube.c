/* Depth cubes around lights: against rays, on lit planes, at contacts, and which of their faces are drawn. */
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/random.h"
#include "cache/light/depth_cube.h"
#include "trace/trace.h"
#include "trace_scenes.h"

/* ---- a scene with its cubes ---- */

typedef struct {
    sl_scene *scene;
    sl_raster *raster;
    sl_light_source light; /* the scene's, or the middle of its lamp */
    sl_depth_cube cube;
    sl_counters counters;
} world;

static sl_light_source eye_of(const sl_scene *s) {
    if (s->light_count) return sl_light_source_of(&s->lights[0]);
    /* half of a parallelogram: its middle is that of the longest side */
    const sl_emitter *e = &s->emitters[0];
    const sl_vec3 a = sl_scene_position(s, s->vertex[0][e->triangle]),
                  c = sl_scene_position(s, s->vertex[2][e->triangle]);
    return (sl_light_source){.kind = SL_SOURCE_AREA,
                          .position = sl_scale(sl_add(a, c), 0.5f),
                          .direction = sl_scene_geometric_normal(s, e->triangle),
                          .two_sided = e->two_sided};
}

static world world_of(trace_mesh *mesh, int size, unsigned threads) {
    world w = {.scene = trace_mesh_build(mesh)};
    sl_error error = {0};
    w.light = eye_of(w.scene);
    bool ok = sl_raster_create(w.scene, threads, &w.raster, &error) == SL_OK &&
              sl_depth_cube_draw(w.scene, w.raster, &w.light, false, size, threads, &w.cube, &w.counters,
                                 &error) == SL_OK;
    if (!ok) fail_msg("%s", error.message);
    return w;
}

static void discard(world *w) {
    sl_depth_cube_release(&w->cube);
    sl_raster_destroy(w->raster);
    sl_scene_destroy(w->scene);
}

static float lit_at(const world *w, sl_vec3 p, sl_vec3 n) {
    float lit = 1.0f;
    const sl_light_points at = {1, &p.x, &p.y, &p.z, &n.x, &n.y, &n.z, &n.x, &n.y, &n.z};
    const sl_depth_cube *cube = &w->cube;
    const sl_cube_looks looks = {1, 1, &cube};
    SL_KERNEL_OF(sl_isa_best(), sl_depth_cube_lit)(&at, &looks, &lit);
    return lit;
}

static sl_light point_light(float x, float y, float z) {
    return (sl_light){.type = SL_LIGHT_POINT, .position = {x, y, z}, .intensity = {1, 1, 1}};
}

static uint32_t grey(trace_mesh *mesh) { return trace_mesh_diffuse(mesh, 0.5f); }

/* A room with boxes and balls. */
static trace_mesh furnished(void) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t m = grey(&mesh);
    trace_mesh_box(&mesh, sl_v3(0, 0, 0), sl_v3(4, 3, 5), true, m);
    trace_mesh_box(&mesh, sl_v3(0.5f, 0, 0.7f), sl_v3(1.2f, 1.1f, 1.6f), false, m);
    trace_mesh_box(&mesh, sl_v3(2.9f, 0.4f, 3.1f), sl_v3(3.3f, 0.9f, 4.2f), false, m);
    trace_mesh_sphere(&mesh, sl_v3(2.2f, 0.6f, 1.3f), 0.45f, 12, 0, false, m);
    trace_mesh_sphere(&mesh, sl_v3(1.2f, 2.1f, 3.7f), 0.35f, 12, 0, false, m);
    return mesh;
}

/* ---- against rays ---- */

/* Is the light seen from p? */
static bool seen(const sl_tracer *tracer, sl_vec3 p, sl_vec3 n, const sl_light_source *light, uint32_t own) {
    sl_ray16 ray;
    sl_counters counters = {{0}};
    p = sl_mad(p, 1e-5f, n);
    bool far = light->kind == SL_SOURCE_DIRECTIONAL;
    sl_vec3 d = far ? sl_neg(light->direction) : sl_sub(light->position, p);
    sl_ray16_set(&ray, 0, p, d, 0.0f, far ? INFINITY : 1.0f - 1e-5f, own);
    return !sl_trace_occluded(tracer, &ray, 1, false, &counters);
}

/* p moved within its plane by (i, k) times `step` as seen from the light. */
static sl_vec3 beside(sl_vec3 p, sl_vec3 n, const sl_light_source *light, int i, int k, float step) {
    bool far = light->kind == SL_SOURCE_DIRECTIONAL;
    sl_vec3 d = far ? light->direction : sl_sub(p, light->position);
    float length = sl_length(d);
    sl_frame f = sl_frame_from_normal(sl_scale(d, 1.0f / length));
    sl_vec3 to = sl_mad(sl_mad(sl_v3(0, 0, 0), (float)i * step, f.x), (float)k * step, f.y);
    if (far) return sl_mad(sl_add(p, to), -sl_dot(n, to) / sl_dot(n, f.z), f.z);
    sl_vec3 ray = sl_mad(d, length, to);
    return sl_mad(light->position, sl_dot(n, d) / sl_dot(n, ray), ray);
}

static sl_vec3 random_point(const sl_scene *s, uint64_t i, uint32_t *triangle) {
    uint64_t key = sl_random_key(5, 0);
    *triangle = (uint32_t)(sl_random_unit(key, 3 * i) * (float)s->triangle_count);
    if (i % 2) *triangle %= 12; /* the walls, which are large */
    float u = sl_random_unit(key, 3 * i + 1), v = sl_random_unit(key, 3 * i + 2);
    if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
    sl_vec3 a = sl_scene_position(s, s->vertex[0][*triangle]),
            b = sl_scene_position(s, s->vertex[1][*triangle]);
    sl_vec3 c = sl_scene_position(s, s->vertex[2][*triangle]);
    return sl_mad(sl_mad(a, u, sl_sub(b, a)), v, sl_sub(c, a));
}

static void compare_with_rays(trace_mesh *mesh, sl_light light, int size, float step, int least_dark) {
    mesh->lights[mesh->light_count++] = light;
    world w = world_of(mesh, size, 2);
    sl_tracer *tracer = tracer_of(w.scene);
    int compared = 0, dark = 0;
    for (uint64_t i = 0; i < 6000; i++) {
        uint32_t own;
        const sl_light_source *l = &w.light;
        sl_vec3 p = random_point(w.scene, i, &own), n = sl_scene_geometric_normal(w.scene, own);
        sl_vec3 to = l->kind == SL_SOURCE_DIRECTIONAL ? sl_neg(l->direction) : sl_sub(l->position, p);
        if (sl_dot(n, to) < 0.0f) n = sl_neg(n);
        if (sl_dot(n, to) < 0.02f * sl_length(to)) continue;
        int visible = 0;
        for (int k = 0; k < 25; k++)
            visible += seen(tracer, beside(p, n, l, k % 5 - 2, k / 5 - 2, step), n, l, own);
        if (visible != 0 && visible != 25) continue;
        float lit = lit_at(&w, p, n);
        if (lit != (visible ? 1.0f : 0.0f))
            fail_msg("(%g %g %g): %g, rays say %d", p.x, p.y, p.z, lit, visible);
        compared++;
        dark += !visible;
    }
    assert_true(compared > 2500 && dark > least_dark);
    sl_tracer_destroy(tracer);
    discard(&w);
}

static void a_cube_says_what_rays_say_but_within_a_texel_of_edges(void **state) {
    for (int size = 128; size <= 512; size *= 2) {
        trace_mesh mesh = furnished();
        compare_with_rays(&mesh, point_light(2.1f, 2.4f, 2.3f), size, 0.75f * 2.0f / (float)(size - 2), 150);
    }
}

static void a_directional_light_s_map_says_what_rays_say(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t m = grey(&mesh);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 5), sl_v3(4, 0, 0), sl_v3(0, 0, -5), m);
    trace_mesh_box(&mesh, sl_v3(0.5f, 0, 0.7f), sl_v3(1.2f, 1.1f, 1.6f), false, m);
    trace_mesh_sphere(&mesh, sl_v3(2.2f, 1.0f, 2.3f), 0.7f, 12, 0, false, m);
    sl_vec3 way = sl_normalize_or(sl_v3(0.3f, -1, 0.2f), sl_v3(0, -1, 0));
    compare_with_rays(&mesh,
                      (sl_light){.type = SL_LIGHT_DIRECTIONAL, .direction = way, .intensity = {1, 1, 1}}, 256,
                      0.022f, 40);
}

/* ---- planes ---- */

static void a_lit_plane_does_not_shadow_itself_however_tilted_and_across_faces(void **state) {
    for (int i = 0; i < 24; i++) {
        uint64_t key = sl_random_key(9, (uint64_t)i);
        sl_vec3 n = sl_normalize_or(sl_v3(sl_random_unit(key, 0) - 0.5f, sl_random_unit(key, 1) - 0.5f,
                                          sl_random_unit(key, 2) - 0.5f),
                                    sl_v3(0, 1, 0));
        sl_frame f = sl_frame_from_normal(n);
        float away = i % 3 ? 0.3f : 0.02f; /* one in three is grazed */
        sl_vec3 at = sl_v3(3, -2, 1), corner = sl_mad(sl_mad(sl_mad(at, -away, n), -2.0f, f.x), -2.0f, f.y);
        trace_mesh mesh = trace_mesh_begin();
        trace_mesh_quad(&mesh, corner, sl_scale(f.x, 4), sl_scale(f.y, 4), grey(&mesh));
        mesh.lights[mesh.light_count++] = point_light(at.x, at.y, at.z);
        world w = world_of(&mesh, i % 2 ? 512 : 100, 1);
        for (int k = 0; k < 120 * 120; k++) {
            sl_vec3 p = sl_mad(sl_mad(corner, 4.0f * ((float)(k % 120) + 0.37f) / 120.0f, f.x),
                               4.0f * ((float)(k / 120) + 0.61f) / 120.0f, f.y);
            assert_true(lit_at(&w, p, n) == 1.0f);
        }
        discard(&w);
    }
}

static void a_thin_blocker_on_a_floor_leaves_a_gap_of_less_than_a_texel(void **state) {
    const int sizes[] = {64, 128, 512};
    for (int s = 0; s < 3; s++) {
        trace_mesh mesh = trace_mesh_begin();
        uint32_t m = grey(&mesh);
        trace_mesh_quad(&mesh, sl_v3(-2, 0, 2), sl_v3(4, 0, 0), sl_v3(0, 0, -4), m);
        trace_mesh_quad(&mesh, sl_v3(0.3f, 0, -0.5f), sl_v3(0, 0.6f, 0), sl_v3(0, 0, 1), m);
        mesh.lights[mesh.light_count++] = point_light(-0.35f, 1, 0.1f);
        world w = world_of(&mesh, sizes[s], 1);
        float texel = 2.0f / (float)(sizes[s] - 2); /* on the floor, 1 below */
        for (int i = 0; i < 400; i++) {
            float z = -0.3f + 0.6f * (float)i / 400.0f;
            assert_true(lit_at(&w, sl_v3(0.3f + texel, 0, z), sl_v3(0, 1, 0)) < 0.5f);
            assert_true(lit_at(&w, sl_v3(0.3f + 2.0f * texel, 0, z), sl_v3(0, 1, 0)) == 0.0f);
            assert_true(lit_at(&w, sl_v3(0.3f - 2.0f * texel, 0, z), sl_v3(0, 1, 0)) == 1.0f);
        }
        discard(&w);
    }
}

/* ---- area lights, spots, and what is skipped ---- */

static uint64_t skipped(const world *w) { return w->counters.value[SL_COUNT_RASTER_PASSES_SKIPPED]; }
static uint64_t drawn(const world *w) { return w->counters.value[SL_COUNT_RASTER_PASSES]; }

static trace_mesh closed_room(void) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_box(&mesh, sl_v3(-1, 0, -1), sl_v3(1, 2, 1), true, grey(&mesh));
    return mesh;
}

static void an_area_light_does_not_shadow_what_it_lights_and_its_back_is_not_drawn(void **state) {
    trace_mesh mesh = closed_room();
    trace_mesh_quad(&mesh, sl_v3(-0.3f, 1.99f, -0.3f), sl_v3(0.6f, 0, 0), sl_v3(0, 0, 0.6f),
                    trace_mesh_lamp(&mesh, 5));
    world w = world_of(&mesh, 128, 1);
    assert_int_equal(drawn(&w), 5);
    assert_int_equal(skipped(&w), 1);
    for (int i = 0; i < 900; i++) {
        float u = -0.95f + 1.9f * (float)(i % 30) / 29.0f, v = -0.95f + 1.9f * (float)(i / 30) / 29.0f;
        assert_true(lit_at(&w, sl_v3(u, 0, v), sl_v3(0, 1, 0)) == 1.0f);
        assert_true(lit_at(&w, sl_v3(-1, 0.95f + v, u), sl_v3(1, 0, 0)) == 1.0f);
    }
    discard(&w);
}

static void a_two_sided_light_sees_both_its_sides(void **state) {
    trace_mesh mesh = closed_room();
    uint32_t both = trace_mesh_lamp(&mesh, 5), m = grey(&mesh);
    mesh.materials[both].emission_two_sided = true;
    trace_mesh_quad(&mesh, sl_v3(-0.3f, 1, -0.3f), sl_v3(0.6f, 0, 0), sl_v3(0, 0, 0.6f), both);
    trace_mesh_quad(&mesh, sl_v3(-0.1f, 0.7f, -0.1f), sl_v3(0.2f, 0, 0), sl_v3(0, 0, 0.2f), m);
    trace_mesh_quad(&mesh, sl_v3(-0.9f, 1.1f, -0.2f), sl_v3(0, 0.2f, 0), sl_v3(0, 0, 0.4f), m);
    world w = world_of(&mesh, 256, 1);
    assert_int_equal(drawn(&w), 10);
    assert_true(lit_at(&w, sl_v3(0, 0, 0), sl_v3(0, 1, 0)) == 0.0f);
    assert_true(lit_at(&w, sl_v3(0.8f, 0, 0), sl_v3(0, 1, 0)) == 1.0f);
    assert_true(lit_at(&w, sl_v3(0, 2, 0), sl_v3(0, -1, 0)) == 1.0f);
    assert_true(lit_at(&w, sl_v3(-1, 1.22f, 0), sl_v3(1, 0, 0)) == 0.0f);
    assert_true(lit_at(&w, sl_v3(-1, 0.78f, 0), sl_v3(1, 0, 0)) == 1.0f);
    discard(&w);
}

static void faces_outside_a_spot_s_cone_and_faces_without_geometry_are_skipped(void **state) {
    const float cosines[] = {0.9f, 0.72f, 0.6f, -0.5f, -0.6f, -1.0f};
    const uint64_t faces[] = {1, 1, 5, 5, 6, 6};
    for (int i = 0; i < 6; i++) {
        trace_mesh mesh = closed_room();
        mesh.lights[mesh.light_count++] = (sl_light){.type = SL_LIGHT_SPOT,
                                                     .position = {0, 1, 0},
                                                     .direction = {0, -1, 0},
                                                     .intensity = {1, 1, 1},
                                                     .cos_inner = cosines[i],
                                                     .cos_outer = cosines[i]};
        world w = world_of(&mesh, 64, 1);
        assert_int_equal(drawn(&w), faces[i]);
        assert_int_equal(skipped(&w), 6 - faces[i]);
        discard(&w);
    }
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_quad(&mesh, sl_v3(-0.5f, 0, 0.5f), sl_v3(1, 0, 0), sl_v3(0, 0, -1), grey(&mesh));
    mesh.lights[mesh.light_count++] = point_light(0, 3, 0);
    world w = world_of(&mesh, 64, 1);
    assert_int_equal(drawn(&w), 1);
    assert_int_equal(skipped(&w), 5);
    assert_true(lit_at(&w, sl_v3(0, 5, 0), sl_v3(0, -1, 0)) == 1.0f);
    /* A light that has gone out. */
    sl_depth_cube_release(&w.cube);
    assert_int_equal(sl_depth_cube_draw(w.scene, w.raster, &w.light, true, 64, 1, &w.cube, &w.counters, NULL),
                     SL_OK);
    assert_int_equal(drawn(&w), 1);
    assert_int_equal(skipped(&w), 5 + 6);
    assert_true(lit_at(&w, sl_v3(0, 0, 0), sl_v3(0, 1, 0)) == 1.0f);
    discard(&w);
}

/* A narrow spot's texels are as much smaller as its cone is narrower than a face: the edge of a shadow that
 * falls across it lies where it should to a fraction of a cube's texel. */
static void a_narrow_spot_has_all_of_its_texels_in_its_cone(void **state) {
    for (int narrow = 0; narrow < 2; narrow++) {
        trace_mesh mesh = closed_room();
        trace_mesh_quad(&mesh, sl_v3(0.03f, 0.5f, 0.5f), sl_v3(0.5f, 0, 0), sl_v3(0, 0, -1), 0);
        mesh.lights[mesh.light_count++] = (sl_light){.type = SL_LIGHT_SPOT,
                                                     .position = {0, 1, 0},
                                                     .direction = {0, -1, 0},
                                                     .intensity = {1, 1, 1},
                                                     .cos_inner = 0.99f,
                                                     .cos_outer = narrow ? 0.98f : 0.72f};
        world w = world_of(&mesh, 64, 1);
        float first = 0.0f, last = 0.0f; /* the edge lies at 0.06 */
        for (int i = 0; i < 2000; i++) {
            float x = 0.0001f * (float)i, lit = lit_at(&w, sl_v3(x, 0, 0.01f), sl_v3(0, 1, 0));
            if (lit == 1.0f) first = x;
            if (lit > 0.0f) last = x;
        }
        float texel = 2.0f / 62.0f * (narrow ? 0.203f : 0.964f);
        assert_true(last - first < 1.1f * texel && first < 0.06f + texel && last > 0.06f - texel);
        discard(&w);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cube_says_what_rays_say_but_within_a_texel_of_edges),
        cmocka_unit_test(a_directional_light_s_map_says_what_rays_say),
        cmocka_unit_test(a_lit_plane_does_not_shadow_itself_however_tilted_and_across_faces),
        cmocka_unit_test(a_thin_blocker_on_a_floor_leaves_a_gap_of_less_than_a_texel),
        cmocka_unit_test(an_area_light_does_not_shadow_what_it_lights_and_its_back_is_not_drawn),
        cmocka_unit_test(a_two_sided_light_sees_both_its_sides),
        cmocka_unit_test(faces_outside_a_spot_s_cone_and_faces_without_geometry_are_skipped),
        cmocka_unit_test(a_narrow_spot_has_all_of_its_texels_in_its_cone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
