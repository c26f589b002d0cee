/* Processes that fork once the library has worked on several threads, as test runners and Python's
 * multiprocessing do: the child has none of those threads, and works all the same, to the same bits. */
#define _DEFAULT_SOURCE

#include <signal.h>
#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unit_test.h"
#include "least_settings.h"
#include "rendering.h"

enum { SECONDS = 30, DIFFERS = 1 };

static const char room[] = "scenes/moving-ball.json";

/* No assertion here, nor what of cmocka's a child would end by: it has no tests to go on with. */
static sl_image *finish(sl_method *method) {
    sl_progress progress = {0};
    sl_image *image = NULL;
    sl_status status = SL_OK;
    while (status == SL_OK && !progress.done) status = sl_method_update(method, &progress, NULL);
    if (status == SL_OK) (void)sl_method_resolve(method, &image, NULL);
    return image;
}

static sl_method *made(const sl_scene *scene, const char *name, unsigned threads) {
    sl_settings settings = least_settings(name, 14, 10);
    sl_method *method = NULL;
    settings.threads = threads;
    (void)sl_method_create(scene, &settings, &method, NULL);
    return method;
}

static bool gives(sl_method *method, const sl_image *expected) {
    sl_image *image = method ? finish(method) : NULL;
    bool same = image && same_picture(image, expected);
    sl_image_destroy(image);
    sl_method_destroy(method);
    return same;
}

static _Noreturn void be_a_child(const sl_scene *scene, const char *name, sl_method *begun,
                                 const sl_image *expected) {
    signal(SIGALRM, SIG_DFL);
    alarm(SECONDS);
    bool same = gives(begun, expected);
    for (unsigned threads = 1; threads <= 3; threads++) same &= gives(made(scene, name, threads), expected);
    _exit(same ? 0 : DIFFERS);
}

static void assert_ends_well(pid_t child, const char *name) {
    int how = 0;
    assert_int_equal(waitpid(child, &how, 0), child);
    if (WIFSIGNALED(how)) {
        fail_msg("%s: %s", name, WTERMSIG(how) == SIGALRM ? "the child hangs" : "the child crashes");
    }
    if (WEXITSTATUS(how) != 0) fail_msg("%s: the child has another picture, or none", name);
}

static void a_forked_child_renders_the_same_bits_by_every_method_at_any_threads(void **state) {
    sl_scene *scene = load_scene(room);
    for (size_t m = 0; sl_method_name(m); m++) {
        const char *name = sl_method_name(m);
        sl_progress progress = {0};
        sl_method *whole = made(scene, name, 2), *begun = made(scene, name, 2);
        sl_image *expected = finish(whole);
        assert_non_null(expected);
        assert_int_equal(sl_method_update(begun, &progress, NULL), SL_OK);
        pid_t child = fork();
        if (child == 0) be_a_child(scene, name, begun, expected);
        assert_ends_well(child, name);
        assert_true(gives(begun, expected)); /* and the parent goes on */
        sl_image_destroy(expected);
        sl_method_destroy(whole);
    }
    sl_scene_destroy(scene);
}

/* Enough triangles for Embree to build their hierarchy on several threads. */
static sl_scene *hills(void) {
    enum { SIDE = 60, LINE = 64 };
    static char text[((SIDE + 1) * (SIDE + 1) + SIDE * SIDE) * LINE];
    size_t size = 0;
    for (int i = 0; i < (SIDE + 1) * (SIDE + 1); i++) {
        size += (size_t)sprintf(text + size, "v %d %d %d\n", i % (SIDE + 1), i * 7 % 5, i / (SIDE + 1));
    }
    for (int y = 0; y < SIDE; y++) {
        for (int x = 0, i = y * (SIDE + 1) + 1; x < SIDE; x++, i++) {
            size += (size_t)sprintf(text + size, "f %d %d %d %d\n", i, i + SIDE + 1, i + SIDE + 2, i + 1);
        }
    }
    return scene_from_text("{\"softlux\": 1, \"meshes\": [{\"file\": \"mesh.obj\"}]}", text);
}

static void a_forked_child_builds_hierarchies_of_many_triangles(void **state) {
    sl_scene *scene = hills();
    for (int i = 0; i < 4; i++) {
        sl_method *begun = made(scene, "path", 3);
        sl_image *expected = finish(begun);
        assert_non_null(expected);
        pid_t child = fork();
        if (child == 0) be_a_child(scene, "path", begun, expected);
        assert_ends_well(child, "path");
        sl_image_destroy(expected);
        sl_method_destroy(begun);
    }
    sl_scene_destroy(scene);
}

static bool play(sl_scene *scene) {
    sl_settings settings = least_settings("shading-cache", 14, 10);
    const sl_image *frame = NULL;
    sl_live_state at = {0};
    sl_live *live = NULL;
    settings.threads = 2;
    sl_status status = sl_live_start(scene, &settings, &live, NULL);
    while (status == SL_OK && at.updates < 2 && !at.done) {
        usleep(1000);
        status = sl_live_frame(live, &frame, &at, NULL);
    }
    sl_live_stop(live, NULL);
    return status == SL_OK;
}

static void a_show_plays_in_the_child_of_a_process_that_has_played_one(void **state) {
    sl_scene *scene = load_scene(room);
    assert_true(play(scene));
    pid_t child = fork();
    if (child == 0) {
        signal(SIGALRM, SIG_DFL);
        alarm(SECONDS);
        bool played = play(scene);
        pid_t grandchild = fork();
        if (grandchild == 0) {
            alarm(SECONDS);
            _exit(play(scene) ? 0 : 1);
        }
        int how = 1;
        waitpid(grandchild, &how, 0);
        _exit(played && how == 0 ? 0 : 1);
    }
    assert_ends_well(child, "a show");
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_forked_child_renders_the_same_bits_by_every_method_at_any_threads),
        cmocka_unit_test(a_forked_child_builds_hierarchies_of_many_triangles),
        cmocka_unit_test(a_show_plays_in_the_child_of_a_process_that_has_played_one)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
