#include "import/gltf.h"

#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "image/formats.h"
#include "scene/file.h"

static const cJSON *member(const cJSON *item, const char *name) {
    return cJSON_GetObjectItemCaseSensitive(item, name);
}

/* ---- features that a file asks for ---- */

/* Extensions that are read here or by the importer, as they are meant. */
static const char *const had[] = {"KHR_lights_punctual", "KHR_materials_emissive_strength",
                                  "KHR_materials_pbrSpecularGlossiness", "KHR_texture_transform"};

static bool is_had(const char *name) {
    for (size_t i = 0; i < sizeof had / sizeof had[0]; i++) {
        if (strcmp(name, had[i]) == 0) return true;
    }
    return false;
}

static sl_status check_required(const char *path, const cJSON *root, sl_error *error) {
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

static void tell_features(const char *path, const cJSON *root, sl_model *model) {
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

/* ---- the file ---- */

static uint32_t little_endian(const char *at) {
    const unsigned char *b = (const unsigned char *)at;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* The JSON text: a .gltf file is one, a .glb file holds it as its first chunk, behind 12 bytes of header and
 * 8 of its own. */
static bool find_json(const char *data, size_t size, const char **json, size_t *length) {
    *json = data;
    *length = size;
    if (size < 4 || memcmp(data, "glTF", 4) != 0) return true;
    if (size < 20 || memcmp(data + 16, "JSON", 4) != 0) return false;
    *json = data + 20;
    *length = little_endian(data + 12);
    return *length <= size - 20;
}

static double number_or(const cJSON *item, double otherwise) {
    return cJSON_IsNumber(item) && isfinite(item->valuedouble) ? item->valuedouble : otherwise;
}

static void read_pair(const cJSON *list, double otherwise, double pair[2]) {
    for (int i = 0; i < 2; i++) pair[i] = number_or(cJSON_GetArrayItem(list, i), otherwise);
}

static cJSON *parse(const char *data, size_t size) {
    const char *json;
    size_t length;
    if (!find_json(data, size, &json, &length)) return NULL;
    cJSON *root = cJSON_ParseWithLength(json, length);
    /* it does not tell want of memory from bad text: which is bad again */
    return root ? root : cJSON_ParseWithLength(json, length);
}

sl_status sl_gltf_read(const char *path, sl_model *model, cJSON **gltf, sl_error *error) {
    sl_bytes bytes;
    *gltf = NULL;
    sl_status status = sl_bytes_read(path, SL_FILE_BYTES, &bytes, error);
    if (status != SL_OK) return status;
    *gltf = parse((char *)bytes.data, bytes.size);
    sl_free(bytes.data);
    if (!*gltf && sl_memory_has_ended()) return sl_fail_memory(error, path);
    if (!cJSON_IsObject(*gltf))
        return sl_fail(error, SL_ERROR_INPUT, "%s: expected a glTF file: its JSON cannot be read", path);
    status = check_required(path, *gltf, error);
    if (status == SL_OK) tell_features(path, *gltf, model);
    return status;
}

/* ---- facts ---- */

static const cJSON *material_of(const cJSON *gltf, const char *name) {
    const cJSON *material;
    cJSON_ArrayForEach(material, member(gltf, "materials")) {
        const cJSON *label = member(material, "name");
        if (strcmp(cJSON_IsString(label) ? label->valuestring : "", name) == 0) return material;
    }
    return NULL;
}

double sl_gltf_vertical_fov(const cJSON *gltf, const char *node) {
    const cJSON *camera = NULL, *item;
    cJSON_ArrayForEach(item, member(gltf, "nodes")) {
        const cJSON *name = member(item, "name"), *index = member(item, "camera");
        const bool named = cJSON_IsString(name) && strcmp(name->valuestring, node) == 0;
        if (cJSON_IsNumber(index) && (named || !camera))
            camera = cJSON_GetArrayItem(member(gltf, "cameras"), index->valueint);
    }
    return number_or(member(member(camera, "perspective"), "yfov"), 0.0);
}

double sl_gltf_emissive_strength(const cJSON *gltf, const char *material) {
    const cJSON *extensions = member(material_of(gltf, material), "extensions");
    return number_or(member(member(extensions, "KHR_materials_emissive_strength"), "emissiveStrength"), 1.0);
}

sl_gltf_transform sl_gltf_base_transform(const cJSON *gltf, const char *name) {
    const cJSON *material = material_of(gltf, name), *extensions = member(material, "extensions"),
                *texture = member(member(material, "pbrMetallicRoughness"), "baseColorTexture"),
                *diffuse =
                    member(member(extensions, "KHR_materials_pbrSpecularGlossiness"), "diffuseTexture"),
                *from = member(member(diffuse ? diffuse : texture, "extensions"), "KHR_texture_transform");
    const double set = number_or(member(from, "texCoord"), -1.0);
    sl_gltf_transform t = {.given = cJSON_IsObject(from),
                           .rotation = number_or(member(from, "rotation"), 0.0),
                           .set = set >= 0.0 && set < 100.0 ? (int)set : -1};
    read_pair(member(from, "offset"), 0.0, t.offset);
    read_pair(member(from, "scale"), 1.0, t.scale);
    return t;
}
