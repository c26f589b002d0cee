/* Running a method with a progress bar, writing pictures, saying what was done. */
#include "app/picture.h"

#include "app/clock.h"
#include "app/page.h"
#include "base/error.h"
#include "base/values.h"
#include "image/tone.h"
#include "scene/features.h"
#include "cache/frame/method.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool is_png(const char *path) { return sl_ends_with(path, ".png"); }

static sl_tone tone_of(const sl_render_options *o) {
    return (sl_tone){(sl_tone_curve)o->tone, (float)o->exposure, !o->exposure_given};
}

/* ---- pictures in which nothing can be seen ---- */

/* Of all pixels, how many black ones make a picture blank; and of those that are not black, how many white
 * ones. */
static const double nearly_all = 0.98, most = 0.9;

static bool is_black(const sl_image *image) {
    const float *planes[3];
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    sl_layer_planes(image, NULL, planes);
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; planes[c] && i < pixels; i++) {
            if (planes[c][i] != 0.0f) return false;
        }
    }
    return true;
}

static const char *reason(const sl_render_options *o, const sl_scene *scene) {
    const sl_features f = sl_scene_features(scene);
    if (!f.light) return "the scene has no light";
    if (!sl_scene_is_in_view(scene))
        return "the camera sees nothing of the scene: --eye and --target place it";
    bool sky_alone = f.environment && !f.emitters && !scene->light_count;
    if (sky_alone && strcmp(o->settings.method, "direct-radiance") == 0)
        return "the environment is the only light, and direct-radiance takes none from it";
    return "no light reaches what the camera sees: lamps may be behind walls, or shine the other way "
           "(softlux info tells where it stands, --eye and --target place it)";
}

/* The shares of pixels that are 0 as a PNG shows them, and of 255 among the others. */
static bool measure(const sl_render_options *o, const sl_image *image, double *black, double *white) {
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    uint8_t *bytes = malloc(3 * pixels);
    sl_tone tone = tone_of(o);
    bool good = bytes && sl_image_srgb(image, &tone, bytes, NULL) == SL_OK;
    size_t count[2] = {0, 0};
    for (size_t i = 0; good && i < pixels; i++) {
        const uint8_t *p = bytes + 3 * i;
        count[0] += (p[0] | p[1] | p[2]) == 0;
        count[1] += (p[0] & p[1] & p[2]) == 255;
    }
    *black = (double)count[0] / (double)pixels;
    *white = count[1] ? (double)count[1] / (double)(pixels - count[0]) : 0.0;
    free(bytes);
    return good;
}

/* Says on stderr that a picture is black, or as a PNG black or white all over, and the likely reason. */
static void tell_blank_picture(const sl_render_options *o, const sl_scene *scene, const sl_image *image) {
    double black, white;
    if (is_black(image)) {
        fprintf(stderr, "softlux: warning: the picture is black: %s\n", reason(o, scene));
        return;
    }
    if (!is_png(o->output) || !measure(o, image, &black, &white)) return;
    if (white >= most)
        fprintf(stderr, "softlux: warning: %.3g %% of the pixels are white: a lower --exposure shows more\n",
                100.0 * white * (1.0 - black));
    if (black >= nearly_all && o->exposure_given)
        fprintf(stderr, "softlux: warning: %.3g %% of the pixels are black: a higher --exposure shows more\n",
                100.0 * black);
}

/* ---- running ---- */

/* done_before: share of a series that is there already. */
sl_status sl_picture_run(const sl_render_options *o, sl_method *method, sl_progress *progress, double start,
                         double done_before, sl_error *error) {
    double drawn = 0.0, share = o->frames ? 1.0 / (double)o->frames : 1.0;
    sl_status status = SL_OK;
    progress->done = progress->frame_done = false;
    while (status == SL_OK && !progress->done && !(o->frames && progress->frame_done) && !sl_interrupted()) {
        status = sl_method_update(method, progress, error);
        double seconds = sl_seconds_now() - start;
        if (seconds - drawn > 0.1 || progress->done) {
            double fraction = done_before + share * progress->fraction;
            sl_progress_show(o->quiet, fraction, "%3.0f %%  %.1f s", 100.0 * fraction, seconds);
            drawn = seconds;
        }
        if (!o->frames && o->batches && progress->batches >= o->batches) break;
        if (!o->frames && o->time_seconds > 0.0 && seconds >= o->time_seconds) break;
    }
    if (!o->frames) sl_progress_keep(o->quiet);
    return status;
}

sl_status sl_picture_make(const sl_scene *scene, const sl_settings *settings, double seconds,
                          sl_image **image, sl_error *error) {
    sl_method *method = NULL;
    sl_progress progress = {0};
    double start = sl_seconds_now();
    *image = NULL;
    sl_status status = sl_method_create(scene, settings, &method, error);
    while (status == SL_OK && !progress.done && sl_seconds_now() - start < seconds)
        status = sl_method_update(method, &progress, error);
    if (status == SL_OK && !progress.done)
        status = sl_fail(error, SL_ERROR_RESOURCES, "not done after %.0f s and %llu batches",
                         sl_seconds_now() - start, (unsigned long long)progress.batches);
    if (status == SL_OK) status = sl_method_resolve(method, image, error);
    sl_method_destroy(method);
    return status;
}

/* ---- writing ---- */

/* Nothing of the clock goes into the file: the same picture is the same file. */
sl_status sl_picture_write(const sl_render_options *o, const sl_image *image, const char *path, double *stops,
                           sl_error *error) {
    *stops = is_png(path) ? sl_tone_stops(image, tone_of(o)) : 0.0;
    return is_png(path) ? sl_image_write_png(image, path, tone_of(o), error)
                                   : sl_image_write(image, path, error);
}

void sl_picture_add_tone(const sl_render_options *o, double stops, cJSON *json) {
    if (!is_png(o->output)) return;
    cJSON *tone = cJSON_AddObjectToObject(json, "tone");
    cJSON_AddStringToObject(tone, "curve", sl_tone_curve_name((size_t)o->tone));
    cJSON_AddNumberToObject(tone, "exposure", stops);
    cJSON_AddBoolToObject(tone, "automatic", !o->exposure_given);
}

static void tell_bounces(const sl_render_options *o) {
    if (!(o->light_left > 0.0)) return;
    fprintf(stderr, "softlux: --bounces %u: all others would add %.1f %% of the light\n", o->settings.bounces,
            100.0 * o->light_left);
}

/* Tells by how much the method's own light paths are fewer, or more, than there are. */
static void tell_left_out(const sl_render_options *o, const sl_scene *scene) {
    enum { SAMPLES = 4 };
    const sl_light_paths paths[] = {{o->settings.method, o->settings.transport}, {"path", "full"}};
    double light[2];
    if (sl_is_tracer(o->settings.method) ||
        sl_measure_light(scene, &o->settings, paths, 2, SAMPLES, light, NULL) != SL_OK)
        return;
    const double share = light[1] > 0.0 ? 1.0 - light[0] / light[1] : 0.0;
    if (fabs(share) < 0.01) return;
    fprintf(
        stderr,
        "softlux: %s counts about %.0f %% %s light than there is; softlux info tells what it leaves out\n",
        o->settings.method, 100.0 * fabs(share), share > 0.0 ? "less" : "more");
}

void sl_picture_warn(const sl_render_options *o, const sl_scene *scene, const sl_progress *progress,
                     const sl_image *image) {
    const char *rest = sl_image_metadata(image, "softlux.warning"), *line;
    size_t length;
    while (!o->quiet && (line = sl_next_item(&rest, "\n", &length)))
        fprintf(stderr, "softlux: warning: %.*s\n", (int)length, line);
    const char *reduced = sl_image_metadata(image, "softlux.reduced");
    if (reduced && !o->quiet) fprintf(stderr, "softlux: to keep within --memory: %s\n", reduced);
    if (o->quiet || !(progress->done || progress->frame_done)) return;
    tell_blank_picture(o, scene, image);
    tell_bounces(o);
    tell_left_out(o, scene);
}

void sl_picture_add_warnings(cJSON *root, const sl_image *image) {
    cJSON *warnings = cJSON_AddArrayToObject(root, "warnings");
    const char *rest = sl_image_metadata(image, "softlux.warning"), *line;
    char text[2048];
    size_t length;
    while ((line = sl_next_item(&rest, "\n", &length))) {
        snprintf(text, sizeof text, "%.*s", (int)length, line);
        cJSON_AddItemToArray(warnings, cJSON_CreateString(text));
    }
}

cJSON *sl_picture_json(const sl_render_options *o, const sl_scene *scene, const sl_method *method,
                       const sl_image *image, const sl_progress *progress, double seconds) {
    int width = o->settings.width, height = o->settings.height;
    if (!width) sl_scene_film(scene, &width, &height);
    cJSON *root = cJSON_CreateObject();
    cJSON_AddItemToObject(root, "size", cJSON_CreateIntArray((const int[]){width, height}, 2));
    cJSON_AddStringToObject(root, "scene", o->scene_path);
    cJSON_AddStringToObject(root, "method", o->settings.method);
    cJSON_AddStringToObject(root, "output", o->output);
    cJSON_AddNumberToObject(root, "threads", o->settings.threads ? (double)o->settings.threads
                                                                 : (double)sysconf(_SC_NPROCESSORS_ONLN));
    cJSON_AddNumberToObject(root, "seconds", seconds);
    cJSON_AddNumberToObject(root, "batches", (double)progress->batches);
    cJSON_AddBoolToObject(root, "done", progress->done);
    cJSON_AddNumberToObject(root, "memory_bytes", (double)sl_method_memory_bytes(method));
    sl_picture_add_warnings(root, image);
    sl_json_add_counters(root, "counters", sl_method_counters(method), true);
    return root;
}

void sl_picture_stopped(const sl_render_options *o, const sl_progress *progress) {
    if (o->quiet || progress->done) return;
    fprintf(stderr, "softlux: stopped after %llu batches, about %.0f %%; %s holds what was done\n",
            (unsigned long long)progress->batches, 100.0 * progress->fraction, o->output);
}
