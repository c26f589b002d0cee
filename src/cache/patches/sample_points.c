/* Where a vertex is sampled: a little beside where it lies, since that is on edges, where other surfaces
 * begin, and may be inside other geometry. */
#include <math.h>

#include "cache/patches/mesh.h"
#include "cache/patches/primitive_parts.h"

/* The root's own corners are on all grids. */
static int32_t side_of_patches(const sl_patch_vertex *v) {
    uint32_t places = v->u | v->v | SL_PATCH_DYADIC;
    return (int32_t)(places & -places);
}

static int32_t at_most(int32_t way, int32_t most) { return way > most ? most : way < -most ? -most : way; }

/* nudge: 0 on borders alone; 1 to NUDGES. */
enum { NUDGES = 3 };
static void nudge_to(const sl_patches *p, uint32_t vertex, int nudge, sl_lit_point *at) {
    static const int32_t ways[NUDGES + 1] = {256, 100, 20, 5};
    const sl_patch_vertex *v = &p->vertex[vertex];
    int corners = sl_primitive_corners(p->primitives, v->root / 2);
    int32_t centre = SL_PATCH_DYADIC / (corners == 3 ? 3 : 2), u = v->u, w = v->v;
    int32_t side = nudge ? side_of_patches(v) : SL_PATCH_DYADIC;
    uint32_t t;
    if (nudge || sl_edge_at(corners, v->u, v->v, &t) >= 0) {
        u += at_most(centre - u, side) / ways[nudge];
        w += at_most(centre - w, side) / ways[nudge];
    }
    sl_root_point_at(p->primitives, v->root, (uint32_t)u, (uint32_t)w, at);
}

void sl_vertex_sample_point(const sl_patches *p, uint32_t vertex, sl_lit_point *at) {
    nudge_to(p, vertex, 0, at);
}

bool sl_leave_solid(const sl_patches *p, const sl_tracer *tracer, const sl_vec3 *eye, uint32_t vertex,
                    sl_lit_point *at, bool *moved, sl_counters *counters) {
    bool inside = sl_solids_hold(p->primitives->solids, tracer, at, eye, counters);
    *moved = false;
    for (int nudge = 1; nudge <= NUDGES && inside; nudge++) {
        nudge_to(p, vertex, nudge, at);
        inside = sl_solids_hold(p->primitives->solids, tracer, at, eye, counters);
        *moved = !inside;
    }
    return !inside;
}

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
    sl_vec3d corner[3], middle = sl_v3d(0.0, 0.0, 0.0), p = sl_to_double(at->lit.position),
                        n = sl_to_double(at->lit.normal);
    for (int i = 0; i < 3; i++) {
        corner[i] = sl_to_double(sl_scene_position(scene, scene->vertex[i][at->face / 2]));
        middle = sl_addd(middle, sl_scaled(corner[i], 1.0 / 3.0));
    }
    sl_vec3d way = sl_scaled(sl_subd(middle, p), share_inside(corner, middle, p, inwards));
    if (!isfinite(sl_lengthd(way))) return;
    double rise = sl_dotd(way, n);
    if (rise < 0.0) way = sl_subd(way, sl_scaled(n, rise));
    at->lit.position = sl_to_float(sl_addd(p, way));
}
