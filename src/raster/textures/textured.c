/* The textured pass: perspective-correct texture coordinates, level of detail and filtered colour, once for each
 * visible pixel.
 *
 *     resolve        a block's runs of pixels with one triangle, their edge functions     (resolve.h)
 *     fetch          each run's texture and corners' coordinates
 *     coordinates    s, t and level of detail, a pixel in each lane                       (textured_kernels.c)
 *     look up        neighbouring runs with one texture together                          (texture_kernels.c)
 *     shade          a run's material times the colours */
#include <string.h>

#include "base/parallel.h"
#include "raster/textures/lookup_kernels.h"

enum { STRIP = 8192 }; /* pixels of a task */

typedef struct {
    const sl_raster *raster;
    const sl_view *view;
    sl_pass_view pass_view;
    const uint32_t *id;
    const sl_textured_pass *pass;
    const sl_textured_planes *out;
    const sl_texture_kernels *kernels;
    size_t pixels;
} textured;

/* NULL: a mesh alone has none. */
static const sl_material *material_of(const textured *c, uint32_t triangle) {
    const sl_scene *scene = c->raster->scene;
    return scene ? &scene->materials[scene->material_index[triangle]] : NULL;
}

/* NULL: without texture. */
static const sl_texture_image *image_of(const textured *c, uint32_t triangle) {
    if (c->pass->single) return c->pass->single;
    const sl_material *m = material_of(c, triangle);
    return m && m->texture != SL_NO_INDEX && c->pass->set ? sl_texture_set_image(c->pass->set, m->texture) : NULL;
}

static void fetch_run(const textured *c, uint32_t triangle, uint32_t run, sl_textured_block *out) {
    const sl_scene *scene = c->raster->scene;
    const float *own = c->pass->coordinates;
    out->image[run] = triangle == SL_NO_INDEX ? NULL : image_of(c, triangle);
    for (int k = 0; k < 3 && out->image[run]; k++) {
        uint32_t vertex = c->raster->mesh.vertex[k][triangle];
        const float *corner = own ? own + 6 * (size_t)triangle + 2 * (size_t)k : NULL;
        out->corner_s[k][run] = corner ? corner[0] : scene ? scene->texture_u[vertex] : 0.0f;
        out->corner_t[k][run] = corner ? corner[1] : scene ? scene->texture_v[vertex] : 0.0f;
    }
}

/* Runs that show one image are looked up together. */
static void look_up(const textured *c, const sl_resolve_block *block, sl_textured_block *t) {
    float *const color = t->color[0];
    for (uint32_t r = 0, end; r < block->runs; r = end) {
        end = r + 1;
        while (end < block->runs && t->image[end] == t->image[r]) end++;
        const uint32_t first = block->start[r], count = block->start[end] - first;
        if (!t->image[r]) continue;
        float *const plane[4] = {color + first, color + SL_RESOLVE_ROOM + first, color + 2 * SL_RESOLVE_ROOM + first,
                                 color + 3 * SL_RESOLVE_ROOM + first};
        if (c->pass->lod_bias != 0.0f) {
            for (uint32_t n = first; n < first + count; n++) t->lod[n] += c->pass->lod_bias;
        }
        for (uint32_t n = 0; n < count; n += SL_TEXTURE_BLOCK) {
            float *const part[4] = {plane[0] + n, plane[1] + n, plane[2] + n, plane[3] + n};
            c->kernels->texture(t->image[r], c->pass->sampler, count - n < SL_TEXTURE_BLOCK ? count - n : SL_TEXTURE_BLOCK,
                                t->s + first + n, t->t + first + n, t->lod + first + n, part);
        }
    }
}

/* values NULL: a constant. */
static void write_run(float *plane, size_t first, size_t count, float factor, const float *restrict values) {
    if (!plane) return;
    float *restrict to = plane + first;
    if (values) {
#pragma omp simd
        for (size_t n = 0; n < count; n++) to[n] = factor * values[n];
    } else {
        for (size_t n = 0; n < count; n++) to[n] = factor;
    }
}

/* Run r, whose pixels begin at `first` of the view. */
static void shade_run(const textured *c, const sl_resolve_block *block, const sl_textured_block *t, uint32_t r, size_t first) {
    const sl_textured_planes *out = c->out;
    const uint32_t triangle = sl_run_triangle(block, r), start = block->start[r];
    const size_t count = block->start[r + 1] - start;
    const sl_material *m = triangle == SL_NO_INDEX ? NULL : material_of(c, triangle);
    const bool drawn = triangle != SL_NO_INDEX, lit = t->image[r] != NULL;
    const sl_rgb white = sl_grey(drawn ? 1.0f : 0.0f), kd = m && !c->pass->single ? m->diffuse : white;
    const sl_rgb ks = m ? m->specular : sl_grey(0.0f);
    write_run(out->color[0], first, count, kd.r, lit ? t->color[0] + start : NULL);
    write_run(out->color[1], first, count, kd.g, lit ? t->color[1] + start : NULL);
    write_run(out->color[2], first, count, kd.b, lit ? t->color[2] + start : NULL);
    write_run(out->color[3], first, count, white.r, lit ? t->color[3] + start : NULL);
    write_run(out->specular[0], first, count, ks.r, NULL);
    write_run(out->specular[1], first, count, ks.g, NULL);
    write_run(out->specular[2], first, count, ks.b, NULL);
    write_run(out->s, first, count, lit ? 1.0f : 0.0f, lit ? t->s + start : NULL);
    write_run(out->t, first, count, lit ? 1.0f : 0.0f, lit ? t->t + start : NULL);
    write_run(out->lod, first, count, lit ? 1.0f : 0.0f, lit ? t->lod + start : NULL);
}

static void shade_strip(void *context, size_t index, unsigned worker) {
    (void)worker;
    const textured *c = context;
    size_t first = index * STRIP, end = c->pixels - first < STRIP ? c->pixels : first + STRIP;
    const bool lod = c->pass->sampler.mip != SL_MIP_NONE || c->out->lod;
    sl_resolve_block block;
    sl_textured_block t;
    memset(&block, 0, sizeof block);
    memset(&t, 0, sizeof t);
    for (; first < end; first += block.count) {
        sl_resolve_next(c->raster, &c->pass_view, end - first, first, NULL, c->id + first, &block);
        for (uint32_t r = 0; r < block.runs; r++) fetch_run(c, sl_run_triangle(&block, r), r, &t);
        c->kernels->textured(&block, c->view, c->pass->lod_rule, lod, &t);
        look_up(c, &block, &t);
        for (uint32_t r = 0; r < block.runs; r++) shade_run(c, &block, &t, r, first + block.start[r]);
    }
}

void sl_raster_textured(const sl_raster *raster, const sl_view *view, unsigned threads, const uint32_t *id,
                        const sl_textured_pass *pass, const sl_textured_planes *out, sl_counters *counters) {
    textured c = {raster, view, sl_pass_view_make(view, view->width, view->height), id, pass, out, sl_texture_kernels_best(),
                  (size_t)view->width * (size_t)view->height};
    sl_parallel_for(sl_thread_count(threads), (c.pixels + STRIP - 1) / STRIP, shade_strip, &c);
    uint64_t shaded = 0;
    for (size_t i = 0; i < c.pixels; i++) shaded += id[i] != SL_NO_INDEX;
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, shaded);
}
