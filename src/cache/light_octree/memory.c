/* What the light octree takes: photons, and what its voxels hold. */
#include "cache/frame/budget.h"
#include "cache/light_octree/octree.h"
#include "cache/photons/photons.h"
#include "cache/light_octree/plan.h"
#include "scene/features.h"

/* G-buffer 64, planes 24, picture 48. A photon lies in its list (half as large again while that grows, and
 * once more while it does) and in the tree. A path leaves 1 / (1 - rho) photons in the mean, which its
 * chunk's list holds twice, with room to grow, before they are committed. Triangles are listed in every voxel
 * that they meet; lists are sorted. */
enum {
    A_PIXEL = 140,
    OF_MIRRORS = 96,
    A_PHOTON = 150,
    A_TRIANGLE = 180,
    A_HIT = 152,
    A_TEXEL = 40,
    A_THREAD = 3000000
};

/* The same photons come however many chunks are traced at a time. */
size_t sl_octree_photon_chunks(const sl_settings *settings) {
    enum { CHUNKS = 16, CHUNKS_BOUNDED = 2 };
    return settings->memory_bytes ? CHUNKS_BOUNDED : CHUNKS;
}

static double chunk_bytes(const sl_scene *scene) {
    enum { BOUNCES_MAX = 64 };
    double brightest = 0.0;
    for (size_t i = 0; i < scene->material_count; i++) {
        const sl_material *m = &scene->materials[i];
        double rho = (double)sl_rgb_max(sl_rgb_add(sl_rgb_add(m->diffuse, m->specular), m->mirror));
        brightest = rho > brightest ? rho : brightest;
    }
    double hits = brightest < 0.98 ? 1.0 / (1.0 - brightest) : BOUNCES_MAX;
    return SL_PHOTON_CHUNK * (hits < BOUNCES_MAX ? hits : BOUNCES_MAX) * A_HIT;
}

/* Voxels that a surface meets: six faces of the root cube and as much inside, or a few for each triangle.
 * Each has sets of lights for its normals, in the making, as textures, and unpacked. */
static double voxel_bytes(const sl_light_octree_settings *o, double triangles) {
    const double side = (double)(1 << o->depth), cells = side * side * side;
    double voxels = 12.0 * side * side, by_triangles = 40.0 * triangles + 64.0;
    voxels = voxels < by_triangles ? voxels : by_triangles;
    voxels = voxels < cells ? voxels : cells;
    const double of_lights = (double)o->lights * 40.0, index = o->depth <= 7 ? 4.0 * cells : 0.0;
    return voxels * (160.0 + 2.0 * of_lights) * 1.5 + index;
}

sl_memory_need sl_octree_need(const sl_scene *scene, const sl_settings *settings) {
    const sl_light_octree_settings *o = &settings->light_octree;
    const sl_octree_plan plan = sl_octree_plan_make(scene, settings);
    const double triangles = (double)scene->triangle_count,
                 sky = 20.0 * (double)scene->environment.width * (double)scene->environment.height;
    double caches = plan.photons ? (double)o->photons * A_PHOTON +
                                       (double)sl_octree_photon_chunks(settings) * chunk_bytes(scene) +
                                       triangles * A_TRIANGLE + voxel_bytes(o, triangles)
                                 : 0.0;
    if (o->atlas) caches += (double)o->atlas_size * o->atlas_size * A_TEXEL;
    caches += sl_need_lights(scene) * 400.0 + sl_need_of_threads(settings, A_THREAD) + sky;
    return (sl_memory_need){.hierarchies = sl_tracer_memory_need(scene->triangle_count) +
                                           sl_raster_memory_kept(scene->triangle_count),
                            .caches = caches,
                            .picture =
                                sl_need_of_pixels(settings, A_PIXEL + (plan.mirrors ? OF_MIRRORS : 0))};
}

const sl_reduction sl_octree_reductions[] = {
    {"stored photons", offsetof(sl_settings, light_octree.photons), SL_REDUCE_COUNT, 2000.0},
    {"levels of the octree", offsetof(sl_settings, light_octree.depth), SL_REDUCE_LEVEL, 3.0},
    {"texels a side of the atlas", offsetof(sl_settings, light_octree.atlas_size), SL_REDUCE_INT, 64.0},
    {"lights a voxel", offsetof(sl_settings, light_octree.lights), SL_REDUCE_INT, 1.0},
    {NULL, 0, SL_REDUCE_INT, 0.0}};
