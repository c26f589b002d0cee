#include "cache/light_octree/photon_area.h"

#include "base/math.h"

static const double flatness_least = 1e-3; /* as photon_tree.c has it */

static bool is_sphere(const sl_ellipsoid *e) { return !(sl_dotd(e->normal, e->normal) > 0.0); }

static double flatness_of(const sl_ellipsoid *e) {
    if (is_sphere(e) || !(e->flatness < 1.0)) return 1.0;
    return e->flatness > flatness_least ? e->flatness : flatness_least;
}

double sl_disc_area(const sl_ellipsoid *e) { return SL_PI * e->radius * e->radius; }

/* A = pi R^2 (1 - h^2 / (R^2 s^2)) / sqrt(cos^2 b + sin^2 b / f^2), s^2 = sin^2 b + f^2 cos^2 b, b the angle
 * between the normals. The root is s / f. */
double sl_section_area(const sl_ellipsoid *e, sl_vec3d normal, double h) {
    double f = flatness_of(e), cosine = is_sphere(e) ? 1.0 : fabs(sl_dotd(e->normal, normal));
    cosine = cosine < 1.0 ? cosine : 1.0;
    double s_squared = (1.0 - cosine * cosine) + f * f * cosine * cosine;
    double share = 1.0 - h * h / (e->radius * e->radius * s_squared);
    return share > 0.0 ? sl_disc_area(e) * share * f / sqrt(s_squared) : 0.0;
}

/* ---- a triangle ------------------------------------------------------------------------------ */

/* A triangle stretched until the ellipsoid is a sphere about the origin. */
typedef struct stretched_edge {
    sl_vec3d from, along;
    /* the point nearest to the disc's centre: where (0 to 1 is on the edge), how far */
    double length_squared, nearest, foot_squared;
    /* twice the area of the triangle that the edge makes with that centre */
    double turn;
} stretched_edge;
typedef struct stretched_triangle {
    sl_vec3d corner[3];
    /* before stretching; 0 where there is none, or it is not finite */
    double area;
    double farthest_squared;
    /* the rest is there: wanted where the sphere's surface cuts the triangle */
    bool planar;
    sl_vec3d normal;
    double twice, height_squared;                 /* twice the area; the plane's distance */
    stretched_edge edge[3];                    /* in the plane, about the foot of its normal */
    double border_squared;                        /* from there to the nearest point of an edge */
    bool around;                                  /* the foot is inside */
} stretched_triangle;

/* Where the ellipsoid is a sphere about the origin: stretched by 1 / f along the short axis. */
static sl_vec3d stretched(const sl_ellipsoid *e, sl_vec3d p) {
    sl_vec3d q = sl_subd(p, e->centre);
    if (is_sphere(e)) return q;
    return sl_addd(q, sl_scaled(e->normal, (1.0 / flatness_of(e) - 1.0) * sl_dotd(q, e->normal)));
}

static double within_edge(double t) { return t > 0.0 ? t < 1.0 ? t : 1.0 : 0.0; }

static stretched_edge edge_of(sl_vec3d a, sl_vec3d b, sl_vec3d normal) {
    stretched_edge e = {.from = a, .along = sl_subd(b, a)};
    e.length_squared = sl_dotd(e.along, e.along);
    if (!(e.length_squared > 0.0)) return e;
    e.nearest = -sl_dotd(a, e.along) / e.length_squared;
    sl_vec3d foot = sl_addd(a, sl_scaled(e.along, e.nearest));
    e.foot_squared = sl_dotd(foot, foot);
    e.turn = sl_dotd(sl_crossd(foot, e.along), normal);
    return e;
}

static stretched_triangle stretch_triangle(const sl_ellipsoid *e, sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    stretched_triangle t = {.corner = {stretched(e, a), stretched(e, b), stretched(e, c)},
                               .area = 0.5 * sl_lengthd(sl_crossd(sl_subd(b, a), sl_subd(c, a)))};
    if (!(t.area > 0.0) || !(t.area <= DBL_MAX)) t.area = 0.0;
    t.farthest_squared = fmax(sl_dotd(t.corner[0], t.corner[0]),
                              fmax(sl_dotd(t.corner[1], t.corner[1]), sl_dotd(t.corner[2], t.corner[2])));
    return t;
}

/* The plane cuts the sphere in a disc: what is the same for all radii. */
static void look_at_plane(stretched_triangle *t) {
    sl_vec3d across = sl_crossd(sl_subd(t->corner[1], t->corner[0]), sl_subd(t->corner[2], t->corner[0]));
    t->twice = sl_lengthd(across);
    t->planar = true;
    if (!(t->twice > 0.0) || !(t->twice <= DBL_MAX)) {
        t->area = 0.0;
        return;
    }
    t->normal = sl_scaled(across, 1.0 / t->twice);
    double height = sl_dotd(t->corner[0], t->normal);
    t->height_squared = height * height;
    sl_vec3d p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_subd(t->corner[k], sl_scaled(t->normal, height));
    t->border_squared = INFINITY;
    t->around = true;
    for (int k = 0; k < 3; k++) {
        stretched_edge e = edge_of(p[k], p[k < 2 ? k + 1 : 0], t->normal);
        double off = within_edge(e.nearest) - e.nearest;
        t->border_squared = fmin(t->border_squared, e.foot_squared + off * off * e.length_squared);
        t->around = t->around && e.turn > 0.0;
        t->edge[k] = e;
    }
}

static double sector(const stretched_triangle *t, double radius_squared, sl_vec3d p, sl_vec3d q) {
    return 0.5 * radius_squared * sl_atan2(sl_dotd(sl_crossd(p, q), t->normal), sl_dotd(p, q));
}

/* The disc's part of the triangle (origin, a, b), negative where they go clockwise: a triangle over the piece
 * of the edge inside, sectors over those outside. */
static double under_edge(const stretched_triangle *t, const stretched_edge *e, double radius_squared) {
    if (!(e->length_squared > 0.0)) return 0.0;
    sl_vec3d a = e->from, b = sl_addd(a, e->along);
    double left = radius_squared - e->foot_squared;
    if (!(left > 0.0)) return sector(t, radius_squared, a, b);
    double half = sqrt(left / e->length_squared), enter = within_edge(e->nearest - half),
           leave = within_edge(e->nearest + half);
    if (!(enter < leave)) return sector(t, radius_squared, a, b);
    double area = 0.5 * (leave - enter) * e->turn;
    if (enter > 0.0) area += sector(t, radius_squared, a, sl_addd(a, sl_scaled(e->along, enter)));
    if (leave < 1.0) area += sector(t, radius_squared, sl_addd(a, sl_scaled(e->along, leave)), b);
    return area;
}

/* The share of the triangle inside the disc is the same before and after stretching. */
static double inside_sphere(stretched_triangle *t, double radius) {
    double squared = radius * radius;
    if (t->farthest_squared <= squared) return t->area;
    if (!t->planar) look_at_plane(t);
    double disc = squared - t->height_squared;
    if (!(t->area > 0.0) || !(disc > 0.0) || (!t->around && t->border_squared >= disc)) return 0.0;
    double inside = under_edge(t, &t->edge[0], disc) + under_edge(t, &t->edge[1], disc) +
                    under_edge(t, &t->edge[2], disc);
    double share = inside / (0.5 * t->twice);
    return share > 0.0 ? t->area * (share < 1.0 ? share : 1.0) : 0.0;
}

double sl_triangle_in_ellipsoid(const sl_ellipsoid *e, sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    stretched_triangle t = stretch_triangle(e, a, b, c);
    return inside_sphere(&t, e->radius);
}
