/* A mesh tidied up when a picture is done: nodes in the order of their quadtrees, so that a walk through them is one through memory, none of them free, and
 * arrays as long as what is in them. On request, samples are forgotten that no leaf has on its edges: tests of cuts that were undone left them, inside
 * of what is one leaf again (they are kept for as long as there is memory). No value that the mesh interpolates changes by it. */
#include <string.h>

#include "base/memory.h"
#include "cache/multi_mesh/mesh.h"
#include "cache/multi_mesh/mesh_parts.h"

typedef struct tidying {
    const sl_mesh *mesh;
    bool forget;
    uint32_t *node_of;     /* by old node: its new number, or SL_NO_INDEX */
    uint32_t *vertex_of;   /* the same for vertices */
    sl_mesh_node *node;
    size_t node_count, vertex_count;
} tidying;

/* ---- what is kept ---- */

static void keep_vertex(tidying *t, uint32_t vertex) {
    if (t->vertex_of[vertex] == SL_NO_INDEX) t->vertex_of[vertex] = (uint32_t)t->vertex_count++;
}

/* All that lies between two points of a face, in the middle of which a vertex lies if there are any. */
static void keep_between(tidying *t, uint32_t face, int p0, int q0, int p1, int q1) {
    int p = p0 + p1, q = q0 + q1;
    if ((p | q) % 2 != 0) return;
    sl_mesh_place place = {.face = face, .p = {0, (uint16_t)p0, (uint16_t)p1}, .q = {0, (uint16_t)q0, (uint16_t)q1}};
    uint32_t vertex = sl_mesh_find_middle(t->mesh, &place, 0);
    if (vertex == SL_NO_INDEX) return;
    keep_vertex(t, vertex);
    if (!t->mesh->key[vertex].halved) return;
    keep_between(t, face, p0, q0, p / 2, q / 2);
    keep_between(t, face, p / 2, q / 2, p1, q1);
}

static void keep_edges(tidying *t, const sl_mesh_place *leaf) {
    for (int e = 0; e < 3; e++) {
        int j = (e + 1) % 3, k = (e + 2) % 3;
        keep_between(t, leaf->face, leaf->p[j], leaf->q[j], leaf->p[k], leaf->q[k]);
    }
}

/* Copies a node, then its children as one block, then what is below each. */
static void keep_below(tidying *t, const sl_mesh_place *place, uint32_t to, uint32_t parent) {
    sl_mesh_node *node = &t->node[to];
    *node = t->mesh->node[place->node];
    node->parent = parent;
    t->node_of[place->node] = to;
    for (int c = 0; c < 3; c++) keep_vertex(t, node->vertex[c]);
    if (node->child == SL_NO_INDEX) {
        if (t->forget) keep_edges(t, place);
        return;
    }
    int children = sl_mesh_children(t->mesh, place->node);
    node->child = (uint32_t)t->node_count;
    t->node_count += (size_t)children;
    for (int c = 0; c < children; c++) {
        sl_mesh_place child = sl_mesh_child_place(t->mesh, place, c);
        keep_below(t, &child, node->child + (uint32_t)c, to);
    }
}

static void keep_trees(tidying *t) {
    const sl_mesh *mesh = t->mesh;
    for (uint32_t n = 0; n < mesh->node_count; n++) {
        uint32_t parent = mesh->node[n].parent;
        if (!sl_mesh_is_root(mesh, n)) continue;
        sl_mesh_place root = sl_mesh_root_place(mesh, parent & ~SL_MESH_ROOT);
        keep_below(t, &root, (uint32_t)t->node_count++, parent);
    }
    for (uint32_t v = 0; v < mesh->vertex_count && !t->forget; v++) keep_vertex(t, v);
}

/* ---- into new arrays ---- */

static void copy_vertices(const tidying *t, sl_mesh *to) {
    const sl_mesh *from = t->mesh;
    size_t channels = (size_t)from->channels;
    for (size_t v = 0; v < from->vertex_count; v++) {
        size_t at = t->vertex_of[v];
        if (at == SL_NO_INDEX) continue;
        to->key[at] = from->key[v];
        to->state[at] = from->state[v];
        memcpy(&to->value[at * channels], &from->value[v * channels], channels * sizeof *to->value);
    }
}

static void rename_vertices(const tidying *t) {
    for (size_t n = 0; n < t->node_count; n++)
        for (int c = 0; c < 3; c++) t->node[n].vertex[c] = t->vertex_of[t->node[n].vertex[c]];
}

/* In place of the mesh's own. False: memory ended, nothing has changed. */
static bool replace(tidying *t, sl_mesh *mesh) {
    size_t room = t->vertex_count + 1;
    sl_mesh tidy = *mesh;
    tidy.key = sl_allocate_unset(room, sizeof *tidy.key);
    tidy.value = sl_allocate_unset(room, (size_t)mesh->channels * sizeof *tidy.value);
    tidy.state = sl_allocate_unset(room, sizeof *tidy.state);
    tidy.slot_count = 4 * room / 3 + 1;
    tidy.slot = sl_allocate_unset(tidy.slot_count, sizeof *tidy.slot);
    tidy.root_slots = 4 * (mesh->root_count + 1) / 3 + 1;
    tidy.root = sl_allocate_unset(tidy.root_slots, sizeof *tidy.root);
    bool good = tidy.key && tidy.value && tidy.state && tidy.slot && tidy.root;
    if (good) {
        rename_vertices(t);
        copy_vertices(t, &tidy);
        tidy.node = t->node;
        tidy.node_count = tidy.node_capacity = t->node_count;
        tidy.free_nodes = 0;
        tidy.first_free[0] = tidy.first_free[1] = SL_NO_INDEX;
        tidy.vertex_count = t->vertex_count;
        tidy.vertex_capacity = room;
        sl_mesh_fill_slots(&tidy);
        sl_mesh_fill_roots(&tidy);
        t->node = mesh->node;
    }
    const sl_mesh *gone = good ? mesh : &tidy;
    void *const left[] = {gone->key, gone->value, gone->state, gone->slot, gone->root};
    for (size_t i = 0; i < sizeof left / sizeof left[0]; i++) sl_free(left[i]);
    if (good) *mesh = tidy;
    return good;
}

bool sl_mesh_tidy(sl_mesh *mesh, bool forget, uint32_t *node_of) {
    size_t used = mesh->node_count - mesh->free_nodes;
    tidying t = {.mesh = mesh, .forget = forget, .node_of = node_of};
    t.vertex_of = sl_allocate_unset(mesh->vertex_count + 1, sizeof *t.vertex_of);
    t.node = sl_allocate_unset(used + 1, sizeof *t.node);
    bool good = t.vertex_of && t.node;
    if (good) {
        for (size_t n = 0; n < mesh->node_count; n++) node_of[n] = SL_NO_INDEX;
        for (size_t v = 0; v < mesh->vertex_count; v++) t.vertex_of[v] = SL_NO_INDEX;
        keep_trees(&t);
        good = replace(&t, mesh);
    }
    sl_free(t.vertex_of);
    sl_free(t.node);
    return good;
}
