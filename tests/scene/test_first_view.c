/* The view of a scene without a camera, without light, or without a word on which axis is up. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "scene/features.h"
#include "scene/scene.h"
#include "rendering.h"
#include "scene_files.h"

/* ---- boxes as OBJ text: vertices 1 to 8, x fastest, then y, then z ------------------------------------- */
#define SIDES                                                                                                \
    "f 1 5 7 3\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n" /* left, below, above, back, front: fronts     \
                                                                 outwards */
#define SIDES_INWARDS "f 3 7 5 1\nf 5 6 2 1\nf 4 8 7 3\nf 2 4 3 1\nf 7 8 6 5\n"
#define RIGHT "f 2 4 8 6\n"
#define RIGHT_INWARDS "f 6 8 4 2\n"

#define ROOM "v 0 0 0\nv 4 0 0\nv 0 3 0\nv 4 3 0\nv 0 0 6\nv 4 0 6\nv 0 3 6\nv 4 3 6\n"
/* Eight vertices more, so numbers count back. */
#define WALLS_AROUND                                                                                         \
    "v -1 -1 -1\nv 5 -1 -1\nv -1 4 -1\nv 5 4 -1\nv -1 -1 7\nv 5 -1 7\nv -1 4 7\nv 5 4 7\n"                   \
    "f -8 -4 -2 -6\nf -8 -7 -3 -4\nf -6 -2 -1 -5\nf -8 -6 -5 -7\nf -4 -3 -1 -2\nf -7 -5 -1 -3\n"
#define LAMP "v 1 2.5 2\nv 3 2.5 2\nv 1 2.5 4\nusemtl lamp\nf -3 -2 -1\n"
static const char lamp_library[] = "newmtl lamp\nKd 0\nKe 5\n";

static sl_scene *load_with(const char *path, const sl_load_options *options) {
    sl_scene *scene;
    sl_error error = {0};
    if (sl_scene_load_with(path, options, &scene, &error) != SL_OK) fail_msg("%s", error.message);
    return scene;
}
static sl_scene *load(const char *path) { return load_with(path, &(sl_load_options){0}); }
static sl_scene *obj(const char *text) { return load(scene_file_text("first.obj", text)); }

static bool is_within(sl_vec3 p, sl_vec3 low, sl_vec3 high) {
    return p.x > low.x && p.y > low.y && p.z > low.z && p.x < high.x && p.y < high.y && p.z < high.z;
}
static const sl_vec3 room_low = {0, 0, 0}, room_high = {4, 3, 6};

/* ---- the camera ---------------------------------------------------------------------------------------- */

static void a_solid_is_framed_from_outside_at_an_angle_under_sun_and_sky(void **state) {
    sl_scene *s = obj(ROOM SIDES RIGHT);
    sl_vec3 back = s->camera.back;
    assert_true(back.x > 0.3f && back.y > 0.3f && back.z > 0.3f &&
                !is_within(s->camera.eye, s->box_min, s->box_max));
    assert_int_equal(s->light_count, 1);
    assert_int_equal(s->lights[0].type, SL_LIGHT_DIRECTIONAL);
    assert_true(s->environment.present && s->environment.constant.r < 0.2f * s->lights[0].intensity.r);
    assert_true(scene_warns_of(s, "framed from outside") && scene_warns_of(s, "a sun") &&
                scene_warns_of(s, "a sky"));
    sl_scene_destroy(s);
}

static void a_closed_room_is_seen_from_inside_in_the_light_of_a_lamp(void **state) {
    sl_scene *s = obj(ROOM SIDES_INWARDS RIGHT_INWARDS);
    assert_true(is_within(s->camera.eye, room_low, room_high));
    assert_true(fabsf(s->camera.back.z) > 0.7f); /* along the room's length */
    assert_int_equal(s->light_count, 1);
    assert_int_equal(s->lights[0].type, SL_LIGHT_POINT);
    assert_true(is_within(s->lights[0].position, room_low, room_high) && s->lights[0].position.y > 1.6f);
    assert_false(s->environment.present);
    assert_true(scene_warns_of(s, "put into the room") && scene_warns_of(s, "a lamp is added"));
    sl_scene_destroy(s);
}

static void a_room_without_one_side_is_seen_through_it(void **state) {
    sl_scene *s = obj(ROOM SIDES_INWARDS);
    assert_true(s->camera.eye.x > 4.0f && s->camera.back.x > 0.9f);
    assert_int_equal(s->lights[0].type, SL_LIGHT_DIRECTIONAL);
    sl_scene_destroy(s);
}

static void lamps_that_are_all_shut_in_are_looked_for_inside(void **state) {
    scene_file_text("lamp.mtl", lamp_library);
    sl_scene *s = obj("mtllib lamp.mtl\n" ROOM SIDES_INWARDS RIGHT_INWARDS WALLS_AROUND LAMP);
    assert_true(is_within(s->camera.eye, room_low, room_high));
    assert_int_equal(s->light_count, 0);
    assert_false(s->environment.present);
    sl_scene_destroy(s);
    s = obj(ROOM SIDES_INWARDS RIGHT_INWARDS WALLS_AROUND); /* without, it is a block of stone */
    assert_false(is_within(s->camera.eye, s->box_min, s->box_max));
    sl_scene_destroy(s);
}

static void a_room_whose_outside_is_blank_is_seen_from_inside(void **state) {
    scene_file_text("four.mtl", "newmtl a\nKd 0.1\nnewmtl b\nKd 0.2\nnewmtl c\nKd 0.3\n");
    sl_scene *s = obj(
        "mtllib four.mtl\n" ROOM
        "usemtl a\nf 3 7 5 1\nf 5 6 2 1\nusemtl b\nf 4 8 7 3\nf 2 4 3 1\nusemtl c\nf 7 8 6 5\n" RIGHT_INWARDS
        "usemtl a\n" WALLS_AROUND);
    assert_true(is_within(s->camera.eye, room_low, room_high));
    sl_scene_destroy(s);
}

static void what_has_its_lamps_in_a_solid_is_lit_from_outside(void **state) {
    scene_file_text("lamp.mtl", lamp_library);
    sl_scene *s = obj("mtllib lamp.mtl\n" ROOM SIDES RIGHT LAMP);
    assert_false(is_within(s->camera.eye, s->box_min, s->box_max));
    assert_true(s->emitter_count == 1 && s->light_count == 1 && s->environment.present);
    assert_true(scene_warns_of(s, "no light but behind walls: a sun"));
    sl_scene_destroy(s);
}

/* ---- the light ----------------------------------------------------------------------------------------- */

static void the_sun_stands_to_the_left_behind_the_camera_wherever_that_looks(void **state) {
    static const char *const targets[] = {"0,1,0", "99,1,0", "-3,-40,70", "0.001,-90,30"};
    char json[300];
    scene_file_text("first.obj", ROOM SIDES RIGHT);
    for (size_t i = 0; i < sizeof targets / sizeof *targets; i++) {
        snprintf(json, sizeof json,
                 "{\"softlux\": 1, \"meshes\": [{\"file\": \"first.obj\"}], \"camera\": {\"eye\": [0,1,30], "
                 "\"target\": [%s]}}",
                 targets[i]);
        sl_scene *s = load(scene_file_text("first.json", json));
        sl_vec3 sun = s->lights[0].direction, behind = sl_v3(-s->camera.right.z, 0.0f, s->camera.right.x);
        assert_true(fabsf(sl_length(sun) - 1.0f) < 1e-6f && sun.y < -0.5f);
        assert_true(sl_dot(sun, s->camera.right) > 0.3f && sl_dot(sun, behind) < -0.3f);
        sl_scene_destroy(s);
    }
}

static void a_camera_that_stands_in_a_dark_room_gets_a_lamp_there(void **state) {
    static const char json[] = "{\"softlux\": 1, \"meshes\": [{\"file\": \"first.obj\"}], \"camera\": "
                               "{\"eye\": [1,1,1], \"target\": [3,1,5]}}";
    scene_file_text("first.obj", ROOM SIDES_INWARDS RIGHT_INWARDS WALLS_AROUND);
    sl_scene *s = load(scene_file_text("first.json", json));
    assert_true(s->light_count == 1 && s->lights[0].type == SL_LIGHT_POINT && !s->environment.present);
    assert_true(is_within(s->lights[0].position, room_low, room_high));
    sl_scene_destroy(s);
    scene_file_text(
        "first.obj", ROOM SIDES_INWARDS
        "v 4 1 2\nv 4 1 4\nv 4 3 2\nv 4 3 4\nf 6 10 9 2\nf 2 9 11 4\nf 6 8 12 10\nf 4 11 12 8\n"); /* a window
                                                                                                      to the
                                                                                                      right */
    s = load(scene_file_text("first.json", json));
    assert_true(s->light_count == 2 && s->lights[0].type == SL_LIGHT_POINT &&
                s->lights[1].type == SL_LIGHT_DIRECTIONAL && s->environment.present);
    sl_scene_destroy(s);
}

/* ---- which axis is up ---------------------------------------------------------------------------------- */

#define SPIRE_ON_Z                                                                                           \
    "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 3\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"

static void a_mesh_file_is_turned_where_one_asks_for_it(void **state) {
    sl_scene *s = load(scene_file_text("spire.obj", SPIRE_ON_Z));
    assert_true(s->box_max.z == 3.0f && s->box_min.z == 0.0f);
    sl_scene_destroy(s);
    s = load_with(scene_file_path("spire.obj"), &(sl_load_options){.up_axis = SL_UP_Z});
    assert_true(s->box_max.y == 3.0f && s->box_min.y == 0.0f);
    assert_true(s->geometric_normal_y[0] == -1.0f && s->normal_y[s->vertex[0][0]] == -1.0f);
    sl_scene_destroy(s);
    scene_file_text("first.json", "{\"softlux\": 1, \"meshes\": [{\"file\": \"spire.obj\"}]}");
    sl_error error; /* a scene file says "up", or y is */
    assert_int_equal(
        sl_scene_load_with(scene_file_path("first.json"), &(sl_load_options){.up_axis = SL_UP_Z}, &s, &error),
        SL_ERROR_USAGE);
    assert_non_null(strstr(error.message, "\"up\""));
}

/* ---- a viewpoint of the caller's ----------------------------------------------------------------------- */

static void a_viewpoint_takes_the_place_of_the_files_camera_and_its_keyframes(void **state) {
    static const char json[] =
        "{\"softlux\": 1, \"meshes\": [{\"file\": \"first.obj\"}], \"camera\": {\"eye\": [0,1,30], "
        "\"target\": [0,1,0], \"fov_deg\": 30,\n"
        "\"keyframes\": [{\"time\": 0, \"eye\": [0,1,30]}, {\"time\": 1, \"eye\": [0,1,60]}]}}";
    scene_file_text("first.obj", ROOM SIDES RIGHT);
    const char *path = scene_file_text("first.json", json);
    const sl_viewpoint whole = {true, true, true, true, {9, 2, 0}, {8, 2, 0}, {0, 0, 2}, 1.0f, {0}},
                       eye = {.has_eye = true, .eye = {2, 1.5f, 40}},
                       fov = {.has_fov = true, .vertical_fov_rad = 0.25f};
    sl_scene *s = load_with(path, &(sl_load_options){.view = &whole});
    assert_true(s->camera.eye.x == 9.0f && s->camera.back.x == 1.0f && s->camera.up.z == 1.0f &&
                s->camera.vertical_fov == 1.0f);
    assert_int_equal(sl_scene_set_time(s, 1.0, NULL, NULL), SL_OK);
    assert_true(s->camera.eye.x == 9.0f);
    sl_scene_destroy(s);
    s = load_with(path, &(sl_load_options){.view = &eye}); /* towards the middle of the box */
    assert_true(s->camera.eye.z == 40.0f && s->camera.back.z == 1.0f &&
                fabsf(s->camera.vertical_fov - 0.5235988f) < 1e-6f);
    sl_scene_destroy(s);
    s = load_with(path, &(sl_load_options){.view = &fov});
    assert_true(s->camera.eye.z == 30.0f && s->camera.back.z == 1.0f && s->camera.vertical_fov == 0.25f);
    sl_scene_destroy(s);
}

static void a_viewpoint_that_shows_nothing_is_refused(void **state) {
    const sl_viewpoint bad[] = {{.has_eye = true, .has_target = true, .eye = {1, 2, 3}, .target = {1, 2, 3}},
                                {.has_fov = true, .vertical_fov_rad = 4.0f},
                                {.has_eye = true, .eye = {NAN, 0, 0}},
                                {.has_eye = true,
                                 .has_target = true,
                                 .has_up = true,
                                 .eye = {1, 2, 3},
                                 .target = {1, 2, 4},
                                 .up = {0, 0, 1}}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        sl_scene *s = NULL;
        assert_int_equal(sl_scene_load_with(scene_file_text("first.obj", ROOM SIDES RIGHT),
                                            &(sl_load_options){.view = &bad[i]}, &s, NULL),
                         SL_ERROR_USAGE);
        assert_null(s);
    }
}

static void a_lamp_is_put_where_the_viewpoint_stands_in_the_dark(void **state) {
    const sl_viewpoint inside = {.has_eye = true, .eye = {1, 1, 1}},
                       outside = {.has_eye = true, .eye = {9, 9, 9}};
    const char *path = scene_file_text("first.obj", ROOM SIDES_INWARDS RIGHT_INWARDS WALLS_AROUND);
    sl_scene *s = load_with(path, &(sl_load_options){.view = &inside});
    assert_true(s->lights[0].type == SL_LIGHT_POINT && !s->environment.present &&
                !scene_warns_of(s, "no camera"));
    sl_scene_destroy(s);
    s = load_with(path, &(sl_load_options){.view = &outside});
    assert_true(s->lights[0].type == SL_LIGHT_DIRECTIONAL && s->environment.present);
    assert_true(sl_scene_is_in_view(s));
    const float eye[3] = {9, 9, 9}, away[3] = {20, 20, 20}, up[3] = {0, 1, 0};
    assert_int_equal(sl_scene_set_camera(s, eye, away, up, 1.0f, NULL), SL_OK);
    assert_false(sl_scene_is_in_view(s));
    sl_scene_destroy(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_solid_is_framed_from_outside_at_an_angle_under_sun_and_sky),
        cmocka_unit_test(a_closed_room_is_seen_from_inside_in_the_light_of_a_lamp),
        cmocka_unit_test(a_room_without_one_side_is_seen_through_it),
        cmocka_unit_test(lamps_that_are_all_shut_in_are_looked_for_inside),
        cmocka_unit_test(a_room_whose_outside_is_blank_is_seen_from_inside),
        cmocka_unit_test(what_has_its_lamps_in_a_solid_is_lit_from_outside),
        cmocka_unit_test(the_sun_stands_to_the_left_behind_the_camera_wherever_that_looks),
        cmocka_unit_test(a_camera_that_stands_in_a_dark_room_gets_a_lamp_there),
        cmocka_unit_test(a_mesh_file_is_turned_where_one_asks_for_it),
        cmocka_unit_test(a_viewpoint_takes_the_place_of_the_files_camera_and_its_keyframes),
        cmocka_unit_test(a_viewpoint_that_shows_nothing_is_refused),
        cmocka_unit_test(a_lamp_is_put_where_the_viewpoint_stands_in_the_dark),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
