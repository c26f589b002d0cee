/* Between patches.c, patch_vertices.c and patch_around.c. */
#pragma once

#include "base/random.h"
#include "cache/patches/patches.h"

/* Returns the room of larger lists: a sixteenth more than before, as what is allocated and not used counts,
 * too. */
static inline size_t sl_patches_room(size_t capacity, size_t wanted) {
    size_t more = capacity + capacity / 16 + 32;
    return more > wanted ? more : wanted;
}
/* Tables of hashes have any number of slots, not a power of two. */
static inline size_t sl_slot_of_hash(uint64_t hash, size_t slots) {
    return (size_t)((hash >> 32) * slots >> 32);
}
static inline size_t sl_slot_after(size_t slot, size_t slots) { return slot + 1 < slots ? slot + 1 : 0; }
/* Puts a table of so many slots, all empty, in place of one. False: memory ended, and nothing has changed. */
bool sl_empty_slots(uint32_t **table, size_t *slots, size_t count);

/* Makes room for so many more vertices; only this can fail. */
sl_status sl_vertices_reserve(sl_patches *patches, size_t count, sl_error *error);
/* Returns the vertex at a place, made where there is none, with one reference more. */
uint32_t sl_vertex_take(sl_patches *patches, sl_root_place place);
/* Returns the pixels of the children seen last, and gives when that was. */
static inline uint32_t sl_pixels_of_children(const sl_patches *p, uint32_t first, uint32_t *latest) {
    uint32_t pixels = 0;
    *latest = 0;
    for (uint32_t k = 0; k < 4; k++) {
        const sl_patch *child = &p->patch[first + k];
        if (child->seen > *latest) *latest = child->seen, pixels = 0;
        if (child->seen == *latest) pixels += child->pixels;
    }
    return pixels;
}

/* Takes one reference away; with the last the vertex is gone. */
void sl_vertex_release(sl_patches *patches, uint32_t vertex);
