/* An importer that crashes, in every way in which a reader of strangers' files can: the program says so in one line and ends as with other damaged files. The
 * importer is one of our own that stands in for the library's. With sanitizers, which tell of crashes themselves, there is nothing to see. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <assimp/cimport.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/load.h"
#include "base/sanitized.h"
#include "scene_files.h"

/* ---- the importer ------------------------------------------------------------------------------------------------------------------- */

typedef enum way { FINDS_NOTHING, READS_NULL, READS_BEYOND_A_FILE, DIVIDES_BY_ZERO, TRAPS, ABORTS, NESTS, TWO_THREADS, WAYS } way;
static way how;

/* volatile: not to be seen through. */
static int nested(volatile int *deeper) {
    volatile int here[64] = {0};
    here[0] = *deeper + 1;
    return here[0] > 0 ? nested(here) + here[0] : 0; /* for ever: there is no stack for so many */
}

static void read_beyond_a_file(void) {
    FILE *file = tmpfile();
    const long page = sysconf(_SC_PAGESIZE);
    volatile const char *bytes = mmap(NULL, (size_t)page, PROT_READ, MAP_SHARED, fileno(file), 0);
    (void)bytes[0];
}

static void *crash(void *context) {
    (void)context;
    raise(SIGSEGV);
    return NULL;
}

/* In place of the library's, which the tests' other half (the program) calls. */
const struct aiScene *aiImportFileEx(const char *path, unsigned flags, struct aiFileIO *files) {
    volatile int zero = 0;
    pthread_t thread;
    (void)path;
    (void)flags;
    (void)files;
    switch (how) {
    case READS_NULL: return *(const struct aiScene *const volatile *)(uintptr_t)zero;
    case READS_BEYOND_A_FILE: read_beyond_a_file(); break;
    case DIVIDES_BY_ZERO: raise(SIGFPE); break; /* not every processor minds */
    case TRAPS: raise(SIGILL); break;
    case ABORTS: abort();
    case NESTS: return nested(&zero) ? NULL : NULL;
    case TWO_THREADS:
        pthread_create(&thread, NULL, crash, NULL);
        crash(NULL);
        pthread_join(thread, NULL);
        break;
    default: break;
    }
    return NULL;
}

/* ---- what is said of it -------------------------------------------------------------------------------------------------------------- */

enum { CRASHES = 5 };
static const int crashes[CRASHES] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

static void load_in_a_child(const char *path, int said) {
    const struct rlimit small_stack = {1 << 20, 1 << 20}, no_core = {0, 0};
    sl_scene *scene;
    sl_error error;
    setrlimit(RLIMIT_STACK, &small_stack);
    setrlimit(RLIMIT_CORE, &no_core);
    dup2(said, STDERR_FILENO);
    for (int i = 0; i < CRASHES; i++) signal(crashes[i], SIG_DFL); /* cmocka's */
    sl_status status = sl_load_scene(path, &(sl_load_options){0}, &scene, &error);
    dprintf(STDERR_FILENO, "softlux: %s\n", status == SL_OK ? "" : error.message);
    _exit((int)status);
}

static void assert_one_line_of(const char *path, way in_which_way, const char *why) {
    char said[8192] = "";
    int ends[2], status;
    size_t length = 0;
    how = in_which_way;
    assert_int_equal(pipe(ends), 0);
    pid_t child = fork();
    if (child == 0) load_in_a_child(path, ends[1]);
    close(ends[1]);
    for (ssize_t got; (got = read(ends[0], said + length, sizeof said - 1 - length)) > 0;) length += (size_t)got;
    close(ends[0]);
    assert_int_equal(waitpid(child, &status, 0), child);
    if (!WIFEXITED(status)) fail_msg("way %d: signal %d, and '%s'", (int)how, WTERMSIG(status), said);
    assert_int_equal(WEXITSTATUS(status), SL_ERROR_INPUT);
    if (how == TWO_THREADS && length > 0) { /* both may come to say it */
        char *second = strstr(said + 1, "softlux: ");
        if (second && memcmp(said, second, strlen(second)) == 0) *second = '\0';
    }
    length = strlen(said);
    assert_true(length > 0 && strncmp(said, "softlux: ", 9) == 0);
    if (strchr(said, '\n') != said + length - 1) fail_msg("expected one line, not '%s'", said);
    if (!strstr(said, why)) fail_msg("expected '%s' in '%s'", why, said);
}

static void however_the_importer_crashes_one_line_says_so(void **state) {
    (void)state;
    if (SL_SANITIZED) skip();
    const char *path = scene_file_text("a.stl", "solid a\nendsolid a\n");
    for (int i = 0; i < WAYS; i++) assert_one_line_of(path, (way)i, i == FINDS_NOTHING ? "cannot be read as a mesh" : "a.stl: cannot be read: the importer");
}

static void the_line_is_one_whatever_the_file_is_called(void **state) {
    (void)state;
    if (SL_SANITIZED) skip();
    assert_one_line_of(scene_file_text("two\nlines.stl", "solid a\nendsolid a\n"), READS_NULL, "two lines.stl: cannot be read");
    assert_one_line_of(scene_file_text("percent %s%n.stl", "solid a\nendsolid a\n"), ABORTS, "percent %s%n.stl: cannot be read");
}

/* Commands that load and go on have their own signals, and their own stack for them, again. */
static void what_was_to_be_done_about_crashes_before_is_so_again(void **state) {
    (void)state;
    static char own_stack[1 << 16];
    const stack_t own = {.ss_sp = own_stack, .ss_size = sizeof own_stack};
    struct sigaction before[CRASHES], after;
    stack_t stack;
    const int ours = (int)(SA_ONSTACK | SA_RESETHAND | SA_SIGINFO); /* not what the C library adds */
    sl_scene *scene;
    how = FINDS_NOTHING;
    const char *path = scene_file_text("a.stl", "solid a\nendsolid a\n");
    stack_t found;
    assert_int_equal(sigaltstack(&own, &found), 0);
    for (int i = 0; i < CRASHES; i++) sigaction(crashes[i], NULL, &before[i]);
    assert_int_equal(sl_load_scene(path, &(sl_load_options){0}, &scene, NULL), SL_ERROR_INPUT);
    for (int i = 0; i < CRASHES; i++) {
        sigaction(crashes[i], NULL, &after);
        assert_true(after.sa_handler == before[i].sa_handler && (after.sa_flags & ours) == (before[i].sa_flags & ours));
    }
    assert_int_equal(sigaltstack(&found, &stack), 0);
    assert_true(stack.ss_sp == own_stack);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(however_the_importer_crashes_one_line_says_so),
        cmocka_unit_test(the_line_is_one_whatever_the_file_is_called),
        cmocka_unit_test(what_was_to_be_done_about_crashes_before_is_so_again),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
