/* Coefficients of incoming radiance over the hemispherical harmonics, and how they change with the place. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/math.h"
#include "cache/gather/projection_integrals.h"
#include "cache/harmonics/harmonics.h"
#include "gather_world.h"

static const sl_gather_kind kinds[3] = {SL_GATHER_PLANE, SL_GATHER_HEMICUBE, SL_GATHER_RAYS};

enum { FLOATS_MAX = 9 * SL_HSH_STRIDE_MAX };

static void assert_near(double a, double b, double eps) {
    if (!(fabs(a - b) <= eps)) fail_msg("%.12g is not %.12g (+- %g)", a, b, eps);
}

static sl_gather_settings settings_of(sl_gather_kind kind, int size, int order) {
    sl_gather_settings s = sl_gather_defaults();
    s.kind = kind;
    s.size = size;
    s.emission = true;
    s.direct = SL_DIRECT_RAYS;
    s.harmonics_order = order;
    return s;
}

static sl_irradiance radiance_at(gatherer *g, sl_vec3 p, sl_vec3 n, float *coefficients) {
    sl_gather_point point = {.position = p, .geometric_normal = n, .normal = n, .triangle = SL_NO_INDEX, .key = 5};
    sl_irradiance e;
    assert_true(sl_gather_coefficient_count(g->gather) <= FLOATS_MAX);
    sl_gather_radiance(g->gather, &point, g->scratch, &e, coefficients, g->counters);
    return e;
}

/* ---- tables ---- */

/* The functions are orthogonal to H_00, which is constant: over all cells together they sum to nothing. */
static void sums_of_cells(sl_gather_kind kind, int size, sl_border border, int order, double *total) {
    double t = sl_tan(70.0 / 180.0 * SL_PI), sums[SL_HSH_STRIDE_MAX];
    sl_gather_tables *tables;
    assert_int_equal(sl_gather_tables_create(kind, size, t, border, &tables, NULL), SL_OK);
    sl_instrument in = sl_instrument_of(tables, t, border, order);
    int width = tables->width;
    memset(total, 0, SL_HSH_STRIDE_MAX * sizeof *total);
    for (int y = width / 2; y < width; y++) {
        for (int x = width / 2; x < width; x++) {
            if (!(tables->length[y * width + x] > 0)) continue;
            sl_cell_harmonics(&in, x, y, sums);
            for (size_t i = 0; i < sl_hsh_stride(order); i++) total[i] += sums[i];
        }
    }
    sl_gather_tables_destroy(tables);
}

static void cells_sum_to_the_hemisphere(void **state) {
    (void)state;
    const sl_border borders[4] = {SL_BORDER_RADIAL, SL_BORDER_RADIAL, SL_BORDER_RADIAL, SL_BORDER_AXIAL};
    const int sizes[5] = {8, 13, 24, 40, 64};
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < 5; i++) {
            double total[SL_HSH_STRIDE_MAX];
            sums_of_cells(kinds[k % 3], sizes[i], borders[k], 10, total);
            for (int l = 0; l < 10; l++) { /* of one quadrant; all else cancels with the mirror images */
                for (int m = 0; m <= l; m += 2) {
                    assert_near(4 * total[sl_hsh_even(l, m)], l == 0 ? sqrt(2 * SL_PI) : 0, 1e-12);
                }
            }
        }
    }
}

/* ---- furnace ---- */

static void white_room_has_one_coefficient_and_no_gradient(void **state) {
    (void)state;
    world *w = world_new();
    uint32_t shine = world_material(w, sl_grey(0), (sl_rgb){1, 2, 4});
    world_box(w, sl_v3(0, 0, 0), sl_v3(2, 3, 4), true, (uint32_t[6]){shine, shine, shine, shine, shine, shine});
    world_build(w);
    const int sizes[3] = {64, 37, 16}, orders[4] = {12, 10, 5, 1};
    for (int i = 0; i < 3 * 3 * 4; i++) {
        int order = orders[i / 9];
        sl_gather_settings s = settings_of(kinds[i % 3], sizes[i / 3 % 3], order);
        gatherer g = gatherer_new(w, &s);
        float c[FLOATS_MAX];
        size_t stride = sl_hsh_stride(order);
        assert_int_equal(sl_gather_coefficient_count(g.gather), 9 * stride);
        radiance_at(&g, sl_v3(0.7f, 0, 1.2f), sl_v3(0, 1, 0), c);
        for (size_t v = 0; v < 9; v++) {
            for (size_t j = 0; j < stride; j++) {
                double radiance = v < 3 && j == 0 ? (double)(1 << v) : 0;
                assert_near((double)c[v * stride + j], sqrt(2 * SL_PI) * radiance, v < 3 ? 4e-5 : 0);
            }
        }
        gatherer_free(&g);
    }
    world_free(w);
}

static void nothing_seen_gives_zeros(void **state) {
    (void)state;
    world *w = world_new();
    world_quad(w, sl_v3(-1, -1, -1), sl_v3(1, -1, -1), sl_v3(1, 1, -1), sl_v3(-1, 1, -1), world_material(w, sl_grey(0.5f), sl_grey(1)));
    world_build(w);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = settings_of(kinds[k], 32, 7);
        gatherer g = gatherer_new(w, &s);
        float c[FLOATS_MAX];
        radiance_at(&g, sl_v3(0, 0, 0), sl_v3(0, 0, 1), c);
        for (size_t i = 0; i < 9 * sl_hsh_stride(7); i++) assert_true(c[i] == 0);
        gatherer_free(&g);
    }
    world_free(w);
}

/* ---- irradiance is among the coefficients ---- */

/* cos theta = sqrt(2 pi) / 2 H_00 + sqrt(2 pi / 3) / 2 H_10 exactly: and the cells' integrals are exact too. */
static void irradiance_is_two_coefficients(void **state) {
    (void)state;
    world *w = world_room(true);
    double a = 0.5 * sqrt(2 * SL_PI), b = 0.5 * sqrt(2 * SL_PI / 3);
    for (int i = 0; i < 6; i++) {
        sl_gather_settings s = settings_of(kinds[i % 3], i < 3 ? 64 : 37, 6);
        gatherer g = gatherer_new(w, &s);
        size_t stride = sl_hsh_stride(6);
        for (uint64_t point = 0; point < 12; point++) {
            float c[FLOATS_MAX];
            sl_gather_point p = world_surface_point(w, point);
            sl_irradiance e;
            sl_gather_radiance(g.gather, &p, g.scratch, &e, c, g.counters);
            sl_frame frame = sl_frame_from_normal(p.normal);
            float value[3] = {e.value.r, e.value.g, e.value.b};
            for (size_t v = 0; v < 3; v++) {
                double got[3];
                for (size_t d = 0; d < 3; d++) {
                    const float *lambda = c + (3 * d + v) * stride;
                    got[d] = a * (double)lambda[0] + b * (double)lambda[sl_hsh_even(1, 0)];
                }
                double tx = (double)sl_dot(e.translational[v], frame.x), ty = (double)sl_dot(e.translational[v], frame.y);
                assert_near(got[0], (double)value[v], 2e-6 * (double)value[v]);
                /* Plane and hemicube have the same walls here and there; those of rays are straight on the disc there. */
                double eps = kinds[i % 3] == SL_GATHER_RAYS ? 0.05 : 2e-4;
                assert_near(got[1], tx, eps * (fabs(tx) + fabs(ty)) + 0.1 * eps * (double)value[v]);
                assert_near(got[2], ty, eps * (fabs(tx) + fabs(ty)) + 0.1 * eps * (double)value[v]);
            }
        }
        gatherer_free(&g);
    }
    world_free(w);
}

/* ---- bits ---- */

static void every_instruction_set_and_thread_count_gives_the_same_bits(void **state) {
    (void)state;
    const char *names[4] = {"baseline", "avx2", "avx512", "avx512"};
    world *w = world_room(true);
    for (int k = 0; k < 3; k++) {
        float first[FLOATS_MAX], other[FLOATS_MAX];
        for (int i = 0; i < 4; i++) {
            setenv("SOFTLUX_ISA", names[i], 1);
            sl_gather_settings s = settings_of(kinds[k], 37, 10);
            gatherer g = {.counters = &w->counters};
            assert_int_equal(sl_gather_create(w->scene, w->raster, w->tracer, &s, i == 3 ? 3 : 1, &g.gather, &w->counters, NULL), SL_OK);
            assert_int_equal(sl_gather_scratch_create(g.gather, &g.scratch, NULL), SL_OK);
            sl_gather_point p = world_surface_point(w, 3);
            sl_irradiance e;
            sl_gather_radiance(g.gather, &p, g.scratch, &e, i ? other : first, g.counters);
            if (i) assert_memory_equal(first, other, 9 * sl_hsh_stride(10) * sizeof(float));
            gatherer_free(&g);
        }
        assert_true(first[0] > 0);
    }
    unsetenv("SOFTLUX_ISA");
    world_free(w);
}

static void orders_out_of_range_are_refused(void **state) {
    (void)state;
    world *w = world_room(false);
    for (int i = 0; i < 2; i++) {
        sl_gather_settings s = settings_of(SL_GATHER_RAYS, 16, i ? -1 : SL_HSH_ORDER_MAX + 1);
        sl_gather *gather;
        sl_error error;
        assert_int_equal(sl_gather_create(w->scene, w->raster, w->tracer, &s, 1, &gather, NULL, &error), SL_ERROR_USAGE);
        assert_null(gather);
    }
    world_free(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_sum_to_the_hemisphere),
        cmocka_unit_test(white_room_has_one_coefficient_and_no_gradient),
        cmocka_unit_test(nothing_seen_gives_zeros),
        cmocka_unit_test(irradiance_is_two_coefficients),
        cmocka_unit_test(every_instruction_set_and_thread_count_gives_the_same_bits),
        cmocka_unit_test(orders_out_of_range_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
