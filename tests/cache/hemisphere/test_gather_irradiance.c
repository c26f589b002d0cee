/* Results of gathers against closed forms: furnaces, polygon lights, mean distances, the integrating sphere.
 */
#include "unit_test.h"
#include "base/math.h"
#include "gather_world.h"
#include "polygon_truth.h"

/* A closed black box whose walls shine with radiance 1. */
static void furnace_gives_pi(void **state) {
    world *w = world_new();
    uint32_t m = world_material(w, sl_grey(0), sl_grey(1));
    world_box(w, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true, (uint32_t[6]){m, m, m, m, m, m});
    world_build(w);
    sl_vec3 n = sl_normalize_or(sl_v3(0.3f, -0.5f, 0.7f), sl_v3(0, 0, 1));
    for (int k = 0; k < 4; k++) {
        sl_gather_settings s = gather_settings(k < 3 ? gather_kinds[k] : SL_GATHER_PLANE, 64);
        s.border = k < 3 ? SL_BORDER_RADIAL : SL_BORDER_LC04;
        sl_irradiance e = gather_once(w, &s, sl_v3(0.2f, 0.1f, -0.3f), n);
        assert_within((double)e.value.r, SL_PI, 3e-6);
        assert_within((double)e.value.g, SL_PI, 3e-6);
        assert_within((double)e.value.b, SL_PI, 3e-6);
        for (int c = 0; c < 3; c++) {
            assert_within((double)sl_length(e.rotational[c]), 0, 1e-5);
            assert_within((double)sl_length(e.translational[c]), 0, 1e-6);
        }
        assert_within((double)e.back_share, 0, 0);
    }
    world_free(w);
}

/* Relative rms error, against Lambert's formula, over positions under the first quad of test_gather_tables.c.
 */
static double polygon_rms(world *w, const sl_gather_settings *s) {
    sl_vec3d light[4] = {{-0.7, -0.4, 1.3}, {-0.7, 0.9, 1.3}, {1.1, 0.9, 1.3}, {1.1, -0.4, 1.3}};
    gatherer g = gatherer_new(w, s);
    double sum = 0;
    enum { COUNT = 100 };
    for (int i = 0; i < COUNT; i++) {
        sl_vec3 p =
            sl_v3(-1.0f + 0.213f * (float)(i % 10), -1.0f + 0.219f * (float)(i / 10), 0.01f * (float)(i % 7));
        double exact = 5 * polygon_irradiance(sl_to_double(p), sl_v3d(0, 0, 1), light, 4, NULL);
        double error = (double)gather_at(&g, p, sl_v3(0, 0, 1), (uint64_t)i).value.g / exact - 1;
        sum += error * error;
    }
    gatherer_free(&g);
    return sqrt(sum / COUNT);
}

static void polygon_light_converges_to_its_closed_form(void **state) {
    world *w = world_new();
    world_quad(w, sl_v3(-0.7f, -0.4f, 1.3f), sl_v3(-0.7f, 0.9f, 1.3f), sl_v3(1.1f, 0.9f, 1.3f),
               sl_v3(1.1f, -0.4f, 1.3f), world_material(w, sl_grey(0), sl_grey(5)));
    world_build(w);
    const double bounds[3] = {0.07, 0.03, 0.01}; /* at 64; the plane's pixels are the largest */
    for (int k = 0; k < 3; k++) {
        double rms[3];
        for (int i = 0; i < 3; i++) {
            sl_gather_settings s = gather_settings(gather_kinds[k], 32 << i);
            rms[i] = polygon_rms(w, &s);
        }
        print_message("rms at 32, 64, 128: %.4f %.4f %.4f\n", rms[0], rms[1], rms[2]);
        assert_true(rms[1] <= bounds[k]);
        assert_true(rms[1] < 0.8 * rms[0] && rms[2] < 0.35 * rms[0]); /* about halving */
    }
    world_free(w);
}

static void mean_distance_is_cosine_weighted(void **state) {
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = gather_settings(gather_kinds[k], 128);
        world *ceiling = world_new(), *wall = world_new(), *sphere = world_new();
        uint32_t m = world_material(ceiling, sl_grey(0.5f), sl_grey(0));
        world_quad(ceiling, sl_v3(-400, -400, 2), sl_v3(-400, 400, 2), sl_v3(400, 400, 2),
                   sl_v3(400, -400, 2), m);
        world_build(ceiling);
        sl_irradiance e = gather_once(ceiling, &s, sl_v3(0, 0, 0), sl_v3(0, 0, 1));
        assert_within((double)e.harmonic_mean, 1.5 * 2, 0.08);
        assert_within((double)e.nearest, 2, 0.02);

        m = world_material(wall, sl_grey(0.5f), sl_grey(0));
        world_quad(wall, sl_v3(2, -800, -800), sl_v3(2, -800, 800), sl_v3(2, 800, 800), sl_v3(2, 800, -800),
                   m);
        world_build(wall);
        e = gather_once(wall, &s, sl_v3(0, 0, 0), sl_v3(0, 0, 1));
        assert_within((double)e.harmonic_mean, 1.5 * SL_PI * 2, gather_kinds[k] == SL_GATHER_PLANE ? 0.9 : 0.25);
        double tangent = sl_tan(0.5 * (double)s.plane_fov),
               sine2 = tangent * tangent / (1 + tangent * tangent);
        assert_within((double)e.nearest, gather_kinds[k] == SL_GATHER_PLANE ? 2 / sine2 : 2, 0.06);

        m = world_material(sphere, sl_grey(0.5f), sl_grey(0));
        world_sphere(sphere, 1, 64, &m, 1);
        world_build(sphere);
        e = gather_once(sphere, &s, sl_v3(0.0f, 0.02f, -0.998f), sl_v3(0, 0, 1));
        /* the plane takes the rim for the horizon */
        assert_within((double)e.harmonic_mean, 1, gather_kinds[k] == SL_GATHER_PLANE ? 0.25 : 0.08);
        /* from the centre everything is a radius away */
        e = gather_once(sphere, &s, sl_v3(0, 0, 0), sl_v3(0, 0.6f, 0.8f));
        assert_within((double)e.harmonic_mean, 1, 0.01);
        assert_within((double)e.nearest, 1, 0.01);
        world_free(ceiling), world_free(wall), world_free(sphere);
    }
}

static void empty_sky_is_infinitely_far(void **state) {
    world *w = world_new();
    world_quad(w, sl_v3(-9, -9, -1), sl_v3(9, -9, -1), sl_v3(9, 9, -1), sl_v3(-9, 9, -1),
               world_material(w, sl_grey(0.5f), sl_grey(0)));
    w->environment = (sl_environment){.present = true, .constant = sl_grey(2)};
    world_build(w);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = gather_settings(gather_kinds[k], 32);
        sl_irradiance e = gather_once(w, &s, sl_v3(0, 0, 0), sl_v3(0, 0, 1));
        assert_within((double)e.value.r, 2 * SL_PI, 1e-5);
        assert_true(isinf(e.harmonic_mean) && isinf(e.nearest));
        assert_within((double)sl_length(e.translational[0]), 0, 0);
        s.emission = false; /* the direct pass samples the sky: black here */
        assert_within((double)gather_once(w, &s, sl_v3(0, 0, 0), sl_v3(0, 0, 1)).value.r, 0, 0);
        /* the ground, lit by the sky: L = 0.5 / pi * 2 pi */
        e = gather_once(w, &s, sl_v3(0, 0, 0), sl_v3(0, 0, -1));
        assert_within((double)e.back_share, 0, 0);
        assert_within((double)e.value.r, 0.5 * 2 * SL_PI, 0.1);
        e = gather_once(w, &s, sl_v3(0, 0, -2), sl_v3(0, 0, 1)); /* and its underside, lit by the sky below */
        assert_within((double)e.back_share, 1, 0.03);
        assert_within((double)e.value.r, 0.5 * 2 * SL_PI, 0.1);
    }
    world_free(w);
}

/* A lamp a hand's breadth above a table: points of the lamp sampled by area would make the hits under it
 * outshine the rest a thousandfold; by solid angle none exceeds four times the radiance that the table has in
 * closed form under the lamp's centre. */
static void lamp_close_to_a_surface_makes_no_outliers(void **state) {
    world *w = world_new();
    uint32_t table = world_material(w, sl_grey(0.5f), sl_grey(0)),
             lamp = world_material(w, sl_grey(0), sl_grey(7));
    world_quad(w, sl_v3(-1, 0, 1), sl_v3(1, 0, 1), sl_v3(1, 0, -1), sl_v3(-1, 0, -1), table);
    world_quad(w, sl_v3(-0.2f, 0.02f, -0.2f), sl_v3(0.2f, 0.02f, -0.2f), sl_v3(0.2f, 0.02f, 0.2f),
               sl_v3(-0.2f, 0.02f, 0.2f), lamp);
    world_build(w);
    sl_vec3d corners[4] = {{-0.2, 0.02, -0.2}, {0.2, 0.02, -0.2}, {0.2, 0.02, 0.2}, {-0.2, 0.02, 0.2}};
    sl_gather_settings s = gather_settings(SL_GATHER_RAYS, 64);
    s.emission = false;
    s.jitter = false;
    gatherer g = gatherer_new(w, &s);
    /* close above the table, below the lamp's height */
    gather_at(&g, sl_v3(0.6f, 0.01f, 0), sl_v3(0, -1, 0), 3);
    sl_gather_picture p = sl_gather_last_picture(g.scratch);
    double brightest = 0;
    for (int i = 0; i < p.width * p.height; i++) brightest = fmax(brightest, (double)p.r[i]);
    /* a sample stands for a hemisphere of the lamp at most */
    assert_true(brightest > 0 && brightest <= 2 * 7.0 * 0.5 * 1.0001);
    sl_gather_settings up = s;
    gatherer h = gatherer_new(w, &up);
    /* along the gap: every hit is lit from close by */
    gather_at(&h, sl_v3(0.201f, 0.0199f, 0), sl_v3(-1, 0, 0), 3);
    p = sl_gather_last_picture(h.scratch);
    brightest = 0;
    for (int i = 0; i < p.width * p.height; i++) brightest = fmax(brightest, (double)p.r[i]);
    double centre = 0.5 * 7 / SL_PI * polygon_irradiance(sl_v3d(0, 0, 0), sl_v3d(0, 1, 0), corners, 4, NULL);
    /* A hit of less light than most gets fewer samples than one, and each stands for more. */
    assert_true(brightest > centre && brightest <= 4 * centre);
    gatherer_free(&g), gatherer_free(&h);
    world_free(w);
}

static void shadow_maps_and_rays_light_alike(void **state) {
    for (int quad = 0; quad < 2; quad++) {
        world *w = world_room(quad);
        if (!quad)
            w->scene->lights[0] = (sl_light){.type = SL_LIGHT_SPOT,
                                             .position = {2.1f, 2.6f, 2.9f},
                                             .direction = {0, -1, 0},
                                             .intensity = sl_grey(10),
                                             .cos_inner = 0.7f,
                                             .cos_outer = 0.3f};
        sl_gather_settings rays = gather_settings(SL_GATHER_RAYS, 64), maps = rays;
        rays.emission = maps.emission = false;
        sl_shadow_maps *made;
        const sl_shadow_map_settings of = {.size = SL_SHADOW_MAP_SIZE, .threads = 1};
        assert_int_equal(sl_shadow_maps_create(w->scene, w->raster, &of, &made, &w->counters, NULL), SL_OK);
        maps.maps = made;
        gatherer a = gatherer_new(w, &rays), b = gatherer_new(w, &maps);
        double sum = 0;
        for (uint64_t i = 0; i < 24; i++) {
            sl_gather_point p = world_surface_point(w, i);
            sl_irradiance x, y;
            sl_gather_irradiance(a.gather, &p, a.scratch, &x, a.counters);
            sl_gather_irradiance(b.gather, &p, b.scratch, &y, b.counters);
            /* in gaps narrower than a texel, a little light */
            double error = (double)(y.value.g - x.value.g) / (double)(x.value.g + y.value.g + 0.02f) * 2;
            sum += error * error;
        }
        print_message("maps against rays, rms: %.4f\n", sqrt(sum / 24));
        assert_true(sqrt(sum / 24) < 0.05);
        assert_true(w->counters.value[SL_COUNT_SHADOW_LOOKUPS] > 1000);
        gatherer_free(&a), gatherer_free(&b);
        sl_shadow_maps_destroy(made);
        world_free(w);
    }
}

/* Shading normals tilt gathers below the surface: what they meet there in their own plane is not seen. */
static void tilted_normal_does_not_see_its_own_surface(void **state) {
    world *w = world_new();
    uint32_t m = world_material(w, sl_grey(0.5f), sl_grey(4));
    for (int i = -5; i < 5; i++) { /* a shining floor of many triangles */
        float x = (float)i;
        world_quad(w, sl_v3(x, 0, 5), sl_v3(x + 1, 0, 5), sl_v3(x + 1, 0, -5), sl_v3(x, 0, -5), m);
    }
    world_build(w);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = gather_settings(gather_kinds[k], 64);
        gatherer g = gatherer_new(w, &s);
        sl_gather_point p = {.position = {0.3f, 0, 0.2f},
                             .geometric_normal = {0, 1, 0},
                             .normal = {0.8f, 0.6f, 0},
                             .triangle = SL_NO_INDEX,
                             .key = 5};
        sl_irradiance e;
        sl_gather_irradiance(g.gather, &p, g.scratch, &e, g.counters);
        assert_within((double)e.value.r, 0, 0);
        assert_true(isinf(e.harmonic_mean) && isinf(e.nearest));
        gatherer_free(&g);
    }
    world_free(w);
}

/* A furnace with a black card over the point. The eye stands eps off the surface; what lies before it is
 * seen, however near. */
static void a_card_before_the_eye_is_seen_however_near(void **state) {
    const float over[] = {0.02f, 1.0f, 4.0f}; /* the eye, in eps */
    for (int i = 0; i < 3; i++) {
        world *w = world_new();
        uint32_t wall = world_material(w, sl_grey(0), sl_grey(1)),
                 black = world_material(w, sl_grey(0), sl_grey(0));
        world_box(w, sl_v3(-1, -1, -1), sl_v3(1, 1, 1), true,
                  (uint32_t[6]){wall, wall, wall, wall, wall, wall});
        float eps = 1e-5f * sqrtf(12.0f), half = over[i] * eps, z = eps + half;
        world_quad(w, sl_v3(-half, -half, z), sl_v3(-half, half, z), sl_v3(half, half, z),
                   sl_v3(half, -half, z), black);
        world_build(w);
        for (int k = 0; k < 3; k++) {
            sl_gather_settings s = gather_settings(gather_kinds[k], 64);
            sl_irradiance e = gather_once(w, &s, sl_v3(0, 0, 0), sl_v3(0, 0, 1));
            assert_true((double)e.value.r < 0.6 * SL_PI && e.nearest < 5 * eps);
        }
        world_free(w);
    }
}

/* A sheet without thickness stands on the floor, between the light and a point that is nearer to it than its
 * eye is to the floor. */
static void no_light_reaches_a_point_that_touches_a_sheet_from_behind(void **state) {
    const float distance[] = {1e-6f, 1e-5f, 4e-5f};
    world *w = world_new();
    uint32_t wall = world_material(w, sl_grey(0.7f), sl_grey(0));
    world_box(w, sl_v3(-1, 0, -1), sl_v3(1, 2, 1), true, (uint32_t[6]){wall, wall, wall, wall, wall, wall});
    world_quad(w, sl_v3(0, 0, 1), sl_v3(0, 0, -1), sl_v3(0, 2, -1), sl_v3(0, 2, 1), wall);
    world_point_light(w, sl_v3(-0.5f, 1.0f, 0.1f), 1.0f);
    world_build(w);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++) {
            sl_gather_settings s = gather_settings(gather_kinds[k], 32);
            float e = gather_once(w, &s, sl_v3(distance[i], 0, 0.1f), sl_v3(0, 1, 0)).value.r;
            if (!(e == 0.0f))
                fail_msg("%s, %g behind the sheet: %g",
                         k == 0   ? "plane"
                         : k == 1 ? "hemicube"
                                  : "rays",
                         (double)distance[i], (double)e);
        }
    }
    world_free(w);
}

static void hostile_points_give_finite_answers(void **state) {
    world *w = world_room(true);
    const sl_vec3 normals[] = {{0, 0, 0}, {NAN, 0, 0}, {0, 0, -1}, {INFINITY, 0, 1}, {1e-30f, 0, 0}};
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = gather_settings(gather_kinds[k], 16);
        gatherer g = gatherer_new(w, &s);
        for (size_t i = 0; i < sizeof normals / sizeof *normals; i++) {
            sl_gather_point p = {.position = {2, 1.5f, 3},
                                 .geometric_normal = {0, 1, 0},
                                 .normal = normals[i],
                                 .triangle = SL_NO_INDEX};
            sl_irradiance e;
            sl_gather_irradiance(g.gather, &p, g.scratch, &e, g.counters);
            assert_true(sl_rgb_is_finite(e.value) && e.value.g >= 0);
            for (int c = 0; c < 3; c++)
                assert_true(sl_is_finite(e.rotational[c]) && sl_is_finite(e.translational[c]));
            assert_true(e.harmonic_mean > 0 && e.nearest > 0);
        }
        gatherer_free(&g);
    }
    world_free(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(furnace_gives_pi),
        cmocka_unit_test(polygon_light_converges_to_its_closed_form),
        cmocka_unit_test(mean_distance_is_cosine_weighted),
        cmocka_unit_test(empty_sky_is_infinitely_far),
        cmocka_unit_test(lamp_close_to_a_surface_makes_no_outliers),
        cmocka_unit_test(shadow_maps_and_rays_light_alike),
        cmocka_unit_test(tilted_normal_does_not_see_its_own_surface),
        cmocka_unit_test(a_card_before_the_eye_is_seen_however_near),
        cmocka_unit_test(no_light_reaches_a_point_that_touches_a_sheet_from_behind),
        cmocka_unit_test(hostile_points_give_finite_answers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
