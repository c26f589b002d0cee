/* The light sampler: unbiased against closed forms, and its pdf is the one it samples with. The points it is
 * given. */
#include <stdlib.h>

#include "unit_test.h"
#include "base/math.h"
#include "trace/sequence.h"
#include "trace_scenes.h"
#include "trace/trace.h"

enum { SAMPLES = 1 << 16 };

static sl_light_sampler *make_sampler(const sl_scene *scene) {
    sl_light_sampler *sampler;
    assert_int_equal(sl_light_sampler_create(scene, &sampler, NULL), SL_OK);
    return sampler;
}

typedef enum draw { DRAW_THREE, DRAW_TWO, DRAW_BY_PLACE, DRAWS } draw;

/* Irradiance without occlusion, by the kinds of samples that a caller may draw. */
static double irradiance(const sl_light_sampler *sampler, sl_vec3 p, sl_vec3 normal, draw kind) {
    static sl_sequence sequence;
    sl_sequence_make(&sequence);
    double sum = 0.0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        float u[3];
        sl_light_sample s;
        sl_sequence_point(&sequence, 42, 7, i, u);
        bool lit = kind == DRAW_TWO ? sl_light_sampler_sample_2d(sampler, p, u[0], u[1], &s)
                                    : sl_light_sampler_sample_at(sampler, p, normal, u[2], u[0], u[1], &s);
        if (!lit) continue;
        assert_true(isfinite(s.radiance.r) && s.radiance.r > 0.0f && s.distance > 0.0f && s.pdf >= 0.0f);
        assert_true(fabsf(sl_length(s.to_light) - 1.0f) < 1e-5f);
        if (s.pdf > 0.0f && kind != DRAW_BY_PLACE) {
            float pdf = sl_light_sampler_pdf(sampler, p, s.to_light, s.triangle, s.distance);
            if (s.triangle != SL_NO_INDEX) assert_true(fabsf(pdf / s.pdf - 1.0f) < 1e-4f);
        }
        sum += (double)(s.radiance.r * fmaxf(0.0f, sl_dot(normal, s.to_light)));
    }
    return sum / SAMPLES;
}

static void check_irradiance(const sl_scene *scene, sl_vec3 p, sl_vec3 normal, double expected,
                             double tolerance) {
    sl_light_sampler *sampler = make_sampler(scene);
    for (draw kind = DRAW_THREE; kind < DRAWS; kind++) {
        if (kind == DRAW_BY_PLACE) assert_int_equal(sl_light_sampler_plant_tree(sampler, NULL), SL_OK);
        double e = irradiance(sampler, p, normal, kind);
        if (!(fabs(e - expected) <= tolerance * fmax(expected, 1e-12)))
            fail_msg("E = %.9g, expected %.9g", e, expected);
    }
    sl_light_sampler_destroy(sampler);
}

/* Quads of radiance 5 whose irradiance is known from Lambert's polygon formula. */
static void irradiance_from_quads_is_that_of_the_polygon_formula(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t light = trace_mesh_lamp(&mesh, 5.0f);
    trace_mesh_quad(&mesh, sl_v3(-0.7f, -0.4f, 1.3f), sl_v3(0, 1.3f, 0), sl_v3(1.8f, 0, 0), light);
    sl_scene *scene = trace_mesh_build(&mesh);
    check_irradiance(scene, sl_v3(0.35f, 0.2f, 0), sl_v3(0, 0, 1), 4.643140759564, 2e-4);
    check_irradiance(scene, sl_v3(0.35f, 0.2f, 0), sl_v3(0, 0, -1), 0.0, 0.0); /* behind the receiver */
    check_irradiance(scene, sl_v3(0.35f, 0.2f, 2.0f), sl_v3(0, 0, -1), 0.0, 0.0); /* the light's dark side */
    sl_scene_destroy(scene);

    mesh = trace_mesh_begin();
    light = trace_mesh_lamp(&mesh, 5.0f);
    trace_mesh_quad(&mesh, sl_v3(1.2f, -0.5f, -0.6f), sl_v3(0, 0, 1.7f), sl_v3(0, 1.4f, 0), light);
    scene = trace_mesh_build(&mesh);
    /* half of it below the horizon */
    check_irradiance(scene, sl_v3(0.1f, 0.2f, 0), sl_v3(0, 0, 1), 1.338699193443, 1e-3);
    check_irradiance(scene, sl_v3(0.1f, 0.2f, 0), sl_v3(0.36f, 0.48f, 0.8f), 2.726858117647, 1e-3);
    sl_scene_destroy(scene);
}

/* Upper half 2, lower half 0, one texel of 500: the irradiance is summed over the texels by quadrature. */
static void a_sky_picture_is_sampled_without_bias(void **unused) {
    enum { W = 16, H = 8 };
    float texels[3 * W * H] = {0};
    for (int i = 0; i < 3 * W * H / 2; i++) texels[i] = 2.0f;
    for (int c = 0; c < 3; c++) texels[3 * (2 * W + 5) + c] = 500.0f;
    sl_environment sky = {.present = true, .width = W, .height = H, .texels = texels};
    trace_mesh mesh = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f);
    mesh.environment = &sky;
    trace_mesh_quad(&mesh, sl_v3(-1, 0, -1), sl_v3(2, 0, 0), sl_v3(0, 0, 2), grey);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_vec3 normals[2] = {{0, 1, 0}, {0.6f, 0.48f, -0.64f}};
    for (int n = 0; n < 2; n++) {
        double expected = 0.0;
        enum { FINE = 64 };
        for (int j = 0; j < H * FINE; j++) {
            double theta = SL_PI * (j + 0.5) / (H * FINE);
            for (int i = 0; i < W * FINE; i++) {
                double phi = 2.0 * SL_PI * ((i + 0.5) / (W * FINE) - 0.5);
                double x = sl_sin(theta) * sl_sin(phi), y = sl_cos(theta), z = -sl_sin(theta) * sl_cos(phi);
                double cosine =
                    x * (double)normals[n].x + y * (double)normals[n].y + z * (double)normals[n].z;
                double area = sl_sin(theta) * (SL_PI / (H * FINE)) * (2.0 * SL_PI / (W * FINE));
                if (cosine > 0.0) expected += (double)texels[3 * (j / FINE * W + i / FINE)] * cosine * area;
            }
        }
        check_irradiance(scene, sl_v3(0, 0, 0), normals[n], expected, 1e-3);
    }
    sl_scene_destroy(scene);
}

static void lights_without_extent_are_exact_and_mix_with_the_others(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t light = trace_mesh_lamp(&mesh, 5.0f);
    trace_mesh_quad(&mesh, sl_v3(-0.7f, -0.4f, 1.3f), sl_v3(0, 1.3f, 0), sl_v3(1.8f, 0, 0), light);
    mesh.lights[0] =
        (sl_light){.type = SL_LIGHT_POINT, .position = {0.35f, 0.2f, 2.0f}, .intensity = {8, 8, 8}};
    mesh.lights[1] = (sl_light){
        .type = SL_LIGHT_DIRECTIONAL, .direction = {0, -0.6f, -0.8f}, .intensity = {1.5f, 1.5f, 1.5f}};
    mesh.lights[2] = (sl_light){.type = SL_LIGHT_SPOT,
                                .position = {0.35f, 0.2f, 4.0f},
                                .direction = {0, 0, -1},
                                .intensity = {32, 32, 32},
                                .cos_inner = 0.9f,
                                .cos_outer = 0.8f};
    mesh.light_count = 3;
    sl_environment sky = {.present = true, .constant = {0.25f, 0.25f, 0.25f}};
    mesh.environment = &sky;
    sl_scene *scene = trace_mesh_build(&mesh);
    double expected = 4.643140759564 + 8.0 / 4.0 + 1.5 * 0.8 + 32.0 / 16.0 + 0.25 * SL_PI;
    check_irradiance(scene, sl_v3(0.35f, 0.2f, 0), sl_v3(0, 0, 1), expected, 2e-3);
    sl_scene_destroy(scene);
}

static void degenerate_questions_are_answered_with_nothing(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t light = trace_mesh_lamp(&mesh, 5.0f), grey = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 1), sl_v3(0, 1, 0), sl_v3(1, 0, 0), light);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 3), sl_v3(0, 1, 0), sl_v3(1, 0, 0), grey);
    trace_mesh_point_light(&mesh, sl_v3(0, 0, 1), sl_grey(1));
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_light_sampler *sampler = make_sampler(scene);
    const sl_vec3 points[] = {{0, 0, 1},   {0.5f, 0.5f, 1},  {1e30f, 0, 0},  {0.25f, 0.125f, 0.99999994f},
                              {NAN, 0, 0}, {INFINITY, 0, 0}, {-1e-38f, 0, 1}};
    for (size_t k = 0; k < sizeof points / sizeof *points; k++) {
        for (uint32_t i = 0; i < 4096; i++) {
            sl_light_sample s;
            float u = (float)(i & 15) / 15.0f * 0x1.fffffep-1f,
                  v = (float)(i >> 4 & 15) / 15.0f * 0x1.fffffep-1f;
            float select = (float)(i >> 8) / 15.0f * 0x1.fffffep-1f;
            if (!sl_light_sampler_sample_at(sampler, points[k], sl_v3(0, 0, 1), select, u, v, &s)) continue;
            assert_true(sl_rgb_is_finite(s.radiance) && sl_is_finite(s.to_light) && isfinite(s.pdf) &&
                        s.distance > 0.0f);
        }
    }
    /* A triangle that is no emitter, and the sky where there is none, are never sampled. */
    assert_true(sl_light_sampler_pdf(sampler, points[0], sl_v3(0, 0, 1), 2, 1.0f) == 0.0f);
    assert_true(sl_light_sampler_pdf(sampler, points[0], sl_v3(0, 0, 1), SL_NO_INDEX, INFINITY) == 0.0f);
    sl_light_sampler_destroy(sampler);
    sl_scene_destroy(scene);

    mesh = trace_mesh_begin();
    grey = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(0, 0, 3), sl_v3(0, 1, 0), sl_v3(1, 0, 0), grey);
    scene = trace_mesh_build(&mesh);
    sampler = make_sampler(scene);
    sl_light_sample s;
    assert_false(sl_light_sampler_sample_at(sampler, sl_v3(0, 0, 0), sl_v3(0, 0, 1), 0.5f, 0.5f, 0.5f, &s));
    assert_false(sl_light_sampler_sample_2d(sampler, sl_v3(0, 0, 0), 0.5f, 0.5f, &s));
    sl_light_sampler_destroy(sampler);
    sl_scene_destroy(scene);
}

/* 67 keys: no whole number of lanes. */
static void a_row_of_points_is_that_of_single_ones(void **unused) {
    enum { KEYS = 67 };
    static sl_sequence sequence;
    sl_sequence_make(&sequence);
    uint64_t key[KEYS];
    for (uint64_t i = 0; i < KEYS; i++) key[i] = sl_random_key(3, i);
    for (int isa = 0; isa <= (int)sl_isa_best(); isa++) {
        for (uint32_t index = 0; index < 1u << 29; index = 5 * index + 1) {
            float x[KEYS], y[KEYS], z[KEYS], *const row[3] = {x, y, z};
            SL_KERNEL_OF((sl_isa)isa, sl_sequence_points)(&sequence, KEYS, key, 11, index, row);
            for (size_t i = 0; i < KEYS; i++) {
                float single[3];
                sl_sequence_point(&sequence, key[i], 11, index, single);
                for (int d = 0; d < 3; d++) assert_true(row[d][i] == single[d]);
            }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_row_of_points_is_that_of_single_ones),
        cmocka_unit_test(irradiance_from_quads_is_that_of_the_polygon_formula),
        cmocka_unit_test(a_sky_picture_is_sampled_without_bias),
        cmocka_unit_test(lights_without_extent_are_exact_and_mix_with_the_others),
        cmocka_unit_test(degenerate_questions_are_answered_with_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
