/* What stays of a picture when the scene changes. Each light has a mesh of its own, of shares that its colour
 * turns into irradiance: where power or colours alone change no direct light is sampled again, but where
 * other thresholds ask for finer meshes. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <string.h>

#include "base/memory.h"

static bool is_same_light(const sl_sampled_light *a, const sl_sampled_light *b) {
    return a->kind == b->kind && a->triangles == b->triangles && a->scene_light == b->scene_light &&
           a->two_sided == b->two_sided &&
           (!a->triangles || memcmp(a->triangle, b->triangle, a->triangles * sizeof *a->triangle) == 0);
}

/* Gives the lights the colours that they have now. False: they are others, in number or in what belongs
 * together. */
static sl_status colour_lights(sl_multi_mesh_state *s, bool *same, sl_error *error) {
    sl_sampled_lights *now;
    sl_status status = sl_sampled_lights_find(s->scene, &now, error);
    if (status != SL_OK) return status;
    *same = now->count == s->lights->count;
    for (size_t l = 0; l < now->count && *same; l++)
        *same = is_same_light(&now->light[l], &s->lights->light[l]);
    for (size_t l = 0; l < now->count && *same; l++) {
        s->lights->light[l].colour = now->light[l].colour;
        s->lights->light[l].radiance = now->light[l].radiance;
    }
    sl_sampled_lights_destroy(now);
    return SL_OK;
}

/* All but what is known of each light by itself is made anew. */
static sl_status colour_world(sl_multi_mesh_state *s, sl_error *error) {
    sl_status status = SL_OK;
    sl_multi_mesh_forget_parts(s);
    sl_multi_mesh_set_perception(s);
    if (s->irradiance) {
        s->light = sl_multi_mesh_irradiance_settings(s);
        sl_irradiance_meshes_judge(s->irradiance, &s->light);
    }
    sl_free(s->coarse_indirect);
    s->coarse_indirect = NULL;
    if (s->coarse) s->coarse->reflectance_known = false;
    if (s->plan.indirect) status = sl_multi_mesh_make_coarse(s, error);
    return status == SL_OK ? sl_multi_mesh_make_parts(s, error) : status;
}

static sl_status edit_world(sl_multi_mesh_state *s, unsigned changes, sl_error *error) {
    bool same = !(changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) && s->raster && !s->light.few_rays &&
                !s->settings.memory_bytes; /* what is kept would leave less for what is new */
    sl_status status = same && s->lights ? colour_lights(s, &same, error) : SL_OK;
    sl_multi_mesh_forget_view(s);
    s->full = false;
    s->done_count = 0;
    s->plan = sl_multi_mesh_plan_make(s->scene, &s->settings); /* light may fall where none fell */
    if (status == SL_OK && same) status = colour_world(s, error);
    if (!same) sl_multi_mesh_forget_world(s);
    if (status == SL_OK && !same) status = sl_multi_mesh_make_world(s, error);
    if (status != SL_OK) sl_multi_mesh_forget_world(s);
    return status;
}

/* The eye: specular radiance starts again, all else stays. Lights and objects: all starts again. */
sl_status sl_multi_mesh_edit(void *state, unsigned changes, sl_error *error) {
    sl_multi_mesh_state *s = state;
    s->phase = SL_PHASE_VIEW;
    if (changes & ~(unsigned)SL_CHANGED_CAMERA) return edit_world(s, changes, error);
    if (s->part[SL_DIRECT_SPECULAR]) sl_displayed_restart(s->part[SL_DIRECT_SPECULAR]);
    return SL_OK;
}
