/* Gouraud (image pass 3): a leaf's pixels from its vertices and those that its neighbours put on its edges.
 * Only what has changed is drawn: leaves that were cut or put together, and those on whose edges a vertex
 * became known. Pixels belong to one leaf each, so the picture does not depend on the order, and an
 * incremental one is that of drawing it all. */
#include "cache/multi_mesh/displayed_internal.h"

#include <stdatomic.h>
#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/multi_mesh/draw_kernels.h"

enum { LEAVES_AT_ONCE = 64 };

/* ---- what is to be drawn ---- */

sl_status sl_displayed_mark(sl_displayed *d, uint32_t leaf, sl_error *error) {
    sl_mesh_node *node = &d->mesh->node[leaf];
    node->flags &= ~(uint32_t)(SL_NODE_SIMPLE | SL_NODE_LISTED);
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

void sl_displayed_forget_edges(sl_displayed *d) {
    for (size_t n = 0; n < d->mesh->node_count; n++)
        d->mesh->node[n].flags &= ~(uint32_t)(SL_NODE_SIMPLE | SL_NODE_LISTED);
    d->hanging_count = 0;
}

void sl_displayed_mark_all(sl_displayed *d) {
    sl_displayed_forget_edges(d);
    d->dirty_all = true;
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
    sl_draw_kernels draw;
    bool remember;               /* what is on leaves' edges: when all are drawn */
    atomic_size_t hanging_count; /* in d->hanging; beyond its capacity they are counted alone */
} draw_job;

sl_leaf_weights sl_displayed_weights_of(const sl_mesh_place *n) {
    const float unit = 1.0f / (float)SL_MESH_DYADIC;
    float p0 = (float)n->p[0] * unit, q0 = (float)n->q[0] * unit, p1 = (float)n->p[1] * unit - p0,
          q1 = (float)n->q[1] * unit - q0,
          /* places have an area */
        p2 = (float)n->p[2] * unit - p0, q2 = (float)n->q[2] * unit - q0,
          inverse = 1.0f / (p1 * q2 - p2 * q1);
    return (sl_leaf_weights){p0, q0, q2 * inverse, -p2 * inverse, -q1 * inverse, p1 * inverse};
}

static float centre_of(float a, float b, float c) { return a + ((b - a) + (c - a)) * (1.0f / 3.0f); }

/* From the vertices that a leaf with SL_NODE_SIMPLE has. */
static sl_simple_fan simple_fan(const sl_displayed *d, const sl_mesh_place *leaf) {
    const sl_mesh_node *node = &d->mesh->node[leaf->node];
    const float *value = d->mesh->value;
    sl_simple_fan fan = {.weights = sl_displayed_weights_of(leaf)};
    for (int c = 0; c < 3; c++) {
        for (int k = 0; k < 3; k++) fan.corner[c][k] = value[3 * (size_t)node->vertex[c] + (size_t)k];
    }
    for (int e = 0; e < 3; e++) {
        uint32_t middle = d->middle[leaf->node][e];
        const float *from = fan.corner[(e + 1) % 3], *to = fan.corner[(e + 2) % 3];
        for (int k = 0; k < 3; k++) {
            float known = middle != SL_NO_INDEX ? value[3 * (size_t)middle + (size_t)k] : 0.0f;
            fan.middle[e][k] = middle != SL_NO_INDEX ? known : from[k] + 0.5f * (to[k] - from[k]);
        }
    }
    for (int k = 0; k < 3; k++)
        fan.centre[k] = centre_of(fan.corner[0][k], fan.corner[1][k], fan.corner[2][k]);
    return fan;
}

static void remember_list(draw_job *job, const sl_mesh_place *leaf, size_t count) {
    sl_displayed *d = job->d;
    size_t first = atomic_fetch_add_explicit(&job->hanging_count, count, memory_order_relaxed), at = first;
    if (first + count > d->hanging_capacity) return;
    for (int e = 0; e < 3; e++) {
        sl_edge_vertices list;
        sl_mesh_edge_vertices(d->mesh, leaf, e, &list);
        for (int i = 0; i < list.count; i++)
            d->hanging[at++] = (sl_hanging_vertex){list.vertex[i], (uint8_t)e, list.at[i]};
    }
    d->middle[leaf->node][0] = (uint32_t)first;
    d->middle[leaf->node][1] = (uint32_t)count;
    d->mesh->node[leaf->node].flags |= SL_NODE_LISTED;
}

/* To look up vertices on edges takes longer than to draw the pixels, so they are remembered until the leaf is
 * marked. Most leaves have no more than middles; of others there is a list, when all leaves are drawn. Where
 * the list is in memory depends on the threads, what it says does not. */
static void remember(draw_job *job, const sl_mesh_place *leaf, const sl_mesh_fan *fan) {
    sl_displayed *d = job->d;
    sl_mesh_node *node = &d->mesh->node[leaf->node];
    bool simple = true;
    for (int i = 0; i < 3; i++) {
        if (d->mesh->state[node->vertex[i]] != SL_VERTEX_KNOWN) return;
        simple &= fan->points[i] <= 3;
    }
    if (!simple) {
        if (job->remember)
            remember_list(job, leaf, (size_t)(fan->points[0] + fan->points[1] + fan->points[2] - 6));
        return;
    }
    for (int e = 0; e < 3; e++)
        d->middle[leaf->node][e] = fan->points[e] == 3 ? sl_mesh_find_middle(d->mesh, leaf, e) : SL_NO_INDEX;
    node->flags |= SL_NODE_SIMPLE;
}

/* Values at equal steps along an edge, between two of its vertices. */
static void spread(sl_full_fan *full, int edge, int from, int to, const float *a, const float *b) {
    float step = 1.0f / (float)(to - from);
    for (int k = 0; k < 3; k++) {
        float *on_edge = full->edge[k] + edge * SL_FAN_EDGE;
        for (int i = from; i < to; i++) on_edge[i] = a[k] + (float)(i - from) * step * (b[k] - a[k]);
        on_edge[to] = b[k];
    }
}
_Static_assert(SL_FULL_FAN_STEPS + 1 == SL_FAN_EDGE, "vertices on edges lie at whole steps");

static void full_fan(const sl_mesh_fan *fan, const sl_mesh_place *of, sl_full_fan *full) {
    full->weights = sl_displayed_weights_of(of);
    for (int k = 0; k < 3; k++) full->centre[k] = fan->centre[k];
    for (int e = 0; e < 3; e++) {
        for (int n = 0; n + 1 < fan->points[e]; n++) {
            int from = (int)(fan->along[e][n] * SL_FULL_FAN_STEPS),
                to = (int)(fan->along[e][n + 1] * SL_FULL_FAN_STEPS);
            spread(full, e, from, to, fan->on_edge[e][n], fan->on_edge[e][n + 1]);
        }
    }
}

/* The same from the list that a leaf with SL_NODE_LISTED has. */
static void listed_fan(const sl_displayed *d, const sl_mesh_place *leaf, sl_full_fan *full) {
    const uint32_t *vertex = d->mesh->node[leaf->node].vertex;
    const float *value = d->mesh->value, *corner[3];
    const sl_hanging_vertex *next = d->hanging + d->middle[leaf->node][0],
                            *end = next + d->middle[leaf->node][1];
    for (int c = 0; c < 3; c++) corner[c] = value + 3 * (size_t)vertex[c];
    full->weights = sl_displayed_weights_of(leaf);
    for (int k = 0; k < 3; k++) full->centre[k] = centre_of(corner[0][k], corner[1][k], corner[2][k]);
    for (int e = 0; e < 3; e++) {
        const float *from = corner[(e + 1) % 3];
        int at = 0;
        for (; next < end && next->edge == e; next++) {
            spread(full, e, at, next->at, from, value + 3 * (size_t)next->vertex);
            from = value + 3 * (size_t)next->vertex;
            at = next->at;
        }
        spread(full, e, at, SL_FULL_FAN_STEPS, from, corner[(e + 2) % 3]);
    }
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

static void fill(const draw_job *job, const uint32_t *pixel, size_t count) {
    const float value[3] = {job->fallback.r, job->fallback.g, job->fallback.b};
    for (int k = 0; k < 3; k++) {
        for (size_t i = 0; i < count; i++) job->planes[k][pixel[i]] = value[k];
    }
}

static void draw_list(draw_job *job, const sl_mesh_place *leaf, const uint32_t *pixel, const float *w1,
                      const float *w2, size_t count) {
    sl_displayed *d = job->d;
    const uint32_t *flags = &d->mesh->node[leaf->node].flags;
    sl_full_fan full;
    if (!(*flags & (SL_NODE_SIMPLE | SL_NODE_LISTED))) {
        sl_mesh_place shown = *leaf;
        sl_mesh_fan fan;
        if (!find_fan(d, &shown, &fan)) {
            fill(job, pixel, count);
            return;
        }
        if (shown.node == leaf->node) remember(job, leaf, &fan);
        full_fan(&fan, &shown, &full);
    }
    if (*flags & SL_NODE_SIMPLE) {
        sl_simple_fan simple = simple_fan(d, leaf);
        job->draw.simple(&simple, count, pixel, w1, w2, job->planes);
        return;
    }
    if (*flags & SL_NODE_LISTED) listed_fan(d, leaf, &full);
    job->draw.full(&full, count, pixel, w1, w2, job->planes);
}

static void draw_leaf(draw_job *job, const sl_mesh_place *leaf) {
    const sl_displayed *d = job->d;
    const sl_visible_pixels *pixels = d->pixels;
    uint32_t first = d->first[leaf->node], count = d->mesh->node[leaf->node].pixels;
    draw_list(job, leaf, pixels->pixel + first, pixels->w1 + first, pixels->w2 + first, count);
}

static void draw_some(void *context, size_t index, unsigned worker) {
    (void)worker;
    draw_job *job = context;
    size_t begin = index * LEAVES_AT_ONCE, end = begin + LEAVES_AT_ONCE;
    for (size_t i = begin; i < end && i < job->d->dirty_count; i++) {
        sl_mesh_place leaf = sl_mesh_place_of(job->d->mesh, job->d->dirty[i]);
        draw_leaf(job, &leaf);
    }
}

static void draw_below(draw_job *job, const sl_mesh_place *place) {
    const sl_mesh_node *node = &job->d->mesh->node[place->node];
    if (!node->pixels) return;
    if (node->child == SL_NO_INDEX) {
        draw_leaf(job, place);
        return;
    }
    for (int c = 0; c < 4; c++) {
        sl_mesh_place child = sl_mesh_child_place(job->d->mesh, place, c);
        draw_below(job, &child);
    }
}

static void draw_share(void *context, size_t share, unsigned worker) {
    (void)worker;
    draw_job *job = context;
    const sl_displayed *d = job->d;
    size_t begin, end;
    sl_visible_share(d->pixels, share, &begin, &end);
    for (size_t e = begin; e < end; e++) {
        if (!sl_displayed_wants(d, e)) continue;
        sl_mesh_place root = sl_mesh_root_place(d->mesh, d->pixels->face[e].face);
        draw_below(job, &root);
    }
}

/* Where lists have outgrown their room, some of it for leaves that are no more, all are forgotten, and there
 * is more room next time. */
static void keep_lists(sl_displayed *d, size_t count) {
    d->hanging_count = count;
    if (count <= d->hanging_capacity) return;
    for (size_t n = 0; n < d->mesh->node_count; n++) d->mesh->node[n].flags &= ~(uint32_t)SL_NODE_LISTED;
    sl_free(d->hanging);
    size_t capacity = sl_grown_capacity(count, 0);
    d->hanging = sl_allocate_unset(capacity, sizeof *d->hanging); /* none: nothing is remembered */
    d->hanging_capacity = d->hanging ? capacity : 0;
    d->hanging_count = 0;
}

void sl_displayed_draw(sl_displayed *d, unsigned threads, sl_rgb fallback, float *const planes[3],
                       sl_counters *counters) {
    if (!d->pixels) return;
    draw_job job = {.d = d,
                    .fallback = fallback,
                    .planes = planes,
                    .draw = sl_draw_kernels_for(sl_isa_best()),
                    .remember = d->dirty_all};
    atomic_init(&job.hanging_count, d->hanging_count);
    uint64_t redrawn = settle_list(d);
    if (d->dirty_all) {
        for (size_t i = 0; i < d->heap_count; i++) redrawn += d->pixels->face[d->heap[i]].count;
        sl_parallel_for(threads, SL_VISIBLE_SHARES, draw_share, &job);
    } else {
        sl_parallel_for(threads, (d->dirty_count + LEAVES_AT_ONCE - 1) / LEAVES_AT_ONCE, draw_some, &job);
    }
    keep_lists(d, atomic_load(&job.hanging_count));
    d->dirty_count = 0;
    d->dirty_all = false;
    sl_count(counters, SL_COUNT_PIXELS_REDRAWN, redrawn);
}
