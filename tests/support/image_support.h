/* Shared by the tests of picture files: whole files as bytes, and EXR files written through OpenEXR itself
 * with every layout that it knows. */
#pragma once

#include <openexr.h>
#include <stddef.h>
#include <stdint.h>

#include "softlux.h"

/* The caller frees it with free(). */
uint8_t *read_file(const char *path, size_t *size);

typedef struct exr_test_channel {
    const char *name;
    exr_pixel_type_t type;
    const void *data; /* of the data window, row by row, as `type` */
    int sampling;     /* 0 or 1: every pixel */
} exr_test_channel;

typedef struct exr_test_file {
    int left, top, width, height;     /* data window */
    const exr_attr_box2i_t *display;  /* NULL: the data window */
    exr_compression_t compression;
    exr_lineorder_t order;
    int tile_width, tile_height;      /* 0: scan lines */
    const exr_test_channel *channels; /* sorted by name */
    int channel_count;
    const exr_attr_chromaticities_t *chromaticities; /* NULL: it says nothing of them; likewise */
    const exr_envmap_t *envmap;
} exr_test_file;

void write_exr(const char *path, const exr_test_file *file);

/* Distinct values, smooth enough for lossy compression, in [0, 1). */
float test_value(int channel, int x, int y);
uint16_t half_of(float value); /* for normal values that a half holds after truncation of its mantissa */
bool same_bits(const float *a, const float *b, size_t count);
