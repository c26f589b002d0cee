#include "import/gltf.h"

#include <string.h>

#include "base/error.h"

/* Extensions that are read here or by the importer, as they are meant. */
static const char *const had[] = {"KHR_lights_punctual", "KHR_materials_emissive_strength",
                                  "KHR_materials_pbrSpecularGlossiness", "KHR_texture_transform"};

static const cJSON *member(const cJSON *item, const char *name) {
    return cJSON_GetObjectItemCaseSensitive(item, name);
}

static bool is_had(const char *name) {
    for (size_t i = 0; i < sizeof had / sizeof had[0]; i++) {
        if (strcmp(name, had[i]) == 0) return true;
    }
    return false;
}

sl_status sl_gltf_check_required(const char *path, const cJSON *root, sl_error *error) {
    const cJSON *name;
    cJSON_ArrayForEach(name, member(root, "extensionsRequired")) {
        if (!cJSON_IsString(name) || is_had(name->valuestring)) continue;
        return sl_fail(error, SL_ERROR_INPUT,
                       "%s: requires the glTF extension %s, which is not supported: expected plain "
                       "(uncompressed) glTF 2.0",
                       path, name->valuestring);
    }
    return SL_OK;
}

/* ---- the lines ----------------------------------------------------------------------------------------- */

static const char *in_place_of(const char *extension) {
    if (strcmp(extension, "KHR_materials_unlit") == 0) return "it is drawn as diffuse, and lit";
    if (strcmp(extension, "KHR_materials_transmission") == 0) return "it is drawn opaque";
    return "it is left out";
}

static void tell_extension(const char *path, const char *name, sl_model *model) {
    if (!is_had(name))
        sl_scene_warn(&model->scene, "%s: the extension %s is not supported: %s", path, name,
                      in_place_of(name));
}

static void tell_extensions(const char *path, const cJSON *root, sl_model *model) {
    const cJSON *name, *material, *extension;
    cJSON_ArrayForEach(name, member(root, "extensionsUsed")) {
        if (cJSON_IsString(name)) tell_extension(path, name->valuestring, model);
    }
    cJSON_ArrayForEach(material, member(root, "materials")) { /* which may use what is not listed */
        cJSON_ArrayForEach(extension, member(material, "extensions")) {
            if (extension->string) tell_extension(path, extension->string, model);
        }
    }
}

static bool has_morphs(const cJSON *root) {
    const cJSON *mesh, *primitive;
    cJSON_ArrayForEach(mesh, member(root, "meshes")) {
        cJSON_ArrayForEach(primitive, member(mesh, "primitives")) {
            if (cJSON_GetArraySize(member(primitive, "targets")) > 0) return true;
        }
    }
    return false;
}

void sl_gltf_tell_features(const char *path, const cJSON *root, sl_model *model) {
    const cJSON *material;
    tell_extensions(path, root, model);
    cJSON_ArrayForEach(material, member(root, "materials")) {
        if (cJSON_IsObject(member(material, "normalTexture")))
            sl_scene_warn(&model->scene, "%s: normal maps are not used", path);
    }
    if (has_morphs(root)) sl_scene_warn(&model->scene, "%s: morph targets are not applied", path);
    if (cJSON_GetArraySize(member(root, "animations")) > 0)
        sl_scene_warn(&model->scene, "%s: animations are not played", path);
}
