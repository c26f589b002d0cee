#include "cache/shading_cache/fade.h"

#include <string.h>

#include "base/grow.h"
#include "base/memory.h"

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

void sl_fade_begin(sl_fades *f, sl_patches *p, uint32_t vertex, const float from[3], const float from_lobe[3], float beta) {
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
    return fade->vertex < p->vertex_count && p->vertex[fade->vertex].references && p->vertex[fade->vertex].evaluated == fade->evaluated;
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
