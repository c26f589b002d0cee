/* The table of vertices by their places, and the walk along an edge. */
#include "cache/patches/places.h"

#include "base/memory.h"

bool sl_place_table_resize(sl_place_table *t, size_t count) {
    uint32_t *slot = sl_allocate_unset(count, sizeof *slot);
    if (!slot) return false;
    memset(slot, 0xff, count * sizeof *slot); /* SL_NO_INDEX */
    sl_free(t->slot);
    t->slot = slot;
    t->count = count;
    return true;
}

/* Those that could have gone here, had it been empty, move up: no marks are left behind. */
void sl_place_table_empty(sl_place_table *t, size_t hole) {
    for (size_t slot = sl_slot_after(hole, t->count); t->slot[slot] != SL_NO_INDEX;
         slot = sl_slot_after(slot, t->count)) {
        size_t home = sl_place_home(t, sl_place_of_vertex(t, t->slot[slot]));
        bool between = hole < slot ? home > hole && home <= slot : home > hole || home <= slot;
        if (between) continue;
        t->slot[hole] = t->slot[slot];
        hole = slot;
    }
    t->slot[hole] = SL_NO_INDEX;
}

void sl_walk_hanging(sl_hanging_walk *w, sl_root_place from, sl_root_place to, uint32_t first,
                     uint32_t length) {
    uint32_t u = (uint32_t)from.u + to.u, v = (uint32_t)from.v + to.v;
    bool smallest = length < 2 || (u | v) % 2 != 0, further = true;
    if (smallest || w->count == w->room) return;
    sl_root_place middle = {from.root, (uint16_t)(u / 2), (uint16_t)(v / 2)};
    uint32_t vertex = w->find(w->tree, middle, &further);
    if (vertex == SL_NO_INDEX) return;
    if (further) sl_walk_hanging(w, from, middle, first, length / 2);
    if (w->count == w->room) return;
    if (w->at) w->at[w->count] = (uint16_t)(first + length / 2);
    w->vertex[w->count++] = vertex;
    if (further) sl_walk_hanging(w, middle, to, first + length / 2, length / 2);
}
