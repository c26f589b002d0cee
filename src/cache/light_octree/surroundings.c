#include "cache/light_octree/surroundings.h"

#include <math.h>

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

/* ---- triangles by size ---- */

enum { LEAVES_A_TASK = 256 };

static sl_vec3d corner_of(const sl_surroundings *s, int k, uint32_t t) {
    return sl_to_double(sl_scene_position(s->scene, s->scene->vertex[k][t]));
}

/* Of a surface that takes no photon all counts exactly: nor does what it lies on. */
static bool is_small(const sl_surroundings *s, uint32_t t) {
    if (!sl_takes_photons(&s->scene->materials[s->scene->material_index[t]])) return false;
    sl_vec3d a = corner_of(s, 0, t), b = corner_of(s, 1, t), c = corner_of(s, 2, t);
    sl_vec3d ab = sl_subd(b, a), bc = sl_subd(c, b), ca = sl_subd(a, c);
    double longest = fmax(sl_dotd(ab, ab), fmax(sl_dotd(bc, bc), sl_dotd(ca, ca)));
    return longest <= s->small_edge * s->small_edge;
}

static sl_vec3 centre_of(const sl_surroundings *s, uint32_t t) {
    return sl_to_float(
        sl_scaled(sl_addd(sl_addd(corner_of(s, 0, t), corner_of(s, 1, t)), corner_of(s, 2, t)), 1.0 / 3.0));
}

/* A leaf's triangles, large ones first, and how many small ones are points of its own. */
static void sort_leaf(sl_surroundings *s, size_t index) {
    const sl_octree_leaf *leaf = &s->octree->leaf[index];
    const uint32_t *triangle = s->octree->triangle + leaf->first_triangle;
    uint32_t at = leaf->first_triangle, own = 0;
    for (uint32_t i = 0; i < leaf->triangle_count; i++) {
        if (!is_small(s, triangle[i])) s->triangle[at++] = triangle[i];
    }
    s->end_of_large[index] = at;
    for (uint32_t i = 0; i < leaf->triangle_count; i++) {
        if (!is_small(s, triangle[i])) continue;
        s->triangle[at++] = triangle[i];
        own += sl_octree_morton_at(s->octree, centre_of(s, triangle[i])) == leaf->morton;
    }
    s->first_surfel[index + 1] = (own + SL_SURFEL_LANES - 1) / SL_SURFEL_LANES * SL_SURFEL_LANES;
}

static void put_surfel(sl_surroundings *s, size_t at, uint32_t triangle, sl_vec3 centre) {
    sl_vec3 n = sl_scene_geometric_normal(s->scene, triangle);
    sl_vec3d a = corner_of(s, 0, triangle), ab = sl_subd(corner_of(s, 1, triangle), a),
             ac = sl_subd(corner_of(s, 2, triangle), a);
    double share = s->octree->share ? (double)s->octree->share[triangle] : 1.0,
           area = 0.5 * sl_lengthd(sl_crossd(ab, ac));
    const float values[7] = {centre.x, centre.y, centre.z, n.x, n.y, n.z, (float)(area * share)};
    float *const planes[7] = {s->surfels.x,        s->surfels.y,        s->surfels.z,   s->surfels.normal_x,
                              s->surfels.normal_y, s->surfels.normal_z, s->surfels.area};
    for (int k = 0; k < 7; k++) planes[k][at] = values[k];
}

static void put_surfels(sl_surroundings *s, size_t index) {
    const sl_octree_leaf *leaf = &s->octree->leaf[index];
    size_t at = s->first_surfel[index];
    for (uint32_t i = s->end_of_large[index]; i < leaf->first_triangle + leaf->triangle_count; i++) {
        sl_vec3 centre = centre_of(s, s->triangle[i]);
        if (sl_octree_morton_at(s->octree, centre) == leaf->morton)
            put_surfel(s, at++, s->triangle[i], centre);
    }
}

typedef struct leaf_task {
    sl_surroundings *s;
    void (*work)(sl_surroundings *s, size_t index);
} leaf_task;

static void for_leaves(void *context, size_t index, unsigned worker) {
    (void)worker;
    const leaf_task *task = context;
    size_t end = (index + 1) * LEAVES_A_TASK < task->s->octree->leaf_count ? (index + 1) * LEAVES_A_TASK
                                                                           : task->s->octree->leaf_count;
    for (size_t i = index * LEAVES_A_TASK; i < end; i++) task->work(task->s, i);
}

/* Counts, prefix sums, then the values. */
static sl_status make_surfels(sl_surroundings *s, unsigned threads, sl_error *error) {
    size_t leaves = s->octree->leaf_count, tasks = (leaves + LEAVES_A_TASK - 1) / LEAVES_A_TASK;
    s->triangle = sl_allocate(s->octree->triangle_count, sizeof *s->triangle);
    s->end_of_large = sl_allocate(leaves, sizeof *s->end_of_large);
    s->first_surfel = sl_allocate(leaves + 1, sizeof *s->first_surfel);
    if (!s->triangle || !s->end_of_large || !s->first_surfel)
        return sl_fail_memory(error, "the octree's triangles");
    leaf_task task = {s, sort_leaf};
    sl_parallel_for(threads, tasks, for_leaves, &task);
    for (size_t i = 1; i <= leaves; i++) s->first_surfel[i] += s->first_surfel[i - 1];
    size_t surfels = s->first_surfel[leaves];
    s->surfels.x = sl_allocate(7 * surfels, sizeof *s->surfels.x);
    if (!s->surfels.x) return sl_fail_memory(error, "the octree's triangles");
    float **const planes[6] = {&s->surfels.y,        &s->surfels.z,        &s->surfels.normal_x,
                               &s->surfels.normal_y, &s->surfels.normal_z, &s->surfels.area};
    for (size_t k = 0; k < 6; k++) *planes[k] = s->surfels.x + (k + 1) * surfels;
    s->surfel_count = surfels;
    task.work = put_surfels;
    sl_parallel_for(threads, tasks, for_leaves, &task);
    return SL_OK;
}

/* ---- creating ---- */

sl_status sl_surroundings_create(const sl_scene *scene, const sl_octree *octree, double small_edge,
                                 unsigned threads, sl_surroundings **result, sl_error *error) {
    *result = NULL;
    sl_surroundings *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the octree's nodes");
    *s = (sl_surroundings){.scene = scene, .octree = octree, .small_edge = small_edge};
    s->kernel = sl_surfel_kernel_for(sl_isa_best());
    int depth = octree->depth;
    s->count[depth] = octree->leaf_count;
    s->code[depth] = sl_allocate(octree->leaf_count, sizeof **s->code);
    sl_status status = s->code[depth] ? SL_OK : sl_fail_memory(error, "the octree's nodes");
    for (size_t i = 0; status == SL_OK && i < octree->leaf_count; i++)
        s->code[depth][i] = (uint32_t)octree->leaf[i].morton;
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
    sl_free(s->end_of_large);
    sl_free(s->triangle);
    sl_free(s);
}

size_t sl_surroundings_bytes(const sl_surroundings *s) {
    size_t bytes = sizeof *s;
    for (int level = 0; level <= s->octree->depth; level++)
        bytes += (2 * s->count[level] + 1) * sizeof(uint32_t);
    size_t leaves = s->octree->leaf_count;
    return bytes + (2 * leaves + 1 + s->octree->triangle_count + 7 * s->surfel_count) * sizeof(uint32_t);
}
