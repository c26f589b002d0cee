/* 3D textures: exact fetches of bytes, trilinear filtering. */
#include "raster_support.h"
#include "raster/textures/textures.h"

static sl_volume *new_volume(int width, int height, int depth, sl_volume_format format) {
    sl_volume *volume = NULL;
    assert_int_equal(sl_volume_create(width, height, depth, format, &volume, NULL), SL_OK);
    return volume;
}

static sl_volume *random_volume(int width, int height, int depth, sl_volume_format format, uint64_t seed) {
    sl_volume *volume = new_volume(width, height, depth, format);
    uint64_t key = sl_random_key(seed, 2);
    for (uint64_t i = 0; i < 4 * (uint64_t)width * (uint64_t)height * (uint64_t)depth; i++) {
        if (format == SL_VOLUME_RGBA8) volume->bytes[i] = (uint8_t)(sl_random_unit(key, i) * 256.0f);
        else volume->texels[i] = sl_random_unit(key, i);
    }
    return volume;
}

static void assert_near(double a, double b, double tolerance) {
    if (!(fabs(a - b) <= tolerance)) fail_msg("%.9g is not %.9g within %.3g", a, b, tolerance);
}

static const sl_sampler CLAMPED = {SL_WRAP_CLAMP, SL_WRAP_CLAMP, SL_WRAP_CLAMP, true, SL_MIP_NONE};
static const sl_sampler REPEATED = {SL_WRAP_REPEAT, SL_WRAP_REPEAT, SL_WRAP_REPEAT, true, SL_MIP_NONE};

static void bytes_are_fetched_exactly_by_place_and_by_coordinate(void **state) {
    (void)state;
    enum { W = 6, H = 5, D = 7 };
    sl_volume *volume = random_volume(W, H, D, SL_VOLUME_RGBA8, 1);
    for (int i = 0; i < W * H * D; i++) {
        int x = i % W, y = i / W % H, z = i / W / H;
        const uint8_t *b = volume->bytes + 4 * i;
        uint32_t expected = (uint32_t)(b[0] | b[1] << 8 | b[2] << 16) | (uint32_t)b[3] << 24;
        assert_true(sl_volume_fetch(volume, x, y, z) == expected);
        assert_true(sl_volume_nearest(volume, REPEATED, ((float)x + 0.5f) / W, ((float)y + 0.5f) / H - 2, ((float)z + 0.5f) / D + 1) ==
                    expected);
        float rgba[4];
        sl_sampler nearest = {.linear = false};
        sl_volume_sample(volume, nearest, ((float)x + 0.5f) / W, ((float)y + 0.5f) / H, ((float)z + 0.5f) / D, rgba);
        for (int c = 0; c < 4; c++) assert_true(rgba[c] == (float)b[c] / 255.0f);
    }
    assert_true(sl_volume_fetch(volume, -5, 99, 3) == sl_volume_fetch(volume, 0, H - 1, 3));
    sl_volume_destroy(volume);
}

/* An octree of bricks of 2 x 2 x 2 texels: alpha 0 nothing, 127 a brick's address, 255 a leaf's. Descended by nearest fetches, it
 * gives every cell's address back, all 24 bits. */
static void an_octree_in_a_byte_texture_is_descended_to_the_right_leaf(void **state) {
    (void)state;
    enum { LEVELS = 4, CELLS = 1 << LEVELS, SIDE = 32 };
    sl_volume *volume = new_volume(SIDE, SIDE, SIDE, SL_VOLUME_RGBA8);
    static uint32_t leaf[CELLS][CELLS][CELLS];
    int bricks = 1, at[3][1 + 8 + 64 + 512] = {{0}}, base[3][1 + 8 + 64 + 512] = {{0}}, queue = 1, level_of[585] = {0};
    uint64_t key = sl_random_key(4, 4);
    for (int b = 0; b < queue; b++) {
        for (int k = 0; k < 8; k++) {
            int cell[3] = {k & 1, k >> 1 & 1, k >> 2}, size = CELLS >> (level_of[b] + 1), low[3];
            for (int d = 0; d < 3; d++) low[d] = base[d][b] + cell[d] * size;
            uint8_t *texel = volume->bytes + 4 * (((2 * at[2][b] + cell[2]) * SIDE + 2 * at[1][b] + cell[1]) * SIDE + 2 * at[0][b] + cell[0]);
            uint32_t random = (uint32_t)(sl_random_unit(key, (uint64_t)(8 * b + k)) * 0x1p24f);
            if (level_of[b] + 1 < LEVELS && random % 4) { /* a brick */
                int brick[3] = {bricks % 16, bricks / 16 % 16, bricks / 256};
                for (int d = 0; d < 3; d++) {
                    texel[d] = (uint8_t)(brick[d] & 255);
                    at[d][queue] = brick[d];
                    base[d][queue] = low[d];
                }
                texel[3] = 127;
                level_of[queue++] = level_of[b] + 1;
                bricks++;
            } else { /* a leaf, or nothing */
                bool empty = random % 3 == 0;
                for (int d = 0; d < 3; d++) texel[d] = (uint8_t)(empty ? 0u : random >> 8 * d & 255u);
                texel[3] = empty ? 0 : 255;
                for (int i = 0; i < size * size * size; i++) {
                    leaf[low[2] + i / size / size][low[1] + i / size % size][low[0] + i % size] = empty ? 0 : random;
                }
            }
        }
    }
    for (uint64_t i = 0; i < 100000; i++) {
        float p[3];
        for (uint64_t d = 0; d < 3; d++) p[d] = sl_random_unit(key, 100000 + 3 * i + d);
        int brick[3] = {0, 0, 0};
        uint32_t found = 0;
        for (int level = 0; level < LEVELS; level++) {
            int place[3];
            for (int d = 0; d < 3; d++) {
                float within = p[d] * (float)(1 << level);
                place[d] = 2 * brick[d] + (int)(2.0f * (within - floorf(within)));
            }
            uint32_t texel = sl_volume_fetch(volume, place[0], place[1], place[2]);
            for (int d = 0; d < 3; d++) brick[d] = (int)(texel >> 8 * d & 255);
            if (texel >> 24 == 255) found = texel & 0xffffff;
            if (texel >> 24 != 127) break;
        }
        assert_true(found == leaf[(int)(p[2] * CELLS)][(int)(p[1] * CELLS)][(int)(p[0] * CELLS)]);
    }
    assert_true(bricks > 100);
    sl_volume_destroy(volume);
}

static void an_affine_field_is_reproduced_inside(void **state) {
    (void)state;
    enum { W = 9, H = 16, D = 5 };
    sl_volume *volume = new_volume(W, H, D, SL_VOLUME_RGBA32F);
    for (int i = 0; i < W * H * D; i++) {
        float x = (float)(i % W), y = (float)(i / W % H), z = (float)(i / W / H);
        volume->texels[4 * i] = x;
        volume->texels[4 * i + 1] = 100 + x - 2 * y + 4 * z;
        volume->texels[4 * i + 2] = z;
    }
    uint64_t key = sl_random_key(8, 0);
    for (uint64_t i = 0; i < 5000; i++) {
        float s = random_between(key, 3 * i, 0.5f / W, 1 - 0.5f / W), t = random_between(key, 3 * i + 1, 0.5f / H, 1 - 0.5f / H);
        float r = random_between(key, 3 * i + 2, 0.5f / D, 1 - 0.5f / D), rgba[4];
        sl_volume_sample(volume, CLAMPED, s, t, r, rgba);
        double x = (double)s * W - 0.5, y = (double)t * H - 0.5, z = (double)r * D - 0.5;
        assert_near((double)rgba[0], x, 0x1p-24 * x + 1e-13);
        assert_near((double)rgba[1], 100 + x - 2 * y + 4 * z, 0x1p-24 * 160);
        assert_near((double)rgba[2], z, 0x1p-24 * z + 1e-13);
    }
    sl_volume_destroy(volume);
}

static void trilinear_filtering_is_that_of_the_definition_in_both_formats(void **state) {
    (void)state;
    enum { W = 5, H = 8, D = 3 };
    for (int format = 0; format < 2; format++) {
        sl_volume *volume = random_volume(W, H, D, (sl_volume_format)format, 6);
        uint64_t key = sl_random_key(9, (uint64_t)format);
        for (uint64_t i = 0; i < 20000; i++) {
            float p[3] = {random_between(key, 3 * i, -2, 2), random_between(key, 3 * i + 1, -2, 2), random_between(key, 3 * i + 2, -2, 2)};
            const int size[3] = {W, H, D};
            bool repeat = i & 1;
            long double f[3];
            int low[3], high[3];
            for (int d = 0; d < 3; d++) {
                long double u = (long double)p[d], x = repeat ? u - floorl(u) : u < 0 ? 0 : u > 1 ? 1 : u;
                x = x * size[d] - 0.5L;
                f[d] = x - floorl(x);
                int n = (int)floorl(x);
                low[d] = repeat ? (n + size[d]) % size[d] : n < 0 ? 0 : n;
                high[d] = repeat ? (n + 1) % size[d] : n + 1 < size[d] ? n + 1 : size[d] - 1;
            }
            float rgba[4];
            sl_volume_sample(volume, repeat ? REPEATED : CLAMPED, p[0], p[1], p[2], rgba);
            for (int c = 0; c < 4; c++) {
                long double sum = 0.0L;
                for (int k = 0; k < 8; k++) {
                    int x = k & 1 ? high[0] : low[0], y = k & 2 ? high[1] : low[1], z = k & 4 ? high[2] : low[2];
                    int texel = 4 * ((z * H + y) * W + x) + c;
                    long double value = format == SL_VOLUME_RGBA8 ? volume->bytes[texel] / 255.0L : (long double)volume->texels[texel];
                    sum += (k & 1 ? f[0] : 1 - f[0]) * (k & 2 ? f[1] : 1 - f[1]) * (k & 4 ? f[2] : 1 - f[2]) * value;
                }
                assert_near((double)rgba[c], (double)sum, 0x1p-25 + 1e-12);
            }
        }
        sl_volume_destroy(volume);
    }
}

static void constants_stay_constant_and_any_coordinate_is_defined(void **state) {
    (void)state;
    const float values[] = {0.0f, -0.0f, 1.0f, -1e-30f, 1e-45f, 0x1.fffffep-1f, 0x1p30f, -3e38f, INFINITY, -INFINITY, NAN, 0.4f};
    sl_volume *constant = new_volume(3, 4, 5, SL_VOLUME_RGBA8), *random = random_volume(3, 4, 5, SL_VOLUME_RGBA32F, 3);
    for (int i = 0; i < 4 * 60; i++) constant->bytes[i] = (uint8_t)(60 * (i % 4) + 7);
    for (int i = 0; i < 12 * 12 * 12 * 16; i++) {
        sl_sampler sampler = {i & 1, i >> 1 & 1, i >> 2 & 1, i & 8, SL_MIP_NONE};
        int n = i / 16;
        float rgba[4];
        sl_volume_sample(constant, sampler, values[n % 12], values[n / 12 % 12], values[n / 144], rgba);
        for (int c = 0; c < 4; c++) assert_true(rgba[c] == (float)(60 * c + 7) / 255.0f);
        sl_volume_sample(random, sampler, values[n % 12], values[n / 12 % 12], values[n / 144], rgba);
        for (int c = 0; c < 4; c++) assert_true(rgba[c] >= 0.0f && rgba[c] <= 1.0f);
        assert_true(sl_volume_nearest(constant, sampler, values[n % 12], values[n / 12 % 12], values[n / 144]) == 0xbb7f4307u);
    }
    sl_volume_destroy(constant);
    sl_volume_destroy(random);
}

static void many_lookups_are_the_same_bits_as_single_ones_on_every_instruction_set(void **state) {
    (void)state;
    enum { COUNT = 700 };
    static float s[COUNT], t[COUNT], r[COUNT], out[4][COUNT];
    static int32_t x[COUNT], y[COUNT], z[COUNT];
    static uint32_t bytes[COUNT], fetched[COUNT];
    const float values[] = {0.0f, -0.0f, 1.0f, -1.0f, 1e-45f, 1e30f, -3.4e38f, INFINITY, -INFINITY, NAN};
    uint64_t key = sl_random_key(31, 0);
    for (uint64_t i = 0; i < COUNT; i++) {
        s[i] = i % 7 ? random_between(key, 6 * i, -2, 2) : values[i / 7 % 10];
        t[i] = i % 8 ? random_between(key, 6 * i + 1, -2, 2) : values[i / 8 % 10];
        r[i] = i % 9 ? random_between(key, 6 * i + 2, -2, 2) : values[i / 9 % 10];
        x[i] = (int32_t)random_between(key, 6 * i + 3, -5, 25);
        y[i] = i % 50 ? (int32_t)random_between(key, 6 * i + 4, -5, 25) : INT32_MAX;
        z[i] = i % 60 ? (int32_t)random_between(key, 6 * i + 5, -5, 25) : INT32_MIN;
    }
    const char *isas[] = {"baseline", "avx2", "avx512"};
    for (int k = 0; k < 3 * 16 * 2; k++) {
        sl_sampler sampler = {k & 1, k >> 1 & 1, k >> 2 & 1, k & 8, SL_MIP_NONE};
        sl_volume_format format = k & 16 ? SL_VOLUME_RGBA8 : SL_VOLUME_RGBA32F;
        assert_int_equal(setenv("SOFTLUX_ISA", isas[k / 32], 1), 0);
        sl_volume *volume = random_volume(17, 6, 20, format, 44);
        unsetenv("SOFTLUX_ISA");
        float *const plane[4] = {out[0], out[1], out[2], NULL};
        size_t count = COUNT - (size_t)k;
        sl_volume_sample_many(volume, sampler, count, s, t, r, plane);
        if (format == SL_VOLUME_RGBA8) {
            sl_volume_nearest_many(volume, sampler, count, s, t, r, bytes);
            sl_volume_fetch_many(volume, count, x, y, z, fetched);
        }
        for (size_t i = 0; i < count; i++) {
            float rgba[4];
            sl_volume_sample(volume, sampler, s[i], t[i], r[i], rgba);
            for (int c = 0; c < 3; c++) assert_memory_equal(&rgba[c], &plane[c][i], sizeof(float));
            if (format != SL_VOLUME_RGBA8) continue;
            assert_true(bytes[i] == sl_volume_nearest(volume, sampler, s[i], t[i], r[i]));
            assert_true(fetched[i] == sl_volume_fetch(volume, x[i], y[i], z[i]));
        }
        sl_volume_destroy(volume);
    }
}

static void impossible_sizes_are_refused(void **state) {
    (void)state;
    sl_volume *volume;
    assert_int_equal(sl_volume_create(0, 1, 1, SL_VOLUME_RGBA8, &volume, NULL), SL_ERROR_USAGE);
    assert_int_equal(sl_volume_create(2048, 2048, 2048, SL_VOLUME_RGBA8, &volume, NULL), SL_ERROR_USAGE);
    assert_int_equal(sl_volume_create(1, 1, 16385, SL_VOLUME_RGBA32F, &volume, NULL), SL_ERROR_USAGE);
    assert_null(volume);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_fetched_exactly_by_place_and_by_coordinate),
        cmocka_unit_test(an_octree_in_a_byte_texture_is_descended_to_the_right_leaf),
        cmocka_unit_test(an_affine_field_is_reproduced_inside),
        cmocka_unit_test(trilinear_filtering_is_that_of_the_definition_in_both_formats),
        cmocka_unit_test(constants_stay_constant_and_any_coordinate_is_defined),
        cmocka_unit_test(many_lookups_are_the_same_bits_as_single_ones_on_every_instruction_set),
        cmocka_unit_test(impossible_sizes_are_refused),
    };
    return cmocka_run_group_tests_name("3D textures", tests, NULL, NULL);
}
