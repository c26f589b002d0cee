/* Direct Radiance Mapping's lights: what each gives, from which points, and the footprint of a picture's
 * part. */
#include "unit_test.h"
#include "base/math.h"
#include "cache/direct_radiance/map.h"
#include "cache/direct_radiance/lights.h"
#include "trace_scenes.h"

static sl_map_lights *find(const sl_scene *scene, int subdivision) {
    sl_map_lights *lights;
    sl_error error = {0};
    if (sl_map_lights_find(scene, subdivision, &lights, &error) != SL_OK) fail_msg("%s", error.message);
    return lights;
}

static bool close_to(double a, double b, double relative) {
    return fabs(a - b) <= relative * (fabs(a) + fabs(b)) * 0.5;
}

static sl_light light_at(sl_light_type type, float intensity) {
    return (sl_light){.type = type,
                      .position = {0.3f, 2.0f, -0.1f},
                      .direction = {0, -1, 0},
                      .intensity = sl_grey(intensity),
                      .cos_inner = 0.9f,
                      .cos_outer = 0.7f};
}

/* A floor, so that there is a scene. */
static trace_mesh floor_mesh(void) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_quad(&mesh, sl_v3(-2, 0, 2), sl_v3(4, 0, 0), sl_v3(0, 0, -4), trace_mesh_diffuse(&mesh, 0.7f));
    return mesh;
}

/* The panel [x0, x0 + 1] x [0, 1] at height y, shining down, of n x n quads. */
static void add_panel(trace_mesh *mesh, float x0, float y, int n, uint32_t material) {
    for (int i = 0; i < n * n; i++) {
        float side = 1.0f / (float)n, x = x0 + side * (float)(i % n), z = side * (float)(i / n);
        trace_mesh_quad(mesh, sl_v3(x, y, z), sl_v3(side, 0, 0), sl_v3(0, 0, side), material);
    }
}

/* ---- what lights give ---- */

/* The intensity's integral over the sphere, by the middles of 400 x 800 cells of equal solid angle. */
static double integral_over_sphere(const sl_map_light *light) {
    double sum = 0.0;
    for (int i = 0; i < 400; i++) {
        for (int k = 0; k < 800; k++) {
            double z = -1.0 + (i + 0.5) / 200.0, s = sqrt(1.0 - z * z), phi = 2.0 * SL_PI * (k + 0.5) / 800.0;
            sl_vec3 d = sl_v3((float)(s * sl_cos(phi)), (float)z, (float)(s * sl_sin(phi)));
            sum += (double)sl_map_light_intensity(light, d).g;
        }
    }
    return sum * 4.0 * SL_PI / (400.0 * 800.0);
}

static void every_kind_of_lights_intensity_adds_up_to_its_flux_over_the_sphere(void **state) {
    trace_mesh mesh = floor_mesh();
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, 3.0f);
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_SPOT, 5.0f);
    add_panel(&mesh, 0, 3, 1, trace_mesh_lamp(&mesh, 7.0f));
    uint32_t both = trace_mesh_lamp(&mesh, 2.0f);
    mesh.materials[both].emission_two_sided = true;
    add_panel(&mesh, -3, 3, 1, both);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights = find(scene, 1);
    assert_int_equal(lights->count, 4);
    const double flux[4] = {SL_PI * 7.0, 2.0 * SL_PI * 2.0, 4.0 * SL_PI * 3.0, 2.0 * SL_PI * 0.2 * 5.0};
    for (size_t i = 0; i < 4; i++) {
        assert_true(close_to((double)sl_map_light_flux(&lights->light[i]).g, flux[i], 1e-5));
        assert_true(close_to(integral_over_sphere(&lights->light[i]), flux[i], 1e-3));
    }
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

/* ---- points ---- */

static double flux_of(const sl_map_lights *lights) {
    double flux = 0.0;
    for (size_t i = 0; i < lights->count; i++) flux += (double)sl_map_light_flux(&lights->light[i]).g;
    return flux;
}

static void a_quad_is_n_x_n_points_that_share_its_intensity(void **state) {
    trace_mesh mesh = floor_mesh();
    add_panel(&mesh, 0, 3, 1, trace_mesh_lamp(&mesh, 2));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *one = find(scene, 1), *lights = find(scene, 4);
    assert_int_equal(one->count, 1);
    assert_true(one->light[0].source.position.x == 0.5f && one->light[0].source.position.z == 0.5f);
    assert_int_equal(lights->count, 16);
    for (size_t i = 0; i < 16; i++) {
        const sl_map_light *l = &lights->light[i];
        const float along[2] = {l->source.position.x, l->source.position.z};
        for (int a = 0; a < 2; a++)
            assert_true(fabsf(along[a] * 4.0f - 0.5f - floorf(along[a] * 4.0f)) < 1e-4f);
        assert_true(close_to(l->source.colour.g, 2.0 / 16.0, 1e-4) && close_to(l->area, 1.0 / 16.0, 1e-4));
        assert_true(l->source.direction.y == -1.0f && l->source.clearance[0] < 1e-5f);
    }
    sl_map_lights_destroy(one);
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

static void a_solid_lamp_shines_from_points_of_its_surface(void **state) {
    const sl_vec3 middle = sl_v3(0, 2, 0);
    trace_mesh mesh = floor_mesh();
    trace_mesh_sphere(&mesh, middle, 0.4f, 40, 0.0f, false, trace_mesh_lamp(&mesh, 2));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights = find(scene, 2);
    assert_int_equal(lights->count, 96);
    assert_true(close_to(flux_of(lights), SL_PI * 2.0 * 4.0 * SL_PI * 0.16, 0.02));
    sl_vec3 sum = {0, 0, 0};
    for (size_t i = 0; i < lights->count; i++) {
        const sl_map_light *l = &lights->light[i];
        const sl_vec3 out = sl_sub(l->source.position, middle);
        assert_true(fabsf(sl_length(out) - 0.4f) < 0.01f && sl_dot(out, l->source.direction) > 0.38f);
        assert_true(l->source.clearance[0] < 1e-5f * scene->diagonal);
        sum = sl_add(sum, l->source.direction);
    }
    assert_true(sl_length(sum) < 0.25f * (float)lights->count); /* all around */
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

static void of_too_many_lights_the_strongest_shine_for_all(void **state) {
    trace_mesh mesh = floor_mesh();
    uint32_t glowing = trace_mesh_lamp(&mesh, 1);
    for (int i = 0; i < 60; i++) /* bulbs, which have fewer points each */
        trace_mesh_box(&mesh, sl_v3((float)i, 1, 0), sl_v3((float)i + 0.5f, 1.5f, 0.5f), false, glowing);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_map_lights *lights = find(scene, 1);
    assert_int_equal(lights->count, 240);
    assert_true(close_to(flux_of(lights), SL_PI * 60.0 * 1.5, 1e-5));
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
    mesh = floor_mesh();
    for (int i = 0; i < 300; i++) { /* of one radiance 60 bulbs are 60 lamps */
        if (i % 60 == 0) glowing = trace_mesh_material(&mesh, 0, 0, 0, 0, (float)(5 - i / 60));
        trace_mesh_box(&mesh, sl_v3((float)i, 1, 0), sl_v3((float)i + 0.5f, 1.5f, 0.5f), false, glowing);
    }
    scene = trace_mesh_build(&mesh);
    lights = find(scene, 1);
    assert_int_equal(lights->count, SL_MAP_LIGHTS_MAX);
    assert_true(close_to(flux_of(lights), SL_PI * 1.5 * 60.0 * 15.0, 1e-4));
    for (size_t i = 0; i < 60; i++) /* of 900 all but 44 of radiance 1 are kept */
        assert_true(close_to((double)lights->light[i].source.colour.g, 1.5 * 5.0 * 900.0 / 856.0, 1e-4));
    sl_map_lights_destroy(lights);
    sl_scene_destroy(scene);
}

/* ---- footprint ---- */

static void solid_angles_of_a_picture_s_parts_add_up_to_the_picture_s(void **state) {
    static const double fovs[] = {0.01, 0.7, SL_PI / 2, 2.0, 3.1};
    for (size_t f = 0; f < sizeof fovs / sizeof *fovs; f++) {
        double t = sl_tan(0.5 * fovs[f]), s = sl_sin(0.5 * fovs[f]), sum = 0.0;
        const int m = 7;
        for (int i = 0; i < m * m; i++) {
            double x = -t + 2.0 * t * (i % m) / m, y = -t + 2.0 * t * (i / m) / m, d = 2.0 * t / m;
            double part = sl_rectangle_solid_angle(x, y, x + d, y + d);
            assert_true(part > 0.0);
            sum += part;
        }
        assert_true(close_to(sum, 4.0 * sl_asin(s * s), 1e-12));
    }
    assert_true(close_to(6.0 * sl_rectangle_solid_angle(-1, -1, 1, 1), 4.0 * SL_PI, 1e-14));
}

static void the_printed_footprint_exceeds_the_true_one_as_the_specification_found(void **state) {
    double printed = 16.0 * 16.0 * sl_printed_footprint(1.0, SL_PI / 2, 16),
           true_sum = sl_rectangle_solid_angle(-1, -1, 1, 1);
    double middle = sl_rectangle_solid_angle(0, 0, 0.125, 0.125),
           corner = sl_rectangle_solid_angle(0.875, 0.875, 1, 1);
    assert_true(close_to(printed / true_sum, 1.18, 0.01));
    assert_true(close_to(sl_printed_footprint(1.0, SL_PI / 2, 16) / middle, 0.63, 0.01));
    assert_true(close_to(sl_printed_footprint(1.0, SL_PI / 2, 16) / corner, 2.83, 0.01));
}

/* The true area on a plane at distance 1 tilted by 30 degrees, of the block straight ahead: planar distance
 * to the plane along (x, y, 1) is 1 / (1 + x tan 30), so the area is the integral of 1 / (cos 30 (1 + x tan
 * 30)^3). */
static void the_tilted_footprint_is_right_to_little_more_than_a_hundredth_at_30_degrees(void **state) {
    double cosine = sqrt(0.75), tangent = sqrt(1.0 / 3.0), side = 0.125, sum = 0.0;
    for (int i = 0; i < 1000; i++) {
        double x = -0.5 * side + side * (i + 0.5) / 1000.0, q = 1.0 + x * tangent;
        sum += side * side / 1000.0 / (cosine * q * q * q);
    }
    double exact = sl_rectangle_solid_angle(-0.5 * side, -0.5 * side, 0.5 * side, 0.5 * side);
    assert_true(close_to(sl_printed_tilted_footprint(exact, cosine), sum, 0.02));
    assert_true(sl_printed_tilted_footprint(1.0, -0.5) == 0.0);
    assert_true(isinf(sl_printed_tilted_footprint(1.0, 0.0)));
    assert_true(sl_printed_tilted_footprint(0.0, 0.0) == 0.0 &&
                sl_printed_tilted_footprint(1.0, (double)NAN) == 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_of_lights_intensity_adds_up_to_its_flux_over_the_sphere),
        cmocka_unit_test(a_quad_is_n_x_n_points_that_share_its_intensity),
        cmocka_unit_test(a_solid_lamp_shines_from_points_of_its_surface),
        cmocka_unit_test(of_too_many_lights_the_strongest_shine_for_all),
        cmocka_unit_test(solid_angles_of_a_picture_s_parts_add_up_to_the_picture_s),
        cmocka_unit_test(the_printed_footprint_exceeds_the_true_one_as_the_specification_found),
        cmocka_unit_test(the_tilted_footprint_is_right_to_little_more_than_a_hundredth_at_30_degrees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
