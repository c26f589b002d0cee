/* The passes of a side whose method is observed: the newest picture of each, what they cost, and their
 * marks. The updating thread leaves them, the stage's sends them on. */
#include "app/serve/passes.h"

#include "app/clock.h"
#include "app/page.h"
#include "app/steps/narrative.h"
#include "base/thread.h"
#include "cache/frame/method.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PASSES = 62, MARKS = 4000, SHOWN = 700, EDGES_SHOWN = 2500 };
static const double pause = 0.5;

typedef struct one_pass {
    char name[96], source[160];
    uint64_t times, told; /* announced; when it was told of last */
    sl_counters cost;     /* of all of them */
    sl_image *latest;     /* or NULL */
    bool pending;         /* it was not shown yet */
    int width, height;
    sl_mark *marks; /* the newest, MARKS at most */
    size_t mark_count, all_marks;
} one_pass;

struct sl_passes {
    sl_observer observer;
    sl_monitor meeting; /* guards the passes */
    one_pass pass[PASSES];
    size_t count;
    cJSON *narrative;
    char overlay[100]; /* the pass whose marks are shown; "": none */
    uint64_t overlay_told;
    double last; /* time */
    uint64_t resolved; /* updates that were done by then */
};

/* ---- the updating thread ---- */

static one_pass *find(sl_passes *p, const sl_pass *told) {
    for (size_t i = 0; i < p->count; i++)
        if (strcmp(p->pass[i].name, told->name) == 0) return &p->pass[i];
    if (p->count == PASSES) return NULL;
    one_pass *made = &p->pass[p->count++];
    snprintf(made->name, sizeof made->name, "%s", told->name);
    snprintf(made->source, sizeof made->source, "%s", told->source);
    return made;
}

/* Evenly chosen of all of them. */
static void keep_marks(one_pass *o, const sl_pass *told) {
    const size_t count = told->mark_count < MARKS ? told->mark_count : MARKS;
    if (!o->marks) o->marks = malloc(MARKS * sizeof *o->marks);
    o->mark_count = o->marks ? count : 0;
    o->all_marks = told->mark_count;
    for (size_t i = 0; i < o->mark_count; i++) o->marks[i] = told->marks[i * told->mark_count / count];
}

static void keep_picture(one_pass *o, const sl_image *buffer) {
    const size_t values = (size_t)buffer->width * (size_t)buffer->height * (size_t)buffer->channels;
    sl_image_destroy(o->latest);
    o->latest = NULL;
    o->pending = true;
    o->width = buffer->width, o->height = buffer->height;
    if (sl_image_create(buffer->width, buffer->height, buffer->channels, NULL, &o->latest, NULL) == SL_OK)
        memcpy(o->latest->planes, buffer->planes, values * sizeof(float));
}

static void on_pass(void *context, const sl_pass *told) {
    sl_passes *p = context;
    sl_monitor_enter(&p->meeting);
    one_pass *o = find(p, told);
    if (o) {
        o->times++;
        for (int i = 0; i < SL_COUNTERS; i++) o->cost.value[i] += told->counters->value[i];
        if (told->buffer) keep_picture(o, told->buffer);
        if (told->mark_count) keep_marks(o, told);
    }
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
    p->narrative = sl_narrative_of(method);
    return p;
}

void sl_passes_destroy(sl_passes *p) {
    if (!p) return;
    for (size_t i = 0; i < p->count; i++) {
        sl_image_destroy(p->pass[i].latest);
        free(p->pass[i].marks);
    }
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
    size_t place = PASSES;
    const one_pass *o = &p->pass[i];
    const cJSON *told = sl_narrative_pass(p->narrative, o->name, &place);
    cJSON *m = sl_message("pass");
    cJSON_AddStringToObject(m, "side", sl_side_name(side));
    cJSON_AddNumberToObject(m, "index", (double)i);
    cJSON_AddNumberToObject(m, "place", (double)place);
    cJSON_AddStringToObject(m, "name", o->name);
    cJSON_AddStringToObject(m, "source", o->source);
    cJSON_AddNumberToObject(m, "times", (double)o->times);
    cJSON_AddNumberToObject(m, "width", o->width);
    cJSON_AddNumberToObject(m, "height", o->height);
    cJSON_AddNumberToObject(m, "marks", (double)o->all_marks);
    sl_json_add_counters(m, "counters", &o->cost, false);
    sl_add_told(m, told);
    sl_say(s, 0, m);
}

static void show(sl_stage *s, const sl_passes *p, int side, size_t i, const sl_image *buffer) {
    size_t place;
    sl_image *picture = NULL;
    bool toned;
    const cJSON *told = sl_narrative_pass(p->narrative, p->pass[i].name, &place);
    sl_tone plain = {SL_TONE_CLIP, 0.0f, false};
    if (sl_pass_picture(buffer, told, &picture, &toned, NULL) == SL_OK)
        sl_show(s, SL_FRAME_PASS, (unsigned)(i + 64 * (size_t)side), picture, toned ? &s->tone : &plain,
                s->side[side].shown, s->side[side].last.done);
    sl_image_destroy(picture);
}

/* One pass, whose picture is taken out so that the updates need not wait while it is encoded. */
static void step_pass(sl_stage *s, sl_passes *p, int side, size_t i) {
    one_pass *o = &p->pass[i];
    sl_monitor_enter(&p->meeting);
    sl_image *latest = o->pending ? o->latest : NULL;
    const bool news = o->times != o->told;
    if (latest) o->latest = NULL;
    o->pending = false;
    o->told = o->times;
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
    for (size_t i = 0; i < p->count; i++) {
        p->pass[i].told = 0;
        p->pass[i].pending = p->pass[i].latest != NULL;
    }
    p->overlay_told = 0;
    sl_monitor_leave(&p->meeting);
}

static void tell_overlay(sl_stage *s, sl_passes *p, int side, const one_pass *o) {
    const sl_mark_view view = sl_stage_view(s);
    const size_t most = o->marks->kind == SL_MARK_SEGMENT ? EDGES_SHOWN : SHOWN;
    const sl_marks marks = {&view, o->marks, o->mark_count, most};
    char *svg = sl_printed(sl_marks_put, &marks);
    cJSON *m = sl_message("overlay");
    cJSON_AddStringToObject(m, "side", sl_side_name(side));
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
    const sl_tracer *tracer;
    if (!*p->overlay || sl_stage_tracer(s, &tracer, NULL) != SL_OK) return;
    sl_monitor_enter(&p->meeting);
    const one_pass *o = p->pass, *end = p->pass + p->count;
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
    const size_t count = p->count;
    sl_monitor_leave(&p->meeting);
    for (size_t i = 0; i < count; i++) step_pass(s, p, side, i);
    step_overlay(s, p, side);
}
