/* Tells observers of a method's passes: each with the picture that it made, and with what the counters have
 * grown by since the last one. Without an observer it costs nothing. */
#pragma once

#include "raster/raster.h"

typedef struct sl_announcer {
    const sl_observer *observer; /* or NULL */
    const char *method;
    const sl_counters *counters; /* the method's own */
    sl_counters told;            /* as they were at the last pass */
} sl_announcer;

/* Tells whether anybody looks: pictures and marks that the method itself needs not are not made else. */
static inline bool sl_announcing(const sl_announcer *announcer) {
    return announcer->observer && announcer->observer->pass;
}

/* planes: `channels` planes of width*height, one after another, bottom row first where bottom_first. */
void sl_announce(sl_announcer *announcer, const char *name, const char *source, int width, int height,
                 int channels, const float *planes, bool bottom_first);
/* An id map, bottom row first, as a plane of numbers: -1 where there is none. */
void sl_announce_ids(sl_announcer *announcer, const char *name, const char *source, int width, int height,
                     const uint32_t *id);
/* A pass that leaves no picture. */
void sl_announce_pass(sl_announcer *announcer, const char *name, const char *source);
/* A pass that leaves marks in the scene: records, photon hits, the edges of a mesh. */
void sl_announce_marks(sl_announcer *announcer, const char *name, const char *source, const sl_mark *marks,
                       size_t count);
/* Three planes that lie apart, bottom row first. */
void sl_announce_planes(sl_announcer *announcer, const char *name, const char *source, int width, int height,
                        const float *const planes[3]);
/* Depth, positions, normals and albedo; the first picture pays for the pass. */
void sl_announce_gbuffer(sl_announcer *announcer, const char *source, const sl_gbuffer *gbuffer);
