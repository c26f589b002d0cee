/* Direct Radiance Mapping (Frisvad, Frisvad, Christensen, Falster 2005): one bounce of indirect light, gathered from pictures taken from the
 * lights. Everything is computed again for every frame. Read in this order:
 *
 *   plan.c              which passes a scene needs
 *   direct_radiance.c   the passes of one frame
 *   lights.c            the lights as points from which pictures are taken, (3), (6)
 *   shadow_cubes.c      pass 1: depth cubes
 *   radiance_map.c      pass 2: the direct radiance map
 *   footprint.c         (12), (13), and what they should be
 *   photons.c           pass 3: sample photons; map_filter.c, importance.c: other ways to take them
 *   receivers.c         passes 5 and 6: what the eye sees, planar mirrors included
 *   emission.c          light that is seen directly
 *   direct.c            pass 6: (5), (9)
 *   indirect.c          pass 7: (10), with (11), (14), (15)
 *   visibility.c        indirect shadows, which the paper leaves open
 *   mirrors.c           pass 4: curved mirrors' environment cubes; mirror_objects.c, which; mirror_look_up.c, what they show
 *   compose.c           pass 8: the picture and its layers
 */
#ifndef SL_CACHE_DIRECT_RADIANCE_H
#define SL_CACHE_DIRECT_RADIANCE_H

#include "cache/direct_radiance/receivers.h"

/* Three planes each of width*height, row 0 at the bottom. */
typedef struct sl_radiance_layers {
    float *emission[3], *direct[3], *indirect[3];
    float *spread; /* uncertainty of the indirect sum, luminance */
} sl_radiance_layers;

/* Pass 8: R, G, B = throughput (emission + direct + indirect), and each of the three alone, top row first. */
sl_status sl_radiance_compose(const sl_radiance_layers *layers, const sl_receivers *receivers, unsigned threads, sl_image **image,
                              sl_error *error);

#endif
