#include "cache/hemisphere/lobe_integral.h"

#include "base/math.h"
#include "cache/hemisphere/quadrature.h"

#include <math.h>

enum { POLAR_NODES = SL_LOBE_POLAR_NODES, AZIMUTH_NODES = SL_LOBE_AZIMUTH_NODES };

void sl_lobe_make(double exponent, sl_lobe *b) {
    b->exponent = exponent > 0.0 ? (exponent < 1e8 ? exponent : 1e8) : 0.0;
    b->scale = (b->exponent + 2.0) / (2.0 * SL_PI);
    /* the power is 6e-19 there, or r . w is 0 */
    b->cos_reach = b->exponent > 0.0 ? sl_exp(-42.0 / b->exponent) : 0.0;
    b->reach = sl_acos(b->cos_reach);
    sl_gauss_both_ends(POLAR_NODES, b->polar, b->polar_weight);
    sl_gauss_upper_end(AZIMUTH_NODES, b->azimuth, b->azimuth_weight);
}

/* (r . w)^s within reach; rounding may take the cosine a little out of [0,1]. */
static double lobe_power(const sl_lobe *b, double cosine) {
    return sl_pow(cosine > 0.0 ? (cosine < 1.0 ? cosine : 1.0) : 0.0, b->exponent);
}

/* r . w = along + across cos phi. */
static void integrate_circle(const sl_lobe *b, double along, double across, int moments, sl_lobe_circle *c) {
    bool whole = !(along - across < b->cos_reach);
    double limit = SL_PI;
    if (!whole) limit = sl_acos((b->cos_reach - along) / across); /* across > along - cos_reach */
    c->square = 0.0;
    for (int m = 0; m < moments; m++) c->moments[m] = 0.0;
    for (int k = 0; k < AZIMUTH_NODES; k++) {
        /* A periodic function wants equal steps. Both halves of the circle are alike. */
        double phi = whole ? SL_PI * (k + 0.5) / AZIMUTH_NODES : limit * b->azimuth[k];
        double weight = 2.0 * (whole ? SL_PI / AZIMUTH_NODES : limit * b->azimuth_weight[k]);
        double cosine = sl_cos(phi), before = cosine, here = 1.0,
               power = b->scale * lobe_power(b, along + across * cosine);
        c->square += weight * power * power;
        for (int m = 0; m < moments; m++) {
            c->moments[m] += weight * power * here;
            double next = 2.0 * cosine * here - before; /* cos((m+1) phi) */
            before = here;
            here = next;
        }
    }
}

typedef struct rings {
    const sl_lobe *lobe;
    double sine, cosine; /* of r */
    int moments;
    sl_lobe_visit *visit;
    void *context;
} rings;

static void visit_ring(const rings *r, double from, double to) {
    if (!(to > from)) return;
    for (int i = 0; i < POLAR_NODES; i++) {
        double theta = from + (to - from) * r->lobe->polar[i];
        sl_lobe_circle c = {.sine = sl_sin(theta), .cosine = sl_cos(theta)};
        c.weight = (to - from) * r->lobe->polar_weight[i] * c.sine;
        integrate_circle(r->lobe, r->cosine * c.cosine, r->sine * c.sine, r->moments, &c);
        r->visit(r->context, &c);
    }
}

void sl_lobe_visit_circles(const sl_lobe *lobe, double theta, bool all, int moments, sl_lobe_visit *visit,
                           void *context) {
    const rings r = {lobe, sl_sin(theta), sl_cos(theta), moments, visit, context};
    const double horizon = 0.5 * SL_PI, farthest = theta + lobe->reach, nearest = fabs(theta - lobe->reach);
    /* Whole circles about the normal, then circles that the lobe's edge cuts: two rings, since the length of
     * arc is not smooth where they meet. Nor are those who integrate where they meet the horizon. */
    if (lobe->reach > theta) visit_ring(&r, 0.0, nearest < horizon ? nearest : horizon);
    visit_ring(&r, nearest, farthest < horizon ? farthest : horizon);
    if (all) visit_ring(&r, horizon, farthest < SL_PI ? farthest : SL_PI);
}
