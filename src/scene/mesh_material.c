/* From an imported file's materials to ours: MTL and its like by name, glTF's metallic-roughness by the
 * mapping kd = base (1 - metallic), ks = 0.04 + (base - 0.04) metallic, n = clamp(2 / roughness^4 - 2, 1,
 * 10000). */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/file.h"
#include "scene/gltf.h"
#include "scene/mesh_file.h"

typedef struct source {
    const char *path;
    const sl_import *file;
    const sl_import_material *material;
    const char *name;
    sl_model *model;
    sl_error *error;
} source;

static float float_or(const source *s, sl_import_field field, float otherwise) {
    return s->material->has >> field & 1 ? s->material->value[field][0] : otherwise;
}
static sl_rgb color_or(const source *s, sl_import_field field, sl_rgb otherwise) {
    const float *c = s->material->value[field];
    return s->material->has >> field & 1 ? (sl_rgb){c[0], c[1], c[2]} : otherwise;
}

/* ---- textures -------------------------------------------------------------------------------- */

/* An image inside the file: compressed bytes, or texels. */
static sl_status embedded_texture(const source *s, const sl_import_texture *t, const char *name,
                                  uint32_t *index) {
    if (t->compressed) return sl_model_texture(s->model, name, t->data, t->bytes, index, s->error);
    sl_model_warn(s->model, "%s: texture left out: uncompressed embedded images are not read", name);
    *index = SL_NO_INDEX;
    return SL_OK;
}

/* "%20" in file names stands for a blank. */
static void decode_blanks(char *name) {
    char *to = name;
    for (const char *from = name; *from; from++) {
        bool blank = from[0] == '%' && from[1] == '2' && from[2] == '0';
        *to++ = blank ? ' ' : *from;
        if (blank) from += 2;
    }
    *to = 0;
}

/* Exporters write back slashes, %20, and folders of the machine they ran on: of the names that can be meant,
 * the first that exists and may be read; else the first that exists, and else the name as it is. Then reading
 * it says what is wrong. */
static char *find_texture_file(const source *s, char *name) {
    for (char *c = name; *c; c++) {
        if (*c == '\\') *c = '/';
    }
    char *candidates[3] = {sl_file_beside(s->path, name)};
    decode_blanks(name);
    const char *base = strrchr(name, '/');
    candidates[1] = sl_file_beside(s->path, name);
    candidates[2] = sl_file_beside(s->path, base ? base + 1 : name);
    int best = 0, score = -1;
    for (int i = 0; i < 3; i++) {
        bool exists = candidates[i] && sl_file_exists(candidates[i]);
        int worth = exists + (exists && sl_file_is_below(s->model->folder, candidates[i]));
        if (worth > score) score = worth, best = i;
    }
    for (int i = 0; i < 3; i++) {
        if (i != best) sl_free(candidates[i]);
    }
    return candidates[best];
}

static sl_status find_texture(const source *s, sl_import_map map, uint32_t *index) {
    char *name = s->material->map[map];
    *index = SL_NO_INDEX;
    if (!name) return SL_OK;
    if (name[0] == '*') {
        unsigned number = 0;
        if (sscanf(name + 1, "%u", &number) != 1 || number >= s->file->texture_count) return SL_OK;
        char label[1200];
        snprintf(label, sizeof label, "%.*s%.100s", 1000, s->path, name);
        return embedded_texture(s, &s->file->textures[number], label, index);
    }
    char *path = find_texture_file(s, name);
    if (!path) return sl_fail_memory(s->error, "a file name");
    sl_error problem;
    sl_status status = sl_model_texture(s->model, path, NULL, 0, index, &problem);
    if (status == SL_ERROR_INPUT)
        sl_fail(s->error, status, "%s: material '%s': texture %s", s->path, s->name, problem.message);
    else if (status != SL_OK) sl_fail(s->error, status, "%s", problem.message);
    sl_free(path);
    return status;
}

/* Tells whether a picture's colours are unit normals, as (n + 1) / 2, that mostly point away from the
 * surface: exporters put such maps where heights are meant. */
static bool holds_normals(const sl_texture *t) {
    const size_t texels = (size_t)t->width * (size_t)t->height;
    size_t unit = 0;
    for (size_t i = 0; i < texels; i++) {
        const uint8_t *p = t->texels + 4 * i;
        const double x = p[0] / 127.5 - 1.0, y = p[1] / 127.5 - 1.0, z = p[2] / 127.5 - 1.0,
                     square = x * x + y * y + z * z;
        unit += z > 0.0 && square > 0.7 && square < 1.3 && p[2] > p[0] && p[2] > p[1];
    }
    return (double)unit > 0.9 * (double)texels;
}

static const sl_texture *texture_at(const source *s, uint32_t index) {
    return index == SL_NO_INDEX ? NULL : &s->model->textures[index];
}

/* ---- MTL, and whatever else has a diffuse and a specular colour ------------------------------ */

static sl_status classic_material(const source *s, sl_material *m) {
    bool is_obj = sl_file_has_extension(s->path, ".obj");
    m->diffuse = color_or(s, SL_IMPORT_DIFFUSE, sl_grey(0.6f));
    m->specular = color_or(s, SL_IMPORT_SPECULAR, sl_grey(0.0f));
    m->emission = color_or(s, SL_IMPORT_EMISSIVE, sl_grey(0.0f));
    m->exponent = float_or(s, SL_IMPORT_SHININESS, 0.0f);
    if (!is_obj) { /* other formats say "no gloss" by a shininess of 0, and may scale the colour */
        m->specular =
            sl_rgb_scale(m->specular, m->exponent > 0.0f ? float_or(s, SL_IMPORT_STRENGTH, 1.0f) : 0.0f);
    }
    float illum = float_or(s, SL_IMPORT_ILLUM, 0.0f);
    if ((illum == 3.0f || illum == 5.0f) && !(sl_rgb_max(m->diffuse) > 0.0f)) {
        m->mirror = m->specular;
        m->specular = sl_grey(0.0f);
    }
    if (float_or(s, SL_IMPORT_OPACITY, 1.0f) < 1.0f) {
        sl_model_warn(s->model, "%s: material '%s' is transparent, which is not modelled: it is drawn opaque",
                      s->path, s->name);
    }
    sl_status status = find_texture(s, SL_IMPORT_MAP_DIFFUSE, &m->texture);
    if (status == SL_OK) status = find_texture(s, SL_IMPORT_MAP_OPACITY, &m->alpha_texture);
    uint32_t heights = SL_NO_INDEX;
    if (status == SL_OK && is_obj) status = find_texture(s, SL_IMPORT_MAP_HEIGHT, &heights);
    if (heights != SL_NO_INDEX && holds_normals(texture_at(s, heights))) {
        sl_model_warn(s->model, "%s: material '%s': its bump map holds normals, not heights, and is not used",
                      s->path, s->name);
        heights = SL_NO_INDEX;
    }
    m->height_map = heights == SL_NO_INDEX ? 0 : heights + 1;
    m->bump_depth = SL_BUMP_DEPTH;
    return status;
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

static float clamp_unit(float value) { return fminf(fmaxf(value, 0.0f), 1.0f); }

/* A texture that modulates a constant of ours enters by its mean. */
static sl_status modulate(const source *s, float *metallic, float *roughness) {
    uint32_t index;
    sl_status status = find_texture(s, SL_IMPORT_MAP_METALNESS, &index);
    if (status == SL_OK && index == SL_NO_INDEX) status = find_texture(s, SL_IMPORT_MAP_UNKNOWN, &index);
    const sl_texture *texture = texture_at(s, index);
    if (status != SL_OK || !texture) return status;
    sl_rgb mean = sl_texture_mean_data(texture);
    *roughness *= mean.g;
    *metallic *= mean.b;
    sl_model_warn(s->model, "%s: material '%s': metalness and roughness are those of its texture's mean",
                  s->path, s->name);
    return SL_OK;
}

static sl_status gltf_emission(const source *s, double strength, sl_material *m) {
    m->emission = sl_rgb_scale(color_or(s, SL_IMPORT_EMISSIVE, sl_grey(0.0f)), (float)strength);
    m->emission_two_sided = float_or(s, SL_IMPORT_TWO_SIDED, 0.0f) != 0.0f;
    if (!sl_material_is_emitter(m)) return SL_OK;
    uint32_t index;
    sl_status status = find_texture(s, SL_IMPORT_MAP_EMISSIVE, &index);
    if (status != SL_OK || index == SL_NO_INDEX) return status;
    m->emission = sl_rgb_mul(m->emission, sl_texture_mean_color(texture_at(s, index)));
    sl_model_warn(s->model, "%s: material '%s': emission is that of its texture's mean", s->path, s->name);
    return SL_OK;
}

static void gltf_alpha(const source *s, sl_material *m) {
    const char *mode = s->material->alpha_mode;
    if (!mode || strcmp(mode, "OPAQUE") == 0) return;
    const sl_texture *texture = texture_at(s, m->texture);
    if (texture && texture->has_alpha) m->alpha_texture = m->texture;
    bool blend = strcmp(mode, "BLEND") == 0;
    if (blend || float_or(s, SL_IMPORT_CUTOFF, 0.5f) != 0.5f) {
        sl_model_warn(s->model, "%s: material '%s': alpha is a mask, tested at 0.5", s->path, s->name);
    }
}

/* The alpha of a texture, which find_texture() takes for a mask's. */
static float mean_alpha(const sl_texture *t) {
    uint64_t sum = 0;
    size_t texels = (size_t)t->width * (size_t)t->height;
    for (size_t i = 0; i < texels; i++) sum += t->texels[4 * i + 3];
    return (float)((double)sum / (255.0 * (double)texels));
}

/* KHR_materials_pbrSpecularGlossiness: kd = diffuse (1 - max(specular)), ks = specular, roughness = 1 -
 * glossiness. */
static sl_status specular_glossiness(const source *s, float glossiness, sl_material *m) {
    uint32_t index;
    m->diffuse = color_or(s, SL_IMPORT_DIFFUSE, sl_grey(1.0f));
    m->specular = color_or(s, SL_IMPORT_SPECULAR, sl_grey(1.0f));
    sl_status status = find_texture(s, SL_IMPORT_MAP_SPECULAR, &index);
    const sl_texture *texture = status == SL_OK ? texture_at(s, index) : NULL;
    if (texture) {
        m->specular = sl_rgb_mul(m->specular, sl_texture_mean_color(texture));
        glossiness *= mean_alpha(texture);
        sl_model_warn(s->model,
                      "%s: material '%s': specular colour and glossiness are those of its texture's mean",
                      s->path, s->name);
    }
    m->diffuse = sl_rgb_scale(m->diffuse, 1.0f - clamp_unit(sl_rgb_max(m->specular)));
    set_roughness(m, 1.0f - clamp_unit(glossiness));
    return status;
}

static sl_status metallic_workflow(const source *s, sl_material *m) {
    sl_rgb base = color_or(s, SL_IMPORT_BASE, color_or(s, SL_IMPORT_DIFFUSE, sl_grey(1.0f)));
    float metallic = float_or(s, SL_IMPORT_METALLIC, 1.0f),
          roughness = float_or(s, SL_IMPORT_ROUGHNESS, 1.0f);
    sl_status status = modulate(s, &metallic, &roughness);
    if (status != SL_OK) return status;
    const sl_texture *texture = texture_at(s, m->texture);
    sl_rgb textured = base;
    if (texture && metallic > 0.0f) {
        textured = sl_rgb_mul(base, sl_texture_mean_color(texture));
        sl_model_warn(s->model,
                      "%s: material '%s': the colour of its metal is that of its base texture's mean",
                      s->path, s->name);
    }
    metallic_roughness(m, base, textured, clamp_unit(metallic), clamp_unit(roughness));
    return SL_OK;
}

static sl_status gltf_material(const source *s, bool unlit, double strength, sl_material *m) {
    sl_status status = find_texture(s, SL_IMPORT_MAP_DIFFUSE, &m->texture);
    if (status != SL_OK) return status;
    if (unlit) m->diffuse = color_or(s, SL_IMPORT_BASE, sl_grey(1.0f));
    else if (s->material->has >> SL_IMPORT_GLOSSINESS & 1)
        status = specular_glossiness(s, float_or(s, SL_IMPORT_GLOSSINESS, 1.0f), m);
    else status = metallic_workflow(s, m);
    if (status != SL_OK) return status;
    gltf_alpha(s, m);
    return gltf_emission(s, strength, m);
}

/* Of other formats than glTF; they are rare. */
static void warn_of_transform(const source *s) {
    const float *t = s->material->value[SL_IMPORT_UV_TRANSFORM];
    if (!(s->material->has >> SL_IMPORT_UV_TRANSFORM & 1)) return;
    if (t[0] == 0.0f && t[1] == 0.0f && t[2] == 1.0f && t[3] == 1.0f && t[4] == 0.0f) return;
    sl_model_warn(s->model, "%s: material '%s': the texture's offset, scale and rotation are not applied",
                  s->path, s->name);
}

/* ---- all of them ----------------------------------------------------------------------------- */

sl_status sl_mesh_materials(const char *path, const sl_import *file, const struct sl_gltf *gltf,
                            sl_model *model, sl_error *error) {
    for (uint32_t i = 0; i < file->material_count; i++) {
        const sl_import_material *from = &file->materials[i];
        source s = {path, file, from, from->name, model, error};
        sl_material material = {.name = from->name, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
        double strength = gltf && i < gltf->material_count ? gltf->emissive_strength[i] : 1.0;
        bool unlit = gltf && i < gltf->material_count && gltf->unlit[i];
        sl_status status =
            gltf ? gltf_material(&s, unlit, strength, &material) : classic_material(&s, &material);
        uint32_t index;
        if (!gltf) warn_of_transform(&s);
        if (status == SL_OK) status = sl_model_add_material(model, &material, &index, error);
        if (status != SL_OK) return status;
    }
    return SL_OK;
}
