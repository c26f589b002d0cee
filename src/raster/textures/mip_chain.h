/* Halving a picture of RGBA texels by exact means (mip_chain.c). */
#ifndef SL_RASTER_MIP_CHAIN_H
#define SL_RASTER_MIP_CHAIN_H

#include <stddef.h>

static inline int sl_half_size(int n) { return n > 1 ? n / 2 : 1; }
/* Levels of a size: 1 + floor(log2(n)). */
int sl_mip_levels(int width, int height);
/* Rows start `stride` texels apart. */
void sl_mip_halve(const float *from, int width, int height, size_t from_stride, float *to, size_t to_stride,
                  unsigned threads);

#endif
