/* Sampling one area light by hardware and by rays (multi-mesh caching, section on hardware sampling), on the generated room:
 *
 *   equal density   N x N pixels of the light's picture against N x N jittered shadow rays in coherent packets of 16: time of each (paper: 0.9 to
 *                   32 ms at 64 x 64)
 *   equal error     error of all sizes over time, so that one can see which pixels are worth which rays (paper: 128 x 128 pixels in the time of
 *                   16 x 16 rays)
 *   scaling         time over N (paper: 0.9 ms at 64, 2.6 at 128, so 0.33 ms and 0.138 us a pixel)
 *   reduction       its share of a sample, summing and reading back (paper: 70 %)
 *
 * Points are what the camera sees in random pixels; errors are of those that see a part of the light, in units of what they would get without
 * occluders, against 512 x 512 rays. Processor time of one thread, medians of repetitions in which all take turns.
 *
 *     build/bench/bench_light_sample [--brief] [--out FOLDER] */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "cache/light_sample/light_sample.h"
#include "cache/light_sample/light_sample_internal.h"
#include "common.h"
#include "timing.h"

enum { POINTS = 512, ASKED = 16384, REPETITIONS = 9, TRUTH = 512, CASES_MAX = 32 };

typedef struct {
    const char *name;
    sl_light_estimator estimator;
    int size;                       /* N pixels or n rays a side */
    sl_light_sampling *sampling;
    sl_light_sample_scratch *scratch;
    double ms[REPETITIONS];         /* a sample, all points' mean */
    double partial_ms[REPETITIONS]; /* those alone that see a part of the light */
    double rms, largest;            /* errors */
    sl_counters counters;
} bench_case;

typedef struct {
    sl_scene *scene;
    sl_raster *raster;
    sl_tracer *tracer;
    sl_sampled_lights *lights;
    size_t light, count, partial;
    sl_lit_point point[POINTS];
    double unoccluded[POINTS], truth[POINTS];
    bench_case cases[CASES_MAX];
    size_t case_count;
    bench_report report;
    int repetitions;
} bench;

static void need(sl_status status, const char *what, const sl_error *error) {
    if (status != SL_OK) bench_fail(what, error);
}

static bench_case *add_case(bench *b, const char *name, sl_light_estimator estimator, int size) {
    bench_case *c = &b->cases[b->case_count++];
    sl_error error = {0};
    sl_light_sample_settings s = sl_light_sample_defaults();
    *c = (bench_case){.name = name, .estimator = estimator, .size = size};
    s.estimator = estimator;
    if (estimator == SL_LIGHT_RAYS) s.rays = size;
    else s.size = s.largest = size;
    if (s.size < s.reduced) s.reduced = s.size;
    need(sl_light_sampling_create(b->scene, b->raster, b->tracer, b->lights, &s, &c->sampling, &error), name, &error);
    need(sl_light_sample_scratch_create(c->sampling, &c->scratch, &error), name, &error);
    return c;
}

static double take(const bench *b, bench_case *c, size_t i) {
    return (double)sl_light_sample_take(c->sampling, b->light, &b->point[i], c->scratch, &c->counters);
}

/* The area light of the largest area times radiance. */
static void choose_light(bench *b) {
    double best = 0.0;
    for (size_t i = 0; i < b->lights->count; i++) {
        const sl_sampled_light *l = &b->lights->light[i];
        double power = 0.0;
        for (size_t t = 0; l->kind == SL_SAMPLED_AREA && t < l->triangles; t++) {
            sl_vec3 e = sl_sub(l->corner[3 * t + 1], l->corner[3 * t]), f = sl_sub(l->corner[3 * t + 2], l->corner[3 * t]);
            power += (double)(sl_length(sl_cross(e, f)) * sl_rgb_mean(l->radiance));
        }
        if (power > best) b->light = i;
        best = fmax(best, power);
    }
    if (!(best > 0.0)) bench_fail("no planar area light", NULL);
}

/* Half of the points see a part of the light, the others are as they come; those first. */
static void choose_points(bench *b) {
    sl_gather_point *seen = sl_allocate(ASKED, sizeof *seen);
    if (!seen) bench_fail("memory", NULL);
    size_t count = bench_visible_points(b->scene, b->tracer, ASKED, seen);
    bench_case *probe = add_case(b, "probe", SL_LIGHT_RATIO, 64), *truth = add_case(b, "truth", SL_LIGHT_RAYS, TRUTH);
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < count && b->count < (pass ? POINTS : POINTS / 2); i++) {
            b->point[b->count] = (sl_lit_point){seen[i].position, seen[i].normal, seen[i].geometric_normal, seen[i].triangle};
            double open = sl_light_unoccluded(&b->lights->light[b->light], &b->point[b->count]);
            if (!(open > 0.001)) continue;
            double share = take(b, probe, b->count) / open;
            bool partial = share > 0.02 && share < 0.98;
            if (partial == (pass == 0)) b->unoccluded[b->count++] = open;
        }
        if (pass == 0) b->partial = b->count;
    }
    for (size_t i = 0; i < b->partial; i++) b->truth[i] = take(b, truth, i);
    sl_free(seen);
}

static void find_errors(const bench *b, bench_case *c) {
    double sum = 0.0;
    for (size_t i = 0; i < b->partial; i++) {
        double e = fabs(take(b, c, i) - b->truth[i]) / b->unoccluded[i];
        sum += e * e;
        c->largest = fmax(c->largest, e);
    }
    c->rms = b->partial ? sqrt(sum / (double)b->partial) : 0.0;
}

static void time_once(const bench *b, bench_case *c, int repetition) {
    double t0 = now_ms();
    for (size_t i = 0; i < b->partial; i++) take(b, c, i);
    double t1 = now_ms();
    for (size_t i = b->partial; i < b->count; i++) take(b, c, i);
    double t2 = now_ms();
    c->partial_ms[repetition] = (t1 - t0) / (double)b->partial;
    c->ms[repetition] = (t2 - t0) / (double)b->count;
}

/* ---- tables ---- */

static void run(bench *b) {
    static const int sizes[] = {16, 32, 64, 128, 256}, rays[] = {4, 8, 16, 32, 64};
    size_t first = b->case_count;
    for (size_t k = 0; k < 5; k++) add_case(b, "window, ratio", SL_LIGHT_RATIO, sizes[k]);
    for (size_t k = 0; k < 5; k++) add_case(b, "window, raw", SL_LIGHT_WINDOW, sizes[k]);
    for (size_t k = 0; k < 5; k++) add_case(b, "frustum", SL_LIGHT_LOOK_AT, sizes[k]);
    for (size_t k = 0; k < 5; k++) add_case(b, "rays, ratio", SL_LIGHT_RAYS, rays[k]);
    for (size_t k = first; k < b->case_count; k++) find_errors(b, &b->cases[k]);
    for (int r = 0; r < b->repetitions; r++) {
        for (size_t k = first; k < b->case_count; k++) time_once(b, &b->cases[k], r);
    }
    bench_table(&b->report, "samples", "Estimator|N|samples|us (part of the light hidden)|us (all points)|rms error|largest error");
    for (size_t k = first; k < b->case_count; k++) {
        bench_case *c = &b->cases[k];
        bench_row(&b->report, "%s|%d|%d|%.1f|%.1f|%.2e|%.2e", c->name, c->size, c->size * c->size, 1e3 * median(c->partial_ms, b->repetitions),
                  1e3 * median(c->ms, b->repetitions), c->rms, c->largest);
    }
}

int main(int argc, char **argv) {
    static bench b;
    bench_options o = bench_options_parse(argc, argv, "build/light-sample");
    sl_error error = {0};
    b.repetitions = o.once ? 3 : REPETITIONS;
    bench_report_open(&b.report, &o, "light-sample");
    if (!bench_open_scene(&b.report, "scenes/generated/room.json", &b.scene)) return 1;
    need(sl_raster_create(b.scene, 1, &b.raster, &error), "raster", &error);
    need(sl_tracer_create(b.scene, 1, NULL, &b.tracer, &error), "rays", &error);
    need(sl_sampled_lights_find(b.scene, &b.lights, &error), "lights", &error);
    choose_light(&b);
    choose_points(&b);
    bench_say(&b.report, "%zu points, %zu of which see a part of the light.\n", b.count, b.partial);
    run(&b);
    bench_report_close(&b.report);
    return 0;
}
