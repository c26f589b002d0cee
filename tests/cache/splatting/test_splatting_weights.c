/* One record's contribution to a pixel (Algorithm 1 of radiance cache splatting), and how far a record
 * reaches. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "unit_test.h"
#include "base/memory.h"
#include "base/random.h"
#include "cache/splatting/record.h"

enum { SIDE = 16, PIXELS = SIDE * SIDE };

/* A patch of receivers that a test fills in. */
typedef struct {
    float px[PIXELS], py[PIXELS], pz[PIXELS], nx[PIXELS], ny[PIXELS], nz[PIXELS];
    uint32_t receives[PIXELS];
    float r[PIXELS], g[PIXELS], b[PIXELS], weight[PIXELS], count[PIXELS], coverage[PIXELS];
    sl_splat_receivers receivers;
} patch;

/* The patch as a tile of the screen; the sums of earlier splats come and go with it. */
static sl_tile_planes tile;

static void into_tile(const patch *p) {
    memset(&tile, 0x7f, sizeof tile); /* what an earlier tile may have left */
    SL_KERNEL_OF(sl_isa_best(), sl_splat_fetch)(&p->receivers, 0, 0, (sl_splat_rect){0, 0, SIDE, SIDE},
                                                &tile);
    for (int i = 0; i < PIXELS; i++) {
        int at = i / SIDE * SL_SPLAT_TILE + i % SIDE;
        tile.r[at] = p->r[i], tile.g[at] = p->g[i], tile.b[at] = p->b[i];
        tile.weight[at] = p->weight[i], tile.count[at] = p->count[i];
    }
}

static void out_of_tile(patch *p) {
    for (int i = 0; i < PIXELS; i++) {
        int at = i / SIDE * SL_SPLAT_TILE + i % SIDE;
        p->r[i] = tile.r[at], p->g[i] = tile.g[at], p->b[i] = tile.b[at];
        p->weight[i] = tile.weight[at], p->count[i] = tile.count[at];
    }
}

static void patch_clear(patch *p) {
    memset(p, 0, sizeof *p);
    for (int i = 0; i < PIXELS; i++) p->nz[i] = 1.0f, p->receives[i] = 1;
    p->receivers = (sl_splat_receivers){SIDE, SIDE, p->px, p->py, p->pz, p->nx, p->ny, p->nz, p->receives};
}

/* The plane z = 0, one unit square. */
static void patch_plane(patch *p) {
    patch_clear(p);
    for (int i = 0; i < PIXELS; i++) {
        p->px[i] = ((float)(i % SIDE) + 0.5f) / SIDE;
        p->py[i] = ((float)(i / SIDE) + 0.5f) / SIDE;
    }
}

static sl_record record_at(float x, float y, float radius, float irradiance) {
    return (sl_record){.position = {x, y, 0.0f},
                       .normal = {0.0f, 0.0f, 1.0f},
                       .radius = radius,
                       .stretch = 1.0f,
                       .irradiance = {irradiance, irradiance, irradiance}};
}

static const sl_weight_rules wards = {0.5f, 0.0f, 1e-6f}, smooth = {0.5f, 2.0f, 1e-6f};

static void splat(patch *p, const sl_record *records, size_t count, const sl_weight_rules *rules) {
    into_tile(p);
    for (size_t k = 0; k < count; k++)
        SL_KERNEL_OF(sl_isa_best(), sl_splat_record)(&records[k], rules, (sl_splat_rect){0, 0, SIDE, SIDE},
                                                     true, &tile, NULL);
    out_of_tile(p);
}

static void two_records_mix_as_computed_by_hand(void **state) {
    patch p;
    patch_clear(&p);
    p.px[0] = 1.0f;
    sl_record records[2] = {record_at(0.0f, 0.0f, 4.0f, 3.0f), record_at(1.5f, 0.0f, 2.0f, 6.0f)};
    splat(&p, records, 2, &wards); /* D = 1/4 and 1/4: weights 4 and 4 */
    assert_true(fabs((double)p.weight[0] - 8.0) < 1e-6);
    assert_true(fabs((double)(p.r[0] / p.weight[0]) - 4.5) < 1e-6);
    assert_true(p.count[0] == 2.0f);
}

static void a_pixel_at_D_equal_to_a_contributes_and_one_ulp_beyond_does_not(void **state) {
    patch p;
    patch_clear(&p);
    p.px[0] = 1.0f;
    p.px[1] = nextafterf(1.0f, 2.0f);
    sl_record record = record_at(0.0f, 0.0f, 2.0f, 1.0f);
    splat(&p, &record, 1, &wards);
    assert_true(p.weight[0] == 2.0f);
    assert_true(p.weight[1] == 0.0f);
}

static void a_field_linear_on_a_plane_is_reproduced(void **state) {
    patch p;
    patch_plane(&p);
    sl_record records[12];
    uint64_t key = sl_random_key(1, 2);
    for (uint64_t k = 0; k < 12; k++) {
        float x = sl_random_unit(key, 2 * k), y = sl_random_unit(key, 2 * k + 1);
        records[k] = record_at(x, y, 3.0f, 4.0f + x - 0.5f * y);
        for (int c = 0; c < 3; c++) records[k].translational[c] = sl_v3(1.0f, -0.5f, 0.0f);
    }
    splat(&p, records, 12, &smooth);
    for (int i = 0; i < PIXELS; i++) {
        double wanted = 4.0 + (double)p.px[i] - 0.5 * (double)p.py[i];
        assert_true(p.weight[i] > 0.0f);
        assert_true(fabs((double)(p.g[i] / p.weight[i]) - wanted) < 2e-6 * wanted);
    }
}

static void a_turned_receiver_takes_the_rotational_gradient(void **state) {
    patch p;
    patch_clear(&p);
    const float angle = 0.1f;
    p.nx[0] = sinf(angle);
    p.nz[0] = cosf(angle);
    sl_record record = record_at(0.0f, 0.0f, 2.0f, 1.0f);
    record.rotational[0] = sl_v3(0.0f, 2.0f, 0.0f); /* n_k x n = (0, sin, 0) */
    record.rotational_length[0] = 2.0f;
    splat(&p, &record, 1, &wards);
    assert_true(fabs((double)(p.r[0] / p.weight[0]) - (1.0 + 2.0 * sin(0.1))) < 1e-6);
    assert_true(fabs((double)(p.g[0] / p.weight[0]) - 1.0) < 1e-6);
}

static void extrapolation_is_never_negative_nor_beyond_what_the_record_knows(void **state) {
    patch p;
    patch_clear(&p);
    p.px[0] = 0.9f;
    p.px[1] = -0.9f;
    sl_record record = record_at(0.0f, 0.0f, 2.0f, 1.0f);
    for (int c = 0; c < 3; c++) record.translational[c] = sl_v3(-10.0f, 0.0f, 0.0f);
    splat(&p, &record, 1, &wards);
    assert_true(p.r[0] == 0.0f);
    assert_true(fabs((double)(p.r[1] / p.weight[1]) - 1.5) < 1e-6); /* E (1 + a) */
}

static void the_weight_at_the_record_itself_is_finite(void **state) {
    patch p;
    patch_clear(&p);
    sl_record record = record_at(0.0f, 0.0f, 2.0f, 1.0f);
    splat(&p, &record, 1, &wards);
    assert_true(fabsf(p.weight[0] - 1000.0f) < 0.01f);
}

static void pixels_that_are_not_finite_and_records_there_add_nothing(void **state) {
    const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f};
    for (int i = 0; i < 5; i++) {
        patch p;
        patch_clear(&p);
        p.px[0] = p.py[1] = p.pz[2] = p.nx[3] = p.ny[4] = p.nz[5] = bad[i];
        sl_record record = record_at(0.0f, 0.0f, 2.0f, 1.0f);
        splat(&p, &record, 1, &wards);
        for (int k = 0; k < 6; k++)
            assert_true(p.weight[k] == 0.0f && p.r[k] == 0.0f && p.g[k] == 0.0f && p.b[k] == 0.0f);
        assert_true(p.weight[6] > 0.0f && p.r[6] > 0.0f);
        patch_clear(&p);
        record.normal.x = bad[i];
        splat(&p, &record, 1, &wards);
        record = record_at(bad[i], 0.0f, 2.0f, 1.0f);
        splat(&p, &record, 1, &wards);
        for (int k = 0; k < PIXELS; k++) assert_true(p.weight[k] == 0.0f && p.r[k] == 0.0f);
    }
}

static void gradients_that_are_not_finite_stay_within_what_the_record_knows(void **state) {
    const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f};
    for (int i = 0; i < 5; i++) {
        patch p;
        patch_clear(&p);
        for (int k = 0; k < PIXELS; k++) p.px[k] = 0.04f * (float)(k % 10);
        sl_record record = record_at(0.0f, 0.0f, 2.0f, 1.0f);
        for (int c = 0; c < 3; c++) record.translational[c] = sl_v3(bad[i], bad[i], 0.0f);
        sl_record_set_radius(&record, 1.0f);
        splat(&p, &record, 1, &wards);
        for (int k = 0; k < PIXELS; k++) {
            if (!(p.weight[k] > 0.0f)) continue;
            float e = p.r[k] / p.weight[k];
            assert_true(e >= 0.0f && e <= (1.0f + wards.accuracy) * 1.0001f);
        }
    }
}

static void a_record_in_front_of_a_pixel_is_refused(void **state) {
    patch p;
    patch_clear(&p);
    p.pz[0] = -0.2f; /* the record floats above this floor pixel: it sees what the floor does not */
    p.pz[1] = 0.2f;
    sl_record record = record_at(0.0f, 0.0f, 2.0f, 1.0f);
    splat(&p, &record, 1, &wards);
    assert_true(p.weight[0] == 0.0f);
    assert_true(p.weight[1] > 0.0f);
}

/* A record of the floor, far below the tread of a step: it sees another piece of the world. aR = 1, so half
 * of it is the most. */
static void a_record_far_behind_a_pixel_is_refused(void **state) {
    patch p;
    patch_clear(&p);
    sl_record record = record_at(0.0f, 0.0f, 2.0f, 1.0f);
    for (int i = 0; i < PIXELS; i++) p.pz[i] = (float)i / PIXELS;
    splat(&p, &record, 1, &wards);
    for (int i = 0; i < PIXELS; i++) assert_true((p.weight[i] > 0.0f) == (i <= PIXELS / 2));
}

static void no_record_on_a_sphere_is_refused_for_curvature(void **state) {
    patch p;
    for (int inside = 0; inside < 2; inside++) {
        patch_clear(&p);
        float side = inside ? -1.0f : 1.0f;
        sl_record record = record_at(0.0f, 0.0f, 4.0f, 1.0f);
        record.position = sl_v3(0.0f, 0.0f, 1.0f);
        record.normal = sl_v3(0.0f, 0.0f, side);
        for (int i = 0; i < PIXELS; i++) {
            float theta = 0.3f * (float)(i + 1) / PIXELS;
            p.px[i] = sinf(theta), p.pz[i] = cosf(theta);
            p.nx[i] = side * p.px[i], p.nz[i] = side * p.pz[i];
        }
        splat(&p, &record, 1, &wards);
        for (int i = 0; i < PIXELS; i++) assert_true(p.weight[i] > 0.0f);
    }
}

static void coverage_has_the_bits_of_the_splatted_weight_on_every_instruction_set(void **state) {
    static patch reference, p;
    sl_record records[20];
    uint64_t key = sl_random_key(5, 6);
    for (uint64_t k = 0; k < 20; k++) {
        records[k] = record_at(sl_random_unit(key, 4 * k), sl_random_unit(key, 4 * k + 1),
                               0.2f + sl_random_unit(key, 4 * k + 2), 1.0f);
        records[k].translational[0] = sl_v3(sl_random_unit(key, 4 * k + 3), 0.3f, 0.0f);
        records[k].rotational[1] = sl_v3(0.3f, 0.1f, 0.0f);
        records[k].rotational_length[1] = 0.32f;
    }
    for (int isa = 0; isa <= (int)sl_isa_best(); isa++) {
        patch_plane(&p);
        for (int i = 0; i < PIXELS; i++)
            p.pz[i] = 0.01f * sl_random_unit(key, 1000 + (uint64_t)i), p.receives[i] = i % 7 != 0;
        const sl_splat_rect some = {3, 1, SIDE - 5, SIDE - 2}; /* runs that fill no vector */
        uint64_t splatted = 0, covered = 0, expected = 0;
        into_tile(&p);
        for (int n = 0; n < 20; n++)
            splatted += SL_KERNEL_OF((sl_isa)isa, sl_splat_record)(&records[n], &smooth, some, true, &tile,
                                                                      NULL);
        out_of_tile(&p);
        memset(tile.weight, 0, sizeof tile.weight);
        for (int n = 0; n < 20; n++)
            covered += SL_KERNEL_OF((sl_isa)isa, sl_splat_record)(&records[n], &smooth, some, false, &tile,
                                                                     NULL);
        for (size_t i = 0; i < PIXELS; i++) { /* and those of adding single pixels in record order */
            float sum = 0.0f;
            int x = (int)i % SIDE, y = (int)i / SIDE;
            bool inside = x >= some.x0 && x < some.x1 && y >= some.y0 && y < some.y1;
            for (int n = 0; n < 20 && inside; n++) {
                float w = SL_KERNEL_OF((sl_isa)isa, sl_splat_weight)(&records[n], &smooth, &p.receivers, i);
                sum += w;
                expected += w > 0.0f;
            }
            assert_true(sum == p.weight[i]);
            assert_true(tile.weight[y * SL_SPLAT_TILE + x] == sum);
        }
        assert_int_equal(splatted, expected);
        assert_int_equal(covered, expected);
        if (isa == 0) reference = p;
        assert_memory_equal(p.r, reference.r, sizeof p.r);
        assert_memory_equal(p.g, reference.g, sizeof p.g);
        assert_memory_equal(p.weight, reference.weight, sizeof p.weight);
        assert_memory_equal(p.count, reference.count, sizeof p.count);
    }
}

/* ---- radii ---- */

static const sl_gather_point at_origin = {.normal = {0, 0, 1}, .geometric_normal = {0, 0, 1}, .triangle = 0};

static sl_radius_rules rules_with(double accuracy, double maximum, bool guard) {
    return (sl_radius_rules){.accuracy = accuracy,
                             .minimum_pixels = 1.5,
                             .maximum_radius = maximum,
                             .guard = guard,
                             .gather = SL_GATHER_RAYS,
                             .plane_tangent = 2.7};
}

static sl_irradiance seen(float value, float slope, float harmonic_mean, float nearest) {
    sl_irradiance e = {.value = sl_grey(value), .harmonic_mean = harmonic_mean, .nearest = nearest};
    for (int c = 0; c < 3; c++) e.translational[c] = sl_v3(slope, 0.0f, 0.0f);
    return e;
}

static void the_radius_is_the_harmonic_mean_where_nothing_limits_it(void **state) {
    sl_radius_rules rules = rules_with(0.2, 100.0, true);
    sl_irradiance e = seen(1.0f, 0.0f, 3.0f, 3.0f);
    assert_true(sl_record_make(&at_origin, &e, &rules, 0.001f).radius == 3.0f);
}

static void a_steep_gradient_limits_the_radius_to_where_the_extrapolation_stays_positive(void **state) {
    sl_radius_rules rules = rules_with(0.2, 100.0, true);
    sl_irradiance e = seen(1.0f, 2.0f, 3.0f, 3.0f);
    assert_true(fabsf(sl_record_make(&at_origin, &e, &rules, 0.001f).radius - 0.5f) < 1e-6f);
}

static void the_guard_keeps_a_record_from_reaching_through_a_wall(void **state) {
    sl_irradiance e = seen(1.0f, 0.0f, 4.7f, 1.0f); /* a lone wall at distance 1: harmonic mean 3 pi / 2 */
    sl_radius_rules rules = rules_with(0.5, 100.0, true);
    assert_true(0.5f * sl_record_make(&at_origin, &e, &rules, 0.001f).radius <= 1.0f);
    rules.guard = false;
    assert_true(0.5f * sl_record_make(&at_origin, &e, &rules, 0.001f).radius > 1.0f);
}

/* The plane's lowest ray, of slope 1 / t, meets the wall so high up that r / cos theta' is (1 + t^2) / t^2
 * there. */
static void the_guard_knows_how_low_a_plane_sees(void **state) {
    for (int i = 0; i < 3; i++) {
        float t = 0.5f + (float)i, lowest = (1.0f + t * t) / (t * t);
        sl_irradiance e = seen(1.0f, 0.0f, 40.0f, lowest);
        sl_radius_rules rules = rules_with(0.5, 100.0, true);
        rules.gather = SL_GATHER_PLANE;
        rules.plane_tangent = (double)t;
        assert_true(fabsf(0.5f * sl_record_make(&at_origin, &e, &rules, 0.001f).radius - 1.0f) < 1e-5f);
        rules.gather = SL_GATHER_RAYS;
        assert_true(fabsf(0.5f * sl_record_make(&at_origin, &e, &rules, 0.001f).radius - lowest) < 1e-5f);
    }
}

static void the_minimum_radius_overrides_the_guard_and_the_gradient_shrinks(void **state) {
    sl_radius_rules rules = rules_with(0.5, 100.0, true);
    sl_irradiance e = seen(1.0f, 50.0f, 0.001f, 1e-4f);
    sl_record r = sl_record_make(&at_origin, &e, &rules, 0.1f);
    assert_true(fabsf(0.5f * r.radius - 0.15f) < 1e-6f); /* 1.5 footprints */
    assert_true(r.translational[0].x * r.radius <= 1.0001f);
}

static void the_least_reach_halves_where_light_is_steep_within_it(void **state) {
    const float footprint = 0.1f; /* 1.5 of them are the least reach */
    for (int i = 0; i < 2; i++) {
        sl_radius_rules rules = rules_with(0.5, 100.0, true);
        rules.steep = i ? 0.2 : 0.0;
        sl_irradiance gentle = seen(1.0f, 1.3f, 0.001f, 1e-4f), steep = seen(1.0f, 1.4f, 0.001f, 1e-4f),
                      dark = seen(0.0f, 0.0f, 0.001f, 1e-4f);
        sl_record r = sl_record_make(&at_origin, &gentle, &rules, footprint);
        assert_true(fabsf(0.5f * r.radius - 0.15f) < 1e-6f);
        r = sl_record_make(&at_origin, &steep, &rules, footprint);
        assert_true(fabsf(0.5f * r.radius - (i ? 0.075f : 0.15f)) < 1e-6f && r.minimum_radius == r.radius);
        r = sl_record_make(&at_origin, &dark, &rules, footprint);
        assert_true(fabsf(0.5f * r.radius - 0.15f) < 1e-6f);
    }
}

static void seeing_nothing_gives_the_maximum_radius(void **state) {
    sl_radius_rules rules = rules_with(0.25, 2.0, true);
    sl_irradiance e = seen(0.0f, 0.0f, INFINITY, INFINITY);
    assert_true(sl_record_make(&at_origin, &e, &rules, 0.001f).radius == 8.0f);
    e.harmonic_mean = NAN;
    assert_true(sl_record_make(&at_origin, &e, &rules, 0.001f).radius == 8.0f);
}

/* The least R_j + |p - p_j|, looked for among all. */
static float brute_limit(const sl_record *records, size_t count, const sl_record *record) {
    float radius = record->own_radius;
    for (size_t j = 0; j < count; j++)
        radius =
            fminf(radius, records[j].own_radius + sl_length(sl_sub(record->position, records[j].position)));
    return radius > record->minimum_radius ? radius : record->minimum_radius;
}

static void clamped_radii_are_lipschitz_and_do_not_depend_on_the_order(void **state) {
    enum { N = 300, SAME_PLACE = 30 };
    static sl_record records[N];
    static float radius[N];
    sl_reach_tree tree = {0}, reversed = {0};
    uint64_t key = sl_random_key(7, 8);
    for (uint64_t i = 0; i < N; i++) {
        float u = sl_random_unit(key, 3 * i + 2);
        records[i] =
            record_at(10.0f * sl_random_unit(key, 3 * i), 10.0f * sl_random_unit(key, 3 * i + 1), 0.0f, 1.0f);
        if (i < SAME_PLACE) records[i].position = sl_v3(3, 4, 0);
        records[i].own_radius = 0.1f + 5.0f * u * u;
    }
    for (size_t i = 0; i < N; i++) {
        assert_int_equal(sl_reach_tree_insert(&tree, records[i].position, records[i].own_radius, NULL),
                         SL_OK);
        assert_int_equal(
            sl_reach_tree_insert(&reversed, records[N - 1 - i].position, records[N - 1 - i].own_radius, NULL),
            SL_OK);
    }
    for (size_t i = 0; i < N; i++) radius[i] = sl_record_clamped_radius(&tree, &records[i]);
    for (size_t i = 0; i < N; i++) {
        assert_true(radius[i] == sl_record_clamped_radius(&reversed, &records[i]));
        assert_true(radius[i] == brute_limit(records, N, &records[i]));
        for (size_t j = 0; j < N; j++) {
            float distance = sl_length(sl_sub(records[i].position, records[j].position));
            assert_true(radius[i] <= radius[j] + distance + 1e-5f);
        }
    }
    sl_free(tree.nodes);
    sl_free(reversed.nodes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_records_mix_as_computed_by_hand),
        cmocka_unit_test(a_pixel_at_D_equal_to_a_contributes_and_one_ulp_beyond_does_not),
        cmocka_unit_test(a_field_linear_on_a_plane_is_reproduced),
        cmocka_unit_test(a_turned_receiver_takes_the_rotational_gradient),
        cmocka_unit_test(extrapolation_is_never_negative_nor_beyond_what_the_record_knows),
        cmocka_unit_test(the_weight_at_the_record_itself_is_finite),
        cmocka_unit_test(pixels_that_are_not_finite_and_records_there_add_nothing),
        cmocka_unit_test(gradients_that_are_not_finite_stay_within_what_the_record_knows),
        cmocka_unit_test(a_record_in_front_of_a_pixel_is_refused),
        cmocka_unit_test(a_record_far_behind_a_pixel_is_refused),
        cmocka_unit_test(no_record_on_a_sphere_is_refused_for_curvature),
        cmocka_unit_test(coverage_has_the_bits_of_the_splatted_weight_on_every_instruction_set),
        cmocka_unit_test(the_radius_is_the_harmonic_mean_where_nothing_limits_it),
        cmocka_unit_test(a_steep_gradient_limits_the_radius_to_where_the_extrapolation_stays_positive),
        cmocka_unit_test(the_guard_keeps_a_record_from_reaching_through_a_wall),
        cmocka_unit_test(the_guard_knows_how_low_a_plane_sees),
        cmocka_unit_test(the_minimum_radius_overrides_the_guard_and_the_gradient_shrinks),
        cmocka_unit_test(the_least_reach_halves_where_light_is_steep_within_it),
        cmocka_unit_test(seeing_nothing_gives_the_maximum_radius),
        cmocka_unit_test(clamped_radii_are_lipschitz_and_do_not_depend_on_the_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
