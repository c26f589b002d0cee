/* Records onto the screen: Algorithm 1's weights alone, for coverage (step 4 of Algorithm 2), or the whole
 * program (step 5). Both go tile by tile through the same hardware, in record order. */
#include <math.h>
#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/splatting/splatting.h"

typedef struct {
    const sl_record_pass *pass;
    const sl_record *records;
    const float *coefficients;     /* of the first record; NULL: only irradiance is splatted */
    const sl_splat_buffer *buffer; /* planes that are wanted; NULL ones are not */
    bool light;                    /* or weights alone */
    sl_isa isa;
} splat_context;

/* ---- a tile comes and goes ---- */

enum { SUMS = 8 };

static void planes_of(const splat_context *c, sl_tile_planes *tile, float *screen[SUMS],
                      float *in_tile[SUMS]) {
    const sl_splat_buffer *b = c->buffer;
    bool glossy = c->coefficients != NULL;
    float *const from[SUMS] = {b->weight, b->r, b->g, b->b, b->count, glossy ? b->glossy[0] : NULL,
                               glossy ? b->glossy[1] : NULL, glossy ? b->glossy[2] : NULL};
    float *const to[SUMS] = {tile->weight, tile->r,         tile->g,         tile->b,
                             tile->count,  tile->glossy[0], tile->glossy[1], tile->glossy[2]};
    memcpy(screen, from, sizeof from);
    memcpy(in_tile, to, sizeof to);
}

static void copy_sums(const splat_context *c, const sl_splat_tile *tile, bool back) {
    float *screen[SUMS], *in_tile[SUMS];
    planes_of(c, tile->memory, screen, in_tile);
    const sl_splat_rect r = tile->region;
    size_t bytes = (size_t)(r.x1 - r.x0) * sizeof(float);
    for (int k = 0; k < SUMS; k++) {
        for (int y = r.y0; screen[k] && y < r.y1; y++) {
            float *there = screen[k] + (size_t)y * (size_t)c->pass->receivers.width + (size_t)r.x0;
            float *here = in_tile[k] + (y - tile->y) * SL_SPLAT_TILE + (r.x0 - tile->x);
            if (back) memcpy(there, here, bytes);
            else memcpy(here, there, bytes);
        }
    }
}

/* Tells whether a tile has anything to draw: sub-frames of a film show few pixels. */
static bool receives_any(const sl_splat_tile *tile) {
    return ((const sl_tile_planes *)tile->memory)->any_receives;
}

static void begin_tile(void *context, const sl_splat_tile *tile) {
    const splat_context *c = context;
    SL_KERNEL_OF(c->isa, sl_splat_fetch)(&c->pass->receivers, tile->x, tile->y, tile->region, tile->memory);
    if (receives_any(tile)) copy_sums(c, tile, false);
}

static void end_tile(void *context, const sl_splat_tile *tile) {
    if (receives_any(tile)) copy_sums(context, tile, true);
}

/* ---- one record in one tile ---- */

/* Steps 4 to 6 for the glossy part, with the weights of the irradiance. */
static void add_glossy(const splat_context *c, const sl_splat_tile *tile, size_t index, sl_splat_rect r,
                       const float *weights) {
    const sl_record_pass *pass = c->pass;
    const sl_record *record = &c->records[index];
    const sl_glossy_record glossy = {record->position, sl_frame_from_normal(record->normal),
                                     c->coefficients + index * pass->coefficient_count};
    sl_tile_planes *planes = tile->memory;
    for (int y = r.y0; y < r.y1; y++) {
        for (int x = r.x0; x < r.x1; x++) {
            const int i = y * SL_SPLAT_TILE + x;
            float radiance[3];
            if (!(weights[i] > 0.0f)) continue;
            SL_KERNEL_OF(c->isa, sl_glossy_radiance)(&pass->glossy, &glossy,
                      (size_t)(tile->y + y) * (size_t)pass->receivers.width + (size_t)(tile->x + x),
                      radiance);
            for (int k = 0; k < 3; k++) planes->glossy[k][i] += weights[i] * radiance[k];
        }
    }
}

static uint64_t shade(void *context, const sl_splat_tile *tile, size_t index, sl_splat_rect rect) {
    const splat_context *c = context;
    const sl_splat_rect r = {rect.x0 - tile->x, rect.y0 - tile->y, rect.x1 - tile->x, rect.y1 - tile->y};
    float weights[SL_SPLAT_TILE_PIXELS];
    if (!receives_any(tile)) return 0;
    uint64_t blended = SL_KERNEL_OF(c->isa, sl_splat_record)(&c->records[index], &c->pass->weights, r,
                                                             c->light, tile->memory,
                                                             c->coefficients ? weights : NULL);
    if (blended && c->coefficients) add_glossy(c, tile, index, r, weights);
    return blended;
}

/* ---- what is seen in mirrors ---- */

static bool is_empty(sl_splat_rect r) { return r.x0 >= r.x1 || r.y0 >= r.y1; }

static sl_splat_rect rect_union(sl_splat_rect a, sl_splat_rect b) {
    if (is_empty(a)) return b;
    if (is_empty(b)) return a;
    return (sl_splat_rect){sl_lesser(a.x0, b.x0), sl_lesser(a.y0, b.y0), sl_greater(a.x1, b.x1),
                           sl_greater(a.y1, b.y1)};
}

sl_mirror_pixels sl_mirror_pixels_find(const sl_gbuffer *g, const sl_reflections *reflections) {
    sl_mirror_pixels m = {.box = sl_box_empty()};
    for (size_t k = 0; reflections && k < reflections->count; k++) {
        const size_t i = reflections->pixel[k];
        const int x = (int)(i % (size_t)g->width), y = (int)(i / (size_t)g->width);
        if (g->material[i] == SL_NO_INDEX) continue;
        m.rect = rect_union(m.rect, (sl_splat_rect){x, y, x + 1, y + 1});
        sl_box_add(&m.box, sl_gbuffer_position(g, i));
    }
    return m;
}

sl_splat_rect sl_mirror_bounds(const sl_mirror_pixels *m, sl_vec3 centre, float reach, sl_splat_rect seen) {
    const sl_vec3 d = sl_outside_box(m->box, centre);
    return sl_dot(d, d) <= reach * reach ? rect_union(seen, m->rect) : seen;
}

/* ---- all records ---- */

enum { BOUNDS_AT_ONCE = 256 };

/* Never less than the kernel's own test accepts. */
static float reach_of(const sl_record_pass *pass, const sl_record *record) {
    return (float)pass->radii.accuracy * record->radius * 1.0001f;
}

typedef struct {
    const splat_context *splats;
    size_t count;
    sl_splat_rect *rects;
} bounds_context;

static void bound_some(void *context, size_t index, unsigned worker) {
    (void)worker;
    const bounds_context *b = context;
    const sl_record_pass *pass = b->splats->pass;
    size_t first = index * BOUNDS_AT_ONCE,
           end = b->count - first < BOUNDS_AT_ONCE ? b->count : first + BOUNDS_AT_ONCE;
    for (size_t i = first; i < end; i++) {
        const sl_record *record = &b->splats->records[i];
        b->rects[i] = sl_sphere_bounds(pass->camera, pass->receivers.width, pass->receivers.height,
                                       pass->near_distance, record->position, reach_of(pass, record));
        if (pass->mirrors)
            b->rects[i] =
                sl_mirror_bounds(pass->mirrors, record->position, reach_of(pass, record), b->rects[i]);
    }
}

static sl_status draw(splat_context *context, size_t count, sl_counters *counters, sl_error *error) {
    const sl_record_pass *pass = context->pass;
    const sl_splat_program program = {sizeof(sl_tile_planes), begin_tile, shade, end_tile};
    bounds_context bounds = {context, count, sl_allocate(count, sizeof *bounds.rects)};
    if (!bounds.rects) return sl_fail_memory(error, "splat rectangles");
    sl_parallel_for(sl_thread_count(pass->threads), (count + BOUNDS_AT_ONCE - 1) / BOUNDS_AT_ONCE, bound_some,
                    &bounds);
    sl_status status = sl_raster_splats(pass->receivers.width, pass->receivers.height, count, bounds.rects,
                                        &program, context, pass->threads, counters, error);
    sl_free(bounds.rects);
    return status;
}

sl_status sl_cover(const sl_record_pass *pass, const sl_record *records, size_t count, sl_error *error) {
    if (count == 0) return SL_OK;
    const sl_splat_buffer weights_alone = {.weight = pass->coverage};
    splat_context context = {pass, records, NULL, &weights_alone, false, pass->isa};
    /* the paper sums coverage on the CPU: these are no splats of the hardware */
    sl_counters unbilled = {{0}};
    return draw(&context, count, &unbilled, error);
}

sl_status sl_splat_records(const sl_record_pass *pass, const sl_record_list *list, size_t first,
                           const sl_splat_buffer *buffer, sl_counters *counters, sl_error *error) {
    if (first >= list->count) return SL_OK;
    const float *coefficients =
        list->coefficients ? list->coefficients + first * pass->coefficient_count : NULL;
    splat_context context = {pass, list->records + first, coefficients, buffer, true, pass->isa};
    return draw(&context, list->count - first, counters, error);
}
