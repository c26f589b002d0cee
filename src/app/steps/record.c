#include "app/steps/record.h"

#include "app/page.h"
#include "image/color.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the text ---- */

/* The ways in which a pass's buffer becomes a picture: the words of "show", in their order. */
typedef enum show_as {
    SHOW_LIGHT,     /* radiance or irradiance, tone-mapped */
    SHOW_COLOUR,    /* reflectances, as they are */
    SHOW_SCALAR,    /* from dark to bright between the least and the greatest value */
    SHOW_NORMALS,   /* (n + 1) / 2 */
    SHOW_POSITIONS, /* scaled into the box of what is seen */
    SHOW_IDS        /* distinct colours */
} show_as;

/* narratives.json, as the linker has put it in. */
extern const char _binary_src_app_steps_narratives_json_start[], _binary_src_app_steps_narratives_json_end[];

static const char *text_of(const cJSON *object, const char *name) {
    return cJSON_GetStringValue(cJSON_GetObjectItem(object, name));
}

cJSON *sl_narrative_of(const char *method) {
    const char *begin = _binary_src_app_steps_narratives_json_start;
    cJSON *all = cJSON_ParseWithLength(begin, (size_t)(_binary_src_app_steps_narratives_json_end - begin));
    cJSON *narrative = all ? all->child : NULL;
    while (narrative && strcmp(text_of(narrative, "method"), method) != 0) narrative = narrative->next;
    if (narrative) cJSON_DetachItemViaPointer(all, narrative);
    cJSON_Delete(all);
    return narrative;
}

/* A pass has the entry that the longest beginning of its name has. */
static const cJSON *find_entry(const cJSON *narrative, const char *pass, size_t *place) {
    const cJSON *best = NULL, *entry;
    size_t longest = 0, i = 0;
    cJSON_ArrayForEach(entry, cJSON_GetObjectItem(narrative, "passes")) {
        size_t length = strlen(text_of(entry, "pass"));
        if (strncmp(text_of(entry, "pass"), pass, length) == 0 && length > longest)
            best = entry, longest = length, *place = i;
        i++;
    }
    return best;
}

static show_as way_told(const cJSON *pass) {
    static const char *const words[] = {"light", "colour", "scalar", "normals", "positions", "ids"};
    int show = SHOW_LIGHT;
    while (show < SHOW_IDS && strcmp(words[show], text_of(pass, "show")) != 0) show++;
    return (show_as)show;
}

/* ---- a buffer as a picture ---- */

/* Linear light that a PNG stores as this displayed level. */
static float displayed(float level) { return sl_srgb_decode(fminf(fmaxf(level, 0.0f), 1.0f)); }

static void range_of(const float *plane, size_t count, float *least, float *greatest) {
    *least = INFINITY, *greatest = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(plane[i])) continue;
        *least = fminf(*least, plane[i]);
        *greatest = fmaxf(*greatest, plane[i]);
    }
}

/* Values between the extremes as brightness; one value everywhere as grey, what is not finite as black. */
static void show_scalar(const float *in, size_t count, float *out) {
    float least, greatest;
    range_of(in, count, &least, &greatest);
    float width = greatest - least;
    for (size_t i = 0; i < count; i++) {
        float level = width > 0.0f ? (in[i] - least) / width : 0.5f;
        out[i] = isfinite(in[i]) ? displayed(level) : 0.0f;
    }
}

static void show_normals(const float *in, size_t count, float *out) {
    for (size_t i = 0; i < count; i++) out[i] = isfinite(in[i]) ? displayed(0.5f + 0.5f * in[i]) : 0.0f;
}

/* A colour for a number, far from those of its neighbours; nothing (0xffffffff or negative) is black. */
static void show_ids(const float *in, size_t count, float *const out[3]) {
    for (size_t i = 0; i < count; i++) {
        bool something = isfinite(in[i]) && in[i] >= 0.0f && in[i] < 4.0e9f;
        uint32_t h = something ? (uint32_t)in[i] * 2654435761u : 0;
        h ^= h >> 15;
        h *= 2246822519u;
        for (int c = 0; c < 3; c++)
            out[c][i] = something ? displayed(0.2f + 0.75f * (float)((h >> (8 * c)) & 255u) / 255.0f) : 0.0f;
    }
}

/* Makes R, G, B in the order of the buffer, ready for a PNG without tone mapping; light excepted, which is to
 * be tone-mapped. */
static sl_status show_buffer(const sl_image *buffer, show_as show, sl_image **picture, sl_error *error) {
    sl_status status = sl_image_create(buffer->width, buffer->height, 3, NULL, picture, error);
    if (status != SL_OK) return status;
    size_t count = (size_t)buffer->width * (size_t)buffer->height;
    float *out[3];
    for (size_t c = 0; c < 3; c++) {
        const float *in = buffer->planes + (buffer->channels >= 3 ? c : 0) * count;
        out[c] = (*picture)->planes + c * count;
        if (show == SHOW_SCALAR || show == SHOW_POSITIONS) show_scalar(in, count, out[c]);
        else if (show == SHOW_NORMALS) show_normals(in, count, out[c]);
        else memcpy(out[c], in, count * sizeof *in);
    }
    if (show == SHOW_IDS) show_ids(buffer->planes, count, out);
    return SL_OK;
}

enum { MARKS_SHOWN = 700 };

static sl_step *find_step(sl_recording *r, const sl_pass *pass) {
    for (size_t i = 0; i < r->count; i++)
        if (strcmp(r->steps[i].name, pass->name) == 0) return &r->steps[i];
    if (r->count == SL_STEPS_MAX) return NULL;
    sl_step *step = &r->steps[r->count++];
    *step = (sl_step){.place = SL_STEPS_MAX, .frames = cJSON_CreateArray()};
    snprintf(step->name, sizeof step->name, "%s", pass->name);
    snprintf(step->source, sizeof step->source, "%s", pass->source);
    step->told = find_entry(r->narrative, pass->name, &step->place);
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

/* Light where nothing else is known of three channels, brightness of one. */
static show_as way_to_show(const sl_step *step) {
    if (step->told) return way_told(step->told);
    return step->latest->channels >= 3 ? SHOW_LIGHT : SHOW_SCALAR;
}

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
    show_as show = way_to_show(step);
    if (show_buffer(step->latest, show, &picture, NULL) == SL_OK)
        text = sl_picture_text(picture, show == SHOW_LIGHT);
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
