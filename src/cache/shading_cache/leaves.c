/* The visible leaves: numbered, their pixels counted, and left out of the selection once there is nothing
 * left to do in them. */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/shading_cache/state.h"

enum { LEAVES_A_TASK = 1024 };

/* The visible leaves in the order of their first pixels. Until they are counted a leaf keeps its number where
 * its pixels will be. */
static void number_leaves(sl_shading_state *s) {
    s->leaf_count = 0;
    for (size_t i = 0; i < sl_shading_pixels(s); i++) {
        uint32_t leaf = s->ids.patch[i];
        s->leaf_of_pixel[i] = SL_NO_INDEX;
        if (leaf == SL_NO_INDEX) continue;
        sl_patch *patch = &s->patches->patch[leaf];
        if (patch->seen != s->now) *patch = (sl_patch){patch->child, s->now, (uint32_t)s->leaf_count++};
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
    for (size_t i = 0; i < sl_shading_pixels(s); i++) {
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

static void visit_some(void *context, size_t task, unsigned worker) {
    (void)worker;
    const leaf_task *t = context;
    size_t begin = task * LEAVES_A_TASK, end = begin + LEAVES_A_TASK;
    for (size_t i = begin; i < end && i < t->state->leaf_count; i++) t->visit(t->state, &t->state->leaf[i]);
}

void sl_shading_each_leaf(sl_shading_state *s, sl_leaf_visit *visit) {
    leaf_task task = {s, visit};
    sl_parallel_for(s->settings.threads, (s->leaf_count + LEAVES_A_TASK - 1) / LEAVES_A_TASK, visit_some,
                    &task);
}

/* ---- finished leaves ---- */

static bool is_finished(const sl_shading_state *s, uint32_t patch) {
    const sl_settings *c = &s->settings;
    return sl_patch_is_finished(s->patches, &s->work, &s->scene->camera, c->width, c->height, patch);
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
bool sl_shading_nothing_is_left(const sl_shading_state *s) {
    if (s->fades.count > 0) return false;
    for (size_t i = 0; i < s->scene->object_count; i++) {
        if (s->changes->object[i].changing || s->changing[i]) return false;
    }
    for (size_t i = 0; i < s->leaf_count; i++) {
        uint32_t patch = s->leaf[i].patch;
        if (!sl_patch_is_alive(s->patches, patch) || !sl_patch_is_leaf(s->patches, patch)) return false;
        if (!is_finished(s, patch)) return false;
    }
    return true;
}
