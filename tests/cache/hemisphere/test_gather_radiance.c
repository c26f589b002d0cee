/* Coefficients of incoming radiance over the hemispherical harmonics, and how they change with the place. */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "cache/hemisphere/harmonics.h"
#include "gather_world.h"
#include "harmonics_support.h"

enum { FLOATS_MAX = 9 * SL_HSH_STRIDE_MAX };

static sl_gather_settings settings_of(sl_gather_kind kind, int size, int order) {
    sl_gather_settings s = gather_settings(kind, size);
    s.harmonics_order = order;
    return s;
}

static sl_irradiance radiance_at(gatherer *g, sl_vec3 p, sl_vec3 n, float *coefficients) {
    sl_gather_point point = {
        .position = p, .geometric_normal = n, .normal = n, .triangle = SL_NO_INDEX, .key = 5};
    sl_irradiance e;
    sl_gather_radiance(g->gather, &point, g->scratch, &e, coefficients, g->counters);
    return e;
}

/* ---- furnace ---- */

static void white_room_has_one_coefficient_and_no_gradient(void **state) {
    world *w = world_new();
    uint32_t shine = world_material(w, sl_grey(0), (sl_rgb){1, 2, 4});
    world_box(w, sl_v3(0, 0, 0), sl_v3(2, 3, 4), true,
              (uint32_t[6]){shine, shine, shine, shine, shine, shine});
    world_build(w);
    const int sizes[3] = {64, 37, 16}, orders[4] = {12, 10, 5, 1};
    for (int i = 0; i < 3 * 3 * 4; i++) {
        int order = orders[i / 9];
        sl_gather_settings s = settings_of(gather_kinds[i % 3], sizes[i / 3 % 3], order);
        gatherer g = gatherer_new(w, &s);
        float c[FLOATS_MAX];
        size_t stride = sl_hsh_stride(order);
        radiance_at(&g, sl_v3(0.7f, 0, 1.2f), sl_v3(0, 1, 0), c);
        for (size_t v = 0; v < 9; v++) {
            for (size_t j = 0; j < stride; j++) {
                double radiance = v < 3 && j == 0 ? (double)(1 << v) : 0;
                assert_within((double)c[v * stride + j], sqrt(2 * SL_PI) * radiance,
                            v < 3 ? 4e-4 * (1 << v) : 0);
            }
        }
        gatherer_free(&g);
    }
    world_free(w);
}

/* ---- irradiance is among the coefficients ---- */

static void compare_with_irradiance(int order, const sl_gather_point *p, double gradient_eps,
                                    const sl_irradiance *e, const float *c) {
    const double a = 0.5 * sqrt(2 * SL_PI), b = 0.5 * sqrt(2 * SL_PI / 3);
    size_t stride = sl_hsh_stride(order);
    sl_frame frame = sl_frame_from_normal(p->normal);
    float value[3] = {e->value.r, e->value.g, e->value.b};
    for (size_t v = 0; v < 3; v++) {
        double got[3];
        for (size_t d = 0; d < 3; d++) {
            const float *lambda = c + (3 * d + v) * stride;
            got[d] = a * (double)lambda[0] + b * (double)lambda[sl_hsh_even(1, 0)];
        }
        double tx = (double)sl_dot(e->translational[v], frame.x),
               ty = (double)sl_dot(e->translational[v], frame.y);
        double eps = gradient_eps * (fabs(tx) + fabs(ty)) + 0.1 * gradient_eps * (double)value[v];
        assert_within(got[0], (double)value[v], 1e-4 * (double)value[v]);
        assert_within(got[1], tx, eps);
        assert_within(got[2], ty, eps);
    }
}

/* cos theta = sqrt(2 pi) / 2 H_00 + sqrt(2 pi / 3) / 2 H_10 exactly. Walls between rays are straight there,
 * and the walls of the plane's radial extension are left off there. */
static void irradiance_is_two_coefficients(void **state) {
    const sl_gather_kind of[4] = {SL_GATHER_PLANE, SL_GATHER_PLANE, SL_GATHER_HEMICUBE, SL_GATHER_RAYS};
    const double eps[4] = {1e-3, 0.3, 1e-3, 0.05};
    world *w = world_room(true);
    for (int i = 0; i < 8; i++) {
        sl_gather_settings s = settings_of(of[i % 4], i < 4 ? 64 : 37, 6);
        s.border = i % 4 ? SL_BORDER_RADIAL : SL_BORDER_LC04;
        gatherer g = gatherer_new(w, &s);
        for (uint64_t point = 0; point < 12; point++) {
            float c[FLOATS_MAX];
            sl_gather_point p = world_surface_point(w, point);
            sl_irradiance e;
            sl_gather_radiance(g.gather, &p, g.scratch, &e, c, g.counters);
            compare_with_irradiance(6, &p, eps[i % 4], &e, c);
        }
        gatherer_free(&g);
    }
    world_free(w);
}

/* ---- against quadrature ---- */

/* A room whose walls all shine, each in its own way, with two boxes in it. */
static world *shining_room(void) {
    world *w = world_new();
    uint32_t m[6], lamp = world_material(w, sl_grey(0), (sl_rgb){9, 6, 3}),
                   dark = world_material(w, sl_grey(0), sl_grey(0.1f));
    for (int i = 0; i < 6; i++) {
        sl_rgb shine = {0.3f + 0.2f * (float)i, 1.2f - 0.15f * (float)i, i == 3 ? 2 : 0.5f};
        m[i] = world_material(w, sl_grey(0), shine);
    }
    world_box(w, sl_v3(0, 0, 0), sl_v3(4, 3, 6), true, m);
    world_box(w, sl_v3(0.6f, 0.001f, 1.0f), sl_v3(1.5f, 1.2f, 2.0f), false,
              (uint32_t[6]){m[3], m[4], m[5], m[0], m[1], m[2]});
    world_box(w, sl_v3(2.3f, 0.001f, 2.4f), sl_v3(3.3f, 0.7f, 3.2f), false,
              (uint32_t[6]){dark, dark, dark, dark, dark, dark});
    world_quad(w, sl_v3(1.5f, 2.95f, 2.5f), sl_v3(2.5f, 2.95f, 2.5f), sl_v3(2.5f, 2.95f, 3.5f),
               sl_v3(1.5f, 2.95f, 3.5f), lamp);
    world_build(w);
    return w;
}

/* Rays of equal solid angle. */
static void quadrature_by_rays(const world *w, sl_vec3 p, sl_vec3 n, int order,
                               double lambda[3][SL_HSH_STRIDE_MAX]) {
    enum { RINGS = 256, SECTORS = 1024 };
    sl_frame frame = sl_frame_from_normal(n);
    sl_counters counters = {{0}};
    sl_hsh_recurrence recurrence;
    sl_hsh_recurrence_of(order, &recurrence);
    memset(lambda, 0, 3 * sizeof *lambda);
    for (int i = 0; i < RINGS * SECTORS / SL_PACKET; i++) {
        sl_ray16 rays;
        sl_hit16 hits;
        sl_vec3d local[SL_PACKET];
        for (int j = 0; j < SL_PACKET; j++) {
            double c = (i * SL_PACKET / SECTORS + 0.5) / RINGS;
            double azimuth = 2 * SL_PI * (i * SL_PACKET % SECTORS + j + 0.5) / SECTORS;
            local[j] = sl_v3d(sqrt(1 - c * c) * sl_cos(azimuth), sqrt(1 - c * c) * sl_sin(azimuth), c);
            sl_vec3 d = sl_frame_to_world(&frame, sl_to_float(local[j])), o = sl_mad(p, 1e-4f, n);
            sl_ray16_set(&rays, (unsigned)j, o, d, 0.0f, INFINITY, SL_NO_INDEX);
        }
        sl_trace(w->tracer, &rays, SL_PACKET, true, &hits, &counters);
        for (int j = 0; j < SL_PACKET; j++) {
            double values[SL_HSH_STRIDE_MAX];
            if (hits.triangle[j] == SL_NO_INDEX) continue;
            sl_rgb shine = w->scene->materials[w->scene->material_index[hits.triangle[j]]].emission;
            sl_hsh_evaluate_by(&recurrence, local[j], values);
            for (size_t k = 0; k < sl_hsh_stride(order); k++) {
                double share = values[k] * 2 * SL_PI / ((double)RINGS * SECTORS);
                lambda[0][k] += share * (double)shine.r;
                lambda[1][k] += share * (double)shine.g;
                lambda[2][k] += share * (double)shine.b;
            }
        }
    }
}

/* Error of all coefficients together, relative to their size. A plane sees nothing below 20 degrees, and rays
 * of equal cosine weight are few there. */
static void coefficients_agree_with_quadrature(void **state) {
    enum { ORDER = 8 };
    const double bounds[3] = {0.1, 0.035, 0.03};
    world *w = shining_room();
    const sl_vec3 points[3] = {{2.1f, 0, 1.4f}, {4, 1.3f, 2.2f}, {1.7f, 2.0f, 6}},
                  normals[3] = {{0, 1, 0}, {-1, 0, 0}, {0, 0, -1}};
    double truth[3][3][SL_HSH_STRIDE_MAX];
    for (int i = 0; i < 3; i++) quadrature_by_rays(w, points[i], normals[i], ORDER, truth[i]);
    for (int m = 0; m < 6; m++) {
        int k = m % 3, size = m < 3 ? 64 : 55;
        double wrong = 0, all = 0;
        sl_gather_settings s = settings_of(gather_kinds[k], size, ORDER);
        gatherer g = gatherer_new(w, &s);
        for (int i = 0; i < 3; i++) {
            float c[FLOATS_MAX];
            radiance_at(&g, points[i], normals[i], c);
            for (size_t v = 0; v < 3; v++) {
                for (size_t j = 0; j < sl_hsh_stride(ORDER); j++) {
                    double difference = (double)c[v * sl_hsh_stride(ORDER) + j] - truth[i][v][j];
                    wrong += difference * difference;
                    all += truth[i][v][j] * truth[i][v][j];
                }
            }
        }
        print_message("instrument %d, N = %d: coefficients' relative error %.4f\n", k, size,
                      sqrt(wrong / all));
        assert_true(sqrt(wrong / all) < bounds[k]);
        gatherer_free(&g);
    }
    world_free(w);
}

/* ---- gradients ---- */

/* Coefficients of a rectangle at height z that shines downwards: integral of H cos theta' / r^2 over its
 * area. */
static void rectangle_light(int order, double px, double py, double *lambda) {
    enum { STEPS = 48 };
    const double x0 = -0.7, x1 = 1.1, y0 = -0.4, y1 = 0.9, z = 1.3, radiance = 5;
    double values[SL_HSH_STRIDE_MAX];
    memset(lambda, 0, SL_HSH_STRIDE_MAX * sizeof *lambda);
    for (int i = 0; i < STEPS * STEPS; i++) {
        double x = x0 + (x1 - x0) * (i % STEPS + 0.5) / STEPS - px,
               y = y0 + (y1 - y0) * (i / STEPS + 0.5) / STEPS - py;
        double squared = x * x + y * y + z * z, length = sqrt(squared);
        double share = radiance * (x1 - x0) * (y1 - y0) / (STEPS * STEPS) * z / (length * squared);
        hsh_evaluate(order, sl_v3d(x / length, y / length, z / length), values);
        for (size_t k = 0; k < sl_hsh_stride(order); k++) lambda[k] += share * values[k];
    }
}

static double rectangle_gradient_error(world *w, sl_gather_kind kind, int size) {
    enum { ORDER = 5, POINTS = 10 };
    const double step = 1e-4;
    size_t stride = sl_hsh_stride(ORDER);
    sl_gather_settings s = settings_of(kind, size, ORDER);
    gatherer g = gatherer_new(w, &s);
    double sum = 0;
    for (int i = 0; i < POINTS; i++) {
        double px = -0.5 + 0.13 * i, py = 0.3 - 0.07 * i, wrong = 0, all = 0;
        float c[FLOATS_MAX];
        radiance_at(&g, sl_to_float(sl_v3d(px, py, 0)), sl_v3(0, 0, 1), c);
        for (size_t d = 0; d < 2; d++) {
            double ahead[SL_HSH_STRIDE_MAX], behind[SL_HSH_STRIDE_MAX], dx = d == 0 ? step : 0,
                                                                        dy = d == 1 ? step : 0;
            rectangle_light(ORDER, px + dx, py + dy, ahead);
            rectangle_light(ORDER, px - dx, py - dy, behind);
            for (size_t k = 0; k < stride; k++) {
                double truth = (ahead[k] - behind[k]) / (2 * step);
                double difference = (double)c[(3 + 3 * d) * stride + k] - truth;
                wrong += difference * difference;
                all += truth * truth;
            }
        }
        sum += wrong / all;
    }
    gatherer_free(&g);
    return sqrt(sum / POINTS);
}

/* Walls see a light's edges only as finely as the cells are. */
static void gradients_agree_with_a_rectangle_light(void **state) {
    const double bounds[3][4] = {
        {0.22, 0.11, 0.11, 0.06}, {0.08, 0.045, 0.045, 0.025}, {0.08, 0.035, 0.035, 0.015}};
    world *w = world_new();
    world_quad(w, sl_v3(-0.7f, -0.4f, 1.3f), sl_v3(-0.7f, 0.9f, 1.3f), sl_v3(1.1f, 0.9f, 1.3f),
               sl_v3(1.1f, -0.4f, 1.3f), world_material(w, sl_grey(0), sl_grey(5)));
    world_build(w);
    for (int k = 0; k < 3; k++) {
        const int sizes[4] = {32, 63, 64, 128};
        for (int i = 0; i < 4; i++) {
            double wrong = rectangle_gradient_error(w, gather_kinds[k], sizes[i]);
            print_message("instrument %d, N = %d: gradients' relative error %.4f\n", k, sizes[i], wrong);
            assert_true(wrong < bounds[k][i]);
        }
    }
    world_free(w);
}

/* ---- hard numbers ---- */

static void add_what_is_no_number(const void *context, const sl_second_points *points, float *r, float *g,
                                  float *b, bool *missed, sl_counters *counters) {
    for (size_t i = 0; i < points->count; i++) {
        r[i] += i % 3 ? 1.0f : NAN;
        g[i] += i % 5 ? 1.0f : INFINITY;
        b[i] += i % 7 ? 0.0f : -INFINITY;
    }
}

static void radiance_that_is_no_number_stays_out(void **state) {
    const sl_second_light hidden = {.irradiance = add_what_is_no_number};
    world *w = world_room(false);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = settings_of(gather_kinds[k], 32, 10);
        s.second = &hidden;
        gatherer g = gatherer_new(w, &s);
        float c[FLOATS_MAX];
        radiance_at(&g, sl_v3(2, 0, 3.7f), sl_v3(0, 1, 0), c);
        for (size_t i = 0; i < 9 * sl_hsh_stride(10); i++) assert_true(isfinite(c[i]));
        assert_true(c[0] > 0 && c[0] < 10);
        gatherer_free(&g);
    }
    assert_true(w->counters.value[SL_COUNT_NONFINITE] > 0);
    world_free(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(white_room_has_one_coefficient_and_no_gradient),
        cmocka_unit_test(irradiance_is_two_coefficients),
        cmocka_unit_test(coefficients_agree_with_quadrature),
        cmocka_unit_test(gradients_agree_with_a_rectangle_light),
        cmocka_unit_test(radiance_that_is_no_number_stays_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
