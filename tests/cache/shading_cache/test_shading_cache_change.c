/* Change: what is stale after an edit, when an object is changing and when that ends, how coarse it becomes.
 */
#include <math.h>

#include "cache/shading_cache/change.h"
#include "cache/shading_cache/selection.h"
#include "shading_cache_support.h"
#include "scene_parts.h"

typedef struct world {
    hierarchy h;
    sl_changes changes;
} world;

/* So many squares beside each other, each an object. */
static world world_of(unsigned objects) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    uint32_t object[16];
    for (unsigned i = 0; i < objects; i++) {
        trace_mesh_quad(&mesh, sl_v3(3.0f * (float)i, 0, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), 0);
        object[2 * i] = object[2 * i + 1] = i;
    }
    sl_scene_parts d = {.vertex_count = mesh.vertex_count,
                        .positions = mesh.positions,
                        .triangle_count = mesh.triangle_count,
                        .indices = mesh.indices,
                        .material_index = mesh.material_index,
                        .object_index = object,
                        .object_count = objects,
                        .material_count = mesh.material_count,
                        .materials = mesh.materials};
    world w;
    sl_scene *scene = scene_built(&d);
    trace_mesh_discard(&mesh);
    w.h = hierarchy_of(scene, 0);
    assert_int_equal(scene->object_count, objects);
    w.changes = (sl_changes){.object_count = objects,
                             .object = calloc(objects, sizeof *w.changes.object),
                             .threshold = 2.0f,
                             .window = 3};
    assert_non_null(w.changes.object);
    return w;
}

static void world_discard(world *w) {
    free(w->changes.object);
    hierarchy_discard(&w->h);
}

/* ---- edits ---- */

static void when_a_light_moves_all_is_stale_and_nothing_is_known_to_change(void **state) {
    world w = world_of(2);
    sl_changes_edit(&w.changes, SL_CHANGED_LIGHTS, NULL, 7);
    for (uint32_t i = 0; i < 2; i++) {
        assert_int_equal(w.changes.object[i].stale_before, 7);
        assert_false(w.changes.object[i].changing);
        assert_int_equal(sl_changes_since(&w.changes, i), 0);
    }
    assert_int_equal(w.changes.eye_moved, 0);
    world_discard(&w);
}

static void an_object_that_moves_is_changing_at_once_and_the_others_are_stale(void **state) {
    world w = world_of(3);
    const bool moved[3] = {false, true, false};
    sl_changes_edit(&w.changes, SL_CHANGED_OBJECTS | SL_CHANGED_CAMERA, moved, 4);
    for (uint32_t i = 0; i < 3; i++) {
        assert_int_equal(w.changes.object[i].stale_before, 4);
        assert_int_equal(w.changes.object[i].changing, moved[i]);
        assert_int_equal(w.changes.object[i].moved, moved[i] ? 4 : 0);
        assert_int_equal(sl_changes_since(&w.changes, i), moved[i] ? 4 : 0);
    }
    assert_int_equal(w.changes.eye_moved, 4);
    world_discard(&w);
}

/* ---- what is a change ---- */

static void only_differences_above_the_threshold_are_changes(void **state) {
    world w = world_of(1);
    assert_false(sl_changes_compare(&w.changes, 0, 0.0f, 1) || sl_changes_compare(&w.changes, 0, 2.0f, 1) ||
                 sl_changes_compare(&w.changes, 0, NAN, 1));
    assert_false(w.changes.object[0].changing);
    assert_true(sl_changes_compare(&w.changes, 0, 2.1f, 5));
    assert_true(w.changes.object[0].changing && w.changes.object[0].changed == 5);
    world_discard(&w);
}

/* A light has moved: a quarter of the picture's pixels shows something else now. Its patches have no
 * priority, so epsilon has to find it. */
static void a_light_that_moved_is_found_within_the_tests_that_epsilon_needs(void **state) {
    enum { SIDE = 64, POINTS = 64, TRIALS = 200 };
    static uint32_t leaf[SIDE * SIDE];
    static sl_leaf_priority leaves[256];
    sl_choice choice[2 * POINTS];
    for (uint32_t i = 0; i < 256; i++) leaves[i] = (sl_leaf_priority){i, 16, 0.0f, 0.0f};
    for (uint32_t i = 0; i < SIDE * SIDE; i++) leaf[i] = i % SIDE / 4 + i / SIDE / 4 * 16;
    sl_priorities_normalise(256, leaves, false);
    double total = 0.0;
    for (uint64_t trial = 0; trial < TRIALS; trial++) {
        world w = world_of(1);
        sl_changes_edit(&w.changes, SL_CHANGED_LIGHTS, NULL, 2);
        sl_counters counters = {0};
        sl_selection s = {.points = POINTS,
                          .random_share = 0.03f,
                          .flood_threshold = 0.5f,
                          .per_patch = 16,
                          .seed = trial,
                          .update = 2,
                          .width = SIDE,
                          .height = SIDE,
                          .leaf = leaf,
                          .leaves = leaves,
                          .leaf_count = 256,
                          .counters = &counters,
                          .choice = choice};
        size_t first = 0;
        assert_int_equal(sl_select_pixels(&s, NULL), SL_OK);
        for (; first < s.count && !w.changes.object[0].changing; first++) {
            bool lit = choice[first].pixel / SIDE < SIDE / 4;
            sl_changes_compare(&w.changes, 0, lit ? 30.0f : 0.0f, 2);
        }
        assert_true(w.changes.object[0].changing);                          /* in the first update: */
        /* M/epsilon tests are its mean */
        assert_true((double)counters.value[SL_COUNT_PIXEL_TESTS] <= 2 * POINTS / 0.03);
        total += (double)first;
        world_discard(&w);
    }
    /* geometric, a quarter: mean 4, variance 12 */
    assert_true(fabs(total / TRIALS - 4.0) < 4.0 * sqrt(12.0 / TRIALS));
}

/* ---- the end of a change ---- */

static void a_change_ends_when_none_was_found_for_the_window_and_nothing_visible_is_from_before(
    void **state) {
    world w = world_of(2);
    bool stale[2] = {true, true};
    sl_changes_edit(&w.changes, SL_CHANGED_LIGHTS, NULL, 10);
    assert_true(sl_changes_compare(&w.changes, 1, 10.0f, 12));
    /* what was evaluated since the edit is new enough, though the change was found later */
    assert_int_equal(sl_changes_since(&w.changes, 1), 10);
    for (uint32_t now = 12; now < 20; now++) {
        sl_changes_settle(&w.changes, stale, now);
        assert_true(w.changes.object[1].changing && !w.changes.object[0].changing);
    }
    assert_true(sl_changes_compare(&w.changes, 1, 10.0f, 20));
    stale[1] = false;
    for (uint32_t now = 20; now <= 24; now++) {
        sl_changes_settle(&w.changes, stale, now);
        assert_int_equal(w.changes.object[1].changing, now < 23);
    }
    assert_int_equal(sl_changes_since(&w.changes, 1), 0);
    world_discard(&w);
}

/* ---- resolution ---- */

static void how_coarse_depends_on_what_there_is_time_for(void **state) {
    /* pixels / (samples a second x seconds); of triangles half */
    assert_true(fabsf(sl_changes_coarsest(100000, 768, 5) - 26.04f) < 0.01f);
    assert_true(sl_changes_coarsest(100000, 768, 2.5) ==
                2.0f * sl_changes_coarsest(100000, 768, 5));
    assert_true(sl_changes_coarsest(0, 768, 5) == 0.0f &&
                sl_changes_coarsest(NAN, 768, 5) == 0.0f);
    assert_true(sl_changes_coarsest(1000, 768, 0) == FLT_MAX &&
                sl_changes_coarsest(0, 0, 0) == 0.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(when_a_light_moves_all_is_stale_and_nothing_is_known_to_change),
        cmocka_unit_test(an_object_that_moves_is_changing_at_once_and_the_others_are_stale),
        cmocka_unit_test(only_differences_above_the_threshold_are_changes),
        cmocka_unit_test(a_light_that_moved_is_found_within_the_tests_that_epsilon_needs),
        cmocka_unit_test(a_change_ends_when_none_was_found_for_the_window_and_nothing_visible_is_from_before),
        cmocka_unit_test(how_coarse_depends_on_what_there_is_time_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
