/* What vertices show: their samples, or, before they have any, what the nearest patch around them shows there
 * all of whose corners have; or the guess. As that depends on where the vertex lies and on nothing else, all
 * leaves that have it show the same, and nothing is seen of a split until its samples come. */
#include "base/error.h"
#include "cache/frame/picture_value.h"
#include "cache/shading_cache/display_parts.h"

/* Finite, as pictures are. */
static void show(const sl_display_copy *copy, uint32_t vertex, const float *value) {
    for (size_t i = 0; i < copy->channels; i++)
        copy->value[vertex * copy->channels + i] = sl_picture_value(value[i]);
}

static void take_surroundings(const sl_display *d, const sl_display_copy *copy, const sl_patches *p,
                              uint32_t vertex) {
    const sl_patch_vertex *v = &p->vertex[vertex];
    double a = (double)v->u / SL_PATCH_DYADIC, b = (double)v->v / SL_PATCH_DYADIC;
    sl_patch_place leaf = sl_patch_locate(p, v->root, a, b);
    const sl_rgb guess = d->settings.guess;
    float value[6] = {guess.r, guess.g, guess.b};
    sl_patch_value(p, &leaf, a, b, value);
    show(copy, vertex, value);
}

/* Vertices of the list with samples get them, the others are pending from then on. */
static void visit(sl_display *d, const sl_display_copy *copy, const sl_patches *p, size_t count,
                  const uint32_t *list) {
    for (size_t i = 0; i < count; i++) {
        if (!sl_patch_is_alive(p, list[i])) continue;
        for (int c = 0; c < sl_patch_corners(p, list[i]); c++) {
            uint32_t vertex = sl_patch_corner(p, list[i], c);
            if (p->vertex[vertex].evaluated == SL_VERTEX_NEVER) d->pending[vertex / 32] |= 1u << vertex % 32;
            else show(copy, vertex, sl_vertex_value(p, vertex));
        }
    }
}

/* All pending ones anew, as what they depend on is not written down; they are few, since patches without
 * samples come first. */
sl_status sl_display_values(sl_display *d, sl_display_copy *copy, const sl_patches *p,
                            const uint32_t *const list[2], const size_t count[2], sl_error *error) {
    if (!sl_display_grow(&d->pending, &d->pending_words, p->vertex_count / 32 + 1, sizeof *d->pending))
        return sl_fail_memory(error, "the display's values");
    for (int k = 0; k < 2; k++) visit(d, copy, p, count[k], list[k]);
    for (uint32_t vertex = 0; vertex < p->vertex_count; vertex++) {
        uint32_t *word = &d->pending[vertex / 32], bit = 1u << vertex % 32;
        if (*word == 0) vertex |= 31;
        if (!(*word & bit)) continue;
        const sl_patch_vertex *v = &p->vertex[vertex];
        if (!v->references || v->evaluated != SL_VERTEX_NEVER) *word &= ~bit;
        else take_surroundings(d, copy, p, vertex);
    }
    return SL_OK;
}
