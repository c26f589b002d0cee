#include "cache/multi_mesh/direct.h"

#include "base/math.h"

sl_rgb sl_direct_diffuse(const sl_sampled_lights *lights, const float *share) {
    double sum[3] = {0.0, 0.0, 0.0};
    for (size_t l = 0; l < lights->count; l++) {
        sl_rgb c = lights->light[l].colour;
        sum[0] += (double)c.r * (double)share[l];
        sum[1] += (double)c.g * (double)share[l];
        sum[2] += (double)c.b * (double)share[l];
    }
    return (sl_rgb){(float)(sum[0] / SL_PI), (float)(sum[1] / SL_PI), (float)(sum[2] / SL_PI)};
}

/* L (1 - exp(-U / L)), and U itself where there is no lamp to be outshone. */
static double saturated(double u, float lamp) { return lamp > 0.0f ? (double)lamp * (1.0 - sl_exp(-u / (double)lamp)) : u; }

sl_rgb sl_direct_specular(const sl_sampled_lights *lights, const float *share, const sl_mesh_point *point, float exponent, sl_vec3 eye,
                          bool plain) {
    sl_vec3 to_eye = sl_sub(eye, point->position);
    float distance = sl_length(to_eye);
    if (!(distance > 0.0f)) return sl_grey(0.0f);
    sl_vec3 view = sl_scale(to_eye, 1.0f / distance);
    double sum[3] = {0.0, 0.0, 0.0}, lobe = ((double)exponent + 2.0) / (2.0 * SL_PI);
    for (size_t l = 0; l < lights->count; l++) {
        const sl_sampled_light *light = &lights->light[l];
        if (!(share[l] > 0.0f)) continue;
        sl_lit_point lit = {point->position, point->normal, point->geometric_normal, point->triangle};
        sl_vec3 to_light = sl_light_direction(light, &lit);
        sl_vec3 reflected = sl_sub(sl_scale(point->normal, 2.0f * sl_dot(point->normal, to_light)), to_light);
        double factor = lobe * (double)sl_powf(sl_dot(reflected, view), exponent) * (double)share[l];
        const float colour[3] = {light->colour.r, light->colour.g, light->colour.b};
        const float lamp[3] = {light->opaque * light->radiance.r, light->opaque * light->radiance.g, light->opaque * light->radiance.b};
        for (int k = 0; k < 3; k++) {
            double u = factor * (double)colour[k];
            sum[k] += plain ? u : saturated(u, lamp[k]);
        }
    }
    return (sl_rgb){(float)sum[0], (float)sum[1], (float)sum[2]};
}
