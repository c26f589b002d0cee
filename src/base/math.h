/* Elementary functions that give the same bits on every machine: libm's may differ between versions and CPUs, these are
 * built of + - * / and sqrt only. Error bounds are tested (tests/test_base_math.c) and hold for all finite arguments
 * in the stated ranges; guarded arguments are said per function. */
#ifndef SL_BASE_MATH_H
#define SL_BASE_MATH_H

#define SL_PI 3.14159265358979323846

/* |x| <= 1e5; error at most 2 ulp of max(|result|, 2^-53 |x|). NaN for NaN or infinite x. */
double sl_sin(double x);
double sl_cos(double x);
double sl_tan(double x);
/* All x; error at most 2 ulp. */
double sl_atan(double x);
/* As C's atan2, including signed zeros; 0 where both are 0 and x is +0. */
double sl_atan2(double y, double x);
/* Arguments beyond [-1,1] are clamped: what rounding puts outside is meant to be 1. Error at most 4 ulp (asin), and
 * at most 1e-15 absolute (acos). */
double sl_asin(double x);
double sl_acos(double x);
/* Error at most 2 ulp; overflow to infinity, underflow to 0 (denormals kept). */
double sl_exp(double x);
/* x > 0: at most 2 ulp. -infinity at 0, NaN below. */
double sl_log(double x);
/* x >= 0; x^y = exp(y log x) with a compensated logarithm: relative error below 1e-14 for results in the normal range.
 * 0^0 = 1, 0^y = 0 for y > 0. NaN for x < 0. */
double sl_pow(double x, double y);

/* Fast float versions for inner loops: relative error below 2e-7 for |result| in the normal range.
 * 2^x for |x| < 126; log2(x) for normal x > 0; cos^n of the Phong lobe: sl_powf(x, n) with 0 <= x <= 1, n >= 0, 1 for n = 0. */
float sl_exp2f(float x);
float sl_log2f(float x);
float sl_powf(float x, float n);
/* sin and cos of 2 pi u for u in [0,1], error below 2e-7 absolute. */
void sl_sincos_turnf(float u, float *sine, float *cosine);

#endif
