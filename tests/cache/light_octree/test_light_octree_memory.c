/* Memory that runs out: an edit that fails says so, and can be had again once there is memory; so could an
 * update, of the light octree's own state. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdatomic.h>
#include <stdlib.h>

#include "cache/frame/method.h"
#include "rendering.h"

/* The library asks for memory here; allocation number `failing` fails, once. */
static atomic_long asked, failing = -1;

void *aligned_alloc(size_t alignment, size_t size) {
    void *block = NULL;
    if (atomic_fetch_add(&asked, 1) == atomic_load(&failing)) return NULL;
    return posix_memalign(&block, alignment, size) == 0 ? block : NULL;
}

static void fail_after(long more) { atomic_store(&failing, more < 0 ? -1 : atomic_load(&asked) + more); }

static bool has_failed(void) {
    return atomic_load(&failing) >= 0 && atomic_load(&asked) > atomic_load(&failing);
}

static sl_settings few_photons(void) {
    sl_settings s = small_settings("light-octree", 16, 16);
    s.quality = SL_QUALITY_DRAFT;
    s.threads = 1;
    s.light_octree.photons = 2000;
    s.light_octree.neighbours = 30;
    s.light_octree.depth = 4;
    s.light_octree.atlas = true;
    s.light_octree.atlas_size = 64;
    return s;
}

static sl_image *finished(sl_method *method) {
    sl_progress progress = {0};
    sl_image *image = NULL;
    sl_error error;
    while (!progress.done) {
        if (sl_method_update(method, &progress, &error) != SL_OK) fail_msg("%s", error.message);
    }
    assert_int_equal(sl_method_resolve(method, &image, NULL), SL_OK);
    return image;
}

static void an_edit_without_memory_can_be_had_again(void **state) {
    (void)state;
    sl_scene *scene = load_scene("scenes/cornell-mirror.json");
    sl_settings settings = few_photons();
    sl_image *alone = render(scene, &settings, NULL);
    const unsigned first[] = {SL_CHANGED_OBJECTS, SL_CHANGED_LIGHTS},
                   then[] = {SL_CHANGED_CAMERA, SL_CHANGED_LIGHTS, SL_CHANGED_OBJECTS};
    for (int k = 0; k < 6; k++) {
        sl_method *method;
        int failures = 0;
        assert_int_equal(sl_method_create(scene, &settings, &method, NULL), SL_OK);
        sl_image_destroy(finished(method));
        for (long n = 0;; n += 1 + n) {
            sl_error error;
            fail_after(n);
            sl_status status = sl_method_edit(method, first[k / 3], &error);
            bool failed = has_failed();
            fail_after(-1);
            if (!failed) break;
            if (status == SL_OK) continue; /* what it had to do without is not missed */
            failures++;
            assert_int_equal(status, SL_ERROR_RESOURCES);
            assert_int_equal(sl_method_edit(method, then[k % 3], &error), SL_OK);
            sl_image *image = finished(method);
            assert_true(same_picture(image, alone));
            sl_image_destroy(image);
        }
        assert_true(failures >= 1);
        sl_method_destroy(method);
    }
    sl_image_destroy(alone);
    sl_scene_destroy(scene);
}

static void an_update_without_memory_leaves_a_state_that_can_go_on(void **state) {
    (void)state;
    sl_scene *scene = load_scene("scenes/cornell-mirror.json");
    sl_settings settings = few_photons();
    sl_image *alone = render(scene, &settings, NULL);
    int failures = 0;
    for (long n = 0;; n += 19) {
        sl_method *method;
        sl_progress progress = {0};
        assert_int_equal(sl_method_create(scene, &settings, &method, NULL), SL_OK);
        fail_after(n);
        while (!progress.done && sl_method_update(method, &progress, NULL) == SL_OK) {}
        bool failed = has_failed();
        fail_after(-1);
        failures += !progress.done;
        /* of methods at large nothing is promised, and so they are asked for nothing more */
        method->health = SL_METHOD_SOUND;
        sl_image *image = finished(method);
        assert_true(same_picture(image, alone));
        sl_image_destroy(image);
        sl_method_destroy(method);
        if (!failed) break;
    }
    assert_true(failures > 10);
    sl_image_destroy(alone);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_edit_without_memory_can_be_had_again),
        cmocka_unit_test(an_update_without_memory_leaves_a_state_that_can_go_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
