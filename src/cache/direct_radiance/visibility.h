/* Does a receiver see a photon? The paper leaves that out, so that its indirect light casts no shadows; this extension asks by rays.
 *
 *   rays     one for each pixel and photon whose light would be more than nothing
 *   blocks   one for each block of 4 x 4 pixels and photon; pixels take the answer of the blocks around that stand on the same
 *            surface, and ask themselves where none does or the answers differ: at a shadow's edge
 */
#ifndef SL_CACHE_DIRECT_RADIANCE_VISIBILITY_H
#define SL_CACHE_DIRECT_RADIANCE_VISIBILITY_H

#include "cache/direct_radiance/light_receivers.h"
#include "cache/direct_radiance/sight_kernels.h"

typedef struct sl_sight sl_sight;

/* What a photon would send to a tile's receivers if all of them saw it. */
typedef void sl_weigh_photon(const void *context, const sl_receiver_tile *tile, size_t photon, float *weight);

/* Traces the blocks' rays, where it is by blocks. */
sl_status sl_sight_create(const sl_light_pass *pass, const sl_receivers *receivers, const sl_receiver_kinds *kinds,
                          sl_weigh_photon *weigh, const void *context, sl_sight **sight, sl_counters *counters, sl_error *error);
void sl_sight_destroy(sl_sight *sight);

/* Before a tile's photons. */
void sl_sight_begin_tile(const sl_sight *sight, const sl_receiver_tile *tile, sl_tile_sight *around);
/* Sets around->seen for photons first, first + 1, ...: count of them, at most SL_SIGHT_PHOTONS; first is a multiple of that. */
void sl_sight_see(const sl_sight *sight, const sl_receiver_tile *tile, sl_tile_sight *around, size_t first, size_t count,
                  sl_counters *counters);

#endif
