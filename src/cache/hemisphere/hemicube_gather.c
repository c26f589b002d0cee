/* Five renders: the top and the upper halves of four sides, folded out around it (gather_tables.h has the layout). */
#include "cache/hemisphere/gather_internal.h"

#include "base/counters.h"

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
    sl_view pyramid = sl_view_hemicube_face(&view->frame, view->eye, face, gather->tables->size, sl_gather_near(gather));
    int width = pyramid.width, height = pyramid.height;
    pyramid.skip_triangle = view->point->triangle;
    sl_target target = {.width = width, .height = height, .id = s->target_id, .depth = s->target_depth};
    sl_raster_id_small(gather->raster, &pyramid, &target, s->raster, counters);
    size_t count = (size_t)width * (size_t)height;
    sl_raster_barycentrics(gather->raster, &pyramid, count, s->pixels, s->target_id, s->target_w1, s->target_w2);
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
    sl_gather_hits_of_cells(view);
}
