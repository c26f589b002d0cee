/* Finds the triangle, and the point of it, that each cell of a gather sees. */
#include "cache/hemisphere/gather_internal.h"

#include "base/counters.h"
#include "base/random.h"

/* ---- by the rasterizer ---- */

/* Gathers by the rasterizer. One render of the plane at unit distance above the point: (u, v) is direction
 * (u, v, 1), d omega = du dv / (1 + u^2 + v^2)^(3/2). Or five: the top of a hemicube and the upper halves of
 * its four sides, folded out around it (gather_tables.h has the layout). */
/* The depth buffer holds 1/w, the inverse of the depth along the plane's axis. */
static void hits_of_cells(const sl_gather_view *view) {
    const sl_gather_tables *t = view->gather->tables;
    const sl_gather_scratch *s = view->scratch;
    const sl_gather_hits *h = &s->hits;
    for (size_t k = 0; k < t->used; k++) {
        uint32_t cell = t->order[k];
        float inverse = s->cell_depth[cell];
        bool hit = s->cell_id[cell] != SL_NO_INDEX && inverse > 0.0f;
        sl_vec3 d = sl_frame_to_world(
            &view->frame, sl_v3(t->direction_x[cell], t->direction_y[cell], t->direction_z[cell]));
        sl_put(h->direction_x, h->direction_y, h->direction_z, k, d);
        h->triangle[k] = hit ? s->cell_id[cell] : SL_NO_INDEX;
        h->depth[k] = hit ? 1.0f / inverse : 0.0f;
        h->w1[k] = s->cell_w1[cell];
        h->w2[k] = s->cell_w2[cell];
    }
}

typedef struct drawn {
    uint32_t *id;
    float *depth, *w1, *w2;
} drawn;

static void draw(const sl_gather_view *view, sl_view *pyramid, const drawn *to, sl_counters *counters) {
    const sl_raster *raster = view->gather->raster;
    sl_target target = {
        .width = pyramid->width, .height = pyramid->height, .id = to->id, .depth = to->depth};
    pyramid->skip_triangle = view->point->triangle;
    sl_raster_id_small(raster, pyramid, &target, view->scratch->raster, counters);
    sl_raster_barycentrics(raster, pyramid, (size_t)target.width * (size_t)target.height,
                           view->scratch->pixels, to->id, to->w1, to->w2);
}

void sl_gather_draw_plane(const sl_gather_view *view, float *depth, sl_counters *counters) {
    const sl_gather_scratch *s = view->scratch;
    const sl_gather *gather = view->gather;
    const drawn cells = {s->cell_id, depth, s->cell_w1, s->cell_w2};
    int n = gather->tables->size;
    float t = gather->half_tangent;
    sl_view pyramid = sl_view_pyramid(&view->frame, view->eye, -t, t, -t, t, n, n, sl_gather_near(gather));
    draw(view, &pyramid, &cells, counters);
}

/* Where a hemicube's face has its lower left pixel in the picture, in half sizes. */
typedef struct place {
    int column, row;
} place;

static const place places[5] = {{1, 1}, {3, 1}, {0, 1}, {1, 3}, {1, 0}};

static void draw_face(const sl_gather_view *view, int face, sl_counters *counters) {
    const sl_gather *gather = view->gather;
    const sl_gather_scratch *s = view->scratch;
    const drawn target = {s->target_id, s->target_depth, s->target_w1, s->target_w2};
    int size = gather->tables->size, column = places[face].column * (size / 2);
    sl_view pyramid = sl_view_hemicube_face(&view->frame, view->eye, face, size, sl_gather_near(gather));
    draw(view, &pyramid, &target, counters);
    for (int y = 0; y < pyramid.height; y++) {
        size_t from = (size_t)y * (size_t)pyramid.width;
        size_t to =
            (size_t)(places[face].row * (size / 2) + y) * (size_t)gather->tables->width + (size_t)column;
        for (int x = 0; x < pyramid.width; x++, from++, to++) {
            s->cell_id[to] = s->target_id[from];
            s->cell_depth[to] = s->target_depth[from];
            s->cell_w1[to] = s->target_w1[from];
            s->cell_w2[to] = s->target_w2[from];
        }
    }
}

void sl_gather_see_raster(const sl_gather_view *view, sl_counters *counters) {
    const sl_gather_tables *t = view->gather->tables;
    if (t->kind == SL_GATHER_PLANE) sl_gather_draw_plane(view, view->scratch->cell_depth, counters);
    else for (int i = 0; i < 5; i++) draw_face(view, i, counters);
    /* radiance and depth of the paper's pixel */
    sl_count(counters, SL_COUNT_BYTES_READ_BACK, 16 * t->used);
    hits_of_cells(view);
}

/* ---- by rays ---- */

void sl_gather_trace_packet(const sl_gather_view *view, size_t first, unsigned count, const sl_ray16 *rays,
                            bool coherent, sl_counters *counters) {
    const sl_gather_hits *h = &view->scratch->hits;
    sl_hit16 hits;
    sl_trace(view->gather->tracer, rays, count, coherent, &hits, counters);
    for (unsigned i = 0; i < count; i++) {
        h->triangle[first + i] = hits.triangle[i];
        h->depth[first + i] = hits.triangle[i] != SL_NO_INDEX ? hits.t[i] : 0.0f;
        h->w1[first + i] = hits.w1[i];
        h->w2[first + i] = hits.w2[i];
    }
}

/* Rays through the cells of the concentric map: the cells have equal cosine weights, so every ray counts
 * alike. */
static void trace_packet(const sl_gather_view *view, size_t first, unsigned count, sl_counters *counters) {
    const sl_gather_hits *h = &view->scratch->hits;
    sl_ray16 rays;
    for (unsigned i = 0; i < SL_PACKET; i++) {
        size_t k = first + (i < count ? i : 0);
        sl_ray16_set(&rays, i, view->eye, sl_v3(h->direction_x[k], h->direction_y[k], h->direction_z[k]),
                     0.0f, INFINITY, view->point->triangle);
    }
    sl_gather_trace_packet(view, first, count, &rays, true, counters);
}

static void trace_slots(const sl_gather_view *view, size_t from, size_t to, sl_counters *counters) {
    for (size_t first = from; first < to; first += SL_PACKET)
        trace_packet(view, first, to - first < SL_PACKET ? (unsigned)(to - first) : (unsigned)SL_PACKET,
                     counters);
}

/* Gives the rays of slots from `from` on their directions, and traces them. */
static void see_cells(const sl_gather_view *view, size_t from, sl_ray_cells *cells, sl_counters *counters) {
    const sl_gather *gather = view->gather;
    const sl_gather_hits *h = &view->scratch->hits;
    cells->cell = 2.0f / (float)gather->tables->size;
    cells->frame = view->frame;
    cells->x = h->direction_x + from;
    cells->y = h->direction_y + from;
    cells->z = h->direction_z + from;
    SL_KERNEL_OF(gather->isa, sl_gather_directions)(cells);
    trace_slots(view, from, from + cells->count, counters);
}

void sl_gather_see_more_rays(const sl_gather_view *view, sl_counters *counters) {
    const sl_gather_scratch *s = view->scratch;
    const size_t used = view->gather->tables->used;
    sl_ray_cells cells = {
        .count = s->slots - used, .slot_a = s->more_a, .slot_b = s->more_b, .bits = s->more_bits};
    see_cells(view, used, &cells, counters);
}

void sl_gather_see_rays(const sl_gather_view *view, sl_counters *counters) {
    const sl_gather_tables *t = view->gather->tables;
    sl_ray_cells cells = {.count = t->used,
                          .slot_a = t->slot_a,
                          .slot_b = t->slot_b,
                          .jitter = view->gather->settings.jitter,
                          .key = sl_random_key(view->point->key, 0)};
    see_cells(view, 0, &cells, counters);
}
