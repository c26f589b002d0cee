/* Vertices behind the eye, at the eye, on the near plane, beyond the screen, and not finite at all. */
#include "raster_support.h"

enum { SIZE = 48, PIXELS = SIZE * SIZE };

static sl_view random_pyramid(uint64_t key, uint64_t n, sl_vec3 eye, float tangent, float near) {
    sl_frame frame = sl_frame_from_normal(random_direction(key, n));
    return sl_view_pyramid(&frame, eye, -tangent, tangent, -tangent, tangent, SIZE, SIZE, near);
}

/* Taking one triangle away must uncover just its pixels: then no other triangle claimed them, and each was drawn once. */
static void assert_covered_exactly_once(const sl_raster *raster, size_t triangles, sl_view view) {
    uint32_t all[PIXELS], without[PIXELS];
    float depth[PIXELS];
    render(raster, &view, 1, all, depth);
    for (int i = 0; i < PIXELS; i++) {
        assert_true(all[i] < triangles);
        assert_true(depth[i] > 0.0f && isfinite(depth[i]));
    }
    for (uint32_t t = 0; t < triangles; t++) {
        view.skip_triangle = t;
        render(raster, &view, 1, without, depth);
        for (int i = 0; i < PIXELS; i++) assert_int_equal(without[i], all[i] == t ? SL_NO_INDEX : all[i]);
    }
}

static void watertight_mesh_around_the_eye_covers_each_pixel_exactly_once(void **state) {
    (void)state;
    float xyz[12 * 9 * 9];
    for (uint64_t seed = 0; seed < 12; seed++) {
        uint64_t key = sl_random_key(5, seed);
        int n = 1 + (int)(seed % 3);
        size_t count = add_box(xyz, 0, sl_v3(-1, -2, -1.5f), sl_v3(3, 1, 1.25f), n, NULL, NULL);
        sl_scene *scene = scene_of_triangles(xyz, count);
        sl_raster *raster = raster_of(scene);
        sl_vec3 eye = sl_v3(random_between(key, 0, -0.9f, 2.9f), random_between(key, 1, -1.9f, 0.9f),
                            random_between(key, 2, -1.4f, 1.2f));
        assert_covered_exactly_once(raster, count, random_pyramid(key, 1, eye, 1.0f, 1e-4f));
        assert_covered_exactly_once(raster, count, random_pyramid(key, 2, eye, 2.7474774f, 1e-4f));
        assert_covered_exactly_once(raster, count, random_pyramid(key, 3, eye, 0.1f, 1e-4f));
        sl_raster_destroy(raster);
        sl_scene_destroy(scene);
    }
}

static void camera_inside_a_box_sees_every_pixel_with_window_depth(void **state) {
    (void)state;
    float xyz[12 * 4 * 9];
    size_t count = add_box(xyz, 0, sl_v3(-1, -2, -1.5f), sl_v3(3, 1, 1.25f), 2, NULL, NULL);
    sl_scene *scene = scene_of_triangles(xyz, count);
    sl_raster *raster = raster_of(scene);
    sl_camera camera;
    assert_true(sl_camera_look_at(&camera, sl_v3(0.2f, 0.1f, 0.3f), sl_v3(1, -1, 0.5f), sl_v3(0, 1, 0), 1.5f));
    assert_covered_exactly_once(raster, count, sl_view_camera(&camera, SIZE, SIZE, 0.01f, 100.0f));
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void plane_through_the_eyes_height_ends_at_the_horizon(void **state) {
    (void)state;
    /* A floor one below the eye, reaching far behind it; the view looks level. Depth: w = -1 / tangent. */
    const float far = 4000.0f;
    const float xyz[18] = {-far, -1, -far, far, -1, -far, far, -1, far, -far, -1, -far, far, -1, far, -far, -1, far};
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
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void vertex_at_the_eye_or_on_the_near_plane_is_harmless(void **state) {
    (void)state;
    const float near = 0.5f;
    const float xyz[5 * 9] = {
        0, 0, 0, 1, 0.25f, 1, -1, 0.5f, 1,             /* a corner at the eye: seen edge-on */
        -1, -1, near, 1, -1, near, 0, 1, near,         /* in the near plane: inclusive, so it is drawn */
        -3, -3, 2, 3, -3, 2, 0, 3, near,               /* a corner on the near plane */
        -9, -9, 3, 9, -9, 3, 0, 0, -1,                 /* a corner behind the eye, on the axis */
        -2, -2, -near, 2, -2, -near, 0, 2, -near,      /* behind altogether */
    };
    sl_scene *scene = scene_of_triangles(xyz, 5);
    assert_int_equal(scene->triangle_count, 5);
    sl_raster *raster = raster_of(scene);
    sl_frame frame = {sl_v3(1, 0, 0), sl_v3(0, 1, 0), sl_v3(0, 0, 1)};
    sl_view view = sl_view_pyramid(&frame, sl_v3(0, 0, 0), -1, 1, -1, 1, SIZE, SIZE, near);
    uint32_t id[PIXELS];
    float depth[PIXELS];
    sl_counters counters = render(raster, &view, 1, id, depth);
    for (int i = 0; i < PIXELS; i++) {
        assert_true(id[i] == SL_NO_INDEX || id[i] <= 3);
        assert_true(isfinite(depth[i]) && depth[i] >= 0.0f && depth[i] <= 1.0f / near);
    }
    assert_int_equal(id[SIZE / 2 * SIZE + SIZE / 2], 1); /* the nearest at the middle */
    assert_int_equal(counters.value[SL_COUNT_TRIANGLES_DROPPED], 0);
    assert_true(counters.value[SL_COUNT_TRIANGLES_CLIPPED] >= 2);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void vertices_that_are_not_finite_are_dropped_and_counted(void **state) {
    (void)state;
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
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void every_triangle_is_accounted_for(void **state) {
    (void)state;
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
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(watertight_mesh_around_the_eye_covers_each_pixel_exactly_once),
        cmocka_unit_test(camera_inside_a_box_sees_every_pixel_with_window_depth),
        cmocka_unit_test(plane_through_the_eyes_height_ends_at_the_horizon),
        cmocka_unit_test(vertex_at_the_eye_or_on_the_near_plane_is_harmless),
        cmocka_unit_test(vertices_that_are_not_finite_are_dropped_and_counted),
        cmocka_unit_test(every_triangle_is_accounted_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
