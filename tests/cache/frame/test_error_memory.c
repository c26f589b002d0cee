/* Memory that runs out while a picture's error is estimated: said so, nothing lost, and the same answer once
 * there is memory. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "rendering.h"

#include "failing_memory.h"

typedef struct judging {
    sl_scene *scene;
    sl_settings settings;
    sl_image *image;
    sl_error_probe *probe;
    sl_error_estimate estimate;
    sl_error error;
} judging;

static judging begin(void) {
    judging j = {.scene = load_scene("scenes/cornell-point.json"),
                 .settings = small_settings("path", 16, 16)};
    j.settings.transport = "direct";
    j.settings.spp = 2;
    j.settings.threads = 1;
    j.image = render(j.scene, &j.settings, NULL);
    return j;
}

static void end(judging *j) {
    sl_error_probe_destroy(j->probe);
    sl_image_destroy(j->image);
    sl_scene_destroy(j->scene);
}

static sl_status create(void *context) {
    judging *j = context;
    return sl_error_probe_create(j->scene, &j->settings, &j->probe, &j->error);
}

static void there_is_none(void *context) { assert_null(((judging *)context)->probe); }

static sl_status estimate(void *context) {
    judging *j = context;
    return sl_error_probe_estimate(j->probe, j->image, 32, 2, &j->estimate, &j->error);
}

static sl_status estimate_more(void *context) {
    judging *j = context;
    return sl_error_probe_estimate(j->probe, j->image, 100, 4, &j->estimate, &j->error);
}

static sl_status from_halves(void *context) {
    judging *j = context;
    return sl_error_estimate_from_halves(j->image, NULL, &j->estimate, &j->error);
}

static void probes_without_memory_leave_nothing(void **state) {
    (void)state;
    judging j = begin();
    assert_true(until_it_succeeds(create, &j, false, there_is_none) > 3);
    end(&j);
}

static void an_estimate_without_memory_can_be_had_again(void **state) {
    (void)state;
    judging j = begin(), other = begin();
    assert_int_equal(create(&j), SL_OK);
    assert_int_equal(create(&other), SL_OK);
    assert_true(until_it_succeeds(estimate, &j, true, NULL) > 4);
    assert_true(until_it_succeeds(estimate_more, &j, true, NULL) > 4); /* more probes: what there is moves */
    assert_int_equal(estimate_more(&other), SL_OK); /* at once */
    assert_memory_equal(&j.estimate, &other.estimate, sizeof j.estimate);
    end(&other);
    end(&j);
}

static void halves_without_memory_say_so(void **state) {
    (void)state;
    judging j = begin();
    assert_int_equal(until_it_succeeds(from_halves, &j, false, NULL), 1);
    end(&j);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(probes_without_memory_leave_nothing),
        cmocka_unit_test(an_estimate_without_memory_can_be_had_again),
        cmocka_unit_test(halves_without_memory_say_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
