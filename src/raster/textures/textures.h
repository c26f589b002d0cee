/* The hardware's texture units: 2D textures, read linearly between texels; and 3D textures of bytes, read a
 * texel at a time.
 *
 * Texels are four floats (RGBA) side by side: a filter reads four texels at unrelated places, and so it reads
 * four cache lines instead of sixteen. Row 0 is at the bottom, t = 0 its lower edge; texel i of n has its
 * centre at (i + 1/2) / n. Beyond the edge the edge's texels go on.
 *
 * Accuracy: positions and weights are worked out in double, filtering too, and a result is rounded to float
 * once. So it is within half a unit in the last place of exact filtering of the given floats, whatever the
 * texture's size.
 *
 * Coordinates may be anything: infinite ones count as the nearest edge, NaN as the lower. */
#pragma once

#include "raster/raster.h"

enum { SL_TEXTURE_SIZE_MAX = 16384 };

/* ---- 2D textures ---- */

typedef struct sl_texture_image {
    int width, height;
    float *texels; /* 4 floats each */
} sl_texture_image;

/* Texels all 0, to be written by the caller. */
sl_status sl_texture_image_create(int width, int height, sl_texture_image **image, sl_error *error);
void sl_texture_image_destroy(sl_texture_image *image);

void sl_texture_image_sample(const sl_texture_image *image, float s, float t, float rgba[4]);

/* ---- 3D textures ---- */

/* Texels of four bytes, x fastest, then y, then z: 24-bit addresses and marks. */
typedef struct sl_volume {
    int width, height, depth;
    uint8_t *bytes;
} sl_volume;

/* Texels all 0, to be written by the caller at any time. 1 to 16384 each way, less than 2^31 texels. */
sl_status sl_volume_create(int width, int height, int depth, sl_volume **volume, sl_error *error);
void sl_volume_destroy(sl_volume *volume);
/* The four bytes of a texel, red lowest, exactly as stored: x | y | z are clamped to what there is. */
uint32_t sl_volume_fetch(const sl_volume *volume, int x, int y, int z);

/* ---- MIP levels (mip_chain.c; mip.h has those of scenes) ---- */

static inline int sl_half_size(int n) { return n > 1 ? n / 2 : 1; }
/* Halves a picture of RGBA texels. Each way the result has half as many, rounded down (OpenGL 4.5, section
 * 8.14.3), each the exact mean over its area: 2x2 texels, or 3 in a direction whose size is odd, those shared
 * by two weighted by their share. So its mean is the picture's. */
void sl_mip_halve(const float *from, int width, int height, float *to, unsigned threads);
