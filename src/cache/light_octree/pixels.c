#include "cache/light_octree/pixels.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "scene/bump.h"

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
        status = sl_atlas_bake_octree(p->atlas->canvas, (sl_atlas_side)side, p->scene, p->shading, p->threads,
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
