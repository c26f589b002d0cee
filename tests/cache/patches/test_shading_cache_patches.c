/* The patch hierarchy: counts, sharing, hanging vertices, values, splits and drops in any order, eviction,
 * memory. */
#include "patch_support.h"

#include <math.h>
#include <stdio.h>

#include "base/random.h"
#include "rendering.h"

static size_t power_of_4(int d) { return (size_t)1 << (2 * d); }

/* ---- counts ---- */

static void assert_split_evenly(sl_scene *scene, uint32_t root, int d, size_t vertices) {
    hierarchy h = hierarchy_of(scene, 0);
    split_levels(&h, want_root(&h, root), d);
    assert_int_equal(h.patches->leaves_alive, power_of_4(d));
    assert_int_equal(h.patches->patches_alive, (power_of_4(d + 1) - 1) / 3);
    assert_int_equal(h.patches->vertices_alive, vertices);
    assert_sound(h.patches);
    hierarchy_discard(&h);
}

static void a_square_split_to_depth_d_has_4_to_the_d_leaves_and_a_grid_of_vertices(void **state) {
    for (int d = 0; d <= 5; d++) {
        size_t n = (size_t)1 << d;
        assert_split_evenly(square_scene(), 0, d, (n + 1) * (n + 1));
    }
}

static void a_triangle_split_to_depth_d_has_4_to_the_d_leaves_and_a_triangular_grid_of_vertices(
    void **state) {
    for (int d = 0; d <= 5; d++) {
        size_t n = (size_t)1 << d;
        assert_split_evenly(triangle_scene(), 1, d, (n + 1) * (n + 2) / 2);
    }
}

static void nothing_is_there_before_it_is_wanted_and_nothing_is_evaluated_before_it_is_asked_for(
    void **state) {
    hierarchy h = hierarchy_of(square_scene(), KEEP_LOBES);
    assert_int_equal(h.patches->patches_alive + h.patches->vertices_alive, 0);
    assert_int_equal(sl_patch_locate(h.patches, 0, 0.5, 0.5).patch, SL_NO_INDEX);
    split_levels(&h, want_root(&h, 0), 3);
    for (size_t i = 0; i < h.patches->vertex_count; i++)
        assert_int_equal(h.patches->vertex[i].evaluated, SL_VERTEX_NEVER);
    assert_int_equal(sl_patches_find_root(h.patches, 1), SL_NO_INDEX);
    hierarchy_discard(&h);
}

/* ---- places ---- */

static void every_point_is_in_the_leaf_that_is_found_for_it(void **state) {
    for (int kind = 0; kind < 2; kind++) {
        hierarchy h = hierarchy_of(kind ? triangle_scene() : square_scene(), 0);
        want_root(&h, 0);
        uint64_t key = sl_random_key(5, (uint64_t)kind);
        for (uint64_t i = 0; i < 500; i++) { /* finer and finer where the points fall */
            double u = (double)sl_random_unit(key, 2 * i), v = (double)sl_random_unit(key, 2 * i + 1);
            if (kind && u + v > 1.0) continue;
            sl_patch_place place = sl_patch_locate(h.patches, 0, u, v);
            sl_patch_place same = sl_patch_place_of(h.patches, place.patch);
            assert_memory_equal(&place, &same, sizeof place);
            double low_u = 1, high_u = 0, low_v = 1, high_v = 0;
            for (int c = 0; c < place.corners; c++) {
                low_u = fmin(low_u, (double)place.u[c] / SL_PATCH_DYADIC),
                high_u = fmax(high_u, (double)place.u[c] / SL_PATCH_DYADIC);
                low_v = fmin(low_v, (double)place.v[c] / SL_PATCH_DYADIC),
                high_v = fmax(high_v, (double)place.v[c] / SL_PATCH_DYADIC);
            }
            assert_true(low_u <= u && u <= high_u && low_v <= v && v <= high_v);
            if (kind) { /* and on the right side of the slanted edge */
                bool turned = place.u[1] < place.u[0];
                double slant = (double)(place.u[1] + place.v[1]) / SL_PATCH_DYADIC;
                assert_true(turned ? u + v >= slant : u + v <= slant);
            }
            split(&h, place.patch);
        }
        assert_int_equal(sl_patch_locate(h.patches, 0, -1e30, (double)NAN).patch,
                         sl_patch_locate(h.patches, 0, 0.0, 0.0).patch);
        assert_sound(h.patches);
        hierarchy_discard(&h);
    }
}

/* ---- sharing ---- */

static void a_closed_box_shares_no_corner_and_a_flat_fan_shares_all(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_box(&mesh, sl_v3(0, 0, 0), sl_v3(1, 1, 1), false, 0);
    hierarchy box = hierarchy_of(trace_mesh_build(&mesh), 0);
    for (uint32_t r = 0; r < 12; r += 2) split_levels(&box, want_root(&box, r), 2);
    assert_int_equal(box.patches->vertices_alive, 6 * 25);
    assert_sound(box.patches);
    hierarchy_discard(&box);

    mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < 2; j++)
            trace_mesh_quad(&mesh, sl_v3((float)i, (float)j, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
    }
    hierarchy fan = hierarchy_of(trace_mesh_build(&mesh), 0);
    for (uint32_t r = 0; r < 8; r++) split_levels(&fan, want_root(&fan, r), 2);
    assert_int_equal(fan.patches->vertices_alive, 2 * 9 * 9); /* the fronts', the backs' */
    assert_sound(fan.patches);
    hierarchy_discard(&fan);
}

/* A square of which one half is a triangle of its own; `material`: of another material. */
static sl_scene *two_triangles(bool other_material, bool turned) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_diffuse(&mesh, 0.7f);
    uint32_t a = trace_mesh_vertex(&mesh, 0, 0, 0), b = trace_mesh_vertex(&mesh, 1, 0, 0),
             c = trace_mesh_vertex(&mesh, 0, 1, 0);
    uint32_t d = trace_mesh_vertex(&mesh, 1, 2, turned ? 0.01f : 0.0f);
    trace_mesh_triangle(&mesh, a, b, c, 0);
    trace_mesh_triangle(&mesh, d, c, b, other_material ? 1 : 0);
    return trace_mesh_build(&mesh);
}

static size_t vertices_of_two_triangles(bool other_material, bool turned) {
    hierarchy h = hierarchy_of(two_triangles(other_material, turned), 0);
    assert_int_equal(h.primitives->count, 2);
    split_levels(&h, want_root(&h, 2), 3); /* the higher one first: whose turn it is has no say */
    split_levels(&h, want_root(&h, 0), 3);
    assert_sound(h.patches);
    size_t vertices = h.patches->vertices_alive;
    hierarchy_discard(&h);
    return vertices;
}

static void primitives_share_an_edge_where_normal_and_material_agree_and_only_there(void **state) {
    assert_int_equal(vertices_of_two_triangles(false, false), 2 * 45 - 9);
    assert_int_equal(vertices_of_two_triangles(true, false), 2 * 45);
    assert_int_equal(vertices_of_two_triangles(false, true), 2 * 45);
}

static void a_shared_vertex_is_evaluated_once_for_both(void **state) {
    hierarchy h = hierarchy_of(two_triangles(false, 0), 0);
    split_levels(&h, want_root(&h, 2), 1);
    split_levels(&h, want_root(&h, 0), 1);
    sl_patches *p = h.patches;
    /* what the renderer would answer: a function of position */
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        sl_lit_point point;
        sl_root_point_at(h.primitives, p->vertex[i].root, p->vertex[i].u, p->vertex[i].v, &point);
        sl_vertex_value(p, i)[0] = point.position.x + 10.0f * point.position.y;
        p->vertex[i].evaluated = 1;
    }
    for (int i = 0; i <= 16; i++) { /* the edge from (1, 0) to (0, 1), from both sides */
        double t = i / 16.0;
        float a[3], b[3];
        sl_patch_place left = sl_patch_locate(p, 0, 1.0 - t, t), right = sl_patch_locate(p, 2, 1.0 - t, t);
        /* The other triangle is d c b: weights of c and b. */
        assert_true(sl_patch_value(p, &left, 1.0 - t, t, a));
        right = sl_patch_locate(p, 2, t, 1.0 - t);
        assert_true(sl_patch_value(p, &right, t, 1.0 - t, b));
        assert_true(fabs((double)a[0] - ((1.0 - t) + 10.0 * t)) < 1e-5);
        assert_true(fabs((double)a[0] - (double)b[0]) < 1e-5);
    }
    hierarchy_discard(&h);
}

/* ---- hanging vertices ---- */

static void a_leaf_beside_finer_ones_knows_the_vertices_on_its_edge_in_order(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    for (int i = 0; i < 2; i++)
        trace_mesh_quad(&mesh, sl_v3((float)i, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
    hierarchy h = hierarchy_of(trace_mesh_build(&mesh), 0);
    uint32_t coarse = want_root(&h, 0), fine = want_root(&h, 2), vertex[16];
    sl_patch_place place = sl_patch_place_of(h.patches, coarse);
    assert_int_equal(hanging_on(h.patches, &place, 1, vertex, NULL, 16), 0);
    split_levels(&h, fine, 3);
    size_t count = hanging_on(h.patches, &place, 1, vertex, NULL, 16); /* its right edge, upwards */
    assert_int_equal(count, 7);
    for (size_t i = 0; i < count; i++) {
        const sl_patch_vertex *v = &h.patches->vertex[vertex[i]];
        sl_vec3 at = sl_root_position(h.primitives, v->root, v->u, v->v);
        assert_true(at.x == 1.0f && at.y == (float)(i + 1) / 8.0f);
    }
    assert_int_equal(hanging_on(h.patches, &place, 1, vertex, NULL, 4), 4);
    for (int edge = 0; edge < 4; edge++) {
        if (edge != 1) assert_int_equal(hanging_on(h.patches, &place, edge, vertex, NULL, 16), 0);
    }
    /* Within one root, and gone when the finer ones go. */
    sl_patch_drop_children(h.patches, fine);
    assert_int_equal(hanging_on(h.patches, &place, 1, vertex, NULL, 16), 0);
    split(&h, coarse);
    uint32_t child = h.patches->patch[coarse].child;
    split(&h, child);
    place = sl_patch_place_of(h.patches, child + 1);
    assert_int_equal(hanging_on(h.patches, &place, 3, vertex, NULL, 16), 1);
    assert_false(h.patches->vertex[vertex[0]].references == 0);
    hierarchy_discard(&h);
}

static void leaves_around_a_vertex_are_all_that_have_it_and_no_others(void **state) {
    hierarchy h = hierarchy_of(two_triangles(false, 0), 0);
    split_levels(&h, want_root(&h, 0), 3);
    split_levels(&h, want_root(&h, 2), 1);
    sl_patches *p = h.patches;
    for (uint32_t vertex = 0; vertex < p->vertex_count; vertex++) {
        mark_around(p, p->vertex[vertex].place);
        for (uint32_t i = 0; i < p->patch_count; i++) {
            if (!sl_patch_is_alive(p, i) || !sl_patch_is_leaf(p, i)) continue;
            sl_patch_place place = sl_patch_place_of(p, i);
            bool has = false;
            for (int e = 0; e < 3; e++) {
                uint32_t hanging[64];
                size_t count = hanging_on(p, &place, e, hanging, NULL, 64);
                has |= sl_patch_corner(p, i, e) == vertex;
                for (size_t k = 0; k < count; k++) has |= hanging[k] == vertex;
            }
            assert_int_equal(has, (p->patch[i].flags & MARKED) != 0);
        }
    }
    hierarchy_discard(&h);
}

/* ---- values ---- */

static void values_are_bilinear_and_come_from_the_nearest_evaluated_ancestor(void **state) {
    hierarchy h = hierarchy_of(square_scene_of(0.2f), KEEP_LOBES);
    sl_patches *p = h.patches;
    uint32_t root = want_root(&h, 0);
    sl_patch_place place = sl_patch_place_of(p, root);
    float value[6];
    assert_false(sl_patch_value(p, &place, 0.5, 0.5, value));
    const float corner[4] = {1, 2, 4, 8};
    for (int c = 0; c < 4; c++) {
        uint32_t v = sl_patch_corner(p, root, c);
        p->vertex[v].evaluated = 1;
        for (int i = 0; i < 3; i++) sl_vertex_value(p, v)[i] = corner[c] * (float)(i + 1);
        sl_vertex_lobe(p, v)[1] = -corner[c];
    }
    split_levels(&h, root, 2);
    sl_patch_place leaf = sl_patch_locate(p, 0, 0.3, 0.6);
    assert_int_equal(leaf.depth, 2);
    double expected = 0.7 * 0.4 * 1 + 0.3 * 0.4 * 2 + 0.3 * 0.6 * 4 + 0.7 * 0.6 * 8;
    assert_true(sl_patch_value(p, &leaf, 0.3, 0.6, value));
    for (int i = 0; i < 3; i++) assert_true(fabs((double)value[i] - expected * (i + 1)) < 1e-5);
    assert_true(fabs((double)value[4] + expected) < 1e-5);
    for (int c = 0; c < 4; c++) { /* the leaf's own corners, once they are there */
        uint32_t v = sl_patch_corner(p, leaf.patch, c);
        p->vertex[v].evaluated = 2;
        sl_vertex_value(p, v)[0] = 100.0f;
    }
    assert_true(sl_patch_value(p, &leaf, 0.3, 0.6, value));
    assert_true(fabs((double)value[0] - 100.0) < 1e-4);
    hierarchy_discard(&h);
}

/* ---- splits and drops in any order ---- */

static void split_and_drop_at_random(hierarchy *h, uint64_t steps, int deepest) {
    sl_patches *p = h->patches;
    uint32_t roots = 2 * (uint32_t)h->primitives->count;
    uint64_t key = sl_random_key(11, roots);
    for (uint64_t i = 0; i < steps; i++) {
        uint32_t root = sl_random_bits(key, 4 * i) % roots, choice = sl_random_bits(key, 4 * i + 3);
        want_root(h, root);
        double u = (double)sl_random_unit(key, 4 * i + 1), v = (double)sl_random_unit(key, 4 * i + 2);
        sl_patch_place place = sl_patch_locate(p, root, u, v);
        bool growing = i / 2000 % 2 == 0;
        if (choice % 8 < (growing ? 7u : 2u)) {
            if (place.depth < deepest) split(h, place.patch);
        } else {
            uint32_t above = place.patch;
            for (uint32_t k = choice >> 8; k % 3 && sl_patch_parent(p, above) != SL_NO_INDEX; k /= 3)
                above = sl_patch_parent(p, above);
            sl_patch_drop_children(p, above);
        }
        if (i % 5000 == 4999) assert_sound(p);
    }
    for (uint32_t r = 0; r < roots; r++) sl_patch_drop_children(p, want_root(h, r));
    assert_sound(p);
    assert_int_equal(p->patches_alive, roots);
}

static void random_splits_and_drops_leave_a_sound_hierarchy(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    for (int i = 0; i < 2; i++)
        trace_mesh_quad(&mesh, sl_v3((float)i, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
    uint32_t a = trace_mesh_vertex(&mesh, 0, 1, 0), b = trace_mesh_vertex(&mesh, 1, 1, 0),
             c = trace_mesh_vertex(&mesh, 0.5f, 2, 0);
    trace_mesh_triangle(&mesh, a, b, c, 0);
    hierarchy h = hierarchy_of(trace_mesh_build(&mesh), 0);
    split_and_drop_at_random(&h, 100000, 9);
    assert_int_equal(h.patches->vertices_alive, 2 * 7); /* 6 of the squares, the triangle's tip */
    hierarchy_discard(&h);
}

static void so_do_they_on_curved_surfaces_with_a_pole(void **state) {
    hierarchy h = hierarchy_of(load_scene("scenes/vase.bpt"), 0);
    split_and_drop_at_random(&h, 20000, 7);
    assert_int_equal(h.patches->vertices_alive, 2 * (4 * 4 + 1)); /* rings of four, and the pole */
    hierarchy_discard(&h);
}

/* ---- degenerate shapes ---- */

static void patches_are_not_split_where_floats_cannot_tell_their_corners_apart(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    float x = 16384.0f; /* neighbouring floats are 1/512 apart */
    uint32_t a = trace_mesh_vertex(&mesh, x, 0, 0), b = trace_mesh_vertex(&mesh, x + 1.0f / 64.0f, 0, 0);
    uint32_t c = trace_mesh_vertex(&mesh, x, 1, 0);
    trace_mesh_triangle(&mesh, a, b, c, 0);
    hierarchy h = hierarchy_of(trace_mesh_build(&mesh), 0);
    split_levels(&h, want_root(&h, 0), 7);
    int deepest = 0;
    for (uint32_t i = 0; i < h.patches->patch_count; i++) {
        if (!sl_patch_is_alive(h.patches, i)) continue;
        sl_patch_place place = sl_patch_place_of(h.patches, i);
        if (place.depth > deepest) deepest = place.depth;
        sl_vec3 p[3];
        for (int k = 0; k < 3; k++) p[k] = sl_root_position(h.primitives, 0, place.u[k], place.v[k]);
        assert_true((p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x) > 0.0f);
    }
    assert_int_equal(deepest, 3);
    assert_sound(h.patches);
    hierarchy_discard(&h);
}

/* ---- eviction ---- */

static size_t seen_patches(const sl_patches *p, uint32_t since) {
    size_t count = 0;
    for (uint32_t i = 0; i < p->patch_count; i++)
        count += sl_patch_is_alive(p, i) && p->patch[i].seen >= since;
    return count;
}

static void see(sl_patches *p, uint32_t patch, uint32_t now, uint32_t pixels) {
    if (sl_patch_is_leaf(p, patch)) {
        p->patch[patch].pixels = pixels;
    } else {
        for (uint32_t k = 0; k < 4; k++) see(p, p->patch[patch].child + k, now, pixels);
    }
    p->patch[patch].seen = now;
}

static hierarchy two_walls(void) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 5), sl_v3(1, 0, 0), sl_v3(0, 1, 0), 0);
    hierarchy h = hierarchy_of(trace_mesh_build(&mesh), 0);
    split_levels(&h, want_root(&h, 0), 4);
    split_levels(&h, want_root(&h, 2), 4);
    return h;
}

static void eviction_takes_what_was_not_seen_for_longest_down_to_nine_tenths(void **state) {
    hierarchy h = two_walls();
    sl_patches *p = h.patches;
    size_t all = p->patches_alive;
    assert_int_equal(all, 2 * 341);
    see(p, sl_patches_find_root(p, 0), 100, 50);
    see(p, sl_patches_find_root(p, 2), 40, 50);
    uint32_t old_child = p->patch[sl_patches_find_root(p, 2)].child;
    see(p, old_child + 2, 30, 50); /* one quarter of it longer ago */
    sl_counters counters = {0};
    assert_int_equal(sl_patches_evict(p, all, 90, 0.8, &counters, NULL), SL_OK);
    assert_int_equal(p->patches_alive, all); /* not above the limit */
    assert_int_equal(sl_patches_evict(p, 640, 90, 0.8, &counters, NULL), SL_OK);
    assert_true(p->patches_alive <= 576 && p->patches_alive > 576 - 4);
    assert_int_equal(counters.value[SL_COUNT_PATCHES_EVICTED], all - p->patches_alive);
    assert_int_equal(seen_patches(p, 100), 341);
    /* the oldest quarter went whole, and before the others */
    assert_true(sl_patch_is_leaf(p, old_child + 2));
    assert_sound(p);
    /* Whatever is wanted: what was seen within the window stays, and roots do. */
    assert_int_equal(sl_patches_evict(p, 1, 90, 0.8, &counters, NULL), SL_OK);
    assert_int_equal(p->patches_alive, 341 + 1);
    assert_int_equal(seen_patches(p, 100), 341);
    assert_int_equal(p->patch[sl_patches_find_root(p, 2)].seen, 40);
    assert_int_equal(p->patch[sl_patches_find_root(p, 2)].pixels, 12 * 16 * 50 + 0 * 50);
    assert_sound(p);
    hierarchy_discard(&h);
}

static void eviction_takes_children_of_patches_below_a_pixel_even_if_they_are_in_view(void **state) {
    hierarchy h = two_walls();
    sl_patches *p = h.patches;
    see(p, sl_patches_find_root(p, 0), 100, 2);
    see(p, sl_patches_find_root(p, 2), 100, 0);
    sl_counters counters = {0};
    assert_int_equal(sl_patches_evict(p, 10, 90, 0.8, &counters, NULL), SL_OK);
    assert_int_equal(p->patches_alive, 341 + 1);
    hierarchy_discard(&h);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_square_split_to_depth_d_has_4_to_the_d_leaves_and_a_grid_of_vertices),
        cmocka_unit_test(a_triangle_split_to_depth_d_has_4_to_the_d_leaves_and_a_triangular_grid_of_vertices),
        cmocka_unit_test(
            nothing_is_there_before_it_is_wanted_and_nothing_is_evaluated_before_it_is_asked_for),
        cmocka_unit_test(every_point_is_in_the_leaf_that_is_found_for_it),
        cmocka_unit_test(a_closed_box_shares_no_corner_and_a_flat_fan_shares_all),
        cmocka_unit_test(primitives_share_an_edge_where_normal_and_material_agree_and_only_there),
        cmocka_unit_test(a_shared_vertex_is_evaluated_once_for_both),
        cmocka_unit_test(a_leaf_beside_finer_ones_knows_the_vertices_on_its_edge_in_order),
        cmocka_unit_test(leaves_around_a_vertex_are_all_that_have_it_and_no_others),
        cmocka_unit_test(values_are_bilinear_and_come_from_the_nearest_evaluated_ancestor),
        cmocka_unit_test(random_splits_and_drops_leave_a_sound_hierarchy),
        cmocka_unit_test(so_do_they_on_curved_surfaces_with_a_pole),
        cmocka_unit_test(patches_are_not_split_where_floats_cannot_tell_their_corners_apart),
        cmocka_unit_test(eviction_takes_what_was_not_seen_for_longest_down_to_nine_tenths),
        cmocka_unit_test(eviction_takes_children_of_patches_below_a_pixel_even_if_they_are_in_view),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
