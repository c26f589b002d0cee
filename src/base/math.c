/* The polynomials were fitted at Chebyshev nodes over the reduced ranges, with 50 digits; their own error is
 * below 2^-55 of the function, so what is left is rounding. */
#include "base/math.h"

#include <math.h>

/* ---- unevaluated sums of two doubles ---------------------------------------------------------- */

typedef struct {
    double hi, lo;
} pair;

/* a + b exactly (Knuth). */
static pair two_sum(double a, double b) {
    double sum = a + b, part = sum - a;
    return (pair){sum, (a - (sum - part)) + (b - part)};
}

/* a * b exactly (Dekker), unless 2^27 a or 2^27 b overflows. */
static pair two_product(double a, double b) {
    double ta = 0x1.0000002p27 * a, tb = 0x1.0000002p27 * b;
    double ah = ta - (ta - a), bh = tb - (tb - b);
    double al = a - ah, bl = b - bh, product = a * b;
    return (pair){product, ((ah * bh - product) + ah * bl + al * bh) + al * bl};
}

/* ---- sine, cosine, tangent -------------------------------------------------------------------- */

/* x = n pi/2 + r with |r| <= pi/4: Cody and Waite's reduction, pi/2 in parts of 33 bits, so that n times a
 * part is exact for n below 2^20. Returns n modulo 4. */
static unsigned reduce(double x, pair *r) {
    /* fmod is exact, hence the same everywhere; NaN for infinity */
    if (!(fabs(x) <= 1e5)) x = fmod(x, 2.0 * SL_PI);
    double rounded = x * 0x1.45f306dc9c883p-1 + 0x1.8p52;
    double n = rounded - 0x1.8p52;
    pair a = two_sum(x - n * 0x1.921fb544p+0, -(n * 0x1.0b4611a6p-34));
    pair b = two_sum(a.hi, -(n * 0x1.3198a2ep-69));
    double lo = a.lo + (b.lo - n * 0x1.b839a252049c1p-104);
    r->hi = b.hi + lo;
    r->lo = lo - (r->hi - b.hi);
    return (unsigned)(sl_double_bits(rounded) & 3u);
}

/* sin(r.hi + r.lo) and cos(r.hi + r.lo), to first order in r.lo. */
static double sine_of_reduced(pair r) {
    double z = r.hi * r.hi;
    double p = 0x1.5e0b05bff20f2p-33;
    p = p * z - 0x1.ae600aca92c64p-26;
    p = p * z + 0x1.71de379654304p-19;
    p = p * z - 0x1.a01a019e83816p-13;
    p = p * z + 0x1.1111111110bb2p-7;
    p = p * z - 0x1.5555555555555p-3;
    return r.hi + (r.hi * z * p + r.lo * (1.0 - 0.5 * z));
}

static double cosine_of_reduced(pair r) {
    double z = r.hi * r.hi;
    double p = -0x1.907d8f29fe831p-37;
    p = p * z + 0x1.1eeb68cd22f56p-29;
    p = p * z - 0x1.27e4fa17bf139p-22;
    p = p * z + 0x1.a01a019f4e9b4p-16;
    p = p * z - 0x1.6c16c16c16967p-10;
    p = p * z + 0x1.5555555555555p-5;
    double half = 0.5 * z, head = 1.0 - half;
    return head + (((1.0 - head) - half) + (z * z * p - r.hi * r.lo));
}

double sl_sin(double x) {
    pair r;
    unsigned quadrant = reduce(x, &r);
    if (x == 0.0) return x;
    double s = quadrant & 1u ? cosine_of_reduced(r) : sine_of_reduced(r);
    return quadrant & 2u ? -s : s;
}

double sl_cos(double x) {
    pair r;
    unsigned quadrant = reduce(x, &r);
    double c = quadrant & 1u ? sine_of_reduced(r) : cosine_of_reduced(r);
    return (quadrant + 1u) & 2u ? -c : c;
}

double sl_tan(double x) {
    pair r;
    unsigned quadrant = reduce(x, &r);
    if (x == 0.0) return x;
    double s = sine_of_reduced(r), c = cosine_of_reduced(r);
    return quadrant & 1u ? -c / s : s / c;
}

/* ---- arc tangent and what follows from it ----------------------------------------------------- */

/* atan(k/8) */
static const pair atan_of_eighths[9] = {
    {0x0.0p+0, 0x0.0p+0},
    {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
    {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
    {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
    {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
    {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
    {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
    {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
    {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
};
static const pair half_pi = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};

/* atan(y/x) for 0 <= y <= x, x > 0, as atan(c) + atan((y - c x) / (x + c y)) with c the eighth nearest to
 * y/x. */
static pair atan_of_ratio(double y, double x) {
    double ratio = y / x;
    int k = (int)(8.0 * ratio + 0.5);
    double c = 0.125 * k;
    double t = k ? (y - c * x) / (x + c * y) : ratio;
    double z = t * t;
    double p = 0x1.37a11cfd2bddep-4;
    p = p * z - 0x1.7458e47ba7bedp-4;
    p = p * z + 0x1.c71c6f6b1f802p-4;
    p = p * z - 0x1.2492492445898p-3;
    p = p * z + 0x1.9999999999927p-3;
    p = p * z - 0x1.5555555555555p-2;
    return (pair){atan_of_eighths[k].hi, t + (t * z * p + atan_of_eighths[k].lo)};
}

/* The angle of (x, y) in the first quadrant; not both zero, not both infinite, no NaN. */
static double first_quadrant(double y, double x) {
    bool steep = y > x;
    pair a = steep ? atan_of_ratio(x, y) : atan_of_ratio(y, x);
    if (!steep) return a.hi + a.lo;
    return (half_pi.hi - a.hi) - (a.lo - half_pi.lo);
}

double sl_atan(double x) {
    if (x == 0.0) return x; /* a zero keeps its sign */
    return isnan(x) ? x : copysign(first_quadrant(fabs(x), 1.0), x);
}

double sl_atan2(double y, double x) {
    if (isnan(x) || isnan(y)) return x + y;
    double ax = fabs(x), ay = fabs(y), larger = ax > ay ? ax : ay;
    double angle = 0.0;
    if (larger > 0.0) {
        if (isinf(ax) && isinf(ay)) ax = ay = 1.0;
        /* no overflow in x + c y */
        double scale = larger > 0x1p900 ? 0x1p-200 : larger < 0x1p-900 ? 0x1p200 : 1.0;
        angle = first_quadrant(ay * scale, ax * scale);
    }
    if (signbit(x)) angle = 2.0 * half_pi.hi - (angle - 2.0 * half_pi.lo);
    return copysign(angle, y);
}

static double clamp_to_one(double x) { return x > 1.0 ? 1.0 : x < -1.0 ? -1.0 : x; }

double sl_asin(double x) {
    x = clamp_to_one(x);
    return sl_atan2(x, sqrt((1.0 - x) * (1.0 + x)));
}

double sl_acos(double x) {
    x = clamp_to_one(x);
    return sl_atan2(sqrt((1.0 - x) * (1.0 + x)), x);
}

/* ---- exponential, logarithm, power ------------------------------------------------------------ */

static double power_of_two(int n) { return sl_double_of_bits((uint64_t)(n + 1023) << 52); }

/* exp(x.hi + x.lo): x = n log 2 + r, |r| <= log(2)/2; the first part of log 2 has 40 bits, so n times it is
 * exact. */
static double exp_of_pair(pair x) {
    if (isnan(x.hi)) return x.hi;
    if (x.hi > 710.0) return INFINITY;
    if (x.hi < -746.0) return 0.0;
    double n = (x.hi * 0x1.71547652b82fep+0 + 0x1.8p52) - 0x1.8p52;
    double r = (x.hi - n * 0x1.62e42fefa2p-1) - (n * 0x1.9ef35793c7673p-41 - x.lo);
    double p = 0x1.1f730349868cep-29; /* (exp(r) - 1 - r) / r^2 */
    p = p * r + 0x1.af4de97ca4194p-26;
    p = p * r + 0x1.27e4db646b17ep-22;
    p = p * r + 0x1.71de0231960ebp-19;
    p = p * r + 0x1.a01a01a6d889cp-16;
    p = p * r + 0x1.a01a01abe7fe1p-13;
    p = p * r + 0x1.6c16c16c162d4p-10;
    p = p * r + 0x1.11111111100dcp-7;
    p = p * r + 0x1.5555555555556p-5;
    p = p * r + 0x1.5555555555557p-3;
    p = p * r + 0.5;
    int whole = (int)n, half = whole / 2;
    /* only the last can round */
    return (1.0 + (r + r * r * p)) * power_of_two(half) * power_of_two(whole - half);
}

/* log x for finite x > 0, with about ten bits more than a double: x = 2^k m, m in [sqrt(1/2), sqrt(2)), and
 * log m = 2 (s + s^3/3 + s^5/5 + ...) with s = (m-1)/(m+1); only the leading term needs the second double. */
static pair log_to_pair(double x) {
    int shift = 0;
    if (x < 0x1p-1022) {
        x *= 0x1p54;
        shift = 54;
    }
    uint64_t bits = sl_double_bits(x);
    uint64_t biased = (bits + (0x3ff0000000000000u - 0x3fe6a09e667f3bcdu)) >> 52;
    double k = (double)((int)biased - 1023 - shift);
    double f = sl_double_of_bits(bits - (biased << 52) + 0x3ff0000000000000u) - 1.0;
    pair below = two_sum(2.0, f);
    double s = f / below.hi;
    pair back = two_product(s, below.hi);
    double s_lo = (((f - back.hi) - back.lo) - s * below.lo) / below.hi;
    double z = s * s;
    double p = 0x1.0c0aff044a970p-3;
    p = p * z + 0x1.0fbde0f4ad17bp-3;
    p = p * z + 0x1.3b1c3c1c81c8fp-3;
    p = p * z + 0x1.745cf8e4bba1bp-3;
    p = p * z + 0x1.c71c7201a55d7p-3;
    p = p * z + 0x1.2492492476a1ap-2;
    p = p * z + 0x1.9999999999a39p-2;
    p = p * z + 0x1.5555555555555p-1;
    pair head = two_sum(k * 0x1.62e42fefa2p-1, 2.0 * s);
    double tail = head.lo + (k * 0x1.9ef35793c7673p-41 + (2.0 * s_lo + s * z * p));
    pair log_x = {head.hi + tail, 0.0};
    log_x.lo = tail - (log_x.hi - head.hi);
    return log_x;
}

double sl_exp(double x) { return exp_of_pair((pair){x, 0.0}); }

double sl_log(double x) {
    if (isnan(x) || x < 0.0) return NAN;
    if (x == 0.0) return -INFINITY;
    return isinf(x) ? x : log_to_pair(x).hi;
}

double sl_pow(double x, double y) {
    if (y == 0.0 || x == 1.0) return 1.0;
    if (isnan(y) || isnan(x) || x < 0.0) return NAN;
    if (x == 0.0 || isinf(x)) return (x == 0.0) == (y > 0.0) ? 0.0 : INFINITY;
    pair log_x = log_to_pair(x);
    double rough = y * log_x.hi;
    if (!(fabs(rough) < 750.0)) return rough > 0.0 ? INFINITY : 0.0;
    pair product = two_product(y, log_x.hi);
    product.lo += y * log_x.lo;
    return exp_of_pair(product);
}
