/* Section 7 of the paper: a furnished room of 7,000 triangles with one area light, 640 x 480.
 *
 *   samples   how many: of the coarse mesh, of direct and of indirect light, for pictures of several
 * qualities, with their errors; how many bytes an element of the meshes takes; seconds to the first picture,
 * to one within 15 % of the reference (relRMSE), to the end passes    a picture from cached samples, pass by
 * pass costs     a sample of direct and one of indirect light; the coarse mesh threads   all of it with two
 * threads, by a clock
 *
 * Processor time of one thread unless it says otherwise.
 *
 *     build/bench/bench_mesh_room [--brief|--once] [--pictures] [--out FOLDER] */
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "cache/multi_mesh/coarse.h"
#include "cache/multi_mesh/gather.h"
#include "cache/patches/mesh.h"
#include "cache/multi_mesh/multi_mesh_internal.h"
#include "mesh_bench.h"
#include "timing.h"

static const char room[] = "scenes/generated/room.json";
static const double useful = 0.15; /* relRMSE */
enum { REPETITIONS = 15 };

/* ---- samples ---- */

typedef struct trial {
    const char *name;
    sl_quality quality;
    bool papers_leaves;    /* leaves of 16 pixels, coarse mesh of depth 3: what its words come to */
} trial;

static const trial trials[] = {{"draft", SL_QUALITY_DRAFT, false},
                               {"normal", SL_QUALITY_NORMAL, false},
                               {"normal, 16-pixel leaves", SL_QUALITY_NORMAL, true},
                               {"high", SL_QUALITY_HIGH, false}};
enum { TRIALS = sizeof trials / sizeof trials[0] };

typedef struct outcome {
    double first, useful, all; /* seconds */
    bench_error error[MESH_PARTS];
} outcome;

static sl_settings settings_of(const mesh_world *w, const trial *t) {
    sl_settings s = mesh_settings(w, t->quality);
    if (t->papers_leaves) {
        s.multi_mesh.leaf_area = 16.0;
        s.multi_mesh.leaf_edge = 8.0;
        s.multi_mesh.coarse_depth = 3;
    }
    return s;
}

/* A picture is looked at whenever a tenth more time has gone by. */
static outcome converge(const mesh_world *w, mesh_run *run) {
    outcome o = {0};
    double next = 0.0, picture;
    sl_image *image;
    while (!run->done) {
        mesh_run_step(run);
        if (o.first == 0.0 &&
            mesh_run_count(run, SL_COUNT_LIGHT_SAMPLES) > mesh_run_count(run, SL_COUNT_COARSE_SAMPLES))
            o.first = run->seconds;
        if (o.useful > 0.0 || run->seconds < next) continue;
        next = 1.1 * run->seconds;
        image = mesh_run_picture(run, &picture);
        mesh_judge(w, image, o.error);
        sl_image_destroy(image);
        if (o.error[MESH_ALL].rel_rmse < useful) o.useful = run->seconds + picture;
    }
    image = mesh_run_picture(run, &picture);
    mesh_judge(w, image, o.error);
    o.all = run->seconds + picture;
    sl_image_destroy(image);
    return o;
}

static void write_pictures(const bench_report *r, const char *what, mesh_run *run) {
    sl_image *image = mesh_run_picture(run, NULL);
    bench_write_picture(r, "room", what, image);
    sl_image_destroy(image);
}

static void say_memory(bench_report *r, const char *name, const mesh_run *run) {
    static const char *const kinds[SL_MESH_KINDS] = {"direct", "specular", "indirect", "irradiance",
                                                     "coarse"};
    sl_mesh_census c[SL_MESH_KINDS], all = {0};
    sl_multi_mesh_census(run->state, c);
    for (int k = 0; k < SL_MESH_KINDS; k++) {
        if (!c[k].leaves) continue;
        bench_row(r, "%s|%s|%zu|%zu|%zu|%.0f|%.0f", name, kinds[k], c[k].leaves, c[k].vertices, c[k].known,
                  (double)c[k].bytes / 1024.0, (double)c[k].bytes / (double)c[k].leaves);
        all.leaves += c[k].leaves;
        all.vertices += c[k].vertices;
        all.known += c[k].known;
        all.bytes += c[k].bytes;
    }
    bench_row(r, "%s|all|%zu|%zu|%zu|%.0f|%.0f", name, all.leaves, all.vertices, all.known,
              (double)all.bytes / 1024.0, (double)all.bytes / (double)all.leaves);
}

static void table_of_samples(bench_report *r, const bench_options *o, const mesh_world *w) {
    mesh_run run[TRIALS];
    outcome out[TRIALS];
    bench_table(r, "samples",
                "quality|coarse|direct|of these drawn|indirect|splits|undone|relRMSE %|relMSE|without the "
                "largest 0.1 %|direct %|indirect %|bias %|first s|useful s|all s");
    bench_row(r, "the paper|9200|26000||9000|||||||||||104 (its rates)");
    for (int t = 0; t < TRIALS; t++) {
        sl_settings s = settings_of(w, &trials[t]);
        char mse[32];
        mesh_run_open(&run[t], w->scene, &s);
        out[t] = converge(w, &run[t]);
        const bench_error *e = out[t].error;
        uint64_t light = mesh_run_count(&run[t], SL_COUNT_LIGHT_SAMPLES);
        bench_row(r, "%s|%llu|%llu|%llu|%llu|%llu|%llu|%.2f|%s|%.2e|%.2f|%.2f|%+.2f|%.2f|%.2f|%.2f",
                  trials[t].name, (unsigned long long)mesh_run_count(&run[t], SL_COUNT_COARSE_SAMPLES),
                  (unsigned long long)light, (unsigned long long)mesh_run_drawn(&run[t]),
                  (unsigned long long)mesh_run_count(&run[t], SL_COUNT_INDIRECT_SAMPLES),
                  (unsigned long long)mesh_run_count(&run[t], SL_COUNT_SPLITS),
                  (unsigned long long)mesh_run_count(&run[t], SL_COUNT_COLLAPSES),
                  100.0 * e[MESH_ALL].rel_rmse, bench_mse_text(&e[MESH_ALL], mse), e[MESH_ALL].trimmed,
                  100.0 * e[MESH_DIRECT].rel_rmse, 100.0 * e[MESH_INDIRECT].rel_rmse,
                  100.0 * e[MESH_ALL].bias, out[t].first, out[t].useful, out[t].all);
        if (o->pictures)
            write_pictures(r, trials[t].papers_leaves ? "small-leaves" : trials[t].name, &run[t]);
    }
    bench_table(r, "memory", "quality|mesh|leaves|vertices|with a value|KiB|bytes a leaf");
    for (int t = 0; t < TRIALS; t++) {
        say_memory(r, trials[t].name, &run[t]);
        mesh_run_close(&run[t]);
    }
}

/* ---- passes: a picture from cached samples ---- */

enum { PASSES_MAX = 16 };
typedef struct stopwatch {
    unsigned threads;
    double last;           /* when the last pass ended */
    int count, repetition;
    const char *name[PASSES_MAX];
    double ms[PASSES_MAX][REPETITIONS];
} stopwatch;

static void pass_done(void *context, const sl_pass *pass) {
    stopwatch *w = context;
    double now = mesh_seconds(w->threads);
    int i = 0;
    while (i < w->count && strcmp(w->name[i], pass->name) != 0) i++;
    if (i == w->count && w->count < PASSES_MAX) w->name[w->count++] = pass->name;
    if (i < PASSES_MAX) w->ms[i][w->repetition] = 1e3 * (now - w->last);
    w->last = mesh_seconds(w->threads);
}

/* The eye is said to have moved: identifiers, materials and all pictures are made anew, and no sample is
 * asked for. */
static double picture_from_cache(mesh_run *run, stopwatch *watch, double *view, double *resolve) {
    double from = mesh_seconds(run->threads);
    uint64_t samples =
        mesh_run_count(run, SL_COUNT_LIGHT_SAMPLES) + mesh_run_count(run, SL_COUNT_INDIRECT_SAMPLES);
    mesh_run_edit(run, SL_CHANGED_CAMERA);
    watch->last = mesh_seconds(run->threads);
    mesh_run_step(run);
    *view = mesh_seconds(run->threads) - from;
    watch->last = mesh_seconds(run->threads);
    sl_image_destroy(mesh_run_picture(run, resolve));
    while (!run->done) mesh_run_step(run);
    if (mesh_run_count(run, SL_COUNT_LIGHT_SAMPLES) + mesh_run_count(run, SL_COUNT_INDIRECT_SAMPLES) !=
        samples)
        bench_fail("samples were asked for again", NULL);
    return *view + *resolve;
}

static void table_of_passes(bench_report *r, const bench_options *o, const mesh_world *w, unsigned threads) {
    static stopwatch watch;
    int repetitions = o->once ? 5 : REPETITIONS;
    sl_settings s = mesh_settings(w, SL_QUALITY_NORMAL);
    mesh_run run;
    double whole[REPETITIONS], view[REPETITIONS], resolve[REPETITIONS];
    watch = (stopwatch){.threads = threads};
    const sl_observer observer = {&watch, pass_done};
    s.threads = threads;
    mesh_run_open(&run, w->scene, &s);
    while (!run.done) mesh_run_step(&run);
    for (int i = 0; i < repetitions; i++)
        whole[i] = 1e3 * picture_from_cache(&run, &watch, &view[i], &resolve[i]);
    mesh_run_close(&run);
    s.observer = &observer;
    mesh_run_open(&run, w->scene, &s);
    /* what an observer gets to see of meshes takes longer than they do */
    ((sl_multi_mesh_state *)run.state)->announcer.names_alone = true;
    while (!run.done) mesh_run_step(&run);
    watch.count = 0;
    for (watch.repetition = 0; watch.repetition < repetitions; watch.repetition++) {
        double ignored[2];
        picture_from_cache(&run, &watch, &ignored[0], &ignored[1]);
    }
    mesh_run_close(&run);
    bench_table(r, threads > 1 ? "passes-2" : "passes", "pass|ms|share %|paper ms");
    double sum = 0.0;
    for (int i = 0; i < watch.count; i++) sum += median(watch.ms[i], repetitions);
    for (int i = 0; i < watch.count; i++) {
        const char *name = watch.name[i];
        const char *paper = strstr(name, "identifiers")                        ? "40"
                            : strstr(name, "k_d")                              ? "12"
                            : strstr(name, "mesh") || strstr(name, "radiance") ? "12"
                            : strstr(name, "merge")                            ? "10"
                                                                               : "";
        double ms = median(watch.ms[i], repetitions);
        if (ms > 0.0) bench_row(r, "%s|%.2f|%.0f|%s", name, ms, 100.0 * ms / sum, paper);
    }
    double v = 1e3 * median(view, repetitions), p = 1e3 * median(resolve, repetitions);
    bench_row(r, "all, without being watched|%.2f||100", median(whole, repetitions));
    bench_say(r, "\n%u thread%s, %s: %.1f ms until the view is known, %.1f ms for the picture.\n", threads,
              threads > 1 ? "s" : "", threads > 1 ? "by a clock" : "processor time", v, p);
}

/* ---- costs of samples ---- */

typedef struct studio {
    sl_raster *raster;
    sl_topology *topology;
    sl_sampled_lights *lights;
    sl_light_sampling *sampling;
    sl_coarse_light *light;
    sl_coarse *coarse;
    double coarse_seconds;
    uint64_t coarse_samples;
} studio;

static void need(sl_status status, const char *what, const sl_error *error) {
    if (status != SL_OK) bench_fail(what, error);
}

static void studio_open(const mesh_world *w, int depth, studio *s) {
    sl_error error = {0};
    sl_light_sample_settings sampling = sl_light_sample_defaults();
    need(sl_raster_create(w->scene, 1, &s->raster, &error), "raster", &error);
    need(sl_topology_create(w->scene, false, &s->topology, &error), "topology", &error);
    need(sl_sampled_lights_find(w->scene, &s->lights, &error), "lights", &error);
    need(sl_light_sampling_create(w->scene, s->raster, w->tracer, s->lights, &sampling, &s->sampling, &error),
         "lights", &error);
    sl_coarse_light_settings light = {.scene = w->scene,
                                      .topology = s->topology,
                                      .tracer = w->tracer,
                                      .lights = s->lights,
                                      .sampling = s->sampling,
                                      .threads = 1};
    need(sl_coarse_light_create(&light, &s->light, &error), "coarse mesh", &error);
    sl_coarse_settings coarse = {w->scene->diagonal / 24.0f, depth};
    need(sl_coarse_create(w->scene, s->topology, &coarse, &s->coarse, &error), "coarse mesh", &error);
}

static void light_coarse(studio *s) {
    size_t count = s->coarse->vertex_count;
    sl_rgb *radiance = sl_allocate(count, sizeof *radiance);
    sl_counters counters = {{0}};
    if (!radiance) bench_fail("memory", NULL);
    double from = mesh_seconds(1);
    sl_coarse_light_take(s->light, count, s->coarse->vertex, radiance, &counters);
    for (size_t i = 0; i < count; i++) sl_coarse_set(s->coarse, i, radiance[i]);
    sl_coarse_finish(s->coarse, 1);
    s->coarse_seconds = mesh_seconds(1) - from;
    s->coarse_samples = counters.value[SL_COUNT_LIGHT_SAMPLES];
    sl_free(radiance);
}

static double light_ms(const studio *s, size_t count, const sl_gather_point *points) {
    sl_light_sample_scratch *scratch;
    sl_counters counters = {{0}};
    sl_error error;
    need(sl_light_sample_scratch_create(s->sampling, &scratch, &error), "light", &error);
    double from = now_ms();
    for (size_t i = 0; i < count; i++) {
        sl_lit_point point = {points[i].position, points[i].normal, points[i].geometric_normal,
                              points[i].triangle};
        for (size_t l = 0; l < s->lights->count; l++)
            sl_light_sample_take(s->sampling, l, &point, scratch, &counters);
    }
    double ms = (now_ms() - from) / (double)(count * s->lights->count);
    sl_light_sample_scratch_destroy(scratch);
    return ms;
}

static double gather_ms(const mesh_world *w, const studio *s, int size, size_t count,
                        const sl_gather_point *points) {
    sl_mesh_gather_settings settings = {.size = size, .reduced = 16, .fov = 160.0f * 3.1415927f / 180.0f};
    sl_mesh_gather *gather;
    sl_mesh_gather_scratch *scratch;
    sl_counters counters = {{0}};
    sl_error error;
    need(sl_mesh_gather_create(w->scene, s->raster, s->coarse, &settings, &gather, &error), "gather", &error);
    need(sl_mesh_gather_scratch_create(gather, &scratch, &error), "gather", &error);
    double from = now_ms();
    for (size_t i = 0; i < count; i++) {
        sl_mesh_point point = {.position = points[i].position,
                               .normal = points[i].normal,
                               .geometric_normal = points[i].geometric_normal,
                               .triangle = points[i].triangle,
                               .face = 2 * points[i].triangle};
        sl_mesh_gather_take(gather, &point, scratch, &counters);
    }
    double ms = (now_ms() - from) / (double)count;
    sl_mesh_gather_scratch_destroy(scratch);
    sl_mesh_gather_destroy(gather);
    return ms;
}

static void table_of_costs(bench_report *r, const bench_options *o, const mesh_world *w) {
    enum { POINTS = 400 };
    static const int sizes[] = {64, 128, 256};
    static sl_gather_point points[POINTS];
    studio s = {0};
    size_t count = bench_visible_points(w->scene, w->tracer, o->brief ? 100 : POINTS, points);
    bench_table(r, "costs", "sample|ms|times a direct one|paper ms|times");
    studio_open(w, 4, &s);
    light_coarse(&s);
    light_ms(&s, count, points);
    double direct = light_ms(&s, count, points);
    bench_row(r, "direct, 64 x 64|%.4f|1|0.9|1", direct);
    for (int i = 0; i < 3; i++) {
        double ms = gather_ms(w, &s, sizes[i], count, points);
        bench_row(r, "indirect, %d x %d|%.4f|%.2f|%s|%s", sizes[i], sizes[i], ms, ms / direct,
                  sizes[i] == 256 ? "9" : "", sizes[i] == 256 ? "10" : "");
    }
    double vertices = (double)s.coarse->vertex_count, each = 1e3 * s.coarse_seconds / vertices;
    bench_row(r, "a coarse vertex|%.4f|%.2f|1.63|1.8", each, each / direct);
    bench_say(r,
              "\nThe coarse mesh (depth 4): %.0f vertices, %llu samples, %.2f s; the paper: 9,200 in 15 s. "
              "Direct samples are those of points that the camera sees: "
              "many need no picture.\n",
              vertices, (unsigned long long)s.coarse_samples, s.coarse_seconds);
    sl_coarse_destroy(s.coarse);
    sl_coarse_light_destroy(s.light);
    sl_light_sampling_destroy(s.sampling);
    sl_sampled_lights_destroy(s.lights);
    sl_topology_destroy(s.topology);
    sl_raster_destroy(s.raster);
}

/* ---- two threads ---- */

static double refine_wall(const mesh_world *w, unsigned threads, double *cpu) {
    sl_settings s = mesh_settings(w, SL_QUALITY_NORMAL);
    mesh_run run;
    s.threads = threads;
    double from = wall_ms(), cpu_from = process_ms();
    mesh_run_open(&run, w->scene, &s);
    while (!run.done) mesh_run_step(&run);
    sl_image_destroy(mesh_run_picture(&run, NULL));
    *cpu = 1e-3 * (process_ms() - cpu_from);
    mesh_run_close(&run);
    return 1e-3 * (wall_ms() - from);
}

static void say_threads(bench_report *r, const bench_options *o, const mesh_world *w) {
    double best[2] = {1e30, 1e30}, cpu[2] = {0};
    for (int i = 0; i < (o->once ? 1 : 3); i++)
        for (unsigned t = 1; t <= 2; t++) best[t - 1] = fmin(best[t - 1], refine_wall(w, t, &cpu[t - 1]));
    bench_say(r,
              "\nThreads, by a clock: one %.2f s, two %.2f s: %.2f times. Processor seconds of both "
              "together: %.2f and %.2f, so that at most %.2f "
              "times is to be had.\n",
              best[0], best[1], best[0] / best[1], cpu[0], cpu[1], 2.0 * cpu[0] / cpu[1]);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/multi-mesh");
    bench_report r;
    mesh_world w;
    bench_report_open(&r, &o, "mesh_room");
    if (mesh_world_open(&r, room, o.brief ? 160 : 640, o.brief ? 120 : 480, 8, o.brief ? 256 : 4096, &w)) {
        bench_say(&r, "\n%zu triangles, %d x %d, %u reference samples at %zu pixels.\n",
                  w.scene->triangle_count, w.pixels.width, w.pixels.height, w.reference[MESH_ALL].samples,
                  w.pixels.count);
        table_of_samples(&r, &o, &w);
        table_of_passes(&r, &o, &w, 1);
        if (!o.once) table_of_passes(&r, &o, &w, 2);
        table_of_costs(&r, &o, &w);
        say_threads(&r, &o, &w);
        mesh_world_close(&w);
    }
    bench_report_close(&r);
    return 0;
}
