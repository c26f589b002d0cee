/* Additive blending of triangles: every fragment counts, whether hidden or not, and is added in index order, since float
 * sums depend on their order.
 *
 * Attributes are interpolated in 2D homogeneous coordinates (Olano and Greer 1997, "Triangle scan conversion using 2D
 * homogeneous coordinates"): with e_k the edge functions of the triangle as it was before clipping (barycentrics.h),
 *     a(x, y) = (e_0 a_0 + e_1 a_1 + e_2 a_2) / (e_0 + e_1 + e_2),
 * numerator and denominator are linear in the pixel, so each is one plane a triangle, and what clipping cuts off does not
 * matter. */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "raster/barycentrics.h"

typedef struct {
    const sl_raster *raster; /* its clusters in index order */
    const sl_view *view;
    const float *attributes;
    int channels;
    float *planes;
    sl_pass_view pass;
    sl_tiles tiles;
    sl_visible visible;
    sl_raster_scratch *scratch; /* one a worker */
    sl_add_triangle **triangle; /* likewise, of `channels` each */
    uint64_t *blended;          /* by tile */
} adding;

/* ---- planes of one triangle ---- */

static sl_value_plane plane_of(const sl_edge_lines *e, const double value[3], double scale) {
    double a = (e->a0 * value[0] + e->a1 * value[1]) + e->a2 * value[2];
    double b = (e->b0 * value[0] + e->b1 * value[1]) + e->b2 * value[2];
    double c = (e->c0 * value[0] + e->c1 * value[1]) + e->c2 * value[2];
    return (sl_value_plane){(float)(a * scale), (float)(b * scale), (float)(c * scale)};
}

/* Planes told from the centre of pixel (x, y) of the target, one pixel a step; scaled so that the denominator is 1 there or
 * nearby, which keeps floats in range. */
static void find_values(const adding *p, uint32_t triangle, int x, int y, sl_add_triangle *out) {
    const sl_raster_mesh *mesh = &p->raster->mesh;
    sl_window_corner v[3];
    for (int k = 0; k < 3; k++) {
        v[k] = sl_window_corner_of(&p->pass, sl_sub(sl_mesh_position(mesh, mesh->vertex[k][triangle]), p->view->origin));
    }
    sl_edge_lines e = sl_edge_lines_about(&p->pass, v[0], v[1], v[2], (double)(x - p->view->x), (double)(y - p->view->y));
    double at = (e.c0 + e.c1) + e.c2, largest = fabs(e.c0) + fabs(e.c1) + fabs(e.c2);
    double scale = fabs(at) > 1e-9 * largest ? 1.0 / at : largest > 0.0 ? 1.0 / largest : 1.0;
    out->denominator = plane_of(&e, (const double[3]){1, 1, 1}, scale);
    for (int c = 0; c < p->channels; c++) {
        double value[3];
        for (int k = 0; k < 3; k++) {
            value[k] = (double)p->attributes[(size_t)mesh->vertex[k][triangle] * (size_t)p->channels + (size_t)c];
        }
        sl_add_channel *channel = &out->channel[c];
        channel->value = plane_of(&e, value, scale);
        channel->least = (float)fmin(fmin(value[0], value[1]), value[2]);
        channel->most = (float)fmax(fmax(value[0], value[1]), value[2]);
    }
}

/* ---- one tile ---- */

static uint64_t add_batch(const adding *p, sl_raster_scratch *s, sl_add_triangle *values) {
    const sl_raster_kernels *kernels = p->raster->kernels;
    uint64_t blended = 0;
    kernels->set_up_edges(&s->tile, &s->batch, 0);
    for (uint32_t t = 0; t < s->batch.count; t++) {
        if (s->batch.x0[t] > s->batch.x1[t] || s->batch.y0[t] > s->batch.y1[t]) continue;
        values->x = (s->batch.x0[t] + s->batch.x1[t]) / 2;
        values->y = (s->batch.y0[t] + s->batch.y1[t]) / 2;
        find_values(p, s->batch.id[t], values->x, values->y, values);
        blended += kernels->add(&p->pass, &s->batch, t, values, p->channels, p->planes);
    }
    s->batch.count = 0;
    return blended;
}

/* Triangles inside and triangles to be clipped, merged by index. */
static uint64_t add_cluster(const adding *p, sl_raster_scratch *s, uint32_t cluster, sl_add_triangle *values) {
    const sl_raster *raster = p->raster;
    const sl_classes *classes = &s->classes;
    uint32_t first = raster->first_triangle[cluster], tiny = 0, other = 0, clipped = 0;
    uint64_t blended = 0;
    raster->kernels->transform(raster, cluster, &p->pass, &s->vertices);
    raster->kernels->classify(raster, cluster, &p->pass, &s->tile, &s->vertices, &s->classes);
    for (uint32_t t = 0; t < raster->triangles[cluster]; t++) {
        uint32_t base = s->batch.count;
        if (tiny < classes->tiny && classes->tiny_list[tiny] == t) {
            sl_batch_append(raster, &s->vertices, first + t, &s->batch);
            tiny++;
        } else if (other < classes->other && classes->other_list[other] == t) {
            sl_batch_append(raster, &s->vertices, first + t, &s->batch);
            other++;
        } else if (clipped < classes->clipped && classes->clipped_list[clipped] == t) {
            uint16_t corner[3] = {raster->corner[0][first + t], raster->corner[1][first + t], raster->corner[2][first + t]};
            sl_clip_triangle(&p->pass, &s->vertices, corner, &s->batch);
            clipped++;
        }
        for (uint32_t n = base; n < s->batch.count; n++) s->batch.id[n] = raster->triangle[first + t];
        if (s->batch.count + SL_CLIP_TRIANGLES > SL_BATCH) blended += add_batch(p, s, values);
    }
    return blended + add_batch(p, s, values);
}

static void add_tile(void *context, size_t index, unsigned worker) {
    adding *p = context;
    sl_raster_scratch *s = &p->scratch[worker];
    int columns = p->tiles.columns;
    sl_tile_place(&s->tile, &p->pass, p->tiles.first_column + (int)index % columns, p->tiles.first_row + (int)index / columns);
    s->batch.count = 0;
    for (uint32_t n = 0; n < p->visible.count; n++) {
        if (p->visible.x0[n] >= s->tile.x1 || p->visible.x1[n] < s->tile.x0) continue;
        if (p->visible.y0[n] >= s->tile.y1 || p->visible.y1[n] < s->tile.y0) continue;
        p->blended[index] += add_cluster(p, s, p->visible.cluster[n], p->triangle[worker]);
    }
}

/* ---- the whole ---- */

static bool allocate(adding *p, unsigned threads, size_t tiles) {
    p->scratch = sl_allocate(threads, sizeof *p->scratch);
    p->triangle = sl_allocate(threads, sizeof *p->triangle);
    p->blended = sl_allocate(tiles, sizeof *p->blended);
    bool ok = sl_visible_allocate(&p->visible, p->raster) && p->scratch && p->triangle && p->blended;
    size_t bytes = sizeof(sl_add_triangle) + (size_t)p->channels * sizeof(sl_add_channel);
    for (unsigned i = 0; p->triangle && i < threads; i++) ok &= (p->triangle[i] = sl_allocate(1, bytes)) != NULL;
    return ok;
}

static void release(adding *p, unsigned threads) {
    for (unsigned i = 0; p->triangle && i < threads; i++) sl_free(p->triangle[i]);
    sl_free(p->triangle);
    sl_free(p->scratch);
    sl_free(p->blended);
    sl_visible_free(&p->visible);
}

sl_status sl_raster_add(const sl_raster *raster, const sl_view *view, unsigned threads, const float *attributes, int channels,
                        const sl_target *size, float *planes, sl_counters *counters, sl_error *error) {
    sl_status status = sl_viewport_check(view, size, error);
    if (status != SL_OK) return status;
    sl_raster *in_order;
    status = sl_raster_create_in_order(&raster->mesh, &in_order, error);
    if (status != SL_OK) return status;
    adding p = {.raster = in_order, .view = view, .attributes = attributes, .channels = channels, .planes = planes,
                .pass = sl_pass_view_make(view, size->width, size->height)};
    p.tiles = sl_tiles_of(&p.pass);
    size_t tiles = (size_t)p.tiles.columns * (size_t)p.tiles.rows;
    threads = sl_thread_count(threads);
    if (threads > tiles) threads = (unsigned)tiles;
    bool ok = allocate(&p, threads, tiles);
    if (ok) {
        in_order->kernels->cull(in_order, &p.pass, &p.visible); /* in index order */
        sl_parallel_for(threads, tiles, add_tile, &p);
        for (size_t i = 0; i < tiles; i++) sl_count(counters, SL_COUNT_FRAGMENTS_BLENDED, p.blended[i]);
        sl_count(counters, SL_COUNT_RASTER_PASSES, 1);
    }
    release(&p, threads);
    sl_raster_destroy(in_order);
    return ok ? SL_OK : sl_fail_memory(error, "a blending pass");
}
