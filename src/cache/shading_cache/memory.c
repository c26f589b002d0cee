/* What the shading cache takes. It has a limit of its own, patches to a pixel (of small pictures as if they were larger), beyond which patches go that were not used for long. */
#include "cache/frame/budget.h"
#include "cache/shading_cache/plan.h"
#include "scene/features.h"

/* ID map 20, leaves 24, the picture 12. For each triangle: primitives with edges and corners, two display copies, roots, a rasterizer. A patch is in the tree and in two
 * copies for the display; twice while arrays grow. Lobes where something is glossy. */
enum { A_PIXEL = 60, A_TRIANGLE = 460, A_PATCH = 180, OF_LOBES = 160, A_CURVED = 40000, A_PHOTON = 150, A_THREAD = 1500000 };

sl_memory_need sl_shading_need(const sl_scene *scene, const sl_settings *settings) {
    const sl_shading_plan plan = sl_shading_plan_make(scene, settings);
    const double triangles = (double)scene->triangle_count, patch = A_PATCH + (plan.radiance ? OF_LOBES : 0);
    const double patches = sl_shading_patch_limit(settings);
    double caches = triangles * A_TRIANGLE + patches * patch + (double)scene->bicubic_count * A_CURVED + (plan.caustics ? 4e5 * A_PHOTON : 0.0);
    caches += (double)settings->shading_cache.points * 4000.0 + sl_need_lights(scene) * 400.0;
    return (sl_memory_need){.hierarchies = sl_tracer_memory_need(scene->triangle_count) + sl_raster_memory_kept(scene->triangle_count),
                            .caches = caches + sl_need_of_threads(settings, A_THREAD) + 4e6,
                            .picture = sl_need_of_pixels(settings, A_PIXEL)};
}

const sl_concession sl_shading_concessions[] = {{"patches to a pixel", offsetof(sl_settings, shading_cache.cache_limit), SL_CONCEDE_REAL, 0.05},
                                                {"points an update", offsetof(sl_settings, shading_cache.points), SL_CONCEDE_INT, 16.0},
                                                {NULL, 0, SL_CONCEDE_INT, 0.0}};
