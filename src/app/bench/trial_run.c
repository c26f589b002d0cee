/* One trial, in its own process: a scene, a method, a picture, and what they cost. */
#include "app/bench/trials.h"
#include "app/memory_limit.h"
#include "app/options.h"
#include "app/clock.h"
#include "cache/frame/method.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

bool sl_trial_settings(const char *arguments, sl_settings *settings) {
    enum { WORDS = 48 };
    static const sl_option none = {0};
    char text[SL_BENCH_ARGUMENTS], *words[WORDS], *rest = NULL;
    const char *operands[1];
    int count = 0, operand_count, status;
    snprintf(text, sizeof text, "%s", arguments);
    for (char *w = strtok_r(text, " ", &rest); w && count < WORDS; w = strtok_r(NULL, " ", &rest))
        words[count++] = w;
    *settings = sl_settings_default();
    const sl_command_line line = {arguments, "", NULL, &none, 0, 0, NULL, settings, NULL};
    return sl_options_parse(&line, count, words, operands, &operand_count, &status);
}

/* Adds what a look found out: which passes take the time. */
static void add_parts(cJSON *root, const sl_pass_times *times) {
    cJSON *parts = cJSON_AddObjectToObject(root, "parts");
    double sum = 0.0;
    for (int i = 0; i < times->count; i++) sum += times->pass[i].seconds;
    for (int i = 0; i < times->count && sum > 0.0; i++)
        cJSON_AddNumberToObject(parts, times->pass[i].name, times->pass[i].seconds / sum);
}

/* ---- the picture ---- */

typedef struct made {
    sl_method *method;
    sl_image *image;
    sl_progress progress;
    double cpu, wall, first_picture;
} made;

/* Shows the first picture, which is there after the first update; showing it costs time that another run
 * would not need: so of a look only. */
static sl_status show_first(made *m, double from, sl_error *error) {
    sl_image *first = NULL;
    sl_status status = sl_method_resolve(m->method, &first, error);
    m->first_picture = sl_process_seconds() - from;
    sl_image_destroy(first);
    return status;
}

/* Leaves in the settings how many bounces matter, for the estimate. */
static sl_status make_picture(const sl_scene *scene, sl_settings *settings, sl_pass_times *watch, made *m,
                              sl_error *error) {
    const sl_settings asked = *settings;
    double wall = sl_seconds_now(), cpu = sl_process_seconds();
    sl_transport ignored;
    sl_pass_times_begin(watch, sl_process_seconds);
    sl_status status = sl_method_choose(scene, &asked, settings, &ignored, NULL, error);
    if (status == SL_OK) status = sl_method_create(scene, settings, &m->method, error);
    while (status == SL_OK && !m->progress.done) {
        status = sl_method_update(m->method, &m->progress, error);
        if (settings->observer && status == SL_OK && !(m->first_picture > 0.0))
            status = show_first(m, cpu, error);
    }
    if (status == SL_OK) status = sl_method_resolve(m->method, &m->image, error);
    m->wall = sl_seconds_now() - wall;
    m->cpu = sl_process_seconds() - cpu;
    if (settings->observer) sl_pass_times_add(watch, "the rest", cpu + m->cpu - watch->last);
    return status;
}

/* Adds what the picture tells of itself, without the beginning of each name. */
static void add_metadata(cJSON *root, const sl_image *image) {
    static const char ours[] = "softlux.";
    cJSON *metadata = cJSON_AddObjectToObject(root, "metadata");
    for (size_t i = 0; i < image->metadata_count; i++) {
        const sl_metadatum *m = &image->metadata[i];
        if (strncmp(m->key, ours, sizeof ours - 1) == 0)
            cJSON_AddStringToObject(metadata, m->key + sizeof ours - 1, m->value);
    }
}

static cJSON *report(const sl_trial_run *run, const made *m, sl_pass_times *watch) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    cJSON *root = cJSON_CreateObject();
    cJSON_AddNumberToObject(root, "cpu_seconds", m->cpu);
    cJSON_AddNumberToObject(root, "wall_seconds", m->wall);
    cJSON_AddNumberToObject(root, "peak_bytes", 1024.0 * (double)usage.ru_maxrss);
    cJSON_AddNumberToObject(root, "method_bytes", (double)sl_method_memory_bytes(m->method));
    add_metadata(root, m->image);
    if (run->look) {
        cJSON_AddNumberToObject(root, "first_picture", m->first_picture);
        add_parts(root, watch);
    }
    return root;
}

/* Judges a tracer's picture by its own halves, another by probes on the paths that its method declares. What
 * cannot be judged tells nothing, nor does a bound that is infinite. */
static void add_estimate(const sl_scene *scene, const sl_settings *settings, const sl_image *picture,
                         cJSON *root) {
    enum { PROBES = 512, SAMPLES = 32 };
    sl_error_probe *probe = NULL;
    sl_error_estimate e = {0};
    sl_error error;
    sl_status status = sl_error_probe_create(scene, settings, &probe, &error);
    if (status == SL_OK && sl_image_channel(picture, "even.R"))
        status = sl_error_estimate_from_halves(picture, sl_error_probe_surfaces(probe), &e, &error);
    else if (status == SL_OK) status = sl_error_probe_estimate(probe, picture, PROBES, SAMPLES, &e, &error);
    sl_error_probe_destroy(probe);
    if (status != SL_OK || !isfinite(e.bound)) return;
    cJSON_AddNumberToObject(root, "estimate", e.rel_rmse);
    cJSON_AddNumberToObject(root, "bound", e.bound);
}

static sl_status write_picture(const made *m, const char *path, sl_error *error) {
    char seconds[32];
    snprintf(seconds, sizeof seconds, "%.4g", m->cpu);
    sl_status status = sl_image_set_metadata(m->image, SL_TRIAL_SECONDS, seconds, error);
    return status == SL_OK ? sl_image_write(m->image, path, error) : status;
}

bool sl_trial_work(void *context, char **answer) {
    static sl_pass_times watch;
    const sl_trial_run *run = context;
    sl_settings settings = sl_settings_default();
    sl_scene *scene = NULL;
    sl_error error = {SL_ERROR_USAGE, "a trial with arguments that mean nothing"};
    made m = {0};
    cJSON *root = NULL;
    sl_status status = sl_trial_settings(run->arguments, &settings) ? SL_OK : SL_ERROR_USAGE;
    settings.width = run->width;
    settings.height = run->height;
    if (!settings.threads) settings.threads = run->threads;
    settings.observer = run->look ? &watch.observer : NULL;
    sl_keep_freed_memory(&settings); /* as render does */
    if (status == SL_OK) status = sl_scene_load_with(run->scene_path, &run->load, &scene, &error);
    if (status == SL_OK) status = make_picture(scene, &settings, &watch, &m, &error);
    if (status == SL_OK) root = report(run, &m, &watch);
    if (status == SL_OK && run->picture) status = write_picture(&m, run->picture, &error);
    if (status == SL_OK && run->estimate) add_estimate(scene, &settings, m.image, root);
    *answer = status == SL_OK ? cJSON_PrintUnformatted(root) : strdup(error.message);
    cJSON_Delete(root);
    sl_image_destroy(m.image);
    sl_method_destroy(m.method);
    sl_scene_destroy(scene);
    return status == SL_OK;
}
