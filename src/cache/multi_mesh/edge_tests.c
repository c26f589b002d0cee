/* Tests whether an eye can tell an edge's values from those between its ends. The middle is compared, at the
 * final pixel, with the mean of the ends; and so is every middle of a part of the edge that has a value
 * already, since someone on the other side asked for it: an edge is tested once, for both its sides.
 * Otherwise a large leaf beside a small shadow would draw the shadow's vertex on its edge as a spike to its
 * own centre. */
#include "cache/multi_mesh/displayed_internal.h"

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
        !d->mesh->key[middle.vertex].halved)
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
