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

/* How far from where a vertex lies to its face's middle a leaf that has it as a corner may reach, by its weights in 1/SL_MESH_DYADIC: all the way from
 * a face's corner, half of it from the middle of an edge, ... */
double sl_dyadic_reach(uint32_t p, uint32_t q);
/* Whether a vertex where nothing arrives lies behind a wall, at the end of something that sticks in it, as a beam's in a wall that is but a face: then what
 * is asked for at `inside`, a fifth of the way into its leaf, stands for it. Such an end is short: the wall is met within the first quarter of that way.
 * One that stands further off is a wall beside a dark place, and what is behind it is none of the vertex's. */
bool sl_is_walled_in(const sl_tracer *tracer, const sl_mesh_point *vertex, const sl_mesh_point *inside, float lift, sl_counters *counters);

static inline sl_lit_point sl_lit_point_of(const sl_mesh_point *at) {
    return (sl_lit_point){at->position, at->normal, at->geometric_normal, at->triangle};
}

#endif
