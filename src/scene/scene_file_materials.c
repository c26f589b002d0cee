/* Scene files: materials, which override those of the mesh files by name, key by key. */
#include <float.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/values.h"
#include "scene/file.h"
#include "scene/scene_file.h"

/* ---- one material ---------------------------------------------------------------------------- */

/* A file name, or null to take away what the mesh file says. */
static void read_texture(sl_scene_file *file, const cJSON *item, uint32_t *texture) {
    sl_json *json = &file->json;
    if (!item || json->status != SL_OK) return;
    if (cJSON_IsNull(item)) {
        *texture = SL_NO_INDEX;
        return;
    }
    const char *name = sl_json_string(json, item);
    char *path = name ? sl_file_beside(json->path, name) : NULL;
    if (name && !path) json->status = sl_fail_memory(json->error, "a file name");
    if (!path) return;
    sl_error problem;
    if (sl_file_exists(path))
        sl_json_take(json, item, "texture",
                     sl_model_texture(&file->model, path, NULL, 0, texture, &problem), &problem);
    else sl_json_fail(json, item, "texture '%s' does not exist", path);
    sl_free(path);
}

static void read_heights(sl_scene_file *file, const cJSON *item, sl_material *m) {
    const cJSON *bump = sl_json_get(item, "bump"), *depth = sl_json_get(item, "bump_depth");
    uint32_t texture = m->height_map > 0 ? m->height_map - 1 : SL_NO_INDEX;
    read_texture(file, bump, &texture);
    m->height_map = texture == SL_NO_INDEX ? 0 : texture + 1;
    if (bump && !(m->bump_depth > 0.0f)) m->bump_depth = SL_BUMP_DEPTH;
    double value;
    if (sl_json_number(&file->json, depth, 0.0, 1.0, &value)) m->bump_depth = (float)value;
}

static void check_range(sl_json *json, const cJSON *item, sl_rgb value) {
    if (item && sl_rgb_max(value) > 1.0f)
        sl_json_fail(json, item, "expected reflectance '%s' from 0 to 1", item->string);
}

static void override(sl_scene_file *file, const cJSON *item, sl_material *m) {
    sl_json *json = &file->json;
    const cJSON *diffuse = sl_json_get(item, "diffuse"), *specular = sl_json_get(item, "specular"),
                *mirror = sl_json_get(item, "mirror");
    /* A mirror has no other lobe: naming one kind of reflection takes the other away. */
    if (mirror) m->diffuse = m->specular = sl_grey(0.0f);
    else if (diffuse || specular) m->mirror = sl_grey(0.0f);
    if (mirror && (diffuse || specular))
        sl_json_fail(json, mirror, "expected either 'mirror', or 'diffuse' and 'specular'");
    if (sl_json_rgb(json, diffuse, &m->diffuse)) check_range(json, diffuse, m->diffuse);
    if (sl_json_rgb(json, specular, &m->specular)) check_range(json, specular, m->specular);
    if (sl_json_rgb(json, mirror, &m->mirror)) check_range(json, mirror, m->mirror);
    double exponent;
    if (sl_json_number(json, sl_json_get(item, "exponent"), 0.0, SL_LARGEST_EXPONENT, &exponent))
        m->exponent = (float)exponent;
    sl_json_rgb(json, sl_json_get(item, "emission"), &m->emission);
    sl_json_bool(json, sl_json_get(item, "two_sided"), &m->emission_two_sided);
    read_texture(file, sl_json_get(item, "texture"), &m->texture);
    read_texture(file, sl_json_get(item, "alpha"), &m->alpha_texture);
    read_heights(file, item, m);
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
    for (size_t i = 0; i < file->model.scene.material_count; i++) {
        if (strcmp(file->model.scene.materials[i].name, name) == 0) return (uint32_t)i;
    }
    fail_unknown(file, item, name);
    return 0;
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
    if (cJSON_GetArraySize(list) > SL_JSON_ENTRIES) {
        sl_json_fail(json, list, "expected 'materials' to have at most %d entries, got %d", SL_JSON_ENTRIES,
                     cJSON_GetArraySize(list));
        return;
    }
    for (const cJSON *item = list->child; item && json->status == SL_OK; item = item->next)
        read_material(file, item, meshes);
}
