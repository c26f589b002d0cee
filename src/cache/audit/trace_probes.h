/* Path traced values of pixels, for probes: twice over, with as many samples as are asked for, each pixel
 * traced once only. */
#pragma once

#include "trace/path_walk.h"

/* A pixel that is traced. */
typedef struct sl_probe {
    uint32_t pixel, samples;     /* samples of each half */
    double sum[SL_HALVES][3];
} sl_probe;

typedef struct sl_probe_tracer {
    const sl_scene *scene;
    sl_tracer *tracer;
    sl_light_sampler *lights;
    sl_sequence sequence;
    sl_path_walk walk;
    sl_path_lamps lamps; /* of that walk */
    sl_path_lens lens;
    sl_image *surfaces;  /* the pixels that show no lamp: sl_audit_surfaces() */
    unsigned threads;
    uint64_t seed;
    size_t pixels;       /* of the picture */
    int block, across;   /* the pilot has a sample for each block x block pixels, so many side by side */
    size_t blocks;
    float *pilot;        /* R, G, B planes of them; NULL until it is wanted */
    uint32_t *slot;      /* of each pixel, or SL_NO_INDEX */
    size_t slots, capacity;
    sl_probe *probe;     /* of each slot */
    sl_counters counters;
} sl_probe_tracer;

sl_status sl_probe_tracer_create(sl_probe_tracer *t, const sl_scene *scene, const sl_transport *transport,
                                 int width, int height, unsigned threads, uint64_t seed, sl_error *error);
void sl_probe_tracer_release(sl_probe_tracer *t);
/* One sample of a pixel in every block, independent of all others; of every pixel, unless the picture is
 * large. */
sl_status sl_probe_tracer_pilot(sl_probe_tracer *t, sl_error *error);
static inline size_t sl_probe_tracer_block(const sl_probe_tracer *t, size_t pixel) {
    size_t width = (size_t)t->lens.width, side = (size_t)t->block;
    return pixel / width / side * (size_t)t->across + pixel % width / side;
}
/* Each of the pixels, which differ, has at least so many samples a half afterwards. */
sl_status sl_probe_tracer_trace(sl_probe_tracer *t, const uint32_t *pixels, size_t count, uint32_t samples,
                                sl_error *error);
/* Samples of both halves together that this would trace. */
double sl_probe_tracer_missing(const sl_probe_tracer *t, const uint32_t *pixels, size_t count,
                               uint32_t samples);
/* The two halves' means at a pixel that has been traced. */
void sl_probe_tracer_means(const sl_probe_tracer *t, uint32_t pixel, double p[3], double q[3]);

/* A picture of one channel: 0 where a pixel's first hit shines towards the eye or a sky that shines is seen,
 * else 1. A pixel of a box shows what any part of it does. 1 everywhere where nearly nothing but light is
 * seen (a furnace), or the transport leaves out emission. The caller destroys it (surfaces.c). */
sl_status sl_audit_surfaces(const sl_path_walk *walk, const sl_path_lens *lens, unsigned threads,
                            sl_image **surfaces, sl_error *error);
