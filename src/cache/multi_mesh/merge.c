/* Image pass 2: the materials that a view shows, whatever the light; and image pass 4, which merges them with
 * the pictures of the meshes: L = k_d (U_dd + E_i / pi) + k_s U_ds + L_e. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/math.h"
#include "base/parallel.h"
#include "cache/frame/picture_value.h"

#include <string.h>

/* ---- image pass 2 ---- */

typedef struct resolving {
    const sl_multi_mesh_state *s;
    const sl_view *view;
} resolving;

static void put(float *const planes[3], size_t pixel, sl_rgb colour) {
    planes[0][pixel] = colour.r;
    planes[1][pixel] = colour.g;
    planes[2][pixel] = colour.b;
}

static void resolve_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const resolving *r = context;
    const sl_materials_seen *m = &r->s->materials;
    const sl_scene *scene = r->s->scene;
    size_t width = (size_t)r->view->width;
    sl_rgb emission = sl_grey(0.0f);
    for (size_t column = 0; column < width; column++) {
        size_t pixel = row * width + column;
        uint32_t triangle = r->s->id[pixel];
        if (m->specular[0] && triangle != SL_NO_INDEX)
            put(m->specular, pixel, sl_triangle_material(scene, triangle)->specular);
        if (!m->emission[0]) continue;
        /* At all of a triangle's points the eye sees the same side. */
        if (!column || triangle == SL_NO_INDEX || triangle != r->s->id[pixel - 1])
            emission = sl_view_emission(r->view, scene, triangle, column, row);
        put(m->emission, pixel, emission);
    }
}

/* Tells whether any visible face needs a pass. A pass that no visible face needs is skipped. */
static bool shows(const sl_multi_mesh_state *s, bool (*has)(const sl_material *)) {
    for (size_t f = 0; f < s->visible->face_count; f++)
        if (has(sl_triangle_material(s->scene, s->visible->face[f].face / 2))) return true;
    return false;
}

/* Allocates planes of what materials show; pixels that show nothing are black. */
static bool allocate(const sl_multi_mesh_state *s, sl_materials_seen *m) {
    const size_t pixels = sl_settings_pixels(&s->settings);
    const bool sky = s->scene->environment.present && s->visible->count < pixels,
               specular = s->plan.specular_seen && shows(s, sl_material_is_glossy),
               emission = s->plan.emission && (sky || shows(s, sl_material_is_emitter));
    float *next = m->planes = sl_allocate((3u + (specular ? 3u : 0u) + (emission ? 3u : 0u)) * pixels,
                                          sizeof *m->planes);
    for (int k = 0; k < 3 && next; k++, next += pixels) m->diffuse[k] = next;
    for (int k = 0; k < 3 && next && specular; k++, next += pixels) m->specular[k] = next;
    for (int k = 0; k < 3 && next && emission; k++, next += pixels) m->emission[k] = next;
    return next;
}

static void announce(sl_multi_mesh_state *s, const char *name, const float *planes) {
    const sl_settings *of = &s->settings;
    if (planes) sl_announce(&s->announcer, name, "image pass 2", of->width, of->height, 3, planes, true);
}

sl_status sl_multi_mesh_see_materials(sl_multi_mesh_state *s, const sl_view *view, sl_error *error) {
    sl_materials_seen *m = &s->materials;
    if (!allocate(s, m)) return sl_fail_memory(error, "the material pass");
    sl_gbuffer targets = {.width = view->width, .height = view->height, .id = s->id,
                          .diffuse_r = m->diffuse[0], .diffuse_g = m->diffuse[1], .diffuse_b = m->diffuse[2]};
    sl_status status =
        sl_raster_resolve(s->raster, view, s->settings.threads, &targets, &s->counters, error);
    if (status != SL_OK) {
        sl_multi_mesh_forget_materials(s);
        return status;
    }
    resolving r = {s, view};
    if (m->specular[0] || m->emission[0])
        sl_parallel_for(s->settings.threads, (size_t)view->height, resolve_row, &r);
    announce(s, "material: k_d", m->diffuse[0]);
    announce(s, "material: k_s", m->specular[0]);
    return SL_OK;
}

void sl_multi_mesh_forget_materials(sl_multi_mesh_state *s) {
    sl_free(s->materials.planes);
    s->materials = (sl_materials_seen){.planes = NULL};
}

/* ---- image pass 4 ---- */

enum { PICTURE, DIRECT, SPECULAR, INDIRECT, EMISSION, KD, KS, LAYERS, CHANNELS = 3 * LAYERS };

static const char *const channel_names[CHANNELS] = {
    "R",          "G",          "B",          "direct.R",   "direct.G",   "direct.B",   "specular.R",
    "specular.G", "specular.B", "indirect.R", "indirect.G", "indirect.B", "emission.R", "emission.G",
    "emission.B", "kd.R",       "kd.G",       "kd.B",       "ks.R",       "ks.G",       "ks.B"};

typedef struct merging {
    const sl_multi_mesh_state *s;
    float *out;
} merging;

/* out = a b scale; black, as it is, where the mesh is not in view, or there is no b. */
static void product(const merging *c, sl_component part, size_t k, const float *b, size_t from, float scale,
                    float *out) {
    const float *a = sl_is_in_view(c->s->part[part]) ? c->s->planes[part][k] : NULL;
    const size_t count = (size_t)c->s->settings.width;
    for (size_t i = 0; a && b && i < count; i++)
        out[i] = sl_picture_value(b[from + i] * (a[from + i] * scale));
}

static void copy(const float *plane, size_t from, size_t count, float *to) {
    if (plane) memcpy(to, plane + from, count * sizeof *to);
}

static void merge_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const merging *c = context;
    const sl_materials_seen *m = &c->s->materials;
    size_t width = (size_t)c->s->settings.width, height = (size_t)c->s->settings.height;
    size_t from = row * width, to = (height - 1 - row) * width, pixels = width * height;
    for (size_t k = 0; k < 3; k++) {
        const float *kd = m->diffuse[k], *ks = m->specular[k];
        float *layer[LAYERS];
        for (size_t i = 0; i < LAYERS; i++) layer[i] = c->out + (3 * i + k) * pixels + to;
        float *direct = layer[DIRECT], *highlight = layer[SPECULAR],
              *indirect = layer[INDIRECT], *lamp = layer[EMISSION], *picture = layer[PICTURE];
        product(c, SL_DIRECT_DIFFUSE, k, kd, from, 1.0f, direct);
        product(c, SL_DIRECT_SPECULAR, k, ks, from, 1.0f, highlight);
        product(c, SL_INDIRECT, k, kd, from, (float)(1.0 / SL_PI), indirect);
        copy(m->emission[k], from, width, lamp);
        copy(kd, from, width, layer[KD]);
        copy(ks, from, width, layer[KS]);
        for (size_t i = 0; i < width; i++)
            picture[i] = sl_picture_value(((direct[i] + highlight[i]) + indirect[i]) + lamp[i]);
    }
}

/* Tells of what lobes leave out where enough is seen of it: a twentieth of the picture reflects more by its
 * lobe than by its diffuse part. */
static sl_status warn_of_lobes(const sl_multi_mesh_state *s, sl_image *image, sl_error *error) {
    const sl_materials_seen *m = &s->materials;
    size_t pixels = sl_settings_pixels(&s->settings), glossy = 0;
    for (size_t i = 0; m->specular[0] && i < pixels; i++) {
        float ks = m->specular[0][i] + m->specular[1][i] + m->specular[2][i];
        glossy += ks > m->diffuse[0][i] + m->diffuse[1][i] + m->diffuse[2][i];
    }
    double share = (double)glossy / (double)pixels;
    if (!(share > 0.05)) return SL_OK;
    return sl_warn(
        image, error,
        "%.0f %% of the pixels show gloss, which reflects lamps alone: what surfaces and the sky would "
        "add to it is missing",
        100.0 * share);
}

sl_status sl_multi_mesh_merge(const sl_multi_mesh_state *s, sl_image **image, sl_error *error) {
    sl_status status =
        sl_image_create(s->settings.width, s->settings.height, CHANNELS, channel_names, image, error);
    if (status != SL_OK) return status;
    merging c = {s, (*image)->planes};
    sl_parallel_for(s->settings.threads, (size_t)s->settings.height, merge_row, &c);
    return warn_of_lobes(s, *image, error);
}
