/* Which lights there are: what is one, what it looks like, and that lights know nothing of each other. */
#include <string.h>

#include "light_sample_support.h"

#include "base/random.h"

static const sl_vec3 up = {0, 1, 0};

static uint32_t lamp_material(trace_mesh *mesh, float radiance) { return trace_mesh_lamp(mesh, radiance); }

/* A horizontal quad that shines down. */
static void add_panel(trace_mesh *mesh, float x, float y, float z, float size, uint32_t material) {
    trace_mesh_quad(mesh, sl_v3(x, y, z), sl_v3(size, 0, 0), sl_v3(0, 0, size), material);
}

static void coplanar_triangles_of_one_radiance_are_one_light(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t dim = lamp_material(&mesh, 1), bright = lamp_material(&mesh, 2);
    add_panel(&mesh, 0, 2, 0, 1, dim);
    add_panel(&mesh, 3, 2, 0, 1, bright);
    add_panel(&mesh, 5, 2, 0, 1, dim); /* apart from the first, in its plane */
    light_world w = light_world_make(&mesh);
    assert_int_equal(w.lights->count, 2);
    assert_int_equal(w.lights->light[0].triangles, 4);
    assert_int_equal(w.lights->light[1].triangles, 2);
    assert_true(w.lights->light[0].kind == SL_SOURCE_AREA && w.lights->light[0].normal.y == -1.0f);
    assert_near((double)w.lights->light[0].position.x, 3.0, 1e-6);
    assert_near((double)w.lights->light[1].colour.r, 2.0 * 3.14159265, 1e-5);
    for (uint32_t t = 0; t < 6; t++) assert_int_equal(w.lights->light_of_triangle[t], t == 2 || t == 3);
    for (size_t k = 1; k < 4; k++)
        assert_true(w.lights->light[0].triangle[k] > w.lights->light[0].triangle[k - 1]);
    light_world_free(&w);
}

static void bulbs_apart_are_lights_of_their_own(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t lamp = lamp_material(&mesh, 1), grey = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_sphere(&mesh, sl_v3(0, 2, 0), 0.1f, 8, 0.0f, false, lamp);
    add_panel(&mesh, 9, 9, 9, 1, grey);
    trace_mesh_sphere(&mesh, sl_v3(2, 2, 0), 0.1f, 8, 0.0f, false, lamp);
    add_panel(&mesh, 1, 3, 1, 0.5f, lamp);
    light_world w = light_world_make(&mesh);
    assert_int_equal(w.lights->count, 3);
    assert_true(w.lights->light[0].kind == SL_SOURCE_SOLID && w.lights->light[1].kind == SL_SOURCE_SOLID);
    assert_int_equal(w.lights->light[2].kind, SL_SOURCE_AREA);
    assert_near((double)w.lights->light[1].position.x, 2.0, 1e-5);
    assert_true(sample_light(&w, 0, sl_v3(0, 0, 0), up) > sample_light(&w, 1, sl_v3(0, 0, 0), up));
    light_world_free(&w);
}

static void a_swarm_of_lamps_is_one_light(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t lamp = lamp_material(&mesh, 1);
    for (int i = 0; i < 100; i++) add_panel(&mesh, (float)i, 2 + 0.01f * (float)i, 0, 0.5f, lamp);
    light_world w = light_world_make(&mesh);
    assert_int_equal(w.lights->count, 1);
    assert_int_equal(w.lights->light[0].kind, SL_SOURCE_SOLID);
    assert_int_equal(w.lights->light[0].triangles, 200);
    assert_true(sample_light(&w, 0, sl_v3(50, 0, 0), up) > 0.0);
    light_world_free(&w);
}

static void lights_without_extent_follow_in_the_scenes_order(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    mesh.lights[0] = (sl_light){SL_LIGHT_SPOT, {0, 2, 0}, {0, -1, 0}, {1, 1, 1}, 0.9f, 0.8f};
    mesh.lights[1] = (sl_light){SL_LIGHT_POINT, {0, 2, 0}, {0, 0, 0}, {3, 2, 1}, 0, 0};
    mesh.light_count = 2;
    add_panel(&mesh, 0, 2, 0, 1, lamp_material(&mesh, 1));
    light_world w = light_world_make(&mesh);
    assert_int_equal(w.lights->count, 3);
    assert_int_equal(w.lights->light[0].kind, SL_SOURCE_AREA);
    assert_int_equal(w.lights->light[1].kind, SL_SOURCE_SPOT);
    assert_int_equal(w.lights->light[2].kind, SL_SOURCE_POINT);
    light_world_free(&w);
}

/* F times the colour, summed over all lights, is the irradiance: panel by panel against the closed form. */
static void lights_add_up_to_the_irradiance(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    for (int i = 0; i < 6; i++)
        add_panel(&mesh, (float)i - 3, 2, (float)(i % 2), 0.8f, lamp_material(&mesh, 1.0f + (float)i));
    light_world w = light_world_make(&mesh);
    assert_int_equal(w.lights->count, 6);
    double sum = 0.0, expected = 0.0;
    for (size_t i = 0; i < 6; i++)
        sum += sample_light(&w, i, sl_v3(0, 0, 0), up) * (double)w.lights->light[i].colour.g;
    for (int i = 0; i < 6; i++) {
        double x = (double)i - 3, z = (double)(i % 2);
        expected += rectangle_form(x, x + 0.8, z, z + 0.8, 2) * 3.14159265358979 * (1.0 + (double)i);
    }
    assert_share(sum, expected, 1e-6);
    light_world_free(&w);
}

/* A room that shines inwards is six lights and a block that shines outwards one. */
static void a_hollow_of_few_planes_is_as_many_lights(void **state) {
    for (int inside = 0; inside < 2; inside++) {
        trace_mesh mesh = trace_mesh_begin();
        uint32_t lamp = trace_mesh_lamp(&mesh, 1);
        trace_mesh_box(&mesh, sl_v3(-1, 0, -2), sl_v3(1.5f, 3, 2), inside == 1, lamp);
        sl_scene *scene = trace_mesh_build(&mesh);
        sl_sampled_lights *lights;
        assert_int_equal(sl_sampled_lights_find(scene, &lights, NULL), SL_OK);
        assert_int_equal(lights->count, inside ? 6 : 1);
        for (size_t i = 0; i < lights->count; i++) {
            assert_int_equal(lights->light[i].kind, inside ? SL_SOURCE_AREA : SL_SOURCE_SOLID);
            assert_int_equal(lights->light[i].triangles, inside ? 2 : 12);
        }
        sl_sampled_lights_destroy(lights);
        sl_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_hollow_of_few_planes_is_as_many_lights),
        cmocka_unit_test(coplanar_triangles_of_one_radiance_are_one_light),
        cmocka_unit_test(bulbs_apart_are_lights_of_their_own),
        cmocka_unit_test(a_swarm_of_lamps_is_one_light),
        cmocka_unit_test(lights_without_extent_follow_in_the_scenes_order),
        cmocka_unit_test(lights_add_up_to_the_irradiance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
