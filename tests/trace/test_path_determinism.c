/* The path tracer's bits depend on the scene, the settings and the seed alone. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "base/random.h"
#include "trace/sequence.h"
#include "trace/trace.h"
#include "trace_scenes.h"

enum { WIDTH = 61, HEIGHT = 43, PIXELS = WIDTH * HEIGHT, SAMPLES = 6 };

/* Diffuse, glossy and mirror surfaces, every kind of light, a bumpy ball. */
static sl_scene *rich_scene(void) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t wall = trace_mesh_material(&mesh, 0.6f, 0, 0, 0, 0),
             glossy = trace_mesh_material(&mesh, 0.2f, 0.5f, 40, 0, 0);
    uint32_t mirror = trace_mesh_material(&mesh, 0, 0, 0, 0.9f, 0),
             lamp = trace_mesh_material(&mesh, 0, 0, 0, 0, 9.0f);
    trace_mesh_quad(&mesh, sl_v3(-3, -1, -3), sl_v3(0, 0, 6), sl_v3(6, 0, 0), wall);
    trace_mesh_quad(&mesh, sl_v3(-3, -1, -3), sl_v3(6, 0, 0), sl_v3(0, 4, 0), mirror);
    trace_mesh_sphere(&mesh, sl_v3(0.4f, 0, 0), 0.9f, 12, 0.2f, false, glossy);
    trace_mesh_quad(&mesh, sl_v3(-1, 2.5f, -1), sl_v3(1, 0, 0), sl_v3(0, 0, 1), lamp);
    mesh.lights[0] = (sl_light){.type = SL_LIGHT_POINT, .position = {2, 2, 2}, .intensity = {3, 2, 1}};
    mesh.lights[1] = (sl_light){
        .type = SL_LIGHT_DIRECTIONAL, .direction = {0, -0.6f, -0.8f}, .intensity = {0.5f, 0.5f, 0.7f}};
    mesh.light_count = 2;
    sl_environment sky = {.present = true, .constant = {0.1f, 0.15f, 0.3f}};
    mesh.environment = &sky;
    mesh.has_camera = true;
    assert_true(sl_camera_look_at(&mesh.camera, sl_v3(1, 1, 4), sl_v3(0, 0.2f, 0), sl_v3(0, 1, 0), 0.9f));
    return trace_mesh_build(&mesh);
}

typedef struct picture {
    float planes[3][3 * PIXELS]; /* all, even, odd samples */
    sl_counters counters;
} picture;

static picture *render(const sl_scene *scene, const char *transport, unsigned threads, uint64_t seed,
                       bool backwards) {
    picture *p = calloc(1, sizeof *p);
    sl_tracer *tracer;
    sl_path_tracer *path;
    sl_path_settings settings = {.width = WIDTH, .height = HEIGHT, .threads = threads, .seed = seed};
    assert_true(sl_transport_named(transport, &settings.transport));
    assert_int_equal(sl_tracer_create(scene, threads, NULL, &tracer, NULL), SL_OK);
    assert_int_equal(sl_path_tracer_create(scene, tracer, &settings, &path, NULL), SL_OK);
    for (uint64_t i = 0; i < SAMPLES; i++) {
        assert_int_equal(sl_path_tracer_sample(path, backwards ? SAMPLES - 1 - i : i, &p->counters, NULL),
                         SL_OK);
    }
    for (int half = -1; half < 2; half++) {
        float *plane = p->planes[half + 1];
        sl_path_tracer_mean(path, half, plane, plane + PIXELS, plane + 2 * PIXELS);
    }
    sl_path_tracer_destroy(path);
    sl_tracer_destroy(tracer);
    return p;
}

/* Another seed gives another picture, the same seed the same, in whatever order the samples are taken, up to
 * the rounding of the sums. */
static void the_seed_and_nothing_else_chooses_the_samples(void **unused) {
    (void)unused;
    sl_scene *scene = rich_scene();
    picture *a = render(scene, "full", 2, 5, false), *b = render(scene, "full", 2, 6, false),
            *c = render(scene, "full", 2, 5, true);
    size_t differ = 0;
    for (int i = 0; i < 3 * PIXELS; i++) {
        differ += a->planes[0][i] != b->planes[0][i];
        assert_true(fabsf(a->planes[0][i] - c->planes[0][i]) <= 1e-6f * a->planes[0][i]);
    }
    assert_true(differ > PIXELS);
    assert_memory_equal(&a->counters, &c->counters, sizeof a->counters);
    assert_int_equal(a->counters.value[SL_COUNT_SAMPLES], (uint64_t)PIXELS * SAMPLES);
    assert_int_equal(a->counters.value[SL_COUNT_NONFINITE], 0);
    free(a);
    free(b);
    free(c);
    sl_scene_destroy(scene);
}

/* The mean of all is the mean of the halves; and the halves' errors are not correlated, so that their
 * difference is the noise. */
static void the_two_halves_are_independent(void **unused) {
    (void)unused;
    sl_scene *scene = rich_scene();
    picture *p = render(scene, "direct", 2, 5, false);
    enum { TRIALS = 24 };
    picture *truth[TRIALS];
    static double mean[3 * PIXELS];
    memset(mean, 0, sizeof mean);
    for (int k = 0; k < TRIALS; k++) {
        truth[k] = render(scene, "direct", 2, 100 + (uint64_t)k, false);
        for (int i = 0; i < 3 * PIXELS; i++) mean[i] += (double)truth[k]->planes[0][i] / TRIALS;
    }
    double covariance = 0.0, variance = 0.0;
    for (int i = 0; i < 3 * PIXELS; i++) {
        assert_true(fabsf(p->planes[0][i] - 0.5f * (p->planes[1][i] + p->planes[2][i])) <=
                    1e-5f * p->planes[0][i]);
        double even = (double)p->planes[1][i] - mean[i], odd = (double)p->planes[2][i] - mean[i];
        covariance += even * odd;
        variance += 0.5 * (even * even + odd * odd);
    }
    assert_true(variance > 0.0);
    assert_true(fabs(covariance) < 0.1 * variance);
    for (int k = 0; k < TRIALS; k++) free(truth[k]);
    free(p);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_seed_and_nothing_else_chooses_the_samples),
        cmocka_unit_test(the_two_halves_are_independent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
