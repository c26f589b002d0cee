/* Vertices: what makes two of them one (the place that stands for all that share it, sl_root_canonical()),
 * how they are found (a hash of places), and where they lie. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "cache/patches/mesh_parts.h"

static sl_root_place place_of(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q) {
    return sl_root_canonical(mesh->primitives, (sl_root_place){face, (uint16_t)p, (uint16_t)q});
}

/* ---- the table ------------------------------------------------------------------------------- */

static bool grow_vertices(sl_mesh *mesh) {
    if (mesh->vertex_count >= SL_NO_INDEX) return false;
    size_t used = mesh->vertex_count, capacity = sl_grown_capacity(mesh->vertex_capacity, used + 64),
           channels = (size_t)mesh->channels;
    if (!sl_regrow(&mesh->place, used, capacity, sizeof *mesh->place)) return false;
    mesh->table.vertex = mesh->place;
    if (!sl_regrow(&mesh->halved, used, capacity, sizeof *mesh->halved)) return false;
    if (!sl_regrow(&mesh->value, used, capacity, channels * sizeof *mesh->value)) return false;
    if (!sl_regrow(&mesh->state, used, capacity, sizeof *mesh->state)) return false;
    mesh->vertex_capacity = capacity;
    return true;
}

static bool grow_slots(sl_mesh *mesh) {
    if (!sl_place_table_resize(&mesh->table, sl_grown_capacity(mesh->table.count, 16))) return false;
    for (size_t i = 0; i < mesh->vertex_count; i++)
        mesh->table.slot[sl_place_slot(&mesh->table, mesh->place[i])] = (uint32_t)i;
    return true;
}

uint32_t sl_mesh_vertex_at(sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q, sl_status *status,
                           sl_error *error) {
    sl_root_place place = place_of(mesh, face, p, q);
    size_t slot = sl_place_slot(&mesh->table, place);
    *status = SL_OK;
    if (mesh->table.slot[slot] != SL_NO_INDEX) return mesh->table.slot[slot];
    bool full = mesh->vertex_count == mesh->vertex_capacity,
         crowded = 4 * (mesh->vertex_count + 1) > 3 * mesh->table.count;
    if ((full && !grow_vertices(mesh)) || (crowded && !grow_slots(mesh))) {
        *status = sl_fail_memory(error, "mesh vertices");
        return SL_NO_INDEX;
    }
    uint32_t fresh = (uint32_t)mesh->vertex_count++;
    mesh->place[fresh] = place;
    mesh->halved[fresh] = 0;
    mesh->state[fresh] = SL_VERTEX_UNKNOWN;
    memset(&mesh->value[(size_t)fresh * (size_t)mesh->channels], 0,
           (size_t)mesh->channels * sizeof *mesh->value);
    mesh->table.slot[crowded ? sl_place_slot(&mesh->table, place) : slot] = fresh;
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
    mesh->halved[corner[(edge + 1) % 3]] = mesh->halved[corner[(edge + 2) % 3]] = 1;
    return vertex;
}

uint32_t sl_mesh_find_middle(const sl_mesh *mesh, const sl_mesh_place *place, int edge) {
    uint32_t p, q;
    return middle_of(place, edge, &p, &q) ? sl_mesh_find_vertex(mesh, place->face, p, q) : SL_NO_INDEX;
}

uint32_t sl_mesh_find_vertex(const sl_mesh *mesh, uint32_t face, uint32_t p, uint32_t q) {
    return mesh->table.slot[sl_place_slot(&mesh->table, place_of(mesh, face, p, q))];
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
    sl_mesh_point_at(mesh->primitives, mesh->place[vertex], point);
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
