#include "app/steps/run.h"

#include "app/bench/judge.h"
#include "app/clock.h"
#include "app/page.h"
#include "app/picture.h"
#include "app/steps/explanations.h"
#include "app/steps/record.h"
#include "base/error.h"
#include "image/tone.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void tell(const sl_steps_options *o, const char *what, double fraction) {
    sl_progress_show(o->quiet, fraction, "%s", what);
}

/* ---- the reference: the method's own light paths, path traced ---- */

static sl_status trace_reference(const sl_scene *scene, const sl_steps_options *o, sl_image **reference,
                                 sl_error *error) {
    char transport[64];
    snprintf(transport, sizeof transport, "matched:%s", o->settings.method);
    sl_settings settings = o->settings;
    settings.method = "path";
    settings.transport = transport;
    settings.spp = o->reference_samples;
    settings.observer = NULL;
    tell(o, "reference", 0.0);
    return sl_picture_make(scene, &settings, HUGE_VAL, reference, error);
}

/* Returns the relative RMSE without the reference's own noise; negative: there is no reference. */
static double error_of(const sl_image *picture, const sl_image *reference) {
    sl_bench_error e;
    sl_error ignored;
    if (!reference || sl_judge_quickly(picture, reference, &e, &ignored) != SL_OK || !e.known) return -1.0;
    return e.rel_rmse;
}

/* Takes a picture's text; an error that is not known is null. */
static void add_text(cJSON *to, const char *name, char *text) {
    if (text) cJSON_AddStringToObject(to, name, text);
    free(text);
}

static void add_error(cJSON *to, const char *name, double rel_rmse) {
    if (rel_rmse >= 0.0 && isfinite(rel_rmse)) cJSON_AddNumberToObject(to, name, rel_rmse);
    else cJSON_AddNullToObject(to, name);
}

static void add_reference(cJSON *run, const sl_steps_options *o, const sl_image *picture,
                          const sl_image *reference) {
    sl_image *difference = NULL;
    sl_bench_error e;
    sl_error ignored;
    if (sl_judge(picture, reference, &e, &difference, &ignored) != SL_OK) return;
    cJSON *told = cJSON_AddObjectToObject(run, "reference");
    add_text(told, "picture", sl_picture_text(reference, true));
    add_text(told, "difference", sl_picture_text(difference, false));
    add_error(told, "noise", e.noise);
    cJSON_AddNumberToObject(told, "samples", o->reference_samples);
    sl_image_destroy(difference);
}

/* ---- the film ---- */

/* Makes a map of the layer `samples`, in proportion to it: a fiftieth where there are the pilot's four. */
static sl_status map_samples(const sl_image *picture, sl_image **map, sl_error *error) {
    const size_t pixels = (size_t)picture->width * (size_t)picture->height;
    const float *samples = sl_image_channel(picture, "samples");
    sl_status status = sl_image_create(picture->width, picture->height, 3, NULL, map, error);
    for (size_t i = 0; status == SL_OK && i < 3 * pixels; i++)
        (*map)->planes[i] = samples ? fminf(0.02f * samples[i % pixels] / 4.0f, 1.0f) : 0.0f;
    return status;
}

/* Makes the picture once more, its pixels means over their squares. */
static sl_status add_film(cJSON *run, const sl_scene *scene, const sl_steps_options *o, sl_error *error) {
    sl_settings settings = o->settings;
    sl_image *picture = NULL, *map = NULL;
    settings.filter = SL_FILTER_BOX;
    settings.observer = NULL;
    tell(o, "the film", 0.0);
    sl_status status = sl_picture_make(scene, &settings, HUGE_VAL, &picture, error);
    if (status == SL_OK) status = map_samples(picture, &map, error);
    if (status == SL_OK) {
        cJSON *film = cJSON_AddObjectToObject(run, "film");
        add_text(film, "picture", sl_picture_text(picture, true));
        add_text(film, "samples", sl_picture_text(map, true));
    }
    sl_image_destroy(picture);
    sl_image_destroy(map);
    return status;
}

/* ---- what each layer is worth ---- */

/* Returns the error of the picture less one of its layers. */
static double error_without(const sl_image *picture, const char *layer, const sl_image *reference) {
    const size_t pixels = (size_t)picture->width * (size_t)picture->height;
    const float *whole[3], *part[3];
    sl_image *rest = NULL;
    double error = -1.0;
    if (sl_layer_planes(picture, NULL, whole) && sl_layer_planes(picture, layer, part) &&
        sl_image_create(picture->width, picture->height, 3, NULL, &rest, NULL) == SL_OK) {
        for (size_t i = 0; i < 3 * pixels; i++)
            rest->planes[i] = whole[i / pixels][i % pixels] - part[i / pixels][i % pixels];
        error = error_of(rest, reference);
    }
    sl_image_destroy(rest);
    return error;
}

static void add_layers(cJSON *run, const sl_image *picture, const sl_image *reference) {
    static const char *const names[] = {"emission", "direct", "specular", "indirect", "glossy"};
    cJSON *layers = cJSON_AddObjectToObject(run, "layers");
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        const float *planes[3];
        if (sl_layer_planes(picture, names[i], planes))
            add_error(layers, names[i], error_without(picture, names[i], reference));
    }
}

/* ---- the method ---- */

static sl_status snap(cJSON *snapshots, sl_recording *recording, sl_method *method,
                      const sl_progress *progress, const sl_image *reference, sl_image **picture,
                      sl_error *error) {
    sl_image_destroy(*picture);
    *picture = NULL;
    sl_recording_interrupt(recording, sl_method_counters(method));
    sl_status status = sl_method_resolve(method, picture, error);
    if (status != SL_OK) return status;
    sl_recording_snapshot(recording);
    cJSON *snapshot = cJSON_CreateObject();
    cJSON_AddItemToArray(snapshots, snapshot);
    cJSON_AddNumberToObject(snapshot, "batches", (double)progress->batches);
    add_error(snapshot, "error", error_of(*picture, reference));
    add_text(snapshot, "picture", sl_picture_text(*picture, true));
    return cJSON_GetObjectItem(snapshot, "picture") && !recording->watched.failed
               ? SL_OK
               : sl_fail_memory(error, "the page's pictures");
}

/* Snapshots after the first batches and then ever more rarely, the last one when all is done. */
static sl_status refine(cJSON *run, sl_recording *recording, const sl_steps_options *o, sl_method *method,
                        const sl_image *reference, sl_image **picture, sl_error *error) {
    enum { SNAPSHOTS_MAX = 24 };
    cJSON *snapshots = cJSON_AddArrayToObject(run, "snapshots");
    sl_progress progress = {0};
    uint64_t next = 1;
    sl_status status = SL_OK;
    while (status == SL_OK && !progress.done) {
        status = sl_method_update(method, &progress, error);
        tell(o, o->settings.method, progress.fraction);
        bool room = recording->snapshots + 1 < SNAPSHOTS_MAX;
        if (status != SL_OK || !(progress.done || (room && progress.batches >= next))) continue;
        status = snap(snapshots, recording, method, &progress, reference, picture, error);
        next = progress.batches + 1 + progress.batches / 3;
    }
    return status;
}

static sl_status watch(const sl_scene *scene, const sl_steps_options *o, cJSON *run, sl_recording *recording,
                       const sl_image *reference, sl_error *error) {
    sl_observer observer = sl_recording_observer(recording);
    sl_settings settings = o->settings;
    settings.observer = &observer;
    sl_method *method = NULL;
    sl_image *picture = NULL;
    cJSON *explanations = NULL;
    sl_status status = sl_method_create(scene, &settings, &method, error);
    if (status == SL_OK) status = refine(run, recording, o, method, reference, &picture, error);
    if (status == SL_OK) {
        tell(o, "explanations of the pixels", 0.0);
        status = sl_explanations_collect(method, picture, &recording->view, &explanations, error);
    }
    if (status == SL_OK) cJSON_AddItemToObject(run, "explanations", explanations);
    if (status == SL_OK) cJSON_AddItemToObject(run, "steps", sl_recording_json(recording));
    if (status == SL_OK && reference) {
        add_layers(run, picture, reference);
        add_reference(run, o, picture, reference);
    }
    sl_image_destroy(picture);
    sl_method_destroy(method);
    return status;
}

/* Runs a method; *out, which the caller deletes, is one of a page's runs. */
static sl_status run_method(const sl_scene *scene, const sl_steps_options *o, cJSON **out, sl_error *error) {
    static sl_recording recording; /* large */
    int width = o->settings.width, height = o->settings.height;
    cJSON *run = *out = cJSON_CreateObject(), *narrative = sl_narrative_of(o->settings.method);
    if (!narrative)
        return sl_fail(error, SL_ERROR_USAGE,
                       "--method: steps are told of splatting, direct-radiance, light-octree, multi-mesh and "
                       "shading-cache");
    cJSON_AddItemToObject(run, "narrative", narrative);
    cJSON_AddNumberToObject(run, "width", width);
    cJSON_AddNumberToObject(run, "height", height);
    sl_tracer *tracer = NULL;
    sl_image *reference = NULL; /* NULL: there is none */
    char *plan = NULL;
    sl_status status = sl_tracer_create(scene, o->settings.threads, NULL, &tracer, error);
    recording = (sl_recording){.view = {scene->camera, width, height, tracer, scene->scale},
                               .watched = {.narrative = narrative}};
    if (status == SL_OK) status = sl_method_plan(scene, &o->settings, &plan, error);
    if (status == SL_OK && o->reference_samples) status = trace_reference(scene, o, &reference, error);
    if (status == SL_OK) status = watch(scene, o, run, &recording, reference, error);
    if (status == SL_OK) status = add_film(run, scene, o, error);
    add_text(run, "plan", plan);
    sl_recording_clear(&recording);
    sl_image_destroy(reference);
    sl_tracer_destroy(tracer);
    return status;
}

/* ---- the page ---- */

/* page.css and page.js, as the linker has put them in. */
extern const char _binary_src_app_steps_page_css_start[], _binary_src_app_steps_page_css_end[];
extern const char _binary_src_app_steps_page_js_start[], _binary_src_app_steps_page_js_end[];
/* Equations in MathML, as on the page of `serve`. */
extern const char _binary_src_app_serve_page_equation_js_start[],
    _binary_src_app_serve_page_equation_js_end[];

static sl_status write_page(const char *path, const char *scene_path, const sl_steps_options *o,
                            const cJSON *runs, sl_error *error) {
    const sl_page_files files = {
        _binary_src_app_steps_page_css_start,         _binary_src_app_steps_page_css_end,
        _binary_src_app_steps_page_js_start,          _binary_src_app_steps_page_js_end,
        _binary_src_app_serve_page_equation_js_start, _binary_src_app_serve_page_equation_js_end};
    char heading[4096], title[4300];
    snprintf(heading, sizeof heading, "%.4000s, step by step", scene_path);
    snprintf(title, sizeof title, "%.60s%s%.60s, %s", o->settings.method, o->beside ? " beside " : "",
             o->beside ? o->beside : "", heading);
    return sl_page_write(path, title, heading, &files, runs, error);
}

void sl_steps_size(int width, int height, sl_settings *settings) {
    enum { WIDTH = 160 };
    settings->width = WIDTH;
    settings->height = (WIDTH * height + width / 2) / width;
    if (settings->height < 1) settings->height = 1;
    if (settings->height > 2 * WIDTH) settings->height = 2 * WIDTH;
}

sl_status sl_steps_write(const sl_scene *scene, const char *scene_path, const sl_steps_options *options,
                         const char *path, sl_error *error) {
    sl_steps_options o = *options;
    cJSON *runs = cJSON_CreateArray();
    sl_status status = SL_OK;
    for (int i = 0; i < (o.beside ? 2 : 1) && status == SL_OK; i++) {
        cJSON *run;
        if (i == 1) o.settings.method = o.beside;
        status = run_method(scene, &o, &run, error);
        cJSON_AddItemToArray(runs, run);
    }
    sl_progress_clear(o.quiet);
    sl_watch_for_interrupt(); /* a page that is being written is written to its end */
    if (status == SL_OK) status = write_page(path, scene_path, options, runs, error);
    cJSON_Delete(runs);
    return status;
}
