#include "cache/light/spherical_triangle.h"

#include "base/math.h"

#include <math.h>

static sl_vec3d unit_towards(sl_vec3 corner, sl_vec3 p) {
    sl_vec3d d = sl_subd(sl_to_double(corner), sl_to_double(p));
    double length = sl_lengthd(d);
    return length > 0.0 ? sl_scaled(d, 1.0 / length) : d;
}

/* cosine * axis + sine * (the unit vector towards v, square to the axis) */
static sl_vec3d arc(sl_vec3d axis, sl_vec3d v, double cosine) {
    sl_vec3d across = sl_subd(v, sl_scaled(axis, sl_dotd(v, axis)));
    double length = sl_lengthd(across), sine = sqrt(fmax(0.0, 1.0 - cosine * cosine));
    return length > 0.0 ? sl_addd(sl_scaled(axis, cosine), sl_scaled(across, sine / length)) : axis;
}

/* Arvo 1995, "Stratified sampling of spherical triangles": u1 cuts off a triangle of that share of the area, whose corner C' moves along
 * the side AC; u2 walks from B towards C'. */
bool sl_spherical_point(const sl_vec3 corner[3], sl_vec3 p, double u1, double u2, sl_vec3d *direction, double *solid_angle) {
    sl_vec3d a = unit_towards(corner[0], p), b = unit_towards(corner[1], p), c = unit_towards(corner[2], p);
    double volume = fabs(sl_dotd(a, sl_crossd(b, c)));
    double cos_c = sl_dotd(a, b), cos_b = sl_dotd(a, c);
    double area = 2.0 * sl_atan2(volume, 1.0 + cos_c + cos_b + sl_dotd(b, c));
    *solid_angle = area;
    if (!(area > 1e-6)) return false;
    double alpha = sl_atan2(volume, sl_dotd(b, c) - cos_c * cos_b), part = u1 * area - alpha;
    double sin_alpha = sl_sin(alpha), cos_alpha = sl_cos(alpha), s = sl_sin(part), t = sl_cos(part);
    double u = t - cos_alpha, w = s + sin_alpha * cos_c;
    double denominator = (w * s + u * t) * sin_alpha;
    double q = denominator != 0.0 ? ((w * t - u * s) * cos_alpha - w) / denominator : 1.0;
    sl_vec3d moved = arc(a, c, fmin(fmax(q, -1.0), 1.0));
    *direction = arc(b, moved, 1.0 - u2 * (1.0 - sl_dotd(moved, b)));
    return true;
}
