/* Step 6 of Algorithm 2: means of E' and of the reflected radiance, filled where nothing reached, times
 * albedo / pi and ks, plus direct light and emission. */
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/frame/picture_value.h"
#include "cache/splatting/state.h"

const char *const sl_layer_names[SL_LAYERS_GLOSSY] = {
    "R",        "G",         "B",        "emission.R", "emission.G", "emission.B",
    "direct.R", "direct.G",  "direct.B", "indirect.R", "indirect.G", "indirect.B",
    "weight.Y", "records.Y", "glossy.R", "glossy.G",   "glossy.B"};

enum {
    PICTURE = 0,
    EMISSION = 3,
    DIRECT = 6,
    INDIRECT = 9,
    WEIGHT = 12,
    RECORDS = 13,
    GLOSSY = 14,
    MEANS = 6
};

typedef struct {
    const sl_splat_state *state;
    sl_view view;
    float *mean; /* planes of irradiance, then of reflected radiance per unit ks; bottom row first */
    float *layers;
} composing;

/* ---- means ---- */

static size_t mean_count(const sl_splat_state *s) { return s->splats.glossy[0] ? MEANS : 3; }

static void average_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const composing *c = context;
    const sl_splat_buffer *b = &c->state->splats;
    const float *sums[MEANS] = {b->r, b->g, b->b, b->glossy[0], b->glossy[1], b->glossy[2]};
    const size_t width = (size_t)c->state->settings.width, pixels = sl_splat_pixels(c->state);
    for (size_t k = 0; k < mean_count(c->state); k++) {
        for (size_t i = row * width; i < (row + 1) * width; i++)
            c->mean[k * pixels + i] = b->weight[i] > 0.0f ? sums[k][i] / b->weight[i] : 0.0f;
    }
}

static sl_status fill(const sl_splat_state *s, float *mean, sl_error *error) {
    const size_t pixels = sl_splat_pixels(s);
    sl_status status = SL_OK;
    for (int class = 0; class < SL_RECEIVER_CLASSES; class++) {
        const uint32_t *mine = s->cache[class].receives;
        for (size_t k = 0; mine && status == SL_OK && k < (class == SL_RECEIVES_RADIANCE ? MEANS : 3); k += 3)
            status = sl_fill_uncovered(s->settings.width, s->settings.height, s->splats.weight, mine,
                                       mean + k * pixels, mean + (k + 1) * pixels, mean + (k + 2) * pixels,
                                       error);
    }
    return status;
}

/* ---- pixels ---- */

static bool receives(const sl_splat_state *s, sl_receiver_class class, size_t i) {
    return s->cache[class].receives && s->cache[class].receives[i];
}

/* The layers of pixel i, whose row counts from the bottom as on the hardware; images have row 0 at the top.
 * left: what the mirrors before it leave of its light. */
static void put(const composing *c, size_t i, sl_rgb emission, sl_rgb left) {
    const sl_splat_state *s = c->state;
    const sl_gbuffer *g = s->gbuffer;
    const size_t width = (size_t)g->width, pixels = sl_splat_pixels(s),
                 out = ((size_t)g->height - 1 - i / width) * width + i % width;
    const bool glossy = receives(s, SL_RECEIVES_RADIANCE, i),
               diffuse = glossy || receives(s, SL_RECEIVES_IRRADIANCE, i);
    const sl_rgb ks = glossy ? s->scene->materials[g->material[i]].specular : sl_grey(0.0f);
    const float emitted[3] = {emission.r, emission.g, emission.b}, specular[3] = {ks.r, ks.g, ks.b},
                albedo[3] = {g->diffuse_r[i], g->diffuse_g[i], g->diffuse_b[i]},
                share[3] = {left.r, left.g, left.b};
    for (size_t k = 0; k < 3; k++) {
        const float e = c->mean[k * pixels + i], lobe = glossy ? c->mean[(3 + k) * pixels + i] : 0.0f;
        const float irradiated = diffuse ? sl_picture_value(e * (albedo[k] * (float)(1.0 / SL_PI))) : 0.0f;
        /* A lobe of finite order rings below 0. */
        const float reflected = lobe > 0.0f ? sl_picture_value(lobe * specular[k]) : 0.0f;
        const float light = sl_picture_value(emitted[k]),
                    direct = sl_picture_value(sl_picture_value(s->direct_light[k][i]) * share[k]),
                    indirect = sl_picture_value(irradiated * share[k]),
                    gloss = sl_picture_value(reflected * share[k]);
        c->layers[(EMISSION + k) * pixels + out] = light;
        c->layers[(DIRECT + k) * pixels + out] = direct;
        c->layers[(INDIRECT + k) * pixels + out] = indirect;
        if (mean_count(s) == MEANS) c->layers[(GLOSSY + k) * pixels + out] = gloss;
        c->layers[(PICTURE + k) * pixels + out] = sl_picture_value(light + direct + indirect + gloss);
    }
    c->layers[WEIGHT * pixels + out] = s->splats.weight[i];
    c->layers[RECORDS * pixels + out] = s->splats.count[i];
}

static void compose_row(void *context, size_t row, unsigned worker) {
    (void)worker;
    const composing *c = context;
    const sl_splat_state *s = c->state;
    const size_t width = (size_t)s->settings.width;
    for (size_t x = 0, i = row * width; x < width; x++, i++) {
        if (!sl_sub_frame_shows(&s->scene->sub_frame, i)) continue;
        put(c, i, sl_gbuffer_emission(s->scene, &c->view, s->gbuffer, i, (int)x, (int)row), sl_grey(1.0f));
    }
}

static void compose_mirrors(const composing *c) {
    const sl_splat_state *s = c->state;
    const sl_reflections *r = s->reflections;
    for (size_t k = 0; r && k < r->count; k++) {
        const sl_rgb emission = sl_reflections_emission(s->scene, s->gbuffer, r, k);
        put(c, r->pixel[k], emission, r->throughput[k]);
    }
}

sl_status sl_compose(const sl_splat_state *s, sl_image *image, sl_error *error) {
    const size_t rows = (size_t)s->settings.height;
    composing c = {s, sl_view_scene(s->scene, s->settings.width, s->settings.height),
                   sl_allocate(mean_count(s) * sl_splat_pixels(s), sizeof *c.mean), image->planes};
    if (!c.mean) return sl_fail_memory(error, "the picture");
    sl_parallel_for(s->settings.threads, rows, average_row, &c);
    sl_status status = fill(s, c.mean, error);
    if (status == SL_OK) {
        sl_parallel_for(s->settings.threads, rows, compose_row, &c);
        compose_mirrors(&c);
    }
    sl_free(c.mean);
    return status;
}
