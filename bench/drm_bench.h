/* What the experiments on direct radiance mapping share beside common.h: frames of the method, and times of
 * several things taken in turn. */
#ifndef SL_BENCH_DRM_H
#define SL_BENCH_DRM_H

#include "common.h"

enum { DRM_CHANGED_ALL = SL_CHANGED_CAMERA | SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS };

/* ---- frames ---- */

/* The paper's: a picture of 512 x 512, one frustum, 3 x 3 photons read from a map of 18 x 18 (16, rounded up
 * to a multiple of 3). */
sl_settings drm_paper_settings(int size, sl_photon_weight weight);

typedef struct drm_frames {
    sl_scene *scene;
    sl_method *method;
    sl_image *image;       /* of the last frame */
    sl_counters counters;  /* of the last frame alone */
} drm_frames;

void drm_frames_open(drm_frames *f, sl_scene *scene, const sl_settings *settings);
/* The next frame, after so much has changed. */
void drm_frame(drm_frames *f, unsigned changes);
void drm_frames_close(drm_frames *f);
/* A value of the last frame's, "direct.R", or 0 where it has no such layer. */
const float *drm_layer(const sl_image *image, const char *layer, char channel);

/* ---- times ---- */

/* Things that are measured beside each other take turns, so that whatever else the machine does hits all. One
 * thread: median of processor time. More: the shortest time by a clock, since whatever else runs can only
 * add. */
typedef struct drm_timed {
    void (*run)(void *context);
    void *context;
    /* apart: half the distance of the quartiles; of more threads the median over the shortest, less 1 */
    double ms, apart;
} drm_timed;

enum { DRM_TIMED_MAX = 32 };
/* seconds: for all of them together, once each has run three times. */
void drm_time(drm_timed *timed, size_t count, unsigned threads, double seconds);

#endif
