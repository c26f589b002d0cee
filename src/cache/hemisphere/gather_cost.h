/* What a gather costs, and what it is worth: the model behind `--gather auto`.
 *
 * Cheaper means cheaper at equal expected error. A plane of N x N pixels costs less than N x N rays in most scenes, but it lacks the
 * directions near the horizon, and who asks for 256 x 256 wants the error of 256 x 256, not a fast picture that stays at 3 % whatever
 * N is. So N is a promise of quality: that of N x N rays, the instrument without a bias. Every other instrument is given the size at
 * which it errs as little (sl_gather_size_for; there may be none), and the cheapest of what remains is taken, its light included.
 * Who wants the plane for its own sake asks for it.
 *
 * In every scene measured that choice is rays. Drawing is the cheaper way to see: at equal N a plane is seen 1.3 to 5 times faster
 * than its rays are traced from 64 x 64 on, and at any N in small scenes. But lighting what is seen costs several times what seeing it
 * costs, and a hemicube as good as N x N rays has twice their cells to light, a plane, where it can be as good, 5 to 7 times.
 *
 * Costs are linear in counts, each with a constant that is not negative: what the raster hardware counts when it draws a few views of
 * this scene (gather_probe.c), what is visible in them, and N. No clock has a say, so a scene has one choice on every machine. */
#ifndef SL_CACHE_GATHER_COST_H
#define SL_CACHE_GATHER_COST_H

#include "cache/hemisphere/gather.h"

/* One gather in counts, the mean of some. Those of rays at N are of the plane at N: what the hardware draws, and what then shows, tells
 * how much there is to walk through, and how far the rays of a packet part. */
typedef struct sl_gather_counts {
    double triangles;  /* of the scene */
    double cells;      /* N^2, hemicube: 3 N^2 */
    double passes, clusters_tested, triangles_submitted, triangles_rasterized;
    double visible;    /* different triangles in a tile of 4 x 4 cells, summed over the tiles */
    double hits;       /* cells in which something is seen */
    double samples;    /* light samples drawn, one a hit where there is anything to draw from */
    double shadow_rays, shadow_lookups;
} sl_gather_counts;

/* The terms that constants are fitted to: cost = sum of constants[i] * terms[i]. */
enum { SL_GATHER_COST_TERMS = 6 };
typedef struct sl_gather_terms {
    double see[SL_GATHER_COST_TERMS], shade[SL_GATHER_COST_TERMS];
} sl_gather_terms;
sl_gather_terms sl_gather_cost_terms(sl_gather_kind kind, const sl_gather_counts *counts);

/* Nanoseconds on the processor they were fitted on; only ratios mean anything. */
double sl_gather_see_cost(sl_gather_kind kind, const sl_gather_counts *counts);
double sl_gather_shade_cost(sl_gather_kind kind, const sl_gather_counts *counts);

/* Relative RMS error of the irradiance to be expected at size N. */
double sl_gather_expected_error(sl_gather_kind kind, int size, double half_tangent);
/* The least size at which an instrument errs no more than size x size rays are expected to; 0 if there is none of at most
 * SL_GATHER_SIZE_MAX. */
enum { SL_GATHER_SIZE_MAX = 1024 };
int sl_gather_size_for(sl_gather_kind kind, int size, double half_tangent);

/* ---- counts of a scene (gather_probe.c) ---- */

struct sl_gather;
/* The counts of an instrument at N, from views at a few points that the scene's own camera sees. gather: everything but tables and kind
 * decided; raster and tracer there. What is counted here is no part of anybody's bill. */
sl_status sl_gather_probe(const struct sl_gather *gather, sl_gather_kind kind, int size, sl_gather_counts *counts, sl_error *error);

#endif
