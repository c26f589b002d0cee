#include "scene/gltf_order.h"

#include "base/error.h"
#include "base/memory.h"

enum { DEEPEST = 1000 /* deeper files are refused */ };

/* A list of the file, what of it was come to, and in which order. */
typedef struct dictionary {
    size_t count;
    const cJSON **item;
    bool *seen;
    sl_gltf_list used;
} dictionary;

typedef struct walk {
    dictionary nodes, meshes, materials, cameras;
} walk;

static const cJSON *member(const cJSON *item, const char *name) {
    return cJSON_GetObjectItemCaseSensitive(item, name);
}

static bool open_dictionary(const cJSON *list, dictionary *d) {
    d->count = cJSON_IsArray(list) ? (size_t)cJSON_GetArraySize(list) : 0;
    d->item = sl_allocate(d->count, sizeof *d->item);
    d->seen = sl_allocate(d->count, sizeof *d->seen);
    d->used.item = sl_allocate(d->count, sizeof *d->used.item);
    if (!d->item || !d->seen || !d->used.item) return false;
    const cJSON *item = d->count ? list->child : NULL;
    for (size_t i = 0; item; item = item->next) d->item[i++] = item;
    return true;
}

static void close_dictionary(dictionary *d) {
    sl_free(d->item);
    sl_free(d->seen);
    sl_free(d->used.item);
}

/* The item of that number, where it is come to for the first time; else NULL. */
static const cJSON *come_to(dictionary *d, const cJSON *number) {
    if (!cJSON_IsNumber(number) || !(number->valuedouble >= 0.0 && number->valuedouble < (double)d->count))
        return NULL;
    size_t index = (size_t)number->valuedouble;
    if (d->seen[index]) return NULL;
    d->seen[index] = true;
    return d->used.item[d->used.count++] = d->item[index];
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

sl_status sl_gltf_used(const cJSON *root, sl_gltf_list *materials, sl_gltf_list *cameras, sl_error *error) {
    walk w = {0};
    bool open = open_dictionary(member(root, "nodes"), &w.nodes) &&
                open_dictionary(member(root, "meshes"), &w.meshes) &&
                open_dictionary(member(root, "materials"), &w.materials) &&
                open_dictionary(member(root, "cameras"), &w.cameras);
    if (open) visit_scene(&w, root);
    *materials = w.materials.used;
    *cameras = w.cameras.used;
    w.materials.used.item = w.cameras.used.item = NULL;
    close_dictionary(&w.nodes);
    close_dictionary(&w.meshes);
    close_dictionary(&w.materials);
    close_dictionary(&w.cameras);
    return open ? SL_OK : sl_fail_memory(error, "a glTF file");
}
