/* 8-bit pictures (PNG, JPEG, BMP, TGA) as they are stored: the texels of textures, and the start of reading a
 * PNG or JPEG as an image. */
#ifndef SL_IMAGE_DECODE_H
#define SL_IMAGE_DECODE_H

#include "softlux.h"

/* Decodes the file at `path`, or the `bytes` bytes at `memory` where that is not NULL (`path` then only names
 * it in errors). *rgba gets width * height texels of R, G, B, A, row 0 at the top, values as stored (sRGB for
 * colours), A = 255 where the file has no alpha; the caller frees it with sl_free(). 16-bit PNGs are rounded
 * to 8 bits. */
sl_status sl_decode_texels(const char *path, const void *memory, size_t bytes, int *width, int *height,
                           bool *has_alpha, uint8_t **rgba, sl_error *error);

#endif
