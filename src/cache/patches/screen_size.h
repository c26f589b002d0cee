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
/* Of a convex polygon of three or four corners. */
sl_screen_size sl_screen_size_of(const sl_view *view, int corners, const sl_clip_point *corner);

/* Corners of a scene triangle. */
typedef struct sl_face_clip {
    sl_clip_point corner[3];
} sl_face_clip;
sl_face_clip sl_face_clip_of(const sl_scene *scene, const sl_view *view, uint32_t face);
/* Of a part of it, whose corner i has weights p[i] / unit, q[i] / unit of the face's corners 1 and 2. */
sl_screen_size sl_face_part_size(const sl_view *view, const sl_face_clip *face, const uint16_t p[3],
                                 const uint16_t q[3], float unit);

#endif
