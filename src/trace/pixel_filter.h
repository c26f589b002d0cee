/* Pixel filters by the places of samples: where the filter weighs more, more of them lie, and all of them
 * weigh the same (Ernst, Stamminger, Greiner, "Filter Importance Sampling", 2006). */
#ifndef SL_TRACE_PIXEL_FILTER_H
#define SL_TRACE_PIXEL_FILTER_H

#include "base/choices.h"

enum { SL_FILTER_STEPS = 128 };

typedef struct sl_pixel_shape {
    sl_pixel_filter filter;
    float radius; /* of its support, in pixels; 0.5 of a box, 0 of a centre */
    /* Blackman-Harris: the inverse of its integral, offsets from the centre */
    float offset[SL_FILTER_STEPS + 1];
} sl_pixel_shape;

/* radius: of Blackman-Harris alone. */
sl_pixel_shape sl_pixel_shape_of(sl_pixel_filter filter, double radius);
/* Turns point, two numbers in [0,1), into a place from the pixel's corner on, which may lie in others. */
void sl_pixel_shape_place(const sl_pixel_shape *shape, float point[2]);

#endif
