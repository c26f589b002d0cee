/* Weights of photons against closed forms and fine integrals (sections 2.4 and 6). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/math.h"
#include "base/random.h"
#include "receiver_support.h"

static sl_vec3d unit_direction(uint64_t key, uint64_t i) {
    double z = 2.0 * (double)sl_random_unit(key, 2 * i) - 1.0, turn = 2.0 * SL_PI * (double)sl_random_unit(key, 2 * i + 1);
    double level = sqrt(1.0 - z * z);
    return sl_v3d(level * cos(turn), level * sin(turn), z);
}

/* E = rho Phi / (4 pi R^2) everywhere, for any light and any m: here rho I / R^2. */
static void plain_weight_is_exact_inside_a_diffuse_sphere(void **state) {
    (void)state;
    const sl_vec3d lights[] = {{0, 0, 0}, {0.3, -0.2, 0.4}, {-0.6, 0.1, 0.5}};
    const int ms[] = {1, 2, 3, 8};
    uint64_t key = sl_random_key(1, 2);
    for (int l = 0; l < 3; l++) {
        for (int k = 0; k < 4; k++) {
            sl_map_photons *photons = cube_photons(meet_unit_sphere, NULL, lights[l], 6, ms[k], 0.7, 2.0);
            for (uint64_t i = 0; i < 50; i++) {
                sl_vec3d x = unit_direction(key, i);
                assert_true(fabs(irradiance_at(photons, SL_WEIGHT_PLAIN, x, sl_scaled(x, -1.0)) / 0.7 - 1.0) < 1e-6);
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
    (void)state;
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
                fail_msg("weight %d, m = %d: ratio %.3f, rms %.3f", (int)table[w].weight, ms[i], got.ratio, got.rms);
        }
        free_photons(photons);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_weight_is_exact_inside_a_diffuse_sphere),
        cmocka_unit_test(cube_room_has_the_ratios_of_each_weight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
