/* Additive blending of triangles: every fragment counts, whether hidden or not, and is added in index order, since float
 * sums depend on their order.
 *
 * Attributes are interpolated in 2D homogeneous coordinates (Olano and Greer 1997, "Triangle scan conversion using 2D
 * homogeneous coordinates"): with e_k the edge functions of the triangle as it was before clipping (barycentrics.h),
 *     a(x, y) = (e_0 a_0 + e_1 a_1 + e_2 a_2) / (e_0 + e_1 + e_2),
 * numerator and denominator are linear in the pixel, so each is one plane a triangle, and what clipping cuts off does not
 * matter.
 *
 * Clusters are gathered and transformed in every tile that they touch, and set up as a batch; add_kernels.c does the rest. */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "raster/fragments/add.h"
#include "raster/resolve/barycentrics.h"

/* A worker's own. */
typedef struct {
    sl_tile tile;
    sl_one_cluster cluster;
    sl_vertex_buffer vertices;
    sl_classes classes;
    sl_batch batch;
    sl_add_tile add;
} worker_memory;

typedef struct {
    const sl_raster *bounds; /* of clusters in index order */
    const sl_view *view;
    const float *attributes;
    int channels;
    sl_pass_view pass;
    sl_tiles tiles;
    sl_visible visible;
    worker_memory **worker;
    uint64_t *blended; /* by tile */
} adding;

/* ---- planes of one triangle ---- */

static sl_value_plane plane_of(const sl_edge_lines *e, const double value[3], double scale) {
    double a = (e->a0 * value[0] + e->a1 * value[1]) + e->a2 * value[2];
    double b = (e->b0 * value[0] + e->b1 * value[1]) + e->b2 * value[2];
    double c = (e->c0 * value[0] + e->c1 * value[1]) + e->c2 * value[2];
    return (sl_value_plane){(float)(a * scale), (float)(b * scale), (float)(c * scale)};
}

/* Whether the denominator rounds to 1 all over a tile, so that nothing needs to be divided by it. */
static bool is_level(sl_value_plane p) { return p.c == 1.0f && fabsf(p.a) + fabsf(p.b) < 0x1p-26f / SL_TILE; }

/* Planes told from the centre of pixel (x, y) of the target, one pixel a step; scaled so that the denominator is 1 there or
 * nearby, which keeps floats in range. */
static void find_planes(const adding *p, uint32_t triangle, uint32_t t, int x, int y, sl_add_planes *out) {
    const sl_raster_mesh *mesh = &p->bounds->mesh;
    sl_window_corner v[3];
    for (int k = 0; k < 3; k++) {
        v[k] = sl_window_corner_of(&p->pass, sl_sub(sl_mesh_position(mesh, mesh->vertex[k][triangle]), p->view->origin));
    }
    sl_edge_lines e = sl_edge_lines_about(&p->pass, v[0], v[1], v[2], (double)(x - p->view->x), (double)(y - p->view->y));
    double at = (e.c0 + e.c1) + e.c2, largest = fabs(e.c0) + fabs(e.c1) + fabs(e.c2);
    double scale = fabs(at) > 1e-9 * largest ? 1.0 / at : largest > 0.0 ? 1.0 / largest : 1.0;
    out->x[t] = x;
    out->y[t] = y;
    out->denominator[t] = plane_of(&e, (const double[3]){1, 1, 1}, scale);
    out->level[t] = is_level(out->denominator[t]);
    for (int c = 0; c < p->channels; c++) {
        double value[3];
        for (int k = 0; k < 3; k++) {
            value[k] = (double)p->attributes[(size_t)mesh->vertex[k][triangle] * (size_t)p->channels + (size_t)c];
        }
        sl_add_channel *channel = &out->channel[(size_t)t * (size_t)p->channels + (size_t)c];
        channel->value = plane_of(&e, value, scale);
        channel->least = (float)fmin(fmin(value[0], value[1]), value[2]);
        channel->most = (float)fmax(fmax(value[0], value[1]), value[2]);
    }
}

/* ---- one tile ---- */

static int bounded(int x, int low, int high) { return x < low ? low : x > high ? high : x; }

/* Of the box's part in the tile; what the scissor cuts off does not matter, so that a pixel has the same bits with and without it. */
static int middle(const int32_t snapped[3][SL_BATCH], uint32_t t, int first) {
    int32_t low = snapped[0][t], high = low;
    for (int k = 1; k < 3; k++) {
        low = snapped[k][t] < low ? snapped[k][t] : low;
        high = snapped[k][t] > high ? snapped[k][t] : high;
    }
    return (bounded(low >> 8, first, first + SL_TILE - 1) + bounded(high >> 8, first, first + SL_TILE - 1)) / 2;
}

static uint64_t add_batch(const adding *p, worker_memory *w) {
    const sl_raster_kernels *kernels = p->bounds->kernels;
    sl_batch *batch = &w->batch;
    uint64_t blended = 0;
    if (!batch->count) return 0;
    kernels->set_up_edges(&w->tile, batch, 0);
    for (uint32_t t = 0; t < batch->count; t++) {
        if (batch->x0[t] > batch->x1[t] || batch->y0[t] > batch->y1[t]) continue;
        if (!sl_widen_edges(batch, t, &w->add.edges[t])) batch->x1[t] = batch->x0[t] - 1;
        else find_planes(p, batch->id[t], t, middle(batch->snapped_u, t, w->tile.left), middle(batch->snapped_v, t, w->tile.low), &w->add.planes);
    }
    blended = kernels->add(&w->tile, batch, &w->add);
    batch->count = 0;
    return blended;
}

/* If triangle t is the list's next, moves on. */
static bool is_next(const uint8_t *list, uint32_t *next, uint32_t end, uint32_t t) {
    if (*next >= end || list[*next] != t) return false;
    ++*next;
    return true;
}

/* Triangles inside and triangles to be clipped, merged by index. */
static uint64_t add_cluster(const adding *p, worker_memory *w, uint32_t cluster) {
    const sl_raster *raster = &w->cluster.raster;
    const sl_classes *classes = &w->classes;
    uint32_t tiny = 0, other = 0, once = 0;
    uint64_t blended = 0;
    sl_one_cluster_fetch(&w->cluster, cluster);
    raster->kernels->transform(raster, 0, &p->pass, &w->vertices);
    raster->kernels->classify(raster, 0, &p->pass, &w->tile, &w->vertices, &w->classes);
    uint32_t several = classes->clipped_once;
    for (uint32_t t = 0; t < raster->triangles[0]; t++) {
        const uint32_t base = w->batch.count, id = raster->triangle[t];
        const bool inside = is_next(classes->tiny_list, &tiny, classes->tiny, t) ||
                            is_next(classes->other_list, &other, classes->other, t);
        const bool clipped = is_next(classes->clipped_list, &once, classes->clipped_once, t) ||
                             is_next(classes->clipped_list, &several, classes->clipped, t);
        if (id == p->view->skip_triangle) continue;
        if (inside) {
            sl_batch_append(raster, &w->vertices, t, &w->batch);
        } else if (clipped) {
            uint16_t corner[3] = {raster->corner[0][t], raster->corner[1][t], raster->corner[2][t]};
            sl_clip_triangle(&p->pass, &w->vertices, corner, &w->batch);
        }
        for (uint32_t n = base; n < w->batch.count; n++) w->batch.id[n] = id;
        if (w->batch.count + SL_CLIP_TRIANGLES > SL_BATCH) blended += add_batch(p, w);
    }
    return blended + add_batch(p, w);
}

static void add_tile(void *context, size_t index, unsigned worker) {
    adding *p = context;
    worker_memory *w = p->worker[worker];
    int columns = p->tiles.columns;
    sl_tile_place(&w->tile, &p->pass, p->tiles.first_column + (int)index % columns, p->tiles.first_row + (int)index / columns);
    w->batch.count = 0;
    for (uint32_t n = 0; n < p->visible.count; n++) {
        if (p->visible.x0[n] >= w->tile.x1 || p->visible.x1[n] < w->tile.x0) continue;
        if (p->visible.y0[n] >= w->tile.y1 || p->visible.y1[n] < w->tile.y0) continue;
        p->blended[index] += add_cluster(p, w, p->visible.cluster[n]);
    }
    p->bounds->kernels->add_return(&w->tile, &w->add);
}

/* ---- the whole ---- */

static worker_memory *create_worker(const adding *p, const sl_target *size, float *planes) {
    worker_memory *w = sl_allocate(1, sizeof *w);
    if (!w) return NULL;
    sl_one_cluster_make(p->bounds, &w->cluster);
    w->add.width = size->width;
    w->add.channels = p->channels;
    w->add.plane = (size_t)size->width * (size_t)size->height;
    w->add.target = planes;
    w->add.memory = sl_allocate((size_t)p->channels * SL_TILE_PIXELS, sizeof *w->add.memory);
    w->add.planes.channel = sl_allocate((size_t)p->channels * SL_BATCH, sizeof *w->add.planes.channel);
    return w;
}

static void destroy_worker(worker_memory *w) {
    if (!w) return;
    sl_free(w->add.memory);
    sl_free(w->add.planes.channel);
    sl_free(w);
}

static bool allocate(adding *p, unsigned threads, size_t tiles, const sl_target *size, float *planes) {
    p->worker = sl_allocate(threads, sizeof *p->worker);
    p->blended = sl_allocate(tiles, sizeof *p->blended);
    bool ok = sl_visible_allocate(&p->visible, p->bounds) && p->worker && p->blended;
    for (unsigned i = 0; p->worker && i < threads; i++) {
        worker_memory *w = p->worker[i] = create_worker(p, size, planes);
        ok &= w && w->add.memory && w->add.planes.channel;
    }
    return ok;
}

static void release(adding *p, unsigned threads) {
    for (unsigned i = 0; p->worker && i < threads; i++) destroy_worker(p->worker[i]);
    sl_free(p->worker);
    sl_free(p->blended);
    sl_visible_free(&p->visible);
}

sl_status sl_raster_add(const sl_raster *raster, const sl_view *view, unsigned threads, const float *attributes, int channels,
                        const sl_target *size, float *planes, sl_counters *counters, sl_error *error) {
    sl_status status = sl_viewport_check(view, size, error);
    if (status != SL_OK) return status;
    threads = sl_thread_count(threads);
    sl_raster *bounds;
    status = sl_in_order_bounds(raster, threads, &bounds, error);
    if (status != SL_OK) return status;
    adding p = {.bounds = bounds, .view = view, .attributes = attributes, .channels = channels,
                .pass = sl_pass_view_make(view, size->width, size->height)};
    p.pass.skip = SL_NO_INDEX; /* add_cluster() sees to it */
    p.tiles = sl_tiles_of(&p.pass);
    size_t tiles = (size_t)p.tiles.columns * (size_t)p.tiles.rows;
    if (threads > tiles) threads = (unsigned)tiles;
    bool ok = allocate(&p, threads, tiles, size, planes);
    if (ok) {
        bounds->kernels->cull(bounds, &p.pass, &p.visible); /* in index order */
        sl_parallel_for(threads, tiles, add_tile, &p);
        for (size_t i = 0; i < tiles; i++) sl_count(counters, SL_COUNT_FRAGMENTS_BLENDED, p.blended[i]);
        sl_count(counters, SL_COUNT_RASTER_PASSES, 1);
    }
    release(&p, threads);
    sl_raster_destroy(bounds);
    return ok ? SL_OK : sl_fail_memory(error, "a blending pass");
}
