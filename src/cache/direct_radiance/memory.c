/* What Direct Radiance Mapping takes: pictures from the lights, for the most part. */
#include "cache/frame/budget.h"
#include "cache/direct_radiance/map_faces.h"
#include "cache/direct_radiance/plan.h"
#include "scene/features.h"

/* A picture has the order of receivers 4 and 13 layers; drawn pass by pass (visibility) 120 more; mirrors tell of two ways a pixel. A texel of a map: 22 planes
 * and the rasterizer's 6. A photon: itself, its lobe, its polygon, and the weights of a reordering. Texels of a depth cube are there twice while it is drawn. */
enum { FACES = 6, LAYERS = 13, A_PIXEL = 8, BY_PASSES = 120, OF_MIRRORS = 140, A_TEXEL = 28 * 4, A_PHOTON = 512, A_THREAD = 2000000, CURVED = 8 };

static double smaller(double a, double b) { return a < b ? a : b; }

/* Maps are taken from no more than SL_MAP_LIGHTS_MAX lights, and from no more points of them than SL_MAP_POINTS_MAX. */
static double light_points(const sl_scene *scene, const sl_radiance_map_settings *m, double *lights) {
    *lights = smaller(sl_need_lights(scene), SL_MAP_LIGHTS_MAX);
    const double n = m->emitter_samples;
    double points = smaller((double)scene->light_count, SL_MAP_LIGHTS_MAX) + n * n * smaller(sl_need_emitters(scene), SL_MAP_LIGHTS_MAX);
    return points;
}

static double map_bytes(const sl_radiance_map_settings *m, double pictures, double directional) {
    const double texels = (double)m->map_size * m->map_size, samples = (double)m->samples * m->samples;
    const double wide = (double)m->samples * sl_parallel_texels(m->samples, m->map_size / m->samples + 1);
    return pictures * FACES * (texels * A_TEXEL + samples * A_PHOTON) + directional * wide * wide * A_TEXEL;
}

sl_memory_need sl_radiance_need(const sl_scene *scene, const sl_settings *settings) {
    const sl_radiance_map_settings *m = &settings->radiance_map;
    const sl_features f = sl_scene_features(scene);
    double lights, points = light_points(scene, m, &lights);
    const double cube = (double)m->shadow_size * m->shadow_size * FACES * sizeof(float);
    const double curved = f.mirror_triangles ? CURVED * 3.0 * FACES * 16.0 * (double)m->cube_size * m->cube_size : 0.0;
    const double layers = m->without_layers ? 3.0 : LAYERS, triangles = (double)scene->triangle_count;
    const bool rays = m->visibility != SL_VISIBILITY_NONE || m->traced_light_mirrors;
    /* Where light comes by planar mirrors each light has a picture more for each of them; a few at most count. */
    const double pictures = smaller(points, SL_MAP_POINTS_MAX) * (f.mirror_triangles ? 3.0 : 1.0);
    const double suns = smaller((double)f.directional_lights, SL_MAP_LIGHTS_MAX);
    return (sl_memory_need){.hierarchies = rays ? sl_tracer_memory_need(scene->triangle_count) + sl_raster_memory_kept(scene->triangle_count)
                                                : sl_raster_memory_need(scene->triangle_count),
                            .caches = points * cube + map_bytes(m, pictures, suns) + curved + sl_need_of_threads(settings, A_THREAD) + 8.0 * triangles + 4e6,
                            .picture = sl_need_of_pixels(settings, A_PIXEL + 4.0 * layers + (m->visibility != SL_VISIBILITY_NONE ? BY_PASSES : 0) +
                                                                       (f.mirror_triangles ? OF_MIRRORS : 0))};
}

const sl_concession sl_radiance_concessions[] = {{"sample photons a side of a map's face", offsetof(sl_settings, radiance_map.samples), SL_CONCEDE_INT, 2.0},
                                                 {"texels a side of a map's face", offsetof(sl_settings, radiance_map.map_size), SL_CONCEDE_INT, 4.0},
                                                 {"texels a side of a depth cube", offsetof(sl_settings, radiance_map.shadow_size), SL_CONCEDE_INT, 64.0},
                                                 {"texels a side of a mirror's cube", offsetof(sl_settings, radiance_map.cube_size), SL_CONCEDE_INT, 16.0},
                                                 {"points a side of an area light", offsetof(sl_settings, radiance_map.emitter_samples), SL_CONCEDE_INT, 1.0},
                                                 {"no layers", offsetof(sl_settings, radiance_map.without_layers), SL_CONCEDE_FLAG, 0.0},
                                                 {NULL, 0, SL_CONCEDE_INT, 0.0}};
