/* PFM, Radiance HDR, PNG and JPEG against files made by hand or by another writer; the tone curves;
 * whole-or-nothing. */
#define _XOPEN_SOURCE 700

#include <dirent.h>
#include <math.h>
#include <png.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image_write.h>

#include "unit_test.h"
#include "rendering.h"
#include "base/random.h"
#include "image/formats.h"
#include "image_support.h"
#include "scene_files.h"

static sl_image *read_image(const char *path) {
    sl_error error = {0};
    sl_image *image = NULL;
    if (sl_image_read(path, &image, &error) != SL_OK) fail_msg("%s", error.message);
    return image;
}

/* ---- PFM ------------------------------------------------------------------------------------- */

static void a_pfm_begins_with_its_bottom_row(void **state) {
    static const uint8_t little[] =
        "Pf\n2 2\n-1.0\n\x00\x00\x80\x3f\x00\x00\x00\x40\x00\x00\x40\x40\x00\x00\x80\x40";
    static const uint8_t big[] =
        "Pf\n2 2\n1.0\n\x3f\x80\x00\x00\x40\x00\x00\x00\x40\x40\x00\x00\x40\x80\x00\x00";
    static const float expected[4] = {3, 4, 1, 2};
    for (int i = 0; i < 2; i++) {
        scene_file_write("gray.pfm", i ? big : little, (i ? sizeof big : sizeof little) - 1);
        sl_image *image = read_image(scene_file_path("gray.pfm"));
        assert_int_equal(image->channels, 3);
        for (int c = 0; c < 3; c++) assert_true(same_bits(image->planes + 4 * c, expected, 4));
        sl_image_destroy(image);
    }
}

static void a_pfm_comes_back_bit_for_bit(void **state) {
    static const uint32_t special[] = {0x7fc01234, 0xff800000, 0x7f800000,
                                       0x00000001, 0x80000000, 0x7f7fffff};
    sl_image *image = blank_image(7, 5, 3);
    for (int i = 0; i < 105; i++) image->planes[i] = test_value(i / 35, i % 7, i / 7);
    memcpy(image->planes + 50, special, sizeof special);
    assert_int_equal(sl_image_write(image, scene_file_path("back.pfm"), NULL), SL_OK);
    sl_image *back = read_image(scene_file_path("back.pfm"));
    assert_int_equal(back->width, 7);
    assert_int_equal(back->height, 5);
    assert_true(same_bits(image->planes, back->planes, 105));
    destroy_pictures(image, back);
}

/* ---- Radiance HDR ---------------------------------------------------------------------------- */

static void a_flat_hdr_is_read_top_row_first(void **state) {
    static const uint8_t file[] =
        "#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n-Y 2 +X 2\n"
        "\x80\x40\x20\x81\x00\x00\x00\x00\xff\x01\x80\x90\x80\x00\x00\x01";
    static const float expected[12] = {1.0f,   0.0f, 65280.0f, 0x1p-128f, 0.5f,     0.0f,
                                       256.0f, 0.0f, 0.25f,    0.0f,      32768.0f, 0.0f};
    scene_file_write("flat.hdr", file, sizeof file - 1);
    sl_image *image = read_image(scene_file_path("flat.hdr"));
    assert_true(same_bits(image->planes, expected, 12));
    sl_image_destroy(image);
}

static void a_run_length_coded_hdr_is_read(void **state) {
    /* 8 pixels: red 128 in all, green 1..8, blue 5 six times then 6 7, exponent 129 + 7 = 2^(136-136). */
    static const uint8_t by_component[] =
        "#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n\x02\x02\x00\x08\x88\x80"
        "\x08\x01\x02\x03\x04\x05\x06\x07\x08\x86\x05\x02\x06\x07\x88\x88";
    scene_file_write("runs.hdr", by_component, sizeof by_component - 1);
    sl_image *image = read_image(scene_file_path("runs.hdr"));
    static const float blue[8] = {5, 5, 5, 5, 5, 5, 6, 7};
    for (int x = 0; x < 8; x++) {
        assert_true(image->planes[x] == 128.0f);
        assert_true(image->planes[8 + x] == (float)(x + 1));
        assert_true(image->planes[16 + x] == blue[x]);
    }
    sl_image_destroy(image);
}

/* ---- PNG and JPEG ---------------------------------------------------------------------------- */

static void texels_of_every_png_kind_are_decoded(void **state) {
    static const uint8_t pixels[16] = {10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150, 160};
    for (int channels = 1; channels <= 4; channels++) {
        const char *path = scene_file_path("kinds.png");
        int width, height;
        bool has_alpha;
        uint8_t *rgba;
        assert_true(stbi_write_png(path, 2, 2, channels, pixels, 2 * channels));
        assert_int_equal(sl_decode_texels(path, NULL, 0, &width, &height, &has_alpha, &rgba, NULL), SL_OK);
        assert_int_equal(width, 2);
        assert_int_equal(height, 2);
        assert_int_equal(has_alpha, channels == 2 || channels == 4);
        for (int i = 0; i < 4; i++) {
            const uint8_t *stored = pixels + i * channels;
            for (int c = 0; c < 3; c++)
                assert_int_equal(rgba[4 * i + c], channels >= 3 ? stored[c] : stored[0]);
            assert_int_equal(rgba[4 * i + 3], has_alpha ? stored[channels - 1] : 255);
        }
        free(rgba);
    }
}

static void pngs_of_palettes_and_sixteen_bits_are_decoded(void **state) {
    /* linear gray for libpng: the file is 16-bit */
    static const uint16_t deep[4] = {0, 0x8080, 0xffff, 0x1234};
    static const uint8_t map[6] = {1, 2, 3, 200, 100, 50}, indices[4] = {0, 1, 1, 0};
    png_image description = {
        .version = PNG_IMAGE_VERSION, .width = 4, .height = 1, .format = PNG_FORMAT_LINEAR_Y};
    const char *path = scene_file_path("deep.png");
    int width, height;
    bool has_alpha;
    uint8_t *rgba;
    assert_true(png_image_write_to_file(&description, path, 0, deep, 0, NULL));
    assert_int_equal(sl_decode_texels(path, NULL, 0, &width, &height, &has_alpha, &rgba, NULL), SL_OK);
    for (int i = 0; i < 4; i++) assert_int_equal(rgba[4 * i], (deep[i] * 255 + 32767) / 65535);
    free(rgba);
    png_image palette = {.version = PNG_IMAGE_VERSION,
                         .width = 2,
                         .height = 2,
                         .format = PNG_FORMAT_RGB_COLORMAP,
                         .colormap_entries = 2};
    path = scene_file_path("palette.png");
    assert_true(png_image_write_to_file(&palette, path, 0, indices, 0, map));
    assert_int_equal(sl_decode_texels(path, NULL, 0, &width, &height, &has_alpha, &rgba, NULL), SL_OK);
    for (int i = 0; i < 4; i++) assert_memory_equal(rgba + 4 * i, map + 3 * indices[i], 3);
    assert_false(has_alpha);
    free(rgba);
}

static void expect_waves(const char *name, const uint8_t *bytes, size_t size, int tolerance) {
    enum { W = 24, H = 20 };
    int width, height;
    bool has_alpha;
    uint8_t *rgba;
    assert_int_equal(sl_decode_texels(name, bytes, size, &width, &height, &has_alpha, &rgba, NULL), SL_OK);
    assert_int_equal(width, W);
    assert_int_equal(height, H);
    assert_false(has_alpha);
    for (int i = 0; i < W * H * 3; i++) {
        int expected = (int)(255.0f * test_value(i % 3, i / 3 % W, i / 3 / W));
        assert_true(abs(rgba[4 * (i / 3) + i % 3] - expected) <= tolerance);
        assert_int_equal(rgba[4 * (i / 3) + 3], 255);
    }
    free(rgba);
}

static void a_jpeg_is_decoded(void **state) { /* the file holds test_value(), at quality 90 */
    expect_waves("tests/data/waves.jpg", NULL, 0, 12);
}

static void bmp_and_tga_are_decoded_exactly(void **state) {
    enum { W = 24, H = 20 };
    uint8_t rgb[W * H * 3];
    for (int i = 0; i < W * H * 3; i++) rgb[i] = (uint8_t)(255.0f * test_value(i % 3, i / 3 % W, i / 3 / W));
    for (int format = 0; format < 2; format++) {
        const char *path = scene_file_path(format ? "picture.tga" : "picture.bmp");
        assert_true(format ? stbi_write_tga(path, W, H, 3, rgb) : stbi_write_bmp(path, W, H, 3, rgb));
        size_t size;
        uint8_t *bytes = read_file(path, &size);
        expect_waves("memory", bytes, size, 0);
        free(bytes);
    }
}

static void a_png_read_as_an_image_is_linear(void **state) {
    static const uint8_t rgba[8] = {0, 255, 128, 51, 10, 11, 188, 255};
    const char *path = scene_file_path("linear.png");
    assert_true(stbi_write_png(path, 2, 1, 4, rgba, 8));
    sl_image *image = read_image(path);
    assert_true(sl_image_channel(image, "R")[0] == 0.0f);
    assert_true(sl_image_channel(image, "G")[0] == 1.0f);
    assert_true(fabs((double)sl_image_channel(image, "B")[0] - 0.21586050) < 1e-7);
    assert_true(fabs((double)sl_image_channel(image, "R")[1] - 10.0 / 255.0 / 12.92) < 1e-9);
    assert_true(sl_image_channel(image, "A")[0] == 0.2f);
    sl_image_destroy(image);
}

/* ---- tone ------------------------------------------------------------------------------------ */

/* libpng's own reading, without ours. */
static void read_codes(const char *path, uint8_t *rgb, int count) {
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&png, path));
    png.format = PNG_FORMAT_RGB;
    assert_int_equal(PNG_IMAGE_SIZE(png), 3 * count);
    assert_true(png_image_finish_read(&png, NULL, rgb, 0, NULL));
}

static void check_codes(sl_tone tone, const float *values, const int *codes, int count) {
    uint8_t rgb[3 * 64];
    sl_image *image = blank_image(count, 1, 3);
    for (int c = 0; c < 3; c++) memcpy(image->planes + c * count, values, (size_t)count * sizeof *values);
    assert_int_equal(sl_image_write_png(image, scene_file_path("tone.png"), tone, NULL), SL_OK);
    read_codes(scene_file_path("tone.png"), rgb, count);
    for (int i = 0; i < 3 * count; i++) assert_int_equal(rgb[i], codes[i / 3]);
    uint8_t shown[3 * 64];
    assert_int_equal(sl_image_srgb(image, &tone, shown, NULL), SL_OK); /* a screen gets the same */
    assert_memory_equal(shown, rgb, 3 * (size_t)count);
    sl_image_destroy(image);
}

static void tone_curves_give_known_codes(void **state) {
    static const float values[] = {0.0f,  1.0f, 0.5f,     0.18f,     0.0031308f, 2.0f,
                                   -1.0f, NAN,  INFINITY, -INFINITY, 1e-9f,      4.0f};
    static const int clipped[] = {0, 255, 188, 118, 10, 255, 0, 0, 255, 0, 0, 255};
    static const int one_stop_up[] = {0, 255, 255, 162, 18, 255, 0, 0, 255, 0, 0, 255};
    static const int reinhard[] = {0, 193, 158, 109, 10, 225, 0, 0, 255, 0, 0, 255};
    check_codes((sl_tone){SL_TONE_CLIP, 0.0f, false}, values, clipped, 12);
    check_codes((sl_tone){SL_TONE_CLIP, 1.0f, false}, values, one_stop_up, 12);
    check_codes((sl_tone){SL_TONE_REINHARD, 0.0f, false}, values, reinhard, 12);
}

static void automatic_exposure_brings_the_log_average_to_middle_gray(void **state) {
    static const float values[] = {2.0f, 32.0f, 8.0f, 0.0f, NAN}; /* their log average is 8 */
    static const int codes[] = {60, 221, 118, 0, 0};
    static const int one_stop_up[] = {85, 255, 162, 0, 0};
    static const float black[] = {0.0f, 0.0f};
    static const int black_codes[] = {0, 0};
    check_codes((sl_tone){SL_TONE_CLIP, 0.0f, true}, values, codes, 5);
    check_codes((sl_tone){SL_TONE_CLIP, 1.0f, true}, values, one_stop_up, 5);
    check_codes((sl_tone){SL_TONE_CLIP, 0.0f, true}, black, black_codes, 2);
}

static void frames_after_the_first_one_keep_its_exposure(void **state) {
    sl_tone tone = {SL_TONE_CLIP, 0.0f, true};
    uint8_t first[3], second[3], alone[3];
    sl_image *image = blank_image(1, 1, 3);
    for (int c = 0; c < 3; c++) image->planes[c] = 8.0f;
    assert_int_equal(sl_image_srgb(image, &tone, first, NULL), SL_OK);
    assert_false(tone.automatic);
    assert_true(fabs((double)tone.exposure_stops - log2(0.18 / 8.0)) < 1e-5);
    for (int c = 0; c < 3; c++) image->planes[c] = 16.0f;
    assert_int_equal(sl_image_srgb(image, &tone, second, NULL), SL_OK);
    tone.automatic = true;
    tone.exposure_stops = 0.0f;
    assert_int_equal(sl_image_srgb(image, &tone, alone, NULL), SL_OK);
    for (int c = 0; c < 3; c++) {
        assert_int_equal(first[c], 118);
        assert_int_equal(second[c], 162);
        assert_int_equal(alone[c], 118);
    }
    sl_image_destroy(image);
}

/* ---- whole or not at all --------------------------------------------------------------------- */

static int files_there(void) {
    int count = 0;
    DIR *directory = opendir(scene_file_path(""));
    assert_non_null(directory);
    while (readdir(directory)) count++;
    closedir(directory);
    return count;
}

static void a_write_that_fails_keeps_the_old_file(void **state) {
    static const char *const names[] = {"kept.exr", "kept.pfm", "kept.png"};
    static const char *const channels[] = {"R", "G", "B"};
    sl_image *image;
    assert_int_equal(sl_image_create(100, 100, 3, channels, &image, NULL), SL_OK);
    /* will not compress */
    for (uint64_t i = 0; i < 30000; i++) image->planes[i] = sl_random_unit(sl_random_key(1, 2), i);
    signal(SIGXFSZ, SIG_IGN);
    for (int i = 0; i < 3; i++) {
        const char *path = scene_file_write(names[i], "old", 3);
        int before = files_there();
        struct rlimit limit, small;
        sl_error error = {0};
        assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
        small = limit;
        small.rlim_cur = 8000;
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        sl_status status = sl_image_write(image, path, &error);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
        assert_int_equal(status, SL_ERROR_OUTPUT);
        assert_non_null(strstr(error.message, "cannot write"));
        assert_non_null(strstr(error.message, names[i]));
        assert_int_equal(files_there(), before);
        size_t size;
        uint8_t *bytes = read_file(path, &size);
        assert_int_equal(size, 3);
        assert_memory_equal(bytes, "old", 3);
        free(bytes);
        assert_int_equal(sl_image_write(image, path, &error), SL_OK); /* and with room it is replaced */
        sl_image_destroy(read_image(path));
        assert_int_equal(files_there(), before);
    }
    sl_image_destroy(image);
}

static void impossible_targets_are_named(void **state) {
    sl_error error;
    sl_image *image = blank_image(2, 2, 3);
    assert_int_equal(sl_image_write(image, "/nowhere/at/all.exr", &error), SL_ERROR_OUTPUT);
    assert_string_equal(error.message, "cannot write /nowhere/at/all.exr: No such file or directory");
    const char *folder = scene_file_path("folder.png");
    assert_int_equal(mkdir(folder, 0777), 0);
    assert_int_equal(sl_image_write(image, folder, &error), SL_ERROR_OUTPUT);
    assert_int_equal(rmdir(folder), 0);
    assert_int_equal(sl_image_write(image, scene_file_path("what.gif"), &error), SL_ERROR_USAGE);
    sl_image_destroy(image);
}

static void a_link_is_followed_and_permissions_are_kept(void **state) {
    struct stat status;
    sl_image *image = blank_image(2, 2, 3);
    scene_file_write("target.pfm", "old", 3);
    assert_int_equal(chmod(scene_file_path("target.pfm"), 0640), 0);
    assert_int_equal(symlink("target.pfm", scene_file_path("link.pfm")), 0);
    assert_int_equal(sl_image_write(image, scene_file_path("link.pfm"), NULL), SL_OK);
    assert_int_equal(lstat(scene_file_path("link.pfm"), &status), 0);
    assert_true(S_ISLNK(status.st_mode));
    assert_int_equal(stat(scene_file_path("target.pfm"), &status), 0);
    assert_int_equal(status.st_mode & 0777, 0640);
    assert_true(status.st_size > 3);
    sl_image_destroy(image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pfm_begins_with_its_bottom_row),
        cmocka_unit_test(a_pfm_comes_back_bit_for_bit),
        cmocka_unit_test(a_flat_hdr_is_read_top_row_first),
        cmocka_unit_test(a_run_length_coded_hdr_is_read),
        cmocka_unit_test(texels_of_every_png_kind_are_decoded),
        cmocka_unit_test(pngs_of_palettes_and_sixteen_bits_are_decoded),
        cmocka_unit_test(a_jpeg_is_decoded),
        cmocka_unit_test(bmp_and_tga_are_decoded_exactly),
        cmocka_unit_test(a_png_read_as_an_image_is_linear),
        cmocka_unit_test(tone_curves_give_known_codes),
        cmocka_unit_test(automatic_exposure_brings_the_log_average_to_middle_gray),
        cmocka_unit_test(frames_after_the_first_one_keep_its_exposure),
        cmocka_unit_test(a_write_that_fails_keeps_the_old_file),
        cmocka_unit_test(impossible_targets_are_named),
        cmocka_unit_test(a_link_is_followed_and_permissions_are_kept),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
