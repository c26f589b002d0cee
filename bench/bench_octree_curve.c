/* Time to an error: the light octree over photons, neighbours and depths; its photon map shown directly, by a
 * gather for each pixel; the path tracer on the same paths. All in one run, on the same pixels, in processor
 * seconds of one thread with all that indirect light takes: Embree's hierarchy, photons, octree, G-buffer,
 * pixels. A second view costs the octree its pixels alone, the others all of a gather or all paths. */
#include <stdlib.h>
#include <string.h>

#include "octree_bench.h"
#include "timing.h"

typedef struct world {
    octree_world judged;
    bench_pixels all;           /* a quarter of all, with which gathers are timed */
    float *all_values;
} world;

static bool open_world(bench_report *r, const bench_options *o, const char *path, world *w) {
    memset(w, 0, sizeof *w);
    if (!octree_world_open(r, o, path, &w->judged)) return false;
    const octree_view *view = &w->judged.view;
    bench_pixels_make(view->scene, view->tracer, w->judged.pixels.width, w->judged.pixels.height, 2, &w->all);
    w->all_values = calloc(3 * w->all.count + 1, sizeof(float));
    if (!w->all_values) bench_fail("values", NULL);
    return true;
}

static void close_world(world *w) {
    free(w->all_values);
    bench_pixels_free(&w->all);
    octree_world_close(&w->judged);
}

static void add(bench_series *s, const octree_world *w, double seconds, const char *what) {
    bench_error e = bench_compare(w->values[0], &w->reference, NULL);
    bench_point *p = &s->point[s->count++];
    *p = (bench_point){.seconds = seconds, .rel_mse = e.rel_mse};
    snprintf(p->what, sizeof p->what, "%.52s%s", what, e.noisy ? " (noise)" : "");
}

/* ---- the octree, and its photons shown directly ---- */

static const uint64_t maps[] = {40000, 150000, 600000, 2400000};
static const int ks[] = {30, 100, 300};

static void with_map(const bench_options *o, world *all, uint64_t photons, bench_series *octrees,
                     bench_series *direct) {
    octree_world *w = &all->judged;
    sl_light_octree_settings s = octree_settings();
    sl_counters counters = {{0}};
    double traced[2], voxels, before = w->view.embree + w->view.gbuffer_seconds;
    char what[64];
    s.photons = photons;
    sl_photon_tree *tree = octree_photons(w->view.scene, w->view.tracer, &s, 0, 1, traced, &counters);
    before += traced[0] + traced[1];
    for (s.depth = 4; s.depth <= 6; s.depth++) {
        sl_octree *octree = octree_voxels(w->view.scene, s.depth, 1, &voxels);
        for (int k = 0; k < 3; k += o->brief ? 2 : 1) {
            s.neighbours = ks[k];
            octree_picture picture = octree_world_picture(w, octree, tree, &s, 1, w->values[0]);
            snprintf(what, sizeof what, "%uk photons, k %d, depth %d", (unsigned)(photons / 1000),
                     s.neighbours, s.depth);
            add(octrees, w, before + voxels + picture.seconds, what);
            if (s.depth < 6) continue;
            octree_direct(&w->view, &w->pixels, octree, tree, &s, OCTREE_AT_PIXEL, w->values[0]);
            double gathers =
                4.0 * octree_direct(&w->view, &all->all, octree, tree, &s, OCTREE_AT_PIXEL, all->all_values);
            snprintf(what, sizeof what, "%uk photons, k %d", (unsigned)(photons / 1000), s.neighbours);
            add(direct, w, before + voxels + gathers, what); /* its areas need the octree too */
        }
        sl_octree_destroy(octree);
    }
    sl_photon_tree_destroy(tree);
}

/* ---- the path tracer ---- */

/* One run, judged whenever its samples have doubled. */
static void run_path_tracer(const bench_options *o, octree_world *w, bench_series *path) {
    sl_settings settings = sl_settings_default();
    sl_method *method;
    sl_image *image;
    sl_error error;
    settings.method = "path";
    settings.transport = "matched:light-octree";
    settings.light_octree.indirect_only = true;
    settings.width = w->pixels.width;
    settings.height = w->pixels.height;
    settings.spp = o->brief ? 16 : 128;
    settings.seed = 99;
    settings.threads = 1;
    double spent = 0.0, from = octree_seconds(1);
    if (sl_method_create(w->view.scene, &settings, &method, &error) != SL_OK)
        bench_fail("path tracer", &error);
    spent += octree_seconds(1) - from;
    for (uint32_t n = 1; n <= settings.spp; n++) {
        sl_progress progress = {0};
        char what[64];
        from = octree_seconds(1);
        if (sl_method_update(method, &progress, &error) != SL_OK) bench_fail("path tracer", &error);
        spent += octree_seconds(1) - from;
        if (n & (n - 1)) continue;
        if (sl_method_resolve(method, &image, &error) != SL_OK ||
            !bench_pick(image, NULL, &w->pixels, w->values[0]))
            bench_fail("path tracer", &error);
        snprintf(what, sizeof what, "%u samples", (unsigned)n);
        add(path, w, spent, what);
        sl_image_destroy(image);
    }
    sl_method_destroy(method);
    /* One more point: the reference's own noise is the path tracer's error at so many samples, and its time
     * grows with them. */
    bench_point *last = &path->point[path->count++];
    *last = (bench_point){.seconds = spent * (double)w->reference.samples / (double)settings.spp,
                          .rel_mse = bench_compare(w->values[0], &w->reference, NULL).noise};
    snprintf(last->what, sizeof last->what, "%u samples, by noise", (unsigned)w->reference.samples);
}

/* ---- first pictures ---- */

typedef struct stopwatch {
    double from, shown[8];
    int count;
} stopwatch;

static void pass_done(void *context, const sl_pass *pass) {
    stopwatch *w = context;
    if (strncmp(pass->name, "indirect light, depth", 21) == 0 && w->count < 8)
        w->shown[w->count++] = 1e-3 * wall_ms() - w->from;
}

/* By a clock, with all threads, as a person waits; direct light included. */
static void progressive(const octree_world *w, char *text, size_t size) {
    stopwatch watch = {.from = 1e-3 * wall_ms()};
    sl_observer observer = {&watch, pass_done};
    sl_settings settings = sl_settings_default();
    sl_progress progress = {0};
    sl_method *method;
    sl_error error;
    settings.method = "light-octree";
    settings.light_octree.depth = octree_settings().depth;
    settings.width = settings.height = 512;
    settings.observer = &observer;
    if (sl_method_create(w->view.scene, &settings, &method, &error) != SL_OK)
        bench_fail("light octree", &error);
    while (!progress.done) {
        if (sl_method_update(method, &progress, &error) != SL_OK) bench_fail("light octree", &error);
    }
    sl_method_destroy(method);
    int at = snprintf(text, size,
                      "512 x 512 with 16 light samples, 600,000 photons, all threads, by a clock: shown");
    for (int i = 0; i < watch.count; i++)
        at += snprintf(text + at, size - (size_t)at, "%s after %.1f s at depth %d", i ? "," : "",
                       watch.shown[i], 4 + i);
}

/* ---- the experiment ---- */

static const char *ratio(double value, char text[24]) {
    text[0] = '\0';
    if (value > 0.0) snprintf(text, 24, "%.1f", value);
    return text;
}

static void rows(bench_report *r, const char *scene, const char *method, const bench_series *s,
                 const bench_series *direct, const bench_series *path) {
    for (size_t i = 0; i < s->count; i++) {
        const bench_point *p = &s->point[i];
        char by_path[24], by_direct[24];
        bench_row(r, "%s|%s|%s|%.2f|%.2e|%s|%s", scene, method, p->what, p->seconds, p->rel_mse,
                  path ? ratio(bench_between(path, p->rel_mse, true) / p->seconds, by_path) : "",
                  direct ? ratio(bench_between(direct, p->rel_mse, true) / p->seconds, by_direct) : "");
    }
}

static void experiment(bench_report *r, const bench_options *o, const char *path_name) {
    static bench_series series[6];
    static world w;
    char text[400];
    if (!open_world(r, o, path_name, &w)) return;
    bench_series *octrees = &series[0], *directs = &series[1], *octree = &series[2], *direct = &series[3],
                 *path = &series[4];
    memset(series, 0, sizeof series);
    for (size_t m = 0; m < sizeof maps / sizeof *maps - (o->brief ? 2 : 0); m++)
        with_map(o, &w, maps[m], octrees, directs);
    run_path_tracer(o, &w.judged, path);
    *octree = bench_envelope(octrees);
    *direct = bench_envelope(directs);
    octrees->color = "#9bd", directs->color = "#9d9";
    octree->name = "light octree", octree->color = "#06c", octree->line = true;
    direct->name = "photons gathered at pixels", direct->color = "#080", direct->line = true;
    path->name = "path tracer, same paths", path->color = "#c40", path->line = true;
    bench_say(r,
              "\n%s, %d x %d, %u reference samples. *by paths*, *by photons*: seconds that the path tracer, "
              "and photons gathered at pixels, take for the same\n"
              "error, over these; empty beyond what they were tried with.\n",
              w.judged.name, w.judged.pixels.width, w.judged.pixels.height, w.judged.reference.samples);
    bench_table(r, w.judged.name, "scene|method|with|cpu s|relMSE|by paths|by photons");
    rows(r, w.judged.name, "octree", octree, direct, path);
    rows(r, w.judged.name, "photons", direct, NULL, path);
    rows(r, w.judged.name, "paths", path, NULL, NULL);
    bench_draw_curves(r, w.judged.name, series, 5);
    progressive(&w.judged, text, sizeof text);
    bench_say(r, "\n%s: %s.\n\n![time to an error, %s](pictures/octree_curve-%s.svg)\n", w.judged.name, text,
              w.judged.name, w.judged.name);
    close_world(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/light-octree");
    bench_report r;
    bench_report_open(&r, &o, "octree_curve");
    experiment(&r, &o, "scenes/cornell.json");
    if (!o.brief || o.only) {
        experiment(&r, &o, "scenes/generated/room.json");
        experiment(&r, &o, "scenes/generated/atrium.json");
        experiment(&r, &o, "scenes/generated/cathedral.json");
    }
    bench_report_close(&r);
    return 0;
}
