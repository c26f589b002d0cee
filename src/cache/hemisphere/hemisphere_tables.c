#include "cache/hemisphere/hemisphere_tables.h"

#include "base/math.h"

/* ---- any cell bounded by great circles ------------------------------------------------------- */

/* The integral of omega over a spherical polygon is a sum over its edges: half the angle along the normal of
 * the edge's plane. */
sl_vec3d sl_cell_vector(const sl_vec3d *corners, int count) {
    sl_vec3d sum = {0.0, 0.0, 0.0};
    for (int i = 0; i < count; i++) {
        sl_vec3d a = corners[i], b = corners[(i + 1) % count], normal = sl_crossd(a, b);
        double length = sl_lengthd(normal);
        if (!(length > 0.0)) continue; /* no edge, or one through the eye: its plane is undefined */
        sum = sl_addd(sum, sl_scaled(normal, 0.5 * sl_atan2(length, sl_dotd(a, b)) / length));
    }
    return sum;
}

/* ---- edges: what moves when the receiver moves ----------------------------------------------- */

/* An edge from a to b seen from the origin: its line's foot h, its unit direction, and the integrals of s^k /
 * (h^2 + s^2)^2 along it (k = 1: j1, k = 0: j2). False where there is no edge, or the origin lies on its
 * line. */
typedef struct edge {
    sl_vec3d foot, along;
    double j1, j2;
} edge;

static bool make_edge(sl_vec3d a, sl_vec3d b, edge *e) {
    sl_vec3d difference = sl_subd(b, a);
    double length = sl_lengthd(difference);
    if (!(length > 0.0)) return false;
    e->along = sl_scaled(difference, 1.0 / length);
    double s0 = sl_dotd(a, e->along), s1 = s0 + length;
    e->foot = sl_subd(a, sl_scaled(e->along, s0));
    double h = sl_lengthd(e->foot);
    if (!(h >= 1e-9 * length)) return false;
    double r0 = h * h + s0 * s0, r1 = h * h + s1 * s1;
    e->j1 = 0.5 * (1.0 / r0 - 1.0 / r1);
    e->j2 = (s1 / r1 - s0 / r0) / (2.0 * h * h) + sl_atan2(length * h, h * h + s0 * s1) / (2.0 * h * h * h);
    return true;
}

/* A point d of the wall, |d| = l, is seen to move by -delta_perp / l (depth 1), and sweeps (e x d) . delta /
 * l^3 of solid angle an element; times the cosine n . d / l. e x d is the same all along the edge, n . d is
 * linear on it. */
sl_vec3d sl_wall_vector(sl_vec3d a, sl_vec3d b) {
    edge e;
    if (!make_edge(a, b, &e)) return sl_v3d(0.0, 0.0, 0.0);
    return sl_scaled(sl_crossd(e.along, e.foot), e.foot.z * e.j2 + e.along.z * e.j1);
}

/* ---- second derivatives ---------------------------------------------------------------------- */

/* Nusselt's disc, q = the tangential part of the direction, has equal areas where cosine weights are equal,
 * so that second derivatives are those of areas and need none of a kernel. A point at distance l is seen at
 *     q(delta) = q + (s q - delta) / l + (q (3 s^2 - delta^2) / 2 - s delta) / l^2 + ...,   s = q . delta. */
typedef struct disc_point {
    double x, y, distance;
} disc_point;

static disc_point on_disc(sl_vec3d direction) {
    double length = sl_lengthd(direction);
    return (disc_point){direction.x / length, direction.y / length, length};
}

/* A segment from q0 to q1 sweeps half the cross product of the diagonals (q1' - q0) x (q0' - q1) to its left:
 * with D = q1 - q0, first order d and second order e of each end, that is half of D x (d0 + d1) + D x (e0 +
 * e1) + d1 x d0. The last two, for one displacement. */
static double swept(disc_point a, disc_point b, double x, double y) {
    double sum[2] = {0.0, 0.0}, d[2][2];
    const disc_point ends[2] = {a, b};
    for (int i = 0; i < 2; i++) {
        const disc_point q = ends[i];
        double near = 1.0 / q.distance, s = q.x * x + q.y * y, along = 0.5 * (3.0 * s * s - x * x - y * y);
        d[i][0] = (s * q.x - x) * near;
        d[i][1] = (s * q.y - y) * near;
        sum[0] += (along * q.x - s * x) * near * near;
        sum[1] += (along * q.y - s * y) * near * near;
    }
    double crossed = (b.x - a.x) * sum[1] - (b.y - a.y) * sum[0];
    return 0.5 * (crossed + d[1][0] * d[0][1] - d[1][1] * d[0][0]);
}

/* A wall is straight in space and an arc on the disc: short pieces of it are straight enough. */
sl_curvature sl_wall_curvature(sl_vec3d a, sl_vec3d b) {
    enum { PIECES = 8 };
    sl_curvature sum = {0.0, 0.0, 0.0};
    disc_point from = on_disc(a);
    for (int i = 1; i <= PIECES; i++) {
        double share = (double)i / PIECES;
        disc_point to = on_disc(sl_addd(sl_scaled(a, 1.0 - share), sl_scaled(b, share)));
        double xx = swept(from, to, 1.0, 0.0), yy = swept(from, to, 0.0, 1.0),
               both = swept(from, to, 1.0, 1.0);
        sum.xx += 2.0 * xx;
        sum.yy += 2.0 * yy;
        sum.xy += both - xx - yy;
        from = to;
    }
    return sum;
}
