/* A page of a method's steps on one scene: under the observer its passes, snapshots of the picture with their
 * errors, and the explanations of its pixels. */
#pragma once

#include "cache/frame/settings.h"

typedef struct sl_steps_options {
    sl_settings settings;       /* of the method; its observer is set by the run */
    const char *beside;         /* another method, side by side with it; or NULL */
    uint32_t reference_samples; /* of the path tracer, a pixel; 0: no reference */
    bool quiet;
} sl_steps_options;

/* Makes pictures for a page, small and in the shape of a film: every pixel has an explanation to be told. */
void sl_steps_size(int width, int height, sl_settings *settings);
/* Runs one method, or both, and writes the page. What page.js reads is a list of runs: "narrative", "width",
 * "height", "plan", "snapshots" (batches, error, picture), "steps", "explanations", and where there is a
 * reference "layers" (the error without each) and "reference". Pictures are PNG in base 64, errors relative
 * RMSE against the reference, whose own noise is subtracted; null: not known. */
sl_status sl_steps_write(const sl_scene *scene, const char *scene_path, const sl_steps_options *options,
                         const char *path, sl_error *error);
