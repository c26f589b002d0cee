/* What a gather sees reflects direct light by its glossy lobe, too, towards the gather (L G D E, L G G E):
 * where that is asked for and the scene has glossy materials. */
#ifndef SL_CACHE_GATHER_GLOSSY_HITS_H
#define SL_CACHE_GATHER_GLOSSY_HITS_H

#include "cache/hemisphere/gather_internal.h"

/* By slot. */
struct sl_glossy_hits {
    float *specular; /* sum over the channels of ks; 0: the lobe is black, or nothing is seen */
    sl_rgb *radiance;
};

/* False: nobody asked, or nothing is glossy. */
bool sl_glossy_hits_wanted(const sl_gather *gather);
sl_status sl_glossy_hits_create(size_t slots, sl_glossy_hits **hits, sl_error *error);
void sl_glossy_hits_destroy(sl_glossy_hits *hits);

/* Slots first to first + count see new things, that nothing lights yet. */
void sl_glossy_hits_begin(const sl_gather_view *view, size_t first, size_t count);
/* Irradiance arrives at slot k from a direction of any length. */
void sl_glossy_hits_add(const sl_gather_view *view, size_t k, sl_vec3 to_light, sl_rgb irradiance);
/* The same by shadow maps for a block of slots that starts at `first`. */
void sl_glossy_hits_add_maps(const sl_gather_view *view, const sl_light_points *points, size_t first,
                             unsigned parts, sl_counters *counters);

/* Light that arrives at slot k may be seen from the gather: kd, or ks where that counts. */
static inline float sl_hit_reflectance(const sl_gather_view *view, size_t k) {
    const sl_gather_hits *h = &view->scratch->hits;
    if (h->triangle[k] == SL_NO_INDEX) return 0.0f;
    float diffuse = h->diffuse_r[k] + h->diffuse_g[k] + h->diffuse_b[k];
    return view->scratch->glossy ? diffuse + view->scratch->glossy->specular[k] : diffuse;
}

#endif
