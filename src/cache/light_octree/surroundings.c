#include "cache/light_octree/surroundings.h"

#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/light_octree/triangle_cells.h"

/* ---- the nodes ---- */

static sl_status make_level(sl_surroundings *s, int level, sl_error *error) {
    const uint32_t *below = s->code[level + 1];
    size_t count = 0, children = s->count[level + 1];
    for (size_t i = 0; i < children; i++) count += i == 0 || below[i] >> 3 != below[i - 1] >> 3;
    s->count[level] = count;
    s->code[level] = sl_allocate(count, sizeof **s->code);
    s->first_child[level] = sl_allocate(count + 1, sizeof **s->first_child);
    if (!s->code[level] || !s->first_child[level]) return sl_fail_memory(error, "the octree's nodes");
    size_t node = 0;
    for (size_t i = 0; i < children; i++) {
        if (i > 0 && below[i] >> 3 == below[i - 1] >> 3) continue;
        s->code[level][node] = below[i] >> 3;
        s->first_child[level][node++] = (uint32_t)i;
    }
    s->first_child[level][count] = (uint32_t)children;
    return SL_OK;
}

/* ---- small triangles ---- */

enum { LEAVES_A_TASK = 256 };

/* Of each leaf: how many of its triangles are small and its own, how many are large. */
typedef struct surfel_task {
    sl_surroundings *s;
    bool fill;
} surfel_task;

static sl_vec3d corner_of(const sl_surroundings *s, int k, uint32_t t) {
    return sl_to_double(sl_scene_position(s->scene, s->scene->vertex[k][t]));
}

static bool is_small(const sl_surroundings *s, sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    double limit = s->small_edge * s->small_edge;
    sl_vec3d ab = sl_subd(b, a), bc = sl_subd(c, b), ca = sl_subd(a, c);
    return sl_dotd(ab, ab) <= limit && sl_dotd(bc, bc) <= limit && sl_dotd(ca, ca) <= limit;
}

/* No photon is stored on it, and none on what it lies on. */
static bool hides(const sl_surroundings *s, uint32_t t) { return !sl_takes_photons(&s->scene->materials[s->scene->material_index[t]]); }

static void put_surfel(sl_surroundings *s, size_t at, uint32_t triangle, sl_vec3 centre, double area) {
    sl_vec3 n = sl_scene_geometric_normal(s->scene, triangle);
    double share = s->octree->share ? (double)s->octree->share[triangle] : 1.0;
    const float values[7] = {centre.x, centre.y, centre.z, n.x, n.y, n.z, (float)(area * share)};
    float *const planes[7] = {s->surfels.x, s->surfels.y, s->surfels.z, s->surfels.normal_x, s->surfels.normal_y, s->surfels.normal_z,
                              s->surfels.area};
    for (int k = 0; k < 7; k++) planes[k][at] = values[k];
}

static void sort_leaf(const surfel_task *task, size_t index) {
    sl_surroundings *s = task->s;
    const sl_octree_leaf *leaf = &s->octree->leaf[index];
    uint32_t small = 0, large = 0;
    for (uint32_t i = 0; i < leaf->triangle_count; i++) {
        uint32_t t = s->octree->triangle[leaf->first_triangle + i];
        sl_vec3d a = corner_of(s, 0, t), b = corner_of(s, 1, t), c = corner_of(s, 2, t);
        if (!is_small(s, a, b, c) || hides(s, t)) {
            if (task->fill) s->large[s->first_large[index] + large] = t;
            large++;
            continue;
        }
        sl_vec3 centre = sl_to_float(sl_scaled(sl_addd(sl_addd(a, b), c), 1.0 / 3.0));
        if (sl_octree_morton_at(s->octree, centre) != leaf->morton) continue;
        if (task->fill) {
            put_surfel(s, s->first_surfel[index] + small, t, centre, 0.5 * sl_lengthd(sl_crossd(sl_subd(b, a), sl_subd(c, a))));
        }
        small++;
    }
    if (task->fill) return;
    s->first_surfel[index + 1] = (small + SL_SURFEL_LANES - 1) / SL_SURFEL_LANES * SL_SURFEL_LANES;
    s->first_large[index + 1] = large;
}

static void sort_leaves(void *context, size_t index, unsigned worker) {
    (void)worker;
    const surfel_task *task = context;
    size_t end = (index + 1) * LEAVES_A_TASK < task->s->octree->leaf_count ? (index + 1) * LEAVES_A_TASK : task->s->octree->leaf_count;
    for (size_t i = index * LEAVES_A_TASK; i < end; i++) sort_leaf(task, i);
}

/* Counts, prefix sums, then the values. */
static sl_status make_surfels(sl_surroundings *s, unsigned threads, sl_error *error) {
    size_t leaves = s->octree->leaf_count, tasks = (leaves + LEAVES_A_TASK - 1) / LEAVES_A_TASK;
    s->first_surfel = sl_allocate(leaves + 1, sizeof *s->first_surfel);
    s->first_large = sl_allocate(leaves + 1, sizeof *s->first_large);
    if (!s->first_surfel || !s->first_large) return sl_fail_memory(error, "the octree's triangles");
    surfel_task task = {s, false};
    sl_parallel_for(threads, tasks, sort_leaves, &task);
    uint64_t surfels = 0;
    for (size_t i = 0; i < leaves; i++) {
        surfels += s->first_surfel[i + 1];
        s->first_surfel[i + 1] += s->first_surfel[i];
        s->first_large[i + 1] += s->first_large[i];
    }
    if (surfels > UINT32_MAX) return sl_fail_memory(error, "the octree's triangles");
    s->large = sl_allocate(s->first_large[leaves], sizeof *s->large);
    s->surfels.x = sl_allocate(7 * (size_t)surfels, sizeof *s->surfels.x);
    if (!s->large || !s->surfels.x) return sl_fail_memory(error, "the octree's triangles");
    float **const planes[6] = {&s->surfels.y,        &s->surfels.z,        &s->surfels.normal_x,
                               &s->surfels.normal_y, &s->surfels.normal_z, &s->surfels.area};
    for (size_t k = 0; k < 6; k++) *planes[k] = s->surfels.x + (k + 1) * (size_t)surfels;
    task.fill = true;
    sl_parallel_for(threads, tasks, sort_leaves, &task);
    return SL_OK;
}

/* ---- creating ---- */

sl_status sl_surroundings_create(const sl_scene *scene, const sl_octree *octree, double small_edge, unsigned threads,
                                 sl_surroundings **result, sl_error *error) {
    *result = NULL;
    sl_surroundings *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the octree's nodes");
    *s = (sl_surroundings){.scene = scene, .octree = octree, .small_edge = small_edge};
    s->kernel = sl_surfel_kernel_for(sl_isa_best());
    int depth = octree->depth;
    s->count[depth] = octree->leaf_count;
    s->code[depth] = sl_allocate(octree->leaf_count, sizeof **s->code);
    sl_status status = s->code[depth] ? SL_OK : sl_fail_memory(error, "the octree's nodes");
    for (size_t i = 0; status == SL_OK && i < octree->leaf_count; i++) s->code[depth][i] = (uint32_t)octree->leaf[i].morton;
    for (int level = depth - 1; status == SL_OK && level >= 0; level--) status = make_level(s, level, error);
    if (status == SL_OK) status = make_surfels(s, threads, error);
    if (status != SL_OK) sl_surroundings_destroy(s);
    else *result = s;
    return status;
}

void sl_surroundings_destroy(sl_surroundings *s) {
    if (!s) return;
    for (int level = 0; level <= SL_OCTREE_DEPTH_MAX; level++) {
        sl_free(s->code[level]);
        sl_free(s->first_child[level]);
    }
    sl_free(s->surfels.x);
    sl_free(s->first_surfel);
    sl_free(s->first_large);
    sl_free(s->large);
    sl_free(s);
}

size_t sl_surroundings_bytes(const sl_surroundings *s) {
    size_t bytes = sizeof *s;
    for (int level = 0; level <= s->octree->depth; level++) bytes += (2 * s->count[level] + 1) * sizeof(uint32_t);
    size_t leaves = s->octree->leaf_count;
    return bytes + (2 * leaves + 2 + s->first_large[leaves] + 7 * (size_t)s->first_surfel[leaves]) * sizeof(uint32_t);
}

/* ---- one ellipsoid ---- */

typedef struct search {
    const sl_surroundings *s;
    const sl_ellipsoid *e;
    sl_vec3d reach;          /* half the ellipsoid's box */
    sl_vec3d low, high;      /* that box in units of the root cube */
    int last_level;          /* nodes of that level are small against the ellipsoid: taken whole */
    double least_cosine, stretch; /* stretch: 1/f^2 - 1 */
    bool has_normal, exact;
    sl_surfel_query small;
    sl_surroundings_marks *marks;
    sl_surfel_sums sums;     /* heights are those of the triangles' planes above the centre */
    double hidden[2];        /* of the disc, by what no photon is stored on: in front, behind */
} search;

/* delta^2, about the centre. */
static inline double metric(const search *q, sl_vec3d p) {
    double u = sl_dotd(p, q->e->normal);
    return sl_dotd(p, p) + q->stretch * u * u;
}

static double area_inside(const search *q, sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    double limit = q->e->radius * q->e->radius;
    if (metric(q, a) <= limit && metric(q, b) <= limit && metric(q, c) <= limit) { /* convex */
        return 0.5 * sl_lengthd(sl_crossd(sl_subd(b, a), sl_subd(c, a)));
    }
    sl_ellipsoid at_origin = *q->e;
    at_origin.centre = sl_v3d(0.0, 0.0, 0.0);
    return sl_triangle_in_ellipsoid(&at_origin, a, b, c);
}

static inline bool beyond(double a, double b, double c, double reach) {
    return (a > reach && b > reach && c > reach) || (a < -reach && b < -reach && c < -reach);
}

/* Outside the ellipsoid's box, or of a plane that misses it: its extent along n is R sqrt(1 - (1 - f^2) cos^2). */
static bool misses(const search *q, sl_vec3d a, sl_vec3d b, sl_vec3d c, sl_vec3d n, double cosine) {
    double height = sl_dotd(n, a), f = q->e->flatness;
    if (height * height > q->e->radius * q->e->radius * (1.0 - (1.0 - f * f) * cosine * cosine) * (1.0 + 1e-6)) return true;
    return beyond(a.x, b.x, c.x, q->reach.x) || beyond(a.y, b.y, c.y, q->reach.y) || beyond(a.z, b.z, c.z, q->reach.z);
}

static void visit_triangle(search *q, uint32_t t) {
    const sl_scene *scene = q->s->scene;
    sl_vec3d n = sl_to_double(sl_scene_geometric_normal(scene, t));
    double cosine = sl_dotd(n, q->e->normal);
    if (q->has_normal && fabs(cosine) < q->least_cosine) return;
    double share = q->s->octree->share ? (double)q->s->octree->share[t] : 1.0;
    bool hiding = share == 0.0 && q->has_normal && hides(q->s, t);
    if (!(share > 0.0) && !hiding) return;
    sl_vec3d a = sl_subd(corner_of(q->s, 0, t), q->e->centre), b = sl_subd(corner_of(q->s, 1, t), q->e->centre),
             c = sl_subd(corner_of(q->s, 2, t), q->e->centre);
    if (misses(q, a, b, c, n, cosine)) return;
    if (hiding) {
        q->hidden[cosine < 0.0] += fabs(cosine) * area_inside(q, a, b, c);
        return;
    }
    double area = share * area_inside(q, a, b, c);
    if (!(area > 0.0)) return;
    double height = q->has_normal ? sl_dotd(n, a) / cosine : 0.0;
    if (q->has_normal && cosine < 0.0) {
        q->sums.back += area;
        q->sums.back_flat -= area * cosine;
        q->sums.back_height += area * height;
    } else {
        q->sums.front += area;
        q->sums.front_flat += area * cosine;
        q->sums.front_height += area * height;
    }
}

static void visit_list(search *q, const uint32_t *triangle, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        if (q->marks->mark[triangle[i]] == q->marks->query) continue;
        q->marks->mark[triangle[i]] = q->marks->query;
        visit_triangle(q, triangle[i]);
    }
}

/* Leaves in Morton order: what a node holds stands together. */
static void visit_leaves(search *q, uint32_t first, uint32_t end) {
    const sl_surroundings *s = q->s;
    if (q->exact) {
        const sl_octree_leaf *last = &s->octree->leaf[end - 1];
        uint32_t from = s->octree->leaf[first].first_triangle;
        visit_list(q, s->octree->triangle + from, last->first_triangle + last->triangle_count - from);
        return;
    }
    visit_list(q, s->large + s->first_large[first], s->first_large[end] - s->first_large[first]);
    s->kernel(&s->surfels, s->first_surfel[first], s->first_surfel[end], &q->small, &q->sums);
}

static void visit_node(search *q, int level, uint32_t node) {
    uint32_t cell[3];
    sl_morton_decode(q->s->code[level][node], cell);
    double edge = 1.0 / (double)(1u << level);
    if (cell[0] * edge > q->high.x || (cell[0] + 1) * edge < q->low.x || cell[1] * edge > q->high.y || (cell[1] + 1) * edge < q->low.y ||
        cell[2] * edge > q->high.z || (cell[2] + 1) * edge < q->low.z) {
        return;
    }
    if (level < q->last_level) {
        const uint32_t *children = q->s->first_child[level];
        for (uint32_t child = children[node]; child < children[node + 1]; child++) visit_node(q, level + 1, child);
        return;
    }
    uint32_t first = node, end = node + 1;
    for (int below = level; below < q->s->octree->depth; below++) {
        first = q->s->first_child[below][first];
        end = q->s->first_child[below][end];
    }
    visit_leaves(q, first, end);
}

/* Half the ellipsoid's extent along an axis that has that cosine to its short one: R sqrt(1 - (1 - f^2) cos^2). */
static double extent(const sl_ellipsoid *e, double cosine) {
    double square = 1.0 - (1.0 - e->flatness * e->flatness) * cosine * cosine;
    return e->radius * sqrt(square > 0.0 ? square : 0.0);
}

/* Seen along its normal the ellipsoid is a disc: what projects onto more than that lies in layers, a floor below its boards, and photons
 * met but one of them; of a ceiling with a black lamp on it, what the lamp leaves free. */
static void one_layer(const sl_ellipsoid *e, double hidden, double *area, double *flat) {
    double disc = sl_disc_area(e), least = 0.01 * disc, free = disc - hidden > least ? disc - hidden : least;
    if (!(*flat > free)) return;
    *area *= free / *flat;
    *flat = free;
}

sl_strewn_area sl_surroundings_area(const sl_surroundings *s, const sl_ellipsoid *e, double least_cosine, sl_surroundings_marks *marks) {
    search q = {.s = s, .e = e, .least_cosine = least_cosine, .stretch = 1.0 / (e->flatness * e->flatness) - 1.0, .marks = marks};
    q.has_normal = sl_dotd(e->normal, e->normal) > 0.0;
    q.exact = !(e->radius * e->flatness >= s->small_edge);
    q.small = (sl_surfel_query){sl_to_float(e->centre), sl_to_float(e->normal), (float)q.stretch, (float)(e->radius * e->radius),
                                q.has_normal ? (float)least_cosine : -1.0f};
    if (++marks->query == 0) { /* all numbers used up */
        memset(marks->mark, 0, s->scene->triangle_count * sizeof *marks->mark);
        marks->query = 1;
    }
    sl_vec3d reach = sl_v3d(extent(e, e->normal.x), extent(e, e->normal.y), extent(e, e->normal.z));
    q.reach = sl_scaled(reach, 1.0 + 1e-6);
    while (q.last_level < s->octree->depth && s->octree->edge > 0.5 * e->radius * (double)(1u << q.last_level)) q.last_level++;
    double scale = 1.0 / s->octree->edge, slack = 1e-6 / (double)(1u << s->octree->depth);
    sl_vec3d margin = sl_v3d(slack, slack, slack);
    q.low = sl_subd(sl_scaled(sl_subd(sl_subd(e->centre, reach), s->octree->origin), scale), margin);
    q.high = sl_addd(sl_scaled(sl_subd(sl_addd(e->centre, reach), s->octree->origin), scale), margin);
    if (s->count[0] > 0) visit_node(&q, 0, 0);
    /* Both windings at one height are one sheet whose triangles turn either way. */
    double front = q.sums.front, back = q.sums.back, front_flat = 0.0, back_flat = 0.0;
    bool both = front > 0.1 * back && back > 0.1 * front;
    bool sheet = !both || fabs(q.sums.front_height / front - q.sums.back_height / back) < 1e-3 * e->radius;
    if (q.has_normal) {
        front_flat = q.sums.front_flat;
        back_flat = q.sums.back_flat;
        one_layer(e, q.hidden[0], &front, &front_flat);
        one_layer(e, q.hidden[1], &back, &back_flat);
    }
    return (sl_strewn_area){front, back, sheet, front_flat, back_flat};
}
