/* Bytes a triangle by method, in the accounts that the library keeps: a mesh that is there many times. */
#include <stdlib.h>

#include "unit_test.h"
#include "base/math.h"
#include "rendering.h"

enum { COLUMNS = 100, ROWS = 50, VERTICES = (COLUMNS + 1) * (ROWS + 1), COPIES = 64, SIDE = 8 };

static uint32_t add_ball(sl_scene_builder *b) {
    float *p = malloc(3 * VERTICES * sizeof *p);
    uint32_t *corner = malloc((size_t)6 * COLUMNS * ROWS * sizeof *corner), mesh;
    size_t corners = 0;
    for (int v = 0; v < VERTICES; v++) {
        const double turn = 2.0 * SL_PI * (v % (COLUMNS + 1)) / COLUMNS,
                     down = SL_PI * (0.02 + 0.96 * (v / (COLUMNS + 1)) / ROWS);
        p[3 * v] = (float)(sl_sin(down) * sl_cos(turn));
        p[3 * v + 1] = (float)sl_cos(down);
        p[3 * v + 2] = (float)(sl_sin(down) * sl_sin(turn));
    }
    for (uint32_t cell = 0; cell < COLUMNS * ROWS; cell++) {
        const uint32_t a = cell / COLUMNS * (COLUMNS + 1) + cell % COLUMNS, c = a + COLUMNS + 2,
                       six[6] = {a, a + 1, c, a, c, c - 1};
        for (int i = 0; i < 6; i++) corner[corners++] = six[i];
    }
    const sl_mesh_data ball = {.size = sizeof ball,
                               .vertex_count = VERTICES,
                               .positions = p,
                               .normals = p,
                               .triangle_count = corners / 3,
                               .indices = corner};
    assert_int_equal(sl_scene_builder_mesh(b, &ball, &mesh, NULL), SL_OK);
    free(p);
    free(corner);
    return mesh;
}

static sl_scene *field_of_balls(void) {
    const sl_light_data lamp = {
        .size = sizeof lamp, .type = SL_LIGHT_POINT, .position = {0, 9, 0}, .strength = {50, 50, 50}};
    sl_scene_builder *b;
    sl_scene *scene;
    assert_int_equal(sl_scene_builder_create(&b, NULL), SL_OK);
    const uint32_t ball = add_ball(b);
    for (int i = 0; i < COPIES; i++) {
        const double c = sl_cos(0.7 * i), s = sl_sin(0.7 * i), x = 2.4 * (i % SIDE - SIDE / 2);
        const double m[16] = {c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, x, 0, -2.4 * (i / SIDE), 1};
        const sl_instance_data here = {.size = sizeof here, .mesh = ball, .transform = m};
        assert_int_equal(sl_scene_builder_instance(b, &here, NULL), SL_OK);
    }
    assert_int_equal(sl_scene_builder_light(b, &lamp, NULL), SL_OK);
    assert_int_equal(sl_scene_builder_build(b, &scene, NULL), SL_OK);
    sl_scene_builder_destroy(b);
    return scene;
}

/* A gigabyte for ten million triangles is 107 bytes for each, of which loading and the film take their part. */
static void a_mesh_that_is_there_many_times_takes_few_bytes_a_triangle(void **unused) {
    static const struct {
        const char *method;
        double most; /* beside the scene */
    } cases[] = {{"path", 1.5}, {"splatting", 28.0}, {"shading-cache", 70.0}, {"multi-mesh", 242.0}};
    sl_scene *scene = field_of_balls();
    const double triangles = (double)sl_scene_triangle_count(scene);
    assert_true((double)sl_scene_memory_bytes(scene) < 54.0 * triangles);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        sl_settings settings = small_settings(cases[i].method, 16, 12);
        settings.threads = 1;
        sl_method *method = created_method(scene, &settings);
        const double each = (double)sl_method_memory_bytes(method) / triangles;
        print_message("%-14s %.1f bytes a triangle\n", cases[i].method, each);
        assert_true(each < cases[i].most);
        sl_method_destroy(method);
    }
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_that_is_there_many_times_takes_few_bytes_a_triangle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
