/* Vertices behind the eye, at the eye, on the near plane, beyond the screen, and not finite at all. */
#include "raster_support.h"

#include "raster/pipeline.h"

enum { SIZE = 48, PIXELS = SIZE * SIZE };

static sl_view random_pyramid(uint64_t key, uint64_t n, sl_vec3 eye, float tangent, float near) {
    sl_frame frame = sl_frame_from_normal(random_direction(key, n));
    return sl_view_pyramid(&frame, eye, -tangent, tangent, -tangent, tangent, SIZE, SIZE, near);
}

static void plane_through_the_eyes_height_ends_at_the_horizon(void **state) {
    (void)state;
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
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

/* The eye looks along a wall from just below a ceiling, and sees the room below a near plane that is level,
 * not upright. Two corners of each of the wall's triangles are above it and some behind the eye: those are
 * not before it for that. */
static void an_oblique_near_plane_keeps_triangles_that_reach_behind_the_eye(void **state) {
    (void)state;
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
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void a_view_that_meets_nothing_draws_nothing_and_some_are_found_to_meet_nothing(void **state) {
    (void)state;
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

/* Corners before, beside and behind the eye, from a thousandth to a million times as far away as the view's
 * own scale. */
static void random_corners(uint64_t key, float *xyz, size_t triangles) {
    for (uint64_t t = 0; t < triangles; t++) {
        sl_vec3 at = sl_v3(random_between(key, 32 * t, -2, 2), random_between(key, 32 * t + 1, -2, 2),
                           random_between(key, 32 * t + 2, -1, 3));
        for (uint64_t k = 0; k < 3; k++) {
            float size = sl_random_unit(key, 32 * t + 3) < 0.7f ? 0.5f : 1e-3f;
            if (sl_random_unit(key, 32 * t + 4 + k) < 0.01f)
                size = random_between(key, 32 * t + 8 + k, 10, 1e6f);
            float *p = &xyz[9 * t + 3 * k];
            p[0] = at.x + size * random_between(key, 32 * t + 12 + 3 * k, -1, 1);
            p[1] = at.y + size * random_between(key, 32 * t + 13 + 3 * k, -1, 1);
            p[2] = at.z + size * random_between(key, 32 * t + 14 + 3 * k, -1, 1);
            if (sl_random_unit(key, 32 * t + 24 + k) < 0.01f) p[2] = 1e-4f * p[0];
        }
    }
}

/* Triangle t's pieces in `many`, in turn, are the same as those in `one`. */
static void assert_same_pieces(const sl_batch *many, uint32_t id, const sl_batch *one) {
    uint32_t found = 0;
    for (uint32_t n = 0; n < many->count; n++) {
        if (many->id[n] != id) continue;
        assert_true(found < one->count);
        for (int k = 0; k < 3; k++) {
            assert_memory_equal(&many->x[k][n], &one->x[k][found], sizeof(float));
            assert_memory_equal(&many->y[k][n], &one->y[k][found], sizeof(float));
            assert_memory_equal(&many->depth[k][n], &one->depth[k][found], sizeof(float));
            assert_int_equal(many->snapped_u[k][n], one->snapped_u[k][found]);
            assert_int_equal(many->snapped_v[k][n], one->snapped_v[k][found]);
        }
        found++;
    }
    assert_int_equal(found, one->count);
}

/* Returns how many of the cluster's triangles the kernel clipped, and adds those that it left. */
static size_t compare_cluster(const sl_raster *raster, uint32_t cluster, const sl_pass_view *pass,
                              sl_raster_scratch *s, size_t *left) {
    size_t clipped = 0;
    uint32_t first = raster->first_triangle[cluster];
    raster->kernels->transform(raster, cluster, pass, &s->vertices);
    raster->kernels->classify(raster, cluster, pass, &s->tile, &s->vertices, &s->classes);
    for (uint32_t n = 0; n < s->classes.clipped; n += SL_LANES) {
        const uint8_t *list = s->classes.clipped_list + n;
        uint32_t count = s->classes.clipped - n < SL_LANES ? s->classes.clipped - n : SL_LANES;
        s->batch.count = 0;
        uint32_t doubtful = raster->kernels->clip(raster, first, pass, &s->vertices, list, count, &s->batch);
        assert_true(doubtful >> count == 0);
        for (uint32_t l = 0; l < count; l++) {
            static sl_batch one;
            uint32_t t = first + list[l];
            uint16_t corner[3] = {raster->corner[0][t], raster->corner[1][t], raster->corner[2][t]};
            one.count = 0;
            if (!(doubtful >> l & 1)) sl_clip_triangle(pass, &s->vertices, corner, &one);
            assert_same_pieces(&s->batch, raster->triangle[t], &one);
            *left += doubtful >> l & 1;
            clipped++;
        }
    }
    return clipped;
}

static void clipping_many_together_gives_the_pieces_of_clipping_one_by_one(void **state) {
    (void)state;
    enum { TRIANGLES = 3000 };
    static float xyz[9 * TRIANGLES];
    size_t clipped = 0, left = 0;
    for (uint64_t seed = 0; seed < 8; seed++) {
        random_corners(sl_random_key(7, seed), xyz, TRIANGLES);
        sl_scene *scene = scene_of_triangles(xyz, TRIANGLES);
        sl_raster *raster = raster_of(scene);
        sl_raster_scratch *scratch;
        assert_int_equal(sl_raster_scratch_create(raster, SIZE, SIZE, &scratch, NULL), SL_OK);
        sl_camera camera;
        assert_true(
            sl_camera_look_at(&camera, sl_v3(0.1f, 0.2f, 0.3f), sl_v3(0.5f, -0.5f, 2), sl_v3(0, 1, 0), 1.2f));
        sl_view views[4] = {random_pyramid(sl_random_key(8, seed), 0, sl_v3(0, 0, 0), 1.0f, 1e-3f),
                            random_pyramid(sl_random_key(8, seed), 1, sl_v3(0, 0, 0.5f), 0.2f, 0.5f),
                            sl_view_camera(&camera, SIZE, SIZE, 0.05f, 3.0f),
                            sl_view_camera(&camera, SIZE, SIZE, 0.5f, 2.0f)};
        views[3].corner_planes = true;
        for (int n = 0; n < 4; n++) {
            sl_pass_view pass = sl_pass_view_make(&views[n], SIZE, SIZE);
            sl_tile_place(&scratch->tile, &pass, 0, 0);
            for (uint32_t c = 0; c < raster->cluster_count; c++)
                clipped += compare_cluster(raster, c, &pass, scratch, &left);
        }
        sl_raster_scratch_destroy(scratch);
        sl_raster_destroy(raster);
        sl_scene_destroy(scene);
    }
    assert_true(clipped > 5000 && left > 100);
    /* of such wild triangles many are left; by narrow vectors all */
    assert_true(left < clipped / 2 || left == clipped);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plane_through_the_eyes_height_ends_at_the_horizon),
        cmocka_unit_test(an_oblique_near_plane_keeps_triangles_that_reach_behind_the_eye),
        cmocka_unit_test(a_view_that_meets_nothing_draws_nothing_and_some_are_found_to_meet_nothing),
        cmocka_unit_test(vertices_that_are_not_finite_are_dropped_and_counted),
        cmocka_unit_test(every_triangle_is_accounted_for),
        cmocka_unit_test(clipping_many_together_gives_the_pieces_of_clipping_one_by_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
