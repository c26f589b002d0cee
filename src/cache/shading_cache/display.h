/* The display: Gouraud times texture on the raster hardware, of the geometry as it is, from the first frame on (sections on display and on
 * curved surfaces). The hardware draws the scene's own triangles, and of curved surfaces finer ones made for the view; a fragment knows its root and its
 * (u, v) there, and fetches its leaf from the display arrays: the tree with its vertices' values. So silhouettes and alpha masks never depend on patches,
 * nothing can tear where patches meet, no triangle is made or moved when a patch is split, and a quadrilateral is bilinear, where two triangles of it would
 * show their diagonal. Arrays are kept twice: one set is drawn while the other is brought up to date, and they are swapped at an update's end.
 *
 *   arrays.c         the two copies: trees, only what has changed
 *   display_fans.c   leaves beside finer ones: fans around their centre, so that colours meet along edges
 *   vertex_values.c  what vertices show: their samples, or, before they have any, what lies between those around them
 *   packed_colour.h  colours in eight bytes
 *   leaf_lookup.h    from (u, v) to a leaf, and what it shows there
 *   tessellate.c     curved surfaces, from the view: chord within half a pixel; never shaded, only interpolated
 *   draw.c           id map, Gouraud, texture, emission
 */
#ifndef SL_SHADING_CACHE_DISPLAY_H
#define SL_SHADING_CACHE_DISPLAY_H

#include "cache/shading_cache/patches.h"
#include "raster/raster.h"

typedef struct sl_display sl_display;

typedef struct sl_display_settings {
    int width, height;
    sl_rgb guess;              /* irradiance where nothing is evaluated yet: mean reflectance x power / (area (1 - mean reflectance)) */
    unsigned threads;
} sl_display_settings;
sl_status sl_display_create(const sl_scene *scene, const sl_primitives *primitives, const sl_display_settings *settings, sl_display **display,
                            sl_error *error);
void sl_display_destroy(sl_display *display);
/* Of both copies, all that grows with the patches (and not what stands for the scene's triangles, or for pixels). */
size_t sl_display_memory_bytes(const sl_display *display);

/* Brings the hidden copy up to date with the patches (those marked SL_PATCH_DIRTY, in it or in the copy before) and with the camera (curved surfaces),
 * and swaps. Frames from the shown copy may be drawn meanwhile, by one other thread; what that draws goes on with its copy when they are swapped, so
 * that frame has to end before the next build begins. After a failure the shown copy is what it was, and the hidden one is made anew next time. */
sl_status sl_display_build(sl_display *display, sl_patches *patches, sl_counters *counters, sl_error *error);
/* Positions follow the scene's objects as they stand now: before the next frame. While nothing is being drawn. */
sl_status sl_display_move(sl_display *display, sl_error *error);

/* What the id map tells of a frame: by pixel, bottom row first. NULL: not wanted. */
typedef struct sl_display_ids {
    uint32_t *patch;           /* leaf (index into sl_patches); SL_NO_INDEX on the background, and where no patch of the root is wanted yet */
    uint32_t *root;            /* SL_NO_INDEX on the background */
    float *u, *v;              /* of its root; 0 on the background */
} sl_display_ids;

/* A frame from the camera as it stands: radiance, three planes of width*height, bottom row first: L_e + kd E / pi + L_s. */
sl_status sl_display_draw(sl_display *display, unsigned threads, float *const planes[3], sl_counters *counters, sl_error *error);
/* U1: the id map of the same arrays, read back. Planes are the caller's. It may be drawn while another thread draws a frame. */
sl_status sl_display_id_map(sl_display *display, unsigned threads, const sl_display_ids *ids, sl_counters *counters, sl_error *error);

#endif
