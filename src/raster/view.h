/* The constants of one view, and what clipping by its planes says of a vertex. */
#pragma once

#include <math.h>

#include "raster/raster.h"

enum {
    SL_RASTER_MAX_SIZE = 16384, /* so that snapped coordinates stay below 2^22 */
    SL_SUBPIXEL = 256           /* 8 bits */
};

static inline int sl_larger(int a, int b) { return a > b ? a : b; }
static inline int sl_smaller(int a, int b) { return a < b ? a : b; }

/* Clip codes. The four sides, then near and far; the planes' order is that of clipping. */
enum {
    SL_CLIP_RIGHT = 1,  /* x > w */
    SL_CLIP_LEFT = 2,   /* x < -w */
    SL_CLIP_TOP = 4,    /* y > w */
    SL_CLIP_BOTTOM = 8, /* y < -w */
    SL_CLIP_NEAR = 16,
    SL_CLIP_FAR = 32,
    SL_CLIP_INVALID = 64, /* a coordinate is NaN, infinite or so large that differences could overflow */
    SL_CLIP_PLANES = 6
};

/* Nearer corners are at the eye: 1/w would not be finite. */
#define SL_LEAST_W 0x1p-126f

/* Rule of depth: its value between a triangle's corners, and which depth is nearer. */
typedef enum sl_depth_rule {
    SL_NEARER_IS_SMALLER, /* window depth */
    SL_NEARER_IS_LARGER,  /* 1/w */
    SL_OPENGL_PLANE       /* window depth from the plane at the target's corner */
} sl_depth_rule;

/* Constants of one view, worked out once a render. */
typedef struct sl_pass_view {
    float clip[4][4];
    float origin[3];
    float half_width, half_height;
    float offset_x, offset_y; /* window = ndc * half + offset: half the viewport's size plus its corner */
    int width, height;        /* of the target */
    /* the pixels to draw, half-open, in the target: the viewport, or the scissor's part of it */
    int x0, y0, x1, y1;
    bool inverse_w;
    sl_depth_rule rule;
    uint32_t skip;
    const uint8_t *left_out;
    int planes;            /* for culling: 5 without a far plane, 6 with one */
    float plane[6][4];     /* inside: n . (p - origin) + d >= 0 */
    float plane_length[6]; /* |n|; infinite if that is next to nothing */
} sl_pass_view;

/* The view's constants for a target of this size. */
sl_pass_view sl_pass_view_make(const sl_view *view, int width, int height);
