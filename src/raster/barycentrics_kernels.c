/* Barycentric weights of a block of pixels, each by itself. */
#include "raster/barycentrics.h"

void SL_KERNEL(sl_raster_barycentric_weights)(const sl_barycentric_block *block, const sl_pass_view *view, float *w1,
                                              float *w2);
void SL_KERNEL(sl_raster_barycentric_weights)(const sl_barycentric_block *restrict block, const sl_pass_view *view,
                                              float *restrict w1, float *restrict w2) {
    const float *restrict c0 = block->corner[0], *restrict c1 = block->corner[1], *restrict c2 = block->corner[2],
                *restrict c3 = block->corner[3], *restrict c4 = block->corner[4], *restrict c5 = block->corner[5],
                *restrict c6 = block->corner[6], *restrict c7 = block->corner[7], *restrict c8 = block->corner[8];
    const double *restrict x = block->x, *restrict y = block->y;
#pragma omp simd
    for (int n = 0; n < SL_BARYCENTRIC_BLOCK; n++) {
        float b1, b2;
        sl_barycentric_weights(view->clip, sl_v3(c0[n], c1[n], c2[n]), sl_v3(c3[n], c4[n], c5[n]), sl_v3(c6[n], c7[n], c8[n]),
                               x[n], y[n], &b1, &b2);
        w1[n] = b1;
        w2[n] = b2;
    }
}
