/* Gouraud (image pass 3): a leaf's pixels from its vertices and those that its neighbours put on its edges.
 * Only what has changed is drawn: leaves that were cut or put together, and those on whose edges a vertex
 * became known. Pixels belong to one leaf each, so the picture does not depend on the order, and an
 * incremental one is that of drawing it all. */
#include "cache/multi_mesh/displayed_internal.h"

#include "base/counters.h"
#include "base/parallel.h"

void sl_displayed_mark(sl_displayed *d, uint32_t leaf) { d->mesh->node[leaf].flags |= SL_NODE_DIRTY; }

typedef struct draw_job {
    const sl_displayed *d;
    sl_rgb fallback;
    float *const *planes;
    uint64_t redrawn[SL_VISIBLE_SHARES]; /* pixels */
} draw_job;

/* Values of the nearest of a leaf and its ancestors whose corners are known. */
static bool find_fan(const sl_displayed *d, sl_mesh_place *place, sl_mesh_fan *fan) {
    while (!sl_mesh_fan_make(d->mesh, place, d->settings.hanging, fan)) {
        uint32_t parent = sl_mesh_parent(d->mesh, place->node);
        if (parent == SL_NO_INDEX) return false;
        *place = sl_mesh_place_of(d->mesh, parent);
    }
    return true;
}

static void draw_leaf(const draw_job *job, const sl_mesh_place *leaf) {
    const sl_visible_pixels *pixels = job->d->pixels;
    uint32_t first = job->d->first[leaf->node], count = job->d->mesh->node[leaf->node].pixels;
    sl_mesh_place shown = *leaf;
    sl_mesh_fan fan;
    bool known = find_fan(job->d, &shown, &fan);
    for (uint32_t i = first; i < first + count; i++) {
        float value[3] = {job->fallback.r, job->fallback.g, job->fallback.b}, w1, w2;
        sl_mesh_weights_within(&shown, pixels->w1[i], pixels->w2[i], &w1, &w2);
        if (known) sl_mesh_fan_value(&fan, w1, w2, value);
        for (int k = 0; k < 3; k++) job->planes[k][pixels->pixel[i]] = value[k];
    }
}

/* Returns the number of pixels drawn. */
static uint64_t draw_below(const draw_job *job, const sl_mesh_place *place) {
    const sl_displayed *d = job->d;
    sl_mesh_node *node = &d->mesh->node[place->node];
    uint64_t redrawn = 0;
    if (!node->pixels) return 0;
    if (node->child == SL_NO_INDEX) {
        if (!d->dirty_all && !(node->flags & SL_NODE_DIRTY)) return 0;
        node->flags &= ~(uint32_t)SL_NODE_DIRTY;
        draw_leaf(job, place);
        return node->pixels;
    }
    for (int c = 0; c < 4; c++) {
        sl_mesh_place child = sl_mesh_child_place(d->mesh, place, c);
        redrawn += draw_below(job, &child);
    }
    return redrawn;
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
        job->redrawn[share] += draw_below(job, &root);
    }
}

void sl_displayed_draw(sl_displayed *d, unsigned threads, sl_rgb fallback, float *const planes[3],
                       sl_counters *counters) {
    if (!d->pixels) return;
    draw_job job = {.d = d, .fallback = fallback, .planes = planes};
    sl_parallel_for(threads, SL_VISIBLE_SHARES, draw_share, &job);
    for (int share = 0; share < SL_VISIBLE_SHARES; share++)
        sl_count(counters, SL_COUNT_PIXELS_REDRAWN, job.redrawn[share]);
    d->dirty_all = false;
}
