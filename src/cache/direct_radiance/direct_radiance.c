/* One frame of Direct Radiance Mapping, in the order of the paper: what the lights see is drawn and kept (the
 * direct radiance map), samples of it are photons that light the scene a second time, and every point seen
 * sums them:
 *
 *     L_o = L_e + direct (5), (9) + indirect (10),    (10): L_r = sum over photons f_r L_o cos theta dw'
 *
 * The steps call the parts; an equation's number stands beside the step that computes it. Everything is
 * computed again for every frame in which it has changed. */
#include "cache/direct_radiance/direct_radiance.h"

#include "base/error.h"
#include "base/memory.h"

#include <math.h>

/* ---- Which passes a scene needs ---- */

void sl_radiance_forget_geometry(sl_radiance_state *s) {
    sl_tracer_destroy(s->tracer);
    sl_raster_destroy(s->raster);
    s->tracer = NULL;
    s->raster = NULL;
    s->placed = false;
}

/* Objects that have moved, and meshes that have changed their shape, cost a walk over the vertices. */
sl_status sl_radiance_place(sl_radiance_state *s, sl_error *error) {
    unsigned threads = s->settings.threads;
    sl_tracer_destroy(s->tracer);
    s->tracer = NULL;
    sl_status status = s->raster ? sl_raster_move(s->raster, threads, error)
                                 : sl_raster_create(s->scene, threads, &s->raster, error);
    if (status == SL_OK) s->plan = sl_radiance_plan_make(s->scene, &s->settings);
    if (status == SL_OK && s->plan.tracer)
        status = sl_tracer_create(s->scene, threads, NULL, &s->tracer, error);
    s->placed = status == SL_OK;
    if (!s->placed) sl_radiance_forget_geometry(s); /* a rasterizer that could not follow is of no use */
    return status;
}

/* ---- Direct illumination: the lights, and depth cubes for their shadows (pass 1) ---- */

void sl_radiance_darken(sl_radiance_state *s) {
    sl_map_photons_destroy(s->photons);
    sl_radiance_map_destroy(s->map);
    sl_map_lights_destroy(s->lights);
    s->photons = NULL;
    s->map = NULL;
    s->lights = NULL;
    s->lit = false;
}

/* Lights are points with an intensity by direction: Phi / 4 pi (3), of area lights Phi cos theta / pi (6),
 * (7). */
static sl_status find_lights(sl_radiance_state *s, sl_error *error) {
    return sl_map_lights_find(s->scene, s->settings.radiance_map.emitter_samples, &s->lights, error);
}

static sl_status draw_depth_cubes(sl_radiance_state *s, sl_error *error) {
    const int size = s->settings.radiance_map.shadow_size;
    sl_status status = sl_map_lights_draw_cubes(s->lights, s->scene, s->raster, size, s->settings.threads,
                                                &s->counters, error);
    sl_announce_pass(&s->announcer, "depth cubes", "shadows in (5), (9)");
    return status;
}

/* ---- The direct radiance map: positions, radiance, normals (pass 2) ---- */

static sl_status draw_map(sl_radiance_state *s, sl_error *error) {
    const sl_radiance_map_options options = {.lambertian = !s->plan.glossy,
                                             .normals = s->plan.normals,
                                             .tracer = s->plan.mirrors ? s->tracer : NULL,
                                             .threads = s->settings.threads};
    sl_status status = sl_radiance_map_render(s->scene, s->raster, s->lights, &s->settings.radiance_map,
                                              &options, &s->map, &s->counters, error);
    if (status == SL_OK) sl_radiance_announce_map(s);
    return status;
}

/* ---- Sampling: M photons of the map, each with its footprint (12), (13) (pass 3) ---- */

static sl_status take_photons(sl_radiance_state *s, sl_error *error) {
    sl_status status =
        sl_map_photons_take(s->scene, s->map, &s->settings.radiance_map, &s->photons, &s->counters, error);
    if (status == SL_OK) sl_announce_photons(&s->announcer, s->photons);
    return status;
}

sl_light_pass sl_radiance_lighting(const sl_radiance_state *s) {
    const sl_radiance_map_settings *m = &s->settings.radiance_map;
    return (sl_light_pass){.scene = s->scene,
                           .lights = s->lights,
                           .photons = s->photons,
                           .weight = m->weight,
                           .tracer = m->visibility == SL_VISIBILITY_NONE ? NULL : s->tracer,
                           .threads = s->settings.threads};
}

/* Measures what arrives of the photons; with visibility no light arrives that ought not to. */
static sl_status measure_received(sl_radiance_state *s, sl_error *error) {
    const sl_light_pass light = sl_radiance_lighting(s);
    s->received = NAN;
    return light.tracer ? SL_OK : sl_flux_received(&light, &s->received, error);
}

sl_status sl_radiance_light_up(sl_radiance_state *s, sl_error *error) {
    sl_status status = find_lights(s, error);
    if (status == SL_OK && s->plan.shadows) status = draw_depth_cubes(s, error);
    if (status == SL_OK && s->plan.map) status = draw_map(s, error);
    if (status == SL_OK && s->plan.map) status = take_photons(s, error);
    if (status == SL_OK && s->plan.map) status = measure_received(s, error);
    s->lit = status == SL_OK;
    if (!s->lit) sl_radiance_darken(s);
    return status;
}

/* ---- The picture: mirrors, direct and indirect illumination (passes 5 to 8) ---- */

/* (5), (9), and (10) with its weights (11), (14), (15), a few rows at a time. */
sl_status sl_radiance_draw(sl_radiance_state *s, sl_error *error) {
    const int width = s->settings.width, height = s->settings.height;
    const sl_view view = sl_view_scene(s->scene, width, height);
    if (!s->id) s->id = sl_allocate((size_t)width * (size_t)height, sizeof *s->id);
    if (!s->id) return sl_fail_memory(error, "what the picture shows");
    const sl_target target = {width, height, s->id, NULL};
    sl_status status = sl_raster_id(s->raster, &view, s->settings.threads, &target, &s->counters, error);
    if (status == SL_OK) status = sl_radiance_draw_image(s, &s->image, &s->counters, error);
    if (status == SL_OK) sl_radiance_announce_light(s);
    return status;
}
