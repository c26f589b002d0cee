/* Which passes run, with what, and in how much memory. */
#include "cache/light_octree/light_octree.h"

#include <stdio.h>

#include "cache/frame/budget.h"
#include "scene/ambient.h"
#include "scene/features.h"

enum { SHALLOWEST_SHOWN = 4 };

void sl_octree_complete(sl_settings *settings) {
    static const uint32_t light_samples[] = {
        [SL_QUALITY_DRAFT] = 8, [SL_QUALITY_NORMAL] = 16, [SL_QUALITY_HIGH] = 64};
    sl_settings_complete(settings);
    if (!settings->spp) settings->spp = light_samples[settings->quality];
}

sl_octree_plan sl_octree_plan_make(const sl_scene *scene, const sl_settings *settings) {
    sl_features f = sl_scene_features(scene);
    const sl_light_octree_settings *o = &settings->light_octree;
    bool receivers = f.diffuse_triangles || f.glossy_triangles;
    return (sl_octree_plan){
        .photons = f.light && receivers,
        .glossy = f.glossy_triangles > 0,
        .mirrors = f.mirror_triangles > 0,
        .direct = f.light && receivers && !o->indirect_only,
        .environment = f.environment,
        .sky = f.environment && !o->indirect_only && o->store == SL_STORE_INDIRECT,
        .first_depth = o->depth < SHALLOWEST_SHOWN || o->photons_at_pixels ? o->depth : SHALLOWEST_SHOWN,
    };
}

/* L (D|G|S)+ (D|G) S* E beside emission and direct light: every path with at least one bounce before the
 * surface that is seen. */
void sl_octree_transport(const sl_settings *settings, sl_transport *transport) {
    *transport = (sl_transport){
        .emission = true,
        .sky_light = true,
        .eye_mirrors = true,
        .direct_lobes = settings->light_octree.indirect_only ? 0 : SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY,
        .receiver_lobes = SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY,
        .bounce_lobes = SL_LOBE_ALL,
        .bounces = SL_BOUNCES_UNLIMITED,
        .direct_visibility = true,
        .bounce_visibility = true,
        .filter = SL_FILTER_CENTRE,
    };
}

/* ---- what can be said before anything has run ---- */

/* Returns how many voxels of that edge surfaces will take: 3/2 A / h^2, since a plane of any tilt meets |n_x|
 * + |n_y| + |n_z| of them in each h^2. */
static double voxels_expected(const sl_scene *scene, double voxel) {
    double area = 0.0, cells = ceil(sl_octree_root_of_central_region(scene).edge / ((1.0 + 1e-4) * voxel));
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        if (!sl_takes_photons(sl_triangle_material(scene, t))) continue;
        area += sl_triangle_area(scene, t);
    }
    return fmin(1.5 * area / (voxel * voxel), cells * cells * cells);
}

/* Lobes narrower than what one of n lights stands for are widened (shade.c). */
bool sl_octree_widens_gloss(const sl_scene *scene, const sl_light_octree_settings *o) {
    bool widens = false;
    if (o->photons_at_pixels || o->lobes == SL_LOBES_NONE) return false;
    for (size_t i = 0; i < scene->material_count; i++) {
        const sl_material *m = &scene->materials[i];
        widens = widens || (sl_material_is_glossy(m) && (double)m->exponent > 2.0 * o->lights - 2.0);
    }
    return widens;
}

static void plan_octree(const sl_scene *scene, const sl_light_octree_settings *o, const sl_octree_plan *p,
                        sl_plan_writer *writer) {
    double voxel = sl_octree_root_of_central_region(scene).edge / (1.0 + 1e-4) / (double)(1u << o->depth),
           voxels = voxel > 0.0 ? voxels_expected(scene, voxel) : 0.0;
    double a_voxel = voxels > 1.0 ? (double)o->photons / voxels : (double)o->photons;
    char few[160] = "";
    if (a_voxel < SL_OCTREE_FEW_PHOTONS * o->neighbours)
        snprintf(few, sizeof few, ", less than a tenth of %d: %s", o->neighbours,
                 o->own_photons ? "too few to count by voxels" : "they come from far beyond the voxel");
    sl_plan_pass(writer, p->photons, "octree",
                 "depth %d, shown from depth %d on; about %.2g voxels, %.2g photons each%s%s", o->depth,
                 p->first_depth, voxels, a_voxel, few,
                 sl_scene_is_scattered(scene) ? "; around the scene's central region alone if most photons "
                                                "lie there, since parts of it are far apart"
                                              : "");
}

void sl_octree_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    static const char *const stores[] = {"after a bounce at least", "all", "caustics alone"};
    static const char *const areas[] = {"the scene's triangles in the ellipsoid", "the section of a plane",
                                        "a disc"};
    static const char *const lobes[] = {"directional lights, perpendicular irradiance",
                                        "directional lights, irradiance on the surface", "one irradiance"};
    const sl_light_octree_settings *o = &settings->light_octree;
    sl_features f = sl_scene_features(scene);
    sl_octree_plan p = sl_octree_plan_make(scene, settings);
    sl_plan_pass(writer, p.photons, "photons", "%llu to be stored, %s", (unsigned long long)o->photons,
                 stores[o->store]);
    plan_octree(scene, o, &p, writer);
    if (o->photons_at_pixels)
        sl_plan_pass(writer, p.photons, "gathers", "the %d nearest photons of each pixel, spread over %s",
                     o->neighbours, areas[o->area == SL_PHOTON_AREA_SECTION ? SL_PHOTON_AREA_DISC : o->area]);
    else if (o->own_photons) sl_plan_pass(writer, p.photons, "gathers", "each voxel's own photons");
    else
        sl_plan_pass(writer, p.photons, "gathers", "the %d nearest photons of each %s, spread over %s",
                     o->neighbours,
                     o->whole_voxels ? "voxel" : "group of normals in a voxel", areas[o->area]);
    bool directional = !o->photons_at_pixels && o->lobes != SL_LOBES_NONE;
    sl_plan_pass(
        writer, p.photons && directional, "clusters", "%s; at most %d a voxel%s", lobes[o->lobes], o->lights,
        sl_octree_widens_gloss(scene, o) ? "; gloss sharper than that shows indirect light blurred" : "");
    sl_plan_pass(writer, p.photons && o->atlas, "atlas", "%d x %d texels%s", o->atlas_size, o->atlas_size,
                 o->atlas && p.glossy ? "; glossy surfaces look into the octree" : "");
    sl_plan_pass(writer, true, "G-buffer", "%d x %d pixels, %zu triangles", settings->width, settings->height,
                 scene->triangle_count);
    sl_plan_pass(writer, p.mirrors, "mirrors", "%zu mirror triangles, %s", f.mirror_triangles,
                 o->environment_mirrors ? "which show the environment alone" : "followed by rays");
    sl_plan_pass(writer, p.direct, "direct light", "%u light samples a pixel", (unsigned)settings->spp);
    sl_plan_pass(writer, p.sky, "sky in the octree", "%s",
                 p.sky           ? "its first hits are photons too; what stands out of it is sampled"
                 : f.environment ? "all of it is sampled"
                                 : "no environment");
    sl_plan_pass(writer, f.emitters || f.environment, "emission", "%zu emissive triangles%s", f.emitters,
                 f.environment ? ", environment" : "");
}

/* ---- memory ---- */

/* G-buffer 64, planes 24, picture 48. A photon lies in its list (half as large again while that grows, and
 * once more while it does) and in the tree. A path leaves 1 / (1 - rho) photons in the mean, which its
 * chunk's list holds twice, with room to grow, before they are committed. Triangles are listed in every voxel
 * that they meet; lists are sorted. */
enum {
    A_PIXEL = 144,
    OF_MIRRORS = 96,
    A_PHOTON = 150,
    A_TRIANGLE = 180,
    A_HIT = 152,
    A_TEXEL = 44,
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
    const double of_lights = (double)o->lights * 40.0;
    return voxels * (160.0 + 2.0 * of_lights) * 1.5;
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
    if (scene->animation) caches += (double)o->photons * A_PHOTON / SL_OCTREE_SLICES; /* motion.c */
    if (o->atlas) caches += (double)o->atlas_size * o->atlas_size * A_TEXEL;
    caches += sl_need_lights(scene) * 400.0 + sl_need_of_threads(settings, A_THREAD) + sky;
    return (sl_memory_need){.hierarchies = sl_tracer_memory_need(scene) +
                                           sl_raster_memory_kept(scene->triangle_count),
                            .caches = caches,
                            .picture =
                                sl_need_of_pixels(settings, A_PIXEL + (plan.mirrors ? OF_MIRRORS : 0))};
}
