/* Passes 5 to 8 at once, four rows of the picture after another. What the hardware keeps in targets as large
 * as the picture (a G-buffer of fourteen planes, nine of light) is here as large as a strip, which one thread
 * resolves, lights and composes while it is in its cache: out of it goes nothing but the picture. Where the
 * strip shows mirrors, rays find what they reflect. */
#include "base/batch.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/direct_radiance/direct_radiance.h"
#include "cache/direct_radiance/receivers.h"
#include "image/unset.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* APART: floats between planes, lest at widths that are powers of two the same pixel of all of them fell into
 * the same lines of the cache. */
enum { LIGHT_PLANES = 9, APART = 112 };

/* A thread's part of the picture. */
typedef struct {
    int first_row;
    sl_gbuffer *gbuffer;
    float *light;   /* planes: direct, indirect, emission */
    bool shines;    /* there is something in those of emission, which there seldom is */
    float *emission[3];
    sl_tile_target target;
    sl_reflections *reflections; /* NULL: no mirror */
    sl_status status;
    sl_error error;
} strip;

typedef struct {
    const sl_radiance_state *state;
    const sl_scene *scene;
    sl_view view;
    sl_light_pass light;
    sl_resolver *resolver;
    bool nothing_shines;
    sl_direct_light direct;
    sl_photon_sums *sums; /* NULL: no indirect light */
    sl_image *image;
    strip *worker;
    unsigned workers;
    size_t room;            /* from plane to plane of a strip */
} drawing;

/* ---- memory ---- */

static sl_status allocate_strip(const drawing *d, strip *s, sl_error *error) {
    sl_status status = sl_gbuffer_create(d->view.width, SL_TILE_HEIGHT, &s->gbuffer, error);
    if (status != SL_OK) return status;
    s->light = sl_allocate(LIGHT_PLANES * d->room, sizeof *s->light);
    if (!s->light) return sl_fail_memory(error, "the picture");
    for (size_t k = 0; k < 3; k++) {
        s->target.direct[k] = s->light + k * d->room;
        s->target.indirect[k] = s->light + (3 + k) * d->room;
        s->emission[k] = s->light + (6 + k) * d->room;
    }
    return SL_OK;
}

static void release(drawing *d) {
    for (unsigned w = 0; d->worker && w < d->workers; w++) {
        sl_gbuffer_destroy(d->worker[w].gbuffer);
        sl_free(d->worker[w].light);
        sl_reflections_destroy(d->worker[w].reflections);
    }
    sl_free(d->worker);
    sl_photon_sums_destroy(d->sums);
    sl_resolver_destroy(d->resolver);
}

/* ---- a strip ---- */

static void set_rows(const drawing *d, strip *s, size_t index) {
    const int left = d->view.height - (int)index * SL_TILE_HEIGHT;
    s->first_row = (int)index * SL_TILE_HEIGHT;
    s->gbuffer->height = left < SL_TILE_HEIGHT ? left : SL_TILE_HEIGHT;
}

/* Resolves what is seen, and what is seen in mirrors. */
static void resolve_strip(const drawing *d, strip *s, unsigned worker, sl_counters *counters) {
    const size_t width = (size_t)s->gbuffer->width, pixels = width * (size_t)s->gbuffer->height,
                 first = (size_t)s->first_row * width;
    memcpy(s->gbuffer->id, d->state->id + first, pixels * sizeof *s->gbuffer->id);
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED,
             sl_resolver_run(d->resolver, worker, first, pixels, s->gbuffer));
    sl_reflections_destroy(s->reflections);
    s->reflections = NULL;
    if (d->state->plan.mirrors && s->status == SL_OK)
        s->status = sl_reflect_pixels(d->scene, d->state->tracer, 1, s->gbuffer, &s->reflections, counters,
                                      &s->error);
}

static void put_emission(const strip *s, size_t i, sl_rgb light) {
    s->emission[0][i] = light.r;
    s->emission[1][i] = light.g;
    s->emission[2][i] = light.b;
}

/* Leaves of what mirror pixels show what the mirrors reflect. */
static void dim_mirrors(const drawing *d, const strip *s) {
    const sl_reflections *r = s->reflections;
    for (size_t k = 0; r && k < r->count; k++) {
        const size_t i = r->pixel[k];
        const float throughput[3] = {r->throughput[k].r, r->throughput[k].g, r->throughput[k].b};
        put_emission(s, i, sl_reflections_emission(d->scene, s->gbuffer, r, k));
        for (int c = 0; c < 3; c++) {
            s->target.direct[c][i] *= throughput[c];
            s->target.indirect[c][i] *= throughput[c];
        }
    }
}

/* ---- light seen directly, L S* E: it takes no light pass, only what each pixel shows ---- */

static bool is_dark(const sl_scene *scene, uint32_t material) {
    if (material == SL_NO_INDEX) return !scene->environment.present;
    return !sl_material_is_emitter(&scene->materials[material]);
}

static void add_emission(const drawing *d, strip *s, sl_counters *counters) {
    const int width = s->gbuffer->width, height = s->gbuffer->height;
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            if (is_dark(d->scene, s->gbuffer->material[i])) continue;
            s->shines = true;
            put_emission(s, i, sl_gbuffer_emission(d->scene, &d->view, s->gbuffer, i, x,
                                                   s->first_row + y));
        }
    }
    sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, (size_t)width * (size_t)height);
}

/* ---- pass 8: the accumulation targets as a picture ---- */

static const char *const layer_names[SL_RADIANCE_CHANNELS] = {
    "R",        "G",        "B",        "emission.R", "emission.G", "emission.B",
    "direct.R", "direct.G", "direct.B", "indirect.R", "indirect.G", "indirect.B"};

/* sl_picture_value(), without a branch. */
static inline float value(float v) {
    float large = v > 0.0f ? FLT_MAX : 0.0f;
    return fabsf(v) <= FLT_MAX ? v : large;
}

/* One channel of a row; out: the picture, emission, direct and indirect light, pixels apart. */
static void compose(size_t width, const float *restrict emission, const float *restrict direct,
                    const float *restrict indirect, size_t pixels, float *restrict out) {
    float *restrict e = out + SL_RADIANCE_EMISSION * pixels, *restrict d = out + SL_RADIANCE_DIRECT * pixels,
          *restrict i = out + SL_RADIANCE_INDIRECT * pixels;
#pragma omp simd
    for (size_t x = 0; x < width; x++) {
        e[x] = value(emission[x]);
        d[x] = value(direct[x]);
        i[x] = value(indirect[x]);
        out[x] = value(e[x] + d[x] + i[x]);
    }
}

static void compose_without_layers(size_t width, const float *restrict emission, const float *restrict direct,
                                   const float *restrict indirect, float *restrict out) {
#pragma omp simd
    for (size_t x = 0; x < width; x++)
        out[x] = value(value(emission[x]) + value(direct[x]) + value(indirect[x]));
}

/* Composes a row. Rows count from the bottom, as on the hardware; images have row 0 at the top. */
static void compose_row(const drawing *d, const strip *s, size_t row) {
    const sl_image *image = d->image;
    const size_t width = (size_t)image->width, height = (size_t)image->height, pixels = width * height;
    const size_t from = row * width, to = (height - 1 - (size_t)s->first_row - row) * width;
    for (size_t k = 0; k < 3; k++) {
        const float *emission = s->emission[k] + from, *direct = s->target.direct[k] + from,
                    *indirect = s->target.indirect[k] + from;
        float *out = image->planes + k * pixels + to;
        if (d->state->settings.radiance_map.without_layers)
            compose_without_layers(width, emission, direct, indirect, out);
        else compose(width, emission, direct, indirect, pixels, out);
    }
}

static void draw_strip(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)result;
    const drawing *d = context;
    strip *s = &d->worker[worker];
    const sl_direct_light *direct = d->light.lights->count > 0 ? &d->direct : NULL;
    set_rows(d, s, index);
    resolve_strip(d, s, worker, counters);
    memset(s->light, 0, (s->shines ? LIGHT_PLANES : LIGHT_PLANES - 3) * d->room * sizeof *s->light);
    s->shines = s->reflections != NULL; /* which may show the sky */
    if (!d->nothing_shines) add_emission(d, s, counters);
    if (direct || d->sums)
        sl_light_strip(direct, d->sums, d->scene, s->gbuffer, 0, &s->target, counters);
    dim_mirrors(d, s);
    for (size_t row = 0; row < (size_t)s->gbuffer->height; row++) compose_row(d, s, row);
}

/* ---- the picture ---- */

static sl_status prepare(drawing *d, sl_error *error) {
    const bool layers = !d->state->settings.radiance_map.without_layers;
    sl_status status =
        sl_resolver_create(d->state->raster, &d->view, d->state->id, d->workers, &d->resolver, error);
    if (status == SL_OK && d->light.photons && d->light.photons->count)
        status = sl_photon_sums_create(&d->light, &d->sums, error);
    if (status != SL_OK) return status;
    d->worker = sl_allocate(d->workers, sizeof *d->worker);
    if (!d->worker) return sl_fail_memory(error, "the picture");
    for (unsigned w = 0; w < d->workers && status == SL_OK; w++)
        status = allocate_strip(d, &d->worker[w], error);
    if (status != SL_OK) return status;
    return sl_image_create_unset(d->view.width, d->view.height,
                                 layers ? SL_RADIANCE_CHANNELS : SL_RADIANCE_EMISSION, layer_names, &d->image,
                                 error);
}

static sl_status finish(const drawing *d, sl_image **image, sl_error *error) {
    for (unsigned w = 0; w < d->workers; w++) {
        if (d->worker[w].status == SL_OK) continue;
        if (error) *error = d->worker[w].error;
        sl_image_destroy(d->image);
        return d->worker[w].status;
    }
    *image = d->image;
    return SL_OK;
}

sl_status sl_radiance_draw_image(const sl_radiance_state *state, sl_image **image, sl_counters *counters,
                                 sl_error *error) {
    const sl_scene *scene = state->scene;
    drawing d = {.state = state,
                 .scene = scene,
                 .view = sl_view_scene(scene, state->settings.width, state->settings.height),
                 .light = sl_radiance_lighting(state),
                 .nothing_shines = !scene->environment.present && scene->emitter_count == 0,
                 .workers = sl_thread_count(state->settings.threads)};
    const size_t strips = (size_t)((d.view.height + SL_TILE_HEIGHT - 1) / SL_TILE_HEIGHT);
    d.direct = sl_direct_light_of(&d.light);
    d.room = SL_TILE_HEIGHT * (size_t)d.view.width + APART;
    sl_status status = prepare(&d, error);
    if (status == SL_OK) {
        sl_batch_run(&(sl_batch){.count = strips, .work = draw_strip, .context = &d}, d.workers, counters);
        status = finish(&d, image, error);
    }
    release(&d);
    return status;
}
