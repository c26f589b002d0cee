/* Radiance HDR pictures: a byte of mantissa for each of R, G, B and one exponent for the three (G. Ward,
 * "Real pixels", Graphics Gems II, 1991), in rows that may be run-length coded (not as before 1991). */
#include "image/formats.h"

#include "base/error.h"
#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct hdr_reader {
    const sl_bytes *bytes;
    size_t position;
} hdr_reader;

bool sl_hdr_recognise(const sl_bytes *bytes) {
    return (bytes->size >= 10 && memcmp(bytes->data, "#?RADIANCE", 10) == 0) ||
           (bytes->size >= 6 && memcmp(bytes->data, "#?RGBE", 6) == 0);
}

/* ---- the header ------------------------------------------------------------------------------ */

static bool next_line(hdr_reader *reader, char *line, size_t room) {
    size_t length = 0;
    while (reader->position < reader->bytes->size) {
        char c = (char)reader->bytes->data[reader->position++];
        if (c == '\n') {
            if (length > 0 && line[length - 1] == '\r') length--;
            line[length] = '\0';
            return true;
        }
        if (length + 1 < room) line[length++] = c;
    }
    return false;
}

/* Lines up to an empty one; then the size. EXPOSURE is left alone, as nearly all who write or read these
 * files do. */
static sl_status parse_header(hdr_reader *reader, int *width, int *height, sl_error *error) {
    const char *path = reader->bytes->path;
    char line[256];
    do {
        if (!next_line(reader, line, sizeof line))
            return sl_fail(error, SL_ERROR_INPUT, "%s: the Radiance header does not end", path);
        if (strncmp(line, "FORMAT=", 7) == 0 && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
            return sl_fail(error, SL_ERROR_INPUT, "%s: '%s' is not supported, only FORMAT=32-bit_rle_rgbe",
                           path, line);
    } while (line[0]);
    char end;
    if (!next_line(reader, line, sizeof line) || sscanf(line, "-Y %9d +X %9d%c", height, width, &end) != 2)
        return sl_fail(error, SL_ERROR_INPUT,
                       "%s: expected '-Y height +X width' at the end of the Radiance header", path);
    /* A run of 127 equal bytes takes two, and there are four bytes a pixel. */
    return sl_check_claimed_size(reader->bytes, *width, *height, 1, 64, error);
}

/* ---- rows ------------------------------------------------------------------------------------ */

static bool take(hdr_reader *reader, uint8_t *to, size_t count) {
    if (count > reader->bytes->size - reader->position) return false;
    memcpy(to, reader->bytes->data + reader->position, count);
    reader->position += count;
    return true;
}

/* Each of the four components by itself: a count above 128 repeats the next byte count - 128 times, another
 * copies. */
static bool read_component_runs(hdr_reader *reader, size_t width, uint8_t *rgbe) {
    for (size_t component = 0; component < 4; component++) {
        for (size_t x = 0; x < width;) {
            uint8_t count, value = 0;
            if (!take(reader, &count, 1) || count == 0) return false;
            bool repeat = count > 128;
            size_t length = repeat ? count - 128u : count;
            if (length > width - x) return false;
            if (repeat && !take(reader, &value, 1)) return false;
            for (size_t i = 0; i < length; i++, x++) {
                if (!repeat && !take(reader, &value, 1)) return false;
                rgbe[4 * x + component] = value;
            }
        }
    }
    return true;
}

static bool read_row(hdr_reader *reader, size_t width, uint8_t *rgbe) {
    const uint8_t *start = reader->bytes->data + reader->position;
    bool by_component = reader->bytes->size - reader->position >= 4 && width >= 8 && width < 32768 &&
                        start[0] == 2 && start[1] == 2 && start[2] < 128;
    if (!by_component) return take(reader, rgbe, 4 * width);
    if (((size_t)start[2] << 8 | start[3]) != width) return false;
    reader->position += 4;
    return read_component_runs(reader, width, rgbe);
}

static sl_status read_rows(hdr_reader *reader, sl_image *image, sl_error *error) {
    size_t width = (size_t)image->width, height = (size_t)image->height;
    uint8_t *rgbe = sl_allocate(width, 4);
    if (!rgbe) return sl_fail_memory(error, reader->bytes->path);
    sl_status status = SL_OK;
    for (size_t y = 0; y < height && status == SL_OK; y++) {
        if (!read_row(reader, width, rgbe)) {
            status = sl_fail(error, SL_ERROR_INPUT, "%s: damaged or cut short in row %zu of %zu",
                             reader->bytes->path, y, height);
            break;
        }
        for (size_t x = 0; x < width; x++) {
            const uint8_t *pixel = rgbe + 4 * x;
            /* The mantissa is a fraction of 256, the exponent has an excess of 128; ldexp() is exact. */
            float scale = pixel[3] ? ldexpf(1.0f, pixel[3] - (128 + 8)) : 0.0f;
            for (size_t c = 0; c < 3; c++)
                image->planes[(c * height + y) * width + x] = (float)pixel[c] * scale;
        }
    }
    sl_free(rgbe);
    return status;
}

sl_status sl_hdr_read(const sl_bytes *bytes, sl_image **image, sl_error *error) {
    hdr_reader reader = {bytes, 0};
    int width, height;
    sl_image *created = NULL;
    sl_status status = parse_header(&reader, &width, &height, error);
    if (status == SL_OK) status = sl_image_create(width, height, 3, NULL, &created, error);
    if (status == SL_OK) status = read_rows(&reader, created, error);
    if (status == SL_OK) *image = created;
    else sl_image_destroy(created);
    return status;
}
