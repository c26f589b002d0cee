/* H_lm(theta, phi) = sqrt 2 K P_l^|m|(2 cos theta - 1) times cos(m phi) or sin(|m| phi); K P_l^0 for m = 0. Normalised associated
 * Legendre functions by recurrence, without factorials and without the Condon-Shortley sign (Gautron et al. 2004, section 3). */
#include "cache/harmonics/harmonics.h"

#include "base/math.h"

#include <math.h>
#include <string.h>

/* One column m of normalised Legendre functions at x = 2c - 1, l = m .. order-1, given P_m^m. */
static void legendre_column(int order, int m, double x, double first, double *column) {
    double before = 0.0, here = first;
    column[m] = first;
    for (int l = m + 1; l < order; l++) {
        double ll = (double)l * l, mm = (double)m * m, lower = (double)(l - 1) * (l - 1);
        double a = sqrt((4.0 * ll - 1.0) / (ll - mm));
        double b = l == m + 1 ? 0.0 : sqrt((lower - mm) / (4.0 * lower - 1.0));
        double next = a * (x * here - b * before);
        before = here;
        here = next;
        column[l] = next;
    }
}

void sl_hsh_evaluate(int order, sl_vec3d d, double *values) {
    double tangential = d.x * d.x + d.y * d.y, sine = sqrt(tangential);
    double c = d.z > 0.0 ? (d.z < 1.0 ? d.z : 1.0) : 0.0;
    /* 1 - c from the tangential part: no cancellation at the zenith. */
    double x = 2.0 * c - 1.0, s = 2.0 * sqrt(c * (tangential / (1.0 + c)));
    double cos_phi = sine > 0.0 ? d.x / sine : 1.0, sin_phi = sine > 0.0 ? d.y / sine : 0.0;
    double column[SL_HSH_ORDER_MAX], first = sqrt(1.0 / (2.0 * SL_PI)), cosine_m = 1.0, sine_m = 0.0;
    memset(values, 0, sl_hsh_stride(order) * sizeof *values);
    for (int m = 0; m < order; m++) {
        if (m > 0) {
            first *= sqrt((2.0 * m + 1.0) / (2.0 * m)) * s;
            double turned = cosine_m * cos_phi - sine_m * sin_phi;
            sine_m = sine_m * cos_phi + cosine_m * sin_phi;
            cosine_m = turned;
        }
        legendre_column(order, m, x, first, column);
        double scale = m > 0 ? sqrt(2.0) : 1.0;
        for (int l = m; l < order; l++) {
            values[sl_hsh_even(l, m)] = scale * cosine_m * column[l];
            if (m > 0) values[sl_hsh_odd(order, l, -m)] = scale * sine_m * column[l];
        }
    }
}
