/* Direct light of pixels: processor seconds and error, by shadow rays and by shadow maps.
 *
 *   bench_direct SCENE SIZE rays|maps [light samples] [reference.exr]
 *
 * The reference is the direct light alone, of SIZE x SIZE pixels:
 *   softlux render SCENE -m path --transport direct --set filter=centre -s SIZExSIZE --spp 4096 -o reference.exr
 * Seconds are those of one thread, the least of five frames. */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/math.h"
#include "cache/light/direct.h"

typedef struct {
    sl_scene *scene;
    sl_raster *raster;
    sl_tracer *tracer;
    sl_shadow_maps *maps;
    sl_direct *direct;
    sl_environment sky, sun;
    sl_gbuffer *gbuffer;
    sl_image *image;
    float *planes;
    sl_counters counters;
} bench;

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void check(sl_status status, const sl_error *error) {
    if (status == SL_OK) return;
    fprintf(stderr, "bench_direct: %s\n", error->message);
    exit(1);
}

static void draw_gbuffer(bench *b, int size, sl_error *error) {
    const sl_camera *camera = &b->scene->camera;
    sl_frame frame = {camera->right, camera->up, sl_neg(camera->back)};
    float top = (float)sl_tan(0.5 * (double)camera->vertical_fov);
    sl_view view = sl_view_pyramid(&frame, camera->eye, -top, top, -top, top, size, size, 1e-5f * b->scene->scale);
    check(sl_gbuffer_create(size, size, &b->gbuffer, error), error);
    check(sl_raster_gbuffer(b->raster, &view, 1, b->gbuffer, &b->counters, error), error);
}

static void prepare(bench *b, const char *path, int size, bool maps, uint32_t samples) {
    sl_error error;
    check(sl_scene_load_with(path, &(sl_load_options){.allow_outside = true}, &b->scene, &error), &error);
    check(sl_raster_create(b->scene, 1, &b->raster, &error), &error);
    check(sl_tracer_create(b->scene, 1, NULL, &b->tracer, &error), &error);
    check(sl_environment_split(&b->scene->environment, 10.0, &b->sky, &b->sun, &error), &error);
    double start = cpu_seconds();
    const sl_environment *sun = b->sun.present ? &b->sun : NULL;
    sl_shadow_map_settings settings = {SL_SHADOW_MAP_SIZE, sun, NULL, 1};
    if (maps) check(sl_shadow_maps_create(b->scene, b->raster, &settings, &b->maps, &b->counters, &error), &error);
    if (maps)
        printf("maps made in %.1f ms, %.1f MB\n", 1e3 * (cpu_seconds() - start),
               1e-6 * (double)sl_shadow_maps_bytes(b->maps));
    sl_direct_settings direct = {.light_samples = samples, .threads = 1, .maps = b->maps, .sun = sun};
    check(sl_direct_create(b->scene, b->tracer, &direct, &b->direct, &error), &error);
    draw_gbuffer(b, size, &error);
    check(sl_image_create(size, size, 3, NULL, &b->image, &error), &error);
    b->planes = calloc(3 * (size_t)size * (size_t)size, sizeof *b->planes);
    if (!b->planes) exit(1);
}

static void light(bench *b, int size) {
    enum { FRAMES = 5, ROWS = 64 };
    double least = 1e30;
    size_t pixels = (size_t)size * (size_t)size;
    sl_error error;
    sl_counters before = b->counters;
    for (int frame = 0; frame < FRAMES; frame++) {
        double start = cpu_seconds();
        b->counters = before;
        for (int row = 0; row < size; row += ROWS) {
            int end = row + ROWS < size ? row + ROWS : size;
            check(sl_direct_rows(b->direct, b->gbuffer, row, end, b->planes, b->planes + pixels, b->planes + 2 * pixels,
                                 &b->counters, &error),
                  &error);
        }
        double seconds = cpu_seconds() - start;
        least = seconds < least ? seconds : least;
    }
    printf("%.2f ms a frame, %.1f ns a pixel, %.2f shadow rays and %.2f lookups a pixel\n", 1e3 * least,
           1e9 * least / (double)pixels, (double)b->counters.value[SL_COUNT_SHADOW_RAYS] / (double)pixels,
           (double)b->counters.value[SL_COUNT_SHADOW_LOOKUPS] / (double)pixels);
}

/* Where emission or the background is seen, the reference holds that too: those pixels are taken from it. */
static void compare(bench *b, int size, const char *path) {
    sl_error error;
    sl_image *reference;
    sl_comparison result;
    check(sl_image_read(path, &reference, &error), &error);
    size_t pixels = (size_t)size * (size_t)size;
    static const char *const names[3] = {"R", "G", "B"};
    for (size_t c = 0; c < 3; c++) {
        float *plane = b->image->planes + c * pixels;
        const float *other = sl_image_channel(reference, names[c]);
        sl_raster_flip(b->planes + c * pixels, size, size, plane);
        for (int i = 0; i < (int)pixels; i++) {
            uint32_t material = b->gbuffer->material[(size - 1 - i / size) * size + i % size];
            if (material == SL_NO_INDEX || sl_material_is_emitter(&b->scene->materials[material])) plane[i] = other[i];
        }
    }
    check(sl_image_compare(b->image, reference, NULL, &result, NULL, &error), &error);
    printf("relMSE %.6f (%.6f without the largest 0.1 %%, noise of the reference %.6f), bias %+.5f\n", result.rel_mse,
           result.rel_mse_trimmed, result.rel_mse_noise, result.bias);
    sl_image_destroy(reference);
}

int main(int argc, char **argv) {
    if (argc < 4) {
        fprintf(stderr, "usage: bench_direct SCENE SIZE rays|maps [light samples] [reference.exr]\n");
        return 2;
    }
    int size = atoi(argv[2]);
    bench b = {0};
    prepare(&b, argv[1], size, strcmp(argv[3], "maps") == 0, argc > 4 ? (uint32_t)atoi(argv[4]) : 8);
    light(&b, size);
    if (argc > 5) compare(&b, size, argv[5]);
    sl_image_destroy(b.image);
    sl_gbuffer_destroy(b.gbuffer);
    sl_direct_destroy(b.direct);
    sl_shadow_maps_destroy(b.maps);
    sl_tracer_destroy(b.tracer);
    sl_raster_destroy(b.raster);
    sl_environment_release(&b.sky);
    sl_environment_release(&b.sun);
    sl_scene_destroy(b.scene);
    free(b.planes);
    return 0;
}
