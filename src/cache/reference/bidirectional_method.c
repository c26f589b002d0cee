/* The reference bidirectional path tracer as a method. */
#include "cache/reference/sampled_method.h"
#include "trace/bidirectional/bidirectional.h"

static sl_status film_create(const sl_scene *scene, const sl_tracer *tracer, const sl_settings *settings,
                             const sl_transport *transport, void **film, sl_error *error) {
    sl_bidirectional_settings own = {.width = settings->width,
                                     .height = settings->height,
                                     .threads = settings->threads,
                                     .seed = settings->seed,
                                     .transport = *transport};
    sl_bidirectional *made = NULL;
    sl_status status = sl_bidirectional_create(scene, tracer, &own, &made, error);
    *film = made;
    return status;
}

static void film_destroy(void *film) { sl_bidirectional_destroy(film); }

static sl_status film_sample(void *film, uint64_t sample, sl_counters *counters, sl_error *error) {
    return sl_bidirectional_sample(film, sample, counters, error);
}

static void film_mean(const void *film, int half, float *r, float *g, float *b) {
    sl_bidirectional_mean(film, half, r, g, b);
}

static size_t film_memory_bytes(const void *film) { return sl_bidirectional_memory_bytes(film); }

static const sl_sampled_film bidirectional_film = {"bidirectional", "the bidirectional path tracer",
                                                   {8, 32, 128},    film_create,
                                                   film_destroy,    film_sample,
                                                   film_mean,       film_memory_bytes};

static void bidirectional_complete(sl_settings *settings) {
    sl_sampled_complete(&bidirectional_film, settings);
}

static sl_status bidirectional_create(const sl_scene *scene, const sl_settings *settings,
                                      const sl_transport *transport, void **state, sl_error *error) {
    return sl_sampled_create(&bidirectional_film, scene, settings, transport, state, error);
}

/* Two subpaths for each ray of a packet; and lists of what falls on other pixels, 64 tasks of 256 pixels. */
static sl_memory_need bidirectional_need(const sl_scene *scene, const sl_settings *settings) {
    return sl_sampled_need(scene, settings, 1e6, 8e6);
}

static void bidirectional_plan(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    sl_plan_pass(writer, true, "hierarchy", "%zu triangles", scene->triangle_count);
    sl_plan_pass(writer, true, "paths from the eye", "%u for each of %d x %d pixels", (unsigned)settings->spp,
                 settings->width, settings->height);
    bool lit = scene->emitter_count > 0 || scene->light_count > 0 || scene->environment.present;
    sl_plan_pass(writer, lit, "paths from the lights",
                 lit ? "as many; their ends are joined" : "nothing shines");
}

const sl_method_class sl_bidirectional_method = {
    .name = "bidirectional",
    .complete = bidirectional_complete,
    .create = bidirectional_create,
    .destroy = sl_sampled_destroy,
    .update = sl_sampled_update,
    .resolve = sl_sampled_resolve,
    .edit = sl_sampled_edit,
    .counters = sl_sampled_counters,
    .memory_bytes = sl_sampled_memory_bytes,
    .need = bidirectional_need,
    .transport = sl_sampled_transport,
    .plan = bidirectional_plan,
    .any_transport = true,
};
