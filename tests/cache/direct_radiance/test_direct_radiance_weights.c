/* Weights of photons against closed forms and fine integrals: in a sphere, in a cube room, over a floor
 * patch, of one photon ahead. */
#include <stdlib.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "receiver_support.h"
#include "rendering.h"
#include "trace_scenes.h"

static sl_vec3d unit_direction(uint64_t key, uint64_t i) {
    double z = 2.0 * (double)sl_random_unit(key, 2 * i) - 1.0,
           turn = 2.0 * SL_PI * (double)sl_random_unit(key, 2 * i + 1);
    double level = sqrt(1.0 - z * z);
    return sl_v3d(level * cos(turn), level * sin(turn), z);
}

/* E = rho Phi / (4 pi R^2) everywhere, for any light and any m: here rho I / R^2. */
static void plain_weight_is_exact_inside_a_diffuse_sphere(void **state) {
    const sl_vec3d lights[] = {{0, 0, 0}, {0.3, -0.2, 0.4}, {-0.6, 0.1, 0.5}};
    const int ms[] = {1, 2, 3, 8};
    uint64_t key = sl_random_key(1, 2);
    for (int l = 0; l < 3; l++) {
        for (int k = 0; k < 4; k++) {
            sl_map_photons *photons = cube_photons(meet_unit_sphere, NULL, lights[l], 6, ms[k], 0.7, 2.0);
            for (uint64_t i = 0; i < 50; i++) {
                sl_vec3d x = unit_direction(key, i);
                assert_true(fabs(irradiance_at(photons, SL_WEIGHT_PLAIN, x, sl_scaled(x, -1.0)) / 0.7 - 1.0) <
                            1e-6);
            }
            free_photons(photons);
        }
    }
}

/* Mean ratio to exact, and relative root mean square, over 6 x 6 points of each wall of the unit cube. */
typedef struct {
    double ratio, rms;
} figures;

static void wall_point(int k, sl_vec3d *x, sl_vec3d *n) {
    double u = (k % 6 + 0.5) / 6.0, v = (k / 6 % 6 + 0.5) / 6.0;
    switch (k / 36) {
    case 0: *x = sl_v3d(u, v, 0), *n = sl_v3d(0, 0, 1); break;
    case 1: *x = sl_v3d(u, v, 1), *n = sl_v3d(0, 0, -1); break;
    case 2: *x = sl_v3d(0, u, v), *n = sl_v3d(1, 0, 0); break;
    case 3: *x = sl_v3d(1, u, v), *n = sl_v3d(-1, 0, 0); break;
    case 4: *x = sl_v3d(u, 0, v), *n = sl_v3d(0, 1, 0); break;
    default: *x = sl_v3d(u, 1, v), *n = sl_v3d(0, -1, 0); break;
    }
}

static figures measure(const sl_map_photons *photons, sl_photon_weight weight, const double exact[216]) {
    double sum = 0.0, total = 0.0, square = 0.0;
    for (int k = 0; k < 216; k++) {
        sl_vec3d x, n;
        wall_point(k, &x, &n);
        double e = irradiance_at(photons, weight, x, n);
        sum += e;
        total += exact[k];
        square += (e - exact[k]) * (e - exact[k]);
    }
    return (figures){sum / total, sqrt(square / 216.0) / (total / 216.0)};
}

static void cube_room_has_the_ratios_of_each_weight(void **state) {
    const sl_vec3d light = {0.5, 0.5, 0.9};
    const int ms[3] = {3, 8, 16};
    static const struct {
        sl_photon_weight weight;
        figures of_m[3];
    } table[] = {{SL_WEIGHT_PLAIN, {{0.99, 0.14}, {1.00, 0.05}, {0.98, 0.03}}},
                 {SL_WEIGHT_FLUX, {{0.86, 0.15}, {0.96, 0.05}, {0.97, 0.04}}},
                 {SL_WEIGHT_POLYGON, {{0.886, 0.122}, {0.977, 0.024}, {0.983, 0.021}}},
                 {SL_WEIGHT_DISC, {{0.91, 0.17}, {1.07, 0.14}, {1.12, 0.16}}},
                 {SL_WEIGHT_BOX, {{0.30, 0.73}, {0.29, 0.74}, {0.28, 0.74}}},
                 {SL_WEIGHT_EVEN, {{7.3, 7.2}, {7.2, 7.1}, {7.2, 7.1}}}};
    double exact[216];
    for (int k = 0; k < 216; k++) {
        sl_vec3d x, n;
        wall_point(k, &x, &n);
        exact[k] = exact_irradiance(meet_unit_cube, NULL, light, 6, 100, 0.7, x, n);
    }
    for (int i = 0; i < 3; i++) {
        sl_map_photons *photons = cube_photons(meet_unit_cube, NULL, light, 6, ms[i], 0.7, sqrt(3.0));
        for (size_t w = 0; w < sizeof table / sizeof *table; w++) {
            figures got = measure(photons, table[w].weight, exact), wanted = table[w].of_m[i];
            double tolerance = wanted.ratio > 2.0 ? 0.06 : 0.006;
            if (!(fabs(got.ratio - wanted.ratio) < tolerance) || !(fabs(got.rms - wanted.rms) < tolerance))
                fail_msg("weight %d, m = %d: ratio %.3f, rms %.3f", (int)table[w].weight, ms[i], got.ratio,
                         got.rms);
        }
        free_photons(photons);
    }
}

/* ---- a floor patch below the light, and a receiver above it ---- */

/* Ratio to the exact irradiance at a point over a floor of half side 1, lit from height 1 over its middle. */
static double over_the_floor(sl_photon_weight weight, int m, sl_vec3d x) {
    const sl_vec3d light = {0, 0, 1}, down = {0, 0, -1};
    sl_map_photons *photons = cube_photons(meet_floor, NULL, light, 1, m, 0.7, 3.0);
    double exact = exact_irradiance(meet_floor, NULL, light, 1, 401, 0.7, x, down),
           got = irradiance_at(photons, weight, x, down);
    free_photons(photons);
    return got / exact;
}

static void plain_weight_over_a_floor_patch_is_right_to_a_sixth_of_a_percent(void **state) {
    assert_true(fabs(over_the_floor(SL_WEIGHT_PLAIN, 3, sl_v3d(0, 0, 2)) - 1.0) < 1.6e-3);
}

static void polygons_hold_close_to_the_floor_where_other_weights_fail(void **state) {
    const struct {
        sl_photon_weight weight;
        double at_3, at_8;
    } table[] = {
        {SL_WEIGHT_POLYGON, 0.96, 0.985}, {SL_WEIGHT_FLUX, 0.15, 0.57}, {SL_WEIGHT_DISC, 0.06, 0.28}};
    const sl_vec3d close = {0.2, 0.1, 0.1};
    for (int i = 0; i < 3; i++) {
        double at_3 = over_the_floor(table[i].weight, 3, close),
               at_8 = over_the_floor(table[i].weight, 8, close);
        if (!(fabs(at_3 - table[i].at_3) < 0.01) || !(fabs(at_8 - table[i].at_8) < 0.01))
            fail_msg("weight %d: %.3f and %.3f", (int)table[i].weight, at_3, at_8);
    }
}

/* ---- one photon straight ahead ---- */

/* L_o = 1 and area A at the origin, lit from ahead, and looking along z. */
static sl_map_photons *one_photon(double area) {
    sl_map_photons *p = make_photons(1, 1.0f);
    p->nearest = 1e-9f;
    p->photon[0] = (sl_map_photon){.footprint = (float)area,
                                   .flux = sl_grey((float)area),
                                   .cos_alpha = 1.0f,
                                   .normal = {0, 0, 1},
                                   .printed_area = (float)area,
                                   .radiance = {1, 1, 1}};
    return p;
}

static double ahead(const sl_map_photons *p, sl_photon_weight weight, double r) {
    return irradiance_at(p, weight, sl_v3d(0, 0, r), sl_v3d(0, 0, -1));
}

/* A coaxial disc's cosine-weighted solid angle is pi R^2 / (r^2 + R^2): what flux has. (14) has 1 for pi as
 * its limit. */
static void flux_weight_is_a_coaxial_disc_and_printed_14_is_not(void **state) {
    sl_map_photons *p = one_photon(SL_PI); /* R = 1 */
    for (double r = 1e-4; r < 1e4; r *= 1.7) {
        double exact = SL_PI / (r * r + 1.0);
        assert_true(fabs(ahead(p, SL_WEIGHT_FLUX, r) / exact - 1.0) < 1e-6);
        assert_true(fabs(ahead(p, SL_WEIGHT_PLAIN, r) / (SL_PI / (r * r)) - 1.0) < 1e-6);
        assert_true(fabs(ahead(p, SL_WEIGHT_DISC, r) / (SL_PI / (r * r + SL_PI)) - 1.0) < 1e-6);
        double of_disc = fabs(ahead(p, SL_WEIGHT_DISC, r) / exact - 1.0),
               of_plain = fabs(ahead(p, SL_WEIGHT_PLAIN, r) / exact - 1.0);
        if (r > 1.7 && r < 1e2) assert_true(of_disc > of_plain);
        if (r < 1.6) assert_true(of_disc < of_plain);
    }
    assert_true(fabs(ahead(p, SL_WEIGHT_DISC, 1e-4) - 1.0) < 1e-6 &&
                fabs(ahead(p, SL_WEIGHT_FLUX, 1e-4) - SL_PI) < 1e-6);
    const double low[3][2] = {{8, 0.032}, {5, 0.076}, {10, 0.021}};
    for (int i = 0; i < 3; i++) {
        double r = low[i][0], exact = SL_PI / (r * r + 1.0);
        assert_true(fabs(1.0 - ahead(p, SL_WEIGHT_DISC, r) / exact - low[i][1]) < 6e-4);
    }
    free_photons(p);
}

/* A square of half side a: 4 L q atan q, q = a / sqrt(a^2 + r^2). */
static void polygon_weight_is_exact_for_a_uniform_square(void **state) {
    sl_map_photons *p = one_photon(4.0);
    p->polygon = calloc(1, sizeof *p->polygon);
    assert_non_null(p->polygon);
    for (int turn = 0; turn < 2; turn++) {
        sl_vec3 corner[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        if (turn) corner[1] = sl_v3(-1, 1, 0), corner[3] = sl_v3(1, -1, 0);
        p->polygon[0] = sl_photon_polygon_of(corner, p->photon[0].normal, 4.0f, 0.0f);
        for (double r = 1e-3; r < 1e3; r *= 1.9) {
            double q = 1.0 / sqrt(1.0 + r * r), exact = 4.0 * q * atan(q),
                   got = ahead(p, SL_WEIGHT_POLYGON, r);
            if (!(fabs(got / exact - 1.0) < 1e-4)) fail_msg("r = %g: %g instead of %g", r, got, exact);
        }
        /* Half of it below the horizon: two of its four quarters are left, as seen from the side. */
        double upright = irradiance_at(p, SL_WEIGHT_POLYGON, sl_v3d(0, 0, 0.5), sl_v3d(1, 0, 0));
        double q = 1.0 / sqrt(1.25), exact = 0.5 * 2.0 * (atan(2.0) - 0.5 * q * atan(q));
        if (!(fabs(upright / exact - 1.0) < 1e-4)) fail_msg("upright %g instead of %g", upright, exact);
    }
    free_photons(p);
}

/* A lamp in a hollow ball: polygons jut out of it between its corners, and light nothing on its outside. */
static void polygons_of_a_curved_sheet_do_not_light_its_other_side(void **state) {
    for (unsigned rings = 6; rings <= 16; rings += 5) {
        trace_mesh mesh = trace_mesh_begin();
        trace_mesh_sphere(&mesh, sl_v3(0, 0, 0), 1.0f, rings, 0.0f, false, trace_mesh_diffuse(&mesh, 0.5f));
        trace_mesh_point_light(&mesh, sl_v3(0.1f, 0.3f, 0.05f), sl_grey(1));
        mesh.has_camera = true;
        mesh.camera = (sl_camera){
            .eye = {0, 0, 4}, .right = {1, 0, 0}, .up = {0, 1, 0}, .back = {0, 0, 1}, .vertical_fov = 0.6f};
        sl_scene *scene = trace_mesh_build(&mesh);
        sl_settings settings = small_settings("direct-radiance", 48, 48);
        settings.radiance_map.weight = SL_WEIGHT_POLYGON;
        settings.radiance_map.samples = 8;
        sl_image *image = render(scene, &settings, NULL);
        const float *indirect = sl_image_channel(image, "indirect.G");
        double brightest = 0.0;
        for (size_t i = 0; i < 48 * 48; i++) brightest = fmax(brightest, (double)indirect[i]);
        if (brightest > 1e-3) fail_msg("%u rings: %g outside", rings, brightest);
        destroy_picture(image, scene);
    }
}

static void polygon_weight_falls_back_to_flux_without_a_polygon(void **state) {
    sl_map_photons *p = cube_photons(meet_unit_cube, NULL, sl_v3d(0.5, 0.5, 0.9), 6, 3, 0.7, sqrt(3.0));
    for (size_t j = 0; j < p->count; j++) p->polygon[j].over_area = 0.0f;
    for (int k = 0; k < 216; k += 5) {
        sl_vec3d x, n;
        wall_point(k, &x, &n);
        assert_true(irradiance_at(p, SL_WEIGHT_POLYGON, x, n) == irradiance_at(p, SL_WEIGHT_FLUX, x, n));
    }
    free_photons(p);
}

/* (11) 2 pi / M, M of the photon's light; (15) A' over the squared diagonal; both whatever way the photon
 * faces. */
static void printed_11_and_15_know_neither_distance_nor_facing(void **state) {
    sl_map_photons *p = make_photons(5, 10.0f);
    for (size_t j = 0; j < 5; j++)
        p->photon[j] = (sl_map_photon){.position = {0, 0, 0},
                                       .normal = {0, 0, j % 2 ? 1.0f : -1.0f},
                                       .cos_alpha = 0.5f,
                                       .printed_area = 4.0f,
                                       .radiance = {2, 2, 2},
                                       .samples = j < 2 ? 4 : 6};
    for (size_t j = 0; j < 5; j++) {
        double m = j < 2 ? 4.0 : 6.0;
        for (double r = 1.0; r < 100.0; r *= 10.0) {
            sl_vec3 x = sl_v3(0, 0, (float)-r), n = sl_v3(0.6f, 0, 0.8f);
            double even = (double)sl_photon_irradiance(p, j, SL_WEIGHT_EVEN, x, n, n).r,
                   expected = 2.0 * 0.8 * 2.0 * SL_PI / m;
            double box = (double)sl_photon_irradiance(p, j, SL_WEIGHT_BOX, x, n, n).r;
            if (!(fabs(even - expected) < 1e-6 * expected))
                fail_msg("photon %d: %g instead of %g", (int)j, even, expected);
            assert_true(fabs(box - 2.0 * 0.8 * 2.0 / 100.0) < 1e-7);
        }
    }
    free_photons(p);
}

/* ---- hard cases ---- */

/* E_j <= pi L_o whatever the distance, the sizes and the tilts, in scenes of 1e-4 and 1e4; and lengths have
 * no unit. */
static void bounded_weights_are_bounded_at_every_scale(void **state) {
    const float scales[3] = {1e-4f, 1.0f, 1e4f};
    uint64_t key = sl_random_key(9, 9);
    for (uint64_t i = 0; i < 3000; i++) {
        float e[3][3];
        sl_vec3 n = sl_to_float(unit_direction(key, 9 * i)),
                y_n = sl_to_float(unit_direction(key, 9 * i + 1));
        float away = sl_exp2f(-30.0f * sl_random_unit(key, 90 * i + 80)),
              area = sl_exp2f(-30.0f * sl_random_unit(key, 90 * i + 81));
        float alpha = sl_exp2f(-20.0f * sl_random_unit(key, 90 * i + 82));
        sl_vec3 d = sl_scale(sl_to_float(unit_direction(key, 9 * i + 2)), away);
        for (int k = 0; k < 3; k++) {
            float s = scales[k];
            sl_map_photons *p = make_photons(1, s);
            p->photon[0] = (sl_map_photon){.position = sl_scale(d, s),
                                           .footprint = area * alpha * s * s,
                                           .cos_alpha = alpha,
                                           .normal = y_n,
                                           .flux = sl_grey(area * s * s),
                                           .printed_area = area * s * s,
                                           .radiance = {1, 1, 1}};
            const sl_photon_weight of[3] = {SL_WEIGHT_FLUX, SL_WEIGHT_DISC, SL_WEIGHT_EVEN};
            for (int w = 0; w < 3; w++) {
                e[k][w] = sl_photon_irradiance(p, 0, of[w], sl_v3(0, 0, 0), n, n).r;
                assert_true(e[k][w] >= 0.0f && e[k][w] <= (w == 0 ? 3.1416f : w == 1 ? 1.000001f : 6.28319f));
            }
            assert_true(isfinite(sl_photon_irradiance(p, 0, SL_WEIGHT_PLAIN, sl_v3(0, 0, 0), n, n).r));
            free_photons(p);
        }
        for (int w = 0; w < 3; w++) {
            for (int k = 0; k < 3; k += 2) {
                if (!(fabsf(e[k][w] - e[1][w]) <= 2e-4f * e[1][w] + 1e-12f))
                    fail_msg("weight %d, scale %g: %g instead of %g", w, (double)scales[k], (double)e[k][w],
                             (double)e[1][w]);
            }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_weight_is_exact_inside_a_diffuse_sphere),
        cmocka_unit_test(cube_room_has_the_ratios_of_each_weight),
        cmocka_unit_test(plain_weight_over_a_floor_patch_is_right_to_a_sixth_of_a_percent),
        cmocka_unit_test(polygons_hold_close_to_the_floor_where_other_weights_fail),
        cmocka_unit_test(flux_weight_is_a_coaxial_disc_and_printed_14_is_not),
        cmocka_unit_test(polygon_weight_is_exact_for_a_uniform_square),
        cmocka_unit_test(polygons_of_a_curved_sheet_do_not_light_its_other_side),
        cmocka_unit_test(polygon_weight_falls_back_to_flux_without_a_polygon),
        cmocka_unit_test(printed_11_and_15_know_neither_distance_nor_facing),
        cmocka_unit_test(bounded_weights_are_bounded_at_every_scale),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
