#include "cache/shading_cache/plan.h"

#include <math.h>

#include "cache/frame/budget.h"
#include "scene/features.h"

enum { AREA_SAMPLES = 64, AREA_SAMPLES_ALONE = 100, PATH_DEPTH = 6, FEW = 1024, SMALL_SIDE = 24,
      SMALL = 64 * 64, NOMINAL_RATE = 2000 };

/* A picture of a still scene is done after so many points a pixel: the paper's cache has its quality at 0.03.
 * But every primitive wants its corners and every shadow its edge, however few pixels there are: there are
 * FEW points at least. */
static const double points_a_pixel[] = {[SL_QUALITY_DRAFT] = 0.03, [SL_QUALITY_NORMAL] = 0.12,
                                        [SL_QUALITY_HIGH] = 0.5};

static uint32_t updates_for(const sl_settings *settings) {
    double pixels = (double)settings->width * (double)settings->height,
           points = fmax(points_a_pixel[settings->quality] * pixels, FEW);
    return 1u + (uint32_t)(points / (double)settings->shading_cache.points);
}

/* A patch as small as a pixel shows what is in its middle as long as light changes little over a pixel. Where
 * a room is two pixels wide each of them spans all of its shadows: patches of small pictures are as small as
 * if the shorter side had SMALL_SIDE pixels. */
static double stop_size_for(const sl_settings *settings) {
    double side = fmin(settings->width, settings->height) / (double)SMALL_SIDE;
    return fmin(side * side, 1.0);
}

/* Of small pictures all patches are kept: outlines and what lies beside the picture make them more to a pixel
 * there, and memory is no matter. */
double sl_shading_patch_limit(const sl_settings *settings) {
    return settings->shading_cache.cache_limit * fmax((double)settings->width * (double)settings->height,
                                                      SMALL);
}

void sl_shading_complete(sl_settings *settings) {
    sl_shading_cache_settings *c = &settings->shading_cache;
    int area = c->area == SL_AREA_SAMPLED ? AREA_SAMPLES_ALONE : AREA_SAMPLES;
    sl_settings_complete(settings);
    if (!c->area_samples) c->area_samples = settings->quality == SL_QUALITY_HIGH ? 4 * area : area;
    if (!(c->stop_size > 0.0)) c->stop_size = stop_size_for(settings);
    if (!(c->nominal_rate > 0.0)) c->nominal_rate = NOMINAL_RATE;
    if (c->updates == 0) c->updates = updates_for(settings);
}

sl_shading_plan sl_shading_plan_make(const sl_scene *scene, const sl_settings *settings) {
    sl_features f = sl_scene_features(scene);
    bool lights = f.point_lights || f.spot_lights || f.directional_lights || f.emitters || (f.light &&
        f.emissive_triangles);
    bool surfaces = f.diffuse_triangles || f.glossy_triangles || f.mirror_triangles;
    const sl_shading_cache_settings *c = &settings->shading_cache;
    bool direct = lights && (f.diffuse_triangles || f.glossy_triangles),
         indirect = c->indirect != SL_INDIRECT_NONE && surfaces && (lights || f.environment);
    return (sl_shading_plan){
        .direct = direct,
        .indirect = indirect,
        .caustics = c->caustics && f.mirror_triangles && f.diffuse_triangles && lights,
        .radiance = f.glossy_triangles || f.mirror_triangles,
        .ageing = !c->no_ageing && (f.animated || f.glossy_triangles || f.mirror_triangles),
        .curved = scene->bicubic_count > 0,
        .layers = direct && indirect && !c->variance_aware && !c->no_ageing,
    };
}

/* Everything up to the path depth; mirrors are surfaces whose radiance is cached. */
void sl_shading_transport(const sl_settings *settings, sl_transport *transport) {
    const sl_shading_cache_settings *c = &settings->shading_cache;
    bool indirect = c->indirect != SL_INDIRECT_NONE;
    *transport = (sl_transport){
        .emission = true,
        .sky_light = true,
        .eye_mirrors = indirect,
        .direct_lobes = SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY,
        .receiver_lobes = indirect ? SL_LOBE_DIFFUSE | SL_LOBE_GLOSSY : 0,
        .bounce_lobes = SL_LOBE_ALL,
        .bounces = (uint32_t)(c->path_depth ? c->path_depth : PATH_DEPTH),
        .direct_visibility = true,
        .bounce_visibility = true,
        .filter = SL_FILTER_CENTRE,
    };
}

void sl_shading_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    const sl_shading_cache_settings *c = &settings->shading_cache;
    sl_features f = sl_scene_features(scene);
    sl_shading_plan p = sl_shading_plan_make(scene, settings);
    sl_plan_pass(writer, true, "id map", "%d x %d pixels, %zu triangles", settings->width, settings->height,
                 scene->triangle_count);
    sl_plan_pass(writer, true, "selection", "%d points an update, %u updates", c->points, c->updates);
    sl_plan_pass(writer, p.direct, "direct light",
                 "%d points on each of %zu emissive triangles' lights, a ray to each of %zu others",
                 c->area_samples, f.emitters, f.point_lights + f.spot_lights + f.directional_lights);
    sl_plan_pass(writer, p.indirect, "indirect light", "%d bidirectional paths a point, %d surfaces long",
                 c->indirect_samples, c->path_depth);
    sl_plan_pass(writer, p.caustics, "caustics", "%s",
                 p.caustics           ? "a photon map"
                 : f.mirror_triangles ? "left to the paths"
                                      : "there are no mirrors");
    sl_plan_pass(writer, p.radiance, "radiance towards the eye", "%zu glossy and %zu mirror triangles",
                 f.glossy_triangles, f.mirror_triangles);
    sl_plan_pass(writer, p.ageing, "ageing", "%s",
                 p.ageing ? "what is not diffuse, or moves" : "nothing moves, and all is diffuse");
    sl_plan_pass(writer, p.curved, "tessellation", "%zu bicubic surfaces", scene->bicubic_count);
}

/* ---- memory: beyond a limit, patches to a pixel, those go that were not used for long ---- */

/* ID map 20, leaves 24, the picture 12. For each triangle: primitives with edges and corners, two display
 * copies, roots, a rasterizer. A patch is in the tree and in two copies for the display; twice while arrays
 * grow. Lobes where something is glossy. */
enum { A_PIXEL = 60, A_TRIANGLE = 500, A_PATCH = 204, OF_LOBES = 180, A_CURVED = 40000, A_PHOTON = 150,
      A_THREAD = 1500000 };

sl_memory_need sl_shading_need(const sl_scene *scene, const sl_settings *settings) {
    const sl_shading_plan plan = sl_shading_plan_make(scene, settings);
    const double triangles = (double)scene->triangle_count, patch = A_PATCH + (plan.radiance ? OF_LOBES : 0);
    const double patches = sl_shading_patch_limit(settings);
    double caches = triangles * A_TRIANGLE + patches * patch + (double)scene->bicubic_count * A_CURVED +
                    (plan.caustics ? 4e5 * A_PHOTON : 0.0);
    caches += (double)settings->shading_cache.points * 4000.0 + sl_need_lights(scene) * 400.0;
    return (sl_memory_need){.hierarchies = sl_tracer_memory_need(scene) +
                                           sl_raster_memory_kept(scene->triangle_count),
                            .caches = caches + sl_need_of_threads(settings, A_THREAD) + 4e6,
                            .picture = sl_need_of_pixels(settings, A_PIXEL)};
}
