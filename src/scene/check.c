/* Surfaces and lights must be physical: no negative or infinite reflectance or light, no surface that
 * reflects more than it receives. Where a repair is obvious it is made, with a warning; the rest is an input
 * error. */
#include <math.h>

#include "base/error.h"
#include "scene/affine.h"
#include "scene/derive.h"

static bool channel_is_valid(float value) { return value >= 0.0f && isfinite(value); }
static bool rgb_is_valid(sl_rgb c) {
    return channel_is_valid(c.r) && channel_is_valid(c.g) && channel_is_valid(c.b);
}

static sl_status check_numbers(const sl_material *m, sl_error *error) {
    const struct {
        const char *what;
        sl_rgb value;
    } all[] = {{"diffuse reflectance", m->diffuse}, {"specular reflectance", m->specular},
               {"mirror reflectance", m->mirror},   {"emission", m->emission},
               {"exponent", sl_grey(m->exponent)},  {"bump depth", sl_grey(m->bump_depth)}};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        if (rgb_is_valid(all[i].value)) continue;
        return sl_fail(error, SL_ERROR_INPUT,
                       "material '%s': expected a finite %s of at least 0, got (%g, %g, %g)", m->name,
                       all[i].what, (double)all[i].value.r, (double)all[i].value.g, (double)all[i].value.b);
    }
    return SL_OK;
}

/* kd + ks <= 1 in one channel: more would make light out of nothing. */
static bool conserve_channel(float *kd, float *ks) {
    float sum = *kd + *ks;
    if (!(sum > 1.0f)) return false;
    *kd /= sum;
    *ks /= sum;
    /* what rounding left over */
    while (*kd + *ks > 1.0f) *kd = nextafterf(*kd, 0.0f), *ks = nextafterf(*ks, 0.0f);
    return true;
}

static void conserve_energy(sl_scene *scene, sl_material *m) {
    sl_rgb kd = m->diffuse, ks = m->specular;
    bool r = conserve_channel(&m->diffuse.r, &m->specular.r),
         g = conserve_channel(&m->diffuse.g, &m->specular.g),
         b = conserve_channel(&m->diffuse.b, &m->specular.b);
    if (r || g || b) {
        sl_scene_warn(
            scene,
            "material '%s': diffuse (%g, %g, %g) and specular (%g, %g, %g) together exceed 1; both scaled",
            m->name, (double)kd.r, (double)kd.g, (double)kd.b, (double)ks.r, (double)ks.g, (double)ks.b);
    }
    if (sl_rgb_max(m->mirror) > 1.0f) {
        sl_scene_warn(scene, "material '%s': mirror reflectance (%g, %g, %g) exceeds 1; cut to 1", m->name,
                      (double)m->mirror.r, (double)m->mirror.g, (double)m->mirror.b);
        m->mirror = (sl_rgb){fminf(m->mirror.r, 1.0f), fminf(m->mirror.g, 1.0f), fminf(m->mirror.b, 1.0f)};
    }
}

/* A perfect mirror has no other lobe. */
static void settle_mirror(sl_scene *scene, sl_material *m) {
    if (!sl_material_is_mirror(m)) return;
    if (sl_rgb_max(m->diffuse) > 0.0f || sl_rgb_max(m->specular) > 0.0f) {
        sl_scene_warn(scene, "material '%s' is a mirror; its diffuse and specular reflectance are left out",
                      m->name);
    }
    m->diffuse = m->specular = sl_grey(0.0f);
    m->texture = SL_NO_INDEX;
}

static bool texture_exists(const sl_scene *scene, uint32_t index) {
    return index == SL_NO_INDEX || index < scene->texture_count;
}

sl_status sl_material_check(sl_scene *scene, sl_material *m, sl_error *error) {
    sl_status status = check_numbers(m, error);
    if (status != SL_OK) return status;
    if (!texture_exists(scene, m->texture) || !texture_exists(scene, m->alpha_texture) ||
        m->height_map > scene->texture_count) {
        return sl_fail(error, SL_ERROR_INPUT, "material '%s' names a texture that does not exist", m->name);
    }
    settle_mirror(scene, m);
    conserve_energy(scene, m);
    return SL_OK;
}

sl_status sl_materials_check(sl_scene *scene, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; i < scene->material_count && status == SL_OK; i++)
        status = sl_material_check(scene, &scene->materials[i], error);
    return status;
}

static sl_status check_light(sl_light *light, size_t index, sl_error *error) {
    if (!rgb_is_valid(light->intensity)) {
        return sl_fail(error, SL_ERROR_INPUT, "light %zu: expected a finite intensity of at least 0", index);
    }
    if (light->type != SL_LIGHT_DIRECTIONAL && !sl_is_finite(light->position)) {
        return sl_fail(error, SL_ERROR_INPUT, "light %zu: expected a finite position", index);
    }
    if (light->type == SL_LIGHT_POINT) return SL_OK;
    light->direction = sl_unit_or(light->direction, sl_v3(0, 0, 0));
    if (!(sl_dot(light->direction, light->direction) > 0.5f)) {
        return sl_fail(error, SL_ERROR_INPUT, "light %zu: expected a direction that is finite and not zero",
                       index);
    }
    bool cone = light->cos_outer >= -1.0f && light->cos_outer <= light->cos_inner && light->cos_inner <= 1.0f;
    if (light->type == SL_LIGHT_SPOT && !cone) {
        return sl_fail(error, SL_ERROR_INPUT, "light %zu: expected an inner cone inside the outer cone",
                       index);
    }
    return SL_OK;
}

sl_status sl_lights_check(sl_scene *scene, sl_error *error) {
    sl_status status = SL_OK;
    for (size_t i = 0; i < scene->light_count && status == SL_OK; i++)
        status = check_light(&scene->lights[i], i, error);
    return status;
}
