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

bool sl_spherical_triangle_make(const sl_vec3 corner[3], sl_vec3 p, sl_spherical_triangle *t) {
    sl_vec3d a = unit_towards(corner[0], p), b = unit_towards(corner[1], p), c = unit_towards(corner[2], p);
    double volume = fabs(sl_dotd(a, sl_crossd(b, c)));
    double cos_c = sl_dotd(a, b), cos_b = sl_dotd(a, c);
    double area = 2.0 * sl_atan2(volume, 1.0 + cos_c + cos_b + sl_dotd(b, c));
    if (!(area > 1e-6)) return false;
    double alpha = sl_atan2(volume, sl_dotd(b, c) - cos_c * cos_b);
    *t = (sl_spherical_triangle){a, b, c, area, cos_c, alpha, sl_sin(alpha), sl_cos(alpha)};
    return true;
}

/* Arvo 1995, "Stratified sampling of spherical triangles": u1 cuts off a triangle of that share of the area,
 * whose corner C' moves along the side AC; u2 walks from B towards C'. */
sl_vec3d sl_spherical_triangle_point(const sl_spherical_triangle *t, double u1, double u2) {
    double part = u1 * t->solid_angle - t->alpha, sine = sl_sin(part), cosine = sl_cos(part);
    double u = cosine - t->cosine, v = sine + t->sine * t->cos_c;
    double denominator = (v * sine + u * cosine) * t->sine;
    double q = denominator != 0.0 ? ((v * cosine - u * sine) * t->cosine - v) / denominator : 1.0;
    sl_vec3d moved = arc(t->a, t->c, fmin(fmax(q, -1.0), 1.0));
    return arc(t->b, moved, 1.0 - u2 * (1.0 - sl_dotd(moved, t->b)));
}
