/* One render: cluster by cluster through the pipeline of internal.h. */
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "raster/internal.h"

/* ---- scratch ---- */

sl_status sl_raster_scratch_create(const sl_raster *raster, int max_width, int max_height, sl_raster_scratch **scratch,
                                   sl_error *error) {
    *scratch = NULL;
    if (max_width < 0 || max_height < 0 || max_width > SL_RASTER_MAX_SIZE || max_height > SL_RASTER_MAX_SIZE) {
        return sl_fail(error, SL_ERROR_USAGE, "a raster target of %d x %d pixels: at most %d each way", max_width, max_height,
                       (int)SL_RASTER_MAX_SIZE);
    }
    sl_raster_scratch *s = sl_allocate(1, sizeof *s);
    if (s) {
        s->max_pixels = (size_t)max_width * (size_t)max_height;
        s->visible = sl_allocate(raster->cluster_count + SL_LANES, sizeof *s->visible);
        s->vertices = sl_allocate(1, sizeof *s->vertices);
        s->batch = sl_allocate(1, sizeof *s->batch);
        s->id = sl_allocate(s->max_pixels, sizeof *s->id);
        s->depth = sl_allocate(s->max_pixels, sizeof *s->depth);
    }
    if (!s || !s->visible || !s->vertices || !s->batch || !s->id || !s->depth) {
        sl_raster_scratch_destroy(s);
        return sl_fail_memory(error, "a render's scratch");
    }
    *scratch = s;
    return SL_OK;
}

void sl_raster_scratch_destroy(sl_raster_scratch *s) {
    if (!s) return;
    sl_free(s->visible);
    sl_free(s->vertices);
    sl_free(s->batch);
    sl_free(s->id);
    sl_free(s->depth);
    sl_free(s);
}

/* ---- drawing ---- */

typedef struct {
    const sl_raster *raster;
    const sl_view *view;
    const sl_pass_view *pass;
    sl_raster_scratch *scratch;
    uint32_t *id;
    float *depth;
} render;

static void flush(const render *r) {
    sl_batch *batch = r->scratch->batch;
    if (!batch->count) return;
    r->raster->kernels->set_up(r->pass, batch);
    r->raster->kernels->rasterize(r->pass, batch, r->id, r->depth);
    for (uint32_t t = 0; r->raster->masked && t < batch->count; t++) {
        if (batch->masked[t]) sl_rasterize_masked(r->raster, r->view, r->pass, batch, t, r->id, r->depth);
    }
    batch->count = 0;
}

static void gather_accepted(const render *r, uint32_t first, const uint8_t *accepted, uint32_t count) {
    const sl_raster *raster = r->raster;
    const sl_vertex_buffer *from = r->scratch->vertices;
    sl_batch *batch = r->scratch->batch;
    uint32_t base = batch->count;
    for (uint32_t k = 0; k < 3; k++) {
        for (uint32_t n = 0; n < count; n++) {
            uint16_t v = raster->corner[k][first + accepted[n]];
            batch->snapped_u[k][base + n] = from->snapped_u[v];
            batch->snapped_v[k][base + n] = from->snapped_v[v];
            batch->u[k][base + n] = from->u[v];
            batch->v[k][base + n] = from->v[v];
            batch->depth[k][base + n] = from->depth[v];
        }
    }
    for (uint32_t n = 0; n < count; n++) batch->id[base + n] = raster->triangle[first + accepted[n]];
    for (uint32_t n = 0; n < count; n++) {
        batch->masked[base + n] = raster->masked && raster->triangle_masked[first + accepted[n]];
    }
    batch->count += count;
}

static void clip_and_append(const render *r, uint32_t triangle) {
    const sl_raster *raster = r->raster;
    sl_batch *batch = r->scratch->batch;
    if (batch->count + SL_CLIP_TRIANGLES > SL_BATCH) flush(r);
    uint16_t corner[3] = {raster->corner[0][triangle], raster->corner[1][triangle], raster->corner[2][triangle]};
    uint32_t base = batch->count, made = sl_clip_triangle(r->pass, r->scratch->vertices, corner, batch);
    for (uint32_t n = 0; n < made; n++) {
        batch->id[base + n] = raster->triangle[triangle];
        batch->masked[base + n] = raster->triangle_masked[triangle];
    }
}

/* Counts are of the whole target, whatever the region, so that they do not depend on how the target was cut. */
static void draw_cluster(const render *r, uint32_t cluster, bool counted, sl_counters *counters) {
    const sl_raster *raster = r->raster;
    uint8_t accepted[SL_CLUSTER_TRIANGLES], clipped[SL_CLUSTER_TRIANGLES];
    raster->kernels->transform(raster, cluster, r->pass, r->scratch->vertices);
    sl_classes classes = raster->kernels->classify(raster, cluster, r->pass, r->scratch->vertices, accepted, clipped);
    if (counted) {
        uint32_t all = raster->triangles[cluster];
        sl_count(counters, SL_COUNT_TRIANGLES_SUBMITTED, all);
        sl_count(counters, SL_COUNT_TRIANGLES_CULLED, classes.culled);
        sl_count(counters, SL_COUNT_TRIANGLES_DROPPED, classes.dropped);
        sl_count(counters, SL_COUNT_TRIANGLES_CLIPPED, classes.clipped);
        sl_count(counters, SL_COUNT_TRIANGLES_RASTERIZED, all - classes.culled - classes.dropped);
    }
    uint32_t first = raster->first_triangle[cluster];
    gather_accepted(r, first, accepted, classes.accepted);
    for (uint32_t n = 0; n < classes.clipped; n++) clip_and_append(r, first + clipped[n]);
    flush(r);
}

static void clear_rows(const sl_pass_view *pass, uint32_t *id, float *depth) {
    size_t first = (size_t)pass->y0 * (size_t)pass->width, last = (size_t)pass->y1 * (size_t)pass->width;
    float far = pass->inverse_w ? 0.0f : 1.0f;
    for (size_t i = first; i < last; i++) {
        id[i] = SL_NO_INDEX;
        depth[i] = far;
    }
}

void sl_pass_draw(const sl_raster *raster, const sl_view *view, const sl_pass_view *pass, uint32_t *id, float *depth,
                  sl_raster_scratch *scratch, const sl_cluster_list *list, sl_counters *counters) {
    render r = {raster, view, pass, scratch, id, depth};
    clear_rows(pass, id, depth);
    scratch->batch->count = 0;
    for (uint32_t n = 0; n < list->count; n++) {
        uint32_t cluster = list->cluster[n];
        const uint16_t *first = list->first_region, *last = list->last_region;
        if (first && (first[cluster] > list->region || last[cluster] < list->region)) continue;
        draw_cluster(&r, cluster, !first || first[cluster] == list->region, counters);
    }
}

void sl_pass_count(const sl_raster *raster, uint32_t visible, sl_counters *counters) {
    sl_count(counters, SL_COUNT_RASTER_PASSES, 1);
    sl_count(counters, SL_COUNT_CLUSTERS_TESTED, raster->cluster_count);
    sl_count(counters, SL_COUNT_CLUSTERS_CULLED, raster->cluster_count - visible);
}

void sl_raster_id_small(const sl_raster *raster, const sl_view *view, const sl_target *target, sl_raster_scratch *scratch,
                        sl_counters *counters) {
    sl_pass_view pass = sl_pass_view_make(view);
    sl_cluster_list list = {.cluster = scratch->visible, .count = raster->kernels->cull(raster, &pass, scratch->visible)};
    sl_pass_count(raster, list.count, counters);
    sl_pass_draw(raster, view, &pass, target->id ? target->id : scratch->id, target->depth ? target->depth : scratch->depth,
                 scratch, &list, counters);
}
