/* The id map's pixels in the order of the faces (roots of plane primitives) that they show: what "visible
 * sizes" (image pass 1) come to, and what each mesh deals down its quadtrees to know exactly which pixels
 * show which leaf. */
#pragma once

#include "cache/patches/primitives.h"
#include "raster/raster.h"

typedef struct sl_visible_face {
    uint32_t face;
    uint32_t first, count;     /* in the arrays below */
} sl_visible_face;

typedef struct sl_visible_pixels {
    sl_view view;
    size_t face_count;         /* faces in view, ascending */
    sl_visible_face *face;
    uint32_t *entry_of_face;   /* by root: index into face, or SL_NO_INDEX */
    size_t count;              /* pixels that show something */
    uint32_t *pixel;           /* by face, bottom row first within one */
    float *w1, *w2;            /* (u, v) there: of triangles the weights of corners 1 and 2 */
} sl_visible_pixels;

/* From an id plane. Pixels of mirrors and of alpha masks are as the id map has them. The same at any number
 * of threads. */
sl_status sl_visible_pixels_sort(const sl_primitives *primitives, const sl_raster *raster,
                                 const sl_view *view, const uint32_t *id, unsigned threads,
                                 sl_visible_pixels **pixels, sl_counters *counters, sl_error *error);
void sl_visible_pixels_destroy(sl_visible_pixels *pixels);
