/* Highlights: direct specular radiance, equation (6). */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <float.h>
#include <math.h>

#include "base/math.h"

typedef struct highlight {
    const sl_lit_point *lit;
    sl_vec3 view;
    float exponent;
} highlight;

/* cos^n alpha of light from a direction. */
static double lobe_towards(const highlight *h, sl_vec3 to_light) {
    sl_vec3 reflected =
        sl_sub(sl_scale(h->lit->normal, 2.0f * sl_dot(h->lit->normal, to_light)), to_light);
    return (double)sl_powf(sl_dot(reflected, h->view), h->exponent);
}

/* Returns the parts into which a light's triangle is cut along each edge for its points to be closer together
 * than a lobe is wide, 1 / sqrt(n). */
static int cuts_of(const sl_vec3 *corner, const highlight *h) {
    enum { CUTS_MAX = 16 };
    sl_vec3 a = sl_sub(corner[1], corner[0]), b = sl_sub(corner[2], corner[0]),
            c = sl_sub(corner[2], corner[1]);
    double longest = sqrt(fmax((double)sl_dot(a, a), fmax((double)sl_dot(b, b), (double)sl_dot(c, c))));
    double away = (double)sl_length(sl_sub(corner[0], h->lit->position)),
           cuts = 1.5 * longest * sqrt((double)h->exponent + 2.0) / fmax(away, 1e-6 * longest);
    return cuts < CUTS_MAX ? 1 + (int)cuts : CUTS_MAX;
}

/* Adds cos^n alpha of a point of a light, by what an unhidden piece of area there gives. */
static void add_point(const highlight *h, sl_vec3 at, sl_vec3 area, bool two_sided, double sum[2]) {
    sl_vec3 way = sl_sub(at, h->lit->position);
    double squared = (double)sl_dot(way, way), length = sqrt(squared);
    if (!(length > 0.0)) return;
    sl_vec3 to_light = sl_scale(way, (float)(1.0 / length));
    double facing = -(double)sl_dot(area, to_light),
           weight =
               (two_sided ? fabs(facing) : facing) * (double)sl_dot(h->lit->normal, to_light) / squared;
    if (!(facing > 0.0 || two_sided) || !(sl_dot(h->lit->normal, to_light) > 0.0f) || !(weight <= DBL_MAX))
        return;
    sum[0] += weight;
    sum[1] += weight * lobe_towards(h, to_light);
}

/* Returns the mean of cos^n alpha over what a point sees of an area light that nothing hides. */
static double mean_lobe(const sl_sampled_light *light, const highlight *h) {
    double sum[2] = {0.0, 0.0};
    for (size_t t = 0; t < light->triangles; t++) {
        const sl_vec3 *corner = light->corner + 3 * t;
        sl_vec3 e1 = sl_sub(corner[1], corner[0]), e2 = sl_sub(corner[2], corner[0]), area = sl_cross(e1, e2);
        int cuts = cuts_of(corner, h);
        area = sl_scale(area, 1.0f / (float)(cuts * cuts));
        for (int s = 0; s < cuts * cuts; s++) {
            int j = 0, at = s;
            for (; at >= 2 * (cuts - j) - 1; j++) at -= 2 * (cuts - j) - 1;
            float third = at % 2 ? 2.0f / 3.0f : 1.0f / 3.0f, over = 1.0f / (float)cuts;
            sl_vec3 along = sl_mad(corner[0], ((float)(at / 2) + third) * over, e1);
            add_point(h, sl_mad(along, ((float)j + third) * over, e2), area, light->two_sided, sum);
        }
    }
    return sum[0] > 0.0 ? sum[1] / sum[0] : 0.0;
}

static double lobe_of(const sl_sampled_light *light, const highlight *h) {
    return sl_light_has_extent(light) ? mean_lobe(light, h)
                                      : lobe_towards(h, sl_light_direction(light, h->lit));
}

sl_rgb sl_direct_specular(const sl_sampled_lights *lights, const float *share, const sl_lit_point *point,
                          float exponent, sl_vec3 eye) {
    sl_vec3 to_eye = sl_sub(eye, point->position);
    float distance = sl_length(to_eye);
    if (!(distance > 0.0f)) return sl_grey(0.0f);
    const highlight h = {point, sl_scale(to_eye, 1.0f / distance), exponent};
    double sum[3] = {0.0, 0.0, 0.0}, lobe = ((double)exponent + 2.0) / (2.0 * SL_PI);
    for (size_t l = 0; l < lights->count; l++) {
        const sl_sampled_light *light = &lights->light[l];
        if (!(share[l] > 0.0f)) continue;
        sl_sum_colour(sum, lobe * lobe_of(light, &h) * (double)share[l], light->colour);
    }
    return sl_sum_over(sum, 1.0);
}
