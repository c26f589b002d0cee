/* An update takes a step of the picture; an edit makes what it is made from follow the scene, or makes it
 * anew. */
#include "cache/multi_mesh/multi_mesh_internal.h"

/* ---- the end of a picture ---- */

static void end_picture(sl_multi_mesh_state *s) {
    sl_multi_mesh_announce_light_sample(s);
    sl_multi_mesh_remember_done(s);
    s->phase = SL_PHASE_DONE;
    s->settled = true;
}

/* Leaves were judged by the other components as they were then. Before the end all are judged by what there
 * is now. */
static bool look_again(sl_multi_mesh_state *s) {
    for (int i = 0; i < SL_COMPONENTS; i++) {
        if (!sl_multi_mesh_takes_part(s, i)) continue;
        if (s->world > 1 && !s->judged) sl_displayed_settle_all(s->part[i], &s->counters);
        sl_displayed_prioritise(s->part[i]);
    }
    s->judged = true;
    return sl_multi_mesh_most_urgent(s) >= 0;
}

static bool is_coarse_left(const sl_multi_mesh_state *s) {
    return s->plan.indirect && !sl_coarse_is_of_now(s) && sl_is_in_view(s->part[SL_INDIRECT]);
}

/* While light moves an update takes long where the coarse mesh is large, and shadows are to be found soon:
 * batches go on while a leaf counts as much as a 512th of the picture by a threshold. */
static sl_status refine_more(sl_multi_mesh_state *s, sl_error *error) {
    enum { BATCHES = 16, PART = 512 };
    const float large = (float)s->settings.width * (float)s->settings.height / PART;
    sl_status status = SL_OK;
    size_t served = 1;
    for (int k = 1; k < BATCHES && status == SL_OK && served > 0; k++) {
        const int part = sl_multi_mesh_most_urgent(s);
        if (part < 0 || sl_displayed_priority(s->part[part]) < large) break;
        status = sl_multi_mesh_refine(s, &served, error);
    }
    return status;
}

static sl_status refine_or_end(sl_multi_mesh_state *s, sl_error *error) {
    size_t served = 0;
    bool full = sl_multi_mesh_is_full(s);
    sl_status status = full ? SL_OK : sl_multi_mesh_refine(s, &served, error);
    if (status == SL_OK && s->moves && served > 0) status = refine_more(s, error);
    bool idle = served == 0 && !s->old_left && !is_coarse_left(s);
    if (status == SL_OK && idle && (full || !look_again(s))) end_picture(s);
    return status;
}

/* ---- an update ---- */

/* From then on frames may show it: the most visible edges of light are split, or while something moves at
 * least some roots lit. */
static void note_light(sl_multi_mesh_state *s) {
    bool refines = s->phase == SL_PHASE_REFINE && s->fraction >= 0.25;
    bool begins = s->is_edited && s->phase >= SL_PHASE_FIRST;
    s->has_light = s->has_light || refines || begins || s->phase == SL_PHASE_DONE;
}

/* The first picture: one phase after the other. */
static sl_status update_phase(sl_multi_mesh_state *s, sl_error *error) {
    switch (s->phase) {
    case SL_PHASE_VIEW: return sl_multi_mesh_draw_view(s, error);
    case SL_PHASE_FIRST: return sl_multi_mesh_first_vertices(s, error);
    case SL_PHASE_REFINE: break;
    case SL_PHASE_DONE: return SL_OK;
    }
    sl_status status = refine_or_end(s, error);
    return status == SL_OK && is_coarse_left(s) ? sl_multi_mesh_extend_coarse(s, error) : status;
}

/* Once there has been an edit an update has a share for each: the view if it has changed, the coarse mesh,
 * vertices that faces lack which have come into view, what edits have made old, refinement. So leaves are cut
 * and put together whatever moves, and however often. */
static sl_status update_shares(sl_multi_mesh_state *s, sl_error *error) {
    if (s->phase == SL_PHASE_DONE) return SL_OK;
    sl_status status = s->phase == SL_PHASE_VIEW ? sl_multi_mesh_draw_view(s, error) : SL_OK;
    if (status == SL_OK && is_coarse_left(s)) status = sl_multi_mesh_extend_coarse(s, error);
    if (status == SL_OK && s->phase == SL_PHASE_FIRST) status = sl_multi_mesh_first_vertices(s, error);
    if (status == SL_OK) status = sl_multi_mesh_renew(s, error);
    return status == SL_OK ? refine_or_end(s, error) : status;
}

sl_status sl_multi_mesh_update(void *state, sl_progress *progress, sl_error *error) {
    sl_multi_mesh_state *s = state;
    sl_status status = SL_OK;
    s->updates++;
    if (s->is_edited) status = update_shares(s, error);
    else status = update_phase(s, error);
    progress->fraction = sl_multi_mesh_fraction(s);
    progress->frame_done = progress->done = s->phase == SL_PHASE_DONE;
    note_light(s);
    return status == SL_OK && s->has_light ? sl_multi_mesh_show(s, error) : status;
}

/* ---- an edit ---- */

static sl_status make_anew(sl_multi_mesh_state *s, sl_error *error) {
    sl_multi_mesh_forget_view(s);
    sl_multi_mesh_forget_world(s);
    s->full = s->has_light = false;
    s->made++;
    s->plan = sl_multi_mesh_plan_make(s->scene); /* light may fall where none fell */
    sl_status status = sl_multi_mesh_make_world(s, error);
    if (status != SL_OK) sl_multi_mesh_forget_world(s);
    return status;
}

/* Lights and objects: what cannot have changed stays as it is, all else is seen until it is renewed. */
static sl_status edit_world(sl_multi_mesh_state *s, unsigned changes, sl_error *error) {
    bool followed = false;
    s->done_count = 0;
    s->moves = !s->settled;
    s->settled = false;
    sl_multi_mesh_hasten_coarse(s);
    s->gathers_wait = sl_coarse_is_of_now(s) || (s->gathers_wait && !s->next.coarse && !s->whole.rolls);
    s->world++;
    if (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) s->lit = s->world;
    s->judged = false;
    s->updates = 0;
    if (s->whole.coarse && changes & SL_CHANGED_MATERIALS) s->whole.coarse->reflectance_known = false;
    if (!s->change_waits) s->change_world = s->world;
    s->change_waits = true;
    sl_status status = s->raster && !s->full ? sl_multi_mesh_follow(s, changes, &followed, error) : SL_OK;
    if (status == SL_OK && !followed) return make_anew(s, error);
    if (status == SL_OK) return SL_OK;
    sl_multi_mesh_forget_view(s);
    sl_multi_mesh_forget_world(s);
    s->settled = true; /* the next one begins anew */
    return status;
}

/* The eye: specular radiance starts again, all else stays. */
sl_status sl_multi_mesh_edit(void *state, unsigned changes, sl_error *error) {
    sl_multi_mesh_state *s = state;
    s->phase = SL_PHASE_VIEW;
    s->is_edited = true;
    if (changes & SL_CHANGED_CAMERA && s->part[SL_DIRECT_SPECULAR])
        sl_displayed_restart(s->part[SL_DIRECT_SPECULAR]);
    bool world = changes & ~(unsigned)SL_CHANGED_CAMERA;
    return world ? edit_world(s, changes, error) : SL_OK;
}
