/* Irradiance from one light at one point (multi-mesh caching, section on hardware sampling): for an area
 * light the scene is drawn into the frustum that just holds the light, every pixel of the light that no
 * occluder hides counts with its solid angle and cosine, and the picture is summed on the hardware, 2x2 and
 * 2x2 again, down to 16x16. Or by shadow rays. What comes out is F, which the light's colour (lights.h) turns
 * into irradiance.
 *
 * A sample is a pure function of scene, light, point and settings: no jitter but by position (rays), so a
 * mesh refined on samples comes to rest. Read in this order:
 *
 *   lights.c           which lights there are
 *   light_sample.c     what kind of light, whether it can be seen at all, how many pixels it takes
 *   look_at.c          the paper's frustum, solid angles of pixels, ratio to the closed form
 *   closed_forms.c     polygons clipped to the horizon (Lambert), tiny lights as points
 *   shadow_ray.c       rays: lights without extent, the estimator SL_LIGHT_RAYS, what a glossy lobe reflects
 */
#pragma once

#include "cache/light/lights.h"
#include "raster/raster.h"
#include "trace/bsdf.h"
#include "trace/sequence.h"
#include "trace/trace.h"

typedef struct sl_light_sample_settings {
    sl_light_estimator estimator;
    int size;              /* N of N x N pixels, a power of two; doubled where none is on the light, */
    int largest;           /* ... up to this, 2048 at most */
    int rays;              /* n of n x n rays */
    unsigned threads;      /* for making what is shared */
} sl_light_sample_settings;

sl_light_sample_settings sl_light_sample_defaults(void);

/* Where light arrives. normal and geometric_normal are unit, on the lit side; light counts where it is above
 * both horizons. */
typedef struct sl_lit_point {
    sl_vec3 position, normal, geometric_normal;
    /* on which it lies and which hides nothing from it, or SL_NO_INDEX (a point on an edge) */
    uint32_t triangle;
} sl_lit_point;

/* Shared by all samples: immutable after creation. Scene, raster, tracer and lights must outlive it. */
typedef struct sl_light_sampling sl_light_sampling;
sl_status sl_light_sampling_create(const sl_scene *scene, const sl_raster *raster, const sl_tracer *tracer,
                                   const sl_sampled_lights *lights, const sl_light_sample_settings *settings,
                                   sl_light_sampling **sampling, sl_error *error);
void sl_light_sampling_destroy(sl_light_sampling *sampling);
/* Another tracer, of the same scene, from the next sample on. */
void sl_light_sampling_trace_by(sl_light_sampling *sampling, const sl_tracer *tracer);
/* Returns how far ahead of a point, on the way to a light, its rays and pictures begin: what the point
 * touches hides nothing from it. */
double sl_light_sampling_step(const sl_light_sampling *sampling);
size_t sl_light_sampling_memory_bytes(const sl_light_sampling *sampling);

/* One worker's pictures. */
typedef struct sl_light_sample_scratch sl_light_sample_scratch;
sl_status sl_light_sample_scratch_create(const sl_light_sampling *sampling, sl_light_sample_scratch **scratch,
                                         sl_error *error);
void sl_light_sample_scratch_destroy(sl_light_sample_scratch *scratch);

/* F at the point, finite and >= 0. Counts SL_COUNT_LIGHT_SAMPLES, and those that needed no picture as
 * skipped. */
float sl_light_sample_take(const sl_light_sampling *sampling, size_t light, const sl_lit_point *point,
                           sl_light_sample_scratch *scratch, sl_counters *counters);
/* The same by n x n rays whatever the settings say: where less will do. */
float sl_light_sample_by_rays(const sl_light_sampling *sampling, size_t light, const sl_lit_point *point,
                              int rays, sl_counters *counters);
/* All of F or nothing, by a single ray to the middle of what is above the horizon (rays 1), or F by n x n
 * rays. Whoever only wants to know whether it pays to take a sample asks so: nothing is counted but the rays.
 */
float sl_light_probe(const sl_light_sampling *sampling, size_t light, const sl_lit_point *point, int rays,
                     sl_counters *counters);
/* F without occluders, in closed form. */
double sl_light_unoccluded(const sl_sampled_light *light, const sl_lit_point *point);
/* The unit direction in which the light lies, for lobes: of area lights the centroid of what is above the
 * horizon; (0,0,0): nothing is. */
sl_vec3 sl_light_direction(const sl_sampled_light *light, const sl_lit_point *point);

/* ---- a light by points that all receivers share, and what a glossy lobe reflects of it ---- */

/* Points first to first + count of a sequence. */
typedef struct sl_light_numbers {
    const sl_sequence *sequence;
    uint64_t key;
    uint32_t first, count;
} sl_light_numbers;

/* A lobe of ks = 1 reflects what so many points of each area light send, and what so many directions drawn
 * from it meet, put together by the balance heuristic (Veach and Guibas 1995): a narrow lobe would fall
 * between the points. */
typedef struct sl_lit_lobe {
    sl_bsdf bsdf;
    double points, draws;
} sl_lit_lobe;

/* Over the points of a light, or the pixels of its picture: weights of all, and of those that are seen. */
typedef struct sl_light_sums {
    double seen, all, seen_squares, all_squares;
    double lobe;               /* what the lobe reflects of L = 1 */
} sl_light_sums;

/* Adds to the sums, in units of F times the number of points; lobe: NULL, or one that reflects. Returns
 * F without occluders; 0: no light arrives. */
double sl_light_by_points(const sl_light_sampling *sampling, size_t light, const sl_lit_point *point,
                          const sl_light_numbers *numbers, const sl_lit_lobe *lobe, sl_light_sums *sums,
                          sl_counters *counters);
/* Returns what the lobe reflects of area lights that its own directions meet. */
sl_rgb sl_lobe_draws(const sl_light_sampling *sampling, const sl_lit_point *point, const sl_lit_lobe *lobe,
                     const sl_light_numbers *numbers, sl_counters *counters);

/* The environment's light (sky_light.c): irradiance, where it is asked for, with the variance of its
 * channels' mean; and what a lobe of ks = 1 reflects, NULL: none. numbers->count directions are drawn from
 * the cosine, or half of them from that and as many from the environment and from the lobe. */
typedef struct sl_sky_light {
    sl_rgb irradiance, lobe;
    double variance;
} sl_sky_light;
sl_sky_light sl_sky_light_at(const sl_scene *scene, const sl_tracer *tracer, const sl_lit_point *point,
                             bool irradiance, const sl_bsdf *lobe, const sl_light_numbers *numbers,
                             sl_counters *counters);

/* The picture of the last sample that needed one: N x N weights, bottom row first, black where the light is
 * hidden; NULL: none. */
typedef struct sl_light_picture {
    int size;
    const float *weight;
} sl_light_picture;
sl_light_picture sl_light_last_picture(const sl_light_sample_scratch *scratch);
