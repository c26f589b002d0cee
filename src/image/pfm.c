/* Portable float maps: a text header, then rows of floats from the bottom up. */
#include "image/formats.h"
#include "image/tone.h"

#include "base/error.h"
#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool sl_pfm_recognise(const sl_bytes *bytes) {
    return bytes->size >= 3 && bytes->data[0] == 'P' && (bytes->data[1] == 'F' || bytes->data[1] == 'f') &&
           (bytes->data[2] == '\n' || bytes->data[2] == ' ' || bytes->data[2] == '\r' ||
            bytes->data[2] == '\t');
}

/* ---- reading --------------------------------------------------------------------------------- */

typedef struct pfm_header {
    int channels, width, height;
    bool little_endian;
    size_t data; /* where the floats begin */
} pfm_header;

static sl_status parse_header(const sl_bytes *bytes, pfm_header *header, sl_error *error) {
    char text[128] = "", width_word[32], height_word[32], scale[32];
    int used = 0;
    memcpy(text, bytes->data, bytes->size < sizeof text ? bytes->size : sizeof text - 1);
    const bool read =
        sscanf(text + 2, " %31[0-9] %31[0-9] %31s%n", width_word, height_word, scale, &used) == 3;
    if (!read || strlen(width_word) > 11 || strlen(height_word) > 11)
        return sl_fail(error, SL_ERROR_INPUT, "%s: damaged PFM header: expected width, height and scale",
                       bytes->path);
    const int64_t width = strtoll(width_word, NULL, 10), height = strtoll(height_word, NULL, 10);
    const char *digits = scale + (scale[0] == '-' || scale[0] == '+');
    if (strspn(digits, "0123456789.eE+-") != strlen(digits) || strpbrk(digits, "123456789") == NULL)
        return sl_fail(error, SL_ERROR_INPUT,
                       "%s: damaged PFM header: the scale is '%s', expected 1.0 or -1.0", bytes->path, scale);
    sl_status status = sl_check_claimed_size(bytes, width, height, 1, 1, error);
    if (status != SL_OK) return status;
    *header = (pfm_header){bytes->data[1] == 'F' ? 3 : 1, (int)width, (int)height, scale[0] == '-',
                           (size_t)used + 3};
    uint64_t needed = (uint64_t)width * (uint64_t)height * (uint64_t)header->channels * 4;
    uint64_t present = bytes->size > header->data ? bytes->size - header->data : 0;
    if (present < needed)
        return sl_fail(error, SL_ERROR_INPUT, "%s: cut short: %llu bytes of pixels, expected %llu",
                       bytes->path, (unsigned long long)present, (unsigned long long)needed);
    return SL_OK;
}

static float load_float(const uint8_t *from, bool little_endian) {
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++) bits |= (uint32_t)from[i] << (little_endian ? 8 * i : 24 - 8 * i);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

sl_status sl_pfm_read(const sl_bytes *bytes, sl_image **image, sl_error *error) {
    pfm_header header = {0};
    sl_status status = parse_header(bytes, &header, error);
    if (status == SL_OK) status = sl_image_create(header.width, header.height, 3, NULL, image, error);
    if (status != SL_OK) return status;
    size_t width = (size_t)header.width, height = (size_t)header.height, stored = (size_t)header.channels;
    const uint8_t *from = bytes->data + header.data;
    for (size_t row = height; row-- > 0;) {
        for (size_t x = 0; x < width; x++, from += 4 * stored) {
            for (size_t c = 0; c < 3; c++) {
                size_t source = stored == 3 ? c : 0; /* gray is R = G = B */
                (*image)->planes[(c * height + row) * width + x] =
                    load_float(from + 4 * source, header.little_endian);
            }
        }
    }
    return SL_OK;
}

/* ---- writing --------------------------------------------------------------------------------- */

static void store_float(uint8_t *to, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; i++) to[i] = (uint8_t)(bits >> (8 * i));
}

static sl_status write_rows(const sl_image *image, const float *const *planes, size_t channels,
                            sl_output_file *file, sl_error *error) {
    size_t width = (size_t)image->width, row_bytes = width * channels * 4;
    uint8_t *row = sl_allocate(row_bytes, 1);
    if (!row) return sl_fail_memory(error, file->name);
    sl_status status = SL_OK;
    for (size_t y = (size_t)image->height; y-- > 0 && status == SL_OK;) {
        for (size_t x = 0; x < width; x++) {
            for (size_t c = 0; c < channels; c++)
                store_float(row + 4 * (x * channels + c), planes[c][y * width + x]);
        }
        status = sl_output_write(file, row, row_bytes, error);
    }
    sl_free(row);
    return status;
}

sl_status sl_pfm_write(const sl_image *image, sl_output_file *file, sl_error *error) {
    const float *planes[3];
    const size_t channels = sl_layer_planes(image, NULL, planes) ? 3 : 1;
    if (!sl_picture_planes(image, planes))
        return sl_fail(error, SL_ERROR_USAGE, "cannot write %s: a PFM needs the channels R, G, B or Y",
                       file->name);
    char header[64];
    int length = snprintf(header, sizeof header, "%s\n%d %d\n-1.0\n", channels == 3 ? "PF" : "Pf",
                          image->width, image->height);
    sl_status status = sl_output_write(file, header, (size_t)length, error);
    return status == SL_OK ? write_rows(image, planes, channels, file, error) : status;
}
