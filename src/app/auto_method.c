/* Choosing a method. What a scene's picture is made of is measured, by path tracing small pictures of parts
 * of its light:
 *
 *     direct      straight from the lights
 *     one bounce  and by one diffuse surface
 *     surfaces    and by any number of surfaces, mirrors too
 *     all         and of lights without extent by mirrors, which no path from the eye meets
 *
 * Their differences in the mean, and what surfaces and lights there are, say which method is soonest within
 * the error that the picture may have, as measured in many scenes (docs/error-estimates.md). */
#include "app/auto_method.h"

#include "cache/frame/all_light.h"
#include "scene/features.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- where its light comes from -------------------------------------------------------------- */

enum { SAMPLES = 16, MANY_LIGHTS = 50 };

/* A summary of a scene. */
typedef struct scene_kind {
    /* shares of the mean radiance: straight from lights, by one surface, by more, by mirrors of lights
     * without extent; they sum to 1 where there is any */
    double direct, second, further, mirrored;
    bool lit, many_lights;
} scene_kind;

/* Tells where the scene's light comes from, and what it is made of. */
static sl_status look_at(const sl_scene *scene, const sl_settings *base, scene_kind *k, sl_error *error) {
    sl_features f = sl_scene_features(scene);
    const size_t dots = f.point_lights + f.spot_lights + f.directional_lights,
                 kinds = f.mirror_triangles && dots ? 4 : 3;
    const sl_light_paths paths[] = {
        {"path", "direct"}, {"path", "one-bounce"}, {"path", "full"}, {"bidirectional", "full"}};
    double light[4] = {0.0};
    sl_status status = sl_measure_light(scene, base, paths, kinds, SAMPLES, light, error);
    for (int i = 1; i < 4; i++) light[i] = fmax(light[i], light[i - 1]); /* noise makes no share negative */
    double direct = light[0], one = light[1], surfaces = light[2], all = light[3];
    *k = (scene_kind){.lit = all > 0.0, .many_lights = f.emitters + dots >= MANY_LIGHTS};
    if (!k->lit) return status;
    k->direct = direct / all;
    k->second = (one - direct) / all;
    k->further = (surfaces - one) / all;
    k->mirrored = (all - surfaces) / all;
    return status;
}

/* ---- the choice ------------------------------------------------------------------------------ */

/* Returns what may be left out of a picture: the error asked for, or what a quality and a time are good for.
 */
static double tolerance_of(const sl_auto_budget *b) {
    static const double of_quality[] = {
        [SL_QUALITY_DRAFT] = 0.15, [SL_QUALITY_NORMAL] = 0.1, [SL_QUALITY_HIGH] = 0.05};
    return b->error > 0.0 ? b->error : of_quality[b->quality];
}

/* Tells whether a picture may be so rough that voxels do not blur too much of it. */
static bool is_rough(const sl_auto_budget *b) {
    if (b->error > 0.0) return b->error >= 0.1;
    return b->time_seconds > 0.0 ? b->time_seconds < 1.0 : b->quality == SL_QUALITY_DRAFT;
}

/* Chooses the first that holds, and returns why. Light that is missing is not missing evenly: in the Cornell
 * box 9 % of it are 18 % of relative RMSE. */
static const char *choose(const scene_kind *k, const sl_auto_budget *b, sl_auto_choice *c) {
    const double tolerance = tolerance_of(b);
    c->method = "path";
    if (!k->lit) return "nothing in the picture is lit";
    if (b->things_move) return c->method = "direct-radiance", "every frame anew, whatever moves";
    if (2.0 * (1.0 - k->direct) <= tolerance) return "a few light samples a pixel are exact soon";
    if (is_rough(b)) return c->method = "light-octree", "it has all light soonest, a little blurred";
    if (2.0 * k->mirrored > tolerance)
        return c->method = "bidirectional",
               "no path from the eye finds what mirrors throw of lights without extent";
    if (k->many_lights) return "so many lights' edges of shadows are not to be cached";
    c->method = "splatting";
    return "indirect light changes slowly, and is soonest found in records";
}

static void tell(const scene_kind *kind, const char *because, sl_auto_choice *choice) {
    char light[160] = "";
    if (kind->lit)
        snprintf(light, sizeof light,
                 " of the light %.0f %% is direct, %.0f %% comes by one diffuse surface, %.0f %% by more, "
                 "%.0f %% by mirrors;",
                 100.0 * kind->direct, 100.0 * kind->second, 100.0 * kind->further, 100.0 * kind->mirrored);
    snprintf(choice->why, sizeof choice->why, "%s:%s %s", choice->method, light, because);
}

sl_status sl_auto_method(const sl_scene *scene, const sl_settings *settings, const sl_auto_budget *budget,
                         sl_auto_choice *choice, sl_error *error) {
    scene_kind k = {0};
    *choice = (sl_auto_choice){.method = "path"};
    sl_status status = look_at(scene, settings, &k, error);
    if (status == SL_OK) tell(&k, choose(&k, budget, choice), choice);
    return status;
}

sl_status sl_auto_settle(const sl_scene *scene, const sl_auto_budget *budget, bool quiet,
                         sl_settings *settings, sl_error *error) {
    sl_auto_choice choice;
    if (!settings->method || strcmp(settings->method, "auto") != 0) return SL_OK;
    sl_status status = sl_auto_method(scene, settings, budget, &choice, error);
    if (status != SL_OK) return status;
    settings->method = choice.method;
    if (!quiet) fprintf(stderr, "softlux: method %s\n", choice.why);
    return SL_OK;
}
