/* The loops over pixels that are compiled for every instruction set. */
#ifndef SL_MULTI_MESH_PATH_KERNELS_H
#define SL_MULTI_MESH_PATH_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#include "base/isa.h"

/* Which children of a quadtree of triangles hold the point with weights w1, w2 of corners 1 and 2,
 * SL_PATH_LEVELS deep: two bits a level, the first in the highest ones. */
typedef void sl_path_kernel(size_t count, const float *w1, const float *w2, uint32_t *path);

sl_path_kernel *sl_path_kernel_for(sl_isa isa);

#endif
