/* 2D textures: filtering; halving for MIP levels. */
#include "raster_support.h"
#include "base/math.h"
#include "raster/textures/textures.h"

/* Texels in [0,1), different in every channel. */
static sl_texture_image *random_image(int width, int height, uint64_t seed) {
    sl_texture_image *image = NULL;
    assert_int_equal(sl_texture_image_create(width, height, &image, NULL), SL_OK);
    uint64_t key = sl_random_key(seed, 0);
    for (size_t i = 0; i < 4 * (size_t)width * (size_t)height; i++) image->texels[i] = sl_random_unit(key, i);
    return image;
}

static const float *texel_of(const sl_texture_image *image, int x, int y) {
    return image->texels + 4 * (y * image->width + x);
}

static void assert_near(double a, double b, double tolerance) {
    if (!(fabs(a - b) <= tolerance)) fail_msg("%.9g is not %.9g within %.3g", a, b, tolerance);
}

/* ---- filtering ---- */

static const float odd_values[] = {0.0f,       -0.0f,   1.0f,     -1.0f,          0x1p-149f,
                                   -0x1p-149f, -1e-30f, 1e-30f,   0x1.fffffep-1f, -0x1.fffffep-1f,
                                   0x1p24f,    0x1p30f, -0x1p30f, 0x1p31f,        1e30f,
                                   -1e30f,     3.4e38f, INFINITY, -INFINITY,      NAN};
enum { ODD = sizeof odd_values / sizeof *odd_values };

static void any_coordinate_gives_a_texel_of_the_texture(void **state) {
    sl_texture_image *image = random_image(5, 3, 9);
    for (int i = 0; i < ODD * ODD; i++) {
        float rgba[4];
        sl_texture_image_sample(image, odd_values[i % ODD], odd_values[i / ODD], rgba);
        for (int c = 0; c < 4; c++) assert_true(rgba[c] >= 0.0f && rgba[c] <= 1.0f);
    }
    float rgba[4];
    sl_texture_image_sample(image, INFINITY, -INFINITY, rgba);
    assert_memory_equal(rgba, texel_of(image, 4, 0), sizeof rgba);
    sl_texture_image_sample(image, NAN, 3e38f, rgba);
    assert_memory_equal(rgba, texel_of(image, 0, 2), sizeof rgba);
    sl_texture_image_destroy(image);
}

static long double within(float u) { return u < 0.0f ? 0.0L : u > 1.0f ? 1.0L : (long double)u; }
static int clamped(int i, int n) { return i < 0 ? 0 : i < n ? i : n - 1; }

static void the_result_is_exact_filtering_rounded_once(void **state) {
    const int sizes[][2] = {{1024, 512}, {1000, 333}, {3, 1}};
    for (int k = 0; k < 3; k++) {
        int w = sizes[k][0], h = sizes[k][1];
        sl_texture_image *image = random_image(w, h, 4);
        uint64_t key = sl_random_key(5, (uint64_t)k);
        for (uint64_t i = 0; i < 20000; i++) {
            float s = random_between(key, 2 * i, -0.2f, 1.2f),
                  t = random_between(key, 2 * i + 1, -0.2f, 1.2f), rgba[4];
            sl_texture_image_sample(image, s, t, rgba);
            long double u = within(s) * w - 0.5L, v = within(t) * h - 0.5L;
            int x = (int)floorl(u), y = (int)floorl(v);
            long double fu = u - x, fv = v - y;
            for (int c = 0; c < 4; c++) {
                long double sum = 0.0L;
                for (int n = 0; n < 4; n++) {
                    const float *texel =
                        texel_of(image, clamped(x + (n & 1), w), clamped(y + (n >> 1), h));
                    sum += (n & 1 ? fu : 1 - fu) * (n >> 1 ? fv : 1 - fv) * (long double)texel[c];
                }
                assert_near((double)rgba[c], (double)sum, 0x1.00001p-25 + 1e-13); /* half an ulp below 1 */
            }
        }
        sl_texture_image_destroy(image);
    }
}

/* ---- halving ---- */

static double mean_of(const float *texels, int width, int height, int channel) {
    double sum = 0.0;
    for (int i = 0; i < width * height; i++) sum += (double)texels[4 * i + channel];
    return sum / (width * height);
}

static void half_a_picture_has_its_mean_whatever_its_size(void **state) {
    const int sizes[][2] = {{64, 64}, {256, 16}, {37, 81}, {1, 100}, {255, 3}, {640, 480}, {127, 127}};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        int w = sizes[k][0], h = sizes[k][1], width = sl_half_size(w), height = sl_half_size(h);
        sl_texture_image *image = random_image(w, h, k), *half = random_image(width, height, 0);
        sl_mip_halve(image->texels, w, h, half->texels, 1);
        for (int c = 0; c < 4; c++)
            assert_near(mean_of(half->texels, width, height, c), mean_of(image->texels, w, h, c), 3e-7);
        sl_texture_image_destroy(image);
        sl_texture_image_destroy(half);
    }
}

static void impossible_sizes_are_refused(void **state) {
    sl_texture_image *image;
    assert_int_equal(sl_texture_image_create(0, 4, &image, NULL), SL_ERROR_USAGE);
    assert_int_equal(sl_texture_image_create(4, 16385, &image, NULL), SL_ERROR_USAGE);
    assert_null(image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_coordinate_gives_a_texel_of_the_texture),
        cmocka_unit_test(the_result_is_exact_filtering_rounded_once),
        cmocka_unit_test(half_a_picture_has_its_mean_whatever_its_size),
        cmocka_unit_test(impossible_sizes_are_refused),
    };
    return cmocka_run_group_tests_name("textures", tests, NULL, NULL);
}
