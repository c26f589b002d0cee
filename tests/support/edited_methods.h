/* Methods that follow edits of the room. */
#ifndef SL_TESTS_EDITED_METHODS_H
#define SL_TESTS_EDITED_METHODS_H

#include "edited_room.h"
#include "rendering.h"

static inline void good(sl_status status, const sl_error *error) {
    if (status != SL_OK) fail_msg("%s", error->message);
}

static inline void finish(sl_method *method) {
    sl_error error;
    for (sl_progress p = {0}; !p.done;) good(sl_method_update(method, &p, &error), &error);
}

static inline sl_method *finished(const sl_scene *scene, const char *name) {
    sl_error error;
    sl_method *method;
    sl_settings settings = small_settings(name, 24, 24);
    settings.spp = 4;
    settings.bounces = 1;
    settings.light_octree.depth = 4;
    settings.light_octree.photons = 4000;
    settings.gather_size = 16;
    settings.multi_mesh.coarse_depth = 2;
    settings.shading_cache.indirect_samples = 8;
    settings.shading_cache.area_samples = 8;
    good(sl_method_create(scene, &settings, &method, &error), &error);
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

#endif
