/* Depth: ties, order, and the cleared value. */
#include "raster_support.h"

/* ---- ties ---- */

static void equal_depths_go_to_the_lowest_index(void **state) {
    (void)state;
    enum { SIZE = 64, COPIES = 300 };
    float xyz[COPIES * 9];
    /* coplanar, corners turned, so that clusters and set-up see different triangles */
    for (size_t t = 0; t < COPIES; t++) {
        const float corner[3][3] = {{-1, -1, 0.25f}, {3, -1, 0.25f}, {-1, 3, 0.25f}};
        for (size_t c = 0; c < 3; c++) memcpy(&xyz[9 * t + 3 * c], corner[(c + t) % 3], sizeof corner[0]);
    }
    sl_scene *scene = scene_of_triangles(xyz, COPIES);
    sl_raster *raster = raster_of(scene);
    uint32_t id[SIZE * SIZE];
    for (int kind = 0; kind < 2; kind++) {
        sl_view view = flat_view(SIZE, SIZE);
        view.depth = kind ? SL_DEPTH_INVERSE_W : SL_DEPTH_WINDOW;
        render_small(raster, &view, id, NULL);
        for (int i = 0; i < SIZE * SIZE; i++) assert_int_equal(id[i], 0);
        view.skip_triangle = 0;
        render(raster, &view, 2, id, NULL);
        for (int i = 0; i < SIZE * SIZE; i++) assert_int_equal(id[i], 1);
    }
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void nearer_wins_whatever_the_order(void **state) {
    (void)state;
    const float xyz[18] = {-1, -1, 0.5f, 3, -1, 0.5f, -1, 3, 0.5f, -1, -1, -0.5f, 3, -1, -0.5f, -1, 3, -0.5f};
    sl_scene *scene = scene_of_triangles(xyz, 2);
    sl_raster *raster = raster_of(scene);
    uint32_t id[64];
    float depth[64];
    sl_view view = flat_view(8, 8);
    render(raster, &view, 1, id, depth);
    for (int i = 0; i < 64; i++) assert_true(id[i] == 1 && depth[i] == 0.25f);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static void nothing_is_drawn_at_the_cleared_depth(void **state) {
    (void)state;
    const float xyz[18] = {-1, -1, 1, 3, -1, 1, -1, 3, 1, -1, -1, 0.999f, 0, -1, 0.999f, -1, 0, 0.999f};
    sl_scene *scene = scene_of_triangles(xyz, 2);
    sl_raster *raster = raster_of(scene);
    uint32_t id[64];
    sl_view view = flat_view(8, 8);
    render(raster, &view, 1, id, NULL);
    assert_int_equal(id[0], 1);
    /* the first triangle lies in the far plane: GL_LESS against a cleared 1 fails */
    assert_int_equal(id[63], SL_NO_INDEX);
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_depths_go_to_the_lowest_index),
        cmocka_unit_test(nearer_wins_whatever_the_order),
        cmocka_unit_test(nothing_is_drawn_at_the_cleared_depth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
