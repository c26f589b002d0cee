/* Pass 7, (10): a picture's receivers under many photons. */
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "receiver_support.h"

static const sl_photon_weight all_weights[] = {SL_WEIGHT_FLUX, SL_WEIGHT_POLYGON, SL_WEIGHT_PLAIN,
                                               SL_WEIGHT_EVEN, SL_WEIGHT_DISC,    SL_WEIGHT_BOX};
enum {
    WEIGHTS = sizeof all_weights / sizeof *all_weights,
    WIDTH = 77,
    HEIGHT = 23,
    PIXELS = WIDTH * HEIGHT,
    M = 4
};

static sl_vec3 random_unit(uint64_t key, uint64_t i) {
    sl_vec3 d = sl_v3(sl_random_unit(key, 3 * i) - 0.5f, sl_random_unit(key, 3 * i + 1) - 0.5f,
                      sl_random_unit(key, 3 * i + 2) - 0.5f);
    return sl_normalize_or(d, sl_v3(0, 0, 1));
}

/* Points anywhere in the unit cube, with any normals; shading normals a little aside; some pixels are empty.
 */
static sl_gbuffer *random_receivers(uint32_t materials) {
    sl_gbuffer *r = make_receivers(WIDTH, HEIGHT, sl_v3(0.5f, 0.4f, 0.6f));
    uint64_t key = sl_random_key(5, materials);
    for (uint64_t i = 0; i < PIXELS; i++) {
        if (i > PIXELS / 2 && i % 7 == 0) continue;
        sl_vec3 n = random_unit(key, 8 * i), aside = random_unit(key, 8 * i + 1);
        sl_vec3 x = sl_v3(sl_random_unit(key, 64 * i + 40), sl_random_unit(key, 64 * i + 41),
                          sl_random_unit(key, 64 * i + 42));
        sl_rgb kd = {sl_random_unit(key, 64 * i + 43), sl_random_unit(key, 64 * i + 44),
                     sl_random_unit(key, 64 * i + 45)};
        set_receiver(r, i, x, n, sl_normalize_or(sl_mad(n, 0.3f, aside), n), kd,
                     materials ? (uint32_t)i / 3 % materials : 0);
    }
    return r;
}

static sl_map_photons *room_photons(bool lobes) {
    sl_map_photons *p = cube_photons(meet_unit_cube, NULL, sl_v3d(0.4, 0.6, 0.8), 6, M, 0.7, sqrt(3.0));
    uint64_t key = sl_random_key(6, 6);
    for (size_t j = 0; j < p->count; j++) {
        sl_rgb tint = {1.0f, sl_random_unit(key, 2 * j), sl_random_unit(key, 2 * j + 1)};
        p->photon[j].flux = sl_rgb_mul(p->photon[j].flux, tint);
        p->photon[j].radiance = sl_rgb_mul(p->photon[j].radiance, tint);
    }
    if (!lobes) return p;
    p->lobe = calloc(p->count, sizeof *p->lobe);
    assert_non_null(p->lobe);
    for (size_t j = 0; j < p->count; j++) {
        sl_vec3 to_light =
            sl_normalize_or(sl_sub(sl_v3(0.4f, 0.6f, 0.8f), p->photon[j].position), p->photon[j].normal);
        p->lobe[j] = (sl_photon_lobe){
            {0.2f, 0.3f, 0.1f}, {0.4f, 0.3f, 0.5f}, (float)(j % 40), to_light, p->photon[j].normal};
    }
    return p;
}

static planes light_up(const sl_light_pass *pass, const sl_gbuffer *receivers, sl_counters *counters) {
    sl_counters unused = {{0}};
    planes p = make_planes((size_t)receivers->width * (size_t)receivers->height);
    sl_lit_picture picture = {.indirect = {p.value[0], p.value[1], p.value[2]}};
    light_indirectly(pass, receivers, &picture, counters ? counters : &unused);
    return p;
}

static void assert_same_bits(planes a, planes b) {
    for (int c = 0; c < 3; c++) assert_memory_equal(a.value[c], b.value[c], a.count * sizeof(float));
}

static sl_vec3 at(const float *x, const float *y, const float *z, size_t i) {
    return sl_v3(x[i], y[i], z[i]);
}

/* The double loop, in floats, photons in index order. */
static planes plain_loop(const sl_gbuffer *r, const sl_map_photons *photons, sl_photon_weight weight) {
    planes p = make_planes(PIXELS);
    const sl_gbuffer *g = r;
    for (size_t i = 0; i < PIXELS; i++) {
        if (g->material[i] == SL_NO_INDEX) continue;
        sl_rgb e = {0.0f, 0.0f, 0.0f};
        for (size_t j = 0; j < photons->count; j++) {
            e = sl_rgb_add(e, sl_photon_irradiance(photons, j, weight,
                                                   at(g->position_x, g->position_y, g->position_z, i),
                                                   at(g->geometric_x, g->geometric_y, g->geometric_z, i),
                                                   at(g->normal_x, g->normal_y, g->normal_z, i)));
        }
        p.value[0][i] = g->diffuse_r[i] * (float)(1.0 / SL_PI) * e.r;
        p.value[1][i] = g->diffuse_g[i] * (float)(1.0 / SL_PI) * e.g;
        p.value[2][i] = g->diffuse_b[i] * (float)(1.0 / SL_PI) * e.b;
    }
    return p;
}

static void picture_has_the_bits_of_the_plain_double_loop(void **state) {
    sl_gbuffer *receivers = random_receivers(0);
    sl_map_photons *photons = room_photons(false);
    for (int w = 0; w < WEIGHTS; w++) {
        sl_light_pass pass = {.scene = *state, .photons = photons, .weight = all_weights[w], .threads = 1};
        planes lanes = light_up(&pass, receivers, NULL),
               loop = plain_loop(receivers, photons, all_weights[w]);
        assert_same_bits(loop, lanes);
        free_planes(&lanes);
        free_planes(&loop);
    }
    free_photons(photons);
    sl_gbuffer_destroy(receivers);
}

/* ---- lobes ---- */

static void free_all(planes *p, sl_gbuffer *r, sl_map_photons *photons) {
    free_planes(p);
    sl_gbuffer_destroy(r);
    free_photons(photons);
}

/* One photon over a floor that looks up; what eye 0 sees in the first half of the picture and eye 1 in the
 * second. */
static sl_map_photons *photon_over_the_floor(void) {
    sl_map_photons *p = make_photons(1, 2.0f);
    p->photon[0] = (sl_map_photon){.position = {0, 0, 1},
                                   .footprint = 1e-3f,
                                   .flux = {1, 1, 1},
                                   .cos_alpha = 0.8f,
                                   .normal = {0, 0, -1},
                                   .printed_area = 1e-3f / 0.8f,
                                   .radiance = {8, 8, 8}};
    return p;
}

static sl_gbuffer *floor_row(sl_vec3 eye_0, sl_vec3 eye_1, int count, uint32_t material, float kd) {
    sl_gbuffer *r = make_receivers(count, 2, eye_0);
    for (int i = 0; i < 2 * count; i++) {
        sl_vec3 x = sl_v3(-1.0f + 2.0f * ((float)(i % count) + 0.5f) / (float)count, 0, 0),
                up = sl_v3(0, 0, 1);
        if (i >= count) r->seen_from[i] = eye_1;
        set_receiver(r, (size_t)i, x, up, up, sl_grey(kd), material);
    }
    return r;
}

/* Photons of glossy surfaces: f_r(y) for rho / pi. With n = 0, and light from the side, the lobe covers the
 * hemisphere's part around the mirrored light. */
static void photon_with_a_flat_lobe_is_lambertian_and_a_sharp_one_mirrors_its_light(void **state) {
    enum { N = 150 };
    sl_gbuffer *r = floor_row(sl_v3(0, 0, 3), sl_v3(0, 0, 3), N, DIFFUSE_MATERIAL, 0.5f);
    sl_map_photons *lambertian = photon_over_the_floor(), *lobed = photon_over_the_floor();
    lambertian->photon[0].flux = sl_grey((float)(0.6 / SL_PI)); /* rho = 0.6, I dOmega = 1 */
    /* I cos / b^2 = I dOmega cos / A' */
    lambertian->photon[0].radiance = sl_grey((float)(0.6 / SL_PI * 0.8 / 1e-3));
    lobed->photon[0].radiance = sl_grey((float)(0.8 / 1e-3)); /* of a lobe's photon: what arrives at it */
    lobed->lobe = calloc(1, sizeof *lobed->lobe);
    assert_non_null(lobed->lobe);
    sl_vec3 down = sl_v3(0, 0, -1), to_light = sl_v3(-0.6f, 0, -0.8f);
    for (int w = 0; w < WEIGHTS; w++) {
        sl_light_pass pass = {.scene = *state, .photons = lambertian, .weight = all_weights[w], .threads = 1};
        lobed->lobe[0] = (sl_photon_lobe){{0.2f, 0.2f, 0.2f}, {0.4f, 0.4f, 0.4f}, 0.0f, down, down};
        planes expected = light_up(&pass, r, NULL);
        pass.photons = lobed;
        planes flat = light_up(&pass, r, NULL);
        for (int i = 0; i < 2 * N; i++) {
            double got = (double)flat.value[0][i], wanted = (double)expected.value[0][i];
            if (!(fabs(got - wanted) <= 2e-6 * wanted))
                fail_msg("pixel %d, weight %d: %g instead of %g", i, (int)all_weights[w], got, wanted);
        }
        /* Light arrives from x = -0.6 / 0.8: it leaves towards x = 0.75. */
        lobed->lobe[0] = (sl_photon_lobe){{0, 0, 0}, {0.5f, 0.5f, 0.5f}, 1000.0f, to_light, down};
        planes sharp = light_up(&pass, r, NULL);
        int best = 0;
        for (int i = 1; i < N; i++) best = sharp.value[0][i] > sharp.value[0][best] ? i : best;
        assert_true(fabsf(r->position_x[best] - 0.75f) < 0.02f);
        free_planes(&expected);
        free_planes(&flat);
        free_planes(&sharp);
    }
    planes nothing = make_planes(1);
    free_photons(lobed);
    free_all(&nothing, r, lambertian);
}

/* The plain form of a photon with a lobe, and the lanes. */
static void lobed_photons_have_the_bits_of_the_plain_double_loop(void **state) {
    sl_gbuffer *receivers = random_receivers(0);
    sl_map_photons *all = room_photons(true);
    for (int w = 0; w < WEIGHTS; w++) {
        for (size_t j = 0; j < all->count; j += 7) {
            sl_map_photons one = {.count = 1,
                                  .photon = &all->photon[j],
                                  .lobe = &all->lobe[j],
                                  .polygon = &all->polygon[j],
                                  .nearest = all->nearest,
                                  .box_diagonal = all->box_diagonal};
            sl_light_pass pass = {.scene = *state, .photons = &one, .weight = all_weights[w], .threads = 1};
            planes lanes = light_up(&pass, receivers, NULL),
                   loop = plain_loop(receivers, &one, all_weights[w]);
            assert_same_bits(loop, lanes);
            free_planes(&lanes);
            free_planes(&loop);
        }
    }
    free_photons(all);
    sl_gbuffer_destroy(receivers);
}

/* ---- who receives, spread, nothing to do ---- */

/* Receivers that are anywhere but sound: in a photon, not finite, without normals; glossy or not. */
static void damaged_receivers_leave_no_value_that_is_not_finite(void **state) {
    sl_gbuffer *r = random_receivers(2);
    sl_map_photons *photons = room_photons(true);
    sl_gbuffer *g = r;
    float *fields[9] = {g->position_x, g->position_y, g->position_z, g->normal_x, g->normal_y, g->normal_z,
                        g->geometric_x, g->geometric_y, g->geometric_z};
    const float bad[6] = {NAN, INFINITY, -INFINITY, 0.0f, 3e38f, 1e-42f};
    for (int i = 0; i < PIXELS; i++) {
        if (i % 4 == 0) {
            sl_vec3 y = photons->photon[(size_t)i % photons->count].position;
            g->position_x[i] = y.x, g->position_y[i] = y.y, g->position_z[i] = y.z;
        } else if (i % 4 == 1) {
            fields[i % 9][i] = bad[i % 6];
        }
    }
    for (int i = 0; i < PIXELS; i++)
        g->seen_from[i] = sl_v3(g->position_x[3], g->position_y[3], g->position_z[3]);
    for (int w = 0; w < WEIGHTS; w++) {
        sl_light_pass pass = {.scene = *state, .photons = photons, .weight = all_weights[w], .threads = 1};
        planes p = light_up(&pass, r, NULL);
        for (int i = 0; i < PIXELS; i++) {
            for (int c = 0; c < 3; c++) {
                if (!(isfinite(p.value[c][i]) && p.value[c][i] >= 0.0f))
                    fail_msg("pixel %d, weight %d: %g", i, (int)all_weights[w], (double)p.value[c][i]);
            }
        }
        free_planes(&p);
    }
    free_photons(photons);
    sl_gbuffer_destroy(r);
}

/* ---- the same bits ---- */

static void bits_do_not_depend_on_threads_or_instruction_sets(void **state) {
    sl_gbuffer *receivers = random_receivers(2);
    static const char *const isas[] = {"baseline", "avx2", "avx512"};
    for (int lobes = 0; lobes < 2; lobes++) {
        sl_map_photons *photons = room_photons(lobes);
        for (int w = 0; w < WEIGHTS; w++) {
            sl_light_pass pass = {
                .scene = *state, .photons = photons, .weight = all_weights[w], .threads = 1};
            sl_counters first = {{0}};
            planes expected = light_up(&pass, receivers, &first);
            for (unsigned k = 0; k < 3; k++) {
                sl_counters costs = {{0}};
                assert_int_equal(setenv("SOFTLUX_ISA", isas[k], 1), 0);
                pass.threads = k + 1;
                planes got = light_up(&pass, receivers, &costs);
                unsetenv("SOFTLUX_ISA");
                assert_same_bits(expected, got);
                assert_memory_equal(&first, &costs, sizeof costs);
                free_planes(&got);
            }
            free_planes(&expected);
        }
        free_photons(photons);
    }
    sl_gbuffer_destroy(receivers);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(picture_has_the_bits_of_the_plain_double_loop),
        cmocka_unit_test(photon_with_a_flat_lobe_is_lambertian_and_a_sharp_one_mirrors_its_light),
        cmocka_unit_test(lobed_photons_have_the_bits_of_the_plain_double_loop),
        cmocka_unit_test(damaged_receivers_leave_no_value_that_is_not_finite),
        cmocka_unit_test(bits_do_not_depend_on_threads_or_instruction_sets),
    };
    return cmocka_run_group_tests(tests, make_receiver_scene, destroy_receiver_scene);
}
