/* A picture's indirect light from the photon map itself: every pixel gathers its nearest photons (Jensen
 * 1996, direct visualization), and there are no lights in between. What the octree saves, and what it blurs,
 * is the difference. */
#ifndef SL_CACHE_LIGHT_OCTREE_PHOTON_PIXELS_H
#define SL_CACHE_LIGHT_OCTREE_PHOTON_PIXELS_H

#include "cache/frame/settings.h"
#include "cache/light_octree/octree.h"
#include "cache/photons/photon_tree.h"
#include "raster/raster.h"

typedef struct sl_photon_pixels {
    const sl_scene *scene;
    const sl_gbuffer *gbuffer;
    const sl_octree *octree;   /* with triangles: to find the surfaces around a pixel */
    const sl_photon_tree *tree;
    const sl_light_octree_settings *settings; /* neighbours, flatness, acceptance, area; complete */
    double radius;             /* r > 0 */
    unsigned threads;
} sl_photon_pixels;

/* Three planes of the G-buffer's size, all of them written. */
sl_status sl_photon_light_pixels(const sl_photon_pixels *pixels, float *const indirect[3],
                                 sl_counters *counters, sl_error *error);

#endif
