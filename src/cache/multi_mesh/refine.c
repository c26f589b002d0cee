/* The test of a leaf. Each edge's middle is sampled and compared, at the final pixel, with the mean of its
 * ends (edge_tests.c): a difference that an eye can tell splits the edge, and with it the leaf; else the edge
 * is closed, its halves included. A leaf above the size criterion is split whatever its edges say, so that
 * small features are found. What was split for its size in vain is undone: four closed leaves under a parent
 * whose own edges are closed go, and the parent stays closed until it is twice as large on the screen.
 *
 * A leaf is split only when the middles of all its edges have been sampled, so every corner but the roots'
 * has a value. */
#include "cache/multi_mesh/displayed_internal.h"

#include "base/counters.h"

/* Tells whether it is certain that the leaf will be split. Then all its middles are wanted, those of closed
 * edges too. */
static bool will_split(const sl_displayed *d, const sl_mesh_place *leaf) {
    return sl_needs_cut(&d->mesh->node[leaf->node]) && sl_may_split(d, leaf);
}

/* again: what is known, too. */
static void ask(sl_displayed *d, uint32_t v, bool again, uint32_t *vertex, size_t *count) {
    uint8_t state = d->mesh->state[v];
    if (state != SL_VERTEX_UNKNOWN && !(again && state == SL_VERTEX_KNOWN)) return;
    d->mesh->state[v] = SL_VERTEX_REQUESTED;
    vertex[(*count)++] = v;
}

sl_status sl_displayed_request(sl_displayed *d, const sl_mesh_place *leaf, uint32_t *vertex, size_t *count,
                               sl_error *error) {
    sl_status status = SL_OK;
    *count = 0;
    /* some may have been interpolated where something lies in between */
    bool again = sl_displayed_is_contradicted(d, leaf);
    for (int c = 0; c < 3; c++) ask(d, d->mesh->node[leaf->node].vertex[c], again, vertex, count);
    d->corners_asked |= *count > 0;
    bool all = will_split(d, leaf);
    for (int e = 0; e < 3; e++) {
        if (sl_edge_of(&d->mesh->node[leaf->node], e) == SL_EDGE_CLOSED && !all) continue;
        uint32_t middle = sl_mesh_middle(d->mesh, leaf, e, &status, error);
        if (status != SL_OK) return status;
        if (middle != SL_NO_INDEX) ask(d, middle, again, vertex, count);
    }
    return SL_OK;
}

/* ---- edges ---- */

/* Tests what is untested, and tells neighbours of middles that they may not know. Whether all three have a
 * value. */
static bool test_edges(sl_displayed *d, const sl_mesh_place *leaf) {
    sl_mesh_node *node = &d->mesh->node[leaf->node];
    bool complete = true;
    for (int e = 0; e < 3; e++) {
        uint32_t middle = sl_mesh_find_middle(d->mesh, leaf, e);
        bool settled = sl_displayed_is_settled(d, middle);
        complete &= settled && sl_displayed_is_settled(d, node->vertex[e]);
        if (sl_edge_of(node, e) == SL_EDGE_UNTESTED)
            node->flags |= (uint32_t)sl_displayed_test_edge(d, leaf, e) << 2 * e;
        if (settled) sl_displayed_tell_neighbours(d, leaf, e, middle);
    }
    return complete;
}

/* ---- split ---- */

static sl_status split(sl_displayed *d, const sl_mesh_place *leaf, sl_error *error) {
    sl_status status = sl_mesh_split(d->mesh, leaf, error);
    if (status == SL_OK) status = sl_displayed_grow(d, error);
    if (status != SL_OK) return status;
    if (sl_mesh_is_leaf(d->mesh, leaf->node)) { /* coordinates end: it stays whole for good */
        sl_mesh_node *node = &d->mesh->node[leaf->node];
        node->flags = (node->flags & ~(uint32_t)SL_NODE_EDGES) | SL_ALL_EDGES_CLOSED | SL_NODE_SMALL;
        sl_mesh_set_tested_size(node, FLT_MAX);
        return SL_OK;
    }
    sl_face_clip clip = sl_face_clip_of(d->mesh->primitives->scene, &d->pixels->view, leaf->face);
    sl_displayed_hand_down(d, leaf);
    for (int c = 0; c < 4; c++) {
        sl_mesh_place child = sl_mesh_child_place(d->mesh, leaf, c);
        sl_displayed_judge_size(d, &clip, &child);
        d->mesh->node[child.node].priority = sl_displayed_leaf_priority(d, &child);
        sl_displayed_mark(d, child.node);
    }
    return SL_OK;
}

/* ---- undo ---- */

/* Nothing to be told apart in it, as far as it will ever be looked at. */
static bool is_closed(const sl_displayed *d, const sl_mesh_place *leaf) {
    const sl_mesh_node *node = &d->mesh->node[leaf->node];
    if (node->child != SL_NO_INDEX || (node->flags & SL_NODE_TAKEN)) return false;
    if (sl_may_split(d, leaf))
        return (node->flags & SL_NODE_SMALL) && sl_all_edges_closed(node) && !sl_is_unprobed(d, node);
    return sl_all_edges_closed(node) || sl_displayed_corner_contrast(d, leaf) <= 1.0f;
}

/* Collapses a node if all its children are closed. */
static bool undo(sl_displayed *d, const sl_mesh_place *place) {
    sl_mesh *mesh = d->mesh;
    sl_mesh_node *node = &mesh->node[place->node];
    if (node->child == SL_NO_INDEX || !sl_all_edges_closed(node)) return false;
    for (int c = 0; c < 4; c++) {
        sl_mesh_place child = sl_mesh_child_place(mesh, place, c);
        if (!is_closed(d, &child)) return false;
    }
    for (int e = 0; e < 3; e++) { /* neighbours may have seen more on it by now */
        if (sl_displayed_test_edge(d, place, e) == SL_EDGE_SPLIT) return false;
    }
    sl_mesh_collapse(mesh, place->node);
    sl_face_clip clip = sl_face_clip_of(mesh->primitives->scene, &d->pixels->view, place->face);
    sl_mesh_set_tested_size(node, sl_displayed_size(d, &clip, place).edge);
    node->flags |= SL_NODE_SMALL;
    node->priority = 0.0f;
    return true;
}

/* Collapses parents that are closed by now; what is above is brought up to date. */
static void settle_above(sl_displayed *d, sl_mesh_place parent, uint32_t highest, sl_counters *counters) {
    while (undo(d, &parent)) {
        highest = parent.node;
        sl_count(counters, SL_COUNT_COLLAPSES, 1);
        sl_displayed_mark(d, parent.node);
        if (sl_mesh_parent(d->mesh, parent.node) == SL_NO_INDEX) break;
        parent = sl_mesh_place_of(d->mesh, sl_mesh_parent(d->mesh, parent.node));
    }
    sl_displayed_raise(d, parent.face, highest);
}

void sl_displayed_close(sl_displayed *d, const sl_mesh_place *leaf, sl_counters *counters) {
    sl_mesh_place parent =
        leaf->depth > 0 ? sl_mesh_place_of(d->mesh, sl_mesh_parent(d->mesh, leaf->node)) : *leaf;
    d->mesh->node[leaf->node].priority = sl_displayed_leaf_priority(d, leaf);
    settle_above(d, parent, leaf->node, counters);
}

/* Edges that have just been closed: whether the leaf is to be probed. */
static void judge_closed(sl_displayed *d, const sl_mesh_place *leaf) {
    sl_mesh_node *node = &d->mesh->node[leaf->node];
    sl_face_clip clip = sl_face_clip_of(d->mesh->primitives->scene, &d->pixels->view, leaf->face);
    sl_mesh_set_minor(node, 0);
    sl_displayed_judge_probes(d, node, sl_displayed_size(d, &clip, leaf));
}

sl_status sl_displayed_commit(sl_displayed *d, const sl_mesh_place *leaf, sl_counters *counters,
                              sl_error *error) {
    sl_mesh *mesh = d->mesh;
    if (!d->pixels || !sl_mesh_is_leaf(mesh, leaf->node)) return SL_OK;
    mesh->node[leaf->node].flags &= ~(uint32_t)SL_NODE_TAKEN;
    d->dirty_all |= d->corners_asked;
    d->corners_asked = false;
    bool was_closed = sl_all_edges_closed(&mesh->node[leaf->node]), complete = test_edges(d, leaf);
    sl_displayed_mark(d, leaf->node);
    if (!was_closed && sl_all_edges_closed(&mesh->node[leaf->node])) judge_closed(d, leaf);
    sl_status status = complete && will_split(d, leaf) ? split(d, leaf, error) : SL_OK;
    if (status != SL_OK) return status;
    if (sl_mesh_is_leaf(mesh, leaf->node)) {
        sl_displayed_close(d, leaf, counters);
        return SL_OK;
    }
    sl_count(counters, SL_COUNT_SPLITS, 1);
    settle_above(d, *leaf, mesh->node[leaf->node].child, counters);
    return SL_OK;
}

/* Tests whether an eye can tell an edge's values from those between its ends. The middle is compared, at the
 * final pixel, with the mean of the ends; and so is every middle of a part of the edge that has a value
 * already, since someone on the other side asked for it: an edge is tested once, for both its sides.
 * Otherwise a large leaf beside a small shadow would draw the shadow's vertex on its edge as a spike to its
 * own centre. */

enum { NEIGHBOURS = 256 };

typedef struct edge_point {
    uint32_t vertex;
    uint16_t p, q;         /* weights of the face's corners 1 and 2 */
} edge_point;

static edge_point end_of(const sl_mesh *mesh, const sl_mesh_place *place, int corner) {
    return (edge_point){mesh->node[place->node].vertex[corner], place->p[corner], place->q[corner]};
}

static edge_point middle_of(const sl_mesh *mesh, uint32_t face, edge_point a, edge_point b) {
    sl_mesh_place place = {.face = face, .p = {0, a.p, b.p}, .q = {0, a.q, b.q}};
    return (edge_point){sl_mesh_find_middle(mesh, &place, 0), (uint16_t)((a.p + b.p) / 2),
                        (uint16_t)((a.q + b.q) / 2)};
}

static sl_rgb value_of(const sl_mesh *mesh, uint32_t vertex) {
    const float *v = &mesh->value[3 * (size_t)vertex];
    return (sl_rgb){v[0], v[1], v[2]};
}

/* Ends and middle are settled. */
static bool differs(const sl_displayed *d, uint32_t face, edge_point a, edge_point b, edge_point middle) {
    const sl_mesh *mesh = d->mesh;
    const uint8_t *state = mesh->state;
    if (state[a.vertex] != SL_VERTEX_KNOWN || state[b.vertex] != SL_VERTEX_KNOWN ||
        state[middle.vertex] != SL_VERTEX_KNOWN) {
        return true; /* inside other geometry: light ends somewhere along the edge */
    }
    const float unit = 1.0f / (float)SL_MESH_DYADIC;
    float w1 = (float)middle.p * unit, w2 = (float)middle.q * unit;
    const sl_shown_radiance *shown = &d->settings.shown;
    sl_rgb mean = sl_rgb_scale(sl_rgb_add(value_of(mesh, a.vertex), value_of(mesh, b.vertex)), 0.5f);
    sl_rgb computed =
        shown->radiance(shown->context, d->settings.component, face, w1, w2, value_of(mesh, middle.vertex));
    sl_rgb interpolated = shown->radiance(shown->context, d->settings.component, face, w1, w2, mean);
    return sl_display_contrast(&d->settings.perception, computed, interpolated) > 1.0f;
}

/* ---- an edge and its parts ---- */

/* Tells whether any middle of the edge or of its parts differs; `only` that vertex, or SL_NO_INDEX: all. */
static bool any_differs(const sl_displayed *d, uint32_t face, edge_point a, edge_point b, uint32_t only) {
    edge_point middle = middle_of(d->mesh, face, a, b);
    if (!sl_displayed_is_settled(d, middle.vertex)) return false;
    if ((only == SL_NO_INDEX || only == middle.vertex) && differs(d, face, a, b, middle)) return true;
    if (only == middle.vertex || d->mesh->state[middle.vertex] != SL_VERTEX_KNOWN ||
        !d->mesh->halved[middle.vertex])
        return false;
    return any_differs(d, face, a, middle, only) || any_differs(d, face, middle, b, only);
}

sl_edge_state sl_displayed_test_edge(const sl_displayed *d, const sl_mesh_place *place, int edge) {
    edge_point a = end_of(d->mesh, place, (edge + 1) % 3), b = end_of(d->mesh, place, (edge + 2) % 3);
    bool settled = sl_displayed_is_settled(d, a.vertex) && sl_displayed_is_settled(d, b.vertex);
    if (!settled || !sl_displayed_is_settled(d, middle_of(d->mesh, place->face, a, b).vertex))
        return SL_EDGE_UNTESTED;
    return any_differs(d, place->face, a, b, SL_NO_INDEX) ? SL_EDGE_SPLIT : SL_EDGE_CLOSED;
}

/* Opens a neighbour's closed edge if the new middle, a part's of it, differs there. */
static void tell(sl_displayed *d, uint32_t leaf, uint32_t middle) {
    sl_mesh_node *node = &d->mesh->node[leaf];
    if (!node->pixels || !(node->flags & SL_NODE_EDGES)) return;
    sl_mesh_place place = sl_mesh_place_of(d->mesh, leaf);
    for (int e = 0; e < 3; e++) {
        if (sl_edge_of(node, e) != SL_EDGE_CLOSED) continue;
        if (!any_differs(d, place.face, end_of(d->mesh, &place, (e + 1) % 3),
                         end_of(d->mesh, &place, (e + 2) % 3), middle))
            continue;
        node->flags = (node->flags & ~(3u << 2 * e) & ~(uint32_t)SL_NODE_SETTLED) | (uint32_t)SL_EDGE_SPLIT
                                                                                        << 2 * e;
        sl_mesh_set_minor(node, 0); /* nor is it what it was when it was tested */
        node->priority = sl_displayed_leaf_priority(d, &place);
        sl_displayed_raise(d, place.face, leaf);
    }
}

void sl_displayed_tell_neighbours(sl_displayed *d, const sl_mesh_place *place, int edge, uint32_t middle) {
    uint32_t leaf[NEIGHBOURS];
    size_t count = sl_mesh_neighbours(d->mesh, place, edge, leaf, NEIGHBOURS),
           listed = count < NEIGHBOURS ? count : NEIGHBOURS;
    d->dirty_all |= count > NEIGHBOURS;
    for (size_t i = 0; i < listed; i++) {
        tell(d, leaf[i], middle);
        if (d->settings.hanging) sl_displayed_mark(d, leaf[i]);
    }
}
