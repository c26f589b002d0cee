#include "app/steps/record.h"

#include "app/page.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MARKS_SHOWN = 700 };

static sl_step *find_step(sl_recording *r, const sl_pass *pass) {
    for (size_t i = 0; i < r->count; i++)
        if (strcmp(r->steps[i].name, pass->name) == 0) return &r->steps[i];
    if (r->count == SL_STEPS_MAX) return NULL;
    sl_step *step = &r->steps[r->count++];
    *step = (sl_step){.place = SL_STEPS_MAX, .frames = cJSON_CreateArray()};
    snprintf(step->name, sizeof step->name, "%s", pass->name);
    snprintf(step->source, sizeof step->source, "%s", pass->source);
    step->told = sl_narrative_pass(r->narrative, pass->name, &step->place);
    return step;
}

static sl_image *copy_of(const sl_image *image) {
    sl_image *copy = NULL;
    if (sl_image_create(image->width, image->height, image->channels, NULL, &copy, NULL) != SL_OK)
        return NULL;
    memcpy(copy->planes, image->planes,
           (size_t)image->width * (size_t)image->height * (size_t)image->channels * sizeof(float));
    return copy;
}

void sl_recording_interrupt(sl_recording *r, const sl_counters *counters) {
    r->resolving = true;
    for (int i = 0; i < SL_COUNTERS; i++) r->early.value[i] = counters->value[i] - r->told.value[i];
}

/* To each what it cost itself. */
static void add_cost(sl_recording *r, sl_step *step, const sl_counters *cost) {
    for (int i = 0; i < SL_COUNTERS; i++) {
        uint64_t own = cost->value[i];
        r->told.value[i] += own;
        if (r->early.value[i]) {
            own -= r->early.value[i];
            r->owed.value[i] += r->early.value[i];
            r->early.value[i] = 0;
        } else if (!r->resolving) {
            own += r->owed.value[i];
            r->owed.value[i] = 0;
        }
        step->cost.value[i] += own;
    }
}

static void on_pass(void *context, const sl_pass *pass) {
    sl_recording *r = context;
    sl_step *step = find_step(r, pass);
    if (!step) {
        r->failed = true;
        return;
    }
    step->times++;
    add_cost(r, step, pass->counters);
    if (pass->buffer) {
        sl_image_destroy(step->latest);
        step->latest = copy_of(pass->buffer);
        step->width = pass->buffer->width, step->height = pass->buffer->height;
        r->failed = r->failed || !step->latest;
    }
    if (pass->mark_count) {
        const sl_marks marks = {&r->view, pass->marks, pass->mark_count, MARKS_SHOWN};
        free(step->latest_marks);
        step->latest_marks = sl_printed(sl_marks_put, &marks);
        r->failed = r->failed || !step->latest_marks;
    }
}

sl_observer sl_recording_observer(sl_recording *recording) { return (sl_observer){recording, on_pass}; }

static cJSON *text_or_null(char *text) {
    cJSON *item = text ? cJSON_CreateString(text) : cJSON_CreateNull();
    free(text);
    return item;
}

/* Takes the latest picture, as PNG in base 64; NULL: there is none, or no memory. */
static char *take_picture(sl_step *step) {
    sl_image *picture = NULL;
    char *text = NULL;
    if (!step->latest) return NULL;
    bool tone;
    if (sl_pass_picture(step->latest, step->told, &picture, &tone, NULL) == SL_OK)
        text = sl_picture_text(picture, tone);
    sl_image_destroy(picture);
    sl_image_destroy(step->latest);
    step->latest = NULL;
    return text;
}

static cJSON *frame_of(cJSON *picture, cJSON *marks) {
    cJSON *frame = cJSON_CreateArray();
    cJSON_AddItemToArray(frame, picture);
    cJSON_AddItemToArray(frame, marks);
    return frame;
}

void sl_recording_snapshot(sl_recording *r) {
    r->resolving = false;
    r->early = (sl_counters){{0}};
    for (size_t i = 0; i < r->count; i++) {
        sl_step *step = &r->steps[i];
        while (cJSON_GetArraySize(step->frames) < r->snapshots) /* it comes late */
            cJSON_AddItemToArray(step->frames, frame_of(cJSON_CreateNull(), cJSON_CreateNull()));
        bool due = step->latest != NULL;
        char *picture = take_picture(step);
        r->failed = r->failed || (due && !picture);
        cJSON_AddItemToArray(step->frames, frame_of(text_or_null(picture), text_or_null(step->latest_marks)));
        step->latest_marks = NULL;
    }
    r->snapshots++;
}

static int by_place(const void *a, const void *b) {
    const sl_step *x = a, *y = b;
    if (x->place != y->place) return x->place < y->place ? -1 : 1;
    return strcmp(x->name, y->name);
}

static cJSON *json_of(sl_step *step) {
    cJSON *json = cJSON_CreateObject();
    sl_json_add_counters(json, "cost", &step->cost, false);
    cJSON_AddStringToObject(json, "name", step->name);
    cJSON_AddStringToObject(json, "source", step->source);
    cJSON_AddNumberToObject(json, "times", (double)step->times);
    cJSON_AddNumberToObject(json, "width", step->width);
    cJSON_AddNumberToObject(json, "height", step->height);
    if (step->told) cJSON_AddItemToObject(json, "told", cJSON_Duplicate(step->told, true));
    cJSON_AddItemToObject(json, "frames", step->frames);
    step->frames = NULL;
    return json;
}

cJSON *sl_recording_json(sl_recording *r) {
    cJSON *steps = cJSON_CreateArray();
    qsort(r->steps, r->count, sizeof r->steps[0], by_place);
    for (size_t i = 0; i < r->count; i++) cJSON_AddItemToArray(steps, json_of(&r->steps[i]));
    return steps;
}

void sl_recording_clear(sl_recording *r) {
    for (size_t i = 0; i < r->count; i++) {
        sl_image_destroy(r->steps[i].latest);
        free(r->steps[i].latest_marks);
        cJSON_Delete(r->steps[i].frames);
    }
    r->count = 0;
}
