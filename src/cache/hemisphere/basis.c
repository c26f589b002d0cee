/* H_lm(theta, phi) = sqrt 2 K P_l^|m|(2 cos theta - 1) times cos(m phi) or sin(|m| phi); K P_l^0 for m = 0.
 * Normalised associated Legendre functions by recurrence, without factorials and without the Condon-Shortley
 * sign (Gautron et al. 2004):
 *
 *     P_0^0 = sqrt(1 / 2 pi),  P_m^m = sqrt((2m+1) / 2m) s P_(m-1)^(m-1),  P_l^m = a_lm (x P_(l-1)^m - b_lm
 * P_(l-2)^m)
 *
 * with x = 2 cos theta - 1, s = sqrt(1 - x^2). */
#include "cache/hemisphere/harmonics.h"

#include "base/math.h"

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
    double c = d.z > 0.0 ? (d.z < 1.0 ? d.z : 1.0) : 0.0;
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
