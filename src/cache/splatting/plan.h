/* What radiance cache splatting will do with a scene. */
#ifndef SL_CACHE_SPLATTING_PLAN_H
#define SL_CACHE_SPLATTING_PLAN_H

#include "cache/hemisphere/gather.h"
#include "cache/frame/method.h"

typedef struct sl_splat_quality {
    double accuracy;        /* a of irradiance records */
    double glossy_accuracy; /* a of radiance records */
    /* aR_min in footprints of a pixel (of fewer and larger ones, beyond 400 rows): below, records cost more
     * than they tell */
    double minimum_pixels;
    int gather_size;        /* N x N */
    uint32_t light_samples; /* a pixel */
} sl_splat_quality;

/* The environment is split: the sky, at most so many times as bright as its mean, is the gathers' background
 * and reaches the pixels through the records; the sun, which is what stands out of it, is sampled for every
 * pixel. Never both, never neither. */
#define SL_SKY_CONTRAST 10.0

typedef struct sl_splat_plan {
    sl_splat_quality quality;
    sl_gather_settings gather;
    sl_radius_metric metric; /* of irradiance records, decided */
    int harmonics_order;    /* n of radiance records */
    bool mirrors;           /* rays from the eye follow them */
    bool direct, irradiance, radiance; /* is there anything to compute? */
} sl_splat_plan;

sl_splat_plan sl_splat_plan_make(const sl_scene *scene, const sl_settings *settings);
/* The entries of sl_method_class of the same names. */
void sl_splat_complete(sl_settings *settings);
void sl_splat_transport(const sl_settings *settings, sl_transport *transport);
void sl_splat_plan_write(const sl_scene *scene, const sl_settings *settings, sl_plan_writer *writer);

#endif
