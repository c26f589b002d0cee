/* Voxels split by normal, which the paper does not do: a voxel at an edge holds surfaces that see different
 * light. */
#ifndef SL_CACHE_LIGHT_OCTREE_NORMAL_GROUPS_H
#define SL_CACHE_LIGHT_OCTREE_NORMAL_GROUPS_H

#include "cache/light_octree/octree.h"
#include "cache/light_octree/voxel_lights.h"

typedef struct sl_normal_group {
    sl_vec3 normal, centroid; /* by area, of what lies in the voxel */
    float area;
    bool flat;                /* one shading normal, and it reflects light of all directions alike */
} sl_normal_group;

/* What lies in a voxel, triangle by triangle; a worker's scratch. */
typedef struct sl_voxel_piece {
    sl_vec3d normal, moment; /* unit; area times position, in cells about the voxel's first corner */
    double area;
    int group;
    bool flat;               /* as of groups */
} sl_voxel_piece;

/* Greedy: the largest piece not yet in a group starts one, and all within 45 degrees of it join that lie at
 * about its height: a floor and the ground below it see different light. What is left after
 * SL_VOXEL_SETS_MAX, and groups below a hundredth of the area, go to the nearest. Returns how many, largest
 * first seed first; 0 where nothing has an area. */
int sl_normal_groups(const sl_cell_space *space, const sl_octree *octree, size_t index,
                     sl_voxel_piece *pieces, sl_normal_group groups[SL_VOXEL_SETS_MAX]);
/* The most pieces that a leaf has. */
size_t sl_voxel_pieces_max(const sl_octree *octree);

#endif
