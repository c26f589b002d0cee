/* The gather's weights and walls against closed forms, sums and quadrature. */
#include "unit_test.h"
#include "base/math.h"
#include "cache/hemisphere/gather_tables.h"
#include "polygon_truth.h"

static void assert_near(double a, double b, double eps) {
    if (!(fabs(a - b) <= eps)) fail_msg("%.15g is not %.15g (+- %g)", a, b, eps);
}

/* Simpson's rule. */
static double quadrature(double (*f)(double, const double *), const double *c, double a, double b) {
    enum { STEPS = 2000 };
    double h = (b - a) / STEPS, sum = f(a, c) + f(b, c);
    for (int i = 1; i < STEPS; i++) sum += f(a + h * i, c) * (i % 2 ? 4.0 : 2.0);
    return sum * h / 3.0;
}
static double wall_kernel(double v, const double *c) {
    double l = 1.0 + c[0] * c[0] + v * v;
    return 1.0 / (l * l);
}
static double side_kernel(double z, const double *c) {
    double l = 1.0 + c[0] * c[0] + z * z;
    return z / (l * l);
}

static void walls_equal_quadrature(void **state) {
    for (int i = 0; i < 50; i++) {
        double c = -2.5 + 0.1 * i, v0 = -1.3 + 0.03 * i, v1 = v0 + 0.4;
        sl_vec3d g = sl_wall_vector(sl_v3d(c, v0, 1), sl_v3d(c, v1, 1));
        assert_near(g.x, quadrature(wall_kernel, &c, v0, v1), 1e-14); /* dE/dx, and dE/dz = -c dE/dx */
        assert_near(g.y, 0.0, 1e-15);
        assert_near(g.z, -c * g.x, 1e-14);
        double z0 = 0.01 * i, z1 = z0 + 0.2; /* a wall of a hemicube's side: K_u */
        sl_vec3d side = sl_wall_vector(sl_v3d(1, c, z0), sl_v3d(1, c, z1));
        assert_near(fabs(side.y), quadrature(side_kernel, &c, z0, z1), 1e-14);
        assert_near(side.x, -c * side.y, 1e-14);
    }
    /* no edge, and one through the eye */
    sl_vec3d none = sl_wall_vector(sl_v3d(0.1, 0.2, 1), sl_v3d(0.1, 0.2, 1));
    assert_near(none.x, 0.0, 0.0);
    none = sl_wall_vector(sl_v3d(0, 0, 1), sl_v3d(0, 0, -1));
    assert_near(none.x, 0.0, 0.0);
}

static double total(const float *plane, size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += (double)plane[i];
    return sum;
}

static void every_instrument_weighs_pi(void **state) {
    const sl_gather_kind kinds[] = {SL_GATHER_PLANE, SL_GATHER_HEMICUBE, SL_GATHER_RAYS};
    const int sizes[] = {4, 20, 37, 64};
    for (size_t k = 0; k < 12; k++) {
        sl_gather_tables *t;
        assert_int_equal(sl_gather_tables_create(kinds[k % 3], sizes[k / 3], 2.7, SL_BORDER_RADIAL, true, &t,
                                                 NULL),
                         SL_OK);
        assert_near(t->weight_sum, SL_PI, 1e-12);
        assert_near(total(t->weight, t->padded), SL_PI, 1e-6);
        assert_near(total(t->vector_x, t->padded), 0.0, 1e-6);
        assert_near(total(t->vector_y, t->padded), 0.0, 1e-6);
        assert_int_equal(t->used, kinds[k % 3] == SL_GATHER_HEMICUBE ? 3 * t->cells / 4 : t->cells);
        for (size_t i = 0; i < t->used; i++) assert_true(t->weight[t->order[i]] > 0.0f);
        sl_gather_tables_destroy(t);
    }
}

static void both_borders_weigh_pi_and_none_what_the_plane_covers(void **state) {
    const double covered = 4 * sqrt(0.8) * sl_atan(sqrt(0.8)); /* 4 s atan s, s the sine of the half angle */
    for (sl_border border = SL_BORDER_LC04; border <= SL_BORDER_PLAIN; border++) {
        sl_gather_tables *t;
        assert_int_equal(sl_gather_tables_create(SL_GATHER_PLANE, 64, 2.0, border, true, &t, NULL), SL_OK);
        assert_near(t->weight_sum, border == SL_BORDER_PLAIN ? covered : SL_PI, 1e-12);
        if (border == SL_BORDER_LC04) assert_near(SL_PI / t->scale, covered, 1e-12);
        /* the middle of an edge with what lies beyond it, and the centre */
        if (border == SL_BORDER_RADIAL) assert_near((double)t->weight[32], 1.64e-4 + 3.12e-3, 1e-5);
        if (border == SL_BORDER_RADIAL) assert_near((double)t->weight[32 * 64 + 32], 3.89e-3, 1e-5);
        sl_gather_tables_destroy(t);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walls_equal_quadrature),
        cmocka_unit_test(every_instrument_weighs_pi),
        cmocka_unit_test(both_borders_weigh_pi_and_none_what_the_plane_covers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
