/* The fast path against its plain opposite: the same ids and the same depths, bit by bit, whatever is drawn.
 */
#include "base/math.h"
#include "raster/plain.h"
#include "raster_support.h"

enum { MAX_SIZE = 330, MAX_PIXELS = MAX_SIZE * MAX_SIZE, UNTOUCHED = 123456789 };

static uint32_t fast_id[MAX_PIXELS], plain_id[MAX_PIXELS];
static float fast_depth[MAX_PIXELS], plain_depth[MAX_PIXELS];

/* ---- comparison ---- */

static void fill(uint32_t *id, float *depth) {
    for (int i = 0; i < MAX_PIXELS; i++) {
        id[i] = UNTOUCHED;
        depth[i] = -3.0f;
    }
}

static void assert_same_planes(const char *which, int width, int height) {
    for (int i = 0; i < width * height; i++) {
        if (fast_id[i] == plain_id[i] && memcmp(&fast_depth[i], &plain_depth[i], 4) == 0) continue;
        fail_msg("%s, pixel %d,%d: %u at %.9g, not %u at %.9g", which, i % width, i / width, fast_id[i],
                 (double)fast_depth[i], plain_id[i], (double)plain_depth[i]);
    }
}

/* Returns how many pixels show something. */
static int assert_same(const sl_raster *raster, const sl_raster_mesh *mesh, const sl_scene *masks,
                       const sl_view *view, int width, int height) {
    assert_true(width <= MAX_SIZE && height <= MAX_SIZE);
    sl_target plain = {width, height, plain_id, plain_depth}, fast = {width, height, fast_id, fast_depth};
    sl_counters counters = {{0}};
    fill(plain_id, plain_depth);
    sl_plain_id(mesh, masks, view, &plain);
    for (unsigned threads = 1; threads <= 2; threads++) {
        fill(fast_id, fast_depth);
        assert_int_equal(sl_raster_id(raster, view, threads, &fast, &counters, NULL), SL_OK);
        assert_same_planes(threads == 1 ? "one thread" : "two threads", width, height);
    }
    sl_raster_scratch *scratch = NULL;
    assert_int_equal(sl_raster_scratch_create(raster, width, height, &scratch, NULL), SL_OK);
    fill(fast_id, fast_depth);
    sl_raster_id_small(raster, view, &fast, scratch, &counters);
    sl_raster_scratch_destroy(scratch);
    assert_same_planes("small", width, height);
    int seen = 0;
    for (int i = 0; i < width * height; i++) seen += plain_id[i] != SL_NO_INDEX && plain_id[i] != UNTOUCHED;
    return seen;
}

/* ---- meshes of triangles of their own ---- */

typedef struct {
    size_t count;
    float *x, *y, *z;
    uint32_t *vertex[3];
    sl_raster_mesh mesh;
    sl_raster *raster;
} soup;

static soup soup_of(size_t count) {
    soup s = {.count = count, .x = malloc(12 * count), .y = malloc(12 * count), .z = malloc(12 * count)};
    for (int k = 0; k < 3; k++) {
        s.vertex[k] = malloc(4 * count);
        assert_non_null(s.vertex[k]);
        for (uint32_t t = 0; t < count; t++) s.vertex[k][t] = 3 * t + (uint32_t)k;
    }
    assert_true(s.x && s.y && s.z);
    s.mesh = (sl_raster_mesh){3 * count, count, s.x, s.y, s.z, {s.vertex[0], s.vertex[1], s.vertex[2]}};
    return s;
}

static void raster_soup(soup *s) {
    sl_raster_destroy(s->raster);
    assert_int_equal(sl_raster_create_mesh(&s->mesh, 1, &s->raster, NULL), SL_OK);
}

static void free_soup(soup *s) {
    sl_raster_destroy(s->raster);
    free(s->x);
    free(s->y);
    free(s->z);
    for (int k = 0; k < 3; k++) free(s->vertex[k]);
}

typedef void make_triangle(uint64_t key, uint64_t t, sl_vec3 p[3]);

static void make_soup(soup *s, make_triangle *make, uint64_t key) {
    for (size_t t = 0; t < s->count; t++) {
        sl_vec3 p[3];
        make(key, t, p);
        for (size_t k = 0; k < 3; k++)
            s->x[3 * t + k] = p[k].x, s->y[3 * t + k] = p[k].y, s->z[3 * t + k] = p[k].z;
    }
    raster_soup(s);
}

static sl_vec3 in_cube(uint64_t key, uint64_t n, float size) {
    return sl_v3(random_between(key, 3 * n, -size, size), random_between(key, 3 * n + 1, -size, size),
                 random_between(key, 3 * n + 2, -size, size));
}

static void any_size(uint64_t key, uint64_t t, sl_vec3 p[3]) { /* from a thousandth to the whole */
    sl_vec3 centre = in_cube(key, 8 * t, 1.2f);
    float size = sl_exp2f(random_between(key, 1000000 + t, -10.0f, 0.5f));
    for (uint64_t k = 0; k < 3; k++) p[k] = sl_add(centre, in_cube(key, 8 * t + 1 + k, size));
}

static void sub_pixel(uint64_t key, uint64_t t, sl_vec3 p[3]) {
    sl_vec3 centre = in_cube(key, 8 * t, 1.0f);
    for (uint64_t k = 0; k < 3; k++) p[k] = sl_add(centre, in_cube(key, 8 * t + 1 + k, 0.008f));
}

static void huge(uint64_t key, uint64_t t, sl_vec3 p[3]) {
    for (uint64_t k = 0; k < 3; k++)
        p[k] = in_cube(key, 8 * t + k, sl_exp2f(random_between(key, 1000000 + 3 * t + k, -2.0f, 70.0f)));
}

static void broken(uint64_t key, uint64_t t, sl_vec3 p[3]) { /* some NaN, infinite, denormal, without area */
    any_size(key, t, p);
    static const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f, 1e-42f, 0.0f, -0.0f};
    float *coordinates = &p[0].x;
    if (t % 3 == 0)
        coordinates[sl_random_bits(key, 3000000 + t) % 9] = odd[sl_random_bits(key, 4000000 + t) % 7];
    if (t % 7 == 0) p[1] = p[0];
}

/* vertices on pixel centres, depths that tie */
static void on_the_grid(uint64_t key, uint64_t t, sl_vec3 p[3]) {
    for (uint64_t k = 0; k < 3; k++) {
        p[k].x = (2.0f * (float)(sl_random_bits(key, 16 * t + k) % 64) + 1.0f) / 64.0f - 1.0f;
        p[k].y = (2.0f * (float)(sl_random_bits(key, 16 * t + 3 + k) % 64) + 1.0f) / 64.0f - 1.0f;
        p[k].z = 0.25f * (float)(sl_random_bits(key, 16 * t + 6) % 3);
    }
}

/* ---- views ---- */

static uint8_t some_triangles[4000];

static const uint8_t *every_third_triangle(void) {
    for (size_t t = 0; t < sizeof some_triangles; t++) some_triangles[t] = t % 3 == 1;
    return some_triangles;
}

static sl_view random_view(uint64_t key, uint64_t n, int width, int height) {
    sl_frame frame = sl_frame_from_normal(random_direction(key, 50 * n));
    sl_vec3 eye = in_cube(key, 500000 + n, 1.5f);
    sl_view view;
    if (n % 3 == 0) {
        sl_camera camera = {eye, frame.x, frame.y, sl_neg(frame.z),
                            random_between(key, 600000 + n, 0.2f, 2.5f)};
        view = sl_view_camera(&camera, width, height, n % 2 ? 0.01f : 0.5f, n % 5 ? 100.0f : 1.5f);
        view.corner_planes = n % 4 == 0;
    } else if (n % 3 == 1) {
        float t = random_between(key, 600000 + n, 0.1f, 6.0f);
        view = sl_view_pyramid(&frame, eye, -t, t * 0.7f, -t * 0.9f, t, width, height, n % 2 ? 1e-4f : 0.3f);
    } else {
        view = flat_view(width, height); /* w = 1, clipped at all six planes */
        view.corner_planes = n % 4 == 0;
    }
    if (n % 11 == 3) view.skip_triangle = (uint32_t)(n % 17);
    if (n % 7 == 2) view.left_out = every_third_triangle();
    return view;
}

/* Many views of one kind of triangles; targets from a few pixels to several tiles, viewports and scissors
 * within. */
static void compare(make_triangle *make, uint64_t seed, size_t count, uint64_t views, int least_seen) {
    soup s = soup_of(count);
    uint64_t key = sl_random_key(81, seed);
    static const int sizes[][2] = {{64, 64}, {37, 51}, {300, 290}, {1, 1}, {130, 7}, {64, 64}};
    int seen = 0;
    for (uint64_t n = 0; n < views; n++) {
        if (n % 8 == 0) make_soup(&s, make, key + 977 * n);
        int width = sizes[n % 6][0], height = sizes[n % 6][1], right = 0, above = 0;
        sl_view view = random_view(key, n, width, height);
        if (n % 5 == 1) view.x = 9, view.y = 17, right = 5, above = 3;
        if (n % 5 == 2) view.scissor = (sl_scissor){width / 3, height / 4, width, height - height / 5};
        seen += assert_same(s.raster, &s.mesh, NULL, &view, width + view.x + right, height + view.y + above);
    }
    if (seen < least_seen) fail_msg("only %d pixels were seen", seen);
    free_soup(&s);
}

/* ---- tests ---- */

static void triangles_of_any_size_come_out_the_same(void **state) {
    (void)state;
    compare(any_size, 0, 400, 120, 100000);
    compare(any_size, 1, 3000, 24, 50000);
}

static void triangles_below_a_pixel_come_out_the_same(void **state) {
    (void)state;
    compare(sub_pixel, 2, 4000, 60, 5000);
}

static void triangles_far_larger_than_the_view_come_out_the_same(void **state) {
    (void)state;
    compare(huge, 4, 200, 120, 100000);
}

static void triangles_that_are_not_numbers_come_out_the_same(void **state) {
    (void)state;
    compare(broken, 5, 400, 120, 50000);
}

static void vertices_on_pixel_centres_and_equal_depths_come_out_the_same(void **state) {
    (void)state;
    soup s = soup_of(300);
    int seen = 0;
    for (uint64_t n = 0; n < 20; n++) {
        make_soup(&s, on_the_grid, sl_random_key(82, n));
        sl_view view = flat_view(64, 64);
        view.corner_planes = n % 2;
        seen += assert_same(s.raster, &s.mesh, NULL, &view, 64, 64);
    }
    assert_true(seen > 20 * 3000);
    free_soup(&s);
}

static void rooms_come_out_the_same(void **state) {
    (void)state;
    sl_scene *scene = furnished_room(30, 8);
    sl_raster *raster = raster_of(scene);
    sl_raster_mesh mesh = {scene->vertex_count, scene->triangle_count,
                           scene->position_x,   scene->position_y,
                           scene->position_z,   {scene->vertex[0], scene->vertex[1], scene->vertex[2]}};
    uint64_t key = sl_random_key(83, 0);
    for (uint64_t n = 0; n < 24; n++) {
        int size = n % 4 == 0 ? 300 : 64;
        sl_vec3 eye =
            sl_v3(random_between(key, 3 * n, 0.1f, 3.9f), random_between(key, 3 * n + 1, 0.1f, 2.9f),
                  random_between(key, 3 * n + 2, 0.1f, 4.9f));
        sl_frame frame = sl_frame_from_normal(random_direction(key, 1000 + n));
        float t = n % 3 ? 1.0f : 5.671282f;
        sl_view view = sl_view_pyramid(&frame, eye, -t, t, -t, t, size, size, 1e-4f);
        /* the room is closed */
        assert_int_equal(assert_same(raster, &mesh, scene, &view, size, size), size * size);
        sl_camera camera = {eye, frame.x, frame.y, sl_neg(frame.z), 1.2f};
        view = sl_view_camera(&camera, size, size, 0.01f, 50.0f);
        assert_same(raster, &mesh, scene, &view, size, size);
    }
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_of_any_size_come_out_the_same),
        cmocka_unit_test(triangles_below_a_pixel_come_out_the_same),
        cmocka_unit_test(triangles_far_larger_than_the_view_come_out_the_same),
        cmocka_unit_test(triangles_that_are_not_numbers_come_out_the_same),
        cmocka_unit_test(vertices_on_pixel_centres_and_equal_depths_come_out_the_same),
        cmocka_unit_test(rooms_come_out_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
