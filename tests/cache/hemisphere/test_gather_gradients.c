/* Gradients, and second derivatives along the tangent plane, against closed forms (Lambert's of polygon
 * lights with an occluder before them and without, the inside of a sphere) and against differences. */
#include "unit_test.h"
#include "base/math.h"
#include "gather_world.h"
#include "polygon_truth.h"

static sl_gather_settings settings_of(sl_gather_kind kind, int size) {
    sl_gather_settings s = gather_settings(kind, size);
    s.jitter = false;
    return s;
}

static world *light_above(bool occluder) {
    world *w = world_new();
    world_quad(w, sl_v3(-0.7f, -0.4f, 1.3f), sl_v3(-0.7f, 0.9f, 1.3f), sl_v3(1.1f, 0.9f, 1.3f),
               sl_v3(1.1f, -0.4f, 1.3f), world_material(w, sl_grey(0), sl_grey(5)));
    if (occluder) {
        world_quad(w, sl_v3(-0.1f, -0.2f, 0.6f), sl_v3(-0.1f, 0.45f, 0.6f), sl_v3(0.5f, 0.45f, 0.6f),
                   sl_v3(0.5f, -0.2f, 0.6f), world_material(w, sl_grey(0), sl_grey(0)));
    }
    world_build(w);
    return w;
}

static void polygon_light_moves_and_turns_as_its_closed_form(void **state) {
    world *w = light_above(false);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = settings_of(gather_kinds[k], 256);
        sl_irradiance e = gather_once(w, &s, sl_v3(0.35f, 0.2f, 0), sl_v3(0, 0, 1));
        assert_within((double)e.value.g, 4.643140759564, 0.08);
        assert_within((double)e.translational[1].x, -0.648396539400, 0.08);
        assert_within((double)e.translational[1].y, 0.305188879962, 0.08);
        assert_within((double)e.translational[1].z, 0, 0);
        assert_within((double)e.rotational[1].x, -0.136330404, 0.06);
        assert_within((double)e.rotational[1].y, -0.326685256, 0.06);
        assert_within((double)e.rotational[1].z, 0, 0);
    }
    world_free(w);
}

/* The wall is cut by the horizon; the second normal is tilted. The plane does not see down to the horizon. */
static void clipped_wall_moves_as_its_closed_form(void **state) {
    world *w = world_new();
    world_quad(w, sl_v3(1.2f, -0.5f, -0.6f), sl_v3(1.2f, -0.5f, 1.1f), sl_v3(1.2f, 0.9f, 1.1f),
               sl_v3(1.2f, 0.9f, -0.6f), world_material(w, sl_grey(0), sl_grey(5)));
    world_build(w);
    for (int k = 1; k < 3; k++) {
        sl_gather_settings s = settings_of(gather_kinds[k], 256);
        sl_irradiance e = gather_once(w, &s, sl_v3(0.1f, 0.2f, 0), sl_v3(0, 0, 1));
        assert_within((double)e.value.r, 1.338699193443, 0.03);
        assert_within((double)e.translational[0].x, 2.136970274, 0.08);
        assert_within((double)e.translational[0].y, 0, 0.05);
        sl_vec3 n = sl_v3(0.36f, 0.48f, 0.8f);
        e = gather_once(w, &s, sl_v3(0.1f, 0.2f, 0), n);
        assert_within((double)e.value.r, 2.726858117647, 0.04);
        double exact[3] = {3.302700934, -1.501339400, -1.379378227}; /* its tangential part */
        double along = exact[0] * 0.36 + exact[1] * 0.48 + exact[2] * 0.8;
        assert_within((double)e.translational[0].x, exact[0] - along * 0.36, 0.1);
        assert_within((double)e.translational[0].y, exact[1] - along * 0.48, 0.1);
        assert_within((double)e.translational[0].z, exact[2] - along * 0.8, 0.1);
    }
    world_free(w);
}

/* Silhouettes of an occluder move with the occluder, not with what lies behind: without that the gradient has
 * another sign. */
static void occluder_moves_before_the_light(void **state) {
    world *w = light_above(true);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = settings_of(gather_kinds[k], 256);
        sl_irradiance e = gather_once(w, &s, sl_v3(0.35f, 0.2f, 0), sl_v3(0, 0, 1));
        assert_within((double)e.value.b, 1.48128, 0.06);
        assert_within((double)e.translational[2].x, 2.3814, 0.12);
        assert_within((double)e.translational[2].y, 3.1224, 0.15);
    }
    world_free(w);
}

/* L = 1 + x / 2 on the unit sphere, seen from its lowest point: E = pi; moving along the sphere turns the
 * normal as well, and the two gradients cancel. */
static void gradients_cancel_on_the_inside_of_a_sphere(void **state) {
    enum { SHADES = 256 };
    world *w = world_new();
    uint32_t shades[SHADES];
    for (int i = 0; i < SHADES; i++) {
        float x = ((float)i + 0.5f) * (2.0f / SHADES) - 1.0f;
        shades[i] = world_material(w, sl_grey(0), sl_grey(1.0f + 0.5f * x));
    }
    world_sphere(w, 1, 128, shades, SHADES);
    world_build(w);
    for (int k = 1; k < 3; k++) {
        sl_gather_settings s = settings_of(gather_kinds[k], 128);
        sl_irradiance e = gather_once(w, &s, sl_v3(0.003f, 0.002f, -0.9995f), sl_v3(0, 0, 1));
        assert_within((double)e.value.g, SL_PI, 0.01);
        assert_within((double)e.rotational[1].x, 0, 0.02);
        assert_within((double)e.rotational[1].y, SL_PI / 4, gather_kinds[k] == SL_GATHER_RAYS ? 0.03 : 0.01);
        assert_within((double)e.translational[1].x, SL_PI / 4, 0.04);
        assert_within((double)e.translational[1].y, 0, 0.03);
        double step = 0.1; /* n' = (-s, 0, 1): n x n' = (0, -s, 0) */
        assert_within(step * (double)e.translational[1].x - step * (double)e.rotational[1].y, 0, 0.006);
    }
    world_free(w);
}

/* ---- second derivatives ---- */

typedef struct matrix {
    double xx, xy, yy;
} matrix;

/* The eigenvalue of the larger absolute value. */
static double greatest(matrix h) {
    double mean = 0.5 * (h.xx + h.yy), radius = hypot(0.5 * (h.xx - h.yy), h.xy);
    return mean < 0.0 ? mean - radius : mean + radius;
}

static void check(bool occluder, int size, matrix exact, const double tolerance[3]) {
    world *w = light_above(occluder);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = settings_of(gather_kinds[k], size);
        sl_irradiance e = gather_once(w, &s, sl_v3(0.35f, 0.2f, 0), sl_v3(0, 0, 1));
        print_message("instrument %d, N = %d: %.3f, exact %.3f\n", (int)gather_kinds[k], size,
                      (double)e.curvature, greatest(exact));
        assert_within((double)e.curvature, greatest(exact), tolerance[k]);
    }
    world_free(w);
}

/* Rays cut edges at any angle into steps: they are off by a fifth to a third. Where a near edge crosses a far
 * one every wall moves as if it were alone, which is 3 % here. The plane is coarse for the small occluder. */
static void polygon_light_curves_as_its_closed_form(void **state) {
    check(false, 64, (matrix){-4.282, -0.049, -6.084}, (double[3]){0.15, 0.05, 0.2});
    check(false, 256, (matrix){-4.282, -0.049, -6.084}, (double[3]){0.05, 0.02, 0.07});
}

static void occluder_curves_irradiance_before_the_light(void **state) {
    check(true, 64, (matrix){12.92, -2.62, 7.13}, (double[3]){7.0, 0.5, 3.5});
    check(true, 256, (matrix){12.92, -2.62, 7.13}, (double[3]){0.5, 0.5, 2.8});
}

/* Exact gradients differenced. The polygon stands, leans, and is cut by the horizon: its depths differ along
 * every edge. */
static matrix differences(const sl_vec3 corners[4]) {
    const double h = 1e-4;
    sl_vec3d v[4], n = sl_v3d(0, 0, 1), g[4];
    const sl_vec3d steps[4] = {sl_v3d(h, 0, 0), sl_v3d(-h, 0, 0), sl_v3d(0, h, 0), sl_v3d(0, -h, 0)};
    for (int i = 0; i < 4; i++) v[i] = sl_to_double(corners[i]);
    for (int i = 0; i < 4; i++) polygon_irradiance(steps[i], n, v, 4, &g[i]);
    return (matrix){(g[0].x - g[1].x) / (2 * h), (g[0].y - g[1].y + g[2].x - g[3].x) / (4 * h),
                    (g[2].y - g[3].y) / (2 * h)};
}

static void walls_curve_as_differences_of_their_closed_form(void **state) {
    static const sl_vec3 walls[2][4] = {
        {{0.9f, -1.5f, -0.5f}, {0.9f, -1.5f, 1.9f}, {0.9f, 1.1f, 1.9f}, {0.9f, 1.1f, -0.5f}},
        {{0.3f, -0.7f, 0.8f}, {-0.5f, -0.6f, 1.6f}, {-0.4f, 0.8f, 1.4f}, {0.4f, 0.7f, 0.6f}},
    };
    for (int i = 0; i < 2; i++) {
        world *w = world_new();
        world_quad(w, walls[i][0], walls[i][1], walls[i][2], walls[i][3],
                   world_material(w, sl_grey(0), sl_grey(1)));
        world_build(w);
        matrix exact = differences(walls[i]);
        double size = fabs(exact.xx) + fabs(exact.xy) + fabs(exact.yy);
        for (int k = i == 0 ? 1 : 0; k < 3; k++) { /* the plane does not see down to the horizon */
            sl_gather_settings s = settings_of(gather_kinds[k], 256);
            sl_irradiance e = gather_once(w, &s, sl_v3(0, 0, 0), sl_v3(0, 0, 1));
            print_message("wall %d, instrument %d: %.3f, exact %.3f\n", i, (int)gather_kinds[k],
                          (double)e.curvature, greatest(exact));
            assert_within((double)e.curvature, greatest(exact), 0.08 * size);
        }
        world_free(w);
    }
}

static void nothing_seen_has_no_curvature(void **state) {
    world *w = world_new();
    world_quad(w, sl_v3(-1, -1, -1), sl_v3(1, -1, -1), sl_v3(1, 1, -1), sl_v3(-1, 1, -1),
               world_material(w, sl_grey(0.5f), sl_grey(1)));
    world_build(w);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = settings_of(gather_kinds[k], 16);
        sl_irradiance e = gather_once(w, &s, sl_v3(0, 0, 0), sl_v3(0, 0, 1));
        assert_true(e.curvature == 0.0f);
    }
    world_free(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(polygon_light_moves_and_turns_as_its_closed_form),
        cmocka_unit_test(clipped_wall_moves_as_its_closed_form),
        cmocka_unit_test(occluder_moves_before_the_light),
        cmocka_unit_test(gradients_cancel_on_the_inside_of_a_sphere),
        cmocka_unit_test(polygon_light_curves_as_its_closed_form),
        cmocka_unit_test(occluder_curves_irradiance_before_the_light),
        cmocka_unit_test(walls_curve_as_differences_of_their_closed_form),
        cmocka_unit_test(nothing_seen_has_no_curvature),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
