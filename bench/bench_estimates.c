/* How well errors are estimated without a reference: pictures by every method and quality, their error
 * measured against a path traced reference of the same light paths, beside what probes say of them, with many
 * seeds. The table of docs/error-estimates.md.
 *
 *     bench_estimates [--size N] [--spp N] [--seeds N] [SCENE ...] */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cache/frame/settings.h"

enum { QUALITIES = 3, SEEDS_MAX = 100, PROBES = 512, PROBE_SAMPLES = 32 };

typedef struct options {
    int size;
    uint32_t spp;
    unsigned seeds;
} options;

typedef struct totals {
    unsigned estimates, held, held_below, judged, promised, false_promises, accepted;
    double samples;
} totals;

static void check(sl_status status, const sl_error *error) {
    if (status == SL_OK) return;
    fprintf(stderr, "bench_estimates: %s\n", error->message);
    exit((int)status);
}

static sl_settings settings_for(const options *o, const char *method, const char *transport) {
    sl_settings s = sl_settings_default();
    s.method = method;
    s.transport = transport;
    s.width = s.height = o->size;
    s.threads = 1;
    return s;
}

static sl_image *render(const sl_scene *scene, const sl_settings *settings) {
    sl_error error;
    sl_method *method;
    sl_image *image;
    sl_progress progress = {0};
    check(sl_method_create(scene, settings, &method, &error), &error);
    while (!progress.done) check(sl_method_update(method, &progress, &error), &error);
    check(sl_method_resolve(method, &image, &error), &error);
    sl_method_destroy(method);
    return image;
}

/* sl_comparison.rel_rmse over the pixels that show surfaces, less what the reference's noise adds. *noise:
 * that, relative too. */
static double measured(const sl_image *image, const sl_image *reference, const sl_image *surfaces,
                       double *noise) {
    const sl_compare_options of_surfaces = {.mask = surfaces};
    sl_error error;
    sl_comparison c;
    sl_error_estimate own;
    check(sl_image_compare(image, reference, &of_surfaces, &c, NULL, &error), &error);
    check(sl_error_estimate_from_halves(reference, surfaces, &own, &error), &error);
    double square = c.rmse * c.rmse - own.rmse * own.rmse, mean = fabs(c.mean_reference);
    *noise = mean > 0.0 ? own.rmse / mean : 0.0;
    return mean > 0.0 && square > 0.0 ? sqrt(square) / mean : 0.0;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, unsigned count) {
    qsort(values, count, sizeof *values, ascending);
    return count % 2 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

typedef struct judged {
    double truth, noise, estimate[SEEDS_MAX], bound[SEEDS_MAX];
    unsigned held, held_below;
} judged;

static void print_rows(const char *scene, const char *method, judged rows[QUALITIES], unsigned seeds) {
    static const char *const names[QUALITIES] = {"draft", "normal", "high"};
    for (int q = 0; q < QUALITIES; q++) {
        judged *r = &rows[q];
        printf("| %s | %s | %s | %.2f | %.2f | %.2f | %.2f | %u of %u |\n", scene, method, names[q],
               100.0 * r->truth, 100.0 * r->noise, 100.0 * median(r->estimate, seeds),
               100.0 * median(r->bound, seeds), r->held, seeds);
    }
    fflush(stdout);
}

/* What --error does: may a picture that is off by `truth` be promised to be within somewhat less, or not be
 * within somewhat more? */
static void judge(const sl_scene *scene, const sl_settings *settings, const sl_image *image, double truth,
                  totals *t) {
    sl_error error;
    sl_error_probe *probe;
    sl_error_estimate e;
    if (!(truth > 0.02)) return; /* smaller ones take tens of millions of samples each */
    check(sl_error_probe_create(scene, settings, &probe, &error), &error);
    check(sl_error_probe_judge(probe, image, 0.95 * truth, 0, &e, &error), &error);
    t->judged++;
    t->false_promises += e.bound <= 0.95 * truth;
    check(sl_error_probe_judge(probe, image, 1.25 * truth, 0, &e, &error), &error);
    t->accepted += e.bound <= 1.25 * truth;
    t->samples += (double)e.samples;
    sl_error_probe_destroy(probe);
}

static void one_method(const options *o, const sl_scene *scene, const char *name, const char *method,
                       totals *t) {
    char transport[64];
    judged rows[QUALITIES] = {{0}};
    sl_image *images[QUALITIES];
    sl_error error;
    sl_settings settings = settings_for(o, method, NULL);
    snprintf(transport, sizeof transport, "matched:%s", method);
    sl_settings truth = settings_for(o, "path", transport);
    truth.spp = o->spp;
    truth.seed = 1000003;
    sl_image *reference = render(scene, &truth);
    sl_error_probe *viewer;
    check(sl_error_probe_create(scene, &settings, &viewer, &error), &error);
    for (int q = 0; q < QUALITIES; q++) {
        settings.quality = (sl_quality)q;
        images[q] = render(scene, &settings);
        rows[q].truth = measured(images[q], reference, sl_error_probe_surfaces(viewer), &rows[q].noise);
    }
    for (unsigned seed = 0; seed < o->seeds; seed++) {
        sl_error_probe *probe;
        settings.seed = seed;
        check(sl_error_probe_create(scene, &settings, &probe, &error), &error);
        for (int q = 0; q < QUALITIES; q++) {
            sl_error_estimate e;
            check(sl_error_probe_estimate(probe, images[q], PROBES, PROBE_SAMPLES, &e, &error), &error);
            rows[q].estimate[seed] = e.rel_rmse;
            rows[q].bound[seed] = e.bound;
            rows[q].held += e.bound >= rows[q].truth;
            rows[q].held_below += e.least <= rows[q].truth;
        }
        sl_error_probe_destroy(probe);
    }
    for (int q = 0; q < QUALITIES; q++) {
        t->estimates += o->seeds;
        t->held += rows[q].held;
        t->held_below += rows[q].held_below;
        settings.seed = 999;
        if (q < 2) judge(scene, &settings, images[q], rows[q].truth, t);
        sl_image_destroy(images[q]);
    }
    sl_image_destroy(reference);
    sl_error_probe_destroy(viewer);
    print_rows(name, method, rows, o->seeds);
}

static void one_scene(const options *o, const char *path, totals *t) {
    static const char *const methods[] = {"splatting", "direct-radiance", "light-octree", "multi-mesh",
                                          "shading-cache"};
    sl_error error;
    sl_scene *scene;
    char name[64];
    const char *slash = strrchr(path, '/');
    snprintf(name, sizeof name, "%s", slash ? slash + 1 : path);
    name[strcspn(name, ".")] = '\0';
    check(sl_scene_load_with(path, &(sl_load_options){.allow_outside = true}, &scene, &error), &error);
    for (size_t i = 0; i < sizeof methods / sizeof methods[0]; i++) one_method(o, scene, name, methods[i], t);
    sl_scene_destroy(scene);
}

int main(int argc, char **argv) {
    static const char *const scenes[] = {"scenes/cornell.json",        "scenes/cornell-glossy.json",
                                         "scenes/cornell-point.json",  "scenes/cornell-mirror.json",
                                         "scenes/two-rooms.json",      "scenes/vase.json",
                                         "scenes/generated/room.json", "scenes/generated/atrium.json"};
    options o = {128, 512, 20};
    totals t = {0};
    int i = 1;
    for (; i + 1 < argc && strncmp(argv[i], "--", 2) == 0; i += 2) {
        int value = atoi(argv[i + 1]);
        if (strcmp(argv[i], "--size") == 0) o.size = value;
        else if (strcmp(argv[i], "--spp") == 0) o.spp = (uint32_t)value;
        else if (strcmp(argv[i], "--seeds") == 0) o.seeds = (unsigned)(value < SEEDS_MAX ? value : SEEDS_MAX);
    }
    printf("| scene | method | quality | measured %% | reference's noise %% | estimated %% | bound %% | "
           "bounds held |\n"
           "| --- | --- | --- | ---: | ---: | ---: | ---: | ---: |\n");
    if (i < argc) {
        for (; i < argc; i++) one_scene(&o, argv[i], &t);
    } else {
        for (size_t s = 0; s < sizeof scenes / sizeof scenes[0]; s++) one_scene(&o, scenes[s], &t);
    }
    printf("\n%u of %u upper bounds and %u of them from below held. Judged by 0.95 of the true error, %u of "
           "%u pictures were promised falsely;"
           " by 1.25 of it %u were promised, with %.3g million samples each.\n",
           t.held, t.estimates, t.held_below, t.false_promises, t.judged, t.accepted,
           t.judged ? 1e-6 * t.samples / t.judged : 0.0);
    return 0;
}
