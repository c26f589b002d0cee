/* softlux render: a picture of a scene, with a progress bar. */
#include "app/commands.h"
#include "app/options.h"
#include "softlux.h"

#include <cjson/cJSON.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

typedef struct {
    const char *scene_path, *output;
    sl_settings settings;
    int size[2], quality, gather, direct, filter, order, metric, tone;
    uint64_t threads, spp, gather_size, harmonics_order, bounces, hit_samples, batches;
    double time_seconds, at_seconds, exposure;
    bool at_given, exposure_given, json, quiet;
} render_options;

static const char *const quality_names[] = {"draft", "normal", "high", NULL};
static const char *const gather_names[] = {"auto", "raster", "hemicube", "trace", NULL}; /* as sl_gather_kind */
static const char *const direct_names[] = {"auto", "rays", "shadow-maps", NULL};         /* as sl_direct_kind */
static const char *const filter_names[] = {"method", "box", "centre", NULL};             /* as sl_pixel_filter */
static const char *const order_names[] = {"coarse-to-fine", "linear", NULL};             /* as sl_traversal_order */
static const char *const metric_names[] = {"auto", "harmonic", "minimum", "hessian", "adaptive", NULL}; /* as sl_radius_metric */
static const char *const tone_names[] = {"clip", "reinhard", NULL};                      /* as sl_tone_curve */

static bool parse(int argc, char **argv, render_options *o, int *status) {
    *o = (render_options){.settings = sl_settings_default(), .quality = SL_QUALITY_NORMAL, .tone = SL_TONE_REINHARD,
                          .output = "out.exr"};
    sl_settings *s = &o->settings;
    const sl_option options[] = {
        {"output", 'o', SL_OPTION_TEXT, &o->output, NULL, "FILE", "picture to write: .exr, .png or .pfm [out.exr]", 0, 0, NULL},
        {"method", 'm', SL_OPTION_TEXT, &s->method, NULL, "NAME", "splatting or path [splatting]", 0, 0, NULL},
        {"transport", 0, SL_OPTION_TEXT, &s->transport, NULL, "PATHS",
         "path: direct, one-bounce, full or matched:METHOD [full]", 0, 0, NULL},
        {"size", 's', SL_OPTION_SIZE, o->size, NULL, "WxH", "pixels [as the scene says]", 0, 0, NULL},
        {"quality", 'q', SL_OPTION_CHOICE, &o->quality, NULL, "Q", "draft, normal or high [normal]", 0, 0, quality_names},
        {"spp", 0, SL_OPTION_COUNT, &o->spp, NULL, "N", "samples a pixel; splatting: light samples [by quality]", 1, 1e8, NULL},
        {"accuracy", 'a', SL_OPTION_REAL, &s->accuracy, NULL, "A", "splatting: the records' a [by quality]", 1e-3, 2.0, NULL},
        {"gather", 0, SL_OPTION_CHOICE, &o->gather, NULL, "HOW", "auto, raster, hemicube or trace [auto]", 0, 0, gather_names},
        {"gather-size", 0, SL_OPTION_COUNT, &o->gather_size, NULL, "N", "N x N samples a gather, N even [by quality]", 4, 1024, NULL},
        {"direct", 0, SL_OPTION_CHOICE, &o->direct, NULL, "HOW", "auto, rays or shadow-maps [auto]", 0, 0, direct_names},
        {"filter", 0, SL_OPTION_CHOICE, &o->filter, NULL, "F", "path: box or centre of the pixel [method]", 0, 0, filter_names},
        {"order", 0, SL_OPTION_CHOICE, &o->order, NULL, "ORDER",
         "splatting: pixels coarse-to-fine or linear [coarse-to-fine]", 0, 0, order_names},
        {"metric", 0, SL_OPTION_CHOICE, &o->metric, NULL, "METRIC",
         "splatting: what decides how far records reach: auto, harmonic, minimum, hessian or adaptive [auto]", 0, 0, metric_names},
        {"glossy-accuracy", 0, SL_OPTION_REAL, &s->glossy_accuracy, NULL, "A", "splatting: a of the radiance records [by quality]",
         1e-3, 2.0, NULL},
        {"harmonics", 0, SL_OPTION_COUNT, &o->harmonics_order, NULL, "N",
         "splatting: order of the radiance records' harmonics [by the lobes]", 1, 12, NULL},
        {"bounces", 0, SL_OPTION_COUNT, &o->bounces, NULL, "N", "splatting: diffuse bounces; also of matched:splatting [1]", 1, 64,
         NULL},
        {"glossy-hits", 0, SL_OPTION_FLAG, &s->glossy_hits, NULL, NULL, "splatting: gathers see glossy lobes too", 0, 0, NULL},
        {"hit-samples", 0, SL_OPTION_COUNT, &o->hit_samples, NULL, "N",
         "splatting: light samples for what a gather sees [by quality]", 1, 256, NULL},
        {"seed", 0, SL_OPTION_COUNT, &s->seed, NULL, "N", "another number, other noise [0]", 0, 0, NULL},
        {"threads", 't', SL_OPTION_COUNT, &o->threads, NULL, "N", "workers; the bits do not depend on it [all processors]", 1,
         256, NULL},
        {"time", 0, SL_OPTION_REAL, &o->time_seconds, NULL, "SECONDS", "stop at the first batch that ends later", 1e-3, 1e9,
         NULL},
        {"batches", 0, SL_OPTION_COUNT, &o->batches, NULL, "N", "stop after N batches", 1, 1e15, NULL},
        {"at", 0, SL_OPTION_REAL, &o->at_seconds, &o->at_given, "SECONDS", "time of an animated scene [0]", -1e9, 1e9, NULL},
        {"exposure", 0, SL_OPTION_REAL, &o->exposure, &o->exposure_given, "STOPS", "PNG: times 2^STOPS [automatic]", -64, 64,
         NULL},
        {"tone", 0, SL_OPTION_CHOICE, &o->tone, NULL, "CURVE", "PNG: clip or reinhard [reinhard]", 0, 0, tone_names},
        {"json", 0, SL_OPTION_FLAG, &o->json, NULL, NULL, "print what was done as one JSON object", 0, 0, NULL},
        {"quiet", 0, SL_OPTION_FLAG, &o->quiet, NULL, NULL, "no progress bar, no warnings", 0, 0, NULL},
        {0},
    };
    const sl_command_line line = {
        "softlux render SCENE [-o FILE] [options]",
        "Renders a scene: a JSON scene file, or a mesh file (OBJ, glTF, PLY, ...).",
        "Ctrl-C writes what is done so far. A picture stopped by --time can be had again, bit for bit, with\n"
        "--batches and the number that its metadata (softlux.batches) tells.\n\n"
        "example: softlux render scenes/cornell.json -q high -o cornell.exr",
        options, 1, 1};
    int operands;
    if (!sl_options_parse(&line, argc, argv, &o->scene_path, &operands, status)) return false;
    s->width = o->size[0];
    s->height = o->size[1];
    s->quality = (sl_quality)o->quality;
    s->gather = (sl_gather_kind)o->gather;
    s->direct = (sl_direct_kind)o->direct;
    s->filter = (sl_pixel_filter)o->filter;
    s->order = (sl_traversal_order)o->order;
    s->metric = (sl_radius_metric)o->metric;
    s->harmonics_order = (int)o->harmonics_order;
    s->bounces = (uint32_t)o->bounces;
    s->hit_samples = (uint32_t)o->hit_samples;
    s->spp = (uint32_t)o->spp;
    s->gather_size = (int)o->gather_size;
    s->threads = (unsigned)o->threads;
    return true;
}

static int report(const sl_error *error) {
    fprintf(stderr, "softlux: %s\n", error->message);
    return (int)error->status;
}

static double now_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The one thing that a signal handler can do: leave word. */
static volatile sig_atomic_t interrupted;

static void on_interrupt(int signal_number) {
    (void)signal_number;
    interrupted = 1;
}

static void watch_for_interrupt(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_interrupt;
    action.sa_flags = (int)SA_RESETHAND; /* a second Ctrl-C ends the program at once */
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

static void draw_progress(const sl_progress *progress, double seconds) {
    enum { CELLS = 40 };
    char bar[CELLS + 1];
    int filled = (int)(progress->fraction * CELLS);
    for (int i = 0; i < CELLS; i++) bar[i] = i < filled ? '#' : '.';
    bar[CELLS] = '\0';
    fprintf(stderr, "\r[%s] %3.0f %%  %.1f s ", bar, 100.0 * progress->fraction, seconds);
    fflush(stderr);
}

/* Updates until the method is done, time or batches run out, or somebody presses Ctrl-C. */
static sl_status run(const render_options *o, sl_method *method, sl_progress *progress, double start, sl_error *error) {
    bool bar = !o->quiet && isatty(STDERR_FILENO);
    double drawn = 0.0;
    sl_status status = SL_OK;
    watch_for_interrupt();
    while (status == SL_OK && !progress->done && !interrupted) {
        status = sl_method_update(method, progress, error);
        double seconds = now_seconds() - start;
        if (bar && (seconds - drawn > 0.1 || progress->done)) draw_progress(progress, drawn = seconds);
        if (o->batches && progress->batches >= o->batches) break;
        if (o->time_seconds > 0.0 && seconds >= o->time_seconds) break;
    }
    if (bar) fputc('\n', stderr);
    return status;
}

static bool ends_with(const char *text, const char *end) {
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcmp(text + n - m, end) == 0;
}

/* *seconds: from `start` until the picture was there, writing it not included. */
static sl_status write_picture(const render_options *o, sl_method *method, double start, double *seconds, sl_error *error) {
    sl_image *image;
    sl_status status = sl_method_resolve(method, &image, error);
    if (status != SL_OK) return status;
    char text[32];
    *seconds = now_seconds() - start;
    snprintf(text, sizeof text, "%.3f", *seconds);
    status = sl_image_set_metadata(image, "softlux.seconds", text, error);
    sl_tone tone = {(sl_tone_curve)o->tone, (float)o->exposure, !o->exposure_given};
    if (status == SL_OK)
        status = ends_with(o->output, ".png") ? sl_image_write_png(image, o->output, tone, error)
                                              : sl_image_write(image, o->output, error);
    sl_image_destroy(image);
    return status;
}

static void print_json(const render_options *o, const sl_scene *scene, const sl_method *method, const sl_progress *progress,
                       double seconds) {
    int width = o->settings.width, height = o->settings.height;
    if (!width) sl_scene_film(scene, &width, &height);
    cJSON *root = cJSON_CreateObject();
    cJSON *size = cJSON_AddArrayToObject(root, "size");
    cJSON_AddItemToArray(size, cJSON_CreateNumber(width));
    cJSON_AddItemToArray(size, cJSON_CreateNumber(height));
    cJSON_AddStringToObject(root, "scene", o->scene_path);
    cJSON_AddStringToObject(root, "method", o->settings.method);
    cJSON_AddStringToObject(root, "output", o->output);
    cJSON_AddNumberToObject(root, "threads", o->settings.threads ? (double)o->settings.threads
                                                                 : (double)sysconf(_SC_NPROCESSORS_ONLN));
    cJSON_AddNumberToObject(root, "seconds", seconds);
    cJSON_AddNumberToObject(root, "batches", (double)progress->batches);
    cJSON_AddBoolToObject(root, "done", progress->done);
    cJSON_AddNumberToObject(root, "memory_bytes", (double)sl_method_memory_bytes(method));
    cJSON *counters = cJSON_AddObjectToObject(root, "counters");
    const sl_counters *c = sl_method_counters(method);
    for (int i = 0; i < SL_COUNTERS; i++) cJSON_AddNumberToObject(counters, sl_counter_name((sl_counter)i), (double)c->value[i]);
    char *text = cJSON_Print(root);
    if (text) puts(text);
    cJSON_free(text);
    cJSON_Delete(root);
}

static void print_warnings(const sl_scene *scene) {
    for (size_t i = 0; i < sl_scene_warning_count(scene); i++)
        fprintf(stderr, "softlux: warning: %s\n", sl_scene_warning(scene, i));
}

static bool known_output(const char *path, sl_error *error) {
    if (ends_with(path, ".exr") || ends_with(path, ".png") || ends_with(path, ".pfm")) return true;
    error->status = SL_ERROR_USAGE;
    snprintf(error->message, sizeof error->message, "--output: expected a name that ends with .exr, .png or .pfm, got '%s'",
             path);
    return false;
}

static sl_status render(const render_options *o, const sl_scene *scene, sl_error *error) {
    double start = now_seconds(), seconds = 0.0;
    sl_method *method = NULL;
    sl_progress progress = {0};
    sl_status status = sl_method_create(scene, &o->settings, &method, error);
    if (status == SL_OK) status = run(o, method, &progress, start, error);
    if (status == SL_OK) status = write_picture(o, method, start, &seconds, error);
    if (status == SL_OK) {
        if (!progress.done && !o->quiet)
            fprintf(stderr, "softlux: stopped after %llu batches, about %.0f %%; %s holds what was done\n",
                    (unsigned long long)progress.batches, 100.0 * progress.fraction, o->output);
        if (o->json) print_json(o, scene, method, &progress, seconds);
    }
    sl_method_destroy(method);
    return status;
}

int sl_command_render(int argc, char **argv) {
    render_options o;
    int exit_status;
    if (!parse(argc, argv, &o, &exit_status)) return exit_status;
    sl_error error;
    sl_scene *scene = NULL;
    if (!known_output(o.output, &error)) return report(&error); /* before the work, not after */
    sl_status status = sl_scene_load(o.scene_path, &scene, &error);
    if (status == SL_OK && o.at_given) status = sl_scene_set_time(scene, o.at_seconds, NULL, &error);
    if (status == SL_OK) {
        if (!o.quiet) print_warnings(scene);
        status = render(&o, scene, &error);
    }
    sl_scene_destroy(scene);
    return status == SL_OK ? 0 : report(&error);
}
