#include "cache/frame/settings.h"
#include "app/bench/audits.h"

#include "app/clock.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PROBES = 512, SAMPLES = 32 };

/* ---- in the child ---- */

typedef struct audit {
    const char *scene_path;
    const sl_bench_row *row;
    int width, height;
    unsigned threads;
    sl_load_options load;
} audit;

/* Judges a tracer's picture by its own halves, another by probes on the paths that its method declares. */
static sl_status estimate(const audit *a, const sl_scene *scene, const sl_image *picture,
                          sl_error_estimate *e, sl_error *error) {
    sl_settings settings = sl_settings_default();
    sl_error_probe *probe = NULL;
    sl_trial_settings(a->row->arguments, &settings);
    settings.width = a->width;
    settings.height = a->height;
    settings.threads = a->threads;
    sl_status status = sl_error_probe_create(scene, &settings, &probe, error);
    if (status == SL_OK && sl_image_channel(picture, "even.R"))
        status = sl_error_estimate_from_halves(picture, sl_error_probe_surfaces(probe), e, error);
    else if (status == SL_OK) status = sl_error_probe_estimate(probe, picture, PROBES, SAMPLES, e, error);
    sl_error_probe_destroy(probe);
    return status;
}

static bool audit_work(void *context, char **report) {
    const audit *a = context;
    sl_scene *scene = NULL;
    sl_image *picture = NULL;
    sl_error_estimate e = {0};
    sl_error error;
    char text[160];
    sl_status status = sl_scene_load_with(a->scene_path, &a->load, &scene, &error);
    if (status == SL_OK) status = sl_image_read(a->row->picture, &picture, &error);
    double from = sl_process_seconds();
    if (status == SL_OK) status = estimate(a, scene, picture, &e, &error);
    bool promised = isfinite(e.bound); /* JSON has no word for what is not */
    snprintf(text, sizeof text,
             "{\"estimate\": %.9g, \"bound\": %.9g, \"promised\": %s, \"cpu_seconds\": %.4f}", e.rel_rmse,
             promised ? e.bound : 0.0, promised ? "true" : "false", sl_process_seconds() - from);
    *report = strdup(status == SL_OK ? text : error.message);
    sl_image_destroy(picture);
    sl_scene_destroy(scene);
    return status == SL_OK;
}

/* ---- in the parent ---- */

static void take(const cJSON *entry, sl_bench_promise *p) {
    const cJSON *result = cJSON_GetObjectItem(entry, "result");
    if (!cJSON_IsTrue(cJSON_GetObjectItem(result, "promised"))) return;
    p->known = true;
    p->estimate = cJSON_GetObjectItem(result, "estimate")->valuedouble;
    p->bound = cJSON_GetObjectItem(result, "bound")->valuedouble;
    p->cpu_seconds = cJSON_GetObjectItem(result, "cpu_seconds")->valuedouble;
}

sl_status sl_audits_run(const sl_bench_options *o, sl_bench_scene *s, sl_journal *journal, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; i < s->row_count && status == SL_OK; i++) {
        char key[1024];
        sl_bench_row *row = &s->rows[i];
        if (row->end != SL_BENCH_RAN || access(row->picture, R_OK) != 0) continue;
        snprintf(key, sizeof key, "%s %dx%d, %s %s, %s, audit of surfaces", s->hash, s->width, s->height,
                 SL_VERSION, o->program, row->arguments);
        if (!sl_journal_find(journal, key) && !sl_interrupted()) {
            if (!o->quiet && isatty(STDERR_FILENO))
                fprintf(stderr, "\r\033[K%s, error without a reference: %s, %s", s->name, row->curve,
                        row->name);
            audit a = {s->path, row, s->width, s->height, o->threads, o->load};
            status = sl_schedule_child(o, s, key, o->limit, audit_work, &a, journal, error);
        }
        if (status == SL_OK) take(sl_journal_find(journal, key), &row->promise);
    }
    return status;
}
