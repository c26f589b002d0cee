/* Vertices: what makes two of them one (keys), how they are found (a hash of keys), and where they lie. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/patches/mesh_parts.h"

/* ---- keys ------------------------------------------------------------------------------------ */

static sl_vertex_key make_key(sl_vertex_kind kind, uint32_t of, uint32_t p, uint32_t q) {
    return (sl_vertex_key){.of = of, .p = p & 0x1fffu, .q = q & 0x1fffu, .kind = (unsigned)kind & 3u};
}

/* A point of a face with a weight of 0 lies on the edge opposite to that corner, one with two on a site;
 * these belong to all faces around. */
static sl_vertex_key key_of(const sl_topology *topology, uint32_t face, uint32_t p, uint32_t q) {
    uint32_t w[3] = {SL_MESH_DYADIC - p - q, p, q}, site[3];
    for (int c = 0; c < 3; c++) site[c] = topology->site[c][face];
    for (int c = 0; c < 3; c++)
        if (w[c] == SL_MESH_DYADIC) return make_key(SL_VERTEX_ON_SITE, site[c], 0, 0);
    for (int c = 0; c < 3; c++) {
        int j = (c + 1) % 3, k = (c + 2) % 3;
        if (w[c] != 0 || site[j] == site[k]) continue;
        /* from the lower site */
        return make_key(SL_VERTEX_ON_EDGE, topology->edge[c][face], site[j] < site[k] ? w[k] : w[j], 0);
    }
    return make_key(SL_VERTEX_IN_FACE, face, p, q);
}

static bool same_key(const sl_vertex_key *x, const sl_vertex_key *y) {
    return x->of == y->of && x->p == y->p && x->q == y->q && x->kind == y->kind;
}

/* Of as many slots as there are. */
static size_t first_slot(const sl_mesh *mesh, const sl_vertex_key *key) {
    uint64_t hash =
        sl_hash64((uint64_t)key->of << 32 | (uint64_t)key->p << 15 | (uint64_t)key->q << 2 | key->kind);
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
    sl_vertex_key key = key_of(mesh->topology, face, p, q);
    return mesh->slot[slot_of(mesh, &key)];
}

uint32_t sl_mesh_vertex_at(sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q, sl_status *status,
                           sl_error *error) {
    sl_vertex_key key = key_of(mesh->topology, face, p, q);
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

/* The sum of a face's three site values in double. On an edge one weight is 0, a product of a float and a
 * 13-bit weight is exact, and the sum of two does not depend on their order: so all faces around, and both
 * sides, get the same bits. Corners without weight do not count even if they are not finite. */
static sl_vec3d weigh(const sl_topology *topology, const sl_vec3 *site_value, uint32_t face,
                      const double w[3]) {
    sl_vec3d sum = sl_v3d(0.0, 0.0, 0.0);
    for (int c = 0; c < 3; c++)
        if (w[c] != 0.0)
            sum = sl_addd(sum, sl_scaled(sl_to_double(site_value[topology->site[c][face]]), w[c]));
    return sl_scaled(sum, 1.0 / SL_MESH_DYADIC);
}

sl_vec3 sl_mesh_position_in_face(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q) {
    double w[3] = {(double)SL_MESH_DYADIC - p - q, p, q};
    return sl_to_float(weigh(mesh->topology, mesh->topology->site_position, face, w));
}

/* The lowest face that has the vertex, how many do (2: several), and the vertex's weights of its corners in
 * 1/SL_MESH_DYADIC. */
static uint32_t lowest_face(const sl_topology *topology, const sl_vertex_key *key, bool *several,
                            double w[3]) {
    uint32_t face = key->of;
    int c = 0;
    w[0] = (double)SL_MESH_DYADIC - key->p - key->q;
    w[1] = key->p;
    w[2] = key->q;
    *several = false;
    if (key->kind == SL_VERTEX_ON_SITE) {
        face = topology->site_face[key->of];
        *several = topology->site_shared[key->of];
        while (c < 2 && topology->site[c][face] != key->of) c++;
        for (int i = 0; i < 3; i++) w[i] = i == c ? SL_MESH_DYADIC : 0.0;
    } else if (key->kind == SL_VERTEX_ON_EDGE) {
        face = topology->edge_face[topology->edge_start[key->of]];
        *several = topology->edge_start[key->of + 1] - topology->edge_start[key->of] > 1;
        while (c < 2 && topology->edge[c][face] != key->of) c++;
        int j = (c + 1) % 3, k = (c + 2) % 3;
        bool first = topology->site[j][face] < topology->site[k][face];
        w[c] = 0.0;
        w[first ? j : k] = (double)SL_MESH_DYADIC - key->p;
        w[first ? k : j] = key->p;
    }
    return face;
}

uint32_t sl_mesh_lowest_face(const sl_mesh *mesh, uint32_t vertex, uint16_t *p, uint16_t *q) {
    double w[3];
    bool several;
    uint32_t face = lowest_face(mesh->topology, &mesh->key[vertex], &several, w);
    *p = (uint16_t)w[1];
    *q = (uint16_t)w[2];
    return face;
}

static sl_vec3 normal_at(const sl_topology *topology, uint32_t face, const double w[3]) {
    return sl_normalize_or(sl_to_float(weigh(topology, topology->site_normal, face, w)),
                           sl_face_normal(topology->scene, face));
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

static sl_vec3d between(sl_vec3d a, sl_vec3d b, double share) {
    return sl_addd(a, sl_scaled(sl_subd(b, a), share));
}

void sl_mesh_point_nudged(const sl_mesh *mesh, uint32_t vertex, sl_leaf_middle leaf, double share,
                          sl_mesh_point *point) {
    const sl_topology *topology = mesh->topology;
    const double w[3] = {(double)SL_MESH_DYADIC - (double)leaf.p - (double)leaf.q, (double)leaf.p,
                         (double)leaf.q};
    sl_mesh_point_of(mesh, vertex, point);
    sl_vec3 geometric = sl_face_normal(topology->scene, leaf.face);
    sl_vec3d middle = weigh(topology, topology->site_position, leaf.face, w),
             normal = sl_to_double(normal_at(topology, leaf.face, w));
    point->face = leaf.face;
    point->triangle = leaf.face / 2;
    point->position = sl_to_float(between(sl_to_double(point->position), middle, share));
    point->normal =
        sl_normalize_or(sl_to_float(between(sl_to_double(point->normal), normal, share)), geometric);
    point->geometric_normal = geometric;
}
