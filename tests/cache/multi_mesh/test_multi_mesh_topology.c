/* Faces, the corners and edges that they share, and solids. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/math.h"
#include "base/random.h"
#include "cache/multi_mesh/topology.h"
#include "trace_scenes.h"

typedef struct world {
    sl_scene *scene;
    sl_topology *topology;
} world;

static world world_of(trace_mesh *parts) {
    world w = {.scene = trace_mesh_build(parts)};
    assert_int_equal(sl_topology_create(w.scene, false, &w.topology, NULL), SL_OK);
    return w;
}

static void discard(world *w) {
    sl_topology_destroy(w->topology);
    sl_scene_destroy(w->scene);
}

static trace_mesh begin(void) {
    trace_mesh m = trace_mesh_begin();
    trace_mesh_material(&m, 0.5f, 0, 0, 0, 0);
    trace_mesh_material(&m, 0.0f, 0, 0, 0, 5.0f);
    return m;
}

/* What must hold of any: sites agree with the scene, edges list each face's three once, and name their sites. */
static void check(const sl_topology *t) {
    const sl_scene *scene = t->scene;
    size_t listed = 0;
    for (uint32_t f = 0; f < t->face_count; f++)
        for (int c = 0; c < 3; c++) {
            uint32_t site = t->site[c][f], a = t->site[(c + 1) % 3][f], b = t->site[(c + 2) % 3][f], e = t->edge[c][f], times = 0;
            sl_vec3 p = sl_scene_position(scene, scene->vertex[c][f / 2]), q = t->site_position[site];
            assert_true(site < t->site_count && p.x == q.x && p.y == q.y && p.z == q.z);
            assert_true(fabsf(sl_length(t->site_normal[site]) - 1.0f) < 1e-5f && sl_dot(t->site_normal[site], sl_face_normal(scene, f)) > -1e-4f);
            assert_true(t->site_face[site] <= f && (t->site_shared[site] || t->site_face[site] == f));
            assert_true(t->edge_low[e] == (a < b ? a : b) && t->edge_high[e] == (a < b ? b : a));
            for (uint32_t i = t->edge_start[e]; i < t->edge_start[e + 1]; i++) times += t->edge_face[i] == f;
            assert_int_equal(times, 1);
        }
    for (uint32_t e = 0; e < t->edge_count; e++)
        for (uint32_t i = t->edge_start[e]; i < t->edge_start[e + 1]; i++, listed++)
            assert_true(i == t->edge_start[e] || t->edge_face[i - 1] < t->edge_face[i]);
    assert_int_equal(listed, 3 * t->face_count);
}

static size_t faces_along(const sl_topology *t, int corner, uint32_t face) {
    uint32_t e = t->edge[corner][face];
    return t->edge_start[e + 1] - t->edge_start[e];
}

/* ---- sites and edges -------------------------------------------------------------------------------------------------- */

static void coplanar_triangles_share_corners_on_each_side_apart(void **state) {
    (void)state;
    trace_mesh parts = begin();
    trace_mesh_quad(&parts, sl_v3(0, 0, 0), sl_v3(2, 0, 0), sl_v3(0, 0, -3), 0);
    world w = world_of(&parts);
    check(w.topology);
    assert_int_equal(w.topology->site_count, 2 * 4);
    assert_int_equal(w.topology->edge_count, 2 * 5);
    for (uint32_t s = 0; s < 8; s++) assert_true(fabsf(w.topology->site_normal[s].y) == 1.0f);
    discard(&w);
}

static void a_box_has_three_sites_at_each_corner_on_either_side(void **state) {
    (void)state;
    trace_mesh parts = begin();
    trace_mesh_box(&parts, sl_v3(0, 0, 0), sl_v3(1, 2, 3), false, 0);
    world w = world_of(&parts);
    check(w.topology);
    assert_int_equal(w.topology->site_count, 2 * 8 * 3);
    assert_int_equal(w.topology->edge_count, 2 * 6 * 5);
    discard(&w);
}

/* A scene with normals given: two triangles bent along an edge, or three around it, smooth in that they have the same normal there. */
static sl_scene *bent(size_t triangles, float tilt, const sl_material *materials, size_t material_count) {
    static const float positions[] = {0, 0, 0, 0, 0, 1, 1, 0.2f, 0, -1, 0.2f, 0, 0.1f, 1, 0};
    float normals[15];
    for (int v = 0; v < 5; v++) {
        normals[3 * v] = v == 4 ? 0 : tilt * (float)v;
        normals[3 * v + 1] = 1;
        normals[3 * v + 2] = 0;
    }
    static const uint32_t indices[] = {0, 1, 2, 1, 0, 3, 0, 1, 4}, material_index[] = {0, 1, 0};
    sl_scene_parts parts = {.vertex_count = 5, .positions = positions, .normals = normals, .triangle_count = triangles, .indices = indices,
                            .material_count = material_count, .materials = materials, .material_index = material_count > 1 ? material_index : NULL};
    sl_scene *scene;
    assert_int_equal(sl_scene_build(&parts, &scene, NULL), SL_OK);
    return scene;
}

static void smooth_edges_are_shared_by_two_faces_or_three(void **state) {
    (void)state;
    sl_material material = {.diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
    for (size_t triangles = 2; triangles <= 3; triangles++) {
        world w = {.scene = bent(triangles, 0.0f, &material, 1)};
        assert_int_equal(sl_topology_create(w.scene, false, &w.topology, NULL), SL_OK);
        check(w.topology);
        assert_int_equal(faces_along(w.topology, 2, 0), triangles);
        assert_int_equal(w.topology->site_count, 2 * (2 + triangles));
        assert_int_equal(w.topology->edge_count, 2 * (1 + 2 * triangles));
        discard(&w);
    }
}

static void exponents_keep_sites_apart_where_asked(void **state) {
    (void)state;
    sl_material materials[2] = {{.specular = {0.5f, 0.5f, 0.5f}, .exponent = 10, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
                                {.specular = {0.5f, 0.5f, 0.5f}, .exponent = 20, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX}};
    for (int different = 0; different < 2; different++)
        for (int by_exponent = 0; by_exponent < 2; by_exponent++) {
            materials[1].exponent = different ? 20 : 10;
            world w = {.scene = bent(2, 0.0f, materials, 2)};
            assert_int_equal(sl_topology_create(w.scene, by_exponent == 1, &w.topology, NULL), SL_OK);
            check(w.topology);
            assert_int_equal(faces_along(w.topology, 2, 0), different && by_exponent ? 1 : 2);
            discard(&w);
        }
}

static void normals_within_a_ten_thousandth_of_a_radian_are_one(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        float angle = i == 0 ? 0.9e-4f : 1.2e-4f;
        static const float positions[] = {0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 1, -1, 0, 0};
        float normals[18] = {0};
        for (int v = 0; v < 6; v++) {
            normals[3 * v] = v >= 3 ? angle : 0.0f;
            normals[3 * v + 1] = 1;
        }
        static const uint32_t indices[] = {0, 1, 2, 4, 3, 5};
        sl_material material = {.diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
        sl_scene_parts parts = {.vertex_count = 6, .positions = positions, .normals = normals, .triangle_count = 2, .indices = indices,
                                .material_count = 1, .materials = &material};
        world w = {0};
        assert_int_equal(sl_scene_build(&parts, &w.scene, NULL), SL_OK);
        assert_int_equal(sl_topology_create(w.scene, false, &w.topology, NULL), SL_OK);
        check(w.topology);
        assert_int_equal(faces_along(w.topology, 2, 0), i == 0 ? 2 : 1);
        discard(&w);
    }
}

static void a_sphere_of_facets_and_all_its_edges_are_consistent(void **state) {
    (void)state;
    trace_mesh parts = begin();
    trace_mesh_sphere(&parts, sl_v3(1, 2, 3), 2.0f, 20, 0.2f, false, 0);
    world w = world_of(&parts);
    check(w.topology);
    assert_true(sl_topology_memory_bytes(w.topology) < 350 * w.scene->triangle_count); /* nothing is shared but within a facet */
    discard(&w);
}

/* Normals all over the sphere at one position, in pairs that are the same but for rounding: a site for each pair. */
static void thousands_of_normals_at_one_corner_are_kept_apart(void **state) {
    (void)state;
    enum { PAIRS = 4000, TRIANGLES = 2 * PAIRS };
    static float positions[9 * TRIANGLES], normals[9 * TRIANGLES];
    static uint32_t indices[3 * TRIANGLES];
    for (uint32_t t = 0; t < TRIANGLES; t++) {
        double z = 1.0 - 2.0 * (t / 2 + 0.5) / PAIRS, turn = 2.399963 * (t / 2), radius = sqrt(1.0 - z * z); /* a spiral: 0.05 radians apart */
        sl_vec3 n = sl_v3((float)(radius * sl_cos(turn)), (float)(radius * sl_sin(turn)), (float)z);
        sl_frame frame = sl_frame_from_normal(n);
        for (uint32_t c = 0; c < 3; c++) {
            sl_vec3 p = c == 0 ? sl_v3(0, 0, 0) : sl_scale(c == 1 ? frame.x : frame.y, 1.0f + 0.1f * (float)(t % 2));
            memcpy(&positions[9 * t + 3 * c], (float[3]){p.x, p.y, p.z}, 3 * sizeof(float));
            memcpy(&normals[9 * t + 3 * c], (float[3]){n.x, n.y, n.z + (t % 2 ? 0.7e-4f : 0.0f) * n.x}, 3 * sizeof(float));
            indices[3 * t + c] = 3 * t + c;
        }
    }
    sl_material material = {.diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
    sl_scene_parts parts = {.vertex_count = 3 * TRIANGLES, .positions = positions, .normals = normals, .triangle_count = TRIANGLES, .indices = indices,
                            .material_count = 1, .materials = &material};
    world w = {0};
    assert_int_equal(sl_scene_build(&parts, &w.scene, NULL), SL_OK);
    assert_int_equal(w.scene->triangle_count, TRIANGLES);
    assert_int_equal(sl_topology_create(w.scene, false, &w.topology, NULL), SL_OK);
    check(w.topology);
    size_t at_tip = 0;
    for (size_t s = 0; s < w.topology->site_count; s++) at_tip += sl_length(w.topology->site_position[s]) == 0.0f;
    for (uint32_t f = 0; f < w.topology->face_count; f += 4) assert_int_equal(w.topology->site[0][f], w.topology->site[0][f + 2]);
    assert_int_equal(at_tip, 2 * PAIRS);
    discard(&w);
}

static void needles_and_points_that_are_no_numbers_are_degenerate(void **state) {
    (void)state;
    trace_mesh parts = begin();
    trace_mesh_quad(&parts, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
    uint32_t a = trace_mesh_vertex(&parts, 0, 0, 2), b = trace_mesh_vertex(&parts, 1e-13f, 0, 2), c = trace_mesh_vertex(&parts, 0, 1, 2);
    trace_mesh_triangle(&parts, a, b, c, 0);
    uint32_t d = trace_mesh_vertex(&parts, 1, 1, 3), e = trace_mesh_vertex(&parts, 2, 1, 3), f = trace_mesh_vertex(&parts, 1, 2, 3);
    trace_mesh_triangle(&parts, d, e, f, 0);
    sl_scene *scene = trace_mesh_build(&parts);
    assert_int_equal(scene->triangle_count, 4);
    scene->position_y[scene->vertex[1][3]] = NAN;
    world w = {.scene = scene};
    assert_int_equal(sl_topology_create(scene, false, &w.topology, NULL), SL_OK);
    static const uint8_t wanted[4] = {0, 0, 1, 1};
    assert_memory_equal(w.topology->degenerate, wanted, 4);
    discard(&w);
}

/* ---- solids ----------------------------------------------------------------------------------------------------------- */

/* The answer for all triangles of a component, which begins at `first` and has `count`. */
static void assert_solid(const sl_topology *t, uint32_t first, uint32_t count, uint8_t solid) {
    for (uint32_t i = first; i < first + count; i++) {
        assert_int_equal(t->solid[i], solid);
        assert_int_equal(t->body[i] != SL_NO_INDEX, solid != 0);
    }
}

static void closed_boxes_are_solids_whichever_way_they_are_wound(void **state) {
    (void)state;
    for (int inside = 0; inside < 2; inside++) {
        trace_mesh parts = begin();
        trace_mesh_quad(&parts, sl_v3(-5, 0, 5), sl_v3(10, 0, 0), sl_v3(0, 0, -10), 0);
        trace_mesh_box(&parts, sl_v3(0, 0, 0), sl_v3(1, 1, 1), inside == 1, 0);
        trace_mesh_quad(&parts, sl_v3(-1, 4, 0), sl_v3(1, 0, 0), sl_v3(0, 0, 1), 1);
        trace_mesh_sphere(&parts, sl_v3(3, 1, 0), 0.5f, 6, 0.1f, inside == 1, 0);
        world w = world_of(&parts);
        assert_solid(w.topology, 0, 2, 0);
        assert_solid(w.topology, 2, 12, inside ? 1 : 2);
        assert_solid(w.topology, 14, 2, 0);
        assert_solid(w.topology, 16, (uint32_t)w.scene->triangle_count - 16, inside ? 1 : 2);
        assert_int_equal(w.topology->body_count, 2);
        discard(&w);
    }
}

static void what_is_open_wound_both_ways_or_flat_is_no_solid(void **state) {
    (void)state;
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
        trace_mesh_triangle(&parts, parts.indices[base + 3 * i], parts.indices[base + 3 * i + 2], parts.indices[base + 3 * i + 1], 0);
    trace_mesh_box(&parts, sl_v3(0, 5, 0), sl_v3(1, 6, 1), false, 0);
    trace_mesh_box(&parts, sl_v3(1, 5, 0), sl_v3(2, 6, 1), false, 0); /* they share a face's four corners: four triangles along its edges */
    world w = world_of(&parts);
    assert_solid(w.topology, 0, (uint32_t)w.scene->triangle_count, 0);
    assert_int_equal(w.topology->body_count, 0);
    discard(&w);
}

static void a_room_with_light_inside_is_no_solid(void **state) {
    (void)state;
    enum { LAMP_INSIDE, LAMP_OUTSIDE, LAMP_ON_WALL, POINT_INSIDE, POINT_OUTSIDE, SUN, CASES };
    static const uint8_t wanted[CASES] = {0, 1, 1, 0, 1, 1};
    for (int i = 0; i < CASES; i++) {
        trace_mesh parts = begin();
        trace_mesh_box(&parts, sl_v3(0, 0, 0), sl_v3(4, 3, 4), true, 0);
        float height = i == LAMP_INSIDE ? 2.9f : i == LAMP_ON_WALL ? 3.0f : 3.5f;
        trace_mesh_quad(&parts, sl_v3(1, height, 1), sl_v3(1, 0, 0), sl_v3(0, 0, 1), i <= LAMP_ON_WALL ? 1 : 0);
        if (i >= POINT_INSIDE) {
            parts.lights[parts.light_count++] = (sl_light){.type = i == SUN ? SL_LIGHT_DIRECTIONAL : SL_LIGHT_POINT, .position = {2, i == POINT_OUTSIDE ? 9 : 1, 2},
                                                           .direction = {0, -1, 0}, .intensity = {1, 1, 1}};
        }
        world w = world_of(&parts);
        assert_solid(w.topology, 0, 12, wanted[i]);
        discard(&w);
    }
}

static void a_glowing_body_is_a_solid_if_it_shines_outwards_only(void **state) {
    (void)state;
    for (int inside = 0; inside < 2; inside++)
        for (int two_sided = 0; two_sided < 2; two_sided++) {
            trace_mesh parts = begin();
            parts.materials[1].emission_two_sided = two_sided == 1;
            trace_mesh_sphere(&parts, sl_v3(0, 0, 0), 1.0f, 6, 0.0f, inside == 1, 1);
            world w = world_of(&parts);
            assert_solid(w.topology, 0, (uint32_t)w.scene->triangle_count, inside || two_sided ? 0 : 2);
            discard(&w);
        }
}

/* Boxes, some of them standing on or in others, and a box within a box; with their answers. */
static const float boxes[][6] = {{0, 0, 0, 1, 1, 1}, {0.25f, 1, 0.25f, 0.75f, 2, 0.75f}, {0.5f, 0.5f, 0.5f, 2.5f, 0.75f, 2.5f},
                                 {3, 0, 0, 6, 3, 3}, {4, 1, 1, 5, 2, 2}, {0.1f, 2, 0.1f, 0.9f, 2.5f, 0.9f}};
enum { BOXES = sizeof boxes / sizeof boxes[0] };

static trace_mesh furniture(void) {
    trace_mesh parts = begin();
    for (int b = 0; b < BOXES; b++)
        trace_mesh_box(&parts, sl_v3(boxes[b][0], boxes[b][1], boxes[b][2]), sl_v3(boxes[b][3], boxes[b][4], boxes[b][5]), b == 4, 0);
    trace_mesh_quad(&parts, sl_v3(-5, 0, 8), sl_v3(15, 0, 0), sl_v3(0, 0, -13), 0);
    trace_mesh_quad(&parts, sl_v3(-5, 6, -5), sl_v3(15, 0, 0), sl_v3(0, 0, 13), 1);
    return parts;
}

/* Signed distance from all boxes' surfaces: negative inside one. */
static float depth_in_boxes(sl_vec3 p, float *nearest) {
    float least = INFINITY;
    *nearest = INFINITY;
    for (int b = 0; b < BOXES; b++) {
        float x = fmaxf(boxes[b][0] - p.x, p.x - boxes[b][3]), y = fmaxf(boxes[b][1] - p.y, p.y - boxes[b][4]), z = fmaxf(boxes[b][2] - p.z, p.z - boxes[b][5]);
        float d = fmaxf(x, fmaxf(y, z));
        least = fminf(least, d);
        *nearest = fminf(*nearest, fabsf(d));
    }
    return least;
}

static void points_inside_of_solids_are_known_from_those_outside(void **state) {
    (void)state;
    trace_mesh parts = furniture();
    world w = world_of(&parts);
    sl_tracer *tracer;
    assert_int_equal(sl_tracer_create(w.scene, 1, NULL, &tracer, NULL), SL_OK);
    assert_int_equal(w.topology->body_count, BOXES);
    uint64_t key = sl_random_key(8, 1);
    size_t inside = 0;
    for (uint64_t i = 0; i < 4000; i++) {
        sl_vec3 p = sl_v3(7 * sl_random_unit(key, 3 * i) - 0.5f, 4 * sl_random_unit(key, 3 * i + 1) - 0.5f, 4 * sl_random_unit(key, 3 * i + 2) - 0.5f);
        sl_counters counters = {0};
        float nearest;
        bool wanted = depth_in_boxes(p, &nearest) < 0.0f;
        if (nearest < 0.001f) continue;
        assert_int_equal(sl_topology_inside_solid(w.topology, tracer, p, sl_v3(0, 1, 0), &counters), wanted);
        inside += wanted;
    }
    assert_true(inside > 800);
    sl_tracer_destroy(tracer);
    discard(&w);
}

static void a_floor_is_inside_where_a_leg_stands_on_it_and_a_leg_is_not(void **state) {
    (void)state;
    trace_mesh parts = furniture();
    world w = world_of(&parts);
    sl_tracer *tracer;
    assert_int_equal(sl_tracer_create(w.scene, 1, NULL, &tracer, NULL), SL_OK);
    sl_counters counters = {0};
    for (int y = 0; y < 20; y++)
        for (int x = 0; x < 60; x++) {
            sl_vec3 p = sl_v3(-0.4f + 0.11f * (float)x, 0, -0.45f + 0.19f * (float)y);
            bool wanted = false;
            for (int b = 0; b < BOXES; b++) wanted |= boxes[b][1] == 0.0f && p.x > boxes[b][0] && p.x < boxes[b][3] && p.z > boxes[b][2] && p.z < boxes[b][5];
            assert_int_equal(sl_topology_inside_solid(w.topology, tracer, p, sl_v3(0, 1, 0), &counters), wanted);
        }
    /* The first box's own side, top, and top where the second one stands. */
    assert_false(sl_topology_inside_solid(w.topology, tracer, sl_v3(0, 0.3f, 0.3f), sl_v3(-1, 0, 0), &counters));
    assert_false(sl_topology_inside_solid(w.topology, tracer, sl_v3(0.9f, 1, 0.1f), sl_v3(0, 1, 0), &counters));
    assert_true(sl_topology_inside_solid(w.topology, tracer, sl_v3(0.5f, 1, 0.5f), sl_v3(0, 1, 0), &counters));
    sl_tracer_destroy(tracer);
    discard(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coplanar_triangles_share_corners_on_each_side_apart),
        cmocka_unit_test(a_box_has_three_sites_at_each_corner_on_either_side),
        cmocka_unit_test(smooth_edges_are_shared_by_two_faces_or_three),
        cmocka_unit_test(exponents_keep_sites_apart_where_asked),
        cmocka_unit_test(normals_within_a_ten_thousandth_of_a_radian_are_one),
        cmocka_unit_test(a_sphere_of_facets_and_all_its_edges_are_consistent),
        cmocka_unit_test(thousands_of_normals_at_one_corner_are_kept_apart),
        cmocka_unit_test(needles_and_points_that_are_no_numbers_are_degenerate),
        cmocka_unit_test(closed_boxes_are_solids_whichever_way_they_are_wound),
        cmocka_unit_test(what_is_open_wound_both_ways_or_flat_is_no_solid),
        cmocka_unit_test(a_room_with_light_inside_is_no_solid),
        cmocka_unit_test(a_glowing_body_is_a_solid_if_it_shines_outwards_only),
        cmocka_unit_test(points_inside_of_solids_are_known_from_those_outside),
        cmocka_unit_test(a_floor_is_inside_where_a_leg_stands_on_it_and_a_leg_is_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
