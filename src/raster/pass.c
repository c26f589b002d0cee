/* One render of one tile: cluster by cluster through the pipeline of pipeline.h; and what is decided before:
 * whether there is anything to draw, and in which order. */
#include <stdatomic.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "raster/pipeline.h"

/* ---- buffers ---- */

static bool allocate_visible(sl_visible *v, const sl_raster *raster) {
    size_t count = raster->cluster_count + SL_LANES;
    *v = (sl_visible){.cluster = sl_allocate(count, 4),
                      .x0 = sl_allocate(count, 4),
                      .y0 = sl_allocate(count, 4),
                      .x1 = sl_allocate(count, 4),
                      .y1 = sl_allocate(count, 4),
                      .nearest = sl_allocate(count, 4),
                      .distance = sl_allocate(count, 4),
                      .order = sl_allocate(count, 4)};
    return v->cluster && v->x0 && v->y0 && v->x1 && v->y1 && v->nearest && v->distance && v->order;
}

sl_status sl_raster_scratch_create(const sl_raster *raster, int max_width, int max_height,
                                   sl_raster_scratch **scratch, sl_error *error) {
    *scratch = NULL;
    if (max_width < 0 || max_height < 0 || max_width > SL_RASTER_MAX_SIZE ||
        max_height > SL_RASTER_MAX_SIZE) {
        return sl_fail(error, SL_ERROR_USAGE, "a raster target of %d x %d pixels: at most %d each way",
                       max_width, max_height, (int)SL_RASTER_MAX_SIZE);
    }
    sl_raster_scratch *s = sl_allocate(1, sizeof *s);
    bool ok = s != NULL;
    if (ok) {
        s->fate = sl_allocate(raster->cluster_count, sizeof *s->fate);
        s->tile.id = sl_allocate(SL_TILE_PIXELS, sizeof *s->tile.id);
        s->tile.depth = sl_allocate(SL_TILE_PIXELS, sizeof *s->tile.depth);
        ok = allocate_visible(&s->visible, raster) && s->fate && s->tile.id && s->tile.depth;
    }
    if (!ok) {
        sl_raster_scratch_destroy(s);
        return sl_fail_memory(error, "a render's scratch");
    }
    *scratch = s;
    return SL_OK;
}

void sl_raster_scratch_destroy(sl_raster_scratch *s) {
    if (!s) return;
    const sl_visible *v = &s->visible;
    SL_FREE_ALL(v->cluster, v->x0, v->y0, v->x1, v->y1, v->nearest, v->distance, v->order);
    SL_FREE_ALL(s->tile.id, s->tile.depth, (void *)s->fate, s);
}

/* Kept for later passes: a pass over a large target would otherwise begin by having a megabyte faulted in
 * page by page and cleared. Passes run at the same time, so each takes what it needs for itself alone and
 * gives it back afterwards. */
enum { SPARES = 8 };

struct sl_spares {
    _Atomic(sl_raster_scratch *) kept[SPARES];
};

struct sl_spares *sl_spares_create(void) { return sl_allocate(1, sizeof(struct sl_spares)); }

void sl_spares_destroy(struct sl_spares *spares) {
    for (int i = 0; spares && i < SPARES; i++) sl_raster_scratch_destroy(atomic_load(&spares->kept[i]));
    sl_free(spares);
}

sl_raster_scratch *sl_spare_take(const sl_raster *raster) {
    sl_raster_scratch *scratch = NULL;
    for (int i = 0; i < SPARES && !scratch; i++) scratch = atomic_exchange(&raster->spares->kept[i], NULL);
    if (!scratch && sl_raster_scratch_create(raster, 0, 0, &scratch, NULL) != SL_OK) return NULL;
    return scratch;
}

void sl_spare_give(const sl_raster *raster, sl_raster_scratch *scratch) {
    for (int i = 0; i < SPARES && scratch; i++) {
        sl_raster_scratch *none = NULL;
        if (atomic_compare_exchange_strong(&raster->spares->kept[i], &none, scratch)) return;
    }
    sl_raster_scratch_destroy(scratch);
}

/* ---- is there anything to draw? ---- */

/* The bounds reach across the plane, or lie before it; with room for rounding, as culling has it. NaN counts
 * as inside. */
static bool reaches(const sl_raster *r, const sl_pass_view *view, const float plane[4], size_t c) {
    float x = plane[0] * (r->centre_x[c] - view->origin[0]),
          y = plane[1] * (r->centre_y[c] - view->origin[1]);
    float z = plane[2] * (r->centre_z[c] - view->origin[2]);
    float reach =
        fabsf(plane[0]) * r->half_x[c] + fabsf(plane[1]) * r->half_y[c] + fabsf(plane[2]) * r->half_z[c];
    float slack = 1e-5f * (fabsf(x) + fabsf(y) + fabsf(z) + fabsf(plane[3]) + reach) + 1e-37f;
    return !(x + y + z + plane[3] < -(reach + slack));
}

bool sl_raster_meets(const sl_raster *raster, const sl_view *view) {
    const sl_pass_view pass = sl_pass_view_make(view, view->x + view->width, view->y + view->height);
    for (size_t c = 0; c < raster->cluster_count; c++) {
        int k = 0;
        while (k < pass.planes && reaches(raster, &pass, pass.plane[k], c)) k++;
        if (k == pass.planes) return true;
    }
    return false;
}

/* ---- front to back ---- */

/* The visible clusters by their distance, roughly, since the picture does not depend on it: one counting sort
 * over the logarithm of the distance, 16 steps an octave, whose bits a float's bits are. */
enum { BUCKETS = 256, STEP_BITS = 19 };

static uint32_t step_of(float distance) { /* >= 0 and finite */
    uint32_t bits;
    memcpy(&bits, &distance, sizeof bits);
    return bits >> STEP_BITS;
}

void sl_visible_sort(sl_visible *v) {
    uint32_t start[BUCKETS + 1] = {0}, farthest = BUCKETS - 1;
    for (uint32_t n = 0; n < v->count; n++) {
        uint32_t step = step_of(v->distance[n]);
        farthest = step > farthest ? step : farthest;
    }
    const uint32_t base = farthest - (BUCKETS - 1);
    for (uint32_t n = 0; n < v->count; n++) {
        uint32_t step = step_of(v->distance[n]);
        start[(step > base ? step - base : 0) + 1]++;
    }
    for (int b = 0; b < BUCKETS; b++) start[b + 1] += start[b];
    for (uint32_t n = 0; n < v->count; n++) {
        uint32_t step = step_of(v->distance[n]);
        v->order[start[step > base ? step - base : 0]++] = n;
    }
}

/* ---- tiles ---- */

sl_tiles sl_tiles_of(const sl_pass_view *view) {
    int column = view->x0 / SL_TILE, row = view->y0 / SL_TILE;
    return (sl_tiles){column, row, (view->x1 - 1) / SL_TILE + 1 - column, (view->y1 - 1) / SL_TILE + 1 - row};
}

void sl_tile_place(sl_tile *tile, const sl_pass_view *view, int column, int row) {
    tile->left = column * SL_TILE;
    tile->low = row * SL_TILE;
    tile->x0 = view->x0 > tile->left ? view->x0 : tile->left;
    tile->y0 = view->y0 > tile->low ? view->y0 : tile->low;
    tile->x1 = view->x1 < tile->left + SL_TILE ? view->x1 : tile->left + SL_TILE;
    tile->y1 = view->y1 < tile->low + SL_TILE ? view->y1 : tile->low + SL_TILE;
    tile->blocks_x = (tile->x1 - tile->left + SL_BLOCK - 1) / SL_BLOCK;
    tile->blocks_y = (tile->y1 - tile->low + SL_BLOCK - 1) / SL_BLOCK;
}

/* ---- drawing ---- */

typedef struct {
    const sl_raster *raster;
    const sl_view *view;
    const sl_pass_view *pass;
    sl_raster_scratch *scratch;
} render;

static void append_triangles(const render *r, uint32_t first, const uint8_t *list, uint32_t count) {
    const sl_raster *raster = r->raster;
    sl_triangle_batch *batch = &r->scratch->batch;
    for (uint32_t n = 0; n < count; n++) {
        batch->id[batch->count] = raster->triangle[first + list[n]];
        batch->masked[batch->count] = raster->masked && raster->triangle_masked[first + list[n]];
        sl_batch_append(raster, &r->scratch->vertices, first + list[n], batch);
    }
}

/* Draws the batch; its first `tiny` triangles are the tiny ones. */
static void flush(const render *r, uint32_t tiny) {
    sl_raster_scratch *s = r->scratch;
    const sl_isa isa = r->raster->isa;
    if (!s->batch.count) return;
    SL_KERNEL_OF(isa, sl_raster_set_up_depth)(r->pass, &s->batch);
    if (tiny) SL_KERNEL_OF(isa, sl_raster_rasterize_tiny)(r->pass, &s->tile, &s->batch, &s->tiny);
    if (s->batch.count > tiny) {
        SL_KERNEL_OF(isa, sl_raster_set_up_edges)(&s->tile, &s->batch, tiny);
        SL_KERNEL_OF(isa, sl_raster_rasterize)(r->pass, &s->tile, &s->batch, tiny);
    }
    for (uint32_t t = tiny; r->raster->masked && t < s->batch.count; t++) {
        if (s->batch.masked[t]) sl_rasterize_masked(r->raster, r->view, r->pass, &s->tile, &s->batch, t);
    }
    s->batch.count = 0;
}

/* Draws the batch first if there is no room for so many triangles more. */
static void make_room(const render *r, uint32_t triangles, uint32_t *tiny) {
    if (r->scratch->batch.count + triangles <= SL_BATCH) return;
    flush(r, *tiny);
    *tiny = 0;
}

static void clip(const render *r, uint32_t triangle, uint32_t *tiny) {
    const sl_raster *raster = r->raster;
    sl_triangle_batch *batch = &r->scratch->batch;
    make_room(r, SL_CLIP_TRIANGLES, tiny);
    uint16_t corner[3] = {raster->corner[0][triangle], raster->corner[1][triangle],
                          raster->corner[2][triangle]};
    uint32_t base = batch->count, made = sl_clip_triangle(r->pass, &r->scratch->vertices, corner, batch);
    for (uint32_t n = 0; n < made; n++) {
        batch->id[base + n] = raster->triangle[triangle];
        batch->masked[base + n] = raster->triangle_masked[triangle];
    }
}

static uint32_t draw_cluster(const render *r, uint32_t cluster) {
    const sl_raster *raster = r->raster;
    sl_raster_scratch *s = r->scratch;
    uint32_t first = raster->first_triangle[cluster], tiny = 0;
    SL_KERNEL_OF(raster->isa, sl_raster_transform)(raster, cluster, r->pass, &s->vertices);
    SL_KERNEL_OF(raster->isa, sl_raster_classify)(raster, cluster, r->pass, &s->tile, &s->vertices,
                                                  &s->classes);
    if (s->classes.tiny) {
        SL_KERNEL_OF(raster->isa, sl_raster_cover_tiny)(raster, cluster, &s->tile, &s->vertices, &s->classes,
                                                        &s->tiny);
        tiny = s->tiny.count;
        append_triangles(r, first, s->tiny.triangle, tiny);
    }
    append_triangles(r, first, s->classes.other_list, s->classes.other);
    for (uint32_t n = 0; n < s->classes.clipped; n++) clip(r, first + s->classes.clipped_list[n], &tiny);
    flush(r, tiny);
    return sl_fate_of(&s->classes);
}

void sl_tile_draw(const sl_raster *raster, const sl_view *view, const sl_pass_view *pass,
                  const sl_visible *visible, sl_raster_scratch *scratch, sl_cluster_fate *fate) {
    const sl_isa isa = raster->isa;
    const sl_tile *tile = &scratch->tile;
    render r = {raster, view, pass, scratch};
    SL_KERNEL_OF(isa, sl_raster_clear)(pass, tile);
    scratch->batch.count = 0;
    for (uint32_t i = 0; i < visible->count; i++) {
        uint32_t n = visible->order[i];
        sl_rectangle seen = {sl_larger(visible->x0[n], tile->x0), sl_larger(visible->y0[n], tile->y0),
                             sl_smaller(visible->x1[n], tile->x1 - 1),
                             sl_smaller(visible->y1[n], tile->y1 - 1)};
        if (seen.x0 > seen.x1 || seen.y0 > seen.y1) continue;
        if (SL_KERNEL_OF(isa, sl_raster_occluded)(pass, tile, seen, visible->nearest[n])) continue;
        fate[n] = draw_cluster(&r, visible->cluster[n]);
    }
}

void sl_pass_count(const sl_raster *raster, const sl_visible *visible, const sl_cluster_fate *fate,
                   sl_counters *counters) {
    uint64_t drawn = 0, submitted = 0, culled = 0, dropped = 0, clipped = 0;
    for (uint32_t n = 0; n < visible->count; n++) {
        uint32_t f = fate[n];
        if (!f) continue;
        drawn++;
        submitted += raster->triangles[visible->cluster[n]];
        culled += f >> 16 & 255;
        dropped += f >> 8 & 255;
        clipped += f & 255;
    }
    sl_count(counters, SL_COUNT_RASTER_PASSES, 1);
    sl_count(counters, SL_COUNT_CLUSTERS_TESTED, raster->cluster_count);
    sl_count(counters, SL_COUNT_CLUSTERS_CULLED, raster->cluster_count - drawn);
    sl_count(counters, SL_COUNT_TRIANGLES_SUBMITTED, submitted);
    sl_count(counters, SL_COUNT_TRIANGLES_CULLED, culled);
    sl_count(counters, SL_COUNT_TRIANGLES_DROPPED, dropped);
    sl_count(counters, SL_COUNT_TRIANGLES_CLIPPED, clipped);
    sl_count(counters, SL_COUNT_TRIANGLES_RASTERIZED, submitted - culled - dropped);
}

void sl_raster_id_small(const sl_raster *raster, const sl_view *view, const sl_target *target,
                        sl_raster_scratch *scratch, sl_counters *counters) {
    sl_pass_view pass = sl_pass_view_make(view, target->width, target->height);
    const sl_tiles tiles = sl_tiles_of(&pass);
    if (raster->observer) raster->observer->draw(raster->observer->context, raster, view, true);
    SL_KERNEL_OF(raster->isa, sl_raster_cull)(raster, &pass, &scratch->visible);
    sl_visible_sort(&scratch->visible);
    for (uint32_t n = 0; n < scratch->visible.count; n++) scratch->fate[n] = 0;
    for (int t = 0; t < tiles.columns * tiles.rows; t++) {
        sl_tile_place(&scratch->tile, &pass, tiles.first_column + t % tiles.columns,
                      tiles.first_row + t / tiles.columns);
        sl_tile_draw(raster, view, &pass, &scratch->visible, scratch, scratch->fate);
        SL_KERNEL_OF(raster->isa, sl_raster_copy_out)(&pass, &scratch->tile, target->id, target->depth);
    }
    sl_pass_count(raster, &scratch->visible, scratch->fate, counters);
}
