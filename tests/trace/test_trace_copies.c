/* Copies of a mesh share one hierarchy, and no ray can tell. */
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "trace/copies.h"
#include "trace/trace.h"

enum { COLUMNS = 24, ROWS = 12, VERTICES = (COLUMNS + 1) * (ROWS + 1), COPIES = 40, RAYS = 48000 };

static double number(uint64_t key, uint64_t i) { return (double)sl_random_unit(sl_random_key(key, 1), i); }

static uint32_t add_blob(sl_scene_builder *b, double bump) {
    static float p[3 * VERTICES];
    static uint32_t f[6 * COLUMNS * ROWS];
    uint32_t mesh, *t = f;
    for (int i = 0; i < VERTICES; i++) {
        const double x = (double)(i % (COLUMNS + 1)), y = (double)i / (COLUMNS + 1),
                     r = 1.0 + bump * sl_sin(3.0 * x + y), up = sl_cos(SL_PI * (0.05 + 0.07 * y)),
                     out = sl_sin(SL_PI * (0.05 + 0.07 * y));
        p[3 * i] = (float)(r * out * sl_cos(2.0 * SL_PI * x / COLUMNS));
        p[3 * i + 1] = (float)(r * up);
        p[3 * i + 2] = (float)(r * out * sl_sin(2.0 * SL_PI * x / COLUMNS));
    }
    for (uint32_t j = 0; j < ROWS; j++) {
        for (uint32_t i = 0; i < COLUMNS; i++) {
            const uint32_t a = j * (COLUMNS + 1) + i, c = a + COLUMNS + 2;
            const uint32_t two[6] = {a, a + 1, c, a, c, c - 1};
            memcpy(t, two, sizeof two);
            t += 6;
        }
    }
    const sl_mesh_data data = {.size = sizeof data, .vertex_count = VERTICES, .positions = p,
                               .triangle_count = 2 * COLUMNS * ROWS, .indices = f};
    assert_int_equal(sl_scene_builder_mesh(b, &data, &mesh, NULL), SL_OK);
    return mesh;
}

/* Turned, mirrored, of any size, squeezed, and through one another. */
static void place(sl_scene_builder *b, uint32_t mesh, uint64_t i, double far) {
    const double turn = 6.0 * number(1, i), size = 0.3 + 2.0 * number(2, i) * number(2, i),
                 squeeze = i % 4 == 1 ? 0.4 : 1.0, side = i % 5 == 2 ? -1.0 : 1.0, c = sl_cos(turn),
                 s = sl_sin(turn);
    const double m[16] = {size * c, 0, -size * s, 0, 0, size * squeeze, 0.2 * size * squeeze, 0,
                          size * s * side, 0, size * c * side, 0,
                          far + 8.0 * number(3, i), 3.0 * number(4, i), 8.0 * number(5, i) - far, 1};
    const sl_instance_data here = {.size = sizeof here, .mesh = mesh, .transform = m};
    assert_int_equal(sl_scene_builder_instance(b, &here, NULL), SL_OK);
}

static sl_scene *field(double far) {
    sl_scene_builder *b;
    sl_scene *scene;
    assert_int_equal(sl_scene_builder_create(&b, NULL), SL_OK);
    const uint32_t blob = add_blob(b, 0.3), other = add_blob(b, 0.30003);
    for (uint64_t i = 0; i < COPIES; i++) place(b, i % 10 == 3 ? other : blob, i, far);
    assert_int_equal(sl_scene_builder_build(b, &scene, NULL), SL_OK);
    sl_scene_builder_destroy(b);
    return scene;
}

/* In turn at corners, at edges and at insides of triangles, from among the blobs. */
static void aim(const sl_scene *s, sl_ray16 *rays, unsigned lane, uint64_t i) {
    const uint32_t t = (uint32_t)(number(6, i) * (double)(s->triangle_count - 1));
    sl_vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_scene_position(s, s->vertex[k][t]);
    const sl_vec3 edge = sl_mad(p[0], i % 3 ? (float)number(7, i) : 0.0f, sl_sub(p[1], p[0])),
                  at = sl_mad(edge, i % 3 == 2 ? (float)number(8, i) : 0.0f, sl_sub(p[2], edge)),
                  size = sl_sub(s->box_max, s->box_min),
                  from = sl_add(s->box_min, sl_v3(size.x * (float)number(9, i), size.y * (float)number(10, i),
                                                  size.z * (float)number(11, i)));
    sl_ray16_set(rays, lane, from, sl_sub(at, from), 0.0f, i % 7 ? INFINITY : 1.0f, i % 11 ? SL_NO_INDEX : t);
}

static sl_tracer *tracer_worth(const sl_scene *scene, size_t worth, const char *config) {
    sl_tracer *tracer;
    sl_error error = {0};
    if (sl_tracer_create_sharing(scene, 2, config, worth, &tracer, &error) != SL_OK)
        fail_msg("%s", error.message);
    return tracer;
}

static void expect_the_same_hits(const sl_scene *scene, const char *config) {
    sl_tracer *one = tracer_worth(scene, SIZE_MAX, config), *shared = tracer_worth(scene, 1, config);
    sl_counters counters = {{0}};
    size_t met = 0;
    for (uint64_t first = 0; first < RAYS; first += SL_PACKET) {
        const bool coherent = first / SL_PACKET % 2;
        sl_ray16 rays;
        sl_hit16 expected, got;
        for (unsigned i = 0; i < SL_PACKET; i++) aim(scene, &rays, i, first + i);
        sl_trace(one, &rays, SL_PACKET, coherent, &expected, &counters);
        sl_trace(shared, &rays, SL_PACKET, coherent, &got, &counters);
        assert_memory_equal(&expected, &got, sizeof got);
        assert_int_equal(sl_trace_occluded(one, &rays, SL_PACKET, coherent, &counters),
                         sl_trace_occluded(shared, &rays, SL_PACKET, coherent, &counters));
        for (unsigned i = 0; i < SL_PACKET; i++) met += got.triangle[i] != SL_NO_INDEX;
    }
    assert_true(met > RAYS / 2);
    /* bytes a triangle of a few meshes, not of all */
    assert_true(3 * sl_tracer_memory_bytes(shared) < sl_tracer_memory_bytes(one));
    sl_tracer_destroy(one);
    sl_tracer_destroy(shared);
}

static void rays_hit_copies_as_they_hit_the_triangles(void **unused) {
    static const char *const embree[] = {NULL, "isa=sse2", "isa=avx"};
    for (int e = 0; e < 3; e++) {
        sl_scene *scene = field(e == 2 ? 3000.0 : 0.0);
        expect_the_same_hits(scene, embree[e]);
        sl_scene_destroy(scene);
    }
}

static void copies_are_known_by_their_corners(void **unused) {
    sl_scene *scene = field(0.0);
    sl_copies copies;
    assert_int_equal(sl_copies_find(scene, 1, &copies, NULL), SL_OK);
    assert_int_equal(copies.copy_count, COPIES);
    assert_int_equal(copies.mesh_count, 2);
    assert_int_equal(copies.saved, (COPIES - 2) * (scene->triangle_count / COPIES));
    sl_copies_release(&copies);
    scene->position_x[scene->vertex[0][5 * (scene->triangle_count / COPIES) + 7]] += 0.01f;
    assert_int_equal(sl_copies_find(scene, 1, &copies, NULL), SL_OK);
    assert_int_equal(copies.copy_count, COPIES - 1);
    sl_copies_release(&copies);
    assert_int_equal(sl_copies_find(scene, scene->triangle_count - 1, &copies, NULL), SL_OK);
    assert_int_equal(copies.copy_count, 0);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_hit_copies_as_they_hit_the_triangles),
        cmocka_unit_test(copies_are_known_by_their_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
