/* The public face of the methods: a table of classes, settings completed, metadata stamped on every picture.
 */
#include "cache/frame/method.h"

#include "base/print.h"
#include "cache/frame/all_light.h"
#include "cache/frame/budget.h"
#include "cache/frame/settings.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "image/tone.h"
#include "image/unset.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const sl_method_class *const classes[] = {&sl_splatting_method,     &sl_direct_radiance_method,
                                                 &sl_light_octree_method,  &sl_multi_mesh_method,
                                                 &sl_shading_cache_method, &sl_path_method,
                                                 &sl_bidirectional_method};
enum { CLASSES = sizeof classes / sizeof classes[0] };

const char *sl_version(void) { return SL_VERSION; }

const char *sl_method_name(size_t index) { return index < CLASSES ? classes[index]->name : NULL; }

static const sl_method_class *find_class(const char *name) {
    if (!name) return NULL;
    for (size_t i = 0; i < CLASSES; i++) {
        if (strcmp(name, classes[i]->name) == 0) return classes[i];
    }
    return NULL;
}

static sl_status unknown_method(const char *name, sl_error *error) {
    char known[256] = "";
    for (size_t i = 0; i < CLASSES; i++) {
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "", classes[i]->name);
    }
    return sl_fail(error, SL_ERROR_USAGE, "unknown method '%s'; expected one of %s", name ? name : "", known);
}

/* The paths to count: the class's own, a named set, or those that another method declares. */
static sl_status choose_transport(const sl_method_class *class, const sl_settings *settings,
                                  sl_transport *transport, sl_error *error) {
    static const char matched[] = "matched:";
    const char *name = settings->transport;
    class->transport(settings, transport);
    if (!name) return SL_OK;
    const sl_method_class *other = NULL;
    if (strncmp(name, matched, sizeof matched - 1) == 0) {
        other = find_class(name + sizeof matched - 1);
        if (!other) return unknown_method(name + sizeof matched - 1, error);
        if (other == class) return SL_OK;
        other->transport(settings, transport);
    } else if (!sl_transport_named(name, transport)) {
        return sl_fail(error, SL_ERROR_USAGE,
                       "unknown transport '%s'; expected direct, one-bounce, full or matched:METHOD", name);
    }
    if (!class->any_transport)
        return sl_fail(
            error, SL_ERROR_USAGE,
            "%s computes its own paths only; another transport needs --method path or bidirectional",
            class->name);
    return SL_OK;
}

sl_status sl_method_transport(const sl_settings *settings, sl_transport *transport, sl_error *error) {
    const sl_method_class *class = find_class(settings->method);
    if (!class) return unknown_method(settings->method, error);
    sl_status status = choose_transport(class, settings, transport, error);
    if (status != SL_OK || settings->filter == SL_FILTER_METHOD) return status;
    transport->filter = settings->filter;
    transport->filter_radius = sl_filter_radius(settings);
    return SL_OK;
}

sl_status sl_method_choose(const sl_scene *scene, const sl_settings *asked, sl_settings *chosen,
                           sl_transport *transport, sl_bounces_measured *measured, sl_error *error) {
    sl_bounces_measured found = {0};
    if (measured) *measured = found;
    if (!scene || !asked) return sl_fail_null(error, "a scene and settings");
    *chosen = *asked;
    if (chosen->width == 0 && chosen->height == 0) sl_scene_film(scene, &chosen->width, &chosen->height);
    sl_status status = sl_method_transport(chosen, transport, error);
    if (status == SL_OK) status = sl_settings_check(chosen, error);
    if (status != SL_OK || chosen->bounces || !sl_has_bounces(chosen)) return status;
    status = sl_measure_bounces(scene, chosen, &found, error);
    if (measured) *measured = found;
    chosen->bounces = found.bounces;
    return status == SL_OK ? sl_method_transport(chosen, transport, error) : status;
}

/* All that is known of a method before it is made. */
typedef struct prepared {
    const sl_method_class *class;
    sl_settings settings; /* complete */
    sl_transport transport;
    sl_bounces_measured found;
    char reduced[512];
} prepared;

/* Fills in what was left to the scene, the machine or the quality, within the memory that there is. */
static sl_status prepare(const sl_scene *scene, const sl_settings *asked, double beside, prepared *p,
                         sl_error *error) {
    sl_status status = sl_method_choose(scene, asked, &p->settings, &p->transport, &p->found, error);
    if (status != SL_OK) return status;
    p->class = find_class(p->settings.method);
    p->settings.threads = sl_thread_count(p->settings.threads);
    p->class->complete(&p->settings);
    return sl_budget_keep(p->class, scene, &p->settings, beside, p->reduced, sizeof p->reduced, error);
}

/* ---- the central region of a scattered scene ---- */

static void remember_region(sl_method *m) {
    m->scale = m->scene->scale;
    m->central_min = m->scene->central_min;
    m->central_max = m->scene->central_max;
}

/* An eye elsewhere may make another part of a scattered scene its central region (scene/scale.c), where an
 * octree, voxels or a coarse mesh are not that were made for the one before. Small moves change the scale a
 * little, which matters no more than that it is a rough measure. */
static bool region_has_moved(const sl_method *m) {
    const sl_scene *s = m->scene;
    const float larger = fmaxf(m->scale, s->scale), smaller = fminf(m->scale, s->scale);
    if (larger == smaller && memcmp(&m->central_min, &s->central_min, sizeof m->central_min) == 0 &&
        memcmp(&m->central_max, &s->central_max, sizeof m->central_max) == 0)
        return false;
    const double before = (double)sl_length(sl_sub(m->central_max, m->central_min)),
                 now = (double)sl_scene_central_diagonal(s);
    const double moved = fmax((double)sl_length(sl_sub(s->central_min, m->central_min)),
                              (double)sl_length(sl_sub(s->central_max, m->central_max)));
    return larger > 2.0f * smaller || !(moved <= 0.25 * fmin(before, now));
}

/* ---- creation ---- */

static void destroy_state(sl_method *m) {
    if (m->state) m->class->destroy(m->state);
    sl_film_destroy(m->film);
    sl_image_destroy(m->sub_frame);
    m->state = NULL;
    m->film = NULL;
    m->sub_frame = NULL;
}

static sl_status create_state(sl_method *m, sl_error *error) {
    sl_status status = SL_OK;
    m->seen = *m->scene;
    if (sl_method_has_film(m->class, &m->settings))
        status = sl_film_create(&m->seen, &m->settings, m->class->asks, &m->film, error);
    if (status == SL_OK) sl_expose_anew(m, true);
    const sl_scene *seen = m->film ? &m->seen : m->scene;
    if (status == SL_OK) status = m->class->create(seen, &m->settings, &m->transport, &m->state, error);
    if (status != SL_OK) destroy_state(m);
    m->planned = sl_scene_features(m->scene);
    m->states++;
    remember_region(m);
    return status;
}

/* Where the plan was made for a scene of another kind. What was counted stays. */
static sl_status create_anew(sl_method *m, sl_error *error) {
    if (!m->before) m->before = sl_allocate(2, sizeof *m->before);
    if (!m->before) return sl_fail_memory(error, "a method");
    if (m->state) m->before[0] = *sl_method_counters(m);
    destroy_state(m);
    return create_state(m, error);
}

/* Tells whether the scene has lights of other kinds than the method was planned for. */
static bool is_lit_otherwise(const sl_method *m) {
    const sl_features now = sl_scene_features(m->scene), *then = &m->planned;
    return !now.emissive_triangles != !then->emissive_triangles || !now.point_lights != !then->point_lights ||
           !now.spot_lights != !then->spot_lights || !now.directional_lights != !then->directional_lights ||
           now.environment != then->environment;
}

sl_status sl_method_create(const sl_scene *scene, const sl_settings *settings, sl_method **method,
                           sl_error *error) {
    return sl_method_create_beside(scene, settings, 0.0, method, error);
}

sl_status sl_method_create_beside(const sl_scene *scene, const sl_settings *settings, double bytes,
                                  sl_method **method, sl_error *error) {
    if (!method) return sl_fail_null(error, "a place for a method");
    *method = NULL;
    prepared p;
    sl_status status = prepare(scene, settings, bytes, &p, error);
    if (status != SL_OK) return status;
    sl_method *m = sl_allocate(1, sizeof *m);
    if (!m) return sl_fail_memory(error, "a method");
    m->class = p.class;
    m->scene = scene;
    m->settings = p.settings;
    m->transport = p.transport;
    memcpy(m->reduced, p.reduced, sizeof m->reduced);
    snprintf(m->transport_name, sizeof m->transport_name, "%s%s", settings->transport ? "" : "matched:",
             settings->transport ? settings->transport : p.class->name);
    m->settings.method = p.class->name;
    m->settings.transport = m->transport_name;
    m->memory_bytes = settings->memory_bytes;
    status = create_state(m, error);
    if (status != SL_OK) {
        sl_method_destroy(m);
        return status;
    }
    m->scene_version = scene->version;
    *method = m;
    return SL_OK;
}

void sl_method_destroy(sl_method *method) {
    if (!method) return;
    destroy_state(method);
    sl_free(method->before);
    sl_free(method);
}

/* Refuses where nothing can be updated, shown or saved. */
static sl_status check_health(const sl_method *m, sl_error *error) {
    if (m->health == SL_METHOD_FAILED)
        return sl_fail(error, SL_ERROR_USAGE, "an earlier update failed: %s can only be destroyed",
                       m->class->name);
    if (m->health == SL_METHOD_WANTS_EDIT)
        return sl_fail(error, SL_ERROR_USAGE, "an earlier edit of the scene failed; edit it again");
    if (m->scene_version != m->scene->version)
        return sl_fail(error, SL_ERROR_USAGE,
                       "the scene has changed, and %s was not told so: sl_method_edit() comes first",
                       m->class->name);
    return SL_OK;
}

sl_status sl_method_update(sl_method *method, sl_progress *progress, sl_error *error) {
    if (!method || !progress) return sl_fail_null(error, "a method and a place for its progress");
    sl_progress now = {.batches = method->progress.batches + 1};
    sl_status status = check_health(method, error);
    if (status != SL_OK) return status;
    if (!method->progress.done) {
        status = method->film ? sl_expose(method, &now, error)
                              : method->class->update(method->state, &now, error);
        method->resolved = false;
        if (status != SL_OK) method->health = SL_METHOD_FAILED;
        if (status != SL_OK) return status;
        now.frame_done = now.frame_done || now.done;
        method->progress = now;
    }
    *progress = method->progress;
    return SL_OK;
}

/* A scene of a million triangles takes milliseconds to hash, and most edits are of its camera. */
static uint64_t scene_hash(sl_method *m) {
    if (!m->light_hash_known) m->light_hash = sl_scene_light_hash(m->scene);
    m->light_hash_known = true;
    return sl_scene_hash_of(m->scene, m->light_hash);
}

/* Every picture carries what made it. */
static sl_status stamp(sl_method *method, sl_image *image, sl_error *error) {
    char text[24];
    sl_settings told = method->settings;
    if (!method->film) told.sub_samples = 0;
    told.filter_radius = sl_filter_radius(&told);
    sl_status status = sl_settings_stamp(&told, image, error);
    if (status == SL_OK) status = sl_image_set_metadata(image, "softlux.version", SL_VERSION, error);
    snprintf(text, sizeof text, "%016" PRIx64, scene_hash(method));
    if (status == SL_OK) status = sl_image_set_metadata(image, "softlux.scene_hash", text, error);
    snprintf(text, sizeof text, "%" PRIu64, method->progress.batches);
    if (status == SL_OK) status = sl_image_set_metadata(image, "softlux.batches", text, error);
    snprintf(text, sizeof text, "%" PRIu64, method->memory_bytes);
    if (status == SL_OK && method->memory_bytes)
        status = sl_image_set_metadata(image, "softlux.memory", text, error);
    const char *reduced = sl_method_reduction(method);
    if (status == SL_OK && reduced)
        status = sl_image_set_metadata(image, "softlux.reduced", reduced, error);
    const sl_counters *counters = sl_method_counters(method);
    for (int i = 0; i < SL_COUNTERS && status == SL_OK; i++) {
        if (!counters->value[i]) continue;
        char key[SL_METADATA_KEY_MAX];
        snprintf(key, sizeof key, "softlux.counter.%s", sl_counter_name((sl_counter)i));
        snprintf(text, sizeof text, "%" PRIu64, counters->value[i]);
        status = sl_image_set_metadata(image, key, text, error);
    }
    return status;
}

sl_status sl_method_resolve(sl_method *method, sl_image **image, sl_error *error) {
    if (!image) return sl_fail_null(error, "a place for a picture");
    *image = NULL;
    if (!method) return sl_fail_null(error, "a method");
    sl_image *result = NULL;
    sl_status status = check_health(method, error);
    if (status == SL_OK)
        status = method->film && sl_film_has_picture(method->film)
                     ? sl_film_develop(method->film, &result, error)
                     : method->class->resolve(method->state, &result, error);
    if (status == SL_OK) status = stamp(method, result, error);
    if (status != SL_OK) {
        sl_image_destroy(result);
        return status;
    }
    *image = result;
    method->resolved = true;
    return SL_OK;
}

static sl_status colours_of_picture(sl_method *m, sl_image *colours, sl_error *error) {
    const size_t plane = (size_t)colours->width * (size_t)colours->height;
    const float *planes[3];
    sl_image *picture;
    sl_status status = sl_method_resolve(m, &picture, error);
    if (status == SL_OK && !sl_layer_planes(picture, NULL, planes))
        status = sl_fail(error, SL_ERROR_USAGE, "a picture without R, G and B");
    for (size_t c = 0; status == SL_OK && c < 3; c++)
        memcpy(colours->planes + c * plane, planes[c], plane * sizeof(float));
    sl_image_destroy(picture);
    return status;
}

sl_status sl_method_resolve_colours(sl_method *m, sl_image **image, sl_error *error) {
    const bool alone = m->class->resolve_colours && !m->film && !m->settings.observer;
    sl_status status = check_health(m, error);
    *image = NULL;
    if (status == SL_OK)
        status = sl_image_create_unset(m->settings.width, m->settings.height, 3, NULL, image, error);
    if (status == SL_OK)
        status = alone ? m->class->resolve_colours(m->state, *image, error)
                       : colours_of_picture(m, *image, error);
    if (status == SL_OK) return status;
    sl_image_destroy(*image);
    *image = NULL;
    return status;
}

/* Tells the class of its scene. Light that has changed is light, whatever has changed it. */
static sl_status edit_state(sl_method *m, unsigned changes, sl_error *error) {
    const unsigned told =
        SL_CHANGED_CAMERA | SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS | m->class->tells_apart;
    const bool kinds = changes & SL_CHANGED_KINDS;
    if (changes & ~told) changes |= SL_CHANGED_LIGHTS;
    if (!m->state || kinds || (changes & SL_CHANGED_LIGHTS && is_lit_otherwise(m)))
        return create_anew(m, error);
    if (changes & SL_CHANGED_OBJECTS) remember_region(m);
    sl_expose_anew(m, changes & SL_CHANGED_OBJECTS);
    return m->class->edit(m->state, changes & told, error);
}

sl_status sl_rate_check(double samples_a_second, sl_error *error) {
    return samples_a_second >= 1.0 && samples_a_second <= 1e9
               ? SL_OK
               : sl_fail(error, SL_ERROR_USAGE, "rate: expected 1 to 1e9 samples a second");
}

sl_status sl_method_rate(sl_method *method, double samples_a_second, sl_error *error) {
    if (!method) return sl_fail_null(error, "a method");
    sl_status status = sl_rate_check(samples_a_second, error);
    if (status != SL_OK || !method->class->rate) return status;
    method->settings.shading_cache.nominal_rate = samples_a_second; /* also of states that are to come */
    if (method->state) method->class->rate(method->state, samples_a_second);
    return SL_OK;
}

sl_status sl_method_edit(sl_method *method, unsigned changes, sl_error *error) {
    const unsigned everything = SL_CHANGED_CAMERA | SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS;
    if (!method) return sl_fail_null(error, "a method");
    if (changes & ~(unsigned)SL_CHANGED_ALL)
        return sl_fail(error, SL_ERROR_USAGE, "changes 0x%x: there are 0x%x at most", changes,
                       (unsigned)SL_CHANGED_ALL);
    if (method->health == SL_METHOD_FAILED) return check_health(method, error);
    changes |= sl_scene_changes_since(method->scene, method->scene_version);
    if (method->health == SL_METHOD_WANTS_EDIT || region_has_moved(method)) changes |= everything;
    method->progress.done = method->progress.frame_done = method->resolved = false;
    if (changes != SL_CHANGED_CAMERA) method->light_hash_known = false;
    sl_status status = edit_state(method, changes, error);
    method->health = status == SL_OK ? SL_METHOD_SOUND : SL_METHOD_WANTS_EDIT;
    if (status == SL_OK) method->scene_version = method->scene->version;
    return status;
}

bool sl_method_keeps_cache(const sl_method *method) { return method->class->save && method->class->load; }

sl_status sl_method_save(const sl_method *method, const char *path, sl_error *error) {
    if (!method || !path) return sl_fail_null(error, "a method and the name of a file");
    if (!method->class->save)
        return sl_fail(error, SL_ERROR_USAGE, "%s keeps no cache that could be saved", method->class->name);
    sl_status status = check_health(method, error);
    return status == SL_OK ? method->class->save(method->state, path, error) : status;
}

sl_status sl_method_load(sl_method *method, const char *path, sl_error *error) {
    if (!method || !path) return sl_fail_null(error, "a method and the name of a file");
    if (!method->class->load)
        return sl_fail(error, SL_ERROR_USAGE, "%s keeps no cache that could be loaded", method->class->name);
    sl_status status = check_health(method, error);
    if (status == SL_OK) sl_expose_anew(method, false);
    if (status == SL_OK) status = method->class->load(method->state, path, error);
    if (status == SL_OK) method->progress.done = method->progress.frame_done = method->resolved = false;
    return status;
}

const sl_counters *sl_method_counters(const sl_method *method) {
    static const sl_counters none;
    const sl_counters *own = method->state ? sl_method_own_counters(method) : &none;
    if (method->before) {
        method->before[1] = method->before[0];
        sl_counters_add(&method->before[1], own);
        own = &method->before[1];
    }
    return method->film ? sl_film_counters(method->film, own) : own;
}

size_t sl_method_memory_bytes(const sl_method *method) {
    return sizeof *method + (method->state ? method->class->memory_bytes(method->state) : 0) +
           (method->film ? sl_film_bytes(method->film) : 0);
}

sl_status sl_method_memory_need(const sl_scene *scene, const sl_settings *settings, uint64_t *bytes,
                                sl_error *error) {
    if (!bytes) return sl_fail_null(error, "a place for a number");
    *bytes = 0;
    if (!settings) return sl_fail_null(error, "a scene and settings");
    sl_settings unlimited = *settings;
    prepared p;
    unlimited.memory_bytes = 0;
    sl_status status = prepare(scene, &unlimited, 0.0, &p, error);
    if (status == SL_OK) *bytes = sl_budget_need(p.class, scene, &p.settings);
    return status;
}

const char *sl_method_reduction(sl_method *m) {
    const char *filled = m->state && m->class->filled ? m->class->filled(m->state) : NULL;
    snprintf(m->reduction, sizeof m->reduction, "%s%s%s", m->reduced, m->reduced[0] && filled ? ", " : "",
             filled ? filled : "");
    return m->reduction[0] ? m->reduction : NULL;
}

static bool says(const sl_image *picture, const char *key, const char *value) {
    const char *said = sl_image_metadata(picture, key);
    return said && strcmp(said, value) == 0;
}

/* By what was stamped on it. */
static bool is_the_last_one(sl_method *m, const sl_image *picture) {
    char batches[24], hash[24];
    snprintf(batches, sizeof batches, "%" PRIu64, m->progress.batches);
    snprintf(hash, sizeof hash, "%016" PRIx64, scene_hash(m));
    return m->resolved && m->scene_version == m->scene->version && picture->width == m->settings.width &&
           picture->height == m->settings.height && says(picture, "softlux.method", m->class->name) &&
           says(picture, "softlux.batches", batches) && says(picture, "softlux.scene_hash", hash);
}

sl_status sl_method_explanation(sl_method *method, const sl_image *picture, int x, int y,
                                sl_explanation **explanation, sl_error *error) {
    if (!explanation) return sl_fail_null(error, "a place for an explanation");
    *explanation = NULL;
    if (!method || !picture) return sl_fail_null(error, "a method and its picture");
    if (method->film)
        return sl_fail(error, SL_ERROR_USAGE,
                       "a pixel is explained by what its centre shows: expected filter=centre");
    if (!is_the_last_one(method, picture))
        return sl_fail(error, SL_ERROR_USAGE,
                       "explanations want the picture that %s resolved last, and no update or edit since",
                       method->class->name);
    return sl_explanation_tell(method->class, method->state, picture, x, y, explanation, error);
}

/* ---- the plan ---- */

struct sl_plan_writer {
    FILE *out;
};

void sl_plan_pass(sl_plan_writer *writer, bool runs, const char *pass, const char *why, ...) {
    va_list arguments;
    fprintf(writer->out, "%-4s %-28s ", runs ? "run" : "skip", pass);
    va_start(arguments, why);
    vfprintf(writer->out, why, arguments);
    va_end(arguments);
    fputc('\n', writer->out);
}

void sl_plan_limit(sl_plan_writer *writer, const char *limit, ...) {
    va_list arguments;
    fputs("limit ", writer->out);
    va_start(arguments, limit);
    vfprintf(writer->out, limit, arguments);
    va_end(arguments);
    fputc('\n', writer->out);
}

static void write_plan(sl_plan_writer *writer, const sl_scene *scene, const prepared *p) {
    p->class->plan(scene, &p->settings, writer);
    if (sl_method_has_film(p->class, &p->settings))
        sl_plan_pass(writer, true, "film",
                     "4 sub-frames of all pixels, others where edges are or light differs: "
                     "%u samples at most",
                     p->settings.sub_samples);
    if (p->found.bounces)
        sl_plan_pass(writer, true, "bounces",
                     "%u: all others would add %.1f %% of the light, as a few paths tell", p->found.bounces,
                     100.0 * p->found.left);
    if (p->reduced[0]) sl_plan_pass(writer, true, "with less memory", "%s", p->reduced);
}

sl_status sl_method_plan(const sl_scene *scene, const sl_settings *settings, char **text, sl_error *error) {
    if (!text) return sl_fail_null(error, "a place for a plan");
    *text = NULL;
    prepared p;
    char *told = NULL;
    size_t size;
    sl_status status = prepare(scene, settings, 0.0, &p, error);
    if (status != SL_OK) return status;
    sl_plan_writer writer = {open_memstream(&told, &size)};
    if (!writer.out) return sl_fail_memory(error, "the plan");
    void *before = sl_c_locale_begin();
    write_plan(&writer, scene, &p);
    sl_c_locale_end(before);
    const bool whole = !ferror(writer.out);
    if (fclose(writer.out) == 0 && whole) *text = told;
    else free(told);
    return *text ? SL_OK : sl_fail_memory(error, "the plan");
}

/* ---- limits that showed ---- */

sl_status sl_warn(sl_image *image, sl_error *error, const char *limit, ...) {
    char text[2048];
    const char *before = sl_image_metadata(image, "softlux.warning");
    const int used = before ? snprintf(text, sizeof text, "%s\n", before) : 0;
    if (used >= (int)sizeof text) return SL_OK; /* more than anybody reads */
    va_list arguments;
    va_start(arguments, limit);
    sl_print_list(text + used, sizeof text - (size_t)used, limit, arguments);
    va_end(arguments);
    return sl_image_set_metadata(image, "softlux.warning", text, error);
}
