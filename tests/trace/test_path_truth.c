/* The path tracer where the answer is known in closed form. Every mean has to lie within four and a half of
 * its own standard errors, which have to be small. */
#include <stdlib.h>

#include "unit_test.h"
#include "base/math.h"
#include "trace/trace.h"
#include "trace_scenes.h"

typedef struct measurement {
    double mean, error;
} measurement;

static measurement measure(const sl_scene *scene, sl_transport transport, sl_vec3 origin, sl_vec3 direction,
                           unsigned samples) {
    sl_tracer *tracer = tracer_of(scene);
    traced_radiance traced = trace_along(scene, tracer, &transport, origin, direction, samples);
    sl_tracer_destroy(tracer);
    return (measurement){traced.mean[1], sqrt(traced.variance[1])};
}

/* model: what the scene's tessellation or the table's digits may be off by, relatively. */
static void check(measurement m, double expected, double model) {
    if (!(m.error <= 0.006 * fabs(expected) + 1e-12))
        fail_msg("%g +- %g is too noisy for a test", m.mean, m.error);
    double tolerance = 4.5 * m.error + (model + 2e-5) * fabs(expected);
    if (!(fabs(m.mean - expected) <= tolerance))
        fail_msg("%.6g +- %.2g, expected %.6g", m.mean, m.error, expected);
}

static void furnace_radiance_is_the_geometric_series(void **unused) {
    const double albedo = 0.6;
    trace_mesh mesh = trace_mesh_begin();
    uint32_t wall = trace_mesh_material(&mesh, (float)albedo, 0, 0, 0, 1.0f);
    trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, wall);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_vec3 eye = sl_v3(0.2f, 0.1f, -0.3f), direction = sl_v3(0.3f, -1.0f, 0.4f);
    check(measure(scene, transport_of("direct"), eye, direction, 500), 1.0 + albedo, 0);
    double series = 1.0 + albedo;
    for (unsigned bounces = 1; bounces <= 3; bounces++) {
        sl_transport transport = transport_of("one-bounce");
        transport.bounces = bounces;
        series = 1.0 + albedo * series;
        check(measure(scene, transport, eye, direction, 500), series, 0);
    }
    check(measure(scene, transport_of("full"), eye, direction, 1000), 1.0 / (1.0 - albedo), 0);
    sl_transport unseen = transport_of("full");
    unseen.emission = false;
    check(measure(scene, unseen, eye, direction, 1000), albedo / (1.0 - albedo), 0);
    sl_scene_destroy(scene);
}

static sl_scene *floor_under_light(sl_vec3 corner, sl_vec3 a, sl_vec3 b, float radiance) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t floor = trace_mesh_diffuse(&mesh, 0.8f), light = trace_mesh_lamp(&mesh, radiance);
    trace_mesh_quad(&mesh, sl_v3(-50, -50, 0), sl_v3(100, 0, 0), sl_v3(0, 100, 0), floor);
    trace_mesh_quad(&mesh, corner, a, b, light);
    return trace_mesh_build(&mesh);
}

static void direct_light_on_a_floor_is_the_polygon_formula(void **unused) {
    sl_scene *scene =
        floor_under_light(sl_v3(-0.7f, -0.4f, 1.3f), sl_v3(0, 1.3f, 0), sl_v3(1.8f, 0, 0), 5.0f);
    sl_vec3 eye = sl_v3(0.35f, 0.2f, 1.0f), down = sl_v3(0, 0, -1);
    check(measure(scene, transport_of("direct"), eye, down, 2000), 0.8 / SL_PI * 4.643140759564, 0);
    /* Nothing else is lit here, so more bounces add nothing. */
    check(measure(scene, transport_of("full"), eye, down, 2000), 0.8 / SL_PI * 4.643140759564, 0);
    sl_scene_destroy(scene);
    /* A vanishing light: E = L A / d^2. A light that fills the sky: E = pi L. */
    scene = floor_under_light(sl_v3(-5e-5f, -5e-5f, 2.0f), sl_v3(0, 1e-4f, 0), sl_v3(1e-4f, 0, 0), 1e8f);
    check(measure(scene, transport_of("direct"), sl_v3(0, 0, 1), down, 64), 0.8 / SL_PI * 1e8 * 1e-8 / 4.0,
          1e-4);
    sl_scene_destroy(scene);
    scene = floor_under_light(sl_v3(-1e4f, -1e4f, 2.0f), sl_v3(0, 2e4f, 0), sl_v3(2e4f, 0, 0), 3.0f);
    check(measure(scene, transport_of("direct"), sl_v3(0, 0, 1), down, 2000), 0.8 * 3.0, 1e-4);
    sl_scene_destroy(scene);
}

/* Under a sky of radiance 1 a surface shows its directional albedo. */
static void phong_lobe_has_its_directional_albedo(void **unused) {
    /* n = 20, in steps of 15 degrees */
    static const double albedo[] = {1.0000, 0.9659, 0.8660, 0.7071, 0.5005, 0.2712};
    trace_mesh mesh = trace_mesh_begin();
    uint32_t glossy = trace_mesh_material(&mesh, 0, 1.0f, 20.0f, 0, 0);
    sl_environment sky = {.present = true, .constant = {1, 1, 1}};
    mesh.environment = &sky;
    trace_mesh_quad(&mesh, sl_v3(-50, -50, 0), sl_v3(100, 0, 0), sl_v3(0, 100, 0), glossy);
    sl_scene *scene = trace_mesh_build(&mesh);
    for (int i = 0; i < 6; i++) {
        double angle = SL_PI / 12.0 * i;
        sl_vec3 direction = sl_v3((float)sl_sin(angle), 0, -(float)sl_cos(angle));
        sl_vec3 eye = sl_scale(direction, -3.0f);
        measurement m = measure(scene, transport_of("direct"), eye, direction, 2000);
        check(m, albedo[i], 5e-5 / albedo[i]);
        sl_transport diffuse_only = transport_of("direct");
        diffuse_only.direct_lobes = SL_LOBE_DIFFUSE;
        check(measure(scene, diffuse_only, eye, direction, 16), 0.0, 0);
    }
    sl_scene_destroy(scene);
}

static void mirrors_are_followed_where_the_transport_says(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t mirror = trace_mesh_material(&mesh, 0, 0, 0, 0.8f, 0), light = trace_mesh_lamp(&mesh, 5.0f);
    uint32_t floor = trace_mesh_diffuse(&mesh, 0.5f);
    /* A light that faces up, a mirror above it that faces down, a floor that only the mirror's image of the
     * light shines on. */
    trace_mesh_quad(&mesh, sl_v3(3, -0.5f, 1), sl_v3(1, 0, 0), sl_v3(0, 1, 0), light);
    trace_mesh_quad(&mesh, sl_v3(-20, -20, 2), sl_v3(0, 40, 0), sl_v3(40, 0, 0), mirror);
    trace_mesh_quad(&mesh, sl_v3(-20, -20, 0), sl_v3(40, 0, 0), sl_v3(0, 40, 0), floor);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_vec3 eye = sl_v3(0, 0, 0.5f), down = sl_v3(0, 0, -1);

    double irradiance = 0.0; /* of the image, at height 3: the sum over its area of cos cos' / r^2 */
    enum { FINE = 200 };
    for (int j = 0; j < FINE; j++) {
        for (int i = 0; i < FINE; i++) {
            double x = 3.0 + (i + 0.5) / FINE, y = -0.5 + (j + 0.5) / FINE, r2 = x * x + y * y + 9.0;
            irradiance += 5.0 * 0.8 * 9.0 / (r2 * r2) / (FINE * FINE);
        }
    }
    check(measure(scene, transport_of("direct"), eye, down, 16), 0.0, 0);
    check(measure(scene, transport_of("one-bounce"), eye, down, 64), 0.0, 0);
    sl_transport caustics = transport_of("direct");
    caustics.receiver_lobes = SL_LOBE_DIFFUSE;
    caustics.bounce_lobes = SL_LOBE_MIRROR;
    check(measure(scene, caustics, eye, down, 20000), 0.5 / SL_PI * irradiance, 0);
    /* The light seen in the mirror, and the mirror as a black surface. */
    sl_vec3 at_image = sl_v3(3.5f, 0.0f, 2.5f);
    check(measure(scene, transport_of("direct"), eye, at_image, 16), 0.8 * 5.0, 0);
    sl_transport blind = transport_of("direct");
    blind.eye_mirrors = false;
    check(measure(scene, blind, eye, at_image, 16), 0.0, 0);
    sl_scene_destroy(scene);
}

static void direct_light_without_visibility_passes_blockers(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t floor = trace_mesh_diffuse(&mesh, 0.8f), light = trace_mesh_lamp(&mesh, 5.0f);
    uint32_t black = trace_mesh_diffuse(&mesh, 0);
    trace_mesh_quad(&mesh, sl_v3(-50, -50, 0), sl_v3(100, 0, 0), sl_v3(0, 100, 0), floor);
    trace_mesh_quad(&mesh, sl_v3(-0.7f, -0.4f, 1.3f), sl_v3(0, 1.3f, 0), sl_v3(1.8f, 0, 0), light);
    trace_mesh_quad(&mesh, sl_v3(-0.1f, -0.2f, 0.6f), sl_v3(0.6f, 0, 0), sl_v3(0, 0.65f, 0), black);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_vec3 eye = sl_v3(0.35f, 0.2f, 0.3f), down = sl_v3(0, 0, -1);
    check(measure(scene, transport_of("direct"), eye, down, 4000), 0.8 / SL_PI * 1.48128, 1e-5);
    sl_transport through = transport_of("direct");
    through.direct_visibility = false;
    check(measure(scene, through, eye, down, 4000), 0.8 / SL_PI * 4.643140759564, 0);
    sl_scene_destroy(scene);
}

/* A floor that sees a lit ceiling, with or without a black screen between them. */
static sl_scene *floor_and_lit_ceiling(bool screen) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t white = trace_mesh_diffuse(&mesh, 0.8f), black = trace_mesh_diffuse(&mesh, 0);
    trace_mesh_quad(&mesh, sl_v3(-50, -50, 0), sl_v3(100, 0, 0), sl_v3(0, 100, 0), white);
    trace_mesh_quad(&mesh, sl_v3(-3, -3, 2), sl_v3(0, 6, 0), sl_v3(6, 0, 0), white);
    if (screen) trace_mesh_quad(&mesh, sl_v3(-50, -50, 1), sl_v3(100, 0, 0), sl_v3(0, 100, 0), black);
    trace_mesh_point_light(&mesh, sl_v3(0.2f, 0, 1.2f), sl_grey(5));
    return trace_mesh_build(&mesh);
}

static void gathering_without_visibility_sees_through_surfaces(void **unused) {
    sl_scene *open = floor_and_lit_ceiling(false), *screened = floor_and_lit_ceiling(true);
    sl_vec3 eye = sl_v3(0.3f, 0.1f, 0.5f), down = sl_v3(0, 0, -1);
    sl_transport indirect = transport_of("one-bounce"), through;
    indirect.direct_lobes = 0;
    through = indirect;
    through.bounce_visibility = false;
    measurement seen = measure(open, indirect, eye, down, 8000);
    assert_true(seen.mean > 0.01);
    check(measure(screened, indirect, eye, down, 64), 0.0, 0);
    check(measure(screened, through, eye, down, 8000), seen.mean, 4.0 * seen.error / seen.mean);
    check(measure(open, through, eye, down, 8000), seen.mean, 4.0 * seen.error / seen.mean);
    sl_scene_destroy(open);
    sl_scene_destroy(screened);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(furnace_radiance_is_the_geometric_series),
        cmocka_unit_test(direct_light_on_a_floor_is_the_polygon_formula),
        cmocka_unit_test(phong_lobe_has_its_directional_albedo),
        cmocka_unit_test(mirrors_are_followed_where_the_transport_says),
        cmocka_unit_test(direct_light_without_visibility_passes_blockers),
        cmocka_unit_test(gathering_without_visibility_sees_through_surfaces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
