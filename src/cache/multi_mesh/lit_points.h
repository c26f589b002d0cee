/* Where light is asked for: a little beside the vertices, which lie on edges and may lie inside other
 * geometry. */
#ifndef SL_MULTI_MESH_LIT_POINTS_H
#define SL_MULTI_MESH_LIT_POINTS_H

#include "cache/light/light_sample.h"
#include "cache/patches/mesh.h"

/* Moves a point on an edge into its face, at least `inwards` from all its edges unless the face is too small.
 */
void sl_step_inside(const sl_scene *scene, double inwards, sl_mesh_point *at);

/* Moves the point of a vertex that lies inside a solid towards the middle of a leaf that has it, at most a
 * fifth of the way, until it does not. False: it still does, and no light there is anybody's. */
bool sl_leave_solid(const sl_mesh *mesh, const sl_tracer *tracer, uint32_t vertex, sl_root_place leaf,
                    sl_mesh_point *at, bool *moved, sl_counters *counters);

static inline sl_lit_point sl_lit_point_of(const sl_mesh_point *at) {
    return (sl_lit_point){at->position, at->normal, at->geometric_normal, at->triangle};
}

#endif
