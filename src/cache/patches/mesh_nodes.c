/* Memory of a mesh: nodes and roots. Children lie in blocks of four, so that they need one link; blocks that
 * collapse leave form chains and are used again, last freed first. */
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/patches/mesh.h"
#include "cache/patches/mesh_parts.h"

/* ---- all of it ------------------------------------------------------------------------------- */

sl_status sl_mesh_create(const sl_primitives *primitives, int channels, int max_depth, sl_mesh **mesh,
                         sl_error *error) {
    *mesh = NULL;
    if (channels < 1 || channels > 3)
        return sl_fail(error, SL_ERROR_USAGE, "a mesh has 1 to 3 channels, not %d", channels);
    if (max_depth < 0 || max_depth > SL_MESH_DEPTH_MAX)
        return sl_fail(error, SL_ERROR_USAGE, "a mesh is 0 to %d levels deep, not %d", (int)SL_MESH_DEPTH_MAX,
                       max_depth);
    sl_mesh *m = sl_allocate(1, sizeof *m);
    if (m == NULL) return sl_fail_memory(error, "a mesh");
    m->primitives = primitives;
    m->channels = channels;
    m->max_depth = max_depth;
    m->table.stride = sizeof *m->place;
    m->root_slots = 16;
    m->root = sl_allocate(m->root_slots, sizeof *m->root);
    if (m->root == NULL || !sl_place_table_resize(&m->table, 16)) {
        sl_mesh_destroy(m);
        return sl_fail_memory(error, "a mesh");
    }
    sl_mesh_clear(m);
    *mesh = m;
    return SL_OK;
}

void sl_mesh_destroy(sl_mesh *mesh) {
    if (mesh == NULL) return;
    void *const all[] = {mesh->root,   mesh->node,  mesh->place,     mesh->halved,
                         mesh->value, mesh->state, mesh->table.slot};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) sl_free(all[i]);
    sl_free(mesh);
}

size_t sl_mesh_memory_bytes(const sl_mesh *mesh) {
    size_t vertices =
        mesh->vertex_capacity *
        (sizeof *mesh->place + 1 + (size_t)mesh->channels * sizeof *mesh->value + sizeof *mesh->state);
    return sizeof *mesh + (mesh->root_slots + mesh->table.count) * sizeof(uint32_t) +
           mesh->node_capacity * sizeof *mesh->node + vertices;
}

void sl_mesh_clear(sl_mesh *mesh) {
    for (size_t i = 0; i < mesh->root_slots; i++) mesh->root[i] = SL_NO_INDEX;
    for (size_t i = 0; i < mesh->table.count; i++) mesh->table.slot[i] = SL_NO_INDEX;
    mesh->root_count = mesh->node_count = mesh->vertex_count = mesh->leaf_count = mesh->free_nodes = 0;
    mesh->first_free = SL_NO_INDEX;
}

/* ---- nodes ----------------------------------------------------------------------------------- */

static bool grow_nodes(sl_mesh *mesh) {
    if (mesh->node_count + 4 > SL_MESH_ROOT) return false;
    size_t capacity = sl_grown_capacity(mesh->node_capacity, mesh->node_count + 64);
    if (!sl_regrow(&mesh->node, mesh->node_count, capacity, sizeof *mesh->node)) return false;
    mesh->node_capacity = capacity;
    return true;
}

uint32_t sl_mesh_take_nodes(sl_mesh *mesh, int count, uint32_t parent) {
    uint32_t first = count == 4 ? mesh->first_free : SL_NO_INDEX, n = (uint32_t)count;
    if (first != SL_NO_INDEX) {
        mesh->first_free = mesh->node[first].child;
        mesh->free_nodes -= 4;
    } else {
        if (mesh->node_count + n > mesh->node_capacity && !grow_nodes(mesh)) return SL_NO_INDEX;
        first = (uint32_t)mesh->node_count;
        mesh->node_count += n;
    }
    for (uint32_t i = first; i < first + n; i++)
        mesh->node[i] = (sl_mesh_node){
            .child = SL_NO_INDEX, .parent = parent, .vertex = {SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX}};
    return first;
}

void sl_mesh_free_nodes(sl_mesh *mesh, uint32_t first) {
    for (uint32_t i = first; i < first + 4; i++) mesh->node[i].parent = SL_NO_INDEX;
    mesh->node[first].child = mesh->first_free;
    mesh->first_free = first;
    mesh->free_nodes += 4;
}

/* ---- roots ----------------------------------------------------------------------------------- */

/* Returns where a face's root is in the table, or would be. */
static size_t root_slot(const sl_mesh *mesh, uint32_t face) {
    size_t i = sl_slot_of_hash(sl_hash64(face), mesh->root_slots);
    while (mesh->root[i] != SL_NO_INDEX && mesh->node[mesh->root[i]].parent != (SL_MESH_ROOT | face))
        i = sl_slot_after(i, mesh->root_slots);
    return i;
}

uint32_t sl_mesh_root_of(const sl_mesh *mesh, uint32_t face) { return mesh->root[root_slot(mesh, face)]; }

static void fill_roots(sl_mesh *mesh) {
    for (size_t i = 0; i < mesh->root_slots; i++) mesh->root[i] = SL_NO_INDEX;
    for (uint32_t n = 0; n < mesh->node_count; n++)
        if (sl_mesh_is_root(mesh, n)) mesh->root[root_slot(mesh, mesh->node[n].parent & ~SL_MESH_ROOT)] = n;
}

static bool grow_roots(sl_mesh *mesh) {
    size_t slots = sl_grown_capacity(mesh->root_slots, 16);
    uint32_t *root = sl_allocate_unset(slots, sizeof *root);
    if (root == NULL) return false;
    sl_free(mesh->root);
    mesh->root = root;
    mesh->root_slots = slots;
    fill_roots(mesh);
    return true;
}

uint32_t sl_mesh_root(sl_mesh *mesh, uint32_t face, sl_status *status, sl_error *error) {
    *status = SL_OK;
    uint32_t vertex[3], root = sl_mesh_root_of(mesh, face);
    if (root != SL_NO_INDEX) return root;
    for (uint32_t c = 0; c < 3; c++) {
        vertex[c] = sl_mesh_vertex_at(mesh, face, c == 1 ? SL_MESH_DYADIC : 0, c == 2 ? SL_MESH_DYADIC : 0,
                                      status, error);
        if (vertex[c] == SL_NO_INDEX) return SL_NO_INDEX;
    }
    bool room = 4 * (mesh->root_count + 1) <= 3 * mesh->root_slots || grow_roots(mesh);
    root = room ? sl_mesh_take_nodes(mesh, 1, SL_MESH_ROOT | face) : SL_NO_INDEX;
    if (root == SL_NO_INDEX) {
        *status = sl_fail_memory(error, "mesh nodes");
        return root;
    }
    mesh->root[root_slot(mesh, face)] = root;
    mesh->root_count++;
    memcpy(mesh->node[root].vertex, vertex, sizeof vertex);
    mesh->leaf_count++;
    return root;
}

/* ---- a number in a node's flags -------------------------------------------------------------- */

/* Returns the upper half of a float's bits; what has been probed alone has the sign of a negative one. */
static float upper_half(const sl_mesh_node *node) {
    uint32_t bits = node->flags >> SL_NODE_TESTED_SHIFT << SL_NODE_TESTED_SHIFT;
    float size;
    memcpy(&size, &bits, sizeof size);
    return size;
}

static void set_upper_half(sl_mesh_node *node, float size) {
    uint32_t bits;
    memcpy(&bits, &size, sizeof bits);
    node->flags = (node->flags & 0xffffu) | bits >> SL_NODE_TESTED_SHIFT << SL_NODE_TESTED_SHIFT;
}

float sl_mesh_tested_size(const sl_mesh_node *node) {
    float size = upper_half(node);
    return size > 0.0f ? size : 0.0f;
}

void sl_mesh_set_tested_size(sl_mesh_node *node, float size) {
    set_upper_half(node, size > 0.0f ? size : 0.0f); /* NaN, too */
}

float sl_mesh_probed_size(const sl_mesh_node *node) {
    float size = upper_half(node);
    return size < 0.0f ? -size : 2.0f * size;
}

/* A hundredth more, for what the lower half loses. */
void sl_mesh_set_probed_size(sl_mesh_node *node, float size) {
    set_upper_half(node, size > 0.0f && size < 1e30f ? -1.01f * size : -1e30f);
}
