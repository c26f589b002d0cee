/* Phong lobes in the frame of their own surface: energy, coefficients against a plain quadrature, what an
 * order cuts off, and the tables' ends. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/math.h"
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

/* Coefficients for an outgoing direction at azimuth 0. */
static void look_up(const sl_moved_lobe *lobe, double cosine, float *coefficients) {
    float c = (float)cosine, sine = (float)sqrt(fmax(0.0, 1.0 - cosine * cosine));
    moved_lobe_look_up(lobe, lobe_order, sl_v3(-sine, 0.0f, c), sl_v3(0.0f, 0.0f, 1.0f), c, coefficients);
}

/* Radiance reflected under a white sky. */
static double albedo(const sl_moved_lobe *table, double cosine) {
    float even[SL_HSH_STRIDE_MAX];
    look_up(table, cosine, even);
    return sqrt(2.0 * SL_PI) * (double)even[0];
}

static void albedo_is_right_at_any_order(void **state) {
    (void)state;
    const double truth[6] = {1.0000, .9659, .8660, .7071, .5005, .2712};
    for (int order = 1; order <= SL_HSH_ORDER_MAX; order++) {
        sl_moved_lobe *table = lobe_new(order, 20.0);
        for (int k = 0; k < 6; k++)
            assert_true(fabs(albedo(table, cos(15.0 * k * degree)) - truth[k]) < 1e-4);
        sl_moved_lobe_destroy(table);
    }
}

/* Relative L2 error of the lobe cut off at that order, per cent. */
static void truncation_is_as_tabulated(void **state) {
    (void)state;
    const struct {
        double exponent;
        int order;
        double error[4], digits;
    } truths[] = {
        {20, 10, {0.8, 1.1, 2.0, 5.8}, 0.051},
        {15, 5, {21.5, 23.1, 26.1, 32.5}, 0.051},
        {20, 5, {31, 32, 35, 42}, 0.51},
        {100, 10, {37, 38, 40, 48}, 0.51},
    };
    const double angles[4] = {0, 45, 60, 75};
    for (size_t k = 0; k < 4; k++) {
        for (int a = 0; a < 4; a++) {
            double error =
                100.0 * sl_phong_truncation_at(truths[k].order, truths[k].exponent, angles[a] * degree);
            assert_true(fabs(error - truths[k].error[a]) < truths[k].digits);
        }
        assert_true(sl_phong_truncation(truths[k].order, truths[k].exponent) ==
                    sl_phong_truncation_at(truths[k].order, truths[k].exponent, 45 * degree));
    }
}

static void the_least_sufficient_order_is_chosen(void **state) {
    (void)state;
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

static void cosines_beyond_the_table_take_its_ends(void **state) {
    (void)state;
    float rows[SL_PHONG_ANGLES];
    const float above[] = {1.0f, 1.0000001f, 1.5f, INFINITY},
                below[] = {0.0f, -0.0f, -1e-20f, -0.5f, -INFINITY, NAN};
    for (size_t k = 0; k < sizeof above / sizeof above[0]; k++) {
        sl_phong_rows at = sl_phong_rows_at(rows, 1, above[k]);
        assert_true(at.first == rows && at.mix == 0.0f);
    }
    for (size_t k = 0; k < sizeof below / sizeof below[0]; k++) {
        sl_phong_rows at = sl_phong_rows_at(rows, 1, below[k]);
        assert_true(at.second == rows + SL_PHONG_ANGLES - 1 && at.mix > 0.9999f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(albedo_is_right_at_any_order),
        cmocka_unit_test(truncation_is_as_tabulated),
        cmocka_unit_test(the_least_sufficient_order_is_chosen),
        cmocka_unit_test(cosines_beyond_the_table_take_its_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
