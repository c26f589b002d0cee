/* A Phong lobe times the cosine in hemispherical harmonics (Krivanek et al. 2005; section 3.3):
 *
 *     c_lm(theta_o) = integral over the hemisphere of (s+2)/(2 pi) max(0, r . w)^s cos theta H_lm(w) dw
 *
 * r is the mirror direction of w_o = (sin theta_o, 0, cos theta_o), so the lobe is symmetric in y and has no part that goes with
 * sin(m phi). An isotropic lobe needs a table over theta_o alone: another azimuth only turns the coefficients. */
#include "cache/harmonics/harmonics.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/harmonics/quadrature.h"

#include <math.h>
#include <string.h>

enum { ANGLES = SL_PHONG_ANGLES, POLAR_NODES = 48, AZIMUTH_NODES = 32 };

struct sl_phong_table {
    int order;
    size_t width; /* floats a row */
    float *rows;  /* ANGLES of them */
};

/* ---- one lobe ---------------------------------------------------------------------------------------------------- */

typedef struct quadrature {
    double polar[POLAR_NODES], polar_weight[POLAR_NODES];         /* crowded at both ends */
    double azimuth[AZIMUTH_NODES], azimuth_weight[AZIMUTH_NODES]; /* crowded at the lobe's edge */
} quadrature;

typedef struct lobe {
    const quadrature *quadrature;
    sl_hsh_recurrence recurrence;
    double exponent, scale;         /* scale = (s + 2) / (2 pi) */
    double reach, cos_reach;        /* the angle about r beyond which nothing is worth adding */
    double sin_out, cos_out;
    double *coefficients;           /* even ones; sums */
    double norm;                    /* sum of the lobe's square */
} lobe;

/* (r . w)^s within reach; rounding may take the cosine a little out of [0,1]. */
static double lobe_power(const lobe *b, double cosine) {
    return sl_pow(cosine > 0.0 ? (cosine < 1.0 ? cosine : 1.0) : 0.0, b->exponent);
}

/* moments[m] = integral of the lobe times cos(m psi) over the circle at theta, psi = phi - pi measured from r; the lobe's square is
 * integrated too. r . w = along + across cos psi. */
static double circle(const lobe *b, double sine, double cosine, double *moments) {
    const quadrature *q = b->quadrature;
    int order = b->recurrence.order;
    double along = b->cos_out * cosine, across = b->sin_out * sine, square = 0.0;
    bool whole = !(along - across < b->cos_reach);
    double limit = SL_PI;
    if (!whole) limit = sl_acos((b->cos_reach - along) / across); /* across > along - cos_reach */
    for (int m = 0; m < order; m++) moments[m] = 0.0;
    for (int k = 0; k < AZIMUTH_NODES; k++) {
        /* A periodic function wants equal steps. Both halves of the circle are alike. */
        double psi = whole ? SL_PI * (k + 0.5) / AZIMUTH_NODES : limit * q->azimuth[k];
        double weight = 2.0 * (whole ? SL_PI / AZIMUTH_NODES : limit * q->azimuth_weight[k]);
        double c = sl_cos(psi), before = c, here = 1.0, power = b->scale * lobe_power(b, along + across * c);
        square += weight * power * power;
        for (int m = 0; m < order; m++) {
            moments[m] += weight * power * here;
            double next = 2.0 * c * here - before; /* cos((m+1) psi) */
            before = here;
            here = next;
        }
    }
    return square;
}

/* Adds the ring from theta_0 to theta_1. */
static void add_ring(lobe *b, double theta_0, double theta_1) {
    if (!(theta_1 > theta_0)) return;
    int order = b->recurrence.order;
    double moments[SL_HSH_ORDER_MAX], values[SL_HSH_STRIDE_MAX];
    for (int i = 0; i < POLAR_NODES; i++) {
        double theta = theta_0 + (theta_1 - theta_0) * b->quadrature->polar[i];
        double sine = sl_sin(theta), cosine = sl_cos(theta);
        if (!(cosine > 0.0)) continue;
        double weight = (theta_1 - theta_0) * b->quadrature->polar_weight[i] * sine * cosine;
        b->norm += weight * cosine * circle(b, sine, cosine, moments);
        sl_hsh_evaluate_by(&b->recurrence, sl_v3d(sine, 0.0, cosine), values);
        for (int l = 0; l < order; l++)
            for (int m = 0; m <= l; m++) {
                double turned = m % 2 ? -moments[m] : moments[m]; /* cos(m phi) = cos(m psi + m pi) */
                b->coefficients[sl_hsh_even(l, m)] += weight * turned * values[sl_hsh_even(l, m)];
            }
    }
}

static double usable_exponent(double exponent) { return exponent > 0.0 ? (exponent < 1e8 ? exponent : 1e8) : 0.0; }

static void quadrature_of(quadrature *q) {
    sl_gauss_both_ends(POLAR_NODES, q->polar, q->polar_weight);
    sl_gauss_upper_end(AZIMUTH_NODES, q->azimuth, q->azimuth_weight);
}

static void lobe_of(const quadrature *q, int order, double exponent, lobe *b) {
    *b = (lobe){.quadrature = q, .exponent = usable_exponent(exponent)};
    sl_hsh_recurrence_of(order, &b->recurrence);
    b->scale = (b->exponent + 2.0) / (2.0 * SL_PI);
    b->cos_reach = b->exponent > 0.0 ? sl_exp(-42.0 / b->exponent) : 0.0; /* the power is 6e-19 there, or r . w is 0 */
    b->reach = sl_acos(b->cos_reach);
}

/* Coefficients of the lobe for one outgoing angle; returns the integral of its square. */
static double project_lobe(lobe *b, double theta_out, double *coefficients) {
    double horizon = 0.5 * SL_PI, nearest = fabs(theta_out - b->reach), farthest = theta_out + b->reach;
    b->sin_out = sl_sin(theta_out);
    b->cos_out = sl_cos(theta_out);
    b->cos_out = b->cos_out > 0.0 ? b->cos_out : 0.0;
    b->coefficients = coefficients;
    b->norm = 0.0;
    memset(coefficients, 0, sl_hsh_even_count(b->recurrence.order) * sizeof *coefficients);
    /* Whole circles about the normal, then circles that the lobe's edge cuts: two rings, since the length of arc is not smooth
     * where they meet. */
    nearest = nearest < horizon ? nearest : horizon;
    if (b->reach > theta_out) add_ring(b, 0.0, nearest);
    add_ring(b, nearest, farthest < horizon ? farthest : horizon);
    return b->norm;
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

sl_status sl_phong_table_create(int order, double exponent, sl_phong_table **table, sl_error *error) {
    *table = NULL;
    if (order < 1 || order > SL_HSH_ORDER_MAX)
        return sl_fail(error, SL_ERROR_USAGE, "order of hemispherical harmonics %d: expected 1 to %d", order, SL_HSH_ORDER_MAX);
    sl_phong_table *t = sl_allocate(1, sizeof *t);
    size_t width = sl_hsh_odd_start(order);
    float *rows = sl_allocate(ANGLES * width, sizeof *rows);
    if (!t || !rows) {
        sl_free(t);
        sl_free(rows);
        return sl_fail_memory(error, "a table of Phong lobes");
    }
    *t = (sl_phong_table){.order = order, .width = width, .rows = rows};
    quadrature q;
    lobe b;
    double coefficients[SL_HSH_MAX];
    quadrature_of(&q);
    lobe_of(&q, order, exponent, &b);
    for (int i = 0; i < ANGLES; i++) {
        (void)project_lobe(&b, 0.5 * SL_PI * i / (ANGLES - 1), coefficients);
        for (size_t j = 0; j < sl_hsh_even_count(order); j++) rows[(size_t)i * width + j] = (float)coefficients[j];
    }
    *table = t;
    return SL_OK;
}

void sl_phong_table_destroy(sl_phong_table *table) {
    if (!table) return;
    sl_free(table->rows);
    sl_free(table);
}

size_t sl_phong_table_bytes(const sl_phong_table *table) { return sizeof *table + ANGLES * table->width * sizeof *table->rows; }

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

sl_phong_rows sl_phong_table_at(const sl_phong_table *table, float cosine) {
    float c = cosine > 0.0f ? (cosine < 1.0f ? cosine : 1.0f) : 0.0f;
    float at = quick_acos(c) * ((float)(ANGLES - 1) * (float)(2.0 / SL_PI));
    int row = (int)at;
    row = row < ANGLES - 2 ? row : ANGLES - 2;
    float mix = at - (float)row;
    const float *first = table->rows + (size_t)row * table->width;
    return (sl_phong_rows){first, first + table->width, mix < 1.0f ? mix : 1.0f};
}

void sl_phong_table_look_up(const sl_phong_table *table, float cosine, float *restrict even) {
    sl_phong_rows rows = sl_phong_table_at(table, cosine);
    const float *restrict first = rows.first, *restrict second = rows.second;
    for (size_t i = 0; i < table->width; i++) even[i] = first[i] + rows.mix * (second[i] - first[i]);
}

/* ---- how much of a lobe an order holds --------------------------------------------------------------------------- */

/* errors[n] for n = 1 .. order; the basis is orthonormal, so what a projection keeps is a sum of squares. */
static void truncation_errors(int order, double exponent, double theta_out, double *errors) {
    quadrature q;
    lobe b;
    double coefficients[SL_HSH_MAX], kept = 0.0;
    quadrature_of(&q);
    lobe_of(&q, order, exponent, &b);
    double norm = project_lobe(&b, theta_out, coefficients);
    for (int l = 0; l < order; l++) {
        for (int m = 0; m <= l; m++) kept += coefficients[sl_hsh_even(l, m)] * coefficients[sl_hsh_even(l, m)];
        double left = norm > 0.0 ? 1.0 - kept / norm : 0.0;
        errors[l + 1] = left > 0.0 ? sqrt(left) : 0.0;
    }
}

static int usable_order(int order) { return order < 1 ? 1 : order > SL_HSH_ORDER_MAX ? SL_HSH_ORDER_MAX : order; }

double sl_phong_truncation_at(int order, double exponent, double theta_out) {
    double errors[SL_HSH_ORDER_MAX + 1];
    double theta = theta_out > 0.0 ? (theta_out < 0.5 * SL_PI ? theta_out : 0.5 * SL_PI) : 0.0;
    truncation_errors(usable_order(order), exponent, theta, errors);
    return errors[usable_order(order)];
}

double sl_phong_truncation(int order, double exponent) { return sl_phong_truncation_at(order, exponent, 0.25 * SL_PI); }

int sl_phong_order(double exponent, double largest_error) {
    double errors[SL_HSH_ORDER_MAX + 1];
    truncation_errors(SL_HSH_ORDER_MAX, exponent, 0.25 * SL_PI, errors);
    int order = 1;
    while (order < SL_HSH_ORDER_MAX && !(errors[order] <= largest_error)) order++;
    return order;
}
