/* One picture, pass by pass (their names are those of light_octree.h), and again with each deeper octree.
 *
 *   G-buffer ── direct light ── photons ── tree ── octree ─┬─ lights of its voxels ── textures ── pixels ─┬─
 * done what mirrors show                                      └──────────── one level deeper
 * ────────────────┘
 */
#include "base/error.h"
#include "cache/light_octree/photon_pixels.h"
#include "cache/light_octree/state.h"
#include "cache/light_octree/explanation.h"

#include <stdio.h>
#include <string.h>

enum {
    DIRECT_ROWS = 64,  /* an update's */
    LEAVES = 4096
};

static void announce_picture(sl_octree_state *s, const char *name, const char *source, const float *planes) {
    sl_announce(&s->announcer, name, source, s->settings.width, s->settings.height, 3, planes, true);
}

void sl_octree_forget_level(sl_octree_level *level) {
    sl_voxel_texture_destroy(level->texture);
    sl_voxel_lights_destroy(level->lights);
    sl_octree_destroy(level->octree);
    *level = (sl_octree_level){NULL, NULL, NULL};
}

/* ---- the view ---- */

static sl_status draw_gbuffer(sl_octree_state *s, sl_error *error) {
    sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    sl_status status =
        sl_raster_gbuffer(s->raster, &view, s->settings.threads, s->gbuffer, &s->counters, error);
    sl_reflections_destroy(s->reflections);
    s->reflections = NULL;
    if (status == SL_OK && s->plan.mirrors && s->settings.light_octree.environment_mirrors)
        status = sl_reflect_environment(s->scene, s->cube, s->settings.threads, s->gbuffer, &s->reflections,
                                        &s->counters, error);
    else if (status == SL_OK && s->plan.mirrors)
        status = sl_reflect_pixels(s->scene, s->tracer, s->settings.threads, s->gbuffer, &s->reflections,
                                   &s->counters, error);
    if (status != SL_OK) return status;
    sl_announce_gbuffer(&s->announcer, "direct light beside the octree", s->gbuffer);
    s->lit = false;
    memset(s->planes, 0, SL_OCTREE_PLANES * sl_octree_state_pixels(s) * sizeof *s->planes);
    s->direct_row = 0;
    s->phase = s->plan.direct ? SL_OCTREE_PHASE_DIRECT : SL_OCTREE_PHASE_PHOTONS;
    return status;
}

static sl_status light_rows(sl_octree_state *s, sl_error *error) {
    int end =
        s->direct_row + DIRECT_ROWS < s->settings.height ? s->direct_row + DIRECT_ROWS : s->settings.height;
    sl_status status = sl_direct_rows(s->direct, s->gbuffer, s->direct_row, end, s->direct_light[0],
                                      s->direct_light[1], s->direct_light[2], &s->counters, error);
    if (status != SL_OK) return status;
    s->direct_row = end;
    if (end < s->settings.height) return status;
    announce_picture(s, "direct light", "direct light beside the octree", s->direct_light[0]);
    s->phase = SL_OCTREE_PHASE_PHOTONS;
    return status;
}

/* ---- P1, P2: photons ---- */

static sl_status finish_photons(sl_octree_state *s, sl_error *error) {
    sl_announce_pass(&s->announcer, "photons", "photon map");
    sl_photon_list *list = s->photons;
    if (list) sl_octree_announce_photons(&s->announcer, list);
    s->photons = NULL;
    if (!list || !list->count) {
        sl_photon_list_destroy(list);
        s->phase = SL_OCTREE_PHASE_DONE;
        return SL_OK;
    }
    sl_status status = sl_photon_tree_create(list, s->settings.threads, &s->tree, error);
    if (status != SL_OK) return status; /* without photons again */
    s->phase = SL_OCTREE_PHASE_OCTREE;
    s->depth = s->plan.first_depth;
    return SL_OK;
}

static sl_status trace_photons(sl_octree_state *s, sl_error *error) {
    if (!s->plan.photons) {
        s->phase = SL_OCTREE_PHASE_DONE;
        return SL_OK;
    }
    if (s->tree) { /* of an earlier view */
        s->phase = s->shown.octree ? SL_OCTREE_PHASE_SHADE : SL_OCTREE_PHASE_OCTREE;
        return SL_OK;
    }
    sl_photon_options options = {.stored = s->settings.light_octree.photons,
                                 .store = s->settings.light_octree.store,
                                 .sky = s->sky.present ? &s->sky : NULL,
                                 .seed = s->settings.seed,
                                 .threads = s->settings.threads};
    bool done = false;
    sl_status status = sl_photons_trace(s->scene, s->tracer, &options, sl_octree_photon_chunks(&s->settings),
                                        &s->photons, &done, &s->counters, error);
    return status == SL_OK && done ? finish_photons(s, error) : status;
}

/* ---- G1: the octree, from the shallowest that is shown ---- */

sl_voxel_light_options sl_octree_light_options(const sl_light_octree_settings *o, double radius) {
    return (sl_voxel_light_options){.neighbours = (size_t)o->neighbours,
                                    .radius = radius,
                                    .flatness = o->flatness,
                                    .acceptance = o->acceptance,
                                    .area = o->area,
                                    .lobes = o->lobes,
                                    .lights = o->lights,
                                    .unit_weights = o->unit_weights,
                                    .own_photons = o->own_photons,
                                    .split_by_normal = !o->whole_voxels && !o->own_photons,
                                    .estimated_radius = !o->fixed_neighbours};
}

/* Of a scattered scene the central region, unless most photons lie elsewhere: where there is light, it is to
 * be seen. */
static sl_octree_root root_of(const sl_octree_state *s) {
    const sl_photon_list *photons = sl_photon_tree_list(s->tree);
    const sl_octree_root core = sl_octree_root_of_core(s->scene);
    size_t inside = 0;
    for (size_t i = 0; i < photons->count; i++) {
        const float *p = photons->photon[i].position;
        inside += sl_octree_root_holds(&core, sl_v3(p[0], p[1], p[2]));
    }
    return 2 * inside >= photons->count ? core : sl_octree_root_of_all(s->scene);
}

static sl_status start_level(sl_octree_state *s, sl_error *error) {
    const sl_light_octree_settings *o = &s->settings.light_octree;
    unsigned threads = s->settings.threads;
    const sl_octree_root root = root_of(s);
    sl_status status =
        sl_octree_create_in(s->scene, &root, s->depth, o->dilation, threads, &s->next.octree, error);
    if (status != SL_OK) return status;
    sl_announce_pass(&s->announcer, "octree", "octree, K-means of its photons");
    s->leaf = 0;
    s->radius = o->radius > 0.0 ? o->radius
                                : sl_voxel_radius(s->next.octree, (size_t)o->neighbours,
                                                  sl_photon_tree_list(s->tree)->count);
    if (o->photons_at_pixels) { /* no lights in between */
        sl_octree_forget_level(&s->shown);
        s->shown = s->next;
        s->next = (sl_octree_level){NULL, NULL, NULL};
        s->phase = SL_OCTREE_PHASE_SHADE;
        return status;
    }
    sl_voxel_light_options options = sl_octree_light_options(o, s->radius);
    status = sl_voxel_lights_create(s->scene, s->next.octree, s->next.octree, s->tree, &options, threads,
                                    &s->next.lights, error);
    if (status == SL_OK) s->phase = SL_OCTREE_PHASE_LIGHTS;
    else sl_octree_forget_level(&s->next);
    return status;
}

/* ---- P3 to P5: lights of the voxels, and their textures ---- */

static sl_status finish_level(sl_octree_state *s, sl_error *error) {
    const sl_octree_level *n = &s->next;
    bool dense = n->octree->depth <= 7; /* an index of 8 MiB at most */
    sl_status status = sl_voxel_texture_create(n->octree, n->lights, dense, &s->next.texture, error);
    if (status != SL_OK) return status;
    sl_octree_forget_level(&s->shown);
    s->shown = s->next;
    s->next = (sl_octree_level){NULL, NULL, NULL};
    sl_octree_announce_lights(&s->announcer, s->shown.octree, s->shown.lights);
    s->lit = false;
    if (s->atlas) s->atlas->filled[SL_ATLAS_FRONT] = s->atlas->filled[SL_ATLAS_BACK] = false;
    s->phase = SL_OCTREE_PHASE_SHADE;
    return status;
}

static sl_status light_leaves(sl_octree_state *s, sl_error *error) {
    size_t left = s->next.octree->leaf_count - s->leaf, count = left < LEAVES ? left : LEAVES;
    sl_voxel_lights_compute(s->next.lights, s->leaf, count, s->settings.threads, &s->counters);
    s->leaf += count;
    return s->leaf == s->next.octree->leaf_count ? finish_level(s, error) : SL_OK;
}

/* ---- R1: pixels ---- */

static sl_status gather_at_pixels(sl_octree_state *s, sl_error *error) {
    sl_photon_pixels pixels = {.scene = s->scene,
                               .gbuffer = s->gbuffer,
                               .octree = s->shown.octree,
                               .tree = s->tree,
                               .settings = &s->settings.light_octree,
                               .radius = s->radius,
                               .threads = s->settings.threads};
    return sl_photon_light_pixels(&pixels, s->indirect_light, &s->counters, error);
}

/* G2 to G4 once; its light is that of the octree that is shown. */
static sl_status ready_atlas(sl_octree_state *s, sl_error *error) {
    if (!s->settings.light_octree.atlas || s->atlas) return SL_OK;
    sl_status status = sl_lit_atlas_create(s->scene, s->settings.light_octree.atlas_size, s->settings.threads,
                                           &s->atlas, error);
    sl_announce_pass(&s->announcer, "atlas", "render to texture atlas");
    return status;
}

/* A whole voxel's normal is the mean of what is in it: to weigh by it does harm. */
sl_octree_shading sl_octree_shading_of(const sl_light_octree_settings *o, const sl_voxel_texture *texture) {
    bool split = !o->whole_voxels && !o->own_photons;
    return (sl_octree_shading){.texture = texture,
                               .filter = o->filter,
                               .keep_void_dark = o->keep_void_dark,
                               .facing = split && !o->keep_void_dark};
}

sl_octree_shading sl_octree_state_shading(const sl_octree_state *s) {
    return sl_octree_shading_of(&s->settings.light_octree, s->shown.texture);
}

static sl_status light_pixels(sl_octree_state *s, sl_error *error) {
    sl_octree_shading shading = sl_octree_state_shading(s);
    sl_octree_pixels pixels = {.scene = s->scene,
                               .gbuffer = s->gbuffer,
                               .reflections = s->reflections,
                               .shading = &shading,
                               .atlas = s->atlas,
                               .eye = s->scene->camera.eye,
                               .threads = s->settings.threads};
    return sl_octree_light_pixels(&pixels, s->indirect_light, &s->counters, error);
}

static sl_status shade(sl_octree_state *s, sl_error *error) {
    char name[48];
    int depth = s->shown.octree->depth;
    bool gathered = s->settings.light_octree.photons_at_pixels;
    sl_status status = gathered ? gather_at_pixels(s, error) : ready_atlas(s, error);
    if (status == SL_OK && !gathered) status = light_pixels(s, error);
    if (status != SL_OK) return status;
    s->lit = true;
    if (gathered) snprintf(name, sizeof name, "indirect light, photons at pixels");
    else snprintf(name, sizeof name, "indirect light, depth %d", depth);
    announce_picture(s, name, "light from the octree", s->indirect_light[0]);
    s->depth = depth + 1;
    s->phase = s->depth <= s->settings.light_octree.depth ? SL_OCTREE_PHASE_OCTREE : SL_OCTREE_PHASE_DONE;
    return status;
}

/* ---- one after the other ---- */

sl_status sl_octree_step(sl_octree_state *s, sl_error *error) {
    switch (s->phase) {
    case SL_OCTREE_PHASE_GBUFFER: return draw_gbuffer(s, error);
    case SL_OCTREE_PHASE_DIRECT: return light_rows(s, error);
    case SL_OCTREE_PHASE_PHOTONS: return trace_photons(s, error);
    case SL_OCTREE_PHASE_OCTREE: return start_level(s, error);
    case SL_OCTREE_PHASE_LIGHTS: return light_leaves(s, error);
    case SL_OCTREE_PHASE_SHADE: return shade(s, error);
    case SL_OCTREE_PHASE_DONE: return SL_OK;
    }
    return SL_OK;
}
