/* Irradiance from one light against closed forms: without occluders, and behind straight edges. */
#include "light_sample_support.h"

#include "base/math.h"
#include "cache/light/light_sample_internal.h"

static const sl_vec3 up = {0, 1, 0};

/* ---- nothing in between ---- */

static void a_parallel_rectangle_gives_its_closed_form(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, 0.0f, 0.0f, 3.0f, 0.5f, 2.0f);
    light_world w = light_world_make(&mesh);
    assert_int_equal(w.lights->count, 1);
    assert_int_equal(w.lights->light[0].kind, SL_SOURCE_AREA);
    assert_share(sample_light(&w, 0, sl_v3(0, 0, 0), up), corner_form(1.5, 0.25), 1e-6);
    assert_share(sample_light(&w, 0, sl_v3(1, 0.5f, -2), up), rectangle_form(-1, 2, 2, 2.5, 1.5), 1e-6);
    light_world_free(&w);
}

/* The wall's lower half is below the receiver's horizon; so is half of every pixel column. */
static void a_wall_half_below_the_horizon_counts_with_its_upper_half(void **unused) {
    const double a = 1.5, b = 2.0, c = 1.0;
    trace_mesh mesh = trace_mesh_begin();
    uint32_t lamp = trace_mesh_lamp(&mesh, 1.0f);
    trace_mesh_quad(&mesh, sl_v3(0, -2, (float)c), sl_v3(0, 2 + (float)b, 0), sl_v3((float)a, 0, 0), lamp);
    light_world w = light_world_make(&mesh);
    double r = sqrt(b * b + c * c), expected = (sl_atan(a / c) - c / r * sl_atan(a / r)) / (2.0 * SL_PI);
    assert_share(sample_light(&w, 0, sl_v3(0, 0, 0), up), expected, 1e-6);
    sl_lit_point p = lit_point(sl_v3(0, 0, 0), up);
    assert_true(sl_light_direction(&w.lights->light[0], &p).y > 0.3f);
    light_world_free(&w);
}

/* (R/d)^2 cos theta, for a ball wholly above the horizon; a fine polyhedron inside it. */
static void a_ball_gives_its_closed_form(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t lamp = trace_mesh_lamp(&mesh, 1.0f);
    trace_mesh_sphere(&mesh, sl_v3(0, 2, 0), 0.5f, 24, 0.0f, false, lamp);
    light_world w = light_world_make(&mesh);
    assert_int_equal(w.lights->count, 1);
    assert_int_equal(w.lights->light[0].kind, SL_SOURCE_SOLID);
    assert_share(sample_light(&w, 0, sl_v3(0, 0, 0), up), 1.0 / 16.0, 0.01);
    double d = sqrt(8.0);
    assert_share(sample_light(&w, 0, sl_v3(2, 0, 0), up), 0.25 / 8.0 * 2.0 / d, 0.01);
    light_world_free(&w);
}

/* ---- a straight edge ---- */

/* An occluder fills x > 0 at height b; a light x0..x1 wide at height H. From x = p the edge is seen over x =
 * p - p H / b of the light: the part on its left is the difference of rectangles. */
static double beside_an_edge(double p, double x0, double x1, double z0, double z1, double b, double height) {
    double edge = p + (0.0 - p) * height / b, right = fmin(fmax(edge, x0), x1);
    return rectangle_form(x0 - p, right - p, z0, z1, height);
}

static void the_penumbra_of_a_straight_edge_is_its_closed_form(void **unused) {
    static const struct {
        sl_light_estimator estimator;
        double tolerance;
    } cases[] = {
        {SL_LIGHT_RATIO, 0.004}, {SL_LIGHT_LOOK_AT, 0.02}, {SL_LIGHT_RAYS, 0.05}};
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, -0.5f, -0.5f, 1.0f, 1.0f, 2.0f);
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(0, 1, -20), sl_v3(20, 0, 0), sl_v3(0, 0, 40), grey);
    light_world w = light_world_make(&mesh);
    double open = rectangle_form(-0.5, 0.5, -0.5, 0.5, 2.0);
    for (size_t k = 0; k < 3; k++) {
        sl_light_sample_settings settings = sl_light_sample_defaults();
        settings.estimator = cases[k].estimator;
        light_world_set(&w, &settings);
        for (int i = 0; i <= 40; i++) { /* the penumbra is -0.5 .. 0.5 */
            double p = -1.0 + 0.05 * (double)i + 0.001;
            double expected = beside_an_edge((double)(float)p, -0.5, 0.5, -0.5, 0.5, 1.0, 2.0);
            assert_near(sample_light(&w, 0, sl_v3((float)p, 0, 0), up), expected, cases[k].tolerance * open);
        }
    }
    light_world_free(&w);
}

/* ---- lights without extent ---- */

static void point_lights_spots_and_the_sun_fall_off_and_cast_sharp_shadows(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(0, 1, -2), sl_v3(2, 0, 0), sl_v3(0, 0, 4), grey);
    mesh.lights[0] = (sl_light){SL_LIGHT_POINT, {0, 2, 0}, {0, 0, 0}, {3, 2, 1}, 0, 0};
    mesh.lights[1] = (sl_light){SL_LIGHT_SPOT, {-1, 2, 0}, {0, -1, 0}, {1, 1, 1}, 0.9f, 0.8f};
    mesh.lights[2] = (sl_light){SL_LIGHT_DIRECTIONAL, {0, 0, 0}, {0, -1, 0}, {5, 5, 5}, 0, 0};
    mesh.light_count = 3;
    light_world w = light_world_make(&mesh);
    assert_int_equal(w.lights->count, 3);
    assert_true(w.lights->light[0].colour.r == 3.0f && w.lights->light[2].kind == SL_SOURCE_DIRECTIONAL);
    double r2 = 0.01 + 4.0;
    assert_share(sample_light(&w, 0, sl_v3(-0.1f, 0, 0), up), 2.0 / (r2 * sqrt(r2)), 1e-6);
    assert_true(sample_light(&w, 0, sl_v3(0.1f, 0, 0), up) == 0.0);
    assert_true(sample_light(&w, 0, sl_v3(0, 3, 0), up) == 0.0);
    assert_true(sample_light(&w, 0, sl_v3(0, 2, 0), up) == 0.0); /* at the light itself */
    assert_share(sample_light(&w, 1, sl_v3(-1, 0, 0), up), 0.25, 1e-6);
    assert_true(sample_light(&w, 1, sl_v3(-3, 0, 0), up) == 0.0);
    assert_share(sample_light(&w, 2, sl_v3(-0.5f, 0, 0), sl_v3(0, 1, 1)), sqrt(0.5), 1e-6);
    assert_true(sample_light(&w, 2, sl_v3(0.5f, 0, 0), up) == 0.0);
    light_world_free(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_parallel_rectangle_gives_its_closed_form),
        cmocka_unit_test(a_wall_half_below_the_horizon_counts_with_its_upper_half),
        cmocka_unit_test(a_ball_gives_its_closed_form),
        cmocka_unit_test(the_penumbra_of_a_straight_edge_is_its_closed_form),
        cmocka_unit_test(point_lights_spots_and_the_sun_fall_off_and_cast_sharp_shadows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
