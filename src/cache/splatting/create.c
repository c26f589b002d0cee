/* Makes what the passes need, when it is needed and not before: light and hierarchy at the start, a cache
 * when the first pixel of its class has been seen. */
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/splatting/state.h"

/* ---- the caches ---- */

void sl_splat_close_gathers(sl_splat_state *s) {
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) sl_gathers_destroy(&s->cache[c].gathers);
}

static void close_caches(sl_splat_state *s) {
    sl_splat_close_gathers(s);
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        sl_glossy_destroy(s->cache[c].glossy);
        s->cache[c].glossy = NULL;
    }
}

/* While things move, at whatever quality: few records with few rays, of which most gather anew for each
 * picture. */
static const double quick_accuracy = 0.6, quick_pixels = 6.0;
enum { QUICK_SIZE = 10 };

double sl_splat_accuracy(const sl_splat_state *s, sl_receiver_class class) {
    const double a = class == SL_RECEIVES_RADIANCE ? s->settings.glossy_accuracy : s->settings.accuracy;
    return sl_splat_is_quick(s) && a < quick_accuracy ? quick_accuracy : a;
}

/* Second-level records stay as long as geometry and lights do; where the camera goes to other places, there
 * will be more. */
static sl_status open_second(sl_splat_state *s, sl_error *error) {
    if (s->settings.bounces < 2 || s->second) return SL_OK;
    sl_second_settings settings =
        sl_second_settings_for(&s->plan.gather, s->settings.accuracy, s->settings.bounces);
    settings.aspect = (float)s->settings.width / (float)s->settings.height;
    settings.threads = s->settings.threads;
    settings.quick = s->settings.records_per_frame > 0;
    sl_status status =
        sl_second_cache_create(s->scene, s->tracer, &settings, &s->second, &s->counters, error);
    if (status == SL_OK) sl_splat_announce_second_level(s);
    return status;
}

/* Where frames follow each other, records must not depend on the view in which they were made: aR_min is what
 * it would be a quarter of the scene away from the eye, and at least a thousandth of the scene. */
static double minimum_reach(const sl_splat_state *s, double footprint_per_depth) {
    double size = (double)sl_scene_central_diagonal(s->scene);
    double pixels = s->plan.minimum_pixels;
    if (sl_splat_is_quick(s) && pixels < quick_pixels) pixels = quick_pixels;
    double reach = pixels * footprint_per_depth * 0.25 * size;
    return reach > 1e-3 * size ? reach : 1e-3 * size;
}

/* What sub-frames behind the first see is near to what has been covered, and a part of a pixel: there a tenth
 * is enough. */
static float covered_weight(const sl_splat_state *s, float accuracy) {
    const bool asks_again = s->scene->sub_frame.purpose == SL_SUB_FRAME_ASKS;
    return asks_again ? 1.0f / (90.0f * accuracy) : sl_covered_weight(accuracy);
}

static void prepare_pass(const sl_splat_state *s, sl_record_cache *cache) {
    const sl_gbuffer *g = s->gbuffer;
    float a = (float)sl_splat_accuracy(s, cache->class), scale = s->scene->scale;
    const bool depends_on_view = !s->settings.records_per_frame;
    const sl_camera *camera = &s->scene->camera;
    /* Pictures of more than 400 rows show more, but not in proportion: there what is told in pixels goes with
     * the root of the rows. */
    const double rows = s->settings.height < 400 ? (double)s->settings.height : 400.0;
    double footprint_per_depth =
        2.0 * sl_tan(0.5 * (double)camera->vertical_fov) / sqrt(rows * (double)s->settings.height);
    cache->pass = (sl_record_pass){
        .scene = s->scene,
        .tracer = s->tracer,
        .gathers = &cache->gathers,
        .gbuffer = g,
        .receivers = {g->width, g->height, g->position_x, g->position_y, g->position_z, g->normal_x,
                      g->normal_y, g->normal_z, cache->receives},
        .weights = {a, 1.0f / a, 1e-5f * scale},
        .covered_weight = covered_weight(s, a),
        .radii = {.accuracy = (double)a,
                  .minimum_pixels = depends_on_view ? s->plan.minimum_pixels : 0.0,
                  .steep = depends_on_view && s->scene->sub_frame.share > 0 ? s->plan.steep : 0.0,
                  .minimum_reach = minimum_reach(s, footprint_per_depth),
                  .maximum_radius = 0.1 * (double)s->scene->diagonal,
                  .guard = true,
                  .gather = s->plan.gather.kind,
                  .plane_tangent = sl_tan(0.5 * (double)s->plan.gather.plane_fov),
                  .metric = cache->glossy ? SL_METRIC_HARMONIC : s->plan.metric},
        .coefficient_count = sl_splat_coefficients(s, cache->class),
        .isa = sl_isa_best(),
        .camera = camera,
        .mirrors = s->reflections ? &s->mirrors : NULL,
        .near_distance = 1e-5f * scale,
        .footprint_per_depth = (float)footprint_per_depth,
        .coverage = s->coverage,
        .owned = s->owned,
        .seed = s->settings.seed,
        .threads = s->settings.threads,
    };
    cache->pass.glossy = (sl_glossy_view){cache->glossy, &cache->pass.receivers, g->material, camera->eye, g};
}

sl_status sl_splat_open_cache(sl_splat_state *s, sl_record_cache *cache, sl_error *error) {
    sl_status status = SL_OK;
    if (cache->class == SL_RECEIVES_RADIANCE && !cache->glossy)
        status = sl_glossy_create(s->scene, s->plan.harmonics_order, &cache->glossy, error);
    if (status == SL_OK) prepare_pass(s, cache);
    return status;
}

/* Light of further bounces is asked for by rays where records of the second level are too far apart, except
 * while things move. These ways have one surface more than `bounces` says, which behind so many is little. */
static float onward_reach(const sl_splat_state *s) {
    enum { MANY_BOUNCES = 5 };
    if (!s->second || sl_splat_is_quick(s) || s->settings.bounces < MANY_BOUNCES) return 0.0f;
    return sl_second_cache_reach(s->second);
}

sl_status sl_splat_open_gathers(sl_splat_state *s, sl_record_cache *cache, sl_error *error) {
    if (cache->gathers.gather) return SL_OK;
    sl_status status = open_second(s, error);
    sl_gather_settings settings = s->plan.gather;
    settings.harmonics_order = cache->class == SL_RECEIVES_RADIANCE ? s->plan.harmonics_order : 0;
    if (sl_splat_is_quick(s) && settings.size > QUICK_SIZE) settings.size = QUICK_SIZE;
    settings.second = s->second ? sl_second_cache_light(s->second) : NULL;
    settings.onward_reach = onward_reach(s);
    if (status == SL_OK)
        status = sl_gathers_create(s->scene, s->raster, s->tracer, &settings, s->settings.threads,
                                   &cache->gathers, error);
    if (status == SL_OK) prepare_pass(s, cache);
    return status;
}

/* ---- light and hierarchy ---- */

static void destroy_lights(sl_splat_state *s) {
    close_caches(s);
    sl_direct_destroy(s->direct);
    sl_shadow_maps_destroy(s->maps);
    sl_tracer_destroy(s->tracer);
    sl_raster_destroy(s->raster);
    sl_environment_release(&s->sky);
    sl_environment_release(&s->sun);
    s->direct = NULL;
    s->maps = NULL;
    s->tracer = NULL;
    s->raster = NULL;
}

void sl_splat_destroy_transport(sl_splat_state *s) {
    destroy_lights(s);
    sl_second_cache_destroy(s->second);
    s->second = NULL;
}

static const sl_environment *present_or_null(const sl_environment *e) { return e->present ? e : NULL; }

/* Once for pixels, which want the lights and the sun, and for gathers, which want the sky too. */
static sl_status create_maps(sl_splat_state *s, sl_error *error) {
    const int walks = s->settings.records_per_frame > 0;
    const sl_shadow_map_settings maps = {SL_SHADOW_MAP_SIZE, SL_SHADOW_MAP_SIZE / (walks ? 8 : 4),
                                         present_or_null(&s->sun), present_or_null(&s->sky),
                                         s->settings.threads};
    return sl_shadow_maps_create(s->scene, s->raster, &maps, &s->maps, &s->counters, error);
}

/* Two tell what differs, and are filtered; one is noise. */
static uint32_t light_samples(const sl_splat_state *s) {
    return sl_splat_is_quick(s) && s->settings.spp > 2 ? 2 : s->settings.spp;
}

sl_status sl_splat_renew_direct(sl_splat_state *s, sl_error *error) {
    const sl_direct_settings direct = {light_samples(s), s->settings.seed, s->settings.threads,
                                       s->maps, present_or_null(&s->sun)};
    sl_direct_destroy(s->direct);
    s->direct = NULL;
    return sl_splat_is_quick(s) && !s->maps
               ? sl_direct_create_quick(s->scene, s->raster, s->tracer, &direct, !s->settings.memory_bytes,
                                        &s->direct, &s->counters, error)
               : sl_direct_create(s->scene, s->tracer, &direct, &s->direct, error);
}

static sl_status create_transport(sl_splat_state *s, sl_error *error) {
    unsigned threads = s->settings.threads;
    sl_status status = sl_raster_create(s->scene, threads, &s->raster, error);
    if (status == SL_OK)
        status = sl_environment_split(&s->scene->environment, SL_SKY_CONTRAST, &s->sky, &s->sun, error);
    if (status == SL_OK && (s->plan.direct || s->plan.mirrors))
        status = sl_tracer_create(s->scene, threads, NULL, &s->tracer, error);
    if (status == SL_OK && s->plan.direct && s->settings.direct == SL_DIRECT_SHADOW_MAPS)
        status = create_maps(s, error);
    if (status == SL_OK && s->plan.direct) status = sl_splat_renew_direct(s, error);
    if (status == SL_OK) status = sl_splat_note_places(s, error);
    s->plan.gather.background = present_or_null(&s->sky);
    s->plan.gather.maps = s->maps;
    return status;
}

sl_status sl_splat_renew_transport(sl_splat_state *s, sl_error *error) {
    s->full = false;
    sl_splat_settle(s);
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        sl_record_list_clear(&s->cache[c].list);
        s->cache[c].clamped = 0;
    }
    sl_splat_destroy_transport(s);
    sl_status status = create_transport(s, error);
    if (status != SL_OK) sl_splat_destroy_transport(s);
    return status;
}

sl_status sl_splat_renew_lights(sl_splat_state *s, sl_error *error) {
    destroy_lights(s);
    sl_status status = create_transport(s, error);
    if (status != SL_OK) sl_splat_destroy_transport(s);
    return status;
}

/* ---- all of it ---- */

static sl_status create_buffers(sl_splat_state *s, sl_error *error) {
    size_t pixels = sl_splat_pixels(s), planes = s->plan.radiance ? SL_SPLAT_PLANES : SL_SPLAT_PLANES - 3;
    bool enough = true;
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        s->cache[c].class = (sl_receiver_class)c;
        bool wanted = c == SL_RECEIVES_RADIANCE ? s->plan.radiance : s->plan.irradiance;
        if (wanted) s->cache[c].receives = sl_allocate(pixels, sizeof *s->cache[c].receives);
        enough = enough && (s->cache[c].receives || !wanted);
    }
    s->owned = sl_allocate(pixels, sizeof *s->owned);
    s->planes = sl_allocate(planes * pixels, sizeof *s->planes);
    if (!enough || !s->owned || !s->planes) return sl_fail_memory(error, "the splat buffers");
    for (int c = 0; c < 3; c++) s->direct_light[c] = s->planes + (size_t)c * pixels;
    float *p = s->planes + 3 * pixels;
    s->coverage = p;
    s->splats =
        (sl_splat_buffer){p + pixels, p + 2 * pixels, p + 3 * pixels, p + 4 * pixels, p + 5 * pixels, {NULL}};
    for (size_t c = 0; s->plan.radiance && c < 3; c++) s->splats.glossy[c] = p + (6 + c) * pixels;
    return sl_gbuffer_create(s->settings.width, s->settings.height, &s->gbuffer, error);
}

sl_status sl_splat_create(const sl_scene *scene, const sl_settings *settings, const sl_transport *transport,
                          void **state, sl_error *error) {
    (void)transport; /* its own: sl_splat_transport() */
    sl_splat_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "radiance cache splatting");
    s->scene = scene;
    s->settings = *settings;
    s->announcer =
        (sl_announcer){.observer = settings->observer, .method = "splatting", .counters = &s->counters};
    s->plan = sl_splat_plan_make(scene, settings);
    sl_status status = create_transport(s, error);
    if (status == SL_OK) status = create_buffers(s, error);
    if (status != SL_OK) {
        sl_splat_destroy(s);
        return status;
    }
    *state = s;
    return SL_OK;
}

void sl_splat_destroy(void *state) {
    sl_splat_state *s = state;
    if (!s) return;
    sl_splat_destroy_transport(s);
    sl_splat_ages_free(&s->ages);
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        sl_free(s->cache[c].receives);
        sl_record_list_free(&s->cache[c].list);
    }
    sl_gbuffer_destroy(s->gbuffer);
    sl_reflections_destroy(s->reflections);
    sl_free(s->planes);
    sl_free(s->owned);
    sl_free(s);
}

static size_t list_bytes(const sl_record_list *list, size_t coefficients) {
    return list->capacity * (sizeof(sl_record) + coefficients * sizeof(float)) +
           list->reaches.capacity * sizeof(sl_reach_node);
}

size_t sl_splat_memory_bytes(const void *state) {
    const sl_splat_state *s = state;
    size_t pixels = sl_splat_pixels(s), planes = s->plan.radiance ? SL_SPLAT_PLANES : SL_SPLAT_PLANES - 3;
    size_t gbuffer = pixels * (14 * sizeof(float) + 2 * sizeof(uint32_t));
    size_t bytes = sizeof *s + pixels * (planes * sizeof(float) + 1) + gbuffer;
    for (int c = 0; c < SL_RECEIVER_CLASSES; c++) {
        const sl_record_cache *cache = &s->cache[c];
        bytes += list_bytes(&cache->list, cache->pass.coefficient_count) +
                 list_bytes(&s->ages.kept[c], cache->pass.coefficient_count);
        if (cache->receives) bytes += pixels * sizeof *cache->receives;
        if (cache->gathers.gather) bytes += sl_gather_memory_bytes(cache->gathers.gather);
        if (cache->glossy) bytes += sl_glossy_bytes(cache->glossy);
    }
    if (s->second) bytes += sl_second_cache_bytes(s->second);
    if (s->ages.kept_second) bytes += sl_second_cache_bytes(s->ages.kept_second);
    if (s->raster) bytes += sl_raster_memory_bytes(s->raster);
    if (s->tracer) bytes += sl_tracer_memory_bytes(s->tracer);
    if (s->maps) bytes += sl_shadow_maps_bytes(s->maps);
    bytes += sl_direct_map_bytes(s->direct);
    return bytes;
}
