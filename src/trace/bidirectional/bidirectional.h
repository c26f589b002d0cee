/* The reference bidirectional path tracer: the same light paths as the path tracer, each found from either end, and those that only
 * light can find (caustics of lights without extent). As a film, and as values at surface points, which the shading cache asks for. */
#ifndef SL_TRACE_BIDIRECTIONAL_H
#define SL_TRACE_BIDIRECTIONAL_H

#include "trace/trace.h"

/* ---- the film ------------------------------------------------------------------------------------------------------------ */

typedef struct sl_bidirectional sl_bidirectional;

typedef struct sl_bidirectional_settings {
    int width, height;
    unsigned threads;
    uint64_t seed;
    sl_transport transport;   /* filter must be BOX or CENTRE; with CENTRE light subpaths are not joined to the camera */
    bool balance;             /* the balance heuristic instead of the power heuristic */
    bool without_light_image; /* light subpaths are not joined to the camera with BOX either */
} sl_bidirectional_settings;

sl_status sl_bidirectional_create(const sl_scene *scene, const sl_tracer *tracer, const sl_bidirectional_settings *settings,
                                  sl_bidirectional **film, sl_error *error);
void sl_bidirectional_destroy(sl_bidirectional *film);
/* One more sample for every pixel, sample number `sample` (0, 1, 2, ...): an eye and a light subpath for each. */
sl_status sl_bidirectional_sample(sl_bidirectional *film, uint64_t sample, sl_counters *counters, sl_error *error);
/* As sl_path_tracer_mean(). */
void sl_bidirectional_mean(const sl_bidirectional *film, int half, float *r, float *g, float *b);
size_t sl_bidirectional_memory_bytes(const sl_bidirectional *film);

#endif
