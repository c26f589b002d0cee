#include "app/bench/references.h"

#include "app/clock.h"
#include "base/error.h"
#include "cache/frame/method.h"
#include "image/output_file.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- where they are ---- */

void sl_reference_default_folder(char path[SL_BENCH_PATH]) {
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (cache && cache[0] == '/') snprintf(path, SL_BENCH_PATH, "%s/softlux/references", cache);
    else if (home && home[0]) snprintf(path, SL_BENCH_PATH, "%s/.cache/softlux/references", home);
    else snprintf(path, SL_BENCH_PATH, "softlux-references");
}

/* Reads paths, which may be named with options that change them: "matched:splatting --bounces 2". */
static bool settings_of(const char *transport, char name[SL_BENCH_PATHS], sl_settings *settings) {
    char arguments[SL_BENCH_ARGUMENTS];
    int length = (int)strcspn(transport, " ");
    snprintf(name, SL_BENCH_PATHS, "%.*s", length, transport);
    snprintf(arguments, sizeof arguments, "-m path --set filter=centre%s", transport + length);
    if (!sl_trial_settings(arguments, settings)) return false;
    settings->transport = name;
    return true;
}

/* Takes away what there is not in a scene, since no path of it can meet that. */
static bool transport_of(const sl_bench_scene *s, const char *name, sl_transport *t) {
    sl_settings settings;
    char word[SL_BENCH_PATHS];
    unsigned lobes = SL_LOBE_DIFFUSE | (s->glossy ? SL_LOBE_GLOSSY : 0u) | (s->mirrors ? SL_LOBE_MIRROR : 0u);
    if (!settings_of(name, word, &settings) || sl_method_transport(&settings, t, NULL) != SL_OK)
        return false;
    t->direct_lobes &= lobes;
    t->receiver_lobes &= lobes;
    t->bounce_lobes &= lobes;
    t->eye_mirrors = t->eye_mirrors && s->mirrors;
    t->sky_light = t->sky_light && s->sky;
    return true;
}

bool sl_reference_is_same(const sl_bench_scene *s, const char *name, const char *other) {
    sl_transport a, b;
    if (!transport_of(s, name, &a) || !transport_of(s, other, &b)) return false;
    return a.emission == b.emission && a.eye_mirrors == b.eye_mirrors && a.direct_lobes == b.direct_lobes &&
           a.receiver_lobes == b.receiver_lobes && a.bounce_lobes == b.bounce_lobes &&
           a.bounces == b.bounces && a.direct_visibility == b.direct_visibility &&
           a.bounce_visibility == b.bounce_visibility && a.sky_light == b.sky_light;
}

static bool leaves_out_the_sky(const sl_bench_scene *s, const char *transport) {
    sl_transport t;
    return s->sky && transport_of(s, transport, &t) && !t.sky_light;
}

void sl_reference_path(const char *folder, const sl_bench_scene *s, const char *transport,
                       char path[SL_BENCH_PATH]) {
    /* whose files stand for others' of the same paths */
    static const char *const plain[] = {"full", "one-bounce", "direct"};
    char name[SL_BENCH_PATHS + 16];
    /* Files of the plain name may be kept from when it had the sky's light in it. */
    snprintf(name, sizeof name, "%s%s", transport, leaves_out_the_sky(s, transport) ? "-skyless" : "");
    for (size_t i = sizeof plain / sizeof *plain; i-- > 0;) {
        if (sl_reference_is_same(s, plain[i], transport)) snprintf(name, sizeof name, "%s", plain[i]);
    }
    for (char *c = name; *c; c++) {
        if (*c == ':' || *c == ' ' || *c == '/') *c = '-';
    }
    snprintf(path, SL_BENCH_PATH, "%s/%s-%dx%d-%s-centres-%s.exr", folder, s->hash, s->width, s->height, name,
             SL_VERSION);
}

/* ---- how long chunks are ---- */

/* Makes them as long as all before them: samples of one sequence do more than as many of two (noise falls
 * with their number to the power of -0.65 or so). */
static uint32_t chunk_samples(uint64_t chunk) {
    enum { LONGEST = 12 };
    uint64_t pair = chunk / 2;
    return 32u << (pair < LONGEST ? pair : LONGEST);
}

uint64_t sl_reference_samples(uint64_t pairs) {
    uint64_t samples = 0;
    for (uint64_t pair = 0; pair < pairs; pair++) samples += 2 * (uint64_t)chunk_samples(2 * pair);
    return samples;
}

static const char *const half_channels[2][3] = {{"even.R", "even.G", "even.B"}, {"odd.R", "odd.G", "odd.B"}};

bool sl_reference_read(const sl_image *image, uint64_t *pairs, double *seconds) {
    const char *count = sl_image_metadata(image, "softlux.reference.pairs"),
               *spent = sl_image_metadata(image, "softlux.reference.seconds");
    bool usable = count != NULL;
    for (int k = 0; k < 6; k++) usable = usable && sl_image_channel(image, half_channels[k / 3][k % 3]);
    *pairs = usable ? strtoull(count, NULL, 10) : 0;
    *seconds = spent ? strtod(spent, NULL) : 0.0;
    return *pairs > 0;
}

/* ---- in the child: more chunks ---- */

typedef struct extension {
    const char *scene_path, *transport, *path;
    int width, height;
    unsigned threads;
    uint64_t pairs;
    sl_load_options load;
} extension;

/* Reads the sums of both halves so far: planes R, G, B of the one, then of the other. An unreadable file
 * counts as none. */
static void begin(const extension *e, double *sums, uint64_t *pairs, double *seconds) {
    sl_image *image = NULL;
    size_t pixels = (size_t)e->width * (size_t)e->height;
    *pairs = 0;
    *seconds = 0.0;
    if (sl_image_read(e->path, &image, NULL) != SL_OK) return;
    bool usable =
        image->width == e->width && image->height == e->height && sl_reference_read(image, pairs, seconds);
    for (int k = 0; usable && k < 6; k++) {
        const float *from = sl_image_channel(image, half_channels[k / 3][k % 3]);
        for (size_t i = 0; i < pixels; i++)
            sums[(size_t)k * pixels + i] = 0.5 * (double)from[i] * (double)sl_reference_samples(*pairs);
    }
    if (!usable) *pairs = 0;
    sl_image_destroy(image);
}

static sl_status add_chunk(const extension *e, const sl_scene *scene, uint64_t chunk, double *sums,
                           sl_error *error) {
    sl_settings settings = sl_settings_default();
    char name[SL_BENCH_PATHS];
    sl_progress progress = {0};
    sl_method *method = NULL;
    sl_image *image = NULL;
    size_t pixels = (size_t)e->width * (size_t)e->height;
    settings_of(e->transport, name, &settings);
    settings.width = e->width;
    settings.height = e->height;
    settings.threads = e->threads;
    settings.spp = chunk_samples(chunk);
    settings.seed = 0x5eed0000u + chunk; /* none that a trial has */
    sl_status status = sl_method_create(scene, &settings, &method, error);
    while (status == SL_OK && !progress.done) status = sl_method_update(method, &progress, error);
    if (status == SL_OK) status = sl_method_resolve(method, &image, error);
    for (size_t i = 0; status == SL_OK && i < 3 * pixels; i++)
        sums[(chunk % 2) * 3 * pixels + i] += (double)settings.spp * (double)image->planes[i];
    sl_image_destroy(image);
    sl_method_destroy(method);
    return status;
}

static sl_status write_reference(const extension *e, const double *sums, uint64_t pairs, double seconds,
                                 sl_error *error) {
    static const char *const names[] = {"R",      "G",     "B",     "even.R", "even.G",
                                        "even.B", "odd.R", "odd.G", "odd.B"};
    sl_image *image = NULL;
    size_t values = 3 * (size_t)e->width * (size_t)e->height;
    char text[32];
    double samples = 0.5 * (double)sl_reference_samples(pairs); /* of a half */
    sl_status status = sl_image_create(e->width, e->height, 9, names, &image, error);
    for (size_t i = 0; status == SL_OK && i < values; i++) {
        double even = sums[i] / samples, odd = sums[values + i] / samples;
        image->planes[i] = (float)(0.5 * (even + odd));
        image->planes[values + i] = (float)even;
        image->planes[2 * values + i] = (float)odd;
    }
    snprintf(text, sizeof text, "%" PRIu64, pairs);
    if (status == SL_OK) status = sl_image_set_metadata(image, "softlux.reference.pairs", text, error);
    snprintf(text, sizeof text, "%.3f", seconds);
    if (status == SL_OK) status = sl_image_set_metadata(image, "softlux.reference.seconds", text, error);
    if (status == SL_OK) status = sl_image_set_metadata(image, "softlux.transport", e->transport, error);
    if (status == SL_OK) status = sl_image_write(image, e->path, error);
    sl_image_destroy(image);
    return status;
}

static bool extend_work(void *context, char **report) {
    const extension *e = context;
    sl_scene *scene = NULL;
    sl_error error = {SL_ERROR_RESOURCES, "not enough memory for a reference"};
    uint64_t pairs = 0;
    double seconds = 0.0, *sums = calloc(6 * (size_t)e->width * (size_t)e->height, sizeof *sums);
    char text[96];
    sl_status status =
        sums ? sl_scene_load_with(e->scene_path, &e->load, &scene, &error) : SL_ERROR_RESOURCES;
    if (status == SL_OK) begin(e, sums, &pairs, &seconds);
    for (uint64_t i = 0; i < 2 * e->pairs && status == SL_OK; i++)
        status = add_chunk(e, scene, 2 * pairs + i, sums, &error);
    seconds += sl_process_seconds();
    if (status == SL_OK) status = write_reference(e, sums, pairs + e->pairs, seconds, &error);
    snprintf(text, sizeof text, "{\"pairs\": %" PRIu64 ", \"seconds\": %.3f}", pairs + e->pairs, seconds);
    *report = strdup(status == SL_OK ? text : error.message);
    sl_scene_destroy(scene);
    free(sums);
    return status == SL_OK;
}

/* ---- in the parent ---- */

/* Does as mkdir -p. */
sl_status sl_reference_make_folder(const char *path, sl_error *error) {
    char part[SL_BENCH_PATH];
    size_t length = strlen(path);
    for (size_t i = 1; i <= length && i < sizeof part; i++) {
        if (path[i] != '/' && path[i]) continue;
        snprintf(part, sizeof part, "%.*s", (int)i, path);
        if (mkdir(part, 0777) == 0 || errno == EEXIST) continue;
        return sl_fail(error, SL_ERROR_OUTPUT, "cannot make the folder %.900s: %s", part,
                 strerror(errno));
    }
    snprintf(part, sizeof part, "%.1000s/reference.exr", path);
    return sl_output_check(part, error);
}

static void tell_trouble(sl_bench_reference *r, const sl_child_end *end) {
    snprintf(r->trouble, sizeof r->trouble, "%s", end->why);
}

sl_status sl_reference_extend(const sl_bench_options *o, const sl_bench_scene *s, uint64_t pairs,
                              sl_bench_reference *r, sl_error *error) {
    const sl_child_limits limits = {0.0, 0, sl_interrupted};
    extension e = {s->path, r->transport, r->file, s->width, s->height, o->reference_threads, pairs, o->load};
    sl_child_end end;
    sl_reference_path(o->references, s, r->transport, r->file);
    sl_status status = sl_reference_make_folder(o->references, error);
    if (status == SL_OK) status = sl_child_run(extend_work, &e, &limits, &end, error);
    if (status != SL_OK) return status;
    cJSON *told = cJSON_Parse(end.text);
    if (end.outcome != SL_CHILD_DONE) {
        tell_trouble(r, &end);
    } else if (told) {
        r->pairs = (uint64_t)cJSON_GetObjectItem(told, "pairs")->valuedouble;
        r->samples = sl_reference_samples(r->pairs);
        r->seconds = cJSON_GetObjectItem(told, "seconds")->valuedouble;
        r->trouble[0] = '\0';
    }
    cJSON_Delete(told);
    free(end.text);
    return SL_OK;
}

/* ---- the mask ---- */

/* Finds the pixels that show surfaces, which --error judges too. */
static bool mask_work(void *context, char **report) {
    const extension *e = context;
    sl_settings settings = sl_settings_default();
    sl_scene *scene = NULL;
    sl_error_probe *probe = NULL;
    sl_error error;
    settings.method = "path";
    settings.filter = SL_FILTER_CENTRE;
    settings.threads = e->threads;
    settings.width = e->width;
    settings.height = e->height;
    sl_status status = sl_scene_load_with(e->scene_path, &e->load, &scene, &error);
    if (status == SL_OK) status = sl_error_probe_create(scene, &settings, &probe, &error);
    if (status == SL_OK) status = sl_image_write(sl_error_probe_surfaces(probe), e->path, &error);
    sl_error_probe_destroy(probe);
    sl_scene_destroy(scene);
    *report = strdup(status == SL_OK ? "{}" : error.message);
    return status == SL_OK;
}

sl_image *sl_reference_mask(const sl_bench_options *o, const sl_bench_scene *s, sl_error *error) {
    const sl_child_limits limits = {0.0, 0, sl_interrupted};
    char path[SL_BENCH_PATH];
    extension e = {s->path, "", path, s->width, s->height, o->reference_threads, 0, o->load};
    sl_image *mask = NULL;
    sl_child_end end;
    sl_reference_path(o->references, s, "surfaces", path);
    if (sl_image_read(path, &mask, NULL) == SL_OK) return mask;
    if (sl_reference_make_folder(o->references, error) != SL_OK ||
        sl_child_run(mask_work, &e, &limits, &end, error) != SL_OK)
        return NULL;
    free(end.text);
    if (end.outcome == SL_CHILD_DONE && sl_image_read(path, &mask, error) == SL_OK) return mask;
    error->status = SL_ERROR_RESOURCES;
    if (end.outcome != SL_CHILD_DONE)
        snprintf(error->message, sizeof error->message, "no mask: %.200s", end.why);
    return NULL;
}
