/* 2D textures: filtering, MIP chains, levels of detail, and the pass that applies a scene's textures. */
#include "raster_support.h"
#include "base/math.h"
#include "raster/textures/textures.h"

static const sl_sampler BILINEAR = {SL_WRAP_REPEAT, SL_WRAP_REPEAT, SL_WRAP_REPEAT, true, SL_MIP_NONE};
static const sl_sampler TRILINEAR = {SL_WRAP_REPEAT, SL_WRAP_REPEAT, SL_WRAP_REPEAT, true, SL_MIP_LINEAR};

static sl_texture_image *new_image(int width, int height, bool mip) {
    sl_texture_image *image = NULL;
    assert_int_equal(sl_texture_image_create(width, height, mip, &image, NULL), SL_OK);
    return image;
}

/* Texels in [0,1), different in every channel. */
static sl_texture_image *random_image(int width, int height, uint64_t seed) {
    sl_texture_image *image = new_image(width, height, true);
    uint64_t key = sl_random_key(seed, 0);
    for (size_t i = 0; i < 4 * (size_t)width * (size_t)height; i++) image->texels[i] = sl_random_unit(key, i);
    sl_texture_image_build(image, 1);
    return image;
}

static void assert_near(double a, double b, double tolerance) {
    if (!(fabs(a - b) <= tolerance)) fail_msg("%.9g is not %.9g within %.3g", a, b, tolerance);
}

/* ---- filtering ---- */

static void a_linear_ramp_is_reproduced_exactly_inside(void **state) {
    (void)state;
    enum { W = 48, H = 20 };
    sl_texture_image *image = new_image(W, H, false);
    for (int y = 0; y < H; y++) {
        for (int x = 0; x < W; x++) {
            float *texel = image->texels + 4 * (y * W + x);
            texel[0] = (float)x + 0.5f;
            texel[1] = (float)y + 0.5f;
            texel[2] = (float)(3 * x - 2 * y);
        }
    }
    uint64_t key = sl_random_key(1, 1);
    for (uint64_t i = 0; i < 5000; i++) {
        float s = random_between(key, 2 * i, 0.5f / W, 1.0f - 0.5f / W), t = random_between(key, 2 * i + 1, 0.5f / H, 1.0f - 0.5f / H);
        float rgba[4];
        sl_texture_sample(image, BILINEAR, s, t, 0.0f, rgba);
        double u = (double)s * W, v = (double)t * H;
        assert_near((double)rgba[0], u, 0x1p-24 * u);
        assert_near((double)rgba[1], v, 0x1p-24 * v);
        double plane = 3.0 * (u - 0.5) - 2.0 * (v - 0.5);
        assert_near((double)rgba[2], plane, 0x1p-24 * fabs(plane) + 1e-13);
    }
    sl_texture_image_destroy(image);
}

static void a_texel_centre_gives_that_texel(void **state) {
    (void)state;
    const int sizes[][2] = {{1, 1}, {64, 32}, {7, 13}};
    for (int k = 0; k < 3; k++) {
        int w = sizes[k][0], h = sizes[k][1];
        sl_texture_image *image = random_image(w, h, 3);
        for (int y = 0; y < h; y++) {
            for (int x = 0; x < w; x++) {
                float rgba[4], s = ((float)x + 0.5f) / (float)w, t = ((float)y + 0.5f) / (float)h;
                const float *texel = sl_texture_fetch(image, 0, x, y);
                sl_sampler nearest = {.linear = false};
                sl_texture_sample(image, nearest, s, t, 0.0f, rgba);
                assert_memory_equal(rgba, texel, sizeof rgba);
                sl_texture_sample(image, BILINEAR, s, t, 0.0f, rgba);
                for (int c = 0; c < 4; c++) assert_near((double)rgba[c], (double)texel[c], 2e-6); /* s itself is rounded */
            }
        }
        sl_texture_image_destroy(image);
    }
}

static void repetition_blends_the_last_texel_with_the_first_and_clamping_does_not(void **state) {
    (void)state;
    sl_texture_image *image = new_image(4, 1, false);
    for (int x = 0; x < 4; x++) image->texels[4 * x] = (float)(x + 1);
    sl_sampler clamp = {SL_WRAP_CLAMP, SL_WRAP_CLAMP, SL_WRAP_CLAMP, true, SL_MIP_NONE};
    const struct {
        float s, repeated, clamped;
    } cases[] = {{0.0f, 2.5f, 1.0f}, {1.0f, 2.5f, 4.0f}, {-0.125f, 4.0f, 1.0f}, {1.125f, 1.0f, 4.0f}, {5.375f, 2.0f, 4.0f},
                 {-3.375f, 3.0f, 1.0f}, {0.0625f, 1.75f, 1.0f}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        float rgba[4];
        sl_texture_sample(image, BILINEAR, cases[i].s, 0.3f, 0.0f, rgba);
        assert_true(rgba[0] == cases[i].repeated);
        sl_texture_sample(image, clamp, cases[i].s, 0.3f, 0.0f, rgba);
        assert_true(rgba[0] == cases[i].clamped);
    }
    sl_texture_image_destroy(image);
}

static const float odd_values[] = {0.0f, -0.0f, 1.0f, -1.0f, 0x1p-149f, -0x1p-149f, -1e-30f, 1e-30f, 0x1.fffffep-1f, -0x1.fffffep-1f, 0x1p24f,
                                   0x1p30f, -0x1p30f, 0x1p31f, 1e30f, -1e30f, 3.4e38f, INFINITY, -INFINITY, NAN};
enum { ODD = sizeof odd_values / sizeof *odd_values };

static void any_coordinate_gives_a_texel_of_the_texture(void **state) {
    (void)state;
    sl_texture_image *image = random_image(5, 3, 9);
    for (int mode = 0; mode < 24; mode++) {
        sl_sampler sampler = {mode & 1, mode >> 1 & 1, 0, mode & 4, (sl_mip)(mode / 8)};
        for (int i = 0; i < ODD * ODD * ODD; i++) {
            float rgba[4];
            sl_texture_sample(image, sampler, odd_values[i % ODD], odd_values[i / ODD % ODD], odd_values[i / ODD / ODD], rgba);
            for (int c = 0; c < 4; c++) assert_true(rgba[c] >= 0.0f && rgba[c] <= 1.0f);
        }
    }
    sl_sampler clamp = {SL_WRAP_CLAMP, SL_WRAP_CLAMP, SL_WRAP_CLAMP, true, SL_MIP_NONE};
    float rgba[4];
    sl_texture_sample(image, clamp, INFINITY, -INFINITY, 0.0f, rgba);
    assert_memory_equal(rgba, sl_texture_fetch(image, 0, 4, 0), sizeof rgba);
    sl_texture_sample(image, clamp, NAN, 3e38f, 0.0f, rgba);
    assert_memory_equal(rgba, sl_texture_fetch(image, 0, 0, 2), sizeof rgba);
    assert_memory_equal(sl_texture_fetch(image, 99, 99, -99), sl_texture_fetch(image, 2, 0, 0), 4 * sizeof(float));
    sl_texture_image_destroy(image);
}

static void the_result_is_exact_filtering_rounded_once(void **state) {
    (void)state;
    const int sizes[][2] = {{1024, 512}, {1000, 333}, {3, 1}};
    for (int k = 0; k < 3; k++) {
        int w = sizes[k][0], h = sizes[k][1];
        sl_texture_image *image = random_image(w, h, 4);
        uint64_t key = sl_random_key(5, (uint64_t)k);
        for (uint64_t i = 0; i < 20000; i++) {
            float s = random_between(key, 2 * i, -3, 3), t = random_between(key, 2 * i + 1, -3, 3), rgba[4];
            sl_texture_sample(image, BILINEAR, s, t, 0.0f, rgba);
            long double u = ((long double)s - floorl((long double)s)) * w - 0.5L, v = ((long double)t - floorl((long double)t)) * h - 0.5L;
            int x = (int)floorl(u), y = (int)floorl(v);
            long double fu = u - x, fv = v - y;
            for (int c = 0; c < 4; c++) {
                long double sum = 0.0L;
                for (int n = 0; n < 4; n++) {
                    const float *texel = sl_texture_fetch(image, 0, (x + (n & 1) + w) % w, (y + (n >> 1) + h) % h);
                    sum += (n & 1 ? fu : 1 - fu) * (n >> 1 ? fv : 1 - fv) * (long double)texel[c];
                }
                assert_near((double)rgba[c], (double)sum, 0x1.00001p-25 + 1e-13); /* half an ulp below 1 */
            }
        }
        sl_texture_image_destroy(image);
    }
}

/* ---- MIP chains ---- */

static void a_constant_texture_is_constant_at_any_level_of_detail(void **state) {
    (void)state;
    sl_texture_image *image = new_image(37, 81, true);
    const float color[4] = {0.1f, 1e-20f, 12345.678f, 0.7f};
    for (int i = 0; i < 37 * 81; i++) memcpy(image->texels + 4 * i, color, sizeof color);
    sl_texture_image_build(image, 2);
    uint64_t key = sl_random_key(7, 7);
    for (uint64_t i = 0; i < 5000; i++) {
        float rgba[4];
        sl_texture_sample(image, TRILINEAR, random_between(key, 3 * i, -9, 9), random_between(key, 3 * i + 1, -9, 9),
                          random_between(key, 3 * i + 2, -1, 9), rgba);
        assert_memory_equal(rgba, color, sizeof color);
    }
    sl_texture_image_destroy(image);
}

static double mean_of_level(const sl_texture_image *image, int level, int channel) {
    double sum = 0.0;
    size_t texels = (size_t)image->width[level] * (size_t)image->height[level];
    for (size_t i = 0; i < texels; i++) sum += (double)image->texels[4 * ((size_t)image->first[level] + i) + (size_t)channel];
    return sum / (double)texels;
}

static void every_level_has_the_mean_of_the_picture_whatever_its_size(void **state) {
    (void)state;
    const int sizes[][2] = {{64, 64}, {256, 16}, {37, 81}, {1, 100}, {255, 3}, {640, 480}, {127, 127}};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        sl_texture_image *image = random_image(sizes[k][0], sizes[k][1], k);
        int larger = sizes[k][0] > sizes[k][1] ? sizes[k][0] : sizes[k][1], levels = 1;
        while (larger >> levels) levels++;
        assert_int_equal(image->levels, levels);
        for (int l = 0; l < levels; l++) {
            assert_int_equal(image->width[l], sizes[k][0] >> l > 1 ? sizes[k][0] >> l : 1);
            assert_int_equal(image->height[l], sizes[k][1] >> l > 1 ? sizes[k][1] >> l : 1);
            for (int c = 0; c < 4; c++) assert_near(mean_of_level(image, l, c), mean_of_level(image, 0, c), 3e-7);
        }
        sl_texture_image_destroy(image);
    }
}

/* A ramp's mean over a texel is the ramp at its middle: so the levels of a ramp are the ramp itself. With odd sizes n the ramp is made
 * of steps that texels cut, which moves it by less than a texel's n-th part; dropping the odd row would move it by half a texel. */
static void a_ramp_stays_where_it_is_in_every_level(void **state) {
    (void)state;
    enum { W = 77, H = 64 };
    sl_texture_image *image = new_image(W, H, true);
    for (int i = 0; i < W * H; i++) {
        image->texels[4 * i] = ((float)(i % W) + 0.5f) / W;
        image->texels[4 * i + 1] = ((float)(i / W) + 0.5f) / H;
    }
    sl_texture_image_build(image, 1);
    double moved = 5e-7;
    for (int l = 0; l < image->levels; l++) {
        if (l > 0 && image->width[l - 1] % 2) moved += 0.6 / image->width[l - 1] / image->width[l - 1];
        for (int y = 0; y < image->height[l]; y++) {
            for (int x = 0; x < image->width[l]; x++) {
                const float *texel = sl_texture_fetch(image, l, x, y);
                assert_near((double)texel[0], ((double)x + 0.5) / image->width[l], moved);
                assert_near((double)texel[1], ((double)y + 0.5) / image->height[l], 5e-7);
            }
        }
    }
    sl_texture_image_destroy(image);
}

static void the_level_read_follows_the_level_of_detail(void **state) {
    (void)state;
    sl_texture_image *image = new_image(8, 8, true);
    for (int l = 0; l < 4; l++) {
        int texels = image->width[l] * image->height[l];
        for (int i = 0; i < texels; i++) image->texels[4 * (image->first[l] + i)] = (float)l;
    }
    const struct {
        float lod, linear, nearest;
    } cases[] = {{-5.0f, 0, 0}, {0.0f, 0, 0}, {0.25f, 0.25f, 0}, {0.5f, 0.5f, 0}, {0.75f, 0.75f, 1}, {1.5f, 1.5f, 1}, {2.0f, 2, 2},
                 {2.625f, 2.625f, 3}, {3.0f, 3, 3}, {9.0f, 3, 3}, {INFINITY, 3, 3}, {NAN, 0, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (int linear = 0; linear < 2; linear++) {
            float rgba[4];
            sl_sampler sampler = {0, 0, 0, linear, SL_MIP_LINEAR};
            sl_texture_sample(image, sampler, 0.3f, 0.6f, cases[i].lod, rgba);
            assert_true(rgba[0] == cases[i].linear);
            sampler.mip = SL_MIP_NEAREST;
            sl_texture_sample(image, sampler, 0.3f, 0.6f, cases[i].lod, rgba);
            assert_true(rgba[0] == cases[i].nearest);
        }
    }
    sl_texture_image_destroy(image);
}

static void the_level_of_detail_is_the_longer_axis_in_texels(void **state) {
    (void)state;
    assert_near((double)sl_texture_lod(256, 256, 1.0 / 256, 0, 0, 1.0 / 256), 0.0, 1e-6);
    assert_near((double)sl_texture_lod(256, 64, 4.0 / 256, 0, 0, 1.0 / 64), 2.0, 1e-6);
    assert_near((double)sl_texture_lod(256, 64, 3.0 / 256, 4.0 / 64, 0.001, 0), 2.321928, 2e-6);
    assert_near((double)sl_texture_lod(100, 10, 0.0, 0.0, 0.3 / 100, 0.4 / 10), -1.0, 1e-6);
    assert_true(sl_texture_lod(16, 16, 0, 0, 0, 0) == -63.0f);
    assert_true(sl_texture_lod(16, 16, (double)NAN, 0, 0, 0) == -63.0f);
    assert_true(sl_texture_lod(16, 16, 1e300, 0, 0, 0) == 64.0f);
}

static void a_file_texture_is_decoded_before_it_is_averaged(void **state) {
    (void)state;
    uint8_t bytes[4 * 4] = {255, 0, 188, 0, 0, 0, 188, 255, 255, 255, 188, 255, 0, 255, 188, 0};
    sl_texture texture = {.width = 2, .height = 2, .has_alpha = true, .texels = bytes};
    sl_texture_image *image = NULL;
    assert_int_equal(sl_texture_image_of_texture(&texture, 1, &image, NULL), SL_OK);
    assert_int_equal(image->levels, 2);
    const float *lower_left = sl_texture_fetch(image, 0, 0, 0), *mean = sl_texture_fetch(image, 1, 0, 0);
    assert_true(lower_left[0] == 1.0f && lower_left[1] == 1.0f && lower_left[3] == 1.0f); /* the file's third texel: rows turned */
    assert_true(mean[0] == 0.5f && mean[1] == 0.5f && mean[3] == 0.5f);
    assert_true(mean[2] == lower_left[2]); /* a constant channel: 188 is about half in linear light */
    assert_near((double)mean[2], 0.5029, 1e-4);
    sl_texture_image_destroy(image);
}

static void a_pbuffer_and_its_levels_hold_the_means_of_its_pixels(void **state) {
    (void)state;
    sl_pbuffer *pbuffer = NULL, *ids = NULL;
    sl_texture_image *image = NULL;
    assert_int_equal(sl_pbuffer_create(18, 18, SL_PBUFFER_RGB32F, &pbuffer, NULL), SL_OK);
    double sum = 0.0;
    for (int i = 0; i < 18 * 18; i++) sum += (double)(pbuffer->channel[1][i] = (float)(i * i % 97));
    assert_int_equal(sl_texture_image_of_pbuffer(pbuffer, 1, &image, NULL), SL_OK);
    assert_int_equal(image->levels, 5);
    assert_near((double)sl_texture_fetch(image, 4, 0, 0)[1], sum / (18 * 18), 1e-4);
    assert_true(sl_texture_fetch(image, 0, 5, 7)[1] == pbuffer->channel[1][7 * 18 + 5] && sl_texture_fetch(image, 0, 5, 7)[3] == 1.0f);
    sl_texture_image_destroy(image);
    assert_int_equal(sl_pbuffer_create(4, 4, SL_PBUFFER_R32UI, &ids, NULL), SL_OK);
    assert_int_equal(sl_texture_image_of_pbuffer(ids, 1, &image, NULL), SL_ERROR_USAGE);
    assert_null(image);
    sl_pbuffer_destroy(ids);
    sl_pbuffer_destroy(pbuffer);
}

static void impossible_sizes_are_refused(void **state) {
    (void)state;
    sl_texture_image *image;
    sl_pbuffer *pbuffer;
    assert_int_equal(sl_texture_image_create(0, 4, true, &image, NULL), SL_ERROR_USAGE);
    assert_int_equal(sl_texture_image_create(4, 16385, true, &image, NULL), SL_ERROR_USAGE);
    assert_null(image);
    assert_int_equal(sl_pbuffer_create(4, -1, SL_PBUFFER_R32F, &pbuffer, NULL), SL_ERROR_USAGE);
    assert_null(pbuffer);
}

/* ---- the vectorised form ---- */

static void many_lookups_are_the_same_bits_as_single_ones_on_every_instruction_set(void **state) {
    (void)state;
    enum { COUNT = 1000 };
    static float s[COUNT], t[COUNT], lod[COUNT], out[4][COUNT];
    uint64_t key = sl_random_key(11, 0);
    for (uint64_t i = 0; i < COUNT; i++) {
        s[i] = random_between(key, 3 * i, -2, 2);
        t[i] = random_between(key, 3 * i + 1, -2, 2);
        lod[i] = i % 200 < 100 ? random_between(key, 3 * i + 2, -3, 8) : -1.0f; /* whole blocks without blending too */
        if (i % 10 == 0) s[i] = odd_values[i / 10 % ODD];
        if (i % 10 == 1) t[i] = odd_values[i / 10 % ODD];
        if (i % 10 == 2) lod[i] = odd_values[i / 10 % ODD];
    }
    const char *isas[] = {"baseline", "avx2", "avx512"};
    for (int k = 0; k < 3 * 24; k++) {
        int mode = k % 24;
        sl_sampler sampler = {mode & 1, mode >> 1 & 1, 0, mode & 4, (sl_mip)(mode / 8)};
        assert_int_equal(setenv("SOFTLUX_ISA", isas[k / 24], 1), 0);
        sl_texture_image *image = random_image(k % 5 ? 61 : 64, 23, 12);
        unsetenv("SOFTLUX_ISA");
        image->texels[5] = INFINITY;
        image->texels[9] = -0.0f;
        float *const plane[4] = {out[0], out[1], k % 2 ? NULL : out[2], out[3]};
        size_t count = COUNT - (size_t)k;
        sl_texture_sample_many(image, sampler, count, s, t, k % 7 ? lod : NULL, plane);
        for (size_t i = 0; i < count; i++) {
            float rgba[4];
            sl_texture_sample(image, sampler, s[i], t[i], k % 7 ? lod[i] : 0.0f, rgba);
            for (int c = 0; c < 4; c++) {
                if (plane[c] && !(isnan(rgba[c]) && isnan(plane[c][i]))) assert_memory_equal(&rgba[c], &plane[c][i], sizeof(float));
            }
        }
        sl_texture_image_destroy(image);
    }
}

/* The same bits by every compiler: found once, never to change. */
static void lookups_have_their_golden_hash(void **state) {
    (void)state;
    const uint64_t golden = 0x24cb09d820ae9d87u;
    uint64_t hash = 0xcbf29ce484222325u, key = sl_random_key(40, 4);
    sl_texture_image *image = random_image(61, 23, 12);
    for (uint64_t i = 0; i < 20000; i++) {
        float rgba[4];
        sl_texture_sample(image, TRILINEAR, random_between(key, 3 * i, -3, 3), random_between(key, 3 * i + 1, -3, 3),
                          sl_texture_lod(61, 23, 0.1 * (double)sl_random_unit(key, 3 * i + 2), 0.01, 0.02, 0.03), rgba);
        for (int c = 0; c < 4; c++) {
            for (int bit = 0; bit < 32; bit += 8) hash = (hash ^ (sl_float_bits(rgba[c]) >> bit & 255)) * 0x100000001b3u;
        }
    }
    if (hash != golden) fail_msg("the hash is 0x%016llx", (unsigned long long)hash);
    sl_texture_image_destroy(image);
}

/* ---- the textured pass ---- */

/* A floor of two triangles seen in perspective, with a checkerboard of bytes repeated over it, and a wall without texture. */
static sl_scene *floor_scene(void) {
    enum { SIZE = 64 };
    static uint8_t bytes[4 * SIZE * SIZE];
    for (int i = 0; i < SIZE * SIZE; i++) {
        uint8_t value = (i % SIZE / 8 + i / SIZE / 8) % 2 ? 255 : 0;
        const uint8_t texel[4] = {value, (uint8_t)(255 - value), 100, 255};
        memcpy(bytes + 4 * i, texel, sizeof texel);
    }
    const float positions[] = {-10, 0, 0, 10, 0, 0, 10, 0, -40, -10, 0, -40, -10, 0, -40, 10, 0, -40, 10, 9, -40};
    const float uv[] = {0, 0, 8, 0, 8, 16, 0, 16, 0, 0, 1, 0, 1, 1};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 4, 5, 6}, material[] = {0, 0, 1};
    sl_texture texture = {.file = (char *)"checker", .width = SIZE, .height = SIZE, .texels = bytes};
    sl_material materials[2] = {
        {.diffuse = {0.5f, 0.25f, 1.0f}, .specular = {0.1f, 0.2f, 0.0f}, .texture = 0, .alpha_texture = SL_NO_INDEX},
        {.diffuse = {0.3f, 0.4f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX}};
    sl_scene_parts parts = {.vertex_count = 7, .positions = positions, .texture_coordinates = uv, .triangle_count = 3,
                            .indices = indices, .material_index = material, .material_count = 2, .materials = materials,
                            .texture_count = 1, .textures = &texture};
    sl_scene *scene = NULL;
    sl_error error;
    if (sl_scene_build(&parts, &scene, &error) != SL_OK) fail_msg("%s", error.message);
    return scene;
}

enum { WIDTH = 160, HEIGHT = 120, PIXELS = WIDTH * HEIGHT };

typedef struct shaded {
    uint32_t id[PIXELS];
    float plane[10][PIXELS];
    sl_counters counters;
} shaded;

static sl_view floor_view(void) {
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, sl_v3(0.5f, 2.0f, 3.0f), sl_v3(0, 1, -10), sl_v3(0.05f, 1, 0), 1.0f));
    return sl_view_camera(&camera, WIDTH, HEIGHT, 0.1f, 100.0f);
}

static shaded *shade(const sl_scene *scene, const char *isa, unsigned threads, sl_lod_rule rule, const sl_texture_image *single,
                     const float *coordinates) {
    if (isa) assert_int_equal(setenv("SOFTLUX_ISA", isa, 1), 0);
    shaded *p = calloc(1, sizeof *p);
    assert_non_null(p);
    sl_raster *raster = raster_of(scene);
    sl_view view = floor_view();
    render(raster, &view, threads, p->id, NULL);
    sl_texture_set *set = NULL;
    assert_int_equal(sl_texture_set_create(scene, threads, &set, NULL), SL_OK);
    sl_textured_pass pass = {set, single, coordinates, TRILINEAR, rule, 0.0f};
    sl_textured_planes out = {{p->plane[0], p->plane[1], p->plane[2], p->plane[3]}, {p->plane[4], p->plane[5], p->plane[6]},
                              p->plane[7], p->plane[8], p->plane[9]};
    sl_raster_textured(raster, &view, threads, p->id, &pass, &out, &p->counters);
    sl_texture_set_destroy(set);
    sl_raster_destroy(raster);
    unsetenv("SOFTLUX_ISA");
    return p;
}

/* The floor is y = 0 with s = (x + 10) / 2.5, t = -z / 2.5: where a ray through a place of the window meets it. */
static void floor_coordinates(const sl_view *view, double x, double y, double *s, double *t) {
    double a[3][3], rhs[2] = {x / WIDTH * 2 - 1, y / HEIGHT * 2 - 1};
    /* Rows: clip_x - nx clip_w = 0, clip_y - ny clip_w = 0, and q_y = -eye_y. */
    for (int k = 0; k < 2; k++) {
        for (int c = 0; c < 3; c++) a[k][c] = (double)view->clip[k][c] - rhs[k] * (double)view->clip[3][c];
    }
    double qy = -(double)view->origin.y, d = a[0][0] * a[1][2] - a[0][2] * a[1][0];
    double r0 = -a[0][1] * qy, r1 = -a[1][1] * qy;
    double qx = (r0 * a[1][2] - a[0][2] * r1) / d, qz = (a[0][0] * r1 - r0 * a[1][0]) / d;
    *s = (qx + (double)view->origin.x + 10.0) / 2.5;
    *t = -(qz + (double)view->origin.z) / 2.5;
}

static void coordinates_and_level_of_detail_of_a_floor_in_perspective_are_those_of_geometry(void **state) {
    shaded *p = shade(*state, NULL, 1, SL_LOD_EXACT, NULL, NULL);
    sl_view view = floor_view();
    int floor_pixels = 0, far_levels = 0;
    for (int i = 0; i < PIXELS; i++) {
        if (p->id[i] > 1) continue;
        double x = i % WIDTH + 0.5, y = i / WIDTH + 0.5, s, t, s1, t1, s2, t2, s3, t3, s4, t4;
        const double h = 1e-3;
        floor_coordinates(&view, x, y, &s, &t);
        floor_coordinates(&view, x + h, y, &s1, &t1);
        floor_coordinates(&view, x - h, y, &s2, &t2);
        floor_coordinates(&view, x, y + h, &s3, &t3);
        floor_coordinates(&view, x, y - h, &s4, &t4);
        double dx = hypot(s1 - s2, t1 - t2) / (2 * h), dy = hypot(s3 - s4, t3 - t4) / (2 * h);
        floor_pixels++;
        if (s > 0 && s < 8 && t > 0 && t < 16) { /* not moved to an edge */
            assert_near((double)p->plane[7][i], s, 2e-6);
            assert_near((double)p->plane[8][i], t, 4e-6);
        }
        double lod = log2(64 * (dx > dy ? dx : dy));
        far_levels += lod > 3.0;
        assert_near((double)p->plane[9][i], lod, 2e-5);
    }
    assert_true(floor_pixels > PIXELS / 4 && far_levels > 100);
    free(p);
}

static void differences_are_near_the_derivatives_and_one_for_each_quad(void **state) {
    shaded *exact = shade(*state, NULL, 1, SL_LOD_EXACT, NULL, NULL), *quads = shade(*state, NULL, 1, SL_LOD_DIFFERENCES, NULL, NULL);
    sl_view view = floor_view();
    bool differ = false;
    for (int y = 0; y < HEIGHT; y += 2) {
        for (int x = 0; x < WIDTH; x += 2) {
            int i = y * WIDTH + x;
            if (quads->id[i] > 1) continue;
            double s, t, s1, t1, s2, t2;
            floor_coordinates(&view, x + 0.5, y + 0.5, &s, &t);
            floor_coordinates(&view, x + 1.5, y + 0.5, &s1, &t1);
            floor_coordinates(&view, x + 0.5, y + 1.5, &s2, &t2);
            double dx = hypot(s1 - s, t1 - t), dy = hypot(s2 - s, t2 - t), lod = log2(64 * (dx > dy ? dx : dy));
            for (int k = 0; k < 4; k++) {
                int n = i + (k & 1) + (k >> 1) * WIDTH;
                if (quads->id[n] != quads->id[i]) continue;
                assert_near((double)quads->plane[9][n], lod, 2e-5);
                assert_near((double)exact->plane[9][n], lod, 0.6);
                differ |= fabsf(exact->plane[9][n] - quads->plane[9][n]) > 0.02f;
            }
        }
    }
    assert_true(differ);
    free(exact);
    free(quads);
}

static void colours_are_the_materials_times_the_filtered_texture(void **state) {
    const sl_scene *scene = *state;
    shaded *p = shade(scene, NULL, 1, SL_LOD_EXACT, NULL, NULL);
    sl_texture_image *image = NULL;
    assert_int_equal(sl_texture_image_of_texture(&scene->textures[0], 1, &image, NULL), SL_OK);
    uint64_t drawn = 0;
    int walls = 0;
    for (int i = 0; i < PIXELS; i++) {
        float rgba[4] = {0, 0, 0, 0}, kd[3] = {0, 0, 0}, ks[3] = {0, 0, 0};
        if (p->id[i] < 2) {
            sl_texture_sample(image, TRILINEAR, p->plane[7][i], p->plane[8][i], p->plane[9][i], rgba);
            memcpy(kd, (float[]){0.5f, 0.25f, 1.0f}, sizeof kd);
            memcpy(ks, (float[]){0.1f, 0.2f, 0.0f}, sizeof ks);
        } else if (p->id[i] == 2) {
            memcpy(rgba, (float[]){1, 1, 1, 1}, sizeof rgba);
            memcpy(kd, (float[]){0.3f, 0.4f, 0.5f}, sizeof kd);
            walls++;
        }
        for (int c = 0; c < 3; c++) {
            assert_true(p->plane[c][i] == kd[c] * rgba[c]);
            assert_true(p->plane[4 + c][i] == ks[c]);
        }
        assert_true(p->plane[3][i] == rgba[3]);
        drawn += p->id[i] != SL_NO_INDEX;
    }
    assert_true(walls > 10);
    assert_true(p->counters.value[SL_COUNT_FRAGMENTS_SHADED] == drawn);
    sl_texture_image_destroy(image);
    free(p);
}

static void an_atlas_replaces_textures_and_coordinates(void **state) {
    sl_texture_image *atlas = random_image(32, 32, 30);
    const float coordinates[18] = {0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1, 0.25f, 0.25f, 0.25f, 0.25f, 0.25f, 0.25f};
    shaded *p = shade(*state, NULL, 2, SL_LOD_EXACT, atlas, coordinates);
    for (int i = 0; i < PIXELS; i++) {
        if (p->id[i] == SL_NO_INDEX) continue;
        float rgba[4];
        sl_texture_sample(atlas, TRILINEAR, p->plane[7][i], p->plane[8][i], p->plane[9][i], rgba);
        for (int c = 0; c < 4; c++) assert_true(p->plane[c][i] == rgba[c]);
        if (p->id[i] == 2) assert_true(p->plane[7][i] == 0.25f && p->plane[8][i] == 0.25f && p->plane[9][i] == -63.0f);
    }
    free(p);
    sl_texture_image_destroy(atlas);
}

static void without_levels_of_detail_the_colours_are_those_of_the_finest_level(void **state) {
    const sl_scene *scene = *state;
    shaded *p = shade(scene, NULL, 1, SL_LOD_EXACT, NULL, NULL);
    static float red[PIXELS];
    sl_raster *raster = raster_of(scene);
    sl_texture_set *set = NULL;
    assert_int_equal(sl_texture_set_create(scene, 1, &set, NULL), SL_OK);
    sl_view view = floor_view();
    sl_textured_pass pass = {.set = set, .sampler = BILINEAR};
    sl_textured_planes out = {.color = {red}};
    sl_raster_textured(raster, &view, 1, p->id, &pass, &out, &p->counters);
    for (int i = 0; i < PIXELS; i++) {
        if (p->id[i] > 1) continue;
        float rgba[4];
        sl_texture_sample(sl_texture_set_image(set, 0), BILINEAR, p->plane[7][i], p->plane[8][i], 0.0f, rgba);
        assert_true(red[i] == 0.5f * rgba[0]);
    }
    assert_null(sl_texture_set_image(set, 1));
    assert_true(sl_texture_set_memory_bytes(set) == (64 * 64 * 4 - 1) / 3 * 16);
    sl_texture_set_destroy(set);
    sl_raster_destroy(raster);
    free(p);
}

static void the_textured_pass_has_the_same_bits_on_any_number_of_threads_and_instruction_set(void **state) {
    for (int rule = 0; rule < 2; rule++) {
        shaded *expected = shade(*state, NULL, 1, (sl_lod_rule)rule, NULL, NULL);
        for (int k = 0; k < 6; k++) {
            const char *isas[] = {NULL, NULL, NULL, "baseline", "avx2", "avx512"};
            shaded *p = shade(*state, isas[k], (unsigned)k + 2, (sl_lod_rule)rule, NULL, NULL);
            assert_memory_equal(p, expected, sizeof *p);
            free(p);
        }
        free(expected);
    }
}

static int set_up(void **state) { return (*state = floor_scene()) == NULL; }
static int tear_down(void **state) {
    sl_scene_destroy(*state);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_linear_ramp_is_reproduced_exactly_inside),
        cmocka_unit_test(a_texel_centre_gives_that_texel),
        cmocka_unit_test(repetition_blends_the_last_texel_with_the_first_and_clamping_does_not),
        cmocka_unit_test(any_coordinate_gives_a_texel_of_the_texture),
        cmocka_unit_test(the_result_is_exact_filtering_rounded_once),
        cmocka_unit_test(a_constant_texture_is_constant_at_any_level_of_detail),
        cmocka_unit_test(every_level_has_the_mean_of_the_picture_whatever_its_size),
        cmocka_unit_test(a_ramp_stays_where_it_is_in_every_level),
        cmocka_unit_test(the_level_read_follows_the_level_of_detail),
        cmocka_unit_test(the_level_of_detail_is_the_longer_axis_in_texels),
        cmocka_unit_test(a_file_texture_is_decoded_before_it_is_averaged),
        cmocka_unit_test(a_pbuffer_and_its_levels_hold_the_means_of_its_pixels),
        cmocka_unit_test(impossible_sizes_are_refused),
        cmocka_unit_test(many_lookups_are_the_same_bits_as_single_ones_on_every_instruction_set),
        cmocka_unit_test(lookups_have_their_golden_hash),
        cmocka_unit_test(coordinates_and_level_of_detail_of_a_floor_in_perspective_are_those_of_geometry),
        cmocka_unit_test(differences_are_near_the_derivatives_and_one_for_each_quad),
        cmocka_unit_test(colours_are_the_materials_times_the_filtered_texture),
        cmocka_unit_test(without_levels_of_detail_the_colours_are_those_of_the_finest_level),
        cmocka_unit_test(an_atlas_replaces_textures_and_coordinates),
        cmocka_unit_test(the_textured_pass_has_the_same_bits_on_any_number_of_threads_and_instruction_set),
    };
    return cmocka_run_group_tests_name("textures", tests, set_up, tear_down);
}
