/* Texture lookup: bilinear between texel centres, repeated in both directions, v = 0 at the bottom. */
#pragma once

#include "image/color.h"
#include "scene/scene.h"

/* Linear colour: texels are decoded from sRGB before they are filtered. */
sl_rgb sl_texture_color(const sl_texture *texture, float u, float v);
/* The texel that a point lies in, linear. */
sl_rgb sl_texture_nearest(const sl_texture *texture, float u, float v);
const uint8_t *sl_texture_nearest_texel(const sl_texture *texture, float u, float v); /* its four bytes */
/* A height map: the mean of the three colour bytes as they stand, 0 to 1. */
float sl_texture_height(const sl_texture *texture, float u, float v);
/* The alpha channel, or where there is none the luminance of the bytes as they stand (a mask is data, not a
 * colour). */
float sl_texture_alpha(const sl_texture *texture, float u, float v);
