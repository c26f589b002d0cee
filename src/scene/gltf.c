#include "scene/gltf.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "scene/file.h"

static const cJSON *member(const cJSON *item, const char *name) {
    return cJSON_GetObjectItemCaseSensitive(item, name);
}

/* ---- materials and cameras ---- */

enum { DEEPEST = 1000 /* deeper files are refused */ };

/* A list of the file, what of it the scene uses, and in which order: that in which nodes lead there, and not the
 * file's. So the importer numbers it. */
typedef struct dictionary {
    size_t count, used_count;
    const cJSON **item, **used;
    bool *seen;
} dictionary;

typedef struct walk {
    dictionary nodes, meshes, materials, cameras;
} walk;

static bool open_dictionary(const cJSON *list, dictionary *d) {
    d->count = cJSON_IsArray(list) ? (size_t)cJSON_GetArraySize(list) : 0;
    d->item = sl_allocate(d->count, sizeof *d->item);
    d->seen = sl_allocate(d->count, sizeof *d->seen);
    d->used = sl_allocate(d->count, sizeof *d->used);
    if (!d->item || !d->seen || !d->used) return false;
    const cJSON *item = d->count ? list->child : NULL;
    for (size_t i = 0; item; item = item->next) d->item[i++] = item;
    return true;
}

static void close_dictionary(dictionary *d) {
    sl_free(d->item);
    sl_free(d->seen);
    sl_free(d->used);
}

/* The item of that number, where it is come to for the first time; else NULL. */
static const cJSON *come_to(dictionary *d, const cJSON *number) {
    if (!cJSON_IsNumber(number) || !(number->valuedouble >= 0.0 && number->valuedouble < (double)d->count))
        return NULL;
    size_t index = (size_t)number->valuedouble;
    if (d->seen[index]) return NULL;
    d->seen[index] = true;
    return d->used[d->used_count++] = d->item[index];
}

/* Children before a node's own mesh, as the importer reads them. */
static void visit_node(walk *w, const cJSON *number, int depth) {
    const cJSON *node = depth < DEEPEST ? come_to(&w->nodes, number) : NULL, *child, *primitive;
    if (!node) return;
    cJSON_ArrayForEach(child, member(node, "children")) visit_node(w, child, depth + 1);
    const cJSON *mesh = come_to(&w->meshes, member(node, "mesh"));
    cJSON_ArrayForEach(primitive, member(mesh, "primitives"))
        come_to(&w->materials, member(primitive, "material"));
    come_to(&w->cameras, member(node, "camera"));
}

static void visit_scene(walk *w, const cJSON *root) {
    const cJSON *scene = member(root, "scene"), *scenes = member(root, "scenes"), *node;
    int index = cJSON_IsNumber(scene) ? scene->valueint : 0;
    cJSON_ArrayForEach(node, member(index >= 0 ? cJSON_GetArrayItem(scenes, index) : NULL, "nodes"))
        visit_node(w, node, 0);
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

static sl_gltf_transform read_transform(const cJSON *material) {
    const cJSON *extensions = member(material, "extensions");
    const cJSON *texture = member(member(material, "pbrMetallicRoughness"), "baseColorTexture");
    const cJSON *diffuse =
        member(member(extensions, "KHR_materials_pbrSpecularGlossiness"), "diffuseTexture");
    const cJSON *from = member(member(diffuse ? diffuse : texture, "extensions"), "KHR_texture_transform");
    sl_gltf_transform t = {.given = cJSON_IsObject(from),
                           .rotation = number_or(member(from, "rotation"), 0.0)};
    double set = number_or(member(from, "texCoord"), -1.0);
    t.set = set >= 0.0 && set < 100.0 ? (int)set : -1;
    read_pair(member(from, "offset"), 0.0, t.offset);
    read_pair(member(from, "scale"), 1.0, t.scale);
    return t;
}

static void read_material(const cJSON *item, size_t i, sl_gltf *gltf) {
    const cJSON *extensions = member(item, "extensions");
    gltf->emissive_strength[i] =
        number_or(member(member(extensions, "KHR_materials_emissive_strength"), "emissiveStrength"), 1.0);
    gltf->unlit[i] = member(extensions, "KHR_materials_unlit") != NULL;
    gltf->base_transform[i] = read_transform(item);
}

static sl_status fill_lists(const dictionary *materials, const dictionary *cameras, sl_gltf *gltf,
                            sl_error *error) {
    gltf->material_count = materials->used_count;
    gltf->camera_count = cameras->used_count;
    gltf->emissive_strength = sl_allocate(gltf->material_count, sizeof(double));
    gltf->unlit = sl_allocate(gltf->material_count, sizeof(bool));
    gltf->base_transform = sl_allocate(gltf->material_count, sizeof(sl_gltf_transform));
    gltf->vertical_fov = sl_allocate(gltf->camera_count, sizeof(double));
    if (!gltf->emissive_strength || !gltf->unlit || !gltf->base_transform || !gltf->vertical_fov)
        return sl_fail_memory(error, "a glTF file");
    for (size_t i = 0; i < materials->used_count; i++) read_material(materials->used[i], i, gltf);
    for (size_t i = 0; i < cameras->used_count; i++)
        gltf->vertical_fov[i] = number_or(member(member(cameras->used[i], "perspective"), "yfov"), 0.0);
    return SL_OK;
}

static sl_status read_lists(const cJSON *root, sl_gltf *gltf, sl_error *error) {
    walk w = {0};
    bool open = open_dictionary(member(root, "nodes"), &w.nodes) &&
                open_dictionary(member(root, "meshes"), &w.meshes) &&
                open_dictionary(member(root, "materials"), &w.materials) &&
                open_dictionary(member(root, "cameras"), &w.cameras);
    if (open) visit_scene(&w, root);
    sl_status status =
        open ? fill_lists(&w.materials, &w.cameras, gltf, error) : sl_fail_memory(error, "a glTF file");
    close_dictionary(&w.nodes);
    close_dictionary(&w.meshes);
    close_dictionary(&w.materials);
    close_dictionary(&w.cameras);
    return status;
}

sl_status sl_gltf_read(const char *path, sl_model *model, sl_gltf *gltf, sl_error *error) {
    *gltf = (sl_gltf){0};
    char *data;
    size_t size, length;
    const char *json;
    sl_status status = sl_file_read(path, &data, &size, error);
    if (status != SL_OK) return status;
    bool found = find_json(data, size, &json, &length);
    cJSON *root = found ? cJSON_ParseWithLength(json, length) : NULL;
    /* it does not tell want of memory from bad text: which is bad again */
    if (found && !root) root = cJSON_ParseWithLength(json, length);
    if (!root && sl_memory_has_ended()) {
        status = sl_fail_memory(error, path);
    } else if (!cJSON_IsObject(root)) {
        status = sl_fail(error, SL_ERROR_INPUT, "%s: expected a glTF file: its JSON cannot be read", path);
    } else {
        status = sl_gltf_check_required(path, root, error);
        if (status == SL_OK) status = read_lists(root, gltf, error);
        if (status == SL_OK) sl_gltf_tell_features(path, root, model);
        else sl_gltf_release(gltf);
    }
    cJSON_Delete(root);
    sl_free(data);
    return status;
}

void sl_gltf_release(sl_gltf *gltf) {
    sl_free(gltf->emissive_strength);
    sl_free(gltf->unlit);
    sl_free(gltf->base_transform);
    sl_free(gltf->vertical_fov);
    *gltf = (sl_gltf){0};
}
