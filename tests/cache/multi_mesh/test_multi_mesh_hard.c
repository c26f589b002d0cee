/* Hard cases of multi-mesh caching as whole pictures, against closed forms and exact shadows; and that it
 * comes to an end, whatever the scene. */
#include <math.h>
#include <stdio.h>

#include "unit_test.h"
#include "matched.h"
#include "rendering.h"

static const double pi = 3.14159265358979323846;
enum { SIDE = 64, PIXELS = SIDE * SIDE };

static sl_settings mesh_settings(int width, int height) {
    sl_settings s = small_settings("multi-mesh", width, height);
    return s;
}

static double sum_of(const sl_image *image, const char *channel) {
    const float *plane = sl_image_channel(image, channel);
    double sum = 0.0;
    for (size_t i = 0; i < (size_t)image->width * (size_t)image->height; i++) sum += (double)plane[i];
    return sum;
}

/* ---- light of known amount ---- */

/* A disc of angular radius sigma around a glossy floor's normal, seen along that normal: k_s L (1 - cos^(n+2)
 * sigma). Seen from elsewhere a lobe much narrower than the disc shows k_s L cos theta, as long as its mirror
 * direction meets the disc: the lamp is no point in its middle. */
static void a_discs_highlight_is_within_4_percent_of_the_integral_also_beside_its_middle(void **state) {
    static const double exponent[] = {10, 10, 100, 100, 1000, 500}, degrees[] = {20, 60, 5, 60, 1, 40},
                        aside[] = {0, 0, 0, 0, 0, 0.2};
    for (int k = 0; k < 6; k++) {
        char obj[8192], json[512];
        double sigma = degrees[k] * pi / 180.0, radius = tan(sigma);
        int n = snprintf(obj, sizeof obj,
                         "v -9 0 -9\nv -9 0 9\nv 9 0 9\nv 9 0 -9\nusemtl floor\nf 1 2 3 4\nv 0 1 0\n");
        for (int i = 0; i < 64; i++)
            n += snprintf(obj + n, sizeof obj - (size_t)n, "v %.9g 1 %.9g\n", radius * cos(2 * pi * i / 64),
                          radius * sin(2 * pi * i / 64));
        n += snprintf(obj + n, sizeof obj - (size_t)n, "usemtl lamp\n");
        for (int i = 0; i < 64; i++)
            n += snprintf(obj + n, sizeof obj - (size_t)n, "f 5 %d %d\n", 6 + i, 6 + (i + 1) % 64);
        snprintf(json, sizeof json,
                 "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"materials\": {\"floor\": "
                 "{\"diffuse\": 0, \"specular\": 0.5, "
                 "\"exponent\": %g}, \"lamp\": {\"diffuse\": 0, \"emission\": 3}}, \"camera\": {\"eye\": "
                 "[%g, 0.5, 0], \"target\": [0, 0, 0], \"up\": [0, 0, 1], "
                 "\"fov_deg\": 0.5}}",
                 exponent[k], aside[k]);
        sl_scene *scene = scene_from_text(json, obj);
        sl_settings settings = mesh_settings(9, 9);
        settings.quality = SL_QUALITY_HIGH;
        sl_image *image = render(scene, &settings, NULL);
        double expected = 0.5 * 3.0 * (1.0 - pow(cos(sigma), exponent[k] + 2.0)) * 0.5 / hypot(0.5, aside[k]),
               found = (double)sl_image_channel(image, "specular.G")[40];
        print_message("n %.0f, %.0f degrees: %.4f, the integral %.4f: %+.1f %%\n", exponent[k], degrees[k],
                      found, expected, 100.0 * (found / expected - 1.0));
        assert_true(fabs(found / expected - 1.0) < 0.04);
        destroy_picture(image, scene);
    }
}

/* The sky is all the light there is. A wide floor under it reflects 1/2 of it; a small tile above the floor,
 * seen from below, sees nothing else. */
static void the_skys_light_bounces(void **state) {
    sl_scene *scene = scene_from_text(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"materials\": {\"grey\": {\"diffuse\": "
        "0.5}}, \"environment\": {\"radiance\": [2, 2, 2]}, "
        "\"camera\": {\"eye\": [0, 0.5, 0], \"target\": [0, 1, 0], \"up\": [0, 0, 1], \"fov_deg\": 10}}",
        "v -90 0 -90\nv -90 0 90\nv 90 0 90\nv 90 0 -90\nv -.1 1 -.1\nv .1 1 -.1\nv .1 1 .1\nv -.1 1 "
        ".1\nusemtl grey\nf 1 2 3 4\nf 5 6 7 8\n");
    sl_settings settings = mesh_settings(9, 9);
    /* a second one finds nothing but the tile, and the sky is not counted twice */
    for (uint32_t bounces = 1; bounces <= 2; bounces++) {
        settings.bounces = bounces;
        sl_image *image = render(scene, &settings, NULL);
        assert_true(fabs((double)sl_image_channel(image, "indirect.G")[40] / 0.5 - 1.0) < 0.03);
        sl_image_destroy(image);
    }
    sl_scene_destroy(scene);
}

/* ---- exact shadows ---- */

static sl_image *exact_direct_light(const sl_scene *scene, int width, int height) {
    sl_settings s = small_settings("path", width, height);
    s.transport = "direct";
    s.filter = SL_FILTER_CENTRE;
    s.spp = 4;
    return render(scene, &s, NULL); /* without noise: there are but point lights */
}

static bool nearly(float a, float b, float room) { return fabsf(a - b) <= room; }

/* Tells whether the exact picture jumps within `reach` pixels of this one. */
static bool near_a_border(const float *exact, int x, int y, int reach, float jump) {
    float least = INFINITY, most = 0.0f;
    for (int j = y - reach; j <= y + reach; j++) {
        for (int i = x - reach; i <= x + reach; i++) {
            if (i < 0 || j < 0 || i >= SIDE || j >= SIDE) continue;
            least = fminf(least, exact[j * SIDE + i]);
            most = fmaxf(most, exact[j * SIDE + i]);
        }
    }
    return most - least > jump;
}

/* Counts the pixels that differ from exact direct light by more than a tenth of its most, farther than
 * `reach` pixels from where that jumps. */
static int count_wrong(const sl_scene *scene, sl_quality quality, int reach) {
    sl_settings settings = mesh_settings(SIDE, SIDE);
    settings.quality = quality;
    sl_image *ours = render(scene, &settings, NULL), *theirs = exact_direct_light(scene, SIDE, SIDE);
    assert_sound_picture(ours, "direct light");
    const float *mine = sl_image_channel(ours, "direct.G"), *exact = sl_image_channel(theirs, "G");
    float most = 0.0f;
    int wrong = 0, at_borders = 0;
    for (int i = 0; i < PIXELS; i++) most = fmaxf(most, exact[i]);
    assert_true(most > 0.0f);
    for (int i = 0; i < PIXELS; i++) {
        if (nearly(mine[i], exact[i], 0.1f * most)) continue;
        if (near_a_border(exact, i % SIDE, i / SIDE, reach, 0.2f * most)) at_borders++;
        else wrong++;
    }
    print_message("%d of %d pixels differ beside borders, %d elsewhere\n", at_borders, PIXELS, wrong);
    destroy_pictures(ours, theirs);
    return wrong;
}

/* A plate below a point light throws a shadow whose border leaves of at most 8 pixels blur, and nothing
 * beyond. */
static void a_point_lights_shadow_is_sharp_within_a_leaf(void **state) {
    sl_scene *scene = scene_from_text(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"lights\": [{\"type\": \"point\", "
        "\"position\": [0.3, 3, 0.1], "
        "\"intensity\": 20}], \"camera\": {\"eye\": [0, 2.5, 4], \"target\": [0, 0, 0], \"fov_deg\": 45}}",
        "v -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nf 1 2 3 4\nv -0.7 1 -0.4\nv -0.5 1 0.5\nv 0.4 1 0.6\nv 0.5 "
        "1 -0.5\nf 5 6 7 8\n");
    assert_int_equal(count_wrong(scene, SL_QUALITY_HIGH, 4), 0);
    assert_true(count_wrong(scene, SL_QUALITY_NORMAL, 8) <= 4); /* at corners */
    sl_scene_destroy(scene);
}

/* The floor's vertices lie under the leg, where no light is: that darkness does not creep out. */
static void a_leg_on_a_floors_vertex_has_no_dark_halo(void **state) {
    char obj[2048];
    int n = snprintf(obj, sizeof obj,
                     "usemtl floor\nv -3 0 -3\nv 0 0 -3\nv 3 0 -3\nv -3 0 0\nv 0 0 0\nv 3 0 0\nv -3 0 3\nv 0 "
                     "0 3\nv 3 0 3\n"
                     "f 1 4 5 2\nf 2 5 6 3\nf 4 7 8 5\nf 5 8 9 6\nusemtl leg\n");
    for (int i = 0; i < 8; i++)
        n += snprintf(obj + n, sizeof obj - (size_t)n, "v %g %g %g\n", i & 1 ? 0.25 : -0.25,
                      i & 2 ? 1.0 : 0.0, i & 4 ? 0.2 : -0.3);
    snprintf(obj + n, sizeof obj - (size_t)n,
             "f 10 11 13 12\nf 14 16 17 15\nf 10 14 15 11\nf 12 13 17 16\nf 10 12 16 14\nf 11 15 17 13\n");
    sl_scene *scene = scene_from_text(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"lights\": [{\"type\": \"point\", "
        "\"position\": [1, 3, 2], \"intensity\": "
        "20}], \"camera\": {\"eye\": [0.5, 2, 3.5], \"target\": [0, 0.2, 0], \"fov_deg\": 40}}",
        obj);
    assert_true(count_wrong(scene, SL_QUALITY_HIGH, 4) <= 2);
    assert_true(count_wrong(scene, SL_QUALITY_NORMAL, 8) <= 8);
    sl_scene_destroy(scene);
}

/* A slab on a floor whose shadow is narrower than a pixel is long: the floor's vertices lie under the slab,
 * where no light is, or beyond the shadow. Leaves with such corners are cut until it is known where the light
 * begins: what is dark is dark, but for what a leaf of a pixel blurs. */
static void the_shadow_of_a_rug_is_a_pixel_wide_and_dark(void **state) {
    char obj[1024];
    int n = snprintf(obj, sizeof obj,
                     "usemtl floor\nv -6 0 -5\nv -5 0 6\nv 6 0 5\nv 5 0 -6\nf 1 2 3 4\nusemtl rug\n"),
        dark = 0;
    for (int i = 0; i < 8; i++)
        n += snprintf(obj + n, sizeof obj - (size_t)n, "v %g %g %g\n", i & 1 ? 2.0 : -2.0, i & 2 ? 0.03 : 0.0,
                      (i & 4 ? 0.5 : -1.5) + (i & 1 ? 0.3 : 0.0));
    snprintf(obj + n, sizeof obj - (size_t)n,
             "f 5 6 8 7\nf 9 11 12 10\nf 5 9 10 6\nf 7 8 12 11\nf 5 7 11 9\nf 6 10 12 8\n");
    sl_scene *scene = scene_from_text(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"lights\": [{\"type\": \"point\", "
        "\"position\": [0, 2, -2.5], \"intensity\": "
        "20}], \"camera\": {\"eye\": [0, 1.2, 3.2], \"target\": [0, 0, 0.6], \"fov_deg\": 40}}",
        obj);
    sl_settings settings = mesh_settings(SIDE, SIDE);
    settings.quality = SL_QUALITY_NORMAL;
    sl_image *ours = render(scene, &settings, NULL), *theirs = exact_direct_light(scene, SIDE, SIDE);
    const float *mine = sl_image_channel(ours, "direct.G"), *exact = sl_image_channel(theirs, "G");
    double there = 0.0, around = 0.0;
    for (int i = SIDE; i < PIXELS - SIDE; i++) {
        if (!(exact[i] < 1e-3f && exact[i + SIDE] > 0.01f)) continue; /* before it, the floor is lit */
        dark++;
        there += (double)mine[i];
        around += (double)exact[i + SIDE];
    }
    print_message("%d dark pixels, %.1f %% as bright as those below\n", dark, 100.0 * there / around);
    assert_true(dark > 15);
    assert_true(there < 0.1 * around);
    destroy_pictures(ours, theirs);
    sl_scene_destroy(scene);
}

/* ---- layers ---- */

static void the_picture_is_the_sum_of_its_layers_and_a_lamp_shows_its_radiance(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-glossy.json");
    sl_settings settings = mesh_settings(SIDE, SIDE);
    sl_image *image = render(scene, &settings, NULL);
    static const char *const colours = "RGB";
    int lamp = 0;
    for (int c = 0; c < 3; c++) {
        char name[4][16];
        snprintf(name[0], 16, "direct.%c", colours[c]);
        snprintf(name[1], 16, "specular.%c", colours[c]);
        snprintf(name[2], 16, "indirect.%c", colours[c]);
        snprintf(name[3], 16, "emission.%c", colours[c]);
        for (int i = 0; i < PIXELS; i++) {
            double sum = 0.0, whole = (double)image->planes[c * PIXELS + i];
            for (int k = 0; k < 4; k++) sum += (double)sl_image_channel(image, name[k])[i];
            assert_true(fabs(sum - whole) <= 1e-6 * whole);
            lamp += c == 0 && sl_image_channel(image, name[3])[i] > 0.0f;
        }
    }
    assert_true(sum_of(image, "specular.G") > 0.0);
    assert_true(lamp > 0);
    destroy_picture(image, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_discs_highlight_is_within_4_percent_of_the_integral_also_beside_its_middle),
        cmocka_unit_test(the_skys_light_bounces),
        cmocka_unit_test(a_point_lights_shadow_is_sharp_within_a_leaf),
        cmocka_unit_test(a_leg_on_a_floors_vertex_has_no_dark_halo),
        cmocka_unit_test(the_shadow_of_a_rug_is_a_pixel_wide_and_dark),
        cmocka_unit_test(the_picture_is_the_sum_of_its_layers_and_a_lamp_shows_its_radiance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
