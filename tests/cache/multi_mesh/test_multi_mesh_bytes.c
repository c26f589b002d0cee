/* What meshes take, leaf by leaf, in whole pictures: multi_mesh.h says what is counted. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/counters.h"
#include "cache/multi_mesh/multi_mesh.h"
#include "cache/multi_mesh/plan.h"
#include "rendering.h"

static double bytes_a_leaf(const void *state, bool each) {
    sl_mesh_census c[SL_MESH_KINDS];
    size_t leaves = 0, bytes = 0;
    sl_multi_mesh_census(state, c);
    for (int k = 0; k < SL_MESH_KINDS; k++) {
        leaves += c[k].leaves;
        bytes += c[k].bytes;
        if (each && c[k].leaves)
            print_message("  %zu leaves, %.0f bytes each\n", c[k].leaves,
                          (double)c[k].bytes / (double)c[k].leaves);
        if (each && c[k].leaves) assert_true((double)c[k].bytes <= 200.0 * (double)c[k].leaves);
    }
    return (double)bytes / (double)leaves;
}

/* Displayed, irradiance and coarse meshes each at the end, and all together at any time from the first
 * picture on. */
static void check_bytes(const char *path, sl_settings settings) {
    sl_scene *scene = load_scene(path);
    sl_transport transport;
    void *state;
    sl_error error;
    sl_progress progress = {0};
    double most = 0.0;
    sl_multi_mesh_complete(&settings);
    sl_multi_mesh_transport(&settings, &transport);
    assert_int_equal(sl_multi_mesh_method.create(scene, &settings, &transport, &state, &error), SL_OK);
    while (!progress.done) {
        assert_int_equal(sl_multi_mesh_method.update(state, &progress, &error), SL_OK);
        if (sl_multi_mesh_method.counters(state)->value[SL_COUNT_SPLITS] < 200) continue;
        double now = bytes_a_leaf(state, false);
        most = now > most ? now : most;
    }
    print_message("%s: at most %.0f bytes a leaf, %.0f at the end:\n", path, most, bytes_a_leaf(state, true));
    assert_true(most > 0.0 && most <= 150.0);
    sl_image *image;
    assert_int_equal(sl_multi_mesh_method.resolve(state, &image, &error), SL_OK);
    sl_image_destroy(image);
    bytes_a_leaf(state, true);
    sl_multi_mesh_method.destroy(state);
    sl_scene_destroy(scene);
}

static void a_leaf_takes_no_more_than_150_bytes_all_told(void **state) {
    (void)state;
    sl_settings settings = small_settings("multi-mesh", 256, 256);
    settings.quality = SL_QUALITY_NORMAL;
    check_bytes("scenes/cornell.json", settings);
    settings.width = settings.height = 128;
    check_bytes("scenes/two-rooms.json", settings);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_leaf_takes_no_more_than_150_bytes_all_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
