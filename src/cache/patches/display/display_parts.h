/* Between arrays.c, window.c, tessellate.c and draw.c. */
#ifndef SL_PATCHES_DISPLAY_PARTS_H
#define SL_PATCHES_DISPLAY_PARTS_H

#include "cache/patches/display/copies.h"
#include "cache/patches/display/display.h"

/* A patch in the display is a leaf, a leaf with a fan, or the block of four that its children are. */
enum { SL_FAN_BIT = 0x40000000 };
#define SL_DISPLAY_LEAF SL_NO_INDEX
static inline bool sl_is_leaf_word(uint32_t word) { return word >= SL_FAN_BIT; }
static inline bool sl_is_fan_word(uint32_t word) { return sl_is_leaf_word(word) && word != SL_DISPLAY_LEAF; }

/* A wanted root. */
typedef struct sl_display_root {
    uint32_t patch;
    uint32_t vertex[4];
} sl_display_root;

/* Fans in one array: first the number of vertices that hang on the leaf's edges, in `vertex`, then these,
 * around the leaf. Those of leaves that have changed stay where they are until the copy is made anew. */
typedef struct sl_fans {
    sl_fan_spoke *spoke;
    size_t used, capacity, wasted;
} sl_fans;

static inline const sl_fan_spoke *sl_fan_at(const sl_fans *fans, uint32_t word) {
    return &fans->spoke[word & (SL_FAN_BIT - 1)];
}

/* Curved surfaces as triangles for one view. */
typedef struct sl_tessellation {
    sl_raster *raster;         /* NULL: nothing yet */
    float *x, *y, *z, *u, *v;  /* by vertex */
    uint32_t *vertex[3];       /* by triangle */
    uint32_t *primitive;
    size_t vertex_count, triangle_count;
    int rate;                  /* pieces along a side of each surface */
    sl_vec3 *point;            /* 16 control points of each, as they were */
    sl_scene *scene;           /* these triangles with materials and texture coordinates, for alpha masks */
    sl_camera camera;          /* that it was made for */
} sl_tessellation;

typedef struct sl_display_copy {
    bool complete;             /* false: all of it is to be made */
    sl_rgb guess;              /* that it was made with */
    uint32_t *root;            /* by root: index into sl_display.root, or SL_NO_INDEX */
    size_t root_count;
    uint32_t *word;            /* by patch, numbered as in sl_patches */
    size_t patch_count, patch_capacity;
    uint32_t (*middle)[5];     /* by block of four patches: the vertices that the split has made */
    size_t block_capacity;
    size_t channels;           /* as in sl_patches: 3 or 6 */
    float *value;              /* by vertex: E, and L_s after it */
    size_t vertex_count, vertex_capacity;
    sl_fans fans;
} sl_display_copy;

/* Planes of a frame. */
typedef struct sl_frame_planes {
    uint32_t *id, *curved_id;
    float *depth, *curved_depth;
} sl_frame_planes;

struct sl_window {
    sl_display *display;
    float *picture;            /* three planes; NULL: of the display's own */
    const sl_scene *scene;     /* with the camera and the positions */
    unsigned threads;          /* that follow it */
    sl_raster *raster;         /* of it */
    sl_tessellation tessellation;
    sl_frame_planes frame;
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
    /* wanted ones, in the order in which they were; both copies look here: what is there stays */
    sl_display_root *root;
    size_t root_count;
};

/* window.c. */
/* to be closed also where this fails */
sl_status sl_window_open(sl_display *display, const sl_scene *scene, unsigned threads, sl_window *window,
                         sl_error *error);
void sl_window_close(sl_window *window);

/* tessellate.c. */
/* For the window's camera, unless it is for that already. */
sl_status sl_tessellate(const sl_display *display, sl_window *window, sl_error *error);
/* The same triangles, where their surfaces are now. */
sl_status sl_tessellation_move(const sl_display *display, sl_window *window, sl_error *error);
void sl_tessellation_release(sl_tessellation *tessellation);

#endif
