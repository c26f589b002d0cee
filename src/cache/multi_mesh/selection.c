/* Which leaf is served next. A binary heap over the roots in view has the one of highest priority on top, and
 * the leaf is found by following the largest of the children's priorities. Or the paper's chain: it stays at
 * a root and moves to another, drawn at random, if that one has more. The chain chooses worse than the heap
 * at first, when quick pictures matter most; it is the paper's way, and cheaper per step only where thousands
 * of roots are in view. */
#include "cache/multi_mesh/displayed_internal.h"

#include "base/random.h"

/* ---- the heap ---- */

static float priority_of(const sl_displayed *d, uint32_t entry) {
    return d->mesh->node[sl_displayed_root(d, entry)].priority;
}

/* Entries are in the order of faces. */
static bool comes_first(const sl_displayed *d, uint32_t a, uint32_t b) {
    float pa = priority_of(d, a), pb = priority_of(d, b);
    return pa > pb || (pa == pb && a < b);
}

static void put(sl_displayed *d, size_t at, uint32_t entry) {
    d->heap[at] = entry;
    d->heap_place[entry] = (uint32_t)at;
}

static void sink(sl_displayed *d, size_t at) {
    uint32_t entry = d->heap[at];
    for (size_t child; (child = 2 * at + 1) < d->heap_count; at = child) {
        if (child + 1 < d->heap_count && comes_first(d, d->heap[child + 1], d->heap[child])) child++;
        if (!comes_first(d, d->heap[child], entry)) break;
        put(d, at, d->heap[child]);
    }
    put(d, at, entry);
}

static void rise(sl_displayed *d, size_t at) {
    uint32_t entry = d->heap[at];
    for (; at > 0 && comes_first(d, entry, d->heap[(at - 1) / 2]); at = (at - 1) / 2)
        put(d, at, d->heap[(at - 1) / 2]);
    put(d, at, entry);
}

void sl_displayed_heap_build(sl_displayed *d) {
    d->heap_count = 0;
    for (uint32_t e = 0; e < d->pixels->face_count; e++) {
        if (sl_displayed_wants(d, e)) put(d, d->heap_count++, e);
    }
    for (size_t at = d->heap_count / 2; at-- > 0;) sink(d, at);
}

void sl_displayed_heap_update(sl_displayed *d, uint32_t entry) {
    rise(d, d->heap_place[entry]);
    sink(d, d->heap_place[entry]);
}

float sl_displayed_priority(const sl_displayed *d) {
    return d->heap_count ? priority_of(d, d->heap[0]) : 0.0f;
}

/* ---- the paper's chain ---- */

static uint32_t random_entry(sl_displayed *d) {
    uint64_t bits =
        sl_random_bits(sl_random_key(d->settings.seed, (uint64_t)d->settings.component), d->chain_draws++);
    return d->heap[(size_t)(bits * d->heap_count >> 32)];
}

/* Each step draws one root and moves there if its priority is higher. Where nothing is left at the current
 * one it goes on drawing; after as many failures as twice the number of roots it looks at all of them. */
static uint32_t next_of_chain(sl_displayed *d) {
    uint32_t current = d->chain_entry == SL_NO_INDEX ? d->heap[0] : d->chain_entry;
    size_t failures = 0;
    do {
        uint32_t drawn = random_entry(d);
        if (priority_of(d, drawn) > priority_of(d, current)) current = drawn;
    } while (priority_of(d, current) <= 0.0f && ++failures < 2 * d->heap_count);
    return d->chain_entry = priority_of(d, current) > 0.0f ? current : d->heap[0];
}

/* ---- what both share ---- */

/* The leaf of highest priority below a root, the first of equals. */
static sl_mesh_place best_leaf(const sl_displayed *d, uint32_t face) {
    const sl_mesh *mesh = d->mesh;
    sl_mesh_place place = sl_mesh_root_place(mesh, face);
    while (!sl_mesh_is_leaf(mesh, place.node)) {
        const sl_mesh_node *child = &mesh->node[mesh->node[place.node].child];
        int best = 0;
        for (int c = 1; c < 4; c++) best = child[c].priority > child[best].priority ? c : best;
        place = sl_mesh_child_place(mesh, &place, best);
    }
    return place;
}

sl_mesh_place sl_displayed_take(sl_displayed *d) {
    sl_mesh_place none = {.node = SL_NO_INDEX, .face = SL_NO_INDEX};
    if (!(sl_displayed_priority(d) > 0.0f)) return none;
    uint32_t entry = d->settings.selection == SL_SELECT_CHAIN ? next_of_chain(d) : d->heap[0];
    sl_mesh_place leaf = best_leaf(d, d->pixels->face[entry].face);
    d->mesh->node[leaf.node].flags |= SL_NODE_TAKEN;
    d->mesh->node[leaf.node].priority = 0.0f;
    sl_displayed_raise(d, leaf.face, leaf.node);
    return leaf;
}
