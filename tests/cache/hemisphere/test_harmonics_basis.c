/* Hemispherical harmonics: orthonormal, as in the paper, and safe at the zenith, at the horizon and off the
 * hemisphere. The basis is compiled here once more with a higher largest order than the library's. */
#define SL_HSH_ORDER_MAX 20
#include "unit_test.h"
#include "cache/hemisphere/harmonics.c"

#include <stdlib.h>

#include "base/random.h"
#include "harmonics_support.h"

enum { POLAR = 48, AZIMUTHS = 96, ORDER = SL_HSH_ORDER_MAX };

static sl_vec3d direction_at(double cosine, double phi) {
    double sine = sqrt((1.0 - cosine) * (1.0 + cosine));
    return sl_v3d(sine * cos(phi), sine * sin(phi), cosine);
}

/* Gauss's nodes and weights on [0,1], by Newton's method. */
static void gauss(double *nodes, double *weights) {
    for (int i = 0; i < POLAR; i++) {
        double x = cos(SL_PI * (i + 0.75) / (POLAR + 0.5)), slope = 1.0;
        for (int step = 0; step < 8; step++) {
            double before = 1.0, here = x;
            for (int k = 2; k <= POLAR; k++) {
                double next = ((2.0 * k - 1.0) * x * here - (k - 1.0) * before) / k;
                before = here;
                here = next;
            }
            slope = POLAR * (before - x * here) / (1.0 - x * x);
            x -= here / slope;
        }
        nodes[i] = 0.5 + 0.5 * x;
        weights[i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
}

/* Calls for each node of a quadrature of the hemisphere that is exact for every product of two functions of
 * these orders. */
typedef void visit(void *context, sl_vec3d direction, double weight);
static void over_hemisphere(visit *f, void *context) {
    double nodes[POLAR], weights[POLAR];
    gauss(nodes, weights);
    for (int i = 0; i < POLAR; i++)
        for (int k = 0; k < AZIMUTHS; k++)
            f(context, direction_at(nodes[i], 2.0 * SL_PI * (k + 0.5) / AZIMUTHS),
              weights[i] * 2.0 * SL_PI / AZIMUTHS);
}

/* Places of the coefficients without the padding. */
static size_t places(int order, size_t *place) {
    size_t count = 0;
    for (int l = 0; l < order; l++)
        for (int m = -l; m <= l; m++) place[count++] = m < 0 ? sl_hsh_odd(order, l, m) : sl_hsh_even(l, m);
    return count;
}

static long double product[SL_HSH_STRIDE_MAX][SL_HSH_STRIDE_MAX];

static void add_products(void *context, sl_vec3d d, double weight) {
    double h[SL_HSH_STRIDE_MAX];
    size_t stride = sl_hsh_stride(ORDER);
    hsh_evaluate(ORDER, d, h);
    for (size_t i = 0; i < stride; i++)
        for (size_t j = 0; j <= i; j++) product[i][j] += (long double)weight * h[i] * h[j];
}

static void functions_are_orthonormal_up_to_order_20(void **state) {
    size_t place[SL_HSH_MAX], count = places(ORDER, place);
    memset(product, 0, sizeof product);
    over_hemisphere(add_products, NULL);
    double worst = 0.0;
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < count; j++) {
            size_t a = place[i], b = place[j];
            double error = fabs((double)(a > b ? product[a][b] : product[b][a]) - (i == j ? 1.0 : 0.0));
            worst = error > worst ? error : worst;
        }
    assert_true(worst < 4e-14);
}

static void places_are_distinct_and_fill_all_but_the_padding(void **state) {
    for (int order = 1; order <= ORDER; order++) {
        size_t place[SL_HSH_MAX], count = places(order, place), stride = sl_hsh_stride(order);
        bool taken[SL_HSH_STRIDE_MAX] = {false};
        assert_int_equal(count, order * order);
        assert_int_equal(sl_hsh_even_count(order) + sl_hsh_odd_count(order), count);
        assert_true(stride <= SL_HSH_STRIDE_MAX && stride % 16 == 0 && sl_hsh_odd_start(order) % 16 == 0);
        for (size_t i = 0; i < count; i++) {
            assert_true(place[i] < stride && !taken[place[i]]);
            taken[place[i]] = true;
        }
        double h[SL_HSH_STRIDE_MAX];
        for (size_t i = 0; i < stride; i++) h[i] = NAN;
        hsh_evaluate(order, direction_at(0.3, 1.0), h);
        for (size_t i = 0; i < stride; i++) assert_true(taken[i] ? isfinite(h[i]) != 0 : h[i] == 0.0);
    }
}

static double factorial(int n) { return n < 2 ? 1.0 : n * factorial(n - 1); }

/* The associated Legendre function without normalisation and without (-1)^m. */
static double legendre(int l, int m, double x) {
    double here = 1.0, before = 0.0;
    for (int k = 1; k <= m; k++) here *= (2.0 * k - 1.0) * sqrt(1.0 - x * x);
    for (int k = m + 1; k <= l; k++) {
        double next = ((2.0 * k - 1.0) * x * here - (k + m - 1.0) * before) / (k - m);
        before = here;
        here = next;
    }
    return here;
}

static void functions_equal_the_form_with_factorials(void **state) {
    enum { LIBRARY_ORDER = 12 };
    uint64_t key = sl_random_key(7, 0);
    for (uint64_t k = 0; k < 2000; k++) {
        double c = (double)sl_random_unit(key, 2 * k),
               phi = 2.0 * SL_PI * (double)sl_random_unit(key, 2 * k + 1);
        double h[SL_HSH_STRIDE_MAX];
        hsh_evaluate(LIBRARY_ORDER, direction_at(c, phi), h);
        for (int l = 0; l < LIBRARY_ORDER; l++)
            for (int m = -l; m <= l; m++) {
                int a = abs(m);
                double scale = sqrt((2 * l + 1) * factorial(l - a) / (2.0 * SL_PI * factorial(l + a)));
                double turn = m > 0 ? sqrt(2.0) * cos(m * phi) : m < 0 ? sqrt(2.0) * sin(a * phi) : 1.0;
                double truth = scale * turn * legendre(l, a, 2.0 * c - 1.0);
                assert_true(fabs(h[m < 0 ? sl_hsh_odd(LIBRARY_ORDER, l, m) : sl_hsh_even(l, m)] - truth) <
                            5e-14);
            }
    }
}

static void functions_are_continuous_towards_the_zenith(void **state) {
    double at_zenith[SL_HSH_STRIDE_MAX], h[SL_HSH_STRIDE_MAX];
    hsh_evaluate(ORDER, sl_v3d(0.0, 0.0, 1.0), at_zenith);
    for (double sine = 1e-3; sine > 0.0; sine *= 1e-3) { /* down to denormals */
        hsh_evaluate(ORDER, sl_v3d(0.6 * sine, -0.8 * sine, 1.0), h);
        for (size_t i = 0; i < sl_hsh_stride(ORDER); i++)
            assert_true(fabs(h[i] - at_zenith[i]) < 200.0 * sine + 1e-13);
        /* The azimuth survives in the first order of the sine. */
        if (sine > 1e-100)
            assert_true(fabs(h[sl_hsh_odd(ORDER, 1, -1)] / h[sl_hsh_even(1, 1)] + 0.8 / 0.6) < 1e-12);
    }
}

static void directions_off_the_hemisphere_are_harmless(void **state) {
    double h[SL_HSH_STRIDE_MAX], truth[SL_HSH_STRIDE_MAX];
    const sl_vec3d bad[] = {{NAN, 0, 1},       {0, NAN, 0},      {0, 0, NAN},       {INFINITY, 0, 0},
                            {0, -INFINITY, 1}, {0, 0, INFINITY}, {0, 0, 0},         {0.8, 0.6, -1e-17},
                            {0.5, 0, -0.8},    {1e-200, 0, 1},   {0, 0, 1.0000001}, {1.0000001, 0, 0}};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        hsh_evaluate(ORDER, bad[k], h);
        for (size_t i = 0; i < sl_hsh_stride(ORDER); i++) assert_true(fabs(h[i]) < 50.0);
    }
    hsh_evaluate(ORDER, sl_v3d(0.8, 0.6, 0.0), truth);
    hsh_evaluate(ORDER, sl_v3d(0.8, 0.6, -1e-17), h);
    assert_memory_equal(h, truth, sl_hsh_stride(ORDER) * sizeof *h);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(functions_are_orthonormal_up_to_order_20),
        cmocka_unit_test(places_are_distinct_and_fill_all_but_the_padding),
        cmocka_unit_test(functions_equal_the_form_with_factorials),
        cmocka_unit_test(functions_are_continuous_towards_the_zenith),
        cmocka_unit_test(directions_off_the_hemisphere_are_harmless),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
