/* A picture, with the seconds of its parts. Which part an update of the method was is told by what it counted. */
#include <stdlib.h>
#include <string.h>

#include "splat_bench.h"
#include "timing.h"

const char *const splat_part_names[SPLAT_PARTS] = {"setup", "G-buffer", "direct", "records", "splats", "compose"};

typedef struct stopwatch {
    double cpu, wall;
} stopwatch;

static stopwatch start(void) { return (stopwatch){process_ms(), wall_ms()}; }

static void charge(splat_run *run, int part, stopwatch from) {
    run->cpu[part] += 1e-3 * (process_ms() - from.cpu);
    run->wall[part] += 1e-3 * (wall_ms() - from.wall);
}

static int part_of_update(const sl_counters *before, const sl_counters *after, bool first, bool gathered) {
    if (after->value[SL_COUNT_SPLATS] > before->value[SL_COUNT_SPLATS]) return SPLAT_SPLATS;
    if (gathered) return SPLAT_RECORDS; /* also visits of covered pixels, and neighbour clamping */
    return first ? SPLAT_GBUFFER : SPLAT_DIRECT;
}

static void render_once(const sl_scene *scene, const sl_settings *settings, splat_run *run) {
    sl_method *method;
    sl_error error;
    sl_image *again;
    bool tracer = strcmp(settings->method, "path") == 0, first = true, gathered = tracer;
    memset(run, 0, sizeof *run);
    stopwatch watch = start();
    if (sl_method_create(scene, settings, &method, &error) != SL_OK) splat_stop("method", &error);
    charge(run, SPLAT_SETUP, watch);
    for (sl_progress progress = {0}; !progress.done; first = false) {
        sl_counters before = *sl_method_counters(method);
        watch = start();
        if (sl_method_update(method, &progress, &error) != SL_OK) splat_stop("update", &error);
        const sl_counters *after = sl_method_counters(method);
        if (after->value[SL_COUNT_GATHERS] > before.value[SL_COUNT_GATHERS]) gathered = true;
        charge(run, part_of_update(&before, after, first, gathered), watch);
    }
    watch = start();
    if (sl_method_resolve(method, &run->image, &error) != SL_OK) splat_stop("resolve", &error);
    charge(run, SPLAT_SPLATS, watch);
    run->counters = *sl_method_counters(method);
    /* What a second resolve takes is the composition alone: nothing new is splatted. */
    watch = start();
    if (sl_method_resolve(method, &again, &error) != SL_OK) splat_stop("resolve", &error);
    charge(run, SPLAT_COMPOSE, watch);
    sl_image_destroy(again);
    sl_method_destroy(method);
    run->cpu[SPLAT_SPLATS] = fmax(0.0, run->cpu[SPLAT_SPLATS] - run->cpu[SPLAT_COMPOSE]);
    run->wall[SPLAT_SPLATS] = fmax(0.0, run->wall[SPLAT_SPLATS] - run->wall[SPLAT_COMPOSE]);
    for (int part = 0; part < SPLAT_PARTS; part++) {
        run->cpu_all += run->cpu[part];
        run->wall_all += run->wall[part];
    }
}

static int by_cpu(const void *a, const void *b) {
    double x = ((const splat_run *)a)->cpu_all, y = ((const splat_run *)b)->cpu_all;
    return (x > y) - (x < y);
}

void splat_render(const sl_scene *scene, const sl_settings *settings, int runs, splat_run *run) {
    splat_run *all = calloc((size_t)runs, sizeof *all);
    if (!all) splat_stop("runs", NULL);
    for (int i = 0; i < runs; i++) render_once(scene, settings, &all[i]);
    qsort(all, (size_t)runs, sizeof *all, by_cpu);
    for (int i = 0; i < runs; i++) {
        if (i != runs / 2) splat_run_free(&all[i]);
    }
    *run = all[runs / 2];
    free(all);
}

void splat_run_free(splat_run *run) {
    sl_image_destroy(run->image);
    run->image = NULL;
}

bool splat_pick(const sl_image *image, const char *prefix, const splat_pixels *pixels, float *values) {
    for (size_t c = 0; c < 3; c++) {
        char name[SL_CHANNEL_NAME_MAX];
        snprintf(name, sizeof name, "%s%s%c", prefix ? prefix : "", prefix ? "." : "", "RGB"[c]);
        const float *plane = sl_image_channel(image, name);
        if (!plane) return false;
        for (size_t i = 0; i < pixels->count; i++) values[3 * i + c] = plane[pixels->index[i]];
    }
    return true;
}
