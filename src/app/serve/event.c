/* What is done to a scene, as often as there are copies of it. */
#include "app/serve/world.h"

#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the sky ---- */

struct sl_sky {
    int width, height;
    size_t values;
    float radiance[];
};

sl_sky *sl_sky_of(const sl_scene *scene) {
    const sl_environment *e = &scene->environment;
    const size_t values = e->width ? 3 * (size_t)e->width * (size_t)e->height : 3;
    const float constant[3] = {e->constant.r, e->constant.g, e->constant.b};
    sl_sky *sky = malloc(sizeof *sky + values * sizeof(float));
    if (!sky) return NULL;
    *sky = (sl_sky){e->width, e->height, values};
    memcpy(sky->radiance, e->width ? e->texels : constant, values * sizeof(float));
    return sky;
}

static sl_status edit_sky(sl_scene_edit *edit, const sl_sky *sky, double stops, sl_error *error) {
    const float factor = (float)pow(2.0, stops);
    float *radiance = malloc(sky->values * sizeof *radiance);
    if (!radiance) return sl_fail_memory(error, "the sky");
    for (size_t i = 0; i < sky->values; i++) radiance[i] = factor * sky->radiance[i];
    sl_status status = sl_edit_environment(edit, sky->width, sky->height, radiance, error);
    free(radiance);
    return status;
}

/* ---- edits ---- */

static sl_status add_light(sl_scene_edit *edit, const sl_light_item *light, sl_error *error) {
    sl_light_data data = {.size = sizeof data, .type = SL_LIGHT_POINT};
    uint32_t number;
    memcpy(data.strength, light->strength, sizeof data.strength);
    memcpy(data.position, light->position, sizeof data.position);
    return sl_edit_add_light(edit, &data, &number, error);
}

static sl_status edit_item(sl_scene_edit *edit, const sl_item *item, const sl_sky *sky, sl_error *error) {
    const sl_light_item *l = &item->to.light;
    switch (item->kind) {
    case SL_ITEM_OBJECT: return sl_edit_transform(edit, item->number, item->to.columns, error);
    case SL_ITEM_RELEASE: return sl_edit_transform(edit, item->number, NULL, error);
    case SL_ITEM_MATERIAL: return sl_edit_material(edit, item->number, &item->to.material, error);
    case SL_ITEM_LIGHT:
        return sl_edit_light(edit, item->number, l->has_strength ? l->strength : NULL,
                             l->has_position ? l->position : NULL, l->has_direction ? l->direction : NULL,
                             error);
    case SL_ITEM_ADD_LIGHT: return add_light(edit, l, error);
    case SL_ITEM_SKY: return edit_sky(edit, sky, item->to.stops, error);
    default: return sl_fail(error, SL_ERROR_USAGE, "an edit that is none");
    }
}

static sl_status make_edit(const sl_event *e, sl_scene *scene, unsigned *changes, sl_error *error) {
    sl_scene_edit *edit;
    sl_status status = sl_scene_edit_begin(scene, &edit, error);
    if (status != SL_OK) return status;
    for (size_t i = 0; i < e->count && status == SL_OK; i++)
        status = edit_item(edit, &e->items[i], e->sky, error);
    if (status == SL_OK) return sl_scene_edit_commit(edit, changes, error);
    sl_scene_edit_destroy(edit);
    return status;
}

sl_status sl_event_make(const void *event, sl_scene *scene, unsigned *changes, sl_error *error) {
    const sl_event *e = event;
    const sl_item *first = &e->items[0];
    sl_pose there = {.looks = true, .camera = scene->camera};
    *changes = 0;
    switch (first->kind) {
    case SL_ITEM_TIME:
        there.timed = true;
        there.time = first->to.time.seconds;
        there.looks = first->to.time.keeps_camera;
        break;
    case SL_ITEM_CAMERA: there.camera = first->to.camera; break;
    default: return make_edit(e, scene, changes, error);
    }
    return sl_pose_take(&there, scene, changes, error);
}

sl_status sl_events_make(const sl_event *const *events, size_t count, sl_scene *scene, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        unsigned ignored;
        status = sl_event_make(events[i], scene, &ignored, error);
    }
    return status;
}

/* ---- what takes the place of what ---- */

static uint64_t mixed(uint64_t h, uint64_t word) { return (h ^ word) * 1099511628211u; }

/* Events of one kind set the same things, so that the later one is all that counts. */
uint64_t sl_event_kind(const sl_item *items, size_t count) {
    uint64_t h = 14695981039346656037u;
    for (size_t i = 0; i < count; i++) {
        const sl_light_item *l = &items[i].to.light;
        if (items[i].kind == SL_ITEM_ADD_LIGHT) return 0;
        h = mixed(mixed(h, (uint64_t)items[i].kind), items[i].number);
        if (items[i].kind == SL_ITEM_LIGHT)
            h = mixed(h, l->has_strength + 2u * l->has_position + 4u * l->has_direction);
        if (items[i].kind == SL_ITEM_TIME) h = mixed(h, items[i].to.time.keeps_camera);
    }
    return h ? h : 1;
}
