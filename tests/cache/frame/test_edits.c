/* After edits pictures are those of a method that begins with the scene as it is then, whatever it was
 * before. */
#include "unit_test.h"
#include "rendering.h"

#include <stdio.h>

/* A floor with a gloss under a lamp that keyframes scale, and what else is asked for. */
static sl_scene *floor_under_lamp(const char *scale_before, const char *scale_after,
                                  const char *more_lights) {
    char json[1024];
    snprintf(json, sizeof json,
             "{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"name\": \"floor\", \"material\": "
             "\"floor\"}, {\"file\": \"mesh.obj\", \"name\": \"wall\", "
             "\"material\": \"wall\", \"transform\": {\"rotate_deg\": [90, 0, 0], \"translate\": [0, 2, "
             "-2]}}], \"materials\": {\"floor\": {\"diffuse\": 0.5, "
             "\"specular\": 0.3, \"exponent\": 10}, \"wall\": {\"diffuse\": 0.5}}, \"lights\": [{\"type\": "
             "\"quad\", \"corner\": [-0.5, 0, -0.5], \"edge1\": [1, 0, 0], "
             "\"edge2\": [0, 0, 1], \"radiance\": 5, \"keyframes\": [{\"time\": 0, \"translate\": [0, 2, 0], "
             "\"scale\": %s}, {\"time\": 1, \"translate\": [0, 2, 0], "
             "\"scale\": %s}]}%s], \"camera\": {\"eye\": [0, 3, 6], \"target\": [0, 0, 0], \"fov_deg\": 40}}",
             scale_before, scale_after, more_lights);
    return scene_from_text(json, "v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nf 1 2 3 4\n");
}

/* One picture after the other, and that of a method which begins at the end. */
static sl_comparison edited_against_fresh(sl_scene *scene, const sl_settings *settings) {
    sl_method *method = created_method(scene, settings);
    sl_image_destroy(finished_picture(method));
    go_to_time(scene, method, 1.0);
    sl_image *edited = finished_picture(method), *fresh = render(scene, settings, NULL);
    sl_comparison c = comparison_of(edited, fresh);
    destroy_pictures(edited, fresh);
    sl_method_destroy(method);
    return c;
}

static sl_settings settings_for(const char *method) {
    sl_settings settings = small_settings(method, 24, 24);
    settings.spp = 4;
    settings.light_octree.depth = 4;
    settings.light_octree.photons = 4000;
    settings.shading_cache.indirect_samples = 20;
    return settings;
}

/* So small that it has no area, and gives no light. */
static void a_lamp_that_grows_from_nothing_and_shrinks_to_it_is_lit_and_dark(void **state) {
    for (size_t i = 0; sl_method_name(i); i++) {
        for (int shrinks = 0; shrinks < 2; shrinks++) {
            sl_scene *scene = floor_under_lamp(shrinks ? "1" : "1e-30", shrinks ? "1e-30" : "1", "");
            const sl_settings settings = settings_for(sl_method_name(i));
            const sl_comparison c = edited_against_fresh(scene, &settings);
            print_message("%-16s mean %.4f, %.2f %% off a fresh one's %.4f\n", settings.method, c.mean_image,
                          100.0 * c.rel_rmse, c.mean_reference);
            assert_true(shrinks ? c.mean_reference == 0.0 && c.mean_image == 0.0
                                : c.mean_reference > 0.02 && c.rel_rmse < 0.02);
            sl_scene_destroy(scene);
        }
    }
}

/* The meshes' thresholds go by the light in the scene: that of now. Lamps that have not moved keep their
 * samples, and meshes what they were cut into. */
static void meshes_are_as_fine_as_the_light_of_now_asks_for(void **state) {
    const char *const still = ", {\"type\": \"point\", \"position\": [1, 1, 0], \"intensity\": 0.2}";
    const sl_settings settings = settings_for("multi-mesh");
    for (int both = 0; both < 2; both++) {
        sl_scene *scene = floor_under_lamp("30", "0.1", both ? still : "");
        const sl_comparison c = edited_against_fresh(scene, &settings);
        print_message("%.3f %% off\n", 100.0 * c.rel_rmse);
        assert_true(c.rel_rmse < 0.02);
        sl_scene_destroy(scene);
    }
}

static void before_its_first_sample_the_shading_cache_guesses_by_the_light_of_now(void **state) {
    sl_scene *scene = floor_under_lamp("30", "0.1", "");
    const sl_settings settings = settings_for("shading-cache");
    sl_method *method = created_method(scene, &settings);
    sl_image *bright = resolved_picture(method);
    go_to_time(scene, method, 1.0);
    sl_image *edited = resolved_picture(method);
    sl_method *other = created_method(scene, &settings);
    sl_image *fresh = resolved_picture(other);
    assert_true(same_picture(edited, fresh) && !same_picture(edited, bright));
    sl_image *pictures[] = {bright, edited, fresh};
    for (int i = 0; i < 3; i++) sl_image_destroy(pictures[i]);
    sl_method_destroy(other);
    destroy_method(method, scene);
}

/* Two rooms far from each other on a plain: where the eye is is the central region of the scene. */
static sl_scene *far_rooms(void) {
    return scene_from_text("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\", \"name\": \"all\", "
                           "\"transform\": {\"scale\": 2000, \"translate\": [0, -1, 0]}}, "
                           "{\"file\": \"mesh.obj\", \"name\": \"here\", \"transform\": {\"translate\": "
                           "[1000, 0, 0]}}, {\"file\": \"mesh.obj\", \"name\": \"there\", "
                           "\"transform\": {\"translate\": [-1000, 0, 0]}}], \"lights\": [{\"type\": "
                           "\"quad\", \"corner\": [999.5, 3.5, -0.5], \"edge1\": [1, 0, 0], "
                           "\"edge2\": [0, 0, 1], \"radiance\": 5}, {\"type\": \"quad\", \"corner\": "
                           "[-1000.5, 3.5, -0.5], \"edge1\": [1, 0, 0], \"edge2\": [0, 0, 1], "
                           "\"radiance\": 5}], \"camera\": {\"eye\": [1000, 1, 1.5], \"target\": [1000, 1, "
                           "-2], \"fov_deg\": 60}}",
                           "v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 4 -2\nv -2 4 2\nv 2 4 2\nv 2 4 "
                           "-2\nf 1 2 3 4\nf 5 8 7 6\nf 1 4 8 5\nf 2 6 7 3\nf 1 5 6 2\nf 4 3 7 8\n");
}

static void look_from(sl_scene *scene, float x, float z) {
    const float eye[3] = {x, 1, z}, target[3] = {x, 1, -2}, up[3] = {0, 1, 0};
    assert_int_equal(sl_scene_set_camera(scene, eye, target, up, 1.0f, NULL), SL_OK);
}

/* Octrees, voxels and coarse meshes were made around the room that the eye was in. */
static void an_eye_in_another_room_far_away_sees_it_as_a_new_method_would(void **state) {
    sl_scene *scene = far_rooms();
    for (size_t i = 0; sl_method_name(i); i++) {
        const sl_settings settings = settings_for(sl_method_name(i));
        look_from(scene, 1000, 1.5f);
        sl_method *method = created_method(scene, &settings);
        sl_image_destroy(finished_picture(method));
        look_from(scene, -1000, 1.5f);
        assert_int_equal(sl_method_edit(method, SL_CHANGED_CAMERA, NULL), SL_OK);
        sl_image *edited = finished_picture(method), *fresh = render(scene, &settings, NULL);
        sl_comparison c = comparison_of(edited, fresh);
        print_message("%-16s mean %.4f, %.2f %% off a fresh one's %.4f\n", settings.method, c.mean_image,
                      100.0 * c.rel_rmse, c.mean_reference);
        assert_true(c.mean_reference > 0.02 && c.rel_rmse < 0.02);
        destroy_pictures(edited, fresh);
        sl_method_destroy(method);
    }
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lamp_that_grows_from_nothing_and_shrinks_to_it_is_lit_and_dark),
        cmocka_unit_test(meshes_are_as_fine_as_the_light_of_now_asks_for),
        cmocka_unit_test(before_its_first_sample_the_shading_cache_guesses_by_the_light_of_now),
        cmocka_unit_test(an_eye_in_another_room_far_away_sees_it_as_a_new_method_would),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
