/* Pass R1', render to the atlas: triangles are drawn at their places in it. An atlas holds irradiance, which
 * no camera changes. */
#include "cache/light_octree/atlas/bake.h"

#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

/* Bilinear look-ups in a chart read texels less than this far outside it. */
enum { READ_AROUND = 1 };

/* ---- the canvas ---- */

/* Rings around what has a surface point: a texel without any belongs to ring k if one of its 8 neighbours is
 * in ring k - 1. */
static void grow_rings(uint8_t *ring, int size) {
    for (uint8_t k = 1; k <= SL_ATLAS_RINGS; k++)
        for (int y = 0; y < size; y++)
            for (int x = 0; x < size; x++) {
                uint8_t *here = &ring[(size_t)y * (size_t)size + (size_t)x];
                for (int n = 0; *here == SL_ATLAS_VOID && n < 9; n++) {
                    int i = x + n % 3 - 1, j = y + n / 3 - 1;
                    if (i >= 0 && j >= 0 && i < size && j < size &&
                        ring[(size_t)j * (size_t)size + (size_t)i] == k - 1)
                        *here = k;
                }
            }
}

/* Keeps the texels that have a surface point, in order. */
static bool list_texels(sl_atlas_canvas *c, const uint32_t *triangle, const float *w1, const float *w2) {
    size_t texels = (size_t)c->atlas->size * (size_t)c->atlas->size;
    for (size_t i = 0; i < texels; i++) c->count += triangle[i] != SL_NO_INDEX;
    c->texel = sl_allocate(c->count, sizeof *c->texel);
    c->triangle = sl_allocate(c->count, sizeof *c->triangle);
    c->w1 = sl_allocate(c->count, sizeof *c->w1);
    c->w2 = sl_allocate(c->count, sizeof *c->w2);
    c->ring = sl_allocate(texels, sizeof *c->ring);
    if (!c->texel || !c->triangle || !c->w1 || !c->w2 || !c->ring) return false;
    size_t at = 0;
    for (size_t i = 0; i < texels; i++) {
        c->ring[i] = triangle[i] == SL_NO_INDEX ? SL_ATLAS_VOID : 0;
        if (triangle[i] == SL_NO_INDEX) continue;
        c->texel[at] = (uint32_t)i;
        c->triangle[at] = triangle[i];
        c->w1[at] = w1[i];
        c->w2[at++] = w2[i];
    }
    grow_rings(c->ring, c->atlas->size);
    return true;
}

sl_status sl_atlas_canvas_create(const sl_atlas *atlas, const sl_scene *scene, unsigned threads,
                                 sl_atlas_canvas **canvas, sl_error *error) {
    size_t texels = (size_t)atlas->size * (size_t)atlas->size;
    sl_atlas_canvas *c = sl_allocate(1, sizeof *c);
    uint32_t *triangle = sl_allocate(texels, sizeof *triangle);
    float *w = sl_allocate(texels, 2 * sizeof *w);
    sl_status status = c && triangle && w ? sl_atlas_texels(atlas, scene, READ_AROUND, threads, triangle, w,
                                                            w + texels, error)
                                          : sl_fail_memory(error, "the canvas of an atlas");
    if (status == SL_OK) {
        c->atlas = atlas;
        if (!list_texels(c, triangle, w, w + texels))
            status = sl_fail_memory(error, "the canvas of an atlas");
    }
    if (status == SL_OK) status = sl_atlas_maps_create(atlas, scene, threads, &c->map, error);
    sl_free(triangle);
    sl_free(w);
    *canvas = status == SL_OK ? c : NULL;
    if (status != SL_OK) sl_atlas_canvas_destroy(c);
    return status;
}

void sl_atlas_canvas_destroy(sl_atlas_canvas *c) {
    if (!c) return;
    sl_free(c->texel);
    sl_free(c->triangle);
    sl_free(c->w1);
    sl_free(c->w2);
    sl_free(c->ring);
    sl_free(c->map);
    for (int s = 0; s < 2; s++) sl_texture_image_destroy(c->side[s]);
    sl_free(c);
}

size_t sl_atlas_canvas_bytes(const sl_atlas_canvas *c) {
    size_t texels = (size_t)c->atlas->size * (size_t)c->atlas->size,
           sides = (size_t)(c->side[0] != NULL) + (c->side[1] != NULL);
    return sizeof *c + c->atlas->triangle_count * sizeof *c->map +
           c->count * (2 * sizeof(uint32_t) + 2 * sizeof(float)) + texels * (1 + sides * 4 * sizeof(float));
}

/* ---- R1': into the atlas ---- */

typedef struct baking {
    sl_atlas_canvas *canvas;
    float *texels;          /* RGBA */
    sl_atlas_shader *shader;
    void *context;
    float *scratch;         /* 3 SL_ATLAS_BATCH a worker */
} baking;

static void bake_batch(void *context, size_t batch, unsigned worker) {
    const baking *b = context;
    const sl_atlas_canvas *c = b->canvas;
    size_t first = batch * SL_ATLAS_BATCH,
           count = c->count - first < SL_ATLAS_BATCH ? c->count - first : SL_ATLAS_BATCH;
    float *rgb = b->scratch + 3 * SL_ATLAS_BATCH * (size_t)worker;
    b->shader(b->context, worker, count, c->triangle + first, c->w1 + first, c->w2 + first, rgb,
              rgb + SL_ATLAS_BATCH, rgb + 2 * SL_ATLAS_BATCH);
    for (size_t i = 0; i < count; i++) {
        float *texel = b->texels + 4 * (size_t)c->texel[first + i];
        for (size_t k = 0; k < 3; k++)
            texel[k] = isfinite(rgb[k * SL_ATLAS_BATCH + i]) ? rgb[k * SL_ATLAS_BATCH + i] : 0.0f;
        texel[3] = 1.0f;
    }
}

/* A texel of ring k takes the mean of its neighbours in rings below k, in row order. */
static void fill_rings(const sl_atlas_canvas *c, float *texels) {
    int size = c->atlas->size;
    for (int k = 1; k <= SL_ATLAS_RINGS; k++)
        for (int y = 0; y < size; y++)
            for (int x = 0; x < size; x++) {
                size_t here = (size_t)y * (size_t)size + (size_t)x;
                double sum[3] = {0.0, 0.0, 0.0}, count = 0.0;
                if (c->ring[here] != k) continue;
                for (int n = 0; n < 9; n++) {
                    int i = x + n % 3 - 1, j = y + n / 3 - 1;
                    size_t there = (size_t)j * (size_t)size + (size_t)i;
                    if (i < 0 || j < 0 || i >= size || j >= size || c->ring[there] >= k) continue;
                    for (size_t d = 0; d < 3; d++) sum[d] += (double)texels[4 * there + d];
                    count += 1.0;
                }
                /* a ring's texel has such a neighbour */
                for (size_t d = 0; d < 3; d++) texels[4 * here + d] = (float)(sum[d] / count);
                texels[4 * here + 3] = 1.0f;
            }
}

sl_status sl_atlas_bake(sl_atlas_canvas *canvas, sl_atlas_side side, unsigned threads,
                        sl_atlas_shader *shader, void *context, sl_error *error) {
    threads = sl_thread_count(threads);
    if (!canvas->side[side]) {
        sl_status status = sl_texture_image_create(canvas->atlas->size, canvas->atlas->size, false,
                                                   &canvas->side[side], error);
        if (status != SL_OK) return status;
    }
    baking b = {canvas, canvas->side[side]->texels, shader, context,
                sl_allocate((size_t)threads * SL_ATLAS_BATCH, 3 * sizeof *b.scratch)};
    if (!b.scratch) return sl_fail_memory(error, "filling an atlas");
    sl_parallel_for(threads, (canvas->count + SL_ATLAS_BATCH - 1) / SL_ATLAS_BATCH, bake_batch, &b);
    fill_rings(canvas, b.texels);
    sl_free(b.scratch);
    return SL_OK;
}

/* ---- irradiance from the octree ---- */

typedef struct octree_source {
    const sl_scene *scene;
    const sl_octree_shading *shading;
    sl_atlas_side side;
    sl_octree_scratch **scratch;
    float *plane;           /* 6 SL_ATLAS_BATCH a worker: positions and normals */
    sl_counters *counters;
} octree_source;

static void shade_points(void *context, unsigned worker, size_t count, const uint32_t *triangle,
                         const float *w1, const float *w2, float *r, float *g, float *b) {
    const octree_source *o = context;
    float *p = o->plane + 6 * SL_ATLAS_BATCH * (size_t)worker;
    for (size_t i = 0; i < count; i++) {
        sl_vec3 n = sl_scene_geometric_normal(o->scene, triangle[i]);
        sl_surface surface;
        sl_scene_surface(o->scene, triangle[i], w1[i], w2[i], o->side == SL_ATLAS_FRONT ? n : sl_neg(n),
                         &surface);
        const float values[6] = {surface.position.x, surface.position.y, surface.position.z,
                                 surface.normal.x,   surface.normal.y,   surface.normal.z};
        for (size_t k = 0; k < 6; k++) p[k * SL_ATLAS_BATCH + i] = values[k];
    }
    const float *n = p + 3 * SL_ATLAS_BATCH;
    sl_octree_points points = {.count = count,
                               .x = p,
                               .y = p + SL_ATLAS_BATCH,
                               .z = p + 2 * SL_ATLAS_BATCH,
                               .normal_x = n,
                               .normal_y = n + SL_ATLAS_BATCH,
                               .normal_z = n + 2 * SL_ATLAS_BATCH,
                               .view_x = n,
                               .view_y = n + SL_ATLAS_BATCH,
                               .view_z = n + 2 * SL_ATLAS_BATCH};
    sl_octree_shade(o->shading, &points, o->scratch[worker], r, g, b, &o->counters[worker]);
    sl_count(&o->counters[worker], SL_COUNT_FRAGMENTS_SHADED, count);
}

sl_status sl_atlas_bake_octree(sl_atlas_canvas *canvas, sl_atlas_side side, const sl_scene *scene,
                               const sl_octree_shading *shading, unsigned threads, sl_counters *counters,
                               sl_error *error) {
    threads = sl_thread_count(threads);
    octree_source o = {scene,
                       shading,
                       side,
                       sl_allocate(threads, sizeof *o.scratch),
                       sl_allocate((size_t)threads * SL_ATLAS_BATCH, 6 * sizeof *o.plane),
                       sl_allocate(threads, sizeof *o.counters)};
    sl_status status = o.scratch && o.plane && o.counters ? SL_OK : sl_fail_memory(error, "filling an atlas");
    for (unsigned t = 0; status == SL_OK && t < threads; t++)
        status = sl_octree_scratch_create(&o.scratch[t], error);
    if (status == SL_OK) status = sl_atlas_bake(canvas, side, threads, shade_points, &o, error);
    for (unsigned t = 0; status == SL_OK && t < threads; t++) sl_counters_add(counters, &o.counters[t]);
    for (unsigned t = 0; o.scratch && t < threads; t++) sl_octree_scratch_destroy(o.scratch[t]);
    sl_free(o.scratch);
    sl_free(o.plane);
    sl_free(o.counters);
    return status;
}
