/* Frames of the method, and times. */
#include <string.h>

#include "base/math.h"
#include "drm_bench.h"
#include "timing.h"

/* ---- frames ---- */

sl_settings drm_paper_settings(int size, sl_photon_weight weight) {
    sl_settings settings = sl_settings_default();
    settings.method = "direct-radiance";
    settings.width = settings.height = size;
    settings.threads = 1;
    sl_radiance_map_settings *m = &settings.radiance_map;
    m->shape = SL_MAP_FRUSTUM;
    m->map_fov = 0.5 * SL_PI;
    m->samples = 3;
    m->filter = SL_MAP_FILTER_POINT;
    m->weight = weight;
    return settings;
}

void drm_frames_open(drm_frames *f, sl_scene *scene, const sl_settings *settings) {
    sl_error error;
    *f = (drm_frames){.scene = scene};
    if (sl_method_create(scene, settings, &f->method, &error) != SL_OK) bench_fail("direct radiance", &error);
}

void drm_frame(drm_frames *f, unsigned changes) {
    sl_error error;
    sl_progress progress = {0};
    sl_counters before = *sl_method_counters(f->method);
    sl_image_destroy(f->image);
    f->image = NULL;
    if (changes && sl_method_edit(f->method, changes, &error) != SL_OK) bench_fail("edit", &error);
    do {
        if (sl_method_update(f->method, &progress, &error) != SL_OK) bench_fail("update", &error);
    } while (!progress.done);
    if (sl_method_resolve(f->method, &f->image, &error) != SL_OK) bench_fail("resolve", &error);
    const sl_counters *after = sl_method_counters(f->method);
    for (int i = 0; i < SL_COUNTERS; i++) f->counters.value[i] = after->value[i] - before.value[i];
}

void drm_frames_close(drm_frames *f) {
    sl_image_destroy(f->image);
    sl_method_destroy(f->method);
    *f = (drm_frames){0};
}

const float *drm_layer(const sl_image *image, const char *layer, char channel) {
    char name[SL_CHANNEL_NAME_MAX];
    snprintf(name, sizeof name, "%s%s%c", layer ? layer : "", layer ? "." : "", channel);
    return sl_image_channel(image, name);
}

/* ---- times ---- */

enum { ROUNDS_MIN = 3, ROUNDS_MAX = 25 };
static const double sample_ms = 5.0; /* so long at least that the clock's grain does not matter */

static double now(unsigned threads) { return threads > 1 ? wall_ms() : process_ms(); }

static double sample(const drm_timed *t, unsigned threads, int runs) {
    double from = now(threads);
    for (int i = 0; i < runs; i++) t->run(t->context);
    return (now(threads) - from) / runs;
}

void drm_time(drm_timed *timed, size_t count, unsigned threads, double seconds) {
    double ms[DRM_TIMED_MAX][ROUNDS_MAX], from;
    int runs[DRM_TIMED_MAX], rounds = 0;
    for (size_t i = 0; i < count; i++) {
        sample(&timed[i], threads, 1); /* memory is touched, shaders are compiled */
        double once = sample(&timed[i], threads, 1);
        runs[i] = once < sample_ms ? (int)(sample_ms / (once > 0.01 ? once : 0.01)) + 1 : 1;
    }
    from = wall_ms();
    while (rounds < ROUNDS_MIN || (rounds < ROUNDS_MAX && wall_ms() - from < 1e3 * seconds)) {
        for (size_t i = 0; i < count; i++) ms[i][rounds] = sample(&timed[i], threads, runs[i]);
        rounds++;
    }
    for (size_t i = 0; i < count; i++) {
        double middle = median(ms[i], rounds); /* sorts */
        timed[i].ms = threads > 1 ? ms[i][0] : middle;
        timed[i].apart = threads > 1 ? middle / ms[i][0] - 1.0 : spread(ms[i], rounds);
    }
}
