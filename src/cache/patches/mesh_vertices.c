/* Vertices: what makes two of them one (the place that stands for all that share it, sl_root_canonical()),
 * how they are found (a hash of places), and where they lie. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/patches/dyadic.h"
#include "cache/patches/mesh_parts.h"

/* ---- keys ------------------------------------------------------------------------------------ */

static sl_vertex_key key_of(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q) {
    sl_root_place at =
        sl_root_canonical(mesh->primitives, (sl_root_place){face, (uint16_t)p, (uint16_t)q});
    return (sl_vertex_key){.root = at.root, .u = at.u & 0x7fffu, .v = at.v & 0x7fffu};
}

static bool same_key(const sl_vertex_key *x, const sl_vertex_key *y) {
    return x->root == y->root && x->u == y->u && x->v == y->v;
}

/* Of as many slots as there are. */
static size_t first_slot(const sl_mesh *mesh, const sl_vertex_key *key) {
    uint64_t hash = sl_hash64((uint64_t)key->root << 32 | (uint64_t)key->u << 16 | key->v);
    return sl_slot_of_hash(hash, mesh->slot_count);
}

/* Where a key is in the table, or would be. */
static size_t slot_of(const sl_mesh *mesh, const sl_vertex_key *key) {
    size_t i = first_slot(mesh, key);
    while (mesh->slot[i] != SL_NO_INDEX && !same_key(&mesh->key[mesh->slot[i]], key))
        i = sl_slot_after(i, mesh->slot_count);
    return i;
}

/* ---- the table ------------------------------------------------------------------------------- */

static bool grow_vertices(sl_mesh *mesh) {
    if (mesh->vertex_count >= SL_NO_INDEX) return false;
    size_t used = mesh->vertex_count, capacity = sl_grown_capacity(mesh->vertex_capacity, used + 64),
           channels = (size_t)mesh->channels;
    if (!sl_regrow(&mesh->key, used, capacity, sizeof *mesh->key)) return false;
    if (!sl_regrow(&mesh->value, used, capacity, channels * sizeof *mesh->value)) return false;
    if (!sl_regrow(&mesh->state, used, capacity, sizeof *mesh->state)) return false;
    mesh->vertex_capacity = capacity;
    return true;
}

static void fill_slots(sl_mesh *mesh) {
    for (size_t i = 0; i < mesh->slot_count; i++) mesh->slot[i] = SL_NO_INDEX;
    for (size_t v = 0; v < mesh->vertex_count; v++) mesh->slot[slot_of(mesh, &mesh->key[v])] = (uint32_t)v;
}

static bool grow_slots(sl_mesh *mesh) {
    size_t count = sl_grown_capacity(mesh->slot_count, 16);
    uint32_t *slot = sl_allocate_unset(count, sizeof *slot);
    if (slot == NULL) return false;
    sl_free(mesh->slot);
    mesh->slot = slot;
    mesh->slot_count = count;
    fill_slots(mesh);
    return true;
}

static uint32_t find(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q) {
    sl_vertex_key key = key_of(mesh, face, p, q);
    return mesh->slot[slot_of(mesh, &key)];
}

uint32_t sl_mesh_vertex_at(sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q, sl_status *status,
                           sl_error *error) {
    sl_vertex_key key = key_of(mesh, face, p, q);
    size_t slot = slot_of(mesh, &key);
    *status = SL_OK;
    if (mesh->slot[slot] != SL_NO_INDEX) return mesh->slot[slot];
    bool full = mesh->vertex_count == mesh->vertex_capacity,
         crowded = 4 * (mesh->vertex_count + 1) > 3 * mesh->slot_count;
    if ((full && !grow_vertices(mesh)) || (crowded && !grow_slots(mesh))) {
        *status = sl_fail_memory(error, "mesh vertices");
        return SL_NO_INDEX;
    }
    uint32_t fresh = (uint32_t)mesh->vertex_count++;
    mesh->key[fresh] = key;
    mesh->state[fresh] = SL_VERTEX_UNKNOWN;
    memset(&mesh->value[(size_t)fresh * (size_t)mesh->channels], 0,
           (size_t)mesh->channels * sizeof *mesh->value);
    mesh->slot[crowded ? slot_of(mesh, &key) : slot] = fresh;
    return fresh;
}

/* ---- middles of edges ------------------------------------------------------------------------ */

/* False where an edge is as short as dyadic fractions go. */
static bool middle_of(const sl_mesh_place *place, int edge, uint32_t *p, uint32_t *q) {
    int j = (edge + 1) % 3, k = (edge + 2) % 3;
    *p = (uint32_t)place->p[j] + place->p[k];
    *q = (uint32_t)place->q[j] + place->q[k];
    bool even = (*p | *q) % 2 == 0;
    *p /= 2;
    *q /= 2;
    return even;
}

uint32_t sl_mesh_middle(sl_mesh *mesh, const sl_mesh_place *place, int edge, sl_status *status,
                        sl_error *error) {
    uint32_t p, q;
    *status = SL_OK;
    if (place->depth >= mesh->max_depth || !middle_of(place, edge, &p, &q)) return SL_NO_INDEX;
    uint32_t vertex = sl_mesh_vertex_at(mesh, place->face, p, q, status, error);
    if (vertex == SL_NO_INDEX) return vertex;
    const uint32_t *corner = mesh->node[place->node].vertex;
    mesh->key[corner[(edge + 1) % 3]].halved = mesh->key[corner[(edge + 2) % 3]].halved = 1;
    return vertex;
}

uint32_t sl_mesh_find_middle(const sl_mesh *mesh, const sl_mesh_place *place, int edge) {
    uint32_t p, q;
    return middle_of(place, edge, &p, &q) ? find(mesh, place->face, p, q) : SL_NO_INDEX;
}

uint32_t sl_mesh_find_vertex(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q) {
    return find(mesh, face, p, q);
}

/* ---- where vertices lie ---------------------------------------------------------------------- */

void sl_mesh_point_at(const sl_primitives *primitives, sl_root_place place, sl_mesh_point *point) {
    sl_root_point at;
    sl_root_point_at(primitives, place.root, place.u, place.v, &at);
    bool inside = at.triangle != SL_NO_INDEX;
    *point = (sl_mesh_point){at.position, at.normal, inside ? at.geometric_normal : at.normal, at.triangle,
                             place.root};
}

void sl_mesh_point_of(const sl_mesh *mesh, uint32_t vertex, sl_mesh_point *point) {
    sl_mesh_point_at(mesh->primitives, sl_mesh_vertex_place(mesh, vertex), point);
}

static sl_vec3 between(sl_vec3 a, sl_vec3 b, double share) {
    sl_vec3d from = sl_to_double(a);
    return sl_to_float(sl_addd(from, sl_scaled(sl_subd(sl_to_double(b), from), share)));
}

void sl_mesh_point_nudged(const sl_mesh *mesh, uint32_t vertex, sl_root_place middle, double share,
                          sl_mesh_point *point) {
    sl_mesh_point to;
    sl_mesh_point_of(mesh, vertex, point);
    sl_mesh_point_at(mesh->primitives, middle, &to);
    sl_vec3 geometric = sl_face_normal(mesh->primitives->scene, middle.root);
    *point = (sl_mesh_point){between(point->position, to.position, share),
                             sl_normalize_or(between(point->normal, to.normal, share), geometric), geometric,
                             middle.root / 2, middle.root};
}
