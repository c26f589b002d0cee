/* The reference tracers as methods, and what they need. */
#include "cache/frame/budget.h"
#include "cache/reference/sampled_method.h"

const sl_sampled_film sl_path_film = {"path", "the path tracer", {16, 64, 256}, false};
const sl_sampled_film sl_bidirectional_film = {
    "bidirectional", "the bidirectional path tracer", {8, 32, 128}, true};

/* ---- memory ---- */

/* Sums of two halves in double and the picture with its halves in float: 84 bytes a pixel; emitters and their
 * tree. */
enum { A_PIXEL = 88, AN_EMITTER = 256 };

static sl_memory_need need_of(const sl_scene *scene, const sl_settings *settings, double bytes_a_thread,
                              double bytes_more) {
    return (sl_memory_need){.hierarchies = sl_tracer_memory_need(scene->triangle_count),
                            .caches = sl_need_lights(scene) * AN_EMITTER +
                                      sl_need_of_threads(settings, bytes_a_thread) + bytes_more,
                            .picture = sl_need_of_pixels(settings, A_PIXEL)};
}

static sl_memory_need path_need(const sl_scene *scene, const sl_settings *settings) {
    return need_of(scene, settings, 1e5, 0.0);
}

/* Two subpaths for each ray of a packet; and lists of what falls on other pixels, 64 tasks of 256 pixels. */
static sl_memory_need both_need(const sl_scene *scene, const sl_settings *settings) {
    return need_of(scene, settings, 1e6, 8e6);
}

/* ---- plans ---- */

static void path_plan(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    sl_plan_pass(writer, true, "hierarchy", "%zu triangles", scene->triangle_count);
    sl_plan_pass(writer, true, "paths", "%u samples for each of %d x %d pixels", (unsigned)settings->spp,
                 settings->width, settings->height);
}

static void both_plan(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    sl_plan_pass(writer, true, "hierarchy", "%zu triangles", scene->triangle_count);
    sl_plan_pass(writer, true, "paths from the eye", "%u for each of %d x %d pixels", (unsigned)settings->spp,
                 settings->width, settings->height);
    bool lit = scene->emitter_count > 0 || scene->light_count > 0 || scene->environment.present;
    sl_plan_pass(writer, lit, "paths from the lights",
                 lit ? "as many; their ends are joined" : "nothing shines");
}

/* ---- the classes ---- */

#define SAMPLED_METHOD(method_name, memory_need, plan_of) \
    {.name = method_name, .complete = sl_sampled_complete, .create = sl_sampled_create, \
     .destroy = sl_sampled_destroy, .update = sl_sampled_update, .resolve = sl_sampled_resolve, \
     .edit = sl_sampled_edit, .counters = sl_sampled_counters, .memory_bytes = sl_sampled_memory_bytes, \
     .need = memory_need, .transport = sl_sampled_transport, .plan = plan_of, .any_transport = true}

const sl_method_class sl_path_method = SAMPLED_METHOD("path", path_need, path_plan);
const sl_method_class sl_bidirectional_method = SAMPLED_METHOD("bidirectional", both_need, both_plan);
