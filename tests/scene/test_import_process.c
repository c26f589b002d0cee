/* The importer at work in a process of its own, and whatever may become of that: the library and the program
 * say so in one line and go on. The importer is, but for a file that is sound, one of our own, in this
 * program: what it does is in the file's name. */
#define _GNU_SOURCE

#include <assimp/cimport.h>
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unit_test.h"
#include "base/memory.h"
#include "base/sanitized.h"
#include "import/serve.h"
#include "scene/import_process.h"
#include "scene/import_reply.h"
#include "scene_files.h"
#include "softlux.h"

/* ---- the importer -------------------------------------------------------------------------------------- */

enum { CALLERS = 77 /* a descriptor */ };

static bool is_called(const char *path, const char *name) { return strstr(path, name) != NULL; }

/* volatile: not to be seen through. */
static int nested(volatile int *deeper) {
    volatile int here[64] = {0};
    here[0] = *deeper + 1;
    return here[0] > 0 ? nested(here) + here[0] : 0; /* for ever: there is no stack for so many */
}

static void take_all_memory(void) {
    while (malloc(1 << 16)) {}
}

/* In place of Assimp's, which it calls. */
const struct aiScene *aiImportFileEx(const char *path, unsigned flags, struct aiFileIO *files) {
    static const struct aiScene *(*real)(const char *, unsigned, struct aiFileIO *);
    volatile int zero = 0;
    *(void **)&real = dlsym(RTLD_NEXT, "aiImportFileEx");
    if (is_called(path, "null")) return *(const struct aiScene *const volatile *)(uintptr_t)zero;
    if (is_called(path, "segment")) raise(SIGSEGV);
    if (is_called(path, "bus")) raise(SIGBUS);
    if (is_called(path, "divide")) raise(SIGFPE);
    if (is_called(path, "trap")) raise(SIGILL);
    if (is_called(path, "abort")) abort();
    if (is_called(path, "nested") && nested(&zero)) return NULL;
    if (is_called(path, "leave")) _exit(0);
    if (is_called(path, "peeks") && fcntl(CALLERS, F_GETFD) >= 0) return NULL;
    while (is_called(path, "sleeps")) pause();
    while (is_called(path, "turns")) zero = 0;
    if (is_called(path, "hungry")) return take_all_memory(), NULL;
    return real(path, flags, files);
}

/* The answer to a sound file, in part, or with more behind it, or with something else in it. */
static void answer_otherwise(int argc, char **argv) {
    static char reply[1 << 16];
    int answered = dup(STDOUT_FILENO), kept = fileno(tmpfile());
    dup2(kept, STDOUT_FILENO);
    pid_t child = fork();
    if (child == 0) sl_import_serve(argc, argv);
    waitpid(child, NULL, 0);
    ssize_t size = pread(kept, reply, sizeof reply, 0);
    if (is_called(argv[5], "cut")) size /= 2;
    if (is_called(argv[5], "twice")) size += pread(kept, reply + size, (size_t)size, 0);
    if (is_called(argv[5], "blurred")) memset(reply + 16, 0xa5, 64);
    if (is_called(argv[5], "noise")) memset(reply, 0x5a, (size_t)size);
    _exit(write(answered, reply, (size_t)size) == size ? 0 : 1);
}

static int be_the_importer(int argc, char **argv) {
    if (argc > 6 && is_called(argv[5], "answer")) answer_otherwise(argc, argv);
    return sl_import_serve(argc, argv);
}

/* ---- what becomes of it -------------------------------------------------------------------------------- */

static const char sound[] = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
                            "0\nendloop\nendfacet\nendsolid a\n";

static void use_own_importer(void) {
    char self[4096] = "";
    assert_true(readlink("/proc/self/exe", self, sizeof self - 1) > 0);
    setenv("SOFTLUX_IMPORTER", self, 1);
}

static void use_real_importer(void) { unsetenv("SOFTLUX_IMPORTER"); }

static sl_status load(const char *path, sl_error *error) {
    sl_scene *scene;
    sl_status status = sl_scene_load(path, &scene, error);
    if (status == SL_OK) assert_int_equal(sl_scene_triangle_count(scene), 1);
    else assert_null(scene);
    sl_scene_destroy(scene);
    return status;
}

static void assert_refused(const char *name, sl_status expected, const char *why) {
    sl_error error = {0};
    const char *path = scene_file_text(name, sound);
    assert_int_equal(load(path, &error), expected);
    if (!strstr(error.message, name) || !strstr(error.message, why) || strchr(error.message, '\n')) {
        fail_msg("expected '%s' in '%s'", why, error.message);
    }
}

static void however_the_importer_crashes_one_line_says_so_and_the_next_file_loads(void **state) {
    static const char *const ways[] = {"segment.stl", "bus.stl",    "divide.stl", "trap.stl",
                                       "abort.stl",   "nested.stl", "null.stl"};
    use_own_importer();
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        bool told_by_sanitizer = SL_SANITIZED; /* which ends the process in its own way */
        assert_refused(ways[i], SL_ERROR_INPUT,
                       told_by_sanitizer ? "the importer of mesh files"
                                         : "the importer of mesh files crashed on it");
        assert_int_equal(load(scene_file_text("sound.stl", sound), NULL), SL_OK);
    }
    assert_refused("leave.stl", SL_ERROR_INPUT, "ended without a whole answer");
}

static void answers_that_make_no_sense_are_refused(void **state) {
    use_own_importer();
    assert_refused("answer-cut.stl", SL_ERROR_INPUT, "ended without a whole answer");
    assert_refused("answer-twice.stl", SL_ERROR_INPUT, "ended without a whole answer");
    assert_refused("answer-noise.stl", SL_ERROR_INPUT, "ended without a whole answer");
    assert_refused("answer-blurred.stl", SL_ERROR_INPUT, "what it answers makes no sense");
}

static const sl_affine unmoved = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

static sl_status run_within(const char *name, sl_import_limits limits, sl_error *error) {
    void *reply;
    size_t size;
    sl_model model = {0};
    const char *path = scene_file_text(name, sound);
    sl_status status = sl_import_run(path, &unmoved, NULL, limits, &reply, &size, error);
    if (status == SL_OK) status = sl_import_reply_read(path, reply, size, &model, error);
    sl_model_clear(&model);
    sl_free(reply);
    return status;
}

static void an_importer_that_does_not_end_is_ended(void **state) {
    sl_error error;
    use_own_importer();
    assert_int_equal(run_within("sleeps.stl", (sl_import_limits){1, 60, 1u << 30}, &error), SL_ERROR_INPUT);
    assert_non_null(
        strstr(error.message,
               "sleeps.stl: cannot be read: the importer of mesh files took more than 1 seconds"));
    assert_int_equal(run_within("turns.stl", (sl_import_limits){100, 1, 1u << 30}, &error), SL_ERROR_INPUT);
    assert_non_null(strstr(
        error.message,
        "turns.stl: cannot be read: the importer of mesh files was ended, as it is after 1 seconds of work"));
}

static void an_importer_has_so_much_memory_and_no_more(void **state) {
    if (SL_SANITIZED) skip();
    sl_error error;
    use_own_importer();
    assert_int_equal(run_within("hungry.stl", (sl_import_limits){100, 60, 300u << 20}, &error),
                     SL_ERROR_RESOURCES);
}

static void where_the_importer_is_not_one_line_names_it(void **state) {
    setenv("SOFTLUX_IMPORTER", "/nowhere/softlux-import", 1);
    assert_refused(
        "sound.stl", SL_ERROR_RESOURCES,
        "the program that imports mesh files, /nowhere/softlux-import, cannot be started: No such file");
    use_real_importer();
    assert_int_equal(load(scene_file_path("sound.stl"), NULL), SL_OK);
}

/* ---- the caller's own ---------------------------------------------------------------------------------- */

static void reap_all(int number) {
    int before = errno;
    while (waitpid(-1, NULL, WNOHANG) > 0) {}
    errno = before;
}

static void whatever_the_caller_does_about_children_files_load(void **state) {
    static void (*const ways[])(int) = {SIG_IGN, reap_all, SIG_DFL};
    const char *path = scene_file_text("sound.stl", sound);
    use_own_importer();
    for (int i = 0; i < 3; i++) {
        struct sigaction now = {.sa_handler = ways[i]}, before;
        sigaction(SIGCHLD, &now, &before);
        sl_status first = load(path, NULL);
        assert_refused("segment.stl", SL_ERROR_INPUT, "the importer of mesh files");
        sl_status again = load(path, NULL);
        sigaction(SIGCHLD, &before, &now);
        assert_true(now.sa_handler == ways[i]);
        assert_int_equal(first, SL_OK);
        assert_int_equal(again, SL_OK);
    }
}

static int open_descriptors(void) {
    int count = 0;
    DIR *folder = opendir("/proc/self/fd");
    while (readdir(folder)) count++;
    closedir(folder);
    return count;
}

static void the_callers_children_and_descriptors_stay_its_own(void **state) {
    use_own_importer();
    int before = open_descriptors(), how = 0;
    assert_int_equal(dup2(STDOUT_FILENO, CALLERS), CALLERS);
    assert_int_equal(load(scene_file_text("peeks.stl", sound), NULL), SL_OK);
    close(CALLERS);
    pid_t child = fork();
    if (child == 0) _exit(7);
    assert_int_equal(load(scene_file_text("sound.stl", sound), NULL), SL_OK);
    assert_refused("segment.stl", SL_ERROR_INPUT, "the importer of mesh files");
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_int_equal(WEXITSTATUS(how), 7);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1); /* no child is left */
    assert_int_equal(open_descriptors(), before);
}

static void without_standard_streams_files_load(void **state) {
    const char *path = scene_file_text("sound.stl", sound);
    use_real_importer();
    int how = 0;
    pid_t child = fork();
    if (child == 0) {
        for (int i = 0; i < 3; i++) close(i);
        sl_scene *scene;
        _exit(sl_scene_load(path, &scene, NULL) == SL_OK ? 0 : 1);
    }
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_int_equal(how, 0);
}

static void *load_often(void *context) {
    int *loaded = context;
    sl_scene *scene;
    const char *path = scene_file_path("sound.stl");
    for (int i = 0; i < 6; i++) {
        bool there = sl_scene_load(path, &scene, NULL) == SL_OK;
        *loaded += there;
        if (there) sl_scene_destroy(scene);
    }
    return NULL;
}

static void threads_load_at_the_same_time(void **state) {
    pthread_t thread[4];
    int loaded[4] = {0};
    scene_file_text("sound.stl", sound);
    use_real_importer();
    for (int i = 0; i < 4; i++) assert_int_equal(pthread_create(&thread[i], NULL, load_often, &loaded[i]), 0);
    for (int i = 0; i < 4; i++) pthread_join(thread[i], NULL);
    for (int i = 0; i < 4; i++) assert_int_equal(loaded[i], 6);
}

/* ---- the answer, word by word -------------------------------------------------------------------------- */

/* A block as long as that, whose end the address sanitizer knows. */
static bool is_read(const void *bytes, size_t size) {
    sl_error error = {0};
    sl_model model = {0};
    sl_scene *scene = NULL;
    void *copy = malloc(size ? size : 1);
    memcpy(copy, bytes, size);
    sl_status status = sl_import_reply_read("a.ply", copy, size, &model, &error);
    const bool read = status == SL_OK;
    if (read) status = sl_model_build(&model, &scene, &error);
    if (status != SL_OK && !error.message[0]) fail_msg("an error that says nothing");
    sl_scene_destroy(scene);
    sl_model_clear(&model);
    free(copy);
    return read;
}

static void every_word_of_an_answer_may_be_wrong(void **state) {
    static const uint32_t wrong[] = {0, 1, 2, 0x7f, 0x7fffffff, 0xffffffff, 0x7fc00000};
    void *reply;
    size_t size;
    use_real_importer();
    assert_int_equal(sl_import_run("scenes/two-rooms.obj", &unmoved, NULL,
                                   sl_import_limits_of("scenes/two-rooms.obj"), &reply, &size, NULL),
                     SL_OK);
    char *bytes = reply;
    assert_true(is_read(bytes, size));
    for (size_t cut = 0; cut < size; cut += size < 4096 || cut < 4096 ? 1 : 61) {
        assert_false(is_read(bytes, cut));
    }
    for (size_t i = 0; i + 4 <= size; i += i < 1500 ? 3 : 97) {
        uint32_t before;
        memcpy(&before, bytes + i, 4);
        for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++)
            memcpy(bytes + i, &wrong[k], 4), is_read(bytes, size);
        memcpy(bytes + i, &before, 4);
    }
    sl_free(reply);
}

int main(int argc, char **argv) {
    if (argc > 6) return be_the_importer(argc, argv);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(however_the_importer_crashes_one_line_says_so_and_the_next_file_loads),
        cmocka_unit_test(answers_that_make_no_sense_are_refused),
        cmocka_unit_test(an_importer_that_does_not_end_is_ended),
        cmocka_unit_test(an_importer_has_so_much_memory_and_no_more),
        cmocka_unit_test(where_the_importer_is_not_one_line_names_it),
        cmocka_unit_test(whatever_the_caller_does_about_children_files_load),
        cmocka_unit_test(the_callers_children_and_descriptors_stay_its_own),
        cmocka_unit_test(without_standard_streams_files_load),
        cmocka_unit_test(threads_load_at_the_same_time),
        cmocka_unit_test(every_word_of_an_answer_may_be_wrong),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
