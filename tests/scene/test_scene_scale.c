/* The size in which most of a scene lies: for most scenes the diagonal, for a room on a plain without end the
 * room's. */
#include <math.h>

#include "unit_test.h"
#include "scene/ambient.h"
#include "scene/scene.h"
#include "trace_scenes.h"

/* A closed room of 4 x 3 x 5 with a lamp, seen from within. */
static void add_room(trace_mesh *mesh) {
    uint32_t white = trace_mesh_material(mesh, 0.7f, 0, 1, 0, 0),
             lamp = trace_mesh_material(mesh, 0, 0, 1, 0, 10);
    trace_mesh_box(mesh, sl_v3(-2, 0, -2.5f), sl_v3(2, 3, 2.5f), true, white);
    trace_mesh_quad(mesh, sl_v3(-0.5f, 2.9f, -0.5f), sl_v3(1, 0, 0), sl_v3(0, 0, 1), lamp);
    sl_camera_look_at(&mesh->camera, sl_v3(0, 1.5f, 2), sl_v3(0, 1, 0), sl_v3(0, 1, 0), 1.0f);
    mesh->has_camera = true;
}

static void add_plain(trace_mesh *mesh, float half) {
    trace_mesh_quad(mesh, sl_v3(-half, -5, half), sl_v3(2 * half, 0, 0), sl_v3(0, 0, -2 * half), 0);
}

static sl_scene *room_on_plain(float half) {
    trace_mesh mesh = trace_mesh_begin();
    add_room(&mesh);
    if (half > 0.0f) add_plain(&mesh, half);
    return trace_mesh_build(&mesh);
}

static void assert_same(sl_vec3 a, sl_vec3 b) { assert_true(a.x == b.x && a.y == b.y && a.z == b.z); }

static void scale_of_a_room_is_its_diagonal_and_its_core_the_box(void **state) {
    sl_scene *s = room_on_plain(0.0f);
    assert_true(s->scale == s->diagonal && !sl_scene_is_scattered(s));
    assert_same(s->central_min, s->box_min);
    assert_same(s->central_max, s->box_max);
    assert_true(sl_scene_central_diagonal(s) == s->diagonal);
    sl_scene_destroy(s);
}

static void a_plain_of_any_size_leaves_a_room_its_scale_and_core(void **state) {
    sl_scene *alone = room_on_plain(0.0f), *large = room_on_plain(4e3f), *huge = room_on_plain(4e6f);
    assert_true(sl_scene_is_scattered(large) && sl_scene_is_scattered(huge));
    assert_true(huge->diagonal > 1e7f && huge->scale < 100.0f * alone->diagonal);
    assert_true(fabs((double)(huge->scale / large->scale) - 1.0) < 1e-6);
    for (int i = 0; i < 2; i++) {
        const sl_scene *s = i ? huge : large;
        assert_same(s->central_min, alone->box_min);
        assert_same(s->central_max, alone->box_max);
        sl_rgb ambient = sl_ambient_irradiance(s), plain = sl_ambient_irradiance(alone);
        assert_true(ambient.r == plain.r && plain.r > 0.0f);
    }
    sl_scene_destroy(alone);
    sl_scene_destroy(large);
    sl_scene_destroy(huge);
}

/* From the size where the scale begins to part from the diagonal neither it nor the central region jumps. */
static void scale_and_core_shrink_without_a_jump_as_a_plain_grows(void **state) {
    double last = 0.0;
    bool parted = false;
    for (float half = 50.0f; half < 1e4f; half *= 1.02f) {
        sl_scene *s = room_on_plain(half);
        if (sl_scene_is_scattered(s) && !parted) assert_same(s->central_max, s->box_max); /* as yet */
        parted |= sl_scene_is_scattered(s);
        assert_true(last == 0.0 || (fabs((double)s->scale / last - 1.0) < 0.03));
        assert_true(s->scale <= s->diagonal);
        last = (double)s->scale;
        sl_scene_destroy(s);
    }
    assert_true(parted);
}

static void a_grain_with_most_vertices_is_not_the_scene_for_an_eye_that_sees_the_room(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    add_room(&mesh);
    trace_mesh_sphere(&mesh, sl_v3(0.7f, 0.5f, -1), 1e-4f, 12, 0.0f, false, 0);
    sl_scene *s = trace_mesh_build(&mesh);
    assert_true(s->radius < 1e-3);
    assert_true(s->scale == s->diagonal);
    sl_error error;
    const float near[3] = {0.7f, 0.5f, -0.9995f}, grain[3] = {0.7f, 0.5f, -1}, up[3] = {0, 1, 0},
                back[3] = {0, 1.5f, 2};
    assert_int_equal(sl_scene_set_camera(s, near, grain, up, 1.0f, &error), SL_OK);
    assert_true(sl_scene_is_scattered(s) && s->scale < 0.1f);
    assert_int_equal(sl_scene_set_camera(s, back, grain, up, 1.0f, &error), SL_OK);
    assert_true(s->scale == s->diagonal);
    assert_same(s->central_max, s->box_max);
    sl_scene_destroy(s);
}

/* Three things of which the room knows nothing, and which have most of the vertices. */
static sl_scene *room_below_planets(float distance, float size) {
    trace_mesh mesh = trace_mesh_begin();
    const sl_vec3 place[3] = {sl_v3(1, 0.2f, 0), sl_v3(-0.3f, 1, 0.1f), sl_v3(0.1f, 0.3f, -1)};
    add_room(&mesh);
    for (int i = 0; i < 3; i++)
        trace_mesh_sphere(&mesh, sl_scale(place[i], distance), size, 12, 0.0f, false, 0);
    return trace_mesh_build(&mesh);
}

static void far_planets_with_most_vertices_leave_a_room_its_scale_and_core(void **state) {
    const float distances[] = {1e4f, 1e6f, 1e7f};
    sl_scene *alone = room_on_plain(0.0f);
    for (int i = 0; i < 3; i++) {
        sl_scene *s = room_below_planets(distances[i], 0.1f * distances[i]);
        assert_true(s->diagonal > distances[i] && s->scale <= 128.0f * alone->diagonal);
        assert_same(s->central_min, alone->box_min);
        assert_same(s->central_max, alone->box_max);
        sl_scene_destroy(s);
    }
    sl_scene_destroy(alone);
}

/* Who flies out to them sees another scene, and so does who stands in a room that fills less of what there is
 * to see than they do. */
static void planets_that_the_eye_sees_more_of_are_the_scene(void **state) {
    sl_error error;
    const float out[3] = {8e5f, 1.6e5f, 0}, there[3] = {1e6f, 2e5f, 0}, up[3] = {0, 1, 0};
    sl_scene *s = room_below_planets(1e6f, 1e5f);
    assert_int_equal(sl_scene_set_camera(s, out, there, up, 1.0f, &error), SL_OK);
    assert_true(s->scale == s->diagonal);
    sl_scene_destroy(s);
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_sphere(&mesh, sl_v3(0, 0, 0), 1e4f, 12, 0.0f, false, 0);
    trace_mesh_sphere(&mesh, sl_v3(0, 0, 5), 0.1f, 4, 0.0f, false, 0); /* a fly before the eye */
    sl_camera_look_at(&mesh.camera, sl_v3(0, 0, 6), sl_v3(0, 0, 0), sl_v3(0, 1, 0), 1.0f);
    mesh.has_camera = true;
    s = trace_mesh_build(&mesh);
    assert_true(s->scale == s->diagonal);
    sl_scene_destroy(s);
}

/* Tolerances are never below what floats tell apart. */
static void points_far_out_leave_their_surface_by_more_than_rounding(void **state) {
    sl_scene *alone = room_on_plain(0.0f), *huge = room_on_plain(4e6f);
    const sl_vec3 inside = sl_v3(1, 1, 1), outside = sl_v3(3e6f, -5, 1e6f);
    float offset = 1e-5f * huge->scale;
    assert_true(sl_scene_offset_at(huge, offset, inside) == offset);
    float far = sl_scene_offset_at(huge, offset, outside);
    assert_true(outside.x + far > outside.x && outside.x - far < outside.x && far < 1e-5f * huge->diagonal);
    assert_true(sl_scene_offset_at(alone, 1e-5f * alone->scale, outside) == 1e-5f * alone->scale);
    assert_true(sl_scene_coordinate_near(huge, outside) >= 3e6f &&
                sl_scene_coordinate_near(huge, inside) < 2.0f * huge->scale);
    assert_true(sl_scene_coordinate_near(alone, inside) == 3.0f);
    sl_scene_destroy(alone);
    sl_scene_destroy(huge);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scale_of_a_room_is_its_diagonal_and_its_core_the_box),
        cmocka_unit_test(a_plain_of_any_size_leaves_a_room_its_scale_and_core),
        cmocka_unit_test(scale_and_core_shrink_without_a_jump_as_a_plain_grows),
        cmocka_unit_test(a_grain_with_most_vertices_is_not_the_scene_for_an_eye_that_sees_the_room),
        cmocka_unit_test(far_planets_with_most_vertices_leave_a_room_its_scale_and_core),
        cmocka_unit_test(planets_that_the_eye_sees_more_of_are_the_scene),
        cmocka_unit_test(points_far_out_leave_their_surface_by_more_than_rounding),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
