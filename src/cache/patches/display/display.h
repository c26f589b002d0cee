/* The display: Gouraud times texture on the raster hardware, of the geometry as it is, from the first frame
 * on (sections on display and on curved surfaces). The hardware draws the scene's own triangles, and of
 * curved surfaces finer ones made for the view; a fragment knows its root and its (u, v) there, and fetches
 * its leaf from the display arrays: the tree with its vertices' values. So silhouettes and alpha masks never
 * depend on patches, nothing can tear where patches meet, no triangle is made or moved when a patch is split,
 * and a quadrilateral is bilinear, where two triangles of it would show their diagonal. Arrays are kept
 * twice: one set is drawn while the other is brought up to date, and they are swapped at an update's end.
 *
 *   arrays.c         the two copies: trees, only what has changed; of leaves beside finer ones fans around
 *                    their centre, so that colours meet along edges; what vertices show
 *   leaf_lookup.h    from (u, v) to a leaf, and what it shows there
 *   window.c         from where frames are drawn
 *   tessellate.c     curved surfaces, from the view: chord within half a pixel; never shaded
 *   draw.c           id map, Gouraud, texture, emission
 */
#ifndef SL_PATCHES_DISPLAY_H
#define SL_PATCHES_DISPLAY_H

#include "cache/patches/patches.h"
#include "raster/raster.h"

typedef struct sl_display sl_display;

typedef struct sl_display_settings {
    int width, height;
    /* irradiance where nothing is evaluated yet: mean reflectance x power / (area (1 - mean reflectance)) */
    sl_rgb guess;
    unsigned threads;
} sl_display_settings;
sl_status sl_display_create(const sl_scene *scene, const sl_primitives *primitives,
                            const sl_display_settings *settings, sl_display **display, sl_error *error);
void sl_display_destroy(sl_display *display);
/* Of both copies, all that grows with the patches (and not what stands for the scene's triangles, or for
 * pixels). */
size_t sl_display_memory_bytes(const sl_display *display);

/* Brings the hidden copy up to date with the patches (those marked SL_PATCH_DIRTY_FIRST for it) and curved
 * surfaces with the camera, and swaps. Another thread may draw meanwhile, in a window of its own: its frame
 * goes on with the copy that it has begun with, never waits, and the next build waits for its end. After a
 * failure the shown copy is what it was, and the hidden one is made anew next time. */
sl_status sl_display_build(sl_display *display, sl_patches *patches, sl_error *error);
/* Another guess from the next build on, if it is more than a hundredth off; false: it is not. */
bool sl_display_guess(sl_display *display, sl_rgb guess);
/* Positions follow the scene's objects as they stand now: before the next frame. */
sl_status sl_display_move(sl_display *display, sl_error *error);

/* The id map of a frame: by pixel, bottom row first. NULL: not wanted. */
typedef struct sl_display_ids {
    /* leaf (index into sl_patches); SL_NO_INDEX on the background, and where no patch of the root is wanted
     * yet */
    uint32_t *patch;
    uint32_t *root;            /* SL_NO_INDEX on the background */
    float *u, *v;              /* of its root; 0 on the background */
} sl_display_ids;

/* A frame from the camera as it stands, planes of width*height, bottom row first: three of radiance L_e + kd E
 * / pi + L_s, three of L_e alone (NULL: not wanted). */
sl_status sl_display_draw(sl_display *display, unsigned threads, float *const planes[6],
                          sl_counters *counters, sl_error *error);
/* The id map of the same arrays, read back. Planes are the caller's. */
/* The rasterizer of the scene that the display's own window draws with. */
const sl_raster *sl_display_raster(const sl_display *display);
sl_status sl_display_id_map(sl_display *display, unsigned threads, const sl_display_ids *ids,
                            sl_counters *counters, sl_error *error);

/* A window is another thread's way to look: at the same arrays, from the camera and with the objects of a
 * copy of the scene (scene/copy.h), which that thread moves as it likes. Hardware and planes are its own, and
 * it draws on its thread alone where one is given: the others are busy with samples. */
typedef struct sl_window sl_window;
sl_status sl_window_create(sl_display *display, const sl_scene *scene_copy, unsigned threads,
                           sl_window **window, sl_error *error);
void sl_window_destroy(void *window);
/* Positions follow the copy's objects. Curved surfaces are cut anew for its camera with the first frame after
 * a build. */
sl_status sl_window_move(void *window, sl_error *error);
/* Triangles that the last frame's centres show, rows from the bottom. */
const uint32_t *sl_window_ids(const void *window);
/* A frame as a picture; *builds: how many its arrays have seen. */
sl_status sl_window_picture(void *window, sl_image *image, uint64_t *builds, sl_counters *counters,
                            sl_error *error);
sl_status sl_window_draw(sl_display *display, sl_window *window, unsigned threads, float *const planes[6],
                         sl_counters *counters, sl_error *error);

#endif
