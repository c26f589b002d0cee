/* A method's curve: the error that it reaches in a time, over all its settings. */
#ifndef SL_APP_BENCH_CURVES_H
#define SL_APP_BENCH_CURVES_H

#include "app/bench/results.h"

enum { SL_CURVE_POINTS = 64, SL_CURVES = 16 };

typedef struct sl_curve {
    const char *name;
    size_t count;
    const sl_bench_row *row[SL_CURVE_POINTS]; /* with a known error, by time */
    bool best[SL_CURVE_POINTS];               /* nothing cheaper has less of an error */
} sl_curve;

/* The curves of a scene against one truth, in the order of its rows; how many there are. */
size_t sl_curves_of(const sl_bench_scene *scene, sl_bench_truth truth, sl_curve curves[SL_CURVES]);
/* Processor seconds until the error is that small, along the best settings, straight between two of them on
 * logarithmic axes; 0: it never is. The cheapest setting's time where that is good enough already. */
double sl_curve_time_to(const sl_curve *curve, sl_bench_truth truth, double error);
/* Tells whether the curve is one of the reference tracers; or of what the methods are measured beside,
 * tracers and the photon map. */
bool sl_curve_is_tracer(const sl_curve *curve);
bool sl_curve_is_peer(const sl_curve *curve);

#endif
