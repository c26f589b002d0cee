/* What bench_gather's parts share: a scene with points in it, one instrument at work on them, measured and counted. */
#ifndef SL_BENCH_GATHER_H
#define SL_BENCH_GATHER_H

#include "cache/hemisphere/gather_cost.h"
#include "cache/hemisphere/gather_internal.h"

enum { POINTS = 200, SIZES = 5 };

typedef struct bench {
    sl_scene *scene;
    sl_raster *raster;
    sl_tracer *tracer;
    size_t count;
    sl_gather_point points[POINTS];
    sl_irradiance reference[POINTS], result[POINTS];
    sl_counters counters;
} bench;

void bench_stop(const char *what, const sl_error *error);
/* Points: what the scene's camera sees in at most `points` random pixels. */
void bench_open(bench *b, const char *path, size_t points);
void bench_close(bench *b);
/* Irradiance at all points by rays of 256 x 256, the mean of two gathers; returns the relative RMS error that is left. */
double bench_reference(bench *b);
/* sqrt(mean((x - r)^2 / r^2)) over values of more than a thousandth of the mean; *excluded (or NULL): their share. */
double bench_relative_rms(const bench *b, double *excluded);

/* ---- the cost model's measurements (gather_auto.c) ---- */

/* An instrument at one size: milliseconds a gather, and what the probe counts. */
typedef struct gather_row {
    sl_gather_kind kind;
    int size;                      /* 0: none */
    double see_ms, gather_ms, rms; /* visibility alone; all of it; relative RMS error */
    sl_gather_counts counts;
} gather_row;

/* One scene at one N: plane, hemicube and rays at N (by kind), and at the size that is as good as N rays. */
typedef struct gather_case {
    const char *scene;
    int size;
    gather_row at_size[4], as_good[4];
    sl_gather_kind choice;
} gather_case;

extern const int gather_sizes[SIZES];
void gather_measure(bench *b, const char *name, gather_case cases[SIZES]);
void gather_auto_table(const gather_case *cases, int count);
void gather_error_table(const gather_case *cases, int count);
void gather_fit_table(const gather_case *cases, int count);

#endif
