/* The map as a histogram: each voxel counts the photons that lie in it, as in the paper's figure 16a. Where a
 * voxel clips a sliver of a plane it counts few, and such voxels make bands; the k nearest about the centroid
 * do not know what a voxel clips. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/light_octree/voxel_work.h"

static uint32_t leaf_of(const sl_octree *octree, const sl_photon *p) {
    sl_vec3 at = sl_v3(p->position[0], p->position[1], p->position[2]);
    const sl_octree_root root = {octree->origin, octree->edge};
    return sl_octree_root_holds(&root, at) ? sl_octree_find(octree, sl_octree_morton_at(octree, at))
                                           : SL_NO_INDEX;
}

void sl_own_photons_release(sl_own_photons *own) {
    sl_free(own->first);
    sl_free(own->place);
    *own = (sl_own_photons){NULL, NULL, 0};
}

/* Counting sort by leaf, in order of ids. */
sl_status sl_own_photons_find(const sl_octree *octree, const sl_photon_tree *tree, sl_own_photons *own,
                              sl_error *error) {
    const sl_photon_list *list = sl_photon_tree_list(tree);
    size_t leaves = octree->leaf_count;
    uint32_t *leaf = sl_allocate(list->count, sizeof *leaf), *by_id = sl_allocate(list->count, sizeof *by_id);
    own->first = sl_allocate(leaves + 2, sizeof *own->first);
    own->place = sl_allocate(list->count, sizeof *own->place);
    bool good = leaf && by_id && own->first && own->place;
    for (size_t i = 0; good && i < list->count; i++) by_id[sl_photon_tree_id(tree, i)] = (uint32_t)i;
    for (size_t id = 0; good && id < list->count; id++) {
        leaf[id] = leaf_of(octree, &list->photon[by_id[id]]);
        if (leaf[id] != SL_NO_INDEX) own->first[leaf[id] + 2]++; /* else rounding has put it outside */
    }
    for (size_t i = 0; good && i < leaves; i++) {
        own->most = own->first[i + 2] > own->most ? own->first[i + 2] : own->most;
        own->first[i + 2] += own->first[i + 1];
    }
    for (size_t id = 0; good && id < list->count; id++) {
        if (leaf[id] != SL_NO_INDEX) own->place[own->first[leaf[id] + 1]++] = by_id[id];
    }
    sl_free(leaf);
    sl_free(by_id);
    if (!good) sl_own_photons_release(own);
    return good ? SL_OK : sl_fail_memory(error, "the photons of voxels");
}
