#include "cache/photons/photon_tree.h"

#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/photons/photon_search.h"

struct sl_photon_tree {
    sl_photon_list *list;
    sl_photon_bucket *bucket;
    sl_photon_box *box;
    uint32_t *place_of_id;
    size_t buckets;
    sl_isa isa;
};

enum { BUCKETS_A_TASK = 256, SPLIT_LEVELS = 6, SAMPLE = 31 };

/* ---- splitting ------------------------------------------------------------------------------- */

/* The part of a photon that building moves about: its coordinates as integers of the same order, so that
 * comparing needs no branch. */
typedef struct tree_point {
    _Alignas(16) uint32_t coordinate[3];
    uint32_t id;
} tree_point;

static uint32_t integer_of(float v) {
    return sl_float_key(isfinite(v) ? v + 0.0f : FLT_MAX); /* -0 is 0 */
}

typedef struct tree_node {
    size_t node, leaf, leaves;
} tree_node;

typedef struct tree_build {
    sl_photon_tree *tree;
    tree_point *points;
    size_t count;
    sl_photon *ordered;
    /* the upper levels, each from left to right; nodes without leaves are absent */
    tree_node top[(1 << (SPLIT_LEVELS + 1)) - 1];
    size_t first_of_level;
} tree_build;

static inline uint64_t order_of(const tree_point *point, int axis) {
    return (uint64_t)point->coordinate[axis] << 32 | point->id;
}

static inline void swap_points(tree_point *a, tree_point *b) {
    tree_point c = *a;
    *a = *b;
    *b = c;
}

/* A point whose rank among a few is about what is wanted among all goes to the end. */
static void choose_pivot(tree_point *points, size_t low, size_t high, size_t wanted, int axis) {
    uint64_t order[SAMPLE];
    size_t index[SAMPLE], count = high - low, sample = count < 1000 ? count < 40 ? 3 : 7 : SAMPLE;
    for (size_t i = 0; i < sample; i++) {
        size_t at = low + (count - 1) * i / (sample - 1);
        uint64_t o = order_of(&points[at], axis);
        size_t j = i;
        for (; j > 0 && order[j - 1] > o; j--) {
            order[j] = order[j - 1];
            index[j] = index[j - 1];
        }
        order[j] = o;
        index[j] = at;
    }
    size_t rank = (size_t)((double)(wanted - low) / (double)count * (double)sample);
    swap_points(&points[index[rank < sample ? rank : sample - 1]], &points[high - 1]);
}

/* The `wanted` least points of [low, high) by (coordinate, id) come first. */
static void split_points(tree_point *points, size_t low, size_t high, size_t wanted, int axis) {
    while (low < wanted && wanted < high) {
        if (high - low > 2) choose_pivot(points, low, high, wanted, axis);
        uint64_t pivot = order_of(&points[high - 1], axis);
        size_t store = low;
        for (size_t i = low; i < high; i++) {
            tree_point x = points[i];
            points[i] = points[store];
            points[store] = x;
            store += order_of(&x, axis) < pivot; /* the pivot itself comes last, and so to its place */
        }
        if (wanted <= store) high = store;
        else low = store + 1;
    }
}

/* The box around points, and the axis of its longest extent: on a tie x before y before z. */
static int bound_points(const tree_point *points, size_t count, sl_photon_box *box) {
    uint32_t low[3] = {UINT32_MAX, UINT32_MAX, UINT32_MAX}, high[3] = {0, 0, 0};
    for (size_t i = 0; i < count; i++) {
        for (int a = 0; a < 3; a++) {
            uint32_t p = points[i].coordinate[a];
            low[a] = p < low[a] ? p : low[a];
            high[a] = p > high[a] ? p : high[a];
        }
    }
    int longest = 0;
    for (int a = 0; a < 3; a++) {
        float from = sl_float_of_key(low[a]), to = sl_float_of_key(high[a]), centre = 0.5f * from + 0.5f * to;
        box->centre[a] = centre;
        box->half[a] = fmaxf(to - centre, centre - from) * (1.0f + 2e-6f) + FLT_MIN;
        if (box->half[a] > box->half[longest]) longest = a;
    }
    return longest;
}

static size_t end_of(const tree_build *build, size_t leaf) {
    return leaf * SL_PHOTON_BUCKET < build->count ? leaf * SL_PHOTON_BUCKET : build->count;
}

static void split_node(tree_build *build, tree_node n) {
    size_t low = end_of(build, n.leaf), high = end_of(build, n.leaf + n.leaves);
    int axis = bound_points(build->points + low, high - low, &build->tree->box[n.node]);
    if (n.leaves > 1)
        split_points(build->points, low, high, end_of(build, n.leaf + sl_photon_left_leaves(n.leaves)), axis);
}

static void children(tree_node n, tree_node child[2]) {
    size_t left = sl_photon_left_leaves(n.leaves);
    child[0] = (tree_node){n.node + 1, n.leaf, left};
    child[1] = (tree_node){n.node + 2 * left, n.leaf + left, n.leaves - left};
    if (n.leaves < 2) child[0].leaves = child[1].leaves = 0;
}

static void split_below(tree_build *build, tree_node n) {
    if (n.leaves == 0) return;
    tree_node child[2];
    split_node(build, n);
    children(n, child);
    split_below(build, child[0]);
    split_below(build, child[1]);
}

static void split_top_node(void *context, size_t index, unsigned worker) {
    tree_build *build = context;
    size_t at = build->first_of_level + index;
    (void)worker;
    if (build->top[at].leaves > 0) split_node(build, build->top[at]);
    children(build->top[at], &build->top[2 * at + 1]);
}

static void split_subtree(void *context, size_t index, unsigned worker) {
    tree_build *build = context;
    (void)worker;
    split_below(build, build->top[build->first_of_level + index]);
}

/* The upper levels one after another, then what hangs below them, all at once: ranges never overlap. */
static void split_all(tree_build *build, unsigned threads) {
    build->top[0] = (tree_node){0, 0, build->tree->buckets};
    for (int level = 0; level < SPLIT_LEVELS; level++) {
        build->first_of_level = ((size_t)1 << level) - 1;
        sl_parallel_for(threads, (size_t)1 << level, split_top_node, build);
    }
    build->first_of_level = ((size_t)1 << SPLIT_LEVELS) - 1;
    sl_parallel_for(threads, (size_t)1 << SPLIT_LEVELS, split_subtree, build);
}

/* ---- filling --------------------------------------------------------------------------------- */

/* Within a bucket by id, so that the photons' order depends on the set of them alone. */
static void sort_by_id(tree_point *points, size_t count) {
    for (size_t i = 1; i < count; i++) {
        tree_point x = points[i];
        size_t j = i;
        for (; j > 0 && points[j - 1].id > x.id; j--) points[j] = points[j - 1];
        points[j] = x;
    }
}

static void fill_lane(sl_photon_bucket *bucket, size_t lane, const sl_photon *photon, uint32_t id) {
    bucket->x[lane] = photon->position[0];
    bucket->y[lane] = photon->position[1];
    bucket->z[lane] = photon->position[2];
    sl_put(bucket->normal_x, bucket->normal_y, bucket->normal_z, lane, sl_octahedral_decode(photon->normal));
    bucket->id[lane] = id;
}

static void fill_bucket(tree_build *build, size_t index) {
    sl_photon_tree *tree = build->tree;
    sl_photon_bucket *bucket = &tree->bucket[index];
    size_t first = end_of(build, index), count = end_of(build, index + 1) - first;
    sort_by_id(build->points + first, count);
    for (size_t i = 0; i < count; i++) {
        uint32_t id = build->points[first + i].id;
        build->ordered[first + i] = tree->list->photon[id];
        tree->place_of_id[id] = (uint32_t)(first + i);
        fill_lane(bucket, i, &tree->list->photon[id], id);
    }
    for (size_t i = count; i < SL_PHOTON_BUCKET; i++) bucket->x[i] = bucket->y[i] = bucket->z[i] = NAN;
}

static void fill_buckets(void *context, size_t index, unsigned worker) {
    tree_build *build = context;
    (void)worker;
    size_t end = (index + 1) * BUCKETS_A_TASK < build->tree->buckets ? (index + 1) * BUCKETS_A_TASK
                                                                     : build->tree->buckets;
    for (size_t b = index * BUCKETS_A_TASK; b < end; b++) fill_bucket(build, b);
}

static sl_status build_tree(sl_photon_tree *tree, unsigned threads, sl_error *error) {
    const sl_photon_list *list = tree->list;
    size_t count = list->count;
    tree_build build = {.tree = tree, .count = count};
    build.points = sl_allocate(count, sizeof *build.points);
    build.ordered = sl_allocate(count, sizeof *build.ordered);
    if (!build.points || !build.ordered) {
        SL_FREE_ALL(build.points, build.ordered);
        return sl_fail_memory(error, "the photons' tree");
    }
    for (size_t i = 0; i < count; i++) {
        for (int a = 0; a < 3; a++) build.points[i].coordinate[a] = integer_of(list->photon[i].position[a]);
        build.points[i].id = (uint32_t)i;
    }
    split_all(&build, threads);
    sl_parallel_for(threads, (tree->buckets + BUCKETS_A_TASK - 1) / BUCKETS_A_TASK, fill_buckets, &build);
    SL_FREE_ALL(build.points, tree->list->photon);
    tree->list->photon = build.ordered;
    tree->list->capacity = count;
    return SL_OK;
}

sl_status sl_photon_tree_create(sl_photon_list *list, unsigned threads, sl_photon_tree **out,
                                sl_error *error) {
    *out = NULL;
    sl_photon_tree *tree = sl_allocate(1, sizeof *tree);
    if (!tree) {
        sl_photon_list_destroy(list);
        return sl_fail_memory(error, "the photons' tree");
    }
    tree->buckets = (list->count + SL_PHOTON_BUCKET - 1) / SL_PHOTON_BUCKET;
    tree->isa = sl_isa_best();
    tree->bucket = sl_allocate(tree->buckets, sizeof *tree->bucket);
    tree->box = sl_allocate(2 * tree->buckets, sizeof *tree->box);
    tree->place_of_id = sl_allocate(list->count, sizeof *tree->place_of_id);
    tree->list = list;
    sl_status status = SL_OK;
    if (list->count >= UINT32_MAX)
        status = sl_fail(error, SL_ERROR_RESOURCES, "too many photons: %zu", list->count);
    else if (!tree->bucket || !tree->box || !tree->place_of_id)
        status = sl_fail_memory(error, "the photons' tree");
    else status = build_tree(tree, sl_thread_count(threads), error);
    if (status == SL_OK) *out = tree;
    else sl_photon_tree_destroy(tree);
    return status;
}

void sl_photon_tree_destroy(sl_photon_tree *tree) {
    if (!tree) return;
    sl_photon_list_destroy(tree->list);
    SL_FREE_ALL(tree->bucket, tree->box, tree->place_of_id, tree);
}

const sl_photon_list *sl_photon_tree_list(const sl_photon_tree *tree) { return tree->list; }

uint32_t sl_photon_tree_id(const sl_photon_tree *tree, size_t place) {
    return tree->bucket[place / SL_PHOTON_BUCKET].id[place % SL_PHOTON_BUCKET];
}

size_t sl_photon_tree_bytes(const sl_photon_tree *tree) {
    return sizeof *tree + sizeof *tree->list +
           tree->list->count * (sizeof(sl_photon) + sizeof *tree->place_of_id) +
           tree->buckets * (sizeof *tree->bucket + 2 * sizeof *tree->box);
}

/* ---- gathering ------------------------------------------------------------------------------- */

static const double flatness_least = 1e-3;

static sl_photon_search begin_search(const sl_photon_query *query, size_t wanted, uint64_t *key) {
    sl_photon_search s = {.centre = query->centre, .normal = query->normal, .wanted = wanted, .key = key};
    double f = query->flatness, square = query->radius * query->radius;
    bool sphere = query->normal.x == 0.0f && query->normal.y == 0.0f && query->normal.z == 0.0f;
    f = f < 1.0 ? f > flatness_least ? f : flatness_least : 1.0; /* NaN: a sphere */
    s.stretch = sphere ? 0.0f : (float)(1.0 / (f * f) - 1.0);
    /* A cosine of rounded unit vectors may be a little less than -1. */
    s.cos_acceptance = sphere || !(query->cos_acceptance > -1.0) ? -INFINITY : (float)query->cos_acceptance;
    s.back = query->both_sides ? -1.0f : 1.0f;
    s.bound = query->radius >= 0.0 ? square < (double)FLT_MAX ? (float)square : FLT_MAX : -1.0f;
    s.room = 2 * wanted + 2 * SL_PHOTON_BUCKET;
    return s;
}

/* Keys turned round, id first, in order of ids: byte by byte from the lowest, as many as the ids have. */
static uint64_t *sort_ids(uint64_t *key, uint64_t *spare, size_t count, size_t ids) {
    for (size_t i = 0; i < count; i++) key[i] = key[i] << 32 | key[i] >> 32;
    for (unsigned shift = 32; shift < 64 && (ids - 1) >> (shift - 32) > 0; shift += 8) {
        uint32_t places[256] = {0}, sum = 0;
        for (size_t i = 0; i < count; i++) places[key[i] >> shift & 0xff]++;
        for (int b = 0; b < 256; b++) {
            uint32_t here = places[b];
            places[b] = sum;
            sum += here;
        }
        for (size_t i = 0; i < count; i++) spare[places[key[i] >> shift & 0xff]++] = key[i];
        uint64_t *swap = key;
        key = spare;
        spare = swap;
    }
    return key;
}

void sl_photon_tree_gather(const sl_photon_tree *tree, const sl_photon_query *query,
                           sl_gathered_photons *gathered) {
    size_t wanted = query->neighbours < SL_NEIGHBOURS_MAX ? query->neighbours : SL_NEIGHBOURS_MAX;
    uint64_t *spare = gathered->keys, *key = spare + wanted;
    sl_photon_search search = begin_search(query, wanted, key);
    const sl_photon_buckets buckets = {tree->buckets, tree->bucket, tree->box};
    if (wanted > 0 && sl_is_finite(query->centre) && sl_is_finite(query->normal))
        SL_KERNEL_OF(tree->isa, sl_photon_search)(&buckets, &search);
    gathered->count = search.count;
    gathered->full = wanted > 0 && search.count == wanted;
    double farthest = 0.0;
    const uint64_t *sorted = sort_ids(key, spare, search.count, tree->list->count);
    for (size_t i = 0; i < search.count; i++) {
        gathered->place[i] = tree->place_of_id[sorted[i] >> 32];
        gathered->distance[i] = (double)sl_float_of_bits((uint32_t)sorted[i]);
        farthest = fmax(farthest, gathered->distance[i]);
    }
    double radius = gathered->full ? sqrt(farthest) : query->radius;
    gathered->radius = radius > query->minimum ? radius : query->minimum;
}
