/* A view at rest: error over shaded points, and over time (the paper's figure of diffuse interreflection:
 * what the RenderCache has after 120 s the shading cache has after 10). The same sample renderers for both,
 * the same points a batch; beside them the path tracer, pixel by pixel.
 *
 * Errors are those of displayed grey levels (RMS) against what the renderers say of each pixel: what both
 * caches approach; how far that is from the path tracer's picture bench/shading-cache.trials tells. The sweep
 * of the non-matching ratio (pixels a frame / points a second, in seconds) is read off the same curves: the
 * error after ten seconds. */
#include <math.h>
#include <stdlib.h>

#include "cache/shading_cache/plan.h"
#include "shading_bench.h"
#include "timing.h"

enum { POINTS = 128 };
typedef struct series {
    size_t count;
    struct {
        double spent, error; /* RMS levels */
    } point[POINTS];
} series;

typedef struct curve {
    series by_points, by_time; /* spent: points, or seconds */
} curve;

/* Returns what is spent at an error, or the error at what is spent: log-log between neighbours, never beyond
 * the ends (then 0). */
static double between(const series *s, double at, bool spent_wanted) {
    for (size_t i = 0; i + 1 < s->count; i++) {
        double spent0 = s->point[i].spent, spent1 = s->point[i + 1].spent, error0 = s->point[i].error,
               error1 = s->point[i + 1].error;
        double x0 = spent_wanted ? error0 : spent0, x1 = spent_wanted ? error1 : spent1,
               y0 = spent_wanted ? spent0 : error0, y1 = spent_wanted ? spent1 : error1;
        if ((at - x0) * (at - x1) > 0.0 || x0 == x1) continue;
        return exp(log(y0) + (log(y1) - log(y0)) * (log(at) - log(x0)) / (log(x1) - log(x0)));
    }
    return 0.0;
}

static void add_point(series *s, double spent, double error) {
    if (s->count == POINTS) return;
    s->point[s->count].spent = spent;
    s->point[s->count++].error = error;
}

static void add(curve *c, double points, double seconds, double error) {
    add_point(&c->by_points, points, error);
    add_point(&c->by_time, seconds, error);
}

/* Errors are looked at whenever there are a fifth more points than the last time. */
static bool is_due(double *next, double points) {
    if (points < *next) return false;
    *next = 1.2 * points;
    return true;
}

static void run_cache(shading_world *w, double most, curve *c) {
    shading_run run;
    double next = 1.0;
    shading_run_open(&run, w, NULL);
    for (double points = 0.0; points < most;) {
        shading_run_update(&run);
        double before = points;
        points = (double)shading_run_points(&run);
        if (is_due(&next, points)) add(c, points, run.seconds, shading_run_error(&run));
        if (points == before) break; /* nothing left to refine */
    }
    shading_run_close(&run);
}

/* Both fills have the same points. */
static void run_rival(shading_world *w, double most, curve *narrow,
                      curve *wide) {
    render_cache *cache = shading_rival(w, w->settings.shading_cache.points);
    sl_counters counters = {{0}};
    double next = 1.0, spent = 0.0;
    for (double points = 0.0; points < most;) {
        double from = process_ms();
        render_cache_frame(cache, &counters);
        spent += 1e-3 * (process_ms() - from);
        points = (double)render_cache_samples(cache);
        if (!is_due(&next, points)) continue;
        add(narrow, points, spent, shading_rival_error(w, cache, false));
        add(wide, points, spent, shading_rival_error(w, cache, true));
    }
    render_cache_destroy(cache);
}

static void run_path(shading_world *w, const bench_options *o, curve *c) {
    for (uint32_t samples = 1; samples <= (o->brief ? 4 : 64); samples *= 4) {
        double seconds;
        double error = shading_path_error(w, samples, &seconds);
        add(c, (double)samples, seconds, error);
    }
}

static double first_points(const series *s, double error) {
    for (size_t i = 0; i < s->count; i++)
        if (s->point[i].error <= error) return s->point[i].spent;
    return 0.0;
}

static void text_of(double value, char text[24]) {
    if (value > 0.0) snprintf(text, 24, "%.3g", value);
    else snprintf(text, 24, "-");
}

/* Points and seconds to the errors that the cache has at some of its points. */
static void equal_quality(const shading_world *w, curve curves[4]) {
    static const double shares[] = {0.005, 0.01, 0.029, 0.1};
    double pixels = (double)w->settings.width * (double)w->settings.height;
    bench_table(
        "scene|>points / pixel|>points|>RMS levels|>RenderCache needs|>times|>wide fill needs|>times|>cache "
                "s|>RenderCache s|>times|>path tracer s|>times");
    for (int i = 0; i < 4; i++) {
        double points = shares[i] * pixels, error = between(&curves[0].by_points, points, false);
        if (!(error > 0.0)) continue;
        double needs[2], seconds[4];
        for (int k = 0; k < 2; k++) needs[k] = first_points(&curves[1 + k].by_points, error);
        seconds[0] = between(&curves[0].by_time, error, true);
        seconds[1] = first_points(&curves[1].by_time, error);
        seconds[3] = between(&curves[3].by_time, error, true);
        char text[7][24];
        text_of(needs[0], text[0]), text_of(needs[0] / points, text[1]), text_of(needs[1], text[2]),
            text_of(needs[1] / points, text[3]);
        text_of(seconds[1], text[4]), text_of(seconds[0] > 0.0 ? seconds[1] / seconds[0] : 0.0, text[5]),
            text_of(seconds[3], text[6]);
        bench_row("%s|%.4f|%.0f|%.2f|%s|%s|%s|%s|%.2f|%s|%s|%s|%.3g", w->name, shares[i], points, error,
                  text[0], text[1], text[2], text[3], seconds[0], text[4], text[5], text[6],
                  seconds[0] > 0.0 ? seconds[3] / seconds[0] : 0.0);
    }
}

static void ratios(const shading_world *w, curve curves[4]) {
    static const double nmrs[] = {10, 30, 100, 300, 1000, 2500};
    double pixels = (double)w->settings.width * (double)w->settings.height;
    bench_table("scene|>NMR s|>points in 10 s|>cache RMS levels|>RenderCache|>wide fill");
    for (int i = 0; i < 6; i++) {
        double points = 10.0 * pixels / nmrs[i];
        char text[3][24];
        for (int k = 0; k < 3; k++) {
            const series *s = &curves[k].by_points;
            double last = s->count ? s->point[s->count - 1].spent : 0.0;
            text_of(points >= last && points < 1.2 * last ? s->point[s->count - 1].error
                                                          : between(s, points, false),
                    text[k]);
        }
        bench_row("%s|%.0f|%.0f|%s|%s|%s", w->name, nmrs[i], points, text[0], text[1], text[2]);
    }
}

static void experiment(const bench_options *o, const char *path) {
    shading_world w;
    static curve curves[4];
    int size = 512;
    if (!shading_open(o, path, size, 0, o->brief ? 25 : 400, &w)) return;
    shading_judge(&w, o->brief ? 16 : 8);
    printf("\n%s, %d x %d, %d paths and %d light samples a point, %zu pixels judged.\n", w.name, size,
              size, w.settings.shading_cache.indirect_samples, w.settings.shading_cache.area_samples,
              w.pixels.count);
    for (int i = 0; i < 4; i++) curves[i].by_points.count = curves[i].by_time.count = 0;
    double pixels = (double)size * (double)size;
    run_cache(&w, (o->brief ? 0.06 : 0.15) * pixels, &curves[0]);
    run_rival(&w, (o->brief ? 0.12 : 0.5) * pixels, &curves[1], &curves[2]);
    run_path(&w, o, &curves[3]);
    equal_quality(&w, curves);
    ratios(&w, curves);
    shading_close(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv);
    experiment(&o, "scenes/generated/study.json");
    experiment(&o, "scenes/generated/loft.json");
    experiment(&o, "scenes/generated/pool.json");
    return 0;
}
