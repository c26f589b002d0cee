/* Cube maps: faces, seams, MIP chains, lookups by direction. */
#include "raster_support.h"
#include "raster/textures/textures.h"

static sl_cube_map *random_cube(int size, uint64_t seed) {
    sl_cube_map *cube = NULL;
    assert_int_equal(sl_cube_map_create(size, true, &cube, NULL), SL_OK);
    uint64_t key = sl_random_key(seed, 1), n = 0;
    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < size * size; i++) {
            float *texel = sl_cube_map_texel(cube, 0, face, i % size, i / size);
            for (int c = 0; c < 4; c++) texel[c] = sl_random_unit(key, n++);
        }
    }
    sl_cube_map_build(cube, 1);
    return cube;
}

/* The direction of place (s, t), both in [-1,1], of a face. */
static sl_vec3 on_face(int face, float s, float t) {
    sl_frame f = sl_cube_face_frame(face);
    return sl_add(sl_add(sl_scale(f.x, s), sl_scale(f.y, t)), f.z);
}

static void assert_near(double a, double b, double tolerance) {
    if (!(fabs(a - b) <= tolerance)) fail_msg("%.9g is not %.9g within %.3g", a, b, tolerance);
}

static void sample(const sl_cube_map *cube, sl_vec3 d, float lod, float rgba[4]) {
    sl_cube_map_sample_many(cube, 1, &d.x, &d.y, &d.z, &lod,
                            (float *const[4]){&rgba[0], &rgba[1], &rgba[2], &rgba[3]});
}

static void a_texels_own_direction_gives_that_texel_on_every_face(void **state) {
    (void)state;
    sl_cube_map *cube = random_cube(8, 1);
    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < 64; i++) {
            float rgba[4];
            sl_vec3 d = sl_scale(
                on_face(face, ((float)(i % 8) + 0.5f) / 4 - 1, ((float)(i / 8) + 0.5f) / 4 - 1), 3.0f);
            sample(cube, d, 0.0f, rgba);
            assert_memory_equal(rgba, sl_cube_map_texel(cube, 0, face, i % 8, i / 8), sizeof rgba);
        }
    }
    sl_cube_map_destroy(cube);
}

/* Walks across all twelve edges and around all eight corners: a step of length e may change the result by no
 * more than its slope (texels differ by at most 1, so 3 size e), and on the edge itself both faces agree. */
static void lookups_are_continuous_over_edges_and_corners(void **state) {
    (void)state;
    for (int size = 1; size <= 9; size += 4) {
        sl_cube_map *cube = random_cube(size, (uint64_t)size);
        uint64_t key = sl_random_key(21, (uint64_t)size);
        for (uint64_t i = 0; i < 60000; i++) {
            const float e = 1e-6f;
            int face = (int)(i % 6);
            /* Near an edge; one in three near a corner, where three faces meet. */
            float along = random_between(key, 2 * i, -1, 1), sign = i & 8 ? 1.0f : -1.0f;
            float across = sign * (1.0f + (i % 3 ? 0.0f : random_between(key, 2 * i + 1, -e, e)));
            if (i % 3 == 2) along = i & 16 ? 1.0f - e / 2 : -1.0f + e / 2;
            float inner[4], outer[4], lod = i & 32 ? 0.5f * (float)(cube->levels - 1) : 0.0f;
            sl_vec3 d1 =
                i & 4 ? on_face(face, across * (1 - e), along) : on_face(face, along, across * (1 - e));
            sl_vec3 d2 =
                i & 4 ? on_face(face, across * (1 + e), along) : on_face(face, along, across * (1 + e));
            sample(cube, d1, lod, inner);
            sample(cube, d2, lod, outer);
            for (int c = 0; c < 4; c++)
                assert_near((double)inner[c], (double)outer[c], 6.0 * (double)e * size + 2e-7);
        }
        sl_cube_map_destroy(cube);
    }
}

static void any_direction_gives_a_defined_colour(void **state) {
    (void)state;
    sl_cube_map *cube = random_cube(5, 8);
    const float values[] = {0.0f,  -0.0f,    1.0f,    -1.0f,    1e-45f,    -1e-45f,
                            1e30f, -3.4e38f, 3.4e38f, INFINITY, -INFINITY, NAN};
    for (int i = 0; i < 12 * 12 * 12 * 2; i++) {
        float rgba[4];
        sample(cube, sl_v3(values[i / 2 % 12], values[i / 24 % 12], values[i / 288]),
                           i & 1 ? 0.7f : 0.0f, rgba);
        for (int c = 0; c < 4; c++) assert_true(rgba[c] >= 0.0f && rgba[c] <= 1.0f);
    }
    float zero[4], middle[4], infinite[4], diagonal[4];
    sample(cube, sl_v3(0, 0, 0), 0.0f, zero);
    sample(cube, sl_v3(1, 0, NAN), 0.0f, middle);
    assert_memory_equal(zero, middle, sizeof zero);
    sample(cube, sl_v3(-INFINITY, INFINITY, 1), 0.0f, infinite);
    sample(cube, sl_v3(-1, 1, 0), 0.0f, diagonal);
    for (int c = 0; c < 4; c++) assert_near((double)infinite[c], (double)diagonal[c], 1e-6);
    sl_cube_map_destroy(cube);
}

static void lookups_have_the_same_bits_on_every_instruction_set(void **state) {
    (void)state;
    enum { COUNT = 1500 };
    static float x[COUNT], y[COUNT], z[COUNT], lod[COUNT], out[3][4][COUNT];
    const float values[] = {0.0f, -0.0f, 1.0f, -1.0f, 1e-45f, 1e30f, -3.4e38f, INFINITY, -INFINITY, NAN};
    uint64_t key = sl_random_key(19, 0);
    for (uint64_t i = 0; i < COUNT; i++) {
        x[i] = i % 5 ? random_between(key, 4 * i, -1, 1) : values[i / 5 % 10];
        y[i] = i % 7 ? random_between(key, 4 * i + 1, -1, 1) : values[i / 7 % 10];
        z[i] = i % 11 ? random_between(key, 4 * i + 2, -1, 1) : i % 2 ? x[i] : values[i / 11 % 10];
        lod[i] = i % 13 ? random_between(key, 4 * i + 3, -3, 6) : values[i / 13 % 10];
    }
    const char *isas[] = {"baseline", "avx2", "avx512"};
    for (int k = 0; k < 3; k++) {
        assert_int_equal(setenv("SOFTLUX_ISA", isas[k], 1), 0);
        sl_cube_map *cube = random_cube(21, 4);
        unsetenv("SOFTLUX_ISA");
        sl_cube_map_sample_many(cube, COUNT, x, y, z, lod,
                                (float *const[4]){out[k][0], out[k][1], out[k][2], out[k][3]});
        assert_memory_equal(out[k], out[0], sizeof out[0]);
        sl_cube_map_destroy(cube);
    }
}

static void impossible_sizes_are_refused(void **state) {
    (void)state;
    sl_cube_map *cube;
    assert_int_equal(sl_cube_map_create(0, true, &cube, NULL), SL_ERROR_USAGE);
    assert_int_equal(sl_cube_map_create(8193, true, &cube, NULL), SL_ERROR_USAGE);
    assert_null(cube);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_texels_own_direction_gives_that_texel_on_every_face),
        cmocka_unit_test(lookups_are_continuous_over_edges_and_corners),
        cmocka_unit_test(any_direction_gives_a_defined_colour),
        cmocka_unit_test(lookups_have_the_same_bits_on_every_instruction_set),
        cmocka_unit_test(impossible_sizes_are_refused),
    };
    return cmocka_run_group_tests_name("cube maps", tests, NULL, NULL);
}
