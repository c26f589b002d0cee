/* The bidirectional path tracer: pairs of subpaths for the reference tracers' film (trace.h), and values at
 * surface points, which the shading cache asks for. */
#pragma once

#include "base/batch.h"
#include "trace/path_walk.h"

/* ---- the film: path_tracer.c makes it of pairs of subpaths ------------------------------------- */

typedef struct sl_path_pairs sl_path_pairs;

/* Light that falls on other pixels is kept in so many lists. */
enum { SL_PAIR_LISTS = 256 };

/* But with SL_FILTER_BOX light subpaths are not joined to the camera. */
sl_status sl_path_pairs_create(const sl_path_walk *walk, const sl_path_lens *lens, unsigned workers,
                               sl_path_pairs **pairs, sl_error *error);
void sl_path_pairs_destroy(sl_path_pairs *pairs);
size_t sl_path_pairs_memory_bytes(const sl_path_pairs *pairs);
/* An eye and a light subpath for each of up to sixteen places on the film: radiance there; what falls on
 * other pixels goes into the list, which nobody else fills at the same time. */
void sl_path_pairs_radiance(sl_path_pairs *pairs, unsigned worker, size_t list, unsigned count,
                            const sl_path_place *place, const uint64_t *key, uint32_t index,
                            sl_rgb *radiance, sl_counters *counters);
/* How much is in each list: what a task writes beside its radiance. */
sl_batch_plane sl_path_pairs_counts(sl_path_pairs *pairs);
/* Adds what is in the lists, one after the other, and empties them. False: there was no memory for all. */
bool sl_path_pairs_commit(sl_path_pairs *pairs, size_t lists, const sl_halves *halves, unsigned half,
                          sl_counters *counters);

/* ---- values at surface points, as the shading cache (Tole et al. 2002) has them rendered ----- */

/* Holds the light subpaths, which serve every point; to be made again when anything but the camera changes.
 * Many threads may use one, each with a scratch of its own. Every point uses the same random numbers: equal
 * requests have equal bits. */
typedef struct sl_bidirectional_points sl_bidirectional_points;
typedef struct sl_bidirectional_scratch sl_bidirectional_scratch;

typedef struct sl_bidirectional_point_settings {
    uint32_t samples;        /* pairs of subpaths a value; 0: 400 */
    /* how many pairs of the sequence are passed over: others for each set of samples whose means are to be
     * averaged */
    uint32_t first;
    /* surfaces between the point and the light, at most, mirrors not counted; 0: 6; or
     * SL_BOUNCES_UNLIMITED */
    uint32_t bounces;
    uint64_t seed;
    /* irradiance leaves out light that comes to the point by way of mirrors alone (L S+ D), which somebody
     * else counts; */
    bool without_caustics;
    /* ... and > 0: glossy surfaces that are not diffuse count as mirrors from this exponent on */
    float polished;
} sl_bidirectional_point_settings;

/* settings may be NULL. */
sl_status sl_bidirectional_points_create(const sl_scene *scene, const sl_tracer *tracer,
                                         const sl_bidirectional_point_settings *settings,
                                         sl_bidirectional_points **points, sl_error *error);
void sl_bidirectional_points_destroy(sl_bidirectional_points *points);
sl_status sl_bidirectional_scratch_create(sl_bidirectional_scratch **scratch, sl_error *error);
void sl_bidirectional_scratch_destroy(sl_bidirectional_scratch *scratch);

typedef struct sl_bidirectional_request {
    sl_vec3 position;         /* on the surface: it is lifted here */
    sl_vec3 geometric_normal; /* unit, on the side that is asked about */
    sl_vec3 normal;           /* unit shading normal, on the same side */
    uint32_t triangle;        /* its own; or SL_NO_INDEX, where it lies on an edge */
    const sl_material *material; /* whose lobe radiance is asked for; NULL: the triangle's */
    uint32_t samples;         /* the first of the points' samples alone; 0: all */
} sl_bidirectional_request;

typedef struct sl_bidirectional_value {
    double mean[3];
    /* of the mean, as if the samples were independent: they are better spread than that */
    double variance[3];
} sl_bidirectional_value;

/* Indirect irradiance E_i (L_i cos over the hemisphere): light of paths with at least one vertex between
 * light and point, be it a surface or a mirror. The first direction of eye subpaths has the density cos / pi.
 */
void sl_bidirectional_irradiance(const sl_bidirectional_points *points,
                                 const sl_bidirectional_request *request, sl_bidirectional_scratch *scratch,
                                 sl_bidirectional_value *irradiance, sl_counters *counters);
/* Finds what the material's glossy lobe reflects of the same light towards an eye; directions are drawn from
 * the lobe. A perfect mirror reflects all there is, lights themselves too, since no light sample finds
 * those. */
void sl_bidirectional_radiance(const sl_bidirectional_points *points, const sl_bidirectional_request *request,
                               sl_vec3 eye, sl_bidirectional_scratch *scratch,
                               sl_bidirectional_value *radiance, sl_counters *counters);
