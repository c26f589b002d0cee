/* Leaves around a vertex, in its own root and in those that meet there; and vertices along a leaf's edge. */
#include "cache/patches/patches.h"
#include "cache/patches/primitive_parts.h"

/* ---- leaves around a place ------------------------------------------------------------------- */

/* A point, or an edge of a bicubic patch that is one point in space. */
typedef struct uv_box {
    int u[2], v[2];
} uv_box;

/* Closed regions: a leaf holds what lies on its edges. All triangles of a root are upright or turned by half
 * a turn. */
static bool meets(const sl_patch_place *place, const uv_box *box) {
    if (place->corners == 4)
        return box->u[0] <= place->u[2] && box->u[1] >= place->u[0] && box->v[0] <= place->v[2] &&
               box->v[1] >= place->v[0];
    int side = (int)place->u[1] - (int)place->u[0], turned = side < 0 ? -1 : 1;
    int a = (box->u[0] - (int)place->u[0]) * turned, b = (box->v[0] - (int)place->v[0]) * turned;
    return a >= 0 && b >= 0 && a + b <= side * turned;
}

typedef struct leaf_walk {
    sl_patches *patches;
    sl_leaf_visitor *visit;
    void *context;
} leaf_walk;

static void walk_below(const leaf_walk *w, const sl_patch_place *place, const uv_box *box) {
    if (!meets(place, box)) return;
    if (sl_patch_is_leaf(w->patches, place->patch)) {
        w->visit(w->patches, place, w->context);
        return;
    }
    for (int c = 0; c < 4; c++) {
        sl_patch_place child = sl_patch_child_place(w->patches, place, c);
        walk_below(w, &child, box);
    }
}

static void walk_box(const leaf_walk *w, uint32_t root, const uv_box *box) {
    sl_patch_place place = sl_patch_root_place(w->patches, root);
    if (place.patch != SL_NO_INDEX) walk_below(w, &place, box);
}

static uv_box edge_box(const sl_primitives *primitives, uint32_t code, uint32_t from, uint32_t to) {
    uint32_t u[2], v[2];
    int corners = sl_primitive_corners(primitives, code / 4);
    sl_edge_point(corners, (int)(code % 4), from, &u[0], &v[0]);
    sl_edge_point(corners, (int)(code % 4), to, &u[1], &v[1]);
    int low_u = u[0] < u[1] ? 0 : 1, low_v = v[0] < v[1] ? 0 : 1;
    return (uv_box){{(int)u[low_u], (int)u[1 - low_u]}, {(int)v[low_v], (int)v[1 - low_v]}};
}

/* Corners and edges that are one stand in rings. */
void sl_patches_visit_around(sl_patches *p, sl_root_place place, sl_leaf_visitor *visit, void *context) {
    const sl_primitives *primitives = p->primitives;
    leaf_walk walk = {p, visit, context};
    uint32_t primitive = place.root / 2, side = place.root % 2, t;
    int edge = sl_edge_at(sl_primitive_corners(primitives, primitive), place.u, place.v, &t);
    if (edge < 0) {
        uv_box box = {{place.u, place.u}, {place.v, place.v}};
        walk_box(&walk, place.root, &box);
        return;
    }
    uint32_t first = 4 * primitive + (uint32_t)edge, code = first;
    bool corner = t == 0 || primitives->edge_kind[first] & SL_EDGE_POINT;
    uint32_t common = sl_edge_along(primitives, first, t);
    do {
        uint32_t from = corner ? 0 : sl_edge_along(primitives, code, common);
        uint32_t to = corner && primitives->edge_kind[code] & SL_EDGE_POINT ? SL_PATCH_DYADIC : from;
        uv_box box = edge_box(primitives, code, from, to);
        walk_box(&walk, 2 * (code / 4) + side, &box);
        code = corner ? primitives->corner_next[code] : primitives->edge_next[code];
    } while (code != first);
}

/* ---- vertices along edges -------------------------------------------------------------------- */

typedef struct edge_walk {
    const sl_patches *patches;
    uint32_t corner;             /* a vertex that the edge begins with */
    uint32_t state, shortest;
    int edge;
    size_t count;
    sl_fan_spoke *spoke;
} edge_walk;

/* Lists those between two places, which are so far along the edge and so far apart. Finer leaves beside it
 * have its middle for a corner, and only then may they have the middles of its halves. */
static void walk_edge(edge_walk *w, sl_root_place from, sl_root_place to, uint32_t along, uint32_t length) {
    uint32_t u = (uint32_t)from.u + to.u, v = (uint32_t)from.v + to.v;
    if (length < w->shortest || (u | v) % 2 != 0 || w->count == SL_HANGING_MOST) return;
    sl_root_place middle = {from.root, (uint16_t)(u / 2), (uint16_t)(v / 2)};
    uint32_t vertex = sl_vertex_find(w->patches, middle), half = length / 2;
    if (vertex == SL_NO_INDEX || vertex == w->corner) return; /* the latter: the edge is one point */
    const sl_patch_vertex *at = &w->patches->vertex[vertex];
    if (w->state && at->evaluated != w->state) return;
    if (at->halved) walk_edge(w, from, middle, along, half);
    if (w->count == SL_HANGING_MOST) return;
    w->spoke[w->count++] = (sl_fan_spoke){vertex, (uint16_t)w->edge, (uint16_t)(along + half)};
    if (at->halved) walk_edge(w, middle, to, along + half, half);
}

/* Who makes the middle of an edge marks its ends. Where roots' edges are one their corners may still be
 * two. */
static bool may_be_halved(const sl_patch_vertex *v) {
    return v->halved || (v->u | v->v) % SL_PATCH_DYADIC == 0;
}

bool sl_patch_has_no_spokes(const sl_patches *p, uint32_t leaf) {
    const int corners = sl_patch_corners(p, leaf);
    bool last = may_be_halved(&p->vertex[sl_patch_corner(p, leaf, corners - 1)]), any = false;
    for (int c = 0; c < corners && !any; c++) {
        const bool here = may_be_halved(&p->vertex[sl_patch_corner(p, leaf, c)]);
        any = last && here;
        last = here;
    }
    return !any;
}

size_t sl_patch_spokes(const sl_patches *p, const sl_patch_place *leaf, int levels, uint32_t state,
                       sl_fan_spoke *spoke) {
    size_t count = 0;
    for (int edge = 0; edge < leaf->corners; edge++) {
        int next = (edge + 1) % leaf->corners;
        edge_walk walk = {p, sl_patch_corner(p, leaf->patch, edge), state, 2u * (SL_PATCH_DYADIC >> levels),
                          edge, 0, spoke + count};
        walk_edge(&walk, (sl_root_place){leaf->root, leaf->u[edge], leaf->v[edge]},
                  (sl_root_place){leaf->root, leaf->u[next], leaf->v[next]}, 0, SL_PATCH_DYADIC);
        count += walk.count;
    }
    return count;
}

uint32_t sl_leaf_oldest(const sl_patches *p, uint32_t leaf) {
    uint32_t oldest = UINT32_MAX;
    sl_fan_spoke spoke[4 * SL_HANGING_MOST];
    for (int c = 0; c < sl_patch_corners(p, leaf); c++) {
        uint32_t evaluated = p->vertex[sl_patch_corner(p, leaf, c)].evaluated;
        oldest = evaluated < oldest ? evaluated : oldest;
    }
    if (oldest == SL_VERTEX_NEVER) return oldest;
    sl_patch_place place = sl_patch_place_of(p, leaf);
    size_t count = sl_patch_spokes(p, &place, SL_PATCH_DEPTH_MAX, 0, spoke);
    for (size_t i = 0; i < count; i++) {
        uint32_t evaluated = p->vertex[spoke[i].vertex].evaluated;
        if (evaluated != SL_VERTEX_NEVER && evaluated < oldest) oldest = evaluated;
    }
    return oldest;
}
