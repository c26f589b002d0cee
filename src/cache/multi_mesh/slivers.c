/* Pixels of slivers' halves. Below fourfold cuts alone a node's pixels lie together in the order of paths (pixels.h); a sliver is cut in two, and no
 * path knows its halves. A face with such cuts has an order of its own for its pixels, in which those of each node lie together. */
#include "base/grow.h"
#include "cache/multi_mesh/displayed_internal.h"

#include <string.h>

#include "base/error.h"

/* Room for a face's pixels, and as much again to sort them in. */
sl_status sl_displayed_order_pixels(sl_displayed *d, uint32_t face, sl_error *error) {
    uint32_t entry = d->pixels->entry_of_face[face];
    size_t room = 2 * (size_t)d->pixels->face[entry].count;
    if (d->order_at[entry] != SL_NO_INDEX) return SL_OK;
    if (d->order_count + room > d->order_capacity) {
        size_t capacity = sl_grown_capacity(d->order_capacity, d->order_count + room);
        if (!sl_regrow(&d->order, d->order_count, capacity, sizeof *d->order)) return sl_fail_memory(error, "displayed mesh");
        d->order_capacity = capacity;
    }
    d->order_at[entry] = (uint32_t)d->order_count;
    d->order_count += room;
    d->mesh->node[sl_displayed_root(d, entry)].flags |= SL_NODE_SLIVERS;
    return SL_OK;
}

const uint32_t *sl_displayed_ordered(const sl_displayed *d, const sl_mesh_place *place) {
    uint32_t entry = d->pixels->entry_of_face[place->face];
    return d->order + d->order_at[entry] + (d->first[place->node] - d->pixels->face[entry].first);
}

/* Equals are kept in their order. */
void sl_displayed_partition(sl_displayed *d, const sl_mesh_place *place) {
    const sl_visible_pixels *pixels = d->pixels;
    const sl_visible_face *face = &pixels->face[pixels->entry_of_face[place->face]];
    sl_mesh_node *node = &d->mesh->node[place->node], *children = &d->mesh->node[node->child];
    uint32_t begin = d->first[place->node], count = node->pixels, at = 0;
    uint32_t *order = d->order + d->order_at[pixels->entry_of_face[place->face]] + (begin - face->first), *scratch = order + face->count;
    int parts = sl_mesh_children(d->mesh, place->node);
    if (sl_displayed_follows_paths(place)) {
        for (uint32_t i = 0; i < count; i++) order[i] = begin + i;
    }
    for (int c = 0; c < parts; c++) {
        uint32_t first = at, others = 0;
        for (uint32_t i = first; i < count; i++) {
            bool own = c + 1 == parts || sl_mesh_child_at(d->mesh, place, pixels->w1[order[i]], pixels->w2[order[i]]) == c;
            if (own) order[at++] = order[i];
            else scratch[others++] = order[i];
        }
        memcpy(order + at, scratch, others * sizeof *order);
        d->first[node->child + (uint32_t)c] = begin + first;
        children[c].pixels = at - first;
    }
}
