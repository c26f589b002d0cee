/* Building: every triangle names the cells of the deepest level that it meets; the pairs (Morton code,
 * triangle) are sorted, and each run of equal codes is a leaf. The levels above are the codes' prefixes: a
 * cell is split if and only if a deeper one in it meets a triangle. */
#include "cache/light_octree/octree.h"

#include <string.h>

#include "base/code_sort.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/parallel.h"

/* Things around the central region take light from it, too. */
static const double AROUND_CENTRE = 1.5;

enum { CHUNK = 2048 };

/* ---- the space of cells ---- */

static double largest(double a, double b) { return a > b ? a : b; }

sl_cell_space sl_cell_space_of(const sl_scene *scene, sl_vec3d origin, double edge, int depth) {
    double scale = (double)(1u << depth) / edge,
           far = (double)sl_scene_coordinate_near(scene, scene->central_min);
    /* four half units in the last place */
    return (sl_cell_space){scene, origin, scale, 0x1p-22 * far * scale};
}

static sl_vec3d place(const sl_cell_space *space, uint32_t vertex) {
    return sl_scaled(sl_subd(sl_to_double(sl_scene_position(space->scene, vertex)), space->origin),
                     space->scale);
}

sl_cell_triangle sl_cell_space_triangle(const sl_cell_space *space, uint32_t triangle) {
    uint32_t *const *vertex = (uint32_t *const *)space->scene->vertex;
    return sl_cell_triangle_of(place(space, vertex[0][triangle]), place(space, vertex[1][triangle]),
                               place(space, vertex[2][triangle]));
}

/* ---- the part of a triangle in a box, by clipping (Sutherland and Hodgman 1974) ---- */

static void put(sl_vec3d *p, int axis, double value) {
    if (axis == 0) p->x = value;
    else if (axis == 1) p->y = value;
    else p->z = value;
}

/* Cuts off the part with sign * (p_axis - plane) <= 0; its corners alone. */
static void cut_below(const sl_triangle_part *in, int axis, double plane, double sign,
                      sl_triangle_part *out) {
    out->count = 0;
    for (int i = 0; i < in->count && out->count < SL_TRIANGLE_PART_CORNERS - 1; i++) {
        sl_vec3d p = in->corner[i], q = in->corner[i + 1 < in->count ? i + 1 : 0];
        double a = sign * (sl_along(p, axis) - plane), b = sign * (sl_along(q, axis) - plane);
        if (a <= 0.0) out->corner[out->count++] = p;
        if ((a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0)) {
            sl_vec3d cut = sl_addd(p, sl_scaled(sl_subd(q, p), a / (a - b)));
            put(&cut, axis, plane);
            out->corner[out->count++] = cut;
        }
    }
}

/* A fan of triangles about the first corner: all turn the same way. */
static void measure(sl_triangle_part *clipped) {
    const sl_vec3d *p = clipped->corner;
    sl_vec3d mean = {0}, weighted = {0};
    double area = 0.0;
    for (int i = 0; i < clipped->count; i++) mean = sl_addd(mean, p[i]);
    for (int i = 1; i + 1 < clipped->count; i++) {
        double piece = 0.5 * sl_lengthd(sl_crossd(sl_subd(p[i], p[0]), sl_subd(p[i + 1], p[0])));
        area += piece;
        weighted =
            sl_addd(weighted, sl_scaled(sl_addd(sl_subd(p[i], p[0]), sl_subd(p[i + 1], p[0])), piece / 3.0));
    }
    clipped->area = area;
    if (area > 0.0) clipped->centroid = sl_addd(p[0], sl_scaled(weighted, 1.0 / area));
    else if (clipped->count > 0) clipped->centroid = sl_scaled(mean, 1.0 / clipped->count);
    else clipped->centroid = sl_v3d(0.0, 0.0, 0.0);
}

void sl_triangle_in_box(const sl_cell_triangle *triangle, sl_vec3d low, sl_vec3d high,
                        sl_triangle_part *clipped) {
    sl_triangle_part other;
    clipped->count = 3;
    for (int k = 0; k < 3; k++) clipped->corner[k] = triangle->corner[k];
    for (int axis = 0; axis < 3; axis++) {
        double a = sl_along(triangle->corner[0], axis), b = sl_along(triangle->corner[1], axis),
               c = sl_along(triangle->corner[2], axis), l = sl_along(low, axis), h = sl_along(high, axis);
        if (fmin(fmin(a, b), c) >= l && fmax(fmax(a, b), c) <= h) continue;
        cut_below(clipped, axis, l, -1.0, &other);
        cut_below(&other, axis, h, 1.0, clipped);
    }
    measure(clipped);
}

/* ---- pairs of cells and triangles ---- */

typedef struct pair_list {
    uint64_t *pair; /* Morton code in the upper half, triangle in the lower */
    size_t count, room;
    bool failed;
} pair_list;

typedef struct builder {
    sl_cell_space space;
    double grown;   /* by what voxels are wider on each side, tolerance included; cells */
    uint32_t cells; /* an edge of the root */
    pair_list *chunk;
    sl_octree *octree;
} builder;

static void emit(pair_list *list, const uint32_t cell[3], uint32_t triangle) {
    list->failed = list->failed || !sl_make_room(&list->pair, list->count, &list->room, sizeof *list->pair);
    if (!list->failed)
        list->pair[list->count++] = sl_morton_code(cell[0], cell[1], cell[2]) << 32 | triangle;
}

typedef struct cell_range {
    uint32_t low[3], high[3]; /* both inclusive */
} cell_range;

/* Closed boxes: cell i reaches from i - grown to i + 1 + grown. */
static cell_range range_of(const builder *b, const sl_cell_triangle *t) {
    cell_range range;
    const double end = (double)(b->cells - 1);
    for (int axis = 0; axis < 3; axis++) {
        double p = sl_along(t->corner[0], axis), q = sl_along(t->corner[1], axis),
               r = sl_along(t->corner[2], axis);
        range.low[axis] = (uint32_t)fmax(fmin(ceil(fmin(fmin(p, q), r) - b->grown - 1.0), end), 0.0);
        range.high[axis] = (uint32_t)fmax(fmin(floor(fmax(fmax(p, q), r) + b->grown), end), 0.0);
    }
    return range;
}

/* Halves a range of cells along its longest side as long as something of the triangle lies in it. */
static void visit_range(const builder *b, const sl_triangle_part *part, cell_range range, uint32_t triangle,
                        pair_list *list) {
    int axis = 0;
    uint32_t side = 0;
    for (int k = 0; k < 3; k++) {
        if (range.high[k] - range.low[k] > side) {
            side = range.high[k] - range.low[k];
            axis = k;
        }
    }
    if (part->count == 0) return;
    if (side == 0) {
        emit(list, range.low, triangle);
        return;
    }
    cell_range lower = range, upper = range;
    sl_triangle_part half;
    lower.high[axis] = range.low[axis] + side / 2;
    upper.low[axis] = lower.high[axis] + 1;
    cut_below(part, axis, lower.high[axis] + 1.0 + b->grown, 1.0, &half);
    visit_range(b, &half, lower, triangle, list);
    cut_below(part, axis, upper.low[axis] - b->grown, -1.0, &half);
    visit_range(b, &half, upper, triangle, list);
}

static void visit_chunk(void *context, size_t index, unsigned worker) {
    (void)worker;
    builder *b = context;
    size_t first = index * CHUNK, end = first + CHUNK;
    if (end > b->space.scene->triangle_count) end = b->space.scene->triangle_count;
    for (size_t i = first; i < end; i++) {
        sl_cell_triangle t = sl_cell_space_triangle(&b->space, (uint32_t)i);
        cell_range range = range_of(b, &t);
        double g = b->grown;
        sl_triangle_part part;
        sl_triangle_in_box(&t, sl_v3d(range.low[0] - g, range.low[1] - g, range.low[2] - g),
                           sl_v3d(range.high[0] + 1.0 + g, range.high[1] + 1.0 + g, range.high[2] + 1.0 + g),
                           &part);
        visit_range(b, &part, range, (uint32_t)i, &b->chunk[index]);
    }
}

/* ---- leaves ---- */

/* Cells in which nothing takes photons are no leaves. Returns how many pairs are left. */
static size_t drop_dark_cells(const sl_scene *scene, sl_coded *pair, size_t count) {
    size_t kept = 0;
    for (size_t i = 0, end; i < count; i = end) {
        bool takes = false;
        for (end = i; end < count && pair[end].code == pair[i].code; end++)
            takes |= sl_takes_photons(sl_triangle_material(scene, pair[end].item));
        for (size_t k = i; takes && k < end; k++) pair[kept++] = pair[k];
    }
    return kept;
}

static bool begins_leaf(const sl_coded *pair, size_t i) { return i == 0 || pair[i].code != pair[i - 1].code; }

static size_t count_leaves(const sl_coded *pair, size_t count) {
    size_t leaves = 0;
    for (size_t i = 0; i < count; i++) leaves += begins_leaf(pair, i);
    return leaves;
}

static void fill_leaves(sl_octree *octree, const sl_coded *pair) {
    size_t leaf = 0;
    for (size_t i = 0; i < octree->triangle_count; i++) {
        octree->triangle[i] = pair[i].item;
        if (begins_leaf(pair, i))
            octree->leaf[leaf++] = (sl_octree_leaf){.morton = pair[i].code, .first_triangle = (uint32_t)i};
        octree->leaf[leaf - 1].triangle_count++;
    }
}

static sl_status allocate_leaves(sl_octree *octree, size_t leaves, size_t triangles, sl_error *error) {
    octree->leaf_count = leaves;
    octree->triangle_count = triangles;
    octree->leaf = sl_allocate(leaves, sizeof *octree->leaf);
    octree->triangle = sl_allocate(triangles, sizeof *octree->triangle);
    return octree->leaf && octree->triangle ? SL_OK : sl_fail_memory(error, "the octree");
}

static void join_chunks(const builder *b, size_t chunks, sl_coded *pair) {
    for (size_t i = 0; i < chunks; i++)
        for (size_t k = 0; k < b->chunk[i].count; k++)
            *pair++ = (sl_coded){b->chunk[i].pair[k] >> 32, (uint32_t)b->chunk[i].pair[k]};
}

/* From the chunks' pairs to leaves. */
static sl_status make_leaves(builder *b, size_t chunks, sl_error *error) {
    size_t count = 0;
    bool failed = false;
    for (size_t i = 0; i < chunks; i++) {
        count += b->chunk[i].count;
        failed |= b->chunk[i].failed;
    }
    sl_coded *pair = failed || count > UINT32_MAX ? NULL : sl_allocate_unset(count, sizeof *pair);
    if (!pair) return sl_fail_memory(error, "the octree's triangle lists");
    join_chunks(b, chunks, pair);
    sl_sort_coded(pair, count);
    count = drop_dark_cells(b->space.scene, pair, count);
    sl_status status = allocate_leaves(b->octree, count_leaves(pair, count), count, error);
    if (status == SL_OK) fill_leaves(b->octree, pair);
    sl_free(pair);
    return status;
}

/* The box made cubic about its middle, and a little larger. */
static sl_octree_root root_around(sl_vec3 box_min, sl_vec3 box_max, double larger) {
    sl_vec3d low = sl_to_double(box_min), high = sl_to_double(box_max), size = sl_subd(high, low);
    double edge = larger * largest(size.x, largest(size.y, size.z));
    if (!(edge > 0.0 && edge < 1e300)) edge = 1.0; /* no triangles */
    edge *= 1.0 + 1e-4;
    return (sl_octree_root){
        sl_subd(sl_scaled(sl_addd(low, high), 0.5), sl_scaled(sl_v3d(1.0, 1.0, 1.0), 0.5 * edge)), edge};
}

sl_octree_root sl_octree_root_of_all(const sl_scene *scene) {
    return root_around(scene->box_min, scene->box_max, 1.0);
}

sl_octree_root sl_octree_root_of_central_region(const sl_scene *scene) {
    return root_around(scene->central_min, scene->central_max,
                       sl_scene_is_scattered(scene) ? AROUND_CENTRE : 1.0);
}

sl_status sl_octree_create(const sl_scene *scene, const sl_octree_root *root, int depth, double dilation,
                           unsigned threads, sl_octree **result, sl_error *error) {
    *result = NULL;
    sl_octree *octree = sl_allocate(1, sizeof *octree);
    if (!octree) return sl_fail_memory(error, "the octree");
    octree->depth = depth;
    octree->dilation = dilation;
    octree->origin = root->origin;
    octree->edge = root->edge;
    size_t chunks = (scene->triangle_count + CHUNK - 1) / CHUNK;
    builder b = {.space = sl_cell_space_of(scene, octree->origin, octree->edge, depth),
                 .cells = 1u << depth,
                 .octree = octree,
                 .chunk = sl_allocate(chunks, sizeof *b.chunk)};
    b.grown = dilation + b.space.tolerance;
    sl_status status = b.chunk ? SL_OK : sl_fail_memory(error, "the octree");
    if (status == SL_OK) {
        threads = sl_thread_count(threads);
        sl_parallel_for(threads, chunks, visit_chunk, &b);
        status = make_leaves(&b, chunks, error);
        for (size_t i = 0; i < chunks; i++) sl_free(b.chunk[i].pair);
    }
    sl_free(b.chunk);
    if (status != SL_OK) sl_octree_destroy(octree);
    else *result = octree;
    return status;
}

void sl_octree_destroy(sl_octree *octree) {
    if (!octree) return;
    SL_FREE_ALL(octree->leaf, octree->triangle, octree);
}

size_t sl_octree_bytes(const sl_octree *octree) {
    return sizeof *octree + octree->leaf_count * sizeof *octree->leaf +
           octree->triangle_count * sizeof *octree->triangle;
}

/* ---- look-ups ---- */

size_t sl_octree_lower_bound(const sl_octree *octree, size_t first, size_t end, uint64_t morton) {
    size_t count = end - first;
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

static uint32_t cell_at(double x, double cells) {
    return (uint32_t)(x > 0.0 ? (x < cells - 1.0 ? floor(x) : cells - 1.0) : 0.0); /* NaN: 0 */
}

uint64_t sl_octree_morton_at(const sl_octree *octree, sl_vec3 p) {
    double cells = (double)(1u << octree->depth);
    sl_vec3d u = sl_scaled(sl_subd(sl_to_double(p), octree->origin), cells / octree->edge);
    return sl_morton_code(cell_at(u.x, cells), cell_at(u.y, cells), cell_at(u.z, cells));
}
