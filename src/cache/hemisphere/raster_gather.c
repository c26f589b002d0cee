/* Gathers by the rasterizer. One render of the plane at unit distance above the point: (u, v) is direction
 * (u, v, 1), d omega = du dv / (1 + u^2 + v^2)^(3/2). Or five: the top of a hemicube and the upper halves of
 * its four sides, folded out around it (gather_tables.h has the layout). */
#include "cache/hemisphere/gather_internal.h"

#include "base/counters.h"

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
        h->direction_x[k] = d.x;
        h->direction_y[k] = d.y;
        h->direction_z[k] = d.z;
        h->triangle[k] = hit ? s->cell_id[cell] : SL_NO_INDEX;
        h->depth[k] = hit ? 1.0f / inverse : 0.0f;
        h->w1[k] = s->cell_w1[cell];
        h->w2[k] = s->cell_w2[cell];
    }
}

static sl_view render_plane(const sl_gather_view *view, float *depth, sl_counters *counters) {
    const sl_gather *gather = view->gather;
    int n = gather->tables->size;
    float t = gather->half_tangent;
    sl_view pyramid = sl_view_pyramid(&view->frame, view->eye, -t, t, -t, t, n, n, sl_gather_near(gather));
    pyramid.skip_triangle = view->point->triangle;
    sl_target target = {.width = n, .height = n, .id = view->scratch->cell_id, .depth = depth};
    sl_raster_id_small(gather->raster, &pyramid, &target, view->scratch->raster, counters);
    return pyramid;
}

void sl_gather_see_triangles(const sl_gather_view *view, sl_counters *counters) {
    render_plane(view, NULL, counters);
}

void sl_gather_see_plane(const sl_gather_view *view, sl_counters *counters) {
    const sl_gather *gather = view->gather;
    const sl_gather_scratch *s = view->scratch;
    sl_view pyramid = render_plane(view, s->cell_depth, counters);
    sl_raster_barycentrics(gather->raster, &pyramid, gather->tables->cells, s->pixels, s->cell_id, s->cell_w1,
                           s->cell_w2);
    /* radiance and depth of the paper's pixel */
    sl_count(counters, SL_COUNT_BYTES_READ_BACK, 16 * gather->tables->cells);
    hits_of_cells(view);
}

/* ---- the hemicube ---- */

/* Where a face's lower left pixel lies in the picture, in half sizes. */
typedef struct place {
    int column, row;
} place;

static const place places[5] = {{1, 1}, {3, 1}, {0, 1}, {1, 3}, {1, 0}};

static void render_face(const sl_gather_view *view, int face, sl_counters *counters) {
    const sl_gather *gather = view->gather;
    sl_gather_scratch *s = view->scratch;
    const place *f = &places[face];
    int half = gather->tables->size / 2;
    sl_view pyramid =
        sl_view_hemicube_face(&view->frame, view->eye, face, gather->tables->size, sl_gather_near(gather));
    int width = pyramid.width, height = pyramid.height;
    pyramid.skip_triangle = view->point->triangle;
    sl_target target = {.width = width, .height = height, .id = s->target_id, .depth = s->target_depth};
    sl_raster_id_small(gather->raster, &pyramid, &target, s->raster, counters);
    size_t count = (size_t)width * (size_t)height;
    sl_raster_barycentrics(gather->raster, &pyramid, count, s->pixels, s->target_id, s->target_w1,
                           s->target_w2);
    sl_count(counters, SL_COUNT_BYTES_READ_BACK, 16 * count);
    for (int y = 0; y < height; y++) {
        size_t from = (size_t)y * (size_t)width;
        size_t to = (size_t)(f->row * half + y) * (size_t)gather->tables->width + (size_t)(f->column * half);
        for (int x = 0; x < width; x++, from++, to++) {
            s->cell_id[to] = s->target_id[from];
            s->cell_depth[to] = s->target_depth[from];
            s->cell_w1[to] = s->target_w1[from];
            s->cell_w2[to] = s->target_w2[from];
        }
    }
}

void sl_gather_see_hemicube(const sl_gather_view *view, sl_counters *counters) {
    for (int i = 0; i < 5; i++) render_face(view, i, counters);
    hits_of_cells(view);
}
