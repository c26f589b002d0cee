/* Scene files: materials, which override those of the mesh files by name, key by key. */
#include <float.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/values.h"
#include "scene/file.h"
#include "scene/scene_file.h"

/* ---- one material ---------------------------------------------------------------------------- */

static void find_texture(sl_scene_file *file, const cJSON *item, uint32_t *index) {
    sl_json *json = &file->json;
    const char *name = sl_json_string(json, item);
    char *path = name ? sl_file_beside(json->path, name) : NULL;
    if (name && !path) json->status = sl_fail_memory(json->error, "a file name");
    if (!path) return;
    sl_error problem;
    if (sl_file_exists(path))
        sl_json_take(json, item, "texture", sl_model_texture(&file->model, path, NULL, 0, index, &problem),
                     &problem);
    else sl_json_fail(json, item, "texture '%s' does not exist", path);
    sl_free(path);
}

/* Reads a file name, or null, which takes away what the mesh file says. */
static void read_texture(sl_scene_file *file, const cJSON *item, const sl_material_texture *t,
                         sl_material *m) {
    uint32_t index = SL_NO_INDEX;
    if (!item || file->json.status != SL_OK) return;
    if (!cJSON_IsNull(item)) find_texture(file, item, &index);
    memcpy((char *)m + t->field, &index, sizeof index);
}

static void read_number(sl_json *json, const cJSON *item, const sl_material_number *n, sl_material *m) {
    const double most = (double)FLT_MAX;
    double number = 0.0;
    sl_rgb c = {0};
    char text[SL_RULE_TEXT];
    const bool there = n->floats == 3 ? sl_json_rgb(json, item, &c)
                                      : sl_json_number(json, item, -most, most, &number);
    if (!there) return;
    if (n->floats == 1) c.r = (float)number;
    memcpy((char *)m + n->field, (float[3]){c.r, c.g, c.b}, (size_t)n->floats * sizeof(float));
    if (!sl_material_number_fits(n, m, text)) sl_json_fail(json, item, "%s", text);
}

static void override(sl_scene_file *file, const cJSON *item, sl_material *m) {
    sl_json *json = &file->json;
    const cJSON *mirror = sl_json_get(item, "mirror");
    const bool other = sl_json_get(item, "diffuse") || sl_json_get(item, "specular");
    /* A mirror has no other lobe: naming one kind of reflection takes the other away. */
    if (mirror) m->diffuse = m->specular = sl_grey(0.0f);
    else if (other) m->mirror = sl_grey(0.0f);
    if (mirror && other) sl_json_fail(json, mirror, SL_EXPECTED_ONE_REFLECTION);
    for (int i = 0; i < SL_MATERIAL_NUMBERS; i++)
        read_number(json, sl_json_get(item, sl_material_numbers[i].key), &sl_material_numbers[i], m);
    sl_json_bool(json, sl_json_get(item, "two_sided"), &m->emission_two_sided);
    for (int i = 0; i < SL_MATERIAL_TEXTURES; i++)
        read_texture(file, sl_json_get(item, sl_material_textures[i].key), &sl_material_textures[i], m);
    if (sl_json_get(item, "bump") && !sl_json_get(item, "bump_depth") && !(m->bump_depth > 0.0f))
        m->bump_depth = SL_BUMP_DEPTH;
}

/* ---- all of them ----------------------------------------------------------------------------- */

static const char **names_of(const sl_scene_file *file) {
    const char **names = sl_allocate(file->model.scene.material_count, sizeof *names);
    for (size_t i = 0; names && i < file->model.scene.material_count; i++)
        names[i] = file->model.scene.materials[i].name;
    return names;
}

static void fail_unknown(sl_scene_file *file, const cJSON *item, const char *name) {
    const char **names = names_of(file);
    const char *nearest = names ? sl_nearest_word(name, names, file->model.scene.material_count) : NULL;
    if (nearest)
        sl_json_fail(&file->json, item, "no mesh has a material '%s'; expected '%s'?", name, nearest);
    else sl_json_fail(&file->json, item, "no mesh has a material '%s'", name);
    sl_free(names);
}

uint32_t sl_scene_file_material_named(sl_scene_file *file, const cJSON *item, const char *name) {
    const uint32_t number = sl_scene_find_material(&file->model.scene, name);
    if (!number) fail_unknown(file, item, name);
    return number ? number - 1 : 0;
}

static bool a_mesh_asks_for(const cJSON *meshes, const char *name) {
    const cJSON *mesh;
    cJSON_ArrayForEach(mesh, meshes) {
        const cJSON *material = sl_json_get(mesh, "material");
        if (cJSON_IsString(material) && strcmp(material->valuestring, name) == 0) return true;
    }
    return false;
}

static void read_material(sl_scene_file *file, const cJSON *item, const cJSON *meshes) {
    sl_json *json = &file->json;
    if (!SL_JSON_KEYS(json, item, "a material", "diffuse", "specular", "exponent", "mirror", "emission",
                      "two_sided", "texture", "alpha", "bump", "bump_depth"))
        return;
    bool found = false;
    for (size_t i = 0; i < file->model.scene.material_count && json->status == SL_OK; i++) {
        if (strcmp(file->model.scene.materials[i].name, item->string) != 0) continue;
        found = true;
        override(file, item, &file->model.scene.materials[i]);
    }
    if (found || json->status != SL_OK) return;
    if (!a_mesh_asks_for(meshes, item->string)) {
        fail_unknown(file, item, item->string);
        return;
    }
    sl_material fresh = sl_grey_material(item->string, 0.5f);
    uint32_t index;
    override(file, item, &fresh);
    if (json->status == SL_OK)
        json->status = sl_model_add_material(&file->model, &fresh, &index, json->error);
}

void sl_scene_file_materials(sl_scene_file *file, const cJSON *list, const cJSON *meshes) {
    sl_json *json = &file->json;
    if (!list || json->status != SL_OK) return;
    if (!cJSON_IsObject(list)) {
        sl_json_fail(json, list, "expected 'materials' to be an object { NAME: { ... } }");
        return;
    }
    const size_t count = sl_json_entries(json, list);
    for (const cJSON *item = count ? list->child : NULL; item && json->status == SL_OK; item = item->next)
        read_material(file, item, meshes);
}
