#include "cache/multi_mesh/lit_points.h"

#include <math.h>

/* Shares of the way to its leaf's middle by which a point is moved that lies inside other geometry, one after
 * another. */
enum { NUDGES = 3 };
static const double nudge[NUDGES] = {0.01, 0.05, 0.2};

/* Returns the share of the way to a face's middle that is needed to be so far from those of its edges that a
 * point lies on; at most a quarter. */
static double share_inside(const sl_vec3d corner[3], sl_vec3d middle, sl_vec3d p, double far) {
    double share = 0.0;
    for (int i = 0; i < 3; i++) {
        sl_vec3d from = corner[(i + 1) % 3], edge = sl_subd(corner[(i + 2) % 3], from);
        double length = sl_lengthd(edge), at = sl_lengthd(sl_crossd(edge, sl_subd(p, from))),
               whole = sl_lengthd(sl_crossd(edge, sl_subd(middle, from)));
        if (at < far * length && whole > 0.0) share = fmax(share, far * length / whole);
    }
    return fmin(share, 0.25);
}

/* A vertex on an edge touches the walls beyond: whether they are before it or behind is rounding, and rays
 * begin past them. What is meant is the limit from within its own face, so the vertex is moved towards that
 * face's middle, until it is further from the edge than rays begin ahead of it: the wall at whose foot it
 * lies hides what is behind the wall. (So far on the way itself would not do: on a narrow strip that way runs
 * along the edge.) Where the face falls below the tangent plane (a bulge) it stays in the plane, so as not to
 * dive. */
void sl_step_inside(const sl_scene *scene, double inwards, sl_mesh_point *at) {
    sl_vec3d corner[3], middle = sl_v3d(0.0, 0.0, 0.0), p = sl_to_double(at->position),
                        n = sl_to_double(at->normal);
    for (int i = 0; i < 3; i++) {
        corner[i] = sl_to_double(sl_scene_position(scene, scene->vertex[i][at->face / 2]));
        middle = sl_addd(middle, sl_scaled(corner[i], 1.0 / 3.0));
    }
    sl_vec3d way = sl_scaled(sl_subd(middle, p), share_inside(corner, middle, p, inwards));
    if (!isfinite(sl_lengthd(way))) return;
    double rise = sl_dotd(way, n);
    if (rise < 0.0) way = sl_subd(way, sl_scaled(n, rise));
    at->position = sl_to_float(sl_addd(p, way));
}

static bool is_inside(const sl_mesh *mesh, const sl_tracer *tracer, const sl_mesh_point *at,
                      sl_counters *counters) {
    return sl_mesh_point_in_solid(mesh->primitives, tracer, at, counters);
}

bool sl_leave_solid(const sl_mesh *mesh, const sl_tracer *tracer, uint32_t vertex, sl_root_place leaf,
                    sl_mesh_point *at, bool *moved, sl_counters *counters) {
    *moved = false;
    if (!is_inside(mesh, tracer, at, counters)) return true;
    for (int i = 0; i < NUDGES && !*moved; i++) {
        sl_mesh_point_nudged(mesh, vertex, leaf, nudge[i], at);
        *moved = !is_inside(mesh, tracer, at, counters);
    }
    return *moved;
}
