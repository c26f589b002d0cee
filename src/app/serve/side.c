/* One method that is shown while it works: from the world's scene it is drawn, another copy is its own. */
#include "app/serve/stage_parts.h"

#include "app/clock.h"
#include "app/page.h"
#include "base/error.h"
#include "cache/frame/method.h"

#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

/* Seconds between frames while somebody moves, while samples come, and between accounts. */
static const double moving = 1.0 / 60.0, refining = 1.0 / 12.0, telling = 0.5;

const char *sl_side_name(int index) { return index ? "b" : "a"; }

/* ---- life ---- */

/* Splatting's own choice for soft shadows, rays, takes two and a half times as long for each frame; and a
 * frame of fewer records comes sooner. */
sl_settings sl_side_shown(const sl_settings *settings) {
    sl_settings shown = *settings;
    if (strcmp(shown.method, "splatting") == 0 && shown.direct == SL_DIRECT_AUTO)
        shown.direct = SL_DIRECT_SHADOW_MAPS;
    if (!shown.records_per_frame) shown.records_per_frame = 24;
    return shown;
}

/* A show with all that only it has. Whoever waits for its last update, to end it, is a show's thread and not
 * the stage's. */
struct sl_side_show {
    const sl_world *world;
    sl_scene *scene;   /* the updates' */
    uint64_t has;      /* events that were made to it before the updates began */
    const sl_event **events; /* all that there were when it was asked for */
    size_t count;
    sl_live *live; /* NULL: it could not begin */
    sl_passes *passes;
    sl_side_show *before;
};

/* Returns its scene, or NULL, and how many events that has had. NULL is allowed. */
static sl_scene *end_show(sl_side_show *w, uint64_t *has) {
    *has = 0;
    if (!w) return NULL;
    if (w->live) {
        const uint64_t last = sl_live_halt(w->live);
        *has = last ? last : w->has;
    }
    sl_scene *scene = w->live ? w->scene : end_show(w->before, has);
    sl_live_stop(w->live, NULL);
    sl_passes_destroy(w->passes);
    free(w->events);
    free(w);
    return scene;
}

/* The updating thread's first work. Samples give way to frames and to the network: on Linux a thread has a
 * priority of its own, and those that it starts have that, too. */
static sl_status open_show(void *context, sl_scene **scene, sl_error *error) {
    sl_side_show *w = context;
    setpriority(PRIO_PROCESS, 0, 5);
    w->scene = end_show(w->before, &w->has);
    w->before = NULL;
    if (!w->scene) w->has = 0;
    sl_status status = w->scene ? SL_OK : sl_world_copy(w->world, &w->scene, error);
    if (status == SL_OK)
        status = sl_events_make(w->events + w->has, w->count - w->has, w->scene, error);
    w->has = w->count;
    if (status != SL_OK) sl_scene_destroy(w->scene), w->scene = NULL;
    *scene = w->scene;
    return status;
}

/* The newest show of a side, which is not yet begun. */
static sl_status add_show(sl_stage *s, sl_side *d, sl_error *error) {
    const size_t count = s->world.count;
    sl_side_show *w = calloc(1, sizeof *w);
    const sl_event **events = malloc((count + 1) * sizeof *events);
    if (!w || !events) {
        free(w), free(events);
        return sl_fail_memory(error, "a show");
    }
    if (count) memcpy(events, s->world.events, count * sizeof *events);
    *w = (sl_side_show){.world = &s->world, .events = events, .count = count, .before = d->show};
    if (d->observed) w->passes = sl_passes_create(d->settings.method);
    d->show = w;
    d->has = count;
    return SL_OK;
}

sl_status sl_side_start(sl_stage *s, int index, sl_error *error) {
    sl_side *d = &s->side[index];
    sl_status status = add_show(s, d, error);
    sl_settings settings = sl_side_shown(&d->settings);
    if (status == SL_OK && d->show->passes) settings.observer = sl_passes_observer(d->show->passes);
    if (status == SL_OK)
        status =
            sl_live_start_beside(open_show, d->show, s->world.scene, &settings, &d->show->live, error);
    d->wanted = status == SL_OK;
    if (d->wanted) d->live = d->show->live, d->passes = d->show->passes;
    d->began = d->moved = sl_seconds_now();
    d->last = (sl_live_state){0};
    d->rate = (sl_rate){0};
    d->shown = s->world.count;
    d->sent_still = false;
    d->edit = 0;
    if (status == SL_OK && !s->viewers) sl_live_rest(d->live, true);
    return status;
}

void sl_side_stop(sl_stage *s, int index) {
    sl_side *d = &s->side[index];
    if (d->live) sl_live_leave(d->live);
    d->passes = NULL;
    d->live = NULL;
    d->wanted = false;
}

void sl_side_close(sl_stage *s, int index) {
    uint64_t ignored;
    sl_side_stop(s, index);
    sl_scene_destroy(end_show(s->side[index].show, &ignored));
    s->side[index].show = NULL;
}

sl_status sl_side_follow(sl_stage *s, int index, unsigned changes, sl_error *error) {
    sl_side *d = &s->side[index];
    const sl_event *e = s->world.events[s->world.count - 1];
    if (!d->live) return SL_OK;
    if (changes & ~(unsigned)SL_CHANGED_CAMERA) {
        d->edit = e->number;
        d->edit_changes = changes;
        sl_live_counters(d->live, &d->before_edit);
    }
    d->moved = sl_seconds_now();
    d->sent_still = false;
    const sl_live_change change = {sl_event_make, e, e->number, e->kind};
    return sl_live_follow(d->live, &change, changes, error);
}

/* ---- accounts ---- */

static void add_kept(const sl_side *d, cJSON *state, const sl_counters *now) {
    sl_counters since = *now;
    cJSON *kept = cJSON_AddObjectToObject(state, "kept");
    cJSON_AddNumberToObject(kept, "event", (double)d->edit);
    cJSON_AddItemToObject(kept, "changes", sl_describe_changes(d->edit_changes));
    cJSON *counters = cJSON_AddObjectToObject(kept, "counters");
    sl_json_add_counters(counters, "before", &d->before_edit, false);
    for (int i = 0; i < SL_COUNTERS; i++) since.value[i] -= d->before_edit.value[i];
    sl_json_add_counters(counters, "since", &since, false);
}

static void tell_state(sl_stage *s, int index) {
    const sl_side *d = &s->side[index];
    sl_counters now;
    cJSON *state = sl_message_of_side("state", index);
    sl_live_counters(d->live, &now);
    cJSON_AddStringToObject(state, "method", d->settings.method);
    cJSON_AddNumberToObject(state, "seconds", sl_seconds_now() - d->began);
    cJSON_AddNumberToObject(state, "batches", (double)d->last.updates);
    cJSON_AddBoolToObject(state, "done", d->last.done);
    cJSON_AddNumberToObject(state, "latency", 1e3 * d->latency);
    cJSON_AddNumberToObject(state, "drawing", 1e3 * d->drawing);
    cJSON_AddNumberToObject(state, "encoding", 1e3 * d->encoding);
    cJSON_AddNumberToObject(state, "frame", d->frame);
    cJSON_AddStringToObject(state, "reduced", sl_live_reduction(d->live));
    cJSON_AddItemToObject(state, "settings", sl_describe_settings(&d->settings));
    sl_json_add_counters(state, "counters", &now, false);
    if (d->edit) add_kept(d, state, &now);
    sl_say(s, 0, state);
}

/* ---- frames ---- */

static bool is_due(const sl_stage *s, const sl_side *d, double now) {
    const double since = now - d->drawn;
    if (d->shown != s->world.count) return since >= moving;
    return since >= refining && !(d->last.done && d->sent_still);
}

static void note_latency(const sl_stage *s, sl_side *d, uint64_t shown) {
    if (shown != d->shown && shown + SL_TIMES > s->world.count)
        d->latency = sl_seconds_now() - s->times[shown % SL_TIMES];
    d->shown = shown;
}

/* What a side that has failed leaves is a line for all. */
static void fail(sl_stage *s, int index, const sl_error *error) {
    cJSON *refused = sl_refusal("method", error);
    cJSON_AddStringToObject(refused, "side", sl_side_name(index));
    sl_say(s, 0, refused);
    sl_side_stop(s, index);
}

static void draw(sl_stage *s, int index, double now) {
    sl_side *d = &s->side[index];
    const sl_image *frame;
    sl_live_state state;
    sl_error error;
    const double begun = sl_thread_seconds();
    sl_status status = sl_live_frame(d->live, &frame, &state, &error);
    if (status == SL_OK) status = sl_rate_tell(&d->rate, d->live, &d->settings, &state, &error);
    if (status != SL_OK) {
        fail(s, index, &error);
        return;
    }
    const uint64_t followed = sl_live_shows(d->live), shown = followed > d->has ? followed : d->has;
    const bool differs = state.versions != d->last.versions || shown != d->shown,
               still = state.done && shown == s->world.count && now - d->moved > 0.2;
    d->last = state;
    if (differs || shown == s->world.count) d->drawn = now; /* else a picture is on its way */
    if (!state.versions || (!differs && (!still || d->sent_still))) return;
    const double drawn = sl_thread_seconds();
    note_latency(s, d, shown);
    sl_show(s, (sl_frame_kind)index, (unsigned)index, frame, &s->tone, shown, still);
    if (index == 0) sl_film_frame(s, frame);
    if (shown == s->world.count) sl_worker_see(s->worker, index, frame, &d->settings);
    d->drawing = drawn - begun;
    d->encoding = sl_thread_seconds() - drawn;
    d->frame = s->frame;
    d->sent_still = still;
}

void sl_side_step(sl_stage *s, int index, double now) {
    sl_side *d = &s->side[index];
    const bool rested = d->last.done && d->sent_still;
    if (!d->live && d->show && (!d->show->live || sl_live_has_ended(d->show->live))) sl_side_close(s, index);
    if (!d->live) return;
    if (is_due(s, d, now)) draw(s, index, now);
    if (d->passes) sl_passes_step(s, d->passes, index, now);
    if (!d->live || now - d->told < telling || (rested && d->told > d->drawn)) return;
    d->told = now;
    tell_state(s, index);
}
