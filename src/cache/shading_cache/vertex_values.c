/* What vertices show. A vertex without samples lies in the middle of an edge, or of a quadrilateral, that was
 * cut; it shows the mean of the edge's ends, or of the four corners, which may have none themselves; corners
 * of roots have the guess. As that depends on where the vertex lies and on nothing else, all leaves that have
 * it show the same, and nothing is seen of a split until its samples come. */
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/frame/picture_value.h"
#include "cache/patches/patch_parts.h"
#include "cache/shading_cache/display_parts.h"

/* ---- what a vertex lies between -------------------------------------------------------------- */

static int zeros_below(uint32_t x) {
    int zeros = 0;
    while (zeros < SL_PATCH_DEPTH_MAX && !(x >> zeros & 1)) zeros++;
    return zeros;
}

static uint32_t vertex_beside(const sl_patches *p, const sl_patch_vertex *of, int du, int dv) {
    return sl_vertex_find(p, (sl_root_place){of->root, (uint16_t)(of->u + du), (uint16_t)(of->v + dv)});
}

/* Its level is the depth of the patches that it was made for; 0: it lies between nothing, as a root's corner.
 */
static int find_around(const sl_patches *p, uint32_t vertex, sl_pending_vertex *entry) {
    const sl_patch_vertex *v = &p->vertex[vertex];
    *entry = (sl_pending_vertex){vertex, {SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX}};
    int zu = zeros_below(v->u), zv = zeros_below(v->v), zeros = zu < zv ? zu : zv, step = 1 << zeros;
    if (zeros == SL_PATCH_DEPTH_MAX) return 0;
    bool triangle = p->primitives->kind[v->root / 2] == SL_PRIMITIVE_TRIANGLE;
    if (zu != zv) {
        entry->around[0] = vertex_beside(p, v, zu < zv ? -step : 0, zu < zv ? 0 : -step);
        entry->around[1] = vertex_beside(p, v, zu < zv ? step : 0, zu < zv ? 0 : step);
    } else {
        entry->around[0] = vertex_beside(p, v, -step, step);
        entry->around[1] = vertex_beside(p, v, step, -step);
        entry->around[2] = triangle ? SL_NO_INDEX : vertex_beside(p, v, -step, -step);
        entry->around[3] = triangle ? SL_NO_INDEX : vertex_beside(p, v, step, step);
    }
    bool between = entry->around[0] != SL_NO_INDEX && entry->around[1] != SL_NO_INDEX;
    return between ? SL_PATCH_DEPTH_MAX - zeros : 0;
}

/* ---- the list of those without samples ------------------------------------------------------- */

void sl_display_values_release(sl_display *d) {
    for (int l = 0; l <= SL_PATCH_DEPTH_MAX; l++) sl_free(d->pending[l].entry);
    sl_free(d->seen_pending);
}

static bool append(sl_pending *list, const sl_pending_vertex *entry) {
    bool ok = sl_display_grow(&list->entry, &list->capacity, list->count + 1, sizeof *list->entry);
    if (ok) list->entry[list->count++] = *entry;
    return ok;
}

/* Entries go whose vertex has samples by now, or is gone, or will be entered again as it has been met: so are
 * all whose number is another vertex's by now. */
static void drop_entries(sl_display *d, const sl_patches *p) {
    for (int l = 0; l <= SL_PATCH_DEPTH_MAX; l++) {
        sl_pending *list = &d->pending[l];
        size_t kept = 0;
        for (size_t i = 0; i < list->count; i++) {
            sl_pending_vertex entry = list->entry[i];
            const sl_patch_vertex *v = &p->vertex[entry.vertex];
            bool met = d->seen_pending[entry.vertex / 32] >> entry.vertex % 32 & 1;
            if (!met && v->references && v->evaluated == SL_VERTEX_NEVER) list->entry[kept++] = entry;
        }
        list->count = kept;
    }
}

/* ---- values ---------------------------------------------------------------------------------- */

/* Finite, as pictures are. */
static sl_rgb shown(const float value[3]) {
    return (sl_rgb){sl_picture_value(value[0]), sl_picture_value(value[1]), sl_picture_value(value[2])};
}

static void take_samples(const sl_display_copy *copy, const sl_patches *p, uint32_t vertex) {
    const float *lobe = sl_vertex_lobe(p, vertex);
    copy->value[vertex] = shown(p->vertex[vertex].value);
    if (lobe) *sl_display_lobe(copy, vertex) = shown(lobe);
}

static sl_rgb *value_of(const sl_display_copy *copy, uint32_t vertex, bool lobe) {
    return lobe ? sl_display_lobe(copy, vertex) : &copy->value[vertex];
}

/* Vertices lie between such as have lobes if they have one. */
static void take_mean(const sl_display_copy *copy, bool lobe, const sl_pending_vertex *e) {
    int count = e->around[2] != SL_NO_INDEX && e->around[3] != SL_NO_INDEX ? 4 : 2;
    for (int which = 0; which <= (int)lobe; which++) {
        sl_rgb sum = sl_grey(0.0f);
        for (int k = 0; k < count; k++)
            sum = sl_rgb_add(sum, sl_rgb_scale(*value_of(copy, e->around[k], which), 1.0f / (float)count));
        *value_of(copy, e->vertex, which) = sum;
    }
}

static void take_guess(const sl_display *d, const sl_display_copy *copy, const sl_patches *p,
                       uint32_t vertex) {
    copy->value[vertex] = d->settings.guess;
    if (sl_vertex_lobe(p, vertex)) *sl_display_lobe(copy, vertex) = sl_grey(0.0f);
}

/* Vertices of the list with samples get them, the others are met. */
static void visit(sl_display *d, const sl_display_copy *copy, const sl_patches *p, size_t count,
                  const uint32_t *list) {
    for (size_t i = 0; i < count; i++) {
        if (!sl_patch_is_alive(p, list[i])) continue;
        for (int c = 0; c < sl_patch_corners(p, list[i]); c++) {
            uint32_t vertex = sl_patch_corner(p, list[i], c);
            if (p->vertex[vertex].evaluated == SL_VERTEX_NEVER)
                d->seen_pending[vertex / 32] |= 1u << vertex % 32;
            else take_samples(copy, p, vertex);
        }
    }
}

/* Those that were met are entered, once each; corners of roots have their value at once. */
static bool enter(sl_display *d, const sl_display_copy *copy, const sl_patches *p, size_t count,
                  const uint32_t *list) {
    for (size_t i = 0; i < count; i++) {
        for (int c = 0; sl_patch_is_alive(p, list[i]) && c < sl_patch_corners(p, list[i]); c++) {
            uint32_t vertex = sl_patch_corner(p, list[i], c), bit = 1u << vertex % 32;
            if (!(d->seen_pending[vertex / 32] & bit)) continue;
            d->seen_pending[vertex / 32] &= ~bit;
            sl_pending_vertex entry;
            int level = find_around(p, vertex, &entry);
            if (level == 0) take_guess(d, copy, p, vertex);
            else if (!append(&d->pending[level], &entry)) return false;
        }
    }
    return true;
}

static bool make_room_for_marks(sl_display *d, const sl_patches *p) {
    return sl_display_grow(&d->seen_pending, &d->seen_words, p->vertex_count / 32 + 1,
                           sizeof *d->seen_pending);
}

/* Coarse levels first: what a vertex lies between is of lower levels. All of them, as what they depend on is
 * not written down; they are few, since patches without samples come first. */
sl_status sl_display_values(sl_display *d, sl_display_copy *copy, const sl_patches *p,
                            const uint32_t *const list[2], const size_t count[2], sl_error *error) {
    bool ok = make_room_for_marks(d, p);
    for (int k = 0; ok && k < 2; k++) visit(d, copy, p, count[k], list[k]);
    if (ok) drop_entries(d, p);
    for (int k = 0; ok && k < 2; k++) ok = enter(d, copy, p, count[k], list[k]);
    if (!ok) {
        if (d->seen_pending) memset(d->seen_pending, 0, d->seen_words * sizeof *d->seen_pending);
        return sl_fail_memory(error, "the display's values");
    }
    for (int l = 0; l <= SL_PATCH_DEPTH_MAX; l++) {
        for (size_t i = 0; i < d->pending[l].count; i++)
            take_mean(copy, sl_vertex_lobe(p, d->pending[l].entry[i].vertex) != NULL,
                      &d->pending[l].entry[i]);
    }
    return SL_OK;
}
