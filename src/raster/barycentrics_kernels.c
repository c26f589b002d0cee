/* Barycentric weights of a block of pixels, each by itself. */
#include "raster/barycentrics.h"

void SL_KERNEL(sl_raster_barycentric_weights)(const sl_barycentric_block *block, const sl_pass_view *view, float *w1,
                                              float *w2);
void SL_KERNEL(sl_raster_barycentric_weights)(const sl_barycentric_block *restrict block, const sl_pass_view *view,
                                              float *restrict w1, float *restrict w2) {
#pragma omp simd
    for (int n = 0; n < SL_BARYCENTRIC_BLOCK; n++) {
        float q[9];
        for (int k = 0; k < 9; k++) q[k] = block->corner[k][n];
        sl_barycentric_weights(view->clip, q, block->x[n], block->y[n], &w1[n], &w2[n]);
    }
}
