/* The light octree's explanation of a pixel is what made it, whatever its settings, and in pictures that were
 * stopped anywhere. */
#include <math.h>
#include <string.h>

#include "unit_test.h"
#include "rendering.h"

enum { SIZE = 20 };

static sl_settings small(void) {
    sl_settings s = sl_settings_of_papers();
    s.method = "light-octree";
    s.width = s.height = SIZE;
    s.spp = 1;
    s.threads = 1;
    s.light_octree.depth = 5;
    s.light_octree.photons = 8000;
    s.light_octree.neighbours = 40;
    return s;
}

/* Every pixel; returns how many terms are lights of voxels. */
static size_t add_up(sl_method *method, const sl_image *picture) {
    size_t lights = 0;
    for (int pixel = 0; pixel < SIZE * SIZE; pixel++) {
        sl_explanation *explanation;
        double size[3] = {1e-30, 1e-30, 1e-30};
        assert_int_equal(
            sl_method_explanation(method, picture, pixel % SIZE, pixel / SIZE, &explanation, NULL), SL_OK);
        for (size_t i = 0; i < explanation->count; i++) {
            const sl_explanation_term *term = &explanation->terms[i];
            for (int c = 0; c < 3; c++) size[c] += fabs(term->contribution[c]);
            lights += term->placed;
            if (term->placed) assert_true(term->weight > 0.0 && term->weight <= 1.000001);
        }
        for (int c = 0; c < 3; c++) assert_true(fabs(explanation->rounding[c]) <= 4e-6 * size[c]);
        sl_explanation_destroy(explanation);
    }
    return lights;
}

/* `batches` 0: to the end. */
static size_t told(const char *path, const sl_settings *settings, uint64_t batches, bool *done) {
    sl_scene *scene = load_scene(path);
    sl_method *method = created_method(scene, settings);
    *done = run_batches(method, batches);
    sl_image *picture = resolved_picture(method);
    size_t lights = add_up(method, picture);
    sl_image_destroy(picture);
    destroy_method(method, scene);
    return lights;
}

static void one_colour(sl_light_octree_settings *o) { o->lobes = SL_LOBES_NONE; }
static void surface(sl_light_octree_settings *o) { o->lobes = SL_LOBES_SURFACE; }
static void whole(sl_light_octree_settings *o) { o->whole_voxels = true; }
static void nearest(sl_light_octree_settings *o) { o->filter = SL_VOXEL_NEAREST; }
static void void_dark(sl_light_octree_settings *o) { o->keep_void_dark = true; }

static void lights_of_voxels_add_up_whatever_the_settings(void **state) {
    static void (*const settings[])(sl_light_octree_settings *) = {one_colour, surface, whole, nearest,
                                                                   void_dark};
    for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++) {
        bool done;
        sl_settings s = small();
        settings[i](&s.light_octree);
        assert_true(told("scenes/cornell-glossy.json", &s, 0, &done) > SIZE * SIZE);
    }
}

static void what_mirrors_show_is_told_too(void **state) {
    bool done;
    sl_settings s = small();
    assert_true(told("scenes/cornell-mirror.json", &s, 0, &done) > SIZE * SIZE);
}

/* From the atlas, and of the photons themselves: a term for all. */
static void light_by_other_ways_is_one_term(void **state) {
    bool done;
    sl_settings s = small();
    s.light_octree.atlas = true;
    s.light_octree.atlas_size = 64;
    assert_int_equal(told("scenes/cornell.json", &s, 0, &done), 0);
    s.light_octree.atlas = false;
    s.light_octree.photons_at_pixels = true;
    assert_int_equal(told("scenes/cornell-glossy.json", &s, 0, &done), 0);
}

/* Between the lights of a deeper octree and the pixels that they light the picture still is the shallower
 * one's. */
static void a_picture_may_be_stopped_anywhere(void **state) {
    bool done = false;
    uint64_t batches = 1;
    for (sl_settings s = small(); !done; batches++) told("scenes/cornell.json", &s, batches, &done);
    assert_true(batches > 6);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lights_of_voxels_add_up_whatever_the_settings),
        cmocka_unit_test(what_mirrors_show_is_told_too),
        cmocka_unit_test(light_by_other_ways_is_one_term),
        cmocka_unit_test(a_picture_may_be_stopped_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
