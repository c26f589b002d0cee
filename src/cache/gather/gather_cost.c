/* The choice between a raster gather and rays, by counts alone (radiance-cache-splatting 9): one choice a scene, the same on
 * every machine and in every run, never from a clock. */
#include "cache/gather/gather_internal.h"

#include "base/math.h"

/* Nanoseconds on one core of the machine on which bench_gather was run; only their ratios matter.
 *   t_raster = a0 + a1 clusters + a2 triangles + a3 fragments
 *   t_rays   = N^2 (b0 + b1 log2 T + b2 sqrt T), the last for hierarchies that outgrow the caches
 * What a view sees is not known before it is seen: a plane of 140 degrees meets about a third of the triangles of a closed scene. */
static const double pass_cost = 20000.0, cluster_cost = 12.0, triangle_cost = 60.0, fragment_cost = 25.0, share_seen = 0.33;
static const double ray_cost = 20.0, ray_level_cost = 3.0, ray_growth = 0.1;
enum { CLUSTER_TRIANGLES = 96 };

static double raster_time(double triangles, double cells) {
    return pass_cost + cluster_cost * triangles / CLUSTER_TRIANGLES + triangle_cost * share_seen * triangles + fragment_cost * cells;
}

static double ray_time(double triangles, double cells) {
    double levels = sl_log(triangles + 2.0) / sl_log(2.0);
    return cells * (ray_cost + ray_level_cost * levels + ray_growth * sqrt(triangles));
}

/* By four times: at equal N a plane of 140 degrees errs about three times as much as rays (it lacks the directions near the horizon:
 * 6.7 % against 2.1 % at 64 x 64, radiance-cache-splatting 2.6), so a quarter of the rays is still the better instrument. With the
 * constants measured so far that is nowhere the case. */
bool sl_gather_raster_is_cheaper(const sl_scene *scene, const sl_gather_settings *settings) {
    double triangles = (double)scene->triangle_count, cells = (double)settings->size * (double)settings->size;
    return 4.0 * raster_time(triangles, cells) < ray_time(triangles, cells);
}
