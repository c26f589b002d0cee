/* Renders to the atlas: its texels get the light of the surface points that they hold. It is irradiance,
 * which no camera changes. */
#include "cache/light_octree/atlas/atlas.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

/* ---- the canvas ---- */

static size_t texels_of(const sl_atlas_canvas *c) {
    return (size_t)c->atlas->size * (size_t)c->atlas->size;
}

sl_status sl_atlas_canvas_create(sl_atlas *atlas, const sl_scene *scene, unsigned threads,
                                 sl_atlas_canvas **canvas, sl_error *error) {
    *canvas = NULL;
    sl_atlas_canvas *c = sl_allocate(1, sizeof *c);
    if (!c) {
        sl_atlas_destroy(atlas);
        return sl_fail_memory(error, "the canvas of an atlas");
    }
    c->atlas = atlas;
    const size_t texels = texels_of(c);
    c->triangle = sl_allocate(texels, sizeof *c->triangle);
    c->w1 = sl_allocate(texels, 2 * sizeof *c->w1);
    c->w2 = c->w1 ? c->w1 + texels : NULL;
    sl_status status = c->triangle && c->w1
                           ? sl_atlas_texels(atlas, scene, threads, c->triangle, c->w1, c->w2, error)
                           : sl_fail_memory(error, "the canvas of an atlas");
    if (status == SL_OK) *canvas = c;
    else sl_atlas_canvas_destroy(c);
    return status;
}

void sl_atlas_canvas_destroy(sl_atlas_canvas *c) {
    if (!c) return;
    SL_FREE_ALL(c->triangle, c->w1);
    for (int s = 0; s < 2; s++) sl_texture_image_destroy(c->side[s]);
    sl_atlas_destroy(c->atlas);
    sl_free(c);
}

size_t sl_atlas_canvas_bytes(const sl_atlas_canvas *c) {
    size_t sides = (size_t)(c->side[0] != NULL) + (c->side[1] != NULL);
    return sizeof *c + sl_atlas_bytes(c->atlas) +
           texels_of(c) * (sizeof(uint32_t) + (2 + 4 * sides) * sizeof(float));
}

/* ---- irradiance from the octree's lights into the texels ---- */

typedef struct baking {
    const sl_atlas_canvas *canvas;
    const sl_scene *scene;
    sl_atlas_side side;
} baking;

static bool find_texel(const void *context, size_t i, sl_octree_point *point) {
    const baking *b = context;
    const sl_atlas_canvas *c = b->canvas;
    if (c->triangle[i] == SL_NO_INDEX) return false;
    sl_vec3 n = sl_scene_geometric_normal(b->scene, c->triangle[i]);
    sl_surface surface;
    sl_scene_surface(b->scene, c->triangle[i], c->w1[i], c->w2[i],
                     b->side == SL_ATLAS_FRONT ? n : sl_neg(n), &surface);
    *point = (sl_octree_point){
        .position = surface.position, .normal = surface.normal, .diffuse = sl_grey((float)SL_PI)};
    return true;
}

static void put_texel(void *context, size_t i, const float rgb[3]) {
    const baking *b = context;
    float *texel = b->canvas->side[b->side]->texels + 4 * i;
    for (size_t k = 0; k < 3; k++) texel[k] = isfinite(rgb[k]) ? rgb[k] : 0.0f;
    texel[3] = 1.0f;
}

sl_status sl_atlas_bake(sl_atlas_canvas *canvas, sl_atlas_side side, const sl_scene *scene,
                        const sl_octree_shading *shading, unsigned threads, sl_counters *counters,
                        sl_error *error) {
    baking b = {canvas, scene, side};
    const sl_octree_points points = {texels_of(canvas), find_texel, put_texel, &b};
    sl_status status = SL_OK;
    if (!canvas->side[side])
        status = sl_texture_image_create(canvas->atlas->size, canvas->atlas->size, &canvas->side[side],
                                         error);
    if (status == SL_OK) status = sl_octree_shade(shading, &points, threads, counters, error);
    canvas->filled[side] = status == SL_OK;
    return status;
}

/* ---- pixels lit from the atlas ---- */

/* A pixel costs two dot products with its position and one look-up on the side that it shows, where the
 * octree costs a descent for each of eight voxels. */
typedef struct application {
    const sl_atlas_canvas *canvas;
    const sl_gbuffer *gbuffer;
    const uint8_t *side;
    float *const *out;
} application;

sl_atlas_side sl_atlas_side_seen(const sl_scene *scene, const sl_gbuffer *g, size_t pixel) {
    sl_vec3 seen = sl_gbuffer_geometric(g, pixel);
    return sl_dot(seen, sl_scene_geometric_normal(scene, g->id[pixel])) < 0.0f ? SL_ATLAS_BACK
                                                                               : SL_ATLAS_FRONT;
}

static bool is_looked_up(const sl_atlas_canvas *canvas, uint8_t side) {
    return side != SL_ATLAS_NEITHER && canvas->side[side];
}

static void apply_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const application *a = context;
    const sl_gbuffer *g = a->gbuffer;
    const sl_atlas *atlas = a->canvas->atlas;
    const float *const kd[3] = {g->diffuse_r, g->diffuse_g, g->diffuse_b};
    for (size_t i = row * (size_t)g->width; i < (row + 1) * (size_t)g->width; i++) {
        float s, t, irradiance[4];
        if (!is_looked_up(a->canvas, a->side[i])) continue;
        sl_atlas_point(&atlas->chart[atlas->chart_of[g->id[i]]], sl_gbuffer_position(g, i), &s, &t);
        sl_texture_image_sample(a->canvas->side[a->side[i]], s, t, irradiance);
        for (int k = 0; k < 3; k++) a->out[k][i] = kd[k][i] * (float)(1.0 / SL_PI) * irradiance[k];
    }
}

void sl_atlas_apply(const sl_atlas_canvas *canvas, const sl_gbuffer *gbuffer, const uint8_t *side,
                    unsigned threads, float *const out[3], sl_counters *counters) {
    application a = {canvas, gbuffer, side, out};
    size_t looked_up = 0;
    sl_parallel_for(sl_thread_count(threads), (size_t)gbuffer->height, apply_row, &a);
    for (size_t i = 0; i < (size_t)gbuffer->width * (size_t)gbuffer->height; i++)
        looked_up += is_looked_up(canvas, side[i]);
    sl_count(counters, SL_COUNT_TEXTURE_FETCHES, looked_up); /* one a pixel */
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, looked_up);
}
