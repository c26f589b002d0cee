/* Visible leaves: numbered, their pixels counted, left out once there is nothing left to do in them. And
 * choices of their pixels: where they are kept, and the highest priorities first, with which the paper
 * compares hit-and-test and flood fill (shading_cache.c). */
#include <stdlib.h>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/shading_cache/state.h"

/* ---- choices ---- */

static uint32_t most_of(const sl_selection *s, uint32_t leaf) {
    uint32_t most = s->per_patch < UINT16_MAX ? s->per_patch : UINT16_MAX;
    return most < s->leaves[leaf].pixels ? most : s->leaves[leaf].pixels;
}

bool sl_selection_take(sl_selection *s, uint32_t pixel, sl_choice_kind kind) {
    uint32_t leaf = s->leaf[pixel], most = most_of(s, leaf);
    if (s->taken[leaf] >= most || sl_selection_visited(s, pixel)) return false;
    sl_selection_visit(s, pixel);
    s->choice[s->count++] = (sl_choice){pixel, leaf, kind};
    if (++s->taken[leaf] == most) s->open--;
    static const sl_counter counter[] = {
        [SL_CHOICE_HIT] = SL_COUNT_PIXELS_HIT,
        [SL_CHOICE_RANDOM] = SL_COUNT_PIXELS_RANDOM,
        [SL_CHOICE_FLOOD] = SL_COUNT_PIXELS_FLOODED};
    sl_count(s->counters, counter[kind], 1);
    return true;
}

/* ---- instead: the highest priorities first ---- */

typedef struct ranked {
    float normal, priority;
    uint32_t leaf;
} ranked;

static int highest_first(const void *a, const void *b) {
    const ranked *x = a, *y = b;
    if (x->normal != y->normal) return x->normal > y->normal ? -1 : 1;
    if (x->priority != y->priority) return x->priority > y->priority ? -1 : 1;
    return x->leaf < y->leaf ? -1 : x->leaf > y->leaf;
}

/* One pixel of each leaf, from the highest priority down; where there are fewer leaves than choices, one more
 * of each, and so on. share: by leaf. */
static void share_out(const sl_selection *s, const ranked *leaves, uint32_t *share) {
    size_t left = (size_t)s->points;
    for (bool more = true; more && left > 0;) {
        more = false;
        for (size_t i = 0; i < s->leaf_count && left > 0; i++) {
            const uint32_t leaf = leaves[i].leaf;
            if (share[leaf] >= s->leaves[leaf].pixels || share[leaf] >= s->per_patch) continue;
            share[leaf]++;
            left--;
            more = true;
        }
    }
}

/* Its pixels in the order of the picture, at equal distances. */
static bool is_next(uint32_t passed, uint32_t pixels, uint32_t taken, uint32_t share) {
    return taken < share && (uint64_t)(2 * passed + 1) * share >= (uint64_t)(2 * taken + 1) * pixels;
}

static sl_status select_sorted(sl_selection *s, sl_error *error) {
    ranked *leaves = sl_allocate_unset(s->leaf_count, sizeof *leaves);
    uint32_t *passed = sl_allocate(2 * s->leaf_count, sizeof *passed);
    if (!leaves || !passed) {
        sl_free(leaves);
        sl_free(passed);
        return sl_fail_memory(error, "sorted selection");
    }
    uint32_t *share = passed + s->leaf_count;
    for (uint32_t i = 0; i < s->leaf_count; i++) {
        float priority = s->leaves[i].priority; /* never evaluated: before all others */
        leaves[i] = (ranked){s->leaves[i].normal, priority >= 0.0f ? priority : HUGE_VALF, i};
    }
    qsort(leaves, s->leaf_count, sizeof *leaves, highest_first);
    share_out(s, leaves, share);
    for (uint32_t pixel = 0; pixel < s->pixel_count; pixel++) {
        uint32_t leaf = s->leaf[pixel];
        if (leaf == SL_NO_INDEX) continue;
        if (is_next(passed[leaf]++, s->leaves[leaf].pixels, s->taken[leaf], share[leaf]))
            sl_selection_take(s, pixel, SL_CHOICE_HIT);
    }
    sl_free(leaves);
    sl_free(passed);
    return SL_OK;
}

/* ---- all ---- */

static sl_status select_pixels(sl_selection *s, sl_error *error) {
    if (s->how == SL_PIXELS_SORTED) return select_sorted(s, error);
    sl_hit_and_test(s);
    return s->flood_threshold > 1.0f ? SL_OK : sl_flood_fill(s, error);
}

sl_status sl_select_pixels(sl_selection *s, sl_error *error) {
    s->count = s->open = 0;
    if (s->width <= 0 || s->height <= 0 || s->leaf_count == 0 || s->points <= 0) return SL_OK;
    s->pixel_count = (size_t)s->width * (size_t)s->height;
    s->visited = sl_allocate((s->pixel_count + 7) / 8, 1);
    s->taken = sl_allocate(s->leaf_count, sizeof *s->taken);
    for (uint32_t i = 0; i < s->leaf_count; i++) s->open += most_of(s, i) > 0;
    sl_status status = s->visited && s->taken ? select_pixels(s, error) : sl_fail_memory(error, "selection");
    SL_FREE_ALL(s->visited, s->taken);
    if (status != SL_OK) s->count = 0;
    return status;
}

/* ---- visible leaves ---- */

/* The visible leaves in the order of their first pixels. Until they are counted a leaf keeps its number where
 * its pixels will be. */
static void number_leaves(sl_shading_state *s) {
    s->leaf_count = 0;
    for (size_t i = 0; i < sl_settings_pixels(&s->settings); i++) {
        uint32_t leaf = s->ids.patch[i];
        s->leaf_of_pixel[i] = SL_NO_INDEX;
        if (leaf == SL_NO_INDEX) continue;
        sl_patch *patch = &s->patches->patch[leaf];
        if (patch->seen != s->now) patch->pixels = (uint32_t)s->leaf_count++;
        patch->seen = s->now;
        s->leaf_of_pixel[i] = patch->pixels;
    }
}

static sl_status room_for_leaves(sl_shading_state *s, sl_error *error) {
    if (s->leaf_count <= s->leaf_room) return SL_OK;
    size_t room = s->leaf_count + s->leaf_count / 128;
    sl_free(s->leaf);
    s->leaf = sl_allocate_unset(room, sizeof *s->leaf);
    s->leaf_room = s->leaf ? room : 0;
    return s->leaf ? SL_OK : sl_fail_memory(error, "visible patches");
}

/* Counts each leaf's pixels, which are those of its ancestors, too: all of them have been seen. */
static void count_pixels(sl_shading_state *s) {
    for (size_t i = 0; i < s->leaf_count; i++) s->leaf[i] = (sl_leaf_priority){0};
    for (size_t i = 0; i < sl_settings_pixels(&s->settings); i++) {
        if (s->leaf_of_pixel[i] == SL_NO_INDEX) continue;
        sl_leaf_priority *leaf = &s->leaf[s->leaf_of_pixel[i]];
        leaf->patch = s->ids.patch[i];
        leaf->pixels++;
    }
    for (size_t i = 0; i < s->leaf_count; i++) {
        sl_patch *leaf = &s->patches->patch[s->leaf[i].patch];
        leaf->pixels = s->leaf[i].pixels;
        uint32_t p = sl_patch_parent(s->patches, s->leaf[i].patch);
        for (; p != SL_NO_INDEX; p = sl_patch_parent(s->patches, p)) {
            sl_patch *patch = &s->patches->patch[p];
            if (patch->seen != s->now) patch->pixels = 0;
            patch->seen = s->now;
            patch->pixels += leaf->pixels;
        }
    }
}

sl_status sl_shading_find_leaves(sl_shading_state *s, sl_error *error) {
    number_leaves(s);
    sl_status status = room_for_leaves(s, error);
    if (status == SL_OK) count_pixels(s);
    return status;
}

/* ---- all of them, on all threads ---- */

typedef struct leaf_task {
    sl_shading_state *state;
    sl_leaf_visit *visit;
} leaf_task;

static void visit_one(void *context, size_t leaf, unsigned worker) {
    (void)worker;
    const leaf_task *t = context;
    t->visit(t->state, &t->state->leaf[leaf]);
}

void sl_shading_each_leaf(sl_shading_state *s, sl_leaf_visit *visit) {
    leaf_task task = {s, visit};
    sl_parallel_for(s->settings.threads, s->leaf_count, visit_one, &task);
}

/* ---- finished leaves ---- */

static bool is_finished(const sl_shading_state *s, uint32_t patch) {
    return sl_patch_is_finished(s->patches, &s->work, patch);
}

/* Where a shadow's edge has come down to pixels its leaves' corners go on differing, and nothing is left to
 * do about it. */
static void leave_out(sl_shading_state *s, sl_leaf_priority *leaf) {
    if (is_finished(s, leaf->patch))
        leaf->pixels = 0; /* none of them may be chosen, or counts for the mean */
}

/* To look at all leaves takes time, and as long as most are larger than a pixel most choices are good: that
 * begins when half of them come to nothing. Sets of samples are never enough: where they are asked for no
 * leaf is finished. */
void sl_shading_leave_out_finished(sl_shading_state *s) {
    if (s->late && !s->settings.shading_cache.variance_aware) sl_shading_each_leaf(s, leave_out);
}

void sl_shading_note_idle(sl_shading_state *s, size_t choices) {
    size_t idle = 0;
    for (size_t i = 0; i < choices && !s->late; i++) idle += is_finished(s, s->leaf[s->choice[i].leaf].patch);
    s->late = s->late || 2 * idle > choices;
}

/* Every visible leaf is as small as it gets, and as the scene is now. Objects that change are shown with
 * coarser leaves: they are not the end. */
static bool nothing_is_left(const sl_shading_state *s) {
    if (s->now == 0 || s->fades.count > 0 || s->stale_left > 0 || s->few_paths) return false;
    for (size_t i = 0; i < s->scene->object_count; i++) {
        if (s->changes.object[i].changing) return false;
    }
    for (size_t i = 0; i < s->leaf_count; i++) {
        uint32_t patch = s->leaf[i].patch;
        if (!sl_patch_is_alive(s->patches, patch) || !sl_patch_is_leaf(s->patches, patch)) return false;
        if (!is_finished(s, patch)) return false;
    }
    return true;
}

bool sl_shading_is_done(const sl_shading_state *s) {
    return s->now >= s->last_update || s->samples >= s->last_sample || nothing_is_left(s);
}
