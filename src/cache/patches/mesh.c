/* Quadtrees of triangles: places, split and collapse. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "cache/patches/mesh.h"
#include "cache/patches/mesh_parts.h"

/* ---- places ---------------------------------------------------------------------------------- */

sl_mesh_place sl_mesh_root_place(const sl_mesh *mesh, uint32_t face) {
    return (sl_mesh_place){.node = sl_mesh_root_of(mesh, face),
                           .face = face,
                           .p = {0, SL_MESH_DYADIC, 0},
                           .q = {0, 0, SL_MESH_DYADIC}};
}

sl_mesh_place sl_mesh_child_place(const sl_mesh *mesh, const sl_mesh_place *parent, int child) {
    sl_mesh_place place = {.node = mesh->node[parent->node].child + (uint32_t)child,
                           .face = parent->face,
                           .depth = parent->depth + 1};
    sl_dyadic_child(3, parent->p, parent->q, child, place.p, place.q);
    return place;
}

sl_mesh_place sl_mesh_place_of(const sl_mesh *mesh, uint32_t node) {
    int path[SL_MESH_DEPTH_MAX], depth = 0;
    uint32_t at = node;
    for (uint32_t up = sl_mesh_parent(mesh, at); up != SL_NO_INDEX; at = up, up = sl_mesh_parent(mesh, at))
        path[depth++] = (int)(at - mesh->node[up].child);
    sl_mesh_place place = sl_mesh_root_place(mesh, mesh->node[at].parent & ~SL_MESH_ROOT);
    while (depth > 0) place = sl_mesh_child_place(mesh, &place, path[--depth]);
    return place;
}

/* ---- points ---------------------------------------------------------------------------------- */

/* Onto the face: NaN becomes 0. */
static void clamp_weights(float w1, float w2, double *clamped1, double *clamped2) {
    double a = w1 > 0.0f ? (double)fminf(w1, 1.0f) : 0.0, b = w2 > 0.0f ? (double)fminf(w2, 1.0f) : 0.0;
    double sum = a + b;
    *clamped1 = sum > 1.0 ? a / sum : a;
    *clamped2 = sum > 1.0 ? b / sum : b;
}

/* Gives weights of a place's corners 1 and 2 at a point of the face: exact for points that are not absurdly
 * near a corner. */
static void weights_within(const sl_mesh_place *place, double w1, double w2, double *a, double *b) {
    sl_dyadic_local(3, place->p, place->q, w1 * SL_MESH_DYADIC, w2 * SL_MESH_DYADIC, a, b);
}

void sl_mesh_weights_within(const sl_mesh_place *place, float w1, float w2, float *leaf_w1, float *leaf_w2) {
    double a, b;
    clamp_weights(w1, w2, &a, &b);
    weights_within(place, a, b, &a, &b);
    *leaf_w1 = (float)a;
    *leaf_w2 = (float)b;
}

sl_mesh_place sl_mesh_locate(const sl_mesh *mesh, uint32_t face, float w1, float w2, float *leaf_w1,
                             float *leaf_w2) {
    sl_mesh_place place = sl_mesh_root_place(mesh, face);
    double w[2], a, b;
    if (place.node == SL_NO_INDEX) return place;
    clamp_weights(w1, w2, &w[0], &w[1]);
    for (weights_within(&place, w[0], w[1], &a, &b); !sl_mesh_is_leaf(mesh, place.node);
         weights_within(&place, w[0], w[1], &a, &b))
        place = sl_mesh_child_place(mesh, &place, sl_dyadic_child_at(3, a, b));
    *leaf_w1 = (float)a;
    *leaf_w2 = (float)b;
    return place;
}

/* ---- split and collapse ---------------------------------------------------------------------- */

static double doubled_area(sl_vec3d a, sl_vec3d b, sl_vec3d c) {
    return sl_lengthd(sl_crossd(sl_subd(b, a), sl_subd(c, a)));
}

/* Tells whether all children would have an area in the float coordinates that vertices have. NaN has none. */
static bool can_be_cut(const sl_mesh *mesh, const sl_mesh_place *place) {
    if (sl_triangle_is_degenerate(mesh->primitives->scene, place->face / 2)) return false;
    sl_vec3d corner[3], at[3];
    for (int c = 0; c < 3; c++) {
        int j = (c + 1) % 3, k = (c + 2) % 3;
        uint16_t p = sl_dyadic_middle(place->p[j], place->p[k]),
                 q = sl_dyadic_middle(place->q[j], place->q[k]);
        corner[c] = sl_to_double(sl_root_position(mesh->primitives, place->face, place->p[c], place->q[c]));
        at[c] = sl_to_double(sl_root_position(mesh->primitives, place->face, p, q));
    }
    bool good = doubled_area(at[0], at[1], at[2]) > 0.0;
    for (int c = 0; c < 3; c++)
        good = good && doubled_area(corner[c], at[(c + 1) % 3], at[(c + 2) % 3]) > 0.0;
    return good;
}

static uint32_t closed_edge(uint32_t flags, int edge) {
    return (flags >> 2 * edge & 3u) == SL_EDGE_CLOSED ? (uint32_t)SL_EDGE_CLOSED << 2 * edge : 0;
}

/* Corner c of a child in four keeps the edge opposite to c half, unless c is the corner that it shares with
 * its parent. */
static void fill_four(sl_mesh *mesh, uint32_t node, const uint32_t at[3]) {
    const sl_mesh_node *parent = &mesh->node[node];
    for (int child = 0; child < 3; child++) {
        sl_mesh_node *n = &mesh->node[parent->child + (uint32_t)child];
        for (int c = 0; c < 3; c++) {
            n->vertex[c] = c == child ? parent->vertex[c] : at[3 - c - child];
            if (c != child) n->flags |= closed_edge(parent->flags, c);
        }
    }
    memcpy(mesh->node[parent->child + 3].vertex, at, 3 * sizeof at[0]);
}

sl_status sl_mesh_split(sl_mesh *mesh, const sl_mesh_place *place, sl_error *error) {
    if (!sl_mesh_is_leaf(mesh, place->node) || place->depth >= mesh->max_depth || !can_be_cut(mesh, place))
        return SL_OK;
    uint32_t at[3];
    for (int edge = 0; edge < 3; edge++) {
        sl_status status;
        at[edge] = sl_mesh_middle(mesh, place, edge, &status, error);
        if (at[edge] == SL_NO_INDEX) return status;
    }
    uint32_t children = sl_mesh_take_nodes(mesh, 4, place->node);
    if (children == SL_NO_INDEX) return sl_fail_memory(error, "mesh nodes");
    mesh->node[place->node].child = children;
    fill_four(mesh, place->node, at);
    mesh->leaf_count += 3;
    return SL_OK;
}

void sl_mesh_collapse(sl_mesh *mesh, uint32_t node) {
    sl_mesh_node *n = &mesh->node[node];
    if (n->child == SL_NO_INDEX) return;
    for (uint32_t c = 0; c < 4; c++)
        if (!sl_mesh_is_leaf(mesh, n->child + c)) return;
    sl_mesh_free_nodes(mesh, n->child);
    n->child = SL_NO_INDEX;
    mesh->leaf_count -= 3;
}
