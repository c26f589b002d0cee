/* Shows of methods that have no display of their own: pictures take its place, and only those that have light
 * everywhere. */
#include <malloc.h>
#include <math.h>
#include <time.h>

#include "unit_test.h"
#include "rendering.h"

#include "cache/frame/method.h"

enum { W = 48, H = 40, PICTURES = 8 };

static const char *const methods[] = {"splatting", "direct-radiance", "light-octree", "multi-mesh", "path"};
enum { METHODS = 5 };

/* Mean of what surfaces show: a lamp counts as white. */
static double light_of(const sl_image *image) {
    const float *green = sl_image_channel(image, "G");
    double sum = 0.0;
    for (int i = 0; i < W * H; i++) sum += fmin((double)green[i], 1.0);
    return sum / (W * H);
}

static void pause_a_little(void) { nanosleep(&(struct timespec){0, 2000000}, NULL); }

static sl_settings draft(const char *method) {
    sl_settings s = small_settings(method, W, H);
    s.filter = SL_FILTER_CENTRE;
    return s;
}

static void every_picture_of_a_show_has_light(void **state) {
    for (int m = 0; m < METHODS; m++) {
        sl_scene *scene = load_scene("scenes/moving-ball.json");
        const sl_settings settings = draft(methods[m]);
        sl_image *still = render(scene, &settings, NULL);
        const double expected = light_of(still);
        sl_live *live;
        sl_live_state at = {0};
        const sl_image *frame;
        assert_int_equal(sl_live_start(scene, &settings, &live, NULL), SL_OK);
        /* moves come faster than pictures */
        for (double time = 0.0; at.versions < PICTURES; time += 0.004) {
            assert_int_equal(sl_live_move(live, fmod(time, 4.0), NULL), SL_OK);
            assert_int_equal(sl_live_frame(live, &frame, &at, NULL), SL_OK);
            if (at.versions) assert_true(light_of(frame) > 0.6 * expected);
            pause_a_little();
        }
        sl_live_stop(live, NULL);
        destroy_picture(still, scene);
    }
}

static void what_is_shown_follows_what_moves(void **state) {
    for (int m = 0; m < METHODS; m++) {
        sl_scene *scene = load_scene("scenes/moving-ball.json");
        const sl_settings settings = draft(methods[m]);
        sl_live *live;
        sl_live_state at = {0};
        const sl_image *frame;
        assert_int_equal(sl_live_start(scene, &settings, &live, NULL), SL_OK);
        assert_int_equal(sl_live_move(live, 2.0, NULL), SL_OK);
        while (!at.done) {
            assert_int_equal(sl_live_frame(live, &frame, &at, NULL), SL_OK);
            pause_a_little();
        }
        assert_int_equal(sl_live_frame(live, &frame, &at, NULL), SL_OK);
        assert_true(at.time_seconds == 2.0);
        sl_live_stop(live, NULL);
        sl_scene_destroy(scene);
    }
}

/* Memory that nobody has cleared holds numbers below 0 here. */
static void colours_for_frames_are_the_pictures(void **state) {
    static const char *const names[3] = {"R", "G", "B"};
    mallopt(M_PERTURB, 0x5a);
    for (int m = 0; m < 2 * METHODS; m++) {
        sl_scene *scene = load_scene("scenes/cornell-mirror.json");
        const sl_settings settings = draft(methods[m / 2]);
        sl_method *method = created_method(scene, &settings);
        sl_image *picture, *colours;
        if (m % 2) picture = finished_picture(method);
        else assert_int_equal(sl_method_resolve(method, &picture, NULL), SL_OK); /* nothing is drawn yet */
        assert_int_equal(sl_method_resolve_colours(method, &colours, NULL), SL_OK);
        assert_int_equal(colours->channels, 3);
        for (int i = 0; i < 3 * W * H; i++) assert_true(colours->planes[i] >= 0.0f);
        for (int c = 0; c < 3; c++)
            assert_memory_equal(colours->planes + c * W * H, sl_image_channel(picture, names[c]),
                                W * H * sizeof(float));
        destroy_pictures(picture, colours);
        destroy_method(method, scene);
    }
    mallopt(M_PERTURB, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_picture_of_a_show_has_light),
        cmocka_unit_test(what_is_shown_follows_what_moves),
        cmocka_unit_test(colours_for_frames_are_the_pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
