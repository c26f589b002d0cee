#include "cache/multi_mesh/merge.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/math.h"
#include "base/parallel.h"
#include "cache/frame/picture_value.h"

#include <string.h>

/* ---- image pass 2 ---- */

typedef struct resolving {
    const sl_scene *scene;
    const sl_view *view;
    const uint32_t *id;
    sl_materials_seen *out;
} resolving;

static void put(float *const planes[3], size_t pixel, sl_rgb colour) {
    planes[0][pixel] = colour.r;
    planes[1][pixel] = colour.g;
    planes[2][pixel] = colour.b;
}

static void resolve_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const resolving *r = context;
    size_t width = (size_t)r->out->width;
    sl_rgb emission = sl_grey(0.0f);
    for (size_t column = 0; column < width; column++) {
        size_t pixel = row * width + column;
        uint32_t triangle = r->id[pixel];
        if (r->out->specular[0] && triangle != SL_NO_INDEX)
            put(r->out->specular, pixel, sl_triangle_material(r->scene, triangle)->specular);
        if (!r->out->emission[0]) continue;
        /* At all of a triangle's points the eye sees the same side. */
        if (!column || triangle == SL_NO_INDEX || triangle != r->id[pixel - 1])
            emission = sl_view_emission(r->view, r->scene, triangle, column, row);
        put(r->out->emission, pixel, emission);
    }
}

static void give_planes(sl_materials_seen *m, float *planes[3], size_t *next) {
    for (int k = 0; k < 3; k++) planes[k] = m->planes + (*next)++ * (size_t)m->width * (size_t)m->height;
}

sl_status sl_materials_resolve(const sl_scene *scene, const sl_raster *raster, const sl_view *view,
                               const uint32_t *id, sl_materials_wanted wanted, unsigned threads,
                               sl_materials_seen **materials, sl_counters *counters, sl_error *error) {
    *materials = NULL;
    size_t pixels = (size_t)view->width * (size_t)view->height, next = 0;
    size_t planes = 3u + (wanted.specular ? 3u : 0u) + (wanted.emission ? 3u : 0u);
    sl_materials_seen *m = sl_allocate(1, sizeof *m);
    if (m) m->planes = sl_allocate(planes * pixels, sizeof *m->planes); /* what shows nothing is black */
    if (!m || !m->planes) {
        sl_materials_destroy(m);
        return sl_fail_memory(error, "the material pass");
    }
    m->width = view->width;
    m->height = view->height;
    give_planes(m, m->diffuse, &next);
    if (wanted.specular) give_planes(m, m->specular, &next);
    if (wanted.emission) give_planes(m, m->emission, &next);
    resolving r = {scene, view, id, m};
    sl_gbuffer targets = {.width = view->width, .height = view->height, .id = (uint32_t *)(uintptr_t)id,
                          .diffuse_r = m->diffuse[0], .diffuse_g = m->diffuse[1], .diffuse_b = m->diffuse[2]};
    sl_status status = sl_raster_resolve(raster, view, threads, &targets, counters, error);
    if (status != SL_OK) {
        sl_materials_destroy(m);
        return status;
    }
    if (wanted.specular || wanted.emission) sl_parallel_for(threads, (size_t)view->height, resolve_row, &r);
    *materials = m;
    return SL_OK;
}

void sl_materials_destroy(sl_materials_seen *m) {
    if (!m) return;
    sl_free(m->planes);
    sl_free(m);
}

double sl_materials_glossy_share(const sl_materials_seen *m) {
    size_t pixels = (size_t)m->width * (size_t)m->height, glossy = 0;
    for (size_t i = 0; m->specular[0] && i < pixels; i++) {
        float ks = m->specular[0][i] + m->specular[1][i] + m->specular[2][i];
        glossy += ks > m->diffuse[0][i] + m->diffuse[1][i] + m->diffuse[2][i];
    }
    return (double)glossy / (double)pixels;
}

/* ---- image pass 4 ---- */

enum { PICTURE, DIRECT, SPECULAR, INDIRECT, EMISSION, KD, KS, LAYERS, CHANNELS = 3 * LAYERS };

static const char *const channel_names[CHANNELS] = {
    "R",          "G",          "B",          "direct.R",   "direct.G",   "direct.B",   "specular.R",
    "specular.G", "specular.B", "indirect.R", "indirect.G", "indirect.B", "emission.R", "emission.G",
    "emission.B", "kd.R",       "kd.G",       "kd.B",       "ks.R",       "ks.G",       "ks.B"};

typedef struct merging {
    const sl_merge *merge;
    float *out;
} merging;

/* out = a b scale; black, as it is, where there is no a or b. */
static void product(const float *a, const float *b, float scale, size_t from, size_t count, float *out) {
    for (size_t i = 0; a && b && i < count; i++)
        out[i] = sl_picture_value(a[from + i] * (b[from + i] * scale));
}

static void copy(const float *plane, size_t from, size_t count, float *to) {
    if (plane) memcpy(to, plane + from, count * sizeof *to);
}

static void merge_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const merging *c = context;
    const sl_merge *m = c->merge;
    size_t width = (size_t)m->materials->width, height = (size_t)m->materials->height;
    size_t from = row * width, to = (height - 1 - row) * width, pixels = width * height;
    for (size_t k = 0; k < 3; k++) {
        const float *kd = m->materials->diffuse[k], *ks = m->materials->specular[k];
        float *layer[LAYERS];
        for (size_t i = 0; i < LAYERS; i++) layer[i] = c->out + (3 * i + k) * pixels + to;
        float *direct = layer[DIRECT], *highlight = layer[SPECULAR],
              *indirect = layer[INDIRECT], *lamp = layer[EMISSION], *picture = layer[PICTURE];
        product(kd, m->direct_diffuse[k], 1.0f, from, width, direct);
        product(ks, m->direct_specular[k], 1.0f, from, width, highlight);
        product(kd, m->indirect[k], (float)(1.0 / SL_PI), from, width, indirect);
        copy(m->materials->emission[k], from, width, lamp);
        copy(kd, from, width, layer[KD]);
        copy(ks, from, width, layer[KS]);
        for (size_t i = 0; i < width; i++)
            picture[i] = sl_picture_value(((direct[i] + highlight[i]) + indirect[i]) + lamp[i]);
    }
}

sl_status sl_merge_picture(const sl_merge *merge, sl_image **image, sl_error *error) {
    sl_status status = sl_image_create(merge->materials->width, merge->materials->height, CHANNELS,
                                       channel_names, image, error);
    if (status != SL_OK) return status;
    merging c = {merge, (*image)->planes};
    sl_parallel_for(merge->threads, (size_t)merge->materials->height, merge_row, &c);
    return SL_OK;
}
