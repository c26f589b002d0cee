/* Points inside other geometry: which surfaces are solids, and which points they hold. */
#include <math.h>

#include "unit_test.h"
#include "base/random.h"
#include "cache/patches/solids.h"
#include "trace_scenes.h"

typedef struct world {
    sl_scene *scene;
    sl_solids *solids;
} world;

static world world_of(trace_mesh *parts) {
    world w = {.scene = trace_mesh_build(parts)};
    assert_int_equal(sl_solids_find(w.scene, &w.solids, NULL), SL_OK);
    return w;
}

static void discard(world *w) {
    sl_solids_destroy(w->solids);
    sl_scene_destroy(w->scene);
}

static trace_mesh begin(void) {
    trace_mesh m = trace_mesh_begin();
    trace_mesh_diffuse(&m, 0.5f);
    trace_mesh_lamp(&m, 5.0f);
    return m;
}

/* ---- which are solids ---- */

static void assert_hidden(const sl_solids *s, uint32_t first, uint32_t count, bool hidden) {
    for (uint32_t i = first; i < first + count; i++) assert_int_equal(sl_solids_hide_back(s, i), hidden);
}

static void backs_of_closed_boxes_are_hidden_and_those_of_rooms_are_not(void **state) {
    for (int inside = 0; inside < 2; inside++) {
        trace_mesh parts = begin();
        trace_mesh_quad(&parts, sl_v3(-5, 0, 5), sl_v3(10, 0, 0), sl_v3(0, 0, -10), 0);
        trace_mesh_box(&parts, sl_v3(0, 0, 0), sl_v3(1, 1, 1), inside == 1, 0);
        trace_mesh_quad(&parts, sl_v3(-1, 4, 0), sl_v3(1, 0, 0), sl_v3(0, 0, 1), 1);
        trace_mesh_sphere(&parts, sl_v3(3, 1, 0), 0.5f, 6, 0.1f, inside == 1, 0);
        world w = world_of(&parts);
        assert_hidden(w.solids, 0, 2, false);
        assert_hidden(w.solids, 2, 12, inside == 0);
        assert_hidden(w.solids, 14, 2, false);
        assert_hidden(w.solids, 16, (uint32_t)w.scene->triangle_count - 16, inside == 0);
        discard(&w);
    }
}

static void what_is_open_wound_both_ways_or_flat_hides_nothing(void **state) {
    trace_mesh parts = begin();
    trace_mesh_box(&parts, sl_v3(0, 0, 0), sl_v3(1, 1, 1), false, 0);
    parts.triangle_count--;                              /* a hole */
    trace_mesh_box(&parts, sl_v3(2, 0, 0), sl_v3(3, 1, 1), false, 0);
    uint32_t *turned = &parts.indices[3 * (parts.triangle_count - 1)], corner = turned[0];
    turned[0] = turned[1];
    turned[1] = corner;
    trace_mesh_quad(&parts, sl_v3(4, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0); /* two sheets back to back */
    uint32_t base = 3 * (uint32_t)(parts.triangle_count - 2);
    for (uint32_t i = 0; i < 2; i++)
        trace_mesh_triangle(&parts, parts.indices[base + 3 * i], parts.indices[base + 3 * i + 2],
                            parts.indices[base + 3 * i + 1], 0);
    trace_mesh_box(&parts, sl_v3(0, 5, 0), sl_v3(1, 6, 1), false, 0);
    /* they share a face's four corners: four triangles along its edges */
    trace_mesh_box(&parts, sl_v3(1, 5, 0), sl_v3(2, 6, 1), false, 0);
    world w = world_of(&parts);
    assert_hidden(w.solids, 0, (uint32_t)w.scene->triangle_count, false);
    discard(&w);
}

static void a_box_with_light_inside_hides_nothing(void **state) {
    enum { LAMP_INSIDE, LAMP_OUTSIDE, POINT_INSIDE, POINT_OUTSIDE, SUN, CASES };
    static const bool wanted[CASES] = {false, true, false, true, true};
    for (int i = 0; i < CASES; i++) {
        trace_mesh parts = begin();
        trace_mesh_box(&parts, sl_v3(0, 0, 0), sl_v3(4, 3, 4), false, 0);
        trace_mesh_quad(&parts, sl_v3(1, i == LAMP_INSIDE ? 2.9f : 3.5f, 1), sl_v3(1, 0, 0), sl_v3(0, 0, 1),
                        i <= LAMP_OUTSIDE ? 1 : 0);
        if (i >= POINT_INSIDE) {
            parts.lights[parts.light_count++] =
                (sl_light){.type = i == SUN ? SL_LIGHT_DIRECTIONAL : SL_LIGHT_POINT,
                           .position = {2, i == POINT_OUTSIDE ? 9 : 1, 2},
                           .direction = {0, -1, 0},
                           .intensity = {1, 1, 1}};
        }
        world w = world_of(&parts);
        assert_hidden(w.solids, 0, 12, wanted[i]);
        discard(&w);
    }
}

/* ---- which points they hold ---- */

static bool holds(const world *w, const sl_tracer *tracer, sl_vec3 at, sl_vec3 normal, const sl_vec3 *eye,
                  sl_counters *counters) {
    return sl_solids_hold(w->solids, tracer, &(sl_lit_point){at, normal, normal, SL_NO_INDEX}, eye, counters);
}

/* A sealed box with a lamp in it stands on a floor. */
static void a_lit_box_is_solid_to_eyes_outside_only(void **state) {
    trace_mesh parts = begin();
    trace_mesh_box(&parts, sl_v3(0, 0, 0), sl_v3(1, 1, 1), false, 0);
    trace_mesh_quad(&parts, sl_v3(0.4f, 0.9f, 0.4f), sl_v3(0.2f, 0, 0), sl_v3(0, 0, 0.2f), 1);
    trace_mesh_quad(&parts, sl_v3(-5, 0, 5), sl_v3(10, 0, 0), sl_v3(0, 0, -10), 0);
    world w = world_of(&parts);
    sl_tracer *tracer = tracer_of(w.scene);
    sl_counters counters = {0};
    const sl_vec3 at = {0.2f, 0, 0.3f}, up = {0, 1, 0}, outside = {3, 3, 3}, inside = {0.5f, 0.5f, 0.5f};
    assert_true(holds(&w, tracer, at, up, &outside, &counters));
    assert_false(holds(&w, tracer, at, up, &inside, &counters));
    assert_false(holds(&w, tracer, at, up, NULL, &counters));
    assert_true(sl_solids_eye_matters(w.solids, inside, outside) &&
                !sl_solids_eye_matters(w.solids, outside, outside));
    sl_tracer_destroy(tracer);
    discard(&w);
}

/* Boxes, some of them standing on others. */
static const float boxes[][6] = {{0, 0, 0, 1, 1, 1}, {0.25f, 1, 0.25f, 0.75f, 2, 0.75f},
                                 {3, 0, 0, 6, 3, 3}, {0.1f, 2, 0.1f, 0.9f, 2.5f, 0.9f}};
enum { BOXES = sizeof boxes / sizeof boxes[0] };

static trace_mesh furniture(void) {
    trace_mesh parts = begin();
    for (int b = 0; b < BOXES; b++)
        trace_mesh_box(&parts, sl_v3(boxes[b][0], boxes[b][1], boxes[b][2]),
                       sl_v3(boxes[b][3], boxes[b][4], boxes[b][5]), false, 0);
    trace_mesh_quad(&parts, sl_v3(-5, 0, 8), sl_v3(15, 0, 0), sl_v3(0, 0, -13), 0);
    trace_mesh_quad(&parts, sl_v3(-5, 6, -5), sl_v3(15, 0, 0), sl_v3(0, 0, 13), 1);
    return parts;
}

/* Signed distance from all boxes' surfaces: negative inside one. */
static float depth_in_boxes(sl_vec3 p, float *nearest) {
    float least = INFINITY;
    *nearest = INFINITY;
    for (int b = 0; b < BOXES; b++) {
        float x = fmaxf(boxes[b][0] - p.x, p.x - boxes[b][3]),
              y = fmaxf(boxes[b][1] - p.y, p.y - boxes[b][4]),
              z = fmaxf(boxes[b][2] - p.z, p.z - boxes[b][5]);
        float d = fmaxf(x, fmaxf(y, z));
        least = fminf(least, d);
        *nearest = fminf(*nearest, fabsf(d));
    }
    return least;
}

static void points_inside_of_solids_are_known_from_those_outside(void **state) {
    trace_mesh parts = furniture();
    world w = world_of(&parts);
    sl_tracer *tracer = tracer_of(w.scene);
    uint64_t key = sl_random_key(8, 1);
    size_t inside = 0;
    for (uint64_t i = 0; i < 4000; i++) {
        sl_vec3 p = sl_v3(7 * sl_random_unit(key, 3 * i) - 0.5f, 4 * sl_random_unit(key, 3 * i + 1) - 0.5f,
                          4 * sl_random_unit(key, 3 * i + 2) - 0.5f);
        sl_counters counters = {0};
        float nearest;
        bool wanted = depth_in_boxes(p, &nearest) < 0.0f;
        if (nearest < 0.001f) continue;
        assert_int_equal(holds(&w, tracer, p, sl_v3(0, 1, 0), NULL, &counters), wanted);
        inside += wanted;
    }
    assert_true(inside > 600);
    sl_tracer_destroy(tracer);
    discard(&w);
}

static void a_floor_is_inside_where_a_leg_stands_on_it_and_a_leg_is_not(void **state) {
    trace_mesh parts = furniture();
    world w = world_of(&parts);
    sl_tracer *tracer = tracer_of(w.scene);
    sl_counters counters = {0};
    for (int y = 0; y < 20; y++)
        for (int x = 0; x < 60; x++) {
            sl_vec3 p = sl_v3(-0.4f + 0.11f * (float)x, 0, -0.45f + 0.19f * (float)y);
            bool wanted = false;
            for (int b = 0; b < BOXES; b++)
                wanted |= boxes[b][1] == 0.0f && p.x > boxes[b][0] && p.x < boxes[b][3] &&
                          p.z > boxes[b][2] && p.z < boxes[b][5];
            assert_int_equal(holds(&w, tracer, p, sl_v3(0, 1, 0), NULL, &counters), wanted);
        }
    /* The first box's own side, top, and top where the second one stands. */
    assert_false(holds(&w, tracer, sl_v3(0, 0.3f, 0.3f), sl_v3(-1, 0, 0), NULL, &counters));
    assert_false(holds(&w, tracer, sl_v3(0.9f, 1, 0.1f), sl_v3(0, 1, 0), NULL, &counters));
    assert_true(holds(&w, tracer, sl_v3(0.5f, 1, 0.5f), sl_v3(0, 1, 0), NULL, &counters));
    sl_tracer_destroy(tracer);
    discard(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(backs_of_closed_boxes_are_hidden_and_those_of_rooms_are_not),
        cmocka_unit_test(what_is_open_wound_both_ways_or_flat_hides_nothing),
        cmocka_unit_test(a_box_with_light_inside_hides_nothing),
        cmocka_unit_test(a_lit_box_is_solid_to_eyes_outside_only),
        cmocka_unit_test(points_inside_of_solids_are_known_from_those_outside),
        cmocka_unit_test(a_floor_is_inside_where_a_leg_stands_on_it_and_a_leg_is_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
