/* Indirect light of a picture's pixels: from the octree, or by way of the atlas where light does
 * not depend on the view. Glossy surfaces, and what mirrors show, look into the octree in
 * either case. */
#ifndef SL_CACHE_LIGHT_OCTREE_PIXELS_H
#define SL_CACHE_LIGHT_OCTREE_PIXELS_H

#include "cache/light_octree/atlas/bake.h"
#include "cache/reflect/reflect.h"
#include "cache/light_octree/shade.h"

/* The atlas with the light of one octree in it; sides are filled when a pixel first sees one. */
typedef struct sl_lit_atlas {
    sl_atlas *atlas;
    sl_atlas_canvas *canvas;
    bool filled[2]; /* by side */
} sl_lit_atlas;

sl_status sl_lit_atlas_create(const sl_scene *scene, int size, unsigned threads, sl_lit_atlas **atlas,
                              sl_error *error);
void sl_lit_atlas_destroy(sl_lit_atlas *atlas);
size_t sl_lit_atlas_bytes(const sl_lit_atlas *atlas);

typedef struct sl_octree_pixels {
    const sl_scene *scene;
    const sl_gbuffer *gbuffer;
    const sl_reflections *reflections; /* or NULL */
    const sl_octree_shading *shading;
    sl_lit_atlas *atlas;               /* or NULL */
    sl_vec3 eye;
    unsigned threads;
} sl_octree_pixels;

/* Three planes of the G-buffer's size, all of them written. */
sl_status sl_octree_light_pixels(const sl_octree_pixels *pixels, float *const indirect[3],
                                 sl_counters *counters, sl_error *error);

#endif
