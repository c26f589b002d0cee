/* Large targets: bands of whole rows of tiles, each owned by one thread, which draws every cluster that touches its
 * band.
 *
 * A cluster that lies across a band's edge is transformed in both bands, but its triangles touch disjoint pixels
 * there, so no thread waits for another and there is nothing to merge. Coverage and depth of a pixel do not depend
 * on the band, and a cluster is counted in its first band only: pixels and counters are the same however the target
 * is cut. */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "raster/internal.h"

enum { BANDS_MAX = 256, BANDS_PER_THREAD = 4, BAND_STEP = SL_BLOCK };

typedef struct {
    const sl_raster *raster;
    const sl_view *view;
    uint32_t *id;
    float *depth;
    uint32_t *visible; /* clusters seen by the whole target */
    uint32_t *list;    /* clusters seen by a band, while the ranges are made */
    uint32_t visible_count;
    uint16_t *first_band, *last_band;
    int bands, band_height;
    sl_counters band_counters[BANDS_MAX];
    sl_raster_scratch scratch[]; /* one a worker */
} tiled_pass;

static sl_pass_view band_view(const tiled_pass *p, int band) {
    sl_pass_view pass = sl_pass_view_make(p->view);
    pass.y0 = band * p->band_height;
    pass.y1 = pass.y0 + p->band_height < pass.height ? pass.y0 + p->band_height : pass.height;
    return pass;
}

/* The band's own upper and lower plane, a pixel further out: y <= high w and y >= low w. */
static void narrow_planes(sl_pass_view *pass) {
    float low = (float)(2.0 * (double)(pass->y0 - 1) / (double)pass->height - 1.0);
    float high = (float)(2.0 * (double)(pass->y1 + 1) / (double)pass->height - 1.0);
    for (int k = 0; k < 4; k++) {
        pass->plane[2][k] = high * pass->clip[3][k] - pass->clip[1][k];
        pass->plane[3][k] = pass->clip[1][k] - low * pass->clip[3][k];
    }
    for (int i = 2; i < 4; i++) {
        pass->plane_length[i] = sl_length(sl_v3(pass->plane[i][0], pass->plane[i][1], pass->plane[i][2]));
    }
}

/* Which bands a cluster is drawn in. Its bounds are convex, so the bands are neighbours; one that no band's planes
 * keep (by a hair) is counted and drawn in the first. */
static void assign_bands(tiled_pass *p) {
    const uint16_t none = UINT16_MAX;
    for (size_t c = 0; c < p->raster->cluster_count; c++) p->first_band[c] = none;
    for (int band = 0; band < p->bands; band++) {
        sl_pass_view pass = band_view(p, band);
        narrow_planes(&pass);
        uint32_t count = p->raster->kernels->cull(p->raster, &pass, p->list);
        for (uint32_t n = 0; n < count; n++) {
            if (p->first_band[p->list[n]] == none) p->first_band[p->list[n]] = (uint16_t)band;
            p->last_band[p->list[n]] = (uint16_t)band;
        }
    }
    for (size_t c = 0; c < p->raster->cluster_count; c++) {
        if (p->first_band[c] == none) p->first_band[c] = 0;
    }
}

static void draw_band(void *context, size_t index, unsigned worker) {
    tiled_pass *p = context;
    sl_pass_view pass = band_view(p, (int)index);
    sl_cluster_list list = {p->visible, p->visible_count, p->first_band, p->last_band, (uint16_t)index};
    sl_pass_draw(p->raster, p->view, &pass, p->id, p->depth, &p->scratch[worker], &list, &p->band_counters[index]);
}

static void draw_bands(tiled_pass *p, unsigned threads, sl_counters *counters) {
    sl_pass_view whole = sl_pass_view_make(p->view);
    p->visible_count = p->raster->kernels->cull(p->raster, &whole, p->visible);
    sl_pass_count(p->raster, p->visible_count, counters);
    assign_bands(p);
    sl_parallel_for(threads, (size_t)p->bands, draw_band, p);
    for (int band = 0; band < p->bands; band++) sl_counters_add(counters, &p->band_counters[band]);
}

static void choose_bands(tiled_pass *p, unsigned threads, int height) {
    int wanted = threads <= 1 ? 1 : (int)threads * BANDS_PER_THREAD;
    if (wanted > BANDS_MAX) wanted = BANDS_MAX;
    int rows = (height + wanted - 1) / wanted;
    p->band_height = (rows + BAND_STEP - 1) / BAND_STEP * BAND_STEP;
    p->bands = (height + p->band_height - 1) / p->band_height;
}

static void release(tiled_pass *p, unsigned threads, const sl_target *target) {
    if (!p) return;
    for (unsigned i = 0; i < threads; i++) {
        sl_free(p->scratch[i].vertices);
        sl_free(p->scratch[i].batch);
    }
    if (!target->id) sl_free(p->id);
    if (!target->depth) sl_free(p->depth);
    sl_free(p->visible);
    sl_free(p->list);
    sl_free(p->first_band);
    sl_free(p->last_band);
    sl_free(p);
}

static tiled_pass *prepare(const sl_raster *raster, const sl_view *view, unsigned threads, const sl_target *target) {
    tiled_pass *p = sl_allocate(1, sizeof *p + threads * sizeof p->scratch[0]);
    if (!p) return NULL;
    size_t pixels = (size_t)view->width * (size_t)view->height, clusters = raster->cluster_count + SL_LANES;
    p->raster = raster;
    p->view = view;
    p->id = target->id ? target->id : sl_allocate(pixels, sizeof *p->id);
    p->depth = target->depth ? target->depth : sl_allocate(pixels, sizeof *p->depth);
    p->visible = sl_allocate(clusters, sizeof *p->visible);
    p->list = sl_allocate(clusters, sizeof *p->list);
    p->first_band = sl_allocate(clusters, sizeof *p->first_band);
    p->last_band = sl_allocate(clusters, sizeof *p->last_band);
    bool ok = p->id && p->depth && p->visible && p->list && p->first_band && p->last_band;
    for (unsigned i = 0; i < threads; i++) {
        p->scratch[i].vertices = sl_allocate(1, sizeof *p->scratch[i].vertices);
        p->scratch[i].batch = sl_allocate(1, sizeof *p->scratch[i].batch);
        ok = ok && p->scratch[i].vertices && p->scratch[i].batch;
    }
    if (ok) return p;
    release(p, threads, target);
    return NULL;
}

sl_status sl_raster_id(const sl_raster *raster, const sl_view *view, unsigned threads, const sl_target *target,
                       sl_counters *counters, sl_error *error) {
    if (view->width < 1 || view->height < 1 || view->width > SL_RASTER_MAX_SIZE || view->height > SL_RASTER_MAX_SIZE) {
        return sl_fail(error, SL_ERROR_USAGE, "a raster target of %d x %d pixels: from 1 to %d each way", view->width,
                       view->height, (int)SL_RASTER_MAX_SIZE);
    }
    threads = sl_thread_count(threads);
    tiled_pass *p = prepare(raster, view, threads, target);
    if (!p) return sl_fail_memory(error, "a render's planes");
    choose_bands(p, threads, view->height);
    draw_bands(p, threads, counters);
    release(p, threads, target);
    return SL_OK;
}
