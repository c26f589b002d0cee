/* Eviction: children go that were not seen within the window, or whose parent covers less than a pixel; those
 * first that have not been seen for longest, and from the leaves up, so that what remains is always a tree.
 */
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "cache/patches/patches.h"

/* A patch that can lose its children, all of them leaves. */
typedef struct candidate {
    uint32_t seen, patch;
} candidate;

typedef struct heap {
    candidate *entry;
    size_t count;
} heap;

static bool goes_before(candidate a, candidate b) {
    return a.seen != b.seen ? a.seen < b.seen : a.patch < b.patch;
}

static void put(heap *h, candidate new) {
    size_t at = h->count++;
    for (; at > 0 && goes_before(new, h->entry[(at - 1) / 2]); at = (at - 1) / 2)
        h->entry[at] = h->entry[(at - 1) / 2];
    h->entry[at] = new;
}

static candidate take_first(heap *h) {
    candidate first = h->entry[0], last = h->entry[--h->count];
    size_t at = 0;
    for (size_t child; (child = 2 * at + 1) < h->count; at = child) {
        if (child + 1 < h->count && goes_before(h->entry[child + 1], h->entry[child])) child++;
        if (!goes_before(h->entry[child], last)) break;
        h->entry[at] = h->entry[child];
    }
    h->entry[at] = last;
    return first;
}

/* Tells whether a patch has four leaves for children that may go. Pixels are those of the children seen last.
 */
static bool may_lose_children(const sl_patches *p, uint32_t patch, uint32_t since, double small,
                              candidate *found) {
    uint32_t first = p->patch[patch].child, latest = 0, pixels = 0;
    if (first == SL_NO_INDEX) return false;
    for (uint32_t k = 0; k < 4; k++) {
        const sl_patch *child = &p->patch[first + k];
        if (child->child != SL_NO_INDEX) return false;
        if (child->seen > latest) latest = child->seen, pixels = 0;
        if (child->seen == latest) pixels += child->pixels;
    }
    *found = (candidate){latest, patch};
    return latest < since || (double)pixels < small;
}

sl_status sl_patches_evict(sl_patches *p, size_t limit, uint32_t since, double small, sl_counters *counters,
                           sl_error *error) {
    if (p->patches_alive <= limit) return SL_OK;
    size_t wanted = limit - limit / 10, before = p->patches_alive;
    /* no more than there are blocks of children */
    heap h = {sl_allocate_unset(p->patch_count / 4 + 1, sizeof *h.entry), 0};
    if (!h.entry) return sl_fail_memory(error, "eviction");
    candidate found;
    for (uint32_t i = 0; i < p->patch_count; i++) {
        if (sl_patch_is_alive(p, i) && may_lose_children(p, i, since, small, &found)) put(&h, found);
    }
    while (h.count && p->patches_alive > wanted) {
        uint32_t patch = take_first(&h).patch, parent = sl_patch_parent(p, patch);
        sl_patch_drop_children(p, patch);
        if (parent != SL_NO_INDEX && may_lose_children(p, parent, since, small, &found)) put(&h, found);
    }
    sl_free(h.entry);
    sl_count(counters, SL_COUNT_PATCHES_EVICTED, before - p->patches_alive);
    return SL_OK;
}
