/* Passes 6 and 7: light on receivers. Direct light by (5) and (9) with shadow cubes; indirect light by (10), the sum over the photons. */
#ifndef SL_CACHE_DIRECT_RADIANCE_LIGHT_RECEIVERS_H
#define SL_CACHE_DIRECT_RADIANCE_LIGHT_RECEIVERS_H

#include "cache/direct_radiance/photons.h"
#include "cache/direct_radiance/receiver_tiles.h"
#include "cache/direct_radiance/shadow_cubes.h"
#include "trace/trace.h"

/* Radiance towards the eye, three planes each of width*height, row 0 at the bottom; before the mirrors' throughput. */
typedef struct sl_lit_picture {
    float *direct[3], *indirect[3];
} sl_lit_picture;

typedef struct sl_light_pass {
    const sl_scene *scene;
    const sl_map_lights *lights;
    const sl_shadow_cubes *cubes;        /* NULL: no shadows */
    const sl_map_photons *photons;       /* NULL: no indirect light */
    sl_photon_weight weight;             /* not AUTO */
    const sl_tracer *tracer;             /* for visibility; NULL with SL_VISIBILITY_NONE */
    sl_photon_visibility visibility;
    sl_rgb trick_albedo;                 /* curved mirrors receive indirect light with k_s times that; 0: they do not */
    unsigned threads;
} sl_light_pass;

/* Adds direct light to picture->direct. Pixels of mirrors, of emitters' black surfaces and of the background stay as they are. */
sl_status sl_light_directly(const sl_light_pass *pass, const sl_receivers *receivers, sl_lit_picture *picture, sl_counters *counters,
                            sl_error *error);
/* Adds indirect light to picture->indirect: every pixel sums its even and its odd photons, each in index order, and adds the two sums:
 * the same bits at any number of threads. spread (a plane, or NULL) gets half the difference of the luminances that the even and the odd
 * photons alone would give: what the pixel's sum is uncertain by. */
sl_status sl_light_indirectly(const sl_light_pass *pass, const sl_receivers *receivers, sl_lit_picture *picture, float *spread,
                              sl_counters *counters, sl_error *error);

/* (10) alone, of receivers that are in no picture: without visibility. The pass must outlive its sums. */
typedef struct sl_photon_sums sl_photon_sums;
sl_status sl_photon_sums_create(const sl_light_pass *pass, sl_photon_sums **sums, sl_error *error); /* with photons, not NULL */
void sl_photon_sums_destroy(sl_photon_sums *sums);
void sl_photon_sums_irradiance(const sl_photon_sums *sums, const sl_receiver_tile *tile, sl_tile_light *light);

/* E_j(x) of one photon by one weight (weights.h), W/m^2: the plain form that the lanes agree with bit by bit. n: the receiver's
 * geometric normal decides what is above its horizon, the shading normal `shading` gives the cosine. */
sl_rgb sl_photon_irradiance(const sl_map_photons *photons, size_t photon, sl_photon_weight weight, sl_vec3 x, sl_vec3 n, sl_vec3 shading);

#endif
