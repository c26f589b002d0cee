#include "cache/splatting/reach_tree.h"

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"

enum { LEAF_POINTS = 8, DEPTH_MAX = 24, NONE = 0, ROOM_AT_FIRST = 1024 };

typedef struct {
    sl_vec3 position;
    float radius;
    uint32_t next; /* of the same leaf, plus 1; NONE: the last */
} point;

typedef struct {
    sl_vec3 low, high; /* the box of the points below */
    float least;       /* of their radii */
    sl_vec3 centre;    /* where children meet */
    uint32_t children; /* the first of eight; NONE: a leaf (the root is nobody's child) */
    uint32_t points;   /* the first of a leaf's, plus 1 */
    uint32_t count;
} node;

struct sl_reach_tree {
    node *nodes;
    size_t node_count, node_capacity;
    point *points;
    size_t point_count, point_capacity;
};

static const node empty = {
    .low = {INFINITY, INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY, -INFINITY}, .least = INFINITY};

sl_status sl_reach_tree_create(sl_reach_tree **out, sl_error *error) {
    *out = NULL;
    sl_reach_tree *tree = sl_allocate(1, sizeof *tree);
    if (!tree) return sl_fail_memory(error, "records' reaches");
    tree->node_capacity = ROOM_AT_FIRST;
    tree->nodes = sl_allocate(tree->node_capacity, sizeof *tree->nodes);
    if (!tree->nodes) {
        sl_reach_tree_destroy(tree);
        return sl_fail_memory(error, "records' reaches");
    }
    sl_reach_tree_clear(tree);
    *out = tree;
    return SL_OK;
}

void sl_reach_tree_destroy(sl_reach_tree *tree) {
    if (!tree) return;
    sl_free(tree->nodes);
    sl_free(tree->points);
    sl_free(tree);
}

void sl_reach_tree_clear(sl_reach_tree *tree) {
    tree->point_count = 0;
    tree->node_count = 1;
    tree->nodes[0] = empty;
}

size_t sl_reach_tree_bytes(const sl_reach_tree *tree) {
    return sizeof *tree + tree->node_capacity * sizeof *tree->nodes +
           tree->point_capacity * sizeof *tree->points;
}

static size_t room_for(size_t count) {
    size_t room = ROOM_AT_FIRST;
    while (room < count) room *= 2;
    return room;
}

size_t sl_reach_tree_bytes_of_points(const sl_reach_tree *tree) {
    if (!tree->point_count) return 0;
    return sizeof *tree + room_for(tree->node_count) * sizeof *tree->nodes +
           room_for(tree->point_count) * sizeof *tree->points;
}

/* ---- insertion ---- */

/* Twice the room where what is wanted, a few more, does not fit; `array` as in sl_regrow(). */
static bool make_room(void *array, size_t count, size_t wanted, size_t *capacity, size_t size) {
    if (wanted <= *capacity) return true;
    size_t larger = *capacity ? 2 * *capacity : ROOM_AT_FIRST;
    if (!sl_regrow(array, count, larger, size)) return false;
    *capacity = larger;
    return true;
}

static unsigned octant_of(sl_vec3 centre, sl_vec3 p) {
    return (unsigned)(p.x >= centre.x) | (unsigned)(p.y >= centre.y) << 1 | (unsigned)(p.z >= centre.z) << 2;
}

static sl_vec3 least_of(sl_vec3 a, sl_vec3 b) {
    return sl_v3(fminf(a.x, b.x), fminf(a.y, b.y), fminf(a.z, b.z));
}
static sl_vec3 most_of(sl_vec3 a, sl_vec3 b) {
    return sl_v3(fmaxf(a.x, b.x), fmaxf(a.y, b.y), fmaxf(a.z, b.z));
}

static void widen(node *n, const point *p) {
    n->low = least_of(n->low, p->position);
    n->high = most_of(n->high, p->position);
    n->least = p->radius < n->least ? p->radius : n->least;
}

static void add_to_leaf(sl_reach_tree *tree, node *leaf, uint32_t index) {
    tree->points[index].next = leaf->points;
    leaf->points = index + 1;
    leaf->count++;
}

/* A full leaf hands its points to eight children, which meet in the middle of its box. */
static bool split(sl_reach_tree *tree, uint32_t index) {
    if (!make_room(&tree->nodes, tree->node_count, tree->node_count + 8, &tree->node_capacity,
                   sizeof *tree->nodes))
        return false;
    node *n = &tree->nodes[index];
    uint32_t children = (uint32_t)tree->node_count, next = n->points;
    tree->node_count += 8;
    for (uint32_t c = 0; c < 8; c++) tree->nodes[children + c] = empty;
    n->centre = sl_scale(sl_add(n->low, n->high), 0.5f);
    while (next != NONE) {
        uint32_t p = next - 1;
        next = tree->points[p].next;
        node *child = &tree->nodes[children + octant_of(n->centre, tree->points[p].position)];
        widen(child, &tree->points[p]);
        add_to_leaf(tree, child, p);
    }
    n->children = children;
    n->points = NONE;
    return true;
}

sl_status sl_reach_tree_insert(sl_reach_tree *tree, sl_vec3 position, float radius, sl_error *error) {
    if (!make_room(&tree->points, tree->point_count, tree->point_count + 1, &tree->point_capacity,
                   sizeof *tree->points))
        return sl_fail_memory(error, "records' reaches");
    uint32_t added = (uint32_t)tree->point_count++, index = 0;
    tree->points[added] = (point){position, radius, NONE};
    for (int depth = 0;; depth++) {
        widen(&tree->nodes[index], &tree->points[added]);
        if (tree->nodes[index].children == NONE) {
            /* many may lie in one place */
            if (tree->nodes[index].count < LEAF_POINTS || depth == DEPTH_MAX) break;
            if (!split(tree, index)) return sl_fail_memory(error, "records' reaches");
        }
        index = tree->nodes[index].children + octant_of(tree->nodes[index].centre, position);
    }
    add_to_leaf(tree, &tree->nodes[index], added);
    return SL_OK;
}

/* ---- the question ---- */

static float outside(float low, float high, float x) {
    return x < low ? low - x : x > high ? x - high : 0.0f;
}

/* Not more than the distance from p to anything in the box: rounding is paid for. */
static float distance_to_box(const node *n, sl_vec3 p) {
    sl_vec3 d = sl_v3(outside(n->low.x, n->high.x, p.x), outside(n->low.y, n->high.y, p.y),
                      outside(n->low.z, n->high.z, p.z));
    return 0.9999f * sl_length(d);
}

static float limit_below(const sl_reach_tree *tree, uint32_t index, sl_vec3 p, float radius) {
    const node *n = &tree->nodes[index];
    if (!(n->least < radius) || !(n->least + distance_to_box(n, p) < radius)) return radius;
    if (n->children == NONE) {
        for (uint32_t next = n->points; next != NONE; next = tree->points[next - 1].next) {
            const point *q = &tree->points[next - 1];
            float reach = q->radius + sl_length(sl_sub(p, q->position));
            radius = reach < radius ? reach : radius;
        }
        return radius;
    }
    unsigned nearest = octant_of(n->centre, p); /* first, as it says most */
    for (unsigned k = 0; k < 8; k++) radius = limit_below(tree, n->children + (nearest ^ k), p, radius);
    return radius;
}

float sl_reach_tree_limit(const sl_reach_tree *tree, sl_vec3 position, float radius) {
    return limit_below(tree, 0, position, radius);
}
