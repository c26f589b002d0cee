/* One render of the plane at unit distance above the point: (u, v) is direction (u, v, 1), d omega = du dv / (1 + u^2 + v^2)^(3/2). */
#include "cache/hemisphere/gather_internal.h"

#include "base/counters.h"

void sl_gather_see_plane(const sl_gather_view *view, sl_counters *counters) {
    const sl_gather *gather = view->gather;
    sl_gather_scratch *s = view->scratch;
    int n = gather->tables->size;
    float t = gather->half_tangent;
    sl_view pyramid = sl_view_pyramid(&view->frame, view->eye, -t, t, -t, t, n, n, sl_gather_near(gather));
    pyramid.skip_triangle = view->point->triangle;
    sl_target target = {.width = n, .height = n, .id = s->cell_id, .depth = s->cell_depth};
    sl_raster_id_small(gather->raster, &pyramid, &target, s->raster, counters);
    sl_raster_barycentrics(gather->raster, &pyramid, gather->tables->cells, s->pixels, s->cell_id, s->cell_w1, s->cell_w2);
    sl_count(counters, SL_COUNT_BYTES_READ_BACK, 16 * gather->tables->cells); /* radiance and depth of the paper's pixel */
    sl_gather_hits_of_cells(view);
}

/* The depth buffer holds 1/w, the inverse of the depth along the plane's axis. */
void sl_gather_hits_of_cells(const sl_gather_view *view) {
    const sl_gather_tables *t = view->gather->tables;
    const sl_gather_scratch *s = view->scratch;
    const sl_gather_hits *h = &s->hits;
    for (size_t k = 0; k < t->used; k++) {
        uint32_t cell = t->order[k];
        float inverse = s->cell_depth[cell];
        bool hit = s->cell_id[cell] != SL_NO_INDEX && inverse > 0.0f;
        sl_vec3 d = sl_frame_to_world(&view->frame, sl_v3(t->direction_x[cell], t->direction_y[cell], t->direction_z[cell]));
        h->direction_x[k] = d.x;
        h->direction_y[k] = d.y;
        h->direction_z[k] = d.z;
        h->triangle[k] = hit ? s->cell_id[cell] : SL_NO_INDEX;
        h->depth[k] = hit ? 1.0f / inverse : 0.0f;
        h->w1[k] = s->cell_w1[cell];
        h->w2[k] = s->cell_w2[cell];
    }
}
