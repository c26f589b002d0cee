/* Vertices of patches: found by the place that stands for all that share it (sl_root_canonical()), in a hash
 * table with linear probing, and counted by the splits and roots that asked for them. */
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/patches/dyadic.h"
#include "cache/patches/patch_parts.h"

/* ---- the table ------------------------------------------------------------------------------- */

static size_t home_of(const sl_patches *p, sl_root_place place) {
    uint64_t hash = sl_hash64((uint64_t)place.root << 32 | (uint64_t)place.u << 16 | place.v);
    return sl_slot_of_hash(hash, p->slot_count);
}

/* The slot of the vertex at a place, or the empty one where it would go. */
static size_t slot_of(const sl_patches *p, sl_root_place place) {
    size_t slot = home_of(p, place);
    for (;; slot = sl_slot_after(slot, p->slot_count)) {
        if (p->slot[slot] == SL_NO_INDEX) return slot;
        const sl_patch_vertex *v = &p->vertex[p->slot[slot]];
        if (v->root == place.root && v->u == place.u && v->v == place.v) return slot;
    }
}

static sl_status reserve_slots(sl_patches *p, size_t vertices, sl_error *error) {
    if (5 * vertices <= 4 * p->slot_count) return SL_OK;
    size_t count = vertices + vertices / 4 + vertices / 24 + 64;
    if (count >= SL_NO_INDEX) return sl_fail(error, SL_ERROR_RESOURCES, "too many vertices of patches");
    uint32_t *slot = sl_allocate_unset(count, sizeof *slot);
    if (!slot) return sl_fail_memory(error, "vertices of patches");
    memset(slot, 0xff, count * sizeof *slot); /* SL_NO_INDEX */
    sl_free(p->slot);
    p->slot = slot;
    p->slot_count = count;
    for (size_t i = 0; i < p->vertex_count; i++) {
        if (p->vertex[i].references) p->slot[slot_of(p, sl_vertex_place(&p->vertex[i]))] = (uint32_t)i;
    }
    return SL_OK;
}

/* Those that could have gone here, had it been empty, move up: no marks are left behind. */
static void empty_slot(sl_patches *p, size_t hole) {
    for (size_t slot = sl_slot_after(hole, p->slot_count); p->slot[slot] != SL_NO_INDEX;
         slot = sl_slot_after(slot, p->slot_count)) {
        size_t home = home_of(p, sl_vertex_place(&p->vertex[p->slot[slot]]));
        bool between = hole < slot ? home > hole && home <= slot : home > hole || home <= slot;
        if (between) continue;
        p->slot[hole] = p->slot[slot];
        hole = slot;
    }
    p->slot[hole] = SL_NO_INDEX;
}

/* ---- vertices -------------------------------------------------------------------------------- */

static bool has_lobe(const sl_patches *p, uint32_t root) {
    return p->lobes && sl_material_has_lobe(sl_root_material(p->primitives, root));
}

static sl_status reserve_numbers(sl_patches *p, size_t count, sl_error *error) {
    if (p->vertex_count + count <= p->vertex_capacity) return SL_OK;
    size_t had = p->vertex_count, capacity = sl_patches_room(p->vertex_capacity, had + count);
    capacity = (capacity + SL_VERTEX_GROUP - 1) / SL_VERTEX_GROUP * SL_VERTEX_GROUP;
    if (capacity >= SL_NO_INDEX) return sl_fail(error, SL_ERROR_RESOURCES, "too many vertices of patches");
    size_t group = sizeof *p->lobe_group, groups = SL_VERTEX_GROUP;
    sl_growing all[3] = {{(void **)&p->vertex, had * sizeof *p->vertex, capacity * sizeof *p->vertex, NULL}};
    int arrays = 1;
    if (p->sets)
        all[arrays++] =
            (sl_growing){(void **)&p->sets, had * sizeof *p->sets, capacity * sizeof *p->sets, NULL};
    if (p->lobes)
        all[arrays++] =
            (sl_growing){(void **)&p->lobe_group, had / groups * group, capacity / groups * group, NULL};
    sl_status status = sl_patches_enlarge(all, arrays, error);
    if (status == SL_OK) p->vertex_capacity = capacity;
    return status;
}

static sl_status reserve_lobes(sl_patches *p, sl_error *error) {
    size_t wanted = p->lobe_count + SL_VERTEX_GROUP, capacity = sl_patches_room(p->lobe_capacity, wanted),
           size = sizeof *p->lobe;
    if (wanted <= p->lobe_capacity) return SL_OK;
    sl_growing all[] = {{(void **)&p->lobe, p->lobe_count * size, capacity * size, NULL}};
    sl_status status = sl_patches_enlarge(all, 1, error);
    if (status == SL_OK) p->lobe_capacity = capacity;
    return status;
}

sl_status sl_vertices_reserve(sl_patches *p, uint32_t root, size_t count, sl_error *error) {
    bool lobe = has_lobe(p, root);
    sl_status status = reserve_slots(p, p->vertices_alive + count, error);
    if (status != SL_OK || p->free_vertices[lobe] >= count) return status;
    if (lobe) status = reserve_lobes(p, error);
    return status == SL_OK
               ? reserve_numbers(p, p->lobes ? SL_VERTEX_GROUP : count - p->free_vertices[0], error)
               : status;
}

uint32_t sl_vertex_find(const sl_patches *p, sl_root_place place) {
    return p->slot[slot_of(p, sl_root_canonical(p->primitives, place))];
}

/* Vertices that are not in use have no references and name the next one in `root`. */
static void put_aside(sl_patches *p, uint32_t vertex, bool lobe) {
    p->vertex[vertex] = (sl_patch_vertex){.root = p->first_free_vertex[lobe], .evaluated = SL_VERTEX_NEVER};
    p->first_free_vertex[lobe] = vertex;
    p->free_vertices[lobe]++;
}

/* Where no lobes are kept a group is one. */
static void begin_group(sl_patches *p, bool lobe) {
    uint32_t first = (uint32_t)p->vertex_count, count = p->lobes ? SL_VERTEX_GROUP : 1;
    for (uint32_t k = count; k-- > 0;) put_aside(p, first + k, lobe);
    p->vertex_count += count;
    if (!p->lobes) return;
    p->lobe_group[first / SL_VERTEX_GROUP] = lobe ? (uint32_t)(p->lobe_count / SL_VERTEX_GROUP) : SL_NO_INDEX;
    p->lobe_count += lobe ? SL_VERTEX_GROUP : 0;
}

static uint32_t unused_vertex(sl_patches *p, bool lobe) {
    if (p->free_vertices[lobe] == 0) begin_group(p, lobe);
    uint32_t made = p->first_free_vertex[lobe];
    p->first_free_vertex[lobe] = p->vertex[made].root;
    p->free_vertices[lobe]--;
    return made;
}

uint32_t sl_vertex_take(sl_patches *p, sl_root_place place, bool *created) {
    place = sl_root_canonical(p->primitives, place);
    size_t slot = slot_of(p, place);
    if (p->slot[slot] != SL_NO_INDEX) {
        sl_patch_vertex *found = &p->vertex[p->slot[slot]];
        if (found->references < SL_REFERENCES_MANY) found->references++;
        return p->slot[slot];
    }
    uint32_t made = unused_vertex(p, has_lobe(p, place.root));
    enum { BITS = 2 * SL_PATCH_DYADIC - 1 };
    p->vertex[made] = (sl_patch_vertex){.root = place.root,
                                        .u = place.u & (unsigned)BITS,
                                        .v = place.v & (unsigned)BITS,
                                        .references = 1,
                                        .evaluated = SL_VERTEX_NEVER};
    float *lobe = sl_vertex_lobe(p, made);
    if (lobe) memset(lobe, 0, sizeof *p->lobe);
    if (p->sets) p->sets[made] = (sl_vertex_sets){0};
    p->vertices_alive++;
    p->slot[slot] = made;
    *created = true;
    return made;
}

bool sl_vertex_release(sl_patches *p, uint32_t vertex) {
    sl_patch_vertex *v = &p->vertex[vertex];
    if (v->references == SL_REFERENCES_MANY || --v->references) return false;
    empty_slot(p, slot_of(p, sl_vertex_place(v)));
    put_aside(p, vertex, sl_vertex_lobe(p, vertex) != NULL);
    p->vertices_alive--;
    return true;
}
