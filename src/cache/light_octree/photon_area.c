#include "cache/light_octree/photon_area.h"

#include "base/math.h"

static const double flatness_least = 1e-3; /* as photon_tree.c has it */

static bool is_sphere(const sl_ellipsoid *e) { return !(sl_dotd(e->normal, e->normal) > 0.0); }

static double flatness_of(const sl_ellipsoid *e) {
    if (is_sphere(e) || !(e->flatness < 1.0)) return 1.0;
    return e->flatness > flatness_least ? e->flatness : flatness_least;
}

double sl_disc_area(const sl_ellipsoid *e) { return SL_PI * e->radius * e->radius; }

/* A = pi R^2 (1 - h^2 / (R^2 s^2)) / sqrt(cos^2 b + sin^2 b / f^2), s^2 = sin^2 b + f^2 cos^2 b, b the angle between the
 * normals. The root is s / f. */
double sl_section_area(const sl_ellipsoid *e, sl_vec3d normal, double h) {
    double f = flatness_of(e), cosine = is_sphere(e) ? 1.0 : fabs(sl_dotd(e->normal, normal));
    cosine = cosine < 1.0 ? cosine : 1.0;
    double s_squared = (1.0 - cosine * cosine) + f * f * cosine * cosine;
    double share = 1.0 - h * h / (e->radius * e->radius * s_squared);
    return share > 0.0 ? sl_disc_area(e) * share * f / sqrt(s_squared) : 0.0;
}

/* ---- a triangle -------------------------------------------------------------------------------------------------- */

/* Where the ellipsoid is a sphere about the origin: stretched by 1 / f along the short axis. */
static sl_vec3d stretched(const sl_ellipsoid *e, sl_vec3d p) {
    sl_vec3d q = sl_subd(p, e->centre);
    if (is_sphere(e)) return q;
    return sl_addd(q, sl_scaled(e->normal, (1.0 / flatness_of(e) - 1.0) * sl_dotd(q, e->normal)));
}

/* A disc about the origin of the plane with that unit normal. */
typedef struct flat_disc {
    sl_vec3d normal;
    double radius_squared;
} flat_disc;

static double sector(const flat_disc *disc, sl_vec3d p, sl_vec3d q) {
    return 0.5 * disc->radius_squared * sl_atan2(sl_dotd(sl_crossd(p, q), disc->normal), sl_dotd(p, q));
}

static double within_edge(double t) { return t > 0.0 ? t < 1.0 ? t : 1.0 : 0.0; }

/* The disc's part of the triangle (origin, a, b), negative where they go clockwise: a triangle over the piece of the edge inside,
 * sectors over those outside. */
static double under_edge(const flat_disc *disc, sl_vec3d a, sl_vec3d b) {
    sl_vec3d edge = sl_subd(b, a);
    double length_squared = sl_dotd(edge, edge);
    if (!(length_squared > 0.0)) return 0.0;
    double nearest = -sl_dotd(a, edge) / length_squared;
    sl_vec3d foot = sl_addd(a, sl_scaled(edge, nearest));
    double left = disc->radius_squared - sl_dotd(foot, foot);
    if (!(left > 0.0)) return sector(disc, a, b);
    double half = sqrt(left / length_squared), enter = within_edge(nearest - half), leave = within_edge(nearest + half);
    if (!(enter < leave)) return sector(disc, a, b);
    double area = 0.5 * (leave - enter) * sl_dotd(sl_crossd(foot, edge), disc->normal);
    if (enter > 0.0) area += sector(disc, a, sl_addd(a, sl_scaled(edge, enter)));
    if (leave < 1.0) area += sector(disc, sl_addd(a, sl_scaled(edge, leave)), b);
    return area;
}

/* The plane cuts the sphere in a disc; the share of the triangle inside it is the same before and after stretching. */
double sl_triangle_in_ellipsoid(const sl_ellipsoid *e, sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    double area = 0.5 * sl_lengthd(sl_crossd(sl_subd(b, a), sl_subd(c, a))), radius_squared = e->radius * e->radius;
    sl_vec3d p[3] = {stretched(e, a), stretched(e, b), stretched(e, c)};
    if (!(area > 0.0) || !(area <= DBL_MAX)) return 0.0;
    double farthest = fmax(sl_dotd(p[0], p[0]), fmax(sl_dotd(p[1], p[1]), sl_dotd(p[2], p[2])));
    if (farthest <= radius_squared) return area;

    sl_vec3d across = sl_crossd(sl_subd(p[1], p[0]), sl_subd(p[2], p[0]));
    double twice = sl_lengthd(across);
    if (!(twice > 0.0) || !(twice <= DBL_MAX)) return 0.0;
    flat_disc disc = {.normal = sl_scaled(across, 1.0 / twice)};
    double height = sl_dotd(p[0], disc.normal);
    disc.radius_squared = radius_squared - height * height;
    if (!(disc.radius_squared > 0.0)) return 0.0;
    for (int k = 0; k < 3; k++) p[k] = sl_subd(p[k], sl_scaled(disc.normal, height));
    double inside = under_edge(&disc, p[0], p[1]) + under_edge(&disc, p[1], p[2]) + under_edge(&disc, p[2], p[0]);
    double share = inside / (0.5 * twice);
    return share > 0.0 ? area * (share < 1.0 ? share : 1.0) : 0.0;
}
