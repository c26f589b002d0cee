/* Speed against error from the first picture on: direct diffuse, direct specular and indirect light apart and
 * together, and the path tracer on the same paths; and what the heap gains over the paper's random chain,
 * over samples. A picture is judged whenever half as much time more has gone by; its time is that of all
 * updates before it and of drawing it once. Processor time of one thread.
 *
 *     build/bench/bench_mesh_curve [--brief|--once] [--only SCENE] [--pictures] [--out FOLDER] */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mesh_bench.h"

static const char *const quality_names[] = {"draft", "normal", "high"};

static void add(bench_series *s, double seconds, double error, const char *what) {
    if (s->count == BENCH_POINTS) return;
    bench_point *p = &s->point[s->count++];
    *p = (bench_point){.seconds = seconds, .rel_mse = error};
    snprintf(p->what, sizeof p->what, "%.60s", what);
}

/* ---- the method from its first picture on ---- */

typedef struct progress {
    bench_series part[MESH_PARTS];   /* over seconds */
    bench_series samples;            /* all, over samples: of direct light that took a picture, and gathers */
    double trimmed[BENCH_POINTS];    /* of all: without the largest 0.1 % of the terms */
} progress;

static void judge(const mesh_world *w, mesh_run *run, progress *p) {
    char what[64];
    double picture;
    bench_error e[MESH_PARTS];
    sl_image *image = mesh_run_picture(run, &picture);
    mesh_judge(w, image, e);
    sl_image_destroy(image);
    uint64_t gathers = mesh_run_count(run, SL_COUNT_INDIRECT_SAMPLES),
             direct = mesh_run_count(run, SL_COUNT_LIGHT_SAMPLES);
    snprintf(what, sizeof what, "%llu + %llu samples", (unsigned long long)direct,
             (unsigned long long)gathers);
    if (p->samples.count < BENCH_POINTS) p->trimmed[p->samples.count] = e[MESH_ALL].trimmed;
    for (int part = 0; part < MESH_PARTS; part++)
        add(&p->part[part], run->seconds + picture, e[part].rel_mse, what);
    add(&p->samples, (double)(direct + gathers), e[MESH_ALL].rel_mse, what);
}

static void run_method(const bench_report *r, const bench_options *o, const mesh_world *w, sl_quality quality,
                       sl_mesh_selection selection, progress *p) {
    sl_settings s = mesh_settings(w, quality);
    mesh_run run;
    double next = 0.0;
    memset(p, 0, sizeof *p);
    s.multi_mesh.selection = selection;
    mesh_run_open(&run, w->scene, &s);
    while (!run.done) {
        mesh_run_step(&run);
        if (run.seconds < next || mesh_run_count(&run, SL_COUNT_LIGHT_SAMPLES) == 0) continue;
        judge(w, &run, p);
        next = 1.5 * run.seconds;
    }
    judge(w, &run, p);
    if (o->pictures && selection == SL_SELECT_HEAP) {
        sl_image *image = mesh_run_picture(&run, NULL);
        bench_write_picture(r, w->name, quality_names[quality], image);
        sl_image_destroy(image);
    }
    mesh_run_close(&run);
}

/* ---- the path tracer ---- */

static void run_paths(const bench_report *r, const bench_options *o, const mesh_world *w, double until,
                      bench_series *s, double trimmed[BENCH_POINTS]) {
    sl_settings settings = mesh_settings(w, SL_QUALITY_NORMAL);
    sl_method *method;
    sl_image *image = NULL;
    sl_error error;
    bench_error e[MESH_PARTS];
    settings.method = "path";
    settings.transport = "matched:multi-mesh";
    settings.spp = 1u << 20;
    settings.seed = 99;
    double from = mesh_seconds(1), spent;
    if (sl_method_create(w->scene, &settings, &method, &error) != SL_OK) bench_fail("path tracer", &error);
    spent = mesh_seconds(1) - from;
    for (uint32_t n = 1, next = 1; spent < until; n++) {
        sl_progress told = {0};
        char what[64];
        from = mesh_seconds(1);
        if (sl_method_update(method, &told, &error) != SL_OK) bench_fail("path tracer", &error);
        spent += mesh_seconds(1) - from;
        if (n < next && spent < until) continue;
        next = 2 * n;
        sl_image_destroy(image);
        if (sl_method_resolve(method, &image, &error) != SL_OK) bench_fail("path tracer", &error);
        mesh_pick(w, image, MESH_ALL, w->values);
        e[MESH_ALL] = bench_compare(w->values, &w->reference[MESH_ALL], NULL);
        snprintf(what, sizeof what, "%u paths a pixel", (unsigned)n);
        if (s->count < BENCH_POINTS) trimmed[s->count] = e[MESH_ALL].trimmed;
        add(s, spent, e[MESH_ALL].rel_mse, what);
    }
    /* One more point: the reference's own noise is the path tracer's error at so many paths, and its time
     * grows with them. */
    double paths = atof(s->point[s->count - 1].what), samples = (double)w->reference[MESH_ALL].samples;
    if (samples > paths) {
        char what[64];
        snprintf(what, sizeof what, "%.0f paths, by noise", samples);
        if (s->count < BENCH_POINTS) trimmed[s->count] = 0.0;
        add(s, spent * samples / paths, bench_compare(w->values, &w->reference[MESH_ALL], NULL).noise, what);
    }
    if (o->pictures && image) bench_write_picture(r, w->name, "paths", image);
    sl_image_destroy(image);
    sl_method_destroy(method);
}

/* ---- a scene ---- */

static void say_progress(bench_report *r, const char *name, const char *with, const progress *p,
                         const bench_series *paths) {
    const bench_series *all = &p->part[MESH_ALL];
    for (size_t i = 0; i < all->count; i++) {
        const bench_point *at = &all->point[i];
        char slower[32] = "", error[32] = "";
        double other = at->rel_mse > 0.0 ? bench_between(paths, at->rel_mse, true) : 0.0,
               same_time = bench_between(paths, at->seconds, false);
        if (other > 0.0) snprintf(slower, sizeof slower, "%.1f", other / at->seconds);
        if (same_time > 0.0) snprintf(error, sizeof error, "%.2e", same_time);
        bench_row(r, "%s|%s|%s|%.2f|%.2e|%.2e|%.2e|%.2e|%.2e|%s|%s", name, with, at->what, at->seconds,
                  at->rel_mse, p->trimmed[i], p->part[MESH_DIRECT].point[i].rel_mse,
                  p->part[MESH_SPECULAR].point[i].rel_mse, p->part[MESH_INDIRECT].point[i].rel_mse, error,
                  slower);
    }
}

/* Where one series has an error, samples of another at the same. */
static void say_chain(bench_report *r, const char *name, const bench_series *heap,
                      const bench_series *chain) {
    char text[1200];
    int at = snprintf(text, sizeof text,
                      "\n%s, samples that the chain takes over those of the heap, for the error that the "
                      "heap has after so many:",
                      name);
    for (size_t i = 0; i < heap->count && at < (int)sizeof text - 80; i += 2) {
        double same = bench_between(chain, heap->point[i].rel_mse, true);
        if (same > 0.0)
            at += snprintf(text + at, sizeof text - (size_t)at, " %.0f: %.2f;", heap->point[i].seconds,
                           same / heap->point[i].seconds);
    }
    text[at - 1] = '.';
    bench_say(r, "%s\n", text);
}

static void experiment(bench_report *r, const bench_options *o, const char *path, int width, int height) {
    static progress by_quality[3], chain;
    static bench_series series[MESH_PARTS + 3], paths;
    static double trimmed[BENCH_POINTS];
    static const char *const colours[MESH_PARTS] = {"#c80", "#808", "#080", "#06c"};
    mesh_world w;
    char name[64];
    bench_scene_name(path, name);
    if (!bench_wants(o, name)) return;
    if (o->brief) width /= 4, height /= 4;
    if (!mesh_world_open(r, path, width, height, o->brief ? 4 : 8, o->brief ? 256 : 4096, &w)) return;
    memset(&paths, 0, sizeof paths);
    size_t count = 0;
    for (int q = 0; q < 3; q++) run_method(r, o, &w, (sl_quality)q, SL_SELECT_HEAP, &by_quality[q]);
    run_method(r, o, &w, SL_QUALITY_NORMAL, SL_SELECT_CHAIN, &chain);
    const bench_series *high = &by_quality[2].part[MESH_ALL];
    run_paths(r, o, &w, high->point[high->count - 1].seconds, &paths, trimmed);
    bench_say(r,
              "\n%s, %d x %d, %u reference samples at %zu pixels. *direct*, *specular*, *indirect*: their "
              "shares of relMSE, relative to the whole "
              "picture. *paths*: the path tracer's error in the same time; *slower*: how many times as long "
              "it takes to the same error.\n",
              w.name, width, height, w.reference[MESH_ALL].samples, w.pixels.count);
    bench_table(r, w.name,
                "scene|with|after|s|relMSE|without the largest 0.1 %|direct|specular|indirect|paths|slower");
    for (int q = 0; q < 3; q++) say_progress(r, w.name, quality_names[q], &by_quality[q], &paths);
    for (size_t i = 0; i < paths.count; i++) {
        char most[32] = "";
        if (trimmed[i] > 0.0) snprintf(most, sizeof most, "%.2e", trimmed[i]);
        bench_row(r, "%s|paths|%s|%.2f|%.2e|%s|||||", w.name, paths.point[i].what, paths.point[i].seconds,
                  paths.point[i].rel_mse, most);
    }
    for (int part = 0; part < MESH_PARTS; part++) {
        if (!w.has[part]) continue;
        series[count] = by_quality[1].part[part];
        series[count].name = mesh_part_names[part], series[count].color = colours[part],
        series[count++].line = true;
    }
    for (int q = 0; q < 3; q += 2) {
        series[count] = by_quality[q].part[MESH_ALL];
        series[count].name = q ? "all, high" : "all, draft", series[count].color = q ? "#013" : "#9bd",
        series[count++].line = true;
    }
    series[count] = paths;
    series[count].name = "path tracer, same paths", series[count].color = "#c40", series[count++].line = true;
    bench_draw_curves(r, w.name, series, count);
    bench_say(r, "\n![time to an error, %s](pictures/mesh_curve-%s.svg)\n", w.name, w.name);
    say_chain(r, w.name, &by_quality[1].samples, &chain.samples);
    mesh_world_close(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/multi-mesh");
    bench_report r;
    bench_report_open(&r, &o, "mesh_curve");
    experiment(&r, &o, "scenes/cornell.json", 512, 512);
    experiment(&r, &o, "scenes/cornell-glossy.json", 512, 512);
    if (!o.brief || o.only) experiment(&r, &o, "scenes/generated/room.json", 640, 480);
    bench_report_close(&r);
    return 0;
}
