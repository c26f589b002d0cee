/* Many emitters, chosen by place: the chances are those with which they are chosen, nothing that shines is
 * left out, and what is near is chosen more often than by power. */
#include <stdlib.h>

#include "unit_test.h"
#include "base/math.h"
#include "trace/light_tree.h"
#include "trace_scenes.h"

enum { COLUMNS = 8, ROWS = 6, EMITTERS = 2 * COLUMNS * ROWS, SAMPLES = 1 << 15 };

/* Lamps of 0.2 x 0.2 m a metre apart, shining down from 2 m; every one of its own strength. */
static sl_scene *ceiling_of_lamps(void) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t light[4];
    for (int i = 0; i < 4; i++) light[i] = trace_mesh_material(&mesh, 0, 0, 0, 0, 2.0f + 3.0f * (float)i);
    for (int y = 0; y < ROWS; y++) {
        for (int x = 0; x < COLUMNS; x++) {
            trace_mesh_quad(&mesh, sl_v3((float)x, (float)y, 2.0f), sl_v3(0, 0.2f, 0), sl_v3(0.2f, 0, 0),
                            light[(x + 3 * y) % 4]);
        }
    }
    return trace_mesh_build(&mesh);
}

static sl_light_tree *plant(const sl_scene *scene) {
    sl_light_tree *tree;
    assert_int_equal(scene->emitter_count, EMITTERS);
    assert_int_equal(sl_light_tree_create(scene, &tree, NULL), SL_OK);
    return tree;
}

static void chances_are_those_of_being_chosen_and_sum_to_one(void **state) {
    sl_scene *scene = ceiling_of_lamps();
    sl_light_tree *tree = plant(scene);
    const sl_vec3 places[3] = {{0.3f, 0.4f, 0.0f}, {7.1f, 5.1f, 1.9f}, {-20.0f, 3.0f, 0.5f}};
    for (int p = 0; p < 3; p++) {
        sl_vec3 up = {0, 0, 1};
        int times[EMITTERS] = {0};
        double told[EMITTERS] = {0};
        double sum = 0.0;
        for (int i = 0; i < SAMPLES; i++) {
            uint32_t emitter;
            float chance;
            assert_true(sl_light_tree_choose(tree, places[p], up, ((float)i + 0.5f) / (float)SAMPLES,
                                             &emitter, &chance));
            told[emitter] = (double)chance;
            times[emitter]++;
        }
        for (uint32_t e = 0; e < EMITTERS; e++) {
            assert_true(fabs((double)times[e] / SAMPLES - told[e]) < 4.0 / SAMPLES + 1e-5);
            sum += told[e];
        }
        assert_true(sum < 1.0 + 1e-5 && sum > 0.99); /* the rest: those too faint to be chosen once */
    }
    sl_light_tree_destroy(tree);
    sl_scene_destroy(scene);
}

static void what_cannot_shine_on_the_receiver_is_not_chosen(void **state) {
    sl_scene *scene = ceiling_of_lamps();
    sl_light_tree *tree = plant(scene);
    const sl_vec3 place[3] = {{3.0f, 2.0f, 0.0f}, {3.0f, 2.0f, 3.0f}, {-0.5f, 2.0f, 2.5f}};
    const sl_vec3 normal[3] = {{0, 0, -1}, {0, 0, -1}, {-1, 0, 0}}; /* turned away; above the lamps; both */
    for (int p = 0; p < 3; p++) {
        uint32_t emitter;
        float chance;
        for (int i = 0; i < 64; i++)
            assert_false(
                sl_light_tree_choose(tree, place[p], normal[p], (float)i / 64.0f, &emitter, &chance));
    }
    sl_light_tree_destroy(tree);
    sl_scene_destroy(scene);
}

/* Positions that are not finite, on a lamp's own corner, and within its plane: a choice or none, never a NaN.
 */
static void odd_places_are_survived(void **state) {
    sl_scene *scene = ceiling_of_lamps();
    sl_light_tree *tree = plant(scene);
    const sl_vec3 places[5] = {
        {NAN, 0, 0}, {INFINITY, 0, 0}, {0, 0, 2.0f}, {3e30f, 0, 0}, {0.1f, 0.1f, 2.0f}};
    for (int p = 0; p < 5; p++) {
        for (int i = 0; i < 64; i++) {
            uint32_t emitter = 0;
            float chance = 1.0f;
            bool chosen =
                sl_light_tree_choose(tree, places[p], sl_v3(0, 0, 1), (float)i / 64.0f, &emitter, &chance);
            if (chosen) assert_true(emitter < EMITTERS && chance > 0.0f && chance <= 1.0f + 1e-5f);
        }
    }
    sl_light_tree_destroy(tree);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chances_are_those_of_being_chosen_and_sum_to_one),
        cmocka_unit_test(what_cannot_shine_on_the_receiver_is_not_chosen),
        cmocka_unit_test(odd_places_are_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
