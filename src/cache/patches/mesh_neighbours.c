/* Leaves on the other side of an edge. Within a face quadtrees of triangles are nested, so a leaf beside an
 * edge touches it along a stretch or at a corner, and never reaches across. Everything is in whole numbers of
 * 1/SL_MESH_DYADIC. */
#include "cache/patches/mesh.h"

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

/* The point of a face at weight `first` of corner j and `second` of corner k. */
static point on_edge(int j, int first, int k, int second) {
    return (point){(j == 1) * first + (k == 1) * second, (j == 2) * first + (k == 2) * second};
}

static int weight(const sl_mesh_place *place, int corner, int of) {
    return of == 1   ? place->p[corner]
           : of == 2 ? place->q[corner]
                     : SL_MESH_DYADIC - place->p[corner] - place->q[corner];
}

/* The face's edge on which an edge of a place lies, or -1 if it lies inside. */
static int face_edge_of(const sl_mesh_place *place, int edge) {
    for (int c = 0; c < 3; c++)
        if (weight(place, (edge + 1) % 3, c) == 0 && weight(place, (edge + 2) % 3, c) == 0) return c;
    return -1;
}

/* The other faces along the face's edge c, in each of which the same stretch of it has other weights. */
static void look_in_other_faces(search *s, const sl_mesh_place *place, int edge, int c) {
    const sl_topology *topology = s->mesh->topology;
    int first = (c + 1) % 3, from = weight(place, (edge + 1) % 3, first),
        to = weight(place, (edge + 2) % 3, first);
    uint32_t e = topology->edge[c][place->face], site = topology->site[first][place->face];
    /* no direction: vertices are the face's own */
    if (site == topology->site[(c + 2) % 3][place->face]) return;
    for (uint32_t i = topology->edge_start[e]; i < topology->edge_start[e + 1]; i++) {
        uint32_t face = topology->edge_face[i];
        if (face == place->face || sl_mesh_root_of(s->mesh, face) == SL_NO_INDEX) continue;
        for (int k = 0; k < 3; k++) {
            if (topology->edge[k][face] != e) continue;
            int j = (k + 1) % 3, l = (k + 2) % 3, same = topology->site[j][face] == site ? j : l,
                other = same == j ? l : j;
            s->a = on_edge(same, from, other, SL_MESH_DYADIC - from);
            s->b = on_edge(same, to, other, SL_MESH_DYADIC - to);
            sl_mesh_place root = sl_mesh_root_place(s->mesh, face);
            look_in(s, &root);
        }
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
