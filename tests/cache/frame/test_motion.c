/* Scenes that move without rest, a frame a move: frames have light, are near what they would be if the
 * scene stood still, and are the same at any number of threads. */
#include <math.h>

#include "unit_test.h"
#include "base/sanitized.h"
#include "rendering.h"

enum { SIZE = 24, WINDOW = 10, MOVES = SL_SANITIZED ? 50 : 400 };
enum { RAYS = SL_DIRECT_AUTO, MAPS = SL_DIRECT_SHADOW_MAPS };

typedef struct motion {
    const char *method, *scene;
    int moves;
    double most; /* relative RMS error of a window's last frame, against the picture of what stands still */
    uint32_t records; /* that splatting may make in a frame; others take one update a frame */
    int direct;
} motion;

/* Photons that are other ones make 0.06 of the octree's. Direct radiance mapping does all of a frame anew.
 * Splatting's records gather in turns, with few rays. */
static const motion motions[] = {{"light-octree", "scenes/moving-ball.json", MOVES, 0.12, 0, RAYS},
                                 {"light-octree", "scenes/moving-light.json", 50, 0.12, 0, RAYS},
                                 {"direct-radiance", "scenes/moving-ball.json", MOVES, 1e-6, 0, RAYS},
                                 {"direct-radiance", "scenes/moving-light.json", 100, 1e-6, 0, RAYS},
                                 {"splatting", "scenes/moving-ball.json", MOVES, 0.12, 32, RAYS},
                                 {"splatting", "scenes/moving-light.json", 100, 0.12, 32, RAYS},
                                 {"splatting", "scenes/moving-light.json", 20, 0.12, 32, MAPS}};

static sl_settings settings_of(const motion *m, unsigned threads) {
    sl_settings s = small_settings(m->method, SIZE, SIZE);
    s.filter = SL_FILTER_CENTRE;
    s.threads = threads;
    s.light_octree.depth = 3;
    s.light_octree.photons = 32768;
    s.light_octree.neighbours = 120;
    s.records_per_frame = m->records;
    s.direct = (sl_direct_kind)m->direct;
    return s;
}

static sl_image *frame_at(const motion *m, sl_method *method, sl_scene *scene, double time) {
    sl_progress progress = {0};
    sl_error error;
    go_to_time(scene, method, time);
    do good(sl_method_update(method, &progress, &error), &error);
    while (!progress.frame_done && m->records);
    assert_true(progress.frame_done);
    return resolved_picture(method);
}

static sl_image *next_frame(const motion *m, sl_method *method, sl_scene *scene, int move) {
    return frame_at(m, method, scene, time_of_move(move));
}

static double mean_of(const sl_image *image, const char *channel) {
    const float *plane = sl_image_channel(image, channel);
    double sum = 0.0;
    for (int i = 0; i < SIZE * SIZE; i++) sum += fmin((double)plane[i], 1.0) / (SIZE * SIZE);
    return sum;
}

static double error_of_frame(const motion *m, const sl_scene *scene, const sl_image *frame) {
    const sl_settings settings = settings_of(m, 2);
    sl_image *still = render(scene, &settings, NULL);
    const double error = displayed_difference(frame, still);
    sl_image_destroy(still);
    return error;
}

static void follow(const motion *m) {
    sl_scene *scene = load_scene(m->scene);
    const sl_settings one = settings_of(m, 1), three = settings_of(m, 3);
    sl_method *method[2] = {created_method(scene, &one), created_method(scene, &three)};
    double worst = 0.0, sum = 0.0;
    for (int move = 1; move <= m->moves; move++) {
        sl_image *frame = next_frame(m, method[0], scene, move);
        assert_true(mean_of(frame, "direct.G") > 0.01 && mean_of(frame, "indirect.G") > 0.005);
        if (move % WINDOW == 0) {
            const double now = error_of_frame(m, scene, frame);
            sum += now * WINDOW / m->moves;
            worst = fmax(worst, now);
        }
        if (move <= WINDOW) {
            sl_image *other = next_frame(m, method[1], scene, move);
            assert_true(same_picture(frame, other));
            sl_image_destroy(other);
        }
        sl_image_destroy(frame);
    }
    print_message("%s, %s: %.2f %% off in the mean, %.2f at most\n", m->method, m->scene, 100.0 * sum,
                  100.0 * worst);
    assert_true(worst < m->most);
    sl_method_destroy(method[0]);
    destroy_method(method[1], scene);
}

static void frames_of_what_moves_without_rest_are_near_those_of_what_stands_still(void **state) {
    for (size_t i = 0; i < sizeof motions / sizeof motions[0]; i++) follow(&motions[i]);
}

/* One edit, and whatever was going on: its rest is the picture of a method that is made for the scene as it
 * stands. */
static void what_comes_to_rest_is_the_picture_of_what_never_moved(void **state) {
    for (size_t i = 0; i < sizeof motions / sizeof motions[0]; i++) {
        const sl_settings settings = settings_of(&motions[i], 2);
        sl_scene *scene = load_scene(motions[i].scene);
        sl_method *method = created_method(scene, &settings);
        for (int move = 1; move < 5; move++) sl_image_destroy(next_frame(&motions[i], method, scene, move));
        sl_image *image = finished_picture(method), *still = render(scene, &settings, NULL);
        assert_true(same_picture(image, still));
        destroy_pictures(still, image);
        destroy_method(method, scene);
    }
}

/* A ball that moves by a millionth: photons are traced again in turns, and find the same. */
static void the_octrees_light_does_not_flash_where_nothing_moves(void **state) {
    const motion *m = &motions[0];
    const sl_settings settings = settings_of(m, 2);
    sl_scene *scene = load_scene(m->scene);
    sl_method *method = created_method(scene, &settings);
    sl_image *before = frame_at(m, method, scene, 0.5);
    for (int move = 1; move < 10; move++) {
        sl_image *frame = frame_at(m, method, scene, 0.5 + 1e-6 * move);
        assert_true(displayed_difference(frame, before) < 0.005);
        sl_image_destroy(before);
        before = frame;
    }
    sl_image_destroy(before);
    destroy_method(method, scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_of_what_moves_without_rest_are_near_those_of_what_stands_still),
        cmocka_unit_test(what_comes_to_rest_is_the_picture_of_what_never_moved),
        cmocka_unit_test(the_octrees_light_does_not_flash_where_nothing_moves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
