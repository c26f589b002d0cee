/* Vertices of patches: found by the place that stands for all that share it (sl_root_canonical()), in a hash table with linear probing, and
 * counted by the splits and roots that asked for them. */
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/shading_cache/patch_parts.h"

enum { COUNTED_UP_TO = UINT16_MAX }; /* a vertex that so many asked for stays for good */

/* ---- the table ---------------------------------------------------------------------------------------------------------------- */

static size_t home_of(const sl_patches *p, sl_root_place place) {
    uint64_t hash = sl_hash64((uint64_t)place.root << 32 | (uint64_t)place.u << 16 | place.v);
    return (size_t)((hash >> 32) * p->slot_count >> 32); /* any number of slots, not a power of two: less is left empty */
}

static sl_root_place place_of(const sl_patch_vertex *v) { return (sl_root_place){v->root, v->u, v->v}; }

static size_t after(const sl_patches *p, size_t slot) { return slot + 1 < p->slot_count ? slot + 1 : 0; }

/* The slot of the vertex at a place, or the empty one where it would go. */
static size_t slot_of(const sl_patches *p, sl_root_place place) {
    size_t slot = home_of(p, place);
    for (;; slot = after(p, slot)) {
        if (p->slot[slot] == SL_NO_INDEX) return slot;
        const sl_patch_vertex *v = &p->vertex[p->slot[slot]];
        if (v->root == place.root && v->u == place.u && v->v == place.v) return slot;
    }
}

static sl_status reserve_slots(sl_patches *p, size_t vertices, sl_error *error) {
    if (5 * vertices <= 4 * p->slot_count) return SL_OK;
    size_t count = vertices + vertices / 4 + vertices / 12 + 64;
    if (count >= SL_NO_INDEX) return sl_fail(error, SL_ERROR_RESOURCES, "too many vertices of patches");
    uint32_t *slot = sl_allocate_unset(count, sizeof *slot);
    if (!slot) return sl_fail_memory(error, "vertices of patches");
    memset(slot, 0xff, count * sizeof *slot); /* SL_NO_INDEX */
    sl_free(p->slot);
    p->slot = slot;
    p->slot_count = count;
    for (size_t i = 0; i < p->vertex_count; i++) {
        if (p->vertex[i].references) p->slot[slot_of(p, place_of(&p->vertex[i]))] = (uint32_t)i;
    }
    return SL_OK;
}

/* Those that could have gone here, had it been empty, move up: no marks are left behind. */
static void empty_slot(sl_patches *p, size_t hole) {
    for (size_t slot = after(p, hole); p->slot[slot] != SL_NO_INDEX; slot = after(p, slot)) {
        size_t home = home_of(p, place_of(&p->vertex[p->slot[slot]]));
        bool between = hole < slot ? home > hole && home <= slot : home > hole || home <= slot;
        if (between) continue;
        p->slot[hole] = p->slot[slot];
        hole = slot;
    }
    p->slot[hole] = SL_NO_INDEX;
}

/* ---- vertices ----------------------------------------------------------------------------------------------------------------- */

/* Vertices that are not in use have no references and name the next one in `root`. */
sl_status sl_vertices_reserve(sl_patches *p, size_t count, sl_error *error) {
    sl_status status = reserve_slots(p, p->vertices_alive + count, error);
    size_t unused = p->vertex_count - p->vertices_alive;
    if (status != SL_OK || unused + (p->vertex_capacity - p->vertex_count) >= count) return status;
    size_t capacity = sl_patches_room(p->vertex_capacity, p->vertices_alive + count);
    if (capacity >= SL_NO_INDEX) return sl_fail(error, SL_ERROR_RESOURCES, "too many vertices of patches");
    sl_patch_vertex *vertex = sl_allocate_unset(capacity, sizeof *vertex);
    float(*radiance)[3] = p->radiance ? sl_allocate_unset(capacity, sizeof *radiance) : NULL;
    if (!vertex || (p->radiance && !radiance)) {
        sl_free(vertex);
        sl_free(radiance);
        return sl_fail_memory(error, "vertices of patches");
    }
    if (p->vertex_count) memcpy(vertex, p->vertex, p->vertex_count * sizeof *vertex);
    if (radiance && p->vertex_count) memcpy(radiance, p->radiance, p->vertex_count * sizeof *radiance);
    sl_free(p->vertex);
    sl_free(p->radiance);
    p->vertex = vertex;
    p->radiance = radiance;
    p->vertex_capacity = capacity;
    return SL_OK;
}

uint32_t sl_vertex_find(const sl_patches *p, sl_root_place place) {
    return p->slot[slot_of(p, sl_root_canonical(p->primitives, place))];
}

static uint32_t unused_vertex(sl_patches *p) {
    uint32_t made = p->first_free_vertex;
    if (made == SL_NO_INDEX) return (uint32_t)p->vertex_count++;
    p->first_free_vertex = p->vertex[made].root;
    return made;
}

uint32_t sl_vertex_take(sl_patches *p, sl_root_place place, bool *created) {
    place = sl_root_canonical(p->primitives, place);
    size_t slot = slot_of(p, place);
    if (p->slot[slot] != SL_NO_INDEX) {
        sl_patch_vertex *found = &p->vertex[p->slot[slot]];
        if (found->references < COUNTED_UP_TO) found->references++;
        return p->slot[slot];
    }
    uint32_t made = unused_vertex(p);
    p->vertex[made] = (sl_patch_vertex){.root = place.root, .u = place.u, .v = place.v, .evaluated = SL_VERTEX_NEVER, .references = 1};
    if (p->radiance) memset(p->radiance[made], 0, sizeof p->radiance[made]);
    p->vertices_alive++;
    p->slot[slot] = made;
    *created = true;
    return made;
}

bool sl_vertex_release(sl_patches *p, uint32_t vertex) {
    sl_patch_vertex *v = &p->vertex[vertex];
    if (v->references == COUNTED_UP_TO || --v->references) return false;
    empty_slot(p, slot_of(p, place_of(v)));
    *v = (sl_patch_vertex){.root = p->first_free_vertex, .evaluated = SL_VERTEX_NEVER};
    p->first_free_vertex = vertex;
    p->vertices_alive--;
    return true;
}
