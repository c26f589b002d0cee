/* Vertices of patches: found by the place that stands for all that share it (sl_root_canonical()), in a hash
 * table with linear probing, and counted by the splits and roots that asked for them. */
#include <string.h>

#include "base/error.h"
#include "base/grow.h"
#include "base/memory.h"
#include "cache/patches/patch_parts.h"

/* ---- the table ------------------------------------------------------------------------------- */

bool sl_empty_slots(uint32_t **table, size_t *slots, size_t count) {
    uint32_t *slot = sl_allocate_unset(count, sizeof *slot);
    if (!slot) return false;
    memset(slot, 0xff, count * sizeof *slot); /* SL_NO_INDEX */
    sl_free(*table);
    *table = slot;
    *slots = count;
    return true;
}

static size_t home_of(const sl_patches *p, sl_root_place place) {
    uint64_t bits = (uint64_t)place.root << 32 | (uint64_t)place.u << 16 | place.v;
    return sl_slot_of_hash(sl_hash64(bits), p->slots);
}

/* Returns the slot of the vertex at a place, or the empty one where it would go. */
static size_t slot_of(const sl_patches *p, sl_root_place place) {
    size_t slot = home_of(p, place);
    for (; p->slot[slot] != SL_NO_INDEX; slot = sl_slot_after(slot, p->slots)) {
        const sl_patch_vertex *other = &p->vertex[p->slot[slot]];
        if (other->root == place.root && other->u == place.u && other->v == place.v) break;
    }
    return slot;
}

/* Moves up those that could have gone here, had it been empty: no marks are left behind. */
static void empty_slot(sl_patches *p, size_t hole) {
    for (size_t slot = sl_slot_after(hole, p->slots); p->slot[slot] != SL_NO_INDEX;
         slot = sl_slot_after(slot, p->slots)) {
        size_t home = home_of(p, p->vertex[p->slot[slot]].place);
        bool between = hole < slot ? home > hole && home <= slot : home > hole || home <= slot;
        if (between) continue;
        p->slot[hole] = p->slot[slot];
        hole = slot;
    }
    p->slot[hole] = SL_NO_INDEX;
}

/* ---- vertices -------------------------------------------------------------------------------- */

static bool reserve_slots(sl_patches *p, size_t vertices) {
    if (5 * vertices <= 4 * p->slots) return true;
    size_t count = vertices + vertices / 4 + vertices / 2 + 16;
    if (count >= SL_NO_INDEX || !sl_empty_slots(&p->slot, &p->slots, count)) return false;
    for (size_t i = 0; i < p->vertex_count; i++)
        if (p->vertex[i].references) p->slot[slot_of(p, p->vertex[i].place)] = (uint32_t)i;
    return true;
}

static bool reserve_numbers(sl_patches *p, size_t count) {
    size_t had = p->vertex_count, capacity = sl_patches_room(p->vertex_capacity, had + count);
    if (had + count <= p->vertex_capacity) return true;
    if (capacity >= SL_NO_INDEX || !sl_regrow(&p->vertex, had, capacity, sizeof *p->vertex) ||
        !sl_regrow(&p->value, had, capacity, (size_t)p->settings.channels * sizeof *p->value) ||
        (p->sets && !sl_regrow(&p->sets, had, capacity, sizeof *p->sets)))
        return false;
    p->vertex_capacity = capacity;
    return true;
}

sl_status sl_vertices_reserve(sl_patches *p, size_t count, sl_error *error) {
    bool done = reserve_slots(p, p->vertices_alive + count) && reserve_numbers(p, count);
    return done ? SL_OK : sl_fail_memory(error, "vertices of patches");
}

uint32_t sl_vertex_find(const sl_patches *p, sl_root_place place) {
    return p->slot[slot_of(p, sl_root_canonical(p->primitives, place))];
}

uint32_t sl_vertex_take(sl_patches *p, sl_root_place place) {
    place = sl_root_canonical(p->primitives, place);
    size_t slot = slot_of(p, place);
    if (p->slot[slot] != SL_NO_INDEX) {
        sl_patch_vertex *found = &p->vertex[p->slot[slot]];
        if (found->references < SL_REFERENCES_MANY) found->references++;
        return p->slot[slot];
    }
    uint32_t made = p->first_free_vertex;
    if (made == SL_NO_INDEX) made = (uint32_t)p->vertex_count++;
    else p->first_free_vertex = p->vertex[made].root;
    p->vertex[made] = (sl_patch_vertex){.place = place, .references = 1, .evaluated = SL_VERTEX_NEVER};
    memset(sl_vertex_value(p, made), 0, (size_t)p->settings.channels * sizeof *p->value);
    if (p->sets) p->sets[made] = (sl_vertex_sets){0};
    p->vertices_alive++;
    p->slot[slot] = made;
    return made;
}

uint32_t sl_vertex_make(sl_patches *p, sl_root_place place, sl_status *status, sl_error *error) {
    *status = sl_vertices_reserve(p, 1, error);
    if (*status != SL_OK) return SL_NO_INDEX;
    uint32_t vertex = sl_vertex_take(p, place);
    p->vertex[vertex].references = SL_REFERENCES_MANY;
    return vertex;
}

/* Vertices that are not in use have no references and name the next one in `root`. */
void sl_vertex_release(sl_patches *p, uint32_t vertex) {
    sl_patch_vertex *v = &p->vertex[vertex];
    if (v->references == SL_REFERENCES_MANY || --v->references) return;
    empty_slot(p, slot_of(p, v->place));
    *v = (sl_patch_vertex){.root = p->first_free_vertex, .evaluated = SL_VERTEX_NEVER};
    p->first_free_vertex = vertex;
    p->vertices_alive--;
}
