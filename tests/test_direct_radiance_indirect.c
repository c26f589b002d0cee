/* Pass 7, (10): a picture's receivers under many photons. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/math.h"
#include "base/random.h"
#include "receiver_support.h"

static const sl_photon_weight all_weights[] = {SL_WEIGHT_FLUX, SL_WEIGHT_POLYGON, SL_WEIGHT_PLAIN, SL_WEIGHT_EVEN, SL_WEIGHT_DISC,
                                               SL_WEIGHT_BOX};
enum { WEIGHTS = sizeof all_weights / sizeof *all_weights, WIDTH = 77, HEIGHT = 23, PIXELS = WIDTH * HEIGHT, M = 4 };

static sl_vec3 random_unit(uint64_t key, uint64_t i) {
    sl_vec3 d = sl_v3(sl_random_unit(key, 3 * i) - 0.5f, sl_random_unit(key, 3 * i + 1) - 0.5f, sl_random_unit(key, 3 * i + 2) - 0.5f);
    return sl_normalize_or(d, sl_v3(0, 0, 1));
}

/* Points anywhere in the unit cube, with any normals; shading normals a little aside; some pixels are empty. */
static sl_receivers *random_receivers(uint32_t materials) {
    sl_receivers *r = make_receivers(WIDTH, HEIGHT, sl_v3(0.5f, 0.4f, 0.6f));
    uint64_t key = sl_random_key(5, materials);
    for (uint64_t i = 0; i < PIXELS; i++) {
        if (i > PIXELS / 2 && i % 7 == 0) continue;
        sl_vec3 n = random_unit(key, 8 * i), aside = random_unit(key, 8 * i + 1);
        sl_vec3 x = sl_v3(sl_random_unit(key, 64 * i + 40), sl_random_unit(key, 64 * i + 41), sl_random_unit(key, 64 * i + 42));
        sl_rgb kd = {sl_random_unit(key, 64 * i + 43), sl_random_unit(key, 64 * i + 44), sl_random_unit(key, 64 * i + 45)};
        set_receiver(r, i, x, n, sl_normalize_or(sl_mad(n, 0.3f, aside), n), kd, materials ? (uint32_t)i / 3 % materials : 0);
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
        sl_vec3 to_light = sl_normalize_or(sl_sub(sl_v3(0.4f, 0.6f, 0.8f), p->photon[j].position), p->photon[j].normal);
        p->lobe[j] = (sl_photon_lobe){{0.2f, 0.3f, 0.1f}, {0.4f, 0.3f, 0.5f}, (float)(j % 40), to_light, p->photon[j].normal};
    }
    return p;
}

static planes light_up(const sl_light_pass *pass, const sl_receivers *receivers, float *spread, sl_counters *counters) {
    sl_counters unused = {{0}};
    planes p = make_planes((size_t)receivers->width * (size_t)receivers->height);
    sl_lit_picture picture = {.indirect = {p.value[0], p.value[1], p.value[2]}};
    assert_int_equal(sl_light_indirectly(pass, receivers, &picture, spread, counters ? counters : &unused, NULL), SL_OK);
    return p;
}

static void assert_same_bits(planes a, planes b) {
    for (int c = 0; c < 3; c++) assert_memory_equal(a.value[c], b.value[c], a.count * sizeof(float));
}

static sl_vec3 at(const float *x, const float *y, const float *z, size_t i) { return sl_v3(x[i], y[i], z[i]); }

/* The double loop, in floats and in index order. */
static planes plain_loop(const sl_receivers *r, const sl_map_photons *photons, sl_photon_weight weight) {
    planes p = make_planes(PIXELS);
    const sl_gbuffer *g = r->gbuffer;
    for (size_t i = 0; i < PIXELS; i++) {
        if (g->material[i] == SL_NO_INDEX) continue;
        sl_rgb e = {0.0f, 0.0f, 0.0f};
        for (size_t j = 0; j < photons->count; j++) {
            e = sl_rgb_add(e, sl_photon_irradiance(photons, j, weight, at(g->position_x, g->position_y, g->position_z, i),
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
    sl_receivers *receivers = random_receivers(0);
    sl_map_photons *photons = room_photons(false);
    for (int w = 0; w < WEIGHTS; w++) {
        sl_light_pass pass = {.scene = *state, .photons = photons, .weight = all_weights[w], .threads = 1};
        planes lanes = light_up(&pass, receivers, NULL, NULL), loop = plain_loop(receivers, photons, all_weights[w]);
        assert_same_bits(loop, lanes);
        free_planes(&lanes);
        free_planes(&loop);
    }
    free_photons(photons);
    free_receivers(receivers);
}

/* (10) with the boxed formula of section 2.4, written once more, in double. */
static void lambertian_receiver_agrees_with_a_double_loop_in_double(void **state) {
    sl_receivers *r = random_receivers(0);
    sl_map_photons *photons = room_photons(false);
    sl_light_pass pass = {.scene = *state, .photons = photons, .weight = SL_WEIGHT_FLUX, .threads = 1};
    planes lanes = light_up(&pass, r, NULL, NULL);
    const sl_gbuffer *g = r->gbuffer;
    double largest = 0.0;
    for (size_t i = 0; i < PIXELS; i++) largest = fmax(largest, (double)lanes.value[0][i]);
    assert_true(largest > 0.0);
    for (size_t i = 0; i < PIXELS; i++) {
        if (g->material[i] == SL_NO_INDEX) continue;
        double sum = 0.0;
        for (size_t j = 0; j < photons->count; j++) {
            const sl_map_photon *p = &photons->photon[j];
            sl_vec3d d = sl_subd(sl_to_double(p->position), sl_to_double(at(g->position_x, g->position_y, g->position_z, i)));
            double cx = sl_dotd(sl_to_double(at(g->normal_x, g->normal_y, g->normal_z, i)), d);
            double gx = sl_dotd(sl_to_double(at(g->geometric_x, g->geometric_y, g->geometric_z, i)), d);
            double cy = -sl_dotd(sl_to_double(p->normal), d), squared = sl_dotd(d, d), alpha = (double)p->cos_alpha;
            if (cx <= 0.0 || cy <= 0.0 || gx <= 0.0) continue;
            sum += (double)p->flux.r * cx * cy / squared * alpha / (squared * alpha + (double)p->footprint / SL_PI);
        }
        double expected = (double)g->diffuse_r[i] / SL_PI * sum;
        assert_true(fabs((double)lanes.value[0][i] - expected) < 2e-6 * largest);
    }
    free_planes(&lanes);
    free_photons(photons);
    free_receivers(r);
}

/* ---- the same bits ---- */

static void every_supply_of_photons_gives_the_same_bits(void **state) {
    sl_map_photons *photons = room_photons(false);
    for (uint32_t materials = 0; materials <= 2; materials += 2) {
        sl_receivers *receivers = random_receivers(materials);
        for (int w = 0; w < WEIGHTS; w++) {
            sl_light_pass pass = {.scene = *state, .photons = photons, .weight = all_weights[w], .threads = 1};
            sl_counters costs[3] = {{{0}}};
            planes of[3];
            for (int s = 0; s < 3; s++) {
                pass.supply = (sl_photon_supply)s;
                of[s] = light_up(&pass, receivers, NULL, &costs[s]);
                assert_same_bits(of[0], of[s]);
            }
            uint64_t look_ups = costs[0].value[SL_COUNT_PHOTON_LOOK_UPS];
            assert_true(look_ups > 0);
            assert_int_equal(costs[SL_PHOTONS_IN_TEXTURES].value[SL_COUNT_TEXTURE_FETCHES], 3 * look_ups);
            assert_int_equal(costs[SL_PHOTONS_IN_REGISTERS].value[SL_COUNT_TEXTURE_FETCHES], 0);
            for (int s = 0; s < 3; s++) free_planes(&of[s]);
        }
        free_receivers(receivers);
    }
    free_photons(photons);
}

static void bits_do_not_depend_on_threads_or_instruction_sets(void **state) {
    sl_receivers *receivers = random_receivers(2);
    static const char *const isas[] = {"baseline", "avx2", "avx512"};
    for (int lobes = 0; lobes < 2; lobes++) {
        sl_map_photons *photons = room_photons(lobes);
        for (int w = 0; w < WEIGHTS; w++) {
            sl_light_pass pass = {.scene = *state, .photons = photons, .weight = all_weights[w], .threads = 1};
            float *spread = calloc(2 * PIXELS, sizeof *spread);
            assert_non_null(spread);
            sl_counters first = {{0}};
            planes expected = light_up(&pass, receivers, spread, &first);
            for (unsigned k = 0; k < 3; k++) {
                sl_counters costs = {{0}};
                assert_int_equal(setenv("SOFTLUX_ISA", isas[k], 1), 0);
                pass.threads = k + 1;
                planes got = light_up(&pass, receivers, spread + PIXELS, &costs);
                unsetenv("SOFTLUX_ISA");
                assert_same_bits(expected, got);
                assert_memory_equal(spread, spread + PIXELS, PIXELS * sizeof *spread);
                assert_memory_equal(&first, &costs, sizeof costs);
                free_planes(&got);
            }
            free_planes(&expected);
            free(spread);
        }
        free_photons(photons);
    }
    free_receivers(receivers);
}

static int make_scene(void **state) {
    *state = receiver_scene();
    return 0;
}

static int destroy_scene(void **state) {
    sl_scene_destroy(*state);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(picture_has_the_bits_of_the_plain_double_loop),
        cmocka_unit_test(lambertian_receiver_agrees_with_a_double_loop_in_double),
        cmocka_unit_test(every_supply_of_photons_gives_the_same_bits),
        cmocka_unit_test(bits_do_not_depend_on_threads_or_instruction_sets),
    };
    return cmocka_run_group_tests(tests, make_scene, destroy_scene);
}
