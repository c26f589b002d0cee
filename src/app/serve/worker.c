#include "app/serve/worker.h"

#include "app/clock.h"
#include "app/picture.h"
#include "app/steps/run.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/thread.h"
#include "image/tone.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 16384, PROBES = 600, PROBE_SAMPLES = 16 };
/* Seconds: after the last event, before anything is begun; between pictures; between judgements. */
static const double quiet = 0.4, showing = 0.7, judging = 1.0;

typedef struct seen {
    sl_image *picture; /* not judged yet; or NULL */
    sl_settings settings;
} seen;

struct sl_worker {
    const sl_world *world;
    sl_thread thread;
    bool runs;

    sl_monitor meeting; /* guards what follows */
    bool stop, reference, error;
    sl_settings settings;
    bool resized;
    const sl_event **events; /* not made yet */
    size_t event_count, event_room;
    double last_event;
    seen seen[SL_WORKER_SIDES];
    sl_exact_job *job; /* not begun */
    bool leave_off;
    sl_work_done done;
    bool news;

    /* the thread's own */
    sl_scene *scene;
    sl_method *path;
    sl_progress path_progress;
    sl_image *path_picture;
    double shown, judged;
    sl_error_probe *probe;
    sl_settings probe_settings;
    sl_exact_job *exact;
    sl_scene *exact_scene;
    sl_method *exact_method;
};

/* Puts a picture in another's place; NULL: none. */
static void renew(sl_image **picture, sl_image *by) {
    sl_image_destroy(*picture);
    *picture = by;
}

/* ---- the scene ---- */

static void forget(sl_worker *w) {
    sl_method_destroy(w->path);
    sl_error_probe_destroy(w->probe);
    renew(&w->path_picture, NULL);
    w->path = NULL;
    w->probe = NULL;
}

static sl_status follow(sl_worker *w, sl_error *error) {
    sl_monitor_enter(&w->meeting);
    const sl_event **events = w->events;
    const size_t count = w->event_count;
    const bool changed = count > 0 || w->resized;
    w->events = NULL;
    w->event_count = w->event_room = 0;
    w->resized = false;
    sl_monitor_leave(&w->meeting);
    if (changed) forget(w);
    sl_status status = w->scene ? SL_OK : sl_world_copy(w->world, &w->scene, error);
    if (status == SL_OK) status = sl_events_make(events, count, w->scene, error);
    sl_free(events);
    return status;
}

/* ---- the reference ---- */

static sl_status create_path(sl_worker *w, const sl_settings *as, sl_error *error) {
    sl_settings settings = *as;
    settings.method = "path";
    settings.spp = SAMPLES;
    settings.threads = 1;
    settings.seed = as->seed + 0x5eedu; /* noise of its own */
    settings.observer = NULL;
    w->path_progress = (sl_progress){0};
    return sl_method_create(w->scene, &settings, &w->path, error);
}

static sl_status step_reference(sl_worker *w, const sl_settings *as, sl_error *error) {
    sl_image *copy = NULL;
    sl_status status = w->path ? SL_OK : create_path(w, as, error);
    if (status == SL_OK) status = sl_method_update(w->path, &w->path_progress, error);
    const double now = sl_seconds_now();
    if (status != SL_OK || (now - w->shown < showing && !w->path_progress.done)) return status;
    w->shown = now;
    renew(&w->path_picture, NULL);
    status = sl_method_resolve(w->path, &w->path_picture, error);
    if (status == SL_OK) status = sl_method_resolve(w->path, &copy, error);
    sl_monitor_enter(&w->meeting);
    if (copy) {
        renew(&w->done.reference, copy);
        w->done.samples = w->path_progress.batches;
        w->done.reference_done = w->path_progress.done;
        w->news = true;
    }
    sl_monitor_leave(&w->meeting);
    return status;
}

/* ---- judgements ---- */

/* The size of the relative difference, as brightness: white where it is half of the value or more. */
static sl_image *map_of(const sl_image *picture, const sl_image *reference) {
    sl_image *map = NULL;
    if (sl_image_create(picture->width, picture->height, 3, NULL, &map, NULL) != SL_OK) return NULL;
    const size_t pixels = (size_t)picture->width * (size_t)picture->height;
    const float *x[3], *r[3];
    double mean = 0.0;
    if (!sl_layer_planes(picture, NULL, x) || !sl_layer_planes(reference, NULL, r)) return map;
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < pixels; i++) mean += (double)fabsf(r[c][i]) / (3.0 * (double)pixels);
    for (size_t i = 0; i < pixels; i++) {
        float most = 0.0f;
        for (size_t c = 0; c < 3; c++)
            most = fmaxf(most, fabsf(x[c][i] - r[c][i]) / (fabsf(r[c][i]) + 0.1f * (float)mean));
        for (size_t c = 0; c < 3; c++) map->planes[c * pixels + i] = fminf(4.0f * most * most, 1.0f);
    }
    return map;
}

static void publish(sl_worker *w, int side, double error, sl_image *difference, sl_image *map) {
    sl_work_done *d = &w->done;
    sl_monitor_enter(&w->meeting);
    if (difference) renew(&d->side[side].difference, difference);
    if (map) renew(&d->side[side].map, map);
    d->side[side].judged = true;
    d->side[side].error = error;
    w->news = true;
    sl_monitor_leave(&w->meeting);
}

static sl_status judge_by_reference(sl_worker *w, int side, const seen *s, sl_error *error) {
    sl_comparison c;
    sl_image *difference = NULL;
    sl_status status = sl_image_compare(s->picture, w->path_picture, NULL, &c, &difference, error);
    if (status == SL_OK) publish(w, side, c.rel_rmse, difference, map_of(s->picture, w->path_picture));
    return status;
}

static bool same_probes(const sl_settings *a, const sl_settings *b) {
    return strcmp(a->method, b->method) == 0 && a->bounces == b->bounces && a->width == b->width &&
           a->height == b->height && a->quality == b->quality;
}

static sl_status judge_by_probes(sl_worker *w, int side, const seen *s, sl_error *error) {
    sl_error_estimate e;
    sl_settings settings = s->settings;
    settings.threads = 1;
    settings.observer = NULL;
    if (w->probe && !same_probes(&settings, &w->probe_settings)) {
        sl_error_probe_destroy(w->probe);
        w->probe = NULL;
    }
    w->probe_settings = settings;
    sl_status status = w->probe ? SL_OK : sl_error_probe_create(w->scene, &settings, &w->probe, error);
    if (status == SL_OK)
        status = sl_error_probe_estimate(w->probe, s->picture, PROBES, PROBE_SAMPLES, &e, error);
    if (status == SL_OK) publish(w, side, e.rel_rmse, NULL, NULL);
    return status;
}

static seen take_seen(sl_worker *w, int side) {
    sl_monitor_enter(&w->meeting);
    const seen s = w->seen[side];
    w->seen[side].picture = NULL;
    sl_monitor_leave(&w->meeting);
    return s;
}

static void judge(sl_worker *w, bool reference, bool error) {
    sl_error ignored;
    w->judged = sl_seconds_now();
    for (int side = 0; side < SL_WORKER_SIDES; side++) {
        const seen s = take_seen(w, side);
        if (s.picture && reference && w->path_picture) judge_by_reference(w, side, &s, &ignored);
        else if (s.picture && error) judge_by_probes(w, side, &s, &ignored);
        sl_image_destroy(s.picture);
    }
}

/* ---- the exact picture ---- */

static void leave_exact(sl_worker *w) {
    sl_method_destroy(w->exact_method);
    sl_scene_destroy(w->exact_scene);
    free(w->exact);
    w->exact_method = NULL;
    w->exact_scene = NULL;
    w->exact = NULL;
}

static sl_status begin_exact(sl_worker *w, sl_error *error) {
    const sl_exact_job *j = w->exact;
    sl_status status = sl_scene_load_with(j->scene_path, &j->load, &w->exact_scene, error);
    if (status == SL_OK) status = sl_scene_set_time(w->exact_scene, j->at_seconds, NULL, error);
    return status == SL_OK ? sl_method_create(w->exact_scene, &j->settings, &w->exact_method, error) : status;
}

static sl_status finish_exact(sl_worker *w, sl_image **picture, sl_error *error) {
    const sl_render_options as = {.tone = SL_TONE_REINHARD};
    double ignored;
    sl_status status = sl_method_resolve(w->exact_method, picture, error);
    if (status == SL_OK) status = sl_picture_write(&as, *picture, w->exact->exr, &ignored, error);
    return status == SL_OK ? sl_picture_write(&as, *picture, w->exact->png, &ignored, error) : status;
}

/* All at once. */
static sl_status make_page(const sl_exact_job *j, sl_error *error) {
    sl_scene *scene = NULL;
    const sl_steps_options o = {.settings = j->settings, .reference_samples = 16, .quiet = true};
    sl_status status = sl_scene_load_with(j->scene_path, &j->load, &scene, error);
    if (status == SL_OK) status = sl_scene_set_time(scene, j->at_seconds, NULL, error);
    if (status == SL_OK) status = sl_steps_write(scene, j->scene_path, &o, j->page, error);
    sl_scene_destroy(scene);
    return status;
}

/* Nothing of one that another has taken the place of. */
static void publish_exact(sl_worker *w, const sl_progress *progress, const sl_error *error,
                          sl_image *picture) {
    sl_monitor_enter(&w->meeting);
    if (w->leave_off) {
        sl_image_destroy(picture);
    } else {
        renew(&w->done.exact, picture);
        w->done.exact_news = w->news = true;
        w->done.exact_done = progress->done;
        w->done.fraction = progress->fraction;
        w->done.exact_error = *error;
    }
    sl_monitor_leave(&w->meeting);
}

static void step_exact(sl_worker *w) {
    sl_progress progress = {0};
    sl_image *picture = NULL;
    sl_error error = {.status = SL_OK};
    const bool page = *w->exact->page;
    sl_status status = page ? make_page(w->exact, &error) : w->exact_method ? SL_OK : begin_exact(w, &error);
    progress.done = page;
    if (status == SL_OK && !page) status = sl_method_update(w->exact_method, &progress, &error);
    if (status == SL_OK && !page && progress.done) status = finish_exact(w, &picture, &error);
    error.status = status;
    publish_exact(w, &progress, &error, picture);
    if (status != SL_OK || progress.done) leave_exact(w);
}

/* ---- the thread ---- */

typedef struct turn {
    bool goes_on, exact, reference, error, rests;
    sl_settings settings;
} turn;

/* What is to be done next; waits a little where nothing is. */
static turn next_turn(sl_worker *w) {
    sl_monitor_enter(&w->meeting);
    if (w->leave_off || w->job) {
        leave_exact(w);
        w->exact = w->job;
        w->job = NULL;
        w->leave_off = false;
    }
    const bool still = sl_seconds_now() - w->last_event > quiet, wants = w->reference || w->error;
    const turn t = {!w->stop,          w->exact != NULL, w->reference && still,
                    w->error && still, !wants || !still, w->settings};
    const bool idle = !t.exact && (t.rests || (w->path_progress.done && w->path) || !w->reference);
    if (t.goes_on && idle) sl_monitor_wait_for(&w->meeting, wants ? 0.1 : 1.0);
    sl_monitor_leave(&w->meeting);
    return t;
}

static void work(void *context) {
    sl_worker *w = context;
    turn t;
    sl_error ignored;
    while ((t = next_turn(w)).goes_on) {
        if (t.exact) {
            step_exact(w);
            continue;
        }
        if (!t.reference && !t.error) continue;
        sl_status status = follow(w, &ignored);
        const bool grown = w->path && w->path_progress.done;
        if (status == SL_OK && t.reference && !grown) status = step_reference(w, &t.settings, &ignored);
        if (status == SL_OK && sl_seconds_now() - w->judged > judging) judge(w, t.reference, t.error);
        if (status != SL_OK) sl_sleep_until(sl_seconds_now() + 0.5);
    }
}

/* ---- the stage's side ---- */

sl_status sl_worker_start(const sl_world *world, sl_worker **worker, sl_error *error) {
    sl_worker *w = calloc(1, sizeof *w);
    *worker = NULL;
    if (w && sl_monitor_open(&w->meeting)) {
        w->world = world;
        w->runs = sl_thread_start(&w->thread, work, w);
        if (w->runs) *worker = w;
        else sl_monitor_close(&w->meeting);
    }
    if (!*worker) free(w);
    return *worker ? SL_OK : sl_fail(error, SL_ERROR_RESOURCES, "no thread could be had beside the shows");
}

void sl_work_forget(sl_work_done *d) {
    sl_image_destroy(d->exact);
    sl_image_destroy(d->reference);
    for (int i = 0; i < SL_WORKER_SIDES; i++) {
        sl_image_destroy(d->side[i].difference);
        sl_image_destroy(d->side[i].map);
    }
}

/* What was is of no use any more. */
static void forget_seen(sl_worker *w) {
    for (int i = 0; i < SL_WORKER_SIDES; i++) renew(&w->seen[i].picture, NULL);
}

void sl_worker_stop(sl_worker *w) {
    if (!w) return;
    sl_monitor_enter(&w->meeting);
    w->stop = true;
    sl_monitor_signal(&w->meeting);
    sl_monitor_leave(&w->meeting);
    sl_thread_join(&w->thread);
    leave_exact(w);
    forget(w);
    sl_work_forget(&w->done);
    forget_seen(w);
    sl_scene_destroy(w->scene);
    sl_free(w->events);
    free(w->job);
    sl_monitor_close(&w->meeting);
    free(w);
}

void sl_worker_follow(sl_worker *w, const sl_event *event) {
    sl_monitor_enter(&w->meeting);
    if (sl_make_room(&w->events, w->event_count, &w->event_room, sizeof *w->events))
        w->events[w->event_count++] = event;
    w->last_event = sl_seconds_now();
    forget_seen(w);
    sl_monitor_leave(&w->meeting);
}

void sl_worker_want(sl_worker *w, bool reference, bool error, const sl_settings *settings) {
    sl_monitor_enter(&w->meeting);
    w->resized = w->resized || w->settings.width != settings->width || w->settings.height != settings->height;
    w->reference = reference;
    w->error = error;
    w->settings = *settings;
    if (w->resized) forget_seen(w);
    sl_monitor_signal(&w->meeting);
    sl_monitor_leave(&w->meeting);
}

void sl_worker_see(sl_worker *w, int side, const sl_image *picture, const sl_settings *settings) {
    const size_t values = 3 * (size_t)picture->width * (size_t)picture->height;
    sl_monitor_enter(&w->meeting);
    seen *s = &w->seen[side];
    const bool wanted = w->reference || w->error;
    const bool fits =
        s->picture && s->picture->width == picture->width && s->picture->height == picture->height;
    if (!fits) renew(&s->picture, NULL);
    if (wanted && !s->picture) sl_image_create(picture->width, picture->height, 3, NULL, &s->picture, NULL);
    if (wanted && s->picture) memcpy(s->picture->planes, picture->planes, values * sizeof(float));
    s->settings = *settings;
    sl_monitor_leave(&w->meeting);
}

void sl_worker_exact(sl_worker *w, const sl_exact_job *job) {
    sl_exact_job *own = job ? malloc(sizeof *own) : NULL;
    if (own) *own = *job;
    sl_monitor_enter(&w->meeting);
    free(w->job);
    w->job = own;
    w->leave_off = true;
    renew(&w->done.exact, NULL);
    w->done.exact_news = false;
    sl_monitor_signal(&w->meeting);
    sl_monitor_leave(&w->meeting);
}

bool sl_worker_take(sl_worker *w, sl_work_done *done) {
    sl_monitor_enter(&w->meeting);
    const bool news = w->news;
    *done = w->done;
    w->done = (sl_work_done){.fraction = 0.0};
    w->news = false;
    sl_monitor_leave(&w->meeting);
    return news;
}
