/* Vertices without light of their own: inside other geometry, where a table leg stands on the floor, or where no number came. What they show is borrowed from the corners
 * of the leaves around them that have light, the nearer the more (1/d^2, Shepard 1968; a corner of two leaves counts twice), or, where none of these has any, from those
 * of their parents, and so on upwards. So a leaf that is half under the leg shows on its other half what is beside it, and where the leg begins is for splits to find: what such a leaf
 * shows may be wrong by all of it (sl_patch_error()), down to the size at which nothing is split any more. */
#include <string.h>

#include "base/math.h"
#include "cache/shading_cache/patch_parts.h"

void sl_patches_borrow(sl_patches *p, uint32_t vertex) {
    p->vertex[vertex].borrowed = 1;
    p->borrowing = true;
}

/* ---- lenders ------------------------------------------------------------------------------------------------------------------- */

typedef struct loan {
    uint32_t vertex;           /* that borrows */
    int above;                 /* from patches so many levels above the leaves around it */
    sl_vec3 position;
    double weight, value[3], lobe[3];
} loan;

static void borrow_from(const sl_patches *p, loan *to, uint32_t lender) {
    const sl_patch_vertex *v = &p->vertex[lender];
    if (v->evaluated == SL_VERTEX_NEVER || v->borrowed || lender == to->vertex) return;
    sl_vec3d apart = sl_subd(sl_to_double(sl_root_position(p->primitives, v->root, v->u, v->v)), sl_to_double(to->position));
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
    for (int c = 0; patch != SL_NO_INDEX && c < sl_patch_corners(p, patch); c++) borrow_from(p, to, sl_patch_corner(p, patch, c));
}

/* Nobody has anything: what is there stays. */
static void lend_to(sl_patches *p, uint32_t vertex) {
    sl_patch_vertex *v = &p->vertex[vertex];
    loan l = {.vertex = vertex, .position = sl_root_position(p->primitives, v->root, v->u, v->v)};
    for (; !(l.weight > 0.0) && l.above <= SL_PATCH_DEPTH_MAX; l.above++) sl_patches_visit_around(p, sl_vertex_place(v), borrow_from_patch, &l);
    if (!(l.weight > 0.0)) return;
    float *lobe = sl_vertex_lobe(p, vertex);
    for (int c = 0; c < 3; c++) v->value[c] = (float)(l.value[c] / l.weight);
    for (int c = 0; lobe && c < 3; c++) lobe[c] = (float)(l.lobe[c] / l.weight);
}

/* Lenders have light of their own, so the order does not matter. */
void sl_patches_lend(sl_patches *p) {
    if (!p->borrowing) return;
    for (uint32_t i = 0; i < p->patch_count; i++) {
        if (!(p->flags[i] & SL_PATCH_DIRTY) || !sl_patch_is_alive(p, i) || !sl_patch_is_leaf(p, i)) continue;
        for (int c = 0; c < sl_patch_corners(p, i); c++) {
            uint32_t vertex = sl_patch_corner(p, i, c);
            if (p->vertex[vertex].borrowed) lend_to(p, vertex);
        }
    }
}
