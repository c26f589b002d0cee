/* The octree over the scene's geometry: a cell is split while it meets a triangle, down to a depth; leaves in
 * Morton order. There are leaves where a surface reflects
 * diffusely or glossily: black ones (most lamps) and mirrors ask for no light, and photons there would only
 * bleed onto what is near. They are in those leaves' lists nevertheless, since they may hide others.
 *
 * Boxes are closed, and wider by what rounding to float may have moved a vertex: every point of a surface,
 * worked out in float, lies in a leaf. */
#pragma once

#include "base/morton.h"
#include "base/vec.h"
#include "cache/photons/photons.h"

typedef struct sl_octree_leaf {
    uint64_t morton;         /* z y x interleaved, x lowest, at the octree's depth */
    uint32_t first_triangle; /* in the octree's list */
    uint32_t triangle_count;
} sl_octree_leaf;

typedef struct sl_octree {
    int depth;
    sl_vec3d origin;        /* lower corner of the root cube */
    double edge;            /* of the root cube */
    double dilation;        /* of an edge, by which voxels are grown */
    size_t leaf_count;
    sl_octree_leaf *leaf;
    size_t triangle_count;
    uint32_t *triangle;     /* leaf by leaf, ascending in each */
} sl_octree;

/* The root cube: a box made cubic and enlarged by 1e-4. Beyond it surfaces have no indirect light. */
typedef struct sl_octree_root {
    sl_vec3d origin; /* its lower corner */
    double edge;
} sl_octree_root;

sl_octree_root sl_octree_root_of_all(const sl_scene *scene);
/* Of a scattered scene the central region and half as much again: voxels of all of it would be larger than
 * that region is. Else of all. */
sl_octree_root sl_octree_root_of_central_region(const sl_scene *scene);
static inline bool sl_octree_root_holds(const sl_octree_root *root, sl_vec3 p) {
    sl_vec3d u = sl_subd(sl_to_double(p), root->origin);
    return u.x >= 0.0 && u.y >= 0.0 && u.z >= 0.0 && u.x <= root->edge && u.y <= root->edge &&
           u.z <= root->edge;
}

/* dilation: voxels are grown by that fraction of their edge (0: the paper's remedy is off). */
sl_status sl_octree_create(const sl_scene *scene, const sl_octree_root *root, int depth, double dilation,
                           unsigned threads, sl_octree **octree, sl_error *error);
void sl_octree_destroy(sl_octree *octree);
size_t sl_octree_bytes(const sl_octree *octree);
/* The first leaf of [first, end) whose code is not below that one; else end. */
size_t sl_octree_lower_bound(const sl_octree *octree, size_t first, size_t end, uint64_t morton);
/* The code of the cell (clamped to the root) that holds a point. */
uint64_t sl_octree_morton_at(const sl_octree *octree, sl_vec3 p);
static inline double sl_octree_voxel(const sl_octree *octree) {
    return octree->edge / (double)(1u << octree->depth);
}

/* ---- triangles in units of cells, for building the octree and working on its leaves ---- */

typedef struct sl_cell_triangle {
    sl_vec3d corner[3], normal; /* the normal not unit: its length is twice the area */
} sl_cell_triangle;

static inline sl_cell_triangle sl_cell_triangle_of(sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    return (sl_cell_triangle){{a, b, c}, sl_crossd(sl_subd(b, a), sl_subd(c, b))};
}

static inline double sl_along(sl_vec3d p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

/* Of a triangle's part in a box: corners in order, area and centroid. */
enum { SL_TRIANGLE_PART_CORNERS = 12 /* 9, but for rounding */ };
typedef struct sl_triangle_part {
    int count;   /* of corners: 0 if nothing is left */
    sl_vec3d corner[SL_TRIANGLE_PART_CORNERS];
    double area;
    sl_vec3d centroid; /* mean of the corners where the area is 0 */
} sl_triangle_part;

/* Boxes are closed: what touches one leaves a point or an edge. */
void sl_triangle_in_box(const sl_cell_triangle *triangle, sl_vec3d low, sl_vec3d high,
                        sl_triangle_part *clipped);

/* A scene's triangles in units of the deepest cells, the root's lower corner at 0. */
typedef struct sl_cell_space {
    const sl_scene *scene;
    sl_vec3d origin;
    double scale;     /* cells a scene unit */
    double tolerance; /* cells: what rounding to float may have moved a point of a surface */
} sl_cell_space;

sl_cell_space sl_cell_space_of(const sl_scene *scene, sl_vec3d origin, double edge, int depth);
sl_cell_triangle sl_cell_space_triangle(const sl_cell_space *space, uint32_t triangle);
