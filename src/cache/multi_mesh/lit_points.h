/* Where light is asked for: a little beside the vertices, which lie on edges and may lie inside other geometry. */
#ifndef SL_MULTI_MESH_LIT_POINTS_H
#define SL_MULTI_MESH_LIT_POINTS_H

#include "cache/light/light_sample.h"
#include "cache/patches/mesh.h"

/* How much of the way to its leaf's middle a point is moved that lies inside other geometry: these one after another. */
enum { SL_NUDGES = 3 };
extern const double sl_nudge[SL_NUDGES];

/* Moves a point on an edge into its face, at least `inwards` from all its edges unless the face is too small. */
void sl_step_inside(const sl_topology *topology, double inwards, sl_mesh_point *at);

/* How far from where a vertex lies to its face's middle a leaf that has it as a corner may reach, by its weights in 1/SL_MESH_DYADIC: all the way from
 * a face's corner, half of it from the middle of an edge, ... */
double sl_dyadic_reach(uint32_t p, uint32_t q);
/* Where on the way from a vertex to `inside`, a fifth of the way into its leaf, the first wall stands: a share of that way; 1: there is none. */
float sl_share_before_wall(const sl_tracer *tracer, const sl_mesh_point *vertex, const sl_mesh_point *inside, float lift, sl_counters *counters);
/* A vertex where nothing arrives lies behind a wall, at the end of something that sticks in it, as a beam's in a wall that is but a face, if the wall
 * stands within the first quarter: then what is asked for at `inside` stands for it. A wall that stands further off is one beside a dark place, and what is behind
 * it is none of the vertex's. */
#define SL_STUB 0.25f

static inline sl_lit_point sl_lit_point_of(const sl_mesh_point *at) {
    return (sl_lit_point){at->position, at->normal, at->geometric_normal, at->triangle};
}

#endif
