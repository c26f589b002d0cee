/* Gouraud interpolation, perspective-correct, once for each visible pixel; what is done with the values there
 * is the caller's. */
#include <string.h>

#include "base/parallel.h"
#include "raster/resolve/resolve.h"

enum { STRIP = SL_GOURAUD_STRIP, CHANNELS = SL_GOURAUD_CHANNELS };

typedef struct {
    const sl_raster *raster;
    sl_pass_view view;
    const uint32_t *id;
    const sl_gouraud_pass *pass;
    size_t pixels; /* of a plane */
    size_t first, end;
    uint64_t *shaded; /* by worker */
} gouraud;

/* ---- the corners' values ---- */

static void fetch_vertices(const sl_gouraud_pass *pass, const sl_resolve_block *block, size_t channels,
                           sl_run_corners *value) {
    static const float black[CHANNELS] = {0};
    for (int k = 0; k < 3; k++) {
        for (uint32_t r = 0; r < block->runs; r++) {
            const uint32_t v = block->vertex[k][r];
            const float *attributes = v == SL_NO_INDEX ? black : pass->vertex + v * channels;
            for (size_t c = 0; c < channels; c++) value[c][k][r] = attributes[c];
        }
    }
}

static void fetch_corners(const sl_gouraud_pass *pass, const sl_resolve_block *block, size_t channels,
                          sl_run_corners *value) {
    for (uint32_t r = 0; r < block->runs; r++) {
        float corners[3 * CHANNELS] = {0};
        const uint32_t triangle = sl_run_triangle(block, r);
        if (triangle != SL_NO_INDEX) pass->corners(pass->context, triangle, corners);
        for (size_t k = 0; k < 3; k++) {
            for (size_t c = 0; c < channels; c++) value[c][k][r] = corners[k * channels + c];
        }
    }
}

static void fetch(const sl_gouraud_pass *pass, const sl_resolve_block *block, sl_run_corners *value) {
    if (pass->corners) fetch_corners(pass, block, (size_t)pass->channels, value);
    /* the constant, so that colours are compiled for it */
    else if (pass->channels == 3) fetch_vertices(pass, block, 3, value);
    else fetch_vertices(pass, block, (size_t)pass->channels, value);
}

/* ---- a strip's pixels ---- */

static void interpolate(const gouraud *g, const sl_resolve_block *block, size_t pixel, size_t at,
                        float (*value)[STRIP]) {
    sl_run_corners corners[CHANNELS];
    float plane[SL_RESOLVE_ROOM];
    fetch(g->pass, block, corners);
    for (size_t c = 0; c < (size_t)g->pass->channels; c++) {
        SL_KERNEL_OF(g->raster->isa, sl_resolve_interpolate)(block, corners[c], plane);
        float *out = g->pass->out ? g->pass->out + c * g->pixels + pixel : value[c] + at;
        memcpy(out, plane, block->count * sizeof *plane);
    }
}

static void look_up_textures(const gouraud *g, const sl_resolve_block *block, size_t at,
                             float (*diffuse)[STRIP]) {
    sl_vector_planes kd;
    sl_resolve_diffuse(g->raster, &g->view, block, &kd);
    memcpy(diffuse[0] + at, kd.x, block->count * sizeof(float));
    memcpy(diffuse[1] + at, kd.y, block->count * sizeof(float));
    memcpy(diffuse[2] + at, kd.z, block->count * sizeof(float));
}

static void shade_strip(void *context, size_t index, unsigned worker) {
    const gouraud *g = context;
    const sl_gouraud_pass *pass = g->pass;
    const size_t first = g->first + index * STRIP, count = g->end - first < STRIP ? g->end - first : STRIP;
    float value[CHANNELS][STRIP], diffuse[3][STRIP];
    sl_resolve_block block;
    memset(&block, 0, sizeof block);
    block.later = (const char *)pass->vertex;
    block.later_bytes = (size_t)pass->channels * sizeof *pass->vertex;
    for (size_t at = 0; at < count; at += block.count) {
        sl_resolve_next(g->raster, &g->view, count - at, first + at, NULL, g->id + first + at, &block);
        interpolate(g, &block, first + at, at, value);
        if (pass->textured) look_up_textures(g, &block, at, diffuse);
        g->shaded[worker] += sl_resolve_shaded(&block);
    }
    if (pass->shade) {
        sl_gouraud_pixels pixels = {
            .first = first, .count = count, .worker = worker, .id = g->id + first};
        for (int c = 0; c < pass->channels; c++) pixels.value[c] = value[c];
        for (int c = 0; c < 3 && pass->textured; c++) pixels.diffuse[c] = diffuse[c];
        pass->shade(pass->context, &pixels);
    }
}

void sl_raster_gouraud(const sl_raster *raster, const sl_view *view, unsigned threads, const uint32_t *id,
                       const sl_gouraud_pass *pass, sl_counters *counters) {
    enum { WORKERS_MAX = 256 };
    uint64_t shaded[WORKERS_MAX] = {0}, sum = 0;
    gouraud g = {raster,
                 sl_pass_view_make(view, view->width, view->height),
                 id,
                 pass,
                 (size_t)view->width * (size_t)view->height,
                 pass->first,
                 0,
                 shaded};
    g.end = pass->count ? pass->first + pass->count : g.pixels;
    if (raster->observer) raster->observer->gouraud(raster->observer->context, raster, view, id, pass);
    sl_parallel_for(sl_thread_count(threads), (g.end - g.first + STRIP - 1) / STRIP, shade_strip, &g);
    for (size_t i = 0; i < WORKERS_MAX; i++) sum += shaded[i];
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, sum);
}
