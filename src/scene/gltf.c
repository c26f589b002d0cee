#include "scene/gltf.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/file.h"

/* Required extensions that change no geometry, or that are read here or by the importer. */
static const char *const understood[] = {"KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_unlit",
                                         "KHR_materials_clearcoat", "KHR_materials_sheen", "KHR_materials_specular",
                                         "KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume",
                                         "KHR_texture_transform"};

static uint32_t little_endian(const char *at) {
    const unsigned char *b = (const unsigned char *)at;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* The JSON text: a .gltf file is one, a .glb file holds it as its first chunk, behind 12 bytes of header and 8 of its own. */
static bool find_json(const char *data, size_t size, const char **json, size_t *length) {
    *json = data;
    *length = size;
    if (size < 4 || memcmp(data, "glTF", 4) != 0) return true;
    if (size < 20 || memcmp(data + 16, "JSON", 4) != 0) return false;
    *json = data + 20;
    *length = little_endian(data + 12);
    return *length <= size - 20;
}

static sl_status check_extensions(const char *path, const cJSON *root, sl_error *error) {
    const cJSON *name;
    cJSON_ArrayForEach(name, cJSON_GetObjectItemCaseSensitive(root, "extensionsRequired")) {
        bool known = false;
        if (!cJSON_IsString(name)) continue;
        for (size_t i = 0; i < sizeof understood / sizeof understood[0]; i++) known |= strcmp(name->valuestring, understood[i]) == 0;
        if (known) continue;
        return sl_fail(error, SL_ERROR_INPUT, "%s: requires the glTF extension %s, which is not supported: expected plain "
                       "(uncompressed) glTF 2.0", path, name->valuestring);
    }
    return SL_OK;
}

static double number_or(const cJSON *item, double otherwise) {
    return cJSON_IsNumber(item) && isfinite(item->valuedouble) ? item->valuedouble : otherwise;
}

static sl_status read_lists(const cJSON *root, sl_gltf *gltf, sl_error *error) {
    const cJSON *materials = cJSON_GetObjectItemCaseSensitive(root, "materials"), *cameras = cJSON_GetObjectItemCaseSensitive(root, "cameras");
    gltf->material_count = cJSON_IsArray(materials) ? (size_t)cJSON_GetArraySize(materials) : 0;
    gltf->camera_count = cJSON_IsArray(cameras) ? (size_t)cJSON_GetArraySize(cameras) : 0;
    gltf->emissive_strength = sl_allocate(gltf->material_count, sizeof(double));
    gltf->vertical_fov = sl_allocate(gltf->camera_count, sizeof(double));
    if (!gltf->emissive_strength || !gltf->vertical_fov) return sl_fail_memory(error, "a glTF file");
    const cJSON *item = gltf->material_count ? materials->child : NULL;
    for (size_t i = 0; item; item = item->next, i++) {
        const cJSON *extensions = cJSON_GetObjectItemCaseSensitive(item, "extensions");
        const cJSON *emissive = cJSON_GetObjectItemCaseSensitive(extensions, "KHR_materials_emissive_strength");
        gltf->emissive_strength[i] = number_or(cJSON_GetObjectItemCaseSensitive(emissive, "emissiveStrength"), 1.0);
    }
    item = gltf->camera_count ? cameras->child : NULL;
    for (size_t i = 0; item; item = item->next, i++) {
        const cJSON *perspective = cJSON_GetObjectItemCaseSensitive(item, "perspective");
        gltf->vertical_fov[i] = number_or(cJSON_GetObjectItemCaseSensitive(perspective, "yfov"), 0.0);
    }
    return SL_OK;
}

sl_status sl_gltf_read(const char *path, sl_gltf *gltf, sl_error *error) {
    *gltf = (sl_gltf){0};
    char *data;
    size_t size, length;
    const char *json;
    sl_status status = sl_file_read(path, &data, &size, error);
    if (status != SL_OK) return status;
    bool found = find_json(data, size, &json, &length);
    cJSON *root = found ? cJSON_ParseWithLength(json, length) : NULL;
    if (found && !root) root = cJSON_ParseWithLength(json, length); /* it does not tell want of memory from bad text: which is bad again */
    if (!root && sl_memory_has_ended()) {
        status = sl_fail_memory(error, path);
    } else if (!cJSON_IsObject(root)) {
        status = sl_fail(error, SL_ERROR_INPUT, "%s: expected a glTF file: its JSON cannot be read", path);
    } else {
        status = check_extensions(path, root, error);
        if (status == SL_OK) status = read_lists(root, gltf, error);
        if (status != SL_OK) sl_gltf_release(gltf);
    }
    cJSON_Delete(root);
    sl_free(data);
    return status;
}

void sl_gltf_release(sl_gltf *gltf) {
    sl_free(gltf->emissive_strength);
    sl_free(gltf->vertical_fov);
    *gltf = (sl_gltf){0};
}
