/* The test of a leaf. Each edge's middle is sampled and compared, at the final pixel, with the mean of its
 * ends (sl_mesh_test_edge()): a difference that an eye can tell splits the edge, and with it the leaf; else
 * the edge is closed, its halves included. A leaf above the size criterion is split whatever its edges say,
 * so that small features are found. What was split for its size in vain is undone: four closed leaves under a
 * parent whose own edges are closed go, and the parent stays closed until it is twice as large on the screen.
 *
 * A leaf is split only when the middles of all its edges have been sampled, so every corner but the roots'
 * has a value. */
#include "cache/multi_mesh/displayed.h"

#include "base/counters.h"

/* Tells whether it is certain that the leaf will be split. Then all its middles are wanted, those of closed
 * edges too. */
static bool will_split(const sl_displayed *d, const sl_patch_place *leaf) {
    return sl_needs_cut(&d->mesh->patch[leaf->patch]) && sl_may_split(d, leaf);
}

/* Old values are asked for again. again: what is known, too. */
static void ask(sl_displayed *d, uint32_t v, bool again, uint32_t *vertex, size_t *count) {
    sl_vertex_state state = sl_mesh_state(d->mesh, v);
    bool old = state != SL_VERTEX_REQUESTED && sl_is_old(d, v);
    if (state != SL_VERTEX_UNKNOWN && !(again && state == SL_VERTEX_KNOWN) && !old) return;
    sl_mesh_set_state(d->mesh, v, SL_VERTEX_REQUESTED);
    vertex[(*count)++] = v;
}

sl_status sl_displayed_request(sl_displayed *d, const sl_patch_place *leaf, uint32_t *vertex, size_t *count,
                               sl_error *error) {
    sl_status status = SL_OK;
    *count = 0;
    /* some may have been interpolated where something lies in between */
    bool again = sl_displayed_is_contradicted(d, leaf), all = will_split(d, leaf); /* by values as they are */
    for (int c = 0; c < 3; c++) ask(d, sl_patch_corner(d->mesh, leaf->patch, c), again, vertex, count);
    d->corners_asked |= *count > 0;
    for (int e = 0; e < 3; e++) {
        if (sl_edge_of(&d->mesh->patch[leaf->patch], e) == SL_EDGE_CLOSED && !all) continue;
        uint32_t middle = sl_mesh_middle(d->mesh, leaf, e, &status, error);
        if (status != SL_OK) return status;
        if (middle != SL_NO_INDEX) ask(d, middle, again, vertex, count);
    }
    return sl_displayed_grow(d, error);
}

/* ---- edges: what an eye can tell ---- */

static bool differs(const void *context, uint32_t face, float w1, float w2, const float *mean,
                    const float *value) {
    const sl_displayed *d = context;
    sl_rgb interpolated = sl_displayed_shown(d, face, w1, w2, mean),
           computed = sl_displayed_shown(d, face, w1, w2, value);
    return sl_display_contrast(&d->settings.perception, computed, interpolated) > 1.0f;
}

static sl_edge_state test_edge(const sl_displayed *d, const sl_patch_place *place, int edge) {
    return sl_mesh_test_edge(d->mesh, place, edge, &(sl_edge_test){differs, d});
}

typedef struct news {
    sl_displayed *d;
    uint32_t middle;
} news;

/* Opens a neighbour's closed edge if the new middle, a part's of it, differs there. */
static void tell(sl_patches *mesh, const sl_patch_place *leaf, void *context) {
    const news *n = context;
    sl_displayed *d = n->d;
    sl_patch *node = &mesh->patch[leaf->patch];
    if (d->settings.hanging) sl_displayed_mark(d, leaf->patch);
    if (!node->pixels || !(node->flags & SL_PATCH_EDGES)) return;
    for (int e = 0; e < 3; e++) {
        if (sl_edge_of(node, e) != SL_EDGE_CLOSED) continue;
        if (!sl_mesh_edge_differs(mesh, leaf, e, n->middle, &(sl_edge_test){differs, d})) continue;
        sl_set_edge(node, e, SL_EDGE_SPLIT);
        sl_mesh_set_tested_size(node, 0.0f); /* it is not what it was when it was tested */
        node->priority = sl_displayed_leaf_priority(d, leaf);
        sl_displayed_raise(d, leaf->root, leaf->patch);
    }
}

/* An edge's middle has become known: leaves beyond the edge are drawn again, and split if they can tell. */
static void tell_neighbours(sl_displayed *d, uint32_t middle) {
    news n = {d, middle};
    sl_patches_visit_around(d->mesh, d->mesh->vertex[middle].place, tell, &n);
}

/* Tests what is untested, and tells neighbours of middles that they may not know. Returns true if all
 * three have a value. */
static bool test_edges(sl_displayed *d, const sl_patch_place *leaf) {
    sl_patch *node = &d->mesh->patch[leaf->patch];
    bool complete = true;
    for (int e = 0; e < 3; e++) {
        uint32_t middle = sl_mesh_find_middle(d->mesh, leaf, e);
        bool settled = sl_mesh_is_sampled(d->mesh, middle);
        complete &= settled && sl_mesh_is_sampled(d->mesh, sl_patch_corner(d->mesh, leaf->patch, e));
        if (sl_edge_of(node, e) == SL_EDGE_UNTESTED)
            sl_set_edge(node, e, test_edge(d, leaf, e));
        if (settled) tell_neighbours(d, middle);
    }
    return complete;
}

static bool is_of_now(const sl_displayed *d, const sl_patch_place *leaf, int edge) {
    bool old = sl_is_old(d, sl_mesh_find_middle(d->mesh, leaf, edge));
    for (int k = 1; k < 3; k++) old |= sl_is_old(d, sl_patch_corner(d->mesh, leaf->patch, (edge + k) % 3));
    return !old;
}

void sl_displayed_retest(sl_displayed *d, const sl_patch_place *leaf) {
    sl_patch *node = &d->mesh->patch[leaf->patch];
    bool changed = false;
    for (int e = 0; e < 3; e++) {
        sl_edge_state before = sl_edge_of(node, e), now = before;
        if (before != SL_EDGE_UNTESTED && is_of_now(d, leaf, e)) now = test_edge(d, leaf, e);
        if (now == SL_EDGE_UNTESTED || now == before) continue;
        sl_set_edge(node, e, now);
        changed = true;
    }
    if (changed) sl_mesh_set_tested_size(node, 0.0f);
    if (changed && sl_all_edges_closed(node)) sl_displayed_judge_probes(d, node, sl_displayed_size(d, leaf));
}

/* ---- split ---- */

static sl_status split(sl_displayed *d, const sl_patch_place *leaf, sl_error *error) {
    sl_status status = sl_mesh_split(d->mesh, leaf, error);
    if (status == SL_OK) status = sl_displayed_grow(d, error);
    if (status != SL_OK) return status;
    if (sl_patch_is_leaf(d->mesh, leaf->patch)) { /* coordinates end: it stays whole for good */
        sl_patch *node = &d->mesh->patch[leaf->patch];
        node->flags = (node->flags & ~(uint32_t)SL_PATCH_EDGES) | SL_ALL_EDGES_CLOSED | SL_NODE_SMALL;
        sl_mesh_set_tested_size(node, FLT_MAX);
        return SL_OK;
    }
    sl_displayed_hand_down(d, leaf);
    for (int c = 0; c < 4; c++) {
        sl_patch_place child = sl_patch_child_place(d->mesh, leaf, c);
        sl_displayed_judge_size(d, &child);
        d->mesh->patch[child.patch].priority = sl_displayed_leaf_priority(d, &child);
        sl_displayed_mark(d, child.patch);
    }
    return SL_OK;
}

/* ---- undo ---- */

/* Nothing to be told apart in it, as far as it will ever be looked at. */
static bool is_closed(const sl_displayed *d, const sl_patch_place *leaf) {
    const sl_patch *node = &d->mesh->patch[leaf->patch];
    if (node->child != SL_NO_INDEX || (node->flags & SL_NODE_TAKEN)) return false;
    if (sl_may_split(d, leaf))
        return (node->flags & SL_NODE_SMALL) && sl_all_edges_closed(node) && !sl_is_unprobed(d, node);
    return sl_all_edges_closed(node) || sl_displayed_corner_contrast(d, leaf) <= 1.0f;
}

/* Collapses a node if all its children are closed. What its edges were when it was cut says nothing once
 * there has been an edit: they are tested again. */
static bool undo(sl_displayed *d, const sl_patch_place *place) {
    sl_patches *mesh = d->mesh;
    sl_patch *node = &mesh->patch[place->patch];
    if (node->child == SL_NO_INDEX || !(d->world > 1 || sl_all_edges_closed(node))) return false;
    for (int c = 0; c < 4; c++) {
        sl_patch_place child = sl_patch_child_place(mesh, place, c);
        if (!is_closed(d, &child)) return false;
    }
    for (int e = 0; e < 3; e++) { /* neighbours may have seen more on it by now */
        if (test_edge(d, place, e) != SL_EDGE_CLOSED) return false;
    }
    for (int e = 0; e < 3; e++) sl_set_edge(node, e, SL_EDGE_CLOSED);
    sl_patch_drop_children(mesh, place->patch);
    sl_mesh_set_tested_size(node, sl_displayed_size(d, place).edge);
    node->flags |= SL_NODE_SMALL;
    node->priority = 0.0f;
    return true;
}

/* Collapses parents that are closed by now; what is above is brought up to date. */
static void settle_above(sl_displayed *d, sl_patch_place parent, uint32_t highest, sl_counters *counters) {
    while (undo(d, &parent)) {
        highest = parent.patch;
        sl_count(counters, SL_COUNT_COLLAPSES, 1);
        sl_displayed_mark(d, parent.patch);
        if (sl_patch_parent(d->mesh, parent.patch) == SL_NO_INDEX) break;
        parent = sl_patch_place_of(d->mesh, sl_patch_parent(d->mesh, parent.patch));
    }
    sl_displayed_raise(d, parent.root, highest);
}

void sl_displayed_close(sl_displayed *d, const sl_patch_place *leaf, sl_counters *counters) {
    sl_patch_place parent =
        leaf->depth > 0 ? sl_patch_place_of(d->mesh, sl_patch_parent(d->mesh, leaf->patch)) : *leaf;
    d->mesh->patch[leaf->patch].priority = sl_displayed_leaf_priority(d, leaf);
    settle_above(d, parent, leaf->patch, counters);
}

/* Edges that have just been closed: whether the leaf is to be probed. */
static void judge_closed(sl_displayed *d, const sl_patch_place *leaf) {
    sl_patch *node = &d->mesh->patch[leaf->patch];
    sl_mesh_set_tested_size(node, 0.0f);
    sl_displayed_judge_probes(d, node, sl_displayed_size(d, leaf));
}

sl_status sl_displayed_commit(sl_displayed *d, const sl_patch_place *leaf, sl_counters *counters,
                              sl_error *error) {
    sl_patches *mesh = d->mesh;
    if (!d->pixels || !sl_patch_is_leaf(mesh, leaf->patch)) return SL_OK;
    mesh->patch[leaf->patch].flags &= ~(uint32_t)SL_NODE_TAKEN;
    d->dirty_all |= d->corners_asked;
    d->corners_asked = false;
    bool was_closed = sl_all_edges_closed(&mesh->patch[leaf->patch]), complete = test_edges(d, leaf);
    sl_displayed_mark(d, leaf->patch);
    if (!was_closed && sl_all_edges_closed(&mesh->patch[leaf->patch])) judge_closed(d, leaf);
    sl_status status = complete && will_split(d, leaf) ? split(d, leaf, error) : SL_OK;
    if (status != SL_OK) return status;
    if (sl_patch_is_leaf(mesh, leaf->patch)) {
        sl_displayed_close(d, leaf, counters);
        return SL_OK;
    }
    sl_count(counters, SL_COUNT_SPLITS, 1);
    settle_above(d, *leaf, mesh->patch[leaf->patch].child, counters);
    return SL_OK;
}
