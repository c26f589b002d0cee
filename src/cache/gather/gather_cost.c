/* The choice between a raster gather and rays, by counts alone (radiance-cache-splatting 9): one choice a scene, the same on
 * every machine and in every run, never from a clock. */
#include "cache/gather/gather_internal.h"

#include "base/math.h"

/* Nanoseconds of visibility alone, fitted to what bench_gather measured at N = 64 on one core (five scenes of 32 to 878,000
 * triangles, within a factor of two but for the largest, whose views hold little of it; only the ratio matters):
 *   t_raster = a0 + a1 sqrt T + a3 N^2     clusters that lie outside, behind or hidden are rejected whole, so that what a view
 *                                          sets up grows far more slowly than T
 *   t_rays   = N^2 (b0 + b1 log2 T) */
static const double pass_cost = 20000.0, surface_cost = 2200.0, fragment_cost = 15.0;
static const double ray_cost = 10.0, ray_level_cost = 8.0;

static double raster_time(double triangles, double cells) {
    return pass_cost + surface_cost * sqrt(triangles) + fragment_cost * cells;
}

static double ray_time(double triangles, double cells) {
    return cells * (ray_cost + ray_level_cost * sl_log(triangles + 2.0) / sl_log(2.0));
}

/* By four times: at equal N a plane of 140 degrees errs about three times as much as rays (it lacks the directions near the
 * horizon: 6.7 % against 2.1 % at 64 x 64, radiance-cache-splatting 2.6), so a quarter of the rays is still the better
 * instrument; and beyond 64 x 64 its border, not its pixels, is what errs, so larger planes are held against 64 x 64 rays. With
 * the constants measured so far rays are chosen everywhere. */
bool sl_gather_raster_is_cheaper(const sl_scene *scene, const sl_gather_settings *settings) {
    double triangles = (double)scene->triangle_count, cells = (double)settings->size * (double)settings->size;
    return 4.0 * raster_time(triangles, cells) < ray_time(triangles, fmin(cells, 64.0 * 64.0));
}
