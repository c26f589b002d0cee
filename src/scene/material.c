/* What a material has: each property once, for scene files, calls and the writer; and what no material may
 * be. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "scene/derive.h"
#include "scene/parts.h"

#define PLACES(name) #name, offsetof(sl_material, name), offsetof(sl_material_data, name)
const sl_material_number sl_material_numbers[SL_MATERIAL_NUMBERS] = {
    {PLACES(diffuse), 3, 1.0},
    {PLACES(specular), 3, 1.0},
    {PLACES(mirror), 3, 1.0},
    {PLACES(exponent), 1, SL_LARGEST_EXPONENT},
    {PLACES(emission), 3, (double)FLT_MAX},
    {PLACES(bump_depth), 1, 1.0}};

const sl_material_texture sl_material_textures[SL_MATERIAL_TEXTURES] = {
    {"texture", offsetof(sl_material, texture), offsetof(sl_material_data, texture)},
    {"alpha", offsetof(sl_material, alpha_texture), offsetof(sl_material_data, alpha)},
    {"bump", offsetof(sl_material, height_map), offsetof(sl_material_data, bump)}};

static uint32_t word_at(const void *of, size_t place) {
    uint32_t word;
    memcpy(&word, (const char *)of + place, sizeof word);
    return word;
}

sl_material sl_grey_material(const char *name, float diffuse) {
    return (sl_material){.name = (char *)(uintptr_t)name, /* which nobody writes to */
                         .diffuse = sl_grey(diffuse),
                         .texture = SL_NO_INDEX,
                         .alpha_texture = SL_NO_INDEX,
                         .height_map = SL_NO_INDEX};
}

/* ---- from calls, and back ------------------------------------------------------------------------ */

/* Numbers of textures begin at 1, their indices at 0; SL_NO_INDEX and 0 are none. */
static sl_material material_from(const sl_material_data *d, const char *name) {
    sl_material m = sl_grey_material(name, 0.0f);
    m.emission_two_sided = d->two_sided;
    for (int i = 0; i < SL_MATERIAL_NUMBERS; i++) {
        const sl_material_number *n = &sl_material_numbers[i];
        memcpy((char *)&m + n->field, (const char *)d + n->given, (size_t)n->floats * sizeof(float));
    }
    for (int i = 0; i < SL_MATERIAL_TEXTURES; i++) {
        const uint32_t index = word_at(d, sl_material_textures[i].given) - 1;
        memcpy((char *)&m + sl_material_textures[i].field, &index, sizeof index);
    }
    if (d->bump && d->bump_depth == 0.0f) m.bump_depth = SL_BUMP_DEPTH;
    return m;
}

bool sl_scene_material(const sl_scene *scene, uint32_t material, sl_material_data *data) {
    *data = (sl_material_data){.size = sizeof *data};
    if (material == 0 || material > scene->material_count) return false;
    const sl_material *m = &scene->materials[material - 1];
    data->name = m->name;
    data->two_sided = m->emission_two_sided;
    for (int i = 0; i < SL_MATERIAL_NUMBERS; i++) {
        const sl_material_number *n = &sl_material_numbers[i];
        memcpy((char *)data + n->given, (const char *)m + n->field, (size_t)n->floats * sizeof(float));
    }
    for (int i = 0; i < SL_MATERIAL_TEXTURES; i++) {
        const uint32_t number = word_at(m, sl_material_textures[i].field) + 1;
        memcpy((char *)data + sl_material_textures[i].given, &number, sizeof number);
    }
    return true;
}

uint32_t sl_scene_find_material(const sl_scene *scene, const char *name) {
    for (size_t i = 0; i < scene->material_count; i++) {
        if (strcmp(scene->materials[i].name, name) == 0) return (uint32_t)i + 1;
    }
    return 0;
}

bool sl_material_number_fits(const sl_material_number *n, const sl_material *m, char text[SL_RULE_TEXT]) {
    float values[3];
    memcpy(values, (const char *)m + n->field, (size_t)n->floats * sizeof *values);
    for (int i = 0; i < n->floats; i++) {
        if (!sl_is_within(n->key, (double)values[i], 0.0, n->most, text)) return false;
    }
    return true;
}

/* Mesh files may say that more than all is reflected, which is put right; calls may not. */
static sl_status check_numbers(const sl_material *m, bool calls, sl_error *error) {
    char text[SL_RULE_TEXT];
    for (int i = 0; i < SL_MATERIAL_NUMBERS; i++) {
        sl_material_number number = sl_material_numbers[i];
        if (!calls) number.most = (double)FLT_MAX;
        if (!sl_material_number_fits(&number, m, text))
            return sl_fail(error, SL_ERROR_INPUT, "material '%s': %s", m->name, text);
    }
    return SL_OK;
}

sl_status sl_material_take(const sl_scene *scene, const sl_material_data *data, const char *name,
                           sl_material *material, sl_error *error) {
    sl_material_data d;
    sl_status status = SL_TAKE(sl_material_data, &d, data, error);
    if (status != SL_OK) return status;
    *material = material_from(&d, name);
    status = check_numbers(material, true, error);
    if (status != SL_OK) return status;
    if (sl_material_is_mirror(material) &&
        (sl_material_is_diffuse(material) || sl_material_is_glossy(material)))
        return sl_fail(error, SL_ERROR_INPUT, "material '%s': %s", name, SL_EXPECTED_ONE_REFLECTION);
    for (int i = 0; i < SL_MATERIAL_TEXTURES; i++) {
        const uint32_t number = word_at(&d, sl_material_textures[i].given);
        if (number > scene->texture_count)
            return sl_fail(error, SL_ERROR_INPUT, "material '%s': '%s' is number %u, of %zu that were added",
                           name, sl_material_textures[i].key, number, scene->texture_count);
    }
    return SL_OK;
}

/* ---- what must hold ---------------------------------------------------------------------------- */

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
    if (r || g || b)
        sl_scene_warn(
            scene,
            "material '%s': diffuse (%g, %g, %g) and specular (%g, %g, %g) together exceed 1; both scaled",
            m->name, (double)kd.r, (double)kd.g, (double)kd.b, (double)ks.r, (double)ks.g, (double)ks.b);
    if (sl_rgb_max(m->mirror) > 1.0f) {
        sl_scene_warn(scene, "material '%s': mirror reflectance (%g, %g, %g) exceeds 1; cut to 1", m->name,
                      (double)m->mirror.r, (double)m->mirror.g, (double)m->mirror.b);
        m->mirror = (sl_rgb){fminf(m->mirror.r, 1.0f), fminf(m->mirror.g, 1.0f), fminf(m->mirror.b, 1.0f)};
    }
}

/* A perfect mirror has no other lobe. */
static void settle_mirror(sl_scene *scene, sl_material *m) {
    if (!sl_material_is_mirror(m)) return;
    if (sl_rgb_max(m->diffuse) > 0.0f || sl_rgb_max(m->specular) > 0.0f)
        sl_scene_warn(scene, "material '%s' is a mirror; its diffuse and specular reflectance are left out",
                      m->name);
    m->diffuse = m->specular = sl_grey(0.0f);
    m->texture = SL_NO_INDEX;
}

sl_status sl_material_check(sl_scene *scene, sl_material *m, sl_error *error) {
    sl_status status = check_numbers(m, false, error);
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
