/* One picture, in the order of the paper (Vivanloc, Hoelt, Hong, Paulin 2007): photons are traced and kept,
 * the octree's leaves take the nearest of them, K-means condenses their directions to a few virtual
 * directional lights, two textures hold octree and lights, and the pixels are shaded as by any other lights:
 *
 *     E = kappa sum Phi_i / A          from the k nearest photons, over the surface A that they lie on
 *     L = sum f_r(d_j, v, n) c_j (n . d_j)+     over a voxel's lights (c_j, d_j), then trilinearly over
 * voxels
 *
 * Each depth of the octree from 4 on is shown as soon as it is done. The paper numbers no equations. */
#include "cache/light_octree/light_octree.h"

#include <stdio.h>

#include "base/math.h"

enum { LEAVES = 4096 }; /* an update's */

/* ---- Photon map ---- */

static void next_level(sl_octree_state *s) {
    s->depth = s->shown.octree->depth + 1;
    s->phase = s->depth <= s->settings.light_octree.depth ? SL_OCTREE_PHASE_OCTREE : SL_OCTREE_PHASE_DONE;
}

/* With the one that is shown; after one of a scene in motion with a deeper one, if there is to be any. */
static void go_on_with_levels(sl_octree_state *s) {
    const bool whole = s->shown.octree && !s->motion.shown;
    const int deepest = s->settings.light_octree.depth;
    s->depth = s->plan.first_depth + (s->motion.shown && s->plan.first_depth < deepest);
    s->phase = SL_OCTREE_PHASE_OCTREE;
    if (whole && s->lit) next_level(s);
    else if (whole) s->phase = SL_OCTREE_PHASE_SHADE;
}

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
    go_on_with_levels(s);
    return SL_OK;
}

sl_photon_options sl_octree_photon_options(const sl_octree_state *s) {
    return (sl_photon_options){.stored = s->settings.light_octree.photons,
                               .store = s->settings.light_octree.store,
                               .sky = s->sky.present ? &s->sky : NULL,
                               .seed = s->settings.seed,
                               .threads = s->settings.threads};
}

static sl_status trace_photons(sl_octree_state *s, sl_error *error) {
    if (!s->plan.photons) {
        s->phase = SL_OCTREE_PHASE_DONE;
        return SL_OK;
    }
    if (s->tree) { /* of an earlier view */
        go_on_with_levels(s);
        return SL_OK;
    }
    const sl_photon_options options = sl_octree_photon_options(s);
    bool done = false;
    sl_status status =
        sl_photons_trace(s->scene, s->tracer, &options, sl_octree_photon_chunks(&s->settings), &s->photons,
                         &done, &s->counters, error);
    return status == SL_OK && done ? finish_photons(s, error) : status;
}

/* ---- Octree ---- */

/* Of a scattered scene the central region, unless most photons lie elsewhere: where there is light, it is to
 * be seen. */
static sl_octree_root root_of(const sl_scene *scene, const sl_photon_tree *tree) {
    const sl_photon_list *photons = sl_photon_tree_list(tree);
    const sl_octree_root central = sl_octree_root_of_central_region(scene);
    size_t inside = 0;
    for (size_t i = 0; i < photons->count; i++) {
        const float *p = photons->photon[i].position;
        inside += sl_octree_root_holds(&central, sl_v3(p[0], p[1], p[2]));
    }
    return 2 * inside >= photons->count ? central : sl_octree_root_of_all(scene);
}

static void show_level(sl_octree_state *s) {
    sl_octree_forget_level(&s->shown);
    s->shown = s->next;
    s->next = (sl_octree_level){NULL, NULL, NULL};
    s->phase = SL_OCTREE_PHASE_SHADE;
    if (s->shown.lights->tree == s->tree) sl_octree_forget_slices(&s->motion);
}

static sl_status start_level(sl_octree_state *s, const sl_photon_tree *tree, int depth, sl_error *error) {
    const sl_light_octree_settings *o = &s->settings.light_octree;
    unsigned threads = s->settings.threads;
    const sl_octree_root root = root_of(s->scene, tree);
    sl_status status =
        sl_octree_create(s->scene, &root, depth, o->dilation, threads, &s->next.octree, error);
    if (status != SL_OK) return status;
    sl_announce_pass(&s->announcer, "octree", "octree, K-means of its photons");
    s->leaf = 0;
    status = sl_voxel_lights_create(s->scene, s->next.octree, tree, o, threads, &s->next.lights, error);
    if (status != SL_OK) sl_octree_forget_level(&s->next);
    else if (o->photons_at_pixels) show_level(s); /* no lights in between */
    else s->phase = SL_OCTREE_PHASE_LIGHTS;
    return status;
}

/* ---- Octree texture: bricks of nodes, and a texture of lights ---- */

static sl_status finish_level(sl_octree_state *s, sl_error *error) {
    const sl_octree_level *n = &s->next;
    sl_status status = sl_voxel_texture_create(n->octree, n->lights, &s->next.texture, error);
    if (status != SL_OK) return status;
    show_level(s);
    sl_octree_announce_lights(&s->announcer, s->shown.octree, s->shown.lights);
    s->lit = false;
    if (s->canvas) s->canvas->filled[SL_ATLAS_FRONT] = s->canvas->filled[SL_ATLAS_BACK] = false;
    return status;
}

static sl_status light_leaves(sl_octree_state *s, sl_error *error) {
    size_t count = sl_fewer(s->next.octree->leaf_count - s->leaf, LEAVES);
    sl_voxel_lights_compute(s->next.lights, s->leaf, count, s->settings.threads, &s->counters);
    s->leaf += count;
    return s->leaf == s->next.octree->leaf_count ? finish_level(s, error) : SL_OK;
}

sl_status sl_octree_show_level_of(sl_octree_state *s, const sl_photon_tree *tree, int depth,
                                  sl_error *error) {
    sl_status status = start_level(s, tree, depth, error);
    while (status == SL_OK && s->phase != SL_OCTREE_PHASE_SHADE) status = light_leaves(s, error);
    if (status != SL_OK) sl_octree_forget_level(&s->next);
    return status;
}

/* ---- Rendering: pixels from the octree, or by way of a texture atlas ---- */

/* Makes the atlas once; its light is that of the octree that is shown. */
static sl_status ready_atlas(sl_octree_state *s, sl_error *error) {
    if (!s->settings.light_octree.atlas || s->canvas) return SL_OK;
    sl_atlas *atlas = NULL;
    sl_status status = sl_atlas_create(s->scene, s->settings.light_octree.atlas_size, &atlas, error);
    if (status == SL_OK)
        status = sl_atlas_canvas_create(atlas, s->scene, s->settings.threads, &s->canvas, error);
    sl_announce_pass(&s->announcer, "atlas", "render to texture atlas");
    return status;
}

sl_octree_pixels sl_octree_pixels_of(const sl_octree_state *s, const sl_octree_shading *shading, bool moves) {
    return (sl_octree_pixels){.scene = s->scene,
                              .gbuffer = s->gbuffer,
                              .reflections = s->reflections,
                              .shading = shading,
                              .canvas = s->canvas,
                              .eye = s->scene->camera.eye,
                              .moves = moves && !s->canvas,
                              .threads = s->settings.threads};
}

static sl_status light_pixels(sl_octree_state *s, bool moves, sl_error *error) {
    const sl_octree_shading shading = sl_octree_state_shading(s);
    const sl_octree_pixels pixels = sl_octree_pixels_of(s, &shading, moves);
    return sl_octree_light_pixels(&pixels, s->indirect_light, &s->counters, error);
}

void sl_octree_show_light(sl_octree_state *s, bool lit) {
    char name[48];
    s->lit = lit;
    s->fresh = true;
    if (s->settings.light_octree.photons_at_pixels)
        snprintf(name, sizeof name, "indirect light, photons at pixels");
    else snprintf(name, sizeof name, "indirect light, depth %d", s->shown.octree->depth);
    sl_octree_announce_picture(s, name, "light from the octree", s->indirect_light[0]);
}

sl_status sl_octree_light_picture(sl_octree_state *s, bool moves, sl_error *error) {
    bool gathered = s->settings.light_octree.photons_at_pixels;
    sl_status status = SL_OK;
    if (gathered)
        sl_photons_light_pixels(s->scene, s->gbuffer, s->shown.lights, s->settings.threads, s->indirect_light,
                                &s->counters);
    else status = light_pixels(s, moves, error);
    if (status == SL_OK) sl_octree_show_light(s, gathered || !moves || s->canvas);
    return status;
}

static sl_status shade(sl_octree_state *s, sl_error *error) {
    sl_status status = s->settings.light_octree.photons_at_pixels ? SL_OK : ready_atlas(s, error);
    if (status == SL_OK) status = sl_octree_light_picture(s, false, error);
    if (status == SL_OK) next_level(s);
    return status;
}

/* ---- One after the other, and again with each deeper octree ---- */

sl_status sl_octree_step(sl_octree_state *s, sl_error *error) {
    switch (s->phase) {
    case SL_OCTREE_PHASE_GBUFFER: return sl_octree_draw_gbuffer(s, error);
    case SL_OCTREE_PHASE_DIRECT: return sl_octree_light_rows(s, error);
    case SL_OCTREE_PHASE_PHOTONS: return trace_photons(s, error);
    case SL_OCTREE_PHASE_OCTREE: return start_level(s, s->tree, s->depth, error);
    case SL_OCTREE_PHASE_LIGHTS: return light_leaves(s, error);
    case SL_OCTREE_PHASE_SHADE: return shade(s, error);
    case SL_OCTREE_PHASE_DONE: return SL_OK;
    }
    return SL_OK;
}
