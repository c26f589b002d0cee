/* Quadtrees of triangles: places, split and collapse. */
#include <math.h>
#include <string.h>

#include "base/error.h"
#include "cache/multi_mesh/mesh.h"
#include "cache/multi_mesh/mesh_parts.h"

/* ---- places --------------------------------------------------------------------------------------------------------- */

sl_mesh_place sl_mesh_root_place(const sl_mesh *mesh, uint32_t face) {
    return (sl_mesh_place){.node = sl_mesh_root_of(mesh, face), .face = face, .p = {0, SL_MESH_DYADIC, 0}, .q = {0, 0, SL_MESH_DYADIC}};
}

static uint16_t middle(uint16_t a, uint16_t b) { return (uint16_t)((a + b) / 2); }

/* The edge at which a sliver is cut: the number of the corner opposite to it. */
static int cut_of(uint32_t flags) { return (int)(flags >> SL_NODE_CUT_SHIFT & 3u); }

/* Corner `to` of the child at the middle between corners a and b of its parent. */
static void put_middle(sl_mesh_place *child, int to, const sl_mesh_place *parent, int a, int b) {
    child->p[to] = middle(parent->p[a], parent->p[b]);
    child->q[to] = middle(parent->q[a], parent->q[b]);
}

sl_mesh_place sl_mesh_child_place(const sl_mesh *mesh, const sl_mesh_place *parent, int child) {
    const sl_mesh_node *node = &mesh->node[parent->node];
    sl_mesh_place place = *parent;
    place.node = node->child + (uint32_t)child;
    place.depth++;
    if (node->flags & SL_NODE_BISECTED) { /* child 0 keeps the first end of the longest edge, child 1 the second */
        int cut = cut_of(node->flags), first = (cut + 1) % 3, second = (cut + 2) % 3;
        put_middle(&place, child == 0 ? second : first, parent, first, second);
        return place;
    }
    for (int c = 0; c < 3; c++) {
        if (child == 3) put_middle(&place, c, parent, (c + 1) % 3, (c + 2) % 3);
        else if (c != child) put_middle(&place, c, parent, c, child);
    }
    return place;
}

sl_mesh_place sl_mesh_place_of(const sl_mesh *mesh, uint32_t node) {
    int path[SL_MESH_DEPTH_MAX], depth = 0;
    uint32_t at = node;
    for (uint32_t up = sl_mesh_parent(mesh, at); up != SL_NO_INDEX; at = up, up = sl_mesh_parent(mesh, at)) path[depth++] = (int)(at - mesh->node[up].child);
    sl_mesh_place place = sl_mesh_root_place(mesh, mesh->node[at].parent & ~SL_MESH_ROOT);
    while (depth > 0) place = sl_mesh_child_place(mesh, &place, path[--depth]);
    return place;
}

/* ---- points -------------------------------------------------------------------------------------------------------- */

/* Onto the face: NaN becomes 0. */
static void clamp_weights(float w1, float w2, double *clamped1, double *clamped2) {
    double a = w1 > 0.0f ? (double)fminf(w1, 1.0f) : 0.0, b = w2 > 0.0f ? (double)fminf(w2, 1.0f) : 0.0;
    double sum = a + b;
    *clamped1 = sum > 1.0 ? a / sum : a;
    *clamped2 = sum > 1.0 ? b / sum : b;
}

/* Weights of a place's three corners at a point of the face (weights w1, w2 of the face's): places are at whole numbers of
 * 1/SL_MESH_DYADIC and their areas powers of two of them, so this is exact for points that are not absurdly near a corner. */
static void weights_within(const sl_mesh_place *place, double w1, double w2, double w[3]) {
    double p1 = place->p[1] - place->p[0], p2 = place->p[2] - place->p[0], q1 = place->q[1] - place->q[0], q2 = place->q[2] - place->q[0];
    double u = w1 * SL_MESH_DYADIC - place->p[0], v = w2 * SL_MESH_DYADIC - place->q[0], area = p1 * q2 - p2 * q1;
    w[1] = (u * q2 - v * p2) / area;
    w[2] = (p1 * v - q1 * u) / area;
    w[0] = 1.0 - w[1] - w[2];
}

static int child_at(const sl_mesh_node *node, const double w[3]) {
    if (node->flags & SL_NODE_BISECTED) {
        int cut = cut_of(node->flags);
        return w[(cut + 1) % 3] >= w[(cut + 2) % 3] ? 0 : 1;
    }
    for (int c = 0; c < 3; c++)
        if (w[c] >= 0.5) return c;
    return 3;
}

int sl_mesh_child_at(const sl_mesh *mesh, const sl_mesh_place *place, float w1, float w2) {
    double a, b, w[3];
    clamp_weights(w1, w2, &a, &b);
    weights_within(place, a, b, w);
    return child_at(&mesh->node[place->node], w);
}

void sl_mesh_weights_within(const sl_mesh_place *place, float w1, float w2, float *leaf_w1, float *leaf_w2) {
    double a, b, w[3];
    clamp_weights(w1, w2, &a, &b);
    weights_within(place, a, b, w);
    *leaf_w1 = (float)w[1];
    *leaf_w2 = (float)w[2];
}

sl_mesh_place sl_mesh_locate(const sl_mesh *mesh, uint32_t face, float w1, float w2, float *leaf_w1, float *leaf_w2) {
    sl_mesh_place place = sl_mesh_root_place(mesh, face);
    double a, b, w[3];
    if (place.node == SL_NO_INDEX) return place;
    clamp_weights(w1, w2, &a, &b);
    for (weights_within(&place, a, b, w); !sl_mesh_is_leaf(mesh, place.node); weights_within(&place, a, b, w))
        place = sl_mesh_child_place(mesh, &place, child_at(&mesh->node[place.node], w));
    *leaf_w1 = (float)w[1];
    *leaf_w2 = (float)w[2];
    return place;
}

/* ---- split and collapse --------------------------------------------------------------------------------------------- */

static double doubled_area(sl_vec3d a, sl_vec3d b, sl_vec3d c) { return sl_lengthd(sl_crossd(sl_subd(b, a), sl_subd(c, a))); }

/* How a leaf is to be cut: its longest edge if it is a sliver, 3 if in four, -1 if not at all, since some child would have no area in the float
 * coordinates that vertices have. NaN has none. */
static int choose_cut(const sl_mesh *mesh, const sl_mesh_place *place) {
    if (mesh->topology->degenerate[place->face / 2]) return -1;
    sl_vec3d corner[3], at[3];
    for (int c = 0; c < 3; c++) {
        int j = (c + 1) % 3, k = (c + 2) % 3;
        corner[c] = sl_to_double(sl_mesh_position_in_face(mesh, place->face, place->p[c], place->q[c]));
        at[c] = sl_to_double(sl_mesh_position_in_face(mesh, place->face, middle(place->p[j], place->p[k]), middle(place->q[j], place->q[k])));
    }
    int longest = 0;
    double length_squared[3];
    for (int c = 0; c < 3; c++) {
        sl_vec3d edge = sl_subd(corner[(c + 2) % 3], corner[(c + 1) % 3]);
        length_squared[c] = sl_dotd(edge, edge);
        if (length_squared[c] > length_squared[longest]) longest = c;
    }
    if (length_squared[longest] > SL_MESH_SLIVER * doubled_area(corner[0], corner[1], corner[2])) {
        int j = (longest + 1) % 3, k = (longest + 2) % 3;
        bool good = doubled_area(corner[longest], corner[j], at[longest]) > 0.0 && doubled_area(corner[longest], at[longest], corner[k]) > 0.0;
        return good ? longest : -1;
    }
    bool good = doubled_area(at[0], at[1], at[2]) > 0.0;
    for (int c = 0; c < 3; c++) good = good && doubled_area(corner[c], at[(c + 1) % 3], at[(c + 2) % 3]) > 0.0;
    return good ? 3 : -1;
}

static uint32_t closed_edge(uint32_t flags, int edge) { return (flags >> 2 * edge & 3u) == SL_EDGE_CLOSED ? (uint32_t)SL_EDGE_CLOSED << 2 * edge : 0; }

/* Corner c of a child in four keeps the edge opposite to c half, unless c is the corner that it shares with its parent. */
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

/* Child 0 has the cut edge's first half and the edge opposite to its second end whole, child 1 the other ones. */
static void fill_two(sl_mesh *mesh, uint32_t node, int cut, uint32_t at) {
    const sl_mesh_node *parent = &mesh->node[node];
    int end[2] = {(cut + 1) % 3, (cut + 2) % 3};
    for (int child = 0; child < 2; child++) {
        sl_mesh_node *n = &mesh->node[parent->child + (uint32_t)child];
        int lost = end[1 - child];
        memcpy(n->vertex, parent->vertex, sizeof n->vertex);
        n->vertex[lost] = at;
        n->flags = closed_edge(parent->flags, cut) | closed_edge(parent->flags, lost);
    }
}

sl_status sl_mesh_split(sl_mesh *mesh, const sl_mesh_place *place, sl_error *error) {
    if (!sl_mesh_is_leaf(mesh, place->node) || place->depth >= mesh->max_depth) return SL_OK;
    int cut = choose_cut(mesh, place);
    if (cut < 0) return SL_OK;
    uint32_t at[3] = {SL_NO_INDEX, SL_NO_INDEX, SL_NO_INDEX};
    for (int edge = 0; edge < 3; edge++) {
        sl_status status;
        if (cut < 3 && edge != cut) continue;
        at[edge] = sl_mesh_middle(mesh, place, edge, &status, error);
        if (at[edge] == SL_NO_INDEX) return status;
    }
    uint32_t children = sl_mesh_take_nodes(mesh, cut < 3 ? 2 : 4, place->node);
    if (children == SL_NO_INDEX) return sl_fail_memory(error, "mesh nodes");
    mesh->node[place->node].child = children;
    if (cut < 3) {
        mesh->node[place->node].flags |= SL_NODE_BISECTED | (uint32_t)cut << SL_NODE_CUT_SHIFT;
        fill_two(mesh, place->node, cut, at[cut]);
    } else {
        fill_four(mesh, place->node, at);
    }
    mesh->leaf_count += (size_t)sl_mesh_children(mesh, place->node) - 1;
    return SL_OK;
}

void sl_mesh_collapse(sl_mesh *mesh, uint32_t node) {
    sl_mesh_node *n = &mesh->node[node];
    if (n->child == SL_NO_INDEX) return;
    int children = sl_mesh_children(mesh, node);
    for (int c = 0; c < children; c++)
        if (!sl_mesh_is_leaf(mesh, n->child + (uint32_t)c)) return;
    sl_mesh_free_nodes(mesh, n->child, children);
    n->child = SL_NO_INDEX;
    n->flags &= ~((uint32_t)SL_NODE_BISECTED | 3u << SL_NODE_CUT_SHIFT);
    mesh->leaf_count -= (size_t)children - 1;
}
