/* Sampling one area light by hardware and by rays (multi-mesh caching, section on hardware sampling), on the
 * generated room:
 *
 *   time and error of N x N pixels of the light's picture, and of N x N jittered shadow rays in coherent
 *   packets of 16 (paper: 0.9 to 32 ms at 64 x 64; 128 x 128 pixels in the time of 16 x 16 rays);
 *   how many pixels are as good as so many rays, and what both cost;
 *   time over N (paper: 0.33 ms and 0.138 us a pixel), the share of summing and reading back (paper: 70 %),
 *   and what the hardware culls.
 *
 * Points are what the camera sees in random pixels, unless they get next to nothing from the light; errors
 * are of those that see a part of it, in units of what they would get without occluders, against 512 x 512
 * rays. Processor time of one thread, medians of repetitions in which all take turns.
 *
 *     build/bench/bench_light_sample [--brief] */
#include <math.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/light/light_sample.h"
#include "cache/light/light_sample_internal.h"
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
    double us, partial_us;          /* medians */
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
    int repetitions;
} bench;

static bench_case *add_case(bench *b, const char *name, sl_light_estimator estimator, int size) {
    bench_case *c = &b->cases[b->case_count++];
    sl_error error = {0};
    sl_light_sample_settings s = sl_light_sample_defaults();
    *c = (bench_case){.name = name, .estimator = estimator, .size = size};
    s.estimator = estimator;
    if (estimator == SL_LIGHT_RAYS) s.rays = size;
    else s.size = s.largest = size;
    bench_check(sl_light_sampling_create(b->scene, b->raster, b->tracer, b->lights, &s, &c->sampling, &error),
                &error);
    bench_check(sl_light_sample_scratch_create(c->sampling, &c->scratch, &error), &error);
    return c;
}

static void free_cases(bench *b) {
    for (size_t k = 0; k < b->case_count; k++) {
        sl_light_sample_scratch_destroy(b->cases[k].scratch);
        sl_light_sampling_destroy(b->cases[k].sampling);
    }
    b->case_count = 0;
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
        for (size_t t = 0; l->kind == SL_SOURCE_AREA && t < l->triangles; t++) {
            sl_vec3 e = sl_sub(l->corner[3 * t + 1], l->corner[3 * t]),
                    f = sl_sub(l->corner[3 * t + 2], l->corner[3 * t]);
            power += (double)(sl_length(sl_cross(e, f)) * sl_rgb_mean(l->radiance));
        }
        if (power > best) b->light = i;
        best = fmax(best, power);
    }
    if (!(best > 0.0)) bench_fail("no planar area light");
}

/* Half of the points see a part of the light, the others are as they come; those first. */
static void choose_points(bench *b) {
    sl_gather_point *seen = bench_allocate(ASKED, sizeof *seen);
    size_t count = bench_visible_points(b->scene, b->tracer, ASKED, seen);
    bench_case *probe = add_case(b, "probe", SL_LIGHT_RATIO, 64),
               *truth = add_case(b, "truth", SL_LIGHT_RAYS, TRUTH);
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < count && b->count < (pass ? POINTS : POINTS / 2); i++) {
            b->point[b->count] =
                (sl_lit_point){seen[i].position, seen[i].normal, seen[i].geometric_normal, seen[i].triangle};
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

/* ---- equal density, equal error ---- */

static const int sizes[] = {8, 16, 32, 64, 128, 256}, rays[] = {4, 8, 16, 32, 64, 128};
enum { SIZES = 6 };

/* The three estimators, SIZES cases each, from b->cases[first] on. */
static size_t add_cases(bench *b) {
    size_t first = b->case_count;
    for (size_t k = 0; k < SIZES; k++) add_case(b, "frustum, ratio", SL_LIGHT_RATIO, sizes[k]);
    for (size_t k = 0; k < SIZES; k++) add_case(b, "frustum (the paper's)", SL_LIGHT_LOOK_AT, sizes[k]);
    for (size_t k = 0; k < SIZES; k++) add_case(b, "rays, ratio", SL_LIGHT_RAYS, rays[k]);
    return first;
}

static void table_of_samples(bench *b, size_t first) {
    for (size_t k = first; k < b->case_count; k++) find_errors(b, &b->cases[k]);
    for (int r = 0; r < b->repetitions; r++) {
        for (size_t k = first; k < b->case_count; k++) time_once(b, &b->cases[k], r);
    }
    bench_table(
        "Estimator|>N|>samples|>us, part of the light seen|>us, all points|>rms error|>largest error");
    for (size_t k = first; k < b->case_count; k++) {
        bench_case *c = &b->cases[k];
        c->partial_us = 1e3 * median(c->partial_ms, b->repetitions);
        c->us = 1e3 * median(c->ms, b->repetitions);
        bench_row("%s|%d|%d|%.1f|%.1f|%.2e|%.2e", c->name, c->size, c->size * c->size,
                  c->partial_us, c->us, c->rms, c->largest);
    }
    /* 64 x 64 both */
    const bench_case *picture = &b->cases[first + 3], *ray = &b->cases[first + 2 * SIZES + 4];
    printf(
        "\nEqual density, 64 x 64: rays take %.1f times as long as pixels, at %.2f times their error. "
              "The paper: 35.6 times.\n",
              ray->partial_us / picture->partial_us, ray->rms / picture->rms);
    printf(
        "128 x 128 pixels take %.2f times as long as 16 x 16 rays, at 1/%.1f of their error. The "
              "paper: 1.0.\n",
              picture[1].partial_us / ray[-2].partial_us, ray[-2].rms / picture[1].rms);
}

/* Along the straight line through neighbouring cases, both axes logarithmic; no smaller than the smallest. */
static double between(const bench_case *c, double rms, double (*value)(const bench_case *)) {
    size_t k = 0;
    while (k + 2 < SIZES && c[k + 1].rms > rms) k++;
    double t = fmax(sl_log(c[k].rms / rms) / sl_log(c[k].rms / c[k + 1].rms), 0.0);
    return sl_exp(sl_log(value(&c[k])) + t * (sl_log(value(&c[k + 1])) - sl_log(value(&c[k]))));
}
static double size_of(const bench_case *c) { return (double)c->size; }
static double time_of(const bench_case *c) { return c->partial_us; }

static void table_of_equal_error(bench *b, size_t first) {
    const bench_case *ray = &b->cases[first + 2 * SIZES];
    bench_table(
        "Rays|>us|>rms error|>Frustum, ratio: N of the same error (8 or more)|>us|>rays take|>the paper's: "
                "N|>us|>rays take");
    for (size_t k = 0; k < SIZES; k++) {
        double at[2][2];
        for (size_t e = 0; e < 2; e++) {
            const bench_case *c = &b->cases[first + e * SIZES];
            at[e][0] = between(c, ray[k].rms, size_of);
            at[e][1] = between(c, ray[k].rms, time_of);
        }
        double us = ray[k].partial_us;
        bench_row("%d x %d|%.1f|%.2e|%.0f|%.1f|%.2f x|%.0f|%.1f|%.2f x", ray[k].size, ray[k].size,
                  us, ray[k].rms, at[0][0], at[0][1], us / at[0][1], at[1][0], at[1][1], us / at[1][1]);
    }
}

/* ---- where the time goes ---- */

static double reduction_us(const bench *b, sl_light_query *q, int size) {
    double t0 = now_ms(), sum[2];
    for (size_t i = 0; i < b->count; i++)
        sl_raster_sum(q->scratch->planes, size, 2, q->scratch->halves, sum, q->counters);
    return 1e3 * (now_ms() - t0) / (double)b->count;
}

static double closed_form_us(const bench *b) {
    double t0 = now_ms();
    for (size_t i = 0; i < b->count; i++) sl_light_unoccluded(&b->lights->light[b->light], &b->point[i]);
    return 1e3 * (now_ms() - t0) / (double)b->count;
}

static void table_of_parts(bench *b, size_t first) {
    double form[REPETITIONS], reduce[REPETITIONS];
    bench_table(
        "N|>us|>summing and reading back, us|>its share|>fixed and for each pixel: from this and the next N");
    for (size_t k = 0; k < SIZES; k++) {
        bench_case *c = &b->cases[first + k];
        sl_light_query q = {
            .sampling = c->sampling, .light = b->light, .scratch = c->scratch, .counters = &c->counters};
        for (int r = 0; r < b->repetitions; r++) reduce[r] = reduction_us(b, &q, c->size);
        double us = median(reduce, b->repetitions), pixels = (double)(c->size * c->size);
        const bench_case *next = k + 1 < SIZES ? c + 1 : c - 1;
        double each = (next->us - c->us) / ((double)(next->size * next->size) - pixels);
        bench_row("%d|%.1f|%.2f|%.0f %%|%.1f us + %.2f ns", c->size, c->us, us,
                  100.0 * us / c->us, c->us - each * pixels, 1e3 * each);
    }
    const bench_case *c = &b->cases[first + 3]; /* 64 x 64 */
    for (int r = 0; r < b->repetitions; r++) form[r] = closed_form_us(b);
    const uint64_t *n = c->counters.value;
    double passes = (double)n[SL_COUNT_RASTER_PASSES], tested = (double)n[SL_COUNT_CLUSTERS_TESTED] / passes;
    printf(
        "\nThe hardware culls clusters: %.1f of %.0f are drawn, %.0f triangles submitted, %.0f rasterized. ",
        tested - (double)n[SL_COUNT_CLUSTERS_CULLED] / passes, tested,
        (double)n[SL_COUNT_TRIANGLES_SUBMITTED] / passes, (double)n[SL_COUNT_TRIANGLES_RASTERIZED] / passes);
    printf("The closed form: %.2f us.\n", median(form, b->repetitions));
}

int main(int argc, char **argv) {
    static bench b;
    bench_options o = bench_options_parse(argc, argv);
    sl_error error = {0};
    b.repetitions = o.brief ? 3 : REPETITIONS;
    if (!bench_open_scene("scenes/generated/room.json", &b.scene)) return 1;
    bench_check(sl_raster_create(b.scene, 1, &b.raster, &error), &error);
    bench_check(sl_tracer_create(b.scene, 1, NULL, &b.tracer, &error), &error);
    bench_check(sl_sampled_lights_find(b.scene, &b.lights, &error), &error);
    choose_light(&b);
    choose_points(&b);
    printf("The generated room, %zu triangles; %zu points, of which %zu see a part of the light.\n",
              b.scene->triangle_count, b.count, b.partial);
    size_t first = add_cases(&b);
    table_of_samples(&b, first);
    table_of_equal_error(&b, first);
    table_of_parts(&b, first);
    free_cases(&b);
    sl_sampled_lights_destroy(b.lights);
    sl_tracer_destroy(b.tracer);
    sl_raster_destroy(b.raster);
    sl_scene_destroy(b.scene);
    return 0;
}
