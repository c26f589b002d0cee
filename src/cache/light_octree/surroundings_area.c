/* Over how much surface an ellipsoid's photons were strewn (SL_PHOTON_AREA_CLIP): a visit to the nodes that
 * its box meets, and to the triangles in them. */
#include "cache/light_octree/surroundings.h"

#include <string.h>

#include "cache/light_octree/triangle_cells.h"

typedef struct search {
    const sl_surroundings *s;
    const sl_ellipsoid *e;
    sl_vec3d half;           /* half the ellipsoid's box */
    sl_vec3d low, high;      /* that box in units of the root cube */
    double hidden[2];        /* of the disc, by what no photon is stored on: in front, behind */
    sl_surfel_sums sums;     /* heights are those of the triangles' planes above the centre */
    bool points;             /* small triangles count as points */
    int last_level;          /* nodes of that level are small against the ellipsoid: taken whole */
    double least_cosine;
    bool has_normal;
    sl_surfel_query small;
    sl_surroundings_marks *marks;
} search;

/* ---- triangles ---- */

static inline bool beyond(double a, double b, double c, double half) {
    return (a > half && b > half && c > half) || (a < -half && b < -half && c < -half);
}

/* Outside the ellipsoid's box, or of a plane that misses it: its extent along n is R sqrt(1 - (1 - f^2)
 * cos^2). */
static bool misses(const search *q, const sl_vec3d corner[3], double height, double cosine) {
    const sl_vec3d a = corner[0], b = corner[1], c = corner[2];
    double f = q->e->flatness;
    if (height * height >
        q->e->radius * q->e->radius * (1.0 - (1.0 - f * f) * cosine * cosine) * (1.0 + 1e-6))
        return true;
    return beyond(a.x, b.x, c.x, q->half.x) || beyond(a.y, b.y, c.y, q->half.y) ||
           beyond(a.z, b.z, c.z, q->half.z);
}

static void add_area(search *q, double area, double cosine, double height) {
    sl_surfel_sums *sums = &q->sums;
    if (!(area > 0.0)) return;
    if (q->has_normal && cosine < 0.0) {
        sums->back += area;
        sums->back_flat -= area * cosine;
        sums->back_height += area * height;
    } else {
        sums->front += area;
        sums->front_flat += area * cosine;
        sums->front_height += area * height;
    }
}

static void visit_triangle(search *q, uint32_t t) {
    const sl_scene *scene = q->s->scene;
    const sl_ellipsoid *e = q->e;
    sl_vec3d n = sl_to_double(sl_scene_geometric_normal(scene, t)), corner[3];
    double cosine = sl_dotd(n, e->normal);
    if (q->has_normal && fabs(cosine) < q->least_cosine) return;
    double share = q->s->octree->share ? (double)q->s->octree->share[t] : 1.0;
    bool hiding =
        share == 0.0 && q->has_normal && !sl_takes_photons(&scene->materials[scene->material_index[t]]);
    if (!(share > 0.0) && !hiding) return;
    for (int k = 0; k < 3; k++)
        corner[k] = sl_subd(sl_to_double(sl_scene_position(scene, scene->vertex[k][t])), e->centre);
    double height = sl_dotd(n, corner[0]);
    if (misses(q, corner, height, cosine)) return;
    sl_ellipsoid at_origin = *e;
    at_origin.centre = sl_v3d(0.0, 0.0, 0.0);
    double area = sl_triangle_in_ellipsoid(&at_origin, corner[0], corner[1], corner[2]);
    if (hiding) q->hidden[cosine < 0.0] += fabs(cosine) * area;
    else add_area(q, share * area, cosine, q->has_normal ? height / cosine : 0.0);
}

static void visit_list(search *q, const uint32_t *triangle, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        if (q->marks->mark[triangle[i]] == q->marks->query) continue;
        q->marks->mark[triangle[i]] = q->marks->query;
        visit_triangle(q, triangle[i]);
    }
}

/* ---- nodes ---- */

static bool meets(const search *q, const double low[3], const double high[3]) {
    return low[0] <= q->high.x && high[0] >= q->low.x && low[1] <= q->high.y && high[1] >= q->low.y &&
           low[2] <= q->high.z && high[2] >= q->low.z;
}

static void visit_leaf(search *q, uint32_t leaf) {
    const sl_surroundings *s = q->s;
    uint32_t begin = s->octree->leaf[leaf].first_triangle, large = s->end_of_large[leaf],
             end = begin + s->octree->leaf[leaf].triangle_count;
    const uint32_t *surfel = s->first_surfel + leaf;
    visit_list(q, s->triangle + begin, (q->points ? large : end) - begin);
    if (q->points && surfel[0] < surfel[1]) s->kernel(&s->surfels, surfel[0], surfel[1], &q->small, &q->sums);
}

static void visit_node(search *q, int level, uint32_t node) {
    uint32_t cell[3];
    sl_morton_decode(q->s->code[level][node], cell);
    double edge = 1.0 / (double)(1u << level), low[3], high[3];
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = cell[axis] * edge;
        high[axis] = (cell[axis] + 1) * edge;
    }
    if (!meets(q, low, high)) return;
    if (level < q->last_level) {
        const uint32_t *children = q->s->first_child[level];
        for (uint32_t child = children[node]; child < children[node + 1]; child++)
            visit_node(q, level + 1, child);
        return;
    }
    uint32_t first = node, end = node + 1;
    for (int below = level; below < q->s->octree->depth; below++) {
        first = q->s->first_child[below][first];
        end = q->s->first_child[below][end];
    }
    for (uint32_t leaf = first; leaf < end; leaf++) visit_leaf(q, leaf);
}

/* ---- ellipsoids ---- */

/* Half the ellipsoid's extent along an axis that has that cosine to its short one: R sqrt(1 - (1 - f^2)
 * cos^2). */
static double extent(const sl_ellipsoid *e, double cosine) {
    double square = 1.0 - (1.0 - e->flatness * e->flatness) * cosine * cosine;
    return e->radius * sqrt(square > 0.0 ? square : 0.0);
}

static void find_box(search *q) {
    const sl_octree *octree = q->s->octree;
    const sl_ellipsoid *e = q->e;
    double scale = 1.0 / octree->edge, slack = 1e-6 / (double)(1u << octree->depth);
    sl_vec3d half = sl_v3d(extent(e, e->normal.x), extent(e, e->normal.y), extent(e, e->normal.z)),
             margin = sl_v3d(slack, slack, slack);
    q->half = sl_scaled(half, 1.0 + 1e-6);
    q->low = sl_subd(sl_scaled(sl_subd(sl_subd(e->centre, half), octree->origin), scale), margin);
    q->high = sl_addd(sl_scaled(sl_subd(sl_addd(e->centre, half), octree->origin), scale), margin);
}

/* Seen along its normal the ellipsoid is a disc: what projects onto more than that lies in layers, a floor
 * below its boards, and photons met but one of them; of a ceiling with a black lamp on it, what the lamp
 * leaves free. */
static void one_layer(const sl_ellipsoid *e, double hidden, double *area, double *flat) {
    double disc = sl_disc_area(e), least = 0.01 * disc, free = disc - hidden > least ? disc - hidden : least;
    if (!(*flat > free)) return;
    *area *= free / *flat;
    *flat = free;
}

/* Both windings at one height are one sheet whose triangles turn either way. */
static sl_strewn_area strewn_over(const search *q) {
    const sl_surfel_sums *sums = &q->sums;
    sl_strewn_area a = {.front = sums->front, .back = sums->back};
    bool both = a.front > 0.1 * a.back && a.back > 0.1 * a.front;
    a.sheet = !both || fabs(sums->front_height / a.front - sums->back_height / a.back) < 1e-3 * q->e->radius;
    if (!q->has_normal) return a;
    a.front_flat = sums->front_flat;
    a.back_flat = sums->back_flat;
    one_layer(q->e, q->hidden[0], &a.front, &a.front_flat);
    one_layer(q->e, q->hidden[1], &a.back, &a.back_flat);
    return a;
}

sl_strewn_area sl_surroundings_area(const sl_surroundings *s, const sl_ellipsoid *e, double least_cosine,
                                    sl_surroundings_marks *marks) {
    search q = {.s = s, .e = e, .least_cosine = least_cosine, .marks = marks};
    q.has_normal = sl_dotd(e->normal, e->normal) > 0.0;
    q.points = e->radius * e->flatness >= s->small_edge;
    q.small = (sl_surfel_query){.centre = sl_to_float(e->centre),
                                .normal = sl_to_float(e->normal),
                                .stretch = (float)(1.0 / (e->flatness * e->flatness) - 1.0),
                                .limit = (float)(e->radius * e->radius),
                                .least_cosine = q.has_normal ? (float)least_cosine : -1.0f};
    find_box(&q);
    if (++marks->query == 0) { /* all numbers used up */
        memset(marks->mark, 0, s->scene->triangle_count * sizeof *marks->mark);
        marks->query = 1;
    }
    while (q.last_level < s->octree->depth &&
           s->octree->edge > 0.5 * e->radius * (double)(1u << q.last_level))
        q.last_level++;
    if (s->count[0] > 0) visit_node(&q, 0, 0);
    return strewn_over(&q);
}
