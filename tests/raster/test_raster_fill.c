/* Coverage: exact against a rasterizer in integers that knows nothing of blocks, lanes or clusters. */
#include "raster_support.h"

enum { MAX_PIXELS = 300 * 300 };

/* ---- the reference: rounding, edge functions and fill rule from their definitions ---- */

static int64_t snapped(float ndc, int size) {
    float window = fmaf(ndc, 0.5f * (float)size, 0.5f * (float)size);
    return (int64_t)lrintf((window - 0.5f) * 256.0f);
}

static bool owns(int64_t e, int64_t a, int64_t b) {
    return e > 0 || (e == 0 && (a > 0 || (a == 0 && b > 0)));
}

static bool reference_covers(const int64_t u[3], const int64_t v[3], int64_t px, int64_t py) {
    int64_t area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
    if (area == 0) return false;
    int64_t sign = area > 0 ? 1 : -1;
    for (int k = 0; k < 3; k++) {
        int p = (k + 1) % 3, q = (k + 2) % 3;
        int64_t a = (v[p] - v[q]) * sign, b = (u[q] - u[p]) * sign;
        if (!owns(a * (px - u[p]) + b * (py - v[p]), a, b)) return false;
    }
    return true;
}

/* Triangles of constant depth: nearest wins, then the lowest index. */
static void reference_render(const sl_scene *scene, int width, int height, uint32_t *id, float *nearest) {
    for (int i = 0; i < width * height; i++) {
        id[i] = SL_NO_INDEX;
        nearest[i] = 2.0f;
    }
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        int64_t u[3], v[3];
        float z = 0.0f;
        for (int k = 0; k < 3; k++) {
            sl_vec3 p = sl_scene_position(scene, scene->vertex[k][t]);
            u[k] = snapped(p.x, width);
            v[k] = snapped(p.y, height);
            z = p.z;
        }
        for (int y = 0; y < height; y++) {
            for (int x = 0; x < width; x++) {
                if (z < nearest[y * width + x] && reference_covers(u, v, 256 * x, 256 * y)) {
                    nearest[y * width + x] = z;
                    id[y * width + x] = t;
                }
            }
        }
    }
}

static void assert_same_as_reference(const float *xyz, size_t count, int width, int height) {
    static uint32_t expected[MAX_PIXELS], got[MAX_PIXELS];
    static float nearest[MAX_PIXELS], depth[MAX_PIXELS];
    sl_scene *scene = scene_of_triangles(xyz, count);
    sl_raster *raster = raster_of(scene);
    sl_view view = flat_view(width, height);
    reference_render(scene, width, height, expected, nearest);
    render(raster, &view, 1, got, depth);
    for (int i = 0; i < width * height; i++) {
        if (expected[i] != got[i])
            fail_msg("pixel %d,%d: %u, not %u", i % width, i / width, got[i], expected[i]);
    }
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

/* ---- random triangles of all kinds ---- */

typedef void make_triangle(uint64_t key, uint64_t t, int size, float xy[6]);

static void big(uint64_t key, uint64_t t, int size, float xy[6]) {
    (void)size;
    for (unsigned k = 0; k < 6; k++) xy[k] = random_between(key, 8 * t + k, -1.0f, 1.0f);
}

static void small(uint64_t key, uint64_t t, int size, float xy[6]) {
    float reach = 8.0f / (float)size;
    for (unsigned k = 0; k < 2; k++) {
        float centre = random_between(key, 8 * t + k, -1.0f + reach, 1.0f - reach);
        for (unsigned c = 0; c < 3; c++)
            xy[2 * c + k] = centre + random_between(key, 8 * t + 2 + 2 * c + k, -reach, reach);
    }
}

static void sliver(uint64_t key, uint64_t t, int size, float xy[6]) {
    big(key, t, size, xy);
    float s = sl_random_unit(key, 8 * t + 6), off = 0.5f / (float)size;
    xy[4] = xy[0] + s * (xy[2] - xy[0]);
    xy[5] = xy[1] + s * (xy[3] - xy[1]) + random_between(key, 8 * t + 7, -off, off);
    xy[5] = xy[5] < -1.0f ? -1.0f : xy[5] > 1.0f ? 1.0f : xy[5];
}

/* vertices exactly on pixel centres */
static void on_centres(uint64_t key, uint64_t t, int size, float xy[6]) {
    for (unsigned k = 0; k < 6; k++) {
        int pixel = (int)(sl_random_bits(key, 8 * t + k) % (uint32_t)size);
        xy[k] = (2.0f * (float)pixel + 1.0f) / (float)size - 1.0f;
    }
}

/* half way between two snapped positions */
static void on_ties(uint64_t key, uint64_t t, int size, float xy[6]) {
    for (unsigned k = 0; k < 6; k++) {
        int half = 2 * (int)(sl_random_bits(key, 8 * t + k) % (uint32_t)(size * 256)) + 1;
        xy[k] = (float)half / (float)(256 * size) - 1.0f;
    }
}

static void compare_kind(make_triangle *make, uint64_t key, int scenes, size_t count, int width, int height) {
    float *xyz = malloc(9 * count * sizeof *xyz);
    assert_non_null(xyz);
    for (int s = 0; s < scenes; s++) {
        for (size_t t = 0; t < count; t++) {
            float xy[6], z = random_between(key, 1000000007u + t + count * (size_t)s, -1.0f, 1.0f);
            make(key, t + count * (size_t)s, width, xy);
            for (size_t c = 0; c < 3; c++) {
                xyz[9 * t + 3 * c] = xy[2 * c];
                xyz[9 * t + 3 * c + 1] = xy[2 * c + 1];
                xyz[9 * t + 3 * c + 2] = z;
            }
        }
        assert_same_as_reference(xyz, count, width, height);
    }
    free(xyz);
}

static void random_triangles_cover_exactly_the_pixels_of_integer_arithmetic(void **state) {
    (void)state;
    uint64_t key = sl_random_key(1, 0);
    compare_kind(big, key, 40, 100, 64, 64);
    compare_kind(big, key, 10, 50, 290, 170);
    compare_kind(big, key, 20, 100, 37, 51);
    compare_kind(small, key, 110, 800, 64, 64);
    compare_kind(small, key, 10, 200, 256, 256);
    compare_kind(sliver, key, 20, 200, 64, 64);
    compare_kind(sliver, key, 5, 100, 200, 200);
}

static void vertices_on_pixel_centres_follow_the_fill_rule(void **state) {
    (void)state;
    compare_kind(on_centres, sl_random_key(2, 0), 40, 100, 32, 32);
    compare_kind(on_centres, sl_random_key(2, 1), 10, 100, 128, 128);
}

static void snapping_ties_round_to_even(void **state) {
    (void)state;
    compare_kind(on_ties, sl_random_key(3, 0), 40, 100, 64, 64);
}

/* ---- shared edges ---- */

/* Draws triangles that must not overlap, twice, with rising and with falling depths: a pixel that two
 * triangles claim would go to different ones. Returns how many pixels are covered. */
static size_t covered_exactly_once(float *xyz, size_t count, int width, int height) {
    static uint32_t id[2][MAX_PIXELS];
    static float depth[MAX_PIXELS];
    sl_view view = flat_view(width, height);
    for (int turn = 0; turn < 2; turn++) {
        for (size_t t = 0; t < count; t++) {
            float z = ((float)t + 0.5f) / (float)count * 1.8f - 0.9f;
            for (size_t c = 0; c < 3; c++) xyz[9 * t + 3 * c + 2] = turn ? -z : z;
        }
        sl_scene *scene = scene_of_triangles(xyz, count);
        assert_int_equal(scene->triangle_count, count);
        sl_raster *raster = raster_of(scene);
        render(raster, &view, 1, id[turn], depth);
        sl_raster_destroy(raster);
        sl_scene_destroy(scene);
    }
    assert_memory_equal(id[0], id[1], sizeof(uint32_t) * (size_t)width * (size_t)height);
    size_t covered = 0;
    for (int i = 0; i < width * height; i++) covered += id[0][i] != SL_NO_INDEX;
    return covered;
}

static void shared_edge_is_drawn_once(void **state) {
    (void)state;
    enum { GRID = 24, SIZE = 96 };
    static float vertex[GRID + 1][GRID + 1][2], xyz[GRID * GRID * 2 * 9];
    for (uint64_t seed = 0; seed < 10; seed++) {
        uint64_t key = sl_random_key(4, seed);
        for (int j = 0; j <= GRID; j++) {
            for (int i = 0; i <= GRID; i++) {
                uint64_t n = (uint64_t)(j * (GRID + 1) + i) * 2;
                float x = (float)i, y = (float)j;
                if (i > 0 && i < GRID) x += random_between(key, n, -0.2f, 0.2f);
                if (j > 0 && j < GRID) y += random_between(key, n + 1, -0.2f, 0.2f);
                vertex[j][i][0] = 2.0f * x / GRID - 1.0f;
                vertex[j][i][1] = 2.0f * y / GRID - 1.0f;
            }
        }
        size_t at = 0;
        for (int j = 0; j < GRID; j++) {
            for (int i = 0; i < GRID; i++) {
                const float *quad[4] = {vertex[j][i], vertex[j][i + 1], vertex[j + 1][i + 1],
                                        vertex[j + 1][i]};
                const int corner[6] = {0, 1, 2, 0, 2, 3};
                for (int c = 0; c < 6; c++, at += 3) memcpy(&xyz[at], quad[corner[c]], 2 * sizeof(float));
            }
        }
        assert_int_equal(covered_exactly_once(xyz, GRID * GRID * 2, SIZE, SIZE), SIZE * SIZE);
    }
}

static void fan_around_a_pixel_centre_covers_it_once(void **state) {
    (void)state;
    enum { SIZE = 32 };
    const int spokes[] = {3, 4, 5, 8, 16, 33};
    for (size_t s = 0; s < sizeof spokes / sizeof *spokes; s++) {
        float xyz[33 * 9] = {0},
                       centre[2] = {(2.0f * 13.0f + 1.0f) / SIZE - 1.0f, (2.0f * 17.0f + 1.0f) / SIZE - 1.0f};
        for (int k = 0; k < spokes[s]; k++) {
            memcpy(&xyz[9 * k], centre, sizeof centre);
            for (int c = 0; c < 2; c++) {
                double angle = 6.283185307179586 * (double)((k + c) % spokes[s]) / (double)spokes[s];
                xyz[9 * k + 3 * (c + 1)] = centre[0] + 0.3f * (float)cos(angle);
                xyz[9 * k + 3 * (c + 1) + 1] = centre[1] + 0.3f * (float)sin(angle);
            }
        }
        assert_true(covered_exactly_once(xyz, (size_t)spokes[s], SIZE, SIZE) > 20);
    }
}

/* ---- rules spelt out ---- */

static size_t pixels_of(const float xyz[9], int size, uint32_t *id) {
    static float depth[MAX_PIXELS];
    sl_scene *scene = scene_of_triangles(xyz, 1);
    sl_raster *raster = raster_of(scene);
    sl_view view = flat_view(size, size);
    render(raster, &view, 1, id, depth);
    size_t covered = 0;
    for (int i = 0; i < size * size; i++) covered += id[i] == 0;
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
    return covered;
}

static void left_and_lowest_edges_own_their_points(void **state) {
    (void)state;
    enum { SIZE = 8 };
    uint32_t id[SIZE * SIZE];
    /* Right angle at pixel (1,1)'s centre, legs of 4 pixels along x and y. */
    float low = (2.0f * 1.0f + 1.0f) / SIZE - 1.0f, high = (2.0f * 5.0f + 1.0f) / SIZE - 1.0f;
    assert_int_equal(pixels_of((const float[9]){low, low, 0, high, low, 0, low, high, 0}, SIZE, id), 10);
    /* left and lowest edges are in, the slanted right edge x + y = 6 is out */
    for (int y = 0; y < SIZE; y++) {
        for (int x = 0; x < SIZE; x++) assert_int_equal(id[y * SIZE + x] == 0, x >= 1 && y >= 1 && x + y < 6);
    }
    /* The other half of the square owns the slanted edge, and not its right and top edges. */
    assert_int_equal(pixels_of((const float[9]){high, low, 0, high, high, 0, low, high, 0}, SIZE, id), 6);
    for (int y = 0; y < SIZE; y++) {
        for (int x = 0; x < SIZE; x++) assert_int_equal(id[y * SIZE + x] == 0, x < 5 && y < 5 && x + y >= 6);
    }
}

static void triangle_between_pixel_centres_covers_nothing(void **state) {
    (void)state;
    uint32_t id[64];
    assert_int_equal(pixels_of((const float[9]){0.01f, 0.01f, 0, 0.11f, 0.01f, 0, 0.01f, 0.11f, 0}, 8, id),
                     0);
    assert_int_equal(pixels_of((const float[9]){0.01f, 0.01f, 0, 0.24f, 0.13f, 0, 0.01f, 0.24f, 0}, 8, id),
                     1);
}

static void huge_triangle_fills_the_screen(void **state) {
    (void)state;
    static uint32_t id[MAX_PIXELS];
    const float scales[] = {3.0f, 1e3f, 1e6f, 1e12f};
    for (size_t k = 0; k < 4; k++) {
        float s = scales[k];
        assert_int_equal(pixels_of((const float[9]){-s, -s, 0, 3 * s, -s, 0, -s, 3 * s, 0}, 200, id),
                         200 * 200);
    }
}

static void largest_target_is_covered_to_its_corners(void **state) {
    (void)state;
    enum { WIDTH = 16384, HEIGHT = 3 };
    const float xyz[18] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0.5f, 1, 1, 0.5f, -1, 1, 0.5f};
    sl_scene *scene = scene_of_triangles(xyz, 2);
    sl_raster *raster = raster_of(scene);
    sl_view view = flat_view(WIDTH, HEIGHT);
    uint32_t *id = malloc(sizeof *id * WIDTH * HEIGHT);
    assert_non_null(id);
    render(raster, &view, 2, id, NULL);
    for (int i = 0; i < WIDTH * HEIGHT; i++) assert_true(id[i] != SL_NO_INDEX);
    assert_int_equal(id[WIDTH - 1], 0);
    assert_int_equal(id[WIDTH * (HEIGHT - 1)], 1);
    view.width = WIDTH + 1;
    sl_target target = {view.width, HEIGHT, id, NULL};
    sl_counters counters = {{0}};
    sl_error error;
    assert_int_equal(sl_raster_id(raster, &view, 1, &target, &counters, &error), SL_ERROR_USAGE);
    free(id);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_triangles_cover_exactly_the_pixels_of_integer_arithmetic),
        cmocka_unit_test(vertices_on_pixel_centres_follow_the_fill_rule),
        cmocka_unit_test(snapping_ties_round_to_even),
        cmocka_unit_test(shared_edge_is_drawn_once),
        cmocka_unit_test(fan_around_a_pixel_centre_covers_it_once),
        cmocka_unit_test(left_and_lowest_edges_own_their_points),
        cmocka_unit_test(triangle_between_pixel_centres_covers_nothing),
        cmocka_unit_test(huge_triangle_fills_the_screen),
        cmocka_unit_test(largest_target_is_covered_to_its_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
