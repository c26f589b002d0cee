/* Whole pictures by multi-mesh caching: closed forms, the path tracer on the same paths, what is done again
 * and what is not. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "matched.h"
#include "rendering.h"

static const double pi = 3.14159265358979323846;

static sl_settings mesh_settings(int width, int height) {
    sl_settings s = small_settings("multi-mesh", width, height);
    return s;
}

/* ---- against the truth ---- */

static void the_cornell_box_is_lit_as_by_its_one_bounce_paths(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = mesh_settings(96, 96);
    sl_comparison c = against_path_tracer(scene, &settings, 128, NULL);
    assert_true(fabs(c.bias) < 0.03);
    assert_true(c.rel_mse - c.rel_mse_noise < 6e-3);
    settings.quality = SL_QUALITY_NORMAL;
    c = against_path_tracer(scene, &settings, 128, NULL);
    assert_true(fabs(c.bias) < 0.015);
    assert_true(c.rel_mse - c.rel_mse_noise < 2.2e-3);
    sl_scene_destroy(scene);
}

/* A light enclosed in a sphere of albedo 1/2 lights it evenly with rho Phi / (4 pi R^2), wherever it is; a
 * further bounce adds rho times that. */
static void a_sphere_cavity_is_lit_evenly_by_each_bounce(void **state) {
    sl_scene *scene = load_scene("scenes/sphere.json");
    for (uint32_t bounces = 1; bounces <= 3; bounces++) {
        sl_settings settings = mesh_settings(48, 48);
        settings.bounces = bounces;
        sl_image *image = render(scene, &settings, NULL);
        const float *indirect = sl_image_channel(image, "indirect.G"), *kd = sl_image_channel(image, "kd.G");
        double expected = 0.5 * 4.0 * pi / (4.0 * pi) * (bounces == 1 ? 1.0 : bounces == 2 ? 1.5 : 1.75);
        double sum = 0.0, worst = 0.0;
        for (int i = 0; i < 48 * 48; i++) {
            double irradiance = (double)indirect[i] / (double)kd[i] * pi;
            sum += irradiance;
            worst = fmax(worst, fabs(irradiance / expected - 1.0));
        }
        print_message("%u bounces: E_i %.4f, expected %.4f, largest difference %.2f %%\n", bounces,
                      sum / 2304.0, expected, 100.0 * worst);
        assert_true(fabs(sum / 2304.0 / expected - 1.0) < 0.02);
        assert_true(worst < 0.06);
        sl_image_destroy(image);
    }
    sl_scene_destroy(scene);
}

/* Irradiance at p from a rectangle parallel to the floor at height h, by the four corners' closed form G. */
static double corner_form(double x, double y) {
    return (x / sqrt(1 + x * x) * atan(y / sqrt(1 + x * x)) +
            y / sqrt(1 + y * y) * atan(x / sqrt(1 + y * y))) /
           (2 * pi);
}

static const char floor_obj[] =
    "v -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n";

/* A square lamp above a floor, nothing in between: within what an eye can tell of Lambert's formula. */
static void an_empty_floor_under_a_lamp_is_lit_as_lambert_says(void **state) {
    sl_scene *scene = scene_from_text("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"lights\": "
                                      "[{\"type\": \"quad\", \"corner\": [-1, 2, -1], "
                                      "\"edge1\": [2, 0, 0], \"edge2\": [0, 0, 2], \"radiance\": 1}], "
                                      "\"camera\": {\"eye\": [0, 6, 0], \"target\": [0, 0, 0], "
                                      "\"up\": [0, 0, -1], \"fov_deg\": 60}}",
                                      floor_obj);
    sl_settings settings = mesh_settings(64, 64);
    settings.quality = SL_QUALITY_HIGH;
    sl_image *image = render(scene, &settings, NULL);
    const float *direct = sl_image_channel(image, "direct.G"), *kd = sl_image_channel(image, "kd.G");
    double worst = 0.0, sum = 0.0;
    int compared = 0;
    for (int i = 0; i < 64 * 64; i++) {
        if (!(kd[i] > 0.0f)) continue;
        double x = ((i % 64) + 0.5) / 32.0 - 1.0, y = 1.0 - ((i / 64) + 0.5) / 32.0,
               reach = 6.0 * tan(pi / 6.0), h = 2.0;
        double px = x * reach, pz = -y * reach;
        if (fabs(px) < 2.1 && fabs(pz) < 2.1) continue; /* the lamp's back hides it from the camera */
        double left = (-1 - px) / h, right = (1 - px) / h, near = (-1 - pz) / h, far = (1 - pz) / h;
        double form = corner_form(right, far) - corner_form(left, far) - corner_form(right, near) +
                      corner_form(left, near);
        double error = fabs((double)direct[i] / (double)kd[i] / form - 1.0);
        worst = fmax(worst, error);
        sum += error;
        compared++;
    }
    print_message("%d pixels, mean difference %.2f %%, largest %.2f %%\n", compared, 100.0 * sum / compared,
                  100.0 * worst);
    assert_true(compared > 500);
    assert_true(sum / compared < 0.01);
    assert_true(worst < 0.06); /* three grey levels in the dark */
    destroy_picture(image, scene);
}

static void two_lamps_together_light_as_one_and_the_other(void **state) {
    static const char *const lights[3] = {
        "{\"type\": \"point\", \"position\": [1, 2, 1], \"intensity\": 3}",
        "{\"type\": \"quad\", \"corner\": [-2, 2, -2], \"edge1\": [1, 0, 0], \"edge2\": [0, 0, 1], "
        "\"radiance\": [4, 2, 1]}",
        ("{\"type\": \"point\", \"position\": [1, 2, 1], \"intensity\": 3}, {\"type\": \"quad\", \"corner\": "
         "[-2, 2, -2], \"edge1\": [1, 0, 0], \"edge2\": [0, 0, "
         "1], \"radiance\": [4, 2, 1]}")};
    sl_image *image[3];
    for (int i = 0; i < 3; i++) {
        char json[1024];
        snprintf(json, sizeof json,
                 "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"lights\": [%s], \"camera\": "
                 "{\"eye\": [0, 1.5, 6], \"target\": [0, 0, "
                 "0], \"up\": [0, 1, 0], \"fov_deg\": 50}}",
                 lights[i]);
        sl_scene *scene = scene_from_text(json, floor_obj);
        sl_settings settings = mesh_settings(48, 48);
        settings.quality = SL_QUALITY_HIGH;
        image[i] = render(scene, &settings, NULL);
        sl_scene_destroy(scene);
    }
    const float *a = sl_image_channel(image[0], "direct.R"), *b = sl_image_channel(image[1], "direct.R"),
                *both = sl_image_channel(image[2], "direct.R");
    double difference = 0.0, sum = 0.0;
    for (int i = 0; i < 48 * 48; i++) {
        difference += fabs((double)a[i] + (double)b[i] - (double)both[i]);
        sum += (double)both[i];
    }
    print_message("mean difference %.3f %%\n", 100.0 * difference / sum);
    assert_true(sum > 0.0);
    assert_true(difference < 0.01 * sum);
    for (int i = 0; i < 3; i++) sl_image_destroy(image[i]);
}

/* ---- what is done again, and what is not ---- */

static sl_counters counters_of(const sl_method *method) { return *sl_method_counters(method); }

static uint64_t grown(const sl_counters *before, const sl_counters *after, sl_counter counter) {
    return after->value[counter] - before->value[counter];
}

static void look_from(sl_scene *scene, float x) {
    assert_int_equal(sl_scene_set_camera(scene, (float[]){278 + x, 273, -800}, (float[]){278, 273, 0},
                                         (float[]){0, 1, 0}, 0.686f, NULL),
                     SL_OK);
}

/* There and back again, at the defaults of quality normal. Specular radiance is refined anew each time, from
 * what is there. */
static void back_in_an_old_view_no_irradiance_is_sampled_again(void **state) {
    static const char *const names[] = {"scenes/cornell.json", "scenes/cornell-glossy.json"};
    for (int k = 0; k < 2; k++) {
        sl_scene *scene = load_scene(names[k]);
        sl_settings settings = mesh_settings(128, 96);
        settings.quality = SL_QUALITY_NORMAL;
        look_from(scene, 0);
        sl_method *method = created_method(scene, &settings);
        run_to_end(method);
        for (int there = 0; there < 2; there++) {
            sl_counters at_home = counters_of(method);
            look_from(scene, there ? -90.0f : 150.0f);
            assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
            run_to_end(method);
            sl_counters before = counters_of(method);
            assert_true(grown(&at_home, &before, SL_COUNT_LIGHT_SAMPLES) > 0);
            look_from(scene, 0);
            assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
            run_to_end(method);
            sl_counters after = counters_of(method);
            assert_int_equal(grown(&before, &after, SL_COUNT_LIGHT_SAMPLES), 0);
            assert_int_equal(grown(&before, &after, SL_COUNT_INDIRECT_SAMPLES), 0);
        }
        destroy_method(method, scene);
    }
}

static void the_first_picture_takes_the_roots_vertices_and_the_ambient_light(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = mesh_settings(48, 48);
    sl_method *method = created_method(scene, &settings);
    update(method); /* the view */
    update(method); /* the roots */
    sl_counters counters = counters_of(method);
    sl_image *image = resolved_picture(method);
    const float *indirect = sl_image_channel(image, "indirect.R"), *kd = sl_image_channel(image, "kd.R");
    double first = 0.0;
    for (int i = 0; i < 48 * 48; i++) {
        if (!(kd[i] > 0.0f)) continue;
        double irradiance = (double)indirect[i] / (double)kd[i];
        if (first == 0.0) first = irradiance;
        assert_true(fabs(irradiance / first - 1.0) < 1e-5);
    }
    assert_true(first > 0.0);
    assert_true(counters.value[SL_COUNT_LIGHT_SAMPLES] > 0);
    assert_true(counters.value[SL_COUNT_LIGHT_SAMPLES] <= 3 * 32); /* triangles have three corners each */
    assert_int_equal(counters.value[SL_COUNT_SPLITS], 0);
    assert_int_equal(counters.value[SL_COUNT_INDIRECT_SAMPLES], 0);
    sl_image_destroy(image);
    destroy_method(method, scene);
}

/* ---- limits ---- */

static bool warns_of_gloss(const char *scene_file) {
    sl_scene *scene = load_scene(scene_file);
    sl_settings settings = mesh_settings(24, 24);
    sl_image *picture = render(scene, &settings, NULL);
    const char *warning = sl_image_metadata(picture, "softlux.warning");
    bool warned = warning && strstr(warning, "% of the pixels show gloss, which reflects lamps alone");
    destroy_picture(picture, scene);
    return warned;
}

static void gloss_that_reflects_lamps_alone_is_told(void **state) {
    assert_true(warns_of_gloss("scenes/cornell-glossy.json"));
    assert_false(warns_of_gloss("scenes/cornell.json"));
}

/* ---- determinism ---- */

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cornell_box_is_lit_as_by_its_one_bounce_paths),
        cmocka_unit_test(a_sphere_cavity_is_lit_evenly_by_each_bounce),
        cmocka_unit_test(an_empty_floor_under_a_lamp_is_lit_as_lambert_says),
        cmocka_unit_test(two_lamps_together_light_as_one_and_the_other),
        cmocka_unit_test(back_in_an_old_view_no_irradiance_is_sampled_again),
        cmocka_unit_test(the_first_picture_takes_the_roots_vertices_and_the_ambient_light),
        cmocka_unit_test(gloss_that_reflects_lamps_alone_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
