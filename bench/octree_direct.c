/* Photons gathered for pixels, without lights in between: what is wrong with the octree is the difference. */
#include <math.h>
#include <stdlib.h>

#include "cache/light_octree/surroundings.h"
#include "octree_bench.h"

typedef struct surface_area {
    const sl_surroundings *surroundings;
    sl_surroundings_marks *marks; /* of the one thread there is */
    double least_cosine;
} surface_area;

/* As voxel_lights.c: next to no surface means that the disc is nearer to the truth. */
static double area_of(const void *context, const sl_ellipsoid *e, unsigned worker) {
    (void)worker;
    const surface_area *s = context;
    double area = sl_surroundings_area(s->surroundings, e, s->least_cosine, s->marks).front,
           disc = sl_disc_area(e);
    return area > 1e-3 * disc ? area : disc;
}

/* The pixel's light as its voxel sees it. */
static void move_to_voxel(const sl_octree *octree, sl_surface *surface) {
    uint32_t leaf = sl_octree_find(octree, sl_octree_morton_at(octree, surface->position));
    if (leaf == SL_NO_INDEX) return;
    sl_vec3 normal = octree->leaf[leaf].normal;
    surface->position = octree->leaf[leaf].centroid;
    if (sl_dot(normal, normal) > 0.0f)
        surface->geometric_normal =
            sl_dot(normal, surface->geometric_normal) < 0.0f ? sl_neg(normal) : normal;
}

static void find_surfaces(const octree_view *view, const bench_pixels *pixels, const sl_octree *octree,
                          octree_place place, sl_surface *surfaces, sl_vec3 *to_viewer) {
    for (size_t i = 0; i < pixels->count; i++) {
        uint32_t triangle;
        bench_pixel_surface(view->scene, view->tracer, pixels, i, &surfaces[i], &triangle);
        to_viewer[i] = sl_normalize_or(sl_sub(view->scene->camera.eye, surfaces[i].position),
                                       surfaces[i].geometric_normal);
        if (place == OCTREE_AT_VOXEL) move_to_voxel(octree, &surfaces[i]);
    }
}

double octree_direct(const octree_view *view, const bench_pixels *pixels, const sl_octree *octree,
                     const sl_photon_tree *tree, const sl_light_octree_settings *settings, octree_place place,
                     float *values) {
    sl_error error;
    sl_surroundings *surroundings;
    sl_counters counters = {{0}};
    sl_surface *surfaces = calloc(pixels->count + 1, sizeof *surfaces);
    sl_vec3 *to_viewer = calloc(pixels->count + 1, sizeof *to_viewer);
    sl_rgb *radiance = calloc(pixels->count + 1, sizeof *radiance);
    sl_surroundings_marks marks = {calloc(view->scene->triangle_count + 1, sizeof *marks.mark), 0};
    if (!surfaces || !to_viewer || !radiance || !marks.mark) bench_fail("surfaces", NULL);
    find_surfaces(view, pixels, octree, place, surfaces, to_viewer);
    double radius = sl_voxel_radius(octree, (size_t)settings->neighbours, sl_photon_tree_list(tree)->count);
    if (sl_surroundings_create(view->scene, octree, radius / 16.0, 1, &surroundings, &error) != SL_OK)
        bench_fail("surroundings", &error);
    surface_area area = {surroundings, &marks, cos(settings->acceptance)};
    sl_direct_photons photons = {.tree = tree,
                                 .neighbours = (size_t)settings->neighbours,
                                 .radius = radius,
                                 .flatness = settings->flatness,
                                 .cos_acceptance = cos(settings->acceptance),
                                 .area = settings->area == SL_PHOTON_AREA_CLIP ? area_of : NULL,
                                 .area_context = &area,
                                 .threads = 1};
    double from = octree_seconds(1);
    if (sl_direct_photons_radiance(&photons, pixels->count, surfaces, to_viewer, radiance, NULL, &counters,
                                   &error) != SL_OK)
        bench_fail("photons", &error);
    double seconds = octree_seconds(1) - from;
    for (size_t i = 0; i < pixels->count; i++) {
        const float rgb[3] = {radiance[i].r, radiance[i].g, radiance[i].b};
        for (size_t k = 0; k < 3; k++) values[3 * i + k] = rgb[k];
    }
    sl_surroundings_destroy(surroundings);
    free(marks.mark);
    free(radiance);
    free(to_viewer);
    free(surfaces);
    return seconds;
}
