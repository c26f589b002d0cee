/* Direct and indirect light at points, as the shading cache's sample renderers compute it. */
#include "renderer_support.h"

/* ---- lamps above a floor --------------------------------------------------------------------- */

/* A square lamp, its centre `height` above that of a floor; the floor's triangles are 0 and 1. */
static trace_mesh lamp_over_gloss(float diffuse, float specular, float exponent, float side, float height,
                                  float radiance) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t floor = trace_mesh_material(&mesh, diffuse, specular, exponent, 0, 0),
             lamp = trace_mesh_lamp(&mesh, radiance);
    trace_mesh_quad(&mesh, sl_v3(-50, 0, -50), sl_v3(0, 0, 100), sl_v3(100, 0, 0), floor);
    trace_mesh_quad(&mesh, sl_v3(-side / 2, height, -side / 2), sl_v3(side, 0, 0), sl_v3(0, 0, side), lamp);
    return mesh;
}

static trace_mesh lamp_over_floor(float side, float height, float radiance) {
    return lamp_over_gloss(0.5f, 0, 0, side, height, radiance);
}

static const sl_vec3 up = {0.0f, 1.0f, 0.0f};

/* Irradiance on a plane below the corner of a parallel a x b rectangle of radiance 1 at distance 1. */
static double below_corner(double a, double b) {
    double x = sqrt(1.0 + a * a), y = sqrt(1.0 + b * b);
    return 0.5 * (a / x * sl_atan(b / x) + b / y * sl_atan(a / y));
}

/* At (x, z) on the floor, of a lamp of side 1 at this height: four rectangles, signed. */
static double square_irradiance(double x, double z, double height) {
    double e = 0.0;
    for (int i = 0; i < 4; i++) {
        double a = (i & 1 ? 0.5 - x : 0.5 + x) / height, b = (i & 2 ? 0.5 - z : 0.5 + z) / height;
        e += copysign(1.0, a) * copysign(1.0, b) * below_corner(fabs(a), fabs(b));
    }
    return e;
}

/* ---- shadows --------------------------------------------------------------------------------- */

/* Share of a square lamp's light, of side 1 at height 10, that reaches (x, 0, z) past a screen at height 5
 * which hides all with cos x + sin z > 0 there: by a fine grid on the lamp. */
static double share_past_edge(double x, double z, double cosine, double sine) {
    enum { GRID = 300 };
    double seen = 0.0, all = 0.0;
    for (int i = 0; i < GRID * GRID; i++) {
        double u = ((double)(i % GRID) + 0.5) / GRID - 0.5, v = ((double)(i / GRID) + 0.5) / GRID - 0.5;
        double squared = (u - x) * (u - x) + (v - z) * (v - z) + 100.0, weight = 1.0 / (squared * squared);
        all += weight;
        if (cosine * (u + x) / 2 + sine * (v + z) / 2 <= 0.0) seen += weight;
    }
    return seen / all;
}

/* A lamp of width s at height H, a screen's edge at height b: the penumbra on the floor is s b / (H - b)
 * wide. */
static void penumbras_have_their_width(void **state) {
    static const float edge_heights[] = {1.0f, 2.5f, 4.0f};
    for (int i = 0; i < 3; i++) {
        const float s0 = 0.8f, high = 5.0f, b = edge_heights[i];
        trace_mesh mesh = lamp_over_floor(s0, high, 1.0f);
        trace_mesh_quad(&mesh, sl_v3(0, b, -30), sl_v3(0, 0, 60), sl_v3(30, 0, 0), 0);
        shop s;
        shop_open(&s, trace_mesh_build(&mesh));
        s.settings.cache.area_samples = 1000;
        sl_sample_renderer r = shop_renderer(&s, sl_area_renderer);
        double expected = (double)(s0 * b / (high - b)), step = expected / 200.0, first = INFINITY,
               dark = INFINITY;
        /* the edge's shadow of the lamp's centre falls on x = 0 */
        for (int k = -300; k <= 300 && dark == INFINITY; k++) {
            double x = k * step, whole = square_irradiance(x / (double)s0, 0, (double)(high / s0));
            sl_sample_request q = request_at(sl_v3((float)x, 0, 0), up);
            double e = (double)shop_sample(&s, &r, &q).irradiance.r;
            if (e < 0.999 * whole) first = fmin(first, x);
            if (e < 0.001 * whole) dark = x;
        }
        double width = dark - first;
        printf("    edge at %g: %.4f wide, expected %.4f\n", (double)b, width, expected);
        assert_true(fabs(width - expected) < 0.02 * expected + 2.0 * step);
        r.destroy(r.state);
        shop_close(&s);
    }
}

/* All points see the lamp's same 64: its shadow's edge has as many steps. Dense points are asked for by
 * leaves of one pixel, and change nothing where there is no edge. */
static void dense_points_leave_a_sixth_of_the_bands_in_a_shadows_edge_and_all_else_as_it_was(void **state) {
    enum { POINTS = 240 };
    trace_mesh mesh = lamp_over_floor(0.8f, 5.0f, 1.0f);
    /* the edge is 0.8 wide */
    trace_mesh_quad(&mesh, sl_v3(0, 2.5f, -30), sl_v3(0, 0, 60), sl_v3(30, 0, 0), 0);
    shop s;
    shop_open(&s, trace_mesh_build(&mesh));
    s.settings.cache.area_samples = 20000;
    sl_sample_renderer exact = shop_renderer(&s, sl_area_renderer);
    s.settings.cache.area_samples = 64;
    sl_sample_renderer r = shop_renderer(&s, sl_area_renderer);
    double error[2] = {0.0, 0.0};
    int steps[2] = {0, 0}, same = 0;
    float last[2] = {-1.0f, -1.0f};
    for (int k = 0; k < POINTS; k++) {
        sl_sample_request q = request_at(sl_v3(-0.6f + 1.2f * (float)k / POINTS, 0, 0), up);
        double truth = (double)shop_sample(&s, &exact, &q).irradiance.r;
        float e[2];
        for (int dense = 0; dense < 2; dense++) {
            q.dense = dense;
            e[dense] = shop_sample(&s, &r, &q).irradiance.r;
            error[dense] += ((double)e[dense] - truth) * ((double)e[dense] - truth);
            steps[dense] += fabsf(e[dense] - last[dense]) > 1e-3f * e[dense];
            last[dense] = e[dense];
        }
        same += e[0] == e[1];
    }
    printf("    error %.3g, dense %.3g; steps %d, %d; %d of %d the same\n", sqrt(error[0] / POINTS),
           sqrt(error[1] / POINTS), steps[0], steps[1], same, POINTS);
    assert_true(error[1] < 0.1 * error[0] && steps[1] > steps[0]);
    assert_true(same >= POINTS / 4 && same < POINTS / 2); /* a third lies beside the edge */
    s.settings.cache.area = SL_AREA_SAMPLED;
    sl_sample_renderer sampled = shop_renderer(&s, sl_area_renderer);
    sl_sample_request q = request_at(sl_v3(0, 0, 0), up);
    double truth = (double)shop_sample(&s, &exact, &q).irradiance.r;
    q.dense = true;
    assert_true(fabs((double)shop_sample(&s, &sampled, &q).irradiance.r - truth) < 0.03 * truth);
    sampled.destroy(sampled.state);
    exact.destroy(exact.state);
    r.destroy(r.state);
    shop_close(&s);
}

/* Points are weighed alike where the lamp is far: of n of them that see it with chance p, E^2 p (1 - p) / (n
 * - 1). */
static void the_variance_told_is_that_of_points_which_see_the_lamp_or_not(void **state) {
    trace_mesh mesh = lamp_over_floor(0.4f, 10.0f, 3.0f);
    trace_mesh_quad(&mesh, sl_v3(0, 5, -30), sl_v3(0, 0, 60), sl_v3(30, 0, 0), 0);
    shop s;
    shop_open(&s, trace_mesh_build(&mesh));
    for (int sampled = 0; sampled < 2; sampled++) {
        s.settings.cache.area = sampled ? SL_AREA_SAMPLED : SL_AREA_RATIO;
        sl_sample_renderer r = shop_renderer(&s, sl_area_renderer);
        for (int k = -2; k <= 2; k++) {
            sl_sample_request q = request_at(sl_v3(0.05f * (float)k, 0, 0), up);
            sl_sample sample = shop_sample(&s, &r, &q);
            double whole = 3.0 * square_irradiance(0.125 * (double)k, 0.0, 25.0),
                   p = (double)sample.irradiance.r / whole, expected = whole * whole * p * (1.0 - p) / 63.0;
            assert_true(p > 0.1 && p < 0.9);
            if (!(fabs((double)sample.variance - expected) < 0.02 * expected))
                fail_msg("%g, expected %g", (double)sample.variance, expected);
        }
        r.destroy(r.state);
    }
    shop_close(&s);
}

/* ---- lobes ----------------------------------------------------------------------------------- */

/* Phong lobe of a square lamp at height 2, by a fine grid. */
static void lobes_reflect_a_lamps_points(void **state) {
    trace_mesh mesh = lamp_over_gloss(0.2f, 0.6f, 12, 1.0f, 2.0f, 5.0f);
    shop s;
    shop_open(&s, trace_mesh_build(&mesh));
    s.settings.cache.area_samples = 1000;
    for (int mode = 0; mode < 2; mode++) {
        s.settings.cache.area = mode ? SL_AREA_SAMPLED : SL_AREA_RATIO;
        sl_sample_renderer r = shop_renderer(&s, sl_area_renderer);
        sl_sample_request q = request_on(s.scene, 0, 0.3f, 0.3f, true);
        q.point.position = sl_v3(-0.5f, 0, -0.2f);
        q.radiance = true;
        q.eye = sl_v3(2, 3, 0.5f);
        sl_vec3d p = sl_to_double(q.point.position), v = sl_subd(sl_to_double(q.eye), p),
                 m = sl_scaled(sl_v3d(-v.x, v.y, -v.z), 1.0 / sl_lengthd(v));
        double expected = 0.0;
        for (int i = 0; i < 300 * 300; i++) {
            sl_vec3d d = sl_subd(
                sl_v3d(((double)(i % 300) + 0.5) / 300.0 - 0.5, 2.0, ((double)(i / 300) + 0.5) / 300.0 - 0.5),
                p);
            double r2 = sl_dotd(d, d), alpha = fmax(0, sl_dotd(d, m) / sqrt(r2));
            expected +=
                5.0 * 0.6 * 14.0 / (2 * SL_PI) * sl_pow(alpha, 12.0) * d.y * d.y / (r2 * r2) / 90000.0;
        }
        double found = (double)shop_sample(&s, &r, &q).radiance.r;
        if (!(fabs(found - expected) < 0.01 * expected)) fail_msg("%g, expected %g", found, expected);
        q.eye = sl_v3(2, -3, 0.5f); /* from below nothing is seen of it */
        assert_true(shop_sample(&s, &r, &q).radiance.r == 0.0f);
        r.destroy(r.state);
    }
    shop_close(&s);
}

/* A lobe that is narrower than the distance between the lamp's points shows the lamp: ks L (n + 2) / (n + 1)
 * cos. */
static void narrow_lobes_show_the_lamp(void **state) {
    trace_mesh mesh = lamp_over_gloss(0.0f, 0.6f, 20000, 1.0f, 2.0f, 5.0f);
    shop s;
    shop_open(&s, trace_mesh_build(&mesh));
    sl_sample_renderer r = shop_renderer(&s, sl_area_renderer);
    for (int i = 0; i < 20; i++) {
        float x = 0.02f * (float)i;
        sl_sample_request q = request_on(s.scene, 0, 0.3f, 0.3f, true);
        q.point.position = sl_v3(1.0f, 0, 0.1f);
        q.radiance = true;
        q.eye = sl_v3(2.0f - x, 2.0f, 0.1f + x); /* mirrored: at (x, 2, 0.1 - x) of the lamp */
        double found = (double)shop_sample(&s, &r, &q).radiance.g,
               cosine = 2.0 / sl_lengthd(sl_v3d(1.0 - (double)x, 2.0, (double)x));
        if (!(fabs(found - 3.0 * cosine) < 0.04 * 3.0))
            fail_msg("at %g: %g, expected %g", (double)x, found, 3.0 * cosine);
        q.eye = sl_v3(2.6f, 2.0f, 0.1f); /* beside it */
        assert_true(shop_sample(&s, &r, &q).radiance.g < 1e-3f);
    }
    r.destroy(r.state);
    shop_close(&s);
}

/* ---- the environment ------------------------------------------------------------------------- */

/* It is counted by one renderer: that of indirect light, or, without one, that of direct light. */
static void the_sky_is_counted_once(void **state) {
    sl_environment sky = {.present = true, .constant = {1.0f, 2.0f, 0.5f}};
    trace_mesh mesh = trace_mesh_begin();
    uint32_t black = trace_mesh_material(&mesh, 0.0f, 0.4f, 30, 0, 0),
             dark = trace_mesh_diffuse(&mesh, 1e-6f);
    trace_mesh_quad(&mesh, sl_v3(-50, 0, -50), sl_v3(0, 0, 100), sl_v3(100, 0, 0), black);
    /* hides half of it */
    trace_mesh_quad(&mesh, sl_v3(0, 0, -5000), sl_v3(0, 0, 10000), sl_v3(0, 5000, 0), dark);
    mesh.environment = &sky;
    shop s;
    shop_open(&s, trace_mesh_build(&mesh));
    for (int i = 0; i < 2; i++) {
        s.settings.cache.indirect = i ? SL_INDIRECT_NONE : SL_INDIRECT_BIDIRECTIONAL;
        s.settings.cache.area_samples = 400;
        sl_sample_renderer direct = shop_renderer(&s, sl_area_renderer),
                           indirect = shop_renderer(&s, sl_bidirectional_renderer);
        sl_sample_request q = request_at(sl_v3(1e-3f, 0, 0), up);
        sl_rgb d = shop_sample(&s, &direct, &q).irradiance, b = shop_sample(&s, &indirect, &q).irradiance,
               counted = i ? d : b;
        if (!i) assert_true(d.r == 0.0f && d.g == 0.0f);
        assert_true(fabs((double)counted.g - SL_PI) < 0.03 * SL_PI);
        assert_true(fabs((double)counted.r - 0.5 * SL_PI) < 0.015 * SL_PI);
        q = request_on(s.scene, 0, 0.5f, 0.9f * 0.5f, true); /* the eye is above it */
        q.point.position = sl_v3(30, 0, 0);
        q.radiance = true;
        q.eye = sl_v3(30, 20, 0);
        d = shop_sample(&s, &direct, &q).radiance;
        b = shop_sample(&s, &indirect, &q).radiance;
        counted = i ? d : b;
        if (!i) assert_true(d.r == 0.0f);
        assert_true(fabs((double)counted.g - 0.4) < 0.02); /* half of ks L: the lobe is scaled to that */
        direct.destroy(direct.state);
        indirect.destroy(indirect.state);
    }
    shop_close(&s);
}

/* ---- indirect light -------------------------------------------------------------------------- */

static void check_within_errors(const char *what, double found, double variance, double expected,
                                double model) {
    double error = sqrt(variance);
    if (!(error < 0.1 * expected)) fail_msg("%s: %g +- %g is too noisy for a test", what, found, error);
    if (!(fabs(found - expected) < 3.0 * error + model * expected))
        fail_msg("%s: %g +- %g, expected %g", what, found, error, expected);
}

/* Emission L and albedo rho all around: pi L of direct light, and rho pi L (1 + rho + ...) of up to six
 * further bounces. */
static void furnaces_are_evenly_lit(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t wall = trace_mesh_material(&mesh, 0.6f, 0, 0, 0, 2.0f);
    trace_mesh_box(&mesh, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, wall);
    shop s;
    shop_open(&s, trace_mesh_build(&mesh));
    sl_sample_renderer direct = shop_renderer(&s, sl_area_renderer),
                       indirect = shop_renderer(&s, sl_bidirectional_renderer);
    for (uint32_t t = 0; t < s.scene->triangle_count; t++) {
        sl_sample_request q = request_on(s.scene, t, 0.25f, 0.35f, true);
        sl_sample d = shop_sample(&s, &direct, &q), i = shop_sample(&s, &indirect, &q);
        assert_true(d.valid && i.valid);
        assert_true(fabs((double)d.irradiance.r - 2.0 * SL_PI) < 1e-3);
        check_within_errors("furnace", (double)i.irradiance.r, (double)i.variance,
                            2.0 * SL_PI * 0.6 * (1.0 - sl_pow(0.6, 6)) / 0.4, 1e-3);
    }
    direct.destroy(direct.state);
    indirect.destroy(indirect.state);
    shop_close(&s);
}

/* ---- batches --------------------------------------------------------------------------------- */

static bool same_sample(const sl_sample *a, const sl_sample *b) {
    return memcmp(&a->irradiance, &b->irradiance, sizeof a->irradiance) == 0 &&
           memcmp(&a->radiance, &b->radiance, sizeof a->radiance) == 0 &&
           memcmp(&a->variance, &b->variance, sizeof a->variance) == 0 && a->valid == b->valid;
}

static void answers_depend_on_their_request_alone(void **state) {
    enum { COUNT = 60 };
    static make_renderer *const makers[] = {sl_area_renderer, sl_bidirectional_renderer};
    shop s;
    shop_open(&s, load_scene("scenes/cornell-glossy.json"));
    s.settings.cache.indirect_samples = 100;
    s.settings.threads = 7;
    sl_sample_request q[COUNT];
    for (uint32_t i = 0; i < COUNT; i++) {
        q[i] = request_on(s.scene, i * 7 % (uint32_t)s.scene->triangle_count, 0.01f * (float)i, 0.3f,
                          i % 5 != 0);
        q[i].radiance = i % 2;
        q[i].eye = s.scene->camera.eye;
        q[i].set = i % 3;
    }
    for (int m = 0; m < 2; m++) {
        sl_sample_renderer r = shop_renderer(&s, makers[m]), other = shop_renderer(&s, makers[m]);
        sl_sample all[COUNT], parts[COUNT];
        sl_counters once = {{0}}, split = {{0}};
        sl_render(&r, COUNT, q, 1, all, &once);
        for (size_t i = COUNT; i-- > 0;) sl_render(&other, 1, &q[i], 1, &parts[i], &split);
        for (int i = 0; i < COUNT; i++) assert_true(same_sample(&all[i], &parts[i]));
        assert_memory_equal(&once, &split, sizeof once);
        for (unsigned threads = 2; threads <= 7; threads += 5) {
            sl_counters threaded = {{0}};
            sl_render(&r, COUNT, q, threads, parts, &threaded);
            for (int i = 0; i < COUNT; i++) assert_true(same_sample(&all[i], &parts[i]));
            assert_memory_equal(&once, &threaded, sizeof once);
        }
        /* After an edit that changes nothing all is as it was. */
        assert_int_equal(r.edit(r.state, NULL), SL_OK);
        sl_render(&r, COUNT, q, 1, parts, &split);
        for (int i = 0; i < COUNT; i++) assert_true(same_sample(&all[i], &parts[i]));
        r.destroy(r.state);
        other.destroy(other.state);
    }
    shop_close(&s);
}

/* Other sets, other points: their mean over sixteen is nearer the truth than one. */
static void sets_of_samples_average(void **state) {
    trace_mesh mesh = lamp_over_floor(1.0f, 10.0f, 1.0f);
    trace_mesh_quad(&mesh, sl_v3(0, 5, -30), sl_v3(0, 0, 60), sl_v3(30, 0, 0), 0);
    shop s;
    shop_open(&s, trace_mesh_build(&mesh));
    sl_sample_renderer r = shop_renderer(&s, sl_area_renderer);
    double alone = 0.0, together = 0.0;
    for (int k = 0; k < 20; k++) {
        sl_sample_request q = request_at(sl_v3(0.06f * (float)k - 0.6f, 0, 0.1f), up);
        double x = (double)q.point.position.x,
               exact =
                   share_past_edge(x, (double)q.point.position.z, 1.0, 0.0) * square_irradiance(x, 0.1, 10.0),
               mean = 0.0;
        for (q.set = 0; q.set < 16; q.set++) {
            double off = (double)shop_sample(&s, &r, &q).irradiance.r - exact;
            alone += off * off / 16.0;
            mean += off / 16.0;
        }
        together += mean * mean;
    }
    printf("    %.2g of one set's error is left\n", sqrt(together / alone));
    assert_true(together < 0.25 * 0.25 * alone);
    r.destroy(r.state);
    shop_close(&s);
    shop_open(&s, load_scene("scenes/cornell.json"));
    s.settings.cache.indirect_samples = 100;
    r = shop_renderer(&s, sl_bidirectional_renderer);
    sl_sample_request q = request_on(s.scene, 0, 0.6f, 0.05f, true);
    sl_sample first = shop_sample(&s, &r, &q);
    q.set = 1;
    sl_sample second = shop_sample(&s, &r, &q);
    assert_false(same_sample(&first, &second));
    assert_true(fabs((double)(second.irradiance.r - first.irradiance.r)) <
                4.0 * sqrt((double)(first.variance + second.variance)));
    r.destroy(r.state);
    shop_close(&s);
}

static void points_that_are_not_finite_are_broken_and_leave_the_batch_alone(void **state) {
    sl_sample_renderer r = constant_renderer((sl_rgb){1, 2, 3});
    sl_sample_request q[3] = {request_at(sl_v3(0, 0, 0), up), request_at(sl_v3(5, 0, 0), up),
                              request_at(sl_v3(NAN, 0, 0), up)};
    sl_sample samples[3];
    sl_counters counters = {{0}};
    sl_render(&r, 3, q, 2, samples, &counters);
    for (int i = 0; i < 2; i++)
        assert_true(samples[i].valid && samples[i].irradiance.r == 1 && samples[i].irradiance.g == 2 &&
                    samples[i].irradiance.b == 3);
    assert_false(samples[2].valid);
    assert_int_equal(counters.value[SL_COUNT_NONFINITE], 1);
    r.destroy(r.state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(penumbras_have_their_width),
        cmocka_unit_test(dense_points_leave_a_sixth_of_the_bands_in_a_shadows_edge_and_all_else_as_it_was),
        cmocka_unit_test(the_variance_told_is_that_of_points_which_see_the_lamp_or_not),
        cmocka_unit_test(lobes_reflect_a_lamps_points),
        cmocka_unit_test(narrow_lobes_show_the_lamp),
        cmocka_unit_test(the_sky_is_counted_once),
        cmocka_unit_test(furnaces_are_evenly_lit),
        cmocka_unit_test(answers_depend_on_their_request_alone),
        cmocka_unit_test(sets_of_samples_average),
        cmocka_unit_test(points_that_are_not_finite_are_broken_and_leave_the_batch_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
