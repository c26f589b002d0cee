/* Materials: glTF's metallic-roughness by the mapping kd = base (1 - metallic), ks = 0.04 + (base - 0.04)
 * metallic, n = clamp(2 / roughness^4 - 2, 1, 10000); those of other formats by name. */
#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "import/assimp.h"
#include "scene/texture.h"

typedef struct source {
    const char *path;
    const struct aiScene *file;
    const struct aiMaterial *material;
    const char *name;
    sl_model *model;
    sl_error *error;
} source;

/* Key, type and index are one macro of Assimp's. */
static bool has_number(const source *s, const char *key, unsigned type, unsigned index, float *value) {
    unsigned one = 1;
    return aiGetMaterialFloatArray(s->material, key, type, index, value, &one) == AI_SUCCESS && one == 1;
}
static float number_or(const source *s, const char *key, unsigned type, unsigned index, float otherwise) {
    float value;
    return has_number(s, key, type, index, &value) ? value : otherwise;
}
static sl_rgb color_or(const source *s, const char *key, unsigned type, unsigned index, sl_rgb otherwise) {
    struct aiColor4D c;
    return aiGetMaterialColor(s->material, key, type, index, &c) == AI_SUCCESS ? (sl_rgb){c.r, c.g, c.b}
                                                                               : otherwise;
}

/* ---- textures -------------------------------------------------------------------------------- */

/* An image inside the file: compressed bytes, or texels. */
static sl_status embedded_texture(const source *s, const char *number, uint32_t *index) {
    unsigned which = 0;
    char label[1200];
    if (sscanf(number, "%u", &which) != 1 || which >= s->file->mNumTextures) return SL_OK;
    snprintf(label, sizeof label, "%.*s*%.100s", 1000, s->path, number);
    const struct aiTexture *t = s->file->mTextures[which];
    if (t && t->mHeight == 0 && t->pcData)
        return sl_model_texture(s->model, label, t->pcData, t->mWidth, index, s->error);
    sl_scene_warn(&s->model->scene, "%s: texture left out: uncompressed embedded images are not read", label);
    return SL_OK;
}

static sl_status find_texture(const source *s, enum aiTextureType type, uint32_t *index) {
    struct aiString name;
    *index = SL_NO_INDEX;
    if (aiGetMaterialTextureCount(s->material, type) == 0 ||
        aiGetMaterialString(s->material, AI_MATKEY_TEXTURE(type, 0), &name) != AI_SUCCESS)
        return SL_OK;
    if (name.data[0] == '*') return embedded_texture(s, name.data + 1, index);
    sl_error problem;
    sl_status status = sl_model_texture_beside(s->model, s->path, name.data, index, &problem);
    if (status == SL_ERROR_INPUT)
        sl_fail(s->error, status, "%s: material '%s': texture %s", s->path, s->name, problem.message);
    else if (status != SL_OK) sl_fail(s->error, status, "%s", problem.message);
    return status;
}

static const sl_texture *texture_at(const source *s, uint32_t index) {
    return index == SL_NO_INDEX ? NULL : &s->model->scene.textures[index];
}

/* The means of a texture's channels: of its linear colour, and of its bytes over 255. A texture that
 * modulates a constant of ours enters by them. */
typedef struct means {
    double color[3], byte[4];
} means;

static means means_of(const sl_texture *t) {
    const size_t texels = (size_t)t->width * (size_t)t->height;
    means m = {{0}, {0}};
    for (size_t i = 0; i < 4 * texels; i++) {
        const uint8_t byte = t->texels[i];
        if (i % 4 < 3) m.color[i % 4] += (double)sl_srgb_to_linear[byte];
        m.byte[i % 4] += byte;
    }
    for (int c = 0; c < 3; c++) m.color[c] /= (double)texels;
    for (int c = 0; c < 4; c++) m.byte[c] /= 255.0 * (double)texels;
    return m;
}

static sl_rgb mean_color(const sl_texture *t) {
    const means m = means_of(t);
    return (sl_rgb){(float)m.color[0], (float)m.color[1], (float)m.color[2]};
}

static void tell_mean(const source *s, const char *what) {
    sl_scene_warn(&s->model->scene, "%s: material '%s': %s texture's mean", s->path, s->name, what);
}

/* ---- whatever has a diffuse and a specular colour ---------------------------------------------- */

static sl_status classic_material(const source *s, sl_material *m) {
    m->diffuse = color_or(s, AI_MATKEY_COLOR_DIFFUSE, sl_grey(0.6f));
    m->specular = color_or(s, AI_MATKEY_COLOR_SPECULAR, sl_grey(0.0f));
    m->emission = color_or(s, AI_MATKEY_COLOR_EMISSIVE, sl_grey(0.0f));
    m->exponent = number_or(s, AI_MATKEY_SHININESS, 0.0f);
    /* "no gloss" is a shininess of 0; the colour may be scaled */
    m->specular = sl_rgb_scale(
        m->specular, m->exponent > 0.0f ? number_or(s, AI_MATKEY_SHININESS_STRENGTH, 1.0f) : 0.0f);
    if (number_or(s, AI_MATKEY_OPACITY, 1.0f) < 1.0f)
        sl_scene_warn(&s->model->scene,
                      "%s: material '%s' is transparent, which is not modelled: it is drawn opaque", s->path,
                      s->name);
    sl_status status = find_texture(s, aiTextureType_DIFFUSE, &m->texture);
    return status == SL_OK ? find_texture(s, aiTextureType_OPACITY, &m->alpha_texture) : status;
}

/* ---- glTF ------------------------------------------------------------------------------------ */

static float lerp(float a, float b, float t) { return a + (b - a) * t; }

/* 2/r^4 - 2: the Phong lobe as wide as a GGX lobe of roughness r (alpha = r^2). */
static float exponent_of(float roughness) {
    double r2 = (double)roughness * (double)roughness;
    return (float)fmin(fmax(2.0 / fmax(r2 * r2, 1e-12) - 2.0, 1.0), 10000.0);
}

static void set_roughness(sl_material *m, float roughness) {
    m->exponent = exponent_of(roughness);
    /* A mirror has no other lobe, so only what is mostly a mirror becomes one. */
    if (roughness < 0.03f && sl_rgb_max(m->specular) > sl_rgb_max(m->diffuse)) {
        m->mirror = m->specular;
        m->diffuse = m->specular = sl_grey(0.0f);
        m->exponent = 0.0f;
    }
}

static void metallic_roughness(sl_material *m, sl_rgb base, sl_rgb textured_base, float metallic,
                               float roughness) {
    m->diffuse = sl_rgb_scale(base, 1.0f - metallic);
    m->specular = (sl_rgb){lerp(0.04f, textured_base.r, metallic), lerp(0.04f, textured_base.g, metallic),
                           lerp(0.04f, textured_base.b, metallic)};
    set_roughness(m, roughness);
}


static sl_status modulate(const source *s, float *metallic, float *roughness) {
    uint32_t index;
    sl_status status = find_texture(s, aiTextureType_METALNESS, &index);
    if (status == SL_OK && index == SL_NO_INDEX) status = find_texture(s, aiTextureType_UNKNOWN, &index);
    if (status != SL_OK || index == SL_NO_INDEX) return status;
    const means mean = means_of(texture_at(s, index));
    *roughness *= (float)mean.byte[1];
    *metallic *= (float)mean.byte[2];
    tell_mean(s, "metalness and roughness are those of its");
    return SL_OK;
}

static sl_status gltf_emission(const source *s, double strength, sl_material *m) {
    int two_sided = 0;
    unsigned one = 1;
    uint32_t index;
    aiGetMaterialIntegerArray(s->material, AI_MATKEY_TWOSIDED, &two_sided, &one);
    m->emission = sl_rgb_scale(color_or(s, AI_MATKEY_COLOR_EMISSIVE, sl_grey(0.0f)), (float)strength);
    m->emission_two_sided = two_sided != 0;
    if (!sl_material_is_emitter(m)) return SL_OK;
    sl_status status = find_texture(s, aiTextureType_EMISSIVE, &index);
    if (status != SL_OK || index == SL_NO_INDEX) return status;
    m->emission = sl_rgb_mul(m->emission, mean_color(texture_at(s, index)));
    tell_mean(s, "emission is that of its");
    return SL_OK;
}

static void gltf_alpha(const source *s, sl_material *m) {
    struct aiString mode;
    if (aiGetMaterialString(s->material, AI_MATKEY_GLTF_ALPHAMODE, &mode) != AI_SUCCESS ||
        strcmp(mode.data, "OPAQUE") == 0)
        return;
    const sl_texture *texture = texture_at(s, m->texture);
    if (texture && texture->has_alpha) m->alpha_texture = m->texture;
    if (strcmp(mode.data, "BLEND") == 0 || number_or(s, AI_MATKEY_GLTF_ALPHACUTOFF, 0.5f) != 0.5f)
        sl_scene_warn(&s->model->scene, "%s: material '%s': alpha is a mask, tested at 0.5", s->path,
                      s->name);
}

/* KHR_materials_pbrSpecularGlossiness: kd = diffuse (1 - max(specular)), ks = specular, roughness = 1 -
 * glossiness. */
static sl_status specular_glossiness(const source *s, float glossiness, sl_material *m) {
    uint32_t index;
    m->diffuse = color_or(s, AI_MATKEY_COLOR_DIFFUSE, sl_grey(1.0f));
    m->specular = color_or(s, AI_MATKEY_COLOR_SPECULAR, sl_grey(1.0f));
    sl_status status = find_texture(s, aiTextureType_SPECULAR, &index);
    if (status != SL_OK) return status;
    if (index != SL_NO_INDEX) {
        m->specular = sl_rgb_mul(m->specular, mean_color(texture_at(s, index)));
        glossiness *= (float)means_of(texture_at(s, index)).byte[3];
        tell_mean(s, "specular colour and glossiness are those of its");
    }
    m->diffuse = sl_rgb_scale(m->diffuse, 1.0f - sl_clamp_unitf(sl_rgb_max(m->specular)));
    set_roughness(m, 1.0f - sl_clamp_unitf(glossiness));
    return SL_OK;
}

static sl_status metallic_workflow(const source *s, sl_material *m) {
    const sl_rgb base =
        color_or(s, AI_MATKEY_BASE_COLOR, color_or(s, AI_MATKEY_COLOR_DIFFUSE, sl_grey(1.0f)));
    float metallic = number_or(s, AI_MATKEY_METALLIC_FACTOR, 1.0f),
          roughness = number_or(s, AI_MATKEY_ROUGHNESS_FACTOR, 1.0f);
    sl_status status = modulate(s, &metallic, &roughness);
    if (status != SL_OK) return status;
    sl_rgb textured = base;
    if (m->texture != SL_NO_INDEX && metallic > 0.0f) {
        textured = sl_rgb_mul(base, mean_color(texture_at(s, m->texture)));
        tell_mean(s, "the colour of its metal is that of its base");
    }
    metallic_roughness(m, base, textured, sl_clamp_unitf(metallic), sl_clamp_unitf(roughness));
    return SL_OK;
}

static sl_status gltf_material(const source *s, double strength, sl_material *m) {
    float glossiness;
    int shading = 0;
    unsigned one = 1;
    sl_status status = find_texture(s, aiTextureType_DIFFUSE, &m->texture);
    if (status != SL_OK) return status;
    m->diffuse = sl_grey(0.0f);
    aiGetMaterialIntegerArray(s->material, AI_MATKEY_SHADING_MODEL, &shading, &one);
    if (shading == aiShadingMode_Unlit) m->diffuse = color_or(s, AI_MATKEY_BASE_COLOR, sl_grey(1.0f));
    else if (has_number(s, AI_MATKEY_GLOSSINESS_FACTOR, &glossiness))
        status = specular_glossiness(s, glossiness, m);
    else status = metallic_workflow(s, m);
    if (status != SL_OK) return status;
    gltf_alpha(s, m);
    return gltf_emission(s, strength, m);
}

/* ---- all of them ----------------------------------------------------------------------------- */

sl_status sl_import_materials(const char *path, const struct aiScene *file, const cJSON *gltf,
                              sl_model *model, sl_error *error) {
    sl_status status = SL_OK;
    for (unsigned i = 0; i < file->mNumMaterials && status == SL_OK; i++) {
        struct aiString name = {.data = ""};
        const source s = {path, file, file->mMaterials[i], name.data, model, error};
        sl_material made = sl_grey_material(name.data, 0.6f);
        uint32_t index;
        if (s.material) aiGetMaterialString(s.material, AI_MATKEY_NAME, &name);
        if (s.material && gltf)
            status = gltf_material(&s, sl_gltf_emissive_strength(gltf, name.data), &made);
        else if (s.material) status = classic_material(&s, &made);
        if (status == SL_OK) status = sl_model_add_material(model, &made, &index, error);
    }
    return status;
}
