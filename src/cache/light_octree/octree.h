/* The octree over the scene's geometry (section 2.8): a cell is split while it meets a triangle, down to a depth; leaves in Morton
 * order. A shallower octree is a cut of a deeper one. */
#ifndef SL_CACHE_LIGHT_OCTREE_OCTREE_H
#define SL_CACHE_LIGHT_OCTREE_OCTREE_H

#include "scene/scene.h"

/* 48 bytes. */
typedef struct sl_octree_leaf {
    uint64_t morton;        /* z y x interleaved, x lowest, at the octree's depth */
    sl_vec3 centroid;       /* c_v: by area, of the triangles clipped to the voxel */
    sl_vec3 normal;         /* n_v; (0,0,0) where |sum area n| < 0.2 sum area */
    float area;             /* of the clipped triangles; > 0 */
    uint32_t first_triangle; /* in the octree's list */
    uint32_t triangle_count;
} sl_octree_leaf;

typedef struct sl_octree {
    int depth;
    sl_vec3d origin;        /* lower corner of the root cube: the scene's box made cubic and enlarged by 1e-4 */
    double edge;            /* of the root cube */
    size_t leaf_count;
    sl_octree_leaf *leaf;
    size_t triangle_count;
    uint32_t *triangle;     /* leaf by leaf, ascending in each; empty (counts 0) in cuts */
} sl_octree;

/* dilate: voxels are grown by that fraction of their edge in the test (0: the paper's remedy is off). */
sl_status sl_octree_create(const sl_scene *scene, int depth, double dilate, unsigned threads, sl_octree **octree, sl_error *error);
sl_status sl_octree_cut(const sl_octree *octree, int depth, sl_octree **cut, sl_error *error);
void sl_octree_destroy(sl_octree *octree);
size_t sl_octree_bytes(const sl_octree *octree);
static inline double sl_octree_voxel(const sl_octree *octree) { return octree->edge / (double)(1u << octree->depth); }

#endif
