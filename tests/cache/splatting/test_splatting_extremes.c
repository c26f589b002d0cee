/* Radiance cache splatting at the ends of its ranges: materials, light, scale, settings, films. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "matched.h"
#include "rendering.h"
#include "scene/scene.h"

static const double pi = 3.14159265358979323846;

/* ---- glossy lobes under an even sky: what comes out is the lobe's albedo --------------------- */

/* The share that a lobe sends towards theta_o: the integral of (n + 2) / (2 pi) cos^n alpha cos theta over
 * the hemisphere, by its own distribution about the mirror direction. */
static double lobe_albedo(double exponent, double cosine) {
    enum { STEPS = 400 };
    double sine = sqrt(1.0 - cosine * cosine), sum = 0.0;
    for (int i = 0; i < STEPS; i++) {
        double c = pow((i + 0.5) / STEPS, 1.0 / (exponent + 1.0)), s = sqrt(1.0 - c * c);
        for (int j = 0; j < STEPS; j++)
            sum += fmax(0.0, c * cosine + s * sine * cos(2.0 * pi * (j + 0.5) / STEPS));
    }
    return sum / (STEPS * STEPS) * (exponent + 2.0) / (exponent + 1.0);
}

static const char plain_obj[] = "v -50 0 -50\nv -50 0 50\nv 50 0 50\nv 50 0 -50\nf 1 2 3 4\n";

static double glossy_plain(double exponent, double elevation, sl_gather_kind gather) {
    char json[1024];
    double angle = elevation * pi / 180.0;
    snprintf(json, sizeof json,
             "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"m\"}],\n"
             " \"materials\": {\"m\": {\"diffuse\": 0, \"specular\": 1, \"exponent\": %g}}, \"environment\": "
             "{\"radiance\": 1},\n"
             " \"camera\": {\"eye\": [0, %.9g, %.9g], \"target\": [0, 0, 0], \"up\": [0, 1, -0.1], "
             "\"fov_deg\": 0.01}}",
             exponent, 10.0 * sin(angle), 10.0 * cos(angle));
    sl_scene *scene = scene_from_text(json, plain_obj);
    sl_settings settings = small_settings("splatting", 2, 2);
    settings.gather = gather;
    sl_image *image = render(scene, &settings, NULL);
    assert_sound_picture(image, "a glossy plain");
    double seen = channel_mean(image, "G");
    destroy_picture(image, scene);
    return seen;
}

/* Whatever the order leaves of the lobe, its albedo is kept, for specular 1 and diffuse 0 too. Seen edge-on
 * the albedo goes to 0, and faster than a table over angles of view can tell. */
static void glossy_lobes_of_any_exponent_reflect_their_albedo_of_an_even_sky(void **state) {
    const double exponents[] = {0.0, 1.0, 20.0, 1e4, 1e6}, elevations[] = {90.0, 40.0, 10.0, 0.2},
                 most[] = {0.01, 0.01, 0.01, 0.2};
    for (int e = 0; e < 4; e++) {
        for (int x = 0; x < 5; x++) {
            double truth = lobe_albedo(exponents[x], sin(elevations[e] * pi / 180.0));
            double seen =
                glossy_plain(exponents[x], elevations[e], (sl_gather_kind)(SL_GATHER_PLANE + (e + x) % 3));
            if (!(fabs(seen - truth) < most[e] * truth))
                fail_msg("exponent %g, elevation %g: %g, not %g", exponents[x], elevations[e], seen, truth);
        }
    }
}

/* ---- a room ---- */

static sl_scene *room(double scale, const char *box, const char *lamp, const char *lights) {
    return room_with_a_box(scale, 0.0, "\"diffuse\": 0.6", box, lamp, lights);
}
static const char shiny[] = "\"diffuse\": 0.2, \"specular\": 0.6, \"exponent\": 12";

/* Irradiance beyond floats, of each kind of light, by rays and by maps: the largest float, and what is black
 * or in shadow stays black. */
static void light_beyond_floats_leaves_a_picture_of_numbers(void **state) {
    const char *const lamps[] = {"", "\"emission\": 3e38, ", "", "", ""};
    const char *const lights[] = {
        " \"lights\": [{\"type\": \"point\", \"position\": [5e-5, 0, 0], \"intensity\": 1e37}],\n", "",
        " \"environment\": {\"radiance\": 3e38},\n",
        " \"lights\": [{\"type\": \"directional\", \"direction\": [0, -1, -0.2], \"irradiance\": 3e38}, "
        "{\"type\": \"directional\", \"direction\": [0, -1, -0.1], \"irradiance\": 3e38}],\n",
        " \"lights\": [{\"type\": \"spot\", \"position\": [1e-5, 8e-5, 0], \"direction\": [0, -1, 0], "
        "\"intensity\": 3e38, \"inner_deg\": 30, \"outer_deg\": 60}],\n"};
    for (int i = 0; i < 10; i++) {
        sl_settings settings = small_settings("splatting", 32, 32);
        settings.direct = i % 2 ? SL_DIRECT_SHADOW_MAPS : SL_DIRECT_RAYS;
        sl_scene *scene = room(i / 2 == 1 ? 1.0 : 1e-4, shiny, lamps[i / 2], lights[i / 2]);
        sl_image *image = render(scene, &settings, NULL);
        assert_sound_picture(image, lights[i / 2]);
        destroy_picture(image, scene);
    }
}

static void where_nothing_shines_or_nothing_reflects_nothing_is_gathered(void **state) {
    sl_settings settings = small_settings("splatting", 16, 16);
    sl_scene *dark = room(1.0, shiny, "", "");
    dark->environment.present = false; /* what scene files without light are given */
    dark->light_count = 0;
    sl_scene *black = scene_from_text("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": "
                                      "\"m\"}], \"materials\": {\"m\": {\"diffuse\": 0}},\n"
                                      " \"environment\": {\"radiance\": 1}, \"camera\": {\"eye\": [0, 5, 0], "
                                      "\"target\": [0, 0, 0.001], \"fov_deg\": 40}}",
                                      plain_obj);
    sl_scene *const scenes[] = {dark, black};
    for (int i = 0; i < 2; i++) {
        sl_counters counters;
        sl_image *image = render(scenes[i], &settings, &counters);
        assert_sound_picture(image, "darkness");
        assert_int_equal(counters.value[SL_COUNT_RAYS] + counters.value[SL_COUNT_GATHERS] +
                             counters.value[SL_COUNT_RECORDS],
                         0);
        assert_true(channel_mean(image, "R") == 0.0);
        destroy_picture(image, scenes[i]);
    }
}

/* ---- light and materials that a room does not often have, against the path tracer ------------ */

static void expect_path_tracer(const char *what, sl_scene *scene, double error, double bias) {
    sl_settings settings = small_settings("splatting", 20, 20);
    settings.quality = SL_QUALITY_NORMAL;
    matched m = matched_with_path_tracer(scene, &settings, 100);
    print_message("%s: error %.4f (noise %.4f), bias %+.4f, %g records\n", what, m.error, m.noise, m.bias,
                  m.records);
    sl_scene_destroy(scene);
    if (!(m.error < error && fabs(m.bias) < bias)) fail_msg("%s", what);
}

static void boxes_of_odd_materials_have_the_path_tracers_light(void **state) {
    /* A lobe of 1e6 is a mirror; what twelve bands leave of it is blurred, so of that only the sum is right.
     */
    static const char *const boxes[] = {"\"mirror\": 1", "\"diffuse\": 0.5, \"emission\": 2",
                                        "\"diffuse\": 0, \"specular\": 1, \"exponent\": 0",
                                        "\"diffuse\": 0, \"specular\": 1, \"exponent\": 1e6"};
    const double error[] = {0.08, 0.08, 0.08, 0.25};
    for (int i = 0; i < 4; i++)
        expect_path_tracer(boxes[i], room(1.0, boxes[i], "\"emission\": 5, ", ""), error[i], 0.02);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(glossy_lobes_of_any_exponent_reflect_their_albedo_of_an_even_sky),
        cmocka_unit_test(light_beyond_floats_leaves_a_picture_of_numbers),
        cmocka_unit_test(where_nothing_shines_or_nothing_reflects_nothing_is_gathered),
        cmocka_unit_test(boxes_of_odd_materials_have_the_path_tracers_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
