/* Gouraud (pass P3): a leaf's pixels from its vertices and those that its neighbours put on its edges. Only what has changed is drawn: leaves
 * that were cut or put together, and those on whose edges a vertex became known. Pixels belong to one leaf each, so the picture does not
 * depend on the order, and an incremental one is that of drawing it all. */
#include "cache/multi_mesh/displayed_internal.h"

#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

enum { LEAVES_AT_ONCE = 64 };

/* ---- what is to be drawn ---- */

sl_status sl_displayed_mark(sl_displayed *d, uint32_t leaf, sl_error *error) {
    sl_mesh_node *node = &d->mesh->node[leaf];
    if (d->dirty_all || !node->pixels || (node->flags & SL_NODE_DIRTY)) return SL_OK;
    if (d->dirty_count == d->dirty_capacity) {
        size_t capacity = d->dirty_capacity ? 2 * d->dirty_capacity : 1024;
        uint32_t *dirty = sl_allocate(capacity, sizeof *dirty);
        if (!dirty) return sl_fail_memory(error, "displayed mesh");
        if (d->dirty_count) memcpy(dirty, d->dirty, d->dirty_count * sizeof *dirty);
        sl_free(d->dirty);
        d->dirty = dirty;
        d->dirty_capacity = capacity;
    }
    node->flags |= SL_NODE_DIRTY;
    d->dirty[d->dirty_count++] = leaf;
    return SL_OK;
}

/* Leaves that are still there, each once; how many pixels they have. */
static uint64_t settle_list(sl_displayed *d) {
    uint64_t pixels = 0;
    size_t kept = 0;
    for (size_t i = 0; i < d->dirty_count; i++) {
        sl_mesh_node *node = &d->mesh->node[d->dirty[i]];
        bool draw = (node->flags & SL_NODE_DIRTY) && node->child == SL_NO_INDEX && !d->dirty_all;
        node->flags &= ~(uint32_t)SL_NODE_DIRTY;
        if (!draw) continue;
        d->dirty[kept++] = d->dirty[i];
        pixels += node->pixels;
    }
    d->dirty_count = kept;
    return pixels;
}

/* ---- drawing ---- */

typedef struct draw_job {
    sl_displayed *d;
    sl_rgb fallback;
    float *const *planes;
} draw_job;

/* Weights of a place's corners 1 and 2 from those of its face's. */
typedef struct own_weights {
    float p, q, b_of_p, b_of_q, c_of_p, c_of_q;
} own_weights;

static own_weights weights_of(const sl_mesh_place *n) {
    const float unit = 1.0f / (float)SL_MESH_DYADIC;
    float p0 = (float)n->p[0] * unit, q0 = (float)n->q[0] * unit, p1 = (float)n->p[1] * unit - p0, q1 = (float)n->q[1] * unit - q0,
          p2 = (float)n->p[2] * unit - p0, q2 = (float)n->q[2] * unit - q0, area = p1 * q2 - p2 * q1;
    float inverse = area != 0.0f ? 1.0f / area : 0.0f;
    return (own_weights){p0, q0, q2 * inverse, -p2 * inverse, -q1 * inverse, p1 * inverse};
}

/* The nearest of a leaf and its ancestors whose corners are known. */
static bool find_fan(const sl_displayed *d, sl_mesh_place *place, sl_mesh_fan *fan) {
    while (!sl_mesh_fan_make(d->mesh, place, d->settings.hanging, fan)) {
        uint32_t parent = sl_mesh_parent(d->mesh, place->node);
        if (parent == SL_NO_INDEX) return false;
        *place = sl_mesh_place_of(d->mesh, parent);
    }
    return true;
}

static void draw_leaf(const draw_job *job, const sl_mesh_place *leaf) {
    const sl_displayed *d = job->d;
    const sl_visible_pixels *pixels = d->pixels;
    sl_mesh_place shown = *leaf;
    sl_mesh_fan fan;
    bool known = find_fan(d, &shown, &fan), paths = sl_displayed_follows_paths(leaf);
    own_weights of = weights_of(&shown);
    uint32_t first = d->first[leaf->node], count = d->mesh->node[leaf->node].pixels;
    for (uint32_t n = first; n < first + count; n++) {
        uint32_t i = paths ? n : d->order[n], pixel = pixels->pixel[i];
        float p = pixels->w1[i] - of.p, q = pixels->w2[i] - of.q, value[3] = {job->fallback.r, job->fallback.g, job->fallback.b};
        if (known) sl_mesh_fan_value(&fan, p * of.b_of_p + q * of.b_of_q, p * of.c_of_p + q * of.c_of_q, value);
        for (int c = 0; c < 3; c++) job->planes[c][pixel] = value[c];
    }
}

static void draw_some(void *context, size_t index, unsigned worker) {
    (void)worker;
    const draw_job *job = context;
    size_t begin = index * LEAVES_AT_ONCE, end = begin + LEAVES_AT_ONCE;
    for (size_t i = begin; i < end && i < job->d->dirty_count; i++) {
        sl_mesh_place leaf = sl_mesh_place_of(job->d->mesh, job->d->dirty[i]);
        draw_leaf(job, &leaf);
    }
}

static void draw_below(const draw_job *job, const sl_mesh_place *place) {
    const sl_mesh_node *node = &job->d->mesh->node[place->node];
    if (!node->pixels) return;
    if (node->child == SL_NO_INDEX) {
        draw_leaf(job, place);
        return;
    }
    for (int c = 0; c < sl_mesh_children(job->d->mesh, place->node); c++) {
        sl_mesh_place child = sl_mesh_child_place(job->d->mesh, place, c);
        draw_below(job, &child);
    }
}

static void draw_share(void *context, size_t share, unsigned worker) {
    (void)worker;
    const draw_job *job = context;
    const sl_displayed *d = job->d;
    size_t begin, end;
    sl_visible_share(d->pixels, share, &begin, &end);
    for (size_t e = begin; e < end; e++) {
        if (!sl_displayed_wants(d, e)) continue;
        sl_mesh_place root = sl_mesh_root_place(d->mesh, d->pixels->face[e].face);
        draw_below(job, &root);
    }
}

void sl_displayed_draw(sl_displayed *d, unsigned threads, sl_rgb fallback, float *const planes[3], sl_counters *counters) {
    if (!d->pixels) return;
    draw_job job = {d, fallback, planes};
    uint64_t redrawn = settle_list(d);
    if (d->dirty_all) {
        for (size_t i = 0; i < d->heap_count; i++) redrawn += d->pixels->face[d->heap[i]].count;
        sl_parallel_for(threads, SL_VISIBLE_SHARES, draw_share, &job);
    } else {
        sl_parallel_for(threads, (d->dirty_count + LEAVES_AT_ONCE - 1) / LEAVES_AT_ONCE, draw_some, &job);
    }
    d->dirty_count = 0;
    d->dirty_all = false;
    sl_count(counters, SL_COUNT_PIXELS_REDRAWN, redrawn);
}
