/* Renders to the atlas: its texels get the light of the surface points that they hold. It is irradiance,
 * which no camera changes. */
#include "cache/light_octree/atlas/atlas.h"

#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

/* ---- the canvas ---- */

/* Keeps the texels that have a surface point, in order. */
static bool list_texels(sl_atlas_canvas *c, const uint32_t *triangle, const float *w1, const float *w2) {
    size_t texels = (size_t)c->atlas->size * (size_t)c->atlas->size;
    for (size_t i = 0; i < texels; i++) c->count += triangle[i] != SL_NO_INDEX;
    c->texel = sl_allocate(c->count, sizeof *c->texel);
    c->triangle = sl_allocate(c->count, sizeof *c->triangle);
    c->w1 = sl_allocate(c->count, sizeof *c->w1);
    c->w2 = sl_allocate(c->count, sizeof *c->w2);
    if (!c->texel || !c->triangle || !c->w1 || !c->w2) return false;
    size_t at = 0;
    for (size_t i = 0; i < texels; i++) {
        if (triangle[i] == SL_NO_INDEX) continue;
        c->texel[at] = (uint32_t)i;
        c->triangle[at] = triangle[i];
        c->w1[at] = w1[i];
        c->w2[at++] = w2[i];
    }
    return true;
}

sl_status sl_atlas_canvas_create(const sl_atlas *atlas, const sl_scene *scene, unsigned threads,
                                 sl_atlas_canvas **canvas, sl_error *error) {
    size_t texels = (size_t)atlas->size * (size_t)atlas->size;
    sl_atlas_canvas *c = sl_allocate(1, sizeof *c);
    uint32_t *triangle = sl_allocate(texels, sizeof *triangle);
    float *w = sl_allocate(texels, 2 * sizeof *w);
    sl_status status = c && triangle && w ? sl_atlas_texels(atlas, scene, threads, triangle, w, w + texels,
                                                            &c->covered, error)
                                          : sl_fail_memory(error, "the canvas of an atlas");
    if (status == SL_OK) {
        c->atlas = atlas;
        if (!list_texels(c, triangle, w, w + texels))
            status = sl_fail_memory(error, "the canvas of an atlas");
    }
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
    for (int s = 0; s < 2; s++) sl_texture_image_destroy(c->side[s]);
    sl_free(c);
}

size_t sl_atlas_canvas_bytes(const sl_atlas_canvas *c) {
    size_t texels = (size_t)c->atlas->size * (size_t)c->atlas->size,
           sides = (size_t)(c->side[0] != NULL) + (c->side[1] != NULL);
    return sizeof *c + c->count * (2 * sizeof(uint32_t) + 2 * sizeof(float)) +
           texels * sides * 4 * sizeof(float);
}

/* ---- irradiance from the octree's lights into the texels ---- */

enum { BATCH = 4096 };

typedef struct baking {
    const sl_atlas_canvas *canvas;
    sl_atlas_side side;
    const sl_scene *scene;
    const sl_octree_shading *shading;
    sl_octree_scratch **scratch;   /* a worker's, as are */
    sl_octree_point *point;        /* BATCH, */
    float *rgb;                    /* 3 BATCH */
    sl_counters *counters;
} baking;



static sl_octree_point point_of_texel(const baking *b, size_t i) {
    const sl_atlas_canvas *c = b->canvas;
    sl_vec3 n = sl_scene_geometric_normal(b->scene, c->triangle[i]);
    sl_surface surface;
    sl_scene_surface(b->scene, c->triangle[i], c->w1[i], c->w2[i],
                     b->side == SL_ATLAS_FRONT ? n : sl_neg(n), &surface);
    return (sl_octree_point){
        .position = surface.position, .normal = surface.normal, .diffuse = sl_grey((float)SL_PI)};
}

static void bake_batch(void *context, size_t batch, unsigned worker) {
    const baking *b = context;
    const sl_atlas_canvas *c = b->canvas;
    size_t first = batch * BATCH, count = c->count - first < BATCH ? c->count - first : BATCH;
    sl_octree_point *point = b->point + BATCH * (size_t)worker;
    float *rgb = b->rgb + 3 * BATCH * (size_t)worker;
    for (size_t i = 0; i < count; i++) point[i] = point_of_texel(b, first + i);
    sl_octree_shade(b->shading, point, count, b->scratch[worker], rgb, rgb + BATCH, rgb + 2 * BATCH,
                    &b->counters[worker]);
    for (size_t i = 0; i < count; i++) {
        float *texel = c->side[b->side]->texels + 4 * (size_t)c->texel[first + i];
        for (size_t k = 0; k < 3; k++) texel[k] = isfinite(rgb[k * BATCH + i]) ? rgb[k * BATCH + i] : 0.0f;
        texel[3] = 1.0f;
    }
    sl_count(&b->counters[worker], SL_COUNT_FRAGMENTS_SHADED, count);
}

sl_status sl_atlas_bake(sl_atlas_canvas *canvas, sl_atlas_side side, const sl_scene *scene,
                        const sl_octree_shading *shading, unsigned threads, sl_counters *counters,
                        sl_error *error) {
    threads = sl_thread_count(threads);
    baking b = {canvas,
                side,
                scene,
                shading,
                sl_allocate(threads, sizeof *b.scratch),
                sl_allocate((size_t)threads * BATCH, sizeof *b.point),
                sl_allocate((size_t)threads * BATCH, 3 * sizeof *b.rgb),
                sl_allocate(threads, sizeof *b.counters)};
    sl_status status =
        b.scratch && b.point && b.rgb && b.counters ? SL_OK : sl_fail_memory(error, "filling an atlas");
    for (unsigned t = 0; status == SL_OK && t < threads; t++)
        status = sl_octree_scratch_create(&b.scratch[t], error);
    if (status == SL_OK && !canvas->side[side])
        status = sl_texture_image_create(canvas->atlas->size, canvas->atlas->size, false,
                                         &canvas->side[side], error);
    if (status == SL_OK) sl_parallel_for(threads, (canvas->count + BATCH - 1) / BATCH, bake_batch, &b);
    for (unsigned t = 0; status == SL_OK && t < threads; t++) sl_counters_add(counters, &b.counters[t]);
    for (unsigned t = 0; b.scratch && t < threads; t++) sl_octree_scratch_destroy(b.scratch[t]);
    sl_free(b.scratch);
    sl_free(b.point);
    sl_free(b.rgb);
    sl_free(b.counters);
    return status;
}

/* ---- pixels lit from the atlas ---- */

/* A pixel costs two dot products with its position and one look-up on the side that it shows, where the
 * octree costs a descent for each of eight voxels. */
enum { LOOK_UPS = SL_TEXTURE_BLOCK };

typedef struct application {
    const sl_atlas_canvas *canvas;
    const sl_gbuffer *gbuffer;
    const sl_scene *scene;
    float *out[3];
    uint64_t *fetches; /* of each worker, a cache line apart */
} application;

enum { LINE = 8 };

/* Pixels that wait for their look-up, all on one side. */
typedef struct look_ups {
    sl_atlas_side side;
    size_t count;
    size_t pixel[LOOK_UPS];
    float s[LOOK_UPS], t[LOOK_UPS];
} look_ups;

static void look_up(const application *a, look_ups *l) {
    const sl_gbuffer *g = a->gbuffer;
    const float *const kd[3] = {g->diffuse_r, g->diffuse_g, g->diffuse_b};
    float irradiance[3][LOOK_UPS];
    float *const plane[4] = {irradiance[0], irradiance[1], irradiance[2], NULL};
    sl_texture_sample_many(a->canvas->side[l->side], l->count, l->s, l->t, NULL, plane);
    for (int k = 0; k < 3; k++) {
        for (size_t n = 0; n < l->count; n++)
            a->out[k][l->pixel[n]] = kd[k][l->pixel[n]] * (float)(1.0 / SL_PI) * irradiance[k][n];
    }
    l->count = 0;
}

sl_atlas_side sl_atlas_side_seen(const sl_scene *scene, const sl_gbuffer *g, size_t pixel) {
    sl_vec3 seen = sl_v3(g->geometric_x[pixel], g->geometric_y[pixel], g->geometric_z[pixel]);
    return sl_dot(seen, sl_scene_geometric_normal(scene, g->id[pixel])) < 0.0f ? SL_ATLAS_BACK
                                                                               : SL_ATLAS_FRONT;
}

static void apply_row(void *context, size_t row, unsigned worker) {
    const application *a = context;
    const sl_gbuffer *g = a->gbuffer;
    look_ups l = {.count = 0};
    uint32_t last = SL_NO_INDEX;
    const sl_atlas_chart *chart = NULL;
    bool lit = false;
    for (size_t i = row * (size_t)g->width; i < (row + 1) * (size_t)g->width; i++) {
        for (int k = 0; k < 3; k++) a->out[k][i] = 0.0f;
        if (g->material[i] == SL_NO_INDEX) continue;
        if (g->id[i] != last) { /* a triangle shows one side to a view */
            last = g->id[i];
            chart = &a->canvas->atlas->chart[a->canvas->atlas->chart_of[last]];
            sl_atlas_side side = sl_atlas_side_seen(a->scene, g, i);
            lit = a->canvas->side[side] && !sl_material_is_mirror(&a->scene->materials[g->material[i]]);
            if (lit && side != l.side && l.count > 0) look_up(a, &l);
            if (lit) l.side = side;
        }
        if (!lit) continue;
        sl_atlas_point(chart, sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]), &l.s[l.count],
                       &l.t[l.count]);
        l.pixel[l.count++] = i;
        a->fetches[worker * LINE]++;
        if (l.count == LOOK_UPS) look_up(a, &l);
    }
    if (l.count > 0) look_up(a, &l);
}

sl_status sl_atlas_apply(const sl_atlas_canvas *canvas, const sl_gbuffer *gbuffer, const sl_scene *scene,
                         unsigned threads, float *r, float *g, float *b, sl_counters *counters,
                         sl_error *error) {
    threads = sl_thread_count(threads);
    application a = {
        canvas, gbuffer, scene, {r, g, b}, sl_allocate((size_t)threads * LINE, sizeof *a.fetches)};
    if (!a.fetches) return sl_fail_memory(error, "an atlas's look-ups");
    sl_parallel_for(threads, (size_t)gbuffer->height, apply_row, &a);
    for (unsigned t = 0; t < threads; t++) {
        sl_count(counters, SL_COUNT_TEXTURE_FETCHES, a.fetches[t * LINE]); /* one a pixel */
        sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, a.fetches[t * LINE]);
    }
    sl_free(a.fetches);
    return SL_OK;
}
