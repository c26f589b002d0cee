#include "light_sample_support.h"

#include "base/math.h"

static void free_sampling(light_world *w) {
    sl_light_sample_scratch_destroy(w->scratch);
    sl_light_sampling_destroy(w->sampling);
}

void light_world_set(light_world *w, const sl_light_sample_settings *settings) {
    free_sampling(w);
    w->settings = *settings;
    w->sampling = NULL;
    w->scratch = NULL;
    sl_error error = {0};
    sl_status status = sl_light_sampling_create(w->scene, w->raster, w->tracer, w->lights, &w->settings,
                                                &w->sampling, &error);
    if (status != SL_OK) fail_msg("%s", error.message);
    assert_int_equal(sl_light_sample_scratch_create(w->sampling, &w->scratch, &error), SL_OK);
}

light_world light_world_make(trace_mesh *mesh) {
    light_world w = {.scene = trace_mesh_build(mesh)};
    sl_error error = {0};
    assert_int_equal(sl_raster_create(w.scene, 1, &w.raster, &error), SL_OK);
    w.tracer = tracer_of(w.scene);
    assert_int_equal(sl_sampled_lights_find(w.scene, &w.lights, &error), SL_OK);
    const sl_light_sample_settings settings = sl_light_sample_defaults();
    light_world_set(&w, &settings);
    return w;
}

void light_world_free(light_world *w) {
    free_sampling(w);
    sl_sampled_lights_destroy(w->lights);
    sl_tracer_destroy(w->tracer);
    sl_raster_destroy(w->raster);
    sl_scene_destroy(w->scene);
}

sl_lit_point lit_point(sl_vec3 position, sl_vec3 normal) {
    sl_vec3 n = sl_normalize_or(normal, sl_v3(0, 1, 0));
    return (sl_lit_point){position, n, n, SL_NO_INDEX};
}

double sample_light(light_world *w, size_t light, sl_vec3 position, sl_vec3 normal) {
    sl_lit_point p = lit_point(position, normal);
    float f = sl_light_sample_take(w->sampling, light, &p, w->scratch, &w->counters);
    assert_true(f >= 0.0f && isfinite(f));
    return (double)f;
}

void add_ceiling_light(trace_mesh *mesh, float x, float z, float width, float depth, float height) {
    uint32_t lamp = trace_mesh_lamp(mesh, 1.0f);
    trace_mesh_quad(mesh, sl_v3(x, height, z), sl_v3(width, 0, 0), sl_v3(0, 0, depth), lamp);
}

void assert_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.9g, expected %.9g within %.3g", value, expected, tolerance);
}

double corner_form(double x, double y) {
    double rx = sqrt(1.0 + x * x), ry = sqrt(1.0 + y * y);
    return (x / rx * sl_atan(y / rx) + y / ry * sl_atan(x / ry)) / (2.0 * SL_PI);
}

double rectangle_form(double x0, double x1, double y0, double y1, double h) {
    return corner_form(x1 / h, y1 / h) - corner_form(x0 / h, y1 / h) - corner_form(x1 / h, y0 / h) +
           corner_form(x0 / h, y0 / h);
}
