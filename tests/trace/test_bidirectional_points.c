/* Irradiance and radiance at surface points by bidirectional path tracing, where they are known in closed
 * form, and against the path tracer elsewhere. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/parallel.h"
#include "rendering.h"
#include "trace/bidirectional/bidirectional.h"
#include "trace_scenes.h"

typedef struct world {
    sl_scene *scene;
    sl_tracer *tracer;
    sl_bidirectional_points *points;
    sl_bidirectional_scratch *scratch;
    sl_counters counters;
} world;

static world open_world(sl_scene *scene, const sl_bidirectional_point_settings *settings) {
    world w = {.scene = scene};
    w.tracer = tracer_of(scene);
    assert_int_equal(sl_bidirectional_points_create(scene, w.tracer, settings, &w.points, NULL), SL_OK);
    assert_int_equal(sl_bidirectional_scratch_create(&w.scratch, NULL), SL_OK);
    return w;
}

static void close_world(world *w) {
    assert_int_equal(w->counters.value[SL_COUNT_NONFINITE], 0);
    sl_bidirectional_scratch_destroy(w->scratch);
    sl_bidirectional_points_destroy(w->points);
    sl_tracer_destroy(w->tracer);
    sl_scene_destroy(w->scene);
}

/* The point of a triangle with these barycentric weights, on its front or its back. */
static sl_bidirectional_request point_of(const sl_scene *scene, uint32_t triangle, float w1, float w2,
                                         bool front) {
    sl_surface s;
    sl_scene_surface(scene, triangle, w1, w2,
                     sl_scale(sl_scene_geometric_normal(scene, triangle), front ? 1.0f : -1.0f), &s);
    return (sl_bidirectional_request){s.position, s.geometric_normal, s.normal, triangle, NULL, 0};
}

static sl_bidirectional_value irradiance(world *w, const sl_bidirectional_request *request) {
    sl_bidirectional_value value;
    sl_bidirectional_irradiance(w->points, request, w->scratch, &value, &w->counters);
    return value;
}

static void check(const char *what, const sl_bidirectional_value *v, double expected, double model) {
    for (int c = 0; c < 3; c++) {
        double error = sqrt(v->variance[c]);
        if (!(error <= 0.05 * fabs(expected) + 1e-12))
            fail_msg("%s: %g +- %g is too noisy for a test", what, v->mean[c], error);
        if (!(fabs(v->mean[c] - expected) <= 3.0 * error + (model + 1e-4) * fabs(expected) + 1e-12)) {
            fail_msg("%s: %.6g +- %.2g, expected %.6g", what, v->mean[c], error, expected);
        }
    }
}

/* ---- closed forms ---------------------------------------------------------------------------- */

/* Emission L and albedo rho everywhere: direct light pi L, after k bounces at most pi L (rho + ... + rho^k)
 * more. */
static void furnace_irradiance_is_the_geometric_series(void **unused) {
    const double albedo = 0.6, radiance = 2.0;
    static const uint32_t bounces[] = {1, 2, 6, SL_BOUNCES_UNLIMITED};
    for (int i = 0; i < 4; i++) {
        trace_mesh mesh = trace_mesh_begin();
        uint32_t wall = trace_mesh_material(&mesh, (float)albedo, 0, 0, 0, (float)radiance);
        trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, wall);
        const sl_bidirectional_point_settings settings = {.samples = 2000, .bounces = bounces[i]};
        world w = open_world(trace_mesh_build(&mesh), &settings);
        double sum = albedo / (1.0 - albedo);
        if (bounces[i] != SL_BOUNCES_UNLIMITED) sum *= 1.0 - sl_pow(albedo, (double)bounces[i]);
        for (uint32_t t = 0; t < w.scene->triangle_count; t += 5) {
            sl_bidirectional_request request = point_of(w.scene, t, 0.2f, 0.3f, true);
            sl_bidirectional_value v = irradiance(&w, &request);
            check("furnace", &v, SL_PI * radiance * sum, 0.0);
        }
        close_world(&w);
    }
}

static world box_world(uint32_t samples) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t wall = trace_mesh_diffuse(&mesh, 0.5f), lamp = trace_mesh_material(&mesh, 0.5f, 0, 0, 0, 3.0f);
    trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, wall);
    trace_mesh_quad(&mesh, sl_v3(-0.5f, -0.5f, 0.9f), sl_v3(0, 1, 0), sl_v3(1, 0, 0), lamp);
    return open_world(trace_mesh_build(&mesh), &(sl_bidirectional_point_settings){.samples = samples});
}

static void the_first_samples_alone_give_what_as_few_points_samples_give(void **unused) {
    world all = box_world(64), few = box_world(24);
    sl_bidirectional_request request = point_of(all.scene, 3, 0.2f, 0.3f, true);
    sl_bidirectional_value of_few = irradiance(&few, &request), of_all = irradiance(&all, &request);
    request.samples = 24;
    sl_bidirectional_value first = irradiance(&all, &request);
    assert_memory_equal(&first, &of_few, sizeof first);
    assert_true(memcmp(&first, &of_all, sizeof first) != 0);
    close_world(&all);
    close_world(&few);
}

/* ---- against the path tracer ----------------------------------------------------------------- */

/* The path tracer looks at the point along its normal; what leaves a diffuse surface without its direct light
 * is kd E / pi. */
static void compare_with_path_tracer(world *w, const sl_bidirectional_request *request, sl_vec3 eye,
                                     unsigned lobe, uint32_t bounces, const sl_bidirectional_value *v,
                                     double factor) {
    sl_transport transport;
    assert_true(sl_transport_named("full", &transport));
    transport.bounces = bounces;
    transport.receiver_lobes = lobe;
    transport.direct_lobes = 0;
    transport.emission = false;
    traced_radiance traced =
        trace_along(w->scene, w->tracer, &transport, eye, sl_sub(request->position, eye), 1500);
    for (int c = 0; c < 3; c++) {
        double mean = traced.mean[c], error = sqrt(traced.variance[c] + factor * factor * v->variance[c]);
        if (!(error < 0.1 * mean))
            fail_msg("triangle %u, lobe %u: %g +- %g is too noisy for a test (%g +- %g)", request->triangle,
                     lobe, mean, error, factor * v->mean[c], factor * sqrt(v->variance[c]));
        if (!(fabs(factor * v->mean[c] - mean) < 4.0 * error)) {
            fail_msg("channel %d: %g, the path tracer has %g +- %g", c, factor * v->mean[c], mean, error);
        }
    }
}

/* A ball with normals that lean off their facets, a glossy floor, a mirror; lamps, a point light and a sky.
 */
static sl_scene *rich_scene(int lights) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t white = trace_mesh_diffuse(&mesh, 0.7f),
             glossy = trace_mesh_material(&mesh, 0.25f, 0.5f, 15, 0, 0);
    uint32_t mirror = trace_mesh_material(&mesh, 0, 0, 0, 0.9f, 0), lamp = trace_mesh_lamp(&mesh, 9.0f);
    mesh.materials[white].diffuse = (sl_rgb){0.8f, 0.6f, 0.4f};
    trace_mesh_quad(&mesh, sl_v3(-3, -1, -3), sl_v3(0, 0, 6), sl_v3(6, 0, 0), glossy);
    trace_mesh_quad(&mesh, sl_v3(-3, -1, -3), sl_v3(6, 0, 0), sl_v3(0, 4, 0), white);
    trace_mesh_quad(&mesh, sl_v3(-3, -1, -3), sl_v3(0, 4, 0), sl_v3(0, 0, 6), mirror);
    trace_mesh_quad(&mesh, sl_v3(3, -1, 3), sl_v3(0, 4, 0), sl_v3(0, 0, -6), white);
    trace_mesh_sphere(&mesh, sl_v3(0.6f, -0.2f, 0), 0.7f, 8, 0.2f, false, white);
    if (lights == 0) trace_mesh_quad(&mesh, sl_v3(-2.0f, 2.5f, -2.0f), sl_v3(4, 0, 0), sl_v3(0, 0, 4), lamp);
    if (lights == 1) {
        mesh.lights[mesh.light_count++] = (sl_light){
            .type = SL_LIGHT_DIRECTIONAL, .direction = {0.48f, -0.6f, -0.64f}, .intensity = {3, 3, 2}};
        /* The path tracer finds no caustic of such a light: no mirrors here. */
        mesh.materials[mirror].mirror = sl_grey(0.0f);
        mesh.materials[mirror].diffuse = sl_grey(0.4f);
    }
    sl_environment sky = {.present = true, .constant = {0.5f, 0.7f, 1.0f}};
    if (lights == 2) mesh.environment = &sky;
    return trace_mesh_build(&mesh);
}

static void points_have_the_path_tracers_values(void **unused) {
    for (int lights = 0; lights < 3; lights++) {
        const sl_bidirectional_point_settings settings = {.samples = 3000, .bounces = 4};
        world w = open_world(rich_scene(lights), &settings);
        static const uint32_t triangles[] = {0, 2, 6};
        for (int i = 0; i < 3; i++) {
            sl_bidirectional_request request = point_of(w.scene, triangles[i], 0.3f, 0.45f, true);
            sl_bidirectional_value v = irradiance(&w, &request);
            const sl_material *material = &w.scene->materials[w.scene->material_index[triangles[i]]];
            sl_bidirectional_value scaled = v;
            const float kd[3] = {material->diffuse.r, material->diffuse.g, material->diffuse.b};
            for (int c = 0; c < 3; c++) {
                scaled.mean[c] *= (double)kd[c];
                scaled.variance[c] *= (double)(kd[c] * kd[c]);
            }
            sl_vec3 eye = sl_mad(request.position, 0.2f, request.geometric_normal);
            compare_with_path_tracer(&w, &request, eye, SL_LOBE_DIFFUSE, 4, &scaled, 1.0 / SL_PI);
        }
        sl_bidirectional_request request = point_of(w.scene, 0, 0.3f, 0.45f, true);
        sl_bidirectional_value v;
        sl_vec3 eye = sl_add(request.position, sl_v3(0.2f, 0.3f, 0.25f));
        sl_bidirectional_radiance(w.points, &request, eye, w.scratch, &v, &w.counters);
        compare_with_path_tracer(&w, &request, eye, SL_LOBE_GLOSSY, 4, &v, 1.0);
        close_world(&w);
    }
}

/* ---- bits ------------------------------------------------------------------------------------ */

typedef struct many {
    world *w;
    sl_bidirectional_scratch *scratch[3];
    sl_bidirectional_value values[12];
} many;

static void one_of_many(void *context, size_t index, unsigned worker) {
    many *m = context;
    sl_counters counters = {{0}};
    sl_bidirectional_request request = point_of(m->w->scene, (uint32_t)index, 0.25f, 0.25f, true);
    sl_bidirectional_irradiance(m->w->points, &request, m->scratch[worker], &m->values[index], &counters);
}

static void values_are_the_same_bits_at_any_time_and_with_any_threads(void **unused) {
    sl_bidirectional_value expected[12];
    for (unsigned threads = 1; threads <= 3; threads++) {
        world w = open_world(rich_scene(0), NULL);
        many m = {.w = &w};
        for (int i = 0; i < 3; i++)
            assert_int_equal(sl_bidirectional_scratch_create(&m.scratch[i], NULL), SL_OK);
        for (int again = 0; again < 2; again++) {
            sl_parallel_for(threads, 12, one_of_many, &m);
            if (threads == 1 && again == 0) memcpy(expected, m.values, sizeof expected);
            assert_memory_equal(m.values, expected, sizeof expected);
        }
        for (int i = 0; i < 3; i++) sl_bidirectional_scratch_destroy(m.scratch[i]);
        close_world(&w);
    }
}

/* Nothing shines; the point touches the lamp; the lamp lies in the wall; scenes of any size, with normals at
 * right angles to sense. */
static void degenerate_points_have_finite_values(void **unused) {
    static const float sizes[] = {1e-12f, 1.0f, 1e12f};
    for (int i = 0; i < 3; i++) {
        for (int lit = 0; lit < 2; lit++) {
            float a = sizes[i];
            trace_mesh mesh = trace_mesh_begin();
            uint32_t wall = trace_mesh_material(&mesh, 0.5f, 0.3f, 1000, 0, 0),
                     lamp = trace_mesh_material(&mesh, 0.5f, 0, 0, 0, (float)lit);
            trace_mesh_box(&mesh, sl_v3(-a, -a, -a), sl_v3(a, a, a), true, wall);
            trace_mesh_quad(&mesh, sl_v3(-a, -a, a), sl_v3(0, a, 0), sl_v3(a, 0, 0), lamp);
            world w = open_world(trace_mesh_build(&mesh), NULL);
            for (uint32_t t = 0; t < w.scene->triangle_count; t++) {
                static const float weights[][2] = {{0, 0}, {1, 0}, {0.5f, 0.5f}, {0.3f, 0.2f}};
                for (int k = 0; k < 4; k++) {
                    sl_bidirectional_request request =
                        point_of(w.scene, t, weights[k][0], weights[k][1], true);
                    sl_bidirectional_value v = irradiance(&w, &request), lobe;
                    sl_bidirectional_radiance(w.points, &request, request.position, w.scratch, &lobe,
                                              &w.counters);
                    for (int c = 0; c < 3; c++) {
                        assert_true(isfinite(v.mean[c]) && v.mean[c] >= 0.0 && isfinite(v.variance[c]) &&
                                    v.variance[c] >= 0.0);
                        assert_true(isfinite(lobe.mean[c]) && lobe.mean[c] >= 0.0 &&
                                    isfinite(lobe.variance[c]));
                        if (!lit) assert_true(v.mean[c] == 0.0);
                        if (lit && k == 3 && t < 12) assert_true(v.mean[c] > 0.0 && v.mean[c] < 4.0);
                    }
                }
            }
            close_world(&w);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_samples_alone_give_what_as_few_points_samples_give),
        cmocka_unit_test(furnace_irradiance_is_the_geometric_series),
        cmocka_unit_test(points_have_the_path_tracers_values),
        cmocka_unit_test(values_are_the_same_bits_at_any_time_and_with_any_threads),
        cmocka_unit_test(degenerate_points_have_finite_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
