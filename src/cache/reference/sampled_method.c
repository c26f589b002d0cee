#include "cache/reference/sampled_method.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"

#include <string.h>

typedef struct {
    const sl_sampled_film *kind;
    const sl_scene *scene;
    sl_settings settings;
    sl_transport transport;
    sl_tracer *tracer;
    sl_path_tracer *film;
    uint64_t samples, samples_wanted;
    sl_counters counters;
} sampled_state;

void sl_sampled_destroy(void *state) {
    sampled_state *s = state;
    if (!s) return;
    sl_path_tracer_destroy(s->film);
    sl_tracer_destroy(s->tracer);
    sl_free(s);
}

static sl_status start_film(sampled_state *s, sl_error *error) {
    sl_path_tracer_destroy(s->film);
    s->film = NULL;
    s->samples = 0;
    const sl_path_settings settings = {.width = s->settings.width,
                                       .height = s->settings.height,
                                       .threads = s->settings.threads,
                                       .seed = s->settings.seed,
                                       .transport = s->transport,
                                       .bidirectional = s->kind->bidirectional};
    return sl_path_tracer_create(s->scene, s->tracer, &settings, &s->film, error);
}

static const sl_sampled_film *film_of(const sl_settings *settings) {
    return strcmp(settings->method, sl_path_film.name) == 0 ? &sl_path_film : &sl_bidirectional_film;
}

void sl_sampled_complete(sl_settings *settings) {
    if (settings->spp == 0) settings->spp = film_of(settings)->samples[settings->quality];
}

sl_status sl_sampled_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport,
                            void **state, sl_error *error) {
    const sl_sampled_film *kind = film_of(settings);
    sampled_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, kind->what);
    s->kind = kind;
    s->scene = scene;
    s->settings = *settings;
    s->transport = *transport;
    s->samples_wanted = settings->spp;
    sl_status status = sl_tracer_create(scene, settings->threads, NULL, &s->tracer, error);
    if (status == SL_OK) status = start_film(s, error);
    if (status != SL_OK) {
        sl_sampled_destroy(s);
        return status;
    }
    *state = s;
    return SL_OK;
}

sl_status sl_sampled_update(void *state, sl_progress *progress, sl_error *error) {
    sampled_state *s = state;
    if (!s->film)
        return sl_fail(error, SL_ERROR_RESOURCES, "an earlier edit of the scene failed; edit it again");
    if (s->samples < s->samples_wanted) {
        sl_status status = sl_path_tracer_sample(s->film, s->samples, &s->counters, error);
        if (status != SL_OK) return status;
        s->samples++;
    }
    progress->fraction = (double)s->samples / (double)s->samples_wanted;
    progress->done = s->samples == s->samples_wanted;
    return SL_OK;
}

/* The picture, and the two halves of the samples as layers: their difference is the reference's own noise. */
sl_status sl_sampled_resolve(void *state, sl_image **image, sl_error *error) {
    static const char *const names[] = {"R",        "G",        "B",       "even.R", "even.G",
                                        "even.B",   "odd.R",    "odd.G",   "odd.B"};
    sampled_state *s = state;
    if (!s->film)
        return sl_fail(error, SL_ERROR_RESOURCES, "an earlier edit of the scene failed; edit it again");
    sl_status status = sl_image_create(s->settings.width, s->settings.height, 9, names, image, error);
    if (status != SL_OK) return status;
    size_t pixels = (size_t)s->settings.width * (size_t)s->settings.height;
    float *p = (*image)->planes;
    for (int half = -1; half < 2; half++, p += 3 * pixels)
        sl_path_tracer_mean(s->film, half, p, p + pixels, p + 2 * pixels);
    sl_observe(s->settings.observer, s->kind->name, "mean of the samples", "reference", s->settings.width,
               s->settings.height, 3, (*image)->planes, false, &s->counters, NULL, 0);
    return SL_OK;
}

sl_status sl_sampled_edit(void *state, unsigned changes, sl_error *error) {
    sampled_state *s = state;
    if (changes & SL_CHANGED_OBJECTS) {
        sl_path_tracer_destroy(s->film);
        s->film = NULL;
        sl_tracer_destroy(s->tracer);
        s->tracer = NULL;
        sl_status status = sl_tracer_create(s->scene, s->settings.threads, NULL, &s->tracer, error);
        if (status != SL_OK) return status;
    }
    return start_film(s, error);
}

const sl_counters *sl_sampled_counters(const void *state) {
    return &((const sampled_state *)state)->counters;
}

size_t sl_sampled_memory_bytes(const void *state) {
    const sampled_state *s = state;
    size_t film = s->film ? sl_path_tracer_memory_bytes(s->film) : 0;
    return sizeof *s + film + (s->tracer ? sl_tracer_memory_bytes(s->tracer) : 0);
}

void sl_sampled_transport(const sl_settings *settings, sl_transport *transport) {
    (void)settings;
    sl_transport_named("full", transport);
}
