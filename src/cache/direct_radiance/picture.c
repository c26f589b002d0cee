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

#include <string.h>

/* APART: floats between planes, lest at widths that are powers of two the same pixel of all of them fell into
 * the same lines of the cache. */
enum { LIGHT_PLANES = 6, APART = 112 };

/* A thread's part of the picture. */
typedef struct {
    int first_row;
    sl_gbuffer *gbuffer;
    float *light;   /* planes: direct, indirect */
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

/* ---- pass 8: the accumulation targets as a picture ---- */

static void compose(const drawing *d, const strip *s, sl_counters *counters) {
    float *const *direct = s->target.direct, *const *indirect = s->target.indirect;
    const sl_composition composition = {
        .scene = d->scene, .view = &d->view, .gbuffer = s->gbuffer, .first_row = s->first_row,
        .reflections = s->reflections,
        .layer = {{{direct[0], direct[1], direct[2]}, SL_COMPOSED_DIRECT},
                  {{indirect[0], indirect[1], indirect[2]}, SL_COMPOSED_INDIRECT}},
        .image = d->image};
    for (int row = 0; row < s->gbuffer->height; row++) sl_compose_row(&composition, row);
    sl_compose_mirrors(&composition);
    if (d->scene->environment.present || d->scene->emitter_count > 0)
        sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, (size_t)s->gbuffer->width * (size_t)s->gbuffer->height);
}

static void draw_strip(void *context, size_t index, unsigned worker, void *result, sl_counters *counters) {
    (void)result;
    const drawing *d = context;
    strip *s = &d->worker[worker];
    const sl_direct_light *direct = d->light.lights->count > 0 ? &d->direct : NULL;
    set_rows(d, s, index);
    resolve_strip(d, s, worker, counters);
    memset(s->light, 0, LIGHT_PLANES * d->room * sizeof *s->light);
    if (direct || d->sums)
        sl_light_strip(direct, d->sums, d->scene, s->gbuffer, 0, &s->target, counters);
    compose(d, s, counters);
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
                                 layers ? SL_COMPOSED_CHANNELS : SL_COMPOSED_EMISSION, sl_composed_names,
                                 &d->image, error);
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
