/* The error bounds that base/math.h states, measured against the long double functions of libm (64 bits of
 * mantissa on x86), and every special value. */
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"

enum { POINTS = 40000 };

/* Uniform in [0,1) with 53 bits. */
static double unit(uint64_t stream, uint64_t i) {
    uint64_t key = sl_random_key(7, stream);
    return ((double)(sl_random_bits(key, 2 * i) >> 5) * 0x1p26 +
            (double)(sl_random_bits(key, 2 * i + 1) >> 6)) *
           0x1p-53;
}

static double ulp(long double value) {
    double v = fabs((double)value);
    if (v < DBL_MIN) return 0x1p-1074;
    return ldexp(1.0, ilogb(v) - 52);
}

static double ulps(double got, long double truth) {
    return (double)(fabsl((long double)got - truth) / ulp(truth));
}

typedef double function(double);
typedef long double truth_function(long double);

/* The largest error in ulp over x in [low, high], and on a logarithmic grid down to 2^-60 of the range. */
static double worst_ulps(function *f, truth_function *truth, double low, double high) {
    double worst = 0.0;
    for (uint64_t i = 0; i < POINTS; i++) {
        double u = unit(1, i), x = low + (high - low) * u;
        double scaled = (i & 1u ? low : high) * exp2(-60.0 * unit(2, i));
        worst = fmax(worst, ulps(f(x), truth((long double)x)));
        if (scaled >= low && scaled <= high) worst = fmax(worst, ulps(f(scaled), truth((long double)scaled)));
    }
    return worst;
}

/* As sl_sin's bound: ulp of max(|result|, 2^-53 |x|). */
static double worst_trigonometric(function *f, truth_function *truth, double range) {
    double worst = 0.0;
    for (int i = 0; i < 3 * POINTS; i++) {
        double x = range * (2.0 * unit(3, (uint64_t)i) - 1.0);
        /* next to the zeros and poles */
        if (i % 3 == 1) x = (i / 3) * (SL_PI / 2.0);
        /* ends of the reduced range */
        if (i % 3 == 2) x = (i / 3) * (SL_PI / 4.0) * (1.0 + 0x1p-52 * (i % 5));
        if (fabs(x) > range) continue;
        long double t = truth((long double)x);
        double scale = ulp(fmaxl(fabsl(t), 0x1p-53L * fabsl((long double)x)));
        worst = fmax(worst, (double)fabsl((long double)f(x) - t) / scale);
    }
    return worst;
}

static void assert_below(const char *what, double error, double bound) {
    if (!(error < bound)) fail_msg("%s: error %g, bound %g", what, error, bound);
    print_message("    %-10s worst error %.3g (bound %g)\n", what, error, bound);
}

static void sine_cosine_tangent_keep_their_bounds(void **state) {
    double ranges[] = {1.0, 10.0, 1000.0, 1e5};
    for (int i = 0; i < 4; i++) {
        assert_below("sin ulp", worst_trigonometric(sl_sin, sinl, ranges[i]), 2.0);
        assert_below("cos ulp", worst_trigonometric(sl_cos, cosl, ranges[i]), 2.0);
        assert_below("tan ulp", worst_trigonometric(sl_tan, tanl, ranges[i]), 3.0);
    }
}

static void trigonometric_special_values(void **state) {
    assert_true(sl_sin(0.0) == 0.0 && !signbit(sl_sin(0.0)) && signbit(sl_sin(-0.0)));
    assert_true(signbit(sl_tan(-0.0)) && sl_cos(0.0) == 1.0 && sl_cos(-0.0) == 1.0);
    assert_true(sl_sin(0x1p-1074) == 0x1p-1074 && sl_sin(1e-300) == 1e-300 && sl_tan(1e-300) == 1e-300);
    assert_true(fabs(sl_tan(SL_PI / 4.0) - 1.0) < 1e-15);
    double bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++)
        assert_true(isnan(sl_sin(bad[i])) && isnan(sl_cos(bad[i])) && isnan(sl_tan(bad[i])));
    for (double x = 1e5; x < 1e300; x *= 1.7) {
        double s = sl_sin(x), c = sl_cos(x);
        assert_true(fabs(s) <= 1.0 && fabs(c) <= 1.0 && fabs(s * s + c * c - 1.0) < 1e-14);
    }
    for (uint64_t i = 0; i < POINTS; i++) { /* odd and even, to the bit */
        double x = 1e5 * unit(4, i);
        assert_true(sl_sin(-x) == -sl_sin(x) && sl_cos(-x) == sl_cos(x) && sl_tan(-x) == -sl_tan(x));
    }
}

static void arc_functions_keep_their_bounds(void **state) {
    assert_below("atan ulp", worst_ulps(sl_atan, atanl, -1.0, 1.0), 2.0);
    assert_below("atan ulp", worst_ulps(sl_atan, atanl, -100.0, 100.0), 2.0);
    assert_below("atan ulp", worst_ulps(sl_atan, atanl, -1e30, 1e30), 2.0);
    assert_below("asin ulp", worst_ulps(sl_asin, asinl, -1.0, 1.0), 4.0);
    double acos_error = 0.0, near_one = 0.0;
    for (uint64_t i = 0; i < POINTS; i++) {
        double x = 2.0 * unit(5, i) - 1.0, close = 1.0 - exp2(-53.0 * unit(6, i));
        acos_error = fmax(acos_error, (double)fabsl((long double)sl_acos(x) - acosl((long double)x)));
        acos_error =
            fmax(acos_error, (double)fabsl((long double)sl_acos(-close) - acosl(-(long double)close)));
        near_one =
            fmax(near_one, (double)fabsl((long double)sl_acos(close) / acosl((long double)close) - 1.0L));
    }
    assert_below("acos", acos_error, 1e-15);
    assert_below("acos near 1, relative", near_one, 1e-15);
}

static void arc_special_values(void **state) {
    assert_true(sl_atan(INFINITY) == SL_PI / 2.0 && sl_atan(-INFINITY) == -SL_PI / 2.0 &&
                isnan(sl_atan(NAN)));
    assert_true(sl_atan(1.0) == SL_PI / 4.0 && signbit(sl_atan(-0.0)) && sl_atan(0x1p-1074) == 0x1p-1074);
    assert_true(sl_acos(1.0) == 0.0 && sl_acos(1.5) == 0.0 && sl_acos(1.0 + DBL_EPSILON) == 0.0);
    assert_true(sl_acos(-1.0) == SL_PI && sl_acos(-7.0) == SL_PI && sl_acos(-INFINITY) == SL_PI &&
                isnan(sl_acos(NAN)));
    assert_true(sl_acos(0.0) == SL_PI / 2.0);
    assert_true(sl_asin(1.0) == SL_PI / 2.0 && sl_asin(2.0) == SL_PI / 2.0 && sl_asin(-2.0) == -SL_PI / 2.0);
    assert_true(signbit(sl_asin(-0.0)) && sl_asin(0.0) == 0.0 && isnan(sl_asin(NAN)));
}

static void atan2_agrees_with_c_on_every_pair_of_special_values(void **state) {
    double v[] = {0.0,        -0.0,     1.0,     -1.0,     2.5,      -2.5,     INFINITY,
                  -INFINITY,  NAN,      DBL_MAX, -DBL_MAX, DBL_MIN,  -DBL_MIN, 0x1p-1074,
                  -0x1p-1074, 0x1p-900, 0x1p900, -0x1p901, -0x1p-950};
    int n = (int)(sizeof v / sizeof v[0]);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double got = sl_atan2(v[i], v[j]), expected = atan2(v[i], v[j]);
            if (isnan(expected)) {
                assert_true(isnan(got));
                continue;
            }
            if (signbit(got) != signbit(expected) ||
                fabs(got - expected) > 2.0 * ulp((long double)expected)) {
                fail_msg("atan2(%g, %g) = %.17g, expected %.17g", v[i], v[j], got, expected);
            }
        }
    }
    double worst = 0.0;
    for (uint64_t i = 0; i < POINTS; i++) {
        double y = (unit(7, i) - 0.5) * exp2(40.0 * unit(8, i)),
               x = (unit(9, i) - 0.5) * exp2(40.0 * unit(10, i));
        worst = fmax(worst, ulps(sl_atan2(y, x), atan2l((long double)y, (long double)x)));
    }
    assert_below("atan2 ulp", worst, 2.0);
}

static void exponential_and_logarithm_keep_their_bounds(void **state) {
    assert_below("exp ulp", worst_ulps(sl_exp, expl, -1.0, 1.0), 2.0);
    assert_below("exp ulp", worst_ulps(sl_exp, expl, -745.0, 709.7), 2.0);
    assert_below("log ulp", worst_ulps(sl_log, logl, 0.5, 2.0), 2.0);
    double worst = 0.0;
    for (uint64_t i = 0; i < POINTS; i++) {
        double x = ldexp(1.0 + unit(11, i), (int)(2097.0 * unit(12, i)) - 1074);
        double near_one = 1.0 + (unit(13, i) - 0.5) * exp2(-45.0 * unit(14, i));
        worst = fmax(worst, ulps(sl_log(x), logl((long double)x)));
        worst = fmax(worst, ulps(sl_log(near_one), logl((long double)near_one)));
    }
    assert_below("log ulp", worst, 2.0);
}

static void exponential_and_logarithm_special_values(void **state) {
    assert_true(sl_exp(0.0) == 1.0 && sl_exp(-0.0) == 1.0 && fabs(sl_exp(1.0) - 2.718281828459045) < 5e-16);
    assert_true(sl_exp(INFINITY) == INFINITY && sl_exp(-INFINITY) == 0.0 && isnan(sl_exp(NAN)));
    assert_true(sl_exp(709.78) < INFINITY && sl_exp(709.79) == INFINITY && sl_exp(1e300) == INFINITY);
    assert_true(sl_exp(-745.1) == 0x1p-1074 && sl_exp(-745.2) == 0.0 && sl_exp(-1e300) == 0.0);
    assert_true(sl_log(1.0) == 0.0 && sl_log(0.0) == -INFINITY && sl_log(-0.0) == -INFINITY);
    assert_true(isnan(sl_log(-1.0)) && isnan(sl_log(NAN)) && isnan(sl_log(-INFINITY)) &&
                sl_log(INFINITY) == INFINITY);
    assert_true(sl_log(0x1p-1074) == log(0x1p-1074) && sl_log(DBL_MAX) == log(DBL_MAX) &&
                sl_log(2.0) == log(2.0));
}

static void power_keeps_its_bound_for_large_exponents_too(void **state) {
    double worst = 0.0;
    for (uint64_t i = 0; i < POINTS; i++) {
        double x = exp2(200.0 * (unit(15, i) - 0.5)), y = 20.0 * (unit(16, i) - 0.5);
        /* with exponents up to 2^45 */
        double near_one = 1.0 + (unit(17, i) - 0.5) * exp2(-40.0 * unit(18, i));
        double huge = 600.0 * (2.0 * unit(19, i) - 1.0) / log(near_one);
        long double a = powl((long double)x, (long double)y),
                    b = powl((long double)near_one, (long double)huge);
        if (a > (long double)DBL_MIN && a < (long double)DBL_MAX) {
            worst = fmax(worst, (double)fabsl((long double)sl_pow(x, y) / a - 1.0L));
        }
        if (b > (long double)DBL_MIN && b < (long double)DBL_MAX) {
            worst = fmax(worst, (double)fabsl((long double)sl_pow(near_one, huge) / b - 1.0L));
        }
    }
    assert_below("pow relative", worst, 1e-14);
}

static void power_agrees_with_c_on_every_pair_of_special_values(void **state) {
    double bases[] = {0.0, 0x1p-1074, DBL_MIN, 0.5, 1.0, 2.0, DBL_MAX, INFINITY, NAN};
    double powers[] = {0.0,  -0.0,  0x1p-1074, 0.25,     -0.25,    1.0,       -1.0, 3.0,
                       1e10, -1e10, DBL_MAX,   -DBL_MAX, INFINITY, -INFINITY, NAN};
    for (size_t i = 0; i < sizeof bases / sizeof bases[0]; i++) {
        for (size_t j = 0; j < sizeof powers / sizeof powers[0]; j++) {
            double got = sl_pow(bases[i], powers[j]), expected = pow(bases[i], powers[j]);
            bool same = isnan(expected)                      ? isnan(got)
                        : isinf(expected) || expected == 0.0 ? got == expected
                                                             : fabs(got / expected - 1.0) < 1e-14;
            if (!same) fail_msg("pow(%g, %g) = %g, expected %g", bases[i], powers[j], got, expected);
        }
    }
    assert_true(isnan(sl_pow(-1.0, 2.0)) && isnan(sl_pow(-INFINITY, 0.5)));
}

/* ---- float helpers ---- */

static double relative(float got, long double truth) {
    return (double)fabsl((long double)got / truth - 1.0L);
}

static void the_float_exponential_keeps_its_bound(void **state) {
    double worst = 0.0;
    for (uint64_t i = 0; i < 8 * POINTS; i++) {
        float x = (float)(252.0 * unit(23, i) - 126.0),
              small = (float)((unit(24, i) - 0.5) * exp2(-20.0 * unit(25, i)));
        worst = fmax(worst, relative(sl_exp2f(x), exp2l((long double)x)));
        worst = fmax(worst, relative(sl_exp2f(small), exp2l((long double)small)));
    }
    assert_below("exp2f", worst, 2e-7);
    for (int k = -126; k <= 127; k++) assert_true(sl_exp2f((float)k) == ldexpf(1.0f, k));
    assert_true(sl_exp2f(1000.0f) == 0x1p127f && sl_exp2f(-1000.0f) == 0x1p-126f &&
                sl_exp2f(NAN) == 0x1p-126f);
    assert_true(sl_exp2f(INFINITY) == 0x1p127f && sl_exp2f(-INFINITY) == 0x1p-126f);
}

static void float_power_keeps_its_bound_for_phong_lobes(void **state) {
    double worst = 0.0;
    for (uint64_t i = 0; i < 8 * POINTS; i++) {
        float n = (float)exp2(20.0 * unit(27, i) - 3.0);                      /* exponents to 10^5 */
        float x = (float)exp2(-fmin(126.0 * unit(28, i) / (double)n, 149.0)); /* the whole range of results */
        long double truth = powl((long double)x, (long double)n);
        if (truth < 0x1.00001p-126L || x == 0.0f) continue;
        worst = fmax(worst, relative(sl_powf(x, n), truth));
    }
    assert_below("powf", worst, 2e-7);
}

static void float_power_special_values(void **state) {
    assert_true(sl_powf(0.0f, 0.0f) == 1.0f && sl_powf(0.3f, 0.0f) == 1.0f && sl_powf(1.0f, 1e6f) == 1.0f);
    assert_true(sl_powf(0.0f, 5.0f) == 0.0f && sl_powf(-0.0f, 5.0f) == 0.0f && sl_powf(-1e-9f, 2.0f) == 0.0f);
    assert_true(sl_powf(NAN, 2.0f) == 0.0f && sl_powf(0.5f, 1000.0f) == 0.0f &&
                sl_powf(0.5f, 126.0f) == 0x1p-126f);
    assert_true(sl_powf(0.5f, 127.0f) == 0.0f && sl_powf(0x1p-140f, 0.5f) == 0x1p-70f &&
                sl_powf(4.0f, 100.0f) == 0x1p127f);
    float before = 0.0f;
    for (int i = 0; i <= 10000; i++) { /* the lobe rises towards its axis */
        float now = sl_powf((float)i * 1e-4f, 20.0f);
        assert_true(now >= before * (1.0f - 3e-7f) && now <= 1.0f);
        before = now;
    }
}

static void sine_and_cosine_of_turns(void **state) {
    double worst = 0.0;
    for (uint64_t i = 0; i <= 8 * POINTS; i++) {
        float u = (float)i / (float)(8 * POINTS), s, c;
        sl_sincos_turnf(u, &s, &c);
        long double angle = 2.0L * 3.14159265358979323846264L * (long double)u;
        worst = fmax(worst,
                     (double)fmaxl(fabsl((long double)s - sinl(angle)), fabsl((long double)c - cosl(angle))));
    }
    assert_below("sincos", worst, 2e-7);
    float sines[] = {0.0f, 1.0f, 0.0f, -1.0f, 0.0f}, cosines[] = {1.0f, 0.0f, -1.0f, 0.0f, 1.0f};
    for (int i = 0; i < 5; i++) {
        float s, c;
        sl_sincos_turnf(0.25f * (float)i, &s, &c);
        assert_true(s == sines[i] && c == cosines[i]);
    }
}

/* Compilers, their options and instruction sets must not change a bit: this number was the same for gcc and
 * clang at -O1 and -O3 on baseline x86-64, AVX2 and AVX-512. */
static void the_bits_are_the_same_everywhere(void **state) {
    enum { N = 4099 };
    static float x[N], power[N], exp2_x[N], s[N], c[N];
    uint64_t hash = 0;
    for (uint64_t i = 0; i < N; i++) x[i] = sl_random_unit(99, i);
    for (int i = 0; i < N; i++) power[i] = sl_powf(x[i], 37.5f);
    for (int i = 0; i < N; i++) exp2_x[i] = sl_exp2f(x[i] * 37.0f - 20.0f);
    for (int i = 0; i < N; i++) sl_sincos_turnf(x[i], &s[i], &c[i]);
    for (int i = 0; i < N; i++) {
        hash = sl_hash64(hash ^ sl_float_bits(power[i]) ^
                         ((uint64_t)sl_float_bits(s[i]) << 32) ^ sl_float_bits(c[i]) ^
                         ((uint64_t)sl_float_bits(exp2_x[i]) << 13));
    }
    for (int i = 0; i < N; i++) {
        double d = (double)x[i] * 20.0 - 10.0;
        double results[] = {sl_sin(d),        sl_tan(d),        sl_exp(d), sl_pow((double)x[i] * 30.0, d),
                            sl_atan2(d, 3.0), sl_acos(d / 10.0)};
        for (int j = 0; j < 6; j++) hash = sl_hash64(hash ^ sl_double_bits(results[j]));
    }
    if (hash != 0xefb7776603071b70u) fail_msg("hash is %016llx", (unsigned long long)hash);
}

/* Three components one after the other, as vectors are written everywhere. gcc 12 merges them into vector
 * instructions and there takes double -> float -> double for nothing, unless told not to (EXACT in the
 * Makefile). */
static void __attribute__((noinline))
round_three(const double from[3], double scale, float rounded[3], double back[3]) {
    double x = from[0] * scale, y = from[1] * scale, z = from[2] * scale;
    rounded[0] = (float)x;
    rounded[1] = (float)y;
    rounded[2] = (float)z;
    back[0] = (double)rounded[0];
    back[1] = (double)rounded[1];
    back[2] = (double)rounded[2];
}

static void a_double_made_float_and_double_again_is_rounded(void **state) {
    volatile double scale = 1.3; /* unknown to the compiler, which would do the sum by itself */
    const double from[3] = {1.1, 2.3, 3.7};
    float rounded[3];
    double back[3];
    round_three(from, scale, rounded, back);
    for (int i = 0; i < 3; i++) assert_true(sl_double_bits(back[i]) == sl_double_bits((double)rounded[i]));
    for (int i = 0; i < 3; i++) assert_true(sl_double_bits(back[i]) != sl_double_bits(from[i] * 1.3));
}

static void numbers_are_much_the_same_up_to_a_hundredth_of_the_larger(void **state) {
    assert_true(sl_is_much_the_same(0.0, 0.0));
    assert_true(sl_is_much_the_same(0.995, 1.0) && sl_is_much_the_same(1.0, 0.995));
    assert_false(sl_is_much_the_same(0.98, 1.0) || sl_is_much_the_same(1.0, 0.98));
    assert_false(sl_is_much_the_same(0.0, 1e-30));
    assert_false(sl_is_much_the_same((double)NAN, 1.0) || sl_is_much_the_same(1.0, (double)NAN) ||
                 sl_is_much_the_same((double)INFINITY, 1.0));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sine_cosine_tangent_keep_their_bounds),
        cmocka_unit_test(trigonometric_special_values),
        cmocka_unit_test(arc_functions_keep_their_bounds),
        cmocka_unit_test(arc_special_values),
        cmocka_unit_test(atan2_agrees_with_c_on_every_pair_of_special_values),
        cmocka_unit_test(exponential_and_logarithm_keep_their_bounds),
        cmocka_unit_test(exponential_and_logarithm_special_values),
        cmocka_unit_test(power_keeps_its_bound_for_large_exponents_too),
        cmocka_unit_test(power_agrees_with_c_on_every_pair_of_special_values),
        cmocka_unit_test(the_float_exponential_keeps_its_bound),
        cmocka_unit_test(float_power_keeps_its_bound_for_phong_lobes),
        cmocka_unit_test(float_power_special_values),
        cmocka_unit_test(sine_and_cosine_of_turns),
        cmocka_unit_test(a_double_made_float_and_double_again_is_rounded),
        cmocka_unit_test(numbers_are_much_the_same_up_to_a_hundredth_of_the_larger),
        cmocka_unit_test(the_bits_are_the_same_everywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
