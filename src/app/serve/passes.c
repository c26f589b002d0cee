/* The passes of a side whose method is observed: the newest picture of each, what they cost, and their
 * marks. The updating thread leaves them, the stage's sends them on. */
#include "app/serve/stage_parts.h"

#include "app/clock.h"
#include "app/page.h"
#include "app/steps/watched.h"
#include "base/thread.h"
#include "cache/frame/method.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SHOWN = 700, EDGES_SHOWN = 2500 };
static const double pause = 0.5;

struct sl_passes {
    sl_observer observer;
    sl_monitor meeting; /* guards the passes */
    sl_watched watched;
    struct {
        uint64_t times, pictures;
    } told[SL_WATCHED_MAX]; /* of each pass as many as it had when it was told of last */
    cJSON *narrative;
    char overlay[100]; /* the pass whose marks are shown; "": none */
    uint64_t overlay_told;
    double last; /* time */
    uint64_t resolved; /* updates that were done by then */
};

/* ---- the updating thread ---- */

static void on_pass(void *context, const sl_pass *told) {
    sl_passes *p = context;
    sl_monitor_enter(&p->meeting);
    sl_watched_keep(&p->watched, told);
    sl_monitor_leave(&p->meeting);
}

/* ---- life ---- */

sl_passes *sl_passes_create(const char *method) {
    sl_passes *p = calloc(1, sizeof *p);
    if (p && !sl_monitor_open(&p->meeting)) {
        free(p);
        return NULL;
    }
    if (!p) return NULL;
    p->observer = (sl_observer){p, on_pass};
    p->watched.narrative = p->narrative = sl_narrative_of(method);
    return p;
}

void sl_passes_destroy(sl_passes *p) {
    if (!p) return;
    sl_watched_clear(&p->watched);
    cJSON_Delete(p->narrative);
    sl_monitor_close(&p->meeting);
    free(p);
}

const sl_observer *sl_passes_observer(const sl_passes *passes) { return &passes->observer; }

void sl_passes_overlay(sl_passes *p, const char *kind) {
    snprintf(p->overlay, sizeof p->overlay, "%s", kind);
    p->overlay_told = 0;
}

/* ---- the stage ---- */

static void tell(sl_stage *s, sl_passes *p, int side, size_t i) {
    const sl_watched_pass *o = &p->watched.pass[i];
    cJSON *m = sl_message_of_side("pass", side);
    cJSON_AddNumberToObject(m, "index", (double)i);
    cJSON_AddNumberToObject(m, "place", (double)o->place);
    cJSON_AddStringToObject(m, "name", o->name);
    cJSON_AddStringToObject(m, "source", o->source);
    cJSON_AddNumberToObject(m, "times", (double)o->times);
    cJSON_AddNumberToObject(m, "width", o->width);
    cJSON_AddNumberToObject(m, "height", o->height);
    cJSON_AddNumberToObject(m, "marks", (double)o->all_marks);
    sl_json_add_counters(m, "counters", &o->cost, false);
    sl_add_told(m, o->told);
    sl_say(s, 0, m);
}

static void show(sl_stage *s, const sl_passes *p, int side, size_t i, const sl_image *buffer) {
    sl_image *picture = NULL;
    bool toned;
    sl_tone plain = {SL_TONE_CLIP, 0.0f, false};
    if (sl_pass_picture(buffer, p->watched.pass[i].told, &picture, &toned, NULL) == SL_OK)
        sl_show(s, SL_FRAME_PASS, (unsigned)(i + 64 * (size_t)side), picture, toned ? &s->tone : &plain,
                s->side[side].shown, s->side[side].last.done);
    sl_image_destroy(picture);
}

/* One pass, whose picture is taken out so that the updates need not wait while it is encoded. */
static void step_pass(sl_stage *s, sl_passes *p, int side, size_t i) {
    sl_watched_pass *o = &p->watched.pass[i];
    sl_monitor_enter(&p->meeting);
    sl_image *latest = o->pictures != p->told[i].pictures ? o->latest : NULL;
    const bool news = o->times != p->told[i].times;
    if (latest) o->latest = NULL;
    p->told[i].pictures = o->pictures;
    p->told[i].times = o->times;
    if (news) tell(s, p, side, i);
    sl_monitor_leave(&p->meeting);
    if (!latest) return;
    show(s, p, side, i, latest);
    sl_monitor_enter(&p->meeting);
    if (!o->latest) o->latest = latest, latest = NULL; /* for those who ask later */
    sl_monitor_leave(&p->meeting);
    sl_image_destroy(latest);
}

void sl_passes_again(sl_passes *p) {
    sl_monitor_enter(&p->meeting);
    memset(p->told, 0, sizeof p->told);
    p->overlay_told = 0;
    sl_monitor_leave(&p->meeting);
}

static void tell_overlay(sl_stage *s, sl_passes *p, int side, const sl_watched_pass *o) {
    const sl_mark_view view = sl_stage_view(s);
    const size_t most = o->marks->kind == SL_MARK_SEGMENT ? EDGES_SHOWN : SHOWN;
    const sl_marks marks = {&view, o->marks, o->mark_count, most};
    char *svg = sl_printed(sl_marks_put, &marks);
    cJSON *m = sl_message_of_side("overlay", side);
    cJSON_AddStringToObject(m, "kind", p->overlay);
    cJSON_AddStringToObject(m, "pass", o->name);
    cJSON_AddNumberToObject(m, "width", view.width);
    cJSON_AddNumberToObject(m, "height", view.height);
    cJSON_AddStringToObject(m, "svg", svg ? svg : "");
    sl_say(s, 0, m);
    free(svg);
}

/* The first pass of that name that has marks; marks are where the camera sees them now. */
static void step_overlay(sl_stage *s, sl_passes *p, int side) {
    if (!*p->overlay || sl_stage_needs_tracer(s, NULL) != SL_OK) return;
    sl_monitor_enter(&p->meeting);
    const sl_watched_pass *o = p->watched.pass, *end = o + p->watched.count;
    while (o < end && !(o->mark_count && strstr(o->name, p->overlay))) o++;
    const uint64_t now = o < end ? o->times + 1000003u * s->world.count : 0;
    if (o < end && now != p->overlay_told) tell_overlay(s, p, side, o);
    p->overlay_told = now;
    sl_monitor_leave(&p->meeting);
}

/* A method with a display is not resolved to be shown, but its last passes are those that this takes:
 * pictures of parts, edges of meshes. */
static void resolve(void *context, sl_method *method) {
    sl_image *unused = NULL;
    (void)context;
    if (method && method->class->window) sl_method_resolve(method, &unused, NULL);
    sl_image_destroy(unused);
}

void sl_passes_step(sl_stage *s, sl_passes *p, int side, double now) {
    const sl_side *d = &s->side[side];
    if (now - p->last < pause) return;
    p->last = now;
    if (d->last.updates != p->resolved && sl_live_visit(d->live, resolve, NULL))
        p->resolved = d->last.updates;
    sl_monitor_enter(&p->meeting);
    const size_t count = p->watched.count;
    sl_monitor_leave(&p->meeting);
    for (size_t i = 0; i < count; i++) step_pass(s, p, side, i);
    step_overlay(s, p, side);
}
