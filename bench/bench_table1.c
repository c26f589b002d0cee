/* Table 1 of Gautron et al. 2005: how well one picture of the hemisphere tells the irradiance, at 10,000
 * random visible points.
 *
 * Error is of two kinds: of the hemisphere (directions that the picture misses or knows only coarsely), and
 * noise of the light samples with which what is seen is lit. Two gathers of equal directions and other light
 * samples tell them apart: with E1, E2 and the reference's halves A, B, mean (E1-A)(E2-B)/r^2 is the
 * hemisphere's squared error alone. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "cache/splatting/splatting.h"
#include "common.h"
#include "timing.h"

typedef struct world {
    sl_scene *scene;
    sl_raster *raster;
    sl_tracer *tracer;
    size_t count;
    sl_gather_point *points;
    float *reference[2]; /* 3 values a point, two independent halves */
    double mean;
    float *gathered[2];  /* by the instrument at work */
    unsigned threads;
} world;

typedef struct instrument {
    const char *name;
    sl_gather_kind kind;
    int size;
    double fov_deg;   /* plane */
    sl_border border;
    uint32_t samples; /* of the lights, for each thing seen; 0 counts as 1 */
} instrument;

/* ---- gathers at all points ---- */

typedef struct gather_task {
    const world *w;
    const sl_gather *gather;
    sl_gather_scratch *scratch[256];
    uint64_t key;
    float *values;
} gather_task;

static void gather_one(void *context, size_t index, unsigned worker) {
    gather_task *t = context;
    sl_gather_point point = t->w->points[index];
    sl_counters counters = {{0}};
    sl_irradiance irradiance;
    point.key = sl_hash64(point.key + t->key);
    sl_gather_irradiance(t->gather, &point, t->scratch[worker], &irradiance, &counters);
    memcpy(&t->values[3 * index], &irradiance.value, 3 * sizeof(float));
}

/* The same at the first `count` points by this thread alone: processor milliseconds a gather. */
static double gather_points(const world *w, const instrument *m, bool jitter, uint64_t key, size_t count,
                            unsigned threads, float *values) {
    sl_gather_settings s = sl_gather_defaults();
    gather_task t = {.w = w, .key = key, .values = values};
    sl_gather *gather;
    sl_error error;
    s.kind = m->kind;
    s.size = m->size;
    s.border = m->border;
    s.jitter = jitter;
    s.hit_samples = m->samples;
    if (m->fov_deg > 0.0) s.plane_fov = (float)(m->fov_deg * SL_PI / 180.0);
    bench_check(sl_gather_create(w->scene, w->raster, w->tracer, &s, 1, &gather, &error), &error);
    for (unsigned i = 0; i < threads; i++) {
        bench_check(sl_gather_scratch_create(gather, &t.scratch[i], &error), &error);
    }
    t.gather = gather;
    double from = now_ms();
    if (threads == 1) {
        for (size_t i = 0; i < count; i++) gather_one(&t, i, 0);
    } else {
        sl_parallel_for(threads, count, gather_one, &t);
    }
    double spent = now_ms() - from;
    for (unsigned i = 0; i < threads; i++) sl_gather_scratch_destroy(t.scratch[i]);
    sl_gather_destroy(gather);
    return spent / (double)count;
}

/* Least of two turns over a few points: what is compared takes turns with nothing else of ours. */
static double gather_ms(const world *w, const instrument *m, float *values) {
    size_t some = w->count < 5000 ? w->count / 25 + 4 : 200;
    double least = INFINITY;
    for (int turn = 0; turn < 2; turn++) least = fmin(least, gather_points(w, m, true, 0, some, 1, values));
    return least;
}

/* ---- the world and its reference ---- */

/* Two gathers of N x N jittered rays with light samples of their own. */
static void find_reference(world *w, int size) {
    instrument rays = {"reference", SL_GATHER_RAYS, size, 0.0, SL_BORDER_RADIAL, 1};
    w->reference[0] = bench_allocate(6 * w->count, sizeof(float));
    w->reference[1] = w->reference[0] + 3 * w->count;
    for (int half = 0; half < 2; half++)
        gather_points(w, &rays, true, 1000 + (uint64_t)half, w->count, w->threads, w->reference[half]);
    for (size_t i = 0; i < 6 * w->count; i++) w->mean += (double)w->reference[0][i] / (double)(6 * w->count);
}

static bool open_world(const char *path, size_t points, world *w) {
    sl_error error;
    *w = (world){.threads = sl_thread_count(0)};
    if (!bench_open_scene(path, &w->scene)) return false;
    bench_check(sl_raster_create(w->scene, 1, &w->raster, &error), &error);
    bench_check(sl_tracer_create(w->scene, 1, NULL, &w->tracer, &error), &error);
    w->points = bench_allocate(points, sizeof *w->points);
    w->gathered[0] = bench_allocate(6 * points, sizeof(float));
    w->gathered[1] = w->gathered[0] + 3 * points;
    w->count = bench_visible_points(w->scene, w->tracer, points, w->points);
    return true;
}

static void close_world(world *w) {
    sl_free(w->points);
    sl_free(w->gathered[0]);
    sl_free(w->reference[0]);
    sl_tracer_destroy(w->tracer);
    sl_raster_destroy(w->raster);
    sl_scene_destroy(w->scene);
}

/* ---- errors ---- */

typedef struct gather_error {
    /* sqrt(mean (E-A)(E-B) / r^2): per value, as only so the borders come in the paper's order */
    double relative;
    double hemisphere;  /* the same without the light samples' noise */
    double to_mean;     /* sqrt(mean (E-A)(E-B)) / mean r */
    double bias;        /* mean (E-r)/r */
} gather_error;

static double root(double square, double count) {
    return count > 0.0 && square > 0.0 ? sqrt(square / count) : 0.0;
}

static gather_error errors_of(const world *w, size_t points, const float *first, const float *second) {
    gather_error e = {0};
    double relative = 0.0, hemisphere = 0.0, absolute = 0.0, bias = 0.0, used = 0.0,
           all = (double)(3 * points);
    for (size_t i = 0; i < 3 * points; i++) {
        double a = (double)w->reference[0][i], b = (double)w->reference[1][i], r = 0.5 * (a + b);
        double x = (double)first[i], y = (double)second[i];
        absolute += (x - a) * (x - b);
        if (!(r > 1e-3 * w->mean)) continue;
        relative += (x - a) * (x - b) / (r * r);
        hemisphere += (x - a) * (y - b) / (r * r);
        bias += (x - r) / r;
        used++;
    }
    e.relative = root(relative, used);
    e.hemisphere = root(hemisphere, used);
    e.to_mean = root(absolute, all) / w->mean;
    e.bias = used > 0.0 ? bias / used : 0.0;
    return e;
}

static size_t some_points(const world *w) {
    return w->count < 500 ? w->count : w->count < 5000 ? 500 : w->count / 10;
}

/* The hemisphere's error alone, of two gathers whose directions are equal (jitter would move them), at some
 * of the points; and so is all where there are many light samples, which are as dear as they are many. */
static gather_error measure(const world *w, const instrument *m, double *ms) {
    size_t some = some_points(w), all = m->samples > 1 ? some : w->count;
    for (int i = 0; i < 2; i++) gather_points(w, m, false, 1 + (uint64_t)i, some, w->threads, w->gathered[i]);
    double hemisphere = errors_of(w, some, w->gathered[0], w->gathered[1]).hemisphere;
    gather_points(w, m, true, 1, all, w->threads, w->gathered[0]);
    gather_error e = errors_of(w, all, w->gathered[0], w->gathered[0]);
    e.hemisphere = hemisphere;
    *ms = gather_ms(w, m, w->gathered[0]);
    return e;
}

static void error_row(const char *scene, const instrument *m, const gather_error *e,
                      double ms) {
    char fov[16] = "";
    if (m->fov_deg > 0.0) snprintf(fov, sizeof fov, "%.2f", m->fov_deg);
    int cells = m->kind == SL_GATHER_HEMICUBE ? 3 * m->size * m->size : m->size * m->size;
    bench_row("%s|%s|%d|%s|%d|%u|%.2f|%.2f|%.2f|%+.2f|%.3f", scene, m->name, m->size, fov, cells,
              m->samples, 100.0 * e->relative, 100.0 * e->hemisphere, 100.0 * e->to_mean, 100.0 * e->bias,
              ms);
}

/* ---- rows ---- */

/* The largest even size that takes no longer than `ms`. */
static int size_of_cost(const world *w, sl_gather_kind kind, double ms) {
    int best = 8;
    for (int size = 16; size <= 160; size += size < 48 ? 8 : 16) {
        instrument m = {"", kind, size, 0.0, SL_BORDER_RADIAL, 1};
        if (gather_ms(w, &m, w->gathered[0]) > ms) break;
        best = size;
    }
    return best;
}

static double row(const world *w, const char *scene, const instrument *m, double *ms,
                  double *best) {
    gather_error e = measure(w, m, ms);
    error_row(scene, m, &e, *ms);
    if (m->size == 64) *best = fmin(*best, e.relative);
    return e.relative;
}

/* The paper's scenes have lights without extent, which need no samples: its rows are repeated with as many
 * light samples as leave the hemisphere's error alone to be seen. */
enum { MANY_SAMPLES = 16 };

static void plane_rows(const world *w, const char *scene, double fov, uint32_t samples,
                       double e[3], double *radial_ms, double *best) {
    static const char *const names[] = {"plane, plain", "plane, LC04", "plane, radial"};
    static const sl_border borders[] = {SL_BORDER_PLAIN, SL_BORDER_LC04, SL_BORDER_RADIAL};
    double ms;
    for (int i = 0; i < 3; i++) {
        instrument m = {names[i], SL_GATHER_PLANE, 64, fov, borders[i], samples};
        e[i] = row(w, scene, &m, &ms, best);
        if (borders[i] == SL_BORDER_RADIAL) *radial_ms = ms;
    }
}

static void table_1(const bench_options *o, const world *w, const char *scene,
                    double *best) {
    static const double fovs[] = {126.87, 140.0};
    static const uint32_t samples[] = {1, MANY_SAMPLES};
    double ms, radial_ms = 0.0, errors[2][2][3];
    bench_table("scene|instrument|>N|>FOV|>cells|>light spp|>relRMS %|>hemisphere %|>RMSE/mean %|>bias %|"
                ">ms");
    for (int s = 0; s < 2; s++) {
        for (int f = 0; f < (o->brief ? 1 : 2); f++)
            plane_rows(w, scene, fovs[f], samples[s], errors[s][f], &radial_ms, best);
        const instrument others[] = {
            {"hemicube, N = 64", SL_GATHER_HEMICUBE, 64, 0.0, SL_BORDER_RADIAL, samples[s]},
            {"rays, N = 64", SL_GATHER_RAYS, 64, 0.0, SL_BORDER_RADIAL, samples[s]},
            {"hemicube, as dear", SL_GATHER_HEMICUBE, 0, 0.0, SL_BORDER_RADIAL, 1},
            {"rays, as dear", SL_GATHER_RAYS, 0, 0.0, SL_BORDER_RADIAL, 1}};
        for (size_t i = 0; i < (s ? 2 : 4); i++) {
            instrument m = others[i];
            if (!m.size) m.size = size_of_cost(w, m.kind, radial_ms);
            row(w, scene, &m, &ms, best);
        }
    }
    for (int s = 0; s < 2; s++) {
        for (int f = 0; f < (o->brief ? 1 : 2); f++) {
            const double *e = errors[s][f];
            bool ordered = e[0] > e[1] && e[1] > e[2];
            printf(
                      "\n%s, %.2f degrees, %u light samples: plain : LC04 : radial = 1 : %.2f : %.2f (paper "
                      "1 : 0.57 : 0.32); order %s; radial / plain %s 0.6\n",
                      scene, fovs[f], samples[s], e[1] / e[0], e[2] / e[0],
                      ordered ? "holds" : "DOES NOT HOLD", e[2] <= 0.6 * e[0] ? "<=" : "ABOVE");
        }
    }
}

static void fov_sweep(const bench_options *o, const world *w, const char *scene) {
    static const double fovs[] = {90.0, 110.0, 120.0, 126.87, 133.0, 140.0, 150.0, 160.0};
    printf("\n%s, by field of view: the hemisphere's error alone\n", scene);
    bench_table("scene|>FOV|>F|>plain %|>LC04 %|>radial %");
    for (size_t f = 0; f < sizeof fovs / sizeof *fovs; f += o->brief ? 3 : 1) {
        double half = 0.5 * fovs[f] * SL_PI / 180.0, sine = sl_sin(half), e[3];
        for (int i = 0; i < 3; i++) {
            instrument m = {"", SL_GATHER_PLANE, 64, fovs[f], (sl_border)i, 1};
            for (int k = 0; k < 2; k++)
                gather_points(w, &m, false, 1 + (uint64_t)k, some_points(w), w->threads, w->gathered[k]);
            e[i] = 100.0 * errors_of(w, some_points(w), w->gathered[0], w->gathered[1]).hemisphere;
        }
        bench_row("%s|%.2f|%.4f|%.2f|%.2f|%.2f", scene, fovs[f], 4.0 / SL_PI * sine * sl_atan(sine),
                  e[0], e[1], e[2]);
    }
}

static void experiment(const bench_options *o, const char *path, size_t points) {
    char scene[64];
    world w;
    bench_scene_name(path, scene);
    if (!bench_wants(o, scene) || !open_world(path, o->brief ? 100 : o->points ? o->points : points, &w))
        return;
    /* noisier than some of what it judges, but the errors' form takes that off */
    int size = o->brief ? 64 : 96;
    find_reference(&w, size);
    double noise = 0.0, used = 0.0;
    for (size_t i = 0; i < 3 * w.count; i++) {
        double a = (double)w.reference[0][i], b = (double)w.reference[1][i], mean = 0.5 * (a + b);
        if (!(mean > 1e-3 * w.mean)) continue;
        noise += 0.25 * (a - b) * (a - b) / (mean * mean);
        used++;
    }
    printf(
              "\n%s: %zu points, reference twice %d x %d rays, its noise %.2f %%; %.2f %% of the values are "
              "below a thousandth of the mean\n",
              scene, w.count, size, size, 100.0 * root(noise, used),
              100.0 * (1.0 - used / (double)(3 * w.count)));
    double best = INFINITY;
    table_1(o, &w, scene, &best);
    printf("%s: best at N = 64: %.2f %%, %s 2 %%\n", scene, 100.0 * best,
              best < 0.02 ? "below" : "ABOVE");
    fov_sweep(o, &w, scene);
    close_world(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv);
    experiment(&o, "scenes/generated/cathedral.json", 10000);
    experiment(&o, "scenes/generated/atrium.json", 2000);
    return 0;
}
