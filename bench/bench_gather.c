/* What a gather costs, and what it is worth: milliseconds for one 64 x 64 gather by plane, hemicube and rays, visibility
 * alone and with shading, on one thread, beside the relative RMS error (and that of the translational gradient over E)
 * against jittered ray gathers of 256 x 256 at the same points.
 *
 *     build/bench/bench_gather SCENE...
 *
 * Times are the thread's processor time, medians of five repetitions over the same points; the points are what the scene's
 * camera sees in 200 random pixels. Shadow maps are measured where all lights are without extent, which is where they are
 * meant to be used. */
#include <stdio.h>
#include <stdlib.h>

#include "timing.h"

#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/gather/gather_internal.h"

enum { POINTS = 200, REPETITIONS = 5, SIZE = 64, REFERENCE_SIZE = 256 };

typedef struct bench {
    sl_scene *scene;
    sl_raster *raster;
    sl_tracer *tracer;
    size_t count;
    sl_gather_point points[POINTS];
    sl_irradiance reference[POINTS], result[POINTS];
    sl_counters counters;
} bench;

static void stop(const char *what, const sl_error *error) {
    fprintf(stderr, "bench_gather: %s: %s\n", what, error->message);
    exit(1);
}

/* Random directions through the film; every hit is a point, with the normals turned to the camera. */
static void choose_points(bench *b) {
    const sl_camera *c = &b->scene->camera;
    float tangent = (float)sl_tan(0.5 * (double)c->vertical_fov);
    float aspect = (float)b->scene->film_width / (float)b->scene->film_height;
    uint64_t key = sl_random_key(1, 2);
    b->count = 0;
    for (uint64_t i = 0; i < 20 * POINTS && b->count < POINTS; i++) {
        float x = (2.0f * sl_random_unit(key, 2 * i) - 1.0f) * tangent * aspect;
        float y = (2.0f * sl_random_unit(key, 2 * i + 1) - 1.0f) * tangent;
        sl_vec3 d = sl_sub(sl_mad(sl_scale(c->right, x), y, c->up), c->back);
        sl_ray16 rays = {.origin_x = {c->eye.x}, .origin_y = {c->eye.y}, .origin_z = {c->eye.z}, .direction_x = {d.x},
                         .direction_y = {d.y}, .direction_z = {d.z}, .far = {INFINITY}, .skip = {SL_NO_INDEX}};
        sl_hit16 hits;
        sl_trace(b->tracer, &rays, 1, false, &hits, &b->counters);
        if (hits.triangle[0] == SL_NO_INDEX) continue;
        sl_surface s;
        sl_scene_surface(b->scene, hits.triangle[0], hits.w1[0], hits.w2[0], sl_neg(d), &s);
        b->points[b->count++] = (sl_gather_point){.position = s.position, .geometric_normal = s.geometric_normal,
                                                  .normal = s.normal, .triangle = hits.triangle[0], .key = sl_hash64(i)};
    }
}

typedef struct figures {
    double create_ms, see_ms, gather_ms;
    sl_gather_kind kind;
} figures;

static figures run(bench *b, const sl_gather_settings *settings, int repetitions, sl_irradiance *out) {
    sl_gather *gather;
    sl_gather_scratch *scratch;
    sl_error error;
    double start = now_ms(), see[REPETITIONS], all[REPETITIONS];
    if (sl_gather_create(b->scene, b->raster, b->tracer, settings, 1, &gather, &b->counters, &error) != SL_OK) {
        stop("gather", &error);
    }
    if (sl_gather_scratch_create(gather, &scratch, &error) != SL_OK) stop("scratch", &error);
    figures f = {.create_ms = now_ms() - start, .kind = sl_gather_kind_used(gather)};
    for (int r = 0; r < repetitions; r++) {
        start = now_ms();
        for (size_t i = 0; i < b->count; i++) sl_gather_see(gather, &b->points[i], scratch, &b->counters);
        see[r] = (now_ms() - start) / (double)b->count;
        start = now_ms();
        for (size_t i = 0; i < b->count; i++) sl_gather_irradiance(gather, &b->points[i], scratch, &out[i], &b->counters);
        all[r] = (now_ms() - start) / (double)b->count;
    }
    f.see_ms = median(see, repetitions);
    f.gather_ms = median(all, repetitions);
    sl_gather_scratch_destroy(scratch);
    sl_gather_destroy(gather);
    return f;
}

/* sqrt(mean((x - r)^2 / r^2)) over values of more than a thousandth of the mean; *excluded: their share. */
static double relative_rms(const bench *b, double *excluded) {
    double mean = 0, sum = 0, used = 0;
    for (size_t i = 0; i < b->count; i++) mean += (double)sl_rgb_mean(b->reference[i].value) / (double)b->count;
    for (size_t i = 0; i < b->count; i++) {
        const float *x = &b->result[i].value.r, *r = &b->reference[i].value.r;
        for (int c = 0; c < 3; c++) {
            if (!((double)r[c] > 1e-3 * mean)) continue;
            double error = ((double)x[c] - (double)r[c]) / (double)r[c];
            sum += error * error;
            used++;
        }
    }
    *excluded = 1.0 - used / (3.0 * (double)b->count);
    return used > 0 ? sqrt(sum / used) : 0.0;
}

/* rms of |grad_t E - reference| / E in 1/m, green channel; with NULL for the gathers, of the reference itself. */
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
    sl_gather_settings s = sl_gather_defaults();
    s.kind = SL_GATHER_RAYS;
    s.size = REFERENCE_SIZE;
    s.direct = SL_DIRECT_RAYS;
    run(b, &s, 1, b->reference);
    printf("  %-9s %-12s %10s %10s %10s %10s %9s %12s\n", "gather", "lit by", "create ms", "see ms", "ms", "rel. RMS", "excluded", "grad 1/m");
    for (int direct = 0; direct < 2; direct++) {
        for (int kind = 1; kind < 4; kind++) {
            double excluded;
            s = sl_gather_defaults();
            s.kind = (sl_gather_kind)kind;
            s.size = SIZE;
            s.direct = direct ? SL_DIRECT_SHADOW_MAPS : SL_DIRECT_RAYS;
            if (direct && (b->scene->emitter_count || b->scene->environment.present)) continue;
            figures f = run(b, &s, REPETITIONS, b->result);
            double rms = relative_rms(b, &excluded);
            printf("  %-9s %-12s %10.2f %10.3f %10.3f %9.2f%% %8.1f%% %12.4f\n", names[kind], direct ? "shadow maps" : "rays",
                   f.create_ms, f.see_ms, f.gather_ms, 100 * rms, 100 * excluded,
                   gradient_rms(b, b->result));
        }
    }
    double mean = 0;
    for (size_t i = 0; i < b->count; i++) mean += (double)b->reference[i].value.g / (double)b->count;
    printf("  reference: mean irradiance %.6g, gradient %.4f 1/m\n", mean, gradient_rms(b, NULL));
    s = sl_gather_defaults();
    printf("  auto chooses %s\n", names[run(b, &s, 1, b->result).kind]);
}

int main(int argc, char **argv) {
    bench *b = sl_allocate(1, sizeof *b);
    if (!b) return 1;
    if (argc < 2) fprintf(stderr, "bench_gather: which scenes? bench_gather SCENE...\n");
    for (int i = 1; i < argc; i++) {
        sl_error error;
        if (sl_scene_load(argv[i], &b->scene, &error) != SL_OK) stop(argv[i], &error);
        if (sl_raster_create(b->scene, 1, &b->raster, &error) != SL_OK) stop("rasterizer", &error);
        if (sl_tracer_create(b->scene, 1, NULL, &b->tracer, &error) != SL_OK) stop("tracer", &error);
        choose_points(b);
        printf("%s: %zu triangles, %zu lights, %zu emitters%s, %zu points, isa %s\n", argv[i], b->scene->triangle_count,
               b->scene->light_count, b->scene->emitter_count, b->scene->environment.present ? ", environment" : "", b->count,
               sl_isa_name(sl_isa_best()));
        measure(b);
        fflush(stdout);
        sl_tracer_destroy(b->tracer);
        sl_raster_destroy(b->raster);
        sl_scene_destroy(b->scene);
    }
    sl_free(b);
    return argc < 2 ? 2 : 0;
}
