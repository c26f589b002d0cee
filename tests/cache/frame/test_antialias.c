/* Edges of frames that move: pixels there are mixed from the surfaces beside them. */
#include "cache/frame/antialias.h"
#include "gather_world.h"
#include "rendering.h"
#include "unit_test.h"

#include "base/math.h"

#include <math.h>

enum { SIDE = 32, PIXELS = SIDE * SIDE };

static void look(world *w) {
    world_build(w);
    assert_true(sl_camera_look_at(&w->scene->camera, sl_v3(0, 0, 0), sl_v3(0, 0, -1), sl_v3(0, 1, 0),
                                  (float)(0.5 * SL_PI)));
}

/* A picture in which one wall, in front, is light, and the one behind it dark. */
static sl_image *picture_of(world *w, float light, float dark) {
    static uint32_t id[PIXELS];
    sl_image *picture = blank_image(SIDE, SIDE, 3);
    const sl_view view = sl_view_scene(w->scene, SIDE, SIDE);
    const sl_target target = {SIDE, SIDE, id, NULL};
    assert_int_equal(sl_raster_id(w->raster, &view, 1, &target, &w->counters, NULL), SL_OK);
    for (int i = 0; i < PIXELS; i++)
        for (int c = 0; c < 3; c++)
            picture->planes[c * PIXELS + (SIDE - 1 - i / SIDE) * SIDE + i % SIDE] = id[i] < 2 ? light : dark;
    return picture;
}

static sl_image *smoothed(world *w, unsigned threads, float light, float dark) {
    sl_antialias *edges;
    sl_image *picture = picture_of(w, light, dark);
    assert_int_equal(sl_antialias_create(SIDE, SIDE, &edges, NULL), SL_OK);
    assert_int_equal(
        sl_antialias_edges(edges, w->scene, w->raster, NULL, threads, picture, &w->counters, NULL), SL_OK);
    sl_antialias_destroy(edges);
    return picture;
}

/* The light wall ends at .75 of a pixel. */
static world *two_walls(void) {
    world *w = world_new();
    world_wall(w, SIDE, 4, 4, 12.75f, 20.25f, 4, world_material(w, sl_grey(0.5f), sl_grey(0)));
    world_wall(w, SIDE, 0, 0, SIDE, SIDE, 8, world_material(w, sl_grey(0.5f), sl_grey(0)));
    look(w);
    return w;
}

static float at(const sl_image *picture, int x, int y) { return picture->planes[(SIDE - 1 - y) * SIDE + x]; }

static void a_pixel_at_an_edge_has_each_surface_in_its_share(void **state) {
    world *w = two_walls();
    sl_image *picture = smoothed(w, 1, 4.0f, 1.0f);
    assert_float_equal(at(picture, 12, 10), 0.75f * 4.0f + 0.25f, 1e-5f);
    assert_float_equal(at(picture, 8, 20), 0.25f * 4.0f + 0.75f, 1e-5f);
    sl_image_destroy(picture);
    world_free(w);
}

static void what_is_not_at_an_edge_keeps_its_bits_be_it_a_million_times_as_bright(void **state) {
    world *w = two_walls();
    sl_image *before = picture_of(w, 1e6f, 0.1f), *after = smoothed(w, 1, 1e6f, 0.1f);
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            const bool inside = x > 4 && x < 11 && y > 4 && y < 19,
                       outside = x > 14 || y > 22 || x < 3 || y < 3;
            if (inside || outside) assert_true(at(after, x, y) == at(before, x, y));
        }
    destroy_pictures(before, after);
    world_free(w);
}

static void edges_have_the_same_bits_at_any_number_of_threads(void **state) {
    world *w = two_walls();
    sl_image *one = smoothed(w, 1, 3.0f, 0.7f), *many = smoothed(w, 5, 3.0f, 0.7f);
    assert_memory_equal(one->planes, many->planes, 3 * PIXELS * sizeof *one->planes);
    destroy_pictures(one, many);
    world_free(w);
}

static void infinite_light_stays_finite_at_edges(void **state) {
    world *w = two_walls();
    sl_image *picture = smoothed(w, 1, 3e38f, 3e38f);
    for (int i = 0; i < 3 * PIXELS; i++) assert_true(isfinite(picture->planes[i]));
    sl_image_destroy(picture);
    world_free(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pixel_at_an_edge_has_each_surface_in_its_share),
        cmocka_unit_test(what_is_not_at_an_edge_keeps_its_bits_be_it_a_million_times_as_bright),
        cmocka_unit_test(edges_have_the_same_bits_at_any_number_of_threads),
        cmocka_unit_test(infinite_light_stays_finite_at_edges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
