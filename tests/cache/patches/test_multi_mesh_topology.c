/* Faces, and the corners and edges that they share. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/math.h"
#include "cache/patches/topology.h"
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

/* What must hold of any: sites agree with the scene, edges list each face's three once, and name their sites.
 */
static void check(const sl_topology *t) {
    const sl_scene *scene = t->scene;
    size_t listed = 0;
    for (uint32_t f = 0; f < t->face_count; f++)
        for (int c = 0; c < 3; c++) {
            uint32_t site = t->site[c][f], a = t->site[(c + 1) % 3][f], b = t->site[(c + 2) % 3][f],
                     e = t->edge[c][f], times = 0;
            sl_vec3 p = sl_scene_position(scene, scene->vertex[c][f / 2]), q = t->site_position[site];
            assert_true(site < t->site_count && p.x == q.x && p.y == q.y && p.z == q.z);
            assert_true(fabsf(sl_length(t->site_normal[site]) - 1.0f) < 1e-5f &&
                        sl_dot(t->site_normal[site], sl_face_normal(scene, f)) > -1e-4f);
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

/* ---- sites and edges ------------------------------------------------------------------------- */

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

/* A scene with normals given: two triangles bent along an edge, or three around it, smooth in that they have
 * the same normal there. */
static sl_scene *bent(size_t triangles, float tilt, const sl_material *materials, size_t material_count) {
    static const float positions[] = {0, 0, 0, 0, 0, 1, 1, 0.2f, 0, -1, 0.2f, 0, 0.1f, 1, 0};
    float normals[15];
    for (int v = 0; v < 5; v++) {
        normals[3 * v] = v == 4 ? 0 : tilt * (float)v;
        normals[3 * v + 1] = 1;
        normals[3 * v + 2] = 0;
    }
    static const uint32_t indices[] = {0, 1, 2, 1, 0, 3, 0, 1, 4}, material_index[] = {0, 1, 0};
    sl_scene_parts parts = {.vertex_count = 5,
                            .positions = positions,
                            .normals = normals,
                            .triangle_count = triangles,
                            .indices = indices,
                            .material_count = material_count,
                            .materials = materials,
                            .material_index = material_count > 1 ? material_index : NULL};
    sl_scene *scene;
    assert_int_equal(sl_scene_build(&parts, &scene, NULL), SL_OK);
    return scene;
}

static void smooth_edges_are_shared_by_two_faces_or_three(void **state) {
    (void)state;
    sl_material material = {
        .diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
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
    sl_material materials[2] = {{.specular = {0.5f, 0.5f, 0.5f},
                                 .exponent = 10,
                                 .texture = SL_NO_INDEX,
                                 .alpha_texture = SL_NO_INDEX},
                                {.specular = {0.5f, 0.5f, 0.5f},
                                 .exponent = 20,
                                 .texture = SL_NO_INDEX,
                                 .alpha_texture = SL_NO_INDEX}};
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
        sl_material material = {
            .diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
        sl_scene_parts parts = {.vertex_count = 6,
                                .positions = positions,
                                .normals = normals,
                                .triangle_count = 2,
                                .indices = indices,
                                .material_count = 1,
                                .materials = &material};
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
    /* nothing is shared but within a facet */
    assert_true(sl_topology_memory_bytes(w.topology) < 350 * w.scene->triangle_count);
    discard(&w);
}

/* Normals all over the sphere at one position, in pairs that are the same but for rounding: a site for each
 * pair. */
static void thousands_of_normals_at_one_corner_are_kept_apart(void **state) {
    (void)state;
    enum { PAIRS = 4000, TRIANGLES = 2 * PAIRS };
    static float positions[9 * TRIANGLES], normals[9 * TRIANGLES];
    static uint32_t indices[3 * TRIANGLES];
    for (uint32_t t = 0; t < TRIANGLES; t++) {
        /* a spiral: 0.05 radians apart */
        double z = 1.0 - 2.0 * (t / 2 + 0.5) / PAIRS, turn = 2.399963 * (t / 2), radius = sqrt(1.0 - z * z);
        sl_vec3 n = sl_v3((float)(radius * sl_cos(turn)), (float)(radius * sl_sin(turn)), (float)z);
        sl_frame frame = sl_frame_from_normal(n);
        for (uint32_t c = 0; c < 3; c++) {
            sl_vec3 p =
                c == 0 ? sl_v3(0, 0, 0) : sl_scale(c == 1 ? frame.x : frame.y, 1.0f + 0.1f * (float)(t % 2));
            memcpy(&positions[9 * t + 3 * c], (float[3]){p.x, p.y, p.z}, 3 * sizeof(float));
            memcpy(&normals[9 * t + 3 * c], (float[3]){n.x, n.y, n.z + (t % 2 ? 0.7e-4f : 0.0f) * n.x},
                   3 * sizeof(float));
            indices[3 * t + c] = 3 * t + c;
        }
    }
    sl_material material = {
        .diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
    sl_scene_parts parts = {.vertex_count = 3 * TRIANGLES,
                            .positions = positions,
                            .normals = normals,
                            .triangle_count = TRIANGLES,
                            .indices = indices,
                            .material_count = 1,
                            .materials = &material};
    world w = {0};
    assert_int_equal(sl_scene_build(&parts, &w.scene, NULL), SL_OK);
    assert_int_equal(w.scene->triangle_count, TRIANGLES);
    assert_int_equal(sl_topology_create(w.scene, false, &w.topology, NULL), SL_OK);
    check(w.topology);
    size_t at_tip = 0;
    for (size_t s = 0; s < w.topology->site_count; s++)
        at_tip += sl_length(w.topology->site_position[s]) == 0.0f;
    for (uint32_t f = 0; f < w.topology->face_count; f += 4)
        assert_int_equal(w.topology->site[0][f], w.topology->site[0][f + 2]);
    assert_int_equal(at_tip, 2 * PAIRS);
    discard(&w);
}

static void needles_and_points_that_are_no_numbers_are_degenerate(void **state) {
    (void)state;
    trace_mesh parts = begin();
    trace_mesh_quad(&parts, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
    uint32_t a = trace_mesh_vertex(&parts, 0, 0, 2), b = trace_mesh_vertex(&parts, 1e-13f, 0, 2),
             c = trace_mesh_vertex(&parts, 0, 1, 2);
    trace_mesh_triangle(&parts, a, b, c, 0);
    uint32_t d = trace_mesh_vertex(&parts, 1, 1, 3), e = trace_mesh_vertex(&parts, 2, 1, 3),
             f = trace_mesh_vertex(&parts, 1, 2, 3);
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
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
