/* More bounces: the light that reaches a surface after it has met others (beyond the one bounce of Gautron et al. 2005).
 *
 * A gather sees surfaces and shades them. With one bounce direct light is all that they receive; with more they receive indirect
 * light as well, and that is asked of a second cache of irradiance records: hidden ones, which lie where gathers look and not
 * where the eye looks, and which are fewer and coarser. With E^(0) = 0,
 *
 *     E^(b)(x) = gather at x of what is seen there, shaded with (kd / pi) (E_direct + E^(b-1)),
 *
 * and the visible records gather once with E^(bounces - 1). Read in this order:
 *
 *   scout.c           points that gathers will see
 *   walls.c           how far a hidden record may reach, in each direction
 *   cover.c           points that no hidden record covers get one
 *   record_tree.c     which records lie around a point
 *   look_up_kernels.c irradiance at a point, from the records around it
 *   look_up.c         many points; those that no record covers
 *   bounces.c         one bounce after the other
 *   keep.c            all of it on disk, for another run */
#ifndef SL_CACHE_BOUNCES_H
#define SL_CACHE_BOUNCES_H

#include "cache/frame/cache_file.h"
#include "cache/splatting/record.h"

typedef struct sl_hidden_settings {
    uint32_t bounces;          /* of the whole picture, at least 2 */
    double accuracy;           /* a of the hidden records */
    double minimum_radius;     /* aR_min, as a share of the diagonal of the scene's core */
    sl_gather_settings gather; /* of the hidden records: by rays, and smaller than the visible ones */
    float aspect;              /* width / height of the picture */
    uint64_t seed;
    unsigned threads;
} sl_hidden_settings;

/* What goes with gathers of this kind and size and with visible records of this accuracy. */
sl_hidden_settings sl_hidden_settings_for(const sl_gather_settings *visible, double accuracy, uint32_t bounces);

typedef struct sl_hidden_cache sl_hidden_cache;
/* Finds the places, gathers at them, and lets the light bounce. Scene, raster (NULL but for shadow maps) and tracer must
 * outlive it. */
sl_status sl_hidden_cache_create(const sl_scene *scene, const sl_raster *raster, const sl_tracer *tracer,
                                 const sl_hidden_settings *settings, sl_hidden_cache **cache, sl_counters *counters,
                                 sl_error *error);
/* The camera has moved: if gathers will now look where there are no records, such are made, and the light bounces once more. */
sl_status sl_hidden_cache_follow(sl_hidden_cache *cache, const sl_raster *raster, sl_counters *counters, sl_error *error);
void sl_hidden_cache_destroy(sl_hidden_cache *cache);
/* E^(bounces - 1), for sl_gather_settings.hidden; lives as long as the cache. */
const sl_hidden_light *sl_hidden_cache_light(const sl_hidden_cache *cache);
/* To a file and from it. The reader's file has been checked to be of this scene and of these settings. */
void sl_hidden_cache_write(const sl_hidden_cache *cache, sl_cache_writer *writer);
sl_status sl_hidden_cache_read(const sl_scene *scene, const sl_tracer *tracer, const sl_hidden_settings *settings,
                               sl_cache_reader *reader, sl_hidden_cache **cache, sl_error *error);
size_t sl_hidden_cache_bytes(const sl_hidden_cache *cache);
/* The same without room for more records: read from a file they are as many bytes as they were when they were made. */
size_t sl_hidden_cache_bytes_in_use(const sl_hidden_cache *cache);

typedef struct sl_hidden_report {
    size_t records;
    uint32_t bounces;   /* computed: fewer than asked for where more would not have changed anything */
    bool converged;     /* ... so that these are all there are */
    float change;       /* largest relative change of a record's irradiance by the last bounce */
    float missed;       /* share of some other points that gathers will see which no record reaches */
} sl_hidden_report;
sl_hidden_report sl_hidden_cache_report(const sl_hidden_cache *cache);

#endif
