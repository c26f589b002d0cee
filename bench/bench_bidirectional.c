/* The bidirectional path tracer beside the path tracer: what noise each has after how much time. A picture's
 * variance comes from its two halves and falls as 1 / time, so relMSE times processor time is what a picture
 * costs, whatever its quality. Where the path tracer cannot find some light at all its mean is lower: that is
 * told beside.
 *
 *     bench_bidirectional [SCENE ...]      scene files; without any, the table of docs/bidirectional.md */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/counters.h"
#include "timing.h"
#include "trace/bidirectional/bidirectional.h"

enum {
    SIZE = 64,
    PIXELS = SIZE * SIZE,
    VALUES = 3 * PIXELS,
    RUNS = 1,
    PATH_SAMPLES = 64,
    SAMPLES = 32,
    REFERENCE_SAMPLES = 64
};

typedef struct picture {
    float planes[3][VALUES]; /* all, even, odd samples */
    double ms, samples, rays;
} picture;

static void check(sl_status status, const sl_error *error) {
    if (status == SL_OK) return;
    fprintf(stderr, "%s\n", error->message);
    exit((int)status);
}

static void render_path(const sl_scene *scene, const sl_tracer *tracer, const sl_transport *transport,
                        uint64_t seed, picture *p) {
    sl_path_tracer *film;
    sl_error error;
    sl_counters counters = {{0}};
    sl_path_settings settings = {SIZE, SIZE, 1, seed, *transport};
    check(sl_path_tracer_create(scene, tracer, &settings, &film, &error), &error);
    double start = process_ms();
    for (uint64_t i = 0; i < PATH_SAMPLES; i++)
        check(sl_path_tracer_sample(film, i, &counters, &error), &error);
    p->ms = process_ms() - start;
    p->samples = (double)PATH_SAMPLES * PIXELS;
    p->rays = (double)(counters.value[SL_COUNT_RAYS] + counters.value[SL_COUNT_SHADOW_RAYS]);
    for (int half = -1; half < 2; half++) {
        float *plane = p->planes[half + 1];
        sl_path_tracer_mean(film, half, plane, plane + PIXELS, plane + 2 * PIXELS);
    }
    sl_path_tracer_destroy(film);
}

static void render_both(const sl_scene *scene, const sl_tracer *tracer, const sl_transport *transport,
                        uint64_t seed, unsigned samples, bool direct_image, bool without_light_image,
                        picture *p) {
    sl_bidirectional *film;
    sl_error error;
    sl_counters counters = {{0}};
    sl_bidirectional_settings settings = {.width = SIZE,
                                          .height = SIZE,
                                          .threads = 1,
                                          .seed = seed,
                                          .transport = *transport,
                                          .direct_image = direct_image,
                                          .without_light_image = without_light_image};
    check(sl_bidirectional_create(scene, tracer, &settings, &film, &error), &error);
    double start = process_ms();
    for (uint64_t i = 0; i < samples; i++) check(sl_bidirectional_sample(film, i, &counters, &error), &error);
    p->ms = process_ms() - start;
    p->samples = (double)samples * PIXELS;
    p->rays = (double)(counters.value[SL_COUNT_RAYS] + counters.value[SL_COUNT_SHADOW_RAYS]);
    for (int half = -1; half < 2; half++) {
        float *plane = p->planes[half + 1];
        sl_bidirectional_mean(film, half, plane, plane + PIXELS, plane + 2 * PIXELS);
    }
    sl_bidirectional_destroy(film);
}

static double mean_of(const float *values) {
    double sum = 0.0;
    for (int i = 0; i < VALUES; i++) sum += (double)values[i] / VALUES;
    return sum;
}

/* Mean of (A - B)^2 / 4 over r^2 + 0.01 mean(r)^2 as in sl_image_compare(), r of a better picture; without
 * the values of the largest 0.1 %, which decide a mean of few samples alone. */
static double noise_of(const picture *p, const float *r) {
    static double terms[VALUES];
    double mean = mean_of(r), sum = 0.0;
    for (int i = 0; i < VALUES; i++) {
        double d = 0.5 * ((double)p->planes[1][i] - (double)p->planes[2][i]);
        terms[i] = d * d / ((double)r[i] * (double)r[i] + 0.01 * mean * mean);
    }
    qsort(terms, VALUES, sizeof *terms, by_value);
    int kept = VALUES - VALUES / 1000;
    for (int i = 0; i < kept; i++) sum += terms[i] / kept;
    return sum;
}

typedef enum { PATH, USUAL, ALL_WAYS, NO_LIGHT_IMAGE, KINDS } kind;

static void compare(const char *name, const sl_scene *scene, const sl_tracer *tracer,
                    const char *transport_name) {
    static picture reference, p;
    sl_transport transport;
    sl_transport_named(transport_name, &transport);
    transport.emission = false; /* a lamp seen, or seen in a mirror, is the same noise in both */
    render_both(scene, tracer, &transport, 99, REFERENCE_SAMPLES, false, false, &reference);
    double cost[KINDS][RUNS], us[KINDS][RUNS], middle[KINDS], rays[KINDS], mean[KINDS] = {0.0};
    for (uint64_t run = 0; run < RUNS; run++) {
        for (kind k = PATH; k < KINDS; k++) {
            if (k == PATH) render_path(scene, tracer, &transport, run + 1, &p);
            else
                render_both(scene, tracer, &transport, run + 1, SAMPLES, k == ALL_WAYS, k == NO_LIGHT_IMAGE,
                            &p);
            cost[k][run] = 1e-3 * p.ms * noise_of(&p, reference.planes[0]);
            us[k][run] = 1e3 * p.ms / p.samples;
            rays[k] = p.rays / p.samples;
            mean[k] += mean_of(p.planes[0]) / RUNS;
        }
    }
    for (kind k = PATH; k < KINDS; k++) middle[k] = median(cost[k], RUNS);
    printf("| %s | %s | %.2f | %.1f | %.2f | %.1f | %.1e | %.1e | **%.2f** | %.2f | %.2f | %+.1f %% |\n",
           name, transport_name, median(us[PATH], RUNS), rays[PATH], median(us[USUAL], RUNS), rays[USUAL],
           middle[PATH], middle[USUAL], middle[PATH] / middle[USUAL], middle[PATH] / middle[ALL_WAYS],
           middle[PATH] / middle[NO_LIGHT_IMAGE], 100.0 * (mean[PATH] / mean[USUAL] - 1.0));
    fflush(stdout);
}

static const char *file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

int main(int argc, char **argv) {
    static const char *const usual[] = {
        "scenes/cornell.json",        "scenes/cornell-glossy.json",      "scenes/cornell-point.json",
        "scenes/cornell-mirror.json", "bench/scenes/cornell-balls.json", "scenes/mirror-balls.json",
        "scenes/two-rooms.json",      "bench/scenes/cornell-upward.json"};
    size_t count = argc > 1 ? (size_t)argc - 1 : sizeof usual / sizeof *usual;
    printf("%d x %d pixels, one thread; us and rays: a sample of a pixel; relMSE s: of the whole picture.\n",
           SIZE, SIZE);
    printf("Gain: relMSE s of path over bidirectional; with the way s = 2, t = 1 too; without t = 1. Mean: "
           "of path, to bidirectional.\n\n");
    printf("| scene | transport | path us | rays | bidirectional us | rays | path relMSE s | bidirectional "
           "relMSE s | gain | all ways | "
           "no light image | mean |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- "
           "|\n");
    for (size_t i = 0; i < count; i++) {
        static const char *const transports[] = {"direct", "one-bounce", "full"};
        const char *path = argc > 1 ? argv[i + 1] : usual[i];
        sl_error error;
        sl_scene *scene;
        sl_tracer *tracer;
        check(sl_scene_load_with(path, &(sl_load_options){.allow_outside = true}, &scene, &error), &error);
        check(sl_tracer_create(scene, 1, NULL, &tracer, &error), &error);
        for (int t = 0; t < 3; t++) compare(file_name(path), scene, tracer, transports[t]);
        sl_tracer_destroy(tracer);
        sl_scene_destroy(scene);
    }
    return 0;
}
