/* Glossy surfaces: the error of their reflections alone, L G D E, by the order of the harmonics and by
 * accuracy. How far the finite order limits them is told apart from interpolation: once more, coefficients
 * are gathered at the very points that pixels show. The sky, which gathers see behind the surfaces, is
 * reflected by the records too, L G E, and so belongs to the reference.
 *
 * All pixels that are compared show a glossy surface; errors are relative to its reflection alone. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/random.h"
#include "cache/splatting/glossy.h"
#include "cache/splatting/plan.h"
#include "splat_bench.h"
#include "timing.h"

static const int orders[] = {3, 5, 7, 10, 12};
static const double accuracies[] = {0.5, 0.25, 0.15, 0.08};
enum { ORDERS = sizeof orders / sizeof *orders, ACCURACIES = sizeof accuracies / sizeof *accuracies };

typedef struct world {
    sl_scene *scene;
    sl_tracer *tracer;
    bench_pixels pixels;
    bench_reference reference;
    float *values[2];
    int size;
} world;

/* ---- the reference ---- */

/* L G D E; and of the part of the environment that gathers see, L G E. */
static void find_reference(world *w, uint32_t samples) {
    sl_transport bounce = {.sky_light = true,
                           .receiver_lobes = SL_LOBE_GLOSSY,
                           .bounce_lobes = SL_LOBE_DIFFUSE,
                           .bounces = 1,
                           .direct_visibility = true,
                           .bounce_visibility = true,
                           .filter = SL_FILTER_CENTRE};
    bench_reference_get(w->scene, w->tracer, &bounce, &w->pixels, samples, &w->reference);
    sl_environment sky, sun;
    sl_error error;
    if (!w->scene->environment.present) return;
    if (sl_environment_split(&w->scene->environment, SL_SKY_CONTRAST, &sky, &sun, &error) != SL_OK)
        bench_fail("sky", &error);
    sl_scene under_sky = *w->scene; /* lit by nothing else */
    under_sky.environment = sky;
    under_sky.light_count = under_sky.emitter_count = 0;
    sl_transport direct = {.sky_light = true,
                           .direct_lobes = SL_LOBE_GLOSSY,
                           .direct_visibility = true,
                           .bounce_visibility = true,
                           .filter = SL_FILTER_CENTRE};
    bench_reference of_sky, sum;
    if (sky.present) {
        bench_reference_get(&under_sky, w->tracer, &direct, &w->pixels, samples, &of_sky);
        bench_reference_sum(&w->reference, &of_sky, &sum);
        bench_reference_free(&of_sky);
        bench_reference_free(&w->reference);
        w->reference = sum;
    }
    sl_environment_release(&sky);
    sl_environment_release(&sun);
}

static bool open_world(bench_report *r, const bench_options *o, const char *path, int size, world *w) {
    sl_error error;
    *w = (world){.size = o->brief ? size / 4 : size};
    if (!bench_open_scene(r, path, &w->scene)) return false;
    if (sl_tracer_create(w->scene, 2, NULL, &w->tracer, &error) != SL_OK) bench_fail("tracer", &error);
    bench_pixels_make(w->scene, w->tracer, w->size, w->size, o->brief ? 4 : 8, &w->pixels);
    bench_pixels_keep_glossy(w->scene, w->tracer, &w->pixels);
    for (int i = 0; i < 2; i++) w->values[i] = calloc(3 * w->pixels.count + 1, sizeof(float));
    find_reference(w, o->brief ? 1024 : 16384);
    return true;
}

static void close_world(world *w) {
    for (int i = 0; i < 2; i++) free(w->values[i]);
    bench_reference_free(&w->reference);
    bench_pixels_free(&w->pixels);
    sl_tracer_destroy(w->tracer);
    sl_scene_destroy(w->scene);
}

/* ---- without interpolation ---- */

typedef struct exact_task {
    const world *w;
    const sl_gather *gather;
    const sl_glossy *glossy;
    sl_gather_scratch *scratch[256];
    sl_glossy_kernel *kernel;
    uint64_t key;
    float *values;
} exact_task;

/* A record at the very place of a pixel, with its normal: nothing to translate, nothing to rotate. */
static void reflect_at(void *context, size_t index, unsigned worker) {
    exact_task *t = context;
    sl_surface s;
    uint32_t triangle, receives = 1;
    float coefficients[9 * (SL_HSH_MAX + 32)], radiance[3];
    sl_counters counters = {{0}};
    sl_irradiance irradiance;
    if (!bench_pixel_surface(t->w->scene, t->w->tracer, &t->w->pixels, index, &s, &triangle)) return;
    sl_gather_point point = {.position = s.position,
                             .geometric_normal = s.geometric_normal,
                             .normal = s.normal,
                             .triangle = triangle,
                             .key = sl_hash64(index + (t->key << 32))};
    sl_gather_radiance(t->gather, &point, t->scratch[worker], &irradiance, coefficients, &counters);
    uint32_t material = (uint32_t)(s.material - t->w->scene->materials);
    sl_splat_receivers receivers = {1,           1,           &s.position.x, &s.position.y, &s.position.z,
                                    &s.normal.x, &s.normal.y, &s.normal.z,   &receives};
    sl_glossy_view view = {t->glossy, &receivers, &material, t->w->scene->camera.eye, NULL};
    sl_glossy_record record = {s.position, sl_frame_from_normal(s.normal), coefficients};
    t->kernel(&view, &record, 0, radiance);
    const float ks[3] = {s.material->specular.r, s.material->specular.g, s.material->specular.b};
    for (size_t c = 0; c < 3; c++) t->values[3 * index + c] = fmaxf(radiance[c], 0.0f) * ks[c];
}

/* Two gathers at each point, so that their noise can be taken off too: error of the truncation alone, and its
 * bias. */
static void truncation(const world *w, int order, double *rel_rmse, double *bias) {
    exact_task t = {.w = w};
    sl_environment sky, sun;
    sl_error error;
    sl_gather *gather;
    sl_glossy *glossy;
    sl_counters counters = {{0}};
    unsigned threads = sl_thread_count(0);
    sl_gather_settings g = sl_gather_defaults();
    if (sl_environment_split(&w->scene->environment, SL_SKY_CONTRAST, &sky, &sun, &error) != SL_OK)
        bench_fail("sky", &error);
    g.kind = SL_GATHER_RAYS;
    g.size = 96;
    g.direct = SL_DIRECT_RAYS;
    g.background = sky.present ? &sky : NULL;
    g.harmonics_order = order;
    if (sl_gather_create(w->scene, NULL, w->tracer, &g, threads, &gather, &counters, &error) != SL_OK)
        bench_fail("gather", &error);
    if (sl_glossy_create(w->scene, order, &glossy, &error) != SL_OK) bench_fail("lobes", &error);
    for (unsigned i = 0; i < threads; i++) {
        if (sl_gather_scratch_create(gather, &t.scratch[i], &error) != SL_OK) bench_fail("scratch", &error);
    }
    t.gather = gather;
    t.glossy = glossy;
    t.kernel = sl_glossy_kernel_for(sl_isa_best());
    for (int i = 0; i < 2; i++) {
        t.key = 1 + (uint64_t)i;
        t.values = w->values[i];
        sl_parallel_for(threads, w->pixels.count, reflect_at, &t);
    }
    double square = 0.0, mean = 0.0, difference = 0.0;
    for (size_t i = 0; i < 3 * w->pixels.count; i++) {
        double a = (double)w->reference.half[0][i], b = (double)w->reference.half[1][i];
        square += ((double)w->values[0][i] - a) * ((double)w->values[1][i] - b);
        difference += (double)w->values[0][i] - 0.5 * (a + b);
        mean += 0.5 * (a + b);
    }
    *rel_rmse = sqrt(fmax(0.0, square) * 3.0 * (double)w->pixels.count) / mean;
    *bias = difference / mean;
    for (unsigned i = 0; i < threads; i++) sl_gather_scratch_destroy(t.scratch[i]);
    sl_glossy_destroy(glossy);
    sl_gather_destroy(gather);
    sl_environment_release(&sky);
    sl_environment_release(&sun);
}

/* ---- rows ---- */

static double exponent_of(const sl_scene *scene) {
    double largest = 0.0;
    for (size_t i = 0; i < scene->material_count; i++) {
        if (sl_material_is_glossy(&scene->materials[i]))
            largest = fmax(largest, (double)scene->materials[i].exponent);
    }
    return largest;
}

static void picture_row(bench_report *r, const bench_options *o, world *w, const char *scene, int order,
                        double accuracy, double limit) {
    sl_settings settings = sl_settings_default();
    splat_run run;
    char mse[32];
    settings.method = "splatting";
    settings.width = settings.height = w->size;
    settings.quality = SL_QUALITY_HIGH;
    settings.accuracy = 0.25; /* of the irradiance records: the paper's */
    settings.glossy_accuracy = accuracy;
    settings.harmonics_order = order;
    splat_render(w->scene, &settings, o->once, &run);
    if (!bench_pick(run.image, "glossy", &w->pixels, w->values[0])) bench_fail("no glossy layer", NULL);
    bench_error e = bench_compare(w->values[0], &w->reference, NULL);
    if (o->pictures && order == 10) {
        char what[64];
        snprintf(what, sizeof what, "order-%d-a-%g", order, accuracy);
        bench_write_picture(r, scene, what, run.image);
    }
    bench_row(r, "%s|%d|%g|%.2f|%.2f|%s|%+.2f|%zu|%zu|%.2f|%.2f|%.3f|%.3f|%.2f", scene, order, accuracy,
              100.0 * limit, 100.0 * e.rel_rmse, bench_mse_text(&e, mse), 100.0 * e.bias, run.records[0],
              run.records[1], run.cpu[SPLAT_RECORDS], run.cpu[SPLAT_RECORDS + 1], run.cpu[SPLAT_SPLATS],
              run.cpu[SPLAT_SPLATS + 1], run.cpu_all);
    splat_run_free(&run);
}

static void experiment(bench_report *r, const bench_options *o, const char *path, int size) {
    char scene[64], name[80];
    world w;
    double limits[ORDERS];
    bench_scene_name(path, scene);
    if (!bench_wants(o, scene) || !open_world(r, o, path, size, &w)) return;
    double exponent = exponent_of(w.scene);
    bench_say(r,
              "\n%s, %d x %d, Phong exponent %g: %zu glossy pixels compared. Truncation alone: coefficients "
              "gathered at the pixels themselves\n",
              scene, w.size, w.size, exponent, w.pixels.count);
    bench_table(r, scene, "scene|order|lobe error at 45 deg %|truncation relRMSE %|its bias %");
    for (int i = 0; i < ORDERS; i++) {
        double bias;
        truncation(&w, orders[i], &limits[i], &bias);
        bench_row(r, "%s|%d|%.1f|%.2f|%+.2f", scene, orders[i],
                  100.0 * sl_phong_truncation(orders[i], exponent), 100.0 * limits[i], 100.0 * bias);
    }
    snprintf(name, sizeof name, "%s-pictures", scene);
    bench_table(r, name,
                "scene|order|a|truncation %|relRMSE %|relMSE|bias %|irr. rec.|rad. rec.|irr. rec. s|rad. "
                "rec. s|irr. splats s|rad. splats s|all s");
    for (int i = 0; i < ORDERS; i++) {
        for (int k = 0; k < ACCURACIES; k++) {
            bool shown = o->brief ? orders[i] == 10 && k < 2 : orders[i] == 10 || accuracies[k] == 0.25;
            if (shown) picture_row(r, o, &w, scene, orders[i], accuracies[k], limits[i]);
        }
    }
    close_world(&w);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/splatting");
    bench_report r;
    bench_report_open(&r, &o, "glossy");
    experiment(&r, &o, "scenes/cornell-glossy.json", 512);
    experiment(&r, &o, "scenes/generated/castle.json", 1000);
    bench_report_close(&r);
    return 0;
}
