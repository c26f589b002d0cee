/* The method: makes and ends a cache, shows its picture, takes edits. One update of it is in shading_cache.c.
 * */
#include <math.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/shading_cache/state.h"
#include "scene/ambient.h"

/* ---- life ---- */

static void shading_destroy(void *state) {
    sl_shading_state *s = state;
    if (!s) return;
    for (int i = 0; i < s->renderer_count; i++) s->renderer[i].destroy(s->renderer[i].state);
    sl_display_destroy(s->display);
    sl_object_places_destroy(s->places);
    sl_sampled_lights_destroy(s->lights);
    sl_patches_destroy(s->patches);
    sl_primitives_destroy(s->primitives);
    sl_tracer_destroy(s->own_tracer);
    sl_fades_release(&s->fades);
    sl_layers_release(&s->layers);
    SL_FREE_ALL(s->ids.patch, s->id_memory, s->leaf_of_pixel, s->leaf, s->choice, s->place, s->vertex,
                s->request, s->sample, s->part, s->layer, s->stale, s->changes.object, s);
}

static sl_status make_buffers(sl_shading_state *s, sl_error *error) {
    size_t pixels = sl_settings_pixels(&s->settings), choices = 2 * (size_t)s->settings.shading_cache.points;
    s->ids.patch = sl_allocate(pixels, sizeof *s->ids.patch);
    s->id_memory = sl_allocate(2 * pixels, sizeof *s->id_memory);
    s->leaf_of_pixel = sl_allocate(pixels, sizeof *s->leaf_of_pixel);
    s->choice = sl_allocate(choices, sizeof *s->choice);
    s->place = sl_allocate(choices, sizeof *s->place);
    s->stale = sl_allocate(s->scene->object_count, sizeof *s->stale);
    s->changes.object = sl_allocate(s->scene->object_count, sizeof *s->changes.object);
    if (!s->ids.patch || !s->id_memory || !s->leaf_of_pixel || !s->choice || !s->place || !s->stale ||
        !s->changes.object)
        return sl_fail_memory(error, "the shading cache");
    s->ids.u = s->id_memory;
    s->ids.v = s->id_memory + pixels;
    return sl_shading_reserve(s, 4 * choices + 64, error);
}

typedef sl_status renderer_maker(const sl_renderer_settings *settings, sl_sample_renderer *renderer,
                                 sl_error *error);

static sl_status make_renderers(sl_shading_state *s, sl_error *error) {
    const struct {
        bool runs;
        renderer_maker *make;
        unsigned layer;
    } makers[SL_SHADING_RENDERERS] = {{s->plan.direct, sl_area_renderer, SL_LAYER_CHEAP},
                                      {s->plan.indirect, sl_bidirectional_renderer, SL_LAYER_DEAR},
                                      {s->plan.caustics, sl_caustic_renderer, SL_LAYER_CHEAP}};
    sl_renderer_settings settings = {.scene = s->scene, .tracer = &s->tracer,
                                     .cache = s->settings.shading_cache, .seed = s->settings.seed,
                                     .threads = s->settings.threads};
    sl_status status = SL_OK;
    for (int i = 0; i < SL_SHADING_RENDERERS && status == SL_OK; i++) {
        if (!makers[i].runs) continue;
        status = makers[i].make(&settings, &s->renderer[s->renderer_count], error);
        s->renderer[s->renderer_count].layer = makers[i].layer;
        if (status == SL_OK) s->renderer_count++;
    }
    return status;
}

static sl_status make_tracer(sl_shading_state *s, sl_error *error) {
    sl_tracer_destroy(s->own_tracer);
    s->own_tracer = NULL;
    s->tracer = NULL;
    sl_status status = sl_tracer_create(s->scene, s->settings.threads, NULL, &s->own_tracer, error);
    s->tracer = s->own_tracer;
    return status;
}

/* Y_ref: what the scene's light makes of its surfaces, on the average. */
static float middle_radiance(const sl_shading_state *s) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    float guess = sl_rgb_mean(sl_ambient_irradiance_of_all_bounces(s->scene)) * (float)(1.0 / SL_PI);
    return c->mean_level_radiance > 0.0 ? (float)c->mean_level_radiance : guess > 0.0f ? guess : 1.0f;
}

/* Lamps may have grown, or left. */
static void judge_by_light_of_now(sl_shading_state *s) {
    s->curve.reference = middle_radiance(s);
    if (sl_display_guess(s->display, sl_ambient_irradiance_of_all_bounces(s->scene))) s->drawn = false;
}

static sl_status make_cache(sl_shading_state *s, sl_error *error) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    sl_display_settings display = {s->settings.width, s->settings.height,
                                   sl_ambient_irradiance_of_all_bounces(s->scene), s->settings.threads};
    const sl_patches_settings kept = {.channels = s->plan.radiance ? 6 : 3,
                                      .max_depth = SL_PATCH_DEPTH_MAX,
                                      .shown = true,
                                      .sets = c->variance_aware};
    sl_status status = make_buffers(s, error);
    if (status == SL_OK) status = make_tracer(s, error);
    if (status == SL_OK) status = sl_primitives_find(s->scene, &s->primitives, error);
    if (status == SL_OK)
        status = sl_patches_create(s->primitives, &kept, &s->patches, error);
    if (status == SL_OK) status = make_renderers(s, error);
    if (status == SL_OK) status = sl_display_create(s->scene, s->primitives, &display, &s->display, error);
    if (status == SL_OK) s->raster = s->display->own.raster;
    if (status == SL_OK) status = sl_object_places_take(s->scene, &s->places, error);
    return status == SL_OK ? sl_light_places_take(s->scene, &s->lights, error) : status;
}

static sl_status shading_create(const sl_scene *scene, const sl_settings *settings,
                                const sl_transport *transport, void **state, sl_error *error) {
    (void)transport; /* its own: sl_shading_transport() */
    sl_shading_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "the shading cache");
    s->scene = scene;
    s->eye = scene->camera.eye;
    s->settings = *settings;
    s->plan = sl_shading_plan_make(scene, settings);
    s->announcer = (sl_announcer){.observer = settings->observer, .method = "shading-cache",
                                  .counters = &s->counters};
    s->curve = (sl_display_curve){middle_radiance(s)};
    s->changes = (sl_changes){.object_count = scene->object_count,
                              .threshold = (float)settings->shading_cache.change_threshold,
                              .window = settings->shading_cache.change_window,
                              .no_ageing = settings->shading_cache.no_ageing};
    s->layers = (sl_layers){.kept = s->plan.layers, .now = SL_VERSION_FIRST};
    s->last_update = settings->shading_cache.updates;
    s->last_sample = INFINITY;
    sl_status status = make_cache(s, error);
    if (status == SL_OK) *state = s;
    else shading_destroy(s);
    return status;
}

/* ---- the view: every primitive has a root on the side that the eye may see ---- */

static bool faces_the_eye(const sl_shading_state *s, uint32_t primitive) {
    uint32_t triangle = s->primitives->first_triangle[primitive];
    sl_vec3 corner = sl_scene_position(s->scene, s->scene->vertex[0][triangle]);
    return sl_dot(sl_scene_geometric_normal(s->scene, triangle), sl_sub(s->scene->camera.eye, corner)) > 0.0f;
}

static sl_status want_roots(sl_shading_state *s, sl_error *error) {
    sl_status status = SL_OK;
    for (uint32_t p = 0; p < s->primitives->count; p++) {
        bool curved = s->primitives->kind[p] == SL_PRIMITIVE_BICUBIC, front = curved || faces_the_eye(s, p);
        if (front && sl_patches_root(s->patches, 2 * p, &status, error) == SL_NO_INDEX) return status;
        if ((curved || !front) && sl_patches_root(s->patches, 2 * p + 1, &status, error) == SL_NO_INDEX)
            return status;
    }
    return SL_OK;
}

static sl_status take_view(sl_shading_state *s, sl_error *error) {
    if (s->drawn) return SL_OK;
    sl_status status = want_roots(s, error);
    if (status == SL_OK) status = sl_display_build(s->display, s->patches, error);
    s->drawn = status == SL_OK;
    return status;
}

/* ---- the method ---- */

static sl_status shading_update(void *state, sl_progress *progress, sl_error *error) {
    sl_shading_state *s = state;
    sl_status status = take_view(s, error);
    if (status == SL_OK && !s->done && !s->shows_only) status = sl_shading_update(s, error);
    s->shows_only = false;
    double left = (double)(s->last_update - s->now) / (double)s->settings.shading_cache.updates;
    progress->fraction = s->done ? 1.0 : 1.0 - left;
    progress->frame_done = true;
    progress->done = s->done;
    return status;
}

static sl_status shading_resolve(void *state, sl_image **image, sl_error *error) {
    static const char *const names[6] = {"R", "G", "B", "emission.R", "emission.G", "emission.B"};
    sl_shading_state *s = state;
    size_t pixels = sl_settings_pixels(&s->settings);
    float *memory = sl_allocate(6 * pixels, sizeof *memory), *planes[6];
    if (!memory) return sl_fail_memory(error, "the picture");
    for (size_t k = 0; k < 6; k++) planes[k] = memory + k * pixels;
    sl_status status = take_view(s, error);
    if (status == SL_OK) status = sl_window_draw(&s->display->own, planes, &s->counters, error);
    if (status == SL_OK)
        status = sl_image_create(s->settings.width, s->settings.height, 6, names, image, error);
    sl_count(&s->counters, SL_COUNT_FRAMES_DISPLAYED, status == SL_OK);
    if (status == SL_OK)
        sl_announce(&s->announcer, "display", "display loop", s->settings.width, s->settings.height, 3,
                    memory, true);
    if (status == SL_OK) sl_shading_announce_patches(s);
    for (int k = 0; k < 6 && status == SL_OK; k++)
        sl_raster_flip(planes[k], s->settings.width, s->settings.height,
                       (*image)->planes + (size_t)k * pixels);
    sl_free(memory);
    return status;
}

/* Where an eye that goes into a solid, or leaves one, makes other points valid all is shaded again, as if a
 * light had been moved. */
static unsigned of_the_eye(sl_shading_state *s, unsigned what) {
    bool matters = what & SL_CHANGED_CAMERA &&
                   sl_solids_eye_matters(s->primitives->solids, s->eye, s->scene->camera.eye);
    s->eye = s->scene->camera.eye;
    return matters ? what | SL_CHANGED_LIGHTS : what;
}

static void note_version(sl_layers *l, unsigned what) {
    l->now++;
    if (what & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) l->edited = l->now;
    if (what & SL_CHANGED_CAMERA) l->eye_moved = l->now;
}

/* Finds them, and hands what they were found from to the cache, whatever comes of the edit. */
static sl_status find_moves(sl_shading_state *s, sl_object_places *places, unsigned *what, sl_error *error) {
    sl_sampled_lights *lights = NULL;
    sl_light_moves *moves = NULL;
    sl_status status = sl_light_places_take(s->scene, &lights, error);
    if (status == SL_OK)
        status = sl_light_moves_find(s->scene, s->places, places, s->lights, lights, &moves, error);
    if (moves) *what = sl_shading_keep(s, *what, moves, s->lights);
    sl_light_moves_destroy(moves);
    if (status != SL_OK) {
        sl_sampled_lights_destroy(lights);
        return status;
    }
    sl_sampled_lights_destroy(s->lights);
    s->lights = lights;
    return SL_OK;
}

static sl_status note_motion(sl_shading_state *s, unsigned *what, sl_error *error) {
    sl_object_places *places;
    sl_status status = sl_object_places_take(s->scene, &places, error);
    if (status != SL_OK) return status;
    for (size_t i = 0; i < places->count; i++) s->stale[i] = sl_object_has_moved(s->places, places, i);
    status = find_moves(s, places, what, error);
    sl_object_places_destroy(s->places);
    s->places = places;
    return status;
}

static unsigned as_light(unsigned what) {
    const unsigned light = SL_CHANGED_POWER | SL_CHANGED_MATERIALS;
    return what & light ? (what & ~light) | SL_CHANGED_LIGHTS : what;
}

/* Much is known already: eight tenths of what a picture takes from its beginning make one as good, or half of
 * it where direct light is kept. */
static void allow_more(sl_shading_state *s, unsigned what) {
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    const double most = 2.0 * (double)c->points, share = what == SL_CHANGED_MATERIALS ? 0.5 : 0.8;
    s->last_update = (uint64_t)s->now + c->updates;
    if (!(s->samples_an_update > 0.0))
        s->samples_an_update = s->now ? fmin(s->samples / (double)s->now, most) : most;
    s->last_sample = what == SL_CHANGED_CAMERA
                         ? INFINITY
                         : s->samples + share * (double)c->updates * s->samples_an_update;
}

/* Light moves where an edit comes soon after another. Means of several sets of samples, and values without
 * layers, have the same samples always. */
static void note_move(sl_shading_state *s, unsigned what) {
    enum { SOON = 8 };
    if (!(what & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS))) return;
    const bool rested = !s->moves;
    s->moves = s->layers.kept && s->lit > 0 && s->now - s->lit <= SOON;
    s->lit = s->now;
    if (rested && s->moves) sl_changes_drop_again(&s->changes);
    if (s->few_paths || !s->moves) return;
    s->few_paths = true;
    s->same_paths = s->layers.now + 1;
}

static void begin_picture(sl_shading_state *s, unsigned what) {
    allow_more(s, what);
    what = as_light(what);
    note_move(s, what);
    sl_changes_edit(&s->changes, what, s->stale, s->now + 1);
    note_version(&s->layers, what);
    s->may_be_stale = true;
    if (!s->edited && (what & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS))) s->edited = s->now + 1;
    const sl_shading_cache_settings *c = &s->settings.shading_cache;
    s->shows_only = s->edits++ % (uint32_t)c->frames_per_update != 0;
    if (what & (SL_CHANGED_CAMERA | SL_CHANGED_OBJECTS)) s->drawn = false;
}

/* The display follows at once; the shading finds out for itself what has changed. Of a series of frames every
 * frames_per_update-th waits for an update; the others show what there is, from where things are. */
static sl_status shading_edit(void *state, unsigned changes, sl_error *error) {
    sl_shading_state *s = state;
    s->done = s->scene->sub_frame.purpose != SL_SUB_FRAME_BOTH; /* the others draw what there is */
    if (s->done) return SL_OK;
    unsigned left = of_the_eye(s, changes);
    sl_fades_finish(&s->fades, s->patches);
    sl_status status = note_motion(s, &left, error);
    if (left) begin_picture(s, left);
    s->done = !left && sl_shading_is_done(s);
    changes = as_light(changes);
    const bool light = changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS);
    if (light) judge_by_light_of_now(s);
    if (status == SL_OK && (changes & SL_CHANGED_OBJECTS)) status = sl_window_move(&s->display->own, error);
    if (status == SL_OK && (changes & SL_CHANGED_OBJECTS)) status = make_tracer(s, error);
    if (light) sl_solids_edit(s->primitives->solids);
    for (int i = 0; i < s->renderer_count && light && status == SL_OK; i++)
        status = s->renderer[i].edit(s->renderer[i].state, error);
    if (status != SL_OK) s->tracer = NULL;
    return status;
}

static double shading_error_levels(const void *state) {
    return ((const sl_shading_state *)state)->error_levels;
}

static double shading_samples(const void *state) { return ((const sl_shading_state *)state)->samples; }

static void shading_rate(void *state, double samples_a_second) {
    ((sl_shading_state *)state)->settings.shading_cache.nominal_rate = samples_a_second;
}

static size_t shading_bytes(const void *state) {
    const sl_shading_state *s = state;
    size_t bytes = sizeof *s + s->leaf_room * sizeof *s->leaf;
    bytes += sl_settings_pixels(&s->settings) * (2 * sizeof *s->ids.patch + 2 * sizeof *s->ids.u);
    bytes += s->fades.capacity * sizeof *s->fades.fade;
    bytes += s->vertex_room * (sizeof *s->vertex + sizeof *s->request + 2 * sizeof *s->sample +
                               (s->layer ? sizeof *s->layer : 0));
    bytes += sl_layers_bytes(&s->layers, s->patches);
    if (s->own_tracer) bytes += sl_tracer_memory_bytes(s->own_tracer);
    return bytes + sl_primitives_memory_bytes(s->primitives) + sl_patches_memory_bytes(s->patches) +
           sl_display_memory_bytes(s->display);
}

/* ---- frames beside updates: geometry follows at once, shading is as the last update left it ---- */

static sl_status window_create(void *state, const sl_scene *copy, unsigned threads, void **window,
                               sl_error *error) {
    sl_window *made;
    sl_status status = sl_window_create(((sl_shading_state *)state)->display, copy, threads, &made, error);
    *window = made;
    return status;
}

static const sl_window_class shading_window_class = {.create = window_create,
                                                     .destroy = sl_window_destroy,
                                                     .move = sl_window_move,
                                                     .ids = sl_window_ids,
                                                     .draw = sl_window_picture};

const sl_method_class sl_shading_cache_method = {
    .name = "shading-cache",
    .complete = sl_shading_complete,
    .create = shading_create,
    .destroy = shading_destroy,
    .tells_apart = SL_CHANGED_POWER | SL_CHANGED_MATERIALS,
    .update = shading_update,
    .resolve = shading_resolve,
    .edit = shading_edit,
    .counters_at = offsetof(sl_shading_state, counters),
    .memory_bytes = shading_bytes,
    .need = sl_shading_need,
    .transport = sl_shading_transport,
    .plan = sl_shading_plan_write,
    .raster_at = offsetof(sl_shading_state, raster),
    .asks = true,
    .explanation = sl_shading_explanation,
    .window = &shading_window_class,
    .error_levels = shading_error_levels,
    .samples = shading_samples,
    .rate = shading_rate,
};
