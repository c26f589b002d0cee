/* Step 6 of Algorithm 2: means of E' and of the reflected radiance, filled where nothing reached, times
 * albedo / pi and ks, plus direct light and emission. */
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/splatting/state.h"

const char *const sl_layer_names[SL_LAYERS_GLOSSY] = {
    "R",        "G",         "B",        "emission.R", "emission.G", "emission.B",
    "direct.R", "direct.G",  "direct.B", "indirect.R", "indirect.G", "indirect.B",
    "weight.Y", "records.Y", "glossy.R", "glossy.G",   "glossy.B"};

enum { DIRECT = 6, INDIRECT = 9, WEIGHT = 12, RECORDS = 13, GLOSSY = 14, MEANS = 6 };

typedef struct {
    const sl_splat_state *state;
    float *mean; /* planes of irradiance, then of reflected radiance per unit ks; bottom row first */
    sl_image *image;
} composing;

static size_t width_of(const composing *c) { return (size_t)c->state->settings.width; }

static sl_pixel_run shown(const composing *c, size_t first, size_t end) {
    return sl_sub_frame_run(&c->state->scene->sub_frame, first, end);
}

/* ---- means ---- */

static size_t mean_count(const sl_splat_state *s) { return s->splats.glossy[0] ? MEANS : 3; }

static void average_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const composing *c = context;
    const sl_splat_buffer *b = &c->state->splats;
    const float *sums[MEANS] = {b->r, b->g, b->b, b->glossy[0], b->glossy[1], b->glossy[2]};
    const size_t pixels = sl_splat_pixels(c->state), end = (row + 1) * width_of(c);
    for (sl_pixel_run r = shown(c, row * width_of(c), end); r.first < r.end; r = shown(c, r.end, end)) {
        for (size_t k = 0; k < mean_count(c->state); k++) {
            for (size_t i = r.first; i < r.end; i++)
                c->mean[k * pixels + i] = b->weight[i] > 0.0f ? sums[k][i] / b->weight[i] : 0.0f;
        }
    }
}

static sl_status fill(const sl_splat_state *s, float *mean, sl_error *error) {
    const size_t pixels = sl_splat_pixels(s);
    sl_status status = SL_OK;
    for (int class = 0; class < SL_RECEIVER_CLASSES; class++) {
        const uint32_t *mine = s->cache[class].receives;
        for (size_t k = 0; mine && status == SL_OK && k < (class == SL_RECEIVES_RADIANCE ? MEANS : 3); k += 3)
            status = sl_fill_uncovered(
                s->settings.width, s->settings.height, s->splats.weight, mine, s->settings.threads,
                (float *[3]){mean + k * pixels, mean + (k + 1) * pixels, mean + (k + 2) * pixels}, error);
    }
    return status;
}

/* ---- what pixels reflect of them ---- */

static bool receives(const sl_splat_state *s, sl_receiver_class class, size_t i) {
    return s->cache[class].receives && s->cache[class].receives[i];
}

/* In place. A lobe of finite order rings below 0. */
static void reflect(const composing *c, size_t i) {
    const sl_splat_state *s = c->state;
    const sl_gbuffer *g = s->gbuffer;
    const size_t pixels = sl_splat_pixels(s);
    const bool glossy = receives(s, SL_RECEIVES_RADIANCE, i),
               diffuse = glossy || receives(s, SL_RECEIVES_IRRADIANCE, i);
    const sl_rgb ks = glossy ? s->scene->materials[g->material[i]].specular : sl_grey(0.0f);
    const float specular[3] = {ks.r, ks.g, ks.b},
                albedo[3] = {g->diffuse_r[i], g->diffuse_g[i], g->diffuse_b[i]};
    for (size_t k = 0; k < 3; k++) {
        float *irradiance = &c->mean[k * pixels + i];
        *irradiance = diffuse ? *irradiance * (albedo[k] * (float)(1.0 / SL_PI)) : 0.0f;
        if (mean_count(s) < MEANS) continue;
        float *lobe = &c->mean[(3 + k) * pixels + i];
        *lobe = glossy && *lobe > 0.0f ? *lobe * specular[k] : 0.0f;
    }
}

static void reflect_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const composing *c = context;
    const sl_splat_buffer *b = &c->state->splats;
    const size_t width = width_of(c), pixels = sl_splat_pixels(c->state), from = row * width,
                 to = pixels - from - width; /* images have row 0 at the top */
    for (sl_pixel_run r = shown(c, from, from + width); r.first < r.end; r = shown(c, r.end, from + width)) {
        for (size_t i = r.first; i < r.end; i++) reflect(c, i);
    }
    if (c->image->channels <= WEIGHT) return;
    memcpy(c->image->planes + WEIGHT * pixels + to, b->weight + from, width * sizeof *b->weight);
    memcpy(c->image->planes + RECORDS * pixels + to, b->count + from, width * sizeof *b->count);
}

/* ---- the picture ---- */

static void compose(const composing *c) {
    const sl_splat_state *s = c->state;
    const size_t pixels = sl_splat_pixels(s);
    const float *mean = c->mean, *lobe = mean + 3 * pixels;
    const sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    sl_composition composition = {
        .scene = s->scene, .view = &view, .gbuffer = s->gbuffer, .reflections = s->reflections,
        .layer = {{{s->direct_light[0], s->direct_light[1], s->direct_light[2]}, DIRECT},
                  {{mean, mean + pixels, mean + 2 * pixels}, INDIRECT}},
        .image = c->image};
    if (mean_count(s) == MEANS)
        composition.layer[2] = (sl_light_layer){{lobe, lobe + pixels, lobe + 2 * pixels}, GLOSSY};
    sl_compose_picture(&composition, s->settings.threads);
}

sl_status sl_splat_compose(const sl_splat_state *s, sl_image *image, sl_error *error) {
    const size_t rows = (size_t)s->settings.height;
    composing c = {s, sl_allocate_unset(mean_count(s) * sl_splat_pixels(s), sizeof *c.mean), image};
    if (!c.mean) return sl_fail_memory(error, "the picture");
    sl_parallel_for(s->settings.threads, rows, average_row, &c);
    sl_status status = fill(s, c.mean, error);
    if (status == SL_OK) {
        sl_parallel_for(s->settings.threads, rows, reflect_row, &c);
        compose(&c);
    }
    sl_free(c.mean);
    return status;
}
