/* Vertices behind the eye, at the eye, on the near plane, beyond the screen, and not finite at all. */
#include "raster_support.h"

enum { SIZE = 48, PIXELS = SIZE * SIZE };

static sl_view random_pyramid(uint64_t key, uint64_t n, sl_vec3 eye, float tangent, float near) {
    sl_frame frame = sl_frame_from_normal(random_direction(key, n));
    return sl_view_pyramid(&frame, eye, -tangent, tangent, -tangent, tangent, SIZE, SIZE, near);
}

static void plane_through_the_eyes_height_ends_at_the_horizon(void **state) {
    /* A floor one below the eye, reaching far behind it; the view looks level. Depth: w = -1 / tangent. */
    const float far = 4000.0f;
    const float xyz[18] = {-far, -1, -far, far, -1, -far, far,  -1, far,
                           -far, -1, -far, far, -1, far,  -far, -1, far};
    sl_scene *scene = scene_of_triangles(xyz, 2);
    sl_raster *raster = raster_of(scene);
    sl_frame frame = {sl_v3(1, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1)};
    sl_view view = sl_view_pyramid(&frame, sl_v3(0, 0, 0), -1, 1, -1, 1, SIZE, SIZE, 1e-3f);
    uint32_t id[PIXELS];
    float depth[PIXELS];
    render(raster, &view, 1, id, depth);
    for (int y = 0; y < SIZE; y++) {
        for (int x = 0; x < SIZE; x++) {
            double tangent = ((double)y + 0.5) * 2.0 / SIZE - 1.0;
            assert_int_equal(id[y * SIZE + x] != SL_NO_INDEX, tangent < 0.0);
            if (tangent < 0.0) assert_true(fabs((double)depth[y * SIZE + x] + tangent) < 1e-4);
        }
    }
    destroy_raster(raster, scene);
}

/* The eye looks along a wall from just below a ceiling, and sees the room below a near plane that is level,
 * not upright. Two corners of each of the wall's triangles are above it and some behind the eye: those are
 * not before it for that. */
static void an_oblique_near_plane_keeps_triangles_that_reach_behind_the_eye(void **state) {
    static float xyz[9 * 12];
    size_t count = add_box(xyz, 0, sl_v3(0, 0, 0), sl_v3(4, 3, 5), 1, NULL, NULL);
    sl_scene *scene = scene_of_triangles(xyz, count);
    sl_raster *raster = raster_of(scene);
    const sl_vec3 sides[4] = {{1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}};
    for (int k = 0; k < 4; k++) {
        sl_frame frame = {sl_v3(sides[k].z, 0, -sides[k].x), sl_v3(0, -1, 0), sides[k]};
        sl_view view = sl_view_pyramid(&frame, sl_v3(2.1f, 2.99f, 1.6f), -1, 1, 0, 1, 64, 32, 1e-4f);
        view.clip[2][0] = view.clip[2][2] = 0.0f;
        view.clip[2][1] = -1.0f;
        view.clip[2][3] = -1e-4f;
        uint32_t id[64 * 32];
        float depth[64 * 32];
        render(raster, &view, 1, id, depth);
        for (int i = 0; i < 64 * 32; i++) assert_int_not_equal(id[i], SL_NO_INDEX);
    }
    destroy_raster(raster, scene);
}

static void a_view_that_meets_nothing_draws_nothing_and_some_are_found_to_meet_nothing(void **state) {
    sl_scene *scene = furnished_room(2, 3);
    sl_raster *raster = raster_of(scene);
    uint64_t key = sl_random_key(41, 0);
    int nothing = 0, missed = 0;
    for (uint64_t i = 0; i < 300; i++) { /* eyes in and around the room, looking anywhere */
        sl_vec3 eye = sl_v3(random_between(key, 4 * i, -8, 12), random_between(key, 4 * i + 1, -8, 12),
                            random_between(key, 4 * i + 2, -8, 12));
        sl_frame frame = sl_frame_from_normal(random_direction(key + 1, i));
        sl_view view = sl_view_pyramid(&frame, eye, -0.3f, 0.3f, -0.3f, 0.3f, 32, 32, 0.01f);
        uint32_t id[32 * 32];
        float depth[32 * 32];
        render(raster, &view, 1, id, depth);
        int drawn = 0;
        for (int k = 0; k < 32 * 32; k++) drawn += id[k] != SL_NO_INDEX;
        bool meets = sl_raster_meets(raster, &view);
        if (!meets) assert_int_equal(drawn, 0);
        nothing += !meets;
        missed += meets && !drawn;
    }
    assert_true(nothing > 100 && missed < 20);
    destroy_raster(raster, scene);
}

static void vertices_that_are_not_finite_are_dropped_and_counted(void **state) {
    float xyz[6 * 9];
    for (size_t t = 0; t < 6; t++) {
        const float triangle[9] = {-1, -1, 0, 1, -1, 0, 0, 1, 0};
        memcpy(&xyz[9 * t], triangle, sizeof triangle);
    }
    sl_scene *scene = scene_of_triangles(xyz, 6);
    assert_int_equal(scene->triangle_count, 6);
    scene->position_x[3 * 0] = NAN;
    scene->position_y[3 * 1 + 1] = INFINITY;
    scene->position_z[3 * 2 + 2] = -INFINITY;
    scene->position_x[3 * 3] = 3e38f;
    sl_raster *raster = raster_of(scene);
    sl_view view = flat_view(SIZE, SIZE);
    uint32_t id[PIXELS];
    float depth[PIXELS];
    sl_counters counters = render(raster, &view, 1, id, depth);
    assert_int_equal(counters.value[SL_COUNT_TRIANGLES_DROPPED], 4);
    assert_int_equal(counters.value[SL_COUNT_TRIANGLES_RASTERIZED], 2);
    for (int i = 0; i < PIXELS; i++) assert_true(id[i] == SL_NO_INDEX || id[i] == 4);
    assert_int_equal(id[SIZE / 2 * SIZE + SIZE / 2], 4);
    view.origin = sl_v3(NAN, 0, 0);
    counters = render(raster, &view, 1, id, depth);
    assert_int_equal(counters.value[SL_COUNT_TRIANGLES_DROPPED], 6);
    for (int i = 0; i < PIXELS; i++) assert_int_equal(id[i], SL_NO_INDEX);
    destroy_raster(raster, scene);
}

static void every_triangle_is_accounted_for(void **state) {
    sl_scene *scene = furnished_room(20, 4);
    sl_raster *raster = raster_of(scene);
    for (uint64_t n = 0; n < 20; n++) {
        sl_view view = random_pyramid(sl_random_key(6, 0), n, sl_v3(2, 1.5f, 2.5f), 1.0f, 1e-3f);
        uint32_t id[PIXELS];
        sl_counters c = render(raster, &view, 1, id, NULL);
        assert_true(c.value[SL_COUNT_TRIANGLES_SUBMITTED] <= scene->triangle_count);
        assert_int_equal(c.value[SL_COUNT_TRIANGLES_SUBMITTED], c.value[SL_COUNT_TRIANGLES_CULLED] +
                         c.value[SL_COUNT_TRIANGLES_DROPPED] + c.value[SL_COUNT_TRIANGLES_RASTERIZED]);
        assert_true(c.value[SL_COUNT_CLUSTERS_CULLED] > 0);
        assert_true(c.value[SL_COUNT_CLUSTERS_CULLED] < c.value[SL_COUNT_CLUSTERS_TESTED]);
        assert_int_equal(c.value[SL_COUNT_RASTER_PASSES], 1);
    }
    destroy_raster(raster, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plane_through_the_eyes_height_ends_at_the_horizon),
        cmocka_unit_test(an_oblique_near_plane_keeps_triangles_that_reach_behind_the_eye),
        cmocka_unit_test(a_view_that_meets_nothing_draws_nothing_and_some_are_found_to_meet_nothing),
        cmocka_unit_test(vertices_that_are_not_finite_are_dropped_and_counted),
        cmocka_unit_test(every_triangle_is_accounted_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
