/* Surfaces and lights must be physical: no negative or infinite reflectance or light, no surface that
 * reflects more than it receives. Where a repair is obvious it is made, with a warning; the rest is an input
 * error. */
#include <float.h>
#include <math.h>

#include "base/error.h"
#include "scene/affine.h"
#include "scene/derive.h"
#include "scene/parts.h"

/* Mesh files may say that more than all is reflected, which is put right. */
static sl_status check_numbers(const sl_material *m, sl_error *error) {
    char text[SL_RULE_TEXT];
    for (int i = 0; i < SL_MATERIAL_NUMBERS; i++) {
        sl_material_number number = sl_material_numbers[i];
        number.most = (double)FLT_MAX;
        if (!sl_material_number_fits(&number, m, text))
            return sl_fail(error, SL_ERROR_INPUT, "material '%s': %s", m->name, text);
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

sl_status sl_material_check(sl_scene *scene, sl_material *m, sl_error *error) {
    sl_status status = check_numbers(m, error);
    if (status != SL_OK) return status;
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
    const sl_rgb i = light->intensity;
    if (!(i.r >= 0.0f && i.g >= 0.0f && i.b >= 0.0f) || !sl_rgb_is_finite(i)) {
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
