/* Trials in processes of their own: whatever they do, it is told. */
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "unit_test.h"
#include "app/bench/child.h"

static bool tell_much(void *context, char **report) {
    size_t size = *(const size_t *)context;
    *report = calloc(size + 1, 1);
    if (*report) memset(*report, 'x', size);
    return true;
}

static bool crash(void *context, char **report) {
    raise(SIGABRT);
    return true;
}

static bool leave(void *context, char **report) {
    _exit(7);
}

static bool never_end(void *context, char **report) {
    while (sleep(1) == 0) {}
    return true;
}

static bool is_interrupted(void) { return true; }

static sl_child_end run(sl_child_work *work, void *context, sl_child_limits limits) {
    sl_child_end end;
    sl_error error;
    assert_int_equal(sl_child_run(work, context, &limits, &end, &error), SL_OK);
    assert_non_null(end.text);
    return end;
}

static void a_report_longer_than_a_pipe_holds_arrives_whole(void **state) {
    size_t size = 300000;
    sl_child_end end = run(tell_much, &size, (sl_child_limits){0});
    assert_int_equal(end.outcome, SL_CHILD_DONE);
    assert_int_equal(strlen(end.text), size);
    free(end.text);
}

static void a_child_that_crashes_is_told_by_its_signal(void **state) {
    sl_child_end end = run(crash, NULL, (sl_child_limits){0});
    assert_int_equal(end.outcome, SL_CHILD_CRASHED);
    assert_string_equal(end.why, "Aborted");
    free(end.text);
}

static void a_child_that_leaves_without_a_word_has_crashed(void **state) {
    sl_child_end end = run(leave, NULL, (sl_child_limits){0});
    assert_int_equal(end.outcome, SL_CHILD_CRASHED);
    assert_non_null(strstr(end.why, "7"));
    free(end.text);
}

static void a_child_that_does_not_end_is_stopped_by_the_clock_or_by_somebody(void **state) {
    sl_child_end end = run(never_end, NULL, (sl_child_limits){.interrupted = is_interrupted});
    assert_int_equal(end.outcome, SL_CHILD_LEFT_OUT);
    free(end.text);
    end = run(never_end, NULL, (sl_child_limits){.seconds = 0.1});
    assert_int_equal(end.outcome, SL_CHILD_STOPPED);
    assert_non_null(strstr(end.why, "0.1 seconds"));
    free(end.text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_report_longer_than_a_pipe_holds_arrives_whole),
        cmocka_unit_test(a_child_that_crashes_is_told_by_its_signal),
        cmocka_unit_test(a_child_that_leaves_without_a_word_has_crashed),
        cmocka_unit_test(a_child_that_does_not_end_is_stopped_by_the_clock_or_by_somebody),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
