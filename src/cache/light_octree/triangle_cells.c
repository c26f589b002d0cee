#include "cache/light_octree/triangle_cells.h"

sl_cell_triangle sl_cell_triangle_of(sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    sl_vec3d ab = sl_subd(b, a), bc = sl_subd(c, b), ca = sl_subd(a, c);
    return (sl_cell_triangle){{a, b, c}, {ab, bc, ca}, sl_crossd(ab, bc)};
}

static inline double min3(double a, double b, double c) {
    double m = a < b ? a : b;
    return m < c ? m : c;
}

static inline double max3(double a, double b, double c) {
    double m = a > b ? a : b;
    return m > c ? m : c;
}

/* Projections p of the three corners against the box's half width r. */
static inline bool apart(double p0, double p1, double p2, double r) {
    return min3(p0, p1, p2) > r || max3(p0, p1, p2) < -r;
}

bool sl_triangle_meets_box(const sl_cell_triangle *triangle, sl_vec3d low, sl_vec3d high) {
    sl_vec3d centre = sl_scaled(sl_addd(low, high), 0.5), h = sl_scaled(sl_subd(high, low), 0.5);
    sl_vec3d a = sl_subd(triangle->corner[0], centre), b = sl_subd(triangle->corner[1], centre),
             c = sl_subd(triangle->corner[2], centre);
    if (apart(a.x, b.x, c.x, h.x) || apart(a.y, b.y, c.y, h.y) || apart(a.z, b.z, c.z, h.z)) return false;
    sl_vec3d n = triangle->normal;
    if (fabs(sl_dotd(n, a)) > h.x * fabs(n.x) + h.y * fabs(n.y) + h.z * fabs(n.z)) return false;
    for (int k = 0; k < 3; k++) {
        sl_vec3d e = triangle->edge[k], f = sl_v3d(fabs(e.x), fabs(e.y), fabs(e.z));
        /* x times e */
        if (apart(e.y * a.z - e.z * a.y, e.y * b.z - e.z * b.y, e.y * c.z - e.z * c.y, h.y * f.z + h.z * f.y))
            return false;
        if (apart(e.z * a.x - e.x * a.z, e.z * b.x - e.x * b.z, e.z * c.x - e.x * c.z, h.z * f.x + h.x * f.z))
            return false;
        if (apart(e.x * a.y - e.y * a.x, e.x * b.y - e.y * b.x, e.x * c.y - e.y * c.x, h.x * f.y + h.y * f.x))
            return false;
    }
    return true;
}

/* ---- clipping (Sutherland and Hodgman 1974) ---- */

static inline double along(sl_vec3d p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

static inline void put(sl_vec3d *p, int axis, double value) {
    if (axis == 0) p->x = value;
    else if (axis == 1) p->y = value;
    else p->z = value;
}

/* Keeps what has sign * (p_axis - plane) <= 0. */
static int clip_to_plane(const sl_vec3d *in, int count, int axis, double plane, double sign, sl_vec3d *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        sl_vec3d p = in[i], q = in[i + 1 < count ? i + 1 : 0];
        double a = sign * (along(p, axis) - plane), b = sign * (along(q, axis) - plane);
        if (a <= 0.0) out[kept++] = p;
        if ((a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0)) {
            sl_vec3d cut = sl_addd(p, sl_scaled(sl_subd(q, p), a / (a - b)));
            put(&cut, axis, plane);
            out[kept++] = cut;
        }
    }
    return kept;
}

/* A fan of triangles about the first corner: all turn the same way. */
static void measure(sl_triangle_part *clipped) {
    const sl_vec3d *p = clipped->corner;
    sl_vec3d mean = {0}, weighted = {0};
    double area = 0.0;
    for (int i = 0; i < clipped->count; i++) mean = sl_addd(mean, p[i]);
    for (int i = 1; i + 1 < clipped->count; i++) {
        double piece = 0.5 * sl_lengthd(sl_crossd(sl_subd(p[i], p[0]), sl_subd(p[i + 1], p[0])));
        area += piece;
        weighted =
            sl_addd(weighted, sl_scaled(sl_addd(sl_subd(p[i], p[0]), sl_subd(p[i + 1], p[0])), piece / 3.0));
    }
    clipped->area = area;
    if (area > 0.0) clipped->centroid = sl_addd(p[0], sl_scaled(weighted, 1.0 / area));
    else if (clipped->count > 0) clipped->centroid = sl_scaled(mean, 1.0 / clipped->count);
    else clipped->centroid = sl_v3d(0.0, 0.0, 0.0);
}

void sl_triangle_in_box(const sl_cell_triangle *triangle, sl_vec3d low, sl_vec3d high,
                        sl_triangle_part *clipped) {
    sl_vec3d other[SL_TRIANGLE_PART_CORNERS];
    clipped->count = 3;
    for (int k = 0; k < 3; k++) clipped->corner[k] = triangle->corner[k];
    for (int axis = 0; axis < 3; axis++) {
        double a = along(triangle->corner[0], axis), b = along(triangle->corner[1], axis),
               c = along(triangle->corner[2], axis);
        double l = along(low, axis), h = along(high, axis);
        if (min3(a, b, c) >= l && max3(a, b, c) <= h) continue;
        int count = clip_to_plane(clipped->corner, clipped->count, axis, l, -1.0, other);
        clipped->count = clip_to_plane(other, count, axis, h, 1.0, clipped->corner);
    }
    measure(clipped);
}
