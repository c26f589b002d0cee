/* A system that starts no more threads: as many as there are do the work, to the same bits, and where there
 * is none at all the caller is told. */
#define _GNU_SOURCE

#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "unit_test.h"
#include "base/parallel.h"
#include "base/sanitized.h"
#include "rendering.h"

/* ---- such a system --------------------------------------------------------------------------- */

static atomic_int alive, refused;
static int most = INT_MAX;

#if !SL_SANITIZED /* which have one of their own */
typedef struct start {
    void *(*run)(void *);
    void *argument;
} start;

static void *run_and_be_counted(void *context) {
    const start s = *(start *)context;
    free(context);
    void *result = s.run(s.argument);
    atomic_fetch_sub(&alive, 1);
    return result;
}

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                   void *argument) {
    static int (*real)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "pthread_create");
    start *s = malloc(sizeof *s);
    if (!s || atomic_fetch_add(&alive, 1) >= most) {
        atomic_fetch_sub(&alive, 1);
        atomic_fetch_add(&refused, 1);
        free(s);
        return EAGAIN;
    }
    *s = (start){run, argument};
    return real(thread, attributes, run_and_be_counted, s);
}
#endif

static void at_most_as_many_as_now_and(int more) {
    most = more == INT_MAX ? INT_MAX : atomic_load(&alive) + more;
    atomic_store(&refused, 0);
}

/* ---- what comes of it ------------------------------------------------------------------------ */

enum { TASKS = 1000 };

typedef struct tasks {
    atomic_int done[TASKS];
    atomic_uint largest_worker;
} tasks;

static void note(void *context, size_t index, unsigned worker) {
    tasks *t = context;
    atomic_fetch_add(&t->done[index], 1);
    for (unsigned largest = atomic_load(&t->largest_worker);
         worker > largest && !atomic_compare_exchange_weak(&t->largest_worker, &largest, worker);) {}
}

static void loops_are_done_by_the_threads_that_there_are(void **state) {
    if (SL_SANITIZED) skip();
    for (int more = 0; more <= 3; more++) {
        static tasks t;
        t = (tasks){.largest_worker = 0};
        at_most_as_many_as_now_and(more == 3 ? 1 : more); /* there is a team of as many by then */
        sl_parallel_for(7, TASKS, note, &t);
        assert_true(atomic_load(&refused) > 0);
        for (int i = 0; i < TASKS; i++) assert_int_equal(atomic_load(&t.done[i]), 1);
        assert_true(atomic_load(&t.largest_worker) <= 4); /* all that were ever had */
    }
}

static sl_settings of_threads(const char *name, unsigned threads) {
    sl_settings settings = small_settings(name, 24, 20);
    settings.threads = threads;
    return settings;
}

static void without_any_thread_what_needs_one_says_so(void **state) {
    if (SL_SANITIZED) skip();
    sl_scene *scene = load_scene("scenes/cornell.json");
    sl_settings settings = of_threads("path", 4);
    sl_method *method;
    sl_error error;
    at_most_as_many_as_now_and(0);
    assert_int_equal(sl_method_create(scene, &settings, &method, &error), SL_ERROR_RESOURCES);
    assert_null(method);
    sl_scene_destroy(scene);
}

static void with_fewer_threads_than_were_asked_for_pictures_are_the_same(void **state) {
    if (SL_SANITIZED) skip();
    sl_scene *scene = load_scene("scenes/cornell.json");
    int wanted_more = 0;
    for (size_t m = 0; sl_method_name(m); m++) {
        const sl_settings few = of_threads(sl_method_name(m), 1), many = of_threads(sl_method_name(m), 9);
        at_most_as_many_as_now_and(INT_MAX);
        sl_image *expected = render(scene, &few, NULL);
        at_most_as_many_as_now_and(2);
        sl_image *image = render(scene, &many, NULL);
        wanted_more += atomic_load(&refused) > 0;
        assert_true(same_picture(image, expected));
        destroy_pictures(image, expected);
    }
    assert_true(wanted_more > 3); /* in so small a picture not all do */
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_any_thread_what_needs_one_says_so),
        cmocka_unit_test(loops_are_done_by_the_threads_that_there_are),
        cmocka_unit_test(with_fewer_threads_than_were_asked_for_pictures_are_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
