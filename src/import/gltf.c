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

/* ---- materials and cameras ---- */

enum { DEEPEST = 1000 /* deeper files are refused */ };

/* A list of the file, what of it the scene uses, and in which order: that in which nodes lead there, and not
 * the file's. So the importer numbers it. */
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

/* The lists of what the nodes lead to are kept, the others only walked. */
static sl_status read_lists(sl_gltf *gltf, sl_error *error) {
    walk w = {0};
    bool open = open_dictionary(member(gltf->root, "nodes"), &w.nodes) &&
                open_dictionary(member(gltf->root, "meshes"), &w.meshes) &&
                open_dictionary(member(gltf->root, "materials"), &w.materials) &&
                open_dictionary(member(gltf->root, "cameras"), &w.cameras);
    if (open) visit_scene(&w, gltf->root);
    gltf->materials = w.materials.used;
    gltf->material_count = w.materials.used_count;
    gltf->cameras = w.cameras.used;
    gltf->camera_count = w.cameras.used_count;
    w.materials.used = w.cameras.used = NULL;
    close_dictionary(&w.nodes);
    close_dictionary(&w.meshes);
    close_dictionary(&w.materials);
    close_dictionary(&w.cameras);
    return open ? SL_OK : sl_fail_memory(error, "a glTF file");
}

static cJSON *parse(const char *data, size_t size) {
    const char *json;
    size_t length;
    if (!find_json(data, size, &json, &length)) return NULL;
    cJSON *root = cJSON_ParseWithLength(json, length);
    /* it does not tell want of memory from bad text: which is bad again */
    return root ? root : cJSON_ParseWithLength(json, length);
}

sl_status sl_gltf_read(const char *path, sl_model *model, sl_gltf *gltf, sl_error *error) {
    sl_bytes bytes;
    *gltf = (sl_gltf){0};
    sl_status status = sl_bytes_read(path, SL_FILE_BYTES, &bytes, error);
    if (status != SL_OK) return status;
    gltf->root = parse((char *)bytes.data, bytes.size);
    sl_free(bytes.data);
    if (!gltf->root && sl_memory_has_ended()) return sl_fail_memory(error, path);
    if (!cJSON_IsObject(gltf->root))
        return sl_fail(error, SL_ERROR_INPUT, "%s: expected a glTF file: its JSON cannot be read", path);
    status = sl_gltf_check_required(path, gltf->root, error);
    if (status == SL_OK) status = read_lists(gltf, error);
    if (status == SL_OK) sl_gltf_tell_features(path, gltf->root, model);
    return status;
}

void sl_gltf_release(sl_gltf *gltf) {
    cJSON_Delete(gltf->root);
    sl_free(gltf->materials);
    sl_free(gltf->cameras);
    *gltf = (sl_gltf){0};
}

/* ---- facts ---- */

static const cJSON *material_of(const sl_gltf *gltf, size_t number) {
    return gltf && number < gltf->material_count ? gltf->materials[number] : NULL;
}

double sl_gltf_emissive_strength(const sl_gltf *gltf, size_t material) {
    const cJSON *extensions = member(material_of(gltf, material), "extensions");
    return number_or(member(member(extensions, "KHR_materials_emissive_strength"), "emissiveStrength"), 1.0);
}

bool sl_gltf_is_unlit(const sl_gltf *gltf, size_t material) {
    return member(member(material_of(gltf, material), "extensions"), "KHR_materials_unlit") != NULL;
}

sl_gltf_transform sl_gltf_base_transform(const sl_gltf *gltf, size_t number) {
    const cJSON *material = material_of(gltf, number), *extensions = member(material, "extensions"),
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

double sl_gltf_vertical_fov(const sl_gltf *gltf, size_t camera) {
    const cJSON *item = camera < gltf->camera_count ? gltf->cameras[camera] : NULL;
    return number_or(member(member(item, "perspective"), "yfov"), 0.0);
}
