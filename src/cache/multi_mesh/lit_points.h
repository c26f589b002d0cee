/* Where light is asked for: a little beside the vertices, which lie on edges and may lie inside other geometry. */
#ifndef SL_MULTI_MESH_LIT_POINTS_H
#define SL_MULTI_MESH_LIT_POINTS_H

#include "cache/light_sample/light_sample.h"
#include "cache/multi_mesh/mesh.h"

/* How much of the way to its face's middle a point is moved that lies inside other geometry: these one after another. */
enum { SL_NUDGES = 3 };
extern const double sl_nudge[SL_NUDGES];

/* Moves a point on an edge into its face, at least `inwards` from all its edges unless the face is too small. */
void sl_step_inside(const sl_topology *topology, double inwards, sl_mesh_point *at);
static inline sl_lit_point sl_lit_point_of(const sl_mesh_point *at) {
    return (sl_lit_point){at->position, at->normal, at->geometric_normal, at->triangle};
}

#endif
