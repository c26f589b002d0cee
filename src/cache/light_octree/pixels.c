#include "cache/light_octree/pixels.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "scene/bump.h"
#include "trace/bsdf.h"

#include <string.h>

enum { GUTTER = 2 };

/* ---- the atlas ---- */

sl_status sl_lit_atlas_create(const sl_scene *scene, int size, unsigned threads, sl_lit_atlas **atlas,
                              sl_error *error) {
    sl_atlas_settings settings = {size, GUTTER, 60.0 / 180.0 * SL_PI, threads};
    sl_lit_atlas *a = sl_allocate(1, sizeof *a);
    if (!a) return sl_fail_memory(error, "the atlas");
    sl_status status = sl_atlas_create(scene, &settings, &a->atlas, error);
    if (status == SL_OK) status = sl_atlas_canvas_create(a->atlas, scene, threads, &a->canvas, error);
    if (status != SL_OK) {
        sl_lit_atlas_destroy(a);
        return status;
    }
    *atlas = a;
    return SL_OK;
}

void sl_lit_atlas_destroy(sl_lit_atlas *a) {
    if (!a) return;
    if (a->canvas) sl_atlas_canvas_destroy(a->canvas);
    if (a->atlas) sl_atlas_destroy(a->atlas);
    sl_free(a);
}

size_t sl_lit_atlas_bytes(const sl_lit_atlas *a) {
    return sizeof *a + sl_atlas_bytes(a->atlas) + sl_atlas_canvas_bytes(a->canvas);
}

/* ---- which pixels go which way ---- */

typedef struct {
    uint32_t *id, *material; /* SL_NO_INDEX where pixels are not looked up in the atlas */
    uint32_t *others;        /* the materials of those */
    size_t other_count;
    bool seen[2];            /* sides that the atlas is asked for */
} pixel_ways;

static void forget_ways(pixel_ways *w) {
    sl_free(w->id);
    sl_free(w->material);
    sl_free(w->others);
}

static void leave_to_octree(pixel_ways *w, const sl_gbuffer *g, size_t pixel) {
    if (w->material[pixel] == SL_NO_INDEX) return;
    w->others[pixel] = g->material[pixel];
    w->id[pixel] = w->material[pixel] = SL_NO_INDEX;
    w->other_count++;
}

static sl_status find_ways(const sl_octree_pixels *p, pixel_ways *w, sl_error *error) {
    const sl_gbuffer *g = p->gbuffer;
    size_t pixels = (size_t)g->width * (size_t)g->height;
    uint32_t last = SL_NO_INDEX;
    *w = (pixel_ways){.id = sl_allocate(pixels, sizeof *w->id),
                      .material = sl_allocate(pixels, sizeof *w->material),
                      .others = sl_allocate(pixels, sizeof *w->others)};
    if (!w->id || !w->material || !w->others) return sl_fail_memory(error, "the atlas's pixels");
    memcpy(w->id, g->id, pixels * sizeof *w->id);
    memcpy(w->material, g->material, pixels * sizeof *w->material);
    for (size_t i = 0; i < pixels; i++) w->others[i] = SL_NO_INDEX;
    for (size_t k = 0; p->reflections && k < p->reflections->count; k++)
        leave_to_octree(w, g, p->reflections->pixel[k]);
    for (size_t i = 0; i < pixels; i++) {
        if (w->material[i] == SL_NO_INDEX) continue;
        const sl_material *m = &p->scene->materials[w->material[i]];
        /* they depend on the view, or vary within a texel */
        if (sl_material_is_glossy(m) || sl_material_is_bumpy(m)) leave_to_octree(w, g, i);
        /* a triangle shows one side to a view */
        else if (w->id[i] != last) w->seen[sl_atlas_side_seen(p->scene, g, i)] = true;
        last = w->id[i];
    }
    return SL_OK;
}

/* ---- passes ---- */

static sl_status fill_sides(const sl_octree_pixels *p, const bool seen[2], sl_counters *counters,
                            sl_error *error) {
    sl_status status = SL_OK;
    for (int side = SL_ATLAS_FRONT; side <= SL_ATLAS_BACK && status == SL_OK; side++) {
        if (!seen[side] || p->atlas->filled[side]) continue;
        status = sl_atlas_bake(p->atlas->canvas, (sl_atlas_side)side, p->scene, p->shading, p->threads,
                                      counters, error);
        p->atlas->filled[side] = status == SL_OK;
    }
    return status;
}

static sl_status shade(const sl_octree_pixels *p, const sl_gbuffer *gbuffer, float *const rgb[3],
                       sl_counters *counters, sl_error *error) {
    return sl_octree_shade_gbuffer(p->shading, p->scene, gbuffer, p->eye, p->threads, rgb[0], rgb[1], rgb[2],
                                   counters, error);
}

static sl_status shade_others(const sl_octree_pixels *p, const pixel_ways *w, float *const indirect[3],
                              sl_counters *counters, sl_error *error) {
    size_t pixels = (size_t)p->gbuffer->width * (size_t)p->gbuffer->height;
    float *planes = sl_allocate(3 * pixels, sizeof *planes);
    if (!planes) return sl_fail_memory(error, "the octree's pixels");
    float *const rgb[3] = {planes, planes + pixels, planes + 2 * pixels};
    sl_gbuffer others = *p->gbuffer;
    others.material = w->others;
    sl_status status = shade(p, &others, rgb, counters, error);
    for (size_t c = 0; c < 3 && status == SL_OK; c++) {
        for (size_t i = 0; i < pixels; i++) {
            if (w->others[i] != SL_NO_INDEX) indirect[c][i] = rgb[c][i];
        }
    }
    sl_free(planes);
    return status;
}

static sl_status light_by_atlas(const sl_octree_pixels *p, const pixel_ways *w, float *const indirect[3],
                                sl_counters *counters, sl_error *error) {
    sl_status status = fill_sides(p, w->seen, counters, error);
    if (status != SL_OK) return status;
    sl_gbuffer looked_up = *p->gbuffer;
    looked_up.id = w->id;
    looked_up.material = w->material;
    status = sl_atlas_apply(p->atlas->canvas, &looked_up, p->scene, p->threads, indirect[0], indirect[1],
                            indirect[2], counters, error);
    return status == SL_OK && w->other_count ? shade_others(p, w, indirect, counters, error) : status;
}

sl_status sl_octree_light_pixels(const sl_octree_pixels *p, float *const indirect[3], sl_counters *counters,
                                 sl_error *error) {
    if (!p->atlas) return shade(p, p->gbuffer, indirect, counters, error);
    pixel_ways ways;
    sl_status status = find_ways(p, &ways, error);
    if (status == SL_OK) status = light_by_atlas(p, &ways, indirect, counters, error);
    forget_ways(&ways);
    return status;
}

/* ---- the photon map itself ---- */

static void add(double sum[3], sl_rgb reflected, const sl_lobe_photons *p, size_t i) {
    const float f[3] = {reflected.r, reflected.g, reflected.b};
    for (int c = 0; c < 3; c++) sum[c] += (double)f[c] * (double)p->flux[c][i] * p->inverse_cosine[i];
}

sl_rgb sl_photons_radiance(sl_voxel_lights *lights, unsigned worker, const sl_surface *surface,
                           sl_vec3 to_viewer) {
    sl_voxel_worker *w = &lights->worker[worker];
    if (!lights->tree || sl_material_is_mirror(surface->material)) return sl_grey(0.0f);
    sl_photon_query query = 
        sl_voxel_query(lights, surface->position, surface->geometric_normal, lights->options.radius);
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
    sl_count(&w->counters, SL_COUNT_PHOTONS_GATHERED, gather.found);
    sl_rgb radiance = {(float)(sum[0] * scale), (float)(sum[1] * scale), (float)(sum[2] * scale)};
    return sl_rgb_is_finite(radiance) ? radiance : sl_grey(0.0f);
}

typedef struct pixel_pass {
    const sl_scene *scene;
    const sl_gbuffer *gbuffer;
    sl_voxel_lights *lights;
    float *const *out;
} pixel_pass;

static sl_rgb light_of_pixel(const pixel_pass *pass, unsigned worker, size_t i) {
    const sl_gbuffer *g = pass->gbuffer;
    if (g->material[i] == SL_NO_INDEX) return sl_grey(0.0f);
    sl_vec3 viewer = g->seen_from ? g->seen_from[i] : pass->scene->camera.eye;
    sl_surface s = {.position = sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]),
                    .geometric_normal = sl_v3(g->geometric_x[i], g->geometric_y[i], g->geometric_z[i]),
                    .normal = sl_v3(g->normal_x[i], g->normal_y[i], g->normal_z[i]),
                    .diffuse = {g->diffuse_r[i], g->diffuse_g[i], g->diffuse_b[i]},
                    .material = &pass->scene->materials[g->material[i]],
                    .front = true};
    return sl_photons_radiance(pass->lights, worker, &s,
                               sl_normalize_or(sl_sub(viewer, s.position), s.geometric_normal));
}

static void light_row(void *context, size_t row, unsigned worker) {
    const pixel_pass *pass = context;
    size_t width = (size_t)pass->gbuffer->width;
    for (size_t i = row * width; i < (row + 1) * width; i++) {
        sl_rgb radiance = light_of_pixel(pass, worker, i);
        pass->out[0][i] = radiance.r;
        pass->out[1][i] = radiance.g;
        pass->out[2][i] = radiance.b;
    }
}

void sl_photons_light_pixels(const sl_scene *scene, const sl_gbuffer *gbuffer, sl_voxel_lights *lights,
                             unsigned threads, float *const indirect[3], sl_counters *counters) {
    pixel_pass pass = {scene, gbuffer, lights, indirect};
    threads = sl_thread_count(threads);
    if (threads > lights->workers) threads = lights->workers;
    sl_parallel_for(threads, (size_t)gbuffer->height, light_row, &pass);
    sl_voxel_lights_count(lights, counters);
}
