/* A displayed mesh that is tidied up shows what it showed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "multi_mesh_field.h"

/* A shadow's round border: cuts along it, and many beside it that are undone. */
static sl_rgb round_shadow(const void *context, sl_vec3 p) {
    (void)context;
    return sl_grey(p.x * p.x + p.y * p.y < 0.2f ? 0.1f : 0.8f);
}

static void a_displayed_mesh_that_was_tidied_up_draws_the_same_picture_and_asks_for_nothing(void **state) {
    (void)state;
    sl_displayed_settings settings = usual_settings();
    rig r = rig_of(square_scene(), (field){round_shadow, NULL}, &settings, 96, 96);
    size_t pixels = 96 * 96 * sizeof(float);
    float *before = malloc(3 * pixels);
    assert_non_null(before);
    rig_look(&r, NULL, 1);
    rig_finish(&r);
    rig_draw(&r, 1);
    for (int c = 0; c < 3; c++) memcpy(before + c * 96 * 96, r.plane[c], pixels);
    size_t bytes = sl_displayed_memory_bytes(r.mesh), vertices = r.mesh->mesh->vertex_count;
    sl_displayed_tidy(r.mesh, true);
    assert_true(sl_displayed_memory_bytes(r.mesh) < bytes / 2 && r.mesh->mesh->vertex_count < vertices);
    uint64_t samples = r.samples;
    for (int times = 0; times < 2; times++) { /* what lies on edges is looked up, then remembered */
        for (int c = 0; c < 3; c++) memset(r.plane[c], 0, pixels);
        rig_look(&r, NULL, 1);
        assert_int_equal(rig_finish(&r), 0);
        rig_draw(&r, 1);
        for (int c = 0; c < 3; c++) assert_memory_equal(before + c * 96 * 96, r.plane[c], pixels);
    }
    assert_int_equal(r.samples, samples);
    free(before);
    rig_discard(&r);
}

static void leaves_that_wait_to_be_drawn_are_drawn_after_tidying_up(void **state) {
    (void)state;
    sl_displayed_settings settings = usual_settings();
    rig a = rig_of(square_scene(), (field){round_shadow, NULL}, &settings, 64, 64), b = rig_of(square_scene(), (field){round_shadow, NULL}, &settings, 64, 64);
    rig *both[2] = {&a, &b};
    for (int i = 0; i < 2; i++) {
        rig_look(both[i], NULL, 1);
        rig_step(both[i], 8);
        rig_draw(both[i], 1);
        rig_finish(both[i]);
        if (i == 1) sl_displayed_tidy(both[i]->mesh, true);
        rig_draw(both[i], 1);
    }
    for (int c = 0; c < 3; c++) assert_memory_equal(a.plane[c], b.plane[c], 64 * 64 * sizeof(float));
    rig_discard(&a);
    rig_discard(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_displayed_mesh_that_was_tidied_up_draws_the_same_picture_and_asks_for_nothing),
        cmocka_unit_test(leaves_that_wait_to_be_drawn_are_drawn_after_tidying_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
