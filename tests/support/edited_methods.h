/* Methods that follow edits of the room. */
#pragma once

#include "edited_room.h"
#include "rendering.h"

static inline sl_settings settings_in_room(const char *name) {
    sl_settings settings = small_settings(name, 24, 24);
    settings.spp = 4;
    settings.bounces = 1;
    settings.light_octree.depth = 4;
    settings.light_octree.photons = 4000;
    settings.gather_size = 16;
    settings.multi_mesh.coarse_depth = 2;
    settings.shading_cache.indirect_samples = 8;
    settings.shading_cache.area_samples = 8;
    return settings;
}

static inline void finish(sl_method *method) { sl_image_destroy(finished_picture(method)); }

static inline sl_method *finished(const sl_scene *scene, const char *name) {
    const sl_settings settings = settings_in_room(name);
    sl_method *method = created_method(scene, &settings);
    finish(method);
    return method;
}

/* Returns what has changed. */
static inline unsigned change(sl_scene *scene, edited_room *r, room_edit kind) {
    sl_error error;
    sl_scene_edit *e;
    unsigned changes;
    good(begin_room_edit(r, scene, &e, &error), &error);
    good(edit_room(r, scene, kind, e, &error), &error);
    good(sl_scene_edit_commit(e, &changes, &error), &error);
    return changes;
}

static inline void follow(sl_method *method) {
    sl_error error;
    good(sl_method_edit(method, 0, &error), &error);
    finish(method);
}
