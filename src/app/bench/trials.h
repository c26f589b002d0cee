/* The trials to be run: every method over its three qualities, and over finer and coarser settings that make
 * a curve of time against error (ladder.trials); or the trials of a file (bench/METHOD.trials), with the
 * tables that it asks for. */
#pragma once

#include "app/bench/child.h"
#include "cache/frame/settings.h"

/* The light paths of the reference that a picture is compared with. */
typedef enum sl_bench_truth {
    /* the light paths that the method itself declares: what is wrong is the method's own error */
    SL_BENCH_MATCHED,
    SL_BENCH_ONE_BOUNCE, /* direct light and one diffuse bounce */
    SL_BENCH_FULL,       /* all of global illumination */
    SL_BENCH_TRUTHS
} sl_bench_truth;

enum { SL_BENCH_NAME = 80, SL_BENCH_PATHS = 128, SL_BENCH_ARGUMENTS = 400, SL_BENCH_PATH = 1024 };

typedef struct sl_trial {
    char method[SL_BENCH_NAME], curve[SL_BENCH_NAME], name[SL_BENCH_NAME];
    char arguments[SL_BENCH_ARGUMENTS]; /* of softlux render: what makes this picture, size and file apart */
    char transport[SL_BENCH_PATHS];     /* the paths that are its own truth */
    const char *quality; /* draft, normal, high, whose name it has; or curve: what lies between and beyond */
    const char *scenes; /* that it is run with, with spaces between; NULL: all */
    int table;          /* -1: none */
    int rank;           /* in its curve */
    bool ordered;       /* its curve's trials before it take less time */
    bool look;          /* once more with an observer, for the parts of its time and for a first picture */
} sl_trial;

/* A table that a file of trials asks for, as Markdown: a row for each of its trials in each scene. */
typedef struct sl_trial_table {
    char name[SL_BENCH_NAME];
    const char *columns; /* with commas between (cells.c) */
} sl_trial_table;

enum { SL_TRIAL_TABLES = 32 };
typedef struct sl_trials {
    size_t count, table_count;
    sl_trial *trial; /* a method after the other, in each from cheap to dear */
    sl_trial_table table[SL_TRIAL_TABLES];
    bool truth[SL_BENCH_TRUTHS]; /* that errors are told against */
    const char *base;            /* what all trials and references are given, before their own */
    bool estimates;              /* errors are also told without a reference */
    int width, height;           /* 0: as the scenes say */
    char *text;                  /* of the file */
} sl_trials;

/* Reads those of a file, or with NULL the ladder of all methods. A line that means nothing is an error that
 * names it. */
sl_status sl_trials_read(const char *path, sl_trials *trials, sl_error *error);
void sl_trials_free(sl_trials *trials);
const char *sl_bench_truth_name(sl_bench_truth truth);

typedef struct sl_trial_run {
    const char *arguments, *scene_path;
    int width, height;
    unsigned threads; /* where the arguments name none */
    /* not for the clock: with an observer, for the parts of the time and for the first picture */
    bool look;
    bool estimate;       /* tell the picture's error, too, after the clock has stopped */
    const char *picture; /* EXR to write; or NULL */
    sl_load_options load;
} sl_trial_run;

/* In a child: runs an sl_trial_run and reports a JSON object: cpu_seconds, wall_seconds, peak_bytes,
 * method_bytes, and the picture's metadata; of a look first_picture and parts; of an estimate that could be
 * made estimate and bound. The picture's metadata tell the seconds of the processor. */
sl_child_work sl_trial_work;
#define SL_TRIAL_SECONDS "softlux.cpu_seconds"
/* Finds the settings that the arguments mean; false: they are wrong, which has been told. */
bool sl_trial_settings(const char *arguments, sl_settings *settings);
