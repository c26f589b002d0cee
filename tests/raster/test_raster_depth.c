/* Depth: ties, and the cube of depth maps around a light. */
#include "raster_support.h"

/* ---- ties ---- */

static void equal_depths_go_to_the_lowest_index(void **state) {
    (void)state;
    enum { SIZE = 64, COPIES = 300 };
    float xyz[COPIES * 9];
    for (size_t t = 0; t < COPIES; t++) { /* coplanar, corners turned, so that clusters and set-up see different triangles */
        const float corner[3][3] = {{-1, -1, 0.25f}, {3, -1, 0.25f}, {-1, 3, 0.25f}};
        for (size_t c = 0; c < 3; c++) memcpy(&xyz[9 * t + 3 * c], corner[(c + t) % 3], sizeof corner[0]);
    }
    sl_scene *scene = scene_of_triangles(xyz, COPIES);
    sl_raster *raster = raster_of(scene);
    uint32_t id[SIZE * SIZE];
    for (int kind = 0; kind < 2; kind++) {
        sl_view view = flat_view(SIZE, SIZE);
        view.depth = kind ? SL_DEPTH_INVERSE_W : SL_DEPTH_WINDOW;
        render_small(raster, &view, id, NULL);
        for (int i = 0; i < SIZE * SIZE; i++) assert_int_equal(id[i], 0);
        view.skip_triangle = 0;
        render(raster, &view, 2, id, NULL);
        for (int i = 0; i < SIZE * SIZE; i++) assert_int_equal(id[i], 1);
    }
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void nearer_wins_whatever_the_order(void **state) {
    (void)state;
    const float xyz[18] = {-1, -1, 0.5f, 3, -1, 0.5f, -1, 3, 0.5f, -1, -1, -0.5f, 3, -1, -0.5f, -1, 3, -0.5f};
    sl_scene *scene = scene_of_triangles(xyz, 2);
    sl_raster *raster = raster_of(scene);
    uint32_t id[64];
    float depth[64];
    sl_view view = flat_view(8, 8);
    render(raster, &view, 1, id, depth);
    for (int i = 0; i < 64; i++) assert_true(id[i] == 1 && depth[i] == 0.25f);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void nothing_is_drawn_at_the_cleared_depth(void **state) {
    (void)state;
    const float xyz[18] = {-1, -1, 1, 3, -1, 1, -1, 3, 1, -1, -1, 0.999f, 0, -1, 0.999f, -1, 0, 0.999f};
    sl_scene *scene = scene_of_triangles(xyz, 2);
    sl_raster *raster = raster_of(scene);
    uint32_t id[64];
    sl_view view = flat_view(8, 8);
    render(raster, &view, 1, id, NULL);
    assert_int_equal(id[0], 1);
    assert_int_equal(id[63], SL_NO_INDEX); /* the first triangle lies in the far plane: GL_LESS against a cleared 1 fails */
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

/* ---- the cube's orientation, from OpenGL's table and nothing else ---- */

static void texel_direction(int face, double s, double t, double d[3]) { /* s, t in [-1,1] */
    const double table[6][3] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t}, {s, -1, -t}, {s, -t, 1}, {-s, -t, -1}};
    memcpy(d, table[face], sizeof table[face]);
}

static void cube_faces_hold_the_depth_along_their_axis(void **state) {
    (void)state;
    enum { SIZE = 24 };
    const double low[3] = {-1, -2, -3}, high[3] = {1.5, 2.5, 3.5}, eye[3] = {0.3, -0.4, 0.5};
    float xyz[12 * 9 * 9];
    size_t count = add_box(xyz, 0, sl_v3(-1, -2, -3), sl_v3(1.5f, 2.5f, 3.5f), 3, NULL, NULL);
    sl_scene *scene = scene_of_triangles(xyz, count);
    sl_raster *raster = raster_of(scene);
    sl_depth_cube *cube;
    sl_counters counters = {{0}};
    assert_int_equal(sl_raster_depth_cube(raster, sl_v3(0.3f, -0.4f, 0.5f), SIZE, 1e-3f, 2, &cube, &counters, NULL), SL_OK);
    assert_int_equal(counters.value[SL_COUNT_RASTER_PASSES], 6);
    for (int face = 0; face < 6; face++) {
        for (int y = 0; y < SIZE; y++) {
            for (int x = 0; x < SIZE; x++) {
                double d[3], nearest = 1e30;
                texel_direction(face, (2.0 * x + 1.0) / SIZE - 1.0, (2.0 * y + 1.0) / SIZE - 1.0, d);
                for (int k = 0; k < 3; k++) { /* the major axis has |d| = 1, so the ray's parameter is the depth */
                    if (d[k] != 0.0) nearest = fmin(nearest, ((d[k] > 0.0 ? high[k] : low[k]) - eye[k]) / d[k]);
                }
                double got = (double)cube->depth[(face * SIZE + y) * SIZE + x];
                assert_true(fabs(got * nearest - 1.0) < 1e-2);
            }
        }
    }
    sl_depth_cube_destroy(cube);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

/* ---- shadows ---- */

typedef struct lit_room {
    sl_scene *scene;
    sl_raster *raster;
    sl_depth_cube *cube;
} lit_room;

static const sl_vec3 light = {0.31f, 0.42f, -0.17f};

/* A room [-2,2]^3, and if `plate` a plate of 1.2 x 1.2 hovering at y = -0.8 above the floor. */
static lit_room make_room(bool plate, int size) {
    float xyz[(12 * 4 + 2) * 9];
    size_t count = add_box(xyz, 0, sl_v3(-2, -2, -2), sl_v3(2, 2, 2), 2, NULL, NULL);
    const float quad[18] = {-0.6f, -0.8f, -0.6f, 0.6f, -0.8f, -0.6f, 0.6f, -0.8f, 0.6f,
                            -0.6f, -0.8f, -0.6f, 0.6f, -0.8f, 0.6f, -0.6f, -0.8f, 0.6f};
    if (plate) memcpy(&xyz[9 * count], quad, sizeof quad);
    lit_room room;
    room.scene = scene_of_triangles(xyz, count + (plate ? 2 : 0));
    room.raster = raster_of(room.scene);
    sl_counters counters = {{0}};
    assert_int_equal(sl_raster_depth_cube(room.raster, light, size, 1e-3f, 2, &room.cube, &counters, NULL), SL_OK);
    return room;
}

static void destroy_room(lit_room *room) {
    sl_depth_cube_destroy(room->cube);
    sl_raster_destroy(room->raster);
    sl_scene_destroy(room->scene);
}

/* Not within `margin` of the room's edges: there a texel holds the other wall. */
static void point_on_wall(uint64_t key, uint64_t i, float margin, sl_vec3 *p, sl_vec3 *n) {
    float c[3], m[3] = {0, 0, 0};
    int axis = (int)(i % 3);
    for (unsigned k = 0; k < 3; k++) c[k] = random_between(key, 4 * i + k, margin - 2.0f, 2.0f - margin);
    c[axis] = i % 2 ? 2.0f : -2.0f;
    m[axis] = i % 2 ? -1.0f : 1.0f;
    *p = sl_v3(c[0], c[1], c[2]);
    *n = sl_v3(m[0], m[1], m[2]);
}

static void walls_do_not_shadow_themselves(void **state) {
    (void)state;
    const int sizes[3] = {16, 64, 256};
    for (int s = 0; s < 3; s++) {
        lit_room room = make_room(false, sizes[s]);
        for (uint64_t i = 0; i < 100000; i++) {
            sl_vec3 p, n;
            point_on_wall(sl_random_key(10, 0), i, 16.0f / (float)sizes[s], &p, &n);
            assert_true(sl_depth_cube_lit(room.cube, p, n) == 1.0f);
        }
        destroy_room(&room);
    }
}

static void plate_shadows_the_floor_below_it_and_nothing_else(void **state) {
    (void)state;
    enum { SIZE = 256 };
    lit_room room = make_room(true, SIZE);
    size_t dark = 0, bright = 0, between = 0;
    for (uint64_t i = 0; i < 100000; i++) {
        sl_vec3 p, n = sl_v3(0, 1, 0);
        p = sl_v3(random_between(sl_random_key(11, 0), 2 * i, -1.9f, 1.9f), -2.0f,
                  random_between(sl_random_key(11, 0), 2 * i + 1, -1.9f, 1.9f));
        float at = (light.y + 0.8f) / (light.y + 2.0f); /* where the way from the light meets the plate's height */
        float x = fabsf(light.x + at * (p.x - light.x)), z = fabsf(light.z + at * (p.z - light.z));
        float edge = fmaxf(x, z) - 0.6f, margin = 3.0f * 1.22f * 2.0f / SIZE;
        float lit = sl_depth_cube_lit(room.cube, p, n);
        assert_true(lit >= 0.0f && lit <= 1.0f);
        if (edge < -margin) assert_true(lit == 0.0f);
        if (edge > margin) assert_true(lit == 1.0f);
        dark += lit == 0.0f;
        bright += lit == 1.0f;
        between += lit > 0.0f && lit < 1.0f;
    }
    assert_true(dark > 1000 && bright > 1000 && between > 100);
    for (int i = 0; i < 1000; i++) { /* the plate itself is lit from above */
        sl_vec3 p = sl_v3(-0.599f + 1.198f * (float)(i % 32) / 31.0f, -0.8f, -0.599f + 1.198f * (float)(i / 32) / 31.0f);
        assert_true(sl_depth_cube_lit(room.cube, p, sl_v3(0, 1, 0)) == 1.0f);
    }
    destroy_room(&room);
}

static void shadow_is_continuous(void **state) {
    (void)state;
    lit_room room = make_room(true, 64);
    const sl_vec3 starts[4] = {{-1.9f, -2, 0.1f}, {0.2f, -1.99f, -1.9f}, {0.1f, -1.4f, -1.5f}, {-1.9f, -0.79f, -1.7f}};
    const sl_vec3 ends[4] = {{1.9f, -2, -0.3f}, {-0.3f, -1.99f, 1.9f}, {0.0f, -0.7f, 1.5f}, {1.8f, -0.79f, 1.6f}};
    enum { STEPS = 200000 };
    for (int path = 0; path < 4; path++) {
        float before = -1.0f, least = 1.0f;
        for (int i = 0; i <= STEPS; i++) {
            sl_vec3 p = sl_mad(starts[path], (float)i / STEPS, sl_sub(ends[path], starts[path]));
            float lit = sl_depth_cube_lit(room.cube, p, sl_v3(0, 1, 0));
            if (before >= 0.0f && fabsf(lit - before) > 0.02f) {
                fail_msg("path %d step %d: %g after %g", path, i, (double)lit, (double)before);
            }
            before = lit;
            least = lit < least ? lit : least;
        }
        if (path < 2) assert_true(least == 0.0f);
    }
    destroy_room(&room);
}

static void points_at_the_light_and_beyond_everything_are_lit(void **state) {
    (void)state;
    lit_room room = make_room(false, 16);
    assert_true(sl_depth_cube_lit(room.cube, light, sl_v3(0, 1, 0)) == 1.0f);
    assert_true(sl_depth_cube_lit(room.cube, sl_v3(NAN, 0, 0), sl_v3(0, 1, 0)) == 1.0f);
    for (int i = 0; i < 6 * 16 * 16; i++) room.cube->depth[i] = 0.0f; /* empty space */
    assert_true(sl_depth_cube_lit(room.cube, sl_v3(1, 50, 3), sl_v3(0, 1, 0)) == 1.0f);
    destroy_room(&room);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_depths_go_to_the_lowest_index),
        cmocka_unit_test(nearer_wins_whatever_the_order),
        cmocka_unit_test(nothing_is_drawn_at_the_cleared_depth),
        cmocka_unit_test(cube_faces_hold_the_depth_along_their_axis),
        cmocka_unit_test(walls_do_not_shadow_themselves),
        cmocka_unit_test(plate_shadows_the_floor_below_it_and_nothing_else),
        cmocka_unit_test(shadow_is_continuous),
        cmocka_unit_test(points_at_the_light_and_beyond_everything_are_lit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
