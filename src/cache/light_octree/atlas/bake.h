/* Light that does not depend on the view is kept in an atlas, and put on pixels with one texture look-up
 * each.
 *
 *   sl_atlas_canvas_create()  which texels hold which surface points; as long as the geometry stays
 *   sl_atlas_bake()           fills the texels, whenever the light has changed
 *   sl_atlas_apply()          looks the picture up at the pixels of a G-buffer, whenever the camera has moved
 *
 * Surfaces have two sides, and different light on each: a side is a picture of its own, and only those that
 * are seen need be filled. */
#ifndef SL_CACHE_LIGHT_OCTREE_ATLAS_BAKE_H
#define SL_CACHE_LIGHT_OCTREE_ATLAS_BAKE_H

#include "cache/light_octree/atlas/atlas.h"
#include "cache/light_octree/shade.h"
#include "raster/textures/textures.h"

typedef enum sl_atlas_side { SL_ATLAS_FRONT, SL_ATLAS_BACK } sl_atlas_side; /* front: counter-clockwise */

/* The side that a pixel of a G-buffer shows. */
sl_atlas_side sl_atlas_side_seen(const sl_scene *scene, const sl_gbuffer *gbuffer, size_t pixel);

typedef struct sl_atlas_canvas {
    const sl_atlas *atlas;
    /* of texels that hold a surface point: those in a chart, and those around it that filtering reads */
    size_t count;
    size_t covered;             /* of them, those whose centres lie in a chart */
    uint32_t *texel, *triangle; /* ascending; row * size + column */
    float *w1, *w2;
    sl_texture_image *side[2];  /* RGBA, alpha 1 where there is something; NULL: never filled */
} sl_atlas_canvas;

enum { SL_ATLAS_BATCH = 4096 };

/* The atlas must outlive it. */
sl_status sl_atlas_canvas_create(const sl_atlas *atlas, const sl_scene *scene, unsigned threads,
                                 sl_atlas_canvas **canvas, sl_error *error);
void sl_atlas_canvas_destroy(sl_atlas_canvas *canvas);
size_t sl_atlas_canvas_bytes(const sl_atlas_canvas *canvas);

/* Fills r, g, b of up to SL_ATLAS_BATCH surface points. Each point's must be a function of that point alone.
 */
typedef void sl_atlas_shader(void *context, unsigned worker, size_t count, const uint32_t *triangle,
                             const float *w1, const float *w2, float *r, float *g, float *b);

/* Workers are below sl_thread_count(threads). What is not finite becomes 0. */
sl_status sl_atlas_bake(sl_atlas_canvas *canvas, sl_atlas_side side, unsigned threads,
                        sl_atlas_shader *shader, void *context, sl_error *error);
/* Irradiance from the octree's lights, on the shading normal turned to the side. */
sl_status sl_atlas_bake_octree(sl_atlas_canvas *canvas, sl_atlas_side side, const sl_scene *scene,
                               const sl_octree_shading *shading, unsigned threads, sl_counters *counters,
                               sl_error *error);

/* Irradiance times kd / pi at the pixels of a G-buffer, bilinear, one look-up each; background, mirrors and
 * sides that were never filled are 0. */
sl_status sl_atlas_apply(const sl_atlas_canvas *canvas, const sl_gbuffer *gbuffer, const sl_scene *scene,
                         unsigned threads, float *r, float *g, float *b, sl_counters *counters,
                         sl_error *error);

#endif
