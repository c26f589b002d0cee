/* What a gather sees reflects direct light by its glossy lobe, too: closed forms, then pictures against the
 * path tracer. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "gather_world.h"
#include "matched.h"
#include "rendering.h"

static const double pi = 3.14159265358979323846;
static const sl_vec3 above = {0.3f, 0.5f, -0.2f}, downwards = {0, -1, 0};

/* A plain of 2000 x 2000 that has a glossy lobe alone. */
static world *glossy_plain(float specular, float exponent) {
    world *w = world_new();
    uint32_t m = world_material(w, sl_grey(0.0f), sl_grey(0.0f));
    w->materials[m].specular = (sl_rgb){specular, 0.5f * specular, 0.0f};
    w->materials[m].exponent = exponent;
    world_quad(w, sl_v3(-1000, 0, 1000), sl_v3(1000, 0, 1000), sl_v3(1000, 0, -1000), sl_v3(-1000, 0, -1000),
               m);
    return w;
}

static sl_gather_settings settings_for(sl_gather_kind kind) {
    sl_gather_settings s = sl_gather_defaults();
    s.kind = kind;
    s.glossy_hits = true;
    return s;
}

static void assert_near(double value, double truth, double tolerance) {
    if (!(fabs(value - truth) <= tolerance * truth)) fail_msg("%g, expected %g", value, truth);
}

/* Light of irradiance E straight from above: towards theta goes ks (n + 2) / (2 pi) cos^n theta E, so a point
 * that faces the plain receives ks E, whatever the exponent. */
static void light_from_above_is_received_times_ks(void **state) {
    (void)state;
    const float exponents[] = {0.0f, 1.0f, 8.0f, 50.0f};
    for (int e = 0; e < 4; e++) {
        world *w = glossy_plain(0.8f, exponents[e]);
        w->lights[w->light_count++] =
            (sl_light){.type = SL_LIGHT_DIRECTIONAL, .direction = {0, -1, 0}, .intensity = {3, 3, 3}};
        world_build(w);
        for (int k = SL_GATHER_PLANE; k <= SL_GATHER_RAYS; k++) {
            for (int maps = 0; maps < 2; maps++) {
                sl_gather_settings s = settings_for((sl_gather_kind)k);
                s.direct = maps ? SL_DIRECT_SHADOW_MAPS : SL_DIRECT_RAYS;
                sl_irradiance got = gather_once(w, &s, above, downwards);
                /* The plane's border says of the horizon what it sees at 70 degrees. */
                double tolerance = k == SL_GATHER_PLANE ? 0.06 : 0.01;
                assert_near((double)got.value.r, 0.8 * 3.0, tolerance);
                assert_near((double)got.value.g, 0.4 * 3.0, tolerance);
                assert_true(got.value.b == 0.0f);
            }
        }
        world_free(w);
    }
}

/* Under an even sky a lobe of exponent 0 sends ks (1 + cos theta) / 2 towards theta; its mean over the cosine
 * is 5/6. */
static void an_even_sky_is_received_by_five_sixths_times_ks(void **state) {
    (void)state;
    world *w = glossy_plain(0.8f, 0.0f);
    w->environment = (sl_environment){.present = true, .constant = {2, 2, 2}};
    world_build(w);
    sl_gather_settings s = settings_for(SL_GATHER_RAYS);
    s.hit_samples = 4;
    double sum = 0.0;
    for (int i = 0; i < 4; i++)
        sum += (double)gather_once(w, &s, sl_v3((float)i, 0.5f, 0.0f), downwards).value.r / 4.0;
    assert_near(sum, 0.8 * 2.0 * pi * 5.0 / 6.0, 0.01);
    world_free(w);
}

static void without_the_option_lobes_are_black_and_cost_nothing(void **state) {
    (void)state;
    world *w = glossy_plain(0.8f, 8.0f);
    w->lights[w->light_count++] =
        (sl_light){.type = SL_LIGHT_DIRECTIONAL, .direction = {0, -1, 0}, .intensity = {3, 3, 3}};
    world_build(w);
    sl_gather_settings s = settings_for(SL_GATHER_RAYS);
    s.glossy_hits = false;
    gatherer g = gatherer_new(w, &s);
    sl_irradiance got = gather_at(&g, above, downwards, 1);
    assert_true(got.value.r == 0.0f);
    assert_int_equal(g.counters->value[SL_COUNT_SHADOW_RAYS], 0);
    gatherer_free(&g);
    world_free(w);
}

/* L G D E and L G G E beside the diffuse paths. */
static void the_glossy_box_with_glossy_hits_agrees_with_the_path_tracer(void **state) {
    (void)state;
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    const sl_direct_kind kinds[] = {SL_DIRECT_RAYS, SL_DIRECT_SHADOW_MAPS};
    for (int i = 0; i < 2; i++) {
        sl_settings settings = small_settings("splatting", 24, 24);
        settings.quality = SL_QUALITY_NORMAL;
        settings.glossy_hits = true;
        settings.direct = kinds[i];
        matched m = matched_with_path_tracer(scene, &settings, 256, false);
        print_message("glossy hits: error %.4f (noise %.4f), bias %+.4f\n", m.error, m.noise, m.bias);
        assert_true(m.error < 0.15 && fabs(m.bias) < 0.01);
    }
    sl_scene_destroy(scene);
}

/* More light with the option than without, and no other bits where nothing is glossy. */
static void glossy_hits_add_light_where_something_is_glossy_alone(void **state) {
    (void)state;
    const char *const paths[] = {"scenes/cornell.json", "scenes/cornell-glossy.json"};
    for (int i = 0; i < 2; i++) {
        sl_scene *scene = load_scene(paths[i]);
        sl_settings settings = small_settings("splatting", 24, 24);
        sl_image *without = render(scene, &settings, NULL);
        settings.glossy_hits = true;
        sl_image *with = render(scene, &settings, NULL);
        sl_comparison c;
        assert_int_equal(sl_image_compare(with, without, NULL, &c, NULL, NULL), SL_OK);
        assert_true(i ? c.bias > 0.003 : same_picture(with, without));
        sl_image_destroy(without);
        sl_image_destroy(with);
        sl_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_from_above_is_received_times_ks),
        cmocka_unit_test(an_even_sky_is_received_by_five_sixths_times_ks),
        cmocka_unit_test(without_the_option_lobes_are_black_and_cost_nothing),
        cmocka_unit_test(the_glossy_box_with_glossy_hits_agrees_with_the_path_tracer),
        cmocka_unit_test(glossy_hits_add_light_where_something_is_glossy_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
