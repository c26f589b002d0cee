/* Splats: bounds of spheres, order of blending, reduction. */
#include "raster_support.h"

#include <math.h>

/* ---- bounds ---- */

/* Tells whether a ray through a point of the screen meets the part of the sphere beyond the near plane. */
/* d.z = 1, camera space, z forward */
static bool ray_meets_sphere(sl_vec3d d, sl_vec3d c, double r, double near) {
    double a = sl_dotd(d, d), b = sl_dotd(d, c), k = sl_dotd(c, c) - r * r, disc = b * b - a * k;
    if (disc < 0.0) return false;
    /* the ball's farther hit lies beyond the near plane, so the near section is met or passed */
    return (b + sqrt(disc)) / a >= near;
}

static void check_sphere(const sl_camera *camera, int width, int height, float near, sl_vec3 centre,
                         float radius, uint64_t key, size_t *loose) {
    sl_splat_rect rect = sl_sphere_bounds(camera, width, height, near, centre, radius);
    assert_true(rect.x0 >= 0 && rect.y0 >= 0 && rect.x1 <= width && rect.y1 <= height);
    double tan_y = tan(0.5 * (double)camera->vertical_fov), tan_x = tan_y * width / height;
    sl_vec3d q = sl_subd(sl_to_double(centre), sl_to_double(camera->eye));
    sl_vec3d c = sl_v3d(sl_dotd(sl_to_double(camera->right), q), sl_dotd(sl_to_double(camera->up), q),
                        -sl_dotd(sl_to_double(camera->back), q));
    /* Points on the sphere, projected: each that lies beyond near and on the screen must be inside the
     * bounds. */
    int inner_x0 = width, inner_x1 = 0;
    for (uint64_t i = 0; i < 24; i++) {
        sl_vec3d p = sl_addd(c, sl_scaled(sl_to_double(random_direction(key, i)), (double)radius * 0.999999));
        if (p.z < (double)near) continue;
        double x = (p.x / p.z / tan_x + 1.0) * 0.5 * width, y = (p.y / p.z / tan_y + 1.0) * 0.5 * height;
        if (x < 0.0 || y < 0.0 || x >= width || y >= height) continue;
        assert_true(x >= rect.x0 && x <= rect.x1 && y >= rect.y0 && y <= rect.y1);
        inner_x0 = (int)x < inner_x0 ? (int)x : inner_x0;
        inner_x1 = (int)x > inner_x1 ? (int)x : inner_x1;
    }
    /* Pixel centres just outside the bounds must not see the sphere. */
    for (uint64_t i = 0; i < 8; i++) {
        double x = (double)sl_random_unit(key, 5000 + 2 * i) * width,
               y = (double)sl_random_unit(key, 5001 + 2 * i) * height;
        if (i < 2 && rect.x0 < rect.x1) x = i ? rect.x1 + 0.01 : rect.x0 - 0.01;
        if (x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1) continue;
        if (x < 0.0 || x >= width) continue;
        sl_vec3d d = sl_v3d((2.0 * x / width - 1.0) * tan_x, (2.0 * y / height - 1.0) * tan_y, 1.0);
        assert_false(ray_meets_sphere(d, c, (double)radius, (double)near));
    }
    *loose += rect.x0 < rect.x1 && rect.x1 - rect.x0 < width;
}

static void bounds_are_never_smaller_than_the_sphere(void **state) {
    sl_camera camera;
    size_t useful = 0;
    for (uint64_t i = 0; i < 100000; i++) {
        uint64_t key = sl_random_key(12, i);
        if (i % 100 == 0) {
            sl_vec3 eye = sl_v3(random_between(key, 1, -3, 3), random_between(key, 2, -3, 3),
                                random_between(key, 3, -3, 3));
            assert_true(sl_camera_look_at(&camera, eye, sl_add(eye, random_direction(key, 40)),
                                          sl_v3(0, 1, 0), random_between(key, 4, 0.2f, 2.8f)));
        }
        /* many near the eye and across the near plane */
        float reach = random_between(key, 5, 0, 1) < 0.3f ? 0.5f : 8.0f;
        sl_vec3 centre = sl_mad(camera.eye, random_between(key, 6, 0, reach), random_direction(key, 41));
        check_sphere(&camera, 320, 200, 0.1f, centre, random_between(key, 7, 0.001f, 1.0f), key, &useful);
    }
    assert_true(useful > 10000); /* not the whole screen every time */
}

static void camera_inside_or_sphere_behind(void **state) {
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, sl_v3(1, 2, 3), sl_v3(0, 0, 0), sl_v3(0, 1, 0), 1.0f));
    sl_splat_rect r = sl_sphere_bounds(&camera, 64, 48, 0.1f, sl_v3(1, 2, 3.2f), 0.5f);
    assert_true(r.x0 == 0 && r.y0 == 0 && r.x1 == 64 && r.y1 == 48);
    r = sl_sphere_bounds(&camera, 64, 48, 0.1f, sl_mad(sl_v3(1, 2, 3), 4, camera.back), 1.0f);
    assert_true(r.x0 >= r.x1 || r.y0 >= r.y1);
    r = sl_sphere_bounds(&camera, 64, 48, 0.1f, sl_v3(NAN, 2, 3), 1.0f);
    assert_true(r.x0 == 0 && r.x1 == 64);
    r = sl_sphere_bounds(&camera, 64, 48, 0.1f, sl_mad(camera.eye, 1e-3f, camera.right), 0.0f);
    assert_true(r.x0 >= r.x1 || r.y0 >= r.y1); /* a point beside the eye, before the near plane */
}

/* ---- blending ---- */

enum { WIDTH = 333, HEIGHT = 217, SPLATS = 3000 };

typedef struct canvas {
    float plane[WIDTH * HEIGHT];
} canvas;

static uint64_t add_values(void *context, const sl_splat_tile *tile, size_t index, sl_splat_rect rect) {
    canvas *c = context;
    uint64_t blended = 0;
    for (int y = rect.y0; y < rect.y1; y++) {
        for (int x = rect.x0; x < rect.x1; x++) {
            if ((x + y + (int)index) % 5 == 0) continue;
            c->plane[y * WIDTH + x] += 1.0f / (1.0f + (float)index) + 1e-3f * (float)((x * 7 + y * 3) % 11);
            blended++;
        }
    }
    return blended;
}

static const sl_splat_program add_program = {.shade = add_values};

static void make_rects(sl_splat_rect *rects) {
    uint64_t key = sl_random_key(13, 0);
    for (uint64_t i = 0; i < SPLATS; i++) {
        int x = (int)random_between(key, 4 * i, -40, WIDTH + 10),
            y = (int)random_between(key, 4 * i + 1, -40, HEIGHT + 10);
        int w = (int)random_between(key, 4 * i + 2, -3, 70), h = (int)random_between(key, 4 * i + 3, -3, 70);
        rects[i] = (sl_splat_rect){x, y, x + w, y + h};
    }
    rects[7] = (sl_splat_rect){-1000000, -1000000, 1000000, 1000000};
}

static sl_splat_rect on_target(sl_splat_rect r) {
    return (sl_splat_rect){r.x0 > 0 ? r.x0 : 0, r.y0 > 0 ? r.y0 : 0, r.x1 < WIDTH ? r.x1 : WIDTH,
                           r.y1 < HEIGHT ? r.y1 : HEIGHT};
}

static void tiles_blend_in_index_order_bit_for_bit(void **state) {
    static sl_splat_rect rects[SPLATS];
    static canvas expected, got;
    make_rects(rects);
    uint64_t blended = 0;
    memset(&expected, 0, sizeof expected);
    for (size_t i = 0; i < SPLATS; i++) blended += add_values(&expected, NULL, i, on_target(rects[i]));
    const unsigned threads[5] = {1, 2, 3, 7, 0};
    for (int k = 0; k < 5; k++) {
        sl_counters counters = {{0}};
        memset(&got, 0, sizeof got);
        assert_int_equal(
            sl_raster_splats(WIDTH, HEIGHT, SPLATS, rects, &add_program, &got, threads[k], &counters, NULL),
            SL_OK);
        assert_memory_equal(got.plane, expected.plane, sizeof got.plane);
        assert_int_equal(counters.value[SL_COUNT_FRAGMENTS_BLENDED], blended);
        assert_int_equal(counters.value[SL_COUNT_SPLATS], SPLATS);
    }
}

/* ---- reduction ---- */

enum { CHANNELS = 4 };

static bool same_floats(const float *a, const float *b, size_t count) { /* all NaNs alike */
    for (size_t i = 0; i < count; i++) {
        if (memcmp(&a[i], &b[i], sizeof *a) != 0 && !(isnan(a[i]) && isnan(b[i]))) return false;
    }
    return true;
}

/* The hardware's way: the whole picture halved, then the half, and so on, between two pbuffers. */
static void ping_pong(const float *plane, int size, int final, float *out) {
    static float pbuffer[2][256 * 256];
    memcpy(pbuffer[0], plane, (size_t)(size * size) * sizeof *plane);
    int now = 0;
    for (; size > final; size /= 2, now = 1 - now) {
        for (int y = 0; y < size / 2; y++) {
            for (int x = 0; x < size / 2; x++) {
                const float *low = &pbuffer[now][2 * y * size + 2 * x], *high = low + size;
                pbuffer[1 - now][y * (size / 2) + x] = (low[0] + low[1]) + (high[0] + high[1]);
            }
        }
    }
    memcpy(out, pbuffer[now], (size_t)(final * final) * sizeof *out);
}

static void reduction_has_the_bits_of_ping_pong_halving(void **state) {
    enum { SIZE = 256 };
    static float planes[CHANNELS * SIZE * SIZE], scratch[SIZE * SIZE / 2 + 1], out[CHANNELS * SIZE * SIZE],
        expected[SIZE * SIZE];
    uint64_t key = sl_random_key(15, 0);
    for (uint64_t i = 0; i < CHANNELS * SIZE * SIZE; i++)
        planes[i] = random_between(key, i, -1, 1) * (i % 5 ? 1.0f : 1e6f);
    const float special[4] = {INFINITY, -INFINITY, NAN, 3e38f};
    /* in the last plane of the full size alone */
    for (size_t i = 0; i < 4; i++) planes[3 * SIZE * SIZE + 1000 * i] = special[i];
    for (int size = 1; size <= SIZE; size *= 2) {
        for (int final = 1; final <= size; final *= 2) {
            for (int channels = 1; channels <= CHANNELS; channels++) {
                sl_counters counters = {{0}};
                scratch[size * size / 2] = 42.0f;
                sl_raster_reduce(planes, size, channels, final, scratch, out, &counters);
                assert_true(scratch[size * size / 2] == 42.0f || size == 1);
                for (int c = 0; c < channels; c++) {
                    ping_pong(planes + c * size * size, size, final, expected);
                    assert_true(same_floats(out + c * final * final, expected, (size_t)(final * final)));
                }
                assert_int_equal(counters.value[SL_COUNT_BYTES_READ_BACK], channels * final * final * 4);
                assert_int_equal(counters.value[SL_COUNT_FRAGMENTS_SHADED],
                                 (size * size - final * final) / 3);
            }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_are_never_smaller_than_the_sphere),
        cmocka_unit_test(camera_inside_or_sphere_behind),
        cmocka_unit_test(tiles_blend_in_index_order_bit_for_bit),
        cmocka_unit_test(reduction_has_the_bits_of_ping_pong_halving),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
