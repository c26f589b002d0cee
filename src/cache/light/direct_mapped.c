/* Direct light of pixels by shadow maps. Blocks are tiles, not pieces of rows: what all points of a block
 * agree on is done early (shadow_maps.c). */
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/frame/picture_value.h"
#include "cache/light/direct_internal.h"

#include <string.h>

enum {
    PART_WIDTH = SL_MAPPED_COLUMNS,
    PART_HEIGHT = SL_MAPPED_PART / PART_WIDTH,
    TILE_HEIGHT = 2 * PART_HEIGHT
};

typedef struct mapped_pass {
    const sl_direct *direct;
    const sl_gbuffer *gbuffer;
    int row, end;
    float *const *out;
    sl_counters *counters; /* a row of tiles' own */
} mapped_pass;

typedef struct mapped_block {
    const mapped_pass *pass;
    sl_counters *counters;
    bool whole; /* all pixels are drawn, so that points are neighbours */
    bool tiles; /* they are all those of whole tiles, row by row */
    sl_lit_block points;
    float irradiance[3][SL_LIGHT_BLOCK], glossy[3][SL_LIGHT_BLOCK];
} mapped_block;

static void add_lobes(void *context, const sl_arrivals *a, const float *lit, sl_rgb colour) {
    mapped_block *b = context;
    float *glossy[3] = {b->glossy[0], b->glossy[1], b->glossy[2]};
    for (size_t i = 0; i < b->points.count; i++) {
        const float share = a->weight[i] * lit[i];
        if (share > 0.0f)
            sl_direct_add_lobe(b->pass->direct, b->pass->gbuffer, b->points.pixel[i],
                               sl_v3(a->x[i], a->y[i], a->z[i]), sl_rgb_scale(colour, share), glossy, i);
    }
}

/* Rows of tiles lie side by side in memory. */
static void take_pixels(const mapped_block *b, const float *plane, float *of_points) {
    const uint32_t *pixel = b->points.pixel;
    for (size_t i = 0; b->tiles && i < b->points.count; i += PART_WIDTH)
        memcpy(of_points + i, plane + pixel[i], PART_WIDTH * sizeof *plane);
    for (size_t i = 0; !b->tiles && i < b->points.count; i++) of_points[i] = plane[pixel[i]];
}

static void put_pixels(const mapped_block *b, const float *of_points, float *plane) {
    const uint32_t *pixel = b->points.pixel;
    for (size_t i = 0; b->tiles && i < b->points.count; i += PART_WIDTH)
        memcpy(plane + pixel[i], of_points + i, PART_WIDTH * sizeof *plane);
    for (size_t i = 0; !b->tiles && i < b->points.count; i++) plane[pixel[i]] = of_points[i];
}

static void put_radiance(const mapped_block *b) {
    const sl_gbuffer *g = b->pass->gbuffer;
    const float *diffuse[3] = {g->diffuse_r, g->diffuse_g, g->diffuse_b};
    const size_t count = b->points.count;
    for (int c = 0; c < 3; c++) {
        const float *irradiance = b->irradiance[c], *glossy = b->glossy[c];
        float radiance[SL_LIGHT_BLOCK];
        take_pixels(b, diffuse[c], radiance);
#pragma omp simd
        for (size_t i = 0; i < count; i++) { /* black times infinite is black */
            const float reflected = sl_picture_value(radiance[i] * (float)(1.0 / SL_PI) * irradiance[i]);
            radiance[i] = sl_picture_value(reflected + glossy[i]);
        }
        put_pixels(b, radiance, b->pass->out[c]);
    }
}

static bool some_are_glossy(const mapped_block *b) {
    const sl_direct *direct = b->pass->direct;
    bool glossy = false;
    for (size_t i = 0; direct->glossy && i < b->points.count; i++)
        glossy |= sl_pixel_is_glossy(b->pass->gbuffer, direct->scene, b->points.pixel[i]);
    return glossy;
}

/* Tells whether they are all pixels of tile after tile of eight by eight. */
static bool is_of_tiles(const mapped_block *b) {
    const uint32_t width = (uint32_t)b->pass->gbuffer->width, *pixel = b->points.pixel;
    for (size_t i = 0; i < b->points.count; i += TILE_HEIGHT * PART_WIDTH) {
        const uint32_t last = TILE_HEIGHT * PART_WIDTH - 1;
        if (i + last >= b->points.count || pixel[i + PART_WIDTH - 1] != pixel[i] + PART_WIDTH - 1 ||
            pixel[i + last] != pixel[i] + (TILE_HEIGHT - 1) * width + PART_WIDTH - 1)
            return false;
    }
    return true;
}

static void light_block(mapped_block *b) {
    const sl_shadow_maps *maps = b->pass->direct->settings.maps;
    const sl_light_points points = sl_lit_points(&b->points);
    memset(b->irradiance, 0, sizeof b->irradiance);
    memset(b->glossy, 0, sizeof b->glossy);
    unsigned parts = SL_MAPPED_LIGHTS;
    b->tiles = b->whole && is_of_tiles(b);
    if (b->whole) parts |= SL_MAPPED_TILE;
    if (b->tiles && b->pass->direct->interleaves) parts |= SL_MAPPED_INTERLEAVED;
    sl_shadow_maps_irradiance(maps, &points, parts, b->irradiance[0], b->irradiance[1], b->irradiance[2],
                              b->counters);
    if (some_are_glossy(b)) sl_shadow_maps_each(maps, &points, SL_MAPPED_LIGHTS, add_lobes, b, b->counters);
    put_radiance(b);
    b->points.count = 0;
}

static void add_pixels(mapped_block *b, sl_pixel_run run) {
    const mapped_pass *p = b->pass;
    for (size_t i = run.first; i < run.end; i++) {
        if (sl_pixel_reflects(p->gbuffer, p->direct->scene, i)) {
            sl_lit_block_add(p->direct, p->gbuffer, i, &b->points);
            if (b->points.count == SL_LIGHT_BLOCK) light_block(b);
        } else {
            for (int c = 0; c < 3; c++) p->out[c][i] = 0.0f;
        }
    }
}

static void add_part(mapped_block *b, int x, int y, int end) {
    const mapped_pass *p = b->pass;
    const size_t width = (size_t)p->gbuffer->width, columns = width - (size_t)x;
    for (; y < end; y++) {
        const size_t left = (size_t)y * width + (size_t)x,
                     right = left + (columns < PART_WIDTH ? columns : PART_WIDTH);
        for (sl_pixel_run r = sl_sub_frame_run(&p->direct->scene->sub_frame, left, right); r.first < r.end;
             r = sl_sub_frame_run(&p->direct->scene->sub_frame, r.end, right))
            add_pixels(b, r);
    }
}

static void light_tiles(void *context, size_t index, unsigned worker) {
    (void)worker;
    const mapped_pass *p = context;
    const int first = p->row + (int)index * TILE_HEIGHT, last = first + TILE_HEIGHT,
              end = last < p->end ? last : p->end, half = first + PART_HEIGHT,
              middle = half < end ? half : end, width = p->gbuffer->width;
    mapped_block b = {.pass = p, .counters = &p->counters[index]};
    b.whole = !p->direct->scene->sub_frame.wanted;
    for (int x = 0; x < width; x += PART_WIDTH) {
        add_part(&b, x, first, middle);
        add_part(&b, x, middle, end);
        /* so that one with gaps does not shift those behind it */
        if (p->direct->interleaves && x / PART_WIDTH % 2 && b.points.count) light_block(&b);
    }
    if (b.points.count) light_block(&b);
    sl_count(b.counters, SL_COUNT_FRAGMENTS_SHADED, (size_t)(end - first) * (size_t)width);
}

sl_status sl_direct_mapped_rows(const sl_direct *direct, const sl_gbuffer *gbuffer, int row, int end,
                                float *const radiance[3], sl_counters *counters, sl_error *error) {
    const size_t tasks = (size_t)((end - row + TILE_HEIGHT - 1) / TILE_HEIGHT);
    mapped_pass p = {direct, gbuffer, row, end, radiance, sl_allocate(tasks, sizeof *p.counters)};
    if (!p.counters) return sl_fail_memory(error, "direct light");
    sl_parallel_for(direct->settings.threads, tasks, light_tiles, &p);
    for (size_t i = 0; i < tasks; i++) sl_counters_add(counters, &p.counters[i]);
    sl_free(p.counters);
    return SL_OK;
}
