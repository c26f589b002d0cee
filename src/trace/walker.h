/* A random walk under way, from the eye or from a light: its ray, what it carries, and the points of a
 * sequence that decide where it goes. Sixteen go in step, so that their rays go in packets. */
#pragma once

#include "trace/sequence.h"
#include "trace/trace.h"

typedef struct sl_walker {
    sl_rgb radiance;       /* gathered so far; of walks that gather it themselves */
    struct sl_subpath *path; /* of walks that leave their vertices to others */
    /* f cos / pdf so far, by the lobes that carry light of further surfaces; and by those that reflect direct
     * light at the last one, for a light that the ray under way meets */
    sl_rgb weight, direct_weight;
    float roulette_scale;  /* 1 over the weight of the start */
    sl_vec3 origin, direction; /* of the ray under way; unit direction but for a first one that is given */
    float near, far;
    uint32_t skip;
    double pdf;            /* of the ray: per solid angle, or, if parallel, per area that faces it */
    bool parallel, from_light;
    bool at_surface;       /* a surface that is no mirror was met */
    bool mirror_since;     /* a mirror was met after the last surface */
    bool through;          /* this ray sees through surfaces: no visibility between x1 and x2 */
    uint32_t surfaces, mirrors, vertex; /* mirrors: in a row; vertex: met so far, for the sets of points */
    uint64_t key;
    uint32_t index;
} sl_walker;

/* The sets of points that a walk draws from: set 0 is for the pixel, then four a vertex. */
enum {
    SL_SET_PIXEL = 0,
    SL_SET_LIGHT = 1,
    SL_SET_DIRECTION = 2,
    SL_SET_ROULETTE = 3,
    SL_SET_THROUGH = 4,
    SL_SETS_A_VERTEX = 4
};

/* Mirrors in a row, after which a walk may end: two facing mirrors of reflectance 1 would not end it. */
enum { SL_ROULETTE_AFTER_MIRRORS = 8 };

void sl_walker_draw(const sl_sequence *sequence, const sl_walker *walker, uint32_t set, float point[3]);
/* Russian roulette: goes on with a probability that follows the weight, and makes up for it. */
bool sl_walker_survives(const sl_sequence *sequence, sl_walker *walker);
void sl_walker_leave(sl_walker *walker, sl_vec3 origin, sl_vec3 direction, double pdf, uint32_t triangle);
/* Finds what each walk's ray meets, of at least one. One that sees through surfaces meets one of all on its
 * way. */
void sl_walkers_trace(const sl_tracer *tracer, const sl_sequence *sequence, sl_walker *const *active,
                      unsigned count, bool coherent, sl_hit16 *hits, sl_counters *counters);
