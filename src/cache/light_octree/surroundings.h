/* The scene's triangles around a voxel, found through the octree: over which area the photons of an ellipsoid
 * were strewn. */
#ifndef SL_CACHE_LIGHT_OCTREE_SURROUNDINGS_H
#define SL_CACHE_LIGHT_OCTREE_SURROUNDINGS_H

#include "cache/light_octree/octree.h"
#include "cache/light_octree/photon_area.h"
#include "cache/light_octree/surfel_kernels.h"

/* The octree's inner nodes, which leaves in Morton order alone do not have. Immutable.
 *
 * A fine mesh has thousands of triangles in an ellipsoid: those whose edges are at most small_edge count as
 * points, whole or not at all, in the leaf that their centroid lies in, unless the ellipsoid is thinner than
 * they; all others are cut exactly. */
typedef struct sl_surroundings {
    const sl_scene *scene;
    const sl_octree *octree;                            /* with triangles */
    double small_edge;
    uint32_t *triangle;     /* the octree's list, in each leaf the large ones first */
    uint32_t *end_of_large; /* where they end there: leaf_count */
    sl_surfels surfels;     /* leaf by leaf */
    size_t surfel_count;
    uint32_t *first_surfel; /* of each leaf: leaf_count + 1 */
    sl_surfel_kernel *kernel;
    size_t count[SL_OCTREE_DEPTH_MAX + 1];              /* nodes of each level; level 0: the root */
    uint32_t *code[SL_OCTREE_DEPTH_MAX + 1];            /* their Morton codes, ascending */
    uint32_t *first_child[SL_OCTREE_DEPTH_MAX + 1];     /* count + 1, in the next level */
} sl_surroundings;

/* small_edge 0: none is small. */
sl_status sl_surroundings_create(const sl_scene *scene, const sl_octree *octree, double small_edge,
                                 unsigned threads, sl_surroundings **surroundings, sl_error *error);
void sl_surroundings_destroy(sl_surroundings *surroundings);
size_t sl_surroundings_bytes(const sl_surroundings *surroundings);

/* Which triangles were met already in this query: one for each worker. */
typedef struct sl_surroundings_marks {
    uint32_t *mark; /* a triangle's last query */
    uint32_t query;
} sl_surroundings_marks;

/* Areas within the ellipsoid of triangles with n_t . n >= least_cosine, and with -n_t . n >= it; of layers
 * that hide each other, one. sheet: they are the same sheets, to be seen from both sides, and not the two
 * faces of a wall: then each side's area is that of both. flat: the same projected along the ellipsoid's
 * normal, on its disc; 0 without a normal. */
typedef struct sl_strewn_area {
    double front, back;
    bool sheet;
    double front_flat, back_flat;
} sl_strewn_area;

/* A zero normal: all triangles, as front. */
sl_strewn_area sl_surroundings_area(const sl_surroundings *surroundings, const sl_ellipsoid *ellipsoid,
                                    double least_cosine, sl_surroundings_marks *marks);

#endif
