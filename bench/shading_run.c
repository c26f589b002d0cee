/* Worlds, the cache update by update, its rivals. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cache/shading_cache/plan.h"
#include "base/math.h"
#include "base/memory.h"
#include "scene/ambient.h"
#include "shading_bench.h"
#include "timing.h"

/* ---- worlds ---- */

static sl_settings settings_for(int size, int area, int indirect) {
    sl_settings s = sl_settings_of_papers();
    s.method = "shading-cache";
    s.width = s.height = size;
    s.threads = 1;
    s.shading_cache.area_samples = area;
    s.shading_cache.indirect_samples = indirect;
    s.shading_cache.indirect = indirect > 0 ? SL_INDIRECT_BIDIRECTIONAL : SL_INDIRECT_NONE;
    s.shading_cache.frames_per_update = 1;
    s.shading_cache.updates = 1000000000; /* no end */
    sl_shading_complete(&s);
    return s;
}

static void make_tracer(shading_world *w) {
    sl_error error;
    sl_tracer_destroy(w->own);
    bench_check(sl_tracer_create(w->scene, 1, NULL, &w->own, &error), &error);
    w->tracer = w->own;
}

static void make_renderers(shading_world *w) {
    sl_shading_plan plan = sl_shading_plan_make(w->scene, &w->settings);
    sl_renderer_settings s = {.scene = w->scene,
                              .tracer = &w->tracer,
                              .cache = w->settings.shading_cache,
                              .seed = w->settings.seed,
                              .threads = 1};
    sl_error error;
    if (plan.direct) bench_check(sl_area_renderer(&s, &w->renderer[w->renderers++], &error), &error);
    if (plan.indirect)
        bench_check(sl_bidirectional_renderer(&s, &w->renderer[w->renderers++], &error), &error);
}

bool shading_open(const bench_options *o, const char *path, int size, int area, int indirect,
                  shading_world *w) {
    memset(w, 0, sizeof *w);
    bench_scene_name(path, w->name);
    if (!bench_wants(o, w->name) || !bench_open_scene(path, &w->scene)) return false;
    w->settings = settings_for(size, area, indirect);
    w->display = (sl_display_curve){.reference = sl_rgb_mean(sl_ambient_irradiance_of_all_bounces(w->scene)) *
                                                 (float)(1.0 / SL_PI)};
    make_tracer(w);
    make_renderers(w);
    return true;
}

static void forget_pixels(shading_world *w) {
    bench_pixels_free(&w->pixels);
    sl_free(w->limit);
    w->limit = NULL;
}

void shading_close(shading_world *w) {
    forget_pixels(w);
    for (int i = 0; i < w->renderers; i++) w->renderer[i].destroy(w->renderer[i].state);
    sl_tracer_destroy(w->own);
    sl_scene_destroy(w->scene);
}

unsigned shading_move(shading_world *w, double time) {
    unsigned changes = 0;
    sl_error error;
    bench_check(sl_scene_set_time(w->scene, time, &changes, &error), &error);
    if (changes & SL_CHANGED_OBJECTS) make_tracer(w);
    for (int i = 0; i < w->renderers && changes & ~(unsigned)SL_CHANGED_CAMERA; i++)
        bench_check(w->renderer[i].edit(w->renderer[i].state, &error), &error);
    return changes;
}

static render_cache_settings rival_settings(const shading_world *w, int samples) {
    return (render_cache_settings){.scene = w->scene,
                                   .tracer = &w->tracer,
                                   .renderer = w->renderer,
                                   .renderers = w->renderers,
                                   .width = w->settings.width,
                                   .height = w->settings.height,
                                   .samples = samples,
                                   .threads = 1,
                                   .seed = 1};
}

void shading_judge(shading_world *w, int block) {
    forget_pixels(w);
    bench_pixels_make(w->scene, w->tracer, w->settings.width, w->settings.height, block, &w->pixels);
    size_t count = w->pixels.count;
    w->limit = bench_allocate(3 * count + 1, sizeof *w->limit);
    render_cache_settings s = rival_settings(w, 1);
    render_cache_reference(&s, count, w->pixels.index, w->limit);
}

double shading_error(shading_world *w, const float *planes) {
    size_t pixels = (size_t)w->settings.width * (size_t)w->settings.height;
    double sum = 0.0;
    for (size_t i = 0; i < w->pixels.count; i++) {
        for (size_t k = 0; k < 3; k++) {
            float shown = planes[k * pixels + w->pixels.index[i]], right = w->limit[3 * i + k];
            double apart =
                (double)sl_curve_level_of(&w->display, shown) - (double)sl_curve_level_of(&w->display, right);
            sum += apart * apart / (3.0 * (double)w->pixels.count);
        }
    }
    return sqrt(sum);
}

/* ---- the cache ---- */

void shading_run_open(shading_run *run, shading_world *w, const sl_settings *settings) {
    sl_settings s = settings ? *settings : w->settings;
    sl_error error;
    memset(run, 0, sizeof *run);
    run->world = w;
    bench_check(sl_method_create(w->scene, &s, &run->method, &error), &error);
}

void shading_run_close(shading_run *run) { sl_method_destroy(run->method); }

void shading_run_edit(shading_run *run, unsigned changes) {
    sl_error error;
    if (changes) bench_check(sl_method_edit(run->method, changes, &error), &error);
}

void shading_run_update(shading_run *run) {
    sl_progress progress = {0};
    sl_error error;
    double from = process_ms();
    bench_check(sl_method_update(run->method, &progress, &error), &error);
    run->seconds += 1e-3 * (process_ms() - from);
    run->updates++;
}

uint64_t shading_run_points(const shading_run *run) {
    return sl_method_counters(run->method)->value[SL_COUNT_POINTS_SHADED];
}

static sl_image *picture_of(shading_run *run) {
    sl_image *image;
    sl_error error;
    bench_check(sl_method_resolve(run->method, &image, &error), &error);
    return image;
}

double shading_run_error(shading_run *run) {
    sl_image *image = picture_of(run);
    double e = shading_error(run->world, image->planes);
    sl_image_destroy(image);
    return e;
}

/* ---- rivals ---- */

render_cache *shading_rival(const shading_world *w, int samples) {
    render_cache_settings s = rival_settings(w, samples);
    return render_cache_create(&s);
}

double shading_rival_error(shading_world *w, render_cache *cache, bool wide_fill) {
    render_cache_show(cache, wide_fill);
    return shading_error(w, render_cache_picture(cache));
}

double shading_path_error(shading_world *w, uint32_t samples, double *seconds) {
    int size = w->settings.width;
    size_t pixels = (size_t)size * (size_t)size;
    sl_path_settings settings = {.width = size, .height = size, .threads = 1, .seed = 77};
    sl_path_tracer *path;
    sl_counters counters = {{0}};
    sl_error error;
    sl_shading_transport(&w->settings, &settings.transport);
    settings.transport.filter = SL_FILTER_CENTRE;
    float *planes = bench_allocate(3 * pixels, sizeof *planes);
    double from = process_ms();
    bench_check(sl_path_tracer_create(w->scene, w->tracer, &settings, &path, &error), &error);
    for (uint32_t i = 0; i < samples; i++)
        bench_check(sl_path_tracer_sample(path, i, &counters, &error), &error);
    *seconds = 1e-3 * (process_ms() - from);
    sl_path_tracer_mean(path, -1, planes, planes + pixels, planes + 2 * pixels);
    double e = shading_error(w, planes);
    sl_path_tracer_destroy(path);
    sl_free(planes);
    return e;
}
