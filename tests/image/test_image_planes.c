/* The image in memory: names, planes, metadata, and what is refused. */
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "rendering.h"
#include "softlux.h"

static void a_new_image_is_black_and_its_planes_follow_each_other(void **state) {
    static const char *const names[] = {"R", "G", "B", "direct.R"};
    sl_image *image;
    assert_int_equal(sl_image_create(5, 3, 4, names, &image, NULL), SL_OK);
    for (int i = 0; i < 60; i++) assert_true(image->planes[i] == 0.0f);
    for (int c = 0; c < 4; c++) {
        assert_string_equal(image->channel_name[c], names[c]);
        assert_ptr_equal(sl_image_channel(image, names[c]), image->planes + 15 * c);
    }
    assert_null(sl_image_channel(image, "direct.G"));
    assert_null(sl_image_channel(image, ""));
    destroy_pictures(image, NULL);
}

static void channels_without_names_are_rgb_or_y(void **state) {
    sl_image *image = blank_image(1, 1, 3);
    assert_non_null(sl_image_channel(image, "G"));
    sl_image_destroy(image);
    image = blank_image(1, 1, 1);
    assert_non_null(sl_image_channel(image, "Y"));
    sl_image_destroy(image);
    assert_int_equal(sl_image_create(1, 1, 4, NULL, &image, NULL), SL_ERROR_USAGE);
    assert_null(image);
}

static void impossible_images_are_refused(void **state) {
    static const char *const twice[] = {"R", "R"}, *const nameless[] = {""};
    static const char *const endless[] = {"a.channel.name.of.more.bytes.than.the.sixty.three.that.have.room"};
    sl_error error;
    sl_image *image;
    assert_int_equal(sl_image_create(0, 4, 3, NULL, &image, &error), SL_ERROR_USAGE);
    assert_int_equal(sl_image_create(4, -1, 3, NULL, &image, &error), SL_ERROR_USAGE);
    assert_int_equal(sl_image_create(4, 4, 0, NULL, &image, &error), SL_ERROR_USAGE);
    assert_int_equal(sl_image_create(46341, 46341, 3, NULL, &image, &error), SL_ERROR_RESOURCES);
    assert_int_equal(sl_image_create(INT32_MAX, INT32_MAX, 3, NULL, &image, &error), SL_ERROR_RESOURCES);
    assert_non_null(strstr(error.message, "2147483647 x 2147483647"));
    assert_int_equal(sl_image_create(1, 1, 2, twice, &image, &error), SL_ERROR_USAGE);
    assert_non_null(strstr(error.message, "two channels are called 'R'"));
    assert_int_equal(sl_image_create(1, 1, 1, nameless, &image, &error), SL_ERROR_USAGE);
    assert_int_equal(sl_image_create(1, 1, 1, endless, &image, &error), SL_ERROR_USAGE);
    assert_null(image);
}

static void metadata_is_copied_and_replaced(void **state) {
    char value[8] = "first";
    sl_image *image = blank_image(1, 1, 3);
    assert_null(sl_image_metadata(image, "method"));
    assert_int_equal(sl_image_set_metadata(image, "method", value, NULL), SL_OK);
    strcpy(value, "other");
    assert_string_equal(sl_image_metadata(image, "method"), "first");
    assert_int_equal(sl_image_set_metadata(image, "seed", "", NULL), SL_OK);
    /* itself */
    assert_int_equal(sl_image_set_metadata(image, "method", sl_image_metadata(image, "method"), NULL), SL_OK);
    assert_string_equal(sl_image_metadata(image, "method"), "first");
    assert_int_equal(sl_image_set_metadata(image, "method", value, NULL), SL_OK);
    assert_string_equal(sl_image_metadata(image, "method"), "other");
    assert_string_equal(sl_image_metadata(image, "seed"), "");
    assert_int_equal(image->metadata_count, 2);
    char key[SL_METADATA_KEY_MAX + 1];
    memset(key, 'k', sizeof key - 1);
    key[sizeof key - 1] = '\0';
    assert_int_equal(sl_image_set_metadata(image, key, "v", NULL), SL_ERROR_USAGE);
    key[sizeof key - 2] = '\0';
    assert_int_equal(sl_image_set_metadata(image, key, "v", NULL), SL_OK);
    assert_int_equal(sl_image_set_metadata(image, "", "v", NULL), SL_ERROR_USAGE);
    sl_image_destroy(image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_new_image_is_black_and_its_planes_follow_each_other),
        cmocka_unit_test(channels_without_names_are_rgb_or_y),
        cmocka_unit_test(impossible_images_are_refused),
        cmocka_unit_test(metadata_is_copied_and_replaced),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
