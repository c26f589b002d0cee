/* What each part of the choice of pixels buys: the cache without one of them at a time, error over points in
 * a view at rest. (What the resolution drop and ageing buy shows where something moves:
 * bench_shading_moving.c.) Errors are those of displayed grey levels (RMS) against what the renderers say of
 * each pixel. */
#include <math.h>
#include <stdlib.h>

#include "shading_bench.h"

typedef struct variant {
    const char *name;
    void (*set)(sl_shading_cache_settings *c);
} variant;

static void as_it_is(sl_shading_cache_settings *c) { (void)c; }
static void without_flood(sl_shading_cache_settings *c) { c->no_flood = true; }
static void without_random(sl_shading_cache_settings *c) { c->no_random = true; }
static void hits_alone(sl_shading_cache_settings *c) { c->no_flood = c->no_random = true; }
static void plain(sl_shading_cache_settings *c) { c->plain_normalisation = true; }
static void sorted(sl_shading_cache_settings *c) { c->selection = SL_PIXELS_SORTED; }
static void systematic(sl_shading_cache_settings *c) { c->selection = SL_PIXELS_SYSTEMATIC; }
static void variance(sl_shading_cache_settings *c) { c->variance_aware = true; }

static const variant variants[] = {
    {"hit-and-test, random share, flood fill", as_it_is},
    {"no flood fill", without_flood},
    {"no random share", without_random},
    {"neither: hits alone", hits_alone},
    {"mean +- 4 sigma as printed", plain},
    {"highest priority first", sorted},
    {"systematic", systematic},
    {"variance-aware", variance},
};

enum { MARKS = 5 };
static const double marks[MARKS] = {0.0025, 0.005, 0.01, 0.02, 0.04}; /* points a pixel */

static void row(bench_report *r, shading_world *w, const variant *v, int used) {
    shading_run run;
    sl_settings s = w->settings;
    char text[MARKS][16];
    double pixels = (double)s.width * (double)s.height;
    v->set(&s.shading_cache);
    shading_run_open(&run, w, &s, false);
    for (int k = 0; k < MARKS; k++) {
        snprintf(text[k], sizeof text[k], "-");
        uint64_t before = UINT64_MAX;
        for (int idle = 0; k < used && (double)shading_run_points(&run) < marks[k] * pixels && idle < 100;) {
            shading_run_update(&run);
            idle = shading_run_points(&run) == before ? idle + 1 : 0;
            before = shading_run_points(&run);
        }
        if (k < used && (double)shading_run_points(&run) >= marks[k] * pixels)
            snprintf(text[k], sizeof text[k], "%.2f", shading_run_error(&run));
    }
    const sl_counters *c = sl_method_counters(run.method);
    double points = (double)c->value[SL_COUNT_POINTS_SHADED], tests = (double)c->value[SL_COUNT_PIXEL_TESTS];
    double chosen = (double)(c->value[SL_COUNT_PIXELS_HIT] + c->value[SL_COUNT_PIXELS_RANDOM] +
                             c->value[SL_COUNT_PIXELS_FLOODED]);
    bench_row(r, "%s|%s|%s|%s|%s|%s|%s|%llu|%.1f|%.0f|%.2f|%.2f", w->name, v->name, text[0], text[1], text[2],
              text[3], text[4], (unsigned long long)run.updates, points > 0.0 ? tests / points : 0.0,
              chosen > 0.0 ? 100.0 * (double)c->value[SL_COUNT_PIXELS_FLOODED] / chosen : 0.0,
              points / fmax(1.0, chosen), run.seconds);
    shading_run_close(&run);
}

static void experiment(bench_report *r, const bench_options *o, const char *path) {
    shading_world w;
    if (!shading_open(r, o, path, 512, o->brief ? 25 : 400, &w)) return;
    shading_judge(&w, o->brief ? 16 : 8);
    for (size_t i = 0; i < sizeof variants / sizeof variants[0]; i++)
        row(r, &w, &variants[i], o->brief ? MARKS - 1 : MARKS);
    shading_close(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/shading-cache");
    bench_report r;
    bench_report_open(&r, &o, "shading_parts");
    bench_say(&r, "\nRMS error in grey levels at that many points a pixel, 512 x 512; *tests*: pixels drawn "
                  "for each point; *flooded*: of the pixels chosen, in %%.\n");
    bench_table(
        &r, "choice",
        "scene|choice of pixels|0.0025|0.005|0.01|0.02|0.04|updates|tests|flooded|points / pixel chosen|s");
    experiment(&r, &o, "scenes/generated/study.json");
    experiment(&r, &o, "scenes/generated/loft.json");
    experiment(&r, &o, "scenes/generated/pool.json");
    experiment(&r, &o, "scenes/cornell.json");
    bench_report_close(&r);
    return 0;
}
