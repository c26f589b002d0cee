/* What the five experiments on radiance cache splatting share beside common.h: a picture, with the seconds of
 * each of its parts. */
#ifndef SL_BENCH_SPLAT_H
#define SL_BENCH_SPLAT_H

#include "cache/splatting/splatting.h"
#include "common.h"

/* Records and splats stand for each class of receivers: + SL_RECEIVES_IRRADIANCE, + SL_RECEIVES_RADIANCE. */
enum {
    SPLAT_SETUP,
    SPLAT_GBUFFER,
    SPLAT_DIRECT,
    SPLAT_RECORDS,
    SPLAT_SPLATS = SPLAT_RECORDS + SL_RECEIVER_CLASSES,
    SPLAT_COMPOSE = SPLAT_SPLATS + SL_RECEIVER_CLASSES,
    SPLAT_PARTS
};

typedef struct splat_run {
    double cpu[SPLAT_PARTS], cpu_all; /* processor seconds of one thread */
    double wall_one, wall_two;        /* seconds by a clock with one thread and with two (0: not measured) */
    size_t records[SL_RECEIVER_CLASSES], receivers; /* receivers: pixels that records light */
    sl_counters counters;
    sl_image *image;
} splat_run;

/* Splatting. Processor time is that of one thread: two would be charged for waiting for each other too. The
 * run of the median of three, or fewer where they take long; the clock's seconds likewise. once: one run with
 * one thread. */
void splat_render(const sl_scene *scene, const sl_settings *settings, bool once, splat_run *run);
void splat_run_free(splat_run *run);
/* settings with nothing left to quality, scene or machine, as sl_method_create() makes them. */
sl_settings splat_settings_complete(const sl_scene *scene, const sl_settings *settings);

#endif
