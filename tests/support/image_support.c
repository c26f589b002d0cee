#define _XOPEN_SOURCE 700
#include "unit_test.h"
#include "image_support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

uint8_t *read_file(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    *size = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = malloc(*size + 1);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    fclose(file);
    return bytes;
}

static size_t value_bytes(exr_pixel_type_t type) { return type == EXR_PIXEL_HALF ? 2 : 4; }

/* As in image/exr_write.c: the library's own step can write chunks that nobody can read. */
static exr_result_t compress_or_store(exr_encode_pipeline_t *encoder) {
    exr_result_t (*const *compress)(exr_encode_pipeline_t *) = encoder->encoding_user_data;
    exr_result_t result = (*compress)(encoder);
    if (encoder->compressed_bytes >= encoder->packed_bytes) {
        memmove(encoder->compressed_buffer, encoder->packed_buffer, encoder->packed_bytes);
        encoder->compressed_bytes = encoder->packed_bytes;
    }
    return result;
}

static void encode(exr_context_t context, const exr_test_file *file, const exr_chunk_info_t *info, int x0,
                   int y0) {
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    assert_int_equal(exr_encoding_initialize(context, 0, info, &encoder), EXR_ERR_SUCCESS);
    assert_int_equal(encoder.channel_count, file->channel_count);
    for (int c = 0; c < file->channel_count; c++) {
        exr_coding_channel_info_t *channel = &encoder.channels[c];
        size_t bytes = value_bytes(file->channels[c].type);
        int sampling = file->channels[c].sampling > 1 ? file->channels[c].sampling : 1;
        size_t row = (size_t)(file->width / sampling);
        channel->encode_from_ptr =
            (const uint8_t *)file->channels[c].data + bytes * ((size_t)(y0 / sampling) * row + (size_t)x0);
        channel->user_bytes_per_element = (int16_t)bytes;
        channel->user_data_type = (uint16_t)file->channels[c].type;
        channel->user_pixel_stride = (int32_t)bytes;
        channel->user_line_stride = (int32_t)(bytes * row);
    }
    assert_int_equal(exr_encoding_choose_default_routines(context, 0, &encoder), EXR_ERR_SUCCESS);
    exr_result_t (*compress)(exr_encode_pipeline_t *) = encoder.compress_fn;
    if (compress) {
        encoder.encoding_user_data = &compress;
        encoder.compress_fn = compress_or_store;
    }
    assert_int_equal(exr_encoding_run(context, 0, &encoder), EXR_ERR_SUCCESS);
    exr_encoding_destroy(context, &encoder);
}

static void encode_tiles(exr_context_t context, const exr_test_file *file) {
    for (int y = 0; y * file->tile_height < file->height; y++) {
        for (int x = 0; x * file->tile_width < file->width; x++) {
            exr_chunk_info_t info;
            assert_int_equal(exr_write_tile_chunk_info(context, 0, x, y, 0, 0, &info), EXR_ERR_SUCCESS);
            encode(context, file, &info, x * file->tile_width, y * file->tile_height);
        }
    }
}

static void encode_scan_lines(exr_context_t context, const exr_test_file *file) {
    int32_t lines;
    assert_int_equal(exr_get_scanlines_per_chunk(context, 0, &lines), EXR_ERR_SUCCESS);
    int chunks = (file->height + lines - 1) / lines;
    for (int i = 0; i < chunks; i++) {
        int y = lines * (file->order == EXR_LINEORDER_DECREASING_Y ? chunks - 1 - i : i);
        exr_chunk_info_t info;
        assert_int_equal(exr_write_scanline_chunk_info(context, 0, file->top + y, &info), EXR_ERR_SUCCESS);
        encode(context, file, &info, 0, y);
    }
}

void write_exr(const char *path, const exr_test_file *file) {
    exr_context_t context;
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_attr_box2i_t data = {.min = {.x = file->left, .y = file->top},
                             .max = {.x = file->left + file->width - 1, .y = file->top + file->height - 1}};
    exr_attr_v2f_t centre = {.x = 0.0f, .y = 0.0f};
    int part;
    assert_int_equal(exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &start), EXR_ERR_SUCCESS);
    bool tiled = file->tile_width > 0;
    assert_int_equal(exr_add_part(context, "test", tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part),
                     EXR_ERR_SUCCESS);
    assert_int_equal(exr_initialize_required_attr(context, 0, file->display ? file->display : &data, &data,
                                                  1.0f, &centre, 1.0f, file->order, file->compression),
                     EXR_ERR_SUCCESS);
    if (tiled) {
        assert_int_equal(exr_set_tile_descriptor(context, 0, (uint32_t)file->tile_width,
                                                 (uint32_t)file->tile_height, EXR_TILE_ONE_LEVEL,
                                                 EXR_TILE_ROUND_DOWN),
                         EXR_ERR_SUCCESS);
    }
    for (int c = 0; c < file->channel_count; c++) {
        int sampling = file->channels[c].sampling > 1 ? file->channels[c].sampling : 1;
        assert_int_equal(exr_add_channel(context, 0, file->channels[c].name, file->channels[c].type,
                                         EXR_PERCEPTUALLY_LOGARITHMIC, sampling, sampling), EXR_ERR_SUCCESS);
    }
    assert_int_equal(exr_attr_set_string(context, 0, "comments", "hand-made"), EXR_ERR_SUCCESS);
    if (file->chromaticities)
        assert_int_equal(exr_attr_set_chromaticities(context, 0, "chromaticities", file->chromaticities),
                         EXR_ERR_SUCCESS);
    if (file->envmap)
        assert_int_equal(exr_attr_set_envmap(context, 0, "envmap", *file->envmap), EXR_ERR_SUCCESS);
    assert_int_equal(exr_write_header(context), EXR_ERR_SUCCESS);
    if (tiled) encode_tiles(context, file);
    else encode_scan_lines(context, file);
    assert_int_equal(exr_finish(&context), EXR_ERR_SUCCESS);
}

float test_value(int channel, int x, int y) {
    return 0.125f + 0.4f * (float)(sin(0.11 * x + channel) * cos(0.07 * y) + 1.0) + 0.001f * (float)channel;
}

uint16_t half_of(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (uint16_t)((bits >> 16 & 0x8000u) | (((bits >> 23 & 255u) - 112u) << 10 & 0x7c00u) |
                      (bits >> 13 & 0x3ffu));
}

bool same_bits(const float *a, const float *b, size_t count) { return memcmp(a, b, count * sizeof *a) == 0; }
