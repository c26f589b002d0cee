/* What is run: every method over its three qualities, and over finer and coarser settings that make a curve
 * of time against error. */
#ifndef SL_APP_BENCH_TRIALS_H
#define SL_APP_BENCH_TRIALS_H

#include "app/bench/child.h"
#include "app/bench/results.h"

typedef struct sl_trial {
    const char *method, *curve, *name;
    const char *arguments; /* of softlux render: what makes this picture, size, threads and file apart */
    const char *transport; /* the paths that are its own truth */
    sl_bench_quality quality;
} sl_trial;

/* All trials, a method after the other, in each from cheap to dear; NULL past the end. */
const sl_trial *sl_trial_at(size_t index);

typedef struct sl_trial_run {
    const sl_trial *trial;
    const char *scene_path;
    int width, height;
    unsigned threads;
    /* not for the clock: with an observer, for the parts of the time and for the first picture */
    bool look;
    const char *picture; /* EXR to write; or NULL */
    sl_load_options load;
} sl_trial_run;

/* In a child: runs the trial of an sl_trial_run and reports a JSON object: cpu_seconds, wall_seconds,
 * peak_bytes, method_bytes, batches, counters; of a look first_picture and parts. */
sl_child_work sl_trial_work;
/* The settings that the arguments mean; false: they are wrong, which is a mistake of the table. */
bool sl_trial_settings(const char *arguments, sl_settings *settings);

#endif
