/* What a gather costs, and what it is worth.
 *
 *     build/bench/bench_gather SCENE...          one 64 x 64 gather by plane, hemicube and rays
 *     build/bench/bench_gather --auto [SCENE...] the cost model against clocks: does `--gather auto` pick right?
 *     build/bench/bench_gather --fit [SCENE...]  the cost model's constants, fitted anew
 *
 * The first form prints milliseconds, visibility alone and with shading, on one thread, beside the relative RMS error (and
 * that of the translational gradient over E) against jittered ray gathers of 256 x 256 at the same points. Times are the
 * thread's processor time, medians of five repetitions over the same points; the points are what the scene's camera sees in
 * 200 random pixels. Shadow maps are measured where all lights are without extent, which is where they are meant to be used.
 * The others take 32 points, N = 16 to 256 and, without names, every scene of scenes/ and scenes/generated/. */
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "gather_bench.h"
#include "timing.h"

enum { REPETITIONS = 5, SIZE = 64, MODEL_POINTS = 32, SCENES_MAX = 64 };

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
        bench_stop("gather", &error);
    }
    if (sl_gather_scratch_create(gather, &scratch, &error) != SL_OK) bench_stop("scratch", &error);
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
    double left = bench_reference(b);
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
            double rms = bench_relative_rms(b, &excluded);
            printf("  %-9s %-12s %10.2f %10.3f %10.3f %9.2f%% %8.1f%% %12.4f\n", names[kind], direct ? "shadow maps" : "rays",
                   f.create_ms, f.see_ms, f.gather_ms, 100 * rms, 100 * excluded,
                   gradient_rms(b, b->result));
        }
    }
    double mean = 0;
    for (size_t i = 0; i < b->count; i++) mean += (double)b->reference[i].value.g / (double)b->count;
    printf("  reference: mean irradiance %.6g, its own error %.2f%%, gradient %.4f 1/m\n", mean, 100 * left, gradient_rms(b, NULL));
    s = sl_gather_defaults();
    printf("  auto chooses %s\n", names[run(b, &s, 1, b->result).kind]);
}

static void errors_of(bench *b, char *const *paths, int count) {
    for (int i = 0; i < count; i++) {
        bench_open(b, paths[i], POINTS);
        printf("%s: %zu triangles, %zu lights, %zu emitters%s, %zu points, isa %s\n", paths[i], b->scene->triangle_count,
               b->scene->light_count, b->scene->emitter_count, b->scene->environment.present ? ", environment" : "", b->count,
               sl_isa_name(sl_isa_best()));
        measure(b);
        fflush(stdout);
        bench_close(b);
    }
}

static const char *name_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static void model_of(bench *b, char *const *paths, int count, bool refit) {
    static gather_case cases[SCENES_MAX * SIZES];
    if (count > SCENES_MAX) count = SCENES_MAX;
    for (int i = 0; i < count; i++) {
        bench_open(b, paths[i], MODEL_POINTS);
        double left = bench_reference(b);
        fprintf(stderr, "%s: %zu triangles, %zu points, reference's own error %.2f %%\n", paths[i], b->scene->triangle_count, b->count,
                100.0 * left);
        gather_measure(b, name_of(paths[i]), &cases[i * SIZES]);
        bench_close(b);
    }
    gather_auto_table(cases, count * SIZES);
    gather_error_table(cases, count * SIZES);
    if (refit) gather_fit_table(cases, count * SIZES);
}

int main(int argc, char **argv) {
    bool refit = argc > 1 && !strcmp(argv[1], "--fit"), model = refit || (argc > 1 && !strcmp(argv[1], "--auto"));
    char *const *paths = argv + 1 + model;
    int count = argc - 1 - model;
    glob_t found = {0};
    if (model && count == 0 && glob("scenes/*.json", 0, NULL, &found) == 0) {
        glob("scenes/generated/*.json", GLOB_APPEND, NULL, &found);
        paths = found.gl_pathv;
        count = (int)found.gl_pathc;
    }
    bench *b = sl_allocate(1, sizeof *b);
    if (!b) return 1;
    if (count < 1) fprintf(stderr, "usage: bench_gather SCENE... | --auto [SCENE...] | --fit [SCENE...]\n");
    else if (model) model_of(b, paths, count, refit);
    else errors_of(b, paths, count);
    globfree(&found);
    sl_free(b);
    return count < 1 ? 2 : 0;
}
