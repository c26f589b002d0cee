/* A texture atlas over a scene's triangles. A chart is a connected piece of surface that bends little, laid
 * flat by projection onto its mean plane, so that one affine map takes all of its points to the atlas.
 *
 *   faces.c      which triangles share an edge
 *   charts.c     which go together, each chart's plane, and what leaves charts again
 *   pack.c       shelves of charts in one square
 *   atlas.c      all of that in order
 *   texels.c     which surface point each texel holds, so that filtering finds no seams
 *   bake.c       light into the texels, and from there to pixels
 */
#pragma once

#include "cache/light_octree/shade.h"
#include "raster/raster.h"
#include "raster/textures/textures.h"

/* s and t, in [0,1], of a point p of a chart: at + along . (p - centre). along[0] x along[1] points to the
 * front. */
typedef struct sl_atlas_chart {
    sl_vec3 centre;
    sl_vec3 along[2];
    float at[2];
} sl_atlas_chart;

typedef struct sl_atlas {
    int size;
    size_t triangle_count, chart_count;
    uint32_t *chart_of;     /* of each triangle */
    sl_atlas_chart *chart;
    double texels_per_unit; /* the common density: texels for a length of 1 in a chart's plane */
} sl_atlas;

/* size: texels a side. Every triangle lies in one chart, and no two of a chart overlap. Deterministic. Where
 * all cannot fit the density sinks; where it would sink below a texel a chart, that is an error which says
 * which size would do. */
sl_status sl_atlas_create(const sl_scene *scene, int size, sl_atlas **atlas, sl_error *error);
void sl_atlas_destroy(sl_atlas *atlas);
size_t sl_atlas_bytes(const sl_atlas *atlas);

static inline void sl_atlas_point(const sl_atlas_chart *chart, sl_vec3 p, float *s, float *t) {
    sl_vec3 d = sl_sub(p, chart->centre);
    *s = chart->at[0] + sl_dot(chart->along[0], d);
    *t = chart->at[1] + sl_dot(chart->along[1], d);
}

/* Finds which triangle each texel holds a point of, and where (barycentric weights of corners 1 and 2);
 * SL_NO_INDEX where there is none. A texel whose centre lies outside all charts, but less than a texel away
 * in x and in y, takes the nearest point. Arrays of size*size, row 0 at the bottom. */
sl_status sl_atlas_texels(const sl_atlas *atlas, const sl_scene *scene, unsigned threads, uint32_t *triangle,
                          float *w1, float *w2, sl_error *error);

/* ---- light in it (bake.c) ----
 *
 * Light that does not depend on the view is kept in an atlas, and put on pixels with one texture look-up
 * each.
 *
 *   sl_atlas_canvas_create()  which texels hold which surface points; as long as the geometry stays
 *   sl_atlas_bake()           fills the texels, whenever the light has changed
 *   sl_atlas_apply()          looks the picture up at the pixels of a G-buffer, whenever the camera has moved
 *
 * Surfaces have two sides, and different light on each: a side is a picture of its own, and only those that
 * are seen need be filled. */

/* Front: counter-clockwise. Neither: of pixels that are not looked up. */
typedef enum sl_atlas_side { SL_ATLAS_FRONT, SL_ATLAS_BACK, SL_ATLAS_NEITHER } sl_atlas_side;

/* The side that a pixel of a G-buffer shows. */
sl_atlas_side sl_atlas_side_seen(const sl_scene *scene, const sl_gbuffer *gbuffer, size_t pixel);

typedef struct sl_atlas_canvas {
    sl_atlas *atlas;
    /* of all texels: the surface point of those in a chart, and of those around it that filtering reads */
    uint32_t *triangle;
    float *w1, *w2;             /* w2 lies behind w1 */
    sl_texture_image *side[2];  /* RGBA, alpha 1 where there is something; NULL: never filled */
    bool filled[2];             /* with the light of the octree that is shown */
} sl_atlas_canvas;

/* Takes the atlas over, and destroys it with the canvas, or at once where that fails. */
sl_status sl_atlas_canvas_create(sl_atlas *atlas, const sl_scene *scene, unsigned threads,
                                 sl_atlas_canvas **canvas, sl_error *error);
void sl_atlas_canvas_destroy(sl_atlas_canvas *canvas);
size_t sl_atlas_canvas_bytes(const sl_atlas_canvas *canvas);

/* Fills a side: irradiance from the octree's lights, on the shading normal turned to the side. What is not
 * finite becomes 0. */
sl_status sl_atlas_bake(sl_atlas_canvas *canvas, sl_atlas_side side, const sl_scene *scene,
                        const sl_octree_shading *shading, unsigned threads, sl_counters *counters,
                        sl_error *error);

/* Irradiance times kd / pi at the pixels of a G-buffer, bilinear, one look-up each; side: of each pixel.
 * Pixels of neither side, or of one that was never filled, stay as they are. */
void sl_atlas_apply(const sl_atlas_canvas *canvas, const sl_gbuffer *gbuffer, const uint8_t *side,
                    unsigned threads, float *const out[3], sl_counters *counters);
