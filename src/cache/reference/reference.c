/* The reference tracers as methods: one update is one more sample for every pixel. */
#include "base/error.h"
#include "base/memory.h"
#include "cache/frame/announce.h"
#include "cache/frame/budget.h"
#include "cache/frame/method.h"
#include "trace/trace.h"

#include <string.h>

typedef struct {
    const char *name;      /* of the method */
    const char *what;      /* for errors */
    uint32_t samples[3];   /* by quality */
    bool bidirectional;
} sampled_film;

static const sampled_film path_film = {"path", "the path tracer", {16, 64, 256}, false};
static const sampled_film bidirectional_film = {
    "bidirectional", "the bidirectional path tracer", {8, 32, 128}, true};

typedef struct {
    const sampled_film *kind;
    const sl_scene *scene;
    sl_settings settings;
    sl_transport transport;
    sl_tracer *tracer;
    sl_path_tracer *film;
    uint64_t samples, samples_wanted;
    sl_counters counters;
} sampled_state;

static void sampled_destroy(void *state) {
    sampled_state *s = state;
    if (!s) return;
    sl_path_tracer_destroy(s->film);
    sl_tracer_destroy(s->tracer);
    sl_free(s);
}

static sl_status start_film(sampled_state *s, sl_error *error) {
    sl_path_tracer_destroy(s->film);
    s->film = NULL;
    s->samples = 0;
    const sl_path_settings settings = {.width = s->settings.width,
                                       .height = s->settings.height,
                                       .threads = s->settings.threads,
                                       .seed = s->settings.seed,
                                       .transport = s->transport,
                                       .bidirectional = s->kind->bidirectional};
    return sl_path_tracer_create(s->scene, s->tracer, &settings, &s->film, error);
}

static const sampled_film *film_of(const sl_settings *settings) {
    return strcmp(settings->method, path_film.name) == 0 ? &path_film : &bidirectional_film;
}

static void sampled_complete(sl_settings *settings) {
    if (settings->spp == 0) settings->spp = film_of(settings)->samples[settings->quality];
}

static sl_status sampled_create(const sl_scene *scene, const sl_settings *settings,
                                const sl_transport *transport, void **state, sl_error *error) {
    const sampled_film *kind = film_of(settings);
    sampled_state *s = sl_allocate(1, sizeof *s);
    if (!s) return sl_fail_memory(error, kind->what);
    s->kind = kind;
    s->scene = scene;
    s->settings = *settings;
    s->transport = *transport;
    s->samples_wanted = settings->spp;
    sl_status status = sl_tracer_create(scene, settings->threads, NULL, &s->tracer, error);
    if (status == SL_OK) status = start_film(s, error);
    if (status == SL_OK) *state = s;
    else sampled_destroy(s);
    return status;
}

static sl_status sampled_update(void *state, sl_progress *progress, sl_error *error) {
    sampled_state *s = state;
    if (s->samples < s->samples_wanted) {
        sl_status status = sl_path_tracer_sample(s->film, s->samples, &s->counters, error);
        if (status != SL_OK) return status;
        s->samples++;
    }
    progress->fraction = (double)s->samples / (double)s->samples_wanted;
    progress->done = s->samples == s->samples_wanted;
    return SL_OK;
}

/* The picture, and the two halves of the samples as layers: their difference is the reference's own noise. */
static sl_status sampled_resolve(void *state, sl_image **image, sl_error *error) {
    static const char *const names[] = {"R",        "G",        "B",       "even.R", "even.G",
                                        "even.B",   "odd.R",    "odd.G",   "odd.B"};
    sampled_state *s = state;
    sl_status status = sl_image_create(s->settings.width, s->settings.height, 9, names, image, error);
    if (status != SL_OK) return status;
    size_t pixels = sl_settings_pixels(&s->settings);
    float *p = (*image)->planes;
    for (int half = -1; half < 2; half++, p += 3 * pixels)
        sl_path_tracer_mean(s->film, half, p, p + pixels, p + 2 * pixels);
    sl_announcer announcer = {.observer = s->settings.observer, .method = s->kind->name,
                              .counters = &s->counters};
    sl_announce(&announcer, "mean of the samples", "reference", s->settings.width, s->settings.height, 3,
                (*image)->planes, false);
    return SL_OK;
}

static sl_status sampled_edit(void *state, unsigned changes, sl_error *error) {
    sampled_state *s = state;
    if (changes & SL_CHANGED_OBJECTS) {
        sl_path_tracer_destroy(s->film);
        s->film = NULL;
        sl_tracer_destroy(s->tracer);
        s->tracer = NULL;
        sl_status status = sl_tracer_create(s->scene, s->settings.threads, NULL, &s->tracer, error);
        if (status != SL_OK) return status;
    }
    return start_film(s, error);
}

static bool sampled_shows(const void *state) { return ((const sampled_state *)state)->samples > 0; }

static size_t sampled_memory_bytes(const void *state) {
    const sampled_state *s = state;
    size_t film = s->film ? sl_path_tracer_memory_bytes(s->film) : 0;
    return sizeof *s + film + (s->tracer ? sl_tracer_memory_bytes(s->tracer) : 0);
}

static void sampled_transport(const sl_settings *settings, sl_transport *transport) {
    (void)settings;
    sl_transport_named("full", transport);
}

/* ---- memory ---- */

/* Sums of two halves in double and the picture with its halves in float: 84 bytes a pixel; emitters and their
 * tree. */
enum { A_PIXEL = 88, AN_EMITTER = 256 };

static sl_memory_need sampled_need(const sl_scene *scene, const sl_settings *settings) {
    /* from both ends: two subpaths for each ray of a packet; and lists of what falls on other pixels, 64
     * tasks of 256 pixels */
    const bool both = film_of(settings)->bidirectional;
    return (sl_memory_need){.hierarchies = sl_tracer_memory_need(scene),
                            .caches = sl_need_lights(scene) * AN_EMITTER +
                                      sl_need_of_threads(settings, both ? 1e6 : 1e5) + (both ? 8e6 : 0.0),
                            .picture = sl_need_of_pixels(settings, A_PIXEL)};
}

static void sampled_plan(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer) {
    const bool both = film_of(settings)->bidirectional,
               lit = scene->emitter_count > 0 || scene->light_count > 0 || scene->environment.present;
    sl_plan_pass(writer, true, "hierarchy", "%zu triangles", scene->triangle_count);
    sl_plan_pass(writer, true, both ? "paths from the eye" : "paths", "%u %sfor each of %d x %d pixels",
                 (unsigned)settings->spp, both ? "" : "samples ", settings->width, settings->height);
    if (both)
        sl_plan_pass(writer, lit, "paths from the lights",
                     lit ? "as many; their ends are joined" : "nothing shines");
}

/* ---- the classes ---- */

#define SAMPLED_METHOD(method_name) \
    {.name = method_name, .complete = sampled_complete, .create = sampled_create, \
     .destroy = sampled_destroy, .update = sampled_update, .resolve = sampled_resolve, \
     .edit = sampled_edit, .shows = sampled_shows, .counters_at = offsetof(sampled_state, counters), \
     .memory_bytes = sampled_memory_bytes, \
     .need = sampled_need, .transport = sampled_transport, .plan = sampled_plan, .any_transport = true, \
     .draws_anew = true}

const sl_method_class sl_path_method = SAMPLED_METHOD("path");
const sl_method_class sl_bidirectional_method = SAMPLED_METHOD("bidirectional");
