/* A scene after any series of edits is the scene that is built as it stands then. */
#include <math.h>
#include <string.h>

#include "unit_test.h"
#include "edited_room.h"
#include "failing_memory.h"
#include "rendering.h"
#include "scene/scene.h"

/* It holds no more than that, but for the names of objects that are taken away. */
static void is_as_built(const sl_scene *scene, const edited_room *r) {
    sl_error error;
    sl_scene *fresh;
    const long held = blocks_held;
    good(build_room(r, &fresh, &error), &error);
    assert_true(sl_scene_hash(scene) == sl_scene_hash(fresh));
    const long gone = (long)scene->object_count - (long)fresh->object_count;
    assert_in_range(held, 1, blocks_held - held + gone);
    sl_scene_destroy(fresh);
}

typedef struct attempted {
    sl_scene *scene;
    edited_room before, after;
    int edits;
    uint64_t hash, version;
} attempted;

static sl_status edit_once(void *context) {
    attempted *a = context;
    sl_scene_edit *e;
    a->after = a->before;
    sl_status status = begin_room_edit(&a->after, a->scene, &e, NULL);
    for (int i = 0; i < a->edits && status == SL_OK; i++)
        status = edit_room(&a->after, a->scene, (room_edit)(ALL_ROOM_EDITS * room_random(&a->after)), e, NULL);
    if (status == SL_OK) return sl_scene_edit_commit(e, NULL, NULL);
    sl_scene_edit_destroy(e);
    return status;
}

static void nothing_has_changed(void *context) {
    const attempted *a = context;
    assert_true(sl_scene_hash(a->scene) == a->hash && a->scene->version == a->version);
}

static void after_any_series_of_edits_the_scene_is_one_that_is_built_so(void **state) {
    sl_error error;
    attempted a = {.before = room_at_first(7)};
    long failures = 0;
    good(build_room(&a.before, &a.scene, &error), &error);
    for (int step = 0; step < 200; step++) {
        a.edits = 1 + step % 3;
        a.hash = sl_scene_hash(a.scene);
        a.version = a.scene->version;
        if (step % 4 == 0) failures += until_it_succeeds(edit_once, &a, false, nothing_has_changed);
        else good(edit_once(&a), &error);
        a.before = a.after;
        is_as_built(a.scene, &a.after);
    }
    print_message("%ld failed allocations\n", failures);
    assert_true(failures > 100);
    sl_scene_destroy(a.scene);
    assert_int_equal(blocks_held, 0);
}

static void what_has_changed_is_told_by_its_kind(void **state) {
    static const unsigned changes[ROOM_EDITS] = {
        SL_CHANGED_MATERIALS, SL_CHANGED_KINDS | SL_CHANGED_MATERIALS, SL_CHANGED_POWER, SL_CHANGED_POWER,
        SL_CHANGED_LIGHTS,    SL_CHANGED_SKY, SL_CHANGED_CAMERA,
        SL_CHANGED_OBJECTS};
    sl_error error;
    sl_scene *scene;
    sl_scene_edit *e;
    edited_room r = room_at_first(3);
    r.material[MATERIAL_BOX - 1].exponent = 10.0f;
    good(build_room(&r, &scene, &error), &error);
    for (int kind = 0; kind < ROOM_EDITS; kind++) {
        const uint64_t version = scene->version;
        unsigned told;
        r.random = 2; /* which lights a light, and not none */
        good(sl_scene_edit_begin(scene, &e, &error), &error);
        good(edit_room(&r, scene, (room_edit)kind, e, &error), &error);
        good(sl_scene_edit_commit(e, &told, &error), &error);
        assert_int_equal(told, changes[kind]);
        assert_int_equal(sl_scene_changes_since(scene, version), told);
        assert_int_equal(sl_scene_changes_since(scene, scene->version), 0);
        good(sl_scene_edit_begin(scene, &e, &error), &error); /* the same again */
        r.random = 2;
        good(edit_room(&r, scene, (room_edit)kind, e, &error), &error);
        good(sl_scene_edit_commit(e, &told, &error), &error);
        assert_int_equal(told, 0);
    }
    sl_scene_destroy(scene);
}

#define REFUSED(call, status_, words)                           \
    do {                                                        \
        sl_error error = {SL_OK, ""}, *said = &error;           \
        assert_int_equal(call, status_);                        \
        if (!strstr(said->message, words)) fail_msg("%s", said->message); \
    } while (0)

/* Its number stands for nothing then, and what is written has it no more. */
static void an_object_that_is_taken_away_is_no_more_there(void **state) {
    sl_error error;
    sl_scene *scene;
    sl_scene_edit *e;
    edited_room r = room_at_first(1);
    const double aside[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0, 1};
    uint32_t chair;
    quads to;
    const sl_mesh_data mesh = mesh_of_chair(&to);
    good(build_room(&r, &scene, &error), &error);
    const size_t triangles = sl_scene_triangle_count(scene);
    good(sl_scene_edit_begin(scene, &e, &error), &error);
    good(sl_edit_add_object(e, &mesh, &chair, &error), &error);
    good(sl_edit_transform(e, chair, aside, &error), &error);
    good(sl_edit_remove_object(e, OBJECT_BOX, &error), &error);
    good(sl_scene_edit_commit(e, NULL, &error), &error);
    assert_int_equal(chair, ROOM_OBJECTS + 1);
    assert_int_equal(sl_scene_find_object(scene, "chair"), chair);
    assert_int_equal(sl_scene_find_object(scene, "box"), 0);
    assert_int_equal(sl_scene_triangle_count(scene), triangles - 10 + 4);
    assert_int_equal(sl_scene_vertices(scene, OBJECT_BOX, NULL, NULL), 0);
    float positions[3 * 8], normals[3 * 8];
    assert_int_equal(sl_scene_vertices(scene, chair, positions, normals), 8);
    assert_true(positions[0] == 0.4f && normals[1] == 1.0f && scene->box_max.x == 1.2f);
    sl_scene_destroy(scene);
}

static void what_breaks_a_rule_is_refused(void **state) {
    sl_scene *scene;
    sl_scene_edit *e, *late;
    edited_room r = room_at_first(1);
    const double flat[16] = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                 mirrored[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                 far[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1e39, 0, 0, 1};
    assert_int_equal(build_room(&r, &scene, NULL), SL_OK);
    const uint64_t hash = sl_scene_hash(scene);
    assert_int_equal(sl_scene_edit_begin(scene, &e, NULL), SL_OK);
    assert_int_equal(sl_scene_edit_begin(scene, &late, NULL), SL_OK);
    REFUSED(sl_edit_light(e, 4, r.strength[0], NULL, NULL, said), SL_ERROR_USAGE, "from 1 to 3");
    REFUSED(sl_edit_light(e, 1, (float[3]){-1, 0, 0}, NULL, NULL, said), SL_ERROR_INPUT, "'intensity'");
    REFUSED(sl_edit_light(e, 2, NULL, NULL, (double[3]){0}, said), SL_ERROR_INPUT, "'direction'");
    REFUSED(sl_edit_transform(e, 9, flat, said), SL_ERROR_USAGE, "from 1 to 3");
    REFUSED(sl_edit_transform(e, OBJECT_BOX, flat, said), SL_ERROR_INPUT, "can be inverted");
    REFUSED(sl_edit_transform(e, OBJECT_BOX, mirrored, said), SL_ERROR_INPUT, "not to mirror");
    r.material[0].diffuse[0] = 2.0f;
    REFUSED(sl_edit_material(e, 1, &r.material[0], said), SL_ERROR_INPUT, "'diffuse' from 0 to 1");
    const float points[3 * 4] = {0};
    REFUSED(sl_edit_vertices(e, OBJECT_LAMP, 3, points, NULL, said), SL_ERROR_USAGE, "expected 4 vertices");
    REFUSED(sl_edit_vertices(e, OBJECT_LAMP, 4, (float[12]){NAN}, NULL, said), SL_ERROR_INPUT, "finite");
    REFUSED(sl_edit_remove_object(e, 4, said), SL_ERROR_USAGE, "from 1 to 3");
    assert_int_equal(sl_edit_transform(e, OBJECT_BOX, far, NULL), SL_OK);
    REFUSED(sl_scene_edit_commit(e, NULL, said), SL_ERROR_INPUT, "object 'box'");
    assert_true(sl_scene_hash(scene) == hash);
    const float eye[3] = {0, 1, 2};
    assert_int_equal(sl_scene_set_camera(scene, eye, room_target, room_up, 1.0f, NULL), SL_OK);
    REFUSED(sl_scene_edit_commit(late, NULL, said), SL_ERROR_USAGE, "has changed since");
    assert_int_equal(sl_scene_find_object(scene, "box"), OBJECT_BOX);
    assert_int_equal(sl_scene_find_material(scene, "material 4"), MATERIAL_LAMP);
    assert_int_equal(sl_scene_find_material(scene, "none"), 0);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(after_any_series_of_edits_the_scene_is_one_that_is_built_so),
        cmocka_unit_test(what_has_changed_is_told_by_its_kind),
        cmocka_unit_test(an_object_that_is_taken_away_is_no_more_there),
        cmocka_unit_test(what_breaks_a_rule_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
