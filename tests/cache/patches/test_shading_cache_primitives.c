/* Ground of the hierarchy: quadrilaterals found among triangles, points of roots and back, edges and poles
 * that are shared. */
#include "patch_support.h"

#include <math.h>

#include "base/random.h"
#include "rendering.h"
#include "scene/bicubic.h"
#include "scene_parts.h"

static double distance(sl_vec3 a, sl_vec3 b) { return sl_lengthd(sl_subd(sl_to_double(a), sl_to_double(b))); }

static sl_primitives *primitives_of(const sl_scene *scene) {
    sl_primitives *p;
    assert_int_equal(sl_primitives_find(scene, &p, NULL), SL_OK);
    for (size_t i = 0; i < p->count; i++) {
        for (uint32_t t = 0; t < sl_primitive_triangles(p, (uint32_t)i); t++)
            assert_int_equal(p->of_triangle[p->first_triangle[i] + t], i);
    }
    return p;
}

static void discard(sl_primitives *p, sl_scene *scene) { /* and their scene */
    sl_primitives_destroy(p);
    sl_scene_destroy(scene);
}

static size_t count_of_kind(const sl_primitives *p, sl_primitive_kind kind) {
    size_t count = 0;
    for (size_t i = 0; i < p->count; i++) count += p->kind[i] == kind;
    return count;
}

/* ---- quadrilaterals ---- */

static void the_walls_and_boxes_of_the_cornell_box_are_quadrilaterals(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_primitives *p = primitives_of(scene);
    /* The published measurements are not quite those of parallelograms: the floor's and the ceiling's
     * corners, and some sides of the boxes. */
    size_t quads = count_of_kind(p, SL_PRIMITIVE_QUAD), triangles = count_of_kind(p, SL_PRIMITIVE_TRIANGLE);
    assert_int_equal(2 * quads + triangles, scene->triangle_count);
    assert_true(quads >= 5);
    for (uint32_t i = 0; i < p->count; i++) {
        if (p->kind[i] != SL_PRIMITIVE_QUAD) continue;
        sl_vec3 c[4];
        for (int k = 0; k < 4; k++) c[k] = sl_scene_position(scene, sl_primitive_corner(p, i, k));
        assert_true(distance(sl_add(c[0], c[2]), sl_add(c[1], c[3])) < 1e-2);
        sl_vec3 normal = sl_normalize_or(sl_cross(sl_sub(c[1], c[0]), sl_sub(c[3], c[0])), sl_v3(0, 0, 0));
        assert_true(sl_dot(normal, sl_scene_geometric_normal(scene, p->first_triangle[i])) > 0.999f);
    }
    discard(p, scene);
}

typedef struct pair {
    float xyz[12], uv[12], normal[18];
    uint32_t index[6], material[2], object[2];
} pair;

/* A square of two triangles that have all their six corners for themselves. */
static pair square_pair(void) {
    static const float xy[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    pair p = {.index = {0, 1, 2, 3, 4, 5}};
    for (int i = 0; i < 6; i++) p.normal[3 * i + 2] = 1.0f;
    for (int i = 0; i < 6; i++) {
        p.uv[2 * i] = xy[i][0];
        p.uv[2 * i + 1] = xy[i][1];
    }
    return p;
}

static size_t primitives_in(const pair *p, const float *xyz, bool textured) {
    uint8_t texel[4] = {255, 128, 0, 255};
    sl_texture texture = {.file = "t", .width = 1, .height = 1, .texels = texel};
    sl_material materials[2];
    for (int i = 0; i < 2; i++) {
        materials[i] = (sl_material){.name = "m",
                                     .diffuse = {0.5f, 0.5f, 0.5f},
                                     .texture = textured ? 0 : SL_NO_INDEX,
                                     .alpha_texture = SL_NO_INDEX};
    }
    sl_scene_parts parts = {.vertex_count = 6,
                            .positions = xyz,
                            .normals = p->normal,
                            .texture_coordinates = p->uv,
                            .triangle_count = 2,
                            .indices = p->index,
                            .material_index = p->material,
                            .object_index = p->object,
                            .material_count = 2,
                            .materials = materials,
                            .texture_count = 1,
                            .textures = &texture};
    sl_scene *scene;
    assert_int_equal(sl_scene_build(&parts, &scene, NULL), SL_OK);
    sl_primitives *found = primitives_of(scene);
    size_t count = found->count;
    sl_primitives_destroy(found);
    sl_scene_destroy(scene);
    return count;
}

static void two_triangles_are_a_quadrilateral_only_where_everything_agrees(void **state) {
    static const float square[18] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0};
    float xyz[18];
    pair p = square_pair();
    assert_int_equal(primitives_in(&p, square, true), 1);
    p.material[1] = 1;
    assert_int_equal(primitives_in(&p, square, true), 2);
    p = square_pair();
    p.object[1] = 1;
    assert_int_equal(primitives_in(&p, square, true), 2);
    p = square_pair();
    p.normal[3 * 3] = 5e-5f; /* of the second triangle at the shared corner */
    assert_int_equal(primitives_in(&p, square, true), 1);
    p.normal[3 * 3] = 5e-4f;
    assert_int_equal(primitives_in(&p, square, true), 2);
    p = square_pair();
    p.uv[2 * 5] = 0.5f; /* texture bent along the diagonal */
    assert_int_equal(primitives_in(&p, square, true), 2);
    assert_int_equal(primitives_in(&p, square, false), 1); /* which nobody sees */
    p = square_pair();
    p.uv[2 * 3] = p.uv[2 * 4] = p.uv[2 * 5] = 3.0f; /* another part of the texture */
    assert_int_equal(primitives_in(&p, square, true), 2);

    p = square_pair();
    memcpy(xyz, square, sizeof xyz);
    xyz[3 * 5] = 1e-3f; /* a trapezium */
    assert_int_equal(primitives_in(&p, xyz, true), 2);
    xyz[3 * 5] = 5e-6f;
    assert_int_equal(primitives_in(&p, xyz, true), 1);
    memcpy(xyz, square, sizeof xyz);
    xyz[3 * 5 + 2] = 1e-3f; /* not plane */
    assert_int_equal(primitives_in(&p, xyz, true), 2);
    memcpy(xyz, square, sizeof xyz);
    xyz[3 * 3] = 1e-6f; /* a gap */
    assert_int_equal(primitives_in(&p, xyz, true), 2);
    /* Folded over: the second lies on the first, seen from behind. */
    static const float folded[18] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 1, 0, 0};
    assert_int_equal(primitives_in(&p, folded, true), 2);
}

/* ---- points ---- */

/* However a quadrilateral's triangles begin, (u, v) of its corners are (0,0), (1,0), (1,1), (0,1), and points
 * are affine in (u, v). */
static void points_of_roots_and_their_parameters_agree(void **state) {
    for (uint32_t turn = 0; turn < 9; turn++) {
        trace_mesh mesh = trace_mesh_begin();
        trace_mesh_diffuse(&mesh, 0.5f);
        uint32_t corner[4] = {trace_mesh_vertex(&mesh, 0, 0, 1), trace_mesh_vertex(&mesh, 2, 0.5f, 1),
                              trace_mesh_vertex(&mesh, 3, 1.5f, 1), trace_mesh_vertex(&mesh, 1, 1, 1)};
        uint32_t first[3] = {corner[0], corner[1], corner[2]}, second[3] = {corner[0], corner[2], corner[3]};
        trace_mesh_triangle(&mesh, first[turn % 3], first[(turn + 1) % 3], first[(turn + 2) % 3], 0);
        trace_mesh_triangle(&mesh, second[turn / 3], second[(turn / 3 + 1) % 3], second[(turn / 3 + 2) % 3],
                            0);
        sl_scene *scene = trace_mesh_build(&mesh);
        sl_primitives *p = primitives_of(scene);
        assert_int_equal(p->count, 1);
        for (uint32_t root = 0; root < 2; root++) {
            for (uint32_t i = 0; i <= 8; i++) {
                for (uint32_t j = 0; j <= 8; j++) {
                    sl_lit_point point;
                    double u = i / 8.0, v = j / 8.0, back_u, back_v;
                    sl_root_point_at(p, root, i * SL_PATCH_DYADIC / 8, j * SL_PATCH_DYADIC / 8, &point);
                    sl_vec3 c[4];
                    for (int k = 0; k < 4; k++) c[k] = sl_scene_position(scene, sl_primitive_corner(p, 0, k));
                    sl_vec3 expected =
                        sl_mad(sl_mad(c[0], (float)u, sl_sub(c[1], c[0])), (float)v, sl_sub(c[3], c[0]));
                    assert_true(distance(point.position, expected) < 1e-6);
                    assert_true(point.normal.z == (root ? -1.0f : 1.0f) &&
                                point.geometric_normal.z == point.normal.z);
                    bool on_edge = i % 8 == 0 || j % 8 == 0 || i == j;
                    assert_int_equal(point.triangle == SL_NO_INDEX, on_edge);
                    float w1, w2;
                    uint32_t t = sl_root_triangle_at(p, root, u, v, &w1, &w2);
                    if (!on_edge) assert_int_equal(t, point.triangle);
                    sl_surface surface;
                    sl_scene_surface(scene, t, w1, w2, sl_v3(0, 0, 1), &surface);
                    assert_true(distance(surface.position, expected) < 1e-6);
                    sl_root_parameters(p, t, w1, w2, &back_u, &back_v);
                    assert_true(fabs(back_u - u) < 1e-6 && fabs(back_v - v) < 1e-6);
                }
            }
        }
        discard(p, scene);
    }
}

static void points_of_curved_roots_lie_on_the_scenes_triangles_with_the_surfaces_normal(void **state) {
    sl_scene *scene = load_scene("scenes/vase.json");
    sl_primitives *p = primitives_of(scene);
    assert_int_equal(p->curved, 16);
    uint64_t key = sl_random_key(3, 3);
    for (uint64_t k = 0; k < 4000; k++) {
        uint32_t primitive = sl_random_bits(key, 3 * k) % (uint32_t)p->count, root = 2 * primitive;
        if (p->kind[primitive] != SL_PRIMITIVE_BICUBIC) continue;
        const sl_bicubic *b = &scene->bicubics[p->bicubic[primitive]];
        uint32_t u = sl_random_bits(key, 3 * k + 1) % (SL_PATCH_DYADIC + 1),
                 v = sl_random_bits(key, 3 * k + 2) % (SL_PATCH_DYADIC + 1);
        if (k % 5 == 0) u = u / 4096 * 4096;
        if (k % 7 == 0) v = 0;
        sl_lit_point point;
        sl_root_point_at(p, root, u, v, &point);
        sl_vec3 position, normal;
        sl_bicubic_at(b, (double)u / SL_PATCH_DYADIC, (double)v / SL_PATCH_DYADIC, &position, &normal);
        assert_true(distance(point.position, position) < 0.5); /* the vase is 330 high */
        assert_true(distance(point.position, sl_root_position(p, root, u, v)) == 0.0);
        assert_true(sl_dot(point.normal, normal) > 0.999f &&
                    sl_dot(point.normal, point.geometric_normal) > 0.9f);
        float w1, w2;
        double back_u, back_v;
        uint32_t t =
            sl_root_triangle_at(p, root, (double)u / SL_PATCH_DYADIC, (double)v / SL_PATCH_DYADIC, &w1, &w2);
        assert_true(t >= b->first_triangle && t < b->first_triangle + b->triangle_count && w1 >= 0.0f &&
                    w2 >= 0.0f && w1 + w2 <= 1.0001f);
        sl_root_parameters(p, t, w1, w2, &back_u, &back_v);
        /* nearer to the pole half of the triangles are not there, and others stand for them */
        if (v >= SL_PATCH_DYADIC / 16) {
            assert_true(fabs(back_u - (double)u / SL_PATCH_DYADIC) < 1e-5 &&
                        fabs(back_v - (double)v / SL_PATCH_DYADIC) < 1e-5);
        }
    }
    discard(p, scene);
}

static void any_numbers_are_answered_with_a_point_of_the_root(void **state) {
    sl_scene *scene = load_scene("scenes/vase.json");
    sl_primitives *p = primitives_of(scene);
    const double odd[] = {-1.0, 2.0, (double)NAN, (double)INFINITY, 1.0};
    for (uint32_t root = 0; root < 2 * p->count; root++) {
        for (int k = 0; k < 25; k++) {
            float w1, w2;
            uint32_t t = sl_root_triangle_at(p, root, odd[k / 5], odd[k % 5], &w1, &w2);
            assert_int_equal(p->of_triangle[t], root / 2);
            assert_true(w1 >= 0.0f && w1 <= 1.0f && w2 >= 0.0f && w2 <= 1.0f);
        }
    }
    discard(p, scene);
}

/* ---- textures ---- */

static void mean_reflectance_is_that_of_the_texture(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_diffuse(&mesh, 0.5f);
    uint8_t texels[16] = {255, 255, 255, 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255, 255};
    mesh.textures[0] = (sl_texture){.file = "t", .width = 2, .height = 2, .texels = texels};
    mesh.texture_count = 1;
    mesh.materials[0].texture = 0;
    trace_mesh_quad(&mesh, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 1), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 1);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_primitives *p = primitives_of(scene);
    assert_int_equal(p->count, 2);
    assert_true(fabs((double)sl_root_mean_diffuse(p, 0).g - 0.25) < 1e-3);
    assert_true(sl_root_mean_diffuse(p, 3).r == 0.5f);
    /* The texture through the root is the texture of its triangles. */
    for (int k = 0; k < 64; k++) {
        double u = (k % 8 + 0.5) / 8.0, v = (k / 8 + 0.5) / 8.0;
        float w1, w2;
        uint32_t t = sl_root_triangle_at(p, 0, u, v, &w1, &w2);
        sl_rgb through = sl_scene_diffuse(scene, t, w1, w2);
        sl_vec3 c0 = sl_scene_position(scene, sl_primitive_corner(p, 0, 0)),
                c1 = sl_scene_position(scene, sl_primitive_corner(p, 0, 1));
        sl_vec3 c3 = sl_scene_position(scene, sl_primitive_corner(p, 0, 3));
        /* (x, y) are texture coordinates here */
        sl_vec3 at = sl_mad(sl_mad(c0, (float)u, sl_sub(c1, c0)), (float)v, sl_sub(c3, c0));
        bool checked = (at.x < 0.5f) == (at.y < 0.5f),
             far_from_edges = fabs(fabs(fabs((double)at.x - 0.5) - 0.25)) < 0.1 &&
                              fabs(fabs(fabs((double)at.y - 0.5) - 0.25)) < 0.1;
        if (far_from_edges) assert_true(checked ? through.r < 0.25f : through.r > 0.25f);
    }
    discard(p, scene);
}

/* ---- places that are shared ---- */

static void a_canonical_place_is_where_the_point_is_with_its_normal(void **state) {
    sl_scene *scene = load_scene("scenes/vase.json");
    sl_primitives *p = primitives_of(scene);
    size_t moved = 0;
    for (uint32_t root = 0; root < 2 * p->count; root++) {
        int corners = p->kind[root / 2] == SL_PRIMITIVE_TRIANGLE ? 3 : 4;
        for (uint32_t k = 0; k < 17 * 17; k++) {
            uint16_t u = (uint16_t)(k % 17 * SL_PATCH_DYADIC / 16),
                     v = (uint16_t)(k / 17 * SL_PATCH_DYADIC / 16);
            if (corners == 3 && u + v > SL_PATCH_DYADIC) continue;
            sl_root_place at = {root, u, v}, canonical = sl_root_canonical(p, at);
            assert_true(same_root_place(canonical, sl_root_canonical(p, canonical)));
            assert_true(canonical.root <= root && canonical.root % 2 == root % 2);
            assert_int_equal(sl_root_object(p, root), sl_root_object(p, canonical.root));
            moved += !same_root_place(at, canonical);
            sl_lit_point a, b;
            sl_root_point_at(p, root, u, v, &a);
            sl_root_point_at(p, canonical.root, canonical.u, canonical.v, &b);
            assert_true(distance(a.position, b.position) < 1e-4);
            assert_true(distance(a.normal, b.normal) < 3e-4);
        }
    }
    assert_true(moved > 1000);
    discard(p, scene);
}

/* A ring of n patches, each split to depth d, closed at a pole: (2^d n) (2^d) vertices and one. */
static void a_pole_has_one_vertex_and_seams_are_shared(void **state) {
    hierarchy h = hierarchy_of(load_scene("scenes/vase.json"), 0);
    uint32_t foot = 0;
    while (h.primitives->kind[foot] != SL_PRIMITIVE_BICUBIC) foot++;
    for (int d = 0; d <= 3; d++) {
        for (uint32_t k = 0; k < 4; k++) {
            uint32_t patch = want_root(&h, 2 * (foot + k));
            sl_patch_drop_children(h.patches, patch);
            split_levels(&h, patch, d);
        }
        size_t n = (size_t)1 << d;
        assert_int_equal(h.patches->leaves_alive, 4 * n * n);
        assert_int_equal(h.patches->vertices_alive, 4 * n * n + 1);
        assert_sound(h.patches);
    }
    /* Along the pole nothing hangs, and what happens there is known to all leaves around it. */
    sl_patch_place coarse = sl_patch_place_of(h.patches, sl_patches_find_root(h.patches, 2 * foot));
    sl_patch_drop_children(h.patches, coarse.patch);
    uint32_t vertex[64];
    assert_int_equal(hanging_on(h.patches, &coarse, 0, vertex, NULL, 64), 0);
    assert_int_equal(hanging_on(h.patches, &coarse, 1, vertex, NULL, 64), 7);
    assert_int_equal(hanging_on(h.patches, &coarse, 3, vertex, NULL, 64), 7);
    assert_sound(h.patches);
    uint32_t pole = sl_patch_corner(h.patches, coarse.patch, 0);
    assert_int_equal(sl_patch_corner(h.patches, coarse.patch, 1), pole);
    mark_around(h.patches, h.patches->vertex[pole].place);
    size_t marked = 0;
    for (uint32_t i = 0; i < h.patches->patch_count; i++) {
        if (!sl_patch_is_alive(h.patches, i) || !(h.patches->patch[i].flags & MARKED)) continue;
        sl_patch_place place = sl_patch_place_of(h.patches, i);
        assert_true(sl_patch_is_leaf(h.patches, i) && place.v[0] == 0);
        marked++;
    }
    assert_int_equal(marked, 1 + 3 * 8);
    hierarchy_discard(&h);
}

static void shared_corners_of_many_facets_are_found_in_bounded_time(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    uint32_t tip = trace_mesh_vertex(&mesh, 0, 1, 0);
    for (int i = 0; i < 20000; i++) { /* facets that all face elsewhere, about one point */
        float x = (float)(i - 10000) / 10000.0f;
        uint32_t a = trace_mesh_vertex(&mesh, x, 0, x * x),
                 b = trace_mesh_vertex(&mesh, x + 1e-4f, 0, (x + 1e-4f) * (x + 1e-4f));
        trace_mesh_triangle(&mesh, tip, a, b, 0);
    }
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_primitives *p = primitives_of(scene);
    assert_true(p->count >= 10000);
    discard(p, scene);
}

/* ---- motion ---- */

static void points_move_with_their_objects_and_roots_stay_what_they_are(void **state) {
    sl_scene *scene = load_scene("scenes/moving-ball.json");
    sl_primitives *p = primitives_of(scene);
    uint32_t moving = SL_NO_INDEX;
    for (uint32_t i = 0; i < p->count && moving == SL_NO_INDEX; i++) {
        if (strcmp(scene->object_names[sl_root_object(p, 2 * i)], "ball") == 0) moving = i;
    }
    assert_int_not_equal(moving, SL_NO_INDEX);
    sl_lit_point before, after, still, still_after;
    uint32_t third = SL_PATCH_DYADIC / 4;
    sl_root_point_at(p, 2 * moving, third, third, &before);
    sl_root_point_at(p, 0, third, third, &still);
    sl_root_place place = {2 * moving, 0, (uint16_t)third}, canonical = sl_root_canonical(p, place);
    assert_int_equal(sl_scene_set_time(scene, 1.0, NULL, NULL), SL_OK);
    sl_root_point_at(p, 2 * moving, third, third, &after);
    sl_root_point_at(p, 0, third, third, &still_after);
    assert_true(distance(sl_sub(after.position, before.position), sl_v3(320, 0, 40)) < 1e-3);
    assert_true(distance(after.normal, before.normal) < 1e-5);
    assert_true(distance(still.position, still_after.position) == 0.0);
    assert_true(same_root_place(canonical, sl_root_canonical(p, place)));
    discard(p, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_walls_and_boxes_of_the_cornell_box_are_quadrilaterals),
        cmocka_unit_test(two_triangles_are_a_quadrilateral_only_where_everything_agrees),
        cmocka_unit_test(points_of_roots_and_their_parameters_agree),
        cmocka_unit_test(points_of_curved_roots_lie_on_the_scenes_triangles_with_the_surfaces_normal),
        cmocka_unit_test(any_numbers_are_answered_with_a_point_of_the_root),
        cmocka_unit_test(mean_reflectance_is_that_of_the_texture),
        cmocka_unit_test(a_canonical_place_is_where_the_point_is_with_its_normal),
        cmocka_unit_test(a_pole_has_one_vertex_and_seams_are_shared),
        cmocka_unit_test(shared_corners_of_many_facets_are_found_in_bounded_time),
        cmocka_unit_test(points_move_with_their_objects_and_roots_stay_what_they_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
