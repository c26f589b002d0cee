/* Lights without extent: point, spot and directional. */
#include <math.h>

#include "scene/scene.h"

float sl_spot_falloff(const sl_light *light, float cosine) {
    if (cosine >= light->cos_inner) return 1.0f;
    if (!(cosine > light->cos_outer)) return 0.0f;
    float x = (cosine - light->cos_outer) / (light->cos_inner - light->cos_outer);
    return x * x * (3.0f - 2.0f * x);
}

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
            strength *= sl_spot_falloff(light, -sl_dot(*to_light, light->direction));
        *irradiance = sl_rgb_scale(light->intensity, strength);
    }
    return sl_rgb_max(*irradiance) > 0.0f && sl_rgb_is_finite(*irradiance);
}
