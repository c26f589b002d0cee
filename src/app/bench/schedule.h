/* A scene's trials: in which order they run, and what of them has been measured already. */
#pragma once

#include "app/bench/journal.h"
#include "app/bench/results.h"
#include "app/clock.h"

#include <stdio.h>

typedef struct sl_bench_options {
    const sl_trials *trials;          /* that are to be run */
    const char *folder;               /* of the report */
    sl_journal *journal;              /* what was measured */
    const char *references;           /* folder */
    const char *methods, *qualities;  /* lists with commas between, or NULL: all */
    bool own_scenes;                  /* not those of the trials' file */
    int size[2];                      /* 0: as the scene says, made small */
    uint64_t repeats;
    /* seconds: of a trial; of processor time of each reference. 0: none */
    double limit, reference_budget;
    uint64_t memory_megabytes;        /* of one trial; 0: none */
    uint64_t threads, reference_threads; /* 0: all processors */
    bool quiet;
    bool report_only; /* no trial is run: the journal is taken as it is */
    bool trials_only; /* no errors, no report */
    sl_load_options load;
    char program[17]; /* the fingerprint of what measures, or measured */
} sl_bench_options;

/* Reads the scene, in a child since that may start threads, and finds what is in it. What cannot be read says
 * so in its `trouble`; a usage error where the report would take the place of one of its files. */
sl_status sl_bench_scene_read(const sl_bench_options *options, const char *path, sl_bench_scene *scene,
                              sl_error *error);
/* Runs what the journal does not hold yet. Returns when all is done, or somebody interrupts. */
sl_status sl_schedule_run(const sl_bench_options *options, const sl_bench_scene *scene, sl_error *error);
/* Makes the rows of the scene from what the journal holds of it. */
sl_status sl_schedule_rows(const sl_bench_options *options, sl_bench_scene *scene, sl_error *error);
