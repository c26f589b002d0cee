/* Cone against grid: no triangle that a ray inside the cone hits is missing, and what lies far from the cone is not in the
 * list. */
#include "raster/views/grid.h"
#include "raster/views/light_view.h"
#include "raster_support.h"

#include "base/math.h"
#include "raster/internal.h"

/* ---- brute force ---- */

/* Moeller and Trumbore 1997, in double; distance along d, or -1. */
static double hit_distance(const sl_scene *s, uint32_t t, sl_vec3d origin, sl_vec3d d) {
    sl_vec3d p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_to_double(sl_scene_position(s, s->vertex[k][t]));
    sl_vec3d e1 = sl_subd(p[1], p[0]), e2 = sl_subd(p[2], p[0]), h = sl_crossd(d, e2), from = sl_subd(origin, p[0]);
    double det = sl_dotd(e1, h);
    if (det == 0.0) return -1.0;
    double u = sl_dotd(from, h) / det;
    sl_vec3d q = sl_crossd(from, e1);
    double v = sl_dotd(d, q) / det, at = sl_dotd(e2, q) / det;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && at > 0.0 ? at : -1.0;
}

/* A direction off the axis by at most the half angle, often exactly at its rim. */
static sl_vec3d direction_inside(const sl_cone *cone, uint64_t key, uint64_t n) {
    sl_frame frame = sl_frame_from_normal(sl_normalize_or(cone->axis, sl_v3(0, 0, 1)));
    double least = (double)cone->cosine + 1e-6, unit = n % 3 ? (double)sl_random_unit(key, 2 * n) : 1.0;
    double cosine = 1.0 - (1.0 - least) * unit, phi = 2.0 * SL_PI * (double)sl_random_unit(key, 2 * n + 1);
    double sine = sqrt(fmax(0.0, 1.0 - cosine * cosine));
    sl_vec3d x = sl_to_double(frame.x), y = sl_to_double(frame.y), z = sl_to_double(frame.z);
    return sl_addd(sl_scaled(z, cosine), sl_addd(sl_scaled(x, sine * sl_cos(phi)), sl_scaled(y, sine * sl_sin(phi))));
}

static bool *listed_of(const sl_grid_hits *hits, size_t triangles) {
    bool *listed = calloc(triangles + 1, sizeof *listed);
    assert_non_null(listed);
    for (size_t i = 0; i < hits->count; i++) {
        assert_true(hits->triangle[i] < triangles);
        assert_true(i == 0 || hits->triangle[i] > hits->triangle[i - 1]); /* ascending, each once */
        listed[hits->triangle[i]] = true;
    }
    return listed;
}

static size_t check_none_missing(const sl_scene *s, const sl_cone *cone, const bool *listed, uint64_t key, uint64_t rays) {
    size_t hits = 0;
    sl_vec3d axis = sl_to_double(sl_normalize_or(cone->axis, sl_v3(0, 0, 1)));
    for (uint64_t r = 0; r < rays; r++) {
        sl_vec3d d = direction_inside(cone, key, r);
        for (uint32_t t = 0; t < s->triangle_count; t++) {
            double at = hit_distance(s, t, sl_to_double(cone->apex), d);
            if (at < 0.0 || at * sl_dotd(axis, d) > (double)cone->length) continue;
            hits++;
            if (!listed[t]) fail_msg("triangle %u is hit at %g and not listed", t, at);
        }
    }
    return hits;
}

/* A triangle whose sphere is further from the cone than a cell's diagonal is in no cell that meets the cone. The distance is
 * the exact one to the cone without end, negative within. */
static void check_none_far(const sl_scene *s, const sl_cone *cone, double cell, const bool *listed) {
    sl_vec3d axis = sl_to_double(sl_normalize_or(cone->axis, sl_v3(0, 0, 1)));
    double cosine = (double)cone->cosine, sine = sqrt(1.0 - cosine * cosine);
    for (uint32_t t = 0; t < s->triangle_count; t++) {
        sl_vec3d p[3], middle = {0, 0, 0};
        for (int k = 0; k < 3; k++) p[k] = sl_to_double(sl_scene_position(s, s->vertex[k][t]));
        for (int k = 0; k < 3; k++) middle = sl_addd(middle, sl_scaled(p[k], 1.0 / 3.0));
        double radius = 0.0;
        for (int k = 0; k < 3; k++) radius = fmax(radius, sl_lengthd(sl_subd(p[k], middle)));
        sl_vec3d v = sl_subd(middle, sl_to_double(cone->apex));
        double h = sl_dotd(v, axis), rho = sl_lengthd(sl_subd(v, sl_scaled(axis, h)));
        double behind = h * cosine + rho * sine, distance = behind < 0.0 ? fmin(sl_lengthd(v), fmax(-h, rho * cosine - h * sine))
                                                                         : rho * cosine - h * sine;
        distance = fmax(distance, h - (double)cone->length);
        if (distance > radius + 1.7330 * cell) assert_false(listed[t]);
    }
}

static sl_cone random_cone(const sl_scene *s, uint64_t key, uint64_t n) {
    float length = n % 4 == 0 ? INFINITY : random_between(key, 8 * n, 0.01f, 1.0f) * s->diagonal;
    float spread = sl_exp2f(random_between(key, 8 * n + 1, -12.0f, 0.0f)); /* 1 - cos */
    sl_vec3 apex = sl_v3(random_between(key, 8 * n + 2, s->box_min.x - 1, s->box_max.x + 1),
                         random_between(key, 8 * n + 3, s->box_min.y - 1, s->box_max.y + 1),
                         random_between(key, 8 * n + 4, s->box_min.z - 1, s->box_max.z + 1));
    if (n % 5 == 0) apex = sl_scene_position(s, sl_random_bits(key, 8 * n + 5) % (uint32_t)s->vertex_count);
    sl_vec3 axis = n % 7 == 0 ? sl_v3(0, n % 2 ? 1 : -1, 0) : sl_scale(random_direction(key, 8 * n + 6), 1 + (float)(n % 3));
    return (sl_cone){apex, axis, 1.0f - spread, length};
}

static sl_grid *grid_of(const sl_scene *scene, int cells, sl_grid_scratch **scratch) {
    sl_grid *grid = NULL;
    assert_int_equal(sl_grid_create(scene, cells, 2, &grid, NULL), SL_OK);
    assert_int_equal(sl_grid_scratch_create(grid, scratch, NULL), SL_OK);
    return grid;
}

static sl_scene *random_triangles(uint64_t key, size_t count, float reach) {
    float *xyz = malloc(9 * count * sizeof *xyz);
    assert_non_null(xyz);
    for (size_t t = 0; t < count; t++) {
        float size = t % 50 ? sl_exp2f(random_between(key, 20 * t + 12, -8, -1)) * reach : reach;
        for (size_t i = 0; i < 9; i++) {
            xyz[9 * t + i] = random_between(key, 20 * t + i % 3, -reach, reach) + random_between(key, 20 * t + 3 + i, -size, size);
        }
    }
    sl_scene *scene = scene_of_triangles(xyz, count);
    free(xyz);
    return scene;
}

/* ---- tests ---- */

static void check_scene(sl_scene *scene, int cells, uint64_t key, uint64_t cones, size_t least_hits) {
    sl_grid_scratch *scratch = NULL;
    sl_grid *grid = grid_of(scene, cells, &scratch);
    size_t hits = 0;
    for (uint64_t n = 0; n < cones; n++) {
        sl_cone cone = random_cone(scene, key, n);
        sl_grid_hits found = sl_grid_cone(grid, &cone, scratch);
        bool *listed = listed_of(&found, scene->triangle_count);
        hits += check_none_missing(scene, &cone, listed, key + n, 30);
        check_none_far(scene, &cone, sl_grid_cell_size(grid), listed);
        free(listed);
    }
    if (hits < least_hits) fail_msg("only %zu hits", hits);
    sl_grid_scratch_destroy(scratch);
    sl_grid_destroy(grid);
    sl_scene_destroy(scene);
}

static void no_triangle_that_a_ray_in_the_cone_hits_is_missing(void **state) {
    (void)state;
    check_scene(furnished_room(10, 4), 0, sl_random_key(51, 0), 200, 3000);
    check_scene(random_triangles(sl_random_key(51, 1), 1000, 1.0f), 0, sl_random_key(51, 2), 200, 2000);
    check_scene(random_triangles(sl_random_key(51, 3), 300, 1.0f), 40, sl_random_key(51, 4), 100, 300);
    check_scene(random_triangles(sl_random_key(51, 5), 300, 1.0f), 1, sl_random_key(51, 6), 50, 100);
}

static void scales_and_flat_scenes_lose_nothing(void **state) {
    (void)state;
    check_scene(random_triangles(sl_random_key(52, 0), 300, 1e-6f), 0, sl_random_key(52, 1), 100, 0);
    check_scene(random_triangles(sl_random_key(52, 2), 300, 1e9f), 0, sl_random_key(52, 3), 100, 300);
    float flat[9 * 200];
    uint64_t key = sl_random_key(52, 4);
    for (size_t i = 0; i < 9 * 200; i++) flat[i] = i % 3 == 1 ? 0.0f : random_between(key, i, -1, 1);
    check_scene(scene_of_triangles(flat, 200), 0, sl_random_key(52, 5), 100, 300);
    const float one[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    check_scene(scene_of_triangles(one, 1), 0, sl_random_key(52, 6), 100, 1);
}

static void a_narrow_cone_meets_few_cells(void **state) {
    (void)state;
    sl_scene *scene = furnished_room(40, 8);
    sl_grid_scratch *scratch = NULL;
    sl_grid *grid = grid_of(scene, 0, &scratch);
    size_t listed = 0, met = 0, tested = 0;
    const uint64_t cones = 100;
    for (uint64_t n = 0; n < cones; n++) { /* a lamp of 0.5 on the ceiling, from random points of the floor */
        uint64_t key = sl_random_key(53, n);
        sl_vec3 apex = sl_v3(random_between(key, 0, 0, 4), 0.001f, random_between(key, 1, 0, 5));
        sl_vec3 lamp[4] = {{1.75f, 2.95f, 2.25f}, {2.25f, 2.95f, 2.25f}, {2.25f, 2.95f, 2.75f}, {1.75f, 2.95f, 2.75f}};
        sl_cone cone = sl_cone_around(apex, lamp, 4);
        assert_true(cone.length < 5.2f);
        for (int k = 0; k < 4; k++) {
            sl_vec3d d = sl_subd(sl_to_double(lamp[k]), sl_to_double(apex));
            assert_true(sl_dotd(d, sl_to_double(cone.axis)) >= sl_lengthd(d) * (double)cone.cosine);
        }
        sl_grid_hits hits = sl_grid_cone(grid, &cone, scratch);
        listed += hits.count;
        met += hits.cells_met;
        tested += hits.boxes_tested;
    }
    assert_true(listed < cones * scene->triangle_count / 10);
    assert_true(met < cones * sl_grid_cell_count(grid) / 20);
    assert_true(tested < cones * sl_grid_cell_count(grid) / 5);
    sl_cone away = {sl_v3(2, 10, 2), sl_v3(0, 1, 0), 0.5f, INFINITY}; /* looks away from the room */
    assert_int_equal(sl_grid_cone(grid, &away, scratch).count, 0);
    sl_cone into = {sl_v3(2, 10, 2), sl_v3(0, -1, 0), 0.5f, 6.9f}; /* ends before it */
    assert_int_equal(sl_grid_cone(grid, &into, scratch).count, 0);
    sl_grid_scratch_destroy(scratch);
    sl_grid_destroy(grid);
    sl_scene_destroy(scene);
}

static void cones_that_are_none_hold_everything(void **state) {
    (void)state;
    sl_scene *scene = furnished_room(2, 4);
    sl_grid_scratch *scratch = NULL;
    sl_grid *grid = grid_of(scene, 0, &scratch);
    sl_vec3 apex = sl_v3(2, 1, 2), up = sl_v3(0, 1, 0);
    const sl_cone all[] = {{apex, {0, 0, 0}, 0.5f, 1}, {apex, up, -0.1f, 1},    {apex, up, NAN, 1},
                           {apex, up, 0.5f, NAN},      {{NAN, 0, 0}, up, 0.5f, 1}, {apex, {0, NAN, 0}, 0.5f, 1},
                           sl_cone_around(apex, &apex, 1)};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        assert_int_equal(sl_grid_cone(grid, &all[i], scratch).count, scene->triangle_count);
    }
    sl_cone half_space = {sl_v3(2, 1.5f, 2), up, 0.0f, INFINITY};
    size_t count = sl_grid_cone(grid, &half_space, scratch).count;
    assert_true(count > 128 && count < scene->triangle_count); /* the ceiling, but not the floor */
    sl_grid_scratch_destroy(scratch);
    sl_grid_destroy(grid);
    sl_scene_destroy(scene);
}

static void the_grid_is_the_same_at_any_number_of_threads(void **state) {
    (void)state;
    sl_scene *scene = furnished_room(5, 4);
    sl_grid *one = NULL, *three = NULL;
    sl_grid_scratch *scratch_one = NULL, *scratch_three = NULL;
    assert_int_equal(sl_grid_create(scene, 0, 1, &one, NULL), SL_OK);
    assert_int_equal(sl_grid_create(scene, 0, 3, &three, NULL), SL_OK);
    assert_int_equal(sl_grid_memory_bytes(one), sl_grid_memory_bytes(three));
    assert_int_equal(sl_grid_scratch_create(one, &scratch_one, NULL), SL_OK);
    assert_int_equal(sl_grid_scratch_create(three, &scratch_three, NULL), SL_OK);
    for (uint64_t n = 0; n < 50; n++) {
        sl_cone cone = random_cone(scene, sl_random_key(54, 0), n);
        sl_grid_hits a = sl_grid_cone(one, &cone, scratch_one), b = sl_grid_cone(three, &cone, scratch_three);
        assert_int_equal(a.count, b.count);
        assert_int_equal(a.cells_met, b.cells_met);
        assert_memory_equal(a.triangle, b.triangle, a.count * sizeof *a.triangle);
    }
    sl_grid_scratch_destroy(scratch_one);
    sl_grid_scratch_destroy(scratch_three);
    sl_grid_destroy(one);
    sl_grid_destroy(three);
    sl_scene_destroy(scene);
}

/* A light's pyramid is drawn with the listed triangles alone, and nothing is different up to the light. */
static void a_lights_window_is_the_same_with_and_without_culling(void **state) {
    (void)state;
    sl_scene *scene = furnished_room(20, 6);
    sl_raster *raster = raster_of(scene);
    sl_grid_scratch *scratch = NULL;
    sl_grid *grid = grid_of(scene, 0, &scratch);
    float *subset = malloc(scene->triangle_count * 9 * sizeof *subset);
    assert_non_null(subset);
    sl_vec3 q[4] = {{1.5f, 2.99f, 2.0f}, {2.5f, 2.99f, 2.0f}, {2.5f, 2.99f, 3.0f}, {1.5f, 2.99f, 3.0f}};
    sl_vec3 lamp[6] = {q[0], q[1], q[2], q[0], q[2], q[3]};
    sl_light_shape shape = {lamp, 2, true};
    static uint32_t all[64 * 64], few[64 * 64];
    static float all_depth[64 * 64], few_depth[64 * 64];
    for (uint64_t n = 0; n < 40; n++) {
        sl_vec3 eye = sl_v3(random_between(sl_random_key(9, 0), 2 * n, 0.1f, 3.9f), 0.01f, random_between(sl_random_key(9, 0), 2 * n + 1, 0.1f, 4.9f));
        sl_light_view view;
        assert_int_equal(sl_view_light(eye, sl_v3(0, 1, 0), &shape, 64, 64, 1e-4f, &view), SL_LIGHT_IN_VIEW);
        sl_cone cone = sl_cone_around(eye, lamp, 6); /* the pyramid is square: its corners reach a little further */
        const float tangents[4][2] = {{view.left, view.bottom}, {view.right, view.bottom}, {view.right, view.top}, {view.left, view.top}};
        sl_vec3 rim[4];
        for (int k = 0; k < 4; k++) {
            rim[k] = sl_add(eye, sl_frame_to_world(&view.frame, sl_scale(sl_v3(tangents[k][0], tangents[k][1], 1), 2.0f * view.farthest)));
        }
        cone = sl_cone_around(eye, rim, 4);
        sl_grid_hits hits = sl_grid_cone(grid, &cone, scratch);
        assert_true(hits.count > 0 && hits.count < scene->triangle_count);
        for (size_t i = 0; i < hits.count; i++) {
            for (int k = 0; k < 3; k++) {
                sl_vec3 p = sl_scene_position(scene, scene->vertex[k][hits.triangle[i]]);
                memcpy(&subset[9 * i + 3 * (size_t)k], &p, sizeof p);
            }
        }
        sl_scene *part = scene_of_triangles(subset, hits.count);
        assert_int_equal(part->triangle_count, hits.count);
        sl_raster *part_raster = raster_of(part);
        render_small(raster, &view.view, all, all_depth);
        render_small(part_raster, &view.view, few, few_depth);
        for (int i = 0; i < 64 * 64; i++) {
            assert_int_equal(few[i] == SL_NO_INDEX ? SL_NO_INDEX : hits.triangle[few[i]], all[i]);
            assert_true(few_depth[i] == all_depth[i]);
        }
        sl_raster_destroy(part_raster);
        sl_scene_destroy(part);
    }
    free(subset);
    sl_grid_scratch_destroy(scratch);
    sl_grid_destroy(grid);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

/* Every triangle that a ray in the cone hits is in a listed cluster. */
static void clusters_in_a_cone_are_conservative_and_few(void **state) {
    (void)state;
    sl_scene *scene = furnished_room(40, 8);
    sl_raster *raster = raster_of(scene);
    size_t all = sl_raster_cluster_count(raster), kept = 0;
    uint32_t *clusters = malloc((all + 1) * sizeof *clusters);
    assert_non_null(clusters);
    sl_cone everything = {sl_v3(0, 0, 0), sl_v3(0, 0, 0), 1, 1};
    assert_int_equal(sl_raster_clusters_in_cone(raster, &everything, clusters), all);
    for (uint64_t n = 0; n < 30; n++) {
        sl_cone cone = {sl_v3(2, 1.5f, 2.5f), random_direction(sl_random_key(55, 0), n), 0.98f, INFINITY};
        size_t count = sl_raster_clusters_in_cone(raster, &cone, clusters);
        bool *listed = calloc(scene->triangle_count, sizeof *listed);
        assert_non_null(listed);
        for (size_t i = 0; i < count; i++) {
            const uint32_t first = raster->first_triangle[clusters[i]], triangles = raster->triangles[clusters[i]];
            for (uint32_t t = 0; t < triangles; t++) listed[raster->triangle[first + t]] = true;
        }
        assert_true(check_none_missing(scene, &cone, listed, sl_random_key(56, n), 20) >= 20);
        free(listed);
        kept += count;
    }
    assert_true(kept < 30 * all / 2);
    free(clusters);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_triangle_that_a_ray_in_the_cone_hits_is_missing),
        cmocka_unit_test(scales_and_flat_scenes_lose_nothing),
        cmocka_unit_test(a_narrow_cone_meets_few_cells),
        cmocka_unit_test(cones_that_are_none_hold_everything),
        cmocka_unit_test(the_grid_is_the_same_at_any_number_of_threads),
        cmocka_unit_test(a_lights_window_is_the_same_with_and_without_culling),
        cmocka_unit_test(clusters_in_a_cone_are_conservative_and_few),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
