/* The paper's tables 1 and 2: what an update consists of, with one thread and with two; how fast frames are
 * drawn while shading lags behind; and memory a patch. The paper's processors took 611, 490 and 506 ms of an
 * update of 70, 72 and 61 points for shading, and 9.5, 7.4 and 5.1 % of it for all else; frames came at 45,
 * 60 and 40 a second. Points as in the paper: 100 samples a light, 400 indirect paths. */
#include <stdlib.h>
#include <string.h>

#include "shading_bench.h"
#include "timing.h"

static const char *const paths[3] = {"scenes/generated/study.json", "scenes/generated/loft.json",
                                     "scenes/generated/pool.json"};

static double ms_of(const shading_run *run, const char *stage) {
    for (int i = 0; i < SHADING_STAGES && run->stage[i].name; i++)
        if (strcmp(run->stage[i].name, stage) == 0) return run->stage[i].ms;
    return 0.0;
}

static void forget_times(shading_run *run) {
    memset(run->stage, 0, sizeof run->stage);
    run->seconds = run->wall = 0.0;
}

static void resolve_once(shading_run *run) {
    sl_image *image;
    sl_error error;
    if (sl_method_resolve(run->method, &image, &error) != SL_OK) bench_fail("picture", &error);
    sl_image_destroy(image);
}

/* Median of the times of some frames, by a clock. */
static double frame_ms(shading_run *run, double (*clock)(void)) {
    enum { FRAMES = 9 };
    double ms[FRAMES];
    for (int i = 0; i < FRAMES; i++) {
        double from = clock();
        resolve_once(run);
        ms[i] = clock() - from;
    }
    return median(ms, FRAMES);
}

static void updates_row(bench_report *r, const bench_options *o, const char *path, int early, int count) {
    shading_world w;
    shading_run run;
    if (!shading_open(r, o, path, 512, o->brief ? 100 : 400, &w)) return;
    w.settings.shading_cache.area = SL_AREA_SAMPLED;
    w.settings.shading_cache.area_samples = 100;
    shading_run_open(&run, &w, NULL, true);
    for (int i = 0; i < early; i++) shading_run_update(&run);
    forget_times(&run);
    uint64_t points = shading_run_points(&run);
    for (int i = 0; i < count; i++) shading_run_update(&run);
    points = shading_run_points(&run) - points;
    double total = 1e3 * run.seconds / count, stage[6];
    static const char *const names[6] = {"id map",   "priorities", "selection",
                                         "requests", "samples",    "commit"};
    for (int k = 0; k < 6; k++) stage[k] = ms_of(&run, names[k]) / count;
    double arrays = ms_of(&run, "display arrays") / count, frame = frame_ms(&run, process_ms);
    bench_row(r, "%s|%d|%.0f|%.2f|%.2f|%.2f|%.2f|%.1f|%.2f|%.2f|%.1f|%.1f|%.2f|%.0f", w.name, early,
              (double)points / count, stage[0], stage[1], stage[2], stage[3], stage[4], stage[5], arrays,
              total, 100.0 * (total - stage[4]) / total, frame, 1e3 / frame);
    shading_run_close(&run);
    shading_close(&w);
}

static void table_1(bench_report *r, const bench_options *o) {
    bench_say(r,
              "\nTable 1: an update with one thread, milliseconds of processor time; 512 x 512, %d paths a "
              "point. *other*: what is not samples, in %% of all. Frames: what the\n"
              "display costs at that state, and frames a second were that all. Priorities include the "
              "picture of them that is made for whoever watches.\n",
              o->brief ? 100 : 400);
    bench_table(r, "1",
                "scene|after updates|points|id map|priorities|selection|requests|samples|commit|display "
                "arrays|all|other %|frame ms|frames/s");
    for (int i = 0; i < 3; i++) {
        updates_row(r, o, paths[i], 3, o->brief ? 5 : 20);
        updates_row(r, o, paths[i], o->brief ? 40 : 200, o->brief ? 5 : 20);
    }
}

static void table_2(bench_report *r, const bench_options *o) {
    bench_say(r, "\nTable 2: the same update by the clock, with one thread and with two (the paper: with one "
                 "client and with eight). On a machine that is busy with other things this\n"
                 "says little.\n");
    bench_table(
        r, "2",
        "scene|points|one thread ms|two threads ms|faster|processor ms, two threads|frame ms|two threads");
    for (int i = 0; i < 3; i++) {
        shading_world w;
        double wall[2], spent = 0.0, frame[2], points = 0.0;
        int count = o->brief ? 5 : 20;
        if (!shading_open(r, o, paths[i], 512, o->brief ? 100 : 400, &w)) continue;
        for (unsigned t = 1; t <= 2; t++) {
            shading_run run;
            w.settings.threads = t;
            shading_run_open(&run, &w, NULL, false);
            for (int k = 0; k < 3; k++) shading_run_update(&run);
            forget_times(&run);
            points = -(double)shading_run_points(&run);
            for (int k = 0; k < count; k++) shading_run_update(&run);
            points = (points + (double)shading_run_points(&run)) / count;
            wall[t - 1] = 1e3 * run.wall / count;
            spent = 1e3 * run.seconds / count;
            frame[t - 1] = frame_ms(&run, wall_ms);
            shading_run_close(&run);
        }
        bench_row(r, "%s|%.0f|%.1f|%.1f|%.2f|%.1f|%.1f|%.1f", w.name, points, wall[0], wall[1],
                  wall[0] / wall[1], spent, frame[0], frame[1]);
        shading_close(&w);
    }
}

static double patches_of(const shading_run *run) {
    const sl_counters *c = sl_method_counters(run->method);
    return 4.0 * (double)c->value[SL_COUNT_SPLITS] - (double)c->value[SL_COUNT_PATCHES_EVICTED];
}

/* Everything that stands for the scene itself is there: its primitives' patches and vertices, in both copies
 * of the display (each edit of the camera makes the other one), and the list of those that are seen. The
 * first update asks for corners and splits nothing. */
static double bytes_of_the_scene(shading_run *run) {
    resolve_once(run);
    shading_run_edit(run, SL_CHANGED_CAMERA);
    shading_run_update(run);
    if (patches_of(run) > 0.0) bench_fail("splits in the first update", NULL);
    return (double)sl_method_memory_bytes(run->method);
}

/* Direct light by one sample: patches are made as fast as can be. */
static void memory_rows(bench_report *r, const bench_options *o, const char *path) {
    static const double wanted[] = {5000, 20000, 80000, 300000};
    shading_world w;
    shading_run run;
    size_t next = 0, stuck = 0;
    if (!shading_open(r, o, path, 512, 0, &w)) return;
    w.settings.shading_cache.area_samples = 1;
    w.settings.shading_cache.points = 512;
    shading_run_open(&run, &w, NULL, false);
    double start = bytes_of_the_scene(&run);
    for (double last = 0.0; next < (o->brief ? 2u : 4u) && stuck < 50;) {
        shading_run_update(&run);
        double patches = patches_of(&run);
        stuck = patches > last ? 0 : stuck + 1;
        last = patches;
        if (patches < wanted[next]) continue;
        double bytes = (double)sl_method_memory_bytes(run.method) - start, frame = frame_ms(&run, process_ms);
        bench_row(r, "%s|%.0f|%llu|%.2f|%.2f|%.1f|%.1f|%.0f", w.name, patches,
                  (unsigned long long)shading_run_points(&run), start / 1048576.0, bytes / 1048576.0,
                  bytes / patches, frame, 1e3 / frame);
        next++;
    }
    shading_run_close(&run);
    shading_close(&w);
}

static void memory(bench_report *r, const bench_options *o) {
    bench_say(r, "\nMemory beyond that of the scene's own primitives, per patch that splits made: all that "
                 "grows with them, both display copies and the list of visible leaves included\n"
                 "(paper: below 200 bytes, 20,000 patches). *scene*: MiB for rays, primitives, pixels, and "
                 "what stands for each primitive before any split.\n");
    bench_table(r, "memory", "scene|patches|points|scene MiB|patches MiB|bytes a patch|frame ms|frames/s");
    for (int i = 0; i < 3; i++) memory_rows(r, o, paths[i]);
}

/* What a view that rests comes to hold, and an eye that walks: patches that splits have made, and those of
 * them that are seen (paper: 20,000, beyond the geometry). */
static void walk_rows(bench_report *r, const bench_options *o, const char *path) {
    shading_world w;
    shading_run run;
    int rest = o->brief ? 60 : 300, steps = o->brief ? 16 : 64;
    if (!shading_open(r, o, path, 512, o->brief ? 0 : 25, &w)) return;
    shading_run_open(&run, &w, NULL, false);
    for (int i = 0; i < rest; i++) shading_run_update(&run);
    for (int i = 0; i <= 3 * steps; i++) {
        if (i % (steps / 2) == 0) {
            const char *when = i == 0 ? "rests" : i <= steps ? "walks" : "rests again";
            bench_row(r, "%s|%s|%llu|%llu|%.0f|%.2f", w.name, when, (unsigned long long)run.updates,
                      (unsigned long long)shading_run_points(&run), patches_of(&run),
                      (double)sl_method_memory_bytes(run.method) / 1048576.0);
        }
        if (i < steps) shading_run_edit(&run, shading_move(&w, 2.0 * (double)(i + 1) / (double)steps));
        shading_run_update(&run);
    }
    shading_run_close(&run);
    shading_close(&w);
}

static void walks(bench_report *r, const bench_options *o) {
    bench_say(r, "\nPatches that splits have made, at rest and while the eye walks (paper: 20,000 as a "
                 "rule). *MiB*: all that the cache takes, scene and display included.\n");
    bench_table(r, "walks", "scene|when|updates|points|patches|MiB");
    walk_rows(r, o, "scenes/generated/study-walk.json");
    walk_rows(r, o, "scenes/generated/pool-walk.json");
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/shading-cache");
    bench_report r;
    bench_report_open(&r, &o, "shading_tables");
    memory(&r, &o);
    walks(&r, &o);
    table_1(&r, &o);
    table_2(&r, &o);
    bench_report_close(&r);
    return 0;
}
