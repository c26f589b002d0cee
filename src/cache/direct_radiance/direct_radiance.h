/* Direct Radiance Mapping (Frisvad, Frisvad, Christensen, Falster 2005): one bounce of indirect light, gathered from pictures taken from the
 * lights. Everything is computed again for every frame. Read in this order:
 *
 *   plan.c              which passes a scene needs
 *   direct_radiance.c   the passes of one frame
 *
 *   lights.c            the lights as points from which pictures are taken, (3), (6); light_groups.c, light_points.c: emissive triangles as
 *                       few lights, and lights divided; light_openings.c points behind bars
 *   shadow_cubes.c      pass 1: depth cubes, and what they say
 *   radiance_map.c      pass 2: the direct radiance map; map_faces.c which pictures a light takes, map_pictures.c the pictures,
 *                       map_mirrors.c and map_traced.c light by way of mirrors
 *   footprint.c         (12), (13), and what they should be
 *   photons.c           pass 3: sample photons; map_texel.c what a texel tells, photon_quad.c footprints as polygons
 *   map_filter.c        many texels to a photon: MIP levels, and photon_groups.c, a photon for each surface
 *
 *   mirrors.c           pass 4: curved mirrors; mirror_objects.c, mirror_look_up.c
 *   receivers.c         passes 5 and 6: what the eye sees, planar mirrors included; receiver_tiles.c: in tiles, for lanes
 *   emission.c          light seen directly
 *   direct.c            pass 6: (5), (9)
 *   weights.c           what one photon sends to a receiver: (11), (14), (15), and (14) put right
 *   indirect.c          pass 7: (10), the sum over all photons
 *   visibility.c        indirect shadows, which the paper leaves open
 *   map_report.c, map_captured.c   how much light the map holds, and how much of the photons' arrives
 *   compose.c           pass 8: the picture and its layers
 *   strips.c            passes 5 to 8 at once, strip by strip
 *   story.c             what made a pixel
 */
#ifndef SL_CACHE_DIRECT_RADIANCE_H
#define SL_CACHE_DIRECT_RADIANCE_H

#include "cache/direct_radiance/receivers.h"

/* Three planes each of width*height, row 0 at the bottom. */
typedef struct sl_radiance_layers {
    float *emission[3], *direct[3], *indirect[3];
    float *spread; /* uncertainty of the indirect sum, luminance */
} sl_radiance_layers;

/* Pass 8: R, G, B = throughput (emission + direct + indirect), and where all layers are wanted each of the three alone and the spread, top
 * row first. */
sl_status sl_radiance_compose(const sl_radiance_layers *layers, const sl_receivers *receivers, bool all, unsigned threads, sl_image **image,
                              sl_error *error);
/* The same in parts: a picture of which every pixel is still to be written, and rows of the receivers and layers given, which may be some
 * rows of it themselves. */
sl_status sl_radiance_picture_create(int width, int height, bool all, sl_image **image, sl_error *error);
void sl_radiance_compose_rows(const sl_radiance_layers *layers, const sl_receivers *receivers, size_t first, size_t end, sl_image *image);

#endif
