/* More bounces: the light that reaches a surface after it has met others (beyond the one bounce of Gautron et
 * al. 2005).
 *
 * A gather sees surfaces and shades them. With one bounce direct light is all that they receive; with more
 * they receive indirect light as well, which comes from a second cache of irradiance records:
 * second-level ones, which lie where gathers look and not where the eye looks, and which are fewer and
 * coarser. With E^(0) = 0,
 *
 *     E^(b)(x) = gather at x of what is seen there, shaded with (kd / pi) (E_direct + E^(b-1)),
 *
 * and the visible records gather once with E^(bounces - 1). Gathering is linear, and what a gather sees does
 * not change: a record that has gathered twice, direct light and its first reflection, knows how much comes
 * from which other record, and the bounces that follow are products of a sparse matrix with a vector. Read in
 * this order:
 *
 *   probe.c           points that gathers will see
 *   cover.c           points that no second-level record covers get one
 *   record_octree.c   which records lie around a point
 *   look_up_kernels.c irradiance at points, from the records around them
 *   interreflection.c one bounce after the other
 *   renewal.c         records while objects and lights move
 *   bounces.c         all of it, and cameras that move */
#pragma once

#include "cache/splatting/record.h"

typedef struct sl_second_settings {
    uint32_t bounces;          /* of the whole picture, at least 2 */
    double accuracy;           /* a of the second-level records */
    double minimum_radius;     /* aR_min, as a share of the diagonal of the scene's central region */
    sl_gather_settings gather; /* of the second-level records: by rays, and smaller than the visible ones */
    float aspect;              /* width / height of the picture */
    uint64_t seed;
    unsigned threads;
    bool quick; /* somebody waits for each view */
} sl_second_settings;

/* Returns the settings that go with gathers of this kind and size and visible records of this accuracy. */
sl_second_settings sl_second_settings_for(const sl_gather_settings *visible, double accuracy,
                                          uint32_t bounces);

typedef struct sl_second_cache sl_second_cache;
/* Finds the places, gathers at them, and lets the light bounce. Scene and tracer must outlive it. */
sl_status sl_second_cache_create(const sl_scene *scene, const sl_tracer *tracer,
                                 const sl_second_settings *settings, sl_second_cache **cache,
                                 sl_counters *counters, sl_error *error);
/* The camera has moved: if gathers will now look where there are no records, such are made, few for each view
 * but where it has gone elsewhere. They gather the light of all bounces from the others; once there are an
 * eighth more than when light last bounced it does so again: at once elsewhere, else in turns, some with each
 * view. Where things have moved all light is renewed in turns. */
sl_status sl_second_cache_follow(sl_second_cache *cache, sl_counters *counters, sl_error *error);
/* Objects or lights have changed, and transport was made anew: records go along with what they lie on, and
 * keep the light that they had until it is renewed. motion: by object. */
sl_status sl_second_cache_move(sl_second_cache *cache, const sl_tracer *tracer, const sl_shadow_maps *maps,
                               const sl_object_motion *motion, sl_error *error);
/* The next so many records, in turns, gather all bounces anew from the others as they are. */
sl_status sl_second_cache_renew(sl_second_cache *cache, size_t count, sl_counters *counters,
                                sl_error *error);
/* Tells whether all have done so since things last moved. */
bool sl_second_cache_is_renewed(const sl_second_cache *cache);
void sl_second_cache_destroy(sl_second_cache *cache);
/* E^(bounces - 1), for sl_gather_settings.second; lives as long as the cache. */
const sl_second_light *sl_second_cache_light(const sl_second_cache *cache);
/* Returns how far its records reach at least, m. */
float sl_second_cache_reach(const sl_second_cache *cache);
size_t sl_second_cache_bytes(const sl_second_cache *cache);
typedef struct sl_second_report {
    size_t records;
    uint32_t bounces;   /* computed: fewer than asked for where more would not have changed anything */
    bool converged;     /* ... so that these are all there are */
    float change;       /* largest relative change of a record's irradiance by the last bounce */
    float missed;       /* share of some other points that gathers will see which no record reaches */
} sl_second_report;
sl_second_report sl_second_cache_report(const sl_second_cache *cache);
