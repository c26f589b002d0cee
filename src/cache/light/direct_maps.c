/* Direct light of pixels by shadow maps, a block of pixels side by side at a time. */
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/light/direct_internal.h"
#include "cache/frame/picture_value.h"

typedef struct {
    const sl_direct *direct;
    const sl_gbuffer *gbuffer;
    int row0;
    float *r, *g, *b;
    sl_counters *counters; /* one a row */
} rows_context;

/* Glossy lobes of a block. */
typedef struct {
    const rows_context *rows;
    size_t first, count;
} lobes;

static void add_lobes(void *context, const sl_arrivals *arrivals, const float *lit, sl_rgb colour) {
    const lobes *l = context;
    const rows_context *c = l->rows;
    for (size_t i = 0; i < l->count; i++) {
        float share = arrivals->weight[i] * lit[i];
        size_t pixel = l->first + i;
        if (!(share > 0.0f) || !sl_pixel_is_glossy(c->gbuffer, c->direct->scene, pixel)) continue;
        sl_receiver at = sl_receiver_at(c->direct, c->gbuffer, pixel);
        sl_rgb f = sl_phong(&at, sl_v3(arrivals->x[i], arrivals->y[i], arrivals->z[i]));
        c->r[pixel] = sl_picture_value(c->r[pixel] + sl_picture_value(f.r * colour.r * share));
        c->g[pixel] = sl_picture_value(c->g[pixel] + sl_picture_value(f.g * colour.g * share));
        c->b[pixel] = sl_picture_value(c->b[pixel] + sl_picture_value(f.b * colour.b * share));
    }
}

static void light_block(const rows_context *c, size_t first, size_t count, sl_counters *counters) {
    const sl_direct *direct = c->direct;
    const sl_gbuffer *g = c->gbuffer;
    float r[SL_LIGHT_BLOCK] = {0.0f}, gr[SL_LIGHT_BLOCK] = {0.0f}, b[SL_LIGHT_BLOCK] = {0.0f};
    sl_light_points points = {count, g->position_x + first, g->position_y + first, g->position_z + first,
                              g->geometric_x + first, g->geometric_y + first, g->geometric_z + first,
                              g->normal_x + first, g->normal_y + first, g->normal_z + first};
    bool glossy = false;
    for (size_t i = first; i < first + count; i++) glossy |= sl_pixel_is_glossy(g, direct->scene, i);
    sl_shadow_maps_irradiance(direct->settings.maps, &points, SL_MAPPED_LIGHTS, r, gr, b, counters);
    for (size_t i = 0; i < count; i++) {
        c->r[first + i] = sl_picture_value(g->diffuse_r[first + i] * (float)(1.0 / SL_PI) * r[i]);
        c->g[first + i] = sl_picture_value(g->diffuse_g[first + i] * (float)(1.0 / SL_PI) * gr[i]);
        c->b[first + i] = sl_picture_value(g->diffuse_b[first + i] * (float)(1.0 / SL_PI) * b[i]);
    }
    lobes context = {c, first, count};
    if (glossy)
        sl_shadow_maps_each(direct->settings.maps, &points, SL_MAPPED_LIGHTS, add_lobes, &context, counters);
}

static void light_row(void *context, size_t index, unsigned worker) {
    (void)worker;
    const rows_context *c = context;
    size_t width = (size_t)c->gbuffer->width, first = ((size_t)c->row0 + index) * width;
    for (size_t x = 0; x < width; x += SL_LIGHT_BLOCK) {
        size_t count = width - x < SL_LIGHT_BLOCK ? width - x : SL_LIGHT_BLOCK;
        light_block(c, first + x, count, &c->counters[index]);
    }
    sl_count(&c->counters[index], SL_COUNT_FRAGMENTS_SHADED, width);
}

sl_status sl_direct_by_maps(const sl_direct *direct, const sl_gbuffer *gbuffer, int row0, int row1,
                            float *const radiance[3], sl_counters *counters, sl_error *error) {
    size_t rows = (size_t)(row1 - row0);
    sl_counters *costs = sl_allocate(rows, sizeof *costs);
    if (!costs) return sl_fail_memory(error, "direct light");
    rows_context context = {direct, gbuffer, row0, radiance[0], radiance[1], radiance[2], costs};
    sl_parallel_for(direct->settings.threads, rows, light_row, &context);
    for (size_t i = 0; i < rows; i++) sl_counters_add(counters, &costs[i]);
    sl_free(costs);
    return SL_OK;
}
