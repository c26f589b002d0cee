/* One method on one scene under the observer: its passes, snapshots of the picture with their errors, and the
 * explanations of its pixels. */
#pragma once

#include "cache/frame/settings.h"

#include <cjson/cJSON.h>

typedef struct sl_steps_options {
    sl_settings settings;       /* of the method; its observer is set by the run */
    uint32_t reference_samples; /* of the path tracer, a pixel; 0: no reference */
    bool quiet;
} sl_steps_options;

/* Runs a method; *run, which the caller deletes, is what page.js reads: "narrative", "width", "height",
 * "plan", "snapshots" (batches, error, picture), "steps", "explanations", and where there is a reference
 * "layers" (the error without each) and "reference". Pictures are PNG in base 64, errors relative RMSE
 * against the reference, whose own noise is subtracted; null: not known. */
sl_status sl_steps_run(const sl_scene *scene, const sl_steps_options *options, cJSON **run, sl_error *error);

/* Writes a page of runs, a JSON array of one method's or two's. */
sl_status sl_steps_page(const char *path, const char *methods, const char *scene, const cJSON *runs,
                        sl_error *error);
