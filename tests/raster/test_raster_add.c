/* Additive blending of interpolated values: against sums in double over each triangle's own pixels, and the same bits however the work
 * is cut. Coverage and the order of addition are held against OSMesa in test_osmesa_blending.c. */
#include <math.h>

#include "raster_support.h"

enum { WIDTH = 301, HEIGHT = 277, PIXELS = WIDTH * HEIGHT, CHANNELS = 3, TRIANGLES = 400 };

/* Triangles of every size in a box around the eye, so that many are cut; values at corners, the last channel's the same at all three. */
typedef struct field {
    float x[3 * TRIANGLES], y[3 * TRIANGLES], z[3 * TRIANGLES], value[3 * TRIANGLES * CHANNELS];
    uint32_t vertex[3][TRIANGLES];
    sl_raster_mesh mesh;
} field;

static field *field_create(uint64_t seed) {
    field *f = calloc(1, sizeof *f);
    assert_non_null(f);
    uint64_t key = sl_random_key(seed, 4);
    for (uint32_t t = 0; t < TRIANGLES; t++) {
        float centre[3], size = t % 4 ? 0.1f : 3.0f;
        for (uint32_t i = 0; i < 3; i++) centre[i] = random_between(key, 64 * t + i, -2.0f, 2.0f);
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t v = f->vertex[k][t] = 3 * t + k;
            f->x[v] = centre[0] + size * random_between(key, 64 * t + 8 + 3 * k, -1.0f, 1.0f);
            f->y[v] = centre[1] + size * random_between(key, 64 * t + 9 + 3 * k, -1.0f, 1.0f);
            f->z[v] = centre[2] + size * random_between(key, 64 * t + 10 + 3 * k, -1.0f, 1.0f);
            for (uint32_t c = 0; c < CHANNELS; c++) {
                f->value[v * CHANNELS + c] = random_between(key, 64 * t + 32 + (c + 1 < CHANNELS ? 3 * k + c : 30), 0.0f, 1.0f);
            }
        }
    }
    f->mesh = (sl_raster_mesh){3 * TRIANGLES, TRIANGLES, f->x, f->y, f->z, {f->vertex[0], f->vertex[1], f->vertex[2]}};
    return f;
}

static sl_raster *raster_of_mesh(const sl_raster_mesh *mesh) {
    sl_raster *raster = NULL;
    assert_int_equal(sl_raster_create_mesh(mesh, 1, &raster, NULL), SL_OK);
    return raster;
}

static sl_view perspective(void) {
    const sl_frame frame = {sl_v3(1, 0, 0), sl_v3(0, 0.8f, 0.6f), sl_v3(0, -0.6f, 0.8f)};
    return sl_view_pyramid(&frame, sl_v3(0.1f, -0.2f, -1.5f), -0.9f, 1.1f, -1.0f, 0.8f, WIDTH, HEIGHT, 0.05f);
}

static uint64_t add(const sl_raster *raster, const sl_view *view, unsigned threads, const float *value, float *planes) {
    sl_target size = {.width = WIDTH, .height = HEIGHT};
    sl_counters counters = {{0}};
    assert_int_equal(sl_raster_add(raster, view, threads, value, CHANNELS, &size, planes, &counters, NULL), SL_OK);
    return counters.value[SL_COUNT_FRAGMENTS_BLENDED];
}

/* Each triangle drawn alone, its values taken by barycentric weights and summed in double. Returns the fragments. */
static uint64_t sum_in_double(const field *f, const sl_view *view, double *sums, double *layers) {
    static uint32_t id[PIXELS], pixel[PIXELS];
    static float depth[PIXELS], w1[PIXELS], w2[PIXELS];
    uint64_t fragments = 0;
    for (uint32_t i = 0; i < PIXELS; i++) pixel[i] = i;
    for (uint32_t t = 0; t < TRIANGLES; t++) {
        const uint32_t corner[3] = {3 * t, 3 * t + 1, 3 * t + 2};
        const sl_raster_mesh alone = {3 * TRIANGLES, 1, f->x, f->y, f->z, {&corner[0], &corner[1], &corner[2]}};
        sl_raster *raster = raster_of_mesh(&alone);
        render(raster, view, 1, id, depth);
        sl_raster_barycentrics(raster, view, PIXELS, pixel, id, w1, w2);
        sl_raster_destroy(raster);
        if (t == view->skip_triangle) continue;
        for (uint32_t i = 0; i < PIXELS; i++) {
            if (id[i] == SL_NO_INDEX) continue;
            fragments++;
            layers[i] += 1.0;
            for (uint32_t c = 0; c < CHANNELS; c++) {
                const float *v = f->value + 3 * t * CHANNELS + c;
                sums[c * PIXELS + i] += (double)v[0] + (double)w1[i] * ((double)v[CHANNELS] - (double)v[0]) +
                                        (double)w2[i] * ((double)v[2 * CHANNELS] - (double)v[0]);
            }
        }
    }
    return fragments;
}

static void compare_with_double(sl_view view, double least_layers) {
    static double sums[CHANNELS * PIXELS], layers[PIXELS];
    static float planes[CHANNELS * PIXELS];
    field *f = field_create(11);
    sl_raster *raster = raster_of_mesh(&f->mesh);
    memset(sums, 0, sizeof sums), memset(layers, 0, sizeof layers), memset(planes, 0, sizeof planes);
    uint64_t expected = sum_in_double(f, &view, sums, layers);
    assert_int_equal(add(raster, &view, 1, f->value, planes), expected);
    assert_true((double)expected > least_layers * PIXELS);
    for (uint32_t i = 0; i < CHANNELS * PIXELS; i++) {
        /* A pixel's centre may lie a 512th of a pixel outside its triangle, where the two take different nearest points. */
        double tolerance = 1e-6 + (i < (CHANNELS - 1) * PIXELS ? 1e-4 : 1e-6) * layers[i % PIXELS];
        if (!(fabs((double)planes[i] - sums[i]) <= tolerance)) {
            fail_msg("channel %u, pixel (%u, %u): %.9g, not %.9g, of %g layers", i / PIXELS, i % PIXELS % WIDTH, i % PIXELS / WIDTH,
                     (double)planes[i], sums[i], layers[i % PIXELS]);
        }
    }
    sl_raster_destroy(raster);
    free(f);
}

static void sums_in_perspective_are_those_in_double(void **state) {
    (void)state;
    compare_with_double(perspective(), 2.0);
}

static void sums_without_perspective_are_those_in_double(void **state) {
    (void)state;
    sl_view view = flat_view(WIDTH, HEIGHT);
    for (int k = 0; k < 3; k++) view.clip[k][k] = 0.19f; /* all of it within */
    compare_with_double(view, 1.0);
}

static void skipped_triangle_is_not_added(void **state) {
    (void)state;
    sl_view view = perspective();
    view.skip_triangle = 8; /* a large one */
    compare_with_double(view, 2.0);
}

static void sums_keep_their_bits_at_any_number_of_threads_and_instruction_set(void **state) {
    (void)state;
    static float alone[CHANNELS * PIXELS], shared[CHANNELS * PIXELS];
    const char *isas[] = {"baseline", "avx2", "avx512"};
    field *f = field_create(12);
    sl_view view = perspective();
    for (unsigned n = 0; n < 6; n++) {
        setenv("SOFTLUX_ISA", isas[n % 3], 1);
        sl_raster *raster = raster_of_mesh(&f->mesh);
        memset(shared, 0, sizeof shared);
        add(raster, &view, n < 3 ? 1 : n, f->value, shared);
        if (n == 0) memcpy(alone, shared, sizeof alone);
        assert_memory_equal(alone, shared, sizeof alone);
        sl_raster_destroy(raster);
    }
    unsetenv("SOFTLUX_ISA");
    free(f);
}

/* Planes hold something already, which is kept outside the scissor and added to within. */
static void scissor_keeps_bits_within_and_pixels_without(void **state) {
    (void)state;
    static float whole[CHANNELS * PIXELS], cut[CHANNELS * PIXELS];
    const sl_scissor scissors[] = {{0, 0, WIDTH, HEIGHT}, {17, 33, 271, 262}, {255, 255, 257, 257}, {64, 32, 128, 64}, {5, 6, 6, 7}};
    field *f = field_create(13);
    sl_raster *raster = raster_of_mesh(&f->mesh);
    for (size_t n = 0; n < sizeof scissors / sizeof scissors[0]; n++) {
        const sl_scissor *s = &scissors[n];
        sl_view view = perspective();
        for (uint32_t i = 0; i < CHANNELS * PIXELS; i++) whole[i] = cut[i] = (float)(i % 1000);
        add(raster, &view, 1, f->value, whole);
        view.scissor = *s;
        add(raster, &view, 1, f->value, cut);
        for (uint32_t i = 0; i < CHANNELS * PIXELS; i++) {
            int x = (int)(i % PIXELS % WIDTH), y = (int)(i % PIXELS / WIDTH);
            bool within = x >= s->x0 && x < s->x1 && y >= s->y0 && y < s->y1;
            float expected = within ? whole[i] : (float)(i % 1000);
            if (memcmp(&cut[i], &expected, sizeof expected) != 0) {
                fail_msg("scissor %zu, pixel (%d, %d): %.9g, not %.9g", n, x, y, (double)cut[i], (double)expected);
            }
        }
    }
    sl_raster_destroy(raster);
    free(f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_in_perspective_are_those_in_double),
        cmocka_unit_test(sums_without_perspective_are_those_in_double),
        cmocka_unit_test(skipped_triangle_is_not_added),
        cmocka_unit_test(sums_keep_their_bits_at_any_number_of_threads_and_instruction_set),
        cmocka_unit_test(scissor_keeps_bits_within_and_pixels_without),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
