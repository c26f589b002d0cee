/* 3D textures of bytes: exact fetches. */
#include "raster_support.h"
#include "raster/textures/textures.h"

static void bytes_are_fetched_exactly_and_places_beyond_are_the_nearest(void **state) {
    enum { W = 6, H = 5, D = 7 };
    sl_volume *volume = NULL;
    assert_int_equal(sl_volume_create(W, H, D, &volume, NULL), SL_OK);
    uint64_t key = sl_random_key(1, 2);
    for (uint64_t i = 0; i < 4 * W * H * D; i++)
        volume->bytes[i] = (uint8_t)(sl_random_unit(key, i) * 256.0f);
    for (int i = 0; i < W * H * D; i++) {
        const uint8_t *b = volume->bytes + 4 * i;
        uint32_t expected = (uint32_t)(b[0] | b[1] << 8 | b[2] << 16) | (uint32_t)b[3] << 24;
        assert_true(sl_volume_fetch(volume, i % W, i / W % H, i / W / H) == expected);
    }
    assert_true(sl_volume_fetch(volume, -5, 99, 3) == sl_volume_fetch(volume, 0, H - 1, 3));
    sl_volume_destroy(volume);
}

static void impossible_sizes_are_refused(void **state) {
    sl_volume *volume;
    assert_int_equal(sl_volume_create(0, 1, 1, &volume, NULL), SL_ERROR_USAGE);
    assert_int_equal(sl_volume_create(2048, 2048, 2048, &volume, NULL), SL_ERROR_USAGE);
    assert_int_equal(sl_volume_create(1, 1, 16385, &volume, NULL), SL_ERROR_USAGE);
    assert_null(volume);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_fetched_exactly_and_places_beyond_are_the_nearest),
        cmocka_unit_test(impossible_sizes_are_refused),
    };
    return cmocka_run_group_tests_name("3D textures", tests, NULL, NULL);
}
