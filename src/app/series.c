/* A picture, or a series of an animated scene. */
#include "app/clock.h"
#include "app/files_of_ranks.h"
#include "app/page.h"
#include "app/picture.h"
#include "app/same_file.h"
#include "base/batch.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/ranks.h"
#include "cache/frame/method.h"

#include <stdio.h>
#include <string.h>

/* What is being rendered. */
typedef struct job {
    const sl_render_options *options;
    sl_scene *scene;
    sl_method *method;
    double begin; /* seconds */
    sl_progress progress; /* of the last picture */
} job;

/* Makes a method, with the cache of another run where there is one. */
static sl_status create(const sl_render_options *o, const sl_scene *scene, sl_method **method,
                        sl_error *error) {
    sl_status status = sl_method_create(scene, &o->settings, method, error);
    if (status == SL_OK && (o->load_cache || o->save_cache) && !sl_method_keeps_cache(*method))
        status = sl_fail(error, SL_ERROR_USAGE, "--%s-cache: %s keeps no cache",
                 o->load_cache ? "load" : "save", o->settings.method);
    if (status == SL_OK) (*method)->batch_by_batch = o->batches > 0;
    if (status == SL_OK && o->load_cache) status = sl_method_load(*method, o->load_cache, error);
    return status;
}

/* ---- one picture ---- */

static uint64_t records_of(const sl_method *method) {
    return sl_method_counters(method)->value[SL_COUNT_RECORDS];
}

/* Returns what is told of a frame of a series. */
static cJSON *frame_json(const job *j, uint64_t frame, double seconds, uint64_t records,
                         const sl_image *image) {
    char name[4096];
    cJSON *json = cJSON_CreateObject();
    sl_frame_name(j->options->output, frame, name, sizeof name);
    cJSON_AddNumberToObject(json, "frame", (double)frame);
    cJSON_AddStringToObject(json, "output", name);
    cJSON_AddNumberToObject(json, "seconds", seconds);
    cJSON_AddNumberToObject(json, "new_records", (double)records);
    cJSON_AddBoolToObject(json, "done", j->progress.done);
    sl_picture_add_warnings(json, image);
    return json;
}

/* Renders the picture, or frame number `frame`, of the scene as it stands into a file; an interrupted frame
 * is none. *json: what is told of it, or NULL. */
static sl_status render_one(job *j, uint64_t frame, const char *file, cJSON **json, sl_error *error) {
    const sl_render_options *o = j->options;
    const bool series = o->frames > 0;
    const double start = series ? sl_seconds_now() : j->begin;
    const uint64_t records = records_of(j->method);
    sl_image *image = NULL;
    double stops = 0.0;
    *json = NULL;
    j->progress = (sl_progress){0};
    sl_status status = sl_picture_run(o, j->method, &j->progress, j->begin,
                                      series ? (double)frame / (double)o->frames : 0.0, error);
    if (status != SL_OK || (series && sl_interrupted())) return status;
    status = sl_method_resolve(j->method, &image, error);
    const double seconds = sl_seconds_now() - start; /* writing it not included */
    if (status == SL_OK && frame == 0) sl_picture_warn(o, j->scene, &j->progress, image);
    if (status == SL_OK) status = sl_picture_write(o, image, file, &stops, error);
    if (status == SL_OK && o->json) {
        *json = series ? frame_json(j, frame, seconds, records_of(j->method) - records, image)
                       : sl_picture_json(o, j->scene, j->method, image, &j->progress, seconds);
        sl_picture_add_tone(o, stops, *json);
    }
    sl_image_destroy(image);
    return status;
}

/* Moves the scene on to a frame after the first. */
static sl_status move_on(job *j, uint64_t frame, sl_error *error) {
    const sl_render_options *o = j->options;
    unsigned changes = 0;
    if (!frame) return SL_OK;
    sl_status status =
        sl_scene_set_time(j->scene, o->at_seconds + (double)frame / o->frames_per_second, &changes, error);
    return status == SL_OK && changes ? sl_method_edit(j->method, changes, error) : status;
}

/* ---- one after the other ---- */

static sl_status render_frame(job *j, uint64_t frame, sl_error *error) {
    char name[4096];
    cJSON *json = NULL;
    snprintf(name, sizeof name, "%s", j->options->output);
    if (j->options->frames) sl_frame_name(j->options->output, frame, name, sizeof name);
    sl_status status = move_on(j, frame, error);
    if (status == SL_OK) status = render_one(j, frame, name, &json, error);
    if (json) sl_json_print(json, j->options->frames > 0);
    return status;
}

/* ---- a frame a rank ---- */

/* At once; with a journal they are what a call that ends early loses at most. */
enum { TOGETHER = 64, TOLD = 16384 };

typedef struct group {
    job *job;
    uint64_t first;
    const char *folder; /* for pictures of ranks behind the first */
    uint64_t call;      /* a number of this call's own */
} group;

/* What a rank tells of its frame. */
typedef struct drawn {
    uint64_t call;
    unsigned rank;
    sl_error error;
    char json[TOLD];
} drawn;

/* The first rank draws to where pictures belong. */
static void name_frame(const group *g, uint64_t frame, bool first, char name[SL_RANKS_PATH]) {
    const char *output = g->job->options->output;
    const char *format = strrchr(output, '.');
    if (first) sl_frame_name(output, frame, name, SL_RANKS_PATH);
    else snprintf(name, SL_RANKS_PATH, "%s/%llu%s", g->folder, (unsigned long long)frame, format);
}

static void draw_item(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)worker, (void)counters;
    const group *g = context;
    const uint64_t frame = g->first + index;
    drawn *d = result;
    char name[SL_RANKS_PATH];
    cJSON *json = NULL;
    *d = (drawn){.call = g->call, .rank = sl_ranks_here().rank};
    name_frame(g, frame, d->rank == 0, name);
    d->error.status = move_on(g->job, frame, &d->error);
    if (d->error.status == SL_OK) d->error.status = render_one(g->job, frame, name, &json, &d->error);
    if (json) cJSON_PrintPreallocated(json, d->json, TOLD, false);
    cJSON_Delete(json);
}

/* Brings a frame to the first rank, which tells of it. One of an earlier call's is there. */
static sl_status take_frame(const group *g, uint64_t frame, const drawn *d, sl_error *error) {
    const bool first = sl_ranks_here().rank == 0;
    char name[SL_RANKS_PATH];
    sl_status status = d->error.status;
    if (status != SL_OK) *error = d->error;
    name_frame(g, frame, first, name);
    if (status == SL_OK && d->call == g->call && d->rank)
        status = sl_share_file(d->rank, name, first ? name : NULL, error);
    if (!first) remove(name);
    if (status == SL_OK && d->json[0]) sl_json_print(cJSON_Parse(d->json), true);
    return status;
}

static sl_status render_group(group *g, uint64_t count, sl_error *error) {
    drawn *all = sl_allocate((size_t)count, sizeof *all);
    const sl_batch batch = {.count = (size_t)count, .work = draw_item, .context = g, .results = all,
                            .result_bytes = sizeof *all, .shared = true};
    sl_counters counters = {{0}};
    if (!all) return sl_fail_memory(error, "frames of a series");
    sl_batch_run(&batch, 1, &counters);
    sl_status status = SL_OK;
    for (uint64_t i = 0; i < count && status == SL_OK && !sl_interrupted(); i++)
        status = take_frame(g, g->first + i, &all[i], error);
    sl_free(all);
    return status;
}

static sl_status render_groups(job *j, uint64_t *whole, sl_error *error) {
    char folder[SL_RANKS_FOLDER];
    const uint64_t frames = j->options->frames;
    group g = {.job = j, .folder = folder, .call = (uint64_t)(1e6 * sl_seconds_now())};
    sl_ranks_tell(0, &g.call, sizeof g.call);
    sl_status status = sl_own_folder(folder, error);
    if (status != SL_OK) return status;
    for (; status == SL_OK && g.first < frames && !sl_interrupted(); g.first += TOGETHER) {
        const uint64_t left = frames - g.first, count = left < TOGETHER ? left : TOGETHER;
        status = render_group(&g, count, error);
        if (!sl_interrupted()) *whole += count;
    }
    sl_own_folder_remove(folder);
    return status;
}

/* ---- any ---- */

/* Renders frame by frame, or the one picture. */
static sl_status render_frames(job *j, uint64_t *whole, sl_error *error) {
    const sl_render_options *o = j->options;
    const uint64_t frames = o->frames ? o->frames : 1;
    sl_status status = SL_OK;
    for (uint64_t f = 0; status == SL_OK && f < frames && !(o->frames && sl_interrupted()); f++) {
        status = render_frame(j, f, error);
        *whole += !sl_interrupted() ||
                  (!o->frames && (j->progress.done || (o->batches && j->progress.batches >= o->batches)));
    }
    return status;
}

sl_status sl_render_pictures(const sl_render_options *o, sl_scene *scene, sl_render_end *end,
                             sl_error *error) {
    job j = {.options = o, .scene = scene, .begin = sl_seconds_now()};
    uint64_t whole = 0;
    sl_watch_for_interrupt();
    sl_status status = create(o, scene, &j.method, error);
    const bool apart = status == SL_OK && o->frames && sl_ranks_share() && j.method->class->draws_anew;
    if (status == SL_OK) status = (apart ? render_groups : render_frames)(&j, &whole, error);
    if (whole < (o->frames ? o->frames : 1)) *end = SL_RENDER_STOPPED;
    if (o->frames) sl_progress_keep(o->quiet);
    if (status == SL_OK && o->save_cache) status = sl_method_save(j.method, o->save_cache, error);
    if (status == SL_OK && !o->frames) sl_picture_stopped(o, &j.progress);
    if (status == SL_OK && o->frames && sl_interrupted() && !o->quiet)
        fprintf(stderr, "softlux: stopped; %llu frames are whole\n", (unsigned long long)whole);
    sl_method_destroy(j.method);
    return status;
}
