/* Change: nobody says whose shading an edit has changed. Vertices evaluated before it are stale; those that are chosen are shaded again, with the
 * same samples, so that a difference is a change and nothing else. */
#include "cache/shading_cache/change.h"

#include <math.h>

#include "base/error.h"
#include "base/memory.h"

sl_status sl_changes_create(const sl_scene *scene, float threshold, int window, sl_changes **changes, sl_error *error) {
    *changes = NULL;
    sl_changes *made = sl_allocate(1, sizeof *made);
    if (!made) return sl_fail_memory(error, "change detection");
    made->object_count = scene->object_count;
    made->threshold = threshold;
    made->window = window;
    made->object = sl_allocate(made->object_count, sizeof *made->object);
    if (!made->object) {
        sl_changes_destroy(made);
        return sl_fail_memory(error, "change detection");
    }
    *changes = made;
    return SL_OK;
}

void sl_changes_destroy(sl_changes *changes) {
    if (!changes) return;
    sl_free(changes->object);
    sl_free(changes);
}

/* A change that begins anew makes patches coarser once. */
void sl_changes_begin(sl_changes *changes, uint32_t index, uint32_t now) {
    sl_object_change *object = &changes->object[index];
    if (!object->changing) object->dropped = false;
    object->changing = true;
    object->changed = now;
}

/* Any object may lose light, or gain some, when another one or a light moves; only the one that moved is known to be another one now. */
void sl_changes_edit(sl_changes *changes, unsigned what, const bool *moved, uint32_t now) {
    if (what & SL_CHANGED_CAMERA) changes->eye_moved = now;
    if (!(what & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS))) return;
    for (size_t i = 0; i < changes->object_count; i++) {
        sl_object_change *object = &changes->object[i];
        object->stale_before = now;
        if (!(what & SL_CHANGED_OBJECTS) || !moved || !moved[i]) continue;
        object->moved = now;
        sl_changes_begin(changes, (uint32_t)i, now);
    }
}

bool sl_changes_compare(sl_changes *changes, uint32_t object, float levels, uint32_t now) {
    if (!(levels > changes->threshold)) return false; /* NaN, too: no value came */
    sl_changes_begin(changes, object, now);
    return true;
}

void sl_changes_settle(sl_changes *changes, const bool *still_stale, uint32_t now) {
    uint32_t window = changes->window > 0 ? (uint32_t)changes->window : 0;
    for (size_t i = 0; i < changes->object_count; i++) {
        sl_object_change *object = &changes->object[i];
        if (object->changing && !still_stale[i] && now >= object->changed && now - object->changed >= window) object->changing = false;
    }
}

/* r T_c samples are what there is time for. Grids of quads have as many vertices as leaves, those of triangles half as many. */
float sl_changes_coarsest(double visible_pixels, double rate, double seconds, bool triangles) {
    double budget = rate * seconds * (triangles ? 2.0 : 1.0);
    if (!(visible_pixels > 0.0)) return 0.0f;
    return budget > 0.0 ? (float)fmin(visible_pixels / budget, (double)FLT_MAX) : FLT_MAX;
}

static bool is_to_drop(const sl_changes *changes, const sl_patches *patches, uint32_t patch, float area, float coarsest_quad, float coarsest_triangle) {
    if (!sl_patch_is_alive(patches, patch) || sl_patch_is_leaf(patches, patch)) return false;
    const sl_object_change *object = &changes->object[sl_root_object(patches->primitives, sl_patch_root(patches, patch))];
    return object->changing && !object->dropped && 0.25f * area <= (sl_patch_corners(patches, patch) == 3 ? coarsest_triangle : coarsest_quad);
}

size_t sl_changes_drop(sl_changes *changes, sl_patches *patches, const float *area, float coarsest_quad, float coarsest_triangle) {
    size_t before = patches->patches_alive;
    for (uint32_t i = 0; i < patches->patch_count; i++) {
        if (is_to_drop(changes, patches, i, area[i], coarsest_quad, coarsest_triangle)) sl_patch_drop_children(patches, i);
    }
    for (size_t i = 0; i < changes->object_count; i++) changes->object[i].dropped |= changes->object[i].changing;
    return before - patches->patches_alive;
}
