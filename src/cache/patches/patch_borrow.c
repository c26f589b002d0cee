/* Vertices without light of their own: inside other geometry, where a table leg stands on the floor, or where
 * no number came. What they show is borrowed from the corners of the leaves around them that have light, the
 * nearer the more (1/d^2, Shepard 1968; a corner of two leaves counts twice), or, where none of these has
 * any, from those of their parents, and so on upwards. So a leaf that is half under the leg shows on its
 * other half what is beside it, and where the leg begins is for splits to find: what such a leaf shows may be
 * wrong by all of it (sl_patch_error()), down to the size at which nothing is split any more. */
#include <string.h>

#include "base/math.h"
#include "cache/patches/patch_parts.h"

void sl_patches_borrow(sl_patches *p, uint32_t vertex) {
    p->vertex[vertex].borrowed = 1;
    p->borrowing = true;
}

/* ---- lenders --------------------------------------------------------------------------------- */

typedef struct loan {
    uint32_t vertex;           /* that borrows */
    int above;                 /* from patches so many levels above the leaves around it */
    sl_vec3 position;
    double weight, value[3], lobe[3];
} loan;

static void borrow_from(const sl_patches *p, loan *to, uint32_t lender) {
    const sl_patch_vertex *v = &p->vertex[lender];
    if (v->evaluated == SL_VERTEX_NEVER || v->borrowed || lender == to->vertex) return;
    sl_vec3d apart = sl_subd(sl_to_double(sl_root_position(p->primitives, v->root, v->u, v->v)),
                             sl_to_double(to->position));
    double weight = 1.0 / fmax(sl_dotd(apart, apart), 1e-30);
    const float *lobe = sl_vertex_lobe(p, lender);
    to->weight += weight;
    for (int c = 0; c < 3; c++) to->value[c] += weight * (double)v->value[c];
    for (int c = 0; lobe && c < 3; c++) to->lobe[c] += weight * (double)lobe[c];
}

static void borrow_from_patch(sl_patches *p, const sl_patch_place *leaf, void *context) {
    loan *to = context;
    uint32_t patch = leaf->patch;
    for (int i = 0; i < to->above && patch != SL_NO_INDEX; i++) patch = sl_patch_parent(p, patch);
    for (int c = 0; patch != SL_NO_INDEX && c < sl_patch_corners(p, patch); c++)
        borrow_from(p, to, sl_patch_corner(p, patch, c));
}

static bool put_mean(float to[3], const double sum[3], double weight) {
    bool other = false;
    for (int c = 0; c < 3; c++) {
        float mean = (float)(sum[c] / weight);
        other |= to[c] != mean;
        to[c] = mean;
    }
    return other;
}

/* All leaves that show it are to know. */
static void take_loan(sl_patches *p, const loan *l) {
    float *lobe = sl_vertex_lobe(p, l->vertex);
    bool other = put_mean(p->vertex[l->vertex].value, l->value, l->weight);
    if (lobe) other |= put_mean(lobe, l->lobe, l->weight);
    if (other) sl_patches_touch(p, l->vertex);
}

/* Where nobody has anything what is there stays. False: nobody around has. */
static bool lend_to(sl_patches *p, uint32_t vertex) {
    const sl_patch_vertex *v = &p->vertex[vertex];
    loan l = {.vertex = vertex, .position = sl_root_position(p->primitives, v->root, v->u, v->v)};
    for (; !(l.weight > 0.0) && l.above <= SL_PATCH_DEPTH_MAX; l.above++)
        sl_patches_visit_around(p, sl_vertex_place(v), borrow_from_patch, &l);
    if (l.weight > 0.0) take_loan(p, &l);
    return l.weight > 0.0 && l.above == 1;
}

/* ---- all that borrow ------------------------------------------------------------------------- */

static sl_status wait(sl_patches *p, uint32_t vertex, sl_error *error) {
    if (p->vertex[vertex].waiting) return SL_OK;
    if (p->waiting_count == p->waiting_capacity) {
        size_t room = sl_patches_room(p->waiting_capacity, 0), size = sizeof *p->waiting;
        sl_growing all[] = {{(void **)&p->waiting, p->waiting_count * size, room * size, NULL}};
        sl_status status = sl_patches_enlarge(all, 1, error);
        if (status != SL_OK) return status;
        p->waiting_capacity = room;
    }
    p->vertex[vertex].waiting = 1;
    p->waiting[p->waiting_count++] = vertex;
    return SL_OK;
}

/* Numbers of vertices that are gone may be in the list, and those of others by now, and twice. */
static void lend_to_waiting(sl_patches *p) {
    size_t kept = 0;
    for (size_t i = 0; i < p->waiting_count; i++) p->vertex[p->waiting[i]].waiting = 0;
    for (size_t i = 0; i < p->waiting_count; i++) {
        uint32_t vertex = p->waiting[i];
        sl_patch_vertex *v = &p->vertex[vertex];
        if (!v->references || !v->borrowed || v->waiting) continue;
        if (lend_to(p, vertex)) continue;
        v->waiting = 1;
        p->waiting[kept++] = vertex;
    }
    p->waiting_count = kept;
}

static sl_status lend_or_wait(sl_patches *p, uint32_t vertex, sl_error *error) {
    return !p->vertex[vertex].borrowed || lend_to(p, vertex) ? SL_OK : wait(p, vertex, error);
}

/* To its corners, and to what hangs on its edges: that has the leaf around it, too. */
static sl_status lend_to_leaf(sl_patches *p, uint32_t leaf, sl_error *error) {
    uint32_t hanging[SL_HANGING_MOST];
    sl_patch_place place = sl_patch_place_of(p, leaf);
    sl_status status = SL_OK;
    for (int e = 0; e < place.corners && status == SL_OK; e++) {
        size_t count = sl_patch_hanging(p, &place, e, hanging, SL_HANGING_MOST);
        status = lend_or_wait(p, sl_patch_corner(p, leaf, e), error);
        for (size_t i = 0; i < count && status == SL_OK; i++) status = lend_or_wait(p, hanging[i], error);
    }
    return status;
}

/* Lenders have light of their own, so the order does not matter. */
sl_status sl_patches_lend(sl_patches *p, sl_error *error) {
    sl_status status = SL_OK;
    if (!p->borrowing) return SL_OK;
    lend_to_waiting(p);
    for (uint32_t i = 0; i < p->patch_count && status == SL_OK; i++) {
        if ((p->flags[i] & SL_PATCH_DIRTY) && sl_patch_is_alive(p, i) && sl_patch_is_leaf(p, i))
            status = lend_to_leaf(p, i, error);
    }
    return status;
}
