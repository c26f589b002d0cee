/* Memory of radiance cache splatting, and its end of records if memory ends. */
#include "cache/frame/budget.h"
#include "cache/hemisphere/projection.h"
#include "cache/splatting/state.h"

#include <stdio.h>

/* G-buffer 64, planes 36, receivers 4 for each class and owners 1, the picture 56; of radiance 12 more in
 * either; what mirrors show. Records: the least that shows anything. Gathers: tables and buffers by the
 * square of their size, a thread each. */
enum {
    A_PIXEL = 176,
    OF_RADIANCE = 28,
    OF_MIRRORS = 96,
    RECORDS_LEAST = 1000,
    TREE_A_RECORD = sizeof(sl_reach_node),
    AN_EMITTER = 400,
    A_SAMPLE = 260,
    OF_SECOND_LEVEL = 20000000 /* some 9,000 records, and cells of the octree that list them */
};

static double record_bytes(const sl_settings *settings, bool radiance) {
    double n = settings->harmonics_order > 0 ? settings->harmonics_order : 10;
    return (double)sizeof(sl_record) + TREE_A_RECORD + (radiance ? 9.0 * n * n * sizeof(float) : 0.0);
}

sl_memory_need sl_splat_need(const sl_scene *scene, const sl_settings *settings) {
    const sl_splat_plan plan = sl_splat_plan_make(scene, settings);
    const double n = settings->gather_size, lights = sl_need_lights(scene);
    const double maps = settings->direct == SL_DIRECT_SHADOW_MAPS
                            ? 6.0 * (lights + 64.0) * SL_SHADOW_MAP_SIZE * SL_SHADOW_MAP_SIZE * sizeof(float)
                            : 0.0;
    const double sky = 20.0 * (double)scene->environment.width * (double)scene->environment.height;
    bool tracer = plan.direct || plan.mirrors;
    return (sl_memory_need){
        .hierarchies = tracer ? sl_tracer_memory_need(scene) +
                                    sl_raster_memory_kept(scene->triangle_count)
                              : sl_raster_memory_need(scene->triangle_count),
        .caches = 3.0 * RECORDS_LEAST * record_bytes(settings, plan.radiance) +
                  (4.0 + 2.0 * settings->threads) * n * n * A_SAMPLE + lights * AN_EMITTER + maps + sky +
                  2e6 + (settings->bounces > 1 ? OF_SECOND_LEVEL : 0),
        .picture = sl_need_of_pixels(settings, A_PIXEL + (plan.radiance ? OF_RADIANCE : 0) +
                                                   (plan.mirrors ? OF_MIRRORS : 0))};
}

size_t sl_splat_coefficients(const sl_splat_state *s, sl_receiver_class class) {
    return class == SL_RECEIVES_RADIANCE ? SL_PROJECTION_VECTORS * sl_hsh_stride(s->plan.harmonics_order) : 0;
}

/* By what records there are and nothing else, since bits hang on it: not by room that arrays kept from before
 * an edit, nor by whether a pixel of a class is in view. So a method whose records come from a file ends
 * where the one that made them did. Arrays are half as large again while they grow. */
bool sl_splat_is_full(sl_splat_state *s) {
    if (!s->settings.memory_bytes || s->full) return s->full;
    double bytes = 0.0;
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        const sl_record_list *list = &s->cache[c].list;
        bytes +=
            (double)list->count * ((double)sizeof(sl_record) +
                                   (double)sl_splat_coefficients(s, (sl_receiver_class)c) * sizeof(float));
        bytes += (double)list->reaches.count * sizeof(sl_reach_node);
    }
    const double second = s->settings.bounces > 1 ? OF_SECOND_LEVEL : 0.0;
    s->full = 3.0 * bytes > (double)s->settings.memory_bytes - second;
    size_t count = s->cache[0].list.count + s->cache[1].list.count;
    if (s->full) snprintf(s->filled, sizeof s->filled, "records end at %zu", count);
    return s->full;
}

const char *sl_splat_filled(const void *state) {
    const sl_splat_state *s = state;
    return s->full ? s->filled : NULL;
}
