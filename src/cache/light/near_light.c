#include "cache/light/near_light.h"

#include <math.h>

#include "base/math.h"

/* ---- spherical triangles ---- */

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

/* False where it spans less than a millionth of a steradian: it is seen edge-on or is very small. */
static bool make_spherical(const sl_vec3 corner[3], sl_vec3 p, sl_spherical_triangle *t) {
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

/* Cuts off what lies below the horizon: up to four corners are left. */
static int clip_to_horizon(const sl_vec3 corner[3], sl_vec3 p, sl_vec3 n, sl_vec3 above[4]) {
    int count = 0;
    for (int k = 0; k < 3; k++) {
        sl_vec3 a = corner[k], b = corner[(k + 1) % 3];
        float ha = sl_dot(sl_sub(a, p), n), hb = sl_dot(sl_sub(b, p), n);
        if (ha > 0.0f) above[count++] = a;
        if ((ha > 0.0f) != (hb > 0.0f)) above[count++] = sl_mad(a, ha / (ha - hb), sl_sub(b, a));
    }
    return count;
}

void sl_seen_triangle_make(const sl_vec3 corner[3], sl_vec3 p, sl_vec3 n, sl_seen_triangle *seen) {
    sl_vec3 above[4];
    int corners = clip_to_horizon(corner, p, n, above);
    seen->parts = 0;
    seen->solid_angle = 0.0;
    for (int k = 2; k < corners; k++) {
        const sl_vec3 three[3] = {above[0], above[k - 1], above[k]};
        if (!make_spherical(three, p, &seen->part[seen->parts])) continue;
        seen->solid_angle += seen->part[seen->parts++].solid_angle;
    }
}

int sl_seen_triangle_part(const sl_seen_triangle *seen, double *u1) {
    double first = seen->part[0].solid_angle / seen->solid_angle;
    bool second = seen->parts > 1 && *u1 >= first;
    if (seen->parts > 1) *u1 = second ? (*u1 - first) / (1.0 - first) : *u1 / first;
    return second ? 1 : 0;
}

/* ---- emitters that are near ---- */

#define COSINE_MIN 0.05

/* The cosine above the receiver differs between the corners, so numbers are bent by what is bilinear between
 * the corners' cosines (Hart et al. 2020, "Practical product sampling by fitting and composing warps"). */
void sl_near_light_make(const sl_polygon_light *light, sl_vec3 p, sl_vec3 n, sl_near_light *near) {
    sl_seen_triangle_make(light->corner, p, n, &near->seen);
    for (int k = 0; k < near->seen.parts; k++) {
        const sl_spherical_triangle *t = &near->seen.part[k];
        const sl_vec3d towards[3] = {t->a, t->b, t->c};
        for (int c = 0; c < 3; c++)
            near->cosine[k][c] = fmax(COSINE_MIN, sl_dotd(towards[c], sl_to_double(n)));
    }
    near->out = sl_to_double(light->normal);
    near->height = sl_dotd(near->out, sl_subd(sl_to_double(p), sl_to_double(light->corner[0])));
}

/* Density proportional to a line from `low` at 0 to `high` at 1, both > 0. */
static double draw_line(double u, double low, double high) {
    return u * (low + high) / (low + sqrt(low * low + u * (high * high - low * low)));
}

sl_vec3d sl_near_light_draw(const sl_near_light *near, double u1, double u2, double *density,
                            double *distance) {
    int part = sl_seen_triangle_part(&near->seen, &u1);
    const double *c = near->cosine[part], mean = 0.5 * c[1] + 0.25 * (c[0] + c[2]);
    u2 = draw_line(u2, c[1], 0.5 * (c[0] + c[2]));
    double low = c[1] + u2 * (c[0] - c[1]), high = c[1] + u2 * (c[2] - c[1]);
    u1 = draw_line(u1, low, high);
    *density = (low + u1 * (high - low)) / mean;
    sl_vec3d direction = sl_spherical_triangle_point(&near->seen.part[part], u1, u2);
    double emitted = -sl_dotd(near->out, direction);
    *distance = emitted > 0.0 ? near->height / emitted : 0.0;
    return direction;
}
