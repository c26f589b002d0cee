/* What `softlux bench` has found out, as plain structs: the trials fill them in, the reports read them. */
#ifndef SL_APP_BENCH_RESULTS_H
#define SL_APP_BENCH_RESULTS_H

#include "app/auto_choice.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* What a picture is held against. */
typedef enum sl_bench_truth {
    /* the light paths that the method itself declares: what is wrong is the method's own error */
    SL_BENCH_MATCHED,
    SL_BENCH_ONE_BOUNCE, /* direct light and one diffuse bounce */
    SL_BENCH_FULL,       /* all of global illumination */
    SL_BENCH_TRUTHS
} sl_bench_truth;

/* Which row of a method's ladder of settings a trial is. */
typedef enum sl_bench_quality {
    SL_BENCH_DRAFT,
    SL_BENCH_NORMAL,
    SL_BENCH_HIGH,
    SL_BENCH_CURVE,
    SL_BENCH_QUALITIES
} sl_bench_quality;

typedef enum sl_bench_end {
    SL_BENCH_RAN,
    SL_BENCH_FAILED,  /* with an error message of its own: out of memory, a scene that it cannot do */
    SL_BENCH_CRASHED,
    SL_BENCH_STOPPED, /* by the limit of seconds */
    SL_BENCH_LEFT_OUT /* the budget was spent */
} sl_bench_end;

/* The middle of repeated measurements, and the first and last of them in order of size. */
typedef struct sl_bench_spread {
    int count;
    double median, least, most;
} sl_bench_spread;

/* Over the pixels that look at neither a lamp nor the sky. Relative: over the reference's mean. */
typedef struct sl_bench_error {
    bool known;
    double rel_rmse; /* the reference's own noise is subtracted */
    /* with 95 % confidence it is not further than that from the error against the truth: what that noise
     * leaves of itself */
    double doubt;
    double measured; /* with it */
    double noise;    /* relative RMSE of the reference itself, by its two halves */
    bool lost;       /* it cannot be told from nothing: an upper bound stands in its place */
    double rel_mse, bias, flip;
    uint64_t nonfinite;
} sl_bench_error;

/* The error of the whole picture, lamps and sky included, as it is told without a reference, and as it is. */
typedef struct sl_bench_promise {
    bool known;
    double estimate;    /* relative RMSE against the method's own light paths */
    double bound;       /* with 95 % confidence it is not above that */
    double cpu_seconds; /* that the estimate took */
    bool measured_known;
    double measured;    /* with the matched reference, its noise subtracted */
} sl_bench_promise;

/* A pass of the method, or what lies between passes. */
typedef struct sl_bench_part {
    char name[64];
    double share; /* of the processor time of a picture */
} sl_bench_part;

enum {
    SL_BENCH_PARTS = 12,
    SL_BENCH_NAME = 80,
    SL_BENCH_PATHS = 128,
    SL_BENCH_ARGUMENTS = 400,
    SL_BENCH_PATH = 1024
};

/* One setting of one method. */
typedef struct sl_bench_row {
    char method[SL_BENCH_NAME], curve[SL_BENCH_NAME], name[SL_BENCH_NAME];
    char transport[SL_BENCH_PATHS]; /* the light paths that are its own truth */
    char arguments[SL_BENCH_ARGUMENTS]; /* of softlux render: the same picture again */
    sl_bench_quality quality;
    int table; /* of its trials' file; -1: none */
    sl_bench_end end;
    char why[256];             /* where it did not run to its end */
    /* seconds until the picture was there, reading the scene not included; cpu: of all threads */
    sl_bench_spread cpu, wall;
    double first_picture;      /* processor seconds until a first picture could be shown; 0: not looked at */
    uint64_t peak_bytes, method_bytes; /* of the whole process; of what the method tells of itself */
    uint64_t rays, shadow_rays, records, samples, fragments;
    sl_bench_error error[SL_BENCH_TRUTHS];
    sl_bench_promise promise;
    char picture[SL_BENCH_PATH];
    char *difference; /* against the matched reference, as a PNG in base 64; or NULL */
    size_t part_count;
    sl_bench_part parts[SL_BENCH_PARTS];
} sl_bench_row;

/* A picture by the path tracer, and how far it can be trusted. */
typedef struct sl_bench_reference {
    char transport[SL_BENCH_PATHS];
    char file[SL_BENCH_PATH];
    uint64_t samples; /* a pixel */
    uint64_t pairs;   /* of chunks */
    double seconds;   /* of all processors, in all runs that made it */
    double noise;     /* relative RMSE */
    double wanted;    /* a tenth of the smallest error that is told with it; 0: nothing was */
    double doubt;     /* of that error, as a share of it */
    char trouble[256]; /* why there is none, or no more of it; or "" */
    double energy;    /* its mean over that of full global illumination; 0: not known */
    double missing;   /* its relative RMSE against full global illumination; 0: not known */
    bool missing_known;
    char *difference; /* against full global illumination, as a PNG in base 64; or NULL */
} sl_bench_reference;

typedef struct sl_bench_scene {
    char path[SL_BENCH_PATH], name[SL_BENCH_NAME];
    char hash[17];
    int width, height;
    uint64_t triangles, pixels_compared;
    bool glossy, mirrors; /* there are such surfaces */
    bool sky;
    sl_auto_kind kind;    /* where its light comes from */
    bool kind_known;
    char trouble[1200]; /* why nothing could be measured; or "" */
    size_t row_count, reference_count;
    sl_bench_row *rows;
    sl_bench_reference *references;
    char *picture; /* the full reference as a PNG in base 64; or NULL */
} sl_bench_scene;

typedef struct sl_trials sl_trials;
typedef struct sl_bench_results {
    const sl_trials *trials;
    char version[32], machine[128], date[32];
    int processors, threads, repeats;
    /* a fixed amount of arithmetic, seconds by the clock, again and again between the trials */
    sl_bench_spread calibration;
    double unrest;               /* half the distance of its quartiles over its median */
    double unrest_cpu;           /* the same by the processor's time */
    double share_of_processor;   /* that the arithmetic had: less where others took turns */
    bool noisy, interrupted;
    size_t scene_count;
    sl_bench_scene *scenes;
} sl_bench_results;

void sl_bench_results_free(sl_bench_results *results);
/* Sorts the values. */
sl_bench_spread sl_bench_spread_of(double *values, int count);
/* Half the distance of the quartiles over the median; 0 of fewer than four. Sorts the values. */
double sl_bench_unrest_of(double *values, int count);
/* Of the rows of one method, or NULL: of all: how many promise a bound that could be checked, how many of
 * those keep it, and how far above the measured error the bounds are, in the middle. */
typedef struct sl_bench_kept {
    int made, kept;
    double slack;
} sl_bench_kept;
sl_bench_kept sl_bench_promises(const sl_bench_results *results, const char *method);
const char *sl_bench_truth_name(sl_bench_truth truth);
const char *sl_bench_quality_name(sl_bench_quality quality);
const char *sl_bench_end_name(sl_bench_end end);

#endif
