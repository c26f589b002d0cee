/* What a gather costs, and what it is worth: milliseconds of one 64 x 64 gather by plane, hemicube and rays.
 *
 *     build/bench/bench_gather SCENE...
 *
 * Visibility alone and with shading, on one thread, beside the relative RMS error (and that of the
 * translational gradient over E) against jittered ray gathers of 256 x 256 at the same points. Times are the
 * thread's processor time, medians of five repetitions over the same points; the points are what the scene's
 * camera sees in 200 random pixels. Shadow maps are measured where all lights are without extent, which is
 * where they are meant to be used. */
#include <stdio.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/hemisphere/gather_internal.h"
#include "timing.h"

enum { POINTS = 200, REPETITIONS = 5, SIZE = 64 };

typedef struct bench {
    sl_scene *scene;
    sl_raster *raster;
    sl_tracer *tracer;
    size_t count;
    sl_gather_point points[POINTS];
    sl_irradiance reference[POINTS], result[POINTS];
    sl_counters counters;
} bench;

static void bench_stop(const char *what, const sl_error *error) {
    fprintf(stderr, "bench_gather: %s: %s\n", what, error->message);
    exit(1);
}

/* ---- scenes ---- */

/* Random directions through the film; every hit is a point, with the normals turned to the camera. */
static void choose_points(bench *b, size_t points) {
    const sl_camera *c = &b->scene->camera;
    float tangent = (float)sl_tan(0.5 * (double)c->vertical_fov);
    float aspect = (float)b->scene->film_width / (float)b->scene->film_height;
    uint64_t key = sl_random_key(1, 2);
    b->count = 0;
    for (uint64_t i = 0; i < 20 * points && b->count < points; i++) {
        float x = (2.0f * sl_random_unit(key, 2 * i) - 1.0f) * tangent * aspect;
        float y = (2.0f * sl_random_unit(key, 2 * i + 1) - 1.0f) * tangent;
        sl_vec3 d = sl_sub(sl_mad(sl_scale(c->right, x), y, c->up), c->back);
        sl_ray16 rays = {.origin_x = {c->eye.x},
                         .origin_y = {c->eye.y},
                         .origin_z = {c->eye.z},
                         .direction_x = {d.x},
                         .direction_y = {d.y},
                         .direction_z = {d.z},
                         .far = {INFINITY},
                         .skip = {SL_NO_INDEX}};
        sl_hit16 hits;
        sl_trace(b->tracer, &rays, 1, false, &hits, &b->counters);
        if (hits.triangle[0] == SL_NO_INDEX) continue;
        sl_surface s;
        sl_scene_surface(b->scene, hits.triangle[0], hits.w1[0], hits.w2[0], sl_neg(d), &s);
        b->points[b->count++] = (sl_gather_point){.position = s.position,
                                                  .geometric_normal = s.geometric_normal,
                                                  .normal = s.normal,
                                                  .triangle = hits.triangle[0],
                                                  .key = sl_hash64(i)};
    }
}

static void bench_open(bench *b, const char *path, size_t points) {
    sl_error error;
    if (sl_scene_load_with(path, &(sl_load_options){.allow_outside = true}, &b->scene, &error) != SL_OK)
        bench_stop(path, &error);
    if (sl_raster_create(b->scene, 1, &b->raster, &error) != SL_OK) bench_stop("rasterizer", &error);
    if (sl_tracer_create(b->scene, 1, NULL, &b->tracer, &error) != SL_OK) bench_stop("tracer", &error);
    choose_points(b, points);
}

static void bench_close(bench *b) {
    sl_tracer_destroy(b->tracer);
    sl_raster_destroy(b->raster);
    sl_scene_destroy(b->scene);
}

/* ---- errors ---- */

/* sqrt(mean((x - r)^2 / r^2)) over values of more than a thousandth of the mean; *excluded (or NULL): their
 * share. */
static double bench_relative_rms(const bench *b, double *excluded) {
    double mean = 0, sum = 0, used = 0;
    for (size_t i = 0; i < b->count; i++)
        mean += (double)sl_rgb_mean(b->reference[i].value) / (double)b->count;
    for (size_t i = 0; i < b->count; i++) {
        const float *x = &b->result[i].value.r, *r = &b->reference[i].value.r;
        for (int c = 0; c < 3; c++) {
            if (!((double)r[c] > 1e-3 * mean)) continue;
            double error = ((double)x[c] - (double)r[c]) / (double)r[c];
            sum += error * error;
            used++;
        }
    }
    if (excluded) *excluded = 1.0 - used / (3.0 * (double)b->count);
    return used > 0 ? sqrt(sum / used) : 0.0;
}

typedef struct instrument {
    sl_gather *gather;
    sl_gather_scratch *scratch;
} instrument;

static instrument make(bench *b, sl_gather_kind kind, int size) {
    sl_gather_settings s = sl_gather_defaults();
    instrument m;
    sl_error error;
    s.kind = kind;
    s.size = size;
    s.direct = SL_DIRECT_RAYS;
    if (sl_gather_create(b->scene, b->raster, b->tracer, &s, 1, &m.gather, &b->counters, &error) != SL_OK)
        bench_stop("gather", &error);
    if (sl_gather_scratch_create(m.gather, &m.scratch, &error) != SL_OK) bench_stop("scratch", &error);
    return m;
}

static void drop(instrument *m) {
    sl_gather_scratch_destroy(m->scratch);
    sl_gather_destroy(m->gather);
}

/* With keys of its own, or what is measured against it at 256 x 256 would be it. */
static void gather_all(bench *b, const instrument *m, uint64_t key, sl_irradiance *out) {
    for (size_t i = 0; i < b->count; i++) {
        sl_gather_point point = b->points[i];
        if (key) point.key = sl_hash64(point.key + key);
        sl_gather_irradiance(m->gather, &point, m->scratch, &out[i], &b->counters);
    }
}

/* Irradiance at all points by rays of 256 x 256, the mean of two gathers; returns the relative RMS error that
 * is left. */
static double bench_reference(bench *b) {
    instrument m = make(b, SL_GATHER_RAYS, 256);
    gather_all(b, &m, 77, b->reference);
    gather_all(b, &m, 78, b->result);
    double left = 0.5 * bench_relative_rms(b, NULL);
    for (size_t i = 0; i < b->count; i++) {
        sl_irradiance *r = &b->reference[i], *x = &b->result[i];
        r->value = sl_rgb_scale(sl_rgb_add(r->value, x->value), 0.5f);
        for (int c = 0; c < 3; c++)
            r->translational[c] = sl_scale(sl_add(r->translational[c], x->translational[c]), 0.5f);
    }
    drop(&m);
    return left;
}

/* ---- times ---- */

typedef struct figures {
    double create_ms, see_ms, gather_ms;
} figures;

static figures run(bench *b, const sl_gather_settings *settings, int repetitions, sl_irradiance *out) {
    sl_gather *gather;
    sl_gather_scratch *scratch;
    sl_error error;
    double start = now_ms(), see[REPETITIONS], all[REPETITIONS];
    if (sl_gather_create(b->scene, b->raster, b->tracer, settings, 1, &gather, &b->counters, &error) !=
        SL_OK) {
        bench_stop("gather", &error);
    }
    if (sl_gather_scratch_create(gather, &scratch, &error) != SL_OK) bench_stop("scratch", &error);
    figures f = {.create_ms = now_ms() - start};
    for (int r = 0; r < repetitions; r++) {
        start = now_ms();
        for (size_t i = 0; i < b->count; i++) sl_gather_see(gather, &b->points[i], scratch, &b->counters);
        see[r] = (now_ms() - start) / (double)b->count;
        start = now_ms();
        for (size_t i = 0; i < b->count; i++)
            sl_gather_irradiance(gather, &b->points[i], scratch, &out[i], &b->counters);
        all[r] = (now_ms() - start) / (double)b->count;
    }
    f.see_ms = median(see, repetitions);
    f.gather_ms = median(all, repetitions);
    sl_gather_scratch_destroy(scratch);
    sl_gather_destroy(gather);
    return f;
}

/* rms of |grad_t E - reference| / E in 1/m, green channel; with NULL for the gathers, of the reference
 * itself. */
static double gradient_rms(const bench *b, const sl_irradiance *result) {
    double sum = 0, used = 0;
    for (size_t i = 0; i < b->count; i++) {
        double e = (double)b->reference[i].value.g;
        sl_vec3 d = b->reference[i].translational[1];
        if (result) d = sl_sub(d, result[i].translational[1]);
        if (!(e > 0.0)) continue;
        sum += (double)sl_dot(d, d) / (e * e);
        used++;
    }
    return used > 0 ? sqrt(sum / used) : 0.0;
}

static void measure(bench *b) {
    static const char *const names[4] = {"auto", "plane", "hemicube", "rays"};
    double left = bench_reference(b);
    printf("  %-9s %-12s %10s %10s %10s %10s %9s %12s\n", "gather", "lit by", "create ms", "see ms", "ms",
           "rel. RMS", "excluded", "grad 1/m");
    for (int direct = 0; direct < 2; direct++) {
        for (int kind = 1; kind < 4; kind++) {
            double excluded;
            sl_gather_settings s = sl_gather_defaults();
            s.kind = (sl_gather_kind)kind;
            s.size = SIZE;
            s.direct = direct ? SL_DIRECT_SHADOW_MAPS : SL_DIRECT_RAYS;
            if (direct && (b->scene->emitter_count || b->scene->environment.present)) continue;
            figures f = run(b, &s, REPETITIONS, b->result);
            double rms = bench_relative_rms(b, &excluded);
            printf("  %-9s %-12s %10.2f %10.3f %10.3f %9.2f%% %8.1f%% %12.4f\n", names[kind],
                   direct ? "shadow maps" : "rays", f.create_ms, f.see_ms, f.gather_ms, 100 * rms,
                   100 * excluded, gradient_rms(b, b->result));
        }
    }
    double mean = 0;
    for (size_t i = 0; i < b->count; i++) mean += (double)b->reference[i].value.g / (double)b->count;
    printf("  reference: mean irradiance %.6g, its own error %.2f%%, gradient %.4f 1/m\n", mean, 100 * left,
           gradient_rms(b, NULL));
}

static void errors_of(bench *b, char *const *paths, int count) {
    for (int i = 0; i < count; i++) {
        bench_open(b, paths[i], POINTS);
        printf("%s: %zu triangles, %zu lights, %zu emitters%s, %zu points, isa %s\n", paths[i],
               b->scene->triangle_count, b->scene->light_count, b->scene->emitter_count,
               b->scene->environment.present ? ", environment" : "", b->count, sl_isa_name(sl_isa_best()));
        measure(b);
        fflush(stdout);
        bench_close(b);
    }
}

int main(int argc, char **argv) {
    bench *b = argc > 1 ? sl_allocate(1, sizeof *b) : NULL;
    if (argc < 2) fprintf(stderr, "usage: bench_gather SCENE...\n");
    if (!b) return 2;
    errors_of(b, argv + 1, argc - 1);
    sl_free(b);
    return 0;
}
