/* Which pixels show which face, and how large patches are on the screen. */
#include "multi_mesh_field.h"

#include "trace_scenes.h"

enum { WIDTH = 160, HEIGHT = 120, PIXELS = WIDTH * HEIGHT };

static void every_pixel_that_shows_something_is_listed_once_under_its_face(void **state) {
    sl_scene *scene = striped_room();
    sl_raster *raster = raster_of(scene);
    sl_primitives *primitives;
    sl_view view = sl_view_scene(scene, WIDTH, HEIGHT);
    sl_counters counters = {{0}};
    uint32_t id[PIXELS];
    uint8_t listed[PIXELS] = {0};
    sl_visible_pixels *v;
    sl_target target = {WIDTH, HEIGHT, id, NULL};
    assert_int_equal(sl_primitives_of_triangles(scene, &primitives, NULL), SL_OK);
    assert_int_equal(sl_raster_id(raster, &view, 1, &target, &counters, NULL), SL_OK);
    assert_int_equal(sl_visible_pixels_sort(primitives, raster, &view, id, 1, &v, &counters, NULL), SL_OK);
    size_t shown = 0, sum = 0;
    for (size_t i = 0; i < PIXELS; i++) shown += id[i] != SL_NO_INDEX;
    assert_true(shown > PIXELS / 2);
    for (size_t e = 0; e < v->face_count; e++) {
        assert_int_equal(v->entry_of_face[v->face[e].face], e);
        assert_true(e == 0 || v->face[e].face > v->face[e - 1].face);
        assert_int_equal(v->face[e].first, sum);
        assert_true(v->face[e].count > 0);
        sum += v->face[e].count;
        for (uint32_t i = v->face[e].first; i < v->face[e].first + v->face[e].count; i++) {
            assert_int_equal(id[v->pixel[i]], v->face[e].face / 2);
            assert_int_equal(listed[v->pixel[i]]++, 0);
            assert_true(i == v->face[e].first || v->pixel[i] > v->pixel[i - 1]);
        }
    }
    assert_int_equal(sum, shown);
    assert_int_equal(v->count, shown);
    size_t faces = 0;
    for (size_t f = 0; f < 2 * scene->triangle_count; f++) faces += v->entry_of_face[f] != SL_NO_INDEX;
    assert_int_equal(faces, v->face_count);
    sl_visible_pixels_destroy(v);
    sl_primitives_destroy(primitives);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel_that_shows_something_is_listed_once_under_its_face),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
