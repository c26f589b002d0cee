/* The size of a patch on the screen. */
#ifndef SL_PATCHES_SCREEN_SIZE_H
#define SL_PATCHES_SCREEN_SIZE_H

#include "raster/raster.h"

/* Homogeneous: x, y, distance from the near plane, w. Linear along a straight edge. */
typedef struct sl_clip_point {
    float at[4];
} sl_clip_point;
sl_clip_point sl_clip_point_of(const sl_view *view, sl_vec3 point);

/* The size of the part in the picture and beyond the near plane: pixels squared, and pixels of the longest
 * side. Both 0: nothing is left. */
typedef struct sl_screen_size {
    float area, edge;
} sl_screen_size;

#endif
