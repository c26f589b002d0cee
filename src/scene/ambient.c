#include "scene/ambient.h"

#include "base/math.h"

#include <math.h>

static void add(double sum[3], sl_rgb colour, double scale) {
    if (sl_rgb_is_finite(colour) && scale > 0.0 && scale < 1e300) sl_sum_colour(sum, scale, colour);
}

double sl_triangle_area(const sl_scene *s, size_t triangle) {
    sl_vec3d p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_to_double(sl_scene_position(s, s->vertex[k][triangle]));
    const double area = 0.5 * sl_lengthd(sl_crossd(sl_subd(p[1], p[0]), sl_subd(p[2], p[0])));
    return isfinite(area) ? area : 0.0;
}

static bool is_central(const sl_scene *s, sl_vec3 p) {
    return p.x >= s->central_min.x && p.x <= s->central_max.x && p.y >= s->central_min.y &&
           p.y <= s->central_max.y && p.z >= s->central_min.z && p.z <= s->central_max.z;
}

static bool lies_central(const sl_scene *s, size_t triangle) {
    bool inside = true;
    for (int k = 0; k < 3; k++) inside &= is_central(s, sl_scene_position(s, s->vertex[k][triangle]));
    return inside;
}

/* Of what leaves a place evenly, the share that meets the sphere around the central region. */
static double central_share(const sl_scene *s, sl_vec3 from) {
    if (is_central(s, from)) return 1.0;
    sl_vec3d low = sl_to_double(s->central_min), high = sl_to_double(s->central_max);
    double radius = 0.5 * sl_lengthd(sl_subd(high, low));
    double distance = sl_lengthd(sl_subd(sl_to_double(from), sl_scaled(sl_addd(low, high), 0.5))),
           ratio = distance > 0.0 ? radius / distance : 1.0;
    return fmin(1.0, 0.25 * ratio * ratio);
}

/* The integral of k_d over all surfaces; texture at the middles of four equal parts of each triangle. */
static void reflecting_area(const sl_scene *scene, bool central, double sum[3], double *area) {
    static const float w[4][2] = {{1.0f / 3.0f, 1.0f / 3.0f},
                                  {1.0f / 6.0f, 1.0f / 6.0f},
                                  {2.0f / 3.0f, 1.0f / 6.0f},
                                  {1.0f / 6.0f, 2.0f / 3.0f}};
    sum[0] = sum[1] = sum[2] = *area = 0.0;
    for (size_t t = 0; t < scene->triangle_count; t++) {
        if (central && !lies_central(scene, t)) continue;
        double a = sl_triangle_area(scene, t);
        *area += a;
        for (int k = 0; k < 4; k++)
            add(sum, sl_scene_diffuse_nearest(scene, (uint32_t)t, w[k][0], w[k][1]), 0.25 * a);
    }
}

double sl_mean_reflectance(const sl_scene *scene) {
    double kd[3], area;
    reflecting_area(scene, sl_scene_is_scattered(scene), kd, &area);
    return area > 0.0 ? fmin(fmax(kd[0], fmax(kd[1], kd[2])) / area, 1.0) : 0.0;
}

/* Returns what a light sends into the scene: of sunlight, what falls on its box. */
static double solid_angle_or_area(const sl_scene *scene, bool central, const sl_light *light) {
    if (light->type == SL_LIGHT_POINT) return 4.0 * SL_PI;
    if (light->type == SL_LIGHT_SPOT) { /* smoothstep between the cosines: the half of what lies there */
        return 2.0 * SL_PI * (1.0 - 0.5 * ((double)light->cos_inner + (double)light->cos_outer));
    }
    sl_vec3 low = central ? scene->central_min : scene->box_min,
            high = central ? scene->central_max : scene->box_max;
    sl_vec3d size = sl_subd(sl_to_double(high), sl_to_double(low)), d = sl_to_double(light->direction);
    return fabs(d.x) * size.y * size.z + fabs(d.y) * size.z * size.x + fabs(d.z) * size.x * size.y;
}

static void add_power_of_lights(const sl_scene *scene, bool central, double power[3]) {
    for (size_t i = 0; i < scene->emitter_count; i++) {
        const sl_emitter *e = &scene->emitters[i];
        double share =
            !central ? 1.0 : central_share(scene, sl_scene_position(scene, scene->vertex[0][e->triangle]));
        add(power, e->radiance,
            share * SL_PI * (double)e->area * (double)e->opaque * (e->two_sided ? 2.0 : 1.0));
    }
    for (size_t i = 0; i < scene->light_count; i++) {
        const sl_light *light = &scene->lights[i];
        double share =
            !central || light->type == SL_LIGHT_DIRECTIONAL ? 1.0 : central_share(scene, light->position);
        add(power, light->intensity, share * solid_angle_or_area(scene, central, light));
    }
}

/* The environment shows in gathers itself: its mean over all directions, as if nothing stood before it. */
static void add_environment_irradiance(const sl_environment *e, double sum[3]) {
    if (!e->present) return;
    if (e->width <= 0) add(sum, e->constant, SL_PI);
    for (int row = 0; row < e->height && e->width > 0; row++) {
        /* of a texel */
        double share =
            0.5 * (sl_cos(SL_PI * row / e->height) - sl_cos(SL_PI * (row + 1) / e->height)) / e->width;
        for (int column = 0; column < e->width; column++) {
            const float *t = e->texels + 3 * ((size_t)row * (size_t)e->width + (size_t)column);
            add(sum, (sl_rgb){t[0], t[1], t[2]}, SL_PI * share);
        }
    }
}

static sl_rgb ambient_of(const sl_scene *scene, bool central, bool all_bounces) {
    double area, reflecting[3], power[3] = {0.0, 0.0, 0.0}, sky[3] = {0.0, 0.0, 0.0}, e[3];
    reflecting_area(scene, central, reflecting, &area);
    add_power_of_lights(scene, central, power);
    add_environment_irradiance(&scene->environment, sky);
    const double over = area > 0.0 && area < 1e300 ? 1.0 / area : 0.0;
    for (int k = 0; k < 3; k++) {
        double reflectance = reflecting[k] * over, absorbed = 1.0 - fmin(reflectance, 0.99);
        e[k] = reflectance * (power[k] * over) / (all_bounces ? absorbed : 1.0) + sky[k];
        e[k] = e[k] > 0.0 && e[k] < 1e37 ? e[k] : 0.0;
    }
    return sl_sum_over(e, 1.0);
}

/* A plain without end would leave nothing of what lights a room on it, and the walls around a grain light it
 * as they light all else: in a scattered scene the mean of the central region counts, if it is more than that
 * of all. */
static sl_rgb ambient(const sl_scene *scene, bool all_bounces) {
    sl_rgb all = ambient_of(scene, false, all_bounces);
    if (!sl_scene_is_scattered(scene)) return all;
    sl_rgb central = ambient_of(scene, true, all_bounces);
    return (sl_rgb){fmaxf(all.r, central.r), fmaxf(all.g, central.g), fmaxf(all.b, central.b)};
}

sl_rgb sl_ambient_irradiance(const sl_scene *scene) { return ambient(scene, false); }

sl_rgb sl_ambient_irradiance_of_all_bounces(const sl_scene *scene) { return ambient(scene, true); }
