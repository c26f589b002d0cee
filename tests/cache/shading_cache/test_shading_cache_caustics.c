/* Caustics by photons: closed forms of plane mirrors, and nothing twice beside bidirectional paths. */
#include "renderer_support.h"

#include "cache/photons/photons.h"

/* A floor, a mirror of reflectance 0.8 at x = -1 whose front looks at +x, and a lamp of radiance 40, or a
 * point light. */
static sl_scene *floor_and_mirror(bool lamp_of_extent, float exponent) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t floor = trace_mesh_diffuse(&mesh, 0.5f), lamp = trace_mesh_lamp(&mesh, 40.0f);
    uint32_t mirror = exponent > 0 ? trace_mesh_material(&mesh, 0, 0.8f, exponent, 0, 0)
                                   : trace_mesh_material(&mesh, 0, 0, 0, 0.8f, 0);
    trace_mesh_quad(&mesh, sl_v3(-4, -4, 0), sl_v3(8, 0, 0), sl_v3(0, 8, 0), floor);
    trace_mesh_quad(&mesh, sl_v3(-1, -10, 0), sl_v3(0, 20, 0), sl_v3(0, 0, 10), mirror);
    /* a wall, which light reaches from the mirror */
    trace_mesh_quad(&mesh, sl_v3(-1, -2, 0), sl_v3(0, 0, 4), sl_v3(4, 0, 0), floor);
    /* faces the mirror */
    if (lamp_of_extent)
        trace_mesh_quad(&mesh, sl_v3(0.45f, -1.0f, 0.5f), sl_v3(0, 0, 2.0f), sl_v3(0, 2.0f, 0), lamp);
    else
        trace_mesh_point_light(&mesh, sl_v3(1.5f, 0.2f, 2.0f), (sl_rgb){10, 20, 30});
    return trace_mesh_build(&mesh);
}

static bool same_sample(const sl_sample *a, const sl_sample *b) {
    return memcmp(&a->irradiance, &b->irradiance, sizeof a->irradiance) == 0 &&
           memcmp(&a->variance, &b->variance, sizeof a->variance) == 0;
}

static const sl_vec3 up = {0, 0, 1};
static const sl_vec3 places[] = {
    {-0.5f, 0.1f, 0}, {0.1f, -1.3f, 0}, {1.0f, 0.7f, 0}, {2.2f, 1.5f, 0}, {-0.2f, 2.0f, 0}};

/* Within 4 errors of the estimate; and the estimate is a good one. */
static void check(const char *what, sl_vec3 at, double found, double variance, double expected,
                  double model) {
    double error = sqrt(variance);
    if (!(error < 0.2 * expected))
        fail_msg("%s at (%g, %g): %g +- %g is too noisy for a test", what, (double)at.x, (double)at.y, found,
                 error);
    if (!(fabs(found - expected) < 4.0 * error + model * expected)) {
        fail_msg("%s at (%g, %g): %g +- %g, expected %g", what, (double)at.x, (double)at.y, found, error,
                 expected);
    }
}

/* The image of the light behind the mirror shines. No bidirectional path finds that: to leave it out changes
 * nothing. */
static void plane_mirrors_show_a_point_lights_image(void **state) {
    shop s;
    shop_open(&s, floor_and_mirror(false, 0));
    sl_sample_renderer all = shop_renderer(&s, sl_bidirectional_renderer);
    s.settings.cache.caustics = true;
    sl_sample_renderer r = shop_renderer(&s, sl_caustic_renderer),
                       rest = shop_renderer(&s, sl_bidirectional_renderer);
    for (int i = 0; i < 5; i++) {
        sl_sample_request q = request_at(places[i], up);
        sl_vec3d d = sl_subd(sl_v3d(-3.5, 0.2, 2.0), sl_to_double(places[i]));
        double r2 = sl_dotd(d, d), e = 0.8 * d.z / (r2 * sqrt(r2));
        sl_sample sample = shop_sample(&s, &r, &q);
        check("point light", places[i], (double)sample.irradiance.r, (double)sample.variance, 10.0 * e, 0.02);
        assert_true(fabs((double)(sample.irradiance.b - 3.0f * sample.irradiance.r)) <
                    1e-4 * (double)sample.irradiance.b);
        sl_sample with = shop_sample(&s, &all, &q), without = shop_sample(&s, &rest, &q);
        assert_true(with.irradiance.g > 0.0f && same_sample(&with, &without));
    }
    r.destroy(r.state);
    all.destroy(all.state);
    rest.destroy(rest.state);
    shop_close(&s);
}

/* Photons and paths together carry what paths alone carry without photons, for mirrors and for polished
 * surfaces. */
static void nothing_is_counted_twice(void **state) {
    for (int polished = 0; polished < 2; polished++) {
        shop s;
        shop_open(&s, floor_and_mirror(true, polished ? 300.0f : 0.0f));
        s.settings.cache.indirect_samples = 10000;
        sl_sample_renderer all = shop_renderer(&s, sl_bidirectional_renderer);
        s.settings.cache.caustics = true;
        sl_sample_renderer rest = shop_renderer(&s, sl_bidirectional_renderer),
                           caustics = shop_renderer(&s, sl_caustic_renderer);
        for (int i = 0; i < 2; i++) {
            sl_sample_request q = request_at(places[i], up);
            sl_sample a = shop_sample(&s, &all, &q), b = shop_sample(&s, &rest, &q),
                      c = shop_sample(&s, &caustics, &q);
            check(polished ? "polished" : "mirror", places[i], (double)(b.irradiance.g + c.irradiance.g),
                  (double)(a.variance + b.variance + c.variance), (double)a.irradiance.g, 0.02);
            assert_true((double)c.irradiance.g > 0.3 * (double)a.irradiance.g); /* neither part is idle */
            assert_true((double)b.irradiance.g > 0.02 * (double)a.irradiance.g);
        }
        all.destroy(all.state);
        rest.destroy(rest.state);
        caustics.destroy(caustics.state);
        shop_close(&s);
    }
}

static void check_no_caustics(sl_scene *scene) {
    shop s;
    shop_open(&s, scene);
    sl_sample_renderer r = shop_renderer(&s, sl_caustic_renderer);
    sl_sample_request q = request_at(places[0], up);
    sl_sample sample = shop_sample(&s, &r, &q);
    assert_true(sample.valid && sample.irradiance.r == 0.0f && sample.variance == 0.0f);
    r.destroy(r.state);
    shop_close(&s);
}

/* Surfaces that are less than polished, and those with a diffuse part, are left to bidirectional paths. */
static void rough_surfaces_make_no_caustics(void **state) {
    sl_material m = {.specular = sl_grey(0.5f), .exponent = SL_POLISHED};
    assert_true(sl_is_specular(&m, SL_POLISHED));
    m.exponent = 0.99f * SL_POLISHED;
    assert_false(sl_is_specular(&m, SL_POLISHED));
    m.exponent = 1000.0f;
    m.diffuse = sl_grey(0.1f);
    assert_false(sl_is_specular(&m, SL_POLISHED));
    check_no_caustics(floor_and_mirror(true, 20.0f));
}

static void mirrors_that_no_light_reaches_make_no_caustics(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t floor = trace_mesh_diffuse(&mesh, 0.5f), mirror = trace_mesh_material(&mesh, 0, 0, 0, 0.8f, 0);
    trace_mesh_quad(&mesh, sl_v3(-4, -4, 0), sl_v3(8, 0, 0), sl_v3(0, 8, 0), floor);
    trace_mesh_quad(&mesh, sl_v3(-4, -4, -1), sl_v3(8, 0, 0), sl_v3(0, 8, 0), mirror);
    mesh.lights[mesh.light_count++] = (sl_light){.type = SL_LIGHT_SPOT,
                                                 .position = {0, 0, 2},
                                                 .direction = {0, 0, -1},
                                                 .intensity = sl_grey(1),
                                                 .cos_inner = 0.9f,
                                                 .cos_outer = 0.8f};
    check_no_caustics(trace_mesh_build(&mesh));
}

static void maps_are_the_same_bits_with_any_threads_and_follow_edits(void **state) {
    shop s;
    shop_open(&s, floor_and_mirror(false, 0));
    sl_sample before[5], after[5];
    sl_sample_request q[5];
    for (int i = 0; i < 5; i++) q[i] = request_at(places[i], up);
    for (unsigned threads = 1; threads <= 3; threads += 2) {
        s.settings.threads = threads;
        sl_sample_renderer r = shop_renderer(&s, sl_caustic_renderer);
        sl_render(&r, 5, q, threads, after, &s.counters);
        if (threads == 1) memcpy(before, after, sizeof before);
        for (int i = 0; i < 5; i++) assert_true(same_sample(&before[i], &after[i]));
        assert_int_equal(r.edit(r.state, NULL), SL_OK);
        sl_render(&r, 5, q, threads, after, &s.counters);
        for (int i = 0; i < 5; i++) assert_true(same_sample(&before[i], &after[i]));
        s.scene->lights[0].intensity = sl_grey(0.0f);
        assert_int_equal(r.edit(r.state, NULL), SL_OK);
        sl_render(&r, 5, q, threads, after, &s.counters);
        for (int i = 0; i < 5; i++) assert_true(after[i].valid && after[i].irradiance.g == 0.0f);
        s.scene->lights[0].intensity = (sl_rgb){10, 20, 30};
        r.destroy(r.state);
    }
    shop_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plane_mirrors_show_a_point_lights_image),
        cmocka_unit_test(nothing_is_counted_twice),
        cmocka_unit_test(rough_surfaces_make_no_caustics),
        cmocka_unit_test(mirrors_that_no_light_reaches_make_no_caustics),
        cmocka_unit_test(maps_are_the_same_bits_with_any_threads_and_follow_edits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
