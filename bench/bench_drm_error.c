/* How far indirect light by direct radiance maps is from the truth, and how soon it gets there: for every
 * weight, filter and number of photons, against
 *
 *     A  the path tracer on the very paths that the method models: two diffuse events, and nothing between
 * them is in the way B  the same with what is in the way: what the missing indirect shadows cost C  all
 * paths: what further bounces and caustics would add
 *
 * and what each extension buys. Only the indirect part is compared, relative to itself, at one pixel of each
 * block that does not show a mirror (common.h). Seconds are processor time of one frame with one thread. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cache/direct_radiance/direct_radiance.h"
#include "drm_bench.h"
#include "timing.h"

enum { REFERENCES = 3, COUNTS = 6, WEIGHTS = 6, FILTERS = 3 };

static const int counts[COUNTS] = {1, 2, 3, 4, 8, 16};
static const struct {
    const char *name;
    sl_photon_weight weight;
} weights[WEIGHTS] = {{"(11)", SL_WEIGHT_EVEN}, {"(14)", SL_WEIGHT_DISC}, {"(15)", SL_WEIGHT_BOX},
                      {"plain", SL_WEIGHT_PLAIN}, {"flux", SL_WEIGHT_FLUX}, {"polygon", SL_WEIGHT_POLYGON}};
static const struct {
    const char *name;
    sl_map_filter filter;
} filters[FILTERS] = {
    {"point", SL_MAP_FILTER_POINT}, {"radiance", SL_MAP_FILTER_RADIANCE}, {"flux", SL_MAP_FILTER_FLUX}};

typedef struct world {
    const char *name;
    sl_scene *scene;
    int size;
    bool mirrors;
    bench_pixels pixels;
    bench_reference reference[REFERENCES];
    float *values;
} world;

typedef struct trial {
    double seconds;
    unsigned long long photons;
    bench_error error[REFERENCES];
} trial;

/* ---- the world ---- */

static void find_references(const bench_options *o, world *w, uint32_t samples) {
    sl_settings settings = sl_settings_default();
    sl_transport transport[REFERENCES];
    sl_tracer *tracer;
    sl_error error;
    settings.method = "direct-radiance";
    sl_radiance_complete(&settings);
    sl_radiance_transport(&settings, &transport[0]);
    transport[0].bounce_visibility = false;
    transport[1] = transport[0];
    transport[1].bounce_visibility = true;
    if (!sl_transport_named("full", &transport[2])) bench_fail("transport", NULL);
    if (sl_tracer_create(w->scene, 2, NULL, &tracer, &error) != SL_OK) bench_fail("tracer", &error);
    bench_pixels_make(w->scene, tracer, w->size, w->size, o->brief ? 8 : 6, &w->pixels);
    for (int i = 0; i < REFERENCES; i++) {
        transport[i].emission = false;
        transport[i].direct_lobes = 0;
        bench_reference_get(w->scene, tracer, &transport[i], &w->pixels, samples, &w->reference[i]);
    }
    sl_tracer_destroy(tracer);
}

static bool open_world(bench_report *r, const bench_options *o, const char *path, const char *name,
                       world *w) {
    *w = (world){.name = name, .size = o->brief ? 128 : 256};
    if (!bench_open_scene(r, path, &w->scene)) return false;
    if (w->scene->environment.present) { /* the method has no light from the sky */
        sl_environment_release(&w->scene->environment);
        w->scene->environment = (sl_environment){0};
        bench_say(r, "\n%s: without its sky\n", name);
    }
    for (size_t m = 0; m < w->scene->material_count; m++)
        w->mirrors |= sl_material_is_mirror(&w->scene->materials[m]);
    find_references(o, w, o->brief ? 512 : 4096);
    w->values = calloc(3 * w->pixels.count + 1, sizeof *w->values);
    if (!w->values) bench_fail("values", NULL);
    return true;
}

static void close_world(world *w) {
    free(w->values);
    for (int i = 0; i < REFERENCES; i++) bench_reference_free(&w->reference[i]);
    bench_pixels_free(&w->pixels);
    sl_scene_destroy(w->scene);
}

/* ---- a trial ---- */

static sl_settings settings_of(const world *w, int samples, sl_photon_weight weight, sl_map_filter filter) {
    sl_settings settings = sl_settings_default();
    settings.method = "direct-radiance";
    settings.width = settings.height = w->size;
    settings.threads = 1;
    settings.radiance_map.samples = samples;
    settings.radiance_map.weight = weight;
    settings.radiance_map.filter = filter;
    return settings;
}

static trial try(world *w, const sl_settings *settings, const bench_report *r, const char *picture) {
    trial t;
    drm_frames f;
    drm_frames_open(&f, w->scene, settings);
    double from = process_ms();
    drm_frame(&f, 0);
    t.seconds = 1e-3 * (process_ms() - from);
    t.photons = f.counters.value[SL_COUNT_MAP_PHOTONS];
    if (!bench_pick(f.image, "indirect", &w->pixels, w->values)) bench_fail("no indirect layer", NULL);
    for (int i = 0; i < REFERENCES; i++) t.error[i] = bench_compare(w->values, &w->reference[i], NULL);
    if (picture) bench_write_picture(r, w->name, picture, f.image);
    drm_frames_close(&f);
    return t;
}

/* ---- every weight, filter and number ---- */

static const double long_enough = 12.0; /* seconds of a frame, after which no more photons are tried */

typedef struct trials {
    trial of[WEIGHTS][FILTERS][COUNTS];
    bool made[WEIGHTS][FILTERS][COUNTS];
} trials;

static void run_trials(const bench_options *o, world *w, trials *all) {
    for (int a = 0; a < WEIGHTS; a++) {
        for (int b = 0; b < FILTERS; b++) {
            double seconds = 0.0;
            for (int c = 0; c < (o->brief ? COUNTS - 1 : COUNTS) && seconds < long_enough / 4.0; c++) {
                sl_settings settings = settings_of(w, counts[c], weights[a].weight, filters[b].filter);
                all->of[a][b][c] = try(w, &settings, NULL, NULL);
                all->made[a][b][c] = true;
                seconds = all->of[a][b][c].seconds;
            }
        }
    }
}

static void write_trials(const bench_report *r, const world *w, const trials *all) {
    char path[700];
    snprintf(path, sizeof path, "%s/drm_error-%s-all.csv", r->folder, w->name);
    FILE *file = fopen(path, "w");
    if (!file) return;
    fprintf(file, "weight,filter,m,photons,cpu s,A relRMSE,A relMSE,A bias,A noise,B relRMSE,B relMSE,B "
                  "bias,B noise,C relRMSE,C relMSE,C bias,C noise\n");
    for (int i = 0; i < WEIGHTS * FILTERS * COUNTS; i++) {
        int a = i / (FILTERS * COUNTS), b = i / COUNTS % FILTERS, c = i % COUNTS;
        const trial *t = &all->of[a][b][c];
        if (!all->made[a][b][c]) continue;
        fprintf(file, "%s,%s,%d,%llu,%.5f", weights[a].name, filters[b].name, counts[c], t->photons,
                t->seconds);
        for (int k = 0; k < REFERENCES; k++)
            fprintf(file, ",%.5f,%.4e,%.5f,%.2e", t->error[k].rel_rmse, t->error[k].rel_mse, t->error[k].bias,
                    t->error[k].noise);
        fprintf(file, "\n");
    }
    fclose(file);
}

static void series_row(bench_report *r, const world *w, const trials *all, int a, int b, bool seconds) {
    char line[512];
    int at = snprintf(line, sizeof line, "%s|%s|%s|%s", w->name, weights[a].name, filters[b].name,
                      seconds ? "CPU ms" : "relRMSE % of A");
    for (int c = 0; c < COUNTS; c++) {
        const trial *t = &all->of[a][b][c];
        if (!all->made[a][b][c]) at += snprintf(line + at, sizeof line - (size_t)at, "|");
        else if (seconds) at += snprintf(line + at, sizeof line - (size_t)at, "|%.2f", 1e3 * t->seconds);
        else at += snprintf(line + at, sizeof line - (size_t)at, "|%.1f", 100.0 * t->error[0].rel_rmse);
    }
    bench_row(r, "%s", line);
}

/* ---- what extensions buy ---- */

typedef struct extension {
    const char *name;
    void (*set)(sl_radiance_map_settings *m);
} extension;

static void none(sl_radiance_map_settings *m) { (void)m; }
static void frustum(sl_radiance_map_settings *m) { m->shape = SL_MAP_FRUSTUM; }
static void paper(sl_radiance_map_settings *m) {
    m->shape = SL_MAP_FRUSTUM;
    m->weight = SL_WEIGHT_DISC;
    m->filter = SL_MAP_FILTER_RADIANCE;
}
static void polygon(sl_radiance_map_settings *m) { m->weight = SL_WEIGHT_POLYGON; }
static void rays(sl_radiance_map_settings *m) { m->visibility = SL_VISIBILITY_RAYS; }
static void polygon_rays(sl_radiance_map_settings *m) {
    m->weight = SL_WEIGHT_POLYGON;
    m->visibility = SL_VISIBILITY_RAYS;
}
static void traced(sl_radiance_map_settings *m) { m->traced_light_mirrors = true; }
static void eight_bit(sl_radiance_map_settings *m) { m->eight_bit_positions = true; }

static const extension extensions[] = {
    {"the paper's: frustum, (14), radiance", paper},
    {"flux weight, frustum", frustum},
    {"flux weight, all faces", none},
    {"8-bit positions", eight_bit},
    {"polygon weight", polygon},
    {"light by curved mirrors", traced},
    {"visibility by rays", rays},
    {"polygon, rays", polygon_rays},
};

static void extension_rows(bench_report *r, const bench_options *o, world *w, int samples) {
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; i++) {
        sl_settings settings = settings_of(w, samples, SL_WEIGHT_FLUX, SL_MAP_FILTER_AUTO);
        char texts[REFERENCES][32], picture[32];
        if (extensions[i].set == traced && !w->mirrors) continue;
        extensions[i].set(&settings.radiance_map);
        snprintf(picture, sizeof picture, "m%d-%zu", samples, i);
        trial t = try(w, &settings, r, o->pictures ? picture : NULL);
        for (int k = 0; k < REFERENCES; k++) bench_mse_text(&t.error[k], texts[k]);
        bench_row(r, "%s|%s|%d|%llu|%.1f|%.1f|%s|%.1f|%s|%.1f|%s|%+.1f|%+.1f|%+.1f", w->name,
                  extensions[i].name, samples, t.photons, 1e3 * t.seconds, 100.0 * t.error[0].rel_rmse,
                  texts[0], 100.0 * t.error[1].rel_rmse, texts[1], 100.0 * t.error[2].rel_rmse, texts[2],
                  100.0 * t.error[0].bias, 100.0 * t.error[1].bias, 100.0 * t.error[2].bias);
    }
}

/* ---- difference pictures ---- */

static sl_image *draw(const sl_scene *scene, const sl_settings *settings) {
    sl_method *method;
    sl_image *image;
    sl_error error;
    sl_progress progress = {0};
    if (sl_method_create(scene, settings, &method, &error) != SL_OK) bench_fail("picture", &error);
    while (!progress.done) {
        if (sl_method_update(method, &progress, &error) != SL_OK) bench_fail("picture", &error);
    }
    if (sl_method_resolve(method, &image, &error) != SL_OK) bench_fail("picture", &error);
    sl_method_destroy(method);
    return image;
}

/* Whole pictures: blue where ours is too dark, red where it is too bright, full colour at 50 %. */
static void write_differences(const bench_report *r, const bench_options *o, world *w) {
    static const char *const transports[2] = {"matched:direct-radiance", "full"};
    for (int k = 0; k < 2; k++) {
        sl_settings settings = settings_of(w, 4, SL_WEIGHT_FLUX, SL_MAP_FILTER_AUTO),
                    truth = sl_settings_default();
        sl_image *ours, *path, *difference;
        sl_comparison comparison;
        sl_error error;
        char what[64];
        truth.method = "path";
        truth.transport = transports[k];
        truth.width = truth.height = w->size;
        truth.spp = o->brief ? 32 : 256;
        path = draw(w->scene, &truth);
        snprintf(what, sizeof what, "path-%s", k ? "full" : "matched");
        bench_write_picture(r, w->name, what, path);
        for (int a = 1; a < WEIGHTS; a++) {
            settings.radiance_map.weight = weights[a].weight;
            ours = draw(w->scene, &settings);
            if (sl_image_compare(ours, path, NULL, &comparison, &difference, &error) != SL_OK)
                bench_fail("difference", &error);
            snprintf(what, sizeof what, "difference-%s-%s", k ? "full" : "matched", weights[a].name);
            bench_write_picture(r, w->name, what, difference);
            sl_image_destroy(difference);
            sl_image_destroy(ours);
        }
        sl_image_destroy(path);
    }
}

/* ---- the experiment ---- */

static const char *const scene_paths[] = {
    "scenes/cornell-lamp.json",          "scenes/cornell-point.json",       "scenes/mirror-balls.json",
    "scenes/generated/mirror-cave.json", "bench/scenes/dull-cave.json",     "scenes/generated/room.json",
    "scenes/generated/atrium.json",      "scenes/generated/cathedral.json", "bench/scenes/sponza.json",
};
enum { SCENES = sizeof scene_paths / sizeof *scene_paths };

static const char series_header[] = "scene|weight|filter|what|m = 1|2|3|4|8|16";
static const char extension_header[] = "scene|extension|m|photons|CPU ms|A relRMSE %|A relMSE|B relRMSE %|B "
                                       "relMSE|C relRMSE %|C relMSE|A bias %|B bias %|C bias %";

static void experiment(bench_report *r, const bench_options *o, const char *path) {
    char name[64], csv[80];
    world w;
    bench_scene_name(path, name);
    trials *all = calloc(1, sizeof *all);
    if (!all) bench_fail("trials", NULL);
    if (bench_wants(o, name) && open_world(r, o, path, name, &w)) {
        run_trials(o, &w, all);
        bench_say(r, "\n%s, %d x %d, %zu pixels, %u reference samples\n", name, w.size, w.size,
                  w.pixels.count, w.reference[0].samples);
        snprintf(csv, sizeof csv, "%s-series", name);
        bench_table(r, csv, series_header);
        for (int a = 0; a < WEIGHTS; a++) {
            /* filters side by side for the flux weight alone */
            for (int b = a == 4 ? 0 : FILTERS - 1; b < FILTERS; b++) {
                series_row(r, &w, all, a, b, false);
                series_row(r, &w, all, a, b, true);
            }
        }
        snprintf(csv, sizeof csv, "%s-extensions", name);
        bench_table(r, csv, extension_header);
        extension_rows(r, o, &w, 4);
        if (!o->brief) extension_rows(r, o, &w, 8);
        write_trials(r, &w, all);
        if (o->pictures) write_differences(r, o, &w);
        close_world(&w);
    }
    free(all);
}

int main(int argc, char **argv) {
    bench_options o = bench_options_parse(argc, argv, "build/direct-radiance");
    bench_report r;
    bench_report_open(&r, &o, "drm_error");
    for (int i = 0; i < SCENES; i++) experiment(&r, &o, scene_paths[i]);
    bench_report_close(&r);
    return 0;
}
