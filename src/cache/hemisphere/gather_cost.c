#include "cache/hemisphere/gather_cost.h"

#include "base/math.h"

/* Nanoseconds, fitted by `bench_gather --fit` over the twelve scenes of scenes/ and scenes/generated/ (24 to 878,000 triangles), N = 16 to 256,
 * on one core with AVX-512: least squares of the relative error, no constant negative. What is left is 18 % RMS for the raster, 13 % for
 * rays, 28 % for light, and 45, 15 and 37 % on a scene that had no part in the fit (the raster's clusters are told by the largest scene alone).
 *   t_plane, t_hemicube   passes | clusters tested | triangles submitted | outlines: sqrt(cells * triangles rasterized), about how many blocks
 *                         of pixels the sides of the triangles cross | cells | cells beyond 2^16, where the picture leaves the cache
 *   t_rays                cells | visible triangles | the same by levels of the hierarchy, log2 T | triangles submitted */
static const double raster_see[SL_GATHER_COST_TERMS] = {1857.0, 3.55, 12.06, 21.95, 4.869, 7.174};
static const double ray_see[SL_GATHER_COST_TERMS] = {9.643, 113.3, 12.42, 3.901, 0.0, 0.0};
/*   t_shade               cells | light samples drawn | shadow rays | shadow rays by levels | visible triangles | shadow-map lookups (these from
 *                         cave.json by hand: no other scene of many triangles is lit by lights without extent alone) */
static const double any_shade[SL_GATHER_COST_TERMS] = {0.0, 94.25, 24.35, 6.7, 144.6, 180.0};

/* ---- cost ---- */

static double levels(const sl_gather_counts *c) { return sl_log(c->triangles + 2.0) / sl_log(2.0); }

static double outlines(const sl_gather_counts *c) { return sqrt(c->cells * c->triangles_rasterized); }

sl_gather_terms sl_gather_cost_terms(sl_gather_kind kind, const sl_gather_counts *c) {
    const double cached = 65536.0;
    double beyond = c->cells > cached ? c->cells - cached : 0.0;
    sl_gather_terms raster = {.see = {c->passes, c->clusters_tested, c->triangles_submitted, outlines(c), c->cells, beyond}};
    sl_gather_terms rays = {.see = {c->cells, c->visible, c->visible * levels(c), c->triangles_submitted}};
    sl_gather_terms t = kind == SL_GATHER_RAYS ? rays : raster;
    double shade[SL_GATHER_COST_TERMS] = {c->cells, c->samples, c->shadow_rays, c->shadow_rays * levels(c), c->visible, c->shadow_lookups};
    for (int i = 0; i < SL_GATHER_COST_TERMS; i++) t.shade[i] = shade[i];
    return t;
}

static double weigh(const double constants[SL_GATHER_COST_TERMS], const double terms[SL_GATHER_COST_TERMS]) {
    double sum = 0.0;
    for (int i = 0; i < SL_GATHER_COST_TERMS; i++) sum += constants[i] * terms[i];
    return sum;
}

double sl_gather_see_cost(sl_gather_kind kind, const sl_gather_counts *counts) {
    sl_gather_terms terms = sl_gather_cost_terms(kind, counts);
    return weigh(kind == SL_GATHER_RAYS ? ray_see : raster_see, terms.see);
}

double sl_gather_shade_cost(sl_gather_kind kind, const sl_gather_counts *counts) {
    sl_gather_terms terms = sl_gather_cost_terms(kind, counts);
    return weigh(any_shade, terms.shade);
}

/* ---- expected error ---- */

/* Relative RMS errors of the irradiance against 2 x 256^2 rays at 32 points, geometric means over the twelve scenes (`bench_gather --auto`
 * prints them beside what this expects):
 *          N     16    32    64   128   256
 *   plane      15.4  11.3   6.1   4.1   3.3 %
 *   hemicube    9.9   3.1   1.8   1.0   0.6 %
 *   rays       10.2   5.9   2.3   1.0   0.6 %
 * Rays fall as 1 / N, for cells are strata, not random points; so does the hemicube, whose side faces hold two thirds of its cells but less
 * than half of the cosine weight. The plane stays at what it lacks, the directions near the horizon, 9.75 % of the cosine weight
 * outside 140 degrees, however its border is extended. */
static const double ray_error = 1.55, hemicube_error = 1.27, plane_error = 3.2, plane_floor = 0.03, default_share = 0.0975;

/* 1 - F, F = 4 / pi sin(phi) atan(sin(phi)), phi half the field of view: what a square picture leaves out of the cosine-weighted
 * hemisphere. */
static double share_outside(double half_tangent) {
    double sine = half_tangent / sqrt(1.0 + half_tangent * half_tangent);
    return fmax(0.0, 1.0 - 4.0 / SL_PI * sine * sl_atan2(sine, 1.0));
}

double sl_gather_expected_error(sl_gather_kind kind, int size, double half_tangent) {
    double n = (double)size;
    if (kind == SL_GATHER_RAYS) return ray_error / n;
    if (kind == SL_GATHER_HEMICUBE) return hemicube_error / n;
    double pixels = plane_error / n, border = plane_floor * share_outside(half_tangent) / default_share;
    return sqrt(pixels * pixels + border * border);
}

int sl_gather_size_for(sl_gather_kind kind, int size, double half_tangent) {
    double wanted = sl_gather_expected_error(SL_GATHER_RAYS, size, half_tangent);
    for (int n = 4; n <= SL_GATHER_SIZE_MAX; n += 2) { /* hemicubes are even */
        if (sl_gather_expected_error(kind, n, half_tangent) <= wanted) return kind == SL_GATHER_RAYS ? size : n;
    }
    return 0;
}
