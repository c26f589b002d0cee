/* The method: what it holds, from its creation to its end, and what edits leave of that. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/light_octree/light_octree.h"

/* The sky in the octree rises above its own mean by this factor at most. */
static const double sky_contrast = 10.0;

/* ---- what there is, and its end ---- */

void sl_octree_forget_level(sl_octree_level *level) {
    sl_voxel_texture_destroy(level->texture);
    sl_voxel_lights_destroy(level->lights);
    sl_octree_destroy(level->octree);
    *level = (sl_octree_level){NULL, NULL, NULL};
}

static void forget_light(sl_octree_state *s) {
    sl_octree_forget_level(&s->next);
    sl_octree_forget_level(&s->shown);
    sl_photon_tree_destroy(s->tree);
    sl_photon_list_destroy(s->photons);
    sl_direct_destroy(s->direct);
    sl_environment_release(&s->sky);
    sl_environment_release(&s->sun);
    s->tree = NULL;
    s->photons = NULL;
    s->direct = NULL;
}

static void forget_rays(sl_octree_state *s) {
    sl_atlas_canvas_destroy(s->canvas);
    sl_tracer_destroy(s->tracer);
    s->canvas = NULL;
    s->tracer = NULL;
}

static void forget_geometry(sl_octree_state *s) {
    forget_rays(s);
    sl_raster_destroy(s->raster);
    s->raster = NULL;
}

static void octree_destroy(void *state) {
    sl_octree_state *s = state;
    if (!s) return;
    sl_octree_forget_motion(&s->motion);
    forget_light(s);
    forget_geometry(s);
    sl_reflections_destroy(s->reflections);
    sl_gbuffer_destroy(s->gbuffer);
    SL_FREE_ALL(s->planes, s);
}

static sl_status make_geometry(sl_octree_state *s, sl_error *error) {
    const unsigned threads = s->settings.threads;
    sl_status status = s->raster ? sl_raster_move(s->raster, threads, error)
                                 : sl_raster_create(s->scene, threads, &s->raster, error);
    bool rays = s->plan.photons || (s->plan.mirrors && !s->settings.light_octree.environment_mirrors);
    if (status == SL_OK && rays)
        status = sl_tracer_create(s->scene, threads, NULL, &s->tracer, error);
    return status;
}

const sl_environment *sl_octree_sampled_sky(const sl_octree_state *s) {
    if (!s->plan.sky) return s->plan.environment ? &s->scene->environment : NULL;
    return s->sun.present ? &s->sun : NULL;
}

static sl_status make_light(sl_octree_state *s, sl_error *error) {
    sl_status status = SL_OK;
    if (!s->plan.direct) return status;
    if (s->plan.sky)
        status = sl_environment_split(&s->scene->environment, sky_contrast, &s->sky, &s->sun, error);
    if (status != SL_OK) return status;
    sl_direct_settings direct = {.light_samples = s->settings.spp,
                                 .seed = s->settings.seed,
                                 .threads = s->settings.threads,
                                 .sun = sl_octree_sampled_sky(s)};
    return sl_direct_create(s->scene, s->tracer, &direct, &s->direct, error);
}

static sl_status octree_create(const sl_scene *scene, const sl_settings *settings,
                               const sl_transport *transport, void **state, sl_error *error) {
    (void)transport; /* its own: sl_octree_transport() */
    sl_octree_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the light octree");
    s->scene = scene;
    s->settings = *settings;
    s->announcer =
        (sl_announcer){.observer = settings->observer, .method = "light-octree", .counters = &s->counters};
    s->plan = sl_octree_plan_make(scene, settings);
    s->planes = sl_allocate(SL_OCTREE_PLANES * sl_settings_pixels(&s->settings), sizeof *s->planes);
    sl_status status = s->planes ? sl_gbuffer_create(settings->width, settings->height, &s->gbuffer, error)
                                 : sl_fail_memory(error, "the picture");
    if (status == SL_OK) status = make_geometry(s, error);
    if (status == SL_OK) status = make_light(s, error);
    if (status != SL_OK) {
        octree_destroy(s);
        return status;
    }
    for (size_t k = 0; k < 3; k++) {
        s->direct_light[k] = s->planes + k * sl_settings_pixels(&s->settings);
        s->indirect_light[k] = s->planes + (3 + k) * sl_settings_pixels(&s->settings);
    }
    *state = s;
    return SL_OK;
}

/* ---- settings of the parts ---- */

/* A whole voxel's normal is the mean of what is in it: to weigh by it does harm. */
sl_octree_shading sl_octree_state_shading(const sl_octree_state *s) {
    const sl_light_octree_settings *o = &s->settings.light_octree;
    bool split = !o->whole_voxels && !o->own_photons;
    return (sl_octree_shading){.texture = s->shown.texture,
                               .filter = o->filter,
                               .keep_void_dark = o->keep_void_dark,
                               .facing = split && !o->keep_void_dark};
}

/* ---- what is seen, and direct light: other passes, beside the octree ---- */

void sl_octree_announce_picture(sl_octree_state *s, const char *name, const char *source,
                                const float *planes) {
    sl_announce(&s->announcer, name, source, s->settings.width, s->settings.height, 3, planes, true);
}

void sl_octree_begin_light(sl_octree_state *s) {
    sl_announce_gbuffer(&s->announcer, "direct light beside the octree", s->gbuffer);
    s->lit = false;
    s->direct_row = 0;
    s->phase = s->plan.direct ? SL_OCTREE_PHASE_DIRECT : SL_OCTREE_PHASE_PHOTONS;
}

void sl_octree_announce_direct(sl_octree_state *s) {
    sl_octree_announce_picture(s, "direct light", "direct light beside the octree", s->direct_light[0]);
}

sl_status sl_octree_draw_gbuffer(sl_octree_state *s, sl_error *error) {
    sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    sl_status status =
        sl_raster_gbuffer(s->raster, &view, s->settings.threads, s->gbuffer, &s->counters, error);
    sl_reflections_destroy(s->reflections);
    s->reflections = NULL;
    const sl_tracer *tracer = s->settings.light_octree.environment_mirrors ? NULL : s->tracer;
    if (status == SL_OK && s->plan.mirrors)
        status = sl_reflect_pixels(s->scene, tracer, s->settings.threads, s->gbuffer, &s->reflections,
                                   &s->counters, error);
    if (status != SL_OK) return status;
    sl_octree_begin_light(s);
    sl_sub_frame_clear(&s->scene->sub_frame, s->settings.threads, s->planes, SL_OCTREE_PLANES,
                       sl_settings_pixels(&s->settings));
    return status;
}

sl_status sl_octree_light_rows(sl_octree_state *s, sl_error *error) {
    sl_status status = sl_direct_rows(s->direct, s->gbuffer, SL_DIRECT_ROWS, &s->direct_row, s->direct_light,
                                      &s->counters, error);
    if (status != SL_OK || s->direct_row < s->settings.height) return status;
    sl_octree_announce_direct(s);
    s->fresh = s->lit; /* else it has no indirect light yet */
    s->phase = SL_OCTREE_PHASE_PHOTONS;
    return status;
}

/* ---- the method ---- */

/* A level has about four times the leaves of the one before. */
static double levels_done(const sl_octree_state *s, double share) {
    double all = 1.0;
    for (int d = s->depth; d < s->settings.light_octree.depth; d++) all *= 0.25;
    return all * (0.25 + 0.75 * share);
}

/* Shares of the whole that the phases take, roughly, for the progress bar alone. */
static double fraction_done(const sl_octree_state *s) {
    double stored = s->photons ? (double)s->photons->count / (double)s->settings.light_octree.photons : 0.0;
    switch (s->phase) {
    case SL_OCTREE_PHASE_GBUFFER: return 0.0;
    case SL_OCTREE_PHASE_DIRECT: return 0.3 * (double)s->direct_row / (double)s->settings.height;
    case SL_OCTREE_PHASE_PHOTONS: return 0.3 + 0.2 * (stored < 1.0 ? stored : 1.0);
    case SL_OCTREE_PHASE_OCTREE: return 0.5 + 0.5 * levels_done(s, 0.0);
    case SL_OCTREE_PHASE_LIGHTS:
        return 0.5 + 0.5 * levels_done(s, (double)s->leaf / (double)s->next.octree->leaf_count);
    case SL_OCTREE_PHASE_SHADE: return 0.5 + 0.5 * levels_done(s, 1.0);
    case SL_OCTREE_PHASE_DONE: return 1.0;
    }
    return 1.0;
}

static sl_status octree_update(void *state, sl_progress *progress, sl_error *error) {
    sl_octree_state *s = state;
    const bool moves = s->motion.asked;
    s->fresh = s->motion.asked = false;
    sl_status status = moves ? sl_octree_draw_frame(s, error) : sl_octree_step(s, error);
    progress->fraction = fraction_done(s);
    progress->done = s->phase == SL_OCTREE_PHASE_DONE;
    progress->frame_done = moves || progress->done;
    return status;
}

static sl_status octree_resolve(void *state, sl_image **image, sl_error *error) {
    sl_octree_state *s = state;
    sl_status status = sl_octree_create_image(s, image, error);
    if (status == SL_OK) sl_octree_compose(s, *image);
    if (status == SL_OK) status = sl_octree_write_report(s, *image, error);
    if (status != SL_OK) {
        sl_image_destroy(*image);
        *image = NULL;
    }
    return status;
}

static sl_status octree_resolve_colours(void *state, sl_image *image, sl_error *error) {
    (void)error;
    sl_octree_compose(state, image);
    return SL_OK;
}

static const uint32_t *octree_ids(const void *state) {
    const sl_octree_state *s = state;
    return s->reflections ? NULL : s->gbuffer->id;
}

/* Keeps photons and voxels when only the camera moves. A film's sub-frames are no motion. */
static sl_status octree_edit(void *state, unsigned changes, sl_error *error) {
    sl_octree_state *s = state;
    sl_status status = SL_OK;
    s->phase = SL_OCTREE_PHASE_GBUFFER;
    s->motion.asked = !s->scene->sub_frame.share;
    sl_octree_forget_level(&s->next);
    bool geometry = (changes & SL_CHANGED_OBJECTS) || !s->raster; /* an earlier edit may have failed */
    if (geometry || (changes & SL_CHANGED_LIGHTS)) {
        forget_light(s);
        sl_octree_age_light(&s->motion);
    }
    if (geometry) {
        forget_rays(s);
        status = make_geometry(s, error);
    }
    if (status == SL_OK && !s->direct) status = make_light(s, error);
    if (status != SL_OK) { /* all or nothing: the next edit starts anew */
        forget_light(s);
        forget_geometry(s);
    }
    return status;
}

static bool octree_shows(const void *state) { return ((const sl_octree_state *)state)->fresh; }

const sl_method_class sl_light_octree_method = {
    .name = "light-octree",
    .complete = sl_octree_complete,
    .create = octree_create,
    .destroy = octree_destroy,
    .update = octree_update,
    .resolve = octree_resolve,
    .resolve_colours = octree_resolve_colours,
    .ids = octree_ids,
    .edit = octree_edit,
    .counters_at = offsetof(sl_octree_state, counters),
    .memory_bytes = sl_octree_state_bytes,
    .need = sl_octree_need,
    .transport = sl_octree_transport,
    .plan = sl_octree_plan_write,
    .explanation = sl_octree_explanation,
    .raster_at = offsetof(sl_octree_state, raster),
    .shows = octree_shows,
};
