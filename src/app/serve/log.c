/* What has happened, and how far each show had come when it followed: enough to have its picture again, to
 * the bit. */
#include "app/serve/stage_parts.h"

#include "app/page.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/thread.h"
#include "image/formats.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- items ---- */

/* A part of an item: of which kinds, by which name, and where it is. */
typedef struct field {
    unsigned kinds; /* bits */
    const char *name;
    enum { FLAG, FLOATS, DOUBLES } as;
    size_t count, at, has; /* has: where a flag says that it is there; 0: always */
} field;

#define IN(member) offsetof(sl_item, to.member)
#define OF(kind) (1u << SL_ITEM_##kind)
static const field fields[] = {
    {OF(CAMERA), "camera", FLOATS, sizeof(sl_camera) / sizeof(float), IN(camera), 0},
    {OF(TIME), "seconds", DOUBLES, 1, IN(time.seconds), 0},
    {OF(TIME), "keeps_camera", FLAG, 1, IN(time.keeps_camera), 0},
    {OF(OBJECT), "columns", DOUBLES, 16, IN(columns), 0},
    {OF(MATERIAL), "diffuse", FLOATS, 3, IN(material.diffuse), 0},
    {OF(MATERIAL), "specular", FLOATS, 3, IN(material.specular), 0},
    {OF(MATERIAL), "mirror", FLOATS, 3, IN(material.mirror), 0},
    {OF(MATERIAL), "emission", FLOATS, 3, IN(material.emission), 0},
    {OF(MATERIAL), "exponent", FLOATS, 1, IN(material.exponent), 0},
    {OF(LIGHT) | OF(ADD_LIGHT), "power", FLOATS, 3, IN(light.strength), IN(light.has_strength)},
    {OF(LIGHT) | OF(ADD_LIGHT), "position", DOUBLES, 3, IN(light.position), IN(light.has_position)},
    {OF(LIGHT) | OF(ADD_LIGHT), "direction", DOUBLES, 3, IN(light.direction), IN(light.has_direction)},
    {OF(SKY), "stops", DOUBLES, 1, IN(stops), 0}};
#undef IN
#undef OF
enum { FIELDS = sizeof fields / sizeof fields[0], MOST_VALUES = 16 };

static void add_field(cJSON *o, const field *f, const sl_item *item) {
    const char *at = (const char *)item + f->at;
    double values[MOST_VALUES];
    if (f->has && !*((const bool *)item + f->has)) return;
    if (f->as == FLAG) {
        cJSON_AddBoolToObject(o, f->name, *(const bool *)at);
        return;
    }
    for (size_t i = 0; i < f->count; i++)
        values[i] = f->as == FLOATS ? (double)((const float *)(const void *)at)[i]
                                    : ((const double *)(const void *)at)[i];
    if (f->count == 1) cJSON_AddNumberToObject(o, f->name, values[0]);
    else sl_add_numbers(o, f->name, values, (int)f->count);
}

static cJSON *json_of_item(const sl_item *item) {
    cJSON *o = cJSON_CreateObject();
    cJSON_AddNumberToObject(o, "kind", item->kind);
    cJSON_AddNumberToObject(o, "number", item->number);
    for (int i = 0; i < FIELDS; i++)
        if (fields[i].kinds >> item->kind & 1u) add_field(o, &fields[i], item);
    return o;
}

static cJSON *json_of_event(const sl_event *e) {
    cJSON *o = cJSON_CreateObject(), *items = cJSON_AddArrayToObject(o, "items");
    cJSON_AddNumberToObject(o, "number", (double)e->number);
    for (size_t i = 0; i < e->count; i++) cJSON_AddItemToArray(items, json_of_item(&e->items[i]));
    return o;
}

/* ---- writing ---- */

/* Rates that the method was told of before so many updates: after how many, and which. */
static cJSON *json_of_rates(sl_live *live, uint64_t updates) {
    const size_t count = sl_live_log(live, NULL, 0);
    sl_live_event *events = malloc((count + 1) * sizeof *events);
    cJSON *rates = cJSON_CreateArray();
    if (events) sl_live_log(live, events, count);
    for (size_t i = 0; events && i < count; i++) {
        const double numbers[2] = {(double)events[i].updates, events[i].value};
        if (events[i].rate && events[i].updates < updates)
            cJSON_AddItemToArray(rates, cJSON_CreateDoubleArray(numbers, 2));
    }
    free(events);
    return rates;
}

typedef struct visited {
    sl_monitor meeting;
    bool done;
    sl_live *live;
    sl_image *picture;
    sl_live_turn *turns;
    size_t count;
    uint64_t updates;
    sl_status status;
    sl_error error;
} visited;

static void visit(void *context, sl_method *method) {
    visited *w = context;
    sl_monitor_enter(&w->meeting);
    w->status = method ? sl_method_resolve(method, &w->picture, &w->error) : SL_ERROR_RESOURCES;
    const size_t count = sl_live_turns(w->live, NULL, 0, NULL);
    w->turns = malloc((count + 1) * sizeof *w->turns);
    if (w->turns) w->count = sl_live_turns(w->live, w->turns, count, &w->updates);
    w->done = true;
    sl_monitor_signal(&w->meeting);
    sl_monitor_leave(&w->meeting);
}

/* Waits for the update under way, and goes on to draw, for which an update may be waiting. */
static void await_visit(visited *w) {
    const sl_image *ignored;
    for (bool done = false; !done;) {
        sl_monitor_enter(&w->meeting);
        if (!w->done) sl_monitor_wait_for(&w->meeting, 0.05);
        done = w->done;
        sl_monitor_leave(&w->meeting);
        if (!done) sl_live_frame(w->live, &ignored, NULL, NULL);
    }
}

static cJSON *json_of_show(const sl_side *d, int index, const visited *w) {
    cJSON *o = cJSON_CreateObject(), *turns = cJSON_AddArrayToObject(o, "turns");
    cJSON_AddStringToObject(o, "side", sl_side_name(index));
    cJSON_AddStringToObject(o, "method", d->settings.method);
    sl_add_numbers(o, "size", (double[]){d->settings.width, d->settings.height}, 2);
    cJSON_AddItemToObject(o, "settings", sl_describe_settings(&d->settings));
    cJSON_AddNumberToObject(o, "behind", (double)d->has);
    cJSON_AddNumberToObject(o, "updates", (double)w->updates);
    cJSON_AddItemToObject(o, "rates", json_of_rates(w->live, w->updates));
    for (size_t i = 0; i < w->count; i++) {
        const sl_live_turn *t = &w->turns[i];
        const double numbers[3] = {(double)t->updates, (double)t->turn, (double)t->number};
        cJSON_AddItemToArray(turns, cJSON_CreateDoubleArray(numbers, 3));
    }
    return o;
}

static sl_status write_show(sl_stage *s, int index, const char *path, cJSON *shows, sl_error *error) {
    char name[4096];
    visited w = {.live = s->side[index].live, .status = SL_ERROR_RESOURCES};
    sl_fail(&w.error, SL_ERROR_USAGE, "log: a story is being told");
    if (!sl_monitor_open(&w.meeting)) return sl_fail(error, SL_ERROR_RESOURCES, "no lock could be had");
    if (sl_live_visit(w.live, visit, &w)) await_visit(&w);
    sl_monitor_close(&w.meeting);
    snprintf(name, sizeof name, "%.*s-%s.exr", (int)strlen(path) - 5, path, sl_side_name(index));
    sl_status status = w.done ? w.status : SL_ERROR_USAGE;
    if (status == SL_OK) cJSON_AddItemToArray(shows, json_of_show(&s->side[index], index, &w));
    else if (error) *error = w.error;
    if (status == SL_OK) status = sl_image_write(w.picture, name, error);
    sl_image_destroy(w.picture);
    free(w.turns);
    return status;
}

static sl_status write_text(const char *path, cJSON *log, sl_error *error) {
    char *text = cJSON_PrintUnformatted(log);
    sl_status status = text ? sl_output_whole(path, text, strlen(text), error) : sl_fail_memory(error, path);
    cJSON_free(text);
    return status;
}

sl_status sl_log_write(sl_stage *s, const char *path, sl_error *error) {
    const sl_world *w = &s->world;
    cJSON *log = cJSON_CreateObject(), *events = cJSON_AddArrayToObject(log, "events");
    cJSON *shows = cJSON_AddArrayToObject(log, "shows");
    sl_status status = SL_OK;
    cJSON_AddStringToObject(log, "softlux", SL_VERSION);
    cJSON_AddStringToObject(log, "scene", w->path);
    cJSON_AddNumberToObject(log, "at", w->first_time);
    for (size_t i = 0; i < w->count; i++) cJSON_AddItemToArray(events, json_of_event(w->events[i]));
    for (int i = 0; i < SL_SIDES && status == SL_OK; i++)
        if (s->side[i].live) status = write_show(s, i, path, shows, error);
    if (status == SL_OK) status = write_text(path, log, error);
    cJSON_Delete(log);
    return status;
}

/* ---- replaying ---- */

static bool values_of(const cJSON *list, double *to, size_t count) {
    const cJSON *item;
    size_t i = 0;
    if (!cJSON_IsArray(list) || (size_t)cJSON_GetArraySize(list) != count) return false;
    cJSON_ArrayForEach(item, list) to[i++] = item->valuedouble;
    return true;
}

static bool numbers(const cJSON *o, const char *name, double *to, size_t count) {
    return values_of(cJSON_GetObjectItem(o, name), to, count);
}

static double number(const cJSON *o, const char *name) {
    const cJSON *item = cJSON_GetObjectItem(o, name);
    return cJSON_IsNumber(item) ? item->valuedouble : 0.0;
}

/* False: it is not there, and belongs there. */
static bool read_field(const cJSON *o, const field *f, sl_item *item) {
    char *at = (char *)item + f->at;
    double values[MOST_VALUES] = {f->count == 1 ? number(o, f->name) : 0.0};
    const bool there = f->count == 1 || numbers(o, f->name, values, f->count);
    if (f->has) *((bool *)item + f->has) = there;
    if (f->as == FLAG) *(bool *)at = cJSON_IsTrue(cJSON_GetObjectItem(o, f->name));
    for (size_t i = 0; i < f->count && there; i++) {
        if (f->as == FLOATS) ((float *)(void *)at)[i] = (float)values[i];
        if (f->as == DOUBLES) ((double *)(void *)at)[i] = values[i];
    }
    return there || f->has;
}

/* Textures are the scene's: no event changes them. */
static bool item_from(const cJSON *o, const sl_scene *scene, sl_item *item) {
    const double kind = number(o, "kind");
    bool good = kind >= SL_ITEM_CAMERA && kind <= SL_ITEM_RELEASE;
    *item = (sl_item){.number = (uint32_t)number(o, "number")};
    if (good) item->kind = (sl_item_kind)kind;
    if (good && item->kind == SL_ITEM_MATERIAL)
        good = sl_scene_material(scene, item->number, &item->to.material);
    for (int i = 0; i < FIELDS && good; i++)
        good = !(fields[i].kinds >> item->kind & 1u) || read_field(o, &fields[i], item);
    return good;
}

typedef struct replay {
    const cJSON *events;
    sl_world world; /* only for its first state and its sky */
    sl_scene *scene;
    sl_method *method;
    sl_progress progress;
    const cJSON *rate; /* the next one */
} replay;

static sl_status no_log(sl_error *error) {
    return sl_fail(error, SL_ERROR_INPUT, "a log that is damaged, or another scene's");
}

static sl_status make(replay *r, const cJSON *json, unsigned *changes, sl_error *error) {
    const cJSON *items = cJSON_GetObjectItem(json, "items"), *o;
    sl_event *e = calloc(1, sizeof *e + SL_ITEMS * sizeof e->items[0]);
    sl_status status = e ? SL_OK : sl_fail_memory(error, "an event");
    if (status == SL_OK) e->sky = r->world.sky;
    cJSON_ArrayForEach(o, items) {
        if (status == SL_OK && (e->count == SL_ITEMS || !item_from(o, r->scene, &e->items[e->count++])))
            status = no_log(error);
    }
    if (status == SL_OK) status = e->count ? sl_event_make(e, r->scene, changes, error) : no_log(error);
    free(e);
    return status;
}

static sl_status make_before(replay *r, uint64_t behind, sl_error *error) {
    const cJSON *event;
    sl_status status = SL_OK;
    cJSON_ArrayForEach(event, r->events) {
        unsigned ignored;
        if (status == SL_OK && number(event, "number") <= (double)behind)
            status = make(r, event, &ignored, error);
    }
    return status;
}

/* Tells the method of the rates that it was told of before its next update. */
static sl_status take_rates(replay *r, sl_error *error) {
    sl_status status = SL_OK;
    double at[2];
    for (; r->rate && status == SL_OK; r->rate = r->rate->next) {
        if (!values_of(r->rate, at, 2)) return no_log(error);
        if (at[0] > (double)r->progress.batches) break;
        status = sl_method_rate(r->method, at[1], error);
    }
    return status;
}

static sl_status update_until(replay *r, uint64_t updates, sl_error *error) {
    sl_status status = SL_OK;
    while (status == SL_OK && r->progress.batches < updates && !r->progress.done) {
        status = take_rates(r, error);
        if (status == SL_OK) status = sl_method_update(r->method, &r->progress, error);
    }
    return status;
}

/* Turns in which nothing changed are none. */
static sl_status take_turn(replay *r, const cJSON **turn, sl_error *error) {
    double first[3], t[3];
    unsigned all = 0;
    const cJSON *at = *turn;
    if (!values_of(at, first, 3)) return no_log(error);
    sl_status status = update_until(r, (uint64_t)first[0], error);
    for (; at && status == SL_OK; at = at->next) {
        unsigned changes = 0;
        if (!values_of(at, t, 3) || t[1] != first[1]) break;
        const cJSON *event = cJSON_GetArrayItem(r->events, (int)t[2] - 1);
        status = event ? make(r, event, &changes, error) : no_log(error);
        all |= changes;
    }
    *turn = at;
    r->progress.done = false;
    return status == SL_OK && all ? sl_method_edit(r->method, all, error) : status;
}

static sl_status settings_from(const cJSON *show, sl_settings *settings, sl_error *error) {
    const cJSON *o = cJSON_GetObjectItem(show, "settings"), *item;
    const char *method = cJSON_GetStringValue(cJSON_GetObjectItem(show, "method"));
    double size[2];
    *settings = sl_settings_default();
    if (!method || !numbers(show, "size", size, 2)) return no_log(error);
    sl_status status = sl_settings_set(settings, "method", method, error);
    cJSON_ArrayForEach(item, o) {
        if (status == SL_OK && cJSON_IsString(item))
            status = sl_settings_set(settings, item->string, item->valuestring, error);
    }
    settings->width = (int)size[0], settings->height = (int)size[1];
    return status;
}

static sl_status replay_show(replay *r, const cJSON *show, sl_image **picture, sl_error *error) {
    sl_settings settings, own;
    sl_status status = settings_from(show, &settings, error);
    if (status == SL_OK) status = sl_world_copy(&r->world, &r->scene, error);
    if (status == SL_OK) status = make_before(r, (uint64_t)number(show, "behind"), error);
    const sl_settings shown = sl_side_shown(&settings);
    if (status == SL_OK) status = sl_live_choose(r->scene, &shown, &own, error);
    if (status == SL_OK) status = sl_method_create(r->scene, &own, &r->method, error);
    const cJSON *turns = cJSON_GetObjectItem(show, "turns"), *turn = turns ? turns->child : NULL,
                *rates = cJSON_GetObjectItem(show, "rates");
    r->rate = rates ? rates->child : NULL;
    while (turn && status == SL_OK) status = take_turn(r, &turn, error);
    if (status == SL_OK) status = update_until(r, (uint64_t)number(show, "updates"), error);
    if (status == SL_OK) status = sl_method_resolve(r->method, picture, error);
    sl_method_destroy(r->method);
    sl_scene_destroy(r->scene);
    r->method = NULL;
    r->scene = NULL;
    return status;
}

sl_status sl_log_replay(const char *path, const char *scene, const sl_reading *reading, int side,
                        sl_image **picture, sl_error *error) {
    replay r = {.scene = NULL};
    sl_bytes bytes;
    *picture = NULL;
    sl_status status = sl_bytes_read(path, (size_t)1 << 30, &bytes, error);
    if (status != SL_OK) return status;
    cJSON *log = cJSON_ParseWithLength((const char *)bytes.data, bytes.size);
    const cJSON *shows = cJSON_GetObjectItem(log, "shows"), *show = cJSON_GetArrayItem(shows, side);
    r.events = cJSON_GetObjectItem(log, "events");
    sl_free(bytes.data);
    status =
        show && r.events ? sl_world_open(&r.world, scene, reading, number(log, "at"), error) : no_log(error);
    if (status == SL_OK) {
        status = replay_show(&r, show, picture, error);
        sl_world_close(&r.world);
    }
    cJSON_Delete(log);
    return status;
}
