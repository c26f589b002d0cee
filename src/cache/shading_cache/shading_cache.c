/* "Interactive Global Illumination in Dynamic Scenes" (Tole, Pellacini, Walter, Greenberg 2002), in the order
 * of the paper: one update is
 *
 *   id map                each pixel's patch, read back from the hardware
 *   priority map          p = p_err + p_age, in grey levels, normalised over the pixels
 *   hit-and-test          pixels drawn at random and tested against their priority; flood fill from the hits
 *   lazy evaluation       a patch's corners are asked for, or it is split in four
 *   renewal               corners from before an edit are asked for, layer by layer
 *   sample renderer       values of these corners
 *   motion and age        values committed, changes found, coarser patches where things change, old ones
 *                         deleted
 *   display arrays        the second copy brought up to date, and swapped
 *
 * and any number of frames are drawn from the copy that is shown meanwhile. The parts:
 *
 *   plan.c, method.c      which of it a scene needs; a cache made, edited, shown; state.h: its fields
 *   cache/patches         triangles, quadrilaterals and bicubic patches, and the hierarchy on them; its
 *                         display: arrays, tessellation, drawing
 *   priority.c            interpolation error, age, normalisation
 *   selection.c           visible leaves and their pixels; choices kept; sorted selection
 *   work.c                patches grouped, corners asked for, splits
 *   renewal.c             what is stale, by layers of light
 *   untouched.c           direct light that outlives an edit
 *   cache/patches/layers.h  light apart by what it costs, at the same vertices
 *   renderers.h           direct light (cache/light), bidirectional paths, caustics (cache/photons)
 *   samples.c, change.c   requests, commits; change detection, resolution drop, blending
 *   explanation.c         the terms of a pixel, for observers */
#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/shading_cache/state.h"

enum { CHOICES_A_PATCH = 16 };

/* A patch is split above 1.2 stop sizes, and dropped by ageing below 0.8: in between nothing swings to and
 * fro. */
static const float split_slack = 1.2f, drop_slack = 0.8f;

/* ---- id map ---- */

static sl_status draw_id_map(sl_shading_state *s, sl_error *error) {
    sl_status status = sl_display_id_map(s->display, &s->ids, &s->counters, error);
    if (status == SL_OK) status = sl_shading_find_leaves(s, error);
    if (status == SL_OK)
        sl_announce_ids(&s->announcer, "id map", "patch hierarchy", s->settings.width, s->settings.height,
                        s->ids.patch);
    return status;
}

/* ---- priority map ---- */

/* p = p_err + min(p_age, 255), p_err = max D - min D over the corners, p_age = c (t_now - t_eval) where the
 * object changes, or the eye has moved and the surface is not diffuse. Patches never evaluated come first.
 * Until it is normalised p_norm holds p of at most 255 levels. */
static void prioritise(sl_shading_state *s, sl_leaf_priority *leaf) {
    uint32_t object = sl_root_object(s->primitives, sl_patch_root(s->patches, leaf->patch));
    uint32_t eye_moved = s->changes.no_ageing ? 0 : s->changes.eye_moved;
    leaf->priority = sl_patch_priority(s->patches, &s->curve, leaf->patch, s->now, eye_moved,
                                       sl_changes_since(&s->changes, object));
    leaf->normal = leaf->priority >= 0.0f && leaf->priority < 255.0f ? leaf->priority : 255.0f;
}

/* Returns the mean over the pixels, which shows tell. */
static double mean_error_levels(const sl_shading_state *s) {
    double sum = 0.0, pixels = 0.0;
    for (size_t i = 0; i < s->leaf_count; i++) {
        sum += (double)s->leaf[i].pixels * (double)s->leaf[i].normal;
        pixels += s->leaf[i].pixels;
    }
    return pixels > 0.0 ? sum / pixels : 0.0;
}

static void settle_work(sl_shading_state *s) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    s->view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    s->work = (sl_work_settings){.view = &s->view,
                                 .moves = s->moves,
                                 .curve = &s->curve,
                                 .split_above = split_slack * (float)c->stop_size,
                                 .sharp = s->plan.radiance,
                                 .dense = s->scene->emitter_count > 0 && !c->variance_aware,
                                 .changes = &s->changes,
                                 .coarsest = sl_shading_coarsest(s)};
}

/* p_norm = (p - lo) / (hi - lo) with lo, hi = mean -+ 4 sigma, clamped to the range of p. */
static void make_priority_map(sl_shading_state *s) {
    sl_shading_each_leaf(s, prioritise);
    s->error_levels = mean_error_levels(s);
    settle_work(s);
    sl_shading_leave_out_finished(s);
    sl_priorities_raise(s->leaf_count, s->leaf, sl_settings_pixels(&s->settings));
    sl_priorities_normalise(s->leaf_count, s->leaf, s->settings.shading_cache.plain_normalisation);
    sl_shading_announce_priorities(s);
}

/* ---- hit-and-test ---- */

/* p_total = epsilon + (1 - epsilon) p_norm: a pixel is accepted with that chance. One uniform number u serves
 * twice: below epsilon the pixel is a random one, which finds what the corners of its patch do not show, and
 * (u - epsilon) / (1 - epsilon) < p_norm is the test. */
void sl_hit_and_test(sl_selection *s) {
    float e = s->random_share;
    uint64_t key = sl_random_key(s->seed, s->update), test = 0;
    size_t points = (size_t)s->points;
    double most = 8.0 * (double)points / (e > 0.0f ? (double)e : 0.03);
    for (; s->count < points && s->open > 0 && (double)test < most; test++) {
        uint32_t pixel = (uint32_t)((uint64_t)sl_random_bits(key, 2 * test) * s->pixel_count >> 32);
        float u = sl_random_unit(key, 2 * test + 1);
        if (s->leaf[pixel] == SL_NO_INDEX) continue;
        if (u < e) sl_selection_take(s, pixel, SL_CHOICE_RANDOM);
        else if (u - e < (1.0f - e) * s->leaves[s->leaf[pixel]].normal)
            sl_selection_take(s, pixel, SL_CHOICE_HIT);
    }
    sl_count(s->counters, SL_COUNT_PIXEL_TESTS, test);
}

/* ---- flood fill ---- */

/* The neighbours of a pixel of high priority, at a shadow's edge for instance, are likely to have one, too,
 * and small patches there are hardly ever hit by chance: on 640 x 480 pixels 1,000 draws miss a patch of one
 * pixel 997 times in 1,000. */
typedef struct flooded_pixel {
    uint32_t pixel;
    float threshold; /* p_norm of the seed */
} flooded_pixel;

typedef struct flood {
    flooded_pixel *queue;
    size_t first, end, flooded, most;
} flood;

/* The paper's floods run on while priorities grow, and so end within the patch they begin in, all of whose
 * pixels have the same one. Here they run over all pixels with p_norm >= that of the seed, also through
 * patches with enough choices. */
static void flood_to(sl_selection *s, flood *f, uint32_t pixel, float threshold) {
    uint32_t leaf = s->leaf[pixel];
    if (f->flooded >= f->most || leaf == SL_NO_INDEX || sl_selection_visited(s, pixel) ||
        !(s->leaves[leaf].normal >= threshold)) return;
    f->flooded += sl_selection_take(s, pixel, SL_CHOICE_FLOOD);
    sl_selection_visit(s, pixel);
    f->queue[f->end++] = (flooded_pixel){pixel, threshold};
}

static void run_flood(sl_selection *s, flood *f) {
    uint32_t width = (uint32_t)s->width, height = (uint32_t)s->height;
    while (f->first < f->end && f->flooded < f->most && s->open > 0) {
        flooded_pixel at = f->queue[f->first++];
        uint32_t x = at.pixel % width, y = at.pixel / width;
        if (x > 0) flood_to(s, f, at.pixel - 1, at.threshold);
        if (x + 1 < width) flood_to(s, f, at.pixel + 1, at.threshold);
        if (y > 0) flood_to(s, f, at.pixel - width, at.threshold);
        if (y + 1 < height) flood_to(s, f, at.pixel + width, at.threshold);
    }
}

/* Seeds are the hits with p_norm >= tau_f. Each pixel is in the queue at most once: seeds are visited. */
sl_status sl_flood_fill(sl_selection *s, sl_error *error) {
    flood f = {.queue = sl_allocate_unset(s->pixel_count, sizeof *f.queue),
               .most = (size_t)s->points};
    if (!f.queue) return sl_fail_memory(error, "flood fill");
    for (size_t i = 0; i < s->count; i++) {
        float normal = s->leaves[s->choice[i].leaf].normal;
        if (s->choice[i].kind != SL_CHOICE_HIT || !(normal >= s->flood_threshold)) continue;
        f.queue[f.end++] = (flooded_pixel){s->choice[i].pixel, normal};
    }
    run_flood(s, &f);
    sl_free(f.queue);
    return SL_OK;
}

static sl_status select_pixels(sl_shading_state *s, size_t *choices, sl_error *error) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    sl_selection selection = {.how = c->selection,
                              .points = c->points,
                              .random_share = c->no_random ? 0.0f : (float)c->random_share,
                              .flood_threshold = c->no_flood ? 2.0f : (float)c->flood_threshold,
                              .per_patch = CHOICES_A_PATCH,
                              .seed = s->settings.seed,
                              .update = s->now,
                              .width = s->settings.width,
                              .height = s->settings.height,
                              .leaf = s->leaf_of_pixel,
                              .leaves = s->leaf,
                              .leaf_count = s->leaf_count,
                              .counters = &s->counters,
                              .choice = s->choice};
    sl_status status = sl_select_pixels(&selection, error);
    *choices = selection.count;
    sl_shading_announce_choices(s, *choices);
    return status;
}

/* ---- lazy evaluation ---- */

/* Of each patch with chosen pixels: corners never evaluated are asked for; else, while it is
 * larger than a pixel, it is split into four and each pixel goes to its child, which is treated alike where
 * many pixels lie in it; a leaf of a pixel is done. */
static sl_status evaluate_or_split(sl_shading_state *s, size_t choices, size_t *vertices, sl_error *error) {
    for (size_t i = 0; i < choices; i++) {
        uint32_t pixel = s->choice[i].pixel;
        s->place[i] = (sl_chosen_place){s->ids.patch[pixel], s->ids.u[pixel], s->ids.v[pixel]};
    }
    sl_shading_note_idle(s, choices);
    sl_status status =
        sl_work_out(s->patches, &s->work, choices, s->place, s->vertex, vertices, &s->counters, error);
    if (status == SL_OK) sl_announce_pass(&s->announcer, "requests", "lazy evaluation");
    return status;
}

/* ---- motion and age ---- */

/* An object changes where |D(new) - D(old)| > tau_c for a corner shaded again by the same samples, until W
 * updates have found no such corner and no visible leaf is stale. Its patches age, and until then they are as
 * coarse as leaves time to shade all of them: a = A / (r T_c). */
void sl_shading_commit(sl_shading_state *s, size_t count) {
    uint64_t before = s->counters.value[SL_COUNT_CHANGES_DETECTED];
    sl_fades_go_on(&s->fades, s->patches, (float)s->settings.shading_cache.blending);
    for (size_t i = 0; i < count; i++) sl_shading_commit_sample(s, i);
    sl_layers_follow(&s->layers, s->patches);
    sl_shading_find_stale(s);
    sl_changes_settle(&s->changes, s->stale, s->now);
    if (s->counters.value[SL_COUNT_CHANGES_DETECTED] == before) return;
    sl_shading_note_latency(s);
    sl_shading_drop_resolution(s);
}

/* Children go that were not seen for long, or are smaller than pixels, once there are more patches than the
 * limit. */
static sl_status age(sl_shading_state *s, sl_error *error) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    size_t limit = (size_t)sl_shading_patch_limit(&s->settings) + 2 * s->primitives->count;
    uint32_t window = (uint32_t)c->ageing_window, since = s->now > window ? s->now - window : 0;
    return sl_patches_evict(s->patches, limit, since, (double)drop_slack * c->stop_size, &s->counters, error);
}

/* A vertex without light of its own is extrapolated from the corners around it. */
static sl_status move_and_age(sl_shading_state *s, size_t vertices, sl_error *error) {
    sl_shading_commit(s, vertices);
    bool done = s->now >= s->last_update || s->samples >= s->last_sample;
    if (done) sl_fades_finish(&s->fades, s->patches);
    sl_status status = age(s, error);
    if (status == SL_OK) sl_patches_extrapolate(s->patches);
    sl_announce_pass(&s->announcer, "commit", "motion, age");
    return status;
}

/* ---- display arrays: two copies, one of which is shown ---- */

static sl_status build_display_arrays(sl_shading_state *s, sl_error *error) {
    sl_status status = sl_display_build(s->display, s->patches, error);
    sl_announce_pass(&s->announcer, "display arrays", "display loop");
    return status;
}

/* ---- one update ---- */

/* Things rest when REST updates have seen no edit: what was sampled quickly is sampled again; by all paths
 * when no dear layer is older than the scene. */
static void note_rest(sl_shading_state *s) {
    enum { REST = 2 };
    const bool stops = s->moves && s->now - s->lit > REST,
               caught_up = s->few_paths && !s->moves && s->dear_left == 0;
    if (stops) s->moves = false;
    if (caught_up) {
        s->few_paths = false;
        s->layers.edited = s->same_paths = ++s->layers.now;
    }
    s->may_be_stale |= stops || caught_up;
}

sl_status sl_shading_update(sl_shading_state *s, sl_error *error) {
    size_t choices = 0, vertices = 0;
    s->now++;
    note_rest(s);
    sl_status status = draw_id_map(s, error);
    if (status != SL_OK) return status;
    make_priority_map(s);
    status = select_pixels(s, &choices, error);
    if (status == SL_OK) status = evaluate_or_split(s, choices, &vertices, error);
    if (status == SL_OK) status = sl_shading_renew(s, &vertices, error);
    if (status != SL_OK) return status;
    /* sample renderer: E of diffuse surfaces, L_o towards the eye of others */
    sl_shading_sample(s, vertices);
    status = move_and_age(s, vertices, error);
    if (status == SL_OK) status = build_display_arrays(s, error);
    s->done = sl_shading_is_done(s);
    if (s->done) s->edited = 0; /* nothing that is seen has changed */
    return status;
}
