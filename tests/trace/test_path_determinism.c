/* The path tracer's bits depend on the scene, the settings and the seed alone. */
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "trace/trace.h"
#include "trace_scenes.h"

enum { WIDTH = 61, HEIGHT = 43, PIXELS = WIDTH * HEIGHT, SAMPLES = 6 };

enum { LAMP = 1, POINT = 2, DISTANT = 8, SKY = 16 };

static sl_scene *rich_scene(void) { return trace_scene_lit_by(LAMP | POINT | DISTANT | SKY, true); }

static trace_picture render(const sl_scene *scene, const char *transport, uint64_t seed, bool backwards) {
    const sl_path_settings settings = {
        .width = WIDTH, .height = HEIGHT, .threads = 2, .seed = seed, .transport = transport_of(transport)};
    return trace_picture_of(scene, &settings, SAMPLES, backwards);
}

/* Another seed gives another picture, the same seed the same, in whatever order the samples are taken, up to
 * the rounding of the sums. */
static void the_seed_and_nothing_else_chooses_the_samples(void **unused) {
    sl_scene *scene = rich_scene();
    trace_picture a = render(scene, "full", 5, false), b = render(scene, "full", 6, false),
                  c = render(scene, "full", 5, true);
    size_t differ = 0;
    for (int i = 0; i < 3 * PIXELS; i++) {
        differ += a.plane[0][0][i] != b.plane[0][0][i];
        assert_true(fabsf(a.plane[0][0][i] - c.plane[0][0][i]) <= 1e-6f * a.plane[0][0][i]);
    }
    assert_true(differ > PIXELS);
    assert_memory_equal(&a.counters, &c.counters, sizeof a.counters);
    assert_int_equal(a.counters.value[SL_COUNT_SAMPLES], (uint64_t)PIXELS * SAMPLES);
    trace_picture_free(&a);
    trace_picture_free(&b);
    trace_picture_free(&c);
    sl_scene_destroy(scene);
}

/* The mean of all is the mean of the halves; and the halves' errors are not correlated, so that their
 * difference is the noise. */
static void the_two_halves_are_independent(void **unused) {
    sl_scene *scene = rich_scene();
    trace_picture p = render(scene, "direct", 5, false);
    enum { TRIALS = 24 };
    trace_picture truth[TRIALS];
    static double mean[3 * PIXELS];
    memset(mean, 0, sizeof mean);
    for (int k = 0; k < TRIALS; k++) {
        truth[k] = render(scene, "direct", 100 + (uint64_t)k, false);
        for (int i = 0; i < 3 * PIXELS; i++) mean[i] += (double)truth[k].plane[0][0][i] / TRIALS;
    }
    double covariance = 0.0, variance = 0.0;
    for (int i = 0; i < 3 * PIXELS; i++) {
        assert_true(fabsf(p.plane[0][0][i] - 0.5f * (p.plane[1][0][i] + p.plane[2][0][i])) <=
                    1e-5f * p.plane[0][0][i]);
        double even = (double)p.plane[1][0][i] - mean[i], odd = (double)p.plane[2][0][i] - mean[i];
        covariance += even * odd;
        variance += 0.5 * (even * even + odd * odd);
    }
    assert_true(variance > 0.0);
    assert_true(fabs(covariance) < 0.1 * variance);
    for (int k = 0; k < TRIALS; k++) trace_picture_free(&truth[k]);
    trace_picture_free(&p);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_seed_and_nothing_else_chooses_the_samples),
        cmocka_unit_test(the_two_halves_are_independent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
