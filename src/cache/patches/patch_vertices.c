/* Vertices of patches: found by the place that stands for all that share it (sl_root_canonical()), in a hash
 * table with linear probing, and counted by the splits and roots that asked for them. */
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "cache/patches/patch_parts.h"

/* ---- the table ------------------------------------------------------------------------------- */

static sl_status reserve_slots(sl_patches *p, size_t vertices, sl_error *error) {
    if (5 * vertices <= 4 * p->table.count) return SL_OK;
    size_t count = vertices + vertices / 4 + vertices / 24 + 64;
    if (count >= SL_NO_INDEX) return sl_fail(error, SL_ERROR_RESOURCES, "too many vertices of patches");
    if (!sl_place_table_resize(&p->table, count)) return sl_fail_memory(error, "vertices of patches");
    for (size_t i = 0; i < p->vertex_count; i++) {
        if (p->vertex[i].references)
            p->table.slot[sl_place_slot(&p->table, p->vertex[i].place)] = (uint32_t)i;
    }
    return SL_OK;
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
    p->table.vertex = p->vertex;
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
    return p->table.slot[sl_place_slot(&p->table, sl_root_canonical(p->primitives, place))];
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
    size_t slot = sl_place_slot(&p->table, place);
    if (p->table.slot[slot] != SL_NO_INDEX) {
        sl_patch_vertex *found = &p->vertex[p->table.slot[slot]];
        if (found->references < SL_REFERENCES_MANY) found->references++;
        return p->table.slot[slot];
    }
    uint32_t made = unused_vertex(p, has_lobe(p, place.root));
    p->vertex[made] = (sl_patch_vertex){.place = place, .references = 1, .evaluated = SL_VERTEX_NEVER};
    float *lobe = sl_vertex_lobe(p, made);
    if (lobe) memset(lobe, 0, sizeof *p->lobe);
    if (p->sets) p->sets[made] = (sl_vertex_sets){0};
    p->vertices_alive++;
    p->table.slot[slot] = made;
    *created = true;
    return made;
}

bool sl_vertex_release(sl_patches *p, uint32_t vertex) {
    sl_patch_vertex *v = &p->vertex[vertex];
    if (v->references == SL_REFERENCES_MANY || --v->references) return false;
    sl_place_table_empty(&p->table, sl_place_slot(&p->table, v->place));
    put_aside(p, vertex, sl_vertex_lobe(p, vertex) != NULL);
    p->vertices_alive--;
    return true;
}
