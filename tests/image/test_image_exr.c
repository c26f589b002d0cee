/* EXR: what we write comes back, and what OpenEXR writes is read, whatever its layout. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "unit_test.h"
#include "rendering.h"
#include "base/random.h"
#include "image_support.h"
#include "scene_files.h"

/* ---- our own files --------------------------------------------------------------------------- */

static sl_image *layered_image(int width, int height) {
    static const char *const names[] = {"R", "G", "B", "indirect.R", "direct.G", "Z", "A"};
    sl_image *image;
    assert_int_equal(sl_image_create(width, height, 7, names, &image, NULL), SL_OK);
    for (int c = 0; c < 7; c++) {
        for (int y = 0; y < height; y++) {
            for (int x = 0; x < width; x++) image->planes[(c * height + y) * width + x] = test_value(c, x, y);
        }
    }
    return image;
}

static void assert_same_image(const sl_image *a, const sl_image *b) {
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channels, b->channels);
    for (int c = 0; c < a->channels; c++) {
        const float *other = sl_image_channel(b, a->channel_name[c]);
        assert_non_null(other);
        assert_true(
            same_bits(sl_image_channel(a, a->channel_name[c]), other, (size_t)a->width * (size_t)a->height));
    }
}

static void a_layered_image_comes_back_bit_for_bit(void **state) {
    static const int sizes[][2] = {{1, 1}, {1, 40}, {17, 16}, {33, 35}, {128, 3}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        sl_image *image = layered_image(sizes[i][0], sizes[i][1]), *back;
        assert_int_equal(sl_image_write(image, scene_file_path("layers.exr"), NULL), SL_OK);
        assert_int_equal(sl_image_read(scene_file_path("layers.exr"), &back, NULL), SL_OK);
        assert_same_image(image, back);
        assert_string_equal(back->channel_name[0], "R");
        assert_string_equal(back->channel_name[2], "B");
        destroy_pictures(image, back);
    }
}

static void every_kind_of_float_survives(void **state) {
    static const uint32_t bits[] = {0x7fc00000, 0xffc12345, 0x7f800001, 0x7f800000, 0xff800000,
                                    0x00000001, 0x80000001, 0x007fffff, 0x80000000, 0x00000000,
                                    0x7f7fffff, 0xff7fffff, 0x3f800001, 0x00800000};
    enum { COUNT = sizeof bits / sizeof *bits };
    sl_image *back;
    sl_image *image = blank_image(COUNT, 1, 3);
    for (int c = 0; c < 3; c++) memcpy(image->planes + c * COUNT, bits, sizeof bits);
    assert_int_equal(sl_image_write(image, scene_file_path("floats.exr"), NULL), SL_OK);
    assert_int_equal(sl_image_read(scene_file_path("floats.exr"), &back, NULL), SL_OK);
    assert_same_image(image, back);
    destroy_pictures(image, back);
}

/* OpenEXR 3.1's C library takes a chunk that does not shrink at all for one that does. */
static void chunks_that_zip_to_their_own_size_survive(void **state) {
    enum { ACROSS = 4, CHUNKS = 4000, CHUNK = ACROSS * 16 };
    static const char *const name = "Z";
    sl_image *image, *back;
    assert_int_equal(sl_image_create(ACROSS, 16 * CHUNKS, 1, &name, &image, NULL), SL_OK);
    for (uint64_t chunk = 0; chunk < CHUNKS; chunk++) {
        uint64_t key = sl_random_key(5, chunk), equal = chunk % 16; /* from incompressible on */
        for (uint64_t i = 0; i < CHUNK; i++) {
            uint32_t bits = sl_random_bits(key, i) & 0xbf7fffffu;
            if (i < equal) bits = 0x3f800000u;
            memcpy(image->planes + chunk * CHUNK + i, &bits, sizeof bits);
        }
    }
    assert_int_equal(sl_image_write(image, scene_file_path("chunks.exr"), NULL), SL_OK);
    assert_int_equal(sl_image_read(scene_file_path("chunks.exr"), &back, NULL), SL_OK);
    assert_same_image(image, back);
    destroy_pictures(image, back);
}

static void metadata_comes_back(void **state) {
    static const char long_key[] = "softlux.a.key.that.is.longer.than.thirty.one.bytes";
    char *long_value = malloc(100001);
    memset(long_value, 'v', 100000);
    long_value[100000] = '\0';
    sl_image *image = layered_image(4, 4), *back;
    assert_int_equal(sl_image_set_metadata(image, "softlux.method", "first", NULL), SL_OK);
    assert_int_equal(sl_image_set_metadata(image, "softlux.method", "splatting \xc3\xa9\n2", NULL), SL_OK);
    assert_int_equal(sl_image_set_metadata(image, "softlux.empty", "", NULL), SL_OK);
    assert_int_equal(sl_image_set_metadata(image, long_key, long_value, NULL), SL_OK);
    assert_int_equal(sl_image_write(image, scene_file_path("metadata.exr"), NULL), SL_OK);
    assert_int_equal(sl_image_read(scene_file_path("metadata.exr"), &back, NULL), SL_OK);
    assert_int_equal(back->metadata_count, 3);
    assert_string_equal(sl_image_metadata(back, "softlux.method"), "splatting \xc3\xa9\n2");
    assert_string_equal(sl_image_metadata(back, "softlux.empty"), "");
    assert_string_equal(sl_image_metadata(back, long_key), long_value);
    assert_null(sl_image_metadata(back, "absent"));
    free(long_value);
    destroy_pictures(image, back);
}

static void metadata_with_a_name_of_the_format_is_refused(void **state) {
    static const char *const keys[] = {"dataWindow", "chromaticities", "envmap",    "timeCode",
                                       "preview",    "multiView",      "keyCode",   "framesPerSecond",
                                       "focus",      "tStop",          "worldToNDC"};
    sl_error error;
    for (size_t k = 0; k < sizeof keys / sizeof *keys; k++) {
        sl_image *image = layered_image(4, 4);
        assert_int_equal(sl_image_set_metadata(image, keys[k], "x", NULL), SL_OK);
        assert_int_equal(sl_image_write(image, scene_file_path("reserved.exr"), &error),
                         SL_ERROR_USAGE);
        assert_non_null(strstr(error.message, keys[k]));
        sl_image_destroy(image);
    }
    sl_image *image = layered_image(4, 4); /* those that are strings */
    assert_int_equal(sl_image_set_metadata(image, "owner", "x", NULL), SL_OK);
    assert_int_equal(sl_image_set_metadata(image, "comments", "x", NULL), SL_OK);
    assert_int_equal(sl_image_write(image, scene_file_path("reserved.exr"), &error), SL_OK);
    sl_image_destroy(image);
}

/* ---- others' files --------------------------------------------------------------------------- */

enum { WIDTH = 36, HEIGHT = 44, /* whole 4x4 blocks, as the library cannot write others as B44 */
       VALUES = WIDTH * HEIGHT };

typedef struct sample_data {
    uint16_t half[VALUES];
    float real[VALUES];
    uint32_t integer[VALUES];
} sample_data;

static void fill_samples(sample_data *data) {
    for (int i = 0; i < VALUES; i++) {
        data->half[i] = half_of(test_value(0, i % WIDTH, i / WIDTH));
        data->real[i] = test_value(1, i % WIDTH, i / WIDTH);
        data->integer[i] = (uint32_t)i * 2654435u;
    }
}

static float exact_half(uint16_t half) {
    return ldexpf((float)(1024 + (half & 1023)), (half >> 10 & 31) - 25);
}

static double largest_difference(const float *plane, const sample_data *data, char kind) {
    double largest = 0.0;
    for (int i = 0; i < VALUES; i++) {
        double expected = kind == 'h'   ? exact_half(data->half[i])
                          : kind == 'f' ? data->real[i]
                                        : (float)data->integer[i];
        largest = fmax(largest, fabs((double)plane[i] - expected));
    }
    return largest;
}

static void check_layout(exr_compression_t compression, int tile_width, int tile_height,
                         exr_lineorder_t order, double half_error, double float_error) {
    sample_data *data = malloc(sizeof *data);
    fill_samples(data);
    const exr_test_channel channels[] = {{"B", EXR_PIXEL_UINT, data->integer, 1},
                                         {"G", EXR_PIXEL_FLOAT, data->real, 1},
                                         {"R", EXR_PIXEL_HALF, data->half, 1}};
    exr_test_file file = {.left = -5,
                          .top = 9,
                          .width = WIDTH,
                          .height = HEIGHT,
                          .compression = compression,
                          .tile_width = tile_width,
                          .tile_height = tile_height,
                          .order = order,
                          .channels = channels,
                          .channel_count = 3};
    sl_error error = {0};
    sl_image *image;
    write_exr(scene_file_path("layout.exr"), &file);
    assert_int_equal(sl_image_read(scene_file_path("layout.exr"), &image, &error), SL_OK);
    assert_int_equal(image->width, WIDTH);
    assert_int_equal(image->height, HEIGHT);
    assert_true(largest_difference(sl_image_channel(image, "R"), data, 'h') <= half_error);
    assert_true(largest_difference(sl_image_channel(image, "G"), data, 'f') <= float_error);
    assert_true(largest_difference(sl_image_channel(image, "B"), data, 'u') == 0.0);
    assert_string_equal(sl_image_metadata(image, "comments"), "hand-made");
    sl_image_destroy(image);
    free(data);
}

static void every_compression_of_half_float_and_uint_is_read(void **state) {
    static const struct {
        exr_compression_t compression;
        double half_error, float_error; /* 0: lossless */
    } all[] = {{EXR_COMPRESSION_NONE, 0, 0},   {EXR_COMPRESSION_RLE, 0, 0},
               {EXR_COMPRESSION_ZIPS, 0, 0},   {EXR_COMPRESSION_ZIP, 0, 0},
               {EXR_COMPRESSION_PIZ, 0, 0},    {EXR_COMPRESSION_PXR24, 0, 1e-4},
               {EXR_COMPRESSION_B44, 0.02, 0}, {EXR_COMPRESSION_B44A, 0.02, 0}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        check_layout(all[i].compression, 0, 0, EXR_LINEORDER_INCREASING_Y, all[i].half_error,
                     all[i].float_error);
        check_layout(all[i].compression, 16, 8, EXR_LINEORDER_INCREASING_Y, all[i].half_error,
                     all[i].float_error);
    }
}

static void special_halves_are_converted_exactly(void **state) {
    static const uint16_t halves[] = {0x0000, 0x8000, 0x0001, 0x83ff, 0x0400, 0x7bff,
                                      0xfbff, 0x7c00, 0xfc00, 0x7e00, 0x3c01};
    static const float expected[] = {0.0f,      -0.0f,    0x1p-24f,  -0x3ffp-24f, 0x1p-14f,       65504.0f,
                                     -65504.0f, INFINITY, -INFINITY, NAN,         1.0f + 0x1p-10f};
    enum { COUNT = sizeof halves / sizeof *halves };
    const exr_test_channel channels[] = {{"R", EXR_PIXEL_HALF, halves, 1}};
    exr_test_file file = {.width = COUNT, .height = 1, .channels = channels, .channel_count = 1};
    sl_image *image;
    write_exr(scene_file_path("halves.exr"), &file);
    assert_int_equal(sl_image_read(scene_file_path("halves.exr"), &image, NULL), SL_OK);
    for (int i = 0; i < COUNT; i++) {
        if (isnan(expected[i])) assert_true(isnan(image->planes[i]));
        else assert_true(same_bits(&image->planes[i], &expected[i], 1));
    }
    sl_image_destroy(image);
}

static void the_display_window_is_the_picture(void **state) {
    static const float values[6] = {1, 2, 3, 4, 5, 6}; /* 3 x 2 at (-1, 1) */
    const exr_test_channel channels[] = {{"R", EXR_PIXEL_FLOAT, values, 1}};
    const exr_attr_box2i_t display = {.min = {.x = 0, .y = 0}, .max = {.x = 3, .y = 2}};
    static const float expected[12] = {0, 0, 0, 0, 2, 3, 0, 0, 5, 6, 0, 0};
    for (int tile = 0; tile <= 2; tile++) {
        exr_test_file file = {.left = -1,
                              .top = 1,
                              .width = 3,
                              .height = 2,
                              .display = &display,
                              .channels = channels,
                              .tile_width = tile,
                              .tile_height = tile,
                              .channel_count = 1};
        sl_image *image;
        write_exr(scene_file_path("windows.exr"), &file);
        assert_int_equal(sl_image_read(scene_file_path("windows.exr"), &image, NULL), SL_OK);
        assert_int_equal(image->width, 4);
        assert_int_equal(image->height, 3);
        assert_true(same_bits(sl_image_channel(image, "R"), expected, 12));
        sl_image_destroy(image);
    }
}

static void subsampled_channels_are_refused_by_name(void **state) {
    static const float values[16] = {0};
    const exr_test_channel channels[] = {{"RY", EXR_PIXEL_FLOAT, values, 2},
                                         {"Y", EXR_PIXEL_FLOAT, values, 1}};
    exr_test_file file = {.width = 4, .height = 4, .channels = channels, .channel_count = 2};
    sl_error error;
    sl_image *image;
    write_exr(scene_file_path("subsampled.exr"), &file);
    assert_int_equal(sl_image_read(scene_file_path("subsampled.exr"), &image, &error), SL_ERROR_INPUT);
    assert_null(image);
    assert_non_null(strstr(error.message, "RY is subsampled"));
    assert_non_null(strstr(error.message, "subsampled.exr"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_layered_image_comes_back_bit_for_bit),
        cmocka_unit_test(every_kind_of_float_survives),
        cmocka_unit_test(chunks_that_zip_to_their_own_size_survive),
        cmocka_unit_test(metadata_comes_back),
        cmocka_unit_test(metadata_with_a_name_of_the_format_is_refused),
        cmocka_unit_test(every_compression_of_half_float_and_uint_is_read),
        cmocka_unit_test(special_halves_are_converted_exactly),
        cmocka_unit_test(the_display_window_is_the_picture),
        cmocka_unit_test(subsampled_channels_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
