/* Radiance cache splatting against what must come out: closed forms first, then the reference path tracer. */
#include <math.h>
#include <stdio.h>

#include "unit_test.h"
#include "matched.h"
#include "rendering.h"

/* Inside a sphere one diffuse bounce is the same everywhere: E = albedo <E_direct>, <E_direct> = power / (4
 * pi R^2) = 1 for a light of intensity 1 and R = 1. So L = albedo / pi * albedo, for albedo 0.5. */
static void one_bounce_in_the_integrating_sphere_is_uniform(void **state) {
    const double wanted = 0.25 / 3.14159265358979;
    sl_scene *scene = load_scene("scenes/sphere.json");
    const sl_gather_kind kinds[] = {SL_GATHER_RAYS, SL_GATHER_HEMICUBE, SL_GATHER_PLANE};
    const double tolerance = 0.01, spread[] = {0.08, 0.03, 0.05}; /* measured: 0.071, 0.018, 0.029 */
    for (int k = 0; k < 3; k++) {
        sl_settings settings = small_settings("splatting", 48, 48);
        settings.gather = kinds[k];
        settings.gather_size = 64;
        sl_image *image = render(scene, &settings, NULL);
        const float *indirect = sl_image_channel(image, "indirect.G");
        assert_true(fabs(channel_mean(image, "indirect.G") / wanted - 1.0) < tolerance);
        for (int i = 0; i < 48 * 48; i++) assert_true(fabs((double)indirect[i] / wanted - 1.0) < spread[k]);
        sl_image_destroy(image);
    }
    sl_scene_destroy(scene);
}

/* The same paths by the path tracer: a missing 1/pi, a wrong cosine or a lost factor 2 would show at once. */
static void compare_with_reference(const sl_scene *scene, const char *name, sl_quality quality,
                                   double most_relative_error, double most_bias) {
    sl_settings settings = small_settings("splatting", 96, 96);
    settings.quality = quality;
    print_message("%s: ", name);
    const sl_comparison c = against_path_tracer(scene, &settings, 400, NULL);
    assert_true(c.rel_mse - c.rel_mse_noise < most_relative_error * most_relative_error);
    assert_true(fabs(c.bias) < most_bias);
}

static void expect_near_reference(const char *path, sl_quality quality, double most_relative_error,
                                  double most_bias) {
    sl_scene *scene = load_scene(path);
    compare_with_reference(scene, path, quality, most_relative_error, most_bias);
    sl_scene_destroy(scene);
}

static void the_cornell_box_is_what_the_path_tracer_says(void **state) {
    expect_near_reference("scenes/cornell.json", SL_QUALITY_NORMAL, 0.03, 0.005);
}

static void a_room_lit_only_indirectly_is_what_the_path_tracer_says(void **state) {
    expect_near_reference("scenes/two-rooms.json", SL_QUALITY_HIGH, 0.07, 0.02);
}

static void the_layers_add_up_to_the_picture(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = small_settings("splatting", 32, 32);
    sl_image *image = render(scene, &settings, NULL);
    const float *r = sl_image_channel(image, "R"), *e = sl_image_channel(image, "emission.R"),
                *d = sl_image_channel(image, "direct.R"), *i = sl_image_channel(image, "indirect.R");
    for (int p = 0; p < 32 * 32; p++) assert_true(r[p] == e[p] + d[p] + i[p]);
    destroy_picture(image, scene);
}

/* ---- the sky ---- */

static const char plane_obj[] = "v -50 0 -50\nv -50 0 50\nv 50 0 50\nv 50 0 -50\nf 1 2 3 4\n";
static const char plane_json[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"m\"}],\n"
    " \"materials\": {\"m\": {\"diffuse\": [0.5, 0.5, 0.5]%s}}, \"environment\": {\"radiance\": [2, 2, 2]},\n"
    " \"camera\": {\"eye\": [0, 3, 6], \"target\": [0, 0, 0], \"up\": [0, 1, 0], \"fov_deg\": 30}}";

/* E = pi L on an open plane: reflected radiance is albedo times L, glossy lobe or not: the cache carries the
 * diffuse light of the sky. */
static void an_open_plane_under_an_even_sky_reflects_albedo_times_its_radiance(void **state) {
    const char *const glossy[] = {"", ", \"specular\": [1e-6, 1e-6, 1e-6], \"exponent\": 5"};
    for (int run = 0; run < 2; run++) {
        char json[512];
        snprintf(json, sizeof json, plane_json, glossy[run]);
        sl_scene *scene = scene_from_text(json, plane_obj);
        sl_settings settings = small_settings("splatting", 24, 24);
        settings.spp = 64;
        sl_image *image = render(scene, &settings, NULL);
        assert_true(fabs(channel_mean(image, "R") - 1.0) < 0.005);
        assert_true(channel_mean(image, "direct.R") < 1e-4);
        destroy_picture(image, scene);
    }
}

/* A lamp and a sky together, and a niche that only bounced light reaches. */
static const char niche_obj[] =
    "v -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nv -1 0 -1\nv 1 0 -1\nv 1 2 -1\nv -1 2 -1\n"
    "v -1 2 1\nv 1 2 1\nv -1 0 1\nf 1 2 3 4\nf 5 6 7 8\nf 8 7 10 9\nf 5 8 9 11\n";
static const char niche_json[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"m\"}],\n"
    " \"materials\": {\"m\": {\"diffuse\": [0.7, 0.6, 0.5]}}, \"environment\": {\"radiance\": [0.4, 0.5, "
    "0.7]},\n"
    " \"lights\": [{\"type\": \"quad\", \"corner\": [2, 2.5, -1], \"edge1\": [1, 0, 0], \"edge2\": [0, 0, "
    "1],\n"
    "   \"radiance\": [8, 7, 5]}],\n"
    " \"camera\": {\"eye\": [1.5, 2, 6], \"target\": [0.2, 0.8, 0], \"up\": [0, 1, 0], \"fov_deg\": 45}}";

static void a_niche_under_lamp_and_sky_is_what_the_path_tracer_says(void **state) {
    sl_scene *scene = scene_from_text(niche_json, niche_obj);
    compare_with_reference(scene, "niche", SL_QUALITY_NORMAL, 0.03, 0.005);
    sl_scene_destroy(scene);
}

static void passes_that_a_scene_does_not_need_do_not_run(void **state) {
    sl_scene *furnace = load_scene("scenes/furnace.json");
    sl_settings settings = small_settings("splatting", 24, 24);
    sl_counters counters;
    settings.gather = SL_GATHER_RAYS;
    destroy_picture(render(furnace, &settings, &counters), furnace);
    assert_true(counters.value[SL_COUNT_RECORDS] > 0);
    assert_int_equal(counters.value[SL_COUNT_RASTER_PASSES], 1); /* the G-buffer alone: rays gather */
    assert_int_equal(counters.value[SL_COUNT_SHADOW_LOOKUPS], 0);

    static const char mirror_json[] =
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"material\": \"m\"}], \"materials\": "
        "{\"m\": {\"mirror\": [1, 1, 1]}},\n"
        " \"lights\": [{\"type\": \"point\", \"position\": [3, 1, 1], \"intensity\": [10, 10, 10]}]}";
    sl_scene *mirrors = scene_from_text(mirror_json, niche_obj);
    destroy_picture(render(mirrors, &settings, &counters), mirrors);
    assert_int_equal(counters.value[SL_COUNT_GATHERS], 0);
    /* from mirror to mirror */
    assert_true(counters.value[SL_COUNT_RAYS] > 0 && counters.value[SL_COUNT_RAYS] <= 16 * 24 * 24);
    assert_int_equal(counters.value[SL_COUNT_SHADOW_RAYS], 0);
    assert_int_equal(counters.value[SL_COUNT_SPLATS], 0);
    assert_int_equal(counters.value[SL_COUNT_RASTER_PASSES], 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_bounce_in_the_integrating_sphere_is_uniform),
        cmocka_unit_test(the_cornell_box_is_what_the_path_tracer_says),
        cmocka_unit_test(a_room_lit_only_indirectly_is_what_the_path_tracer_says),
        cmocka_unit_test(the_layers_add_up_to_the_picture),
        cmocka_unit_test(an_open_plane_under_an_even_sky_reflects_albedo_times_its_radiance),
        cmocka_unit_test(a_niche_under_lamp_and_sky_is_what_the_path_tracer_says),
        cmocka_unit_test(passes_that_a_scene_does_not_need_do_not_run),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
