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
/* How much sooner than the path tracer the best of the methods reaches an error against a truth. */
typedef struct sl_lead {
    const char *method; /* NULL: none reaches it */
    double seconds;
    double path_seconds; /* until the path tracer is there */
    bool path_later;     /* it was not there after path_seconds, the longest that was tried */
} sl_lead;
sl_lead sl_lead_at(const sl_bench_scene *scene, sl_bench_truth truth, double error);

#endif
