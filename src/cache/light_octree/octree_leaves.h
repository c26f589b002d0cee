/* What building the octree and working on its leaves share: positions in units of cells. */
#ifndef SL_CACHE_LIGHT_OCTREE_OCTREE_LEAVES_H
#define SL_CACHE_LIGHT_OCTREE_OCTREE_LEAVES_H

#include "cache/light_octree/octree.h"
#include "cache/light_octree/triangle_cells.h"

/* A scene's triangles in units of the deepest cells, the root's lower corner at 0. */
typedef struct sl_cell_space {
    const sl_scene *scene;
    sl_vec3d origin;
    double scale;     /* cells a scene unit */
    double tolerance; /* cells: what rounding to float may have moved a point of a surface */
} sl_cell_space;

sl_cell_space sl_cell_space_of(const sl_scene *scene, sl_vec3d origin, double edge, int depth);
sl_cell_triangle sl_cell_space_triangle(const sl_cell_space *space, uint32_t triangle);

/* A triangle's part in a cell, and which share of its area belongs to that cell: half, if it lies in a face.
 */
double sl_clip_to_cell(const sl_cell_space *space, const sl_cell_triangle *triangle, const uint32_t cell[3],
                       double dilate, sl_triangle_part *part);

/* Writes of each triangle's area the share that no larger coplanar triangle covers (of equal ones none of a
 * lower number). Planes count as equal within 1e-6 of the scene's size (coplanar.c). */
sl_status sl_coplanar_shares(const sl_scene *scene, float *share, sl_error *error);

#endif
