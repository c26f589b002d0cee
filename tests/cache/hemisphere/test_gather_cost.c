/* The choice between plane, hemicube and rays: counts alone decide, more work never costs less, and what is known to be cheaper is. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/math.h"
#include "cache/hemisphere/gather_cost.h"
#include "cache/hemisphere/gather_internal.h"
#include "gather_world.h"

static const sl_gather_kind kinds[3] = {SL_GATHER_PLANE, SL_GATHER_HEMICUBE, SL_GATHER_RAYS};

static sl_gather_settings settings_of(sl_gather_kind kind, int size) {
    sl_gather_settings s = sl_gather_defaults();
    s.kind = kind;
    s.size = size;
    s.direct = SL_DIRECT_RAYS;
    return s;
}

static const sl_camera within = {.eye = {0, 0.5f, 0.9f}, .right = {1, 0, 0}, .up = {0, 1, 0}, .back = {0, 0, 1}, .vertical_fov = 1.0f};

/* 12 triangles, seen from within. */
static world *box(void) {
    world *w = world_new();
    uint32_t grey = world_material(w, sl_grey(0.5f), sl_grey(0)), all[6] = {grey, grey, grey, grey, grey, grey};
    world_box(w, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, all);
    world_point_light(w, sl_v3(0, 0.5f, 0), 1);
    world_build(w);
    w->scene->camera = within;
    assert_int_equal(w->scene->triangle_count, 12);
    return w;
}

static world *furnished(void) {
    world *w = world_room(true);
    const sl_scene *s = w->scene;
    w->scene->camera = within;
    w->scene->camera.eye = sl_scale(sl_add(s->box_min, s->box_max), 0.5f);
    return w;
}

static sl_gather_counts counts_of(world *w, sl_gather_kind kind, int size) {
    sl_gather_settings s = settings_of(kind, size);
    gatherer g = gatherer_new(w, &s);
    sl_gather_counts counts;
    assert_int_equal(sl_gather_probe(g.gather, kind, size, &counts, NULL), SL_OK);
    gatherer_free(&g);
    return counts;
}

static double see_cost(world *w, sl_gather_kind kind, int size) {
    sl_gather_counts counts = counts_of(w, kind, size);
    return sl_gather_see_cost(kind, &counts);
}

/* ---- the model ---- */

static void more_of_anything_never_costs_less(void **state) {
    (void)state;
    sl_gather_counts base = {.triangles = 5000, .cells = 4096, .passes = 1, .clusters_tested = 100, .triangles_submitted = 3000,
                             .triangles_rasterized = 1500, .visible = 900, .hits = 4000, .samples = 4000, .shadow_rays = 3000,
                             .shadow_lookups = 4000};
    enum { FIELDS = sizeof(sl_gather_counts) / sizeof(double) };
    for (int k = 0; k < 3; k++) {
        double see = sl_gather_see_cost(kinds[k], &base), shade = sl_gather_shade_cost(kinds[k], &base);
        int felt = 0;
        assert_true(see > 0.0 && shade > 0.0);
        for (int f = 0; f < FIELDS; f++) {
            double values[FIELDS];
            sl_gather_counts more;
            memcpy(values, &base, sizeof values);
            values[f] *= 8.0;
            memcpy(&more, values, sizeof more);
            assert_true(sl_gather_see_cost(kinds[k], &more) >= see && sl_gather_shade_cost(kinds[k], &more) >= shade);
            felt += sl_gather_see_cost(kinds[k], &more) > see;
        }
        assert_true(felt >= 3);
    }
}

/* Rays feel the number of triangles through its logarithm, the raster hardware through what is submitted. */
static void rays_feel_triangles_by_their_logarithm(void **state) {
    (void)state;
    sl_gather_counts c = {.cells = 4096, .visible = 900};
    double cost[3];
    for (int i = 0; i < 3; i++) {
        c.triangles = (double)((1 << (8 * (i + 1))) - 2); /* 8, 16, 24 levels */
        cost[i] = sl_gather_see_cost(SL_GATHER_RAYS, &c);
    }
    assert_true(cost[0] < cost[1]);
    assert_true(fabs((cost[2] - cost[1]) / (cost[1] - cost[0]) - 1.0) < 1e-9);
}

static void sizes_reach_the_error_of_the_rays_and_no_less(void **state) {
    (void)state;
    double tangent = sl_tan(70.0 / 180.0 * SL_PI);
    for (int size = 16; size <= 256; size *= 2) {
        double wanted = sl_gather_expected_error(SL_GATHER_RAYS, size, tangent);
        assert_int_equal(sl_gather_size_for(SL_GATHER_RAYS, size, tangent), size);
        for (int k = 0; k < 2; k++) {
            int n = sl_gather_size_for(kinds[k], size, tangent);
            if (n == 0) continue;
            assert_int_equal(n % 2, 0);
            assert_true(sl_gather_expected_error(kinds[k], n, tangent) <= wanted);
            if (n > 4) assert_true(sl_gather_expected_error(kinds[k], n - 2, tangent) > wanted);
        }
        assert_true(sl_gather_size_for(SL_GATHER_HEMICUBE, size, tangent) > 0);
    }
    assert_int_equal(sl_gather_size_for(SL_GATHER_PLANE, 256, tangent), 0); /* it lacks the horizon at any N */
}

static void wider_planes_lack_less(void **state) {
    (void)state;
    double last = 1.0;
    for (int degrees = 90; degrees < 178; degrees += 10) {
        double floor = sl_gather_expected_error(SL_GATHER_PLANE, 1 << 20, sl_tan(degrees / 360.0 * SL_PI));
        assert_true(floor > 0.0 && floor < last);
        last = floor;
    }
}

/* ---- scenes ---- */

static void twelve_triangles_at_256_are_cheaper_to_draw_than_to_trace(void **state) {
    (void)state;
    world *w = box();
    assert_true(2.0 * see_cost(w, SL_GATHER_PLANE, 256) < see_cost(w, SL_GATHER_RAYS, 256));
    assert_true(see_cost(w, SL_GATHER_PLANE, 16) < see_cost(w, SL_GATHER_RAYS, 16));
    world_free(w);
}

/* Means over what the cameras of these scenes see, of planes of 16 x 16 and of 64 x 64; measured by plane and by rays: 0.18 and 0.08 ms, 0.66 and 0.96 ms. */
static void known_views_are_known_to_be_cheaper_to_trace_or_to_draw(void **state) {
    (void)state;
    sl_gather_counts figure = {.triangles = 877770, .cells = 256, .passes = 1, .clusters_tested = 11778, .triangles_submitted = 6840,
                               .triangles_rasterized = 1086, .visible = 132, .hits = 256};
    assert_true(1.5 * sl_gather_see_cost(SL_GATHER_RAYS, &figure) < sl_gather_see_cost(SL_GATHER_PLANE, &figure));
    sl_gather_counts atrium = {.triangles = 66608, .cells = 4096, .passes = 1, .clusters_tested = 1068, .triangles_submitted = 33094,
                               .triangles_rasterized = 9854, .visible = 1880, .hits = 3300};
    assert_true(sl_gather_see_cost(SL_GATHER_PLANE, &atrium) < sl_gather_see_cost(SL_GATHER_RAYS, &atrium));
}

static void the_choice_is_the_cheapest_by_the_model(void **state) {
    (void)state;
    world *worlds[2] = {box(), furnished()};
    for (int i = 0; i < 2; i++) {
        for (int size = 16; size <= 128; size *= 2) {
            sl_gather_settings s = settings_of(SL_GATHER_AUTO, size);
            double tangent = sl_tan(0.5 * (double)s.plane_fov), least = INFINITY;
            sl_gather_kind cheapest = SL_GATHER_AUTO;
            for (int k = 2; k >= 0; k--) {
                int n = sl_gather_size_for(kinds[k], size, tangent);
                if (!n) continue;
                sl_gather_counts c = counts_of(worlds[i], kinds[k], n);
                double cost = sl_gather_see_cost(kinds[k], &c) + sl_gather_shade_cost(kinds[k], &c);
                if (cost < least) least = cost, cheapest = kinds[k];
            }
            gatherer g = gatherer_new(worlds[i], &s);
            assert_int_equal(sl_gather_kind_used(g.gather), cheapest);
            assert_int_equal(g.gather->settings.size, sl_gather_size_for(cheapest, size, tangent));
            gatherer_free(&g);
        }
        world_free(worlds[i]);
    }
}

/* ---- determinism ---- */

static void counts_are_the_same_at_any_instruction_set_and_number_of_threads(void **state) {
    (void)state;
    static const char *const names[3] = {"baseline", "avx2", "avx512"};
    for (int k = 0; k < 3; k++) {
        sl_gather_counts first = {0};
        for (unsigned i = 0; i < 3; i++) {
            setenv("SOFTLUX_ISA", names[i], 1);
            world *w = furnished();
            sl_raster_destroy(w->raster);
            sl_tracer_destroy(w->tracer);
            assert_int_equal(sl_raster_create(w->scene, i + 1, &w->raster, NULL), SL_OK);
            assert_int_equal(sl_tracer_create(w->scene, i + 1, NULL, &w->tracer, NULL), SL_OK);
            sl_gather_counts counts = counts_of(w, kinds[k], 30);
            if (i == 0) first = counts;
            assert_memory_equal(&first, &counts, sizeof first);
            world_free(w);
        }
        assert_true(first.cells > 0 && first.hits > 0 && first.visible > 0 && first.triangles_rasterized > 0 && first.shadow_rays > 0);
    }
    unsetenv("SOFTLUX_ISA");
}

/* A camera that looks at nothing, and one that is none: there are still counts, and a choice. */
static void scenes_that_the_camera_does_not_see_are_probed_from_their_own_surfaces(void **state) {
    (void)state;
    world *w = world_room(true);
    const sl_camera away[2] = {{.eye = {100, 100, 100}, .right = {1, 0, 0}, .up = {0, 1, 0}, .back = {0, 0, -1}, .vertical_fov = 0.5f},
                               {.vertical_fov = 0.0f}};
    for (int i = 0; i < 2; i++) {
        w->scene->camera = away[i];
        sl_gather_counts c = counts_of(w, SL_GATHER_PLANE, 32);
        assert_true(c.cells == 32 * 32 && c.hits > 0 && c.triangles_submitted > 0);
        sl_gather_settings s = settings_of(SL_GATHER_AUTO, 32);
        gatherer g = gatherer_new(w, &s);
        assert_true(sl_gather_kind_used(g.gather) != SL_GATHER_AUTO);
        gatherer_free(&g);
    }
    world_free(w);
}

/* Trials are no part of the bill: with AUTO as without it nothing is counted before the first gather. */
static void probing_is_not_counted(void **state) {
    (void)state;
    world *w = world_room(false);
    sl_gather_settings s = settings_of(SL_GATHER_AUTO, 32);
    sl_gather *gather;
    sl_counters counters = {{0}}, none = {{0}};
    assert_int_equal(sl_gather_create(w->scene, w->raster, w->tracer, &s, 1, &gather, &counters, NULL), SL_OK);
    assert_memory_equal(&counters, &none, sizeof none);
    sl_gather_destroy(gather);
    world_free(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(more_of_anything_never_costs_less),
        cmocka_unit_test(rays_feel_triangles_by_their_logarithm),
        cmocka_unit_test(sizes_reach_the_error_of_the_rays_and_no_less),
        cmocka_unit_test(wider_planes_lack_less),
        cmocka_unit_test(twelve_triangles_at_256_are_cheaper_to_draw_than_to_trace),
        cmocka_unit_test(known_views_are_known_to_be_cheaper_to_trace_or_to_draw),
        cmocka_unit_test(the_choice_is_the_cheapest_by_the_model),
        cmocka_unit_test(counts_are_the_same_at_any_instruction_set_and_number_of_threads),
        cmocka_unit_test(scenes_that_the_camera_does_not_see_are_probed_from_their_own_surfaces),
        cmocka_unit_test(probing_is_not_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
