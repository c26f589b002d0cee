/* Reflection of a surface that is not a mirror: Lambertian plus the modified Phong lobe (Lafortune and
 * Willems 1994),
 *
 *     f = kd / pi + ks (n + 2) / (2 pi) max(0, cos alpha)^n,
 *
 * alpha between the light's direction and the viewer's mirror direction. Nothing passes through the surface:
 * directions must lie above the geometric and the shading plane. */
#pragma once

#include "scene/scene.h"

typedef struct sl_bsdf {
    sl_rgb diffuse, specular;
    float exponent;
    sl_vec3 normal, geometric_normal, mirror_direction;
    float diffuse_share; /* of samples; the rest goes to the Phong lobe */
    bool black;          /* no lobe asked for reflects anything */
} sl_bsdf;

/* to_viewer: unit. sampled_lobes: those that sl_bsdf_sample() draws from. */
sl_bsdf sl_bsdf_make(const sl_surface *surface, sl_vec3 to_viewer, unsigned sampled_lobes);
/* The same surface seen from elsewhere, above its geometric plane. */
void sl_bsdf_turn(sl_bsdf *bsdf, sl_vec3 to_viewer, unsigned sampled_lobes);
/* f alone, whatever planes the directions lie above: symmetric in them. */
sl_rgb sl_bsdf_value(const sl_bsdf *bsdf, sl_vec3 to_light, unsigned lobes);
/* f times the cosine of the shading normal, for some of the lobes; 0 below either plane. */
sl_rgb sl_bsdf_reflect(const sl_bsdf *bsdf, sl_vec3 to_light, unsigned lobes);
/* A direction from three numbers in [0,1); false if it falls below the surface. */
bool sl_bsdf_sample(const sl_bsdf *bsdf, float lobe, float u1, float u2, sl_vec3 *to_light);
/* Its density in solid angle: the mixture's. */
float sl_bsdf_pdf(const sl_bsdf *bsdf, sl_vec3 to_light);

sl_vec3 sl_reflect(sl_vec3 to_viewer, sl_vec3 normal);
/* Mirrors a direction by the shading normal, or by the geometric one where that would lead into the mirror.
 */
sl_vec3 sl_reflect_off(sl_vec3 direction, sl_vec3 normal, sl_vec3 geometric);
/* Unit, at that cosine with the axis, `turn` in [0,1) of the way around it. */
sl_vec3 sl_direction_around(sl_vec3 axis, float cosine, float turn);
/* Where a ray leaves a surface: so far above its triangle that it is above it in spite of rounding.
 * Interpolation errs by a few units in the last place of the largest coordinate involved. */
sl_vec3 sl_surface_lift(const sl_scene *scene, uint32_t triangle, const sl_surface *surface);
/* The same for a point on an edge or a corner, whatever meets there. */
sl_vec3 sl_surface_lift_anywhere(const sl_scene *scene, sl_vec3 position, sl_vec3 geometric_normal);
