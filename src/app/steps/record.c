#include "app/steps/record.h"

#include "app/page.h"
#include "base/counters.h"

#include <stdlib.h>
#include <string.h>

enum { MARKS_SHOWN = 700 };

void sl_recording_interrupt(sl_recording *r, const sl_counters *counters) {
    r->later = r->next;
    r->next = r->told;
    sl_counters_subtract(&r->next, counters);
}

/* Keeps a pass with what it cost itself. */
static void on_pass(void *context, const sl_pass *pass) {
    sl_recording *r = context;
    sl_pass own = *pass;
    sl_counters cost = *pass->counters;
    sl_counters_add(&r->told, &cost);
    sl_counters_add(&cost, &r->next);
    sl_counters_subtract(&r->later, &r->next);
    r->next = (sl_counters){{0}};
    own.counters = &cost;
    sl_watched_keep(&r->watched, &own);
}

sl_observer sl_recording_observer(sl_recording *recording) { return (sl_observer){recording, on_pass}; }

/* Takes the latest picture, as PNG in base 64; NULL: no memory. */
static char *take_picture(sl_watched_pass *p) {
    sl_image *picture = NULL;
    char *text = NULL;
    bool tone;
    if (sl_pass_picture(p->latest, p->told, &picture, &tone, NULL) == SL_OK)
        text = sl_picture_text(picture, tone);
    sl_image_destroy(picture);
    sl_image_destroy(p->latest);
    p->latest = NULL;
    return text;
}

static char *take_marks(sl_watched_pass *p, const sl_mark_view *view) {
    const sl_marks marks = {view, p->marks, p->mark_count, MARKS_SHOWN};
    p->mark_count = 0;
    return sl_printed(sl_marks_put, &marks);
}

/* Adds a text that is due, or null. */
static void add_text(sl_recording *r, cJSON *frame, bool due, char *text) {
    cJSON_AddItemToArray(frame, text ? cJSON_CreateString(text) : cJSON_CreateNull());
    r->watched.failed = r->watched.failed || (due && !text);
    free(text);
}

static void add_frame(sl_recording *r, cJSON *frames, sl_watched_pass *p) {
    cJSON *frame = cJSON_CreateArray();
    const bool picture = p->latest != NULL, marks = p->mark_count > 0;
    add_text(r, frame, picture, picture ? take_picture(p) : NULL);
    add_text(r, frame, marks, marks ? take_marks(p, &r->view) : NULL);
    cJSON_AddItemToArray(frames, frame);
}

void sl_recording_snapshot(sl_recording *r) {
    sl_watched_pass nothing = {.latest = NULL};
    r->next = r->later;
    for (size_t i = 0; i < r->watched.count; i++) {
        if (!r->frames[i]) r->frames[i] = cJSON_CreateArray();
        for (int late = cJSON_GetArraySize(r->frames[i]); late < r->snapshots; late++)
            add_frame(r, r->frames[i], &nothing);
        add_frame(r, r->frames[i], &r->watched.pass[i]);
    }
    r->snapshots++;
}

static int by_place(const void *a, const void *b) {
    const sl_watched_pass *x = *(const sl_watched_pass *const *)a, *y = *(const sl_watched_pass *const *)b;
    if (x->place != y->place) return x->place < y->place ? -1 : 1;
    return strcmp(x->name, y->name);
}

/* Takes the frames. */
static cJSON *json_of(const sl_watched_pass *p, cJSON **frames) {
    cJSON *json = cJSON_CreateObject();
    sl_json_add_counters(json, "cost", &p->cost, false);
    cJSON_AddStringToObject(json, "name", p->name);
    cJSON_AddStringToObject(json, "source", p->source);
    cJSON_AddNumberToObject(json, "times", (double)p->times);
    cJSON_AddNumberToObject(json, "width", p->width);
    cJSON_AddNumberToObject(json, "height", p->height);
    if (p->told) cJSON_AddItemToObject(json, "told", cJSON_Duplicate(p->told, true));
    cJSON_AddItemToObject(json, "frames", *frames ? *frames : cJSON_CreateArray());
    *frames = NULL;
    return json;
}

cJSON *sl_recording_json(sl_recording *r) {
    const sl_watched_pass *first = r->watched.pass, *pass[SL_WATCHED_MAX];
    cJSON *steps = cJSON_CreateArray();
    for (size_t i = 0; i < r->watched.count; i++) pass[i] = first + i;
    qsort(pass, r->watched.count, sizeof pass[0], by_place);
    for (size_t i = 0; i < r->watched.count; i++)
        cJSON_AddItemToArray(steps, json_of(pass[i], &r->frames[pass[i] - first]));
    return steps;
}

void sl_recording_clear(sl_recording *r) {
    for (size_t i = 0; i < SL_WATCHED_MAX; i++) cJSON_Delete(r->frames[i]);
    sl_watched_clear(&r->watched);
}
