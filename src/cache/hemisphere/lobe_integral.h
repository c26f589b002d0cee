/* Integrals of a Phong lobe (s+2)/(2 pi) max(0, r . w)^s over circles of latitude about a normal, from which
 * tables of its coefficients are made. */
#ifndef SL_CACHE_LOBE_INTEGRAL_H
#define SL_CACHE_LOBE_INTEGRAL_H

#include "cache/hemisphere/harmonics.h"

enum { SL_LOBE_POLAR_NODES = 48, SL_LOBE_AZIMUTH_NODES = 32, SL_LOBE_MOMENTS_MAX = SL_HSH_ORDER_MAX + 1 };

typedef struct sl_lobe {
    double exponent, scale;  /* scale = (s + 2) / (2 pi) */
    double reach, cos_reach; /* the angle about r beyond which nothing is worth adding */
    double polar[SL_LOBE_POLAR_NODES], polar_weight[SL_LOBE_POLAR_NODES];         /* crowded at both ends */
    /* crowded at the lobe's edge */
    double azimuth[SL_LOBE_AZIMUTH_NODES], azimuth_weight[SL_LOBE_AZIMUTH_NODES];
} sl_lobe;

/* An exponent that is negative or not a number counts as 0. */
void sl_lobe_make(double exponent, sl_lobe *lobe);

/* The circle at polar angle theta stands for `weight` (sin theta d theta); moments[m] is the integral over
 * its azimuths of the lobe times cos(m phi), phi measured from r; square that of the lobe's square. */
typedef struct sl_lobe_circle {
    double sine, cosine, weight, square;
    double moments[SL_LOBE_MOMENTS_MAX];
} sl_lobe_circle;
typedef void sl_lobe_visit(void *context, const sl_lobe_circle *circle);

/* Circles of the upper half of the sphere, or of all of it; r stands at polar angle theta, 0 to 90 degrees.
 * What is integrated may behave like a root of the cosine at the horizon. */
void sl_lobe_visit_circles(const sl_lobe *lobe, double theta, bool all, int moments, sl_lobe_visit *visit,
                           void *context);

#endif
