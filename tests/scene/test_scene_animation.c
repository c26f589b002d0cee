/* Keyframes: states between and beyond the keys, what is reported as changed, and that a state depends on the
 * time alone. */
#include <math.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "scene/animation.h"
#include "rendering.h"
#include "scene_files.h"
#include "softlux.h"

static const char triangle_obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nusemtl plain\nf 1//1 2//1 3//1\n";

static sl_scene *load(const char *json) {
    scene_file_text("triangle.obj", triangle_obj);
    return load_scene(scene_file_text("scene.json", json));
}

static unsigned at(sl_scene *scene, double time) {
    unsigned changes = 99;
    assert_int_equal(sl_scene_set_time(scene, time, &changes, NULL), SL_OK);
    return changes;
}

static bool near(float a, double b) { return fabs((double)a - b) < 1e-5; }

static void quaternions_turn_about_the_axes_in_order(void **state) {
    /* about x: y becomes z; then about z: x becomes y */
    sl_quaternion q = sl_quaternion_from_euler(0.5 * SL_PI, 0, 0.5 * SL_PI);
    sl_affine a = sl_key_placement(&(sl_key){.scale = {1, 1, 1}, .rotate = q});
    sl_vec3d x = sl_affine_vector(&a, sl_v3d(1, 0, 0)), y = sl_affine_vector(&a, sl_v3d(0, 1, 0));
    assert_true(fabs(x.y - 1.0) < 1e-12 && fabs(y.z - 1.0) < 1e-12);
}

static void slerp_turns_at_constant_speed_along_the_shorter_arc(void **state) {
    sl_quaternion a = sl_quaternion_from_euler(0, 0, 0), b = sl_quaternion_from_euler(0, 1.2, 0);
    sl_quaternion minus_b = {-b.w, -b.x, -b.y, -b.z};
    for (int i = 0; i <= 8; i++) {
        sl_quaternion q = sl_quaternion_slerp(a, b, i / 8.0),
                      other = sl_quaternion_slerp(a, minus_b, i / 8.0);
        assert_true(fabs(q.y - sin(0.6 * i / 8.0)) < 1e-12 && fabs(q.w - cos(0.6 * i / 8.0)) < 1e-12);
        assert_true(fabs(q.y - other.y) < 1e-12);
    }
    sl_quaternion same = sl_quaternion_slerp(b, b, 0.3); /* no arc at all */
    assert_true(fabs(same.y - b.y) < 1e-12 && fabs(same.w - b.w) < 1e-12);
}

static const char moving[] =
    "{\"softlux\": 1,\n"
    " \"meshes\": [{\"file\": \"triangle.obj\", \"name\": \"still\"},\n"
    "   {\"file\": \"triangle.obj\", \"name\": \"mover\", \"transform\": {\"translate\": [0, 0, 5]}, "
    "\"keyframes\": [\n"
    "     {\"time\": 1, \"translate\": [0, 0, 0]}, {\"time\": 3, \"translate\": [4, 0, 0], \"rotate_deg\": "
    "[0, 90, 0]}]}],\n"
    " \"lights\": [{\"type\": \"point\", \"position\": [0, 9, 0], \"intensity\": 1}],\n"
    " \"camera\": {\"eye\": [0, 0, 20], \"target\": [0, 0, 0]}}";

static void objects_move_between_keys_and_rest_beyond_them(void **state) {
    sl_scene *s = load(moving);
    uint32_t mover = s->vertex[0][1];
    assert_int_equal(s->version, 0);
    assert_true(s->position_z[mover] == 5.0f);
    assert_int_equal(at(s, 0.5), 0); /* before the first key nothing changes */
    assert_int_equal(at(s, 2.0), SL_CHANGED_OBJECTS);
    assert_int_equal(s->version, 1);
    /* half way: turned by 45 degrees about y, then moved by 2 */
    assert_true(near(s->position_x[mover], 2.0 + 5.0 * sqrt(0.5)) &&
                near(s->position_z[mover], 5.0 * sqrt(0.5)));
    assert_true(near(s->normal_x[mover], sqrt(0.5)) && near(s->geometric_normal_x[1], sqrt(0.5)));
    /* the other one rests */
    assert_true(s->geometric_normal_z[0] == 1.0f && s->position_x[s->vertex[0][0]] == 0.0f);
    at(s, 3.0);
    assert_true(near(s->position_x[mover], 9.0) && near(s->position_z[mover], 0.0) &&
                near(s->box_max.x, 9.0));
    assert_int_equal(at(s, 100.0), 0);
    sl_scene_destroy(s);
}

static void lights_and_camera_move_and_are_reported_by_kind(void **state) {
    sl_scene *s =
        load("{\"softlux\": 1, \"meshes\": [{\"file\": \"triangle.obj\"}],\n"
             " \"lights\": [{\"type\": \"point\", \"position\": [0, 0, 0], \"power\": 1, \"keyframes\": "
             "[{\"time\": 0}, {\"time\": 2, \"position\": [2, 4, 6]}]},\n"
             "  {\"type\": \"spot\", \"position\": [0, 0, 0], \"direction\": [1, 0, 0], \"outer_deg\": 30, "
             "\"intensity\": 1,\n"
             "   \"keyframes\": [{\"time\": 0}, {\"time\": 2, \"direction\": [0, 0, 3]}]}],\n"
             " \"camera\": {\"eye\": [0, 0, 20], \"target\": [0, 0, 0], \"fov_deg\": 40, \"keyframes\": "
             "[{\"time\": 5}, {\"time\": 6, \"eye\": [0, 0, 10], \"fov_deg\": 60}]}}");
    assert_int_equal(at(s, 1.0), SL_CHANGED_LIGHTS);
    assert_true(s->lights[0].position.x == 1.0f && s->lights[0].position.y == 2.0f &&
                s->lights[0].position.z == 3.0f);
    assert_true(near(s->lights[1].direction.x, sqrt(0.5)) && near(s->lights[1].direction.z, sqrt(0.5)));
    assert_int_equal(at(s, 5.5), SL_CHANGED_LIGHTS | SL_CHANGED_CAMERA);
    assert_true(s->camera.eye.z == 15.0f && near(s->camera.vertical_fov, 50.0 * SL_PI / 180.0));
    assert_int_equal(at(s, 6.0), SL_CHANGED_CAMERA);
    sl_scene_destroy(s);
}

static void moving_emitters_count_as_lights_and_keep_their_area(void **state) {
    sl_scene *s =
        load("{\"softlux\": 1, \"meshes\": [{\"file\": \"triangle.obj\"}],\n"
             " \"lights\": [{\"type\": \"quad\", \"corner\": [0, 2, 0], \"edge1\": [1, 0, 0], \"edge2\": [0, "
             "0, 2], \"radiance\": 5,\n"
             "   \"keyframes\": [{\"time\": 0}, {\"time\": 1, \"translate\": [0, 3, 0], \"scale\": 2}]}]}");
    assert_int_equal(s->emitter_count, 2);
    assert_true(near(s->emitters[0].area, 1.0));
    assert_int_equal(at(s, 1.0), SL_CHANGED_OBJECTS | SL_CHANGED_LIGHTS);
    assert_true(near(s->emitters[0].area, 4.0) && near(s->box_max.y, 7.0));
    sl_scene_destroy(s);
}

static void transform(sl_scene *scene, const double columns[16]) {
    sl_scene_edit *e;
    assert_int_equal(sl_scene_edit_begin(scene, &e, NULL), SL_OK);
    assert_int_equal(sl_edit_transform(e, 2, columns, NULL), SL_OK);
    assert_int_equal(sl_scene_edit_commit(e, NULL, NULL), SL_OK);
}

static void an_object_that_was_placed_is_given_back_to_its_keyframes(void **state) {
    const double aside[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 7, 0, 1};
    bool keyed;
    sl_scene *s = load(moving), *plain = load(moving);
    at(s, 1.0);
    transform(s, aside);
    assert_int_equal(at(s, 2.0), 0);
    assert_true(sl_animation_placement(s, 1, &keyed).m[1][3] == 7.0 && !keyed);
    transform(s, NULL);
    at(plain, 2.0);
    assert_true(sl_scene_hash(s) == sl_scene_hash(plain));
    assert_true(sl_animation_placement(s, 1, &keyed).m[0][3] == 2.0 && keyed);
    at(s, 3.0), at(plain, 3.0);
    assert_true(sl_scene_hash(s) == sl_scene_hash(plain));
    sl_scene_destroy(s);
    sl_scene_destroy(plain);
}

static void a_z_up_scene_moves_as_its_y_up_twin(void **state) {
    sl_scene *z =
        load("{\"softlux\": 1, \"up\": \"z\", \"meshes\": [{\"file\": \"triangle.obj\", \"keyframes\": [\n"
             " {\"time\": 0}, {\"time\": 1, \"translate\": [1, 2, 3], \"rotate_deg\": [0, 0, 90]}]}]}");
    at(z, 1.0);
    /* vertex (1,0,0): turned about z to (0,1,0), moved to (1,3,3); z up to y up: (x, z, -y) */
    uint32_t v = z->vertex[1][0];
    assert_true(near(z->position_x[v], 1.0) && near(z->position_y[v], 3.0) && near(z->position_z[v], -3.0));
    assert_true(near(z->geometric_normal_y[0], 1.0));
    sl_scene_destroy(z);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quaternions_turn_about_the_axes_in_order),
        cmocka_unit_test(slerp_turns_at_constant_speed_along_the_shorter_arc),
        cmocka_unit_test(objects_move_between_keys_and_rest_beyond_them),
        cmocka_unit_test(lights_and_camera_move_and_are_reported_by_kind),
        cmocka_unit_test(moving_emitters_count_as_lights_and_keep_their_area),
        cmocka_unit_test(an_object_that_was_placed_is_given_back_to_its_keyframes),
        cmocka_unit_test(a_z_up_scene_moves_as_its_y_up_twin),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
