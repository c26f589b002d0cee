/* softlux render: a picture of a scene, or a series of an animated one. */
#include "app/auto_method.h"
#include "app/clock.h"
#include "app/commands.h"
#include "app/files_of_ranks.h"
#include "app/memory_limit.h"
#include "app/options.h"
#include "app/page.h"
#include "app/picture.h"
#include "app/same_file.h"
#include "base/error.h"
#include "base/values.h"
#include "cache/frame/all_light.h"
#include "image/output_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool parse(int argc, char **argv, sl_render_options *o, bool *at_given, const char **error_text,
                  int *status) {
    *o = (sl_render_options){.tone = SL_TONE_REINHARD,
                             .output = "out.exr",
                             .frames_per_second = 25.0,
                             .settings = sl_settings_default()};
    const sl_option options[] = {
        SL_TEXT("output", 'o', &o->output, "FILE", "picture to write: .exr, .png or .pfm [out.exr]"),
        SL_TEXT("load-cache", 0, &o->load_cache, "FILE", "splatting: start with the records of another run"),
        SL_TEXT("save-cache", 0, &o->save_cache, "FILE", "splatting: keep the records for another run"),
        SL_TEXT("error", 0, error_text, "E",
                "refine until the relative RMSE is within E (0.05 or 5%), with 95 % confidence"),
        SL_REAL("time", &o->time_seconds, NULL, "SECONDS", 1e-3, 1e9,
                "the best picture within that; with --quality or --batches: stop at the first batch that "
                "ends later"),
        SL_NUMBER("batches", 0, &o->batches, "N", 1, 1e15, "stop after N batches"),
        SL_REAL("at", &o->at_seconds, at_given, "SECONDS", -1e9, 1e9, "time of an animated scene [0]"),
        SL_NUMBER(
            "frames", 0, &o->frames, "N", 1, 1e9,
            "a series of N pictures of an animated scene; --output names the number, as frame-%04d.png"),
        SL_REAL("fps", &o->frames_per_second, NULL, "F", 1e-3, 1e6,
                "frames for each second of the scene's time [25]"),
        SL_REAL("exposure", &o->exposure, &o->exposure_given, "STOPS", -64, 64,
                "PNG: times 2^STOPS [automatic]"),
        SL_CHOICE("tone", &o->tone, "CURVE", "clip|reinhard", "PNG: clip or reinhard [reinhard]"),
        SL_FLAG("json", &o->json, "print what was done as one JSON object"),
        SL_FLAG("quiet", &o->quiet, "no progress bar, no warnings"),
        {.name = NULL}};
    const sl_command_line line = {
        "softlux render SCENE [-o FILE] [options]",
        "Renders a scene: a JSON scene file, or a mesh file (OBJ, glTF, PLY, ...).",
        "--error and --time without --quality begin with coarse settings and go on to finer ones (path and "
        "bidirectional:\n"
        "more samples); options that are given stay as they are, and --error begins at a given --quality. "
        "The error is that\n"
        "against a converged picture of the same light paths, estimated from path traced probe pixels: no "
        "reference is needed.\n"
        "It is relative to the mean of the surfaces that are seen, without the pixels that show lamps or the "
        "sky themselves.\n"
        "Where a method does not get within E its best picture is written all the same, and the exit status "
        "is 1.\n\n"
        "Ctrl-C (SIGINT), SIGTERM and SIGHUP write what is done so far and say so by the exit status: 128 + "
        "the signal's number\n"
        "(130 for Ctrl-C), also of a series, whose whole frames are kept. A second one ends the program at "
        "once. A picture stopped by --time can be had again, bit for bit, with the settings\n"
        "that its metadata tells, and --batches with the number in softlux.batches.\n\n"
        "example: softlux render scenes/cornell.json -q high -o cornell.exr",
        options, 1, 1, &o->reading, &o->settings, &o->quality_given};
    int operands;
    *at_given = false;
    *error_text = NULL;
    return sl_options_parse(&line, argc, argv, &o->scene_path, &operands, status);
}

/* "0.05" or "5%": a share above 0. */
static bool parse_share(const char *text, double *share) {
    char *end;
    double value = strtod(text, &end);
    if (end == text) return false;
    if (*end == '%') {
        value /= 100.0;
        end++;
    }
    *share = value;
    return !*end && value >= 1e-5 && value <= 10.0; /* false for NaN */
}

/* --error, and what does not go with it. */
static bool take_error(sl_render_options *o, const char *text) {
    if (!text) return true;
    if (!parse_share(text, &o->error)) {
        fprintf(stderr, "softlux: --error: expected a share of 0.00001 to 10, as 0.05 or 5%%, got '%s'\n",
                text);
        return false;
    }
    const char *other = o->frames       ? "--frames"
                        : o->batches    ? "--batches"
                        : o->load_cache ? "--load-cache"
                        : o->save_cache ? "--save-cache"
                                        : NULL;
    if (other)
        fprintf(
            stderr,
            "softlux: --error: a picture's settings are not known beforehand, so %s does not go with it\n",
            other);
    return !other;
}

/* Takes --frames: a series has all its frames finished; of --time the choice of a method may make use. */
static bool take_frames(const sl_render_options *o) {
    const bool chooses = strcmp(o->settings.method, "auto") == 0;
    const char *other = !o->frames                          ? NULL
                        : o->batches                        ? "--batches"
                        : o->time_seconds > 0.0 && !chooses ? "--time"
                                                            : NULL;
    if (other)
        fprintf(stderr, "softlux: --frames: every frame is finished, so %s does not go with it\n", other);
    return !other;
}

/* Do lights or objects move from the first picture of a series to the next? */
static sl_status do_things_move(const sl_render_options *o, sl_scene *scene, bool *move, sl_error *error) {
    unsigned changes = 0;
    *move = false;
    if (o->frames < 2) return SL_OK;
    sl_status status = sl_scene_set_time(scene, o->at_seconds + 1.0 / o->frames_per_second, &changes, error);
    *move = (changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS)) != 0;
    return status == SL_OK ? sl_scene_set_time(scene, o->at_seconds, NULL, error) : status;
}

static sl_status choose_method(sl_render_options *o, sl_scene *scene, sl_error *error) {
    sl_auto_budget budget = {
        .error = o->error, .time_seconds = o->time_seconds, .quality = o->settings.quality};
    if (strcmp(o->settings.method, "auto") != 0) return SL_OK;
    sl_status status = do_things_move(o, scene, &budget.things_move, error);
    return status == SL_OK ? sl_auto_settle(scene, &budget, o->quiet, &o->settings, error) : status;
}

/* Where the bounces are left to the scene they are the same for all pictures of a climb or a series. */
static sl_status choose_bounces(sl_render_options *o, const sl_scene *scene, sl_error *error) {
    sl_bounces_measured found;
    if (o->settings.bounces || !sl_has_bounces(&o->settings)) return SL_OK;
    sl_status status = sl_measure_bounces(scene, &o->settings, &found, error);
    if (status != SL_OK) return status;
    o->settings.bounces = found.bounces;
    o->light_left = found.left;
    return SL_OK;
}

/* Tells whether --error or --time say what the picture shall be. */
static bool is_target(const sl_render_options *o) {
    if (o->frames) return false;
    if (o->error > 0.0) return true;
    bool fixed = o->quality_given || o->batches || o->load_cache || o->save_cache;
    return o->time_seconds > 0.0 && !fixed;
}

static sl_status render(sl_render_options *o, sl_scene *scene, sl_render_end *end, sl_error *error) {
    sl_status status = choose_method(o, scene, error);
    if (status == SL_OK) status = choose_bounces(o, scene, error);
    if (status != SL_OK) return status;
    return is_target(o) ? sl_render_to_target(o, scene, end, error)
                        : sl_render_pictures(o, scene, end, error);
}

/* ---- names of files ---- */

/* Tells whether the output's name says how to write it, and for a series where the frame's number goes. */
static sl_status check_name(const sl_render_options *o, sl_error *error) {
    bool known = sl_ends_with(o->output, ".exr") || sl_ends_with(o->output, ".png") ||
                 sl_ends_with(o->output, ".pfm");
    if (known && (!o->frames || sl_frame_pattern_is_good(o->output))) return SL_OK;
    return known ? sl_fail(error, SL_ERROR_USAGE,
                           "--output: for --frames expected a name with the frame's number in it, as "
                           "frame-%%04d.png; got '%s'",
                           o->output)
                 : sl_fail(error, SL_ERROR_USAGE,
                           "--output: expected a name that ends with .exr, .png or .pfm, got '%s'",
                           o->output);
}

/* Fails where the picture, the first of a series or the cache could not be written. */
static sl_status check_output(const sl_render_options *o, sl_error *error) {
    char first[4096];
    if (o->frames) sl_frame_name(o->output, 0, first, sizeof first);
    sl_status status = sl_output_check(o->frames ? first : o->output, error);
    return status == SL_OK && o->save_cache ? sl_output_check(o->save_cache, error) : status;
}

/* Lets a cache be kept in the file that it came from, and nothing else. */
static bool loses_nothing(const sl_render_options *o) {
    const char *const read[] = {o->load_cache}, *const others[] = {o->output};
    return sl_is_file_of_its_own("output", o->output, read, 1) &&
           sl_is_file_of_its_own("save-cache", o->save_cache, others, 1);
}

int sl_command_render(int argc, char **argv) {
    sl_render_options o;
    int exit_status;
    bool at_given;
    sl_render_end end = SL_RENDER_DONE;
    const char *error_text;
    if (!parse(argc, argv, &o, &at_given, &error_text, &exit_status)) return exit_status;
    if (!take_error(&o, error_text) || !take_frames(&o)) return SL_ERROR_USAGE;
    if (!loses_nothing(&o)) return SL_ERROR_USAGE;
    sl_error error;
    sl_scene *scene = NULL;
    sl_keep_freed_memory(&o.settings);
    sl_status status = check_name(&o, &error); /* before the work, not after */
    if (status == SL_OK) status = check_output(&o, &error);
    if (status == SL_OK)
        status = sl_load_for_ranks(o.scene_path, &o.reading.load, &o.settings, &scene, &error);
    if (status == SL_OK) status = sl_spare_scene(scene, "output", o.output, &error);
    if (status == SL_OK) status = sl_spare_scene(scene, "save-cache", o.save_cache, &error);
    if (status == SL_OK && (at_given || o.frames))
        status = sl_scene_set_time(scene, o.at_seconds, NULL, &error);
    if (status == SL_OK) {
        sl_tell_warnings(scene, o.quiet);
        status = render(&o, scene, &end, &error);
    }
    sl_scene_destroy(scene);
    if (status != SL_OK) return sl_complain(&error);
    return end == SL_RENDER_STOPPED  ? sl_interrupted_status()
           : end == SL_RENDER_MISSED ? SL_EXIT_COMPARISON_FAILED
                                     : 0;
}
