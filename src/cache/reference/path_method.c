/* The reference path tracer as a method. */
#include "cache/reference/sampled_method.h"

static sl_status film_create(const sl_scene *scene, const sl_tracer *tracer, const sl_settings *settings,
                             const sl_transport *transport, void **film, sl_error *error) {
    sl_path_settings path = {settings->width, settings->height, settings->threads, settings->seed,
                             *transport};
    sl_path_tracer *made = NULL;
    sl_status status = sl_path_tracer_create(scene, tracer, &path, &made, error);
    *film = made;
    return status;
}

static void film_destroy(void *film) { sl_path_tracer_destroy(film); }

static sl_status film_sample(void *film, uint64_t sample, sl_counters *counters, sl_error *error) {
    return sl_path_tracer_sample(film, sample, counters, error);
}

static void film_mean(const void *film, int half, float *r, float *g, float *b) {
    sl_path_tracer_mean(film, half, r, g, b);
}

static size_t film_memory_bytes(const void *film) { return sl_path_tracer_memory_bytes(film); }

static const sl_sampled_film path_film = {"path", "the path tracer", {16, 64, 256}, film_create, film_destroy,
                                          film_sample, film_mean, film_memory_bytes};

static void path_complete(sl_settings *settings) { sl_sampled_complete(&path_film, settings); }

static sl_status path_create(const sl_scene *scene, const sl_settings *settings,
                             const sl_transport *transport, void **state, sl_error *error) {
    return sl_sampled_create(&path_film, scene, settings, transport, state, error);
}

static sl_memory_need path_need(const sl_scene *scene, const sl_settings *settings) {
    return sl_sampled_need(scene, settings, 1e5, 0.0);
}

static void path_plan(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    sl_plan_pass(writer, true, "hierarchy", "%zu triangles", scene->triangle_count);
    sl_plan_pass(writer, true, "paths", "%u samples for each of %d x %d pixels", (unsigned)settings->spp,
                 settings->width, settings->height);
}

const sl_method_class sl_path_method = {
    .name = "path",
    .complete = path_complete,
    .create = path_create,
    .destroy = sl_sampled_destroy,
    .update = sl_sampled_update,
    .resolve = sl_sampled_resolve,
    .edit = sl_sampled_edit,
    .counters = sl_sampled_counters,
    .memory_bytes = sl_sampled_memory_bytes,
    .need = path_need,
    .transport = sl_sampled_transport,
    .plan = path_plan,
    .any_transport = true,
};
