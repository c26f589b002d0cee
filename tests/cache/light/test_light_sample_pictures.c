/* The pictures behind a sample: how their error falls with their size, and how they are summed. */
#include <stdio.h>
#include <stdlib.h>

#include "light_sample_support.h"

#include "base/math.h"
#include "base/random.h"
#include "cache/light/sample_kernels.h"

static const sl_vec3 up = {0, 1, 0};

static double sample_with(light_world *w, sl_light_estimator estimator, int size, sl_vec3 p) {
    sl_light_sample_settings s = sl_light_sample_defaults();
    s.estimator = estimator;
    s.size = s.largest = size;
    light_world_set(w, &s);
    return sample_light(w, 0, p, up);
}

/* ---- size and error ---- */

static void the_error_of_a_raw_frustum_falls_with_its_size(void **unused) {
    enum { POINTS = 40 };
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, -0.5f, -0.5f, 1.0f, 1.0f, 1.0f);
    light_world w = light_world_make(&mesh);
    double before = 0.0;
    for (int size = 16; size <= 256; size *= 4) {
        double error = 0.0;
        for (int i = 0; i < POINTS; i++) {
            const sl_vec3 p = {0.02f * (float)i, 0.0f, 0.1f};
            double x = (double)p.x, exact = rectangle_form(-0.5 - x, 0.5 - x, -0.6, 0.4, 1.0);
            error += fabs(sample_with(&w, SL_LIGHT_LOOK_AT, size, p) - exact) / exact / POINTS;
        }
        if (size > 16 && !(error < before / 5.0)) fail_msg("%d: %g after %g", size, error, before);
        before = error;
    }
    assert_true(before < 3e-4);
    light_world_free(&w);
}

/* With half of a light hidden by an edge that runs along its own sides, at all its places: the worst is what
 * bands on a floor would show. */
static void a_turned_raster_does_not_band_along_edges(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, -0.5f, -0.5f, 1.0f, 1.0f, 2.0f);
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(0, 1, -20), sl_v3(20, 0, 0), sl_v3(0, 0, 40), grey);
    light_world w = light_world_make(&mesh);
    double open = rectangle_form(-0.5, 0.5, -0.5, 0.5, 2.0), worst = 0.0;
    for (int i = 0; i < 300; i++) {
        double p = -0.2 + 0.4 * (double)i / 300.0, edge = -(double)(float)p;
        double expected = rectangle_form(-0.5 - (double)(float)p, edge - (double)(float)p, -0.5, 0.5, 2.0);
        worst = fmax(worst, fabs(sample_light(&w, 0, sl_v3((float)p, 0, 0), up) - expected) / open);
    }
    assert_true(worst < 0.0026); /* a raster along the edge: 1 / (2 x 64) = 0.0078 */
    light_world_free(&w);
}

/* All estimators see the same light. */
static void estimators_agree_on_a_light_partly_hidden_by_a_ball(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, -0.5f, -0.5f, 1.0f, 1.0f, 2.0f);
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_sphere(&mesh, sl_v3(0.1f, 1, 0), 0.15f, 16, 0.0f, false, grey);
    light_world w = light_world_make(&mesh);
    const sl_vec3 p = {0.05f, 0, 0.02f};
    sl_light_sample_settings s = sl_light_sample_defaults();
    s.estimator = SL_LIGHT_RAYS;
    s.rays = 256;
    light_world_set(&w, &s);
    double truth = sample_light(&w, 0, p, up), open = rectangle_form(-0.55, 0.45, -0.52, 0.48, 2.0);
    assert_true(truth > 0.3 * open && truth < 0.95 * open);
    assert_near(sample_with(&w, SL_LIGHT_RATIO, 64, p), truth, 0.003 * open);
    assert_near(sample_with(&w, SL_LIGHT_LOOK_AT, 64, p), truth, 0.01 * open);
    assert_near(sample_with(&w, SL_LIGHT_RATIO, 512, p), truth, 0.0004 * open);
    light_world_free(&w);
}

/* ---- sums ---- */

static void the_reduction_to_16_by_16_is_the_double_sum(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    add_ceiling_light(&mesh, -0.5f, -0.5f, 1.0f, 1.0f, 1.0f);
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_sphere(&mesh, sl_v3(0.1f, 0.6f, 0), 0.15f, 8, 0.0f, false, grey);
    light_world w = light_world_make(&mesh);
    for (int size = 16; size <= 256; size *= 2) {
        double f = sample_with(&w, SL_LIGHT_LOOK_AT, size, sl_v3(0.2f, 0, 0.1f)), sum = 0.0;
        sl_light_picture picture = sl_light_last_picture(w.scratch);
        assert_int_equal(picture.size, size);
        for (int i = 0; i < size * size; i++) sum += (double)picture.weight[i];
        assert_share(f, sum, 2e-7);
    }
    light_world_free(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_error_of_a_raw_frustum_falls_with_its_size),
        cmocka_unit_test(a_turned_raster_does_not_band_along_edges),
        cmocka_unit_test(estimators_agree_on_a_light_partly_hidden_by_a_ball),
        cmocka_unit_test(the_reduction_to_16_by_16_is_the_double_sum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
