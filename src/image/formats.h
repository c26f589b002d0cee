/* The picture formats, each a pair of functions between bytes and images. Readers get the whole file: `path`
 * names it in errors only. */
#pragma once

#include "image/output_file.h"

typedef struct sl_bytes {
    const char *path; /* for errors */
    uint8_t *data;
    size_t size;
} sl_bytes;

/* Reads a whole file of at most so many bytes; behind them is a zero. Freed with sl_free(data). */
sl_status sl_bytes_read(const char *path, size_t most, sl_bytes *bytes, sl_error *error);
/* Refuses a size that no file of so few bytes can mean, before memory is asked for. `expansion`: the most
 * values (pixels, where there is one channel) that a byte can hold in the format. */
sl_status sl_check_claimed_size(const sl_bytes *bytes, int64_t width, int64_t height, int channels,
                                uint64_t expansion, sl_error *error);

/* sl_image_read() of a latitude-longitude picture of a sky: an EXR that says so holds it in its data window.
 * Cube maps are refused, and colours by other primaries than Rec. 709's. */
sl_status sl_sky_read(const char *path, sl_image **image, sl_error *error);

/* Decodes an 8-bit picture (PNG, JPEG, BMP, TGA): the file at `path`, or the `bytes` bytes at `memory` where
 * that is not NULL (`path` then only names it in errors). *rgba gets width * height texels of R, G, B, A, row
 * 0 at the top, values as stored (sRGB for colours), A = 255 where the file has no alpha; the caller frees it
 * with sl_free(). 16-bit PNGs are rounded to 8 bits. */
sl_status sl_decode_texels(const char *path, const void *memory, size_t bytes, int *width, int *height,
                           bool *has_alpha, uint8_t **rgba, sl_error *error);

/* sl_image_read() of a file that is in memory already. */
sl_status sl_image_decode(const sl_bytes *bytes, sl_image **image, sl_error *error);

/* Returns the channels' names in their order, which are the image's; release the list with sl_free(). NULL
 * without memory. */
const char **sl_image_sorted_names(const sl_image *image);

bool sl_exr_recognise(const sl_bytes *bytes);
sl_status sl_exr_read(const sl_bytes *bytes, bool sky, sl_image **image, sl_error *error);
sl_status sl_exr_write(const sl_image *image, sl_output_file *file, sl_error *error);

bool sl_pfm_recognise(const sl_bytes *bytes);
sl_status sl_pfm_read(const sl_bytes *bytes, sl_image **image, sl_error *error);
sl_status sl_pfm_write(const sl_image *image, sl_output_file *file, sl_error *error);

bool sl_hdr_recognise(const sl_bytes *bytes);
sl_status sl_hdr_read(const sl_bytes *bytes, sl_image **image, sl_error *error);

bool sl_png_recognise(const sl_bytes *bytes);
sl_status sl_png_decode(const sl_bytes *bytes, int *width, int *height, bool *has_alpha, uint8_t **rgba,
                        sl_error *error);
/* The value of a tEXt entry of a sound file, cut to `size` bytes; false where there is none. */
bool sl_png_text(const sl_bytes *bytes, const char *key, char *value, size_t size);
typedef struct sl_png_entry {
    const char *key, *value;
} sl_png_entry;
/* texels: width * height of 3 or 4 channels, row 0 at the top; texts: `count` tEXt entries. */
sl_status sl_png_write(int width, int height, int channels, const uint8_t *texels, const sl_png_entry *texts,
                       size_t count, sl_output_file *file, sl_error *error);
/* The same as a file of its own. */
sl_status sl_png_file(const char *path, int width, int height, int channels, const uint8_t *texels,
                      const sl_png_entry *texts, size_t count, sl_error *error);

/* JPEG, BMP and TGA through stb_image; TGA has no mark of its own, so it is what is left. */
bool sl_jpeg_recognise(const sl_bytes *bytes);
bool sl_jpeg_tables_are_sound(const sl_bytes *bytes);
sl_status sl_stb_decode(const sl_bytes *bytes, int *width, int *height, bool *has_alpha, uint8_t **rgba,
                        sl_error *error);
