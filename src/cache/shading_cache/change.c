/* Change: nobody says whose shading an edit has changed. Vertices evaluated before it are stale; those that
 * are chosen are shaded again, with the same samples, so that a difference is a change and nothing else. */
#include "cache/shading_cache/change.h"

#include <math.h>
#include <string.h>

#include "base/grow.h"
#include "base/memory.h"

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

/* r T_c samples are what there is time for. Grids of quads have as many vertices as leaves. */
float sl_changes_coarsest(double visible_pixels, double rate, double seconds) {
    double budget = rate * seconds;
    if (!(visible_pixels > 0.0)) return 0.0f;
    return budget > 0.0 ? (float)fmin(visible_pixels / budget, (double)FLT_MAX) : FLT_MAX;
}

static bool is_to_drop(const sl_changes *changes, const sl_patches *p, uint32_t patch, const sl_view *view,
                       float coarsest) {
    if (!sl_patch_is_alive(p, patch) || sl_patch_is_leaf(p, patch)) return false;
    sl_patch_place place = sl_patch_place_of(p, patch);
    const sl_object_change *object = &changes->object[sl_root_object(p->primitives, place.root)];
    if (!object->changing || object->dropped) return false;
    return 0.25f * sl_patch_projected(p, &place, view).area <= (place.corners == 3 ? 0.5f : 1.0f) * coarsest;
}

void sl_changes_drop(sl_changes *changes, sl_patches *patches, const sl_view *view, float coarsest) {
    for (uint32_t i = 0; i < patches->patch_count; i++)
        if (is_to_drop(changes, patches, i, view, coarsest)) sl_patch_drop_children(patches, i);
    for (size_t i = 0; i < changes->object_count; i++)
        changes->object[i].dropped |= changes->object[i].changing;
}

void sl_changes_drop_again(sl_changes *changes) {
    for (size_t i = 0; i < changes->object_count; i++) changes->object[i].dropped = false;
}

/* ---- blending ---- */

/* Less than what a display of 255 levels can show. */
static const float least_left = 1e-3f;

static void move_towards(sl_patches *p, const sl_fade *fade, float share) {
    float *value = sl_vertex_value(p, fade->vertex);
    for (int c = 0; c < p->settings.channels; c++) value[c] += share * (fade->value[c] - value[c]);
}

void sl_fade_begin(sl_fades *f, sl_patches *p, uint32_t vertex, const float from[6], float beta) {
    float *value = sl_vertex_value(p, vertex);
    size_t bytes = (size_t)p->settings.channels * sizeof *value;
    if (!sl_make_room(&f->fade, f->count, &f->capacity, sizeof *f->fade)) return;
    sl_fade *fade = &f->fade[f->count++];
    *fade = (sl_fade){.vertex = vertex, .evaluated = p->vertex[vertex].evaluated, .left = 1.0f - beta};
    memcpy(fade->value, value, bytes);
    memcpy(value, from, bytes);
    move_towards(p, fade, beta);
}

/* False: the vertex is gone, or has got another value. */
static bool still_fades(const sl_patches *p, const sl_fade *fade) {
    return fade->vertex < p->vertex_count && p->vertex[fade->vertex].references &&
           p->vertex[fade->vertex].evaluated == fade->evaluated;
}

/* Lets all go on, or, where they are to `arrive`, be what they are to become. */
static void go_on(sl_fades *f, sl_patches *p, float beta, bool arrive) {
    size_t kept = 0;
    for (size_t i = 0; i < f->count; i++) {
        sl_fade *fade = &f->fade[i];
        if (!still_fades(p, fade)) continue;
        fade->left *= 1.0f - beta;
        bool there = arrive || fade->left < least_left;
        move_towards(p, fade, beta);
        if (there)
            memcpy(sl_vertex_value(p, fade->vertex), fade->value,
                   (size_t)p->settings.channels * sizeof *fade->value);
        if (!there) f->fade[kept++] = *fade;
    }
    f->count = kept;
}

void sl_fades_go_on(sl_fades *f, sl_patches *p, float beta) { go_on(f, p, beta, false); }

void sl_fades_finish(sl_fades *f, sl_patches *p) { go_on(f, p, 1.0f, true); }

void sl_fades_release(sl_fades *f) {
    sl_free(f->fade);
    *f = (sl_fades){0};
}
