/* Whole frames of direct radiance mapping: what is computed for every frame, what is not, and how its layers
 * add up. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "matched.h"
#include "rendering.h"
#include "scene/scene.h"

static sl_settings radiance_settings(int size) {
    sl_settings s = small_settings("direct-radiance", size, size);
    return s;
}

/* layer: "" or what ends in a point. */
static double mean_of(const sl_image *image, const char *layer) {
    double sum = 0.0;
    for (int c = 0; c < 3; c++) {
        char name[SL_CHANNEL_NAME_MAX];
        snprintf(name, sizeof name, "%s%c", layer, "RGB"[c]);
        sum += channel_mean(image, name) / 3.0;
    }
    return sum;
}

static sl_image *next_frame(sl_method *method, unsigned changes) {
    sl_progress progress;
    sl_error error;
    if (changes) good(sl_method_edit(method, changes, &error), &error);
    good(sl_method_update(method, &progress, &error), &error);
    assert_true(progress.done && progress.frame_done);
    return resolved_picture(method);
}

/* ---- layers ---- */

static void the_picture_is_emission_and_direct_and_indirect_light(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = radiance_settings(48);
    sl_image *image = render(scene, &settings, NULL);
    const char *const layers[] = {"emission.G", "direct.G", "indirect.G"};
    assert_sound_picture(image, "the Cornell box");
    for (size_t i = 0; i < 48 * 48; i++) {
        float sum = 0.0f;
        for (int k = 0; k < 3; k++) sum += sl_image_channel(image, layers[k])[i];
        assert_true(sl_image_channel(image, "G")[i] == sum);
    }
    for (int k = 0; k < 3; k++)
        assert_true(mean_of(image, k == 0 ? "emission." : k == 1 ? "direct." : "indirect.") > 0.0);
    destroy_picture(image, scene);
}

/* R, G and B are the same without the layers; and a picture may be resolved again, for nothing. */
static void a_picture_without_layers_is_the_same_picture(void **state) {
    sl_scene *scene = load_scene("scenes/cornell-mirror.json");
    sl_settings settings = radiance_settings(50), bare;
    bare = settings;
    bare.radiance_map.without_layers = true;
    sl_image *all = render(scene, &settings, NULL);
    sl_method *method = created_method(scene, &bare);
    sl_image *first = next_frame(method, 0);
    const sl_counters counters = *sl_method_counters(method);
    sl_image *again = resolved_picture(method);
    assert_memory_equal(&counters, sl_method_counters(method), sizeof counters);
    assert_int_equal(first->channels, 3);
    assert_true(all->channels > 3 && same_picture(first, again));
    for (int c = 0; c < 3; c++) {
        static const char *const names[] = {"R", "G", "B"};
        assert_memory_equal(sl_image_channel(first, names[c]), sl_image_channel(all, names[c]),
                            50 * 50 * sizeof(float));
    }
    destroy_pictures(first, again);
    sl_method_destroy(method);
    destroy_picture(all, scene);
}

/* ---- lights ---- */

static const char two_lights[] =
    "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"lights\": [%s%s%s],"
    " \"camera\": {\"eye\": [0, 1, 4], \"target\": [0, 0.8, 0], \"fov_deg\": 50}}";
static const char step_obj[] =
    "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nv -2 3 -2\nv 2 3 -2\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    "f 1 4 3 2\nf 1 2 6 5\nf 7 8 9 10\n";

static sl_scene *lit_by(bool first, bool second) {
    char json[1024];
    snprintf(json, sizeof json, two_lights,
             first ? "{\"type\": \"point\", \"position\": [-1, 2, 1], \"intensity\": [3, 2, 1]}" : "",
             first && second ? "," : "",
             second ? "{\"type\": \"spot\", \"position\": [1.5, 2.5, 1], \"direction\": [-1, -1, -1], "
                      "\"intensity\": [1, 2, 3], \"outer_deg\": 40}"
                    : "");
    return scene_from_text(json, step_obj);
}

static void the_light_of_two_lights_is_the_sum_of_each(void **state) {
    sl_settings settings = radiance_settings(32);
    sl_image *image[3];
    for (int k = 0; k < 3; k++) {
        sl_scene *scene = lit_by(k != 1, k != 0);
        image[k] = render(scene, &settings, NULL);
        sl_scene_destroy(scene);
    }
    for (size_t i = 0; i < 3 * 32 * 32; i++) {
        float sum = image[0]->planes[i] + image[1]->planes[i];
        assert_true(fabsf(image[2]->planes[i] - sum) <= 1e-5f * (1.0f + sum));
    }
    for (int k = 0; k < 3; k++) sl_image_destroy(image[k]);
}

/* ---- every frame anew ---- */

static void frame_k_alone_is_frame_k_of_the_series(void **state) {
    const char *const scenes[] = {"scenes/moving-light.json", "scenes/moving-ball.json"};
    for (int k = 0; k < 2; k++) {
        sl_scene *scene = load_scene(scenes[k]);
        sl_settings settings = radiance_settings(32);
        sl_method *method = created_method(scene, &settings);
        sl_image *series = next_frame(method, 0);
        for (int frame = 1; frame <= 3; frame++) {
            unsigned changes;
            sl_image_destroy(series);
            assert_int_equal(sl_scene_set_time(scene, 0.7 * frame, &changes, NULL), SL_OK);
            assert_true(changes & (SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS));
            series = next_frame(method, changes);
        }
        sl_image *alone = render(scene, &settings, NULL);
        assert_true(same_picture(series, alone));
        destroy_pictures(alone, series);
        destroy_method(method, scene);
    }
}

static void a_new_camera_keeps_what_the_lights_see(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = radiance_settings(32);
    sl_method *method = created_method(scene, &settings);
    sl_image_destroy(next_frame(method, 0));
    uint64_t passes = count_of(method, SL_COUNT_RASTER_PASSES),
             photons = count_of(method, SL_COUNT_MAP_PHOTONS);
    assert_true(photons > 0);
    const float eye[3] = {200.0f, 300.0f, -700.0f}, target[3] = {278.0f, 250.0f, 280.0f},
                up[3] = {0.0f, 1.0f, 0.0f};
    assert_int_equal(sl_scene_set_camera(scene, eye, target, up, 0.7f, NULL), SL_OK);
    sl_image_destroy(next_frame(method, SL_CHANGED_CAMERA));
    assert_int_equal(count_of(method, SL_COUNT_RASTER_PASSES), passes + 1);
    assert_int_equal(count_of(method, SL_COUNT_MAP_PHOTONS), photons);
    sl_image_destroy(next_frame(method, SL_CHANGED_LIGHTS));
    assert_int_equal(count_of(method, SL_COUNT_MAP_PHOTONS), 2 * photons);
    destroy_method(method, scene);
}

/* ---- only what is needed ---- */

static sl_counters cost_of(const char *json, const char *obj) {
    sl_scene *scene = scene_from_text(json, obj);
    sl_settings settings = radiance_settings(16);
    sl_counters counters;
    destroy_picture(render(scene, &settings, &counters), scene);
    return counters;
}

static void without_light_there_is_one_pass(void **state) {
    sl_counters c = cost_of(
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}], \"environment\": {\"radiance\": [1, 1, 1]},"
        " \"camera\": {\"eye\": [0, 1, 4], \"target\": [0, 1, 0], \"fov_deg\": 60}}",
        step_obj);
    assert_int_equal(c.value[SL_COUNT_RASTER_PASSES], 1);
    assert_int_equal(c.value[SL_COUNT_MAP_PHOTONS], 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_picture_is_emission_and_direct_and_indirect_light),
        cmocka_unit_test(a_picture_without_layers_is_the_same_picture),
        cmocka_unit_test(the_light_of_two_lights_is_the_sum_of_each),
        cmocka_unit_test(frame_k_alone_is_frame_k_of_the_series),
        cmocka_unit_test(a_new_camera_keeps_what_the_lights_see),
        cmocka_unit_test(without_light_there_is_one_pass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
