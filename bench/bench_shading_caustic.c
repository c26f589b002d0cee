/* A caustic that moves (the paper's last figure: a ring is moved, and five seconds later its caustic is where
 * it belongs): the cache with a renderer for caustics, a photon map of its own that is made anew after the
 * move, beside the cache whose bidirectional paths have to find them, at equal points and at equal time.
 *
 * Errors are of displayed grey levels (RMS) against the bidirectional path tracer's picture, of all pixels
 * that are judged, and of those in the caustic: where it makes the picture brighter by some levels. */
#include <stdlib.h>
#include <string.h>

#include "cache/shading_cache/plan.h"
#include "shading_bench.h"
#include "timing.h"

enum { SIZE = 256, BLOCK = 2, BRIGHTER = 8, MARKS = 4 };

/* Pixels that are judged, and what is right there. */
typedef struct judges {
    bench_pixels pixels;
    bench_reference truth;
} judges;

static const char path[] = "scenes/generated/ring.json";

/* ---- what is right ---- */

static sl_image *true_picture(const shading_world *w, uint32_t samples) {
    sl_settings s = sl_settings_default();
    sl_method *method;
    sl_progress progress = {0};
    sl_image *image;
    sl_error error;
    s.method = "bidirectional";
    s.transport = "matched:shading-cache";
    s.width = s.height = SIZE;
    s.threads = 1;
    s.spp = samples;
    /* at centres alone its light subpaths reach no pixel, and caustics want those */
    s.filter = SL_FILTER_BOX;
    s.shading_cache = w->settings.shading_cache;
    if (sl_method_create(w->scene, &s, &method, &error) != SL_OK) bench_fail("bidirectional", &error);
    while (!progress.done)
        if (sl_method_update(method, &progress, &error) != SL_OK) bench_fail("bidirectional", &error);
    if (sl_method_resolve(method, &image, &error) != SL_OK) bench_fail("bidirectional", &error);
    sl_method_destroy(method);
    return image;
}

/* In place of what the renderers say: from the disk if it is there. */
static void judge_by_paths(shading_world *w, uint32_t samples) {
    size_t count = w->pixels.count, plane = (size_t)SIZE * SIZE;
    uint64_t what[] = {sl_scene_hash(w->scene), SIZE, BLOCK, samples,
                       (uint64_t)w->settings.shading_cache.path_depth};
    uint64_t hash = bench_hash(17, what, sizeof what);
    float *values = w->limit.half[0];
    if (bench_store_load("caustic", hash, 3 * count, values)) return;
    sl_image *image = true_picture(w, samples);
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 3; k++) values[3 * i + k] = image->planes[k * plane + w->pixels.index[i]];
    sl_image_destroy(image);
    bench_store_save("caustic", hash, 3 * count, values);
}

static float level(const shading_world *w, const float *rgb) {
    return sl_curve_level(&w->display, (sl_rgb){rgb[0], rgb[1], rgb[2]});
}

/* Of those that the world judges the ones that are brighter than without caustics. */
static judges in_the_caustic(const shading_world *w, const float *without) {
    size_t count = w->pixels.count;
    judges j = {.pixels = w->pixels, .truth = w->limit};
    j.pixels.index = calloc(count, sizeof *j.pixels.index);
    j.truth.half[0] = calloc(3 * count, sizeof(float));
    if (!j.pixels.index || !j.truth.half[0]) bench_fail("pixels", NULL);
    j.pixels.count = 0;
    for (size_t i = 0; i < count; i++) {
        if (level(w, &w->limit.half[0][3 * i]) < level(w, without + 3 * i) + (float)BRIGHTER) continue;
        memcpy(&j.truth.half[0][3 * j.pixels.count], &w->limit.half[0][3 * i], 3 * sizeof(float));
        j.pixels.index[j.pixels.count++] = w->pixels.index[i];
    }
    j.truth.half[1] = j.truth.half[0];
    return j;
}

/* Those of the world where the ring is now; the others, in the caustic, are the caller's. */
static judges judge(shading_world *w, uint32_t samples) {
    shading_judge(w, BLOCK);
    float *without = calloc(3 * w->pixels.count, sizeof *without);
    if (!without) bench_fail("pixels", NULL);
    shading_limit_without_caustics(w, without);
    judge_by_paths(w, samples);
    judges caustic = in_the_caustic(w, without);
    free(without);
    return caustic;
}

static double error_of(shading_world *w, const judges *j, const float *planes) {
    judges all = {w->pixels, w->limit};
    w->pixels = j->pixels;
    w->limit = j->truth;
    double error = shading_error(w, planes);
    w->pixels = all.pixels;
    w->limit = all.truth;
    return error;
}

/* ---- the move ---- */

typedef struct errors {
    double all, caustic;
} errors;

static errors look(shading_world *w, shading_run *run, const judges *caustic) {
    sl_image *image;
    sl_error error;
    if (sl_method_resolve(run->method, &image, &error) != SL_OK) bench_fail("picture", &error);
    errors e = {shading_error(w, image->planes), error_of(w, caustic, image->planes)};
    sl_image_destroy(image);
    return e;
}

typedef struct variant {
    const char *name;
    int paths;
    bool caustics;
} variant;

/* Errors right after the move, after so many points since then, and after five seconds of one thread, what
 * the edit takes included. */
static void row(bench_report *r, const bench_options *o, const variant *v) {
    static const double marks[MARKS] = {500, 1500, 5000, 15000};
    shading_world w;
    shading_run run;
    char text[MARKS + 1][48];
    int wanted = o->brief ? MARKS - 1 : MARKS;
    if (!shading_open(r, o, path, SIZE, v->paths, &w)) return;
    w.settings.shading_cache.caustics = v->caustics;
    shading_move(&w, 0.0);
    shading_run_open(&run, &w, NULL, false);
    for (int i = 0; i < (o->brief ? 60 : 200); i++) shading_run_update(&run);
    unsigned changes = shading_move(&w, 1.0);
    judges caustic = judge(&w, o->brief ? 64 : 1024);
    double from = process_ms();
    shading_run_edit(&run, changes);
    double edit = 1e-3 * (process_ms() - from), before = run.seconds,
           points = (double)shading_run_points(&run), updates = (double)run.updates;
    errors moved = look(&w, &run, &caustic);
    for (int k = 0; k <= MARKS; k++) snprintf(text[k], sizeof text[k], "-|-");
    bool timed = false;
    for (int next = 0; next < wanted || (!timed && !o->brief);) {
        shading_run_update(&run);
        double done = (double)shading_run_points(&run) - points, seconds = edit + run.seconds - before;
        errors e = {0, 0};
        if ((next < wanted && done >= marks[next]) || (!timed && seconds >= 5.0))
            e = look(&w, &run, &caustic);
        if (next < wanted && done >= marks[next])
            snprintf(text[next++], sizeof text[0], "%.1f|%.1f", e.all, e.caustic);
        if (!timed && seconds >= 5.0)
            snprintf(text[MARKS], sizeof text[0], "%.1f|%.1f", e.all, e.caustic), timed = true;
        if ((double)run.updates - updates > 5000.0) break;
    }
    double done = (double)shading_run_points(&run) - points;
    bench_row(r, "%s|%.2f|%.2f|%zu|%.1f|%.1f|%s|%s|%s|%s|%s", v->name, 1e3 * (run.seconds - before) / done,
              edit, caustic.pixels.count, moved.all, moved.caustic, text[0], text[1], text[2], text[3],
              text[4]);
    if (o->pictures)
        shading_run_picture(&run, r, v->caustics ? "with-caustics" : v->paths > 400 ? "many-paths" : "paths");
    free(caustic.pixels.index);
    free(caustic.truth.half[0]);
    shading_run_close(&run);
    shading_close(&w);
}

int main(int argc, char **argv) {
    static const variant variants[] = {{"caustic renderer, 100 paths", 100, true},
                                       {"caustic renderer, 400 paths", 400, true},
                                       {"100 paths", 100, false},
                                       {"400 paths", 400, false}};
    bench_options o = bench_options_parse(argc, argv, "build/shading-cache");
    bench_report r;
    bench_report_open(&r, &o, "shading_caustic");
    bench_say(&r,
              "\nA polished ring is moved after %d updates; %d x %d, RMS in grey levels, of all pixels "
              "judged and of those in the caustic. Points and seconds (of one thread, the edit with\n"
              "its new photons included) are counted from the move.\n",
              o.brief ? 60 : 200, SIZE, SIZE);
    bench_table(&r, "caustic",
                "who finds caustics|ms a point|edit s|pixels in it|moved: all|in it|500 points: all|in "
                "it|1,500: all|in it|5,000: all|in it|15,000: all|in it|5 s: all|in it");
    for (size_t i = 0; i < sizeof variants / sizeof variants[0]; i++) row(&r, &o, &variants[i]);
    bench_report_close(&r);
    return 0;
}
