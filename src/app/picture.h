/* The work of `softlux render`: a method is run, and its pictures are written, one or a series. */
#pragma once

#include "app/options.h"
#include "cache/frame/settings.h"

#include <cjson/cJSON.h>

typedef struct sl_render_options {
    const char *scene_path, *output;
    const char *load_cache, *save_cache; /* files, or NULL */
    sl_settings settings;
    double time_seconds;       /* stop at the first batch that ends later; 0: no limit */
    double error;              /* stop where the picture's relative RMSE is within that; 0: not asked for */
    bool quality_given;
    uint64_t batches;          /* stop after so many; 0: no limit */
    double at_seconds;         /* of an animated scene */
    uint64_t frames;           /* pictures of a series; 0: a single picture */
    double frames_per_second;  /* of the scene's time */
    int tone;                  /* as sl_tone_curve */
    double exposure;
    double light_left;         /* the share of the light that further bounces would add; 0: not measured */
    bool exposure_given, json, quiet;
    sl_reading reading;
} sl_render_options;

/* The end of a render that did not fail. */
typedef enum sl_render_end {
    SL_RENDER_DONE,
    SL_RENDER_MISSED, /* the error that was asked for */
    SL_RENDER_STOPPED /* by a signal, with work left */
} sl_render_end;

/* Renders the scene as it stands; or a series: the scene at at_seconds, then a frame's time later, and so on.
 * The method keeps its cache between frames. *end is left alone where all is done. */
sl_status sl_render_pictures(const sl_render_options *options, sl_scene *scene, sl_render_end *end,
                             sl_error *error);

/* The same by what a picture shall be instead of by what shall be done: within an error (--error), the best
 * within a time (--time). */
sl_status sl_render_to_target(const sl_render_options *options, const sl_scene *scene, sl_render_end *end,
                              sl_error *error);

/* ---- what both share ---- */

/* Updates until the picture (or the frame) is done, time or batches run out, or somebody presses Ctrl-C; with
 * a progress bar. */
sl_status sl_picture_run(const sl_render_options *options, sl_method *method, sl_progress *progress,
                         double start, double done_before, sl_error *error);
/* Tells on stderr what the method found out on its way, and of a finished picture whether there is anything
 * to be seen. */
void sl_picture_warn(const sl_render_options *options, const sl_scene *scene, const sl_progress *progress,
                     const sl_image *image);
/* Says on stderr of a picture that is not done how far it has come. */
void sl_picture_stopped(const sl_render_options *options, const sl_progress *progress);
/* *stops: the exposure that a PNG was given. */
sl_status sl_picture_write(const sl_render_options *options, const sl_image *image, const char *path,
                           double *stops, sl_error *error);
/* Adds to --json how radiance became the 8 bits of a PNG; nothing for other formats. */
void sl_picture_add_tone(const sl_render_options *options, double stops, cJSON *json);
/* Adds the warnings of a picture to --json, as an array of lines. */
void sl_picture_add_warnings(cJSON *root, const sl_image *image);
/* Returns what was done, for --json. */
cJSON *sl_picture_json(const sl_render_options *options, const sl_scene *scene, const sl_method *method,
                       const sl_image *image, const sl_progress *progress, double seconds);

/* Runs a method to its end; fails where that takes longer than so many seconds. */
sl_status sl_picture_make(const sl_scene *scene, const sl_settings *settings, double seconds,
                          sl_image **image, sl_error *error);
