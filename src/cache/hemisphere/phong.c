/* A Phong lobe times the cosine in hemispherical harmonics (Krivanek et al. 2005):
 *
 *     c_lm(theta_o) = integral over the hemisphere of (s+2)/(2 pi) max(0, r . w)^s cos theta H_lm(w) dw
 *
 * r is the mirror direction of w_o = (sin theta_o, 0, cos theta_o), so the lobe is symmetric in y and has no
 * part that goes with sin(m phi). Their squares tell how much of the lobe an order holds. */
#include "cache/hemisphere/harmonics.h"

#include "base/math.h"
#include "cache/hemisphere/lobe_integral.h"

#include <math.h>
#include <string.h>

enum { ANGLES = SL_PHONG_ANGLES };

/* ---- one lobe -------------------------------------------------------------------------------- */

typedef struct projection {
    sl_hsh_recurrence recurrence;
    double *coefficients; /* even ones */
    double norm;          /* the lobe's square, times cos^2 */
} projection;

static void add_circle(void *context, const sl_lobe_circle *c) {
    projection *p = context;
    double values[SL_HSH_STRIDE_MAX];
    if (!(c->cosine > 0.0)) return;
    p->norm += c->weight * c->cosine * c->cosine * c->square;
    sl_hsh_evaluate_by(&p->recurrence, sl_v3d(c->sine, 0.0, c->cosine), values);
    for (int l = 0; l < p->recurrence.order; l++)
        for (int m = 0; m <= l; m++) {
            double moment = m % 2 ? -c->moments[m] : c->moments[m]; /* r stands at azimuth pi */
            p->coefficients[sl_hsh_even(l, m)] += c->weight * c->cosine * moment * values[sl_hsh_even(l, m)];
        }
}

/* Coefficients of the lobe for one outgoing angle; returns the integral of its square. */
static double project_lobe(const sl_lobe *lobe, int order, double theta_out, double *coefficients) {
    projection p = {.coefficients = coefficients};
    sl_hsh_recurrence_of(order, &p.recurrence);
    memset(coefficients, 0, sl_hsh_even_count(order) * sizeof *coefficients);
    sl_lobe_visit_circles(lobe, theta_out, false, order, add_circle, &p);
    return p.norm;
}

/* ---- rows by the polar angle ----------------------------------------------------------------- */

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

sl_phong_rows sl_phong_rows_at(const float *rows, size_t row_floats, float cosine) {
    float c = cosine > 0.0f ? (cosine < 1.0f ? cosine : 1.0f) : 0.0f;
    float at = quick_acos(c) * ((float)(ANGLES - 1) * (float)(2.0 / SL_PI));
    int row = (int)at;
    row = row < ANGLES - 2 ? row : ANGLES - 2;
    float mix = at - (float)row;
    const float *first = rows + (size_t)row * row_floats;
    return (sl_phong_rows){first, first + row_floats, mix < 1.0f ? mix : 1.0f};
}

/* ---- how much of a lobe an order holds ------------------------------------------------------- */

/* errors[n] for n = 1 .. order; the basis is orthonormal, so what a projection keeps is a sum of squares. */
static void truncation_errors(int order, double exponent, double theta_out, double *errors) {
    sl_lobe lobe;
    double coefficients[SL_HSH_MAX], kept = 0.0;
    sl_lobe_make(exponent, &lobe);
    double norm = project_lobe(&lobe, order, theta_out, coefficients);
    for (int l = 0; l < order; l++) {
        for (int m = 0; m <= l; m++)
            kept += coefficients[sl_hsh_even(l, m)] * coefficients[sl_hsh_even(l, m)];
        double left = norm > 0.0 ? 1.0 - kept / norm : 0.0;
        errors[l + 1] = left > 0.0 ? sqrt(left) : 0.0;
    }
}

static int usable_order(int order) {
    return order < 1 ? 1 : order > SL_HSH_ORDER_MAX ? SL_HSH_ORDER_MAX : order;
}

double sl_phong_truncation_at(int order, double exponent, double theta_out) {
    double errors[SL_HSH_ORDER_MAX + 1];
    double theta = theta_out > 0.0 ? (theta_out < 0.5 * SL_PI ? theta_out : 0.5 * SL_PI) : 0.0;
    truncation_errors(usable_order(order), exponent, theta, errors);
    return errors[usable_order(order)];
}

double sl_phong_truncation(int order, double exponent) {
    return sl_phong_truncation_at(order, exponent, 0.25 * SL_PI);
}

/* Below s = 1 a lobe ends ever more abruptly in the plane across r. The L2 error counts that edge dearly (s =
 * 0 would want more than twelve bands), while reflected light hardly shows it: two bands more than s = 1
 * wants hold it as well. */
int sl_phong_order(double exponent, double largest_error) {
    double errors[SL_HSH_ORDER_MAX + 1];
    bool abrupt = !(exponent >= 1.0);
    truncation_errors(SL_HSH_ORDER_MAX, abrupt ? 1.0 : exponent, 0.25 * SL_PI, errors);
    int order = 1;
    while (order < SL_HSH_ORDER_MAX && !(errors[order] <= largest_error)) order++;
    return usable_order(abrupt && order > 1 ? order + 2 : order);
}
