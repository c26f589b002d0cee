/* Speed against error: splatting over accuracy and size of gathers, its lower left envelope, and the path
 * tracer on the same paths. Where does the cache win, and where does it stop? Both are measured in one run,
 * on the same pixels, in processor seconds of one thread with all that a picture takes (hierarchy and tables
 * included, reading the scene not). Drawn as SVG, both axes logarithmic. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cache/splatting/plan.h"
#include "splat_bench.h"
#include "timing.h"

enum { CURVE_MAX = 128 };

typedef struct trial {
    double seconds, rel_mse, noise, rel_rmse;
    bool noisy;
    double accuracy;
    int gather;
    uint32_t samples;
    size_t records;
} trial;

typedef struct curve {
    size_t count;
    trial trials[CURVE_MAX];
} curve;

typedef struct world {
    sl_scene *scene;
    sl_tracer *tracer;
    bench_pixels pixels;
    bench_reference reference;
    float *values;
    int size;
} world;

/* ---- the world ---- */

static bool open_world(bench_report *r, const bench_options *o, const char *path, int size, world *w) {
    sl_settings settings = sl_settings_default();
    sl_transport direct, indirect;
    bench_reference parts[2];
    sl_error error;
    uint32_t samples = !o->brief ? 16384 : o->size ? 8192 : 1024;
    *w = (world){.size = o->size ? o->size : o->brief ? size / 4 : size};
    if (!bench_open_scene(r, path, &w->scene)) return false;
    if (sl_tracer_create(w->scene, 2, NULL, &w->tracer, &error) != SL_OK) bench_fail("tracer", &error);
    bench_pixels_make(w->scene, w->tracer, w->size, w->size, o->brief ? 5 : 20, &w->pixels);
    w->values = calloc(3 * w->pixels.count + 1, sizeof(float));
    sl_splat_transport(&settings, &indirect);
    direct = indirect;
    direct.receiver_lobes = 0;
    indirect.emission = false;
    indirect.direct_lobes = 0;
    bench_reference_get(w->scene, w->tracer, &direct, &w->pixels, samples, &parts[0]);
    bench_reference_get(w->scene, w->tracer, &indirect, &w->pixels, samples, &parts[1]);
    bench_reference_sum(&parts[0], &parts[1], &w->reference);
    for (int i = 0; i < 2; i++) bench_reference_free(&parts[i]);
    return true;
}

static void close_world(world *w) {
    free(w->values);
    bench_reference_free(&w->reference);
    bench_pixels_free(&w->pixels);
    sl_tracer_destroy(w->tracer);
    sl_scene_destroy(w->scene);
}

static void judge(world *w, const sl_image *image, trial *t) {
    bench_pick(image, NULL, &w->pixels, w->values);
    bench_error e = bench_compare(w->values, &w->reference, NULL);
    t->rel_mse = e.rel_mse;
    t->rel_rmse = e.rel_rmse;
    t->noise = e.noise;
    t->noisy = e.noisy;
}

/* ---- the two methods ---- */

/* Light samples grow as the records do, or one of the two would bear all of the error. */
static const struct {
    double accuracy;
    uint32_t samples;
} steps[] = {{0.7, 2}, {0.7, 4}, {0.5, 8}, {0.35, 16}, {0.25, 16}, {0.15, 32}, {0.1, 64}, {0.05, 128}};
static const int gathers[] = {16, 28, 48};
enum { RUNGS = sizeof steps / sizeof *steps, GATHERS = sizeof gathers / sizeof *gathers };

static void run_splatting(const bench_options *o, world *w, curve *c) {
    for (int a = 0; a < RUNGS; a += o->brief ? 3 : 1) {
        for (int g = 0; g < GATHERS; g += o->brief ? 2 : 1) {
            sl_settings settings = sl_settings_default();
            splat_run run;
            settings.method = "splatting";
            settings.width = settings.height = w->size;
            settings.quality = steps[a].accuracy < 0.3 ? SL_QUALITY_HIGH : SL_QUALITY_NORMAL;
            settings.accuracy = steps[a].accuracy;
            settings.gather_size = gathers[g];
            settings.spp = steps[a].samples;
            splat_render(w->scene, &settings, true, &run);
            trial *t = &c->trials[c->count++];
            *t = (trial){.seconds = run.cpu_all, .accuracy = steps[a].accuracy, .gather = gathers[g],
                         .samples = steps[a].samples, .records = run.records[0] + run.records[1]};
            judge(w, run.image, t);
            splat_run_free(&run);
        }
    }
}

/* One run, judged whenever its samples have doubled; with one thread. */
static void run_path_tracer(const bench_options *o, world *w, uint32_t samples, curve *c) {
    sl_settings settings = sl_settings_default();
    sl_method *method;
    sl_image *image;
    sl_error error;
    settings.method = "path";
    settings.transport = "matched:splatting";
    settings.width = settings.height = w->size;
    settings.spp = o->brief ? 32 : samples;
    settings.seed = 99;
    settings.threads = 1;
    double spent = 0.0, from = process_ms();
    if (sl_method_create(w->scene, &settings, &method, &error) != SL_OK) bench_fail("path tracer", &error);
    spent += process_ms() - from;
    for (uint32_t n = 1; n <= settings.spp; n++) {
        sl_progress progress = {0};
        from = process_ms();
        if (sl_method_update(method, &progress, &error) != SL_OK) bench_fail("path tracer", &error);
        spent += process_ms() - from;
            if (n & (n - 1)) continue;
        if (sl_method_resolve(method, &image, &error) != SL_OK) bench_fail("path tracer", &error);
        trial *t = &c->trials[c->count++];
        *t = (trial){.seconds = 1e-3 * spent, .samples = n};
        judge(w, image, t);
        sl_image_destroy(image);
    }
    /* One more point: the reference's own noise is the path tracer's error at so many samples, and its time
     * grows with them. */
    trial last = c->trials[c->count - 1];
    last.seconds *= (double)w->reference.samples / (double)last.samples;
    last.samples = w->reference.samples;
    last.rel_mse = last.noise;
    last.rel_rmse = 0.0;
    c->trials[c->count++] = last;
    sl_method_destroy(method);
}

/* ---- envelope and ratios ---- */

static int by_seconds(const void *a, const void *b) {
    double x = ((const trial *)a)->seconds, y = ((const trial *)b)->seconds;
    return (x > y) - (x < y);
}

/* Those than which none is both faster and better. */
static curve envelope_of(const curve *all) {
    curve sorted = *all, e = {0};
    qsort(sorted.trials, sorted.count, sizeof *sorted.trials, by_seconds);
    for (size_t i = 0; i < sorted.count; i++) {
        if (e.count && sorted.trials[i].rel_mse >= e.trials[e.count - 1].rel_mse) continue;
        if (sorted.trials[i].rel_mse > 0.0) e.trials[e.count++] = sorted.trials[i];
    }
    return e;
}

static bench_series series_of(const curve *c, const char *name, const char *color, bool line) {
    bench_series s = {.name = name, .color = color, .line = line};
    for (size_t i = 0; i < c->count; i++)
        s.point[s.count++] = (bench_point){.seconds = c->trials[i].seconds, .rel_mse = c->trials[i].rel_mse};
    return s;
}

static double between(const curve *c, double at, bool seconds_wanted) {
    bench_series s = series_of(c, NULL, NULL, false);
    return bench_between(&s, at, seconds_wanted);
}

static const char *ratio_text(double ratio, char text[24]) {
    text[0] = '\0';
    if (ratio > 0.0) snprintf(text, 24, "%.1f", ratio);
    return text;
}

static void envelope_rows(bench_report *r, const char *scene, const curve *envelope, const curve *path) {
    for (size_t i = 0; i < envelope->count; i++) {
        const trial *t = &envelope->trials[i];
        double same_error = between(path, t->rel_mse, true), same_time = between(path, t->seconds, false);
        char faster[24], better[24];
        bench_row(r,
                  t->noisy ? "%s|%g|%d|%u|%zu|%.2f|%.2f|(%.2e)|%.0e|%s|%s"
                           : "%s|%g|%d|%u|%zu|%.2f|%.2f|%.2e|%.0e|%s|%s",
                  scene, t->accuracy, t->gather, t->samples, t->records, t->seconds, 100.0 * t->rel_rmse,
                  t->rel_mse, t->noise, ratio_text(same_error / t->seconds, faster),
                  ratio_text(same_time / t->rel_mse, better));
    }
}

static void path_rows(bench_report *r, const char *scene, const curve *path) {
    for (size_t i = 0; i < path->count; i++) {
        const trial *t = &path->trials[i];
        bench_row(r, "%s|path||%u||%.2f|%.2f|%.2e|%.0e||", scene, t->samples, t->seconds, 100.0 * t->rel_rmse,
                  t->rel_mse, t->noise);
    }
}

static void all_rows(const bench_report *r, const char *scene, const curve *cache, const curve *path) {
    char file_name[700];
    snprintf(file_name, sizeof file_name, "%s/curve-%s-all.csv", r->folder, scene);
    FILE *file = fopen(file_name, "w");
    if (!file) return;
    fprintf(file, "method,accuracy,gather,samples,records,cpu s,relRMSE,relMSE,noise\n");
    for (int m = 0; m < 2; m++) {
        const curve *c = m ? path : cache;
        for (size_t i = 0; i < c->count; i++) {
            const trial *t = &c->trials[i];
            fprintf(file, "%s,%g,%d,%u,%zu,%.4f,%.6f,%.4e,%.2e\n", m ? "path" : "splatting", t->accuracy,
                    t->gather, t->samples, t->records, t->seconds, t->rel_rmse, t->rel_mse, t->noise);
        }
    }
    fclose(file);
}

static void draw(const bench_report *r, const char *scene, const curve *cache, const curve *envelope,
                 const curve *path) {
    static bench_series series[3];
    series[0] = series_of(cache, NULL, "#9bd", false);
    series[1] = series_of(envelope, "radiance cache splatting", "#06c", true);
    series[2] = series_of(path, "path tracer, same paths", "#c40", true);
    bench_draw_curves(r, scene, series, 3);
}

/* ---- the experiment ---- */

static void say_where_it_ends(bench_report *r, const char *scene, const curve *envelope, const curve *path) {
    double most = 0.0, last = 0.0;
    for (size_t i = 0; i < envelope->count; i++) {
        double ratio = between(path, envelope->trials[i].rel_mse, true) / envelope->trials[i].seconds;
        if (ratio > most) most = ratio;
        if (ratio > 1.0) last = envelope->trials[i].rel_mse;
    }
    const trial *best = envelope->count ? &envelope->trials[envelope->count - 1] : NULL;
    if (!best) return;
    bench_say(r,
              "\n%s: at equal error up to %.1f times as fast as the path tracer; ahead at least down to "
              "relMSE %.1e; best reached %.1e in %.1f s\n",
              scene, most, last, best->rel_mse, best->seconds);
}

static void experiment(bench_report *r, const bench_options *o, const char *path_name, int size,
                       uint32_t samples) {
    char scene[64];
    world w;
    bench_scene_name(path_name, scene);
    if (!bench_wants(o, scene) || !open_world(r, o, path_name, size, &w)) return;
    curve *cache = calloc(3, sizeof *cache), *path = cache + 1, *envelope = cache + 2;
    if (!cache) bench_fail("curves", NULL);
    run_splatting(o, &w, cache);
    run_path_tracer(o, &w, samples, path);
    *envelope = envelope_of(cache);
    bench_say(r, "\n%s, %d x %d, %u reference samples\n", scene, w.size, w.size, w.reference.samples);
    bench_table(r, scene, "scene|a|N|light spp|records|cpu s|relRMSE %|relMSE|noise|faster|better");
    envelope_rows(r, scene, envelope, path);
    path_rows(r, scene, path);
    all_rows(r, scene, cache, path);
    draw(r, scene, cache, envelope, path);
    say_where_it_ends(r, scene, envelope, path);
    bench_say(r, "\n![speed against error, %s](pictures/curve-%s.svg)\n", scene, scene);
    free(cache);
    close_world(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/splatting");
    bench_report r;
    bench_report_open(&r, &o, "curve");
    bench_say(&r, "\nThe envelope over accuracy, gathers and light samples, and the path tracer on the same "
                  "paths. *faster*: the path tracer's seconds at\n"
                  "equal error over these; *better*: its squared error at equal time over this; empty beyond "
                  "its measured range.\n");
    experiment(&r, &o, "scenes/cornell.json", 512, 128);
    experiment(&r, &o, "scenes/generated/cathedral.json", 512, 128);
    experiment(&r, &o, "scenes/generated/atrium.json", 512, 128);
    experiment(&r, &o, "scenes/generated/room.json", 512, 128);
    experiment(&r, &o, "bench/scenes/sponza.json", 512, 128);
    bench_report_close(&r);
    return 0;
}
