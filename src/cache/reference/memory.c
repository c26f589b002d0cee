/* What the reference tracers take. */
#include "cache/frame/budget.h"
#include "cache/reference/sampled_method.h"

/* Sums of two halves in double and the picture with its halves in float: 84 bytes a pixel; emitters and their
 * tree. */
enum { A_PIXEL = 88, AN_EMITTER = 256 };

sl_memory_need sl_sampled_need(const sl_scene *scene, const sl_settings *settings, double bytes_a_thread,
                               double bytes_more) {
    return (sl_memory_need){.hierarchies = sl_tracer_memory_need(scene->triangle_count),
                            .caches = sl_need_lights(scene) * AN_EMITTER +
                                      sl_need_of_threads(settings, bytes_a_thread) + bytes_more,
                            .picture = sl_need_of_pixels(settings, A_PIXEL)};
}
