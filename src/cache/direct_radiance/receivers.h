/* What a picture shows, pixel by pixel, ready to be lit: the camera's view, with what planar mirrors show in it, or a face of a curved
 * mirror's environment cube. */
#ifndef SL_CACHE_DIRECT_RADIANCE_RECEIVERS_H
#define SL_CACHE_DIRECT_RADIANCE_RECEIVERS_H

#include "raster/raster.h"
#include "raster/views/mirror.h"

typedef struct sl_receivers {
    int width, height;
    int first_row;               /* of rows of a larger picture: where they begin in it; views are always those of the whole */
    sl_gbuffer *gbuffer;         /* unmirrored positions and normals, turned to where they are seen from; row 0 at the bottom */
    float *throughput[3];        /* product of the planar mirrors' reflectances on the way; NULL: no mirror in view, 1 everywhere */
    uint8_t *path;               /* which of eye[] and view[] each pixel is seen from; NULL: all from the first */
    size_t path_count;           /* 1 without mirrors in view */
    sl_vec3 eye[SL_MIRROR_PATHS]; /* the eye and its mirror images */
    sl_view *view;               /* and the views that they draw: path_count */
    const sl_mirrors *mirrors;   /* those that were followed: what still shows one of them lies beyond the nesting limit; NULL: none */
} sl_receivers;

/* Passes 5 and 6's geometry: view, and up to `reflections` planar mirrors one behind another (mirrors may be NULL). Views may be cameras,
 * pyramids or a cube's faces. The mirrors must outlive what is made of them. *receivers: NULL, or those of an earlier frame, which are then
 * replaced: fresh memory costs as much as a small scene. */
sl_status sl_receivers_render(const sl_scene *scene, const sl_raster *raster, const sl_view *view, const sl_mirrors *mirrors,
                              int reflections, unsigned threads, sl_receivers **receivers, sl_counters *counters, sl_error *error);
/* Which triangle each pixel shows, and by way of which mirrors: all but the G-buffer's resolution, for strips.c. Of the G-buffer there are
 * the id plane, and with mirrors the depth. */
sl_status sl_receivers_outline(const sl_scene *scene, const sl_raster *raster, const sl_view *view, const sl_mirrors *mirrors,
                               int reflections, unsigned threads, sl_receivers **receivers, sl_counters *counters, sl_error *error);
void sl_receivers_destroy(sl_receivers *receivers);
size_t sl_receivers_bytes(const sl_receivers *receivers);

static inline sl_vec3 sl_receiver_eye(const sl_receivers *r, size_t pixel) { return r->eye[r->path ? r->path[pixel] : 0]; }

#endif
