/* Lights without extent: point, spot and directional; and those of a scene that has none: sun and sky, and
 * within walls a lamp. */
#include <math.h>

#include "base/error.h"
#include "base/grow.h"
#include "scene/derive.h"
#include "scene/sight.h"

bool sl_light_illuminate(const sl_light *light, sl_vec3 p, sl_vec3 *to_light, float *distance,
                         sl_rgb *irradiance) {
    *irradiance = light->intensity;
    if (light->type == SL_LIGHT_DIRECTIONAL) {
        *to_light = sl_neg(light->direction);
        *distance = INFINITY;
    } else {
        sl_vec3d offset = sl_subd(sl_to_double(light->position), sl_to_double(p));
        double squared = sl_dotd(offset, offset);
        if (!(squared > 0.0) || !isfinite(squared)) return false;
        double length = sqrt(squared);
        *to_light = sl_to_float(sl_scaled(offset, 1.0 / length));
        *distance = (float)length;
        float strength = (float)(1.0 / squared); /* inverse square law, E = I / r^2 */
        if (light->type == SL_LIGHT_SPOT)
            strength *= sl_spot_falloff(-sl_dot(*to_light, light->direction), light->cos_inner,
                                        light->cos_outer);
        *irradiance = sl_rgb_scale(light->intensity, strength);
    }
    return sl_rgb_max(*irradiance) > 0.0f && sl_rgb_is_finite(*irradiance);
}

bool sl_scene_has_lit_light(const sl_scene *scene) {
    for (size_t i = 0; i < scene->light_count; i++) {
        if (sl_light_is_lit(&scene->lights[i])) return true;
    }
    return false;
}

/* ---- by default ------------------------------------------------------------------------------ */

/* A warm sun and a blue sky tell what is lit from what is not, and grey things from what is behind them. */
static const sl_rgb sun_irradiance = {3.2f, 3.0f, 2.6f}, sky_radiance = {0.15f, 0.2f, 0.3f};
static const float lamp_irradiance = 3.0f;
/* From the eye: to its left, up, and behind it. */
static const double sun_left = 0.65, sun_up = 0.7, sun_behind = 0.35;
/* An eye from which so few of the rays leave the scene stands in a room. */
enum { FEW_LEAVE = SL_SIGHT_RAYS / 8 };

/* The way the light travels. It depends on where the eye looks, and not on how far up or down. */
static sl_vec3 sun_direction(const sl_camera *camera) {
    sl_vec3d right =
        sl_to_double(sl_normalize_or(sl_v3(camera->right.x, 0.0f, camera->right.z), sl_v3(1, 0, 0)));
    sl_vec3d behind = sl_crossd(right, sl_v3d(0, 1, 0));
    sl_vec3d to_sun =
        sl_addd(sl_addd(sl_scaled(right, -sun_left), sl_v3d(0, sun_up, 0)), sl_scaled(behind, sun_behind));
    return sl_normalize_or(sl_to_float(sl_scaled(to_sun, -1.0)), sl_v3(0, -1, 0));
}

static void add_sun_and_sky(sl_scene *s, const char *why) {
    sl_light *sun = &s->lights[s->light_count++];
    *sun = (sl_light){.type = SL_LIGHT_DIRECTIONAL,
                      .direction = sun_direction(&s->camera),
                      .intensity = sun_irradiance};
    s->environment.present = true;
    s->environment.constant = sky_radiance;
    sl_scene_warn(
        s,
        "%s: a sun from the left behind the camera (%g %g %g W/m^2, along %.3g %.3g %.3g) and a sky "
        "(radiance %g %g %g W/(m^2 sr)) are added",
        why, (double)sun_irradiance.r, (double)sun_irradiance.g, (double)sun_irradiance.b,
        (double)sun->direction.x, (double)sun->direction.y, (double)sun->direction.z, (double)sky_radiance.r,
        (double)sky_radiance.g, (double)sky_radiance.b);
}

/* Half-way along the longest free line from the eye, and from there two thirds of the way up to the
 * ceiling. */
static sl_vec3 below_ceiling(const sl_scene *s, const sl_sight *from_eye) {
    int farthest = 0;
    for (int i = 1; i < SL_SIGHT_RAYS; i++) {
        bool farther =
            from_eye->distance[i] > from_eye->distance[farthest] || !isfinite(from_eye->distance[farthest]);
        if (isfinite(from_eye->distance[i]) && farther) farthest = i;
    }
    sl_vec3 middle =
        sl_mad(from_eye->origin, 0.5f * from_eye->distance[farthest], sl_sight_direction(from_eye, farthest));
    sl_sight up = {.origin = middle};
    for (int i = 0; i < SL_SIGHT_RAYS; i++) sl_sight_set(&up, i, sl_v3(0, 1, 0));
    sl_sight_cast(&up, s);
    return isfinite(up.distance[0]) ? sl_mad(middle, 2.0f / 3.0f * up.distance[0], sl_v3(0, 1, 0)) : middle;
}

static bool add_lamp(sl_scene *s, const sl_sight *from_eye) {
    sl_sight around;
    sl_vec3 place = below_ceiling(s, from_eye);
    sl_sight_sphere(&around, s, place);
    float reach = (float)sl_sight_counted(&around, s).mean_distance;
    float intensity = lamp_irradiance * reach * reach;
    if (!(intensity > 0.0f) || !isfinite(intensity) || !sl_is_finite(place)) return false;
    s->lights[s->light_count++] =
        (sl_light){.type = SL_LIGHT_POINT, .position = place, .intensity = sl_grey(intensity)};
    sl_scene_warn(s,
                  "no light: the camera stands between walls, and a lamp is added below the ceiling (%.4g "
                  "W/sr, at %.4g %.4g %.4g)",
                  (double)intensity, (double)place.x, (double)place.y, (double)place.z);
    return true;
}

sl_status sl_scene_light_by_default(sl_scene *scene, sl_error *error) {
    enum { MOST = 2 }; /* the sun and a lamp */
    sl_sight sight;
    const bool dark = !scene->emitter_count && !sl_scene_has_lit_light(scene);
    if (!sl_regrow(&scene->lights, scene->light_count, scene->light_count + MOST, sizeof *scene->lights))
        return sl_fail_memory(error, "the scene's lights");
    sl_sight_sphere(&sight, scene, scene->camera.eye);
    int leave = SL_SIGHT_RAYS - sl_sight_counted(&sight, scene).hit;
    const bool has_lamp = dark && leave <= FEW_LEAVE && add_lamp(scene, &sight);
    if (leave > 0 || (dark && !has_lamp))
        add_sun_and_sky(scene, dark ? "no light" : "no light but behind walls");
    return SL_OK;
}
