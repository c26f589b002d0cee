/* The gather's weights and walls against closed forms, sums and quadrature. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/math.h"
#include "cache/hemisphere/gather_tables.h"
#include "cache/hemisphere/hemisphere_tables.h"
#include "polygon_truth.h"

static void assert_near(double a, double b, double eps) {
    if (!(fabs(a - b) <= eps)) fail_msg("%.15g is not %.15g (+- %g)", a, b, eps);
}

static double line(int n, double t, int i) { return t * (2.0 * i / n - 1.0); }

static void cells_and_extensions_fill_the_hemisphere(void **state) {
    (void)state;
    const double tangents[] = {1.0, 2.0, 2.7474774194546216, 5.67};
    for (size_t k = 0; k < 4; k++) {
        double t = tangents[k], cosine = 0.0, edges = 0.0;
        for (int y = 0; y < 16; y++) {
            for (int x = 0; x < 16; x++) {
                cosine += sl_plane_cosine_weight(line(16, t, x), line(16, t, x + 1), line(16, t, y),
                                                 line(16, t, y + 1));
            }
            edges += 4.0 * sl_border_vector(t, line(16, t, y), line(16, t, y + 1)).z;
        }
        assert_near(cosine + edges, SL_PI, 1e-13);
        double s = t / sqrt(1.0 + t * t);
        assert_near(cosine / SL_PI, 4.0 / SL_PI * s * sl_atan(s), 1e-13);
    }
    double s = sl_sin(sl_atan(2.0));
    /* of the cosine-weighted hemisphere, what 126.87 degrees see */
    assert_near(4.0 / SL_PI * s * sl_atan(s), 0.8310, 5e-5);
}

static void closed_forms_equal_the_polygon_form(void **state) {
    (void)state;
    for (int i = 0; i < 200; i++) {
        double u0 = -2.0 + 0.019 * i, u1 = u0 + 0.01 + 0.002 * (i % 7), v0 = 1.7 - 0.017 * i, v1 = v0 + 0.02;
        sl_vec3d corners[4] = {sl_v3d(u0, v0, 1), sl_v3d(u1, v0, 1), sl_v3d(u1, v1, 1), sl_v3d(u0, v1, 1)};
        sl_vec3d general = sl_cell_vector(corners, 4), closed = sl_plane_vector(u0, u1, v0, v1);
        assert_near(closed.x, general.x, 1e-15);
        assert_near(closed.y, general.y, 1e-15);
        assert_near(closed.z, general.z, 1e-15);
        assert_near(sl_plane_cosine_weight(u0, u1, v0, v1), general.z, 1e-15);
        assert_true(sl_border_vector(2.0, u0, u1).y > 0.0);
    }
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
    (void)state;
    for (int i = 0; i < 50; i++) {
        double c = -2.5 + 0.1 * i, v0 = -1.3 + 0.03 * i, v1 = v0 + 0.4;
        assert_near(sl_plane_wall(c, v0, v1), quadrature(wall_kernel, &c, v0, v1), 1e-14);
        sl_vec3d g = sl_wall_vector(sl_v3d(c, v0, 1), sl_v3d(c, v1, 1));
        assert_near(g.x, sl_plane_wall(c, v0, v1), 1e-14); /* dE/dx, and dE/dz = -c dE/dx */
        assert_near(g.y, 0.0, 1e-15);
        assert_near(g.z, -c * sl_plane_wall(c, v0, v1), 1e-14);
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
    (void)state;
    const sl_gather_kind kinds[] = {SL_GATHER_PLANE, SL_GATHER_HEMICUBE, SL_GATHER_RAYS};
    const int sizes[] = {4, 20, 37, 64};
    for (size_t k = 0; k < 12; k++) {
        sl_gather_tables *t;
        assert_int_equal(sl_gather_tables_create(kinds[k % 3], sizes[k / 3], 2.7, SL_BORDER_RADIAL, &t, NULL),
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

static void borders_differ_as_computed(void **state) {
    (void)state;
    const sl_border borders[] = {SL_BORDER_PLAIN, SL_BORDER_LC04, SL_BORDER_RADIAL};
    /* sin of the half angle, t = 2 */
    const double s = sqrt(0.8), sums[] = {4 * s * sl_atan(s), SL_PI, SL_PI};
    for (size_t k = 0; k < 3; k++) {
        sl_gather_tables *t;
        assert_int_equal(sl_gather_tables_create(SL_GATHER_PLANE, 64, 2.0, borders[k], &t, NULL), SL_OK);
        assert_near(t->weight_sum, sums[k], 1e-12);
        /* the middle of an edge with what lies beyond it, and the centre */
        if (borders[k] == SL_BORDER_RADIAL) {
            assert_near((double)t->weight[32], 1.64e-4 + 3.12e-3, 1e-5);
            assert_near((double)t->weight[32 * 64 + 32], 3.89e-3, 1e-5);
        }
        sl_gather_tables_destroy(t);
    }
}

static void nonsense_sizes_are_refused(void **state) {
    (void)state;
    sl_gather_tables *t;
    assert_int_equal(sl_gather_tables_create(SL_GATHER_PLANE, 0, 2.0, SL_BORDER_RADIAL, &t, NULL),
                     SL_ERROR_USAGE);
    assert_null(t);
    assert_int_equal(sl_gather_tables_create(SL_GATHER_PLANE, 64, -1.0, SL_BORDER_RADIAL, &t, NULL),
                     SL_ERROR_USAGE);
    assert_int_equal(sl_gather_tables_create(SL_GATHER_PLANE, 64, NAN, SL_BORDER_RADIAL, &t, NULL),
                     SL_ERROR_USAGE);
}

/* A gradient test for walls that needs no scene: a polygon's own edges are walls, at their own depth. */
static void polygon_gradient_is_the_sum_of_its_walls(void **state) {
    (void)state;
    sl_vec3d v[4] = {{-0.7, -0.4, 1.3}, {-0.7, 0.9, 1.3}, {1.1, 0.9, 1.3}, {1.1, -0.4, 1.3}},
             p = {0.35, 0.2, 0.0};
    sl_vec3d gradient, walls = {0, 0, 0};
    polygon_irradiance(p, sl_v3d(0, 0, 1), v, 4, &gradient);
    for (int i = 0; i < 4; i++) {
        sl_vec3d a = sl_scaled(sl_subd(v[i], p), 1 / 1.3), b = sl_scaled(sl_subd(v[(i + 1) % 4], p), 1 / 1.3);
        walls = sl_addd(walls, sl_scaled(sl_wall_vector(a, b), 1 / 1.3));
    }
    assert_near(walls.x, gradient.x, 1e-14);
    assert_near(walls.y, gradient.y, 1e-14);
    assert_near(walls.z, gradient.z, 1e-14);
}

typedef struct polygon_case {
    sl_vec3d vertices[4], p, n;
    double irradiance;
    sl_vec3d gradient;
    double eps;
} polygon_case;

/* Lambert's formula and its gradient, L = 5; the vertices' order makes the light shine towards the receiver.
 */
static const polygon_case polygons[] = {
    {{{-0.7, -0.4, 1.3}, {-0.7, 0.9, 1.3}, {1.1, 0.9, 1.3}, {1.1, -0.4, 1.3}},
     {0.35, 0.2, 0},
     {0, 0, 1},
     4.643140759564,
     {-0.648396539400, 0.305188879962, 4.868137219652},
     1e-11},
    {{{1.2, -0.5, -0.6}, {1.2, -0.5, 1.1}, {1.2, 0.9, 1.1}, {1.2, 0.9, -0.6}},
     {0.1, 0.2, 0},
     {0, 0, 1},
     1.338699193443,
     {2.136970274, 0, -1.280895886},
     1e-9},
    {{{1.2, -0.5, -0.6}, {1.2, -0.5, 1.1}, {1.2, 0.9, 1.1}, {1.2, 0.9, -0.6}},
     {0.1, 0.2, 0},
     {0.36, 0.48, 0.8},
     2.726858117647,
     {3.302700934, -1.501339400, -1.379378227},
     1e-9},
};

static void polygon_light_has_its_closed_form_and_gradient(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof polygons / sizeof *polygons; k++) {
        const polygon_case *c = &polygons[k];
        sl_vec3d gradient;
        assert_near(5 * polygon_irradiance(c->p, c->n, c->vertices, 4, &gradient), c->irradiance, 1e-11);
        assert_near(5 * gradient.x, c->gradient.x, c->eps);
        assert_near(5 * gradient.y, c->gradient.y, c->eps);
        assert_near(5 * gradient.z, c->gradient.z, c->eps);
        const double h = 1e-5; /* and by central differences */
        for (int axis = 0; axis < 3; axis++) {
            sl_vec3d d = {axis == 0 ? h : 0, axis == 1 ? h : 0, axis == 2 ? h : 0};
            double plus = polygon_irradiance(sl_addd(c->p, d), c->n, c->vertices, 4, NULL);
            double minus = polygon_irradiance(sl_subd(c->p, d), c->n, c->vertices, 4, NULL);
            double exact = axis == 0 ? gradient.x : axis == 1 ? gradient.y : gradient.z;
            assert_near((plus - minus) / (2 * h), exact, 1e-8);
        }
        sl_vec3d backwards[4] = {c->vertices[3], c->vertices[2], c->vertices[1], c->vertices[0]};
        /* it shines the other way */
        assert_near(polygon_irradiance(c->p, c->n, backwards, 4, &gradient), 0.0, 0.0);
        assert_near(gradient.x, 0.0, 0.0);
    }
}

static void occluder_takes_the_part_of_the_light_behind_it(void **state) {
    (void)state;
    const polygon_case *c = &polygons[0];
    /* the occluder, projected from p onto the light's plane */
    double x0 = -0.1, x1 = 0.5, y0 = -0.2, y1 = 0.45, s = 1.3 / 0.6;
    x0 = fmax(-0.7, c->p.x + s * (x0 - c->p.x));
    x1 = fmin(1.1, c->p.x + s * (x1 - c->p.x));
    y0 = fmax(-0.4, c->p.y + s * (y0 - c->p.y));
    y1 = fmin(0.9, c->p.y + s * (y1 - c->p.y));
    sl_vec3d hidden[4] = {{x0, y0, 1.3}, {x0, y1, 1.3}, {x1, y1, 1.3}, {x1, y0, 1.3}};
    double irradiance = 5 * (polygon_irradiance(c->p, c->n, c->vertices, 4, NULL) -
                             polygon_irradiance(c->p, c->n, hidden, 4, NULL));
    assert_near(irradiance, 1.48128, 5e-6);
}

static void half_spaces_give_half_the_sky(void **state) {
    (void)state;
    const double e = 1e5; /* a quad far enough away to be a half space */
    for (int degrees = 0; degrees <= 90; degrees += 15) {
        double gamma = degrees * SL_PI / 180.0;
        sl_vec3d n = {sl_sin(gamma), 0, sl_cos(gamma)}, sky = {0, 0, 0};
        sl_vec3d faces[5][4] = {{{-e, -e, e}, {-e, e, e}, {e, e, e}, {e, -e, e}},
                                {{e, -e, 0}, {e, -e, e}, {e, e, e}, {e, e, 0}},
                                {{-e, e, 0}, {-e, e, e}, {-e, -e, e}, {-e, -e, 0}},
                                {{e, e, 0}, {e, e, e}, {-e, e, e}, {-e, e, 0}},
                                {{-e, -e, 0}, {-e, -e, e}, {e, -e, e}, {e, -e, 0}}};
        double sum = 0.0;
        for (int f = 0; f < 5; f++) sum += polygon_irradiance(sky, n, faces[f], 4, NULL);
        assert_near(sum, SL_PI * (1 + sl_cos(gamma)) / 2, 1e-12);
    }
}

static void endless_wall_has_its_form_factor(void **state) {
    (void)state;
    const double e = 1e7, d = 0.7, h = 1.9;
    sl_vec3d wall[4] = {{d, -e, 0}, {d, -e, h}, {d, e, h}, {d, e, 0}}, gradient;
    double f = polygon_irradiance(sl_v3d(0, 0, 0), sl_v3d(0, 0, 1), wall, 4, &gradient) / SL_PI;
    assert_near(f, 0.327147320586, 1e-9);
    assert_near(f, 0.5 * (1 - d / sqrt(d * d + h * h)), 1e-12);
    assert_near(gradient.x / SL_PI, 0.217420966092, 1e-9); /* towards the wall: minus d/dd */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_and_extensions_fill_the_hemisphere),
        cmocka_unit_test(closed_forms_equal_the_polygon_form),
        cmocka_unit_test(walls_equal_quadrature),
        cmocka_unit_test(every_instrument_weighs_pi),
        cmocka_unit_test(borders_differ_as_computed),
        cmocka_unit_test(nonsense_sizes_are_refused),
        cmocka_unit_test(polygon_gradient_is_the_sum_of_its_walls),
        cmocka_unit_test(polygon_light_has_its_closed_form_and_gradient),
        cmocka_unit_test(occluder_takes_the_part_of_the_light_behind_it),
        cmocka_unit_test(half_spaces_give_half_the_sky),
        cmocka_unit_test(endless_wall_has_its_form_factor),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
