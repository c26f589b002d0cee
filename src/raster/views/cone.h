/* Cones, and the conservative test of one against a box.
 *
 * A convex cone (half angle up to 90 degrees) and a box are apart where a plane separates them. Of the planes
 * tangent to the cone the one on the side of the box's centre is tried, with normal N = cos(beta) r -
 * sin(beta) a, r being the unit vector from the axis towards the centre, a the axis:
 *
 *                  \        . r          the cone lies in N . (p - apex) <= 0; the box is outside if its
 * centre lies N  \      /             further in front than the box reaches along N, \  \    +---+
 *                  '. \   | c |             rho cos(beta) - h sin(beta) > sum_k half_k |N_k|
 *                     '\  +---+
 *          apex --------*====== a ====>  with h and rho the centre's distances along and from the axis (with
 * the radius /                R of the box's sphere on the right this is the enlarged cone of the multi-mesh
 *                      /                 paper's grid; the box itself reaches less far).
 *
 * So are the two planes that bound the cone along its axis, h = 0 and h = length. */
#ifndef SL_RASTER_CONE_H
#define SL_RASTER_CONE_H

#include "raster/raster.h"

typedef struct sl_cone {
    sl_vec3 apex, axis; /* axis of any length > 0 */
    float cosine;       /* of the half angle; below 0 (wider than a half space) or NaN: everything is in it */
    float length;       /* along the axis from the apex; INFINITY: without end */
} sl_cone;

/* The cone from the apex around points (an area light's corners): axis the mean of their directions, as long
 * as the farthest. A point at the apex has no direction and is passed over. */
sl_cone sl_cone_around(sl_vec3 apex, const sl_vec3 *points, size_t count);

/* The cone as the test wants it. */
typedef struct sl_cone_test {
    sl_vec3d apex, axis;
    double cosine, sine, length;
    bool everything;
} sl_cone_test;
sl_cone_test sl_cone_test_make(const sl_cone *cone);

/* False only if no point of the box centre +- half lies in the cone. */
static inline bool sl_cone_meets_box(const sl_cone_test *c, sl_vec3d centre, sl_vec3d half) {
    if (c->everything) return true;
    sl_vec3d v = sl_subd(centre, c->apex);
    double h = sl_dotd(v, c->axis);
    double along = half.x * fabs(c->axis.x) + half.y * fabs(c->axis.y) + half.z * fabs(c->axis.z);
    double slack = 1e-12 * (fabs(v.x) + fabs(v.y) + fabs(v.z) + half.x + half.y + half.z);
    if (h + along < -slack || h - along > c->length + slack) return false;
    sl_vec3d radial = sl_subd(v, sl_scaled(c->axis, h));
    double rho = sl_lengthd(radial);
    if (!(rho > slack)) return true; /* before the apex, on the axis */
    sl_vec3d n = sl_subd(sl_scaled(radial, c->cosine / rho), sl_scaled(c->axis, c->sine));
    double reach = half.x * fabs(n.x) + half.y * fabs(n.y) + half.z * fabs(n.z);
    return !(rho * c->cosine - h * c->sine > reach + slack);
}

#endif
