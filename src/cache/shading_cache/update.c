/* One update (section on the system's components): U1 to U10.
 *
 *   id map ── priorities ── normalised ── selected pixels ── split, or asked for ── samples ── committed ── aged ── display arrays ── swap
 *                                                                                   │
 *                                                  changes found, coarser patches ──┘
 */
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/shading_cache/state.h"
#include "cache/shading_cache/story.h"

enum { LEVELS_AN_UPDATE = 3, CROWD = 4, CHOICES_A_PATCH = 16, LEAVES_A_TASK = 1024 };

/* A patch is split above 1.2 stop sizes, and dropped by ageing below 0.8: in between nothing swings to and fro. */
static const float split_slack = 1.2f, drop_slack = 0.8f;

/* ---- U1, U2: the id map, and what of its patches wants samples ---- */

/* The visible leaves in the order of their first pixels. Until they are counted a leaf keeps its number where its pixels will be. */
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

/* Counts each leaf's pixels; the leaf and what is above it have been seen. */
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
        for (uint32_t p = sl_patch_parent(s->patches, s->leaf[i].patch); p != SL_NO_INDEX; p = sl_patch_parent(s->patches, p)) {
            sl_patch *patch = &s->patches->patch[p];
            if (patch->seen != s->now) patch->pixels = 0;
            patch->seen = s->now;
            patch->pixels += leaf->pixels;
        }
    }
}

/* By how many levels what a leaf shows may be wrong, priority at most 255, and that where it was never evaluated, waits where its normal priority will be. Objects that
 * change, and what is seen from elsewhere and is not diffuse, grow old. */
static void prioritise_some(void *context, size_t task, unsigned worker) {
    (void)worker;
    sl_shading_state *s = context;
    bool ages = !s->settings.shading_cache.no_ageing;
    size_t end = (task + 1) * LEAVES_A_TASK < s->leaf_count ? (task + 1) * LEAVES_A_TASK : s->leaf_count;
    for (size_t i = task * LEAVES_A_TASK; i < end; i++) {
        uint32_t patch = s->leaf[i].patch, object = sl_root_object(s->primitives, sl_patch_root(s->patches, patch));
        float priority = sl_patch_priority(s->patches, &s->curve, patch, s->now, ages ? s->changes->eye_moved : 0,
                                           ages ? sl_changes_since(s->changes, object) : 0);
        s->leaf[i].normal = priority >= 0.0f && priority < 255.0f ? priority : 255.0f;
        s->leaf[i].priority = priority;
    }
}

static void settle_work(sl_shading_state *s) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    for (size_t i = 0; i < s->scene->object_count; i++) {
        s->stale_before[i] = s->changes->object[i].stale_before;
        s->changing[i] = s->changes->object[i].changing;
    }
    s->work = (sl_work_settings){.split_above = split_slack * (float)c->stop_size, .levels = LEVELS_AN_UPDATE, .crowd = CROWD,
                                 .variance_aware = c->variance_aware, .sharp = s->plan.radiance ? &s->curve : NULL, .dense = s->scene->emitter_count > 0 && !c->variance_aware, .now = s->now, .stale_before = c->no_ageing ? NULL : s->stale_before,
                                 .eye_moved = c->no_ageing ? 0 : s->changes->eye_moved, .changing = s->changing, .coarsest = sl_shading_coarsest(s, false)};
}

static bool is_finished(const sl_shading_state *s, uint32_t patch) {
    return sl_patch_is_finished(s->patches, &s->work, &s->scene->camera, s->settings.width, s->settings.height, patch);
}

/* Where a shadow's edge has come down to pixels its leaves' corners go on differing, and nothing is left to do about it. */
static void leave_out_some(void *context, size_t task, unsigned worker) {
    (void)worker;
    sl_shading_state *s = context;
    size_t end = (task + 1) * LEAVES_A_TASK < s->leaf_count ? (task + 1) * LEAVES_A_TASK : s->leaf_count;
    for (size_t i = task * LEAVES_A_TASK; i < end; i++) {
        if (is_finished(s, s->leaf[i].patch)) s->leaf[i].pixels = 0; /* that may be chosen, or count for the mean */
    }
}

/* To look at all leaves takes time, and as long as most are larger than a pixel most choices are good: that begins when half of them come to nothing. Sets of samples are
 * never enough: where they are asked for no leaf is finished. */
static void leave_out_finished(sl_shading_state *s) {
    if (!s->late || s->settings.shading_cache.variance_aware) return;
    sl_parallel_for(s->settings.threads, (s->leaf_count + LEAVES_A_TASK - 1) / LEAVES_A_TASK, leave_out_some, s);
}

static void note_idle_choices(sl_shading_state *s, size_t choices) {
    size_t idle = 0;
    for (size_t i = 0; i < choices && !s->late; i++) idle += is_finished(s, s->leaf[s->choice[i].leaf].patch);
    s->late = s->late || 2 * idle > choices;
}

/* What holds motion back: the mean over the pixels of what shows. */
static double mean_error_levels(const sl_shading_state *s) {
    double sum = 0.0, pixels = 0.0;
    for (size_t i = 0; i < s->leaf_count; i++) {
        sum += (double)s->leaf[i].pixels * (double)s->leaf[i].normal;
        pixels += s->leaf[i].pixels;
    }
    return pixels > 0.0 ? sum / pixels : 0.0;
}

static void announce_priorities(sl_shading_state *s) {
    float *plane = s->announcer.observer ? sl_allocate(sl_shading_pixels(s), sizeof *plane) : NULL;
    for (size_t i = 0; plane && i < sl_shading_pixels(s); i++)
        plane[i] = s->leaf_of_pixel[i] == SL_NO_INDEX ? 0.0f : s->leaf[s->leaf_of_pixel[i]].normal;
    sl_announce(&s->announcer, "priorities", "priority map", s->settings.width, s->settings.height, 1, plane, true);
    sl_free(plane);
}

static sl_status see_priorities(sl_shading_state *s, sl_error *error) {
    sl_status status = sl_display_id_map(s->display, s->settings.threads, &s->ids, &s->counters, error);
    if (status != SL_OK) return status;
    number_leaves(s);
    status = room_for_leaves(s, error);
    if (status != SL_OK) return status;
    sl_shading_announce_ids(s);
    count_pixels(s);
    sl_parallel_for(s->settings.threads, (s->leaf_count + LEAVES_A_TASK - 1) / LEAVES_A_TASK, prioritise_some, s);
    s->error_levels = mean_error_levels(s);
    settle_work(s);
    leave_out_finished(s);
    sl_priorities_raise(s->leaf_count, s->leaf, sl_shading_pixels(s));
    sl_priorities_normalise(s->leaf_count, s->leaf, s->settings.shading_cache.plain_normalisation);
    announce_priorities(s);
    return SL_OK;
}

/* ---- U4 to U6: which pixels, and what work that makes ---- */

static sl_status select_pixels(sl_shading_state *s, size_t *choices, sl_error *error) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    sl_selection_settings selection = {.how = c->selection, .points = c->points, .random_share = c->no_random ? 0.0f : (float)c->random_share,
                                       .flood_threshold = c->no_flood ? 2.0f : (float)c->flood_threshold, .per_patch = CHOICES_A_PATCH,
                                       .seed = s->settings.seed, .update = s->now};
    return sl_select_pixels(&selection, s->settings.width, s->settings.height, s->leaf_of_pixel, s->leaf_count, s->leaf, s->choice, choices,
                            &s->counters, error);
}

static sl_status work_out(sl_shading_state *s, size_t choices, size_t *vertices, sl_error *error) {
    for (size_t i = 0; i < choices; i++) {
        uint32_t pixel = s->choice[i].pixel;
        s->place[i] = (sl_chosen_place){s->ids.patch[pixel], s->ids.u[pixel], s->ids.v[pixel]};
    }
    note_idle_choices(s, choices);
    return sl_work_out(s->patches, &s->curve, &s->work, &s->scene->camera, s->settings.width, s->settings.height, choices, s->place, s->vertex,
                       vertices, &s->counters, error);
}

/* ---- U9, U10 ---- */

static sl_status age(sl_shading_state *s, sl_error *error) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    size_t limit = (size_t)sl_shading_patch_limit(&s->settings) + 2 * s->primitives->count;
    uint32_t window = (uint32_t)c->ageing_window, since = s->now > window ? s->now - window : 0;
    return sl_patches_evict(s->patches, limit, since, (double)drop_slack * c->stop_size, &s->counters, error);
}

/* Nothing that is seen wants any more: every leaf is as small as it gets, and as the scene is now. What changes is shown with coarser leaves: they are not the end. */
static bool nothing_is_left(const sl_shading_state *s) {
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

sl_status sl_shading_update(sl_shading_state *s, sl_error *error) {
    size_t choices = 0, vertices = 0;
    s->now++;
    sl_status status = see_priorities(s, error);
    if (status != SL_OK) return status;
    status = select_pixels(s, &choices, error);
    sl_shading_announce_choices(s, status == SL_OK ? choices : 0);
    if (status == SL_OK) status = work_out(s, choices, &vertices, error);
    if (status != SL_OK) return status;
    sl_announce_pass(&s->announcer, "requests", "lazy evaluation");
    sl_shading_sample(s, vertices);
    sl_announce_pass(&s->announcer, "samples", "lazy evaluation");
    status = sl_shading_commit(s, vertices, error);
    if (s->now >= s->last_update) sl_fades_finish(&s->fades, s->patches); /* the picture is done */
    if (status == SL_OK) status = age(s, error);
    if (status == SL_OK) status = sl_patches_lend(s->patches, error);
    sl_announce_pass(&s->announcer, "commit", "motion, age");
    if (status == SL_OK) status = sl_display_build(s->display, s->patches, &s->counters, error);
    sl_announce_pass(&s->announcer, "display arrays", "display loop");
    s->done = s->now >= s->last_update || nothing_is_left(s);
    if (s->done) s->edited = 0; /* nothing that is seen has changed */
    return status;
}
