/* The files that commands write, and what they say of them: each command runs in a process of its own. */
#define _XOPEN_SOURCE 700

#include <cjson/cJSON.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "unit_test.h"
#include "app/commands.h"
#include "command.h"
#include "scene_files.h"
#include "softlux.h"

/* ---- running a command ----------------------------------------------------------------------- */

enum { WORD = 300, TEXT = 1 << 16 };
static char out[TEXT], err[TEXT]; /* what the last command said */

static void read_text(const char *name, char text[TEXT]) {
    FILE *file = fopen(scene_file_path(name), "rb");
    assert_non_null(file);
    size_t size = fread(text, 1, TEXT - 1, file);
    text[size] = '\0';
    fclose(file);
}

/* Starts a command; a word that begins with %/ names a file in the test's folder. */
static pid_t start(command *run_it, const char *line) {
    const char *base = scene_file_path(""), *said = scene_file_path("out");
    pid_t child = command_start(run_it, line, base, said, scene_file_path("err"));
    assert_true(child > 0);
    return child;
}

static int end_of(pid_t child) {
    int ended = 0;
    assert_int_equal(waitpid(child, &ended, 0), child);
    read_text("out", out);
    read_text("err", err);
    return ended;
}

static void expect(int status, command *run_it, const char *line) {
    int ended = end_of(start(run_it, line));
    if (!WIFEXITED(ended) || WEXITSTATUS(ended) != status)
        fail_msg("%s: ended with %x, expected status %d: %s", line, (unsigned)ended, status, err);
}

static bool says(const char *text, const char *part) { return strstr(text, part) != NULL; }

static bool are_same_files(const char *a, const char *b) {
    static char bytes[2][TEXT];
    size_t size[2];
    const char *const names[2] = {a, b};
    for (int i = 0; i < 2; i++) {
        FILE *file = fopen(scene_file_path(names[i]), "rb");
        assert_non_null(file);
        size[i] = fread(bytes[i], 1, TEXT, file);
        fclose(file);
    }
    assert_true(size[0] > 0 && size[0] < TEXT);
    return size[0] == size[1] && memcmp(bytes[0], bytes[1], size[0]) == 0;
}

/* ---- the same picture is the same file ------------------------------------------------------- */

static const char cornell[] = "scenes/cornell.json -s 12x12 -q draft --quiet";

static void two_runs_write_the_same_bytes(void **state) {
    static const char *const ends[] = {"exr", "png", "pfm"};
    char line[300];
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 2; k++) {
            snprintf(line, sizeof line, "%s -t %d -o %%/same%d.%s --save-cache %%/same%d.cache --json",
                     cornell, k + 1, k, ends[i], k);
            expect(0, sl_command_render, line);
            assert_true(says(out, "\"seconds\"")); /* where it belongs */
        }
        char names[2][32];
        for (int k = 0; k < 2; k++) snprintf(names[k], sizeof names[k], "same%d.%s", k, ends[i]);
        if (!are_same_files(names[0], names[1])) fail_msg("two .%s files differ", ends[i]);
        assert_true(are_same_files("same0.cache", "same1.cache"));
    }
}

static void a_picture_stopped_by_the_clock_is_the_file_of_its_batches(void **state) {
    char line[300], batches[32];
    const char *rest = "scenes/cornell.json -s 12x12 -m path --quiet -t 1";
    snprintf(line, sizeof line, "%s --time 0.05 -o %%/timed.exr", rest);
    expect(0, sl_command_render, line);
    sl_image *image;
    assert_int_equal(sl_image_read(scene_file_path("timed.exr"), &image, NULL), SL_OK);
    snprintf(batches, sizeof batches, "%.20s", sl_image_metadata(image, "softlux.batches"));
    snprintf(line, sizeof line, "%s --spp %.20s --batches %s -o %%/counted.exr", rest,
             sl_image_metadata(image, "softlux.spp"), batches);
    sl_image_destroy(image);
    expect(0, sl_command_render, line);
    assert_true(are_same_files("timed.exr", "counted.exr"));
}

/* ---- the tone of 8-bit pictures -------------------------------------------------------------- */

static void write_grey(const char *name, float value, const sl_tone *tone) {
    sl_image *image;
    assert_int_equal(sl_image_create(8, 8, 3, NULL, &image, NULL), SL_OK);
    for (int i = 0; i < 3 * 64; i++) image->planes[i] = value * (1.0f + 0.01f * (float)(i % 64));
    sl_status status = tone ? sl_image_write_png(image, scene_file_path(name), *tone, NULL)
                            : sl_image_write(image, scene_file_path(name), NULL);
    sl_image_destroy(image);
    assert_int_equal(status, SL_OK);
}

static void write_greys(void) {
    static const sl_tone automatic = {SL_TONE_REINHARD, 0.0f, true}, fixed = {SL_TONE_REINHARD, 1.0f, false},
                         other = {SL_TONE_REINHARD, 0.0f, false};
    write_grey("dim.exr", 0.1f, NULL);
    write_grey("bright.exr", 0.2f, NULL);
    write_grey("dim-auto.png", 0.1f, &automatic);
    write_grey("bright-auto.png", 0.2f, &automatic);
    write_grey("dim-fixed.png", 0.1f, &fixed);
    write_grey("bright-fixed.png", 0.2f, &fixed);
    write_grey("bright-other.png", 0.2f, &other);
}

static void automatic_and_different_exposures_draw_a_warning(void **state) {
    write_greys();
    expect(0, sl_command_compare, "%/dim-auto.png %/bright-auto.png --identical");
    assert_true(says(err, "warning: ") && says(err, "automatic"));
    assert_true(says(out, "tone_image ") && says(out, "reinhard") && says(out, "tone_reference "));
    assert_false(are_same_files("dim-auto.png", "bright-auto.png"));
    expect(0, sl_command_compare, "%/dim-fixed.png %/bright-other.png");
    assert_true(says(err, "warning: ") && says(err, "exposures differ") && !says(err, "automatic"));
    expect(1, sl_command_compare, "%/dim-fixed.png %/bright-fixed.png --identical");
    assert_false(says(err, "warning: "));
    expect(0, sl_command_compare, "%/dim.exr %/dim.exr --identical");
    assert_true(err[0] == '\0' && !says(out, "tone_"));
}

static void json_tells_the_tones(void **state) {
    write_greys();
    expect(0, sl_command_compare, "%/dim-fixed.png %/bright-auto.png --json");
    cJSON *root = cJSON_Parse(out);
    assert_non_null(root);
    const cJSON *tone = cJSON_GetObjectItem(root, "tone_reference");
    assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(tone, "curve")), "reinhard");
    assert_true(cJSON_IsTrue(cJSON_GetObjectItem(tone, "automatic")));
    assert_float_equal(cJSON_GetNumberValue(cJSON_GetObjectItem(tone, "exposure")), -0.5, 0.2);
    tone = cJSON_GetObjectItem(root, "tone_image");
    assert_true(cJSON_IsFalse(cJSON_GetObjectItem(tone, "automatic")));
    cJSON_Delete(root);
    expect(0, sl_command_compare, "%/dim.exr %/dim.exr --json");
    assert_non_null(root = cJSON_Parse(out));
    assert_true(cJSON_IsNull(cJSON_GetObjectItem(root, "tone_image")));
    cJSON_Delete(root);
}

static void radiance_is_not_compared_with_what_a_screen_shows(void **state) {
    write_greys();
    expect(3, sl_command_compare, "%/dim.exr %/dim-auto.png --identical");
    assert_true(says(err, "dim.exr is radiance, ") && says(err, "dim-auto.png is not: "));
    expect(3, sl_command_compare, "scenes/bricks.png %/dim.exr");
    assert_true(says(err, "dim.exr is radiance, scenes/bricks.png is not: "));
}

static void a_png_that_tells_no_tone_is_compared_with_another(void **state) {
    expect(0, sl_command_compare, "scenes/bricks.png scenes/bricks.png --identical");
    assert_true(says(out, "unknown"));
}

static void a_rendered_png_tells_its_exposure(void **state) {
    expect(0, sl_command_render, "scenes/cornell.json -s 8x8 -m path --spp 1 --quiet -o %/auto.png --json");
    cJSON *root = cJSON_Parse(out), *tone = cJSON_GetObjectItem(root, "tone");
    char line[300];
    assert_true(cJSON_IsTrue(cJSON_GetObjectItem(tone, "automatic")));
    snprintf(line, sizeof line,
             "scenes/cornell.json -s 8x8 -m path --spp 1 --quiet -o %%/told.png --json --exposure %.9g",
             cJSON_GetNumberValue(cJSON_GetObjectItem(tone, "exposure")));
    cJSON_Delete(root);
    expect(0, sl_command_render, line);
    assert_true(says(out, "\"automatic\":\tfalse"));
    expect(0, sl_command_compare, "%/auto.png %/told.png --max-abs 0.02");
    expect(0, sl_command_render, "scenes/cornell.json -s 8x8 -m path --spp 1 --quiet -o %/a.exr --json");
    assert_false(says(out, "\"tone\""));
}

/* ---- JSON ------------------------------------------------------------------------------------ */

static void json_is_utf_8_whatever_files_are_called(void **state) {
    static const char *const names[][2] = {
        {"\xff\xfe.pfm", "/??.pfm"},
        {"a\xc3.pfm", "/a?.pfm"},
        {"\xc0\xaf.pfm", "/??.pfm"},
        {"\xed\xa0\x80.pfm", "/???.pfm"},
        {"\xf4\x90\x80\x80.pfm", "/????.pfm"},
        {"\xc3\xbc\xe2\x82\xac\xf0\x9f\x98\x80.pfm", "/\xc3\xbc\xe2\x82\xac\xf0\x9f\x98\x80.pfm"},
    };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char line[300];
        snprintf(line, sizeof line,
                 "scenes/cornell-point.json -s 4x4 -m path --spp 1 -t 1 --quiet --json -o %%/%s",
                 names[i][0]);
        expect(0, sl_command_render, line);
        if (!says(out, names[i][1])) fail_msg("expected %s in %s", names[i][1], out);
        assert_int_equal(access(scene_file_path(names[i][0]), F_OK), 0);
    }
    expect(0, sl_command_render,
           "scenes/cornell-point.json -s 4x4 -m path --spp 1 -t 1 --quiet --json --frames 1 -o %/\xff%d.pfm");
    assert_true(says(out, "/?0.pfm"));
}

/* ---- what cannot be written ------------------------------------------------------------------ */

/* Each has another mistake, too, which comes to light later: the scene, the picture or the method is not
 * there. */
static void what_cannot_be_written_is_noticed_before_the_work(void **state) {
    static const struct { command *run_it; const char *line; } cases[] = {
        {sl_command_render, "nowhere.json -o %/none/a.exr"},
        {sl_command_render, "nowhere.json --frames 3 -o %/none/a%d.png"},
        {sl_command_render, "nowhere.json -o %/a.pfm --save-cache %/none/a.cache"},
        {sl_command_render, "nowhere.json -o %/taken.exr"}, /* a folder */
        {sl_command_compare, "nowhere.exr nowhere.exr --difference %/none/d.png"},
        {sl_command_live, "nowhere.json --frames 1 -o %/none/a%d.png"},
        {sl_command_live, "nowhere.json --frames 1 -o %/none/a.y4m"},
        {sl_command_steps, "scenes/cornell.json -s 8x8 -q draft -o %/page"},
        {sl_command_bench, "nowhere.json --quiet --references /dev/null/references -o %/report"},
        {sl_command_bench, "nowhere.json --quiet --references %/references -o %/page"},
    };
    assert_int_equal(mkdir(scene_file_path("taken.exr"), 0777), 0);
    assert_int_equal(mkdir(scene_file_path("page"), 0777), 0);
    assert_int_equal(mkdir(scene_file_path("page/index.html"), 0777), 0);
    assert_int_equal(mkdir(scene_file_path("page/report.html"), 0777), 0);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect(4, cases[i].run_it, cases[i].line);
        if (!says(err, "cannot ") || strchr(err, '\n') != err + strlen(err) - 1)
            fail_msg("%s: %s", cases[i].line, err);
    }
}

/* Neither half a file is left by the look, nor is one that is there touched; a pipe's reader sees no end. */
static void looking_whether_a_file_can_be_written_leaves_no_trace(void **state) {
    FILE *file = fopen(scene_file_path("kept.pfm"), "wb");
    assert_true(file && fputs("kept", file) >= 0 && fclose(file) == 0);
    expect(3, sl_command_render, "nowhere.json -o %/kept.pfm");
    expect(3, sl_command_render, "nowhere.json -o %/new.pfm");
    expect(3, sl_command_render, "nowhere.json -o %/new%d.pfm --frames 2");
    read_text("kept.pfm", out);
    assert_string_equal(out, "kept");
    assert_int_equal(access(scene_file_path("new.pfm"), F_OK), -1);
    assert_int_equal(mkfifo(scene_file_path("pipe.pfm"), 0666), 0);
    alarm(20); /* opening it would wait for a reader */
    expect(3, sl_command_render, "nowhere.json -o %/pipe.pfm");
    alarm(0);
}

/* ---- signals --------------------------------------------------------------------------------- */

/* Waits until the process handles a signal itself. */
static void wait_for_handler(pid_t process, int signal_number) {
    char name[64], line[200];
    snprintf(name, sizeof name, "/proc/%d/status", (int)process);
    for (int i = 0; i < 3000; i++) {
        unsigned long long caught = 0;
        FILE *file = fopen(name, "r");
        while (file && fgets(line, sizeof line, file)) sscanf(line, "SigCgt: %llx", &caught);
        if (file) fclose(file);
        if (caught >> (signal_number - 1) & 1) return;
        nanosleep(&(struct timespec){0, 10000000}, NULL);
    }
    fail_msg("signal %d is not handled", signal_number);
}

/* Without end. */
static const char endless[] = "scenes/cornell-point.json -s 16x16 -m path --spp 100000000 -t 1";

static void expect_kept(const char *rest, int signal_number, const char *picture) {
    char line[300];
    snprintf(line, sizeof line, "%s %s -o %%/%s", endless, rest, picture);
    pid_t child = start(sl_command_render, line);
    wait_for_handler(child, signal_number);
    kill(child, signal_number);
    int ended = end_of(child);
    if (!WIFEXITED(ended) || WEXITSTATUS(ended) != 128 + signal_number)
        fail_msg("%s: ended with %x: %s", line, (unsigned)ended, err);
    assert_int_equal(access(scene_file_path(picture), F_OK), 0);
}

static void what_is_done_is_kept_whatever_ends_it_and_the_status_tells(void **state) {
    expect_kept("", SIGINT, "int.pfm");
    assert_true(says(err, "holds what was done"));
    expect_kept("", SIGTERM, "term.pfm");
    expect_kept("", SIGHUP, "hup.pfm");
    expect_kept("--error 0.01% --quiet", SIGINT, "error.pfm");
    expect_kept("--time 1000 --quiet", SIGHUP, "time.pfm");
}

static void who_ignores_that_the_terminal_closes_goes_on(void **state) { /* nohup */
    char line[300];
    snprintf(line, sizeof line, "%s -o %%/nohup.pfm", endless);
    signal(SIGHUP, SIG_IGN);
    pid_t child = start(sl_command_render, line);
    signal(SIGHUP, SIG_DFL);
    wait_for_handler(child, SIGTERM);
    kill(child, SIGHUP);
    kill(child, SIGTERM);
    int ended = end_of(child);
    assert_true(WIFEXITED(ended));
    assert_int_equal(WEXITSTATUS(ended), 128 + SIGTERM);
}

/* Whoever runs these tests may ignore signals: a shell does for what it runs in the background, nohup does.
 */
static int take_signals(void **state) {
    signal(SIGINT, SIG_DFL);
    signal(SIGHUP, SIG_DFL);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_runs_write_the_same_bytes),
        cmocka_unit_test(a_picture_stopped_by_the_clock_is_the_file_of_its_batches),
        cmocka_unit_test(automatic_and_different_exposures_draw_a_warning),
        cmocka_unit_test(json_tells_the_tones),
        cmocka_unit_test(radiance_is_not_compared_with_what_a_screen_shows),
        cmocka_unit_test(a_png_that_tells_no_tone_is_compared_with_another),
        cmocka_unit_test(a_rendered_png_tells_its_exposure),
        cmocka_unit_test(json_is_utf_8_whatever_files_are_called),
        cmocka_unit_test(what_cannot_be_written_is_noticed_before_the_work),
        cmocka_unit_test(looking_whether_a_file_can_be_written_leaves_no_trace),
        cmocka_unit_test(what_is_done_is_kept_whatever_ends_it_and_the_status_tells),
        cmocka_unit_test(who_ignores_that_the_terminal_closes_goes_on),
    };
    return cmocka_run_group_tests(tests, take_signals, scene_files_teardown);
}
