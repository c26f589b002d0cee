/* One method on one scene under the observer: its passes, snapshots of the picture with their errors, and the
 * explanations of its pixels. */
#ifndef SL_APP_STEPS_RUN_H
#define SL_APP_STEPS_RUN_H

#include "app/steps/record.h"
#include "app/steps/explanations.h"
#include "cache/frame/settings.h"

typedef struct sl_snapshot {
    uint64_t batches;
    char *picture;      /* PNG in base 64 */
    double rel_rmse;    /* against the reference, whose own noise is subtracted; negative: there is none */
    sl_counters counters; /* so far */
} sl_snapshot;

/* What the final picture would be off by without one of its layers. */
typedef struct sl_layer_error {
    char layer[32];
    double rel_rmse;
} sl_layer_error;

enum { SL_LAYERS_MAX = 8 };

typedef struct sl_steps_run {
    const sl_narrative *narrative;
    int width, height;
    sl_recording recording;
    sl_snapshot snapshots[SL_SNAPSHOTS_MAX];
    size_t snapshot_count;
    sl_layer_error layers[SL_LAYERS_MAX];
    size_t layer_count;
    char *reference, *difference; /* pictures; NULL: no reference */
    double reference_noise;       /* relative RMSE of the reference itself */
    uint32_t reference_samples;   /* a pixel */
    sl_explanations *explanations;
    char *plan;
} sl_steps_run;

typedef struct sl_steps_options {
    sl_settings settings;       /* of the method; its observer is set by the run */
    uint32_t reference_samples; /* of the path tracer, a pixel; 0: no reference */
    void (*progress)(const char *what, double fraction); /* or NULL */
} sl_steps_options;

/* Fills *run, which the caller clears, whatever comes back. */
sl_status sl_steps_run_method(const sl_scene *scene, const sl_steps_options *options, sl_steps_run *run,
                              sl_error *error);
void sl_steps_run_clear(sl_steps_run *run);

#endif
