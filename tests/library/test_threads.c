/* The library in programs that have threads of their own: a method a thread on one scene that is edited in
 * between, and within a parallel region. */
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unit_test.h"
#include "base/sanitized.h"
#include "rendering.h"

typedef struct {
    const char *scene, *method;
    unsigned threads;
    sl_image *image;
} job;

/* No assertion here: cmocka's belong to the thread that runs the tests. */
static void *work(void *context) {
    job *j = context;
    sl_scene *scene = NULL;
    sl_method *method = NULL;
    sl_progress progress = {0};
    sl_settings settings = sl_settings_default();
    settings.method = j->method;
    settings.width = 24;
    settings.height = 20;
    settings.quality = SL_QUALITY_DRAFT;
    settings.threads = j->threads;
    sl_status status = sl_scene_load(j->scene, &scene, NULL);
    if (status == SL_OK) status = sl_method_create(scene, &settings, &method, NULL);
    while (status == SL_OK && !progress.done) status = sl_method_update(method, &progress, NULL);
    if (status == SL_OK) (void)sl_method_resolve(method, &j->image, NULL);
    destroy_method(method, scene);
    return NULL;
}

/* ---- one scene ---- */

typedef struct follower {
    const sl_scene *scene;
    const char *name;
    sl_method *method;
    sl_image *image;
} follower;

/* Creates a method, or follows the scene's edit; then finishes. No assertion here, either. */
static void *follow(void *context) {
    follower *f = context;
    sl_progress progress = {0};
    sl_settings settings = small_settings(f->name, 16, 16);
    settings.filter = SL_FILTER_CENTRE;
    settings.spp = 1;
    settings.bounces = 1;
    settings.light_octree.photons = 4096;
    settings.light_octree.depth = 3;
    settings.shading_cache.indirect_samples = 4;
    settings.shading_cache.updates = 10;
    sl_status status = f->method ? sl_method_edit(f->method, 0, NULL)
                                 : sl_method_create(f->scene, &settings, &f->method, NULL);
    while (status == SL_OK && !progress.done) status = sl_method_update(f->method, &progress, NULL);
    sl_image_destroy(f->image);
    f->image = NULL;
    if (status == SL_OK) (void)sl_method_resolve(f->method, &f->image, NULL);
    return NULL;
}

static void follow_at_once(follower *followers, size_t count) {
    pthread_t thread[8];
    for (size_t i = 0; i < count; i++)
        assert_int_equal(pthread_create(&thread[i], NULL, follow, &followers[i]), 0);
    for (size_t i = 0; i < count; i++) assert_int_equal(pthread_join(thread[i], NULL), 0);
}

static void a_method_a_thread_follows_one_scene_as_alone(void **state) {
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_scene_edit *edit;
    const float eye[3] = {278, 273, -700}, target[3] = {278, 273, 0}, up[3] = {0, 1, 0};
    follower together[8] = {{0}};
    size_t count = 0;
    for (; sl_method_name(count); count++)
        together[count] = (follower){scene, sl_method_name(count), NULL, NULL};
    assert_true(count <= 8);
    follow_at_once(together, count);
    assert_int_equal(sl_scene_edit_begin(scene, &edit, NULL), SL_OK);
    assert_int_equal(sl_edit_remove_object(edit, sl_scene_find_object(scene, "short_box"), NULL), SL_OK);
    assert_int_equal(sl_edit_camera(edit, eye, target, up, 0.7f, NULL), SL_OK);
    assert_int_equal(sl_scene_edit_commit(edit, NULL, NULL), SL_OK);
    follow_at_once(together, count);
    for (size_t i = 0; i < count; i++) {
        follower alone = {scene, together[i].name, NULL, NULL};
        follow(&alone);
        assert_non_null(alone.image);
        assert_non_null(together[i].image);
        assert_true(same_picture(alone.image, together[i].image));
        destroy_pictures(alone.image, together[i].image);
        sl_method_destroy(alone.method);
        sl_method_destroy(together[i].method);
    }
    sl_scene_destroy(scene);
}

static void in_a_parallel_region_every_thread_gets_the_same_picture(void **state) {
    job alone = {"scenes/cornell.json", "splatting", 1, NULL}, within[3];
    for (int i = 0; i < 3; i++) within[i] = (job){"scenes/cornell.json", "splatting", 4, NULL};
    work(&alone);
#pragma omp parallel for num_threads(3)
    for (int i = 0; i < 3; i++) work(&within[i]);
    assert_non_null(alone.image);
    for (int i = 0; i < 3; i++) {
        assert_non_null(within[i].image);
        assert_true(same_picture(alone.image, within[i].image));
        sl_image_destroy(within[i].image);
    }
    sl_image_destroy(alone.image);
}

/* ---- little stacks --------------------------------------------------------------------------- */

enum { MAIN_STACK = 256 << 10 }; /* what softlux.h names; workers have 128 KiB */
static const char *const stack_scenes[] = {"scenes/cornell-glossy.json", "scenes/mirror-balls.json"};

/* In a process of its own: stacks are made when it begins. Crashes where they are too small. */
static int render_all_on_little_stacks(const char *scene) {
    for (size_t i = 0; sl_method_name(i); i++) {
        job j = {scene, sl_method_name(i), 2, NULL};
        work(&j);
        if (!j.image) return 2;
        sl_image_destroy(j.image);
    }
    return 0;
}

static void every_method_works_on_the_stacks_that_the_header_names(void **state) {
    if (SL_SANITIZED) skip(); /* whose frames are larger */
    for (int i = 0; i < 2; i++) {
        int ended = -1;
        pid_t child = fork();
        if (child == 0) {
            setrlimit(RLIMIT_STACK, &(struct rlimit){MAIN_STACK, MAIN_STACK});
            setenv("OMP_STACKSIZE", "128K", 1);
            execl("/proc/self/exe", "test_threads", stack_scenes[i], (char *)NULL);
            _exit(77);
        }
        assert_int_equal(waitpid(child, &ended, 0), child);
        if (ended) fail_msg("%s: ended with 0x%x", stack_scenes[i], (unsigned)ended);
    }
}

int main(int argc, char **argv) {
    if (argc > 1) return render_all_on_little_stacks(argv[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_method_a_thread_follows_one_scene_as_alone),
        cmocka_unit_test(in_a_parallel_region_every_thread_gets_the_same_picture),
        cmocka_unit_test(every_method_works_on_the_stacks_that_the_header_names)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
