/* D(beta), the tables that take coefficients to a tilted frame: against its integral, its exact properties, and the tables' ends. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "harmonics_support.h"

typedef struct entry_sum {
    int order;
    double beta;
    sl_hsh_fill fill;
    double *sum; /* stride x stride */
} entry_sum;

/* A quadrature of the hemisphere that knows nothing of the lunes: midpoints of equal steps, azimuth by azimuth. */
static void integrate_plainly(entry_sum *e, int polar_steps, int azimuths) {
    size_t stride = sl_hsh_stride(e->order);
    double h[SL_HSH_STRIDE_MAX], other[SL_HSH_STRIDE_MAX];
    memset(e->sum, 0, stride * stride * sizeof *e->sum);
    for (int i = 0; i < polar_steps; i++)
        for (int k = 0; k < azimuths; k++) {
            double theta = 0.5 * SL_PI * (i + 0.5) / polar_steps, phi = 2.0 * SL_PI * (k + 0.5) / azimuths;
            double weight = 0.5 * SL_PI / polar_steps * 2.0 * SL_PI / azimuths * sin(theta);
            sl_vec3d a = sl_v3d(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)), b = tilted(a, e->beta);
            if (b.z < 0.0 && e->fill == SL_HSH_ZERO) continue;
            b.z = fabs(b.z);
            sl_hsh_evaluate(e->order, a, h);
            sl_hsh_evaluate(e->order, b, other);
            for (size_t p = 0; p < stride; p++)
                for (size_t q = 0; q < stride; q++) e->sum[p * stride + q] += weight * h[p] * other[q];
        }
}

static void entries_are_the_integrals(void **state) {
    (void)state;
    enum { ORDER = 5 };
    size_t stride = sl_hsh_stride(ORDER), odd = sl_hsh_odd_start(ORDER);
    double *sum = malloc(stride * stride * sizeof *sum);
    for (int fill = SL_HSH_MIRROR; fill <= SL_HSH_ZERO; fill++) {
        sl_hsh_rotation *r = rotation_new(ORDER, 90, (sl_hsh_fill)fill);
        for (int k = 1; k <= 90; k += 22) { /* whole steps: no interpolation */
            entry_sum e = {ORDER, k * degree, (sl_hsh_fill)fill, sum};
            integrate_plainly(&e, 200, 200);
            sl_hsh_tilt t = sl_hsh_tilt_at(r, (float)(k * degree));
            for (size_t i = 0; i < stride; i++)
                for (size_t j = 0; j < stride; j++) {
                    double truth = sum[i * stride + j], d = 0.0;
                    if (i < odd && j < odd && i < sl_hsh_even_count(ORDER)) d = entry_of(t.even, t.mix, i * odd + j);
                    if (i >= odd && j >= odd && i < odd + sl_hsh_odd_count(ORDER))
                        d = entry_of(t.odd, t.mix, (i - odd) * (stride - odd) + j - odd);
                    assert_true(fabs(d - truth) < (fill == SL_HSH_MIRROR ? 4e-3 : 7e-3)); /* of even with odd ones: 0 */
                }
        }
        sl_hsh_rotation_destroy(r);
    }
    free(sum);
}

static void no_tilt_changes_nothing(void **state) {
    (void)state;
    for (int order = 1; order <= SL_HSH_ORDER_MAX; order++) {
        sl_hsh_rotation *r = rotation_new(order, 2, SL_HSH_MIRROR);
        double v[SL_HSH_STRIDE_MAX] = {0}, u[SL_HSH_STRIDE_MAX];
        for (size_t i = 0; i < sl_hsh_even_count(order); i++) v[i] = 1.0 + (double)i;
        for (size_t i = 0; i < sl_hsh_odd_count(order); i++) v[sl_hsh_odd_start(order) + i] = -1.0 - (double)i;
        tilt_back(r, order, 0.0, v, u);
        assert_memory_equal(u, v, sl_hsh_stride(order) * sizeof *u);
        sl_hsh_rotation_destroy(r);
    }
}

static void white_surroundings_stay_white_when_mirrored(void **state) {
    (void)state;
    const int order = SL_HSH_ORDER_MAX;
    sl_hsh_rotation *r = rotation_new(order, 90, SL_HSH_MIRROR);
    for (int k = 0; k <= 180; k++) {
        sl_hsh_tilt t = sl_hsh_tilt_at(r, (float)(0.5 * k * degree));
        for (size_t i = 0; i < sl_hsh_even_count(order); i++)
            assert_true(fabs(entry_of(t.even, t.mix, i * sl_hsh_odd_start(order)) - (i == 0)) < 1e-6);
    }
    sl_hsh_rotation_destroy(r);
}

/* (1/2 pi) of the lune above both horizons. */
static void black_below_the_horizon_loses_the_lune(void **state) {
    (void)state;
    sl_hsh_rotation *r = rotation_new(3, 90, SL_HSH_ZERO);
    for (int k = 0; k <= 180; k += 9) {
        sl_hsh_tilt t = sl_hsh_tilt_at(r, (float)(0.5 * k * degree));
        assert_true(fabs(entry_of(t.even, t.mix, 0) - (1.0 - 0.5 * k / 180.0)) < 1e-6);
    }
    sl_hsh_rotation_destroy(r);
}

/* Tilting back is tilting the other way: D_ij(beta) = (-1)^(m_i + m_j) D_ji(beta) for the part above both horizons. */
static void zero_fill_is_symmetric_up_to_signs(void **state) {
    (void)state;
    enum { ORDER = 10 };
    size_t width = sl_hsh_odd_start(ORDER);
    sl_hsh_rotation *r = rotation_new(ORDER, 24, SL_HSH_ZERO);
    for (int k = 1; k <= 48; k += 5) {
        sl_hsh_tilt t = sl_hsh_tilt_at(r, (float)(0.5 * k * degree));
        for (int l = 0; l < ORDER; l++)
            for (int m = 0; m <= l; m++)
                for (int p = 0; p < ORDER; p++)
                    for (int q = 0; q <= p; q++) {
                        size_t i = sl_hsh_even(l, m), j = sl_hsh_even(p, q);
                        double there = entry_of(t.even, t.mix, i * width + j), back = entry_of(t.even, t.mix, j * width + i);
                        assert_true(fabs(there - ((m + q) % 2 ? -back : back)) < 1e-6);
                    }
    }
    sl_hsh_rotation_destroy(r);
}

/* The tilted horizon makes D rough in beta near 0 and for m = 1; half a degree is a fine step nevertheless. */
static void interpolation_between_steps_is_close(void **state) {
    (void)state;
    enum { ORDER = 10 };
    sl_hsh_rotation *r = rotation_new(ORDER, 24, SL_HSH_MIRROR);
    size_t width = sl_hsh_odd_start(ORDER), count = sl_hsh_even_count(ORDER) * width;
    for (int k = 1; k < 48; k++) {
        /* What interpolation between steps twice as wide would make of step k. */
        sl_hsh_tilt before = sl_hsh_tilt_at(r, (float)(0.5 * (k - 1) * degree));
        sl_hsh_tilt after = sl_hsh_tilt_at(r, (float)(0.5 * (k + 1) * degree));
        sl_hsh_tilt here = sl_hsh_tilt_at(r, (float)(0.5 * k * degree));
        double worst = 0.0, square = 0.0;
        for (size_t i = 0; i < count; i++) {
            double middle = 0.5 * (entry_of(before.even, before.mix, i) + entry_of(after.even, after.mix, i));
            double error = fabs(entry_of(here.even, here.mix, i) - middle);
            square += error * error;
            worst = error > worst ? error : worst;
        }
        assert_true(worst < (k < 10 ? 0.02 : 7e-3) && sqrt(square / (double)count) < 2e-3);
        assert_true(worst > 1e-4); /* the tables do differ */
    }
    sl_hsh_rotation_destroy(r);
}

/* Irradiance is exact in the first two bands, so its tilts are known: of the part above both horizons, pi (1 + cos beta) / 2. */
static void tilted_cosine_has_its_closed_form(void **state) {
    (void)state;
    sl_hsh_rotation *zero = rotation_new(2, 90, SL_HSH_ZERO), *mirror = rotation_new(2, 90, SL_HSH_MIRROR);
    double cosine[2] = {0.5 * sqrt(2.0 * SL_PI), 0.5 * sqrt(2.0 * SL_PI / 3.0)}; /* of H_00 and H_10 */
    for (int k = 0; k <= 180; k += 12) {
        double beta = 0.5 * k * degree, v[SL_HSH_STRIDE_MAX] = {0}, u[SL_HSH_STRIDE_MAX];
        v[sl_hsh_even(0, 0)] = sqrt(2.0 * SL_PI); /* white seen from the tilted frame, through the record's cosine */
        tilt_back(zero, 2, beta, v, u);
        double seen = cosine[0] * u[sl_hsh_even(0, 0)] + cosine[1] * u[sl_hsh_even(1, 0)];
        assert_true(fabs(seen - 0.5 * SL_PI * (1.0 + cos(beta))) < 1e-5);
        tilt_back(mirror, 2, beta, v, u);
        seen = cosine[0] * u[sl_hsh_even(0, 0)] + cosine[1] * u[sl_hsh_even(1, 0)];
        assert_true(fabs(seen - SL_PI) < 1e-5); /* |cos| is the same on both sides */
    }
    sl_hsh_rotation_destroy(zero);
    sl_hsh_rotation_destroy(mirror);
}

static void same_bits_on_any_number_of_threads(void **state) {
    (void)state;
    for (int order = 3; order <= 9; order += 6) {
        sl_hsh_rotation *one = NULL, *three = NULL;
        assert_int_equal(sl_hsh_rotation_create(order, 0.2, SL_HSH_MIRROR, 1, &one, NULL), SL_OK);
        assert_int_equal(sl_hsh_rotation_create(order, 0.2, SL_HSH_MIRROR, 3, &three, NULL), SL_OK);
        size_t odd_width = sl_hsh_stride(order) - sl_hsh_odd_start(order);
        size_t floats = sl_hsh_even_count(order) * sl_hsh_odd_start(order) + sl_hsh_odd_count(order) * odd_width;
        assert_int_equal(sl_hsh_rotation_bytes(one), sl_hsh_rotation_bytes(three));
        for (int k = 0; k <= 24; k++) {
            sl_hsh_tilt a = sl_hsh_tilt_at(one, (float)(0.5 * k * degree)), b = sl_hsh_tilt_at(three, (float)(0.5 * k * degree));
            assert_memory_equal(a.even[0], b.even[0], floats * sizeof(float));
            assert_memory_equal(a.even[1], b.even[1], floats * sizeof(float));
            assert_true(sl_float_bits(a.mix) == sl_float_bits(b.mix));
        }
        sl_hsh_rotation_destroy(one);
        sl_hsh_rotation_destroy(three);
    }
}

static void angles_beyond_the_table_take_its_ends(void **state) {
    (void)state;
    sl_hsh_rotation *r = rotation_new(4, 16.3, SL_HSH_MIRROR);
    sl_hsh_tilt last = sl_hsh_tilt_at(r, (float)(16.5 * degree)), none = sl_hsh_tilt_at(r, 0.0f);
    assert_true(last.mix > 0.999f && none.mix == 0.0f); /* 16.3 degrees need the step at 16.5 */
    const float large[] = {0.4f, 2.0f, 1e30f, INFINITY}, small[] = {-0.0f, -1e-20f, -3.0f, -INFINITY, NAN};
    for (size_t k = 0; k < sizeof large / sizeof large[0]; k++) {
        sl_hsh_tilt t = sl_hsh_tilt_at(r, large[k]);
        assert_true(t.even[1] == last.even[1] && t.odd[1] == last.odd[1] && t.mix == 1.0f);
    }
    for (size_t k = 0; k < sizeof small / sizeof small[0]; k++) {
        sl_hsh_tilt t = sl_hsh_tilt_at(r, small[k]);
        assert_true(t.even[0] == none.even[0] && t.odd[0] == none.odd[0] && t.mix == 0.0f);
    }
    sl_hsh_rotation_destroy(r);
}

static void impossible_tables_are_refused(void **state) {
    (void)state;
    sl_hsh_rotation *r = (sl_hsh_rotation *)&r;
    sl_error error;
    const double angles[] = {NAN, -0.1, -INFINITY};
    for (size_t k = 0; k < 3; k++) {
        assert_int_equal(sl_hsh_rotation_create(3, angles[k], SL_HSH_MIRROR, 1, &r, &error), SL_ERROR_USAGE);
        assert_null(r);
    }
    assert_int_equal(sl_hsh_rotation_create(0, 0.1, SL_HSH_MIRROR, 1, &r, &error), SL_ERROR_USAGE);
    assert_int_equal(sl_hsh_rotation_create(SL_HSH_ORDER_MAX + 1, 0.1, SL_HSH_MIRROR, 1, &r, NULL), SL_ERROR_USAGE);
    assert_int_equal(sl_hsh_rotation_create(1, 0.0, SL_HSH_ZERO, 1, &r, NULL), SL_OK); /* one step, and nothing odd */
    sl_hsh_tilt t = sl_hsh_tilt_at(r, 1.0f);
    assert_true(t.even[0][0] == 1.0f);
    sl_hsh_rotation_destroy(r);
    assert_int_equal(sl_hsh_rotation_create(2, INFINITY, SL_HSH_MIRROR, 1, &r, NULL), SL_OK); /* as far as 90 degrees */
    double v[SL_HSH_STRIDE_MAX] = {0}, u[SL_HSH_STRIDE_MAX];
    v[0] = 1.0;
    tilt_back(r, 2, 10.0, v, u);
    assert_true(isfinite(u[0]) != 0);
    sl_hsh_rotation_destroy(r);
    sl_hsh_rotation_destroy(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(entries_are_the_integrals),
        cmocka_unit_test(no_tilt_changes_nothing),
        cmocka_unit_test(white_surroundings_stay_white_when_mirrored),
        cmocka_unit_test(black_below_the_horizon_loses_the_lune),
        cmocka_unit_test(zero_fill_is_symmetric_up_to_signs),
        cmocka_unit_test(interpolation_between_steps_is_close),
        cmocka_unit_test(tilted_cosine_has_its_closed_form),
        cmocka_unit_test(same_bits_on_any_number_of_threads),
        cmocka_unit_test(angles_beyond_the_table_take_its_ends),
        cmocka_unit_test(impossible_tables_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
