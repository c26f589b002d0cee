/* JPEG, BMP and TGA textures through stb_image, compiled into this file alone. */
#include "image/formats.h"

#include "base/error.h"
#include "base/grow.h"

#include <stdlib.h>
#include <string.h>

#pragma GCC diagnostic ignored "-Wunused-function"

/* Rows beyond the end of a short file, which stb_image leaves unset, are to be 0, not what the memory held
 * before. */
/* stb_image, which hands no pointer of ours to these, calls a picture damaged for which it has no memory */
static _Thread_local bool starved;

static inline void *zeroed(size_t bytes) {
    void *block = calloc(1, bytes ? bytes : 1);
    if (!block) starved = true;
    return block;
}

static inline void *resized(void *old, size_t bytes) {
    void *block = realloc(old, bytes);
    if (!block) starved = true;
    return block;
}

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_NO_SIMD /* its vector code rounds JPEGs differently */
#define STBI_NO_LINEAR
#define STBI_ONLY_JPEG
#define STBI_ONLY_BMP
#define STBI_ONLY_TGA
#define STBI_MAX_DIMENSIONS 65536
#define STBI_MALLOC(size) zeroed(size)
#define STBI_REALLOC(block, size) resized(block, size)
#define STBI_FREE(block) free(block)
#define STBI_ASSERT(condition) ((void)(condition))
#include <stb/stb_image.h>

/* stb_image reads zeros beyond the end and calls it a picture; this stream notices that it was asked for
 * more. */
typedef struct watched_stream {
    const sl_bytes *bytes;
    size_t position;
    bool overrun;
} watched_stream;

static int stream_read(void *user, char *to, int count) {
    watched_stream *stream = user;
    size_t left = stream->bytes->size - stream->position, asked = (size_t)count;
    /* Its buffer is filled ahead of need, so a filling may come up short; anything else that does is an
     * overrun. */
    bool ahead = asked == sizeof ((stbi__context *)NULL)->buffer_start;
    if (left == 0 || (asked > left && !ahead)) stream->overrun = true;
    if (asked > left) asked = left;
    memcpy(to, stream->bytes->data + stream->position, asked);
    stream->position += asked;
    return (int)asked;
}

static void stream_skip(void *user, int count) {
    watched_stream *stream = user;
    size_t left = stream->bytes->size - stream->position;
    if (count > 0 && (size_t)count > left) {
        stream->overrun = true;
        stream->position = stream->bytes->size;
    } else if (count < 0 && (size_t)-(int64_t)count > stream->position) {
        stream->position = 0;
    } else {
        stream->position = (size_t)((int64_t)stream->position + count);
    }
}

static int stream_at_end(void *user) {
    watched_stream *stream = user;
    return stream->position >= stream->bytes->size;
}

static const stbi_io_callbacks callbacks = {stream_read, stream_skip, stream_at_end};

bool sl_jpeg_recognise(const sl_bytes *bytes) {
    return bytes->size >= 3 && bytes->data[0] == 0xff && bytes->data[1] == 0xd8 && bytes->data[2] == 0xff;
}

/* stb_image passes over fill bytes before the first marker, so more begins a JPEG for it than the three bytes
 * that one has. */
static bool is_taken_for_jpeg(const sl_bytes *bytes) {
    return bytes->size >= 2 && bytes->data[0] == 0xff && (bytes->data[1] == 0xff || bytes->data[1] == 0xd8);
}

static sl_status check_header(const sl_bytes *bytes, bool *has_alpha, sl_error *error) {
    if (is_taken_for_jpeg(bytes) && !sl_jpeg_tables_are_sound(bytes))
        return sl_fail(error, SL_ERROR_INPUT, "%s: damaged JPEG: its segments or Huffman tables are broken",
                       bytes->path);
    watched_stream stream = {bytes, 0, false};
    int width, height, channels;
    bool known = stbi_info_from_callbacks(&callbacks, &stream, &width, &height, &channels);
    if (starved) return sl_fail_memory(error, bytes->path);
    if (!known)
        return sl_fail(error, SL_ERROR_INPUT, "%s: not a PNG, JPEG, BMP or TGA picture, or a damaged one",
                       bytes->path);
    *has_alpha = channels == 2 || channels == 4;
    /* A JPEG spends at least a bit on each of the six blocks of 256 pixels; run-length TGAs stay far below.
     */
    return sl_check_claimed_size(bytes, width, height, 1, 512, error);
}

sl_status sl_stb_decode(const sl_bytes *bytes, int *width, int *height, bool *has_alpha, uint8_t **rgba,
                        sl_error *error) {
    *rgba = NULL;
    starved = false;
    sl_status status = check_header(bytes, has_alpha, error);
    if (status != SL_OK) return status;
    watched_stream stream = {bytes, 0, false};
    int channels;
    uint8_t *texels = stbi_load_from_callbacks(&callbacks, &stream, width, height, &channels, 4);
    if (starved) status = sl_fail_memory(error, bytes->path);
    else if (!texels)
        status =
            sl_fail(error, SL_ERROR_INPUT, "%s: damaged picture: %s", bytes->path, stbi_failure_reason());
    else if (stream.overrun)
        status = sl_fail(error, SL_ERROR_INPUT, "%s: the picture is cut short", bytes->path);
    if (status == SL_OK) {
        *rgba = sl_copy_of(texels, (size_t)*width * (size_t)*height, 4);
        if (!*rgba) status = sl_fail_memory(error, bytes->path);
    }
    stbi_image_free(texels);
    return status;
}
