/* K-means on directions. */
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "cache/light_octree/voxel_lights.h"

enum { MOST = 6000 };

typedef struct cloud {
    float x[MOST], y[MOST], z[MOST];
    double weight[MOST], scratch[MOST];
    uint8_t of[MOST];
    sl_directions directions;
} cloud;

static cloud *new_cloud(void) {
    cloud *c = calloc(1, sizeof *c);
    assert_non_null(c);
    c->directions = (sl_directions){0, c->x, c->y, c->z, c->weight};
    return c;
}

static void add(cloud *c, sl_vec3d d, double weight) {
    size_t i = c->directions.count++;
    sl_vec3 unit = sl_normalize_or(sl_to_float(d), sl_v3(0, 0, 1));
    c->x[i] = unit.x;
    c->y[i] = unit.y;
    c->z[i] = unit.z;
    c->weight[i] = weight;
}

static sl_vec3d cosine_distributed(uint64_t key, uint64_t i) {
    double s = (double)sl_random_unit(key, 2 * i), r = sqrt(s),
           phi = 2.0 * SL_PI * (double)sl_random_unit(key, 2 * i + 1);
    return sl_v3d(r * sl_cos(phi), r * sl_sin(phi), sqrt(1.0 - s));
}

/* kind 0: cosine law; 1: any direction; 2: two narrow lobes */
static cloud *random_cloud(size_t count, int kind, uint64_t seed) {
    cloud *c = new_cloud();
    uint64_t key = sl_random_key(seed, 0), more = sl_random_key(seed, 1);
    for (uint64_t i = 0; i < count; i++) {
        sl_vec3d d = cosine_distributed(key, i);
        if (kind == 1 && i % 2) d.z = -d.z;
        if (kind == 2) d = sl_addd(i % 3 ? sl_v3d(3, 0, 4) : sl_v3d(-4, 1, 3), sl_scaled(d, 0.7));
        add(c, d, 0.1 + (double)sl_random_unit(more, i));
    }
    return c;
}

static double cost_of(const cloud *c, const sl_clusters *clusters) {
    double sum = 0.0;
    for (size_t i = 0; i < c->directions.count; i++) {
        sl_vec3d d =
            sl_subd(sl_v3d((double)c->x[i], (double)c->y[i], (double)c->z[i]), clusters->centre[c->of[i]]);
        sum += c->weight[i] * sl_dotd(d, d);
    }
    return sum;
}

/* The spread by weight: mean squared chord = J / W, an angle psi has the chord 2 sin(psi / 2). */
static double rms_angle(const cloud *c, const sl_clusters *clusters) {
    double weight = 0.0;
    for (size_t i = 0; i < c->directions.count; i++) weight += c->weight[i];
    return 2.0 * sl_asin(0.5 * sqrt(clusters->cost / weight));
}

static void the_cost_never_rises_and_is_what_it_says(void **state) {
    for (int n = 1; n <= 8; n++) {
        for (int kind = 0; kind < 3; kind++) {
            cloud *c = random_cloud(300, kind, (uint64_t)(10 * n + kind));
            sl_clusters clusters;
            double before = INFINITY;
            for (int step = 1; step < 60; step++) {
                SL_KERNEL_OF(sl_isa_best(), sl_cluster)
                (&c->directions, n, step, c->of, c->scratch, &clusters);
                assert_int_equal(clusters.count, n);
                assert_true(fabs(clusters.cost - cost_of(c, &clusters)) < 1e-5 * (double)c->directions.count);
                assert_true(clusters.cost <= before * (1.0 + 1e-12));
                before = clusters.cost;
                assert_true(step < 59 || clusters.iterations < step); /* it settles */
            }
            free(c);
        }
    }
}

static void one_cluster_is_the_weighted_mean(void **state) {
    cloud *c = random_cloud(301, 0, 4);
    sl_vec3d mean = {0};
    double weight = 0.0;
    for (size_t i = 0; i < 301; i++) {
        mean =
            sl_addd(mean, sl_scaled(sl_v3d((double)c->x[i], (double)c->y[i], (double)c->z[i]), c->weight[i]));
        weight += c->weight[i];
    }
    sl_clusters clusters;
    sl_cluster_directions(&c->directions, 1, c->of, c->scratch, &clusters);
    double resultant = sl_lengthd(mean) / weight;
    assert_true(sl_lengthd(sl_subd(clusters.centre[0], sl_scaled(mean, 1.0 / sl_lengthd(mean)))) < 1e-12);
    /* Mean squared chord = 2 (1 - R). */
    assert_true(fabs(rms_angle(c, &clusters) - 2.0 * sl_asin(0.5 * sqrt(2.0 * (1.0 - resultant)))) < 1e-7);
    free(c);
}

/* RMS angle from photons to the lights they are put to: 6,000 photons of a cosine law, equal weights; with
 * 300 of them a little less. */
static void the_spread_over_the_number_of_lights_is_as_simulated(void **state) {
    const int counts[] = {1, 2, 3, 4, 6, 8};
    const double many[] = {48.7, 37.9, 30.1, 26.2, 21.4, 18.8}, few[] = {47.1, 35.5, 28.9, 25.1, 20.9, 18.0};
    int capped = 0;
    for (int k = 0; k < 6; k++) {
        cloud *c = new_cloud();
        uint64_t key = sl_random_key(77, 0);
        for (uint64_t i = 0; i < MOST; i++) add(c, cosine_distributed(key, i), 1.0);
        sl_clusters clusters;
        sl_cluster_directions(&c->directions, counts[k], c->of, c->scratch, &clusters);
        double degrees = rms_angle(c, &clusters) * 180.0 / SL_PI;
        if (fabs(degrees - many[k]) > 0.03 * many[k])
            fail_msg("%d lights: %.2f degrees, not %.1f", counts[k], degrees, many[k]);
        double mean = 0.0;
        for (uint64_t run = 0; run < 20; run++) {
            c->directions.count = 0;
            key = sl_random_key(78, run);
            for (uint64_t i = 0; i < 300; i++) add(c, cosine_distributed(key, i), 1.0);
            sl_cluster_directions(&c->directions, counts[k], c->of, c->scratch, &clusters);
            capped += clusters.iterations == SL_CLUSTER_ITERATIONS;
            mean += rms_angle(c, &clusters) * 180.0 / SL_PI / 20.0;
        }
        if (fabs(mean - few[k]) > 0.05 * few[k])
            fail_msg("%d lights, 300 photons: %.2f degrees, not %.1f", counts[k], mean, few[k]);
        free(c);
    }
    assert_true(capped <= 6); /* of 120: the rest settle */
}

static void equal_directions_are_one_cluster(void **state) {
    cloud *c = new_cloud();
    for (int i = 0; i < 50; i++) add(c, sl_v3d(0.36, 0.48, 0.8), 1.0 + i);
    sl_clusters clusters;
    sl_cluster_directions(&c->directions, 8, c->of, c->scratch, &clusters);
    assert_int_equal(clusters.count, 1);
    assert_true(sl_lengthd(sl_subd(clusters.centre[0], sl_v3d(0.36, 0.48, 0.8))) < 1e-7);
    assert_true(rms_angle(c, &clusters) < 1e-3);
    for (int i = 0; i < 50; i++) add(c, i % 2 ? sl_v3d(0, 0, 1) : sl_v3d(0, 1, 0), 1.0);
    sl_cluster_directions(&c->directions, 8, c->of, c->scratch, &clusters);
    assert_int_equal(clusters.count, 3); /* as many as there are directions */
    assert_true(clusters.cost < 1e-5);
    free(c);
}

static void opposed_directions_split_or_fall_back_on_the_heaviest(void **state) {
    cloud *c = new_cloud();
    add(c, sl_v3d(1, 0, 0), 2.0);
    add(c, sl_v3d(-1, 0, 0), 2.0);
    add(c, sl_v3d(0, 0, 1), 1.0);
    add(c, sl_v3d(0, 0, -1), 1.0);
    sl_clusters clusters;
    sl_cluster_directions(&c->directions, 1, c->of, c->scratch, &clusters); /* the mean vanishes */
    assert_int_equal(clusters.count, 1);
    assert_true(clusters.centre[0].x == 1.0 && fabs(clusters.cost - 12.0) < 1e-12);
    sl_cluster_directions(&c->directions, 4, c->of, c->scratch, &clusters);
    assert_int_equal(clusters.count, 4);
    assert_true(clusters.cost < 1e-12);
    free(c);
}

static void instruction_sets_and_ties_give_the_same_bits(void **state) {
    const char *isas[] = {"baseline", "avx2", "avx512"};
    for (size_t count = 1; count < 400; count = count * 2 + 1) {
        for (int n = 1; n <= 8; n++) {
            sl_clusters first, other;
            uint8_t of[400];
            for (int k = 0; k < 3; k++) {
                assert_int_equal(setenv("SOFTLUX_ISA", isas[k], 1), 0);
                cloud *c = random_cloud(count, 1, count + (size_t)n);
                memset(k ? &other : &first, 0, sizeof first);
                sl_cluster_directions(&c->directions, n, c->of, c->scratch, k ? &other : &first);
                if (k == 0) memcpy(of, c->of, count);
                else assert_memory_equal(of, c->of, count);
                if (k > 0) assert_memory_equal(&first, &other, sizeof first);
                free(c);
            }
            unsetenv("SOFTLUX_ISA");
            assert_true(first.count == (count < (size_t)n ? (int)count : n));
        }
    }
}

static void nothing_gives_nothing(void **state) {
    cloud *c = new_cloud();
    sl_clusters clusters;
    sl_cluster_directions(&c->directions, 4, c->of, c->scratch, &clusters);
    assert_true(clusters.count == 0 && clusters.cost == 0.0);
    free(c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cost_never_rises_and_is_what_it_says),
        cmocka_unit_test(one_cluster_is_the_weighted_mean),
        cmocka_unit_test(the_spread_over_the_number_of_lights_is_as_simulated),
        cmocka_unit_test(equal_directions_are_one_cluster),
        cmocka_unit_test(opposed_directions_split_or_fall_back_on_the_heaviest),
        cmocka_unit_test(instruction_sets_and_ties_give_the_same_bits),
        cmocka_unit_test(nothing_gives_nothing),
    };
    return cmocka_run_group_tests_name("light octree: clusters", tests, NULL, NULL);
}
