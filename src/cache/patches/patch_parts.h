/* Between patches.c, patch_vertices.c, patch_around.c and patch_evict.c; the display finds vertices by it,
 * too. */
#ifndef SL_PATCHES_PATCH_PARTS_H
#define SL_PATCHES_PATCH_PARTS_H

#include "cache/patches/patches.h"

/* Larger lists with room for `wanted` entries: a 128th more than before, as what is allocated and not used
 * counts, too. */
static inline size_t sl_patches_room(size_t capacity, size_t wanted) {
    size_t more = capacity + capacity / 128 + 32;
    return more > wanted ? more : wanted;
}

/* patches.c: copies `used` bytes of each array into a larger one; nothing is changed where one of them cannot
 * be had. */
typedef struct sl_growing {
    void **array;
    size_t used, room; /* bytes */
    void *larger;
} sl_growing;
sl_status sl_patches_enlarge(sl_growing *all, int count, sl_error *error);

/* Room for so many more vertices of a root, at most SL_VERTEX_GROUP; only this can fail. */
sl_status sl_vertices_reserve(sl_patches *patches, uint32_t root, size_t count, sl_error *error);
/* Returns the vertex at a place, or SL_NO_INDEX. */
uint32_t sl_vertex_find(const sl_patches *patches, sl_root_place place);
/* Returns the same, made where there is none, with one reference more. *created is set where it is new. */
uint32_t sl_vertex_take(sl_patches *patches, sl_root_place place, bool *created);
/* One reference less; true: it was the last, and the vertex is gone. */
bool sl_vertex_release(sl_patches *patches, uint32_t vertex);

/* All leaves around a place of a root, of all roots that meet there; one may come twice. */
typedef void sl_leaf_visitor(sl_patches *patches, const sl_patch_place *leaf, void *context);
void sl_patches_visit_around(sl_patches *patches, sl_root_place place, sl_leaf_visitor *visit, void *context);
/* Marks as SL_PATCH_DIRTY the leaves around a place of a root, and of all roots that meet there. */
void sl_patches_touch_place(sl_patches *patches, sl_root_place place);

#endif
