/* Memory within bounds: what a picture would take is worked out from counts before anything is made, and
 * settings are lowered until that fits. Each method tells what it needs (in its folder); which settings may
 * be lowered, and the rule by which they are, is here. */
#pragma once

#include "cache/frame/method.h"
#include "raster/raster.h"
#include "trace/trace.h"

/* All of it, the program, the scene and the method; settings are complete. */
uint64_t sl_budget_need(const sl_method_class *method, const sl_scene *scene, const sl_settings *settings);
/* Complete settings with memory_bytes: lowered until the need is within it, by the step that saves most,
 * again and again; the bits depend on the budget therefore, but not on the number of threads, which is
 * lowered last. `reduced` gets what was done in a few words, or "". beside: bytes that are taken by whoever
 * uses the method, within the same bound. memory_bytes becomes what is left for caches that grow.
 * SL_ERROR_RESOURCES where nothing more can be lowered. */
sl_status sl_budget_keep(const sl_method_class *method, const sl_scene *scene, sl_settings *settings,
                         double beside, char *reduced, size_t room, sl_error *error);

/* Emitters that there are at any time: keyframes may give a lamp an area that it has not yet, and a method is
 * made once for all of them. */
static inline double sl_need_emitters(const sl_scene *scene) {
    return (double)(scene->animation ? scene->emissive_count : scene->emitter_count);
}
static inline double sl_need_lights(const sl_scene *scene) {
    return (double)scene->light_count + sl_need_emitters(scene);
}

/* Three shapes of need that all methods have. */
static inline double sl_need_of_pixels(const sl_settings *settings, double bytes_a_pixel) {
    return (double)settings->width * (double)settings->height * bytes_a_pixel;
}
static inline double sl_need_of_threads(const sl_settings *settings, double bytes_a_thread) {
    return (double)settings->threads * bytes_a_thread;
}
