/* Parts of the experiments on the shading cache: a scene with the sample renderers that the
 * cache itself uses, so that its rivals have the same; the cache, driven update by update; errors against
 * what those renderers say of each pixel, which is what all of them approach. */
#pragma once

#include "cache/shading_cache/priority.h"
#include "common.h"
#include "render_cache.h"

typedef struct shading_world {
    char name[64];
    sl_scene *scene;
    sl_tracer *own;
    const sl_tracer *tracer;
    sl_settings settings;            /* of the cache, complete: an update after every edit, and no end */
    sl_sample_renderer renderer[2];
    int renderers;
    bench_pixels pixels;             /* that are judged, of the view as it stands */
    float *limit;                    /* what the renderers say of them: 3 values each */
    sl_display_curve display;        /* radiance to grey levels, as the cache itself reckons */
} shading_world;

/* size: of pictures; area: points on each lamp (0: the cache's own); indirect: paths a point (0: no indirect
 * light). One thread. False where the scene is not wanted, or not there. */
bool shading_open(const bench_options *o, const char *path, int size, int area, int indirect,
                  shading_world *w);
void shading_close(shading_world *w);
/* Everything goes to where it is at a time; returns SL_CHANGED_ bits. */
unsigned shading_move(shading_world *w, double time);
/* Finds the limit for one pixel of each block x block. */
void shading_judge(shading_world *w, int block);
/* Of R, G, B planes against the limit: root mean square of the difference in displayed levels, 0 to 255, over
 * pixels and channels. What lamps are brighter than white by so counts for nothing, and what shows in the
 * dark for something. */
double shading_error(shading_world *w, const float *planes);

/* ---- the cache ---- */

typedef struct shading_run {
    shading_world *world;
    sl_method *method;
    double seconds; /* of all updates; of the processor, all threads */
    uint64_t updates;
} shading_run;

/* settings: NULL for the world's. */
void shading_run_open(shading_run *run, shading_world *w, const sl_settings *settings);
void shading_run_close(shading_run *run);
void shading_run_edit(shading_run *run, unsigned changes);
void shading_run_update(shading_run *run);
uint64_t shading_run_points(const shading_run *run);
double shading_run_error(shading_run *run);

/* ---- rivals ---- */

render_cache *shading_rival(const shading_world *w, int samples);
/* Of its picture as things are now, narrow gaps filled or wide ones, too. */
double shading_rival_error(shading_world *w, render_cache *cache, bool wide_fill);
/* The path tracer on the cache's paths, that many samples a pixel of the whole picture: its error; *seconds:
 * of the processor. */
double shading_path_error(shading_world *w, uint32_t samples, double *seconds);
