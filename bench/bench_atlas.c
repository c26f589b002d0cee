/* The texture atlas of the light octree: seconds, charts, stretch and coverage, on the generated scenes and on meshes where they are present.
 *
 *   bench_atlas [--size TEXELS] [--threads N] [--shared DIRECTORY] [SCENE ...] */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cache/light_octree/atlas/atlas.h"
#include "timing.h"

static const char *const GENERATED[] = {"room", "atrium", "cathedral", "cave", "figure"};
static const char *const SHARED[] = {"meshes/stanford-bunny.obj", "meshes/stanford-dragon-100k.obj", "sponza-dabrovic/sponza-dabrovic.obj"};

static const char *name_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Area-weighted root mean square of a triangle's density over the common one, and the share of the area that has less than half of it. */
static void density_spread(const sl_scene *scene, const sl_atlas *a, double *spread_of, double *sparse) {
    double area = 0.0, squares = 0.0, thin = 0.0;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        sl_vec3d p[3];
        const float *s = a->coordinates + 6 * t;
        for (size_t k = 0; k < 3; k++) p[k] = sl_to_double(sl_scene_position(scene, scene->vertex[k][t]));
        double twice = sl_lengthd(sl_crossd(sl_subd(p[1], p[0]), sl_subd(p[2], p[0])));
        double mapped = ((double)s[2] - (double)s[0]) * ((double)s[5] - (double)s[1]) - ((double)s[3] - (double)s[1]) * ((double)s[4] - (double)s[0]);
        double density = sqrt(fabs(mapped) / twice) * a->size / a->texels_per_unit;
        area += twice;
        squares += twice * (density - 1.0) * (density - 1.0);
        if (density < 0.5) thin += twice;
    }
    *spread_of = area > 0.0 ? sqrt(squares / area) : 0.0;
    *sparse = area > 0.0 ? thin / area : 0.0;
}

static void measure(const char *path, int size, unsigned threads) {
    sl_scene *scene = NULL;
    sl_atlas *atlas = NULL;
    sl_error error = {.message = ""};
    sl_atlas_settings settings = {.size = size, .gutter = 2, .bend = 75.0 * 3.14159265358979323846 / 180.0, .threads = threads};
    if (sl_scene_load_with(path, &(sl_load_options){.allow_outside = true}, &scene, &error) != SL_OK) {
        printf("%-26s not present: %s\n", name_of(path), error.message);
        return;
    }
    double wall = wall_ms(), cpu = process_ms();
    sl_status status = sl_atlas_create(scene, &settings, &atlas, &error);
    wall = wall_ms() - wall;
    cpu = process_ms() - cpu;
    if (status == SL_OK) {
        double uneven, sparse, texels = process_ms();
        size_t count = (size_t)size * (size_t)size;
        uint32_t *triangle = malloc(count * sizeof *triangle);
        float *w = malloc(2 * count * sizeof *w);
        if (triangle && w && sl_atlas_texels(atlas, scene, 2, threads, triangle, w, w + count, &error) != SL_OK) printf("%s\n", error.message);
        texels = process_ms() - texels;
        free(triangle);
        free(w);
        density_spread(scene, atlas, &uneven, &sparse);
        printf("%-26s %8zu %5d %7zu %7zu %8.4f %8.3f %7.1f%% %8.1f%% %9.2f %8.2f %8.2f %8.2f\n", name_of(path), scene->triangle_count, size,
               atlas->chart_count, atlas->single, atlas->stretch, uneven, 100.0 * sparse, 100.0 * atlas->coverage, atlas->texels_per_unit, 1e-3 * wall,
               1e-3 * cpu, 1e-3 * texels);
    } else {
        printf("%-26s %s\n", name_of(path), error.message);
    }
    fflush(stdout);
    sl_atlas_destroy(atlas);
    sl_scene_destroy(scene);
}

int main(int argc, char **argv) {
    int size = 1024, scenes = 0;
    unsigned threads = 1;
    const char *shared = "../shared/scenes";
    char path[1024];
    for (int i = 1; i < argc; i++) {
        bool more = i + 1 < argc;
        if (!strcmp(argv[i], "--size") && more) size = atoi(argv[++i]);
        else if (!strcmp(argv[i], "--threads") && more) threads = (unsigned)atoi(argv[++i]);
        else if (!strcmp(argv[i], "--shared") && more) shared = argv[++i];
        else argv[++scenes] = argv[i];
    }
    printf("%-26s %8s %5s %7s %7s %8s %8s %8s %9s %9s %8s %8s %8s\n", "scene", "faces", "size", "charts", "single", "stretch", "uneven", "sparse",
           "coverage", "texels/u", "wall s", "cpu s", "texels s");
    for (int i = 1; i <= scenes; i++) measure(argv[i], size, threads);
    for (size_t i = 0; !scenes && i < sizeof GENERATED / sizeof *GENERATED; i++) {
        snprintf(path, sizeof path, "scenes/generated/%s.json", GENERATED[i]);
        measure(path, i == 4 ? 4 * size : size, threads); /* the figure has as many triangles as 1024 x 1024 has texels */
    }
    for (size_t i = 0; !scenes && i < sizeof SHARED / sizeof *SHARED; i++) {
        snprintf(path, sizeof path, "%s/%s", shared, SHARED[i]);
        measure(path, size, threads);
    }
    return 0;
}
