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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_triangles_cover_exactly_the_pixels_of_integer_arithmetic),
        cmocka_unit_test(vertices_on_pixel_centres_follow_the_fill_rule),
        cmocka_unit_test(snapping_ties_round_to_even),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
