/* Patches as multi-mesh caching has them: continuity of values, what is kept and used again. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "unit_test.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/patches/mesh.h"
#include "trace_scenes.h"

typedef struct world {
    sl_scene *scene;
    sl_primitives *primitives;
    sl_patches *mesh;
} world;

static world world_of(trace_mesh parts, int channels, int depth) {
    world w = {.scene = trace_mesh_build(&parts)};
    const sl_patches_settings settings = {.channels = channels, .max_depth = depth};
    assert_int_equal(sl_primitives_of_triangles(w.scene, &w.primitives, NULL), SL_OK);
    assert_int_equal(sl_patches_create(w.primitives, &settings, &w.mesh, NULL), SL_OK);
    return w;
}

static void discard(world *w) {
    sl_patches_destroy(w->mesh);
    sl_primitives_destroy(w->primitives);
    sl_scene_destroy(w->scene);
}

static uint32_t root(world *w, uint32_t face) {
    sl_status status;
    uint32_t node = sl_patches_root(w->mesh, face, &status, NULL);
    assert_int_equal(status, SL_OK);
    return node;
}

static void split_all(sl_patches *mesh, sl_patch_place place, int levels) {
    if (levels == 0) return;
    if (sl_patch_is_leaf(mesh, place.patch)) assert_int_equal(sl_mesh_split(mesh, &place, NULL), SL_OK);
    assert_false(sl_patch_is_leaf(mesh, place.patch));
    for (int c = 0; c < 4; c++) split_all(mesh, sl_patch_child_place(mesh, &place, c), levels - 1);
}

static trace_mesh one_triangle(void) {
    trace_mesh m = trace_mesh_begin();
    trace_mesh_diffuse(&m, 0.5f);
    uint32_t a = trace_mesh_vertex(&m, 0, 0, 0), b = trace_mesh_vertex(&m, 1, 0, 0),
             c = trace_mesh_vertex(&m, 0, 1, 0);
    trace_mesh_triangle(&m, a, b, c, 0);
    return m;
}

/* A flat field of columns x rows squares in z = 0, two triangles each, the last row only 1/64 high (slivers).
 * Positions of vertices are exact. */
static trace_mesh field(int columns, int rows) {
    trace_mesh m = trace_mesh_begin();
    trace_mesh_diffuse(&m, 0.5f);
    for (int y = 0; y <= rows; y++)
        for (int x = 0; x <= columns; x++)
            trace_mesh_vertex(&m, (float)x, y < rows ? (float)y : (float)(rows - 1) + 0x1p-6f, 0);
    for (int y = 0; y < rows; y++)
        for (int x = 0; x < columns; x++) {
            uint32_t a = (uint32_t)(y * (columns + 1) + x), b = a + 1, c = a + (uint32_t)columns + 1,
                     d = c + 1;
            trace_mesh_triangle(&m, a, b, d, 0);
            trace_mesh_triangle(&m, d, c, a, 0);
        }
    return m;
}

static uint64_t stream(uint64_t n) { return sl_random_key(1, n); }

/* The leaf around a random point of a random face. */
static sl_patch_place random_leaf(const sl_patches *mesh, uint64_t key, uint64_t index, uint32_t sides) {
    uint32_t faces = (uint32_t)(mesh->primitives->count * 2),
             face = sl_random_bits(key, 3 * index) % (faces / sides) * sides;
    return sl_mesh_locate(mesh, face, sl_random_unit(key, 3 * index + 1), sl_random_unit(key, 3 * index + 2));
}

/* Fronts alone, split at random places no deeper than `depth`. */
static void refine_randomly(world *w, int splits, int depth, uint64_t seed) {
    uint64_t key = sl_random_key(seed, 1);
    for (uint32_t f = 0; f < w->primitives->count * 2; f += 2) root(w, f);
    for (int i = 0; i < splits; i++) {
        sl_patch_place leaf = random_leaf(w->mesh, key, (uint64_t)i, 2);
        if (leaf.depth < depth) assert_int_equal(sl_mesh_split(w->mesh, &leaf, NULL), SL_OK);
    }
}

/* Every vertex becomes known, with channel c a linear function of its position (or a random number). */
static double linear(int channel, sl_vec3d p) {
    return 1.5 + 0.25 * channel + (0.5 - channel) * p.x + (2.0 + channel) * p.y - p.z;
}

static void know_all(sl_patches *mesh, const char *what) {
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        sl_mesh_point point;
        point = sl_mesh_point_of(mesh, v);
        sl_mesh_set_state(mesh, v, SL_VERTEX_KNOWN);
        for (int c = 0; c < mesh->settings.channels; c++) {
            float *value = &sl_vertex_value(mesh, v)[c];
            *value = what[0] == 'l'   ? (float)linear(c, sl_to_double(point.lit.position))
                     : what[0] == 'r' ? sl_random_unit(stream(77), v * 3 + (uint32_t)c)
                                      : 0.7123f;
        }
    }
}

static sl_vec3d position_in_face(const sl_primitives *primitives, uint32_t face, double w1, double w2) {
    const sl_scene *s = primitives->scene;
    const double w[3] = {1.0 - w1 - w2, w1, w2};
    sl_vec3d p = {0, 0, 0};
    for (int c = 0; c < 3; c++)
        p = sl_addd(p, sl_scaled(sl_to_double(sl_scene_position(s, s->vertex[c][face / 2])), w[c]));
    return p;
}

static sl_vec3d position_in_place(const sl_primitives *primitives, const sl_patch_place *place,
                                  const double w[3]) {
    double p = 0, q = 0;
    for (int c = 0; c < 3; c++) {
        p += w[c] * place->u[c] / SL_PATCH_DYADIC;
        q += w[c] * place->v[c] / SL_PATCH_DYADIC;
    }
    return position_in_face(primitives, place->root, p, q);
}

typedef void (*place_visitor)(const sl_patches *mesh, const sl_patch_place *place, void *context);

static void visit_below(const sl_patches *mesh, const sl_patch_place *place, place_visitor visitor,
                        void *context) {
    visitor(mesh, place, context);
    for (int c = 0; !sl_patch_is_leaf(mesh, place->patch) && c < 4; c++) {
        sl_patch_place child = sl_patch_child_place(mesh, place, c);
        visit_below(mesh, &child, visitor, context);
    }
}

static void visit_all(const sl_patches *mesh, place_visitor visitor, void *context) {
    for (uint32_t f = 0; f < mesh->primitives->count * 2; f++) {
        sl_patch_place place = sl_patch_root_place(mesh, f);
        if (place.patch != SL_NO_INDEX) visit_below(mesh, &place, visitor, context);
    }
}

/* Where nobody holds copies of the tree. Vertices of tested edges stay, with their values. */
static void blocks_that_drops_leave_are_used_again_at_once(void **state) {
    world w = world_of(field(2, 2), 1, 12);
    refine_randomly(&w, 200, 6, 9);
    size_t patches = 0, leaves = w.mesh->leaves_alive;
    for (int cycle = 0; cycle < 50; cycle++) {
        sl_patch_place leaf = random_leaf(w.mesh, stream(3), 0, 2); /* the same one every time */
        sl_status status;
        uint32_t middle = sl_mesh_middle(w.mesh, &leaf, 1, &status, NULL);
        split_all(w.mesh, leaf, 2);
        if (cycle == 0) patches = w.mesh->patch_count;
        sl_patch_drop_children(w.mesh, leaf.patch);
        assert_int_equal(w.mesh->leaves_alive, leaves);
        assert_int_equal(sl_mesh_find_middle(w.mesh, &leaf, 1), middle);
    }
    assert_int_equal(w.mesh->patch_count, patches);
    discard(&w);
}

static void children_keep_what_is_left_of_closed_edges(void **state) {
    world w = world_of(one_triangle(), 1, 12);
    uint32_t node = root(&w, 0);
    sl_patch_place place = sl_patch_root_place(w.mesh, 0);
    /* edge 1 closed (corners 2 and 0), edge 2 failed */
    w.mesh->patch[node].flags |= SL_EDGE_CLOSED << 2 | SL_EDGE_SPLIT << 4;
    assert_int_equal(sl_mesh_split(w.mesh, &place, NULL), SL_OK);
    uint32_t wanted[4] = {SL_EDGE_CLOSED << 2, 0, SL_EDGE_CLOSED << 2, 0};
    for (uint32_t c = 0; c < 4; c++)
        assert_int_equal(w.mesh->patch[w.mesh->patch[node].child + c].flags & SL_PATCH_EDGES, wanted[c]);
    discard(&w);
}

/* ---- points and values ----------------------------------------------------------------------- */

static void a_constant_stays_the_same_in_every_bit_whatever_is_refined(void **state) {
    world w = world_of(field(3, 3), 3, 10);
    refine_randomly(&w, 2000, 9, 12);
    know_all(w.mesh, "constant");
    for (uint64_t i = 0; i < 20000; i++) {
        float value[3], w1 = sl_random_unit(stream(13), 3 * i), w2 = sl_random_unit(stream(13), 3 * i + 1);
        assert_true(sl_mesh_value(w.mesh, 2 * (sl_random_bits(stream(13), 3 * i + 2) % 18), w1, w2, value));
        for (int c = 0; c < 3; c++) assert_true(value[c] == 0.7123f);
    }
    discard(&w);
}

static void a_linear_field_is_reproduced_whatever_is_refined(void **state) {
    for (int hanging = 0; hanging < 2; hanging++) {
        world w = world_of(field(3, 3), 3, 10);
        refine_randomly(&w, 2000, 9, 21);
        know_all(w.mesh, "linear");
        for (uint64_t i = 0; i < 20000; i++) {
            float value[3], l1, l2, w1 = sl_random_unit(stream(17), 3 * i),
                                    w2 = (1.0f - w1) * sl_random_unit(stream(17), 3 * i + 1);
            uint32_t face = 2 * (sl_random_bits(stream(17), 3 * i + 2) % 18);
            sl_patch_place leaf = sl_mesh_locate(w.mesh, face, w1, w2);
            sl_mesh_weights_within(&leaf, w1, w2, &l1, &l2);
            assert_true(sl_mesh_interpolate(w.mesh, &leaf, l1, l2, hanging == 1, value));
            sl_vec3d p = position_in_face(w.primitives, face, w1, w2);
            for (int c = 0; c < 3; c++) assert_true(fabs((double)value[c] - linear(c, p)) < 4e-6);
        }
        discard(&w);
    }
}

/* Points along a line through a face, some of them outside. */
static void lanes_along_a_line(uint64_t number, float w1[SL_FAN_LANES], float w2[SL_FAN_LANES]) {
    const float u = sl_random_unit(stream(19), 2 * number), v = sl_random_unit(stream(19), 2 * number + 1);
    for (int l = 0; l < SL_FAN_LANES; l++) {
        w1[l] = u + 0.01f * (float)(number % 7) * (float)l;
        w2[l] = v * (1.0f - u) - 0.003f * (float)l;
    }
}

static void points_in_lanes_have_the_values_of_one_after_another_to_the_bit(void **state) {
    world w = world_of(field(3, 3), 3, 10);
    refine_randomly(&w, 300, 6, 12);
    know_all(w.mesh, "linear");
    size_t together = 0;
    for (uint64_t i = 0; i < 3000; i++) {
        const uint32_t face = 2 * (uint32_t)(i % 18);
        float w1[SL_FAN_LANES], w2[SL_FAN_LANES], a[SL_FAN_LANES], b[SL_FAN_LANES], value[3][SL_FAN_LANES];
        sl_mesh_fan fan;
        lanes_along_a_line(i, w1, w2);
        sl_patch_place leaf = sl_mesh_locate(w.mesh, face, w1[0], w2[0]);
        assert_true(sl_mesh_fan_make(w.mesh, &leaf, true, &fan));
        const sl_fan_shown shown = sl_mesh_fan_shows(&fan);
        for (int isa = 0; isa <= (int)sl_isa_best(); isa++) {
            size_t run = SL_KERNEL_OF((sl_isa)isa, sl_mesh_run)(&leaf, SL_FAN_LANES, w1, w2, a, b);
            SL_KERNEL_OF((sl_isa)isa, sl_mesh_fan_values)(&shown, a, b, value);
            assert_true(run >= 1 && run <= SL_FAN_LANES);
            together += run - 1;
            for (size_t l = 0; l < run; l++) {
                float one[3];
                assert_int_equal(sl_mesh_locate(w.mesh, face, w1[l], w2[l]).patch, leaf.patch);
                assert_true(sl_mesh_value(w.mesh, face, w1[l], w2[l], one));
                for (int c = 0; c < 3; c++) assert_memory_equal(&one[c], &value[c][l], sizeof *one);
            }
        }
    }
    assert_true(together > 20000);
    discard(&w);
}

static void a_hanging_vertex_shows_its_value_and_the_centre_the_mean(void **state) {
    world w = world_of(one_triangle(), 1, 12);
    root(&w, 0);
    sl_patch_place place = sl_patch_root_place(w.mesh, 0);
    sl_status status;
    uint32_t middle = sl_mesh_middle(w.mesh, &place, 0, &status, NULL);
    know_all(w.mesh, "constant");
    *sl_vertex_value(w.mesh, middle) = 5.0f;
    float value;
    assert_true(sl_mesh_interpolate(w.mesh, &place, 0.5f, 0.5f, true, &value) && value == 5.0f);
    assert_true(sl_mesh_interpolate(w.mesh, &place, 0.5f, 0.5f, false, &value) && value == 0.7123f);
    assert_true(sl_mesh_interpolate(w.mesh, &place, 1.0f / 3, 1.0f / 3, true, &value) &&
                fabs((double)value - 0.7123) < 1e-5);
    assert_true(sl_mesh_interpolate(w.mesh, &place, 0.75f, 0.25f, true, &value) &&
                fabs((double)value - (5.0 + 0.7123) / 2) < 1e-6);
    assert_true(sl_mesh_interpolate(w.mesh, &place, 0.5f, 0.0f, true, &value) && value == 0.7123f);
    sl_mesh_set_state(w.mesh, middle, SL_VERTEX_REQUESTED);
    assert_true(sl_mesh_interpolate(w.mesh, &place, 0.5f, 0.5f, true, &value) && value == 0.7123f);
    discard(&w);
}

static void corners_that_are_not_known_give_no_value_and_invalid_ones_the_mean_of_the_others(void **state) {
    world w = world_of(one_triangle(), 1, 12);
    root(&w, 0);
    know_all(w.mesh, "constant");
    sl_patch_place place = sl_patch_root_place(w.mesh, 0);
    for (uint32_t v = 0; v < 3; v++) *sl_vertex_value(w.mesh, v) = (float)v;
    float value = -7.0f;
    sl_mesh_set_state(w.mesh, 1, SL_VERTEX_REQUESTED);
    assert_false(sl_mesh_interpolate(w.mesh, &place, 0.2f, 0.2f, true, &value));
    sl_mesh_set_state(w.mesh, 1, SL_VERTEX_UNKNOWN);
    assert_false(sl_mesh_interpolate(w.mesh, &place, 0.2f, 0.2f, true, &value));
    assert_true(value == -7.0f);
    sl_mesh_set_state(w.mesh, 0, SL_VERTEX_INVALID);
    sl_mesh_set_state(w.mesh, 1, SL_VERTEX_KNOWN);
    *sl_vertex_value(w.mesh, 0) = NAN;
    assert_true(sl_mesh_interpolate(w.mesh, &place, 0.0f, 0.0f, true, &value) && value == 1.5f);
    sl_mesh_set_state(w.mesh, 1, SL_VERTEX_INVALID);
    sl_mesh_set_state(w.mesh, 2, SL_VERTEX_INVALID);
    assert_false(sl_mesh_interpolate(w.mesh, &place, 0.0f, 0.0f, true, &value));
    discard(&w);
}

/* Values at points of leaves' edges, to be compared between all leaves around a point. */
typedef struct edge_sample {
    double x, y;
    float value;
} edge_sample;

typedef struct edge_samples {
    edge_sample *sample;
    size_t count, capacity;
} edge_samples;

enum { EDGE_STEPS = 64 };

static void sample_edges(const sl_patches *mesh, const sl_patch_place *place, void *context) {
    edge_samples *all = context;
    if (!sl_patch_is_leaf(mesh, place->patch)) return;
    for (int e = 0; e < 3; e++)
        for (int i = 0; i < EDGE_STEPS; i++) {
            double w[3] = {0, 0, 0};
            w[(e + 1) % 3] = 1.0 - (double)i / EDGE_STEPS;
            w[(e + 2) % 3] = (double)i / EDGE_STEPS;
            sl_vec3d p = position_in_place(mesh->primitives, place, w);
            assert_true(all->count < all->capacity);
            edge_sample *s = &all->sample[all->count++];
            *s = (edge_sample){.x = p.x, .y = p.y};
            assert_true(sl_mesh_interpolate(mesh, place, (float)w[1], (float)w[2], true, &s->value));
        }
}

static int by_position(const void *a, const void *b) {
    const edge_sample *x = a, *y = b;
    if (x->x != y->x) return x->x < y->x ? -1 : 1;
    return x->y < y->y ? -1 : x->y > y->y;
}

static void leaves_of_any_size_have_the_same_values_along_common_edges(void **state) {
    world w = world_of(field(3, 3), 1, 10);
    refine_randomly(&w, 1200, 6, 33);
    know_all(w.mesh, "random");
    edge_samples all = {.capacity = w.mesh->leaves_alive * 3 * EDGE_STEPS};
    all.sample = sl_allocate(all.capacity, sizeof *all.sample);
    visit_all(w.mesh, sample_edges, &all);
    qsort(all.sample, all.count, sizeof *all.sample, by_position);
    size_t met = 0;
    for (size_t i = 1; i < all.count; i++) {
        if (by_position(&all.sample[i], &all.sample[i - 1]) != 0) continue;
        assert_true(fabsf(all.sample[i].value - all.sample[i - 1].value) < 1e-6f);
        met++;
    }
    assert_true(met > all.count / 3);
    sl_free(all.sample);
    discard(&w);
}

/* ---- hard triangles -------------------------------------------------------------------------- */

static void triangles_without_area_are_never_split(void **state) {
    trace_mesh parts = field(2, 1);
    sl_scene *scene = trace_mesh_build(&parts);
    scene->position_x[scene->vertex[0][0]] = NAN;
    scene->position_z[scene->vertex[0][3]] = INFINITY;
    world w = {.scene = scene};
    assert_int_equal(sl_primitives_of_triangles(scene, &w.primitives, NULL), SL_OK);
    const sl_patches_settings settings = {.channels = 1, .max_depth = 12};
    assert_int_equal(sl_patches_create(w.primitives, &settings, &w.mesh, NULL), SL_OK);
    assert_true(sl_triangle_is_degenerate(scene, 0) && sl_triangle_is_degenerate(scene, 3));
    for (uint32_t f = 0; f < w.primitives->count * 2; f++) {
        root(&w, f);
        sl_patch_place place = sl_patch_root_place(w.mesh, f);
        assert_int_equal(sl_mesh_split(w.mesh, &place, NULL), SL_OK);
        assert_int_equal(sl_patch_is_leaf(w.mesh, place.patch), sl_triangle_is_degenerate(scene, f / 2));
    }
    discard(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_that_drops_leave_are_used_again_at_once),
        cmocka_unit_test(children_keep_what_is_left_of_closed_edges),
        cmocka_unit_test(a_constant_stays_the_same_in_every_bit_whatever_is_refined),
        cmocka_unit_test(a_linear_field_is_reproduced_whatever_is_refined),
        cmocka_unit_test(points_in_lanes_have_the_values_of_one_after_another_to_the_bit),
        cmocka_unit_test(a_hanging_vertex_shows_its_value_and_the_centre_the_mean),
        cmocka_unit_test(corners_that_are_not_known_give_no_value_and_invalid_ones_the_mean_of_the_others),
        cmocka_unit_test(leaves_of_any_size_have_the_same_values_along_common_edges),
        cmocka_unit_test(triangles_without_area_are_never_split),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
