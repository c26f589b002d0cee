/* Multi-mesh caching, step by step; and its pictures, part by part. */
#include <stdlib.h>
#include <string.h>

#include "cache/multi_mesh/plan.h"
#include "mesh_bench.h"
#include "scene/transport.h"
#include "timing.h"

/* ---- what is compared ---- */

const char *const mesh_part_names[MESH_PARTS] = {"direct diffuse", "direct specular", "indirect", "all"};
static const char *const layers[MESH_ALL] = {"direct", "specular", "indirect"};

static sl_transport transport_of(mesh_part part) {
    sl_transport t = {.sky_light = true,
                      .bounces = 1,
                      .direct_visibility = true,
                      .bounce_visibility = true,
                      .filter = SL_FILTER_CENTRE};
    if (part == MESH_DIRECT) t.direct_lobes = SL_LOBE_DIFFUSE;
    if (part == MESH_SPECULAR) t.direct_lobes = SL_LOBE_GLOSSY;
    if (part == MESH_INDIRECT) t.receiver_lobes = t.bounce_lobes = SL_LOBE_DIFFUSE;
    return t;
}

static bool any_glossy(const sl_scene *scene) {
    for (size_t i = 0; i < scene->material_count; i++)
        if (sl_material_is_glossy(&scene->materials[i])) return true;
    return false;
}

static void add_references(mesh_world *w) {
    bench_reference sum;
    bench_reference_sum(&w->reference[MESH_DIRECT], &w->reference[MESH_INDIRECT], &sum);
    if (w->has[MESH_SPECULAR]) {
        bench_reference_sum(&sum, &w->reference[MESH_SPECULAR], &w->reference[MESH_ALL]);
        bench_reference_free(&sum);
    } else {
        w->reference[MESH_ALL] = sum;
    }
}

bool mesh_world_open(bench_report *r, const char *path, int width, int height, int block, uint32_t samples,
                     mesh_world *w) {
    sl_error error;
    memset(w, 0, sizeof *w);
    bench_scene_name(path, w->name);
    if (!bench_open_scene(r, path, &w->scene)) return false;
    if (sl_tracer_create(w->scene, 1, NULL, &w->tracer, &error) != SL_OK) bench_fail("rays", &error);
    bench_pixels_make(w->scene, w->tracer, width, height, block, &w->pixels);
    w->values = calloc(3 * w->pixels.count + 1, sizeof *w->values);
    if (!w->values) bench_fail("values", NULL);
    for (int part = 0; part < MESH_ALL; part++) {
        sl_transport transport = transport_of((mesh_part)part);
        w->has[part] = part != MESH_SPECULAR || any_glossy(w->scene);
        if (w->has[part])
            bench_reference_get(w->scene, w->tracer, &transport, &w->pixels, samples, &w->reference[part]);
    }
    w->has[MESH_ALL] = true;
    add_references(w);
    return true;
}

void mesh_world_close(mesh_world *w) {
    for (int part = 0; part < MESH_PARTS; part++) bench_reference_free(&w->reference[part]);
    free(w->values);
    bench_pixels_free(&w->pixels);
    sl_tracer_destroy(w->tracer);
    sl_scene_destroy(w->scene);
}

void mesh_pick(const mesh_world *w, const sl_image *image, mesh_part part, float *values) {
    if (part != MESH_ALL) {
        if (!bench_pick(image, layers[part], &w->pixels, values)) bench_fail("layers", NULL);
        return;
    }
    if (!bench_pick(image, NULL, &w->pixels, values)) bench_fail("picture", NULL);
}

void mesh_judge(const mesh_world *w, const sl_image *image, bench_error errors[MESH_PARTS]) {
    for (int part = 0; part < MESH_PARTS; part++) {
        errors[part] = (bench_error){0};
        if (!w->has[part]) continue;
        mesh_pick(w, image, (mesh_part)part, w->values);
        errors[part] = bench_compare(w->values, &w->reference[part], &w->reference[MESH_ALL]);
    }
}

/* ---- the method ---- */

double mesh_seconds(unsigned threads) { return 1e-3 * (threads > 1 ? wall_ms() : process_ms()); }

sl_settings mesh_settings(const mesh_world *w, sl_quality quality) {
    sl_settings s = sl_settings_default();
    s.method = "multi-mesh";
    s.quality = quality;
    s.width = w->pixels.width;
    s.height = w->pixels.height;
    s.threads = 1;
    return s;
}

void mesh_run_open(mesh_run *run, const sl_scene *scene, sl_settings *settings) {
    sl_error error;
    sl_transport transport;
    *run = (mesh_run){.threads = settings->threads};
    sl_multi_mesh_complete(settings);
    sl_multi_mesh_transport(settings, &transport);
    double from = mesh_seconds(run->threads);
    if (sl_multi_mesh_method.create(scene, settings, &transport, &run->state, &error) != SL_OK)
        bench_fail("multi-mesh", &error);
    run->seconds += mesh_seconds(run->threads) - from;
}

void mesh_run_step(mesh_run *run) {
    sl_error error;
    sl_progress progress = {0};
    double from = mesh_seconds(run->threads);
    if (sl_multi_mesh_method.update(run->state, &progress, &error) != SL_OK) bench_fail("update", &error);
    run->seconds += mesh_seconds(run->threads) - from;
    run->done = progress.done;
}

void mesh_run_edit(mesh_run *run, unsigned changes) {
    sl_error error;
    double from = mesh_seconds(run->threads);
    if (sl_multi_mesh_method.edit(run->state, changes, &error) != SL_OK) bench_fail("edit", &error);
    run->seconds += mesh_seconds(run->threads) - from;
    run->done = false;
}

sl_image *mesh_run_picture(mesh_run *run, double *seconds) {
    sl_error error;
    sl_image *image;
    double from = mesh_seconds(run->threads);
    if (sl_multi_mesh_method.resolve(run->state, &image, &error) != SL_OK) bench_fail("resolve", &error);
    if (seconds) *seconds = mesh_seconds(run->threads) - from;
    return image;
}

uint64_t mesh_run_count(const mesh_run *run, sl_counter counter) {
    return sl_multi_mesh_method.counters(run->state)->value[counter];
}

uint64_t mesh_run_drawn(const mesh_run *run) {
    return mesh_run_count(run, SL_COUNT_LIGHT_SAMPLES) - mesh_run_count(run, SL_COUNT_LIGHT_SAMPLES_SKIPPED);
}

void mesh_run_close(mesh_run *run) {
    sl_multi_mesh_method.destroy(run->state);
    *run = (mesh_run){0};
}
