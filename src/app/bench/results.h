/* The results of `softlux bench`: the trials fill it in, the reports read it. */
#pragma once

#include "app/bench/trials.h"

#include <cjson/cJSON.h>

/* The middle of repeated measurements, and the first and last of them in order of size. */
typedef struct sl_bench_spread {
    int count;
    double median, least, most;
} sl_bench_spread;

/* Over all pixels. Relative: over the reference's mean. */
typedef struct sl_bench_error {
    bool known;
    double rel_rmse; /* the reference's own noise is subtracted */
    /* with 95 % confidence it is not further than that from the error against the truth: what that noise
     * leaves of itself */
    double doubt;
    double noise;    /* relative RMSE of the reference itself, by its two halves */
    bool lost;       /* it cannot be told from nothing: an upper bound stands in its place */
    double rel_mse, bias, flip;
    uint64_t nonfinite;
} sl_bench_error;

/* One setting of one method. */
typedef struct sl_bench_row {
    const sl_trial *trial;
    sl_child_outcome end;
    char why[256];             /* where it did not run to its end */
    /* seconds until the picture was there, reading the scene not included; cpu: of all threads */
    sl_bench_spread cpu, wall;
    const cJSON *result, *look; /* what its first run and its look reported, in the journal; NULL: nothing */
    int reference[SL_BENCH_TRUTHS]; /* of the scene's, that errors are told against; -1: none */
    sl_bench_error error[SL_BENCH_TRUTHS];
    char picture[SL_BENCH_PATH];
    char *difference; /* against the matched reference, as a PNG in base 64; or NULL */
} sl_bench_row;

/* A picture by the path tracer, and how far it can be trusted. */
typedef struct sl_bench_reference {
    char transport[SL_BENCH_PATHS];
    char file[SL_BENCH_PATH];
    uint64_t samples; /* a pixel; 0: there is none */
    double seconds;   /* of all processors */
    double noise;     /* relative RMSE */
    double wanted;    /* a tenth of the smallest error that is told with it; 0: nothing was */
    double doubt;     /* of that error, as a share of it */
    char trouble[256]; /* why there is none, or no better one; or "" */
    double energy;    /* its mean over that of full global illumination; 0: not known */
    double missing;   /* its relative RMSE against full global illumination; 0: not known */
    bool missing_known;
    char *difference; /* against full global illumination, as a PNG in base 64; or NULL */
} sl_bench_reference;

typedef struct sl_bench_scene {
    char path[SL_BENCH_PATH], name[SL_BENCH_NAME];
    const char *base; /* of the trials; NULL: nothing */
    char hash[17];
    int width, height;
    uint64_t triangles;
    bool glossy, mirrors, sky; /* there are such surfaces; an environment */
    char trouble[1200]; /* why nothing could be measured; or "" */
    size_t row_count, reference_count;
    sl_bench_row *rows;
    sl_bench_reference *references;
    char *picture; /* the full reference as a PNG in base 64; or NULL */
} sl_bench_scene;

typedef struct sl_bench_results {
    const sl_trials *trials;
    char version[32], machine[128];
    int threads, repeats;
    /* how far apart runs of the same trial are: half of that over their middle, of the middle trial */
    double unrest;
    bool interrupted;
    size_t scene_count;
    sl_bench_scene *scenes;
} sl_bench_results;

void sl_bench_results_free(sl_bench_results *results);
/* Sorts the values. */
sl_bench_spread sl_bench_spread_of(double *values, int count);
/* Finds out, from all rows, how quiet the machine was. */
void sl_bench_find_unrest(sl_bench_results *results);
/* Returns what stands in an object under that name; 0: no number does. */
double sl_bench_number(const cJSON *object, const char *name);
/* Tells whether its error was told without a reference. */
bool sl_bench_promises(const sl_bench_row *row);
const char *sl_bench_end_name(sl_child_outcome end);

/* ---- curves ---- */

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
/* The lead of the best method over the path tracer in reaching an error against a truth. */
typedef struct sl_lead {
    const char *method; /* NULL: none reaches it */
    double seconds;
    double path_seconds; /* until the path tracer is there */
    bool path_later;     /* it was not there after path_seconds, the longest that was tried */
} sl_lead;
sl_lead sl_lead_at(const sl_bench_scene *scene, sl_bench_truth truth, double error);
