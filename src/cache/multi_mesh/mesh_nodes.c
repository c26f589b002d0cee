/* Memory of a mesh: nodes and roots. Children lie in blocks of two or four, so that they need one link; blocks that collapse leave form chains and are
 * used again, last freed first. */
#include "base/error.h"
#include "cache/multi_mesh/grow.h"
#include "cache/multi_mesh/mesh.h"
#include "cache/multi_mesh/mesh_parts.h"

/* ---- all of it --------------------------------------------------------------------------------------------------- */

/* Pages of both sides' faces. */
static size_t page_count(const sl_topology *topology) { return (topology->face_count / 2 + SL_ROOT_PAGE - 1) / SL_ROOT_PAGE * 2; }

sl_status sl_mesh_create(const sl_topology *topology, int channels, int max_depth, sl_mesh **mesh, sl_error *error) {
    *mesh = NULL;
    if (channels < 1 || channels > 3) return sl_fail(error, SL_ERROR_USAGE, "a mesh has 1 to 3 channels, not %d", channels);
    if (max_depth < 0 || max_depth > SL_MESH_DEPTH_MAX)
        return sl_fail(error, SL_ERROR_USAGE, "a mesh is 0 to %d levels deep, not %d", (int)SL_MESH_DEPTH_MAX, max_depth);
    sl_mesh *m = sl_allocate(1, sizeof *m);
    if (m == NULL) return sl_fail_memory(error, "a mesh");
    m->topology = topology;
    m->channels = channels;
    m->max_depth = max_depth;
    m->slot_count = 16;
    m->root_page = sl_allocate(page_count(topology), sizeof *m->root_page);
    m->slot = sl_allocate(m->slot_count, sizeof *m->slot);
    if (m->root_page == NULL || m->slot == NULL) {
        sl_mesh_destroy(m);
        return sl_fail_memory(error, "a mesh");
    }
    sl_mesh_clear(m);
    *mesh = m;
    return SL_OK;
}

void sl_mesh_destroy(sl_mesh *mesh) {
    if (mesh == NULL) return;
    void *const all[] = {mesh->root_page, mesh->root, mesh->node, mesh->key, mesh->value, mesh->state, mesh->slot};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) sl_free(all[i]);
    sl_free(mesh);
}

size_t sl_mesh_memory_bytes(const sl_mesh *mesh) {
    size_t vertices = mesh->vertex_capacity * (sizeof *mesh->key + (size_t)mesh->channels * sizeof *mesh->value + sizeof *mesh->state);
    return sizeof *mesh + (page_count(mesh->topology) + mesh->root_capacity + mesh->slot_count) * sizeof(uint32_t) + mesh->node_capacity * sizeof *mesh->node + vertices;
}

void sl_mesh_clear(sl_mesh *mesh) {
    for (size_t p = 0; p < page_count(mesh->topology); p++) mesh->root_page[p] = SL_NO_INDEX;
    for (size_t i = 0; i < mesh->slot_count; i++) mesh->slot[i] = SL_NO_INDEX;
    mesh->root_count = mesh->node_count = mesh->vertex_count = mesh->leaf_count = mesh->free_nodes = 0;
    mesh->first_free[0] = mesh->first_free[1] = SL_NO_INDEX;
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

static bool grow_nodes(sl_mesh *mesh) {
    if (mesh->node_count + 4 > SL_MESH_ROOT) return false;
    size_t capacity = sl_grown_capacity(mesh->node_capacity, mesh->node_count + 64);
    if (!sl_regrow((void **)&mesh->node, mesh->node_count, capacity, sizeof *mesh->node)) return false;
    mesh->node_capacity = capacity;
    return true;
}

static uint32_t take_free(sl_mesh *mesh, int chain) {
    uint32_t first = mesh->first_free[chain];
    if (first == SL_NO_INDEX) return first;
    mesh->first_free[chain] = mesh->node[first].child;
    mesh->free_nodes -= chain == 0 ? 2 : 4;
    return first;
}

/* Of a free four, two will do. */
static uint32_t find_free(sl_mesh *mesh, int count) {
    if (count == 1) return SL_NO_INDEX;
    uint32_t first = take_free(mesh, count == 2 ? 0 : 1);
    if (first != SL_NO_INDEX || count > 2) return first;
    first = take_free(mesh, 1);
    if (first != SL_NO_INDEX) sl_mesh_free_nodes(mesh, first + 2, 2);
    return first;
}

uint32_t sl_mesh_take_nodes(sl_mesh *mesh, int count, uint32_t parent) {
    uint32_t first = find_free(mesh, count), n = (uint32_t)count;
    if (first == SL_NO_INDEX) {
        if (mesh->node_count + n > mesh->node_capacity && !grow_nodes(mesh)) return SL_NO_INDEX;
        first = (uint32_t)mesh->node_count;
        mesh->node_count += n;
    }
    for (uint32_t i = first; i < first + n; i++)
        mesh->node[i] = (sl_mesh_node){.child = SL_NO_INDEX, .parent = parent, .vertex = {SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX}};
    return first;
}

void sl_mesh_free_nodes(sl_mesh *mesh, uint32_t first, int count) {
    uint32_t *chain = &mesh->first_free[count == 2 ? 0 : 1], n = (uint32_t)count;
    for (uint32_t i = first; i < first + n; i++) mesh->node[i].parent = SL_NO_INDEX;
    mesh->node[first].child = *chain;
    *chain = first;
    mesh->free_nodes += n;
}

/* ---- roots ------------------------------------------------------------------------------------------------------- */

/* Where a face's root is named; NULL: memory ended. */
static uint32_t *root_entry(sl_mesh *mesh, uint32_t face) {
    uint32_t *page = &mesh->root_page[face / 2 / SL_ROOT_PAGE * 2 + face % 2];
    if (*page == SL_NO_INDEX) {
        if (mesh->root_count + SL_ROOT_PAGE > mesh->root_capacity) {
            size_t capacity = sl_grown_capacity(mesh->root_capacity, mesh->root_count + SL_ROOT_PAGE);
            if (!sl_regrow((void **)&mesh->root, mesh->root_count, capacity, sizeof *mesh->root)) return NULL;
            mesh->root_capacity = capacity;
        }
        *page = (uint32_t)mesh->root_count;
        for (int i = 0; i < SL_ROOT_PAGE; i++) mesh->root[mesh->root_count++] = SL_NO_INDEX;
    }
    return &mesh->root[*page + face / 2 % SL_ROOT_PAGE];
}

uint32_t sl_mesh_root(sl_mesh *mesh, uint32_t face, sl_status *status, sl_error *error) {
    *status = SL_OK;
    uint32_t vertex[3], root = sl_mesh_root_of(mesh, face);
    if (root != SL_NO_INDEX) return root;
    for (uint32_t c = 0; c < 3; c++) {
        vertex[c] = sl_mesh_vertex_at(mesh, face, c == 1 ? SL_MESH_DYADIC : 0, c == 2 ? SL_MESH_DYADIC : 0, status, error);
        if (vertex[c] == SL_NO_INDEX) return SL_NO_INDEX;
    }
    uint32_t *entry = root_entry(mesh, face);
    root = entry == NULL ? SL_NO_INDEX : sl_mesh_take_nodes(mesh, 1, SL_MESH_ROOT | face);
    if (root == SL_NO_INDEX) {
        *status = sl_fail_memory(error, "mesh nodes");
        return root;
    }
    *entry = root;
    memcpy(mesh->node[root].vertex, vertex, sizeof vertex);
    mesh->leaf_count++;
    return root;
}

/* ---- a number in a node's flags ------------------------------------------------------------------------------------ */

float sl_mesh_tested_size(const sl_mesh_node *node) {
    uint32_t bits = node->flags >> SL_NODE_TESTED_SHIFT << SL_NODE_TESTED_SHIFT;
    float size;
    memcpy(&size, &bits, sizeof size);
    return size;
}

void sl_mesh_set_tested_size(sl_mesh_node *node, float size) {
    uint32_t bits;
    size = size > 0.0f ? size : 0.0f; /* NaN, too */
    memcpy(&bits, &size, sizeof bits);
    node->flags = (node->flags & 0xffffu) | bits >> SL_NODE_TESTED_SHIFT << SL_NODE_TESTED_SHIFT;
}
