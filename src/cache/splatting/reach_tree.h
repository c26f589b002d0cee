/* Neighbour clamping asks of every record for the least R_j + |p - p_j| over all others (rule 5 of record.h).
 * Among n records that is n questions to n of them; an octree whose cells know the least R_j in them answers
 * each by looking at a few. */
#ifndef SL_CACHE_SPLATTING_REACH_TREE_H
#define SL_CACHE_SPLATTING_REACH_TREE_H

#include <stddef.h>

#include "base/vec.h"
#include "softlux.h"

typedef struct sl_reach_tree sl_reach_tree;

sl_status sl_reach_tree_create(sl_reach_tree **tree, sl_error *error);
void sl_reach_tree_destroy(sl_reach_tree *tree);
void sl_reach_tree_clear(sl_reach_tree *tree);
size_t sl_reach_tree_bytes(const sl_reach_tree *tree);
/* As many as a new tree has once it has these points: the same for the same points in the same order,
 * whatever was in this one before. */
size_t sl_reach_tree_bytes_of_points(const sl_reach_tree *tree);
sl_status sl_reach_tree_insert(sl_reach_tree *tree, sl_vec3 position, float radius, sl_error *error);
/* The least of `radius` and all R_j + |p - p_j|: the same bits in whatever order the points came. Thread-safe
 * between insertions. */
float sl_reach_tree_limit(const sl_reach_tree *tree, sl_vec3 position, float radius);

#endif
