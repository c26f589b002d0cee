/* Photons that do not flash when a light moves and samples change surface: without memory, so that a frame is the same alone as in a
 * sequence. */
#ifndef SL_CACHE_DIRECT_RADIANCE_STEADY_H
#define SL_CACHE_DIRECT_RADIANCE_STEADY_H

#include "base/vec.h"

/* The axes of a cube, or of one of its faces, turned: all by the same rotation. */
sl_frame sl_steady_cube_frame(sl_frame frame);
/* The axes of a single picture or of a hemicube, turned about the way it looks. */
sl_frame sl_steady_roll(sl_frame picture);
/* Texels a side of a face where there would be `size`. */
int sl_steady_map_size(int size);
/* A of a group whose texels have that area together and fill that share, at most 1, of their block. */
double sl_steady_area(double area, double of_block);

#endif
