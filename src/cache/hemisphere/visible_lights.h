/* Which light sources a part of the scene sees: regions, each a cell of a grid and one of the six directions
 * that a surface faces most, that know how often every source was found visible, and which blocks of sources
 * matter at all.
 *
 * Learned once from a few gathers on trial; it decides only how often a source is chosen, and every source
 * keeps a chance everywhere, so what is drawn by it stays unbiased. (After Ward 1994, "Adaptive shadow
 * testing for ray tracing", who orders the sources of a scene by what they can contribute and how often they
 * were seen.) */
#ifndef SL_CACHE_GATHER_VISIBLE_LIGHTS_H
#define SL_CACHE_GATHER_VISIBLE_LIGHTS_H

#include "cache/hemisphere/light_sources.h"

typedef struct sl_light_region {
    uint32_t blocks; /* bit b: the sources of block b are weighed one by one */
    float rest;      /* what all others might give, as the strengths; 0: there are none */
} sl_light_region;

typedef struct sl_visible_lights {
    sl_vec3 low;
    float per_cell;           /* cells a metre */
    int cells[3];
    uint32_t *region_of;      /* by cell, then direction: +x, -x, +y, -y, +z, -z */
    size_t region_count, sources;
    sl_light_region *regions; /* the first is for what nothing is known of */
    /* by region and source: the share of tests that found it visible, in 255ths, never 0 */
    uint8_t *visible;
} sl_visible_lights;

/* A light sample on trial: where, towards which source, and whether it arrived. */
typedef struct sl_light_trial {
    sl_vec3 position, normal;
    uint16_t source;
    bool arrived;
} sl_light_trial;

/* With no trials (count 0) one region holds all. */
sl_status sl_visible_lights_create(const sl_light_sources *sources, const sl_light_trial *trials,
                                   size_t count, sl_visible_lights **lights, sl_error *error);
void sl_visible_lights_destroy(sl_visible_lights *lights);
size_t sl_visible_lights_bytes(const sl_visible_lights *lights);

#endif
