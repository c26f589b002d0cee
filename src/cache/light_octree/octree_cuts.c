/* Shallower octrees from deeper ones, and leaves by their codes. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/light_octree/octree_leaves.h"

sl_status sl_octree_allocate_leaves(sl_octree *octree, size_t leaves, size_t triangles, sl_error *error) {
    octree->leaf_count = leaves;
    octree->triangle_count = triangles;
    octree->leaf = sl_allocate(leaves, sizeof *octree->leaf);
    octree->area_vector = sl_allocate(leaves, sizeof *octree->area_vector);
    octree->triangle = sl_allocate(triangles, sizeof *octree->triangle);
    return octree->leaf && octree->area_vector && octree->triangle ? SL_OK
                                                                   : sl_fail_memory(error, "the octree");
}

/* ---- cuts ---- */

static size_t children_end(const sl_octree *octree, size_t first, int shift) {
    size_t end = first + 1;
    while (end < octree->leaf_count &&
           octree->leaf[end].morton >> shift == octree->leaf[first].morton >> shift)
        end++;
    return end;
}

static void join_leaves(const sl_octree *octree, size_t first, size_t end, sl_octree_leaf *leaf,
                        sl_vec3 *area_vector) {
    sl_vec3d vector = {0}, centre = {0}, base = sl_to_double(octree->leaf[first].centroid), plain = {0},
             normal = {0};
    double area = 0.0;
    for (size_t i = first; i < end; i++) {
        const sl_octree_leaf *child = &octree->leaf[i];
        sl_vec3d offset = sl_subd(sl_to_double(child->centroid), base);
        area += (double)child->area;
        vector = sl_addd(vector, sl_to_double(octree->area_vector[i]));
        centre = sl_addd(centre, sl_scaled(offset, (double)child->area));
        plain = sl_addd(plain, offset);
        normal = sl_addd(normal, sl_to_double(child->normal));
    }
    sl_vec3d n = area > 0.0 ? vector : normal;
    double length = sl_lengthd(n);
    bool turned = length > 0.0 && length >= 0.2 * (area > 0.0 ? area : (double)(end - first));
    leaf->centroid = sl_to_float(sl_addd(base, area > 0.0 ? sl_scaled(centre, 1.0 / area)
                                                          : sl_scaled(plain, 1.0 / (double)(end - first))));
    leaf->normal = turned ? sl_to_float(sl_scaled(n, 1.0 / length)) : sl_v3(0.0f, 0.0f, 0.0f);
    leaf->area = (float)area;
    *area_vector = sl_to_float(vector);
}

sl_status sl_octree_cut(const sl_octree *octree, int depth, sl_octree **result, sl_error *error) {
    *result = NULL;
    if (depth < 1 || depth > octree->depth) {
        return sl_fail(error, SL_ERROR_USAGE, "a cut at depth %d of an octree of depth %d", depth,
                       octree->depth);
    }
    sl_octree *cut = sl_allocate(1, sizeof *cut);
    if (!cut) return sl_fail_memory(error, "the octree");
    *cut = (sl_octree){.depth = depth, .origin = octree->origin, .edge = octree->edge};
    int shift = 3 * (octree->depth - depth);
    size_t leaves = 0;
    for (size_t i = 0; i < octree->leaf_count; i = children_end(octree, i, shift)) leaves++;
    sl_status status = sl_octree_allocate_leaves(cut, leaves, 0, error);
    if (status != SL_OK) {
        sl_octree_destroy(cut);
        return status;
    }
    size_t leaf = 0;
    for (size_t i = 0, end; i < octree->leaf_count; i = end, leaf++) {
        end = children_end(octree, i, shift);
        cut->leaf[leaf].morton = octree->leaf[i].morton >> shift;
        join_leaves(octree, i, end, &cut->leaf[leaf], &cut->area_vector[leaf]);
    }
    *result = cut;
    return SL_OK;
}

/* ---- look-ups ---- */

size_t sl_octree_lower_bound(const sl_octree *octree, uint64_t morton) {
    size_t first = 0, count = octree->leaf_count;
    while (count > 0) {
        size_t half = count / 2;
        if (octree->leaf[first + half].morton < morton) {
            first += half + 1;
            count -= half + 1;
        } else {
            count = half;
        }
    }
    return first;
}

uint32_t sl_octree_find(const sl_octree *octree, uint64_t morton) {
    size_t leaf = sl_octree_lower_bound(octree, morton);
    return leaf < octree->leaf_count && octree->leaf[leaf].morton == morton ? (uint32_t)leaf : SL_NO_INDEX;
}

static uint32_t cell_at(double x, double cells) {
    return (uint32_t)(x > 0.0 ? (x < cells - 1.0 ? floor(x) : cells - 1.0) : 0.0); /* NaN: 0 */
}

uint64_t sl_octree_morton_at(const sl_octree *octree, sl_vec3 p) {
    double cells = (double)(1u << octree->depth);
    sl_vec3d u = sl_scaled(sl_subd(sl_to_double(p), octree->origin), cells / octree->edge);
    return sl_morton_encode(cell_at(u.x, cells), cell_at(u.y, cells), cell_at(u.z, cells));
}
