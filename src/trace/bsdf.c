#include "trace/bsdf.h"

#include "base/math.h"

static const float per_pi = (float)(1.0 / SL_PI), per_two_pi = (float)(0.5 / SL_PI);

sl_vec3 sl_reflect(sl_vec3 to_viewer, sl_vec3 normal) {
    return sl_sub(sl_scale(normal, 2.0f * sl_dot(normal, to_viewer)), to_viewer);
}

sl_vec3 sl_reflect_off(sl_vec3 direction, sl_vec3 normal, sl_vec3 geometric) {
    const sl_vec3 out = sl_mad(direction, -2.0f * sl_dot(direction, normal), normal);
    if (sl_dot(out, geometric) > 0.0f) return out;
    return sl_mad(direction, -2.0f * sl_dot(direction, geometric), geometric);
}

sl_vec3 sl_surface_lift(const sl_scene *scene, uint32_t triangle, const sl_surface *surface) {
    float size = 0.0f;
    for (int k = 0; k < 3; k++) {
        sl_vec3 p = sl_scene_position(scene, scene->vertex[k][triangle]);
        size = fmaxf(size, fmaxf(fabsf(p.x), fmaxf(fabsf(p.y), fabsf(p.z))));
    }
    return sl_mad(surface->position, 6e-7f * size, surface->geometric_normal);
}

sl_vec3 sl_surface_lift_anywhere(const sl_scene *scene, sl_vec3 position, sl_vec3 geometric_normal) {
    return sl_mad(position, 6e-7f * sl_scene_coordinate_near(scene, position), geometric_normal);
}

void sl_bsdf_turn(sl_bsdf *b, sl_vec3 to_viewer, unsigned sampled_lobes) {
    /* In double before it is rounded, so that high exponents see a unit vector. */
    b->mirror_direction = sl_normalize_or(sl_reflect(to_viewer, b->normal), b->normal);
    float diffuse = sampled_lobes & SL_LOBE_DIFFUSE ? sl_rgb_mean(b->diffuse) : 0.0f;
    float glossy = sampled_lobes & SL_LOBE_GLOSSY ? sl_rgb_mean(b->specular) : 0.0f;
    b->black = !(diffuse + glossy > 0.0f);
    b->diffuse_share = b->black ? 1.0f : diffuse / (diffuse + glossy);
}

sl_bsdf sl_bsdf_make(const sl_surface *surface, sl_vec3 to_viewer, unsigned sampled_lobes) {
    sl_bsdf b = {.diffuse = surface->diffuse,
                 .specular = surface->material->specular,
                 .exponent = surface->material->exponent,
                 .normal = surface->normal,
                 .geometric_normal = surface->geometric_normal};
    sl_bsdf_turn(&b, to_viewer, sampled_lobes);
    return b;
}

/* Cosine with the shading normal; 0 below either plane. */
static float cosine_above(const sl_bsdf *b, sl_vec3 to_light) {
    float cosine = sl_dot(b->normal, to_light);
    return cosine > 0.0f && sl_dot(b->geometric_normal, to_light) > 0.0f ? cosine : 0.0f;
}

/* cos^n alpha. */
static float phong_power(const sl_bsdf *b, sl_vec3 to_light) {
    float cosine = sl_dot(b->mirror_direction, to_light);
    if (!(cosine > 0.0f)) return 0.0f;
    return sl_powf(cosine < 1.0f ? cosine : 1.0f, b->exponent);
}

sl_rgb sl_bsdf_value(const sl_bsdf *b, sl_vec3 to_light, unsigned lobes) {
    sl_rgb f = {0.0f, 0.0f, 0.0f};
    if (lobes & SL_LOBE_DIFFUSE) f = sl_rgb_scale(b->diffuse, per_pi);
    if ((lobes & SL_LOBE_GLOSSY) && sl_rgb_max(b->specular) > 0.0f)
        f = sl_rgb_add(
            f, sl_rgb_scale(b->specular, (b->exponent + 2.0f) * per_two_pi * phong_power(b, to_light)));
    return f;
}

sl_rgb sl_bsdf_reflect(const sl_bsdf *b, sl_vec3 to_light, unsigned lobes) {
    float cosine = cosine_above(b, to_light);
    if (!(cosine > 0.0f)) return sl_grey(0.0f);
    return sl_rgb_scale(sl_bsdf_value(b, to_light, lobes), cosine);
}

sl_vec3 sl_direction_around(sl_vec3 axis, float cosine, float turn) {
    float sine = sqrtf(fmaxf(0.0f, 1.0f - cosine * cosine)), s, c;
    sl_sincos_turnf(turn, &s, &c);
    sl_frame frame = sl_frame_from_normal(axis);
    return sl_normalize_or(sl_frame_to_world(&frame, sl_v3(sine * c, sine * s, cosine)), axis);
}

bool sl_bsdf_sample(const sl_bsdf *b, float lobe, float u1, float u2, sl_vec3 *to_light) {
    if (b->black) return false;
    if (lobe < b->diffuse_share) {
        *to_light = sl_direction_around(b->normal, sqrtf(1.0f - u1), u2);
    } else {
        *to_light =
            sl_direction_around(b->mirror_direction, sl_powf(1.0f - u1, 1.0f / (b->exponent + 1.0f)), u2);
    }
    return cosine_above(b, *to_light) > 0.0f;
}

float sl_bsdf_pdf(const sl_bsdf *b, sl_vec3 to_light) {
    float cosine = cosine_above(b, to_light);
    if (b->black || !(cosine > 0.0f)) return 0.0f;
    float pdf = b->diffuse_share * cosine * per_pi;
    if (b->diffuse_share < 1.0f)
        pdf += (1.0f - b->diffuse_share) * (b->exponent + 1.0f) * per_two_pi * phong_power(b, to_light);
    return pdf;
}
