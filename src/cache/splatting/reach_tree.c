#include "cache/splatting/record.h"

#include <math.h>

#include "base/error.h"
#include "base/grow.h"

static unsigned octant_of(sl_vec3 centre, sl_vec3 p) {
    return (unsigned)(p.x >= centre.x) | (unsigned)(p.y >= centre.y) << 1 | (unsigned)(p.z >= centre.z) << 2;
}

static void widen(sl_reach_node *n, sl_vec3 p, float radius) {
    n->low = sl_v3(fminf(n->low.x, p.x), fminf(n->low.y, p.y), fminf(n->low.z, p.z));
    n->high = sl_v3(fmaxf(n->high.x, p.x), fmaxf(n->high.y, p.y), fmaxf(n->high.z, p.z));
    n->least = fminf(n->least, radius);
}

sl_status sl_reach_tree_insert(sl_reach_tree *tree, sl_vec3 position, float radius, sl_error *error) {
    if (!sl_make_room(&tree->nodes, tree->count, &tree->capacity, sizeof *tree->nodes))
        return sl_fail_memory(error, "records' reaches");
    uint32_t *link = NULL;
    for (uint32_t index = 0; index < tree->count; index = *link) {
        sl_reach_node *n = &tree->nodes[index];
        widen(n, position, radius);
        if (n->position.x == position.x && n->position.y == position.y && n->position.z == position.z) {
            n->radius = fminf(n->radius, radius); /* the smaller one answers for both */
            return SL_OK;
        }
        link = &n->child[octant_of(n->position, position)];
        if (!*link) break;
    }
    if (link) *link = (uint32_t)tree->count;
    tree->nodes[tree->count++] = (sl_reach_node){
        .position = position, .radius = radius, .least = radius, .low = position, .high = position};
    return SL_OK;
}

/* ---- the question ---- */

/* Returns at most the distance from p to anything in the box: rounding is paid for. */
static float distance_to_box(const sl_reach_node *n, sl_vec3 p) {
    return 0.9999f * sl_length(sl_outside_box(n->low, n->high, p));
}

static float limit_below(const sl_reach_tree *tree, uint32_t index, sl_vec3 p, float radius) {
    const sl_reach_node *n = &tree->nodes[index];
    if (!(n->least < radius) || !(n->least + distance_to_box(n, p) < radius)) return radius;
    radius = fminf(radius, n->radius + sl_length(sl_sub(p, n->position)));
    const unsigned nearest = octant_of(n->position, p); /* first, as it says most */
    for (unsigned k = 0; k < 8; k++) {
        if (n->child[nearest ^ k]) radius = limit_below(tree, n->child[nearest ^ k], p, radius);
    }
    return radius;
}

float sl_reach_tree_limit(const sl_reach_tree *tree, sl_vec3 position, float radius) {
    return tree->count ? limit_below(tree, 0, position, radius) : radius;
}
