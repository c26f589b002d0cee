#include "cache/light_octree/pixels.h"

#include <string.h>

#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "scene/bump.h"
#include "trace/bsdf.h"

/* ---- from the octree ---- */

enum { TILE = 64, TILE_PIXELS = TILE * TILE };
static const uint32_t QUAD = UINT32_C(1) << 31;

typedef struct listed_pixels {
    const sl_octree_pixels *pixels;
    /* those that the octree lights, tile by tile, so that neighbours share their voxels; QUAD: the lower left
     * of four that share a point */
    uint32_t *list;
    size_t count;
    uint32_t *listed;    /* of each tile */
    size_t across;       /* tiles side by side */
    const uint8_t *side; /* of the atlas; NULL: no atlas */
    float *const *out;
} listed_pixels;

sl_octree_point sl_octree_point_of_pixel(const sl_scene *scene, const sl_gbuffer *g, sl_vec3 eye,
                                         size_t pixel) {
    const sl_material *m = &scene->materials[g->material[pixel]];
    sl_vec3 place = sl_gbuffer_position(g, pixel);
    sl_vec3 n = sl_gbuffer_normal(g, pixel);
    sl_vec3 view = n;
    if (sl_material_is_glossy(m))
        view = sl_normalize_or(sl_sub(sl_gbuffer_seen_from(g, eye, pixel), place), n);
    return (sl_octree_point){.position = place,
                             .normal = n,
                             .view = view,
                             .diffuse = {g->diffuse_r[pixel], g->diffuse_g[pixel], g->diffuse_b[pixel]},
                             .specular = m->specular,
                             .exponent = m->exponent};
}

static bool is_lit(const sl_octree_pixels *p, const uint8_t *side, size_t pixel) {
    const uint32_t material = p->gbuffer->material[pixel];
    if (material == SL_NO_INDEX || (side && side[pixel] != SL_ATLAS_NEITHER)) return false;
    return !sl_material_is_mirror(&p->scene->materials[material]);
}

/* Light differs from voxel to voxel: four pixels may share it that lie within half of one. */
static bool is_quad(const sl_octree_pixels *p, const uint8_t *side, size_t pixel) {
    const float most = (float)(0.5 / p->shading->texture->scale);
    const sl_gbuffer *g = p->gbuffer;
    const uint32_t *low = g->id + pixel, *high = low + g->width, material = g->material[pixel];
    if (low[1] != low[0] || high[0] != low[0] || high[1] != low[0] || !is_lit(p, side, pixel) ||
        sl_material_is_glossy(&p->scene->materials[material]))
        return false;
    const sl_vec3 across = sl_sub(sl_gbuffer_position(g, pixel + (size_t)g->width + 1),
                                  sl_gbuffer_position(g, pixel));
    return sl_dot(across, across) < most * most;
}

static size_t tiles_of(int extent) { return ((size_t)extent + TILE - 1) / TILE; }

/* Those of one tile. */
typedef struct tile_list {
    const sl_octree_pixels *pixels;
    const uint8_t *side;
    uint32_t *pixel;
    uint32_t count;
} tile_list;

static void list_pixel(tile_list *l, size_t pixel) {
    if (is_lit(l->pixels, l->side, pixel)) l->pixel[l->count++] = (uint32_t)pixel;
}

static void list_quads(tile_list *l, int x0, int y0, int x1, int y1) {
    const size_t width = (size_t)l->pixels->gbuffer->width;
    for (int y = y0; y < y1; y += 2) {
        for (int x = x0; x < x1; x += 2) {
            const size_t pixel = (size_t)y * width + (size_t)x;
            if (x + 1 < x1 && y + 1 < y1 && is_quad(l->pixels, l->side, pixel)) {
                l->pixel[l->count++] = (uint32_t)pixel | QUAD;
                continue;
            }
            for (int k = 0; k < 4; k++)
                if (x + k % 2 < x1 && y + k / 2 < y1)
                    list_pixel(l, pixel + (size_t)(k % 2) + (size_t)(k / 2) * width);
        }
    }
}

static void list_rows(tile_list *l, int x0, int y0, int x1, int y1) {
    const sl_sub_frame *at = &l->pixels->scene->sub_frame;
    for (int y = y0; y < y1; y++) {
        const size_t row = (size_t)y * (size_t)l->pixels->gbuffer->width, end = row + (size_t)x1;
        for (sl_pixel_run r = sl_sub_frame_run(at, row + (size_t)x0, end); r.first < r.end;
             r = sl_sub_frame_run(at, r.end, end))
            for (size_t pixel = r.first; pixel < r.end; pixel++) list_pixel(l, pixel);
    }
}

static void list_tile(void *context, size_t tile, unsigned worker) {
    (void)worker;
    listed_pixels *l = context;
    const sl_gbuffer *g = l->pixels->gbuffer;
    const int x0 = (int)(tile % l->across) * TILE, y0 = (int)(tile / l->across) * TILE,
              x1 = x0 + TILE < g->width ? x0 + TILE : g->width,
              y1 = y0 + TILE < g->height ? y0 + TILE : g->height;
    tile_list list = {l->pixels, l->side, l->list + tile * TILE_PIXELS, 0};
    if (l->pixels->moves) list_quads(&list, x0, y0, x1, y1);
    else list_rows(&list, x0, y0, x1, y1);
    l->listed[tile] = list.count;
}

/* Lists all, one tile behind another. */
static void list_pixels(listed_pixels *l, size_t tiles) {
    sl_parallel_for(l->pixels->threads, tiles, list_tile, l);
    for (size_t tile = 0; tile < tiles; tile++) {
        memmove(l->list + l->count, l->list + tile * TILE_PIXELS, l->listed[tile] * sizeof *l->list);
        l->count += l->listed[tile];
    }
}

/* The middle of four; its irradiance is asked for. */
static sl_octree_point point_of_quad(const sl_gbuffer *g, size_t pixel) {
    const size_t other = pixel + (size_t)g->width + 1;
    const sl_vec3 normal = sl_gbuffer_normal(g, pixel);
    return (sl_octree_point){
        .position = sl_scale(sl_add(sl_gbuffer_position(g, pixel), sl_gbuffer_position(g, other)), 0.5f),
        .normal = sl_normalize_or(sl_add(normal, sl_gbuffer_normal(g, other)), normal),
        .diffuse = sl_grey((float)SL_PI)};
}

static bool find_pixel(const void *context, size_t index, sl_octree_point *point) {
    const listed_pixels *l = context;
    const sl_octree_pixels *p = l->pixels;
    const uint32_t pixel = l->list[index];
    *point = pixel & QUAD ? point_of_quad(p->gbuffer, pixel & ~QUAD)
                          : sl_octree_point_of_pixel(p->scene, p->gbuffer, p->eye, pixel);
    return true;
}

static void put_pixel(void *context, size_t index, const float rgb[3]) {
    const listed_pixels *l = context;
    const sl_gbuffer *g = l->pixels->gbuffer;
    const float *diffuse[3] = {g->diffuse_r, g->diffuse_g, g->diffuse_b};
    const size_t pixel = l->list[index] & ~QUAD, quad[4] = {pixel, pixel + 1, pixel + (size_t)g->width,
                                                            pixel + (size_t)g->width + 1};
    for (int c = 0; c < 3; c++) {
        if (!(l->list[index] & QUAD)) l->out[c][pixel] = rgb[c];
        else
            for (int k = 0; k < 4; k++)
                l->out[c][quad[k]] = diffuse[c][quad[k]] * (float)(1.0 / SL_PI) * rgb[c];
    }
}

static sl_status shade_pixels(const sl_octree_pixels *p, const uint8_t *side, float *const out[3],
                              sl_counters *counters, sl_error *error) {
    listed_pixels l = {.pixels = p, .across = tiles_of(p->gbuffer->width), .side = side, .out = out};
    const size_t tiles = l.across * tiles_of(p->gbuffer->height);
    l.list = sl_allocate_unset(tiles * TILE_PIXELS, sizeof *l.list);
    l.listed = sl_allocate_unset(tiles, sizeof *l.listed);
    sl_status status = SL_OK;
    if (l.list && l.listed) {
        list_pixels(&l, tiles);
        const sl_octree_points points = {l.count, find_pixel, put_pixel, &l};
        status = sl_octree_shade(p->shading, &points, p->threads, counters, error);
    } else status = sl_fail_memory(error, "the octree's pixels");
    sl_free(l.listed);
    sl_free(l.list);
    return status;
}

/* ---- by way of the atlas, but for what depends on the view, or varies within a texel ---- */

static void find_sides(const sl_octree_pixels *p, size_t pixels, uint8_t *side) {
    const sl_gbuffer *g = p->gbuffer;
    for (size_t i = 0; i < pixels; i++) {
        const sl_material *m = g->material[i] != SL_NO_INDEX ? &p->scene->materials[g->material[i]] : NULL;
        bool looked_up =
            m && !sl_material_is_mirror(m) && !sl_material_is_glossy(m) && !sl_material_is_bumpy(m);
        side[i] = looked_up ? (uint8_t)sl_atlas_side_seen(p->scene, g, i) : SL_ATLAS_NEITHER;
    }
    for (size_t k = 0; p->reflections && k < p->reflections->count; k++)
        side[p->reflections->pixel[k]] = SL_ATLAS_NEITHER;
}

static sl_status light_by_atlas(const sl_octree_pixels *p, size_t pixels, float *const indirect[3],
                                sl_counters *counters, sl_error *error) {
    uint8_t *side = sl_allocate(pixels, sizeof *side);
    if (!side) return sl_fail_memory(error, "the atlas's pixels");
    sl_status status = SL_OK;
    find_sides(p, pixels, side);
    for (int s = SL_ATLAS_FRONT; s <= SL_ATLAS_BACK && status == SL_OK; s++) {
        if (!p->canvas->filled[s] && memchr(side, s, pixels))
            status = sl_atlas_bake(p->canvas, (sl_atlas_side)s, p->scene, p->shading, p->threads, counters,
                                   error);
    }
    if (status == SL_OK)
        sl_atlas_apply(p->canvas, p->gbuffer, side, p->threads, indirect, counters);
    if (status == SL_OK) status = shade_pixels(p, side, indirect, counters, error);
    sl_free(side);
    return status;
}

sl_status sl_octree_light_pixels(const sl_octree_pixels *p, float *const indirect[3], sl_counters *counters,
                                 sl_error *error) {
    size_t pixels = (size_t)p->gbuffer->width * (size_t)p->gbuffer->height;
    for (int c = 0; c < 3; c++) sl_sub_frame_clear(&p->scene->sub_frame, p->threads, indirect[c], 1, pixels);
    return p->canvas ? light_by_atlas(p, pixels, indirect, counters, error)
                     : shade_pixels(p, NULL, indirect, counters, error);
}

/* ---- the photon map itself ---- */

static void add(double sum[3], sl_rgb reflected, const sl_lobe_photons *p, size_t i) {
    const float f[3] = {reflected.r, reflected.g, reflected.b};
    for (int c = 0; c < 3; c++) sum[c] += (double)f[c] * (double)p->flux[c][i] * p->inverse_cosine[i];
}

sl_rgb sl_photons_radiance(sl_voxel_lights *lights, unsigned worker, const sl_surface *surface,
                           sl_vec3 to_viewer, sl_counters *counters) {
    sl_voxel_worker *w = &lights->worker[worker];
    if (!lights->tree || sl_material_is_mirror(surface->material)) return sl_grey(0.0f);
    sl_photon_query query = sl_voxel_query(lights, surface->position, surface->geometric_normal);
    query.both_sides = false;
    sl_voxel_gather gather = sl_voxel_gather_photons(lights, &query, w);
    sl_bsdf bsdf = sl_bsdf_make(surface, to_viewer, SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY);
    const sl_lobe_photons *p = &gather.side[0];
    double sum[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < p->count; i++) {
        sl_vec3 to_light = sl_v3(p->x[i], p->y[i], p->z[i]);
        add(sum, sl_bsdf_reflect(&bsdf, to_light, SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY), p, i);
    }
    double area = sl_voxel_areas(lights, &gather, w).side[0], scale = area > 0.0 ? gather.kappa / area : 0.0;
    sl_count(counters, SL_COUNT_PHOTONS_GATHERED, gather.found);
    sl_rgb radiance = {(float)(sum[0] * scale), (float)(sum[1] * scale), (float)(sum[2] * scale)};
    return sl_rgb_is_finite(radiance) ? radiance : sl_grey(0.0f);
}

typedef struct pixel_pass {
    const sl_scene *scene;
    const sl_gbuffer *gbuffer;
    sl_voxel_lights *lights;
    float *const *out;
} pixel_pass;

static sl_rgb light_of_pixel(const pixel_pass *pass, unsigned worker, size_t i, sl_counters *counters) {
    const sl_gbuffer *g = pass->gbuffer;
    if (g->material[i] == SL_NO_INDEX) return sl_grey(0.0f);
    sl_vec3 viewer = sl_gbuffer_seen_from(g, pass->scene->camera.eye, i);
    sl_surface s = sl_gbuffer_surface(pass->scene, g, i);
    return sl_photons_radiance(pass->lights, worker, &s,
                               sl_normalize_or(sl_sub(viewer, s.position), s.geometric_normal), counters);
}

static void light_row(void *context, size_t row, unsigned worker, void *result, sl_counters *counters) {
    (void)result;
    const pixel_pass *pass = context;
    size_t width = (size_t)pass->gbuffer->width;
    for (size_t i = row * width; i < (row + 1) * width; i++) {
        sl_rgb radiance = light_of_pixel(pass, worker, i, counters);
        pass->out[0][i] = radiance.r;
        pass->out[1][i] = radiance.g;
        pass->out[2][i] = radiance.b;
    }
}

void sl_photons_light_pixels(const sl_scene *scene, const sl_gbuffer *gbuffer, sl_voxel_lights *lights,
                             unsigned threads, float *const indirect[3], sl_counters *counters) {
    pixel_pass pass = {scene, gbuffer, lights, indirect};
    const size_t row = (size_t)gbuffer->width * sizeof(float);
    const sl_batch_plane planes[] = {{indirect[0], row}, {indirect[1], row}, {indirect[2], row}};
    const sl_batch batch = {.count = (size_t)gbuffer->height, .work = light_row, .context = &pass,
                            .shared = true, .planes = planes, .plane_count = 3};
    threads = sl_thread_count(threads);
    sl_batch_run(&batch, threads < lights->workers ? threads : lights->workers, counters);
}
