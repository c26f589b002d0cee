/* The explanations of pixels: what a method says made a pixel is what made it. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "unit_test.h"
#include "rendering.h"

static const char *const methods[] = {"splatting", "direct-radiance", "shading-cache", "multi-mesh",
                                      "light-octree"};
enum { METHODS = sizeof methods / sizeof methods[0], WIDTH = 40, HEIGHT = 32 };

typedef struct {
    sl_scene *scene;
    sl_method *method;
    sl_image *picture;
} rendered;

static rendered render_batches(const char *scene, const char *method, uint64_t batches,
                               const sl_observer *observer) {
    rendered r = {.scene = load_scene(scene)};
    sl_settings settings = small_settings(method, WIDTH, HEIGHT);
    settings.observer = observer;
    r.method = created_method(r.scene, &settings);
    run_batches(r.method, batches);
    r.picture = resolved_picture(r.method);
    return r;
}

static void forget(rendered *r) {
    sl_image_destroy(r->picture);
    destroy_method(r->method, r->scene);
}

/* Contributions add up to the pixel but for the float sums' own rounding, and the explanation says so. */
static void assert_adds_up(const sl_explanation *explanation, const sl_image *picture, int x, int y) {
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, size = 1e-30;
        for (size_t i = 0; i < explanation->count; i++) {
            sum += explanation->terms[i].contribution[c];
            size += fabs(explanation->terms[i].contribution[c]);
        }
        float value = picture->planes[(c * HEIGHT + y) * WIDTH + x];
        assert_true(explanation->pixel[c] == value);
        assert_true((float)(sum + explanation->rounding[c]) == value);
        assert_true(fabs(explanation->rounding[c]) <= 4e-6 * size);
    }
}

static size_t assert_all_add_up(const char *scene, const char *method, uint64_t batches) {
    rendered r = render_batches(scene, method, batches, NULL);
    size_t terms = 0;
    for (int k = 0; k < 300; k++) {
        int x = (k * 31 + 7) % WIDTH, y = (k * 17 + 3) % HEIGHT;
        sl_explanation *explanation;
        assert_int_equal(sl_method_explanation(r.method, r.picture, x, y, &explanation, NULL), SL_OK);
        assert_adds_up(explanation, r.picture, x, y);
        terms += explanation->count;
        sl_explanation_destroy(explanation);
    }
    forget(&r);
    return terms;
}

static void what_a_method_says_made_a_pixel_adds_up_to_it(void **state) {
    static const char *const scenes[] = {"scenes/cornell.json", "scenes/cornell-glossy.json",
                                         "scenes/sphere.json", "scenes/mirror-balls.json"};
    for (size_t s = 0; s < sizeof scenes / sizeof scenes[0]; s++)
        for (size_t m = 0; m < METHODS; m++) assert_true(assert_all_add_up(scenes[s], methods[m], 0) > 300);
}

static void so_it_does_in_a_picture_that_was_stopped_early(void **state) {
    for (size_t m = 0; m < METHODS; m++) assert_all_add_up("scenes/cornell-glossy.json", methods[m], 4);
}

static void the_explanation_of_a_lamp_is_its_own_light(void **state) {
    for (size_t m = 0; m < METHODS; m++) {
        rendered r = render_batches("scenes/cornell.json", methods[m], 0, NULL);
        sl_explanation *explanation;
        assert_int_equal(sl_method_explanation(r.method, r.picture, WIDTH / 2, 4, &explanation, NULL), SL_OK);
        assert_int_equal(explanation->count, 1);
        assert_string_equal(explanation->terms[0].layer, "emission");
        sl_explanation_destroy(explanation);
        forget(&r);
    }
}

static void pixels_outside_and_tracers_have_no_explanation(void **state) {
    rendered r = render_batches("scenes/cornell.json", "splatting", 2, NULL),
             p = render_batches("scenes/cornell.json", "path", 1, NULL);
    sl_explanation *explanation;
    sl_error error;
    assert_int_equal(sl_method_explanation(r.method, r.picture, WIDTH, 0, &explanation, &error),
                     SL_ERROR_USAGE);
    assert_null(explanation);
    assert_int_equal(sl_method_explanation(r.method, r.picture, 0, -1, &explanation, &error), SL_ERROR_USAGE);
    assert_int_equal(sl_method_explanation(p.method, p.picture, 0, 0, &explanation, &error), SL_ERROR_USAGE);
    forget(&r);
    forget(&p);
}

static void count_marks(void *context, const sl_pass *pass) { *(size_t *)context += pass->mark_count; }

static void who_looks_on_changes_nothing_and_sees_marks(void **state) {
    for (size_t m = 0; m < METHODS; m++) {
        size_t marks = 0;
        sl_observer observer = {&marks, count_marks};
        rendered alone = render_batches("scenes/cornell-glossy.json", methods[m], 0, NULL);
        rendered watched = render_batches("scenes/cornell-glossy.json", methods[m], 0, &observer);
        assert_true(marks > 0);
        assert_memory_equal(sl_method_counters(alone.method), sl_method_counters(watched.method),
                            sizeof(sl_counters));
        assert_memory_equal(alone.picture->planes, watched.picture->planes,
                            sizeof(float) * WIDTH * HEIGHT * (size_t)alone.picture->channels);
        forget(&alone);
        forget(&watched);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_a_method_says_made_a_pixel_adds_up_to_it),
        cmocka_unit_test(so_it_does_in_a_picture_that_was_stopped_early),
        cmocka_unit_test(the_explanation_of_a_lamp_is_its_own_light),
        cmocka_unit_test(pixels_outside_and_tracers_have_no_explanation),
        cmocka_unit_test(who_looks_on_changes_nothing_and_sees_marks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
