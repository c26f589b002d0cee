/* Leaves that are probed. A leaf whose edges agree says nothing of what lies between them, and leaves may be
 * larger than the smallest shadow that an eye looks for. To make them smaller costs samples everywhere; to
 * look whether it would show something costs a ray. So a leaf that is closed, and larger than the finest of
 * size criteria, is probed once: the caller looks at some of its pixels. Where one tells of something that
 * the corners do not know, the leaf counts as too large after all. It is cut, and its children in turn, until
 * corners tell or they are as small as that; what is cut in vain is undone like any other cut for the sake of
 * size.
 *
 * It is done again when the leaf is seen larger than it was then. */
#include "cache/multi_mesh/displayed_internal.h"

void sl_displayed_judge_probes(const sl_displayed *d, sl_mesh_node *node, sl_screen_size size) {
    if (!(d->settings.probed_area > 0.0f) || !sl_all_edges_closed(node)) return;
    if (size.edge > sl_mesh_probed_size(node)) sl_mesh_set_minor(node, 0);
    if (size.area <= d->settings.probed_area && size.edge <= d->settings.probed_edge && !sl_mesh_minor(node))
        sl_mesh_set_probed_size(node, size.edge);
}

bool sl_displayed_wants_probes(const sl_displayed *d, const sl_mesh_place *leaf) {
    return sl_is_unprobed(d, &d->mesh->node[leaf->node]);
}

uint32_t sl_displayed_pixel(const sl_displayed *d, const sl_mesh_place *leaf, uint32_t i) {
    return d->first[leaf->node] + i;
}

/* Of leaves only those that are small enough and do not count as such. */
bool sl_displayed_is_contradicted(const sl_displayed *d, const sl_mesh_place *leaf) {
    const sl_mesh_node *node = &d->mesh->node[leaf->node];
    if (!(d->settings.probed_area > 0.0f) || (node->flags & SL_NODE_SMALL) || !d->pixels) return false;
    if (node->pixels <= d->settings.few_pixels) return true;
    sl_face_clip clip = sl_face_clip_of(d->mesh->primitives->scene, &d->pixels->view, leaf->face);
    return sl_displayed_meets_size(d, node, sl_displayed_size(d, &clip, leaf));
}

bool sl_displayed_below_contradicted(const sl_displayed *d, const sl_mesh_place *leaf) {
    if (!(d->settings.probed_area > 0.0f)) return false;
    for (uint32_t n = sl_mesh_parent(d->mesh, leaf->node); n != SL_NO_INDEX; n = sl_mesh_parent(d->mesh, n)) {
        if (d->mesh->node[n].flags & SL_NODE_SMALL) continue;
        sl_mesh_place place = sl_mesh_place_of(d->mesh, n);
        return sl_displayed_is_contradicted(d, &place); /* what is above it is larger */
    }
    return false;
}

void sl_displayed_probed(sl_displayed *d, const sl_mesh_place *leaf, bool contradicted,
                         sl_counters *counters) {
    sl_mesh_node *node = &d->mesh->node[leaf->node];
    if (!d->pixels || !sl_mesh_is_leaf(d->mesh, leaf->node)) return;
    node->flags &= ~(uint32_t)SL_NODE_TAKEN;
    /* its vertices are asked for once more, and its edges tested again */
    if (sl_is_unprobed(d, node) && contradicted) {
        node->flags &= ~(uint32_t)(SL_NODE_SMALL | SL_NODE_EDGES);
    } else if (sl_is_unprobed(d, node)) { /* and no neighbour has opened an edge in the meantime */
        sl_face_clip clip = sl_face_clip_of(d->mesh->primitives->scene, &d->pixels->view, leaf->face);
        sl_mesh_set_probed_size(node, sl_displayed_size(d, &clip, leaf).edge);
    }
    sl_displayed_close(d, leaf, counters);
}
