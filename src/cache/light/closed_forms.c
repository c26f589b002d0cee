/* Irradiance without occluders, in closed form and in double: Lambert's formula for polygons (multi-mesh
 * caching, closed forms),
 *
 *     E = -L/2 sum over edges of theta_k (n . u_k),   u_k = (v_k x v_k+1) / |.|,   theta_k the edge's angle,
 *
 * vertices v_k relative to the point, counter-clockwise seen from where the polygon shines, cut at the
 * point's horizon: without the cut a wall half of which is below the horizon gets 0.37 instead of 0.50. Far
 * away the sum is a small difference of large terms, and the light's area at its middle does better. */
#include <math.h>

#include "base/math.h"
#include "cache/light/light_sample_internal.h"

enum { CORNERS_MAX = 5 }; /* a triangle cut by two planes */

typedef struct {
    int count;
    sl_vec3d corner[CORNERS_MAX + 1];
} polygon;

/* The part with n . v >= 0 (Sutherland and Hodgman 1974). */
static void cut(polygon *p, sl_vec3d n) {
    polygon out = {.count = 0};
    for (int k = 0; k < p->count; k++) {
        sl_vec3d a = p->corner[k], b = p->corner[(k + 1) % p->count];
        double ha = sl_dotd(n, a), hb = sl_dotd(n, b);
        if (ha >= 0.0 && out.count < CORNERS_MAX) out.corner[out.count++] = a;
        if (((ha < 0.0 && hb > 0.0) || (ha > 0.0 && hb < 0.0)) && out.count < CORNERS_MAX) {
            out.corner[out.count++] = sl_addd(a, sl_scaled(sl_subd(b, a), ha / (ha - hb)));
        }
    }
    *p = out;
}

static polygon above_horizons(const sl_vec3d corner[3], sl_vec3d normal, sl_vec3d geometric_normal) {
    polygon p = {3, {corner[0], corner[1], corner[2]}};
    cut(&p, normal);
    cut(&p, geometric_normal);
    return p;
}

static double edge_term(sl_vec3d a, sl_vec3d b, sl_vec3d n) {
    sl_vec3d c = sl_crossd(a, b);
    double length = sl_lengthd(c);
    return length > 0.0 ? sl_atan2(length, sl_dotd(a, b)) * (sl_dotd(n, c) / length) : 0.0;
}

static double lambert_triangle(const sl_vec3d corner[3], sl_vec3d normal, sl_vec3d geometric_normal) {
    polygon p = above_horizons(corner, normal, geometric_normal);
    double sum = 0.0;
    if (p.count < 3) return 0.0;
    for (int k = 0; k < p.count; k++) sum -= edge_term(p.corner[k], p.corner[(k + 1) % p.count], normal);
    return sum * (0.5 / SL_PI);
}

/* The side of a triangle on which the point lies: 1 where it shines, -1 of a two-sided light's back, 0 where
 * nothing comes from it. */
static int side_of(const sl_sampled_light *light, size_t triangle, sl_vec3d p) {
    double front = sl_dotd(sl_light_cross(light, triangle), sl_subd(p, sl_light_corner(light, 3 * triangle)));
    return front > 0.0 ? 1 : front < 0.0 && light->two_sided ? -1 : 0;
}

/* The triangle's corners from the point, counter-clockwise seen from there; false where nothing comes from
 * it. */
static bool turned_to(const sl_sampled_light *light, size_t triangle, const sl_lit_point *point,
                      sl_vec3d corner[3]) {
    sl_vec3d p = sl_to_double(point->position);
    int side = side_of(light, triangle, p);
    for (size_t k = 0; k < 3; k++)
        corner[side < 0 ? 2 - k : k] = sl_subd(sl_to_double(light->corner[3 * triangle + k]), p);
    return side != 0;
}

/* Area, cosines and squared distance of the triangle's middle. */
static double far_triangle(const sl_vec3d corner[3], sl_vec3d n, sl_vec3d g) {
    sl_vec3d middle = sl_scaled(sl_addd(sl_addd(corner[0], corner[1]), corner[2]), 1.0 / 3.0);
    sl_vec3d cross = sl_crossd(sl_subd(corner[1], corner[0]), sl_subd(corner[2], corner[0]));
    double squared = sl_dotd(middle, middle), high = sl_dotd(n, middle),
           front = -0.5 * sl_dotd(cross, middle);
    if (!(squared > 0.0) || !(high > 0.0) || !(front > 0.0) || !(sl_dotd(g, middle) > 0.0)) return 0.0;
    return high / squared * (front / squared) * (1.0 / SL_PI);
}

static bool is_far(const sl_vec3d corner[3]) {
    double size = 0.0, distance = INFINITY;
    for (int k = 0; k < 3; k++) {
        size = fmax(size, sl_lengthd(sl_subd(corner[k], corner[(k + 1) % 3])));
        distance = fmin(distance, sl_lengthd(corner[k]));
    }
    return size < SL_TINY_LIGHT * distance;
}

/* Nothing of the light is below a horizon: no triangle needs to be cut. */
static bool is_above(const sl_sampled_light *light, const sl_lit_point *point) {
    sl_vec3d p = sl_to_double(point->position), n = sl_to_double(point->normal),
             g = sl_to_double(point->geometric_normal);
    double distance = sl_lengthd(sl_subd(sl_to_double(light->position), p));
    if (!((double)light->extent > SL_TINY_LIGHT * distance)) return false;
    for (size_t k = 0; k < 3 * light->triangles; k++) {
        sl_vec3d c = sl_subd(sl_to_double(light->corner[k]), p);
        if (!(sl_dotd(n, c) >= 0.0) || !(sl_dotd(g, c) >= 0.0)) return false;
    }
    return true;
}

double sl_light_unoccluded(const sl_sampled_light *light, const sl_lit_point *point) {
    if (!sl_light_has_extent(light)) {
        sl_vec3d to;
        double distance;
        return sl_light_point_form(light, point, &to, &distance);
    }
    sl_vec3d n = sl_to_double(point->normal), g = sl_to_double(point->geometric_normal);
    double sum = 0.0;
    for (size_t t = 0; t < light->triangles; t++) {
        sl_vec3d corner[3];
        if (!turned_to(light, t, point, corner)) continue;
        sum += is_far(corner) ? far_triangle(corner, n, g) : lambert_triangle(corner, n, g);
    }
    return sum > 0.0 && isfinite(sum) ? sum : 0.0;
}

/* Area-weighted middle of what is above the horizons, from the point. */
sl_vec3d sl_light_middle(const sl_sampled_light *light, const sl_lit_point *point) {
    sl_vec3d n = sl_to_double(point->normal), g = sl_to_double(point->geometric_normal), middle = {0, 0, 0};
    bool above = is_above(light, point);
    double total = 0.0;
    if (above && light->kind == SL_SOURCE_AREA && side_of(light, 0, sl_to_double(point->position)) != 0) {
        return sl_subd(sl_to_double(light->position), sl_to_double(point->position));
    }
    for (size_t t = 0; t < light->triangles; t++) {
        sl_vec3d corner[3];
        if (!turned_to(light, t, point, corner)) continue;
        polygon p = above ? (polygon){3, {corner[0], corner[1], corner[2]}} : above_horizons(corner, n, g);
        for (int k = 1; k + 1 < p.count; k++) {
            sl_vec3d sum = sl_addd(sl_addd(p.corner[0], p.corner[k]), p.corner[k + 1]);
            double area = sl_lengthd(
                sl_crossd(sl_subd(p.corner[k], p.corner[0]), sl_subd(p.corner[k + 1], p.corner[0])));
            middle = sl_addd(middle, sl_scaled(sum, area / 3.0));
            total += area;
        }
    }
    return total > 0.0 ? sl_scaled(middle, 1.0 / total) : sl_v3d(0, 0, 0);
}

sl_vec3 sl_light_direction(const sl_sampled_light *light, const sl_lit_point *point) {
    sl_vec3 n = point->normal, g = point->geometric_normal;
    if (!sl_is_finite(point->position) || !(sl_dot(n, n) > 0.0f) || !(sl_dot(g, g) > 0.0f))
        return sl_v3(0, 0, 0);
    if (sl_light_has_extent(light))
        return sl_normalize_or(sl_to_float(sl_light_middle(light, point)), sl_v3(0, 0, 0));
    sl_vec3d to;
    double distance;
    return sl_light_point_form(light, point, &to, &distance) > 0.0 ? sl_to_float(to) : sl_v3(0, 0, 0);
}
