/* The 160-degree gather of multi-mesh caching: its weights in closed form, what it sees, and what it makes of
 * hard input. */
#include "multi_mesh_gather_support.h"

static bool near(double a, double b, double tolerance) { return fabs(a - b) <= tolerance; }

static double half_angle(double degrees) { return 0.5 * degrees / 180.0 * SL_PI; }

/* The share of a hemisphere's irradiance that a square picture of half angle phi catches, C = 4/pi sin phi
 * atan(sin phi). */
static double coverage(double phi) { return 4.0 / SL_PI * sl_sin(phi) * sl_atan(sl_sin(phi)); }

/* ---- weights --------------------------------------------------------------------------------- */

static void the_share_lost_beyond_the_picture_is_the_papers_two_percent_and_a_half(void **state) {
    const double lost[6][2] = {{90, 0.4459},   {120, 0.2130},  {150, 0.0554},
                               {160, 0.02479}, {170, 0.00622}, {178, 0.00025}};
    for (int k = 0; k < 6; k++) assert_true(near(1.0 - coverage(half_angle(lost[k][0])), lost[k][1], 6e-5));
    assert_true(near(1.0 - coverage(half_angle(160)), 0.02479, 6e-6));
}

static double sum_of(const float *w, int count) {
    double sum = 0.0;
    for (int i = 0; i < count; i++) sum += (double)w[i];
    return sum;
}

static void halving_to_sixteen_and_adding_up_gives_the_sum_in_double(void **state) {
    enum { N = 128 };
    static float planes[3 * N * N], scratch[N * N / 2];
    double sum[3];
    sl_counters counters = {{0}};
    for (int i = 0; i < 3 * N * N; i++) planes[i] = (float)(((uint32_t)i * 2654435761u) >> 8) * 0x1p-24f;
    sl_raster_sum(planes, N, 3, scratch, sum, &counters);
    for (int c = 0; c < 3; c++)
        assert_true(fabs(sum[c] / sum_of(planes + c * N * N, N * N) - 1.0) < 2e-7);
}

/* ---- what it sees ---------------------------------------------------------------------------- */

/* Closed surfaces are rooms if there is light in them. */
static trace_mesh lit_mesh(void) {
    trace_mesh m = trace_mesh_begin();
    m.lights[m.light_count++] = (sl_light){.type = SL_LIGHT_POINT, .intensity = {1, 1, 1}};
    return m;
}

static sl_scene *box_scene(float diffuse) {
    trace_mesh m = lit_mesh();
    trace_mesh_box(&m, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, trace_mesh_diffuse(&m, diffuse));
    return trace_mesh_build(&m);
}

static void an_enclosure_of_one_radiance_gives_pi_times_it_whatever_the_point(void **state) {
    sl_gather_settings settings = usual_settings();
    gathering g = gathering_of(box_scene(0.5f), 0.3f, 3, &settings);
    set_all(&g, (sl_rgb){1.0f, 2.0f, 0.0f});
    for (uint32_t face = 0; face < 24; face += 2) {
        for (int k = 0; k < 4; k++) {
            const float w[4][2] = {{0.3f, 0.3f}, {0.5f, 0.5f}, {0, 0}, {1, 0}};
            sl_mesh_point p = face_point(g.scene, face, w[k][0], w[k][1]);
            sl_rgb e = take(&g, &p);
            assert_true(near((double)e.r, SL_PI * 0.5, 2e-5));
            assert_true(near((double)e.g, SL_PI, 4e-5));
            assert_true(e.b == 0.0f);
        }
    }
    gathering_destroy(&g);
}

/* A wall without end at distance 1, along the picture's columns, whose top is seen at elevation psi above the
 * horizon: form factor (1 - cos psi) / 2. */
static sl_scene *wall_of_elevation(double psi) {
    trace_mesh m = trace_mesh_begin();
    float far = psi < 1.57 ? 100.0f : 2000.0f, height = psi < 1.57 ? (float)sl_tan(psi) : far;
    sl_frame f = sl_known_colours_frame(sl_v3(0, 0, 1));
    trace_mesh_quad(&m, sl_mad(f.x, -far, f.y), sl_scale(f.y, 2.0f * far), sl_v3(0, 0, height),
                    trace_mesh_diffuse(&m, 1));
    return trace_mesh_build(&m);
}

static double wall_irradiance(double degrees) {
    sl_gather_settings settings = usual_settings();
    settings.size = 2048; /* an edge along pixels is half a pixel off: 3 % of this with 256 */
    gathering g = gathering_of(wall_of_elevation(degrees / 180.0 * SL_PI), 1e9f, 0, &settings);
    set_all(&g, sl_grey(1.0f));
    sl_mesh_point p = free_point(sl_v3(0, 0, 0), sl_v3(0, 0, 1));
    double e = (double)take(&g, &p).r;
    gathering_destroy(&g);
    return e / (SL_PI * 0.5 * (1.0 - sl_cos(degrees / 180.0 * SL_PI)));
}

static void walls_lose_the_part_that_stands_low(void **state) {
    assert_true(wall_irradiance(9) < 1e-6);
    assert_true(near(wall_irradiance(20), (1.0 - 0.317) / coverage(half_angle(160)), 0.02));
    assert_true(near(wall_irradiance(45), 1.0 - 0.054, 0.004));
    assert_true(near(wall_irradiance(60), 1.0 - 0.023, 0.004));
    assert_true(near(wall_irradiance(90), 1.0, 0.003));
}

/* From a floor towards a wall of limited height: as the point moves, the wall's edges cross the picture's
 * pixels one by one. */
static void edges_along_the_axes_make_no_bands(void **state) {
    trace_mesh m = lit_mesh();
    uint32_t grey = trace_mesh_diffuse(&m, 0.5f);
    trace_mesh_quad(&m, sl_v3(0, 0, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), grey);
    trace_mesh_quad(&m, sl_v3(0, 0, 0), sl_v3(0, 2, 0), sl_v3(0, 0, 1), grey);
    gathering g = even_gathering(&m, 1e3f, 0, 2.0f);
    double worst = 0.0, before = 0.0;
    for (int k = 0; k < 100; k++) {
        double c = 0.3 + 0.012 * k;
        sl_mesh_point p = {{sl_v3((float)c, 1, 0), sl_v3(0, 0, 1), sl_v3(0, 0, 1), 0}, SL_NO_INDEX};
        /* A perpendicular wall at distance c, 1 to either side and 1 high. The more of it is lost the lower
         * it stands. */
        double high = sqrt(1.0 + c * c), truth = sl_atan(1.0 / c) - c / high * sl_atan(1.0 / high),
               ratio = (double)take(&g, &p).r / truth;
        if (k && fabs(ratio / before - 1.0) > worst) worst = fabs(ratio / before - 1.0);
        before = ratio;
        assert_true(ratio > 0.85 && ratio < 1.01);
    }
    assert_true(worst < 0.012);
    gathering_destroy(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_share_lost_beyond_the_picture_is_the_papers_two_percent_and_a_half),
        cmocka_unit_test(halving_to_sixteen_and_adding_up_gives_the_sum_in_double),
        cmocka_unit_test(an_enclosure_of_one_radiance_gives_pi_times_it_whatever_the_point),
        cmocka_unit_test(edges_along_the_axes_make_no_bands),
        cmocka_unit_test(walls_lose_the_part_that_stands_low),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
