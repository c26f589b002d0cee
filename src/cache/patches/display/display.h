/* The display: Gouraud times texture on the raster hardware, of the geometry as it is, from the first frame
 * on (sections on display and on curved surfaces). The hardware draws the scene's own triangles, and of
 * curved surfaces finer ones made for the view; a fragment knows its root and its (u, v) there, and fetches
 * its leaf from the display arrays: the tree with its vertices' values. So silhouettes and alpha masks never
 * depend on patches, nothing can tear where patches meet, no triangle is made or moved when a patch is split,
 * and a quadrilateral is bilinear, where two triangles of it would show their diagonal. Arrays are kept
 * twice: one set is drawn while the other is brought up to date, and they are swapped at an update's end.
 *
 *   arrays.c         the two copies: trees; of leaves beside finer ones fans around their centre, so that
 *                    colours meet along edges; what vertices show
 *   leaf_lookup.h    from (u, v) to a leaf, and what it shows there
 *   window.c         from where frames are drawn
 *   tessellate.c     curved surfaces, from the view: chord within half a pixel; never shaded
 *   draw.c           id map, Gouraud, texture, emission
 */
#pragma once

#include "cache/patches/display/copies.h"
#include "cache/patches/patches.h"
#include "raster/raster.h"

typedef struct sl_display sl_display;
typedef struct sl_window sl_window;

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

/* Makes the hidden copy of the patches anew, and curved surfaces for the camera, and swaps. Another thread
 * may draw meanwhile, in a window of its own: its frame goes on with the copy that it has begun with, never
 * waits, and the next build waits for its end. After a failure the shown copy is what it was. */
sl_status sl_display_build(sl_display *display, const sl_patches *patches, sl_error *error);
/* Another guess from the next build on, if it is more than a hundredth off; false: it is not. */
bool sl_display_guess(sl_display *display, sl_rgb guess);

/* The id map of a frame: by pixel, bottom row first. NULL: not wanted. */
typedef struct sl_display_ids {
    /* leaf (index into sl_patches); SL_NO_INDEX on the background, and where no patch of the root is wanted
     * yet */
    uint32_t *patch;
    uint32_t *root;            /* SL_NO_INDEX on the background */
    float *u, *v;              /* of its root; 0 on the background */
} sl_display_ids;

/* The id map of the display's own window, read back. Planes are the caller's. */
sl_status sl_display_id_map(sl_display *display, const sl_display_ids *ids, sl_counters *counters,
                            sl_error *error);

/* A window is a way to look: the display has one of its own, for id maps, and frames where no other thread
 * draws them. Another is another thread's: at the same arrays, from the camera and with the objects of a copy
 * of the scene (scene/copy.h), which that thread moves as it likes. Hardware and planes are its own, and it
 * draws on its thread alone where one is given: the others are busy with samples. */
sl_status sl_window_create(sl_display *display, const sl_scene *scene_copy, unsigned threads,
                           sl_window **window, sl_error *error);
void sl_window_destroy(void *window);
/* Positions follow the scene's objects as they stand now: before the next frame. Curved surfaces are cut anew
 * for its camera with the first frame after a build. */
sl_status sl_window_move(void *window, sl_error *error);
/* Triangles that the last frame's centres show, rows from the bottom. */
const uint32_t *sl_window_ids(const void *window);
/* A frame as a picture; *builds: how many its arrays have seen. */
sl_status sl_window_picture(void *window, sl_image *image, uint64_t *builds, sl_counters *counters,
                            sl_error *error);
/* The same in planes of width*height, bottom row first: three of radiance L_e + kd E / pi + L_s, three of L_e
 * alone (NULL: not wanted). */
sl_status sl_window_draw(sl_window *window, float *const planes[6], sl_counters *counters, sl_error *error);

/* ---- what there is ---- */

/* A patch in the display is a leaf, a leaf with a fan, or the block of four that its children are. */
enum { SL_FAN_BIT = 0x40000000 };
#define SL_DISPLAY_LEAF SL_NO_INDEX
static inline bool sl_is_leaf_word(uint32_t word) { return word >= SL_FAN_BIT; }
static inline bool sl_is_fan_word(uint32_t word) { return sl_is_leaf_word(word) && word != SL_DISPLAY_LEAF; }

/* Fans in one array: first the number of vertices that hang on the leaf's edges, in `vertex`, then these,
 * around the leaf. */
typedef struct sl_fans {
    sl_fan_spoke *spoke;
    size_t used, capacity;
} sl_fans;

static inline const sl_fan_spoke *sl_fan_at(const sl_fans *fans, uint32_t word) {
    return &fans->spoke[word & (SL_FAN_BIT - 1)];
}

/* Curved surfaces as triangles for one view. */
typedef struct sl_tessellation {
    sl_raster *raster;         /* NULL: nothing yet */
    /* these triangles with materials and, for texture coordinates, (u, v): the hardware tests alpha masks */
    sl_scene *scene;
    uint32_t *primitive;       /* by triangle */
    int rate;                  /* pieces along a side of each surface */
    sl_vec3 *point;            /* 16 control points of each, as they were */
    sl_camera camera;          /* that it was made for */
} sl_tessellation;

typedef struct sl_display_copy {
    sl_rgb guess;              /* that it was made with */
    sl_wanted_root *wanted;
    uint32_t *root;            /* by root: index into these, or SL_NO_INDEX */
    size_t root_capacity;
    uint32_t *word;            /* by patch, numbered as in sl_patches */
    size_t patch_capacity;
    uint32_t (*middle)[5];     /* by block of four patches: the vertices that the split has made */
    size_t block_capacity;
    size_t channels;           /* as in sl_patches: 3 or 6 */
    float *value;              /* by vertex: E, and L_s after it */
    size_t vertex_capacity;
    sl_fans fans;
} sl_display_copy;

struct sl_window {
    sl_display *display;
    float *picture;            /* three planes; NULL: of the display's own */
    const sl_scene *scene;     /* with the camera and the positions */
    unsigned threads;          /* that follow it */
    sl_raster *raster;         /* of it */
    sl_tessellation tessellation;
    uint32_t *id, *curved_id;  /* planes of a frame */
    float *depth, *curved_depth;
    uint64_t builds;           /* of the copy that the last frame shows */
};

struct sl_display {
    const sl_scene *scene;
    const sl_primitives *primitives;
    sl_display_settings settings;
    /* of the thread that builds: id maps, and frames where no other thread draws them */
    sl_window own;
    uint8_t *left_out;         /* by scene triangle: those of curved surfaces; NULL: there are none */
    bool textured;
    uint32_t *curved;          /* primitives that are; NULL: none is */
    size_t curved_count;
    sl_display_copy copy[2];
    sl_copies copies;
};

/* ---- between arrays.c, window.c, tessellate.c and draw.c ---- */

/* window.c. */
/* to be closed also where this fails */
sl_status sl_window_open(sl_display *display, const sl_scene *scene, unsigned threads, sl_window *window,
                         sl_error *error);
void sl_window_close(sl_window *window);

/* tessellate.c. */
/* For the window's camera, unless it is for that already. */
sl_status sl_tessellate(sl_window *window, sl_error *error);
/* The same triangles, where their surfaces are now. */
sl_status sl_tessellation_move(sl_window *window, sl_error *error);
void sl_tessellation_release(sl_tessellation *tessellation);
