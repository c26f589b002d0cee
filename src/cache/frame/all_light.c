#include "cache/frame/all_light.h"

#include "base/error.h"
#include "base/memory.h"
#include "cache/frame/method.h"
#include "scene/ambient.h"
#include "scene/features.h"
#include "trace/trace.h"

#include <math.h>
#include <string.h>

/* DARK: where so many bounces bring no light others are not looked for. */
enum { PIXELS = 1024, FEW_SAMPLES = 4, MOST_BOUNCES = 64, DARK = 8 };
static const double that_matters = 0.005;

bool sl_has_bounces(const sl_settings *settings) {
    const char *method = settings->method, *paths = settings->transport;
    if (paths && strncmp(paths, "matched:", 8) == 0) method = paths + 8;
    return strcmp(method, "splatting") == 0 || strcmp(method, "multi-mesh") == 0;
}

/* Paths of a small picture, of the same numbers whatever the transport: what is counted in both of two
 * measurements is the same in both. */
typedef struct measuring {
    const sl_scene *scene;
    sl_tracer *tracer;
    sl_path_settings path;
    unsigned samples;
} measuring;

static sl_status begin(measuring *m, const sl_scene *scene, const sl_settings *settings, unsigned samples,
                       sl_error *error) {
    int width = settings->width, height = settings->height;
    if (!width || !height) sl_scene_film(scene, &width, &height);
    const double shrink = sqrt((double)PIXELS / ((double)width * (double)height));
    *m = (measuring){.scene = scene,
                     .samples = samples,
                     .path = {.width = (int)fmax(width * shrink + 0.5, 1.0),
                              .height = (int)fmax(height * shrink + 0.5, 1.0),
                              .threads = settings->threads,
                              .seed = settings->seed}};
    return sl_tracer_create(scene, settings->threads, NULL, &m->tracer, error);
}

/* *light: mean luminance. */
static sl_status measure(measuring *m, const sl_transport *transport, double *light, sl_error *error) {
    sl_path_tracer *path;
    sl_counters counters = {{0}};
    m->path.transport = *transport;
    m->path.transport.filter = SL_FILTER_BOX;
    m->path.transport.emission = false;
    const size_t pixels = (size_t)m->path.width * (size_t)m->path.height;
    float *planes = sl_allocate(3 * pixels, sizeof *planes);
    if (!planes) return sl_fail_memory(error, "a few paths");
    sl_status status = sl_path_tracer_create(m->scene, m->tracer, &m->path, &path, error);
    for (uint64_t i = 0; i < m->samples && status == SL_OK; i++)
        status = sl_path_tracer_sample(path, i, &counters, error);
    if (status == SL_OK) sl_path_tracer_mean(path, -1, planes, planes + pixels, planes + 2 * pixels);
    *light = 0.0;
    for (size_t i = 0; i < pixels; i++) {
        float y = sl_luminance((sl_rgb){planes[i], planes[pixels + i], planes[2 * pixels + i]});
        *light += isfinite(y) ? (double)y / (double)pixels : 0.0;
    }
    sl_path_tracer_destroy(path);
    sl_free(planes);
    return status;
}

/* Bounces beyond the last that was measured fall off as a geometric series: by the ratio of what the later
 * half of those measured brought. */
static sl_bounces_measured go_on(const double *light, uint32_t measured, uint32_t most) {
    const uint32_t half = measured > 3 ? measured / 2 : 1;
    const double later = light[measured] - light[half + 1], earlier = light[measured - 1] - light[half],
                 ratio = earlier > 0.0 ? fmin(fmax(later / earlier, 0.0), 0.99) : 0.0;
    double left = fmax(light[measured] - light[measured - 1], 0.0) / (1.0 - ratio);
    const double all = light[measured - 1] + left;
    sl_bounces_measured found = {.bounces = measured - 1};
    while (found.bounces < most && left > that_matters * all) {
        left *= ratio;
        found.bounces++;
    }
    found.left = all > 0.0 ? left / all : 0.0;
    return found;
}

/* A picture without light tells nothing of the one that will be there when a door is opened. */
static sl_bounces_measured by_reflectance(const sl_scene *scene, uint32_t most) {
    const double reflectance = sl_mean_reflectance(scene);
    sl_bounces_measured found = {1, reflectance};
    for (; found.bounces < most && found.left > that_matters; found.bounces++) found.left *= reflectance;
    return found;
}

sl_status sl_measure_bounces(const sl_scene *scene, const sl_settings *settings, sl_bounces_measured *found,
                             sl_error *error) {
    sl_settings asked = *settings;
    sl_transport transport;
    measuring m;
    *found = (sl_bounces_measured){0};
    asked.bounces = MOST_BOUNCES;
    sl_status status = sl_method_transport(&asked, &transport, error);
    const uint32_t most = transport.bounces; /* that the method can count */
    if (status == SL_OK) status = begin(&m, scene, settings, FEW_SAMPLES, error);
    if (status != SL_OK) return status;
    double light[MOST_BOUNCES + 2] = {0.0}; /* of so many bounces */
    uint32_t n = 0;
    while (n <= most && status == SL_OK) {
        transport.bounces = ++n;
        status = measure(&m, &transport, &light[n], error);
        if (n > 1 && !(light[n] - light[n - 1] > that_matters * light[n]) && (light[n] > 0.0 || n >= DARK))
            break;
    }
    sl_tracer_destroy(m.tracer);
    if (status != SL_OK) return status;
    *found = light[n] > 0.0 || !sl_scene_features(scene).light ? go_on(light, n, most)
                                                               : by_reflectance(scene, most);
    return status;
}

sl_status sl_measure_light(const sl_scene *scene, const sl_settings *settings, const sl_light_paths *paths,
                           size_t count, unsigned samples, double *light, sl_error *error) {
    measuring m;
    sl_status status = begin(&m, scene, settings, samples, error);
    if (status != SL_OK) return status;
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        sl_settings s = *settings;
        sl_transport transport;
        s.method = paths[i].method;
        s.transport = paths[i].transport;
        m.path.bidirectional = strcmp(s.method, "bidirectional") == 0;
        status = sl_method_transport(&s, &transport, error);
        if (status == SL_OK) status = measure(&m, &transport, &light[i], error);
    }
    sl_tracer_destroy(m.tracer);
    return status;
}
