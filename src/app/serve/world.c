#include "app/serve/world.h"

#include "app/memory_limit.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

enum { EVENTS = 1 << 20, UNDO_STEPS = 512 };

/* ---- life ---- */

sl_status sl_world_copy(const sl_world *w, sl_scene **scene, sl_error *error) {
    unsigned ignored;
    sl_status status = sl_scene_load_with(w->path, &w->reading->load, scene, error);
    if (status == SL_OK) status = sl_scene_set_time(*scene, w->first_time, &ignored, error);
    if (status == SL_OK) return SL_OK;
    sl_scene_destroy(*scene);
    *scene = NULL;
    return status;
}

sl_status sl_world_open(sl_world *w, const char *path, const sl_reading *reading, double time_seconds,
                        sl_error *error) {
    *w = (sl_world){.path = path, .reading = reading, .time = time_seconds, .first_time = time_seconds};
    sl_status status = sl_world_copy(w, &w->scene, error);
    if (status != SL_OK) return status;
    w->sky = sl_sky_of(w->scene);
    w->first_camera = w->scene->camera;
    w->duration = sl_scene_duration(w->scene);
    w->undo = calloc(UNDO_STEPS, sizeof *w->undo);
    if (w->sky && w->undo) return SL_OK;
    sl_world_close(w);
    return sl_fail_memory(error, "the scene's edits");
}

void sl_world_close(sl_world *w) {
    for (size_t i = 0; i < w->count; i++) free((void *)w->events[i]);
    sl_free(w->events);
    free(w->undo);
    free(w->sky);
    sl_scene_destroy(w->scene);
    *w = (sl_world){.path = NULL};
}

/* ---- events ---- */

static void remember(sl_world *w, const sl_item *item) {
    switch (item->kind) {
    case SL_ITEM_SKY: w->stops = item->to.stops; break;
    case SL_ITEM_TIME: w->time = item->to.time.seconds; break;
    default: break;
    }
    w->edited = w->edited || item->kind > SL_ITEM_TIME;
}

/* Does it and appends it to the events; or nothing. */
static sl_status happen(sl_world *w, const sl_item *items, size_t count, unsigned *changes, sl_error *error) {
    sl_event *e = w->count < EVENTS ? malloc(sizeof *e + count * sizeof *items) : NULL;
    if (!e || !sl_make_room(&w->events, w->count, &w->room, sizeof *w->events)) {
        free(e);
        return sl_fail_memory(error, "one more event");
    }
    *e = (sl_event){w->count + 1, sl_event_kind(items, count), w->sky, count};
    memcpy(e->items, items, count * sizeof *items);
    sl_status status = sl_event_make(e, w->scene, changes, error);
    if (status != SL_OK) {
        free(e);
        return status == SL_ERROR_INPUT ? SL_ERROR_USAGE : status; /* the message is sound */
    }
    w->events[w->count++] = e;
    for (size_t i = 0; i < count; i++) remember(w, &items[i]);
    return SL_OK;
}

sl_status sl_world_look(sl_world *w, const sl_camera *camera, unsigned *changes, sl_error *error) {
    const sl_item item = {.kind = SL_ITEM_CAMERA, .to.camera = *camera};
    sl_status status = happen(w, &item, 1, changes, error);
    if (status == SL_OK) w->looks = true;
    return status;
}

sl_status sl_world_go_to(sl_world *w, double seconds, unsigned *changes, sl_error *error) {
    const sl_item item = {.kind = SL_ITEM_TIME, .to.time = {seconds, w->looks}};
    return happen(w, &item, 1, changes, error);
}

/* ---- undo ---- */

static void light_as_it_is(const sl_world *w, uint32_t number, sl_light_item *to) {
    const sl_light *l = &w->scene->lights[number - 1];
    *to = (sl_light_item){
        .has_strength = true,
        .has_position = l->type != SL_LIGHT_DIRECTIONAL,
        .has_direction = l->type != SL_LIGHT_POINT,
        .strength = {l->intensity.r, l->intensity.g, l->intensity.b},
        .position = {(double)l->position.x, (double)l->position.y, (double)l->position.z},
        .direction = {(double)l->direction.x, (double)l->direction.y, (double)l->direction.z}};
}

/* The item that gives back what this one takes; false: it names something that is not there. */
static bool reverse(const sl_world *w, const sl_item *item, size_t lights, sl_item *back) {
    *back = *item;
    switch (item->kind) {
    case SL_ITEM_OBJECT:
    case SL_ITEM_RELEASE:
        if (!item->number || item->number > w->scene->object_count) return false;
        back->kind = sl_scene_transform(w->scene, item->number, back->to.columns) ? SL_ITEM_RELEASE
                                                                                  : SL_ITEM_OBJECT;
        return true;
    case SL_ITEM_MATERIAL: return sl_scene_material(w->scene, item->number, &back->to.material);
    case SL_ITEM_LIGHT:
        if (!item->number || item->number > w->scene->light_count) return false;
        light_as_it_is(w, item->number, &back->to.light);
        return true;
    case SL_ITEM_ADD_LIGHT:
        back->kind = SL_ITEM_LIGHT;
        back->number = (uint32_t)lights;
        back->to.light = (sl_light_item){.has_strength = true};
        return true;
    case SL_ITEM_SKY: back->to.stops = w->stops; return true;
    default: return false;
    }
}

/* A light that was added is there for good: done again it is lit again. */
static sl_item as_repeated(const sl_item *item, const sl_item *back) {
    sl_item again = *item;
    if (item->kind == SL_ITEM_ADD_LIGHT) {
        again.kind = SL_ITEM_LIGHT;
        again.number = back->number;
        again.to.light.has_strength = again.to.light.has_position = true;
    }
    return again;
}

static sl_status fill_step(const sl_world *w, const sl_item *items, size_t count, sl_undo *step,
                           sl_error *error) {
    size_t lights = w->scene->light_count;
    step->count = count;
    for (size_t i = 0; i < count; i++) {
        lights += items[i].kind == SL_ITEM_ADD_LIGHT;
        if (!reverse(w, &items[i], lights, &step->before[i]))
            return sl_fail(error, SL_ERROR_USAGE, "there is no such number: %u", items[i].number);
        step->after[i] = as_repeated(&items[i], &step->before[i]);
    }
    return SL_OK;
}

/* Steps that were undone go; of too many the oldest. */
static void push(sl_world *w, const sl_undo *step) {
    w->undo_count -= w->undone;
    w->undone = 0;
    if (w->undo_count == UNDO_STEPS) memmove(w->undo, w->undo + 1, --w->undo_count * sizeof *w->undo);
    w->undo[w->undo_count++] = *step;
}

static bool goes_on(const sl_world *w, const sl_undo *step) {
    const sl_undo *top = w->undo_count ? &w->undo[w->undo_count - 1] : NULL;
    return w->drags && !w->undone && top && top->count == step->count &&
           sl_event_kind(top->after, top->count) == sl_event_kind(step->after, step->count);
}

sl_status sl_world_edit(sl_world *w, const sl_item *items, size_t count, bool drag, unsigned *changes,
                        sl_error *error) {
    sl_undo *step = malloc(sizeof *step);
    if (!step) return sl_fail_memory(error, "an edit");
    sl_status status = fill_step(w, items, count, step, error);
    if (status == SL_OK) status = happen(w, items, count, changes, error);
    if (status == SL_OK) {
        if (goes_on(w, step)) memcpy(w->undo[w->undo_count - 1].after, step->after, sizeof step->after);
        else push(w, step);
        w->drags = drag;
    }
    free(step);
    return status;
}

sl_status sl_world_undo(sl_world *w, bool again, unsigned *changes, sl_error *error) {
    if (again ? !w->undone : w->undone == w->undo_count)
        return sl_fail(error, SL_ERROR_USAGE, "there is nothing to %s", again ? "do again" : "undo");
    const sl_undo *step = &w->undo[w->undo_count - w->undone - !again];
    sl_status status = happen(w, again ? step->after : step->before, step->count, changes, error);
    if (status == SL_OK) w->undone = again ? w->undone - 1 : w->undone + 1;
    w->drags = false;
    return status;
}
