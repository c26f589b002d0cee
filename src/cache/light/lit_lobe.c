/* Light of area lights that a glossy lobe reflects: of their points, weighed in shadow_ray.c, and of
 * directions that are drawn from the lobe. */
#include "base/math.h"
#include "cache/light/light_sample_internal.h"

double sl_lit_lobe_term(const sl_lit_lobe *lobe, const sl_lit_point *point, sl_vec3 d, sl_vec3 m,
                        double area) {
    sl_vec3d way = sl_to_double(d);
    double squared = sl_dotd(way, way), distance = sqrt(squared);
    sl_vec3 to_light = sl_to_float(sl_scaled(way, 1.0 / distance));
    double facing = fabs((double)sl_dot(m, to_light)), arriving = (double)sl_dot(point->normal, to_light);
    if (!(facing > 0.0 && arriving > 0.0 && squared > 0.0)) return 0.0;
    double density =
        lobe->points * squared / (area * facing) + lobe->draws * (double)sl_bsdf_pdf(&lobe->bsdf, to_light);
    return (double)sl_bsdf_value(&lobe->bsdf, to_light, SL_LOBE_GLOSSY).r * arriving / density;
}

/* Returns L of the area light that a ray meets on a side that shines, times what the lobe reflects of it. */
static sl_rgb met_light(const sl_light_sampling *s, const sl_lit_point *point, const sl_lit_lobe *lobe,
                        sl_vec3 direction, uint32_t triangle, float distance) {
    uint32_t l = triangle != SL_NO_INDEX ? s->lights->light_of_triangle[triangle] : SL_NO_INDEX;
    if (l == SL_NO_INDEX) return sl_grey(0.0f);
    const sl_sampled_light *light = &s->lights->light[l];
    sl_vec3 normal = sl_scene_geometric_normal(s->scene, triangle);
    if (!light->two_sided && !(sl_dot(normal, direction) < 0.0f)) return sl_grey(0.0f);
    double term =
        sl_lit_lobe_term(lobe, point, sl_scale(direction, distance), normal, s->shape[l].surface.area);
    return sl_rgb_scale(light->radiance, (float)term);
}

sl_rgb sl_lobe_draws(const sl_light_sampling *s, const sl_lit_point *point, const sl_lit_lobe *lobe,
                     const sl_light_numbers *numbers, sl_counters *counters) {
    sl_rgb sum = sl_grey(0.0f);
    sl_vec3 eye = sl_light_lifted(s, point);
    for (uint32_t i = 0; i < numbers->count;) {
        sl_ray16 rays;
        sl_hit16 hits;
        sl_vec3 direction[SL_PACKET];
        unsigned count = 0;
        for (; i < numbers->count && count < SL_PACKET; i++) {
            float u[3];
            sl_sequence_point(numbers->sequence, numbers->key, 0, numbers->first + i, u);
            if (!sl_bsdf_sample(&lobe->bsdf, 0.0f, u[0], u[1], &direction[count])) continue;
            sl_ray16_set(&rays, count, eye, direction[count], 0.0f, INFINITY, point->triangle);
            count++;
        }
        if (count > 0) sl_trace(s->tracer, &rays, count, true, &hits, counters);
        for (unsigned k = 0; k < count; k++)
            sum = sl_rgb_add(sum, met_light(s, point, lobe, direction[k], hits.triangle[k], hits.t[k]));
    }
    return sum;
}
