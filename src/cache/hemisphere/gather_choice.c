/* The choice between plane, hemicube and rays: one a scene, by counts alone (gather_cost.h tells what is held against what). */
#include "base/math.h"
#include "cache/hemisphere/gather_cost.h"
#include "cache/hemisphere/gather_internal.h"

/* Infinite where the instrument cannot be as good as size x size rays. */
static sl_status cost_of(const sl_gather *gather, sl_gather_kind kind, int size, double *cost, sl_error *error) {
    *cost = INFINITY;
    if (size == 0) return SL_OK;
    sl_gather_counts counts;
    sl_status status = sl_gather_probe(gather, kind, size, &counts, error);
    if (status == SL_OK) *cost = sl_gather_see_cost(kind, &counts) + sl_gather_shade_cost(kind, &counts);
    return status;
}

/* Rays first: on a tie the instrument without a bias. */
sl_status sl_gather_choose(const sl_gather *gather, sl_gather_kind *kind, int *size, sl_error *error) {
    static const sl_gather_kind candidates[3] = {SL_GATHER_RAYS, SL_GATHER_HEMICUBE, SL_GATHER_PLANE};
    double least = INFINITY;
    int wanted = *size;
    *kind = gather->tracer ? SL_GATHER_RAYS : SL_GATHER_PLANE;
    for (int i = 0; gather->tracer && gather->raster && i < 3; i++) {
        int n = sl_gather_size_for(candidates[i], wanted, (double)gather->half_tangent);
        double cost;
        sl_status status = cost_of(gather, candidates[i], n, &cost, error);
        if (status != SL_OK) return status;
        if (!(cost < least)) continue;
        least = cost;
        *kind = candidates[i];
        *size = n;
    }
    return SL_OK;
}
