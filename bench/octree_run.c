/* The passes of the light octree, one by one and timed. */
#include "octree_bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "timing.h"

enum { DEPTH = 6 }; /* the paper's, whatever quality has */

double octree_seconds(unsigned threads) { return 1e-3 * (threads > 1 ? wall_ms() : process_ms()); }

sl_light_octree_settings octree_settings(void) {
    sl_settings s = sl_settings_default();
    s.light_octree.depth = DEPTH;
    sl_octree_complete(&s);
    return s.light_octree;
}

/* ---- passes ---- */

sl_photon_tree *octree_photons(const sl_scene *scene, const sl_tracer *tracer,
                               const sl_light_octree_settings *settings, uint64_t seed, unsigned threads,
                               double seconds[2], sl_counters *counters) {
    sl_photon_options options = {
        .stored = settings->photons, .store = settings->store, .seed = seed, .threads = threads};
    sl_photon_list *list = NULL;
    sl_photon_tree *tree;
    sl_error error;
    double from = octree_seconds(threads);
    for (bool done = false; !done;) {
        if (sl_photons_trace(scene, tracer, &options, 16, &list, &done, counters, &error) != SL_OK)
            bench_fail("photons", &error);
    }
    seconds[0] = octree_seconds(threads) - from;
    from = octree_seconds(threads);
    if (sl_photon_tree_create(list, threads, &tree, &error) != SL_OK) bench_fail("photon tree", &error);
    seconds[1] = octree_seconds(threads) - from;
    return tree;
}

sl_octree *octree_voxels(const sl_scene *scene, int depth, unsigned threads, double *seconds) {
    sl_octree *octree;
    sl_error error;
    double from = octree_seconds(threads);
    if (sl_octree_create(scene, depth, 0.0, threads, &octree, &error) != SL_OK) bench_fail("octree", &error);
    *seconds = octree_seconds(threads) - from;
    return octree;
}

void octree_light_voxels(const sl_scene *scene, const sl_octree *octree, const sl_photon_tree *tree,
                         const sl_light_octree_settings *settings, unsigned threads, octree_light *light) {
    sl_error error;
    sl_counters counters = {{0}};
    double radius = settings->radius;
    double from = octree_seconds(threads);
    if (!(radius > 0.0))
        radius = sl_voxel_radius(octree, (size_t)settings->neighbours, sl_photon_tree_list(tree)->count);
    sl_voxel_light_options options = sl_octree_light_options(settings, radius);
    if (sl_voxel_lights_create(scene, octree, tree, &options, threads, &light->lights, &error) !=
        SL_OK)
        bench_fail("lights", &error);
    sl_voxel_lights_compute(light->lights, 0, octree->leaf_count, threads, &counters);
    light->seconds[0] = octree_seconds(threads) - from;
    from = octree_seconds(threads);
    if (sl_voxel_texture_create(octree, light->lights, octree->depth <= 7, &light->texture, &error) != SL_OK)
        bench_fail("texture", &error);
    light->seconds[1] = octree_seconds(threads) - from;
}

void octree_light_free(octree_light *light) {
    sl_voxel_texture_destroy(light->texture);
    sl_voxel_lights_destroy(light->lights);
    *light = (octree_light){0};
}

/* ---- views ---- */

bool octree_view_open(bench_report *r, const char *path, int width, int height, octree_view *v) {
    sl_error error;
    memset(v, 0, sizeof *v);
    if (!bench_open_scene(r, path, &v->scene)) return false;
    double from = octree_seconds(1);
    if (sl_tracer_create(v->scene, 1, NULL, &v->tracer, &error) != SL_OK) bench_fail("tracer", &error);
    v->embree = octree_seconds(1) - from;
    v->view = sl_view_scene(v->scene, width, height);
    if (sl_raster_create(v->scene, 1, &v->raster, &error) != SL_OK ||
        sl_gbuffer_create(width, height, &v->gbuffer, &error) != SL_OK)
        bench_fail("rasterizer", &error);
    for (int i = 0; i < 2; i++) { /* memory is touched first */
        from = octree_seconds(1);
        if (sl_raster_gbuffer(v->raster, &v->view, 1, v->gbuffer, &v->counters, &error) != SL_OK)
            bench_fail("G-buffer", &error);
        v->gbuffer_seconds = octree_seconds(1) - from;
    }
    v->planes[0] = calloc(3 * (size_t)width * (size_t)height, sizeof(float));
    if (!v->planes[0]) bench_fail("picture", NULL);
    for (int k = 1; k < 3; k++) v->planes[k] = v->planes[k - 1] + (size_t)width * (size_t)height;
    return true;
}

void octree_view_close(octree_view *v) {
    free(v->planes[0]);
    sl_gbuffer_destroy(v->gbuffer);
    sl_raster_destroy(v->raster);
    sl_tracer_destroy(v->tracer);
    sl_scene_destroy(v->scene);
    *v = (octree_view){0};
}

double octree_shade_view(octree_view *v, const sl_octree_shading *shading, unsigned threads) {
    sl_error error;
    v->counters = (sl_counters){{0}};
    double from = octree_seconds(threads);
    if (sl_octree_shade_gbuffer(shading, v->scene, v->gbuffer, v->scene->camera.eye, threads, v->planes[0],
                                v->planes[1], v->planes[2], &v->counters, &error) != SL_OK)
        bench_fail("shading", &error);
    return octree_seconds(threads) - from;
}

void octree_view_pick(const octree_view *v, const bench_pixels *pixels, float *values) {
    size_t width = (size_t)pixels->width, height = (size_t)pixels->height;
    for (size_t i = 0; i < pixels->count; i++) {
        size_t x = pixels->index[i] % width, y = pixels->index[i] / width;
        for (size_t k = 0; k < 3; k++) values[3 * i + k] = v->planes[k][(height - 1 - y) * width + x];
    }
}

void octree_view_write(const octree_view *v, const bench_report *r, const char *scene, const char *what) {
    static char exposed[64];
    static float stops;
    sl_image *image;
    sl_error error;
    char path[700];
    size_t width = (size_t)v->gbuffer->width, height = (size_t)v->gbuffer->height;
    double sum = 0.0, count = 0.0;
    if (sl_image_create((int)width, (int)height, 3, NULL, &image, &error) != SL_OK)
        bench_fail("picture", &error);
    for (size_t i = 0; i < 3 * width * height; i++) {
        size_t k = i / (width * height), at = i % (width * height);
        float value = v->planes[k][at];
        image->planes[k * width * height + (height - 1 - at / width) * width + at % width] = value;
        if (value > 0.0f) sum += log2((double)value), count++;
    }
    if (strcmp(exposed, scene) != 0) {
        snprintf(exposed, sizeof exposed, "%s", scene);
        stops = count > 0.0 ? (float)(-2.0 - sum / count) : 0.0f;
    }
    snprintf(path, sizeof path, "%s/%s-%s.png", r->folder, scene, what);
    sl_tone tone = {SL_TONE_REINHARD, stops, false};
    if (sl_image_write_png(image, path, tone, &error) != SL_OK) fprintf(stderr, "%s\n", error.message);
    sl_image_destroy(image);
}
