#include "cache/photons/photon_search.h"

#include <string.h>

enum { STACK = 64 };

/* ---- the k smallest so far ------------------------------------------------------------------- */

static inline void swap_keys(uint64_t *a, uint64_t *b) {
    uint64_t c = *a;
    *a = *b;
    *b = c;
}

/* The middle one of three goes to the end. */
static void choose_pivot(uint64_t *key, size_t low, size_t high) {
    uint64_t *a = &key[low], *b = &key[low + (high - low) / 2], *c = &key[high - 1];
    if (*b < *a) swap_keys(a, b);
    if (*c < *b) swap_keys(b, c);
    if (*b < *a) swap_keys(a, b);
    swap_keys(b, c);
}

/* Quickselect (Hoare 1961), its comparisons without branches. All keys differ, since ids do. */
static void keep_smallest(uint64_t *key, size_t count, size_t wanted) {
    for (size_t low = 0, high = count; low < wanted && wanted < high;) {
        choose_pivot(key, low, high);
        uint64_t pivot = key[high - 1];
        size_t store = low;
        for (size_t i = low; i < high; i++) {
            uint64_t x = key[i];
            key[i] = key[store];
            key[store] = x;
            store += x < pivot; /* the pivot itself comes last, and so to its place */
        }
        if (wanted <= store) high = store;
        else low = store + 1;
    }
}

/* The bound follows the k-th: ties with it are still looked at, a lower id may replace it. */
static void tighten(sl_photon_search *s) {
    if (s->count < s->wanted) return;
    keep_smallest(s->key, s->count, s->wanted);
    uint64_t last = 0;
    for (size_t i = 0; i < s->wanted; i++) last = s->key[i] > last ? s->key[i] : last;
    uint32_t bits = (uint32_t)(last >> 32);
    memcpy(&s->bound, &bits, sizeof bits);
    s->count = s->wanted;
}

/* ---- buckets and boxes ----------------------------------------------------------------------- */

static void scan_bucket(const sl_photon_bucket *b, sl_photon_search *s) {
    float distance[SL_PHOTON_BUCKET];
    uint32_t near[SL_PHOTON_BUCKET], any = 0, bits[SL_PHOTON_BUCKET];
    const float cx = s->centre.x, cy = s->centre.y, cz = s->centre.z, nx = s->normal.x, ny = s->normal.y,
                nz = s->normal.z;
    const float stretch = s->stretch, bound = s->bound, cos_acceptance = s->cos_acceptance, back = s->back;
#pragma omp simd reduction(| : any)
    for (int i = 0; i < SL_PHOTON_BUCKET; i++) {
        float x = b->x[i] - cx, y = b->y[i] - cy, z = b->z[i] - cz, u = x * nx + y * ny + z * nz;
        distance[i] = x * x + y * y + z * z + stretch * (u * u);
        near[i] = distance[i] <= bound ? 1u : 0u;
        any |= near[i];
    }
    if (!any) return;
#pragma omp simd
    for (int i = 0; i < SL_PHOTON_BUCKET; i++) {
        float cosine = b->normal_x[i] * nx + b->normal_y[i] * ny + b->normal_z[i] * nz;
        cosine = cosine < 0.0f ? cosine * back : cosine;
        near[i] = cosine >= cos_acceptance ? near[i] : 0u;
    }
    memcpy(bits, distance, sizeof bits);
    size_t count = s->count;
    for (int i = 0; i < SL_PHOTON_BUCKET; i++) {
        s->key[count] = (uint64_t)bits[i] << 32 | b->id[i];
        count += near[i];
    }
    s->count = count;
    if (count + SL_PHOTON_BUCKET > s->room) tighten(s);
}

/* A query in the form in which it is held against boxes. */
typedef struct box_query {
    float centre[3], normal[3], across[3]; /* across: |normal| */
    float stretch, shrink;
} box_query;

/* No photon of the box is nearer: delta^2 = |p|^2 + stretch u^2, each of the two terms at its least.
 * Rounding, here and in the photons' own distances, only makes it smaller. */
static inline float least_distance(const sl_photon_box *box, const box_query *q) {
    float distance = 0.0f, u = 0.0f, reach = 0.0f, sum = 0.0f;
    for (int a = 0; a < 3; a++) {
        float to = box->centre[a] - q->centre[a], size = fabsf(to) * 0.999999f, gap = size - box->half[a];
        gap = gap > 0.0f ? gap : 0.0f;
        distance += gap * gap;
        u += to * q->normal[a];
        reach += box->half[a] * q->across[a];
        sum += size * q->across[a];
    }
    float height = fabsf(u) - reach - 1e-6f * sum;
    height = height > 0.0f ? height : 0.0f;
    return (distance + q->stretch * (height * height)) * q->shrink;
}

static box_query box_query_of(const sl_photon_search *s) {
    box_query q = {{s->centre.x, s->centre.y, s->centre.z}, {s->normal.x, s->normal.y, s->normal.z},
                   {fabsf(s->normal.x), fabsf(s->normal.y), fabsf(s->normal.z)}, s->stretch, 0.0f};
    /* A photon's u errs by some 2^-24 |p|, its delta^2 by sqrt(stretch) times as much. */
    float slack = 2e-6f * (1.0f + sqrtf(s->stretch));
    q.shrink = slack < 1.0f ? 1.0f - slack : 0.0f;
    return q;
}

/* ---- the tree -------------------------------------------------------------------------------- */

typedef struct open_node {
    size_t node, leaf, leaves; /* its number, its first leaf, how many */
    float least;
} open_node;

/* From a node down to the nearest leaf; the other ways are left open. Pruned only when strictly farther than
 * the bound. */
static void descend(const sl_photon_buckets *buckets, const box_query *query, sl_photon_search *s,
                    open_node at, open_node *stack, unsigned *open) {
    while (at.leaves > 1) {
        size_t left = sl_photon_left_leaves(at.leaves);
        open_node a = {at.node + 1, at.leaf, left, least_distance(&buckets->box[at.node + 1], query)};
        open_node b = {at.node + 2 * left, at.leaf + left, at.leaves - left,
                       least_distance(&buckets->box[at.node + 2 * left], query)};
        bool swap = b.least < a.least;
        at = swap ? b : a;
        open_node other = swap ? a : b;
        if (other.least <= s->bound) stack[(*open)++] = other;
        if (!(at.least <= s->bound)) return;
    }
    scan_bucket(&buckets->bucket[at.leaf], s);
}

void SL_KERNEL(sl_photon_search)(const sl_photon_buckets *buckets, sl_photon_search *search) {
    open_node stack[STACK];
    unsigned open = 0;
    box_query query = box_query_of(search);
    search->count = 0;
    if (buckets->count > 0) stack[open++] = (open_node){0, 0, buckets->count, 0.0f};
    while (open > 0) {
        open_node next = stack[--open];
        if (next.least <= search->bound) descend(buckets, &query, search, next, stack, &open);
    }
    tighten(search);
}
