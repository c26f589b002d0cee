/* Lights and objects that move. A sample of a light holds unless something moved between the two
 * (cache/light/moves.h), colours of lamps and walls change none; of direct radiance that is what it was the
 * same is true, and indirect light is all a little older. Old values stay to be seen; each update takes some
 * of them again, those that show most and are oldest first, and refines beside that. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <string.h>

#include "base/counters.h"
#include "base/math.h"
#include "base/memory.h"

/* An update's at 512 x 512 pixels: pictures of lights, and vertices, gathers of few pixels, those of all.
 * Together with the coarse mesh's vertices and the leaves that are served they take about as long as a frame
 * at 25 frames a second on two cores: a light sample 20 to 40 us, a gather of few pixels 30 to 60, one of
 * all 350, a coarse vertex's direct light 5. */
enum {
    PICTURES = 1024,
    QUICK_SAMPLES = 8192, /* in pictures, too: all that a frame shows, mostly */
    VERTICES = 16384,
    QUICK_GATHERS = 512,
    GATHERS = 64,
    A_SLICE = 64
};

/* ---- the world as it is now, beside what is left of the old one ---- */

/* Raster and rays stay where nothing has moved. */
static sl_status renew_world(sl_multi_mesh_state *s, unsigned changes, sl_mesh_world *old, sl_error *error) {
    const unsigned threads = s->settings.threads;
    const bool moved = changes & SL_CHANGED_OBJECTS;
    *old = s->now;
    s->now = (sl_mesh_world){.tracer = moved ? NULL : old->tracer};
    if (!moved) old->tracer = NULL;
    sl_status status = moved ? sl_raster_move(s->raster, threads, error) : SL_OK;
    if (status == SL_OK && moved && s->plan.lights)
        status = sl_tracer_create(s->scene, threads, NULL, &s->now.tracer, error);
    if (status == SL_OK) status = sl_object_places_take(s->scene, &s->now.places, error);
    if (status == SL_OK && s->plan.lights) status = sl_multi_mesh_make_sampling(s, error);
    sl_solids_edit(s->primitives->solids);
    sl_multi_mesh_set_perception(s);
    for (int i = 0; i < SL_COMPONENTS; i++)
        if (s->part[i]) s->part[i]->settings.perception = s->perception;
    sl_multi_mesh_forget_eyes(&s->whole);
    sl_multi_mesh_forget_eyes(&s->next);
    return status;
}

/* ---- what still holds ---- */

/* Probes may see what has come between a leaf's corners. */
static bool leaf_holds(const void *context, const sl_patches *mesh, const sl_patch_place *leaf) {
    const sl_changed_lights *h = context;
    if (sl_has_triangle_moved(h->moves, leaf->root / 2)) return false;
    sl_vec3 corner[3], middle = sl_v3(0.0f, 0.0f, 0.0f);
    double reach = 0.0;
    for (int c = 0; c < 3; c++) {
        corner[c] = sl_root_position(mesh->primitives, leaf->root, leaf->u[c], leaf->v[c]);
        middle = sl_mad(middle, 1.0f / 3.0f, corner[c]);
    }
    for (int c = 0; c < 3; c++) reach = fmax(reach, (double)sl_length(sl_sub(corner[c], middle)));
    return !sl_lights_may_differ(h, middle, reach + h->reach);
}

/* moves NULL: nothing holds. */
static void age_direct(sl_displayed *d, const sl_light_moves *moves, double reach) {
    const sl_changed_lights h = {moves, 0, moves ? moves->lights->count : 0, reach};
    /* of lights of another colour each sample holds, and no sum of them */
    const sl_mesh_check check = {sl_mesh_value_holds, &h};
    sl_displayed_age(d, SL_WORLDS_AN_EDIT, moves && !moves->recoloured ? &check : NULL);
    if (moves) sl_displayed_doubt(d, &(sl_leaf_check){leaf_holds, &h});
}

static sl_status age(sl_multi_mesh_state *s, const sl_light_moves *moves, sl_error *error) {
    const double reach = s->now.sampling ? 10.0 * sl_light_sampling_step(s->now.sampling) : 0.0;
    for (int i = 0; i < SL_INDIRECT; i++)
        if (s->part[i]) age_direct(s->part[i], moves, reach);
    if (s->part[SL_INDIRECT]) sl_displayed_age(s->part[SL_INDIRECT], SL_WORLDS_AN_EDIT, NULL);
    if (!s->irradiance) return SL_OK;
    s->light = sl_multi_mesh_irradiance_settings(s);
    return sl_irradiance_meshes_follow(s->irradiance, &s->light, moves, error);
}

/* Other tolerances, other samples. */
static bool same_tolerances(const sl_multi_mesh_state *s, const sl_mesh_world *old) {
    return s->scale == s->scene->scale &&
           (!s->now.sampling ||
            sl_light_sampling_step(old->sampling) == sl_light_sampling_step(s->now.sampling));
}

static sl_status compare(sl_multi_mesh_state *s, const sl_mesh_world *old, bool *followed, sl_error *error) {
    sl_light_moves *moves = NULL;
    sl_status status = SL_OK;
    if (s->plan.lights) {
        status = sl_light_moves_find(s->scene, old->places, s->now.places, old->lights, s->now.lights, &moves,
                                     error);
        *followed = moves;
    }
    if (status == SL_OK && *followed) status = age(s, same_tolerances(s, old) ? moves : NULL, error);
    sl_light_moves_destroy(moves);
    s->scale = s->scene->scale;
    return status;
}

/* Tells whether the meshes are those of the plan: where all was dark the indirect one is not. */
static bool is_planned_so(const sl_multi_mesh_state *s) {
    const sl_multi_mesh_plan now = sl_multi_mesh_plan_make(s->scene);
    return memcmp(&now, &s->plan, sizeof now) == 0;
}

sl_status sl_multi_mesh_follow(sl_multi_mesh_state *s, unsigned changes, bool *followed, sl_error *error) {
    sl_mesh_world old;
    *followed = is_planned_so(s);
    if (!*followed) return SL_OK;
    sl_status status = renew_world(s, changes, &old, error);
    if (status == SL_OK) status = compare(s, &old, followed, error);
    if (status != SL_OK || !*followed) { /* they may hold the old lights still */
        sl_irradiance_meshes_destroy(s->irradiance);
        s->irradiance = NULL;
    }
    sl_mesh_world_forget(&old);
    return status;
}

/* ---- what is renewed ---- */

/* In pictures of lights: sixteen rays take no longer than one of them. */
static uint64_t work_done(const sl_multi_mesh_state *s) {
    return s->counters.value[SL_COUNT_RASTER_PASSES] + s->counters.value[SL_COUNT_SHADOW_RAYS] / 16;
}

static sl_status renew_slice(sl_multi_mesh_state *s, sl_component part, size_t count,
                             const sl_old_vertex *old, sl_error *error) {
    sl_wanted_vertex wanted[A_SLICE];
    for (size_t i = 0; i < count; i++) {
        sl_patch_place leaf = sl_patch_place_of(s->part[part]->mesh, old[i].leaf);
        wanted[i] = (sl_wanted_vertex){old[i].vertex, sl_displayed_wanted_depth(s->part[part], &leaf)};
    }
    return sl_multi_mesh_sample(s, part, count, wanted, error);
}

/* Returns in which of the method's worlds a value was taken. */
static uint32_t world_of(const sl_multi_mesh_state *s, sl_component part, uint32_t vertex) {
    return s->world - (s->part[part]->world - s->part[part]->world_of[vertex]) / SL_WORLDS_AN_EDIT;
}

/* As many slices as the shares of work and of vertices allow; what is left is counted. */
static sl_status renew_part(sl_multi_mesh_state *s, sl_component part, uint32_t world, size_t work,
                            size_t most, sl_error *error) {
    sl_old_vertex *old;
    size_t count, at = 0;
    const uint64_t end = work_done(s) + sl_multi_mesh_share(s, work);
    sl_status status = sl_displayed_list_old(s->part[part], world, &old, &count, error);
    while (status == SL_OK && at < count && at < most && work_done(s) < end) {
        size_t some = sl_fewer(sl_fewer(count - at, most - at), A_SLICE);
        status = renew_slice(s, part, some, old + at, error);
        at += some;
    }
    s->old_left += count - at;
    for (; status == SL_OK && part != SL_INDIRECT && at < count; at++)
        s->oldest_left = s->oldest_left < world_of(s, part, old[at].vertex)
                             ? s->oldest_left
                             : world_of(s, part, old[at].vertex);
    sl_free(old);
    return status;
}

/* Through few pixels as long as there are older ones, or the coarse mesh is of another world. */
static sl_status renew_indirect(sl_multi_mesh_state *s, sl_error *error) {
    sl_displayed *d = s->part[SL_INDIRECT];
    const bool of_now = sl_coarse_is_of_now(s), has_quick = sl_multi_mesh_has_quick(s);
    const size_t before = s->old_left;
    d->put_as = d->world - 1;
    sl_status status = SL_OK;
    if (!of_now || has_quick)
        status = renew_part(s, SL_INDIRECT, d->world - 1, PICTURES, sl_multi_mesh_share(s, QUICK_GATHERS),
                            error);
    if (status != SL_OK || s->old_left > before || !of_now) return status;
    d->put_as = d->world;
    return renew_part(s, SL_INDIRECT, d->world, PICTURES,
                      sl_multi_mesh_share(s, has_quick ? GATHERS : QUICK_GATHERS), error);
}

/* Light of lamps on diffuse surfaces by few rays while one move comes after another. */
static sl_status renew_direct(sl_multi_mesh_state *s, sl_component part, bool at_rest, sl_error *error) {
    sl_displayed *d = s->part[part];
    const bool quick = part == SL_DIRECT_DIFFUSE && s->moves && !at_rest;
    d->put_as = quick ? d->world - 1 : d->world;
    return renew_part(s, part, d->put_as, quick ? QUICK_SAMPLES : PICTURES, sl_multi_mesh_share(s, VERTICES),
                      error);
}

sl_status sl_multi_mesh_renew(sl_multi_mesh_state *s, sl_error *error) {
    sl_status status = SL_OK;
    const bool at_rest = sl_multi_mesh_rests(s);
    s->oldest_left = s->world;
    s->old_left = 0;
    s->mixed = false;
    if (s->world == 1) return SL_OK;
    for (int i = 0; i < SL_INDIRECT && status == SL_OK; i++)
        if (sl_multi_mesh_takes_part(s, i)) status = renew_direct(s, (sl_component)i, at_rest, error);
    if (status == SL_OK && s->change_waits && s->oldest_left >= s->change_world) {
        s->change_waits = false;
        sl_count(&s->counters, SL_COUNT_CHANGES_SHOWN, 1);
    }
    const size_t direct_left = s->old_left;
    if (status == SL_OK && sl_multi_mesh_takes_part(s, SL_INDIRECT)) status = renew_indirect(s, error);
    s->mixed = at_rest && s->old_left > direct_left;
    for (int i = 0; i < SL_COMPONENTS && status == SL_OK; i++)
        if (s->part[i]) sl_displayed_settle(s->part[i], &s->counters);
    return status;
}
