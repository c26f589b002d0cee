/* The loop over a leaf's pixels that is compiled for every instruction set. */
#ifndef SL_MULTI_MESH_DRAW_KERNELS_H
#define SL_MULTI_MESH_DRAW_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#include "base/isa.h"

/* A leaf whose edges have one vertex between their ends, or none: six triangles around its centre. By corner or edge, by channel. */
typedef struct sl_simple_fan {
    float corner[3][3], centre[3];
    float middle[3][3];    /* of edges; the mean of the ends where nothing is known */
    float p, q;            /* the face's weights 1 and 2 at the leaf's corner 0, */
    float b_of_p, b_of_q, c_of_p, c_of_q; /* ... and what the leaf's weights 1 and 2 gain by them from there */
} sl_simple_fan;

/* Pixel i, where the face's weights are w1[i], w2[i], into three planes. */
typedef void sl_draw_kernel(const sl_simple_fan *fan, size_t count, const uint32_t *pixel, const float *w1, const float *w2, float *const planes[3]);

sl_draw_kernel *sl_draw_kernel_for(sl_isa isa);

#endif
