/* Vertices: what makes two of them one (keys), how they are found (a hash of keys), and where they lie. */
#include <math.h>

#include "base/error.h"
#include "base/random.h"
#include "cache/multi_mesh/grow.h"
#include "cache/multi_mesh/mesh_vertices.h"

/* ---- keys ------------------------------------------------------------------------------------------------------------ */

/* A point of a face with a weight of 0 lies on the edge opposite to that corner, one with two on a site; these belong to all faces around. */
static sl_vertex_key key_of(const sl_topology *topology, uint32_t face, uint32_t p, uint32_t q) {
    uint32_t w[3] = {SL_MESH_DYADIC - p - q, p, q}, site[3];
    for (int c = 0; c < 3; c++) site[c] = topology->site[c][face];
    for (int c = 0; c < 3; c++)
        if (w[c] == SL_MESH_DYADIC) return (sl_vertex_key){.a = site[c], .kind = SL_VERTEX_ON_SITE};
    for (int c = 0; c < 3; c++) {
        int j = (c + 1) % 3, k = (c + 2) % 3;
        if (w[c] != 0 || site[j] == site[k]) continue;
        bool first = site[j] < site[k]; /* fractions count from the lower site */
        return (sl_vertex_key){.a = first ? site[j] : site[k], .b = first ? site[k] : site[j], .p = (uint16_t)(first ? w[k] : w[j]),
                               .kind = SL_VERTEX_ON_EDGE};
    }
    return (sl_vertex_key){.a = face, .p = (uint16_t)p, .q = (uint16_t)q, .kind = SL_VERTEX_IN_FACE};
}

static bool same_key(const sl_vertex_key *x, const sl_vertex_key *y) {
    return x->a == y->a && x->b == y->b && x->p == y->p && x->q == y->q && x->kind == y->kind && x->group == y->group;
}

static size_t hash_of(const sl_vertex_key *key) {
    uint64_t sites = (uint64_t)key->a << 32 | key->b;
    uint64_t place = (uint64_t)key->p << 48 | (uint64_t)key->q << 32 | (uint64_t)key->kind << 16 | key->group;
    return (size_t)sl_hash64(sl_hash64(sites) ^ place);
}

/* Where a key is in the table, or would be. */
static size_t slot_of(const sl_mesh *mesh, const sl_vertex_key *key) {
    size_t i = hash_of(key) & (mesh->slot_count - 1);
    while (mesh->slot[i] != SL_NO_INDEX && !same_key(&mesh->key[mesh->slot[i]], key)) i = (i + 1) & (mesh->slot_count - 1);
    return i;
}

/* ---- the table ------------------------------------------------------------------------------------------------------- */

static bool grow_vertices(sl_mesh *mesh) {
    if (mesh->vertex_count >= SL_NO_INDEX) return false;
    size_t used = mesh->vertex_count, capacity = sl_grown_capacity(mesh->vertex_capacity, used + 64), channels = (size_t)mesh->channels;
    if (!sl_regrow((void **)&mesh->key, used, capacity, sizeof *mesh->key)) return false;
    if (!sl_regrow((void **)&mesh->value, used, capacity, channels * sizeof *mesh->value)) return false;
    if (!sl_regrow((void **)&mesh->state, used, capacity, sizeof *mesh->state)) return false;
    if (!sl_regrow((void **)&mesh->halved, used, capacity, sizeof *mesh->halved)) return false;
    mesh->vertex_capacity = capacity;
    return true;
}

static bool grow_slots(sl_mesh *mesh) {
    size_t count = 2 * mesh->slot_count;
    uint32_t *slot = sl_allocate(count, sizeof *slot);
    if (slot == NULL) return false;
    for (size_t i = 0; i < count; i++) slot[i] = SL_NO_INDEX;
    sl_free(mesh->slot);
    mesh->slot = slot;
    mesh->slot_count = count;
    for (size_t v = 0; v < mesh->vertex_count; v++) mesh->slot[slot_of(mesh, &mesh->key[v])] = (uint32_t)v;
    return true;
}

static uint32_t find(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q) {
    sl_vertex_key key = key_of(mesh->topology, face, p, q);
    return mesh->slot[slot_of(mesh, &key)];
}

uint32_t sl_mesh_vertex_at(sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q, sl_status *status, sl_error *error) {
    sl_vertex_key key = key_of(mesh->topology, face, p, q);
    size_t slot = slot_of(mesh, &key);
    *status = SL_OK;
    if (mesh->slot[slot] != SL_NO_INDEX) return mesh->slot[slot];
    bool full = mesh->vertex_count == mesh->vertex_capacity, crowded = 2 * (mesh->vertex_count + 1) > mesh->slot_count;
    if ((full && !grow_vertices(mesh)) || (crowded && !grow_slots(mesh))) {
        *status = sl_fail_memory(error, "mesh vertices");
        return SL_NO_INDEX;
    }
    uint32_t fresh = (uint32_t)mesh->vertex_count++;
    mesh->key[fresh] = key;
    mesh->state[fresh] = SL_VERTEX_UNKNOWN;
    mesh->halved[fresh] = 0;
    memset(&mesh->value[(size_t)fresh * (size_t)mesh->channels], 0, (size_t)mesh->channels * sizeof *mesh->value);
    mesh->slot[crowded ? slot_of(mesh, &key) : slot] = fresh;
    return fresh;
}

/* ---- middles of edges ------------------------------------------------------------------------------------------------ */

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

uint32_t sl_mesh_middle(sl_mesh *mesh, const sl_mesh_place *place, int edge, sl_status *status, sl_error *error) {
    uint32_t p, q;
    *status = SL_OK;
    if (place->depth >= mesh->max_depth || !middle_of(place, edge, &p, &q)) return SL_NO_INDEX;
    uint32_t vertex = sl_mesh_vertex_at(mesh, place->face, p, q, status, error);
    if (vertex == SL_NO_INDEX) return vertex;
    const uint32_t *corner = mesh->node[place->node].vertex;
    mesh->halved[corner[(edge + 1) % 3]] = mesh->halved[corner[(edge + 2) % 3]] = 1;
    return vertex;
}

uint32_t sl_mesh_find_middle(const sl_mesh *mesh, const sl_mesh_place *place, int edge) {
    uint32_t p, q;
    return middle_of(place, edge, &p, &q) ? find(mesh, place->face, p, q) : SL_NO_INDEX;
}

/* ---- where vertices lie ------------------------------------------------------------------------------------------------ */

/* The sum of a face's three site values in double. On an edge one weight is 0, a product of a float and a 13-bit weight is exact, and the sum of two
 * does not depend on their order: so all faces around, and both sides, get the same bits. Corners without weight do not count even if
 * they are not finite. */
static sl_vec3d weigh(const sl_topology *topology, const sl_vec3 *site_value, uint32_t face, const double w[3]) {
    sl_vec3d sum = sl_v3d(0.0, 0.0, 0.0);
    for (int c = 0; c < 3; c++)
        if (w[c] != 0.0) sum = sl_addd(sum, sl_scaled(sl_to_double(site_value[topology->site[c][face]]), w[c]));
    return sl_scaled(sum, 1.0 / SL_MESH_DYADIC);
}

sl_vec3 sl_mesh_position_in_face(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q) {
    double w[3] = {(double)SL_MESH_DYADIC - p - q, p, q};
    return sl_to_float(weigh(mesh->topology, mesh->topology->site_position, face, w));
}

/* The lowest face that has the vertex, how many do (2: several), and the vertex's weights of its corners in 1/SL_MESH_DYADIC. */
static uint32_t lowest_face(const sl_topology *topology, const sl_vertex_key *key, bool *several, double w[3]) {
    if (key->kind == SL_VERTEX_IN_FACE) {
        *several = false;
        w[0] = (double)SL_MESH_DYADIC - key->p - key->q;
        w[1] = key->p;
        w[2] = key->q;
        return key->a;
    }
    uint32_t face = topology->site_face[key->a];
    *several = topology->site_shared[key->a];
    if (key->kind == SL_VERTEX_ON_EDGE) {
        uint32_t e = sl_topology_find_edge(topology, key->a, key->b);
        face = topology->edge_face[topology->edge_start[e]];
        *several = topology->edge_start[e + 1] - topology->edge_start[e] > 1;
    }
    for (int c = 0; c < 3; c++) {
        uint32_t site = topology->site[c][face];
        bool on_edge = key->kind == SL_VERTEX_ON_EDGE;
        w[c] = site == key->a ? (double)SL_MESH_DYADIC - (on_edge ? key->p : 0) : on_edge && site == key->b ? key->p : 0.0;
    }
    return face;
}

static sl_vec3 normal_at(const sl_topology *topology, uint32_t face, const double w[3]) {
    return sl_normalize_or(sl_to_float(weigh(topology, topology->site_normal, face, w)), sl_face_normal(topology->scene, face));
}

void sl_mesh_point_of(const sl_mesh *mesh, uint32_t vertex, sl_mesh_point *point) {
    const sl_topology *topology = mesh->topology;
    double w[3];
    bool several;
    point->face = lowest_face(topology, &mesh->key[vertex], &several, w);
    point->triangle = several ? SL_NO_INDEX : point->face / 2;
    point->position = sl_to_float(weigh(topology, topology->site_position, point->face, w));
    point->normal = normal_at(topology, point->face, w);
    bool inside = mesh->key[vertex].kind == SL_VERTEX_IN_FACE;
    point->geometric_normal = inside ? sl_face_normal(topology->scene, point->face) : point->normal;
}

void sl_mesh_point_nudged(const sl_mesh *mesh, uint32_t vertex, double share, sl_mesh_point *point) {
    const sl_topology *topology = mesh->topology;
    double w[3];
    bool several;
    point->face = lowest_face(topology, &mesh->key[vertex], &several, w);
    for (int c = 0; c < 3; c++) w[c] += share * (SL_MESH_DYADIC / 3.0 - w[c]);
    point->triangle = point->face / 2;
    point->position = sl_to_float(weigh(topology, topology->site_position, point->face, w));
    point->normal = normal_at(topology, point->face, w);
    point->geometric_normal = sl_face_normal(topology->scene, point->face);
}
