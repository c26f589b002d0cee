/* When the scene changes: what a picture is made from follows it, or is made anew. */
#include "cache/multi_mesh/multi_mesh_internal.h"

static sl_status make_anew(sl_multi_mesh_state *s, sl_error *error) {
    sl_multi_mesh_forget_view(s);
    sl_multi_mesh_forget_world(s);
    s->full = s->has_light = false;
    s->made++;
    s->plan = sl_multi_mesh_plan_make(s->scene, &s->settings); /* light may fall where none fell */
    sl_status status = sl_multi_mesh_make_world(s, error);
    if (status != SL_OK) sl_multi_mesh_forget_world(s);
    return status;
}

/* Lights and objects: what cannot have changed stays as it is, all else is seen until it is renewed. */
static sl_status edit_world(sl_multi_mesh_state *s, unsigned changes, sl_error *error) {
    bool followed = false;
    s->done_count = 0;
    s->world++;
    if (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) s->lit = s->world;
    s->judged = false;
    if (!s->change_waits) s->change_world = s->world;
    s->change_waits = true;
    sl_status status = s->raster && !s->full ? sl_multi_mesh_follow(s, changes, &followed, error) : SL_OK;
    if (status == SL_OK && !followed) return make_anew(s, error);
    if (status == SL_OK) return SL_OK;
    sl_multi_mesh_forget_view(s);
    sl_multi_mesh_forget_world(s);
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
