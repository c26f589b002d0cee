#include "cache/multi_mesh/lit_points.h"

#include <math.h>

const double sl_nudge[SL_NUDGES] = {0.01, 0.05, 0.2};

/* How much of the way to a face's middle is needed to be so far from those of its edges that a point lies on; at most a quarter. */
static double share_inside(const sl_vec3d corner[3], sl_vec3d middle, sl_vec3d p, double far) {
    double share = 0.0;
    for (int i = 0; i < 3; i++) {
        sl_vec3d from = corner[(i + 1) % 3], edge = sl_subd(corner[(i + 2) % 3], from);
        double length = sl_lengthd(edge), at = sl_lengthd(sl_crossd(edge, sl_subd(p, from))), whole = sl_lengthd(sl_crossd(edge, sl_subd(middle, from)));
        if (at < far * length && whole > 0.0) share = fmax(share, far * length / whole);
    }
    return fmin(share, 0.25);
}

/* A vertex on an edge touches the walls beyond: whether they are before it or behind is rounding, and rays begin past them. What is meant is the limit
 * from within its own face, so the vertex is moved towards that face's middle, until it is further from the edge than rays begin ahead of it: the wall at
 * whose foot it lies hides what is behind the wall. (So far on the way itself would not do: on a narrow strip that way runs along the edge.) Where the
 * face falls below the tangent plane (a bulge) it stays in the plane, so as not to dive. */
void sl_step_inside(const sl_topology *topology, double inwards, sl_mesh_point *at) {
    sl_vec3d corner[3], middle = sl_v3d(0.0, 0.0, 0.0), p = sl_to_double(at->position), n = sl_to_double(at->normal);
    for (int i = 0; i < 3; i++) {
        corner[i] = sl_to_double(topology->site_position[topology->site[i][at->face]]);
        middle = sl_addd(middle, sl_scaled(corner[i], 1.0 / 3.0));
    }
    sl_vec3d way = sl_scaled(sl_subd(middle, p), share_inside(corner, middle, p, inwards));
    if (!isfinite(sl_lengthd(way))) return;
    double rise = sl_dotd(way, n);
    if (rise < 0.0) way = sl_subd(way, sl_scaled(n, rise));
    at->position = sl_to_float(sl_addd(p, way));
}

double sl_dyadic_reach(uint32_t p, uint32_t q) {
    uint32_t level = 0;
    while (level < SL_MESH_DEPTH_MAX && (p | q) % ((uint32_t)SL_MESH_DYADIC >> level) != 0) level++;
    return 1.0 / (double)(1u << level);
}

float sl_share_before_wall(const sl_tracer *tracer, const sl_mesh_point *vertex, const sl_mesh_point *inside, float lift, sl_counters *counters) {
    sl_vec3 from = sl_mad(vertex->position, lift, vertex->normal), way = sl_sub(sl_mad(inside->position, lift, inside->normal), from);
    if (!sl_is_finite(way) || !(sl_length(way) > 0.0f)) return 1.0f;
    sl_ray16 ray = {.origin_x = {from.x}, .origin_y = {from.y}, .origin_z = {from.z}, .direction_x = {way.x}, .direction_y = {way.y},
                    .direction_z = {way.z}, .far = {1.0f}, .skip = {vertex->triangle}};
    sl_hit16 hit;
    sl_trace(tracer, &ray, 1, false, &hit, counters);
    return hit.triangle[0] != SL_NO_INDEX ? hit.t[0] : 1.0f;
}
