/* Phong lobes: what an order cuts off, and coefficients in another frame than the pixel's own, exact under a
 * white sky, and against a plain quadrature elsewhere. */
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "cache/hemisphere/harmonics.h"
#include "harmonics_support.h"

static const double degree = SL_PI / 180.0;

static int lobe_order; /* of the newest */

static sl_moved_lobe *lobe_new(int order, double exponent) {
    sl_moved_lobe *lobe = NULL;
    lobe_order = order;
    assert_int_equal(sl_moved_lobe_create(order, exponent, &lobe, NULL), SL_OK);
    return lobe;
}

static sl_vec3d polar(double theta, double phi) {
    return sl_v3d(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta));
}

/* Mirror direction of o about n. */
static sl_vec3d mirrored(sl_vec3d o, sl_vec3d n) { return sl_subd(sl_scaled(n, 2.0 * sl_dotd(o, n)), o); }

static void look_up(const sl_moved_lobe *lobe, sl_vec3d o, sl_vec3d n, float *coefficients) {
    moved_lobe_look_up(lobe, lobe_order, sl_to_float(mirrored(o, n)), sl_to_float(n), (float)sl_dotd(o, n),
                       coefficients);
}

static void a_white_sky_gives_the_albedo_whatever_the_tilt(void **state) {
    const double exponents[] = {0, 1, 20, 500};
    uint64_t key = sl_random_key(2, 0);
    for (size_t k = 0; k < 4; k++) {
        sl_moved_lobe *lobe = lobe_new(4, exponents[k]);
        for (uint64_t i = 0; i < 500; i++) {
            float coefficients[SL_HSH_STRIDE_MAX], upright[SL_HSH_STRIDE_MAX];
            sl_vec3d n = polar(40 * degree * (double)sl_random_unit(key, 4 * i),
                               6.28 * (double)sl_random_unit(key, 4 * i + 1));
            sl_frame frame = sl_frame_from_normal(sl_to_float(n));
            sl_vec3d local = polar(90 * degree * (double)sl_random_unit(key, 4 * i + 2),
                                   6.28 * (double)sl_random_unit(key, 4 * i + 3));
            look_up(lobe, sl_to_double(sl_frame_to_world(&frame, sl_to_float(local))), n, coefficients);
            look_up(lobe, local, sl_v3d(0, 0, 1), upright);
            /* rows are interpolated */
            assert_true(fabs((double)coefficients[0] - (double)upright[0]) < 3e-4);
        }
        sl_moved_lobe_destroy(lobe);
    }
}

/* (s+2)/(2 pi) (r . w)^s (n . w) H(M w) over what lies above the pixel's horizon. */
static void project_plainly(int order, double exponent, sl_vec3d r, sl_vec3d n, double *sums) {
    enum { STEPS = 300 };
    memset(sums, 0, sl_hsh_stride(order) * sizeof *sums);
    for (int i = 0; i < 2 * STEPS; i++)
        for (int k = 0; k < 2 * STEPS; k++) {
            double theta = 0.5 * SL_PI * (i + 0.5) / STEPS, h[SL_HSH_STRIDE_MAX];
            sl_vec3d w = polar(theta, SL_PI * (k + 0.5) / STEPS);
            double cosine = sl_dotd(r, w), up = sl_dotd(n, w);
            if (!(cosine > 0.0 && up > 0.0)) continue;
            double f = (exponent + 2.0) / (2.0 * SL_PI) * pow(cosine, exponent) * up * sin(theta) * 0.5 *
                       SL_PI / STEPS * SL_PI / STEPS;
            w.z = fabs(w.z);
            hsh_evaluate(order, w, h);
            for (size_t j = 0; j < sl_hsh_stride(order); j++) sums[j] += f * h[j];
        }
}

static void coefficients_are_the_integrals_where_the_horizon_cuts_little(void **state) {
    enum { ORDER = 7 };
    sl_moved_lobe *lobe = lobe_new(ORDER, 20.0);
    for (int k = 0; k < 12; k++) { /* r from the zenith to well below the record's horizon */
        sl_vec3d n = polar((5 + 3 * k) * degree, 0.9 * k);
        sl_frame frame = sl_frame_from_normal(sl_to_float(n));
        sl_vec3d o =
            sl_to_double(sl_frame_to_world(&frame, sl_to_float(polar((7 * k % 60) * degree, 1.7 * k))));
        double truth[SL_HSH_STRIDE_MAX];
        float coefficients[SL_HSH_STRIDE_MAX];
        look_up(lobe, o, n, coefficients);
        project_plainly(ORDER, 20.0, mirrored(o, n), n, truth);
        for (size_t j = 0; j < sl_hsh_stride(ORDER); j++)
            assert_true(fabs((double)coefficients[j] - truth[j]) < 5e-3);
    }
    /* Below the horizon, where F_z changes its sign. */
    sl_vec3d r = polar(100 * degree, 2.0), n = polar(35 * degree, 2.2);
    double truth[SL_HSH_STRIDE_MAX];
    float coefficients[SL_HSH_STRIDE_MAX];
    project_plainly(ORDER, 20.0, r, n, truth);
    moved_lobe_look_up(lobe, lobe_order, sl_to_float(r), sl_to_float(n), (float)sl_dotd(r, n), coefficients);
    for (size_t j = 0; j < sl_hsh_stride(ORDER); j++)
        assert_true(fabs((double)coefficients[j] - truth[j]) < 1e-2);
    sl_moved_lobe_destroy(lobe);
}

static void hard_directions_give_numbers(void **state) {
    sl_moved_lobe *lobe = lobe_new(SL_HSH_ORDER_MAX, 10000.0);
    const float values[] = {0.0f, -0.0f, 1.0f, -1.0f, 1e-38f, 1.0000001f, 0.5f};
    for (size_t a = 0; a < 7; a++)
        for (size_t b = 0; b < 7; b++)
            for (size_t c = 0; c < 7; c++) {
                float coefficients[SL_HSH_STRIDE_MAX];
                sl_vec3 r = sl_v3(values[a], values[b], values[c]),
                        n = sl_v3(values[b], values[c], values[a]);
                moved_lobe_look_up(lobe, lobe_order, r, n, values[c], coefficients);
                for (size_t j = 0; j < SL_HSH_STRIDE_MAX; j++) assert_true(fabsf(coefficients[j]) < 100.0f);
            }
    float coefficients[SL_HSH_STRIDE_MAX];
    moved_lobe_look_up(lobe, lobe_order, sl_v3(0, 0, 1), sl_v3(0, 0, 1), NAN, coefficients);
    for (size_t j = 0; j < SL_HSH_STRIDE_MAX; j++) assert_true(isfinite(coefficients[j]) != 0);
    sl_moved_lobe_destroy(lobe);
    lobe = lobe_new(1, NAN);
    assert_true(sl_moved_lobe_bytes(lobe) > 0);
    sl_moved_lobe_destroy(lobe);
}

/* Radiance reflected under a white sky. */
static double albedo(const sl_moved_lobe *table, double cosine) {
    float even[SL_HSH_STRIDE_MAX];
    float c = (float)cosine, sine = (float)sqrt(fmax(0.0, 1.0 - cosine * cosine));
    moved_lobe_look_up(table, lobe_order, sl_v3(-sine, 0.0f, c), sl_v3(0.0f, 0.0f, 1.0f), c, even);
    return sqrt(2.0 * SL_PI) * (double)even[0];
}

static void albedo_is_right_at_any_order(void **state) {
    const double truth[6] = {1.0000, .9659, .8660, .7071, .5005, .2712};
    for (int order = 1; order <= SL_HSH_ORDER_MAX; order++) {
        sl_moved_lobe *table = lobe_new(order, 20.0);
        for (int k = 0; k < 6; k++)
            assert_true(fabs(albedo(table, cos(15.0 * k * degree)) - truth[k]) < 1e-4);
        sl_moved_lobe_destroy(table);
    }
}

/* Relative L2 error of the lobe cut off at that order, at 45 degrees, per cent. */
static void truncation_is_as_tabulated(void **state) {
    const struct {
        double exponent;
        int order;
        double error, digits;
    } truths[] = {{20, 10, 1.1, 0.051}, {15, 5, 23.1, 0.051}, {20, 5, 32, 0.51}, {100, 10, 38, 0.51}};
    for (size_t k = 0; k < 4; k++) {
        double error = 100.0 * sl_phong_truncation(truths[k].order, truths[k].exponent);
        assert_true(fabs(error - truths[k].error) < truths[k].digits);
    }
}

static void the_least_sufficient_order_is_chosen(void **state) {
    for (double exponent = 1.0; exponent < 12000.0; exponent = 1.5 * exponent + 0.5)
        for (double bound = 0.01; bound < 1.0; bound *= 3.0) {
            int order = sl_phong_order(exponent, bound);
            assert_in_range(order, 1, SL_HSH_ORDER_MAX);
            if (order < SL_HSH_ORDER_MAX) assert_true(sl_phong_truncation(order, exponent) <= bound);
            if (order > 1) assert_true(sl_phong_truncation(order - 1, exponent) > bound);
        }
    assert_int_equal(sl_phong_order(20.0, 0.05), 9);
    assert_int_equal(sl_phong_order(1.0, 0.05), 3);
    assert_int_equal(sl_phong_order(0.9, 0.05), 5);
    assert_int_equal(sl_phong_order(0.0, 0.05), 5);
    assert_int_equal(sl_phong_order(NAN, 0.001), SL_HSH_ORDER_MAX);
    assert_int_equal(sl_phong_order(20.0, NAN), SL_HSH_ORDER_MAX);
    assert_int_equal(sl_phong_order(20.0, 2.0), 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_white_sky_gives_the_albedo_whatever_the_tilt),
        cmocka_unit_test(coefficients_are_the_integrals_where_the_horizon_cuts_little),
        cmocka_unit_test(hard_directions_give_numbers),
        cmocka_unit_test(albedo_is_right_at_any_order),
        cmocka_unit_test(truncation_is_as_tabulated),
        cmocka_unit_test(the_least_sufficient_order_is_chosen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
