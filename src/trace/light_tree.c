#include "trace/light_tree.h"

#include <math.h>
#include <stdlib.h>

#include "base/error.h"
#include "base/memory.h"

enum { LEAF_EMITTERS = 12 };

typedef struct tree_emitter {
    sl_vec3 centre, normal;
    float strength;                 /* mean radiance times area */
    float extent_squared;           /* largest squared distance of a corner from the centroid */
    bool two_sided;
} tree_emitter;

typedef struct node {
    sl_vec3 centre;
    float radius, strength;
    uint32_t first, count; /* its emitters, in the tree's order */
    uint32_t right;        /* the left child is the next node; 0: a leaf */
} node;

struct sl_light_tree {
    tree_emitter *emitters;      /* in the scene's order */
    uint32_t *order;        /* emitters as the leaves hold them */
    node *nodes;
    uint32_t node_count;
};

/* ---- emitters ---- */

static tree_emitter emitter_of(const sl_scene *scene, const sl_emitter *e) {
    sl_vec3 corner[3];
    for (int c = 0; c < 3; c++) corner[c] = sl_scene_position(scene, scene->vertex[c][e->triangle]);
    tree_emitter out = {.centre = sl_scale(sl_add(sl_add(corner[0], corner[1]), corner[2]), 1.0f / 3.0f),
                   .normal = sl_scene_geometric_normal(scene, e->triangle),
                   .strength = sl_rgb_mean(e->radiance) * e->area,
                   .two_sided = e->two_sided};
    for (int c = 0; c < 3; c++) {
        sl_vec3 d = sl_sub(corner[c], out.centre);
        out.extent_squared = fmaxf(out.extent_squared, sl_dot(d, d));
    }
    return out;
}

/* Returns how much an emitter can matter at a point: strength, cosines and distance of its centroid, each
 * kept from vanishing where some part of the emitter may still contribute; 0 where none can. */
static float importance_of(const tree_emitter *e, sl_vec3 position, sl_vec3 normal) {
    sl_vec3 d = sl_sub(e->centre, position);
    float squared = sl_dot(d, d), extent = e->extent_squared;
    float bounded = squared > extent ? squared : extent;
    float over = bounded > 0.0f ? 1.0f / sqrtf(bounded) : 0.0f;
    float above = sl_dot(normal, d), front = -sl_dot(e->normal, d);
    if (e->two_sided) front = fabsf(front);
    if (!(front > 0.0f) || above * fabsf(above) < -extent) return 0.0f;
    float cosine = above * over, cosine_emitter = front * over;
    cosine = cosine > 0.1f ? cosine : 0.1f;
    cosine_emitter = cosine_emitter > 0.1f ? cosine_emitter : 0.1f;
    return e->strength * cosine * cosine_emitter * over * over;
}

/* ---- building: halves along the longest axis of the centroids ---- */

typedef struct sorted_emitter {
    float place;
    uint32_t emitter;
} sorted_emitter;

static int by_place(const void *a, const void *b) {
    const sorted_emitter *x = a, *y = b;
    if (x->place != y->place) return x->place < y->place ? -1 : 1;
    return x->emitter < y->emitter ? -1 : x->emitter > y->emitter;
}

static float along_axis(sl_vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static void bound(const sl_light_tree *tree, node *n, sl_vec3 *extent) {
    sl_box box = sl_box_empty();
    for (uint32_t k = n->first; k < n->first + n->count; k++) {
        const tree_emitter *e = &tree->emitters[tree->order[k]];
        sl_box_add(&box, e->centre);
        n->strength += e->strength;
    }
    *extent = sl_sub(box.high, box.low);
    n->centre = sl_scale(sl_add(box.low, box.high), 0.5f);
    for (uint32_t k = n->first; k < n->first + n->count; k++) {
        const tree_emitter *e = &tree->emitters[tree->order[k]];
        n->radius = fmaxf(n->radius, sl_length(sl_sub(e->centre, n->centre)) + sqrtf(e->extent_squared));
    }
}

static void sort_along(const sl_light_tree *tree, const node *n, sl_vec3 extent, sorted_emitter *scratch) {
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    for (uint32_t k = 0; k < n->count; k++) {
        uint32_t e = tree->order[n->first + k];
        scratch[k] = (sorted_emitter){along_axis(tree->emitters[e].centre, axis), e};
    }
    qsort(scratch, n->count, sizeof *scratch, by_place);
    for (uint32_t k = 0; k < n->count; k++) tree->order[n->first + k] = scratch[k].emitter;
}

static uint32_t build(sl_light_tree *tree, uint32_t first, uint32_t count, sorted_emitter *scratch) {
    uint32_t index = tree->node_count++;
    node n = {.first = first, .count = count};
    sl_vec3 extent;
    bound(tree, &n, &extent);
    if (count > LEAF_EMITTERS) {
        sort_along(tree, &n, extent, scratch);
        build(tree, first, count / 2, scratch);
        n.right = build(tree, first + count / 2, count - count / 2, scratch);
    }
    tree->nodes[index] = n;
    return index;
}

sl_status sl_light_tree_create(const sl_scene *scene, sl_light_tree **out, sl_error *error) {
    size_t count = scene->emitter_count;
    *out = NULL;
    sl_light_tree *tree = sl_allocate(1, sizeof *tree);
    if (!tree) return sl_fail_memory(error, "the light tree");
    sorted_emitter *scratch = sl_allocate(count, sizeof *scratch);
    tree->emitters = sl_allocate(count, sizeof *tree->emitters);
    tree->order = sl_allocate(count, sizeof *tree->order);
    tree->nodes = sl_allocate(2 * count, sizeof *tree->nodes);
    sl_status status = scratch && tree->emitters && tree->order && tree->nodes
                           ? SL_OK : sl_fail_memory(error, "the light tree");
    if (status == SL_OK) {
        for (uint32_t i = 0; i < count; i++) {
            tree->order[i] = i;
            tree->emitters[i] = emitter_of(scene, &scene->emitters[i]);
        }
        build(tree, 0, (uint32_t)count, scratch);
        *out = tree;
    } else {
        sl_light_tree_destroy(tree);
    }
    sl_free(scratch);
    return status;
}

void sl_light_tree_destroy(sl_light_tree *tree) {
    if (!tree) return;
    SL_FREE_ALL(tree->emitters, tree->order, tree->nodes, tree);
}

/* ---- choosing ---- */

/* Strength over squared distance, from within the sphere as from its surface, times what the receiver's
 * cosine can be at most; 0 where all of the sphere lies below the horizon. */
static float importance(const node *n, sl_vec3 position, sl_vec3 normal) {
    sl_vec3 d = sl_sub(n->centre, position);
    float squared = sl_dot(d, d), inside = n->radius * n->radius, above = sl_dot(normal, d) + n->radius;
    if (!(above > 0.0f)) return 0.0f;
    squared = squared > inside ? squared : inside;
    float over = squared > 0.0f ? 1.0f / sqrtf(squared) : 0.0f, cosine = above * over;
    return n->strength * over * over * (cosine < 1.0f ? cosine : 1.0f);
}

/* Of going left; both sides 0: none. */
static bool left_share(const sl_light_tree *tree, const node *n, sl_vec3 position, sl_vec3 normal,
                       float *share) {
    float left = importance(n + 1, position, normal),
          right = importance(&tree->nodes[n->right], position, normal);
    float sum = left + right;
    *share = left / sum;
    return sum > 0.0f && isfinite(sum);
}

static float leaf_weights(const sl_light_tree *tree, const node *n, sl_vec3 position, sl_vec3 normal,
                          float weight[LEAF_EMITTERS]) {
    float sum = 0.0f;
    for (uint32_t k = 0; k < n->count; k++)
        sum += weight[k] = importance_of(&tree->emitters[tree->order[n->first + k]], position, normal);
    return sum > 0.0f && isfinite(sum) ? sum : 0.0f;
}

bool sl_light_tree_choose(const sl_light_tree *tree, sl_vec3 position, sl_vec3 normal, float u,
                          uint32_t *emitter, float *chance) {
    const node *n = tree->nodes;
    float way = 1.0f, share, weight[LEAF_EMITTERS];
    while (n->right) {
        if (!left_share(tree, n, position, normal, &share)) return false;
        bool left = u < share;
        u = left ? u / share : (u - share) / (1.0f - share);
        u = u < 0x1.fffffep-1f ? u : 0x1.fffffep-1f;
        way *= left ? share : 1.0f - share;
        n = left ? n + 1 : &tree->nodes[n->right];
    }
    float sum = leaf_weights(tree, n, position, normal, weight), target = u * sum;
    if (!(sum > 0.0f)) return false;
    uint32_t chosen = 0;
    for (uint32_t k = 0; k < n->count; k++) { /* the last one that has weight, if rounding leads beyond all */
        if (weight[k] > 0.0f) chosen = k;
        if (target < weight[k]) break;
        target -= weight[k];
    }
    *emitter = tree->order[n->first + chosen];
    *chance = way * (weight[chosen] / sum);
    return *chance > 0.0f;
}
