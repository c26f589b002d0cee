/* Neighbour clamping asks of every record for the least R_j + |p - p_j| over all others (rule 5 of record.h).
 * An octree whose nodes hold one record each, and know the least R_j below, answers by looking at a few. */
#ifndef SL_CACHE_SPLATTING_REACH_TREE_H
#define SL_CACHE_SPLATTING_REACH_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"
#include "softlux.h"

typedef struct sl_reach_node {
    sl_vec3 position;
    float radius, least; /* of the node's own record; of all at and below it */
    sl_vec3 low, high;   /* the box of those */
    uint32_t child[8];   /* by octant about the position; 0: none, as the root is no child */
} sl_reach_node;

/* {0} is empty. */
typedef struct sl_reach_tree {
    sl_reach_node *nodes;
    size_t count, capacity;
} sl_reach_tree;

sl_status sl_reach_tree_insert(sl_reach_tree *tree, sl_vec3 position, float radius, sl_error *error);
/* Returns the least of `radius` and all R_j + |p - p_j|: the same bits in whatever order the points came.
 * Thread-safe between insertions. */
float sl_reach_tree_limit(const sl_reach_tree *tree, sl_vec3 position, float radius);

#endif
