/* What a picture shows, ready to be lit: kinds of surfaces, and tiles of them in lanes (passes 5 and 6). */
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "cache/direct_radiance/receivers.h"

/* ---- kinds ---- */

sl_status sl_receiver_kinds_find(const sl_scene *scene, sl_receiver_kinds *kinds, sl_error *error) {
    *kinds = (sl_receiver_kinds){.scene = scene};
    kinds->of_material = sl_allocate(scene->material_count + 1, sizeof *kinds->of_material);
    if (!kinds->of_material) return sl_fail_memory(error, "kinds of receivers");
    for (size_t m = 0; m < scene->material_count; m++) {
        const bool glossy = sl_material_is_glossy(&scene->materials[m]);
        kinds->of_material[m] = glossy                                        ? SL_RECEIVER_GLOSSY
                                : sl_material_is_diffuse(&scene->materials[m]) ? SL_RECEIVER_DIFFUSE
                                                                               : SL_RECEIVER_NONE;
        kinds->glossy |= glossy;
    }
    kinds->of_material[scene->material_count] = SL_RECEIVER_NONE;
    return SL_OK;
}

void sl_receiver_kinds_release(sl_receiver_kinds *kinds) {
    sl_free(kinds->of_material);
    kinds->of_material = NULL;
}

static sl_receiver_kind kind_at(const sl_receiver_kinds *kinds, const sl_gbuffer *g, size_t pixel) {
    size_t material = g->material[pixel], none = kinds->scene->material_count;
    return (sl_receiver_kind)kinds->of_material[material < none ? material : none];
}

/* ---- filling ---- */

void sl_receiver_tile_fetch(const sl_gbuffer *g, const sl_receiver_kernels *kernels, sl_receiver_tile *t) {
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
    kernels->prepare(t);
}

static void set_lobes(const sl_gbuffer *g, const sl_scene *scene, const sl_receiver_kernels *kernels,
                      sl_receiver_tile *t) {
    for (size_t i = 0; i < t->padded; i++) {
        size_t pixel = t->pixel[i < t->count ? i : 0];
        const sl_material *m = &scene->materials[g->material[pixel]];
        sl_vec3 eye = g->seen_from ? g->seen_from[pixel] : scene->camera.eye;
        float scale = (m->exponent + 2.0f) * (float)(0.5 / SL_PI);
        t->mirrored_x[i] = eye.x, t->mirrored_y[i] = eye.y, t->mirrored_z[i] = eye.z;
        t->exponent[i] = m->exponent;
        t->specular[0][i] = m->specular.r * scale;
        t->specular[1][i] = m->specular.g * scale;
        t->specular[2][i] = m->specular.b * scale;
    }
    kernels->mirror_eye(t);
}

static bool receives(sl_receiver_kind kind, bool glossy) {
    return kind == (glossy ? SL_RECEIVER_GLOSSY : SL_RECEIVER_DIFFUSE);
}

static void list_wanted(const sl_gbuffer *g, const sl_receiver_kinds *kinds, bool glossy, int x0, int y0,
                        sl_receiver_tile *t) {
    const int x1 = x0 + SL_TILE_WIDTH < g->width ? x0 + SL_TILE_WIDTH : g->width;
    const int y1 = y0 + SL_TILE_HEIGHT < g->height ? y0 + SL_TILE_HEIGHT : g->height;
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            size_t pixel = (size_t)y * (size_t)g->width + (size_t)x;
            t->pixel[t->count] = (uint32_t)pixel;
            t->count += receives(kind_at(kinds, g, pixel), glossy) ? 1 : 0;
        }
    }
}

static void fill_tile(const sl_gbuffer *g, const sl_receiver_kinds *kinds, const sl_receiver_kernels *kernels,
                      bool glossy, int x0, int y0, sl_receiver_tile *t) {
    t->count = 0;
    list_wanted(g, kinds, glossy, x0, y0, t);
    if (t->count == 0) return;
    sl_receiver_tile_fetch(g, kernels, t);
    if (glossy) set_lobes(g, kinds->scene, kernels, t);
}

sl_light_points sl_receiver_tile_points(const sl_receiver_tile *t) {
    return (sl_light_points){t->padded,      t->x,           t->y,        t->z,        t->geometric_x,
                             t->geometric_y, t->geometric_z, t->normal_x, t->normal_y, t->normal_z};
}

/* ---- all tiles ---- */

void sl_receiver_tiles_strip(const sl_gbuffer *g, const sl_receiver_kinds *kinds, int y0,
                             sl_tile_program *program, void *context, sl_counters *counters) {
    const sl_receiver_kernels kernels = sl_receiver_kernels_for(sl_isa_best());
    sl_receiver_tile tile;
    for (int x = 0; x < g->width; x += SL_TILE_WIDTH) {
        for (int glossy = 0; glossy <= (kinds->glossy ? 1 : 0); glossy++) {
            fill_tile(g, kinds, &kernels, glossy, x, y0, &tile);
            if (tile.count == 0) continue;
            program(context, &tile, glossy, counters);
            sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, tile.count);
        }
    }
}
