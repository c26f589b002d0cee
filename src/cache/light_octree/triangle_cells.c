#include "cache/light_octree/triangle_cells.h"

static void put(sl_vec3d *p, int axis, double value) {
    if (axis == 0) p->x = value;
    else if (axis == 1) p->y = value;
    else p->z = value;
}

void sl_triangle_part_below(const sl_triangle_part *in, int axis, double plane, double sign,
                            sl_triangle_part *out) {
    out->count = 0;
    for (int i = 0; i < in->count && out->count < SL_TRIANGLE_PART_CORNERS - 1; i++) {
        sl_vec3d p = in->corner[i], q = in->corner[i + 1 < in->count ? i + 1 : 0];
        double a = sign * (sl_along(p, axis) - plane), b = sign * (sl_along(q, axis) - plane);
        if (a <= 0.0) out->corner[out->count++] = p;
        if ((a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0)) {
            sl_vec3d cut = sl_addd(p, sl_scaled(sl_subd(q, p), a / (a - b)));
            put(&cut, axis, plane);
            out->corner[out->count++] = cut;
        }
    }
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
    sl_triangle_part other;
    clipped->count = 3;
    for (int k = 0; k < 3; k++) clipped->corner[k] = triangle->corner[k];
    for (int axis = 0; axis < 3; axis++) {
        double a = sl_along(triangle->corner[0], axis), b = sl_along(triangle->corner[1], axis),
               c = sl_along(triangle->corner[2], axis), l = sl_along(low, axis), h = sl_along(high, axis);
        if (fmin(fmin(a, b), c) >= l && fmax(fmax(a, b), c) <= h) continue;
        sl_triangle_part_below(clipped, axis, l, -1.0, &other);
        sl_triangle_part_below(&other, axis, h, 1.0, clipped);
    }
    measure(clipped);
}
