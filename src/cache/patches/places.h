/* What all vertices have in common: the place that stands for all that share them, by which they are found,
 * and how they hang on leaves' edges.
 *
 * The table is a hash with linear probing over an array of vertices that begin with their place. It has any
 * number of slots, not a power of two: less is left empty. */
#ifndef SL_PATCHES_PLACES_H
#define SL_PATCHES_PLACES_H

#include <string.h>

#include "base/random.h"
#include "cache/patches/primitives.h"

typedef struct sl_place_table {
    uint32_t *slot;            /* index of a vertex, or SL_NO_INDEX */
    size_t count;
    const void *vertex;        /* the array as it stands, */
    size_t stride;             /* ... bytes of an element */
} sl_place_table;

static inline sl_root_place sl_place_of_vertex(const sl_place_table *t, uint32_t vertex) {
    sl_root_place place;
    memcpy(&place, (const char *)t->vertex + vertex * t->stride, sizeof place);
    return place;
}
static inline size_t sl_slot_of_hash(uint64_t hash, size_t slots) {
    return (size_t)((hash >> 32) * slots >> 32);
}
static inline size_t sl_slot_after(size_t slot, size_t slots) { return slot + 1 < slots ? slot + 1 : 0; }
static inline size_t sl_place_home(const sl_place_table *t, sl_root_place place) {
    uint64_t bits = (uint64_t)place.root << 32 | (uint64_t)place.u << 16 | place.v;
    return sl_slot_of_hash(sl_hash64(bits), t->count);
}
/* Returns the slot of the vertex at a place, or the empty one where it would go. */
static inline size_t sl_place_slot(const sl_place_table *t, sl_root_place place) {
    size_t slot = sl_place_home(t, place);
    for (; t->slot[slot] != SL_NO_INDEX; slot = sl_slot_after(slot, t->count)) {
        sl_root_place other = sl_place_of_vertex(t, t->slot[slot]);
        if (other.root == place.root && other.u == place.u && other.v == place.v) break;
    }
    return slot;
}
/* So many slots, all empty. False: memory ended, and nothing has changed. */
bool sl_place_table_resize(sl_place_table *table, size_t count);
void sl_place_table_empty(sl_place_table *table, size_t slot);

/* Vertices that hang on an edge: finer leaves beside it have its middle for a corner, and only then may they
 * have the middles of its halves. */
typedef struct sl_hanging_walk {
    const void *tree;
    /* The vertex that hangs at a place of a root; SL_NO_INDEX: none. *further: any may on the halves. */
    uint32_t (*find)(const void *tree, sl_root_place place, bool *further);
    uint32_t *vertex;
    uint16_t *at;              /* where along the edge; NULL: not wanted */
    size_t count, room;
} sl_hanging_walk;
/* Lists those between two places of one root, in order; the edge has 2^n parts, of which these are `length`
 * from `first` on. */
void sl_walk_hanging(sl_hanging_walk *walk, sl_root_place from, sl_root_place to, uint32_t first,
                     uint32_t length);

#endif
