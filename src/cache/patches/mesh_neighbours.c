/* Leaves on the other side of an edge. Within a face quadtrees of triangles are nested, so a leaf beside an
 * edge touches it along a stretch or at a corner, and never reaches across. Everything is in whole numbers of
 * 1/SL_MESH_DYADIC. */
#include "cache/patches/mesh.h"
#include "cache/patches/primitive_parts.h"

typedef struct point {
    int p, q;
} point;

typedef struct search {
    const sl_mesh *mesh;
    uint32_t own;          /* not searched: the node that asks */
    point a, b;            /* the edge in the face that is searched */
    uint32_t *leaf;
    size_t room, count;
} search;

static bool apart(int a, int b, const int x[3]) {
    int low = a < b ? a : b, high = a < b ? b : a;
    return (x[0] < low && x[1] < low && x[2] < low) || (x[0] > high && x[1] > high && x[2] > high);
}

/* Tells whether a node lies wholly beyond the edge's ends in one of the three directions of edges. */
static bool far_off(const search *s, const sl_mesh_place *place) {
    int p[3], q[3], r[3];
    for (int c = 0; c < 3; c++) {
        p[c] = place->p[c];
        q[c] = place->q[c];
        r[c] = p[c] + q[c];
    }
    return apart(s->a.p, s->b.p, p) || apart(s->a.q, s->b.q, q) || apart(s->a.p + s->a.q, s->b.p + s->b.q, r);
}

/* Tells whether a triangle beside the edge's line touches the edge between its ends. Along the line positions
 * are scalar products with it, 0 at a and `length` at b. */
static bool touches(const search *s, const sl_mesh_place *place) {
    int dp = s->b.p - s->a.p, dq = s->b.q - s->a.q, length = dp * dp + dq * dq;
    int on_line = 0, least = length, most = 0, left = 0, right = 0;
    for (int c = 0; c < 3; c++) {
        int p = place->p[c] - s->a.p, q = place->q[c] - s->a.q, side = dp * q - dq * p,
            along = dp * p + dq * q;
        left += side > 0;
        right += side < 0;
        if (side != 0) continue;
        if (on_line == 0 || along < least) least = along;
        if (on_line == 0 || along > most) most = along;
        on_line++;
    }
    return on_line > 0 && (left == 0 || right == 0) && most > 0 && least < length;
}

static void look_in(search *s, const sl_mesh_place *place) {
    if (place->node == s->own || far_off(s, place)) return;
    if (sl_mesh_is_leaf(s->mesh, place->node)) {
        if (!touches(s, place)) return;
        if (s->count < s->room) s->leaf[s->count] = place->node;
        s->count++;
        return;
    }
    for (int c = 0; c < 4; c++) {
        sl_mesh_place child = sl_mesh_child_place(s->mesh, place, c);
        look_in(s, &child);
    }
}

static int weight(const sl_mesh_place *place, int corner, int of) {
    return of == 1   ? place->p[corner]
           : of == 2 ? place->q[corner]
                     : SL_MESH_DYADIC - place->p[corner] - place->q[corner];
}

/* Returns the face's edge on which an edge of a place lies, or -1 if it lies inside. */
static int face_edge_of(const sl_mesh_place *place, int edge) {
    for (int c = 0; c < 3; c++)
        if (weight(place, (edge + 1) % 3, c) == 0 && weight(place, (edge + 2) % 3, c) == 0) return c;
    return -1;
}

static point on_edge(int edge, uint32_t t) {
    uint32_t u, v;
    sl_edge_point(3, edge, t, &u, &v);
    return (point){(int)u, (int)v};
}

/* Looks in the other faces along the face's edge opposite to corner c, in each of which the same stretch of
 * it has other weights. */
static void look_in_other_faces(search *s, const sl_mesh_place *place, int edge, int c) {
    const sl_primitives *primitives = s->mesh->primitives;
    uint32_t own = 4 * (place->face / 2) + (uint32_t)(c + 1) % 3;
    uint32_t from = sl_edge_along(primitives, own, (uint32_t)weight(place, (edge + 1) % 3, (c + 2) % 3)),
             to = sl_edge_along(primitives, own, (uint32_t)weight(place, (edge + 2) % 3, (c + 2) % 3));
    for (uint32_t code = primitives->edge_next[own]; code != own; code = primitives->edge_next[code]) {
        uint32_t face = 2 * (code / 4) + place->face % 2;
        if (sl_mesh_root_of(s->mesh, face) == SL_NO_INDEX) continue;
        s->a = on_edge((int)(code % 4), sl_edge_along(primitives, code, from));
        s->b = on_edge((int)(code % 4), sl_edge_along(primitives, code, to));
        sl_mesh_place root = sl_mesh_root_place(s->mesh, face);
        look_in(s, &root);
    }
}

size_t sl_mesh_neighbours(const sl_mesh *mesh, const sl_mesh_place *place, int edge, uint32_t *leaf,
                          size_t room) {
    int j = (edge + 1) % 3, k = (edge + 2) % 3, border = face_edge_of(place, edge);
    search s = {.mesh = mesh,
                .own = place->node,
                .a = {place->p[j], place->q[j]},
                .b = {place->p[k], place->q[k]},
                .leaf = leaf,
                .room = room};
    if (border >= 0) {
        look_in_other_faces(&s, place, edge, border);
    } else {
        sl_mesh_place root = sl_mesh_root_place(mesh, place->face);
        look_in(&s, &root);
    }
    return s.count;
}
