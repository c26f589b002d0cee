/* Emitters as a glossy lobe sees them. */
#pragma once

#include "cache/light/direct_internal.h"
#include "cache/light/near_light.h"
#include "trace/bsdf.h"

/* A side of an emitter, above the horizon. */
typedef struct sl_lamp {
    uint32_t side;
    sl_seen_triangle seen;          /* without parts where it is sampled by its area */
    /* the sum of the importances up to and with this one; this one's share of all */
    float sum, chance;
} sl_lamp;

typedef struct sl_lamps {
    const sl_direct *direct;
    sl_vec3 position;
    size_t count;
    double solid_angle;             /* of all lamps */
    float closest;                  /* the lobe's largest value on any of them, 1 at its axis */
    sl_lamp lamp[SL_EXACT_EMITTERS_MAX];
} sl_lamps;

/* All that the lobe of a surface may see. False: none. */
bool sl_lamps_look(const sl_direct *direct, const sl_bsdf *lobe, sl_vec3 position, sl_lamps *lamps);
/* A sample from two numbers in [0,1); as of sl_light_sampler_sample_2d(). */
bool sl_lamps_draw(const sl_lamps *lamps, const float u[2], sl_light_sample *sample);
/* The density with which that would have drawn the direction that hit this triangle of an emitter. */
float sl_lamps_pdf(const sl_lamps *lamps, sl_vec3 direction, uint32_t triangle, float distance);
