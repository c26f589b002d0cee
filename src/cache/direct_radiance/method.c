/* Direct Radiance Mapping as a method: frames, edits, memory, and what made a pixel. */
#include "cache/direct_radiance/direct_radiance.h"

#include "base/error.h"
#include "base/memory.h"

/* ---- what observers are shown ---- */

/* Texel for texel, faces one above another; those of a hemicube's sides are lower. */
void sl_radiance_announce_map(sl_radiance_state *s) {
    const sl_radiance_map *map = s->map;
    if (!map->face_count) return;
    int width = map->face[0].width, rows = (int)(map->texels / (size_t)width);
    if ((size_t)width * (size_t)rows != map->texels) return;
    const struct {
        const char *name;
        float *const *plane;
    } pictures[] = {{"map of positions", map->position},
                    {map->lambertian ? "map of radiance" : "map of true colour", map->color},
                    {"map of normals", map->normal}};
    for (size_t i = 0; i < sizeof pictures / sizeof pictures[0]; i++) {
        if (!pictures[i].plane[0]) continue;
        const float *const planes[3] = {pictures[i].plane[0], pictures[i].plane[1], pictures[i].plane[2]};
        sl_announce_planes(&s->announcer, pictures[i].name, "direct radiance map", width, rows, planes);
    }
}

void sl_announce_photons(sl_announcer *announcer, const sl_map_photons *photons) {
    sl_mark *marks =
        sl_announcing(announcer) && photons->count ? sl_allocate(photons->count, sizeof *marks) : NULL;
    if (!marks) return;
    for (size_t j = 0; j < photons->count; j++) {
        const sl_map_photon *p = &photons->photon[j];
        marks[j] = (sl_mark){.kind = SL_MARK_POINT,
                             .at = {p->position.x, p->position.y, p->position.z},
                             .colour = {p->flux.r, p->flux.g, p->flux.b}};
    }
    sl_announce_marks(announcer, "sample photons", "samples of the direct radiance map", marks,
                      photons->count);
    sl_free(marks);
}

/* Announces what is seen, drawn whole, since strips leave nothing. */
static void announce_seen(sl_radiance_state *s) {
    const sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    const unsigned threads = s->settings.threads;
    sl_counters ignored = {{0}};
    sl_gbuffer *g = NULL;
    sl_reflections *reflections = NULL;
    sl_status status = sl_gbuffer_create(view.width, view.height, &g, NULL);
    if (status == SL_OK) status = sl_raster_gbuffer(s->raster, &view, threads, g, &ignored, NULL);
    if (status == SL_OK && s->plan.mirrors)
        status = sl_reflect_pixels(s->scene, s->tracer, threads, g, &reflections, &ignored, NULL);
    if (status == SL_OK) sl_announce_gbuffer(&s->announcer, "importons", g);
    sl_reflections_destroy(reflections);
    sl_gbuffer_destroy(g);
}

/* Announces the receivers and the layers of the picture. */
void sl_radiance_announce_light(sl_radiance_state *s) {
    const size_t pixels = sl_settings_pixels(&s->settings);
    if (!s->announcer.observer || s->settings.radiance_map.without_layers) return;
    if (sl_announcing(&s->announcer)) announce_seen(s);
    sl_announce(&s->announcer, "direct light", "(5), (9)", s->settings.width, s->settings.height, 3,
                s->image->planes + SL_COMPOSED_DIRECT * pixels, false);
    sl_announce(&s->announcer, "indirect light", "(10)", s->settings.width, s->settings.height, 3,
                s->image->planes + SL_COMPOSED_INDIRECT * pixels, false);
}

/* ---- a pixel explained: (10) photon by photon ---- */

/* Resolves what one pixel of the picture shows. */
static sl_status resolve_pixel(const sl_radiance_state *s, size_t pixel, sl_gbuffer *g,
                               sl_reflections **reflections, sl_error *error) {
    const sl_view view = sl_view_scene(s->scene, s->settings.width, s->settings.height);
    sl_counters ignored = {{0}};
    sl_resolver *resolver;
    sl_status status = sl_resolver_create(s->raster, &view, s->id, 1, &resolver, error);
    if (status != SL_OK) return status;
    g->id[0] = s->id[pixel];
    (void)sl_resolver_run(resolver, 0, pixel, 1, g);
    sl_resolver_destroy(resolver);
    if (!s->plan.mirrors) return SL_OK;
    return sl_reflect_pixels(s->scene, s->tracer, 1, g, reflections, &ignored, error);
}

static sl_status explain_photons(const sl_radiance_state *s, size_t pixel, sl_explanation_writer *writer,
                                 sl_error *error) {
    const sl_light_pass light = sl_radiance_lighting(s);
    sl_gbuffer *g = NULL;
    sl_reflections *reflections = NULL;
    sl_photon_sums *sums = NULL;
    sl_receiver_tile tile;
    bool glossy;
    sl_status status = sl_gbuffer_create(1, 1, &g, error);
    if (status == SL_OK) status = resolve_pixel(s, pixel, g, &reflections, error);
    if (status == SL_OK) status = sl_photon_sums_create(&light, &sums, error);
    if (status == SL_OK && sl_receiver_tile_of_pixel(s->scene, g, 0, &glossy, &tile))
        sl_indirect_light_explain(sums, &tile, glossy, sl_reflections_throughput(reflections, 0), writer);
    sl_photon_sums_destroy(sums);
    sl_reflections_destroy(reflections);
    sl_gbuffer_destroy(g);
    return status;
}

static sl_status radiance_explanation(void *state, int x, int y, sl_explanation_writer *writer,
                                      sl_error *error) {
    const sl_radiance_state *s = state;
    if (!s->drawn || s->settings.radiance_map.without_layers)
        return sl_fail(error, SL_ERROR_USAGE, "a pixel is explained in a picture with its layers");
    sl_explanation_add_layer(writer, "emission", "emitted light");
    sl_explanation_add_layer(writer, "direct", "direct light");
    if (!s->photons || !s->photons->count) return SL_OK;
    return explain_photons(s, (size_t)y * (size_t)s->settings.width + (size_t)x, writer, error);
}

/* ---- frames ---- */

/* Frees what is of one picture; the plane of ids stays for the next frame. */
static void forget_picture(sl_radiance_state *s) {
    sl_image_destroy(s->image);
    s->image = NULL;
    s->drawn = false;
}

static void radiance_destroy(void *state) {
    sl_radiance_state *s = state;
    if (!s) return;
    forget_picture(s);
    sl_free(s->id);
    sl_radiance_darken(s);
    sl_radiance_forget_geometry(s);
    sl_free(s);
}

static sl_status radiance_create(const sl_scene *scene, const sl_settings *settings,
                                 const sl_transport *transport, void **state, sl_error *error) {
    (void)transport; /* its own: sl_radiance_transport() */
    sl_radiance_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, "direct radiance mapping");
    s->scene = scene;
    s->settings = *settings;
    s->announcer =
        (sl_announcer){.observer = settings->observer, .method = "direct-radiance", .counters = &s->counters};
    sl_status status = sl_radiance_place(s, error);
    if (status == SL_OK) *state = s;
    else radiance_destroy(s);
    return status;
}

/* Draws a whole frame: there is nothing to refine. */
static sl_status radiance_update(void *state, sl_progress *progress, sl_error *error) {
    sl_radiance_state *s = state;
    sl_status status = s->placed ? SL_OK : sl_radiance_place(s, error);
    if (status == SL_OK && !s->lit) status = sl_radiance_light_up(s, error);
    forget_picture(s);
    if (status == SL_OK) status = sl_radiance_draw(s, error);
    s->drawn = status == SL_OK;
    progress->fraction = 1.0;
    progress->frame_done = progress->done = true;
    return status;
}

/* Hands the picture over; to have it again it is drawn again, which is not counted. */
static sl_status give_picture(sl_radiance_state *s, sl_image **image, sl_error *error) {
    sl_counters ignored = {{0}};
    if (!s->image) return sl_radiance_draw_image(s, image, &ignored, error);
    *image = s->image;
    s->image = NULL;
    return SL_OK;
}

static sl_status radiance_resolve(void *state, sl_image **image, sl_error *error) {
    sl_radiance_state *s = state;
    sl_progress ignored;
    sl_status status = s->drawn ? SL_OK : radiance_update(s, &ignored, error);
    if (status == SL_OK) status = give_picture(s, image, error);
    if (status == SL_OK && s->map) status = sl_radiance_stamp(s, *image, error);
    if (status == SL_OK && s->plan.environment)
        status = sl_warn(*image, error, "the sky is seen, but lights nothing");
    return status;
}

/* Passes 1 to 3 do not know the camera. */
static sl_status radiance_edit(void *state, unsigned changes, sl_error *error) {
    (void)error;
    sl_radiance_state *s = state;
    forget_picture(s);
    if (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) sl_radiance_darken(s);
    if (changes & SL_CHANGED_OBJECTS) s->placed = false; /* and planned anew */
    return SL_OK;
}

static size_t radiance_memory_bytes(const void *state) {
    const sl_radiance_state *s = state;
    const size_t pixels = sl_settings_pixels(&s->settings);
    size_t bytes = sizeof *s;
    if (s->image) bytes += (size_t)s->image->channels * pixels * sizeof *s->image->planes;
    if (s->raster) bytes += sl_raster_memory_bytes(s->raster);
    if (s->tracer) bytes += sl_tracer_memory_bytes(s->tracer);
    if (s->lights) bytes += sl_map_lights_bytes(s->lights);
    if (s->map) bytes += sl_radiance_map_bytes(s->map);
    if (s->photons) bytes += sl_map_photons_bytes(s->photons);
    if (s->id) bytes += pixels * sizeof *s->id;
    return bytes;
}

static const uint32_t *radiance_ids(const void *state) { return ((const sl_radiance_state *)state)->id; }

const sl_method_class sl_direct_radiance_method = {
    .name = "direct-radiance",
    .complete = sl_radiance_complete,
    .create = radiance_create,
    .destroy = radiance_destroy,
    .update = radiance_update,
    .resolve = radiance_resolve,
    .ids = radiance_ids,
    .edit = radiance_edit,
    .counters_at = offsetof(sl_radiance_state, counters),
    .memory_bytes = radiance_memory_bytes,
    .need = sl_radiance_need,
    .explanation = radiance_explanation,
    .transport = sl_radiance_transport,
    .plan = sl_radiance_plan_write,
    .raster_at = offsetof(sl_radiance_state, raster),
    .draws_anew = true,
};
