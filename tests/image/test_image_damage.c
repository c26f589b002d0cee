/* Damaged picture files: cut short at every length, with bytes changed, with absurd sizes. Whatever comes
 * out, it is a picture or one line that names the file; the sanitizers watch the rest. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image_write.h>

#include "unit_test.h"
#include "base/random.h"
#include "image/formats.h"
#include "image_support.h"
#include "scene_files.h"

typedef struct sample_file {
    const char *name;
    uint8_t *bytes;
    size_t size;
} sample_file;

enum { WIDTH = 12, HEIGHT = 20 };

static sample_file write_our_own(const char *name) {
    static const char *const names[] = {"R", "G", "B", "layer.R"};
    sl_image *image;
    assert_int_equal(sl_image_create(WIDTH, HEIGHT, 4, names, &image, NULL), SL_OK);
    for (int i = 0; i < 4 * WIDTH * HEIGHT; i++)
        image->planes[i] = test_value(i / (WIDTH * HEIGHT), i % WIDTH, i / WIDTH % HEIGHT);
    assert_int_equal(sl_image_set_metadata(image, "softlux.method", "path", NULL), SL_OK);
    const char *path = scene_file_path(name);
    sample_file sample = {.name = name};
    assert_int_equal(sl_image_write(image, path, NULL), SL_OK);
    sample.bytes = read_file(path, &sample.size);
    sl_image_destroy(image);
    return sample;
}

static sample_file write_exr_of(const char *name, exr_compression_t compression, int tile) {
    static float real[WIDTH * HEIGHT];
    static uint16_t half[WIDTH * HEIGHT];
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        real[i] = test_value(1, i % WIDTH, i / WIDTH);
        half[i] = half_of(real[i]);
    }
    const exr_test_channel channels[] = {{"B", EXR_PIXEL_HALF, half, 1}, {"G", EXR_PIXEL_FLOAT, real, 1},
                                         {"R", EXR_PIXEL_HALF, half, 1}};
    exr_test_file file = {.width = WIDTH,
                          .height = HEIGHT,
                          .compression = compression,
                          .tile_width = tile,
                          .tile_height = tile,
                          .channels = channels,
                          .channel_count = 3};
    sample_file sample = {.name = name};
    write_exr(scene_file_path(name), &file);
    sample.bytes = read_file(scene_file_path(name), &sample.size);
    return sample;
}

static sample_file write_8_bit(const char *name) {
    uint8_t rgb[WIDTH * HEIGHT * 3];
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
        rgb[i] = (uint8_t)(255.0f * test_value(i % 3, i / 3 % WIDTH, i / 3 / WIDTH));
    const char *path = scene_file_path(name);
    assert_true(strstr(name, "tga") ? stbi_write_tga(path, WIDTH, HEIGHT, 3, rgb)
                                    : stbi_write_bmp(path, WIDTH, HEIGHT, 3, rgb));
    sample_file sample = {.name = name};
    sample.bytes = read_file(path, &sample.size);
    return sample;
}

static sample_file write_hdr(void) {
    float rgb[WIDTH * HEIGHT * 3];
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) rgb[i] = test_value(i % 3, i / 3 % WIDTH, i / 3 / WIDTH);
    sample_file sample = {.name = "sample.hdr"};
    assert_true(stbi_write_hdr(scene_file_path(sample.name), WIDTH, HEIGHT, 3, rgb));
    sample.bytes = read_file(scene_file_path(sample.name), &sample.size);
    return sample;
}

enum { SAMPLES = 13 }; /* the last two are read as textures only */

static void make_samples(sample_file samples[SAMPLES]) {
    int count = 0;
    samples[count++] = write_our_own("sample.exr");
    samples[count++] = write_our_own("sample.pfm");
    samples[count++] = write_our_own("sample.png");
    samples[count++] = write_hdr();
    samples[count] = (sample_file){.name = "tests/data/waves.jpg"};
    samples[count].bytes = read_file(samples[count].name, &samples[count].size);
    count++;
    samples[count++] = write_exr_of("none.exr", EXR_COMPRESSION_NONE, 0);
    samples[count++] = write_exr_of("rle.exr", EXR_COMPRESSION_RLE, 8);
    samples[count++] = write_exr_of("zips.exr", EXR_COMPRESSION_ZIPS, 0);
    samples[count++] = write_exr_of("piz.exr", EXR_COMPRESSION_PIZ, 0);
    samples[count++] = write_exr_of("pxr24.exr", EXR_COMPRESSION_PXR24, 0);
    samples[count++] = write_exr_of("b44.exr", EXR_COMPRESSION_B44, 0);
    samples[count++] = write_8_bit("sample.bmp");
    samples[count++] = write_8_bit("sample.tga");
    assert_int_equal(count, SAMPLES);
}

static void free_samples(sample_file samples[SAMPLES]) {
    for (int i = 0; i < SAMPLES; i++) free(samples[i].bytes);
}

/* Reads a damaged file, as an image and as texels; checks what must hold of any answer. True if it was taken
 * for one of them. */
static bool survives(const uint8_t *bytes, size_t size) {
    sl_error error = {0};
    sl_image *image = NULL;
    /* of just this size, so that a sanitizer sees a step beyond it */
    uint8_t *copy = malloc(size ? size : 1);
    if (size) memcpy(copy, bytes, size);
    sl_bytes file = {.path = "damaged", .data = copy, .size = size};
    sl_status status = sl_image_decode(&file, &image, &error);
    assert_true((status == SL_OK) == (image != NULL));
    if (status != SL_OK) {
        assert_int_equal(error.status, status);
        assert_true(status == SL_ERROR_INPUT || status == SL_ERROR_RESOURCES);
        assert_non_null(strstr(error.message, "damaged"));
        assert_null(strchr(error.message, '\n'));
    }
    sl_image_destroy(image);
    int width, height;
    bool has_alpha;
    uint8_t *rgba;
    sl_status decoded = sl_decode_texels("damaged", copy, size, &width, &height, &has_alpha, &rgba, &error);
    assert_true((decoded == SL_OK) == (rgba != NULL));
    free(rgba);
    free(copy);
    return status == SL_OK || decoded == SL_OK;
}

static void files_cut_short_at_any_length_are_refused(void **state) {
    sample_file samples[SAMPLES];
    make_samples(samples);
    for (int i = 0; i < SAMPLES; i++) {
        assert_true(survives(samples[i].bytes, samples[i].size));
        for (size_t size = 0; size < samples[i].size; size++) {
            if (survives(samples[i].bytes, size))
                fail_msg("%s was taken at %zu bytes", samples[i].name, size);
        }
    }
    free_samples(samples);
}

static void changed_bytes_never_crash_a_reader(void **state) {
    enum { ROUNDS = 300 };
    sample_file samples[SAMPLES];
    make_samples(samples);
    for (int i = 0; i < SAMPLES; i++) {
        uint8_t *changed = malloc(samples[i].size);
        for (uint64_t round = 0; round < ROUNDS; round++) {
            uint64_t key = sl_random_key(17, (uint64_t)i * ROUNDS + round), flips = 1 + round % 4;
            memcpy(changed, samples[i].bytes, samples[i].size);
            for (uint64_t flip = 0; flip < flips; flip++) {
                /* Half of them in the header, where the lengths are. */
                size_t range = round % 2 && samples[i].size > 300 ? 300 : samples[i].size;
                changed[sl_random_bits(key, 2 * flip) % range] = (uint8_t)sl_random_bits(key, 2 * flip + 1);
            }
            survives(changed, samples[i].size);
        }
        free(changed);
    }
    free_samples(samples);
}

static void check_refused(const char *name, const void *bytes, size_t size, const char *words) {
    sl_error error = {0};
    sl_image *image;
    const char *path = scene_file_write(name, bytes, size);
    assert_int_equal(sl_image_read(path, &image, &error), SL_ERROR_INPUT);
    assert_null(image);
    assert_non_null(strstr(error.message, name));
    if (!strstr(error.message, words)) fail_msg("'%s' does not say '%s'", error.message, words);
}

static void absurd_sizes_are_refused_before_memory_is_asked_for(void **state) {
#define REFUSED(name, text, words) check_refused(name, text, sizeof text - 1, words)
    REFUSED("huge.pfm", "PF\n46341 46341\n-1.0\nabc", "too many for its");
    REFUSED("wide.pfm", "PF\n2147483648 1\n-1.0\nabc", "no size for a picture");
    REFUSED("overflow.pfm", "PF\n99999999999999999999 1\n-1.0\n", "PFM header");
    REFUSED("empty.pfm", "PF\n0 5\n-1.0\n", "no size for a picture");
    REFUSED("negative.pfm", "PF\n-3 5\n-1.0\n", "PFM header");
    REFUSED("scale.pfm", "PF\n1 1\n0\n000000000000", "the scale is '0'");
    REFUSED("huge.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 46341 +X 46341\n", "too many for its");
    REFUSED("flipped.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+Y 4 +X 4\n",
            "expected '-Y height +X width'");
    REFUSED("xyz.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 4 +X 4\n", "not supported");
    REFUSED("nothing.exr", "", "not an EXR, PFM, Radiance HDR, PNG or JPEG");
    REFUSED("text.exr", "hello, world", "not an EXR, PFM, Radiance HDR, PNG or JPEG");
#undef REFUSED
}

static void a_huge_exr_window_is_refused(void **state) {
    static const float value[16] = {0};
    const exr_test_channel channels[] = {{"R", EXR_PIXEL_FLOAT, value, 1}};
    const exr_attr_box2i_t displays[] = {
        {.min = {.x = 0, .y = 0}, .max = {.x = 46340, .y = 46340}},
        {.min = {.x = -1000000000, .y = 0}, .max = {.x = 1000000000, .y = 0}}};
    for (int i = 0; i < 2; i++) {
        exr_test_file file = {
            .width = 4, .height = 4, .display = &displays[i], .channels = channels, .channel_count = 1};
        sl_error error = {0};
        sl_image *image;
        write_exr(scene_file_path("window.exr"), &file);
        assert_int_equal(sl_image_read(scene_file_path("window.exr"), &image, &error), SL_ERROR_INPUT);
        assert_non_null(strstr(error.message, "window.exr"));
    }
}

/* A small file of many channels may not claim a large picture in each. */
static void the_channels_of_an_exr_count_in_its_claim(void **state) {
    enum { CHANNELS = 1000 };
    static const float value[1] = {0};
    static char names[CHANNELS][16];
    static exr_test_channel channels[CHANNELS];
    const exr_attr_box2i_t display = {.min = {.x = 0, .y = 0}, .max = {.x = 999, .y = 999}};
    for (int c = 0; c < CHANNELS; c++) {
        snprintf(names[c], sizeof names[c], "c%04d", c);
        channels[c] = (exr_test_channel){names[c], EXR_PIXEL_FLOAT, value, 1};
    }
    exr_test_file file = {
        .width = 1, .height = 1, .display = &display, .channels = channels, .channel_count = CHANNELS};
    sl_error error = {0};
    sl_image *image;
    write_exr(scene_file_path("many.exr"), &file);
    assert_int_equal(sl_image_read(scene_file_path("many.exr"), &image, &error), SL_ERROR_INPUT);
    assert_non_null(strstr(error.message, "1000 channels"));
}

/* Found by fuzzing: stb_image passes over bytes of 0xff before the first marker, the check of its Huffman
 * tables did not. This one lists 96 + 765 codes where there are 257 places. */
static void a_jpeg_behind_fill_bytes_is_checked_too(void **state) {
    static const uint8_t start[] = {0xff, 0xff, 0xd8, 0xff, 0xc4, 0x24, 0x00, 0x00, 0,   0,   0,   0,
                                    0,    0,    0,    0,    0,    32,   32,   32,   255, 255, 255, 0};
    uint8_t file[160] = {0}, *rgba;
    int width, height;
    bool has_alpha;
    sl_error error = {0};
    memcpy(file, start, sizeof start);
    for (size_t fill = 0; fill < 2; fill++) {
        assert_int_equal(sl_decode_texels("t.jpg", file + fill, sizeof file - fill, &width, &height,
                                          &has_alpha, &rgba, &error),
                         SL_ERROR_INPUT);
        assert_non_null(strstr(error.message, "t.jpg: damaged JPEG"));
    }
}

static void what_cannot_be_opened_is_named(void **state) {
    sl_error error = {0};
    sl_image *image;
    assert_int_equal(sl_image_read("/nowhere/x.exr", &image, &error), SL_ERROR_INPUT);
    assert_string_equal(error.message, "/nowhere/x.exr: cannot be opened: No such file or directory");
    assert_int_equal(sl_image_read(scene_file_path(""), &image, &error), SL_ERROR_INPUT);
    assert_non_null(strstr(error.message, "expected a file"));
    assert_int_equal(sl_image_read("/dev/zero", &image, NULL), SL_ERROR_INPUT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_cut_short_at_any_length_are_refused),
        cmocka_unit_test(changed_bytes_never_crash_a_reader),
        cmocka_unit_test(absurd_sizes_are_refused_before_memory_is_asked_for),
        cmocka_unit_test(a_huge_exr_window_is_refused),
        cmocka_unit_test(the_channels_of_an_exr_count_in_its_claim),
        cmocka_unit_test(a_jpeg_behind_fill_bytes_is_checked_too),
        cmocka_unit_test(what_cannot_be_opened_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
