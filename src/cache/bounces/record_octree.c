/* Ward's octree of records (second_level.h), grown record by record. */
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "cache/bounces/second_level.h"

static bool reserve_node(sl_record_octree *t) {
    return sl_make_room(&t->nodes, t->node_count, &t->node_capacity, sizeof *t->nodes);
}

static bool reserve_block(sl_record_octree *t) {
    return sl_make_room(&t->blocks, t->block_count, &t->block_capacity, sizeof *t->blocks);
}

static bool start(const sl_scene *scene, sl_record_octree *t) {
    const sl_vec3 extent = sl_sub(scene->box_max, scene->box_min);
    float side = extent.x > extent.y ? extent.x : extent.y;
    side = 1.001f * (side > extent.z ? side : extent.z);
    t->low = sl_sub(scene->box_min, sl_scale(sl_v3(side, side, side), 5e-4f));
    t->side = side;
    t->cells_per_length = (float)(1 << SL_OCTREE_LEVELS) / side;
    if (!reserve_node(t) || !reserve_block(t)) return false;
    t->nodes[t->node_count++] = (sl_record_node){.first = 0};
    t->blocks[t->block_count++] = (sl_record_block){.count = 0};
    return true;
}

/* ---- one record in one cell ---- */

static bool append_block(sl_record_octree *t, uint32_t node) {
    if (!reserve_block(t)) return false;
    const uint32_t index = (uint32_t)t->block_count++;
    sl_record_node *n = &t->nodes[node];
    t->blocks[index] = (sl_record_block){.count = 0};
    for (int l = 0; l < SL_OCTREE_LANES; l++) t->blocks[index].reach_squared[l] = -1.0f;
    if (n->last) t->blocks[n->last].next = index;
    else n->first = index;
    n->last = index;
    return true;
}

static bool append(sl_record_octree *t, uint32_t node, const sl_record_terms *k, uint32_t record) {
    const uint32_t last = t->nodes[node].last;
    if ((!last || t->blocks[last].count == SL_OCTREE_LANES) && !append_block(t, node)) return false;
    sl_record_block *b = &t->blocks[t->nodes[node].last];
    const uint32_t l = b->count++;
    b->x[l] = k->position.x, b->y[l] = k->position.y, b->z[l] = k->position.z;
    b->normal_x[l] = k->normal.x, b->normal_y[l] = k->normal.y, b->normal_z[l] = k->normal.z;
    b->inverse_radius[l] = k->inverse_radius;
    b->reach_squared[l] = k->reach_squared;
    b->front[l] = k->front;
    b->behind[l] = k->behind;
    b->record[l] = record;
    return true;
}

/* ---- which cells ---- */

static bool reaches(const sl_record_terms *k, float reach, sl_vec3 low, float side) {
    const sl_vec3 d = sl_outside_box((sl_box){low, sl_add(low, sl_v3(side, side, side))}, k->position);
    return sl_dot(d, d) <= reach * reach;
}

static sl_vec3 corner_of(sl_vec3 low, float half, unsigned octant) {
    return sl_v3(low.x + (octant & 1u ? half : 0.0f), low.y + (octant & 2u ? half : 0.0f),
                 low.z + (octant & 4u ? half : 0.0f));
}

static bool insert(sl_record_octree *t, uint32_t node, sl_vec3 low, float side, int level,
                   const sl_record_terms *k, float reach, uint32_t record) {
    const float half = 0.5f * side;
    if (side <= reach || level == 0) return append(t, node, k, record);
    for (unsigned octant = 0; octant < 8; octant++) {
        const sl_vec3 corner = corner_of(low, half, octant);
        if (!reaches(k, reach, corner, half)) continue;
        if (!t->nodes[node].child[octant]) {
            if (!reserve_node(t)) return false;
            t->nodes[node].child[octant] = (uint32_t)t->node_count;
            t->nodes[t->node_count++] = (sl_record_node){.first = 0};
        }
        if (!insert(t, t->nodes[node].child[octant], corner, half, level - 1, k, reach, record)) return false;
    }
    return true;
}

sl_status sl_record_octree_insert(const sl_scene *scene, const sl_record_terms *terms, uint32_t record,
                                  sl_record_octree *octree, sl_error *error) {
    bool done = octree->node_count > 0 || start(scene, octree);
    /* A little is added for the rounding of both. */
    const float reach = 1.00001f * sqrtf(terms->reach_squared) + 1e-3f / octree->cells_per_length;
    done = done && insert(octree, 0, octree->low, octree->side, SL_OCTREE_LEVELS, terms, reach, record);
    return done ? SL_OK : sl_fail_memory(error, "the second-level records' octree");
}

void sl_record_octree_free(sl_record_octree *octree) {
    SL_FREE_ALL(octree->nodes, octree->blocks);
    *octree = (sl_record_octree){0};
}
