#include "cache/light_octree/photon_area.h"

#include <string.h>

#include "base/math.h"

static const double flatness_least = 1e-3; /* as photon_tree.c has it */

static bool is_sphere(const sl_ellipsoid *e) { return !(sl_dotd(e->normal, e->normal) > 0.0); }

static double flatness_of(const sl_ellipsoid *e) {
    if (is_sphere(e) || !(e->flatness < 1.0)) return 1.0;
    return e->flatness > flatness_least ? e->flatness : flatness_least;
}

/* ---- disc and section ---- */

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

/* ---- a triangle ---- */

/* Stretches by 1 / f along the short axis: the ellipsoid becomes a sphere about the origin. */
static sl_vec3d stretched(const sl_ellipsoid *e, sl_vec3d p) {
    sl_vec3d q = sl_subd(p, e->centre);
    if (is_sphere(e)) return q;
    return sl_addd(q, sl_scaled(e->normal, (1.0 / flatness_of(e) - 1.0) * sl_dotd(q, e->normal)));
}

static double sector(sl_vec3d normal, double radius_squared, sl_vec3d p, sl_vec3d q) {
    return 0.5 * radius_squared * sl_atan2(sl_dotd(sl_crossd(p, q), normal), sl_dotd(p, q));
}

/* The disc's part of the triangle (origin, a, b), negative where they go clockwise: a triangle over the piece
 * of the edge inside, sectors over those outside. */
static double under_edge(sl_vec3d normal, double radius_squared, sl_vec3d a, sl_vec3d b) {
    sl_vec3d along = sl_subd(b, a);
    double length_squared = sl_dotd(along, along);
    if (!(length_squared > 0.0)) return 0.0;
    double nearest = -sl_dotd(a, along) / length_squared;
    sl_vec3d foot = sl_addd(a, sl_scaled(along, nearest));
    double left = radius_squared - sl_dotd(foot, foot);
    if (!(left > 0.0)) return sector(normal, radius_squared, a, b);
    double half = sqrt(left / length_squared), enter = sl_clamp_unit(nearest - half),
           leave = sl_clamp_unit(nearest + half);
    if (!(enter < leave)) return sector(normal, radius_squared, a, b);
    double area = 0.5 * (leave - enter) * sl_dotd(sl_crossd(foot, along), normal);
    if (enter > 0.0) area += sector(normal, radius_squared, a, sl_addd(a, sl_scaled(along, enter)));
    if (leave < 1.0) area += sector(normal, radius_squared, sl_addd(a, sl_scaled(along, leave)), b);
    return area;
}

/* The stretched triangle's plane cuts the sphere in a disc; the share of the triangle inside that disc is the
 * same before and after stretching. */
double sl_triangle_in_ellipsoid(const sl_ellipsoid *e, sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    double area = 0.5 * sl_lengthd(sl_crossd(sl_subd(b, a), sl_subd(c, a))), farthest = 0.0, inside = 0.0;
    if (!(area > 0.0 && area <= DBL_MAX)) return 0.0;
    sl_vec3d p[3] = {stretched(e, a), stretched(e, b), stretched(e, c)};
    for (int k = 0; k < 3; k++) farthest = fmax(farthest, sl_dotd(p[k], p[k]));
    if (farthest <= e->radius * e->radius) return area;
    sl_vec3d across = sl_crossd(sl_subd(p[1], p[0]), sl_subd(p[2], p[0]));
    double twice = sl_lengthd(across);
    if (!(twice > 0.0 && twice <= DBL_MAX)) return 0.0;
    sl_vec3d normal = sl_scaled(across, 1.0 / twice);
    double height = sl_dotd(p[0], normal), disc = e->radius * e->radius - height * height;
    if (!(disc > 0.0)) return 0.0;
    for (int k = 0; k < 3; k++) p[k] = sl_subd(p[k], sl_scaled(normal, height));
    for (int k = 0; k < 3; k++) inside += under_edge(normal, disc, p[k], p[k < 2 ? k + 1 : 0]);
    double share = inside / (0.5 * twice);
    return share > 0.0 ? area * (share < 1.0 ? share : 1.0) : 0.0;
}

/* ---- all triangles: a visit to the octree's cells that the ellipsoid's box meets ---- */

typedef struct search {
    const sl_scene *scene;
    const sl_octree *octree;
    const sl_ellipsoid *e;
    sl_ellipsoid at_origin;
    sl_vec3d half;                /* half the ellipsoid's box */
    double low[3], high[3];       /* that box in units of the root cube */
    double least_cosine;
    bool has_normal;
    /* in front and behind: area, projected along the normal, and times its plane's height above the centre */
    double area[2], flat[2], height[2];
    sl_triangle_marks *marks;
} search;

static inline bool beyond(double a, double b, double c, double half) {
    return (a > half && b > half && c > half) || (a < -half && b < -half && c < -half);
}

/* Half the ellipsoid's extent along an axis that has that cosine to its short one, squared: R^2 (1 - (1 -
 * f^2) cos^2). */
static double extent_squared(const sl_ellipsoid *e, double cosine) {
    double share = 1.0 - (1.0 - e->flatness * e->flatness) * cosine * cosine;
    return e->radius * e->radius * (share > 0.0 ? share : 0.0);
}

/* Outside the ellipsoid's box, or of a plane that misses it. */
static bool misses(const search *q, const sl_vec3d corner[3], double height, double cosine) {
    const sl_vec3d a = corner[0], b = corner[1], c = corner[2];
    return height * height > extent_squared(q->e, cosine) * (1.0 + 1e-6) ||
           beyond(a.x, b.x, c.x, q->half.x) || beyond(a.y, b.y, c.y, q->half.y) ||
           beyond(a.z, b.z, c.z, q->half.z);
}

static void visit_triangle(search *q, uint32_t t) {
    const sl_scene *scene = q->scene;
    sl_vec3d n = sl_to_double(sl_scene_geometric_normal(scene, t)), corner[3];
    double cosine = sl_dotd(n, q->e->normal);
    if (!sl_takes_photons(sl_triangle_material(scene, t))) return;
    if (q->has_normal && fabs(cosine) < q->least_cosine) return;
    for (int k = 0; k < 3; k++)
        corner[k] = sl_subd(sl_to_double(sl_scene_position(scene, scene->vertex[k][t])), q->e->centre);
    double height = sl_dotd(n, corner[0]);
    if (misses(q, corner, height, cosine)) return;
    double area = sl_triangle_in_ellipsoid(&q->at_origin, corner[0], corner[1], corner[2]);
    if (!(area > 0.0)) return;
    int side = q->has_normal && cosine < 0.0;
    q->area[side] += area;
    q->flat[side] += area * fabs(cosine);
    q->height[side] += q->has_normal ? area * (height / cosine) : 0.0;
}

static void visit_leaf(search *q, const sl_octree_leaf *leaf) {
    const uint32_t *triangle = q->octree->triangle + leaf->first_triangle;
    for (uint32_t i = 0; i < leaf->triangle_count; i++) {
        if (q->marks->mark[triangle[i]] == q->marks->query) continue;
        q->marks->mark[triangle[i]] = q->marks->query;
        visit_triangle(q, triangle[i]);
    }
}

/* Visits the leaves from `first` to `end`, those of one cell of that level. */
static void visit_cell(search *q, int level, uint64_t code, size_t first, size_t end) {
    uint32_t cell[3];
    sl_morton_decode(code, cell);
    double edge = 1.0 / (double)(1u << level);
    for (int axis = 0; axis < 3; axis++) {
        if (cell[axis] * edge > q->high[axis] || (cell[axis] + 1) * edge < q->low[axis]) return;
    }
    if (level == q->octree->depth) {
        visit_leaf(q, &q->octree->leaf[first]);
        return;
    }
    int shift = 3 * (q->octree->depth - level - 1);
    while (first < end) {
        uint64_t child = q->octree->leaf[first].morton >> shift;
        size_t next = sl_octree_lower_bound(q->octree, first, end, (child + 1) << shift);
        visit_cell(q, level + 1, child, first, next);
        first = next;
    }
}

static void find_box(search *q) {
    const sl_octree *octree = q->octree;
    const double normal[3] = {q->e->normal.x, q->e->normal.y, q->e->normal.z},
                 centre[3] = {q->e->centre.x, q->e->centre.y, q->e->centre.z},
                 origin[3] = {octree->origin.x, octree->origin.y, octree->origin.z};
    double half[3], slack = 1e-6 / (double)(1u << octree->depth);
    for (int k = 0; k < 3; k++) {
        half[k] = sqrt(extent_squared(q->e, normal[k]));
        q->low[k] = (centre[k] - half[k] - origin[k]) / octree->edge - slack;
        q->high[k] = (centre[k] + half[k] - origin[k]) / octree->edge + slack;
    }
    q->half = sl_scaled(sl_v3d(half[0], half[1], half[2]), 1.0 + 1e-6);
}

/* Tells whether the triangles turned either way are one sheet, at one height, to be seen from both sides. */
static bool is_sheet(const search *q) {
    const double front = q->area[0], back = q->area[1];
    bool both = front > 0.1 * back && back > 0.1 * front;
    return !both || fabs(q->height[0] / front - q->height[1] / back) < 1e-3 * q->e->radius;
}

/* Seen along its normal the ellipsoid is a disc: what projects onto more than that lies in layers, a floor
 * below its boards or a face modelled twice, and photons met but one of them. */
static sl_strewn_area strewn_over(const search *q, bool by_side) {
    sl_strewn_area a = {.side = {q->area[0], q->area[1]}, .flat = {q->flat[0], q->flat[1]}};
    a.together = !by_side || is_sheet(q);
    if (a.together) {
        a.side[0] = a.side[1] = q->area[0] + q->area[1];
        a.flat[0] = a.flat[1] = q->flat[0] + q->flat[1];
    }
    for (int side = 0; q->has_normal && side < 2; side++) {
        if (!(a.flat[side] > sl_disc_area(q->e))) continue;
        a.side[side] *= sl_disc_area(q->e) / a.flat[side];
        a.flat[side] = sl_disc_area(q->e);
    }
    return a;
}

sl_strewn_area sl_surface_in_ellipsoid(const sl_scene *scene, const sl_octree *octree, const sl_ellipsoid *e,
                                       double least_cosine, sl_triangle_marks *marks) {
    search q = {.scene = scene,
                .octree = octree,
                .e = e,
                .at_origin = *e,
                .least_cosine = least_cosine,
                .has_normal = !is_sphere(e),
                .marks = marks};
    q.at_origin.centre = sl_v3d(0.0, 0.0, 0.0);
    find_box(&q);
    if (++marks->query == 0) { /* all numbers used up */
        memset(marks->mark, 0, scene->triangle_count * sizeof *marks->mark);
        marks->query = 1;
    }
    if (octree->leaf_count > 0) visit_cell(&q, 0, 0, 0, octree->leaf_count);
    return strewn_over(&q, least_cosine > -1.0);
}

/* ---- what photons tell of it by themselves ---- */

/* The square root of a determinant scatters by about 0.7 / sqrt(N) of itself. */
static const double clearly_less = 0.95, scatter = 1.5;
/* A few photons close together must not outshine all else. */
static const double share_least = 0.1;

double sl_strewn_share(const sl_place_sums *p, double area) {
    enum { PHOTONS_LEAST = 8 };
    if (p->count < PHOTONS_LEAST || !(area > 0.0)) return 1.0;
    double n = p->count, xx = p->xx - p->x * p->x / n, yy = p->yy - p->y * p->y / n,
           xy = p->xy - p->x * p->y / n, determinant = xx * yy - xy * xy;
    double share = 4.0 * SL_PI * sqrt(determinant > 0.0 ? determinant : 0.0) / ((n - 1.0) * area);
    if (!(share * (1.0 + scatter / sqrt(n)) < clearly_less)) return 1.0;
    return share > share_least ? share : share_least;
}
