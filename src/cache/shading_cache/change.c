/* Change: nobody says whose shading an edit has changed. Vertices evaluated before it are stale; those that
 * are chosen are shaded again, with the same samples, so that a difference is a change and nothing else. */
#include "cache/shading_cache/change.h"

#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"

sl_status sl_changes_create(const sl_scene *scene, float threshold, int window, sl_changes **changes,
                            sl_error *error) {
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

/* Any object may lose light, or gain some, when another one or a light moves; only the one that moved is
 * known to be another one now. */
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
        if (object->changing && !still_stale[i] && now >= object->changed && now - object->changed >= window)
            object->changing = false;
    }
}

/* r T_c samples are what there is time for. Grids of quads have as many vertices as leaves, those of
 * triangles half as many. */
float sl_changes_coarsest(double visible_pixels, double rate, double seconds, bool triangles) {
    double budget = rate * seconds * (triangles ? 2.0 : 1.0);
    if (!(visible_pixels > 0.0)) return 0.0f;
    return budget > 0.0 ? (float)fmin(visible_pixels / budget, (double)FLT_MAX) : FLT_MAX;
}

static bool is_to_drop(const sl_changes *changes, const sl_patches *patches, uint32_t patch, float area,
                       float coarsest_quad, float coarsest_triangle) {
    if (!sl_patch_is_alive(patches, patch) || sl_patch_is_leaf(patches, patch)) return false;
    uint32_t owner = sl_root_object(patches->primitives, sl_patch_root(patches, patch));
    const sl_object_change *object = &changes->object[owner];
    return object->changing && !object->dropped && 0.25f * area <= (sl_patch_corners(patches,
        patch) == 3 ? coarsest_triangle : coarsest_quad);
}

size_t sl_changes_drop(sl_changes *changes, sl_patches *patches, const float *area, float coarsest_quad,
                       float coarsest_triangle) {
    size_t before = patches->patches_alive;
    for (uint32_t i = 0; i < patches->patch_count; i++) {
        if (is_to_drop(changes, patches, i, area[i], coarsest_quad, coarsest_triangle))
            sl_patch_drop_children(patches, i);
    }
    for (size_t i = 0; i < changes->object_count; i++)
        changes->object[i].dropped |= changes->object[i].changing;
    return before - patches->patches_alive;
}

/* ---- blending ---- */

/* Less than what a display of 255 levels can show. */
static const float least_left = 1e-3f;

bool sl_fade_from(const sl_patches *p, uint32_t vertex, float value[3], float lobe[3]) {
    const sl_patch_vertex *v = &p->vertex[vertex];
    double a = (double)v->u / SL_PATCH_DYADIC, b = (double)v->v / SL_PATCH_DYADIC;
    sl_patch_place leaf = sl_patch_locate(p, v->root, a, b);
    if (leaf.patch == SL_NO_INDEX || !sl_patch_value(p, &leaf, a, b, false, value)) return false;
    return !sl_vertex_lobe(p, vertex) || sl_patch_value(p, &leaf, a, b, true, lobe);
}

static sl_fade *room_for_one(sl_fades *f) {
    if (f->count == f->capacity) {
        size_t room = 2 * f->capacity + 64;
        if (!sl_regrow(&f->fade, f->count, room, sizeof *f->fade)) return NULL;
        f->capacity = room;
    }
    return &f->fade[f->count++];
}

static void move_towards(float value[3], const float target[3], float share) {
    for (int c = 0; c < 3; c++) value[c] += share * (target[c] - value[c]);
}

void sl_fade_begin(sl_fades *f, sl_patches *p, uint32_t vertex, const float from[3], const float from_lobe[3],
                   float beta) {
    sl_fade *fade = room_for_one(f);
    if (!fade) return;
    sl_patch_vertex *v = &p->vertex[vertex];
    float *lobe = sl_vertex_lobe(p, vertex);
    *fade = (sl_fade){.vertex = vertex, .evaluated = v->evaluated, .left = 1.0f - beta};
    memcpy(fade->value, v->value, sizeof fade->value);
    memcpy(v->value, from, sizeof v->value);
    move_towards(v->value, fade->value, beta);
    if (!lobe) return;
    memcpy(fade->lobe, lobe, sizeof fade->lobe);
    memcpy(lobe, from_lobe, sizeof fade->lobe);
    move_towards(lobe, fade->lobe, beta);
}

/* False: the vertex is gone, or has got another value. */
static bool still_fades(const sl_patches *p, const sl_fade *fade) {
    return fade->vertex < p->vertex_count && p->vertex[fade->vertex].references &&
           p->vertex[fade->vertex].evaluated == fade->evaluated;
}

static void arrive(sl_patches *p, const sl_fade *fade) {
    float *lobe = sl_vertex_lobe(p, fade->vertex);
    memcpy(p->vertex[fade->vertex].value, fade->value, sizeof fade->value);
    if (lobe) memcpy(lobe, fade->lobe, sizeof fade->lobe);
}

void sl_fades_go_on(sl_fades *f, sl_patches *p, float beta) {
    size_t kept = 0;
    for (size_t i = 0; i < f->count; i++) {
        sl_fade *fade = &f->fade[i];
        if (!still_fades(p, fade)) continue;
        fade->left *= 1.0f - beta;
        float *lobe = sl_vertex_lobe(p, fade->vertex);
        move_towards(p->vertex[fade->vertex].value, fade->value, beta);
        if (lobe) move_towards(lobe, fade->lobe, beta);
        bool there = fade->left < least_left;
        if (there) arrive(p, fade);
        sl_patches_touch(p, fade->vertex);
        if (!there) f->fade[kept++] = *fade;
    }
    f->count = kept;
}

void sl_fades_finish(sl_fades *f, sl_patches *p) {
    for (size_t i = 0; i < f->count; i++) {
        if (!still_fades(p, &f->fade[i])) continue;
        arrive(p, &f->fade[i]);
        sl_patches_touch(p, f->fade[i].vertex);
    }
    f->count = 0;
}

void sl_fades_release(sl_fades *f) {
    sl_free(f->fade);
    *f = (sl_fades){0};
}
