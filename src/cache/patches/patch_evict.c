/* Eviction: children go that were not seen within the window, or whose parent covers less than a pixel; those
 * first that have not been seen for longest, and from the leaves up, so that what remains is always a tree.
 */
#include "base/code_sort.h"
#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "cache/patches/patch_parts.h"

/* Tells whether a patch has four leaves for children that may go; *found: the patch, coded by when one of
 * them was seen last. */
static bool may_lose_children(const sl_patches *p, uint32_t patch, uint32_t since, double small,
                              sl_coded *found) {
    uint32_t first = p->patch[patch].child, latest;
    if (first == SL_NO_INDEX) return false;
    for (uint32_t k = 0; k < 4; k++)
        if (!sl_patch_is_leaf(p, first + k)) return false;
    const uint32_t pixels = sl_pixels_of_children(p, first, &latest);
    *found = (sl_coded){latest, patch};
    return latest < since || (double)pixels < small;
}

/* Drops its children, and those of the patches above it that are as old by then. */
static void drop_upwards(sl_patches *p, sl_coded from, uint32_t since, double small, size_t wanted) {
    sl_coded next = from;
    do {
        sl_patch_drop_children(p, next.item);
        next.item = sl_patch_parent(p, next.item);
    } while (next.item != SL_NO_INDEX && p->patches_alive > wanted &&
             may_lose_children(p, next.item, since, small, &next) && next.code == from.code);
}

sl_status sl_patches_evict(sl_patches *p, size_t limit, uint32_t since, double small, sl_counters *counters,
                           sl_error *error) {
    if (p->patches_alive <= limit) return SL_OK;
    size_t wanted = limit - limit / 10, before = p->patches_alive, count;
    /* no more than there are blocks of children */
    sl_coded *oldest = sl_allocate_unset(p->patch_count / 4 + 1, sizeof *oldest);
    if (!oldest) return sl_fail_memory(error, "eviction");
    do {
        count = 0;
        for (uint32_t i = 0; i < p->patch_count; i++)
            count += sl_patch_is_alive(p, i) && may_lose_children(p, i, since, small, &oldest[count]);
        sl_sort_coded(oldest, count);
        for (size_t i = 0; i < count && p->patches_alive > wanted; i++)
            drop_upwards(p, oldest[i], since, small, wanted);
    } while (count > 0 && p->patches_alive > wanted);
    sl_free(oldest);
    sl_count(counters, SL_COUNT_PATCHES_EVICTED, before - p->patches_alive);
    return SL_OK;
}
