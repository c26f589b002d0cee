#include "cache/hemisphere/glossy_hits.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

bool sl_glossy_hits_wanted(const sl_gather *gather) {
    const sl_scene *scene = gather->scene;
    if (!gather->settings.glossy_hits) return false;
    for (size_t i = 0; i < scene->material_count; i++) {
        if (sl_material_is_glossy(&scene->materials[i])) return true;
    }
    return false;
}

sl_status sl_glossy_hits_create(size_t slots, sl_glossy_hits **out, sl_error *error) {
    sl_glossy_hits *g = *out = sl_allocate(1, sizeof *g);
    if (g) {
        g->specular = sl_allocate(slots, sizeof *g->specular);
        g->radiance = sl_allocate(slots, sizeof *g->radiance);
    }
    if (g && g->specular && g->radiance) return SL_OK;
    sl_glossy_hits_destroy(g);
    *out = NULL;
    return sl_fail_memory(error, "a gather's glossy lobes");
}

void sl_glossy_hits_destroy(sl_glossy_hits *hits) {
    if (!hits) return;
    sl_free(hits->specular);
    sl_free(hits->radiance);
    sl_free(hits);
}

static const sl_material *material_of(const sl_gather_view *view, size_t k) {
    const sl_scene *scene = view->gather->scene;
    return &scene->materials[scene->material_index[view->scratch->hits.triangle[k]]];
}

void sl_glossy_hits_begin(const sl_gather_view *view, size_t first, size_t count) {
    sl_glossy_hits *g = view->scratch->glossy;
    for (size_t k = first; k < first + count; k++) {
        bool hit = view->scratch->hits.triangle[k] != SL_NO_INDEX;
        sl_rgb ks = hit ? material_of(view, k)->specular : sl_grey(0.0f);
        g->specular[k] = ks.r + ks.g + ks.b;
        g->radiance[k] = sl_grey(0.0f);
    }
}

/* ks (n + 2) / (2 pi) cos^n alpha times the irradiance, alpha between the light and the mirror direction of
 * the way to the gather. */
void sl_glossy_hits_add(const sl_gather_view *view, size_t k, sl_vec3 to_light, sl_rgb irradiance) {
    const sl_gather_hits *h = &view->scratch->hits;
    sl_glossy_hits *g = view->scratch->glossy;
    if (!(g->specular[k] > 0.0f)) return;
    const sl_material *m = material_of(view, k);
    sl_vec3 n = sl_v3(h->normal_x[k], h->normal_y[k], h->normal_z[k]);
    sl_vec3 away = sl_v3(h->direction_x[k], h->direction_y[k], h->direction_z[k]);
    sl_vec3 mirrored = sl_normalize_or(sl_sub(away, sl_scale(n, 2.0f * sl_dot(n, away))), n);
    float cosine = sl_dot(mirrored, sl_normalize_or(to_light, n));
    if (!(cosine > 0.0f)) return;
    float lobe =
        (m->exponent + 2.0f) * (float)(0.5 / SL_PI) * sl_powf(cosine < 1.0f ? cosine : 1.0f, m->exponent);
    g->radiance[k].r += m->specular.r * lobe * irradiance.r;
    g->radiance[k].g += m->specular.g * lobe * irradiance.g;
    g->radiance[k].b += m->specular.b * lobe * irradiance.b;
}

/* ---- by shadow maps ---- */

typedef struct {
    const sl_gather_view *view;
    size_t first, count;
} mapped_block;

static void add_light(void *context, const sl_arrivals *arrivals, const float *lit, sl_rgb colour) {
    const mapped_block *b = context;
    for (size_t i = 0; i < b->count; i++) {
        float share = arrivals->weight[i] * lit[i];
        if (share > 0.0f)
            sl_glossy_hits_add(b->view, b->first + i, sl_v3(arrivals->x[i], arrivals->y[i], arrivals->z[i]),
                               sl_rgb_scale(colour, share));
    }
}

void sl_glossy_hits_add_maps(const sl_gather_view *view, const sl_light_points *points, size_t first,
                             unsigned parts, sl_counters *counters) {
    const float *specular = view->scratch->glossy->specular + first;
    mapped_block block = {view, first, points->count};
    bool glossy = false;
    for (size_t i = 0; i < points->count; i++) glossy |= specular[i] > 0.0f;
    if (glossy) sl_shadow_maps_each(view->gather->maps, points, parts, add_light, &block, counters);
}
