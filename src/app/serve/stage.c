#include "app/serve/stage_parts.h"

#include "app/clock.h"
#include "base/error.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- to viewers ---- */

cJSON *sl_message(const char *is) {
    cJSON *m = cJSON_CreateObject();
    cJSON_AddStringToObject(m, "is", is);
    return m;
}

cJSON *sl_message_of_side(const char *is, int side) {
    cJSON *m = sl_message(is);
    cJSON_AddStringToObject(m, "side", sl_side_name(side));
    return m;
}

cJSON *sl_refusal(const char *what, const sl_error *error) {
    cJSON *m = sl_message("refused");
    cJSON_AddStringToObject(m, "do", what);
    cJSON_AddStringToObject(m, "reason", error->message);
    return m;
}

void sl_say(sl_stage *s, unsigned client, cJSON *message) {
    sl_mail_send(s->mail, sl_packet_text(client, message));
}

void sl_show(sl_stage *s, sl_frame_kind kind, unsigned index, const sl_image *picture, sl_tone *tone,
             uint64_t event, bool still) {
    const sl_frame_told told = {kind, index, ++s->frame, event, still};
    uint8_t *rgb = malloc(3 * (size_t)picture->width * (size_t)picture->height);
    if (rgb && sl_image_srgb(picture, tone, rgb, NULL) == SL_OK)
        sl_mail_send(s->mail, sl_packet_picture(&told, picture->width, picture->height, rgb));
    free(rgb);
}

/* ---- what changes the world ---- */

/* Tells the sides of the newest event. */
static sl_status spread(sl_stage *s, unsigned changes, sl_error *error) {
    sl_status status = SL_OK;
    s->times[s->world.count % SL_TIMES] = sl_seconds_now();
    if (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_KINDS)) sl_stage_forget_tracer(s);
    sl_worker_follow(s->worker, s->world.events[s->world.count - 1]);
    for (int i = 0; i < SL_SIDES && status == SL_OK; i++) status = sl_side_follow(s, i, changes, error);
    return status;
}

static sl_status look(sl_stage *s, const sl_camera *camera, bool told, sl_error *error) {
    unsigned changes;
    sl_status status = sl_world_look(&s->world, camera, &changes, error);
    if (status == SL_OK) status = spread(s, changes, error);
    if (status == SL_OK && told) sl_say(s, 0, sl_describe_camera(s));
    return status;
}

static sl_status take_camera(sl_stage *s, sl_taking *t) {
    sl_camera camera;
    sl_status status = sl_take_camera(t, s->world.scene, &camera);
    return status == SL_OK ? look(s, &camera, s->viewers > 1, t->error) : status;
}

static sl_status go_to(sl_stage *s, double seconds, sl_error *error) {
    unsigned changes;
    sl_status status = sl_world_go_to(&s->world, seconds, &changes, error);
    if (status != SL_OK) return status;
    s->things_move = s->things_move || (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS));
    return spread(s, changes, error);
}

static sl_status take_reset(sl_stage *s, sl_taking *t) {
    s->plays = false;
    sl_status status = s->world.duration > 0.0 ? go_to(s, s->world.first_time, t->error) : SL_OK;
    if (status == SL_OK) status = look(s, &s->world.first_camera, true, t->error);
    s->world.looks = false;
    return status;
}

static sl_status take_time(sl_stage *s, sl_taking *t) {
    const double at = sl_take_number(t, "at", -1e6, 1e6, 0.0);
    sl_status status = sl_take_all(t, sl_is_there(t, "at"), "at", "a number");
    if (status == SL_OK) status = go_to(s, at, t->error);
    s->play_from = at;
    s->play_began = sl_seconds_now();
    return status;
}

static sl_status take_play(sl_stage *s, sl_taking *t) {
    s->plays = sl_take_flag(t, "on", s->plays);
    if (t->status != SL_OK || !s->plays) return t->status;
    s->play_from = s->world.time < s->world.duration ? s->world.time : 0.0;
    s->play_began = sl_seconds_now();
    s->plays = s->world.duration > 0.0;
    return s->plays ? SL_OK : sl_fail(t->error, SL_ERROR_USAGE, "play: nothing moves in this scene");
}

static sl_status edited(sl_stage *s, sl_status status, unsigned changes, sl_error *error) {
    if (status == SL_OK) status = spread(s, changes, error);
    if (status == SL_OK) sl_say(s, 0, sl_describe_scene(s));
    return status;
}

static sl_status take_edit(sl_stage *s, sl_taking *t) {
    sl_item items[SL_ITEMS];
    size_t count;
    unsigned changes = 0;
    sl_status status = sl_take_edits(t, &s->world, items, &count);
    const bool drag = sl_take_flag(t, "drag", false);
    if (status == SL_OK) status = t->status;
    if (status == SL_OK) status = sl_world_edit(&s->world, items, count, drag, &changes, t->error);
    if (drag) return status == SL_OK ? spread(s, changes, t->error) : status;
    return edited(s, status, changes, t->error);
}

/* "undo" or "redo". */
static sl_status take_undo(sl_stage *s, sl_taking *t) {
    const bool again = *sl_take_text(t, "do", "") == 'r';
    unsigned changes = 0;
    return edited(s, sl_world_undo(&s->world, again, &changes, t->error), changes, t->error);
}

/* ---- what is shown of it ---- */

static void want(sl_stage *s) {
    const bool on = s->viewers > 0;
    sl_worker_want(s->worker, on && (s->reference || s->difference), on && s->error, &s->side[0].settings);
}

static sl_status restart(sl_stage *s, int side, sl_error *error) {
    sl_side_stop(s, side);
    return sl_side_start(s, side, error);
}

static sl_status take_size(sl_stage *s, sl_taking *t) {
    const double width = sl_take_number(t, "width", SL_SMALLEST_SIDE, SL_LARGEST_SIDE, 0.0),
                 height = sl_take_number(t, "height", SL_SMALLEST_SIDE, SL_LARGEST_SIDE, 0.0);
    sl_status status = sl_take_all(t, width > 0.0 && height > 0.0, "size", "width and height");
    for (int i = 0; i < SL_SIDES && status == SL_OK; i++) {
        s->side[i].settings.width = (int)width;
        s->side[i].settings.height = (int)height;
        if (s->side[i].wanted) status = restart(s, i, t->error);
    }
    want(s);
    sl_film_end(s, true);
    return status;
}

static sl_status take_setting(sl_settings *settings, const cJSON *item, sl_error *error) {
    static const char *const fixed[] = {"method", "size", "threads", "memory"};
    const char *name = item->string;
    char number[40];
    const sl_setting *row = sl_setting_named(name);
    for (size_t i = 0; i < sizeof fixed / sizeof fixed[0]; i++)
        if (row && strcmp(row->name, fixed[i]) == 0)
            return sl_fail(error, SL_ERROR_USAGE, "%s is not a page's to set", row->name);
    snprintf(number, sizeof number, "%.17g", item->valuedouble);
    if (cJSON_IsBool(item)) snprintf(number, sizeof number, "%d", cJSON_IsTrue(item));
    else if (!cJSON_IsNumber(item) && !cJSON_IsString(item))
        return sl_fail(error, SL_ERROR_INPUT, "settings: expected texts or numbers");
    return sl_settings_set(settings, name, cJSON_IsString(item) ? item->valuestring : number, error);
}

static sl_status take_settings(sl_settings *settings, const sl_taking *t) {
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(t->message, "settings"), *item;
    sl_status status = SL_OK;
    if (list && !cJSON_IsObject(list))
        return sl_fail(t->error, SL_ERROR_INPUT, "settings: expected an object");
    cJSON_ArrayForEach(item, list) if (status == SL_OK) status = take_setting(settings, item, t->error);
    return status;
}

static void tell_method(sl_stage *s, int side) {
    cJSON *m = sl_message_of_side("method", side);
    const sl_side *d = &s->side[side];
    cJSON_AddStringToObject(m, "name", d->wanted ? d->settings.method : "");
    cJSON_AddItemToObject(m, "settings", sl_describe_settings(&d->settings));
    sl_say(s, 0, m);
}

/* The settings begin as the command line has them; those of a method that goes on stay where none are
 * given. */
static sl_status take_method(sl_stage *s, sl_taking *t) {
    const int side = sl_take_side(t);
    const char *name = sl_take_text(t, "name", "");
    sl_status status = t->status;
    sl_side *d = &s->side[side];
    sl_settings settings = s->options.settings;
    settings.width = d->settings.width, settings.height = d->settings.height;
    if (status == SL_OK && !*name && side == 0)
        status = sl_fail(t->error, SL_ERROR_USAGE, "method: side a shows one");
    if (status == SL_OK && *name) status = sl_settings_set(&settings, "method", name, t->error);
    if (status == SL_OK && *name && strcmp(settings.method, "auto") == 0)
        status = sl_fail(t->error, SL_ERROR_USAGE, "method: a page names one");
    if (status == SL_OK) status = take_settings(&settings, t);
    if (status != SL_OK) return status;
    sl_side_stop(s, side);
    d->settings = settings;
    if (*name) status = sl_side_start(s, side, t->error);
    tell_method(s, side);
    return status == SL_ERROR_INPUT ? SL_ERROR_USAGE : status;
}

static sl_status take_tone(sl_stage *s, sl_taking *t) {
    const char *curve = sl_take_text(t, "curve", s->tone.curve == SL_TONE_CLIP ? "clip" : "reinhard");
    const double stops = sl_take_number(t, "exposure", -64, 64, (double)s->tone.exposure_stops);
    const bool automatic = sl_take_flag(t, "auto", false),
               known = strcmp(curve, "clip") == 0 || strcmp(curve, "reinhard") == 0;
    if (sl_take_all(t, known, "curve", "clip or reinhard") != SL_OK) return t->status;
    s->tone = (sl_tone){*curve == 'c' ? SL_TONE_CLIP : SL_TONE_REINHARD, (float)stops, automatic};
    for (int i = 0; i < SL_SIDES; i++) s->side[i].sent_still = false;
    return SL_OK;
}

static sl_status take_passes(sl_stage *s, sl_taking *t) {
    const int side = sl_take_side(t);
    const bool on = sl_take_flag(t, "on", true);
    if (t->status != SL_OK || (!on && !s->side[side].observed)) return t->status;
    if (on && s->side[side].passes) {
        sl_passes_again(s->side[side].passes);
        return SL_OK;
    }
    s->side[side].observed = on;
    return s->side[side].wanted ? restart(s, side, t->error) : SL_OK;
}

static sl_status take_overlay(sl_stage *s, sl_taking *t) {
    const int side = sl_take_side(t);
    const char *kind = sl_take_text(t, "kind", "");
    if (t->status != SL_OK) return t->status;
    if (!s->side[side].passes)
        return sl_fail(t->error, SL_ERROR_USAGE, "overlay: the side's passes are not shown");
    sl_passes_overlay(s->side[side].passes, kind);
    return SL_OK;
}

/* "reference", "difference" or "error". */
static sl_status take_switch(sl_stage *s, sl_taking *t) {
    const char what = *sl_take_text(t, "do", "");
    const bool on = sl_take_flag(t, "on", true);
    if (t->status != SL_OK) return t->status;
    *(what == 'r' ? &s->reference : what == 'd' ? &s->difference : &s->error) = on;
    want(s);
    for (int i = 0; i < SL_SIDES; i++) s->side[i].sent_still = false; /* so that it is looked at */
    return SL_OK;
}

/* ---- messages ---- */

static const struct {
    const char *name;
    sl_status (*take)(sl_stage *stage, sl_taking *t);
} requests[] = {{"camera", take_camera},
                {"reset", take_reset},
                {"time", take_time},
                {"play", take_play},
                {"edit", take_edit},
                {"undo", take_undo},
                {"redo", take_undo},
                {"size", take_size},
                {"method", take_method},
                {"tone", take_tone},
                {"pick", sl_take_pick},
                {"story", sl_take_story},
                {"passes", take_passes},
                {"overlay", take_overlay},
                {"reference", take_switch},
                {"difference", take_switch},
                {"error", take_switch},
                {"exact", sl_take_exact},
                {"keep", sl_take_keep}};

enum { REQUESTS = sizeof requests / sizeof requests[0] };

static cJSON *describe_deed(const sl_stage *s, const char *what) {
    cJSON *m = sl_message("did");
    cJSON_AddStringToObject(m, "do", what);
    cJSON_AddNumberToObject(m, "event", (double)s->world.count);
    return m;
}

static void take_message(sl_stage *s, const cJSON *message) {
    const char *what = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(message, "do"));
    sl_error error = {.message = "this is not known here"};
    sl_status status = SL_ERROR_INPUT;
    sl_taking taking = {message, &error, SL_OK};
    for (int i = 0; i < REQUESTS && what; i++)
        if (strcmp(requests[i].name, what) == 0) status = requests[i].take(s, &taking);
    if (status == SL_ERROR_INPUT && error.status != SL_ERROR_INPUT)
        sl_fail(&error, SL_ERROR_INPUT, "do: nothing of that name");
    if (status == SL_ERROR_INPUT) sl_mail_send(s->mail, sl_packet_end(s->client, error.message));
    else if (status != SL_OK) sl_say(s, s->client, sl_refusal(what, &error));
    else if (strcmp(what, "pick") != 0 && strcmp(what, "story") != 0)
        sl_say(s, s->client, describe_deed(s, what));
}

static void count_viewers(sl_stage *s, int more) {
    s->viewers = (unsigned)((int)s->viewers + more);
    cJSON *m = sl_message("viewers");
    cJSON_AddNumberToObject(m, "count", s->viewers);
    sl_say(s, 0, m);
    want(s);
    for (int i = 0; i < SL_SIDES; i++)
        if (s->side[i].live) sl_live_rest(s->side[i].live, !s->viewers);
}

void sl_stage_take(sl_stage *s, sl_letter letter) {
    if (letter.kind == SL_LETTER_JOINED) {
        count_viewers(s, 1);
        sl_say(s, letter.client, sl_describe_hello(s));
        for (int i = 0; i < SL_SIDES; i++) s->side[i].last.versions = 0, s->side[i].sent_still = false;
    }
    if (letter.kind == SL_LETTER_LEFT) count_viewers(s, -1);
    s->client = letter.client;
    if (letter.kind == SL_LETTER_MESSAGE) take_message(s, letter.message);
    cJSON_Delete(letter.message);
}

/* ---- time ---- */

static void play(sl_stage *s, double now) {
    sl_error error;
    const double at = s->play_from + now - s->play_began, end = s->world.duration;
    if (go_to(s, at < end ? at : end, &error) != SL_OK || at >= end) s->plays = false;
    sl_say(s, 0, sl_describe_camera(s));
}

/* Where keyframes have led things is what a hand takes them from. */
static void tell_motion(sl_stage *s, double now) {
    if (!s->things_move || now - s->motion_told < 0.25) return;
    s->things_move = false;
    s->motion_told = now;
    sl_say(s, 0, sl_describe_scene(s));
}

double sl_stage_step(sl_stage *s) {
    const double now = sl_seconds_now();
    bool busy = s->plays;
    if (!s->viewers) return 1.0;
    if (s->plays && now - s->times[s->world.count % SL_TIMES] > 1.0 / 30.0) play(s, now);
    tell_motion(s, now);
    for (int i = 0; i < SL_SIDES; i++) {
        const sl_side *d = &s->side[i];
        sl_side_step(s, i, now);
        busy = busy || (d->live && !(d->last.done && d->sent_still && d->shown == s->world.count));
    }
    sl_work_step(s);
    return busy ? 0.002 : 0.05;
}

void sl_stage_run(sl_stage *s) {
    sl_letter letter;
    double pause = 0.0;
    while (!sl_mail_has_ended(s->mail)) {
        while (sl_mail_read(s->mail, pause, &letter)) {
            sl_stage_take(s, letter);
            pause = 0.0;
        }
        pause = sl_stage_step(s);
        if (sl_interrupted()) sl_mail_end(s->mail);
    }
}

/* ---- life ---- */

sl_status sl_stage_open(const sl_stage_options *options, sl_mail *mail, sl_stage **stage, sl_error *error) {
    *stage = NULL;
    sl_stage *s = calloc(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the stage");
    s->options = *options;
    s->mail = mail;
    s->tone = (sl_tone){SL_TONE_REINHARD, 0.0f, true};
    for (int i = 0; i < SL_SIDES; i++) s->side[i].settings = options->settings;
    sl_status status =
        sl_world_open(&s->world, options->scene_path, options->reading, options->at_seconds, error);
    if (status == SL_OK) status = sl_worker_start(&s->world, &s->worker, error);
    if (status == SL_OK) status = sl_side_start(s, 0, error);
    if (status == SL_OK) *stage = s;
    else sl_stage_close(s);
    return status;
}

void sl_stage_close(sl_stage *s) {
    if (!s) return;
    for (int i = 0; i < SL_SIDES; i++) sl_side_close(s, i);
    sl_film_end(s, false);
    sl_worker_stop(s->worker);
    sl_stage_forget_tracer(s);
    sl_world_close(&s->world);
    free(s);
}
