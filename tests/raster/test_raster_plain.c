/* The fast path against its plain opposite (raster/plain.c): the same ids, the same depths, bit by bit, and
 * the same bill, at any number of threads, on every instruction set, whatever is drawn: random triangles of
 * every size, and what breaks careless rasterizers. */
#include <float.h>

#include "base/counters.h"
#include "base/math.h"
#include "base/sanitized.h"
#include "raster/pipeline.h"
#include "tests/raster/plain.h"
#include "raster_support.h"
#include "scene_parts.h"

enum { UNTOUCHED = 0x12345678 };
static const float untouched_depth = -3.0f;

/* ---- triangles of every size ---- */

typedef void make_triangle(uint64_t key, uint64_t t, sl_vec3 p[3]);

static sl_vec3 in_cube(uint64_t key, uint64_t n, float size) {
    return sl_v3(random_between(key, 3 * n, -size, size), random_between(key, 3 * n + 1, -size, size),
                 random_between(key, 3 * n + 2, -size, size));
}

static void near_centre(uint64_t key, uint64_t t, float size, sl_vec3 p[3]) {
    sl_vec3 centre = in_cube(key, 8 * t, 1.2f);
    for (uint64_t k = 0; k < 3; k++) p[k] = sl_add(centre, in_cube(key, 8 * t + 1 + k, size));
}

static void any_size(uint64_t key, uint64_t t, sl_vec3 p[3]) { /* from a thousandth to the whole */
    near_centre(key, t, sl_exp2f(random_between(key, 1000000 + t, -10.0f, 0.5f)), p);
}

static void below_a_pixel(uint64_t key, uint64_t t, sl_vec3 p[3]) { near_centre(key, t, 0.008f, p); }

static void far_larger(uint64_t key, uint64_t t, sl_vec3 p[3]) {
    for (uint64_t k = 0; k < 3; k++)
        p[k] = in_cube(key, 8 * t + k, sl_exp2f(random_between(key, 1000000 + 3 * t + k, -2.0f, 70.0f)));
}

/* ---- meshes and pictures ---- */

typedef struct {
    size_t triangles;
    float *at[3]; /* x, y, z */
    uint32_t *vertex[3];
    sl_raster_mesh mesh;
    sl_raster *raster;
} soup;

static soup soup_of(size_t triangles) {
    soup s = {.triangles = triangles};
    for (int k = 0; k < 3; k++) {
        s.at[k] = calloc(3 * triangles + 1, sizeof *s.at[k]);
        s.vertex[k] = calloc(triangles + 1, sizeof *s.vertex[k]);
        assert_true(s.at[k] && s.vertex[k]);
        for (uint32_t t = 0; t < triangles; t++) s.vertex[k][t] = 3 * t + (uint32_t)k;
    }
    s.mesh = (sl_raster_mesh){3 * triangles, triangles, s.at[0],
                              s.at[1],       s.at[2],   {s.vertex[0], s.vertex[1], s.vertex[2]}};
    return s;
}

static void put(soup *s, size_t t, sl_vec3 a, sl_vec3 b, sl_vec3 c) {
    const sl_vec3 p[3] = {a, b, c};
    for (size_t k = 0; k < 3; k++)
        s->at[0][3 * t + k] = p[k].x, s->at[1][3 * t + k] = p[k].y, s->at[2][3 * t + k] = p[k].z;
}

static void free_soup(soup *s) {
    sl_raster_destroy(s->raster);
    for (int k = 0; k < 3; k++) {
        free(s->at[k]);
        free(s->vertex[k]);
    }
}

static soup soup_made(make_triangle *make, uint64_t key, size_t triangles) {
    soup s = soup_of(triangles);
    for (size_t t = 0; t < triangles; t++) {
        sl_vec3 p[3];
        make(key, t, p);
        put(&s, t, p[0], p[1], p[2]);
    }
    return s;
}

static soup random_soup(uint64_t key, size_t triangles) { return soup_made(any_size, key, triangles); }

/* For one instruction set after the other: all have the plain form's bits. */
static const sl_raster *raster_soup(soup *s) {
    static const char *const isas[] = {"baseline", "avx2", "avx512"};
    static int turn;
    sl_raster_destroy(s->raster);
    assert_int_equal(setenv("SOFTLUX_ISA", isas[turn++ % 3], 1), 0);
    assert_int_equal(sl_raster_create_mesh(&s->mesh, 1, &s->raster, NULL), SL_OK);
    unsetenv("SOFTLUX_ISA");
    return s->raster;
}

static sl_raster_mesh mesh_of(const sl_scene *scene) {
    return (sl_raster_mesh){scene->vertex_count, scene->triangle_count,
                            scene->position_x,   scene->position_y,
                            scene->position_z,   {scene->vertex[0], scene->vertex[1], scene->vertex[2]}};
}

typedef struct {
    int width, height;
    uint32_t *id;
    float *depth;
} picture;

static picture picture_of(int width, int height) {
    size_t pixels = (size_t)width * (size_t)height;
    picture p = {width, height, malloc(pixels * sizeof *p.id), malloc(pixels * sizeof *p.depth)};
    assert_true(p.id && p.depth);
    for (size_t i = 0; i < pixels; i++) p.id[i] = UNTOUCHED, p.depth[i] = untouched_depth;
    return p;
}

static void free_picture(picture *p) {
    free(p->id);
    free(p->depth);
}

static sl_target target_of(const picture *p) { return (sl_target){p->width, p->height, p->id, p->depth}; }

static void assert_equal_pictures(const char *which, const picture *a, const picture *b) {
    for (int i = 0; i < a->width * a->height; i++) {
        if (a->id[i] == b->id[i] && memcmp(&a->depth[i], &b->depth[i], 4) == 0) continue;
        fail_msg("%s, pixel %d,%d of %d x %d: %u at %.9g, not %u at %.9g", which, i % a->width, i / a->width,
                 a->width, a->height, a->id[i], (double)a->depth[i], b->id[i], (double)b->depth[i]);
    }
}

/* The small form, the large form on several threads, and the plain opposite: one picture, and one bill.
 * Returns how many pixels show something. */
static int assert_agree(soup *s, const sl_view *view, int width, int height) {
    static const unsigned threads[] = {1, 2, 3, 7, 64};
    const sl_raster *raster = s->raster ? s->raster : raster_soup(s);
    picture plain = picture_of(width, height), small = picture_of(width, height);
    sl_target plain_target = target_of(&plain), small_target = target_of(&small);
    sl_counters bill = {{0}};
    sl_raster_scratch *scratch;
    sl_plain_id(&s->mesh, NULL, view, &plain_target);
    assert_int_equal(sl_raster_scratch_create(raster, width, height, &scratch, NULL), SL_OK);
    sl_raster_id_small(raster, view, &small_target, scratch, &bill);
    sl_raster_scratch_destroy(scratch);
    assert_equal_pictures("small", &small, &plain);
    for (size_t n = 0; n < sizeof threads / sizeof *threads; n++) {
        picture large = picture_of(width, height);
        sl_target large_target = target_of(&large);
        sl_counters counters = {{0}};
        assert_int_equal(sl_raster_id(raster, view, threads[n], &large_target, &counters, NULL), SL_OK);
        assert_equal_pictures("large", &large, &plain);
        assert_memory_equal(&counters, &bill, sizeof bill);
        free_picture(&large);
    }
    int seen = 0;
    for (int i = 0; i < width * height; i++) seen += plain.id[i] != SL_NO_INDEX && plain.id[i] != UNTOUCHED;
    free_picture(&plain);
    free_picture(&small);
    return seen;
}

/* ---- many views of many triangles ---- */

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
        view = camera_view(&camera, width, height, n % 2 ? 0.01f : 0.5f, n % 5 ? 100.0f : 1.5f);
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

/* Targets from a few pixels to several tiles, viewports and scissors within. */
static void compare(make_triangle *make, uint64_t seed, size_t count, uint64_t views, int least_seen) {
    static const int sizes[][2] = {{64, 64}, {37, 51}, {300, 290}, {1, 1}, {130, 7}, {64, 64}};
    uint64_t key = sl_random_key(81, seed);
    int seen = 0;
    for (uint64_t first = 0; first < (SL_SANITIZED ? 8 : views); first += 8) {
        soup s = soup_made(make, key + 977 * first, count);
        for (uint64_t n = first; n < first + 8; n++) {
            int width = sizes[n % 6][0], height = sizes[n % 6][1], right = 0, above = 0;
            sl_view view = random_view(key, n, width, height);
            if (n % 5 == 1) view.x = 9, view.y = 17, right = 5, above = 3;
            if (n % 5 == 2) view.scissor = (sl_scissor){width / 3, height / 4, width, height - height / 5};
            seen += assert_agree(&s, &view, width + view.x + right, height + view.y + above);
        }
        free_soup(&s);
    }
    if (seen < least_seen) fail_msg("only %d pixels were seen", seen);
}

static void triangles_of_every_size_agree(void **state) {
    compare(any_size, 0, 400, 64, 5000);
    compare(any_size, 1, 3000, 24, 5000);
    compare(below_a_pixel, 2, 4000, 32, 250);
    compare(far_larger, 4, 200, 64, 5000);
}

/* ---- ties ---- */

/* Later triangles lie in the plane of earlier ones, so that what hides a cluster is as near as it. */
static void equal_depths_over_tiles_and_clusters_go_to_the_lowest_index(void **state) {
    soup s = soup_of(4000);
    uint64_t key = sl_random_key(92, 0);
    for (size_t t = 0; t < s.triangles; t++) {
        float z = 0.25f * (float)(sl_random_bits(key, 16 * t) % 5) - 0.5f, size = t % 50 ? 0.05f : 1.5f, c[2],
              q[6];
        for (uint64_t k = 0; k < 2; k++) c[k] = random_between(key, 16 * t + 1 + k, -1.2f, 1.2f);
        for (uint64_t k = 0; k < 6; k++) q[k] = c[k % 2] + random_between(key, 16 * t + 3 + k, -size, size);
        size_t place = s.triangles - 1 - t; /* the large ones come last, and last of all the first of them */
        put(&s, place, sl_v3(q[0], q[1], z), sl_v3(q[2], q[3], z), sl_v3(q[4], q[5], z));
    }
    sl_view view = flat_view(300, 270);
    assert_true(assert_agree(&s, &view, 300, 270) > 70000);
    view.depth = SL_DEPTH_INVERSE_W; /* w = 1: all depths are equal */
    assert_true(assert_agree(&s, &view, 300, 270) > 40000);
    free_soup(&s);
}

/* ---- places and sizes ---- */

static void sizes_around_a_tiles_agree(void **state) {
    static const int sizes[] = {1, 2, 255, 256, 257, 511, 512, 513};
    soup s = random_soup(sl_random_key(93, 0), 600);
    for (size_t n = 0; n < 8; n++) {
        sl_view wide = flat_view(sizes[n], 3), high = flat_view(5, sizes[n]),
                square = flat_view(sizes[n], sizes[7 - n]);
        assert_agree(&s, &wide, sizes[n], 3);
        assert_agree(&s, &high, 5, sizes[n]);
        assert_true(assert_agree(&s, &square, sizes[n], sizes[7 - n]) > 0);
    }
    free_soup(&s);
}

static void adjacent_viewports_do_not_touch_each_other(void **state) {
    enum { WIDTH = 307, HEIGHT = 283, X = 133, Y = 141 };
    soup s = random_soup(sl_random_key(96, 0), 500);
    const sl_raster *raster = raster_soup(&s);
    const int rect[4][4] = {
        {0, 0, X, Y}, {X, 0, WIDTH - X, Y}, {0, Y, X, HEIGHT - Y}, {X, Y, WIDTH - X, HEIGHT - Y}};
    picture one_by_one = picture_of(WIDTH, HEIGHT), together = picture_of(WIDTH, HEIGHT),
            plain = picture_of(WIDTH, HEIGHT);
    sl_target target = target_of(&one_by_one), all[4], plain_target = target_of(&plain);
    sl_counters bill = {{0}}, whole_bill = {{0}};
    sl_view views[4];
    for (int n = 0; n < 4; n++) {
        views[n] = flat_view(rect[n][2], rect[n][3]);
        views[n].x = rect[n][0];
        views[n].y = rect[n][1];
        all[n] = target_of(&together);
        assert_int_equal(sl_raster_id(raster, &views[n], 2, &target, &bill, NULL), SL_OK);
        sl_plain_id(&s.mesh, NULL, &views[n], &plain_target);
    }
    assert_equal_pictures("one by one", &one_by_one, &plain);
    /* side by side in one target */
    assert_int_equal(sl_raster_ids(raster, 4, views, 3, all, &whole_bill, NULL), SL_OK);
    assert_equal_pictures("all at once", &together, &plain);
    assert_memory_equal(&bill, &whole_bill, sizeof bill);
    free_picture(&one_by_one);
    free_picture(&together);
    free_picture(&plain);
    free_soup(&s);
}

static void scissors_that_leave_nothing_touch_nothing_and_count_the_same(void **state) {
    soup s = random_soup(sl_random_key(97, 0), 100);
    static const sl_scissor scissors[] = {
        {256, 256, 256, 300}, {5, 5, 5, 9}, {1000, 0, 1001, 1}, {9, 9, 2, 2}, {-5, -5, -1, -1}};
    for (size_t n = 0; n < 5; n++) {
        for (int x = 0; x <= 256; x += 256) { /* where a tile begins, no tile is left */
            sl_view view = flat_view(60, 60);
            view.x = view.y = x;
            view.scissor = scissors[n];
            assert_int_equal(assert_agree(&s, &view, x + 60, x + 60), 0);
        }
    }
    free_soup(&s);
}

/* ---- odd views ---- */

/* Culling by bounding spheres asks for the length of a plane's normal, whose square is 0 in float long before
 * it is. */
static void planes_of_next_to_no_length_cull_nothing_that_shows(void **state) {
    soup s = random_soup(sl_random_key(100, 0), 400);
    static const float scales[] = {1e-42f, 1e-30f, 1e-25f, 1e-22f, 1e-19f, 1e12f};
    for (size_t n = 0; n < sizeof scales / sizeof *scales; n++) {
        sl_view near = flat_view(64, 64), all = flat_view(64, 64);
        near.depth = all.depth = SL_DEPTH_INVERSE_W;
        near.clip[2][2] = -scales[n]; /* the near plane, z = 0 */
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4; j++) all.clip[i][j] *= scales[n];
        }
        assert_true(assert_agree(&s, &near, 64, 64) > 1000);
        assert_agree(&s, &all, 64, 64);
    }
    free_soup(&s);
}

static void matrices_that_mean_nothing_agree(void **state) {
    soup s = random_soup(sl_random_key(101, 0), 200);
    static const float odd[] = {NAN, INFINITY, -INFINITY, 0.0f, FLT_MAX, -FLT_MAX, 1e30f, FLT_MIN, 1e-42f};
    for (size_t n = 0; n < 9; n++) {
        for (int element = 0; element < 16; element++) {
            sl_view view = flat_view(40, 30);
            view.clip[element / 4][element % 4] = odd[n];
            view.depth = (element + (int)n) % 2 ? SL_DEPTH_WINDOW : SL_DEPTH_INVERSE_W;
            assert_agree(&s, &view, 40, 30);
        }
        sl_view view = flat_view(40, 30);
        for (int k = 0; k < 16; k++) view.clip[k / 4][k % 4] = odd[n];
        assert_agree(&s, &view, 40, 30);
        view = flat_view(40, 30);
        view.origin.y = odd[n];
        assert_agree(&s, &view, 40, 30);
    }
    free_soup(&s);
}

static void near_planes_from_nothing_to_beyond_everything_agree(void **state) {
    static const float nears[] = {0.0f, 1e-42f, 1e-38f, 1e-30f, 1e-10f, 0.5f, 1e10f, 1e30f};
    soup s = random_soup(sl_random_key(102, 0), 250);
    for (uint64_t n = 0; n < 8; n++) {
        sl_frame frame = sl_frame_from_normal(random_direction(sl_random_key(102, 1), n));
        sl_vec3 at = sl_mesh_position(&s.mesh, (uint32_t)(7 * n)),
                next = sl_mesh_position(&s.mesh, (uint32_t)(7 * n) / 3 * 3 + 1);
        /* on a vertex, on an edge, between */
        const sl_vec3 eyes[3] = {at, sl_scale(sl_add(at, next), 0.5f), sl_v3(0, 0, 0)};
        for (int e = 0; e < 3; e++) {
            sl_camera camera = {eyes[e], frame.x, frame.y, sl_neg(frame.z), 2.0f};
            sl_view pyramid = sl_view_pyramid(&frame, eyes[e], -5.0f, 4.0f, -3.0f, 5.0f, 70, 50, nears[n]);
            sl_view window = camera_view(&camera, 70, 50, nears[n], 100.0f);
            assert_agree(&s, &pyramid, 70, 50);
            assert_agree(&s, &window, 70, 50);
        }
    }
    free_soup(&s);
}

/* So near the eye that 1/w is no float. */
static void triangles_at_denormal_distances_agree(void **state) {
    static const float scales[] = {1e-36f, 1e-38f, 2e-39f, 1e-40f, 1e-42f};
    for (size_t n = 0; n < 5; n++) {
        soup s = random_soup(sl_random_key(107, n), 250);
        for (size_t i = 0; i < 3 * s.triangles; i++) {
            for (int k = 0; k < 3; k++) s.at[k][i] *= i / 3 % 3 ? scales[n] : 1.0f;
        }
        sl_frame frame = sl_frame_from_normal(random_direction(sl_random_key(107, 9), n));
        sl_view view = sl_view_pyramid(&frame, sl_v3(0, 0, 0), -1, 1, -1, 1, 300, 50, 0.0f);
        assert_agree(&s, &view, 300, 50);
        free_soup(&s);
    }
}

/* ---- odd meshes ---- */

/* Clusters with bounds that are infinite, NaN, or wider than floats go. */
static void clusters_without_finite_bounds_agree(void **state) {
    static const float odd[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1e30f, 1e19f, 1e-42f};
    uint64_t key = sl_random_key(104, 0);
    for (uint64_t n = 0; n < 24; n++) {
        soup s = random_soup(sl_random_key(104, n + 1), 1 + n * 11);
        for (uint64_t k = 0; k < 1 + n; k++) {
            uint64_t bits = sl_random_bits(key, 100 * n + k);
            s.at[bits % 3][k == 0 ? 0 : (bits >> 8) % (3 * s.triangles)] = odd[(bits >> 40) % 8];
        }
        sl_frame frame = sl_frame_from_normal(random_direction(key, n));
        sl_view flat = flat_view(61, 47),
                deep = sl_view_pyramid(&frame, sl_v3(0.1f, 0, 0), -1, 1, -1, 1, 61, 47, 1e-3f);
        assert_agree(&s, &flat, 61, 47);
        assert_agree(&s, &deep, 61, 47);
        free_soup(&s);
    }
}

/* A screen of squares, each with a hole, before thousands of triangles: what shows through must not be taken
 * for hidden. */
static void masked_triangles_do_not_hide_what_shows_through_them(void **state) {
    enum { BEHIND = 3000, COUNT = BEHIND + 2, SIZE = 270 };
    float *xyz = malloc(9 * COUNT * sizeof *xyz), *uv = calloc(6 * COUNT, sizeof *uv);
    uint32_t *indices = malloc(3 * COUNT * sizeof *indices), *materials = calloc(COUNT, sizeof *materials);
    assert_true(xyz && uv && indices && materials);
    uint64_t key = sl_random_key(105, 0);
    for (uint64_t t = 0; t < BEHIND; t++) {
        float c[3] = {random_between(key, 16 * t, -1, 1), random_between(key, 16 * t + 1, -1, 1),
                      random_between(key, 16 * t + 2, 0, 0.9f)};
        for (uint64_t k = 0; k < 9; k++)
            xyz[9 * t + k] = c[k % 3] + random_between(key, 16 * t + 3 + k, -0.05f, 0.05f);
    }
    const float screen[18] = {-1, -1, -0.5f, 1, -1, -0.5f, 1,  1, -0.5f,
                              -1, -1, -0.5f, 1, 1,  -0.5f, -1, 1, -0.5f};
    const float corners[12] = {0, 0, 16, 0, 16, 16, 0, 0, 16, 16, 0, 16}; /* the mask 16 times each way */
    memcpy(xyz + 9 * BEHIND, screen, sizeof screen);
    memcpy(uv + 6 * BEHIND, corners, sizeof corners);
    materials[BEHIND] = materials[BEHIND + 1] = 1;
    for (uint32_t i = 0; i < 3 * COUNT; i++) indices[i] = i;
    uint8_t texels[8 * 8 * 4];
    for (int i = 0; i < 64; i++) memset(&texels[4 * i], i % 8 < 5 && i / 8 < 5 ? 0 : 255, 4);
    sl_texture texture = {.file = "mask", .width = 8, .height = 8, .has_alpha = true, .texels = texels};
    sl_material material[2] = {
        {.diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX},
        {.diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = 0}};
    sl_scene_parts parts = {.vertex_count = 3 * COUNT,
                            .positions = xyz,
                            .texture_coordinates = uv,
                            .triangle_count = COUNT,
                            .indices = indices,
                            .material_index = materials,
                            .material_count = 2,
                            .materials = material,
                            .texture_count = 1,
                            .textures = &texture};
    sl_scene *scene = scene_built(&parts);
    sl_raster *raster = raster_of(scene);
    sl_raster_mesh mesh = mesh_of(scene);
    sl_view view = flat_view(SIZE, SIZE);
    picture plain = picture_of(SIZE, SIZE), fast = picture_of(SIZE, SIZE);
    sl_target target = target_of(&plain);
    sl_plain_id(&mesh, scene, &view, &target);
    render(raster, &view, 3, fast.id, fast.depth);
    assert_equal_pictures("behind a mask", &fast, &plain);
    int masked = 0, behind = 0;
    for (int i = 0; i < SIZE * SIZE; i++) {
        masked += plain.depth[i] == 0.25f;
        behind += plain.depth[i] > 0.25f && plain.depth[i] < 1.0f;
    }
    assert_true(masked > SIZE * SIZE / 2 && behind > SIZE * SIZE / 8); /* of 39/64 and 25/64 */
    free_picture(&plain);
    free_picture(&fast);
    destroy_raster(raster, scene);
    free(xyz);
    free(uv);
    free(indices);
    free(materials);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_of_every_size_agree),
        cmocka_unit_test(equal_depths_over_tiles_and_clusters_go_to_the_lowest_index),
        cmocka_unit_test(sizes_around_a_tiles_agree),
        cmocka_unit_test(adjacent_viewports_do_not_touch_each_other),
        cmocka_unit_test(scissors_that_leave_nothing_touch_nothing_and_count_the_same),
        cmocka_unit_test(planes_of_next_to_no_length_cull_nothing_that_shows),
        cmocka_unit_test(matrices_that_mean_nothing_agree),
        cmocka_unit_test(near_planes_from_nothing_to_beyond_everything_agree),
        cmocka_unit_test(triangles_at_denormal_distances_agree),
        cmocka_unit_test(clusters_without_finite_bounds_agree),
        cmocka_unit_test(masked_triangles_do_not_hide_what_shows_through_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
