/* H_lm(theta, phi) = sqrt 2 K P_l^|m|(2 cos theta - 1) times cos(m phi) or sin(|m| phi); K P_l^0 for m = 0.
 * Normalised associated Legendre functions by recurrence, without factorials and without the Condon-Shortley
 * sign (Gautron et al. 2004):
 *
 *     P_0^0 = sqrt(1 / 2 pi),  P_m^m = sqrt((2m+1) / 2m) s P_(m-1)^(m-1),  P_l^m = a_lm (x P_(l-1)^m - b_lm
 * P_(l-2)^m)
 *
 * with x = 2 cos theta - 1, s = sqrt(1 - x^2). */
#include "cache/hemisphere/harmonics.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

#include <math.h>
#include <string.h>

void sl_hsh_recurrence_of(int order, sl_hsh_recurrence *r) {
    memset(r, 0, sizeof *r);
    r->order = order;
    for (int m = 0; m < order; m++) {
        r->diagonal[m] = m > 0 ? sqrt((2.0 * m + 1.0) / (2.0 * m)) : 0.0;
        for (int l = m + 1; l < order; l++) {
            double ll = (double)l * l, mm = (double)m * m, below = (double)(l - 1) * (l - 1);
            double a = sqrt((4.0 * ll - 1.0) / (ll - mm));
            r->first[m][l] = a;
            r->second[m][l] = l == m + 1 ? 0.0 : a * sqrt((below - mm) / (4.0 * below - 1.0));
        }
    }
}

/* cos theta, sin theta and the azimuth as the basis wants them. Near the horizon and below it, cos theta is
 * 0; a direction that is not a number counts as the zenith. */
typedef struct polar {
    double x, s, cos_phi, sin_phi;
} polar;

static polar polar_of(sl_vec3d d) {
    double tangential = d.x * d.x + d.y * d.y;
    if (!(tangential <= 4.0)) return (polar){1.0, 0.0, 1.0, 0.0};
    double sine = sqrt(tangential);
    double c = sl_clamp_unit(d.z);
    /* s = 2 sqrt(c (1 - c)), 1 - c from the tangential part: no cancellation at the zenith. */
    polar p = {2.0 * c - 1.0, 2.0 * sqrt(c * (tangential / (1.0 + c))), 1.0, 0.0};
    if (sine > 1e-150) { /* below, squares lose their digits, and s^m with them */
        p.cos_phi = d.x / sine;
        p.sin_phi = d.y / sine;
    }
    return p;
}

void sl_hsh_evaluate_by(const sl_hsh_recurrence *r, sl_vec3d direction, double *values) {
    int order = r->order;
    size_t odd_start = sl_hsh_odd_start(order);
    polar p = polar_of(direction);
    double first = sqrt(1.0 / (2.0 * SL_PI)), cosine_m = 1.0, sine_m = 0.0;
    memset(values, 0, sl_hsh_stride(order) * sizeof *values);
    for (int m = 0; m < order; m++) {
        double scale = m > 0 ? sqrt(2.0) : 1.0;
        if (m > 0) {
            first *= r->diagonal[m] * p.s;
            double turned = cosine_m * p.cos_phi - sine_m * p.sin_phi;
            sine_m = sine_m * p.cos_phi + cosine_m * p.sin_phi;
            cosine_m = turned;
        }
        double before = 0.0, here = first, even = scale * cosine_m, odd = scale * sine_m;
        for (int l = m; l < order; l++) {
            if (l > m) {
                double next = r->first[m][l] * (p.x * here) - r->second[m][l] * before;
                before = here;
                here = next;
            }
            values[sl_hsh_even(l, m)] = even * here;
            if (m > 0) values[odd_start + (size_t)(l * (l - 1) / 2 + m - 1)] = odd * here;
        }
    }
}

/* Phong lobes in hemispherical harmonics: how much of one an order holds, and a pixel's lobe as coefficients
 * in a record's frame, without rotating coefficients. What the lobe reflects is
 *
 *     integral of L(w) (s+2)/(2 pi) max(0, r . w)^s max(0, n . w) dw
 *
 * with r and n seen from the record's frame, so its coefficients there are, but for what n . w < 0 cuts off,
 *
 *     sum over k = x, y, z of n_k F_k(r)
 *     F_k,lm(r) = integral over the sphere of (s+2)/(2 pi) max(0, r . w)^s w_k H_lm(M w) dw
 *
 * where M mirrors what lies below the record's horizon. F has a table over the polar angle of r alone, for
 * azimuth 0: F_x and F_z are even in y, F_y is odd. Mirroring r changes nothing but the sign of F_z, so the
 * table ends at 90 degrees. What is cut off,
 *
 *     C_lm = integral over n . w < 0 of (s+2)/(2 pi) max(0, r . w)^s (n . w) H_lm(M w) dw,
 *
 * is small but at grazing angles; it is taken as if the pixel's frame were the record's, at the azimuth of r.
 * Then a pixel with the record's normal gets exactly the coefficients of its own lobe, F_z - C (Krivanek et
 * al. 2005), and a white sky the right albedo whatever the normals. */
enum { ANGLES = SL_PHONG_ANGLES, POLAR_NODES = 48, AZIMUTH_NODES = 32, MOMENTS = SL_HSH_ORDER_MAX + 1 };
enum { X, Y, Z, CUT, VECTORS };

/* ---- integrals over circles of latitude ------------------------------------------------------ */

typedef struct products {
    sl_hsh_recurrence recurrence;
    double exponent, scale;            /* scale: (s + 2) / (2 pi) */
    double reach, cos_reach;           /* the angle about r beyond which nothing is worth adding */
    double sine, cosine;               /* of r's polar angle */
    double sum[VECTORS][SL_HSH_STRIDE_MAX];
    double square;                     /* of the lobe times the cosine, over the hemisphere */
} products;

/* The circle at a polar angle stands for `weight` (sin theta d theta); moments[m] is the integral over its
 * azimuths of the lobe times cos(m phi), phi measured from r; square that of the lobe's square. */
typedef struct circle {
    double sine, cosine, weight, square, moments[MOMENTS];
} circle;

/* Node k of n on [0,1] and its weight: nodes crowd at both ends, so that what goes like a root of the
 * distance to an end is integrated as well as what is smooth. */
static double crowded_node(int k, int n, double *weight) {
    double v = (k + 0.5) / n;
    *weight = 30.0 * v * v * (1.0 - v) * (1.0 - v) / n;
    return v * v * v * (10.0 - v * (15.0 - 6.0 * v));
}

/* (r . w)^s within reach; rounding may take the cosine a little out of [0,1]. */
static double lobe_power(const products *p, double cosine) {
    return p->scale * sl_pow(sl_clamp_unit(cosine), p->exponent);
}

/* r . w = along + across cos phi. */
static void integrate_circle(const products *p, double along, double across, circle *c) {
    bool whole = !(along - across < p->cos_reach);
    /* across > along - cos_reach */
    double limit = whole ? SL_PI : sl_acos((p->cos_reach - along) / across);
    for (int k = 0; k < AZIMUTH_NODES; k++) {
        /* A periodic function wants equal steps. Both halves of the circle are alike. */
        double share = 1.0 / AZIMUTH_NODES, node = whole ? (k + 0.5) * share
                                                         : crowded_node(k, AZIMUTH_NODES, &share);
        double cosine = sl_cos(limit * node), before = cosine, here = 1.0,
               power = lobe_power(p, along + across * cosine), weight = 2.0 * limit * share * power;
        c->square += weight * power;
        for (int m = 0; m <= p->recurrence.order; m++) {
            c->moments[m] += weight * here;
            double next = 2.0 * cosine * here - before; /* cos((m+1) phi) */
            before = here;
            here = next;
        }
    }
}

/* w = (sin theta cos phi, sin theta sin phi, cos theta), so a product with w_x or w_y takes the moments m - 1
 * and m + 1: 2 cos phi cos(m phi) = cos((m-1) phi) + cos((m+1) phi), 2 sin phi sin(m phi) = cos((m-1) phi) -
 * cos((m+1) phi). */
static void add_circle(products *p, const circle *c) {
    double h[SL_HSH_STRIDE_MAX];
    sl_hsh_evaluate_by(&p->recurrence, sl_v3d(c->sine, 0.0, fabs(c->cosine)), h);
    for (int l = 0; l < p->recurrence.order; l++)
        for (int m = 0; m <= l; m++) {
            size_t i = sl_hsh_even(l, m);
            double before = c->moments[m > 0 ? m - 1 : 1], after = c->moments[m + 1],
                   weight = c->weight * h[i];
            p->sum[X][i] += weight * c->sine * 0.5 * (before + after);
            if (m > 0) p->sum[Y][i] += weight * c->sine * 0.5 * (before - after);
            p->sum[Z][i] += weight * c->cosine * c->moments[m];
            if (c->cosine < 0.0) p->sum[CUT][i] += weight * c->cosine * c->moments[m];
        }
    if (c->cosine > 0.0) p->square += c->weight * c->cosine * c->cosine * c->square;
}

static void add_circles(products *p, double from, double to) {
    for (int i = 0; i < POLAR_NODES && to > from; i++) {
        double share, theta = from + (to - from) * crowded_node(i, POLAR_NODES, &share);
        circle c = {.sine = sl_sin(theta), .cosine = sl_cos(theta)};
        c.weight = (to - from) * share * c.sine;
        integrate_circle(p, p->cosine * c.cosine, p->sine * c.sine, &c);
        add_circle(p, &c);
    }
}

static void begin_products(int order, double exponent, products *p) {
    sl_hsh_recurrence_of(order, &p->recurrence);
    p->exponent = exponent > 0.0 ? (exponent < 1e8 ? exponent : 1e8) : 0.0;
    p->scale = (p->exponent + 2.0) / (2.0 * SL_PI);
    /* the power is 6e-19 there, or r . w is 0 */
    p->cos_reach = p->exponent > 0.0 ? sl_exp(-42.0 / p->exponent) : 0.0;
    p->reach = sl_acos(p->cos_reach);
}

/* theta: of r, 0 to 90 degrees. First whole circles about the normal, then circles that the lobe's edge cuts:
 * the length of arc is not smooth where they meet, nor are the functions where they meet the horizon. */
static void integrate_lobe(products *p, double theta) {
    const double horizon = 0.5 * SL_PI, farthest = theta + p->reach, nearest = fabs(theta - p->reach);
    memset(p->sum, 0, sizeof p->sum);
    p->square = 0.0;
    p->sine = sl_sin(theta);
    p->cosine = sl_cos(theta);
    if (p->reach > theta) add_circles(p, 0.0, nearest < horizon ? nearest : horizon);
    add_circles(p, nearest, farthest < horizon ? farthest : horizon);
    add_circles(p, horizon, farthest < SL_PI ? farthest : SL_PI);
}

/* ---- rows by the polar angle ----------------------------------------------------------------- */

struct sl_moved_lobe {
    size_t width;
    float *rows; /* [ANGLES][VECTORS][width] */
};

sl_status sl_moved_lobe_create(int order, double exponent, sl_moved_lobe **out, sl_error *error) {
    *out = NULL;
    size_t width = sl_hsh_odd_start(order);
    sl_moved_lobe *t = sl_allocate(1, sizeof *t);
    float *rows = sl_allocate(ANGLES * VECTORS * width, sizeof *rows);
    if (!t || !rows) {
        sl_free(t);
        sl_free(rows);
        return sl_fail_memory(error, "a table of Phong lobes");
    }
    *t = (sl_moved_lobe){width, rows};
    products p;
    begin_products(order, exponent, &p);
    for (size_t row = 0; row < ANGLES; row++) {
        integrate_lobe(&p, 0.5 * SL_PI * (double)row / (ANGLES - 1));
        for (size_t v = 0; v < VECTORS; v++)
            for (size_t i = 0; i < width; i++) rows[(row * VECTORS + v) * width + i] = (float)p.sum[v][i];
    }
    *out = t;
    return SL_OK;
}

void sl_moved_lobe_destroy(sl_moved_lobe *lobe) {
    if (!lobe) return;
    sl_free(lobe->rows);
    sl_free(lobe);
}

size_t sl_moved_lobe_bytes(const sl_moved_lobe *lobe) {
    return sizeof *lobe + ANGLES * VECTORS * lobe->width * sizeof *lobe->rows;
}

/* acos(x) / sqrt(1 - x) is smooth on [0,1]: fitted at Chebyshev nodes, acos within 3e-7. x in [0,1]. */
static float quick_acos(float x) {
    float p = -0x1.3da658p-10f;
    p = p * x + 0x1.a96da8p-8f;
    p = p * x - 0x1.13ec7ep-6f;
    p = p * x + 0x1.f759ecp-6f;
    p = p * x - 0x1.9a8950p-5f;
    p = p * x + 0x1.6c6a9ap-4f;
    p = p * x - 0x1.b77f3cp-3f;
    p = p * x + 0x1.921fb4p+0f;
    return sqrtf(1.0f - x) * p;
}

sl_phong_rows sl_moved_lobe_at(const sl_moved_lobe *lobe, float cosine) {
    float size = fabsf(cosine), c = sl_clamp_unitf(size);
    float at = quick_acos(c) * ((float)(ANGLES - 1) * (float)(2.0 / SL_PI));
    int row = (int)at;
    row = row < ANGLES - 2 ? row : ANGLES - 2;
    float mix = at - (float)row;
    const float *first = lobe->rows + (size_t)row * VECTORS * lobe->width;
    return (sl_phong_rows){first, first + VECTORS * lobe->width, mix < 1.0f ? mix : 1.0f};
}

/* ---- how much of a lobe an order holds ------------------------------------------------------- */

/* At an outgoing angle of 45 degrees. errors[n] for n = 1 .. order; the basis is orthonormal, so what a
 * projection keeps is a sum of squares. */
static void truncation_errors(int order, double exponent, double *errors) {
    products p;
    double kept = 0.0;
    begin_products(order, exponent, &p);
    integrate_lobe(&p, 0.25 * SL_PI);
    for (int l = 0; l < order; l++) {
        for (int m = 0; m <= l; m++) {
            double c = p.sum[Z][sl_hsh_even(l, m)] - p.sum[CUT][sl_hsh_even(l, m)];
            kept += c * c;
        }
        double left = p.square > 0.0 ? 1.0 - kept / p.square : 0.0;
        errors[l + 1] = left > 0.0 ? sqrt(left) : 0.0;
    }
}

static int usable_order(int order) {
    return order < 1 ? 1 : order > SL_HSH_ORDER_MAX ? SL_HSH_ORDER_MAX : order;
}

double sl_phong_truncation(int order, double exponent) {
    double errors[SL_HSH_ORDER_MAX + 1];
    truncation_errors(usable_order(order), exponent, errors);
    return errors[usable_order(order)];
}

/* Below s = 1 a lobe ends ever more abruptly in the plane across r. The L2 error counts that edge dearly (s =
 * 0 would want more than twelve bands), while reflected light hardly shows it: two bands more than s = 1
 * wants hold it as well. */
int sl_phong_order(double exponent, double largest_error) {
    double errors[SL_HSH_ORDER_MAX + 1];
    bool abrupt = !(exponent >= 1.0);
    truncation_errors(SL_HSH_ORDER_MAX, abrupt ? 1.0 : exponent, errors);
    int order = 1;
    while (order < SL_HSH_ORDER_MAX && !(errors[order] <= largest_error)) order++;
    return usable_order(abrupt && order > 1 ? order + 2 : order);
}
