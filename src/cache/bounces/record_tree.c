/* An octree over the records' spheres. Leaves are cells of space with the records that reach into them,
 * sixteen side by side, ready for the look-up. */
#include "cache/bounces/second_level.h"

#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"

/* A split that lists the records more often than this many times, all children together, is none. */
enum { MOST_COPIES = 3 };

typedef struct {
    const sl_second_list *list;
    sl_record_tree *tree;
    size_t leaf_records;
    float accuracy; /* reach = accuracy * R, widened */
    uint32_t *stack; /* lists of the nodes on the way down */
    size_t stack_count, stack_capacity;
} builder;

/* `array` as in sl_regrow(). */
static bool reserve(void *array, size_t count, size_t *capacity, size_t wanted, size_t size) {
    if (wanted <= *capacity) return true;
    size_t larger = 2 * *capacity > wanted ? 2 * *capacity : wanted + 64;
    if (!sl_regrow(array, count, larger, size)) return false;
    *capacity = larger;
    return true;
}

static bool reserve_nodes(sl_record_tree *t, size_t more) {
    return reserve(&t->nodes, t->node_count, &t->node_capacity, t->node_count + more, sizeof *t->nodes);
}

static bool reserve_blocks(sl_record_tree *t, size_t more) {
    return reserve(&t->blocks, t->block_count, &t->block_capacity, t->block_count + more, sizeof *t->blocks);
}

static bool reserve_stack(builder *b, size_t more) {
    return reserve(&b->stack, b->stack_count, &b->stack_capacity, b->stack_count + more, sizeof *b->stack);
}

/* Does the record reach into the cube? A little is added for the rounding of both. */
static bool reaches(const builder *b, uint32_t record, sl_vec3 low, float side) {
    const sl_record *r = &b->list->records[record];
    const float p[3] = {r->position.x, r->position.y, r->position.z}, l[3] = {low.x, low.y, low.z};
    float reach = b->accuracy * r->radius * b->tree->widen * 1.00001f + 1e-3f * b->tree->cell, squared = 0.0f;
    for (int c = 0; c < 3; c++) {
        float below = l[c] - p[c], above = p[c] - (l[c] + side);
        float gap = below > above ? below : above;
        if (gap > 0.0f) squared += gap * gap;
    }
    return squared <= reach * reach;
}

static void fill_block(const builder *b, const uint32_t *records, size_t count, sl_tree_block *block) {
    memset(block, 0, sizeof *block);
    for (size_t l = 0; l < SL_TREE_LANES; l++) {
        block->reach_squared[l] = -1.0f;
        if (l >= count) continue;
        const sl_record_terms *k = &b->list->terms[records[l]];
        block->x[l] = k->position.x, block->y[l] = k->position.y, block->z[l] = k->position.z;
        block->normal_x[l] = k->normal.x, block->normal_y[l] = k->normal.y, block->normal_z[l] = k->normal.z;
        block->inverse_radius[l] = k->inverse_radius;
        block->reach_squared[l] = k->reach_squared;
        block->front[l] = k->front;
        block->behind[l] = k->behind;
        block->record[l] = records[l] | (b->list->records[records[l]].behind_a_wall ? SL_TREE_WALLS : 0u);
    }
}

static bool make_leaf(builder *b, size_t node, size_t from, size_t count) {
    sl_record_tree *t = b->tree;
    size_t blocks = (count + SL_TREE_LANES - 1) / SL_TREE_LANES;
    if (!reserve_blocks(t, blocks)) return false;
    t->nodes[node] = (sl_tree_node){(uint32_t)t->block_count, (uint32_t)blocks};
    for (size_t i = 0; i < blocks; i++) {
        size_t left = count - i * SL_TREE_LANES;
        fill_block(b, b->stack + from + i * SL_TREE_LANES,
                   left < SL_TREE_LANES ? left : (size_t)SL_TREE_LANES, &t->blocks[t->block_count++]);
    }
    return true;
}

static sl_vec3 corner_of(sl_vec3 low, float half, unsigned child) {
    return sl_v3(low.x + (child & 1u ? half : 0.0f), low.y + (child & 2u ? half : 0.0f),
                 low.z + (child & 4u ? half : 0.0f));
}

/* The node's list is stack[from .. from + count). */
static bool build(builder *b, size_t node, size_t from, size_t count, sl_vec3 low, float side, int level) {
    sl_record_tree *t = b->tree;
    float half = 0.5f * side;
    if (count <= b->leaf_records || level == 0) return make_leaf(b, node, from, count);
    size_t copies = 0;
    for (unsigned child = 0; child < 8; child++) {
        sl_vec3 corner = corner_of(low, half, child);
        for (size_t i = 0; i < count; i++) copies += reaches(b, b->stack[from + i], corner, half);
    }
    if (copies > MOST_COPIES * count) return make_leaf(b, node, from, count);
    size_t first = t->node_count;
    if (!reserve_nodes(t, 8)) return false;
    t->node_count += 8;
    t->nodes[node] = (sl_tree_node){(uint32_t)first, SL_NO_INDEX};
    for (unsigned child = 0; child < 8; child++) {
        sl_vec3 corner = corner_of(low, half, child);
        size_t start = b->stack_count;
        if (!reserve_stack(b, count)) return false;
        for (size_t i = 0; i < count; i++) {
            uint32_t record = b->stack[from + i];
            if (reaches(b, record, corner, half)) b->stack[b->stack_count++] = record;
        }
        if (!build(b, first + child, start, b->stack_count - start, corner, half, level - 1)) return false;
        b->stack_count = start;
    }
    return true;
}

sl_status sl_record_tree_build(const sl_scene *scene, const sl_second_list *list, float widen,
                               size_t leaf_records, sl_record_tree *tree, sl_error *error) {
    sl_vec3 extent = sl_sub(scene->box_max, scene->box_min);
    float side = extent.x > extent.y ? extent.x : extent.y;
    side = 1.001f * (side > extent.z ? side : extent.z);
    sl_record_tree_free(tree);
    tree->low = sl_sub(scene->box_min, sl_scale(sl_v3(side, side, side), 5e-4f));
    tree->cell = side / (float)(1 << SL_TREE_LEVELS);
    tree->cells_per_length = 1.0f / tree->cell;
    tree->widen = widen;
    tree->records = list->count;
    builder b = {.list = list, .tree = tree, .leaf_records = leaf_records,
                 .accuracy = list->count ? list->terms[0].accuracy : 0.0f};
    bool done = reserve_nodes(tree, 1) && reserve_stack(&b, list->count);
    if (done) {
        tree->node_count = 1;
        for (size_t i = 0; i < list->count; i++) b.stack[i] = (uint32_t)i;
        b.stack_count = list->count;
        done = build(&b, 0, 0, list->count, tree->low, side, SL_TREE_LEVELS);
    }
    sl_free(b.stack);
    if (done) return SL_OK;
    sl_record_tree_free(tree);
    return sl_fail_memory(error, "the second-level records' tree");
}

void sl_record_tree_free(sl_record_tree *tree) {
    sl_free(tree->nodes);
    sl_free(tree->blocks);
    *tree = (sl_record_tree){0};
}

size_t sl_record_tree_bytes(const sl_record_tree *tree) {
    return tree->node_capacity * sizeof *tree->nodes + tree->block_capacity * sizeof *tree->blocks;
}
