/* Passes 6 and 7 as programs for tiles: what is made once for a picture, and what is done with each of its tiles. */
#ifndef SL_CACHE_DIRECT_RADIANCE_LIGHT_TILES_H
#define SL_CACHE_DIRECT_RADIANCE_LIGHT_TILES_H

#include "cache/direct_radiance/light_receivers.h"
#include "cache/direct_radiance/receiver_kernels.h"

/* Where a tile's light is added: planes of `width` that the tile's pixels are indices of. */
typedef struct sl_tile_target {
    int width;
    float *direct[3], *indirect[3];
    float *spread; /* or NULL */
} sl_tile_target;

typedef struct sl_direct_light {
    const sl_light_pass *pass;
    float largest_weight; /* 1 / r^2 nearer than which a light is taken to stand on the receiver: it then gives nothing */
    sl_receiver_kernels kernels;
} sl_direct_light;

sl_direct_light sl_direct_light_of(const sl_light_pass *pass);
void sl_direct_light_tile(const sl_direct_light *light, const sl_receiver_tile *tile, bool glossy, const sl_tile_target *to,
                          sl_counters *counters);
/* sl_photon_sums_create() makes it. */
void sl_indirect_light_tile(const sl_photon_sums *sums, const sl_receiver_tile *tile, bool glossy, const sl_tile_target *to,
                            sl_counters *counters);
/* Where the pass wants visibility: from receivers of a whole picture. */
sl_status sl_photon_sums_see(sl_photon_sums *sums, const sl_receivers *receivers, const sl_receiver_kinds *kinds, sl_counters *counters,
                             sl_error *error);
/* What each photon alone sends from one of the tile's receivers towards the eye, in index order; weight: of its diffuse part, and 0 for what the
 * receiver does not see. */
typedef void sl_photon_told(void *context, size_t photon, float weight, const float radiance[3]);
void sl_indirect_light_apart(const sl_photon_sums *sums, const sl_receiver_tile *tile, bool glossy, size_t lane, sl_photon_told *told,
                             void *context, sl_counters *counters);

#endif
