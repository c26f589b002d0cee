/* The reference path tracer as a method: one update is one more sample for every pixel. */
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "cache/method.h"
#include "trace/trace.h"

typedef struct {
    const sl_scene *scene;
    sl_settings settings;
    sl_transport transport;
    sl_tracer *tracer;
    sl_path_tracer *path;
    uint64_t samples, samples_wanted;
    sl_counters counters;
} path_state;

static void path_destroy(void *state) {
    path_state *s = state;
    if (!s) return;
    sl_path_tracer_destroy(s->path);
    sl_tracer_destroy(s->tracer);
    sl_free(s);
}

static sl_status start_tracer(path_state *s, sl_error *error) {
    sl_path_settings settings = {s->settings.width, s->settings.height, s->settings.threads, s->settings.seed, s->transport};
    sl_path_tracer_destroy(s->path);
    s->path = NULL;
    s->samples = 0;
    return sl_path_tracer_create(s->scene, s->tracer, &settings, &s->path, error);
}

static uint32_t samples_by_quality(sl_quality quality) {
    static const uint32_t samples[] = {16, 64, 256};
    return samples[quality];
}

static void path_complete(sl_settings *settings) {
    if (settings->spp == 0) settings->spp = samples_by_quality(settings->quality);
}

static sl_status path_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport,
                             void **state, sl_error *error) {
    path_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the path tracer");
    s->scene = scene;
    s->settings = *settings;
    s->transport = *transport;
    s->samples_wanted = settings->spp;
    sl_status status = sl_tracer_create(scene, settings->threads, NULL, &s->tracer, error);
    if (status == SL_OK) status = start_tracer(s, error);
    if (status != SL_OK) {
        path_destroy(s);
        return status;
    }
    *state = s;
    return SL_OK;
}

static sl_status path_update(void *state, sl_progress *progress, sl_error *error) {
    path_state *s = state;
    if (!s->path) return sl_fail(error, SL_ERROR_RESOURCES, "an earlier edit of the scene failed; edit it again");
    if (s->samples < s->samples_wanted) {
        sl_status status = sl_path_tracer_sample(s->path, s->samples, &s->counters, error);
        if (status != SL_OK) return status;
        s->samples++;
    }
    progress->fraction = (double)s->samples / (double)s->samples_wanted;
    progress->done = s->samples == s->samples_wanted;
    return SL_OK;
}

/* The picture, and the two halves of the samples as layers: their difference is the reference's own noise. */
static sl_status path_resolve(void *state, sl_image **image, sl_error *error) {
    static const char *const names[] = {"R",        "G",        "B",       "even.R", "even.G",
                                        "even.B",   "odd.R",    "odd.G",   "odd.B"};
    path_state *s = state;
    if (!s->path) return sl_fail(error, SL_ERROR_RESOURCES, "an earlier edit of the scene failed; edit it again");
    sl_status status = sl_image_create(s->settings.width, s->settings.height, 9, names, image, error);
    if (status != SL_OK) return status;
    size_t pixels = (size_t)s->settings.width * (size_t)s->settings.height;
    float *p = (*image)->planes;
    for (int half = -1; half < 2; half++, p += 3 * pixels) {
        sl_path_tracer_mean(s->path, half, p, p + pixels, p + 2 * pixels);
    }
    sl_observe(s->settings.observer, "path", "mean of the samples", "reference", s->settings.width, s->settings.height, 3,
               (*image)->planes, false, &s->counters);
    return SL_OK;
}

static sl_status path_edit(void *state, unsigned changes, sl_error *error) {
    path_state *s = state;
    if (changes & SL_CHANGED_OBJECTS) {
        sl_path_tracer_destroy(s->path);
        s->path = NULL;
        sl_tracer_destroy(s->tracer);
        s->tracer = NULL;
        sl_status status = sl_tracer_create(s->scene, s->settings.threads, NULL, &s->tracer, error);
        if (status != SL_OK) return status;
    }
    return start_tracer(s, error);
}

static const sl_counters *path_counters(const void *state) { return &((const path_state *)state)->counters; }

static size_t path_memory_bytes(const void *state) {
    const path_state *s = state;
    size_t film = (size_t)s->settings.width * (size_t)s->settings.height * 6 * sizeof(double);
    return sizeof *s + film + (s->tracer ? sl_tracer_memory_bytes(s->tracer) : 0);
}

static void path_transport(const sl_settings *settings, sl_transport *transport) {
    (void)settings;
    sl_transport_named("full", transport);
}

static void path_plan(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    sl_plan_pass(writer, true, "hierarchy", "%zu triangles", scene->triangle_count);
    sl_plan_pass(writer, true, "paths", "%u samples for each of %d x %d pixels", (unsigned)settings->spp, settings->width,
                 settings->height);
}

const sl_method_class sl_path_method = {
    .name = "path",
    .complete = path_complete,
    .create = path_create,
    .destroy = path_destroy,
    .update = path_update,
    .resolve = path_resolve,
    .edit = path_edit,
    .counters = path_counters,
    .memory_bytes = path_memory_bytes,
    .transport = path_transport,
    .plan = path_plan,
    .any_transport = true,
};
