/* Rays through the cells of the concentric map: the cells have equal cosine weights, so every ray counts
 * alike. */
#include "cache/hemisphere/gather_internal.h"

#include "base/random.h"

static void trace_packet(const sl_gather_view *view, size_t first, unsigned count, sl_counters *counters) {
    const sl_gather_hits *h = &view->scratch->hits;
    sl_ray16 rays;
    sl_hit16 hits;
    for (unsigned i = 0; i < SL_PACKET; i++) {
        size_t k = first + (i < count ? i : 0);
        sl_ray16_set(&rays, i, view->eye, sl_v3(h->direction_x[k], h->direction_y[k], h->direction_z[k]),
                     0.0f, INFINITY, view->point->triangle);
    }
    sl_trace(view->gather->tracer, &rays, count, true, &hits, counters);
    for (unsigned i = 0; i < count; i++) {
        h->triangle[first + i] = hits.triangle[i];
        h->depth[first + i] = hits.triangle[i] != SL_NO_INDEX ? hits.t[i] : 0.0f;
        h->w1[first + i] = hits.w1[i];
        h->w2[first + i] = hits.w2[i];
    }
}

static void trace_slots(const sl_gather_view *view, size_t from, size_t to, sl_counters *counters) {
    for (size_t first = from; first < to; first += SL_PACKET) {
        trace_packet(view, first, to - first < SL_PACKET ? (unsigned)(to - first) : (unsigned)SL_PACKET,
                     counters);
    }
}

void sl_gather_see_more_rays(const sl_gather_view *view, sl_counters *counters) {
    const sl_gather *gather = view->gather;
    const sl_gather_tables *t = gather->tables;
    const sl_gather_scratch *s = view->scratch;
    const sl_gather_hits *h = &s->hits;
    sl_ray_cells cells = {.count = s->slots - t->used,
                          .slot_a = s->more_a,
                          .slot_b = s->more_b,
                          .cell = 2.0f / (float)t->size,
                          .bits = s->more_bits,
                          .frame = view->frame,
                          .x = h->direction_x + t->used,
                          .y = h->direction_y + t->used,
                          .z = h->direction_z + t->used};
    SL_KERNEL_OF(gather->isa, sl_gather_directions)(&cells);
    trace_slots(view, t->used, s->slots, counters);
}

void sl_gather_see_rays(const sl_gather_view *view, sl_counters *counters) {
    const sl_gather *gather = view->gather;
    const sl_gather_tables *t = gather->tables;
    const sl_gather_hits *h = &view->scratch->hits;
    sl_ray_cells cells = {.count = t->used,
                          .slot_a = t->slot_a,
                          .slot_b = t->slot_b,
                          .cell = 2.0f / (float)t->size,
                          .jitter = gather->settings.jitter,
                          .key = sl_random_key(view->point->key, 0),
                          .frame = view->frame,
                          .x = h->direction_x,
                          .y = h->direction_y,
                          .z = h->direction_z};
    SL_KERNEL_OF(gather->isa, sl_gather_directions)(&cells);
    trace_slots(view, 0, t->used, counters);
}
