/* How many bounces matter: as many as a scene that reflects nearly all needs, and no more where walls are
 * dark. */
#include <math.h>

#include "unit_test.h"
#include "cache/frame/all_light.h"
#include "rendering.h"

static sl_scene *closed_room(const char *wall) {
    return room_with_a_box(1.0, 0.0, wall, wall, "\"emission\": 5, ", "");
}

static sl_bounces_measured measured(const sl_scene *scene) {
    const sl_settings settings = small_settings("splatting", 32, 32);
    sl_bounces_measured found;
    sl_error error;
    good(sl_measure_bounces(scene, &settings, &found, &error), &error);
    return found;
}

/* By so many bounces, of other paths than those that were measured. */
static double light_of(const sl_scene *scene, uint32_t bounces) {
    sl_settings settings = small_settings("splatting", 32, 32);
    const sl_light_paths paths = {"splatting", NULL};
    double light;
    sl_error error;
    settings.bounces = bounces;
    settings.seed = 5;
    good(sl_measure_light(scene, &settings, &paths, 1, 16, &light, &error), &error);
    return light;
}

static void bounces_that_are_left_out_hold_less_than_half_a_per_cent_of_the_light(void **state) {
    static const char *const walls[] = {"\"diffuse\": 0.9", "\"diffuse\": 0.7", "\"diffuse\": 0.3"};
    uint32_t before = 64;
    for (int i = 0; i < 3; i++) {
        sl_scene *scene = closed_room(walls[i]);
        const sl_bounces_measured found = measured(scene);
        const double left = 1.0 - light_of(scene, found.bounces) / light_of(scene, 64);
        print_message("%s: %u bounces, %.2f %% left, %.2f told\n", walls[i], (unsigned)found.bounces,
                      100.0 * left, 100.0 * found.left);
        assert_true(found.left < 0.005 && fabs(left - found.left) < 0.0035);
        assert_true(found.bounces < before);
        before = found.bounces;
        sl_scene_destroy(scene);
    }
}

static void where_nothing_is_reflected_there_is_one_bounce(void **state) {
    sl_scene *scene = closed_room("\"diffuse\": 0");
    const sl_bounces_measured found = measured(scene);
    assert_true(found.bounces == 1 && found.left == 0.0);
    sl_scene_destroy(scene);
}

/* The lamp is in a closed box, which may be opened. */
static void where_no_light_is_seen_bounces_are_those_of_the_mean_reflectance(void **state) {
    static const char *const walls[] = {"\"diffuse\": 0.7", "\"diffuse\": 0.3"};
    static const uint32_t bounces[] = {14, 5}; /* .7^15 and .3^6 are less than half a per cent */
    for (int i = 0; i < 2; i++) {
        sl_scene *scene = room_with_a_box(1.0, 0.0, walls[i], walls[i], "",
                                          "\"lights\": [{\"type\": \"point\", \"position\": [0, -0.7, 0], "
                                          "\"intensity\": 5}],");
        const sl_bounces_measured found = measured(scene);
        assert_in_range(found.bounces, bounces[i] - 1, bounces[i] + 1);
        assert_true(found.left > 0.0 && found.left < 0.005);
        sl_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounces_that_are_left_out_hold_less_than_half_a_per_cent_of_the_light),
        cmocka_unit_test(where_nothing_is_reflected_there_is_one_bounce),
        cmocka_unit_test(where_no_light_is_seen_bounces_are_those_of_the_mean_reflectance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
