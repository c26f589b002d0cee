#include "cache/frame/budget.h"

#include "base/error.h"
#include "base/print.h"

#include <stdio.h>
#include <string.h>

/* Code, libraries, stacks, Embree's and OpenMP's own: 17 MB measured with a scene of a thousand triangles. */
static const double program = 32.0 * 1048576.0;

static double all_of(const sl_memory_need *n, const sl_scene *scene) {
    return program + (double)sl_scene_memory_bytes(scene) + n->hierarchies + n->caches + n->picture;
}

static sl_memory_need parts_of(const sl_method_class *method, const sl_scene *scene,
                               const sl_settings *settings) {
    sl_memory_need need = method->need(scene, settings);
    if (sl_method_has_film(method, settings)) need.picture += sl_film_need(scene, settings);
    return need;
}

static double need_of(const sl_method_class *method, const sl_scene *scene, const sl_settings *settings) {
    const sl_memory_need need = parts_of(method, scene, settings);
    return all_of(&need, scene);
}

uint64_t sl_budget_need(const sl_method_class *method, const sl_scene *scene, const sl_settings *settings) {
    double need = need_of(method, scene, settings);
    return need < 9e18 ? (uint64_t)need : (uint64_t)9e18;
}

/* Of what one thread leaves, caches that grow may have that much, however many threads there are; the rest is
 * for more threads. */
static const double of_growth = 0.75;

/* ---- one setting ---- */

/* A setting that can be lowered to save memory, not below `least`; a flag is set. */
typedef struct reduction {
    const char *method, *setting, *what;
    enum { HALVED, ONE_LESS, SET } how;
    double least;
} reduction;

static const reduction reductions[] = {
    {"splatting", "gather-size", "pixels a side of a gather", HALVED, 16.0},
    {"direct-radiance", "direct-radiance.photons", "sample photons a side of a map's face", HALVED, 2.0},
    {"direct-radiance", "direct-radiance.map-size", "texels a side of a map's face", HALVED, 4.0},
    {"direct-radiance", "direct-radiance.shadow-size", "texels a side of a depth cube", HALVED, 64.0},
    {"direct-radiance", "direct-radiance.emitter-samples", "points a side of an area light", HALVED, 1.0},
    {"direct-radiance", "direct-radiance.without-layers", "no layers", SET, 0.0},
    {"light-octree", "light-octree.stored-photons", "stored photons", HALVED, 2000.0},
    {"light-octree", "light-octree.depth", "levels of the octree", ONE_LESS, 3.0},
    {"light-octree", "light-octree.atlas-size", "texels a side of the atlas", HALVED, 64.0},
    {"light-octree", "light-octree.lights", "lights a voxel", HALVED, 1.0},
    {"multi-mesh", "gather-size", "pixels a side of a gather", HALVED, 16.0},
    {"multi-mesh", "multi-mesh.coarse-depth", "levels of the coarse mesh", ONE_LESS, 1.0},
    {"shading-cache", "shading-cache.cache-limit", "patches to a pixel", HALVED, 0.05},
    {"shading-cache", "shading-cache.points", "points an update", HALVED, 16.0},
};
enum { REDUCTIONS = sizeof reductions / sizeof reductions[0] };

/* False: it is as low as it may be, or of another method. */
static bool lower(const sl_method_class *method, sl_settings *settings, const reduction *r) {
    if (strcmp(r->method, method->name) != 0) return false;
    const double value = sl_settings_number(settings, r->setting),
                 lowered = r->how == HALVED ? 0.5 * value : value - 1.0;
    const double reached = lowered > r->least ? lowered : r->least;
    sl_settings_put_number(settings, r->setting, r->how == SET ? 1.0 : reached);
    return r->how == SET ? value == 0.0 : reached < value;
}

/* ---- all of them ---- */

/* The step that saves most; false where none saves anything. */
static bool take_best_step(const sl_method_class *method, const sl_scene *scene, sl_settings *settings,
                           double *need) {
    sl_settings best = *settings;
    double least = *need;
    for (size_t i = 0; i < REDUCTIONS; i++) {
        sl_settings trial = *settings;
        if (!lower(method, &trial, &reductions[i])) continue;
        method->complete(&trial); /* settings that hang together */
        double would_need = need_of(method, scene, &trial);
        if (!(would_need < least)) continue;
        least = would_need;
        best = trial;
    }
    if (!(least < *need)) return false;
    *settings = best;
    *need = least;
    return true;
}

static void tell(const sl_method_class *method, const sl_settings *before, const sl_settings *after,
                 char *text, size_t room) {
    size_t used = 0;
    for (const reduction *r = reductions; r < reductions + REDUCTIONS; r++) {
        const double was = sl_settings_number(before, r->setting), is = sl_settings_number(after, r->setting);
        if (strcmp(r->method, method->name) != 0 || was == is || used >= room) continue;
        int written = r->how == SET ? snprintf(text + used, room - used, "%s%s", used ? ", " : "", r->what)
                                    : sl_print(text + used, room - used, "%s%.9g %s instead of %.9g",
                                               used ? ", " : "", is, r->what, was);
        if (written > 0) used += (size_t)written;
    }
    if (after->threads != before->threads && used < room)
        snprintf(text + used, room - used, "%s%u thread%s instead of %u", used ? ", " : "", after->threads,
                 after->threads > 1 ? "s" : "", before->threads);
}

static sl_status refuse(const sl_method_class *method, const sl_scene *scene, const sl_settings *least,
                        const sl_settings *asked, double beside, sl_error *error) {
    const double mega = 0x1p20;
    const sl_memory_need n = parts_of(method, scene, least);
    char besides[32] = "";
    if (beside > 0.0) snprintf(besides, sizeof besides, ", besides %.0f", beside / mega);
    return sl_fail(error, SL_ERROR_RESOURCES,
                   "%.0fM of memory are not enough: %s needs at least %.0fM for this (program %.0f, scene "
                   "%.0f, hierarchies %.0f, caches %.0f, picture "
                   "%.0f%s); give more memory, a smaller picture or another method",
                   (double)asked->memory_bytes / mega, method->name,
                   (all_of(&n, scene) + beside) / mega + 1.0, program / mega,
                   (double)sl_scene_memory_bytes(scene) / mega, n.hierarchies / mega, n.caches / mega,
                   n.picture / mega, besides);
}

sl_status sl_budget_keep(const sl_method_class *method, const sl_scene *scene, sl_settings *settings,
                         double beside, char *reduced, size_t room, sl_error *error) {
    reduced[0] = '\0';
    if (!settings->memory_bytes) return SL_OK;
    const sl_settings asked = *settings;
    const double budget = (double)asked.memory_bytes - beside;
    settings->threads = 1;
    double need = need_of(method, scene, settings);
    while (need > budget && take_best_step(method, scene, settings, &need)) {}
    if (need > budget) return refuse(method, scene, settings, &asked, beside, error);
    const double left = budget - need;
    settings->memory_bytes = left > 2.0 ? (uint64_t)(of_growth * left) : 1;
    for (sl_settings trial = *settings; trial.threads < asked.threads; settings->threads = trial.threads) {
        trial.threads++;
        if (need_of(method, scene, &trial) > need + (1.0 - of_growth) * left) break;
    }
    tell(method, &asked, settings, reduced, room);
    return SL_OK;
}
