/* Readies a picture's surfaces for light: kinds of surfaces, and tiles of them in lanes (passes 5 and 6). */
#include "base/counters.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/direct_radiance/receivers.h"

#include <string.h>

/* ---- filling ---- */

/* Fills the lanes from the tile's count and pixels; not what glossy receivers have besides. */
static void fetch(const sl_gbuffer *g, sl_isa isa, sl_receiver_tile *t) {
    const float *const from[SL_TILE_PLANES] = {g->position_x,  g->position_y,  g->position_z, g->geometric_x,
                                               g->geometric_y, g->geometric_z, g->normal_x,   g->normal_y,
                                               g->normal_z,    g->diffuse_r,   g->diffuse_g,  g->diffuse_b};
    float *const to[SL_TILE_PLANES] = {t->x,           t->y,           t->z,          t->geometric_x,
                                       t->geometric_y, t->geometric_z, t->normal_x,   t->normal_y,
                                       t->normal_z,    t->diffuse[0],  t->diffuse[1], t->diffuse[2]};
    t->padded = (t->count + SL_TILE_LANES - 1) / SL_TILE_LANES * SL_TILE_LANES;
    for (size_t i = 0; i < t->count; i++) t->triangle[i] = g->id[t->pixel[i]];
    for (int k = 0; k < SL_TILE_PLANES; k++) {
        for (size_t i = 0; i < t->count; i++) to[k][i] = from[k][t->pixel[i]];
        for (size_t i = t->count; i < t->padded; i++) to[k][i] = 0.0f;
    }
    SL_KERNEL_OF(isa, sl_receivers_prepare)(t);
}

static void set_lobes(const sl_gbuffer *g, const sl_scene *scene, sl_isa isa,
                      sl_receiver_tile *t) {
    for (size_t i = 0; i < t->padded; i++) {
        size_t pixel = t->pixel[i < t->count ? i : 0];
        const sl_material *m = &scene->materials[g->material[pixel]];
        sl_vec3 eye = sl_gbuffer_seen_from(g, scene->camera.eye, pixel);
        float scale = (m->exponent + 2.0f) * (float)(0.5 / SL_PI);
        t->mirrored_x[i] = eye.x, t->mirrored_y[i] = eye.y, t->mirrored_z[i] = eye.z;
        t->exponent[i] = m->exponent;
        t->specular[0][i] = m->specular.r * scale;
        t->specular[1][i] = m->specular.g * scale;
        t->specular[2][i] = m->specular.b * scale;
    }
    SL_KERNEL_OF(isa, sl_receiver_mirror_eye)(t);
}

static void fill(const sl_gbuffer *g, const sl_scene *scene, sl_isa isa, bool glossy,
                 sl_receiver_tile *t) {
    fetch(g, isa, t);
    if (glossy) set_lobes(g, scene, isa, t);
}

/* ---- which pixels receive ---- */

static sl_receiver_kind kind_of(const sl_scene *scene, uint32_t material) {
    if (material >= scene->material_count) return SL_RECEIVER_NONE;
    if (sl_material_is_glossy(&scene->materials[material])) return SL_RECEIVER_GLOSSY;
    return sl_material_is_diffuse(&scene->materials[material]) ? SL_RECEIVER_DIFFUSE : SL_RECEIVER_NONE;
}

bool sl_receiver_tile_of_pixel(const sl_scene *scene, const sl_gbuffer *g, size_t pixel, bool *glossy,
                               sl_receiver_tile *t) {
    const sl_isa isa = sl_isa_best();
    const sl_receiver_kind kind = kind_of(scene, g->material[pixel]);
    *glossy = kind == SL_RECEIVER_GLOSSY;
    t->count = 1;
    t->pixel[0] = (uint32_t)pixel;
    if (kind != SL_RECEIVER_NONE) fill(g, scene, isa, *glossy, t);
    return kind != SL_RECEIVER_NONE;
}

/* A tile's pixels by kind. */
typedef struct {
    size_t count[SL_RECEIVER_KINDS];
    uint32_t pixel[SL_RECEIVER_KINDS][SL_TILE_PIXELS];
} tile_pixels;

static void list_pixels(const sl_scene *scene, const sl_gbuffer *g, int x0, int y0, tile_pixels *list) {
    const int x1 = x0 + SL_TILE_WIDTH < g->width ? x0 + SL_TILE_WIDTH : g->width;
    const int y1 = y0 + SL_TILE_HEIGHT < g->height ? y0 + SL_TILE_HEIGHT : g->height;
    uint32_t material = SL_NO_INDEX;
    sl_receiver_kind kind = SL_RECEIVER_NONE;
    memset(list->count, 0, sizeof list->count);
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            const size_t pixel = (size_t)y * (size_t)g->width + (size_t)x;
            if (g->material[pixel] != material) kind = kind_of(scene, material = g->material[pixel]);
            list->pixel[kind][list->count[kind]++] = (uint32_t)pixel;
        }
    }
}

sl_light_points sl_receiver_tile_points(const sl_receiver_tile *t) {
    return (sl_light_points){t->padded,      t->x,           t->y,        t->z,        t->geometric_x,
                             t->geometric_y, t->geometric_z, t->normal_x, t->normal_y, t->normal_z};
}

/* ---- all tiles ---- */

/* Passes 6 and 7, of which each counts the fragments that it shades. */
static void light_tile(const sl_direct_light *direct, const sl_photon_sums *sums,
                       const sl_receiver_tile *tile, bool glossy, const sl_tile_target *to,
                       sl_counters *counters) {
    if (direct) sl_direct_light_tile(direct, tile, glossy, to, counters);
    if (sums) sl_indirect_light_tile(sums, tile, glossy, to, counters);
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, tile->count * (direct && sums ? 2 : 1));
}

void sl_light_strip(const sl_direct_light *direct, const sl_photon_sums *sums, const sl_scene *scene,
                    const sl_gbuffer *g, int y0, const sl_tile_target *to, sl_counters *counters) {
    const sl_isa isa = sl_isa_best();
    tile_pixels list;
    sl_receiver_tile tile;
    for (int x = 0; x < g->width; x += SL_TILE_WIDTH) {
        list_pixels(scene, g, x, y0, &list);
        for (int kind = SL_RECEIVER_DIFFUSE; kind <= SL_RECEIVER_GLOSSY; kind++) {
            tile.count = list.count[kind];
            if (tile.count == 0) continue;
            memcpy(tile.pixel, list.pixel[kind], tile.count * sizeof *tile.pixel);
            fill(g, scene, isa, kind == SL_RECEIVER_GLOSSY, &tile);
            light_tile(direct, sums, &tile, kind == SL_RECEIVER_GLOSSY, to, counters);
        }
    }
}
