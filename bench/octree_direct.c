/* Photons gathered for pixels, without lights in between: what is wrong with the octree is the difference. */
#include <math.h>
#include <stdlib.h>

#include "cache/light_octree/photon_pixels.h"
#include "octree_bench.h"

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
    sl_voxel_lights *lights;
    sl_surface *surfaces = calloc(pixels->count + 1, sizeof *surfaces);
    sl_vec3 *to_viewer = calloc(pixels->count + 1, sizeof *to_viewer);
    if (!surfaces || !to_viewer) bench_fail("surfaces", NULL);
    find_surfaces(view, pixels, octree, place, surfaces, to_viewer);
    double radius = sl_voxel_radius(octree, (size_t)settings->neighbours, sl_photon_tree_list(tree)->count);
    sl_voxel_light_options options = sl_octree_light_options(settings, radius);
    if (sl_voxel_lights_create(view->scene, octree, tree, &options, 1, &lights, &error) != SL_OK)
        bench_fail("photons", &error);
    double from = octree_seconds(1);
    for (size_t i = 0; i < pixels->count; i++) {
        sl_rgb radiance = sl_photons_radiance(lights, 0, &surfaces[i], to_viewer[i]);
        const float rgb[3] = {radiance.r, radiance.g, radiance.b};
        for (size_t k = 0; k < 3; k++) values[3 * i + k] = rgb[k];
    }
    double seconds = octree_seconds(1) - from;
    sl_voxel_lights_destroy(lights);
    free(to_viewer);
    free(surfaces);
    return seconds;
}
