/* softlux bench from its command line to its report, small. */
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "unit_test.h"
#include "app/commands.h"
#include "command.h"
#include "scene_files.h"

#include <math.h>

/* ---- running ---- */

static pid_t start(const char *folder, const char *more) {
    char line[1024];
    snprintf(line, sizeof line,
             "scenes/cornell.json -o %%/%s -s 32x32 -m path,direct-radiance -q draft --repeats 2 "
             "--reference-budget 0.1 --references %%/references --reference-threads 1 --quiet %s",
             folder, more);
    pid_t child = command_start(sl_command_bench, line, scene_file_path(""), NULL, NULL);
    assert_true(child > 0);
    return child;
}

static int finish(pid_t child) {
    int how = 0;
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_true(WIFEXITED(how));
    return WEXITSTATUS(how);
}

/* ---- files: texts stand in memory until the tests end ---- */

static char *file_of(const char *folder, const char *name) {
    enum { FILES = 32, MOST = 1 << 20 };
    static char texts[FILES][MOST];
    static int count;
    char path[256], *text = texts[count++ % FILES];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *in = fopen(scene_file_path(path), "rb");
    text[in ? fread(text, 1, MOST - 1, in) : 0] = '\0';
    if (in) fclose(in);
    return text;
}

static size_t lines_of(const char *text) {
    size_t lines = 0;
    for (; *text; text++) lines += *text == '\n';
    return lines;
}

/* ---- CSV ---- */

enum { FIELDS = 80, ROWS = 8 };

typedef struct csv {
    size_t rows, fields; /* the head not counted */
    char *field[ROWS][FIELDS];
} csv;

/* One field, without its quotes, in place; returns where the next one begins. */
static char *take_field(char *at, char **field, bool *last) {
    bool quoted = *at == '"';
    *field = at + quoted;
    at += quoted ? strcspn(*field, "\"") + 2 : strcspn(at, ",\n");
    *last = *at != ',';
    if (quoted) at[-1] = '\0';
    if (*at) *at++ = '\0';
    return at;
}

static csv table_of(const char *folder) {
    csv c = {0};
    char *text = file_of(folder, "results.csv");
    for (size_t row = 0; *text && row < ROWS; row++) {
        size_t field = 0;
        for (bool last = false; !last && field < FIELDS; field++)
            text = take_field(text, &c.field[row][field], &last);
        if (row == 0) c.fields = field;
        assert_int_equal(field, c.fields);
        c.rows = row;
    }
    return c;
}

static const char *field(const csv *c, size_t row, const char *name) {
    for (size_t i = 0; i < c->fields; i++) {
        if (strcmp(c->field[0][i], name) == 0) return c->field[row + 1][i];
    }
    fail_msg("no column %s", name);
    return NULL;
}

static double number(const csv *c, size_t row, const char *name) { return strtod(field(c, row, name), NULL); }

/* ---- the tests ---- */

static void every_trial_is_a_row_with_its_time_and_its_errors(void **state) {
    assert_int_equal(finish(start("whole", "")), 0);
    csv c = table_of("whole");
    assert_int_equal(c.rows, 2); /* direct radiance mapping; the path tracer */
    for (size_t i = 0; i < c.rows; i++) {
        assert_string_equal(field(&c, i, "end"), "ran");
        assert_string_equal(field(&c, i, "runs"), "2");
        assert_true(number(&c, i, "cpu") > 0.0);
        assert_true(number(&c, i, "peak") > 1.0);
        assert_true(number(&c, i, "matched") > 0.005 && number(&c, i, "matched") < 0.5);
    }
    /* what is told without the reference is near to what is found with it */
    for (size_t i = 0; i < c.rows; i++) {
        double told = number(&c, i, "estimate"), bound = number(&c, i, "bound");
        double measured = number(&c, i, "matched");
        bool lost = number(&c, i, "matched.lost") > 0.0;
        /* of the worse: surfaces beside the lamp, or all pixels; measured: or no more than that */
        assert_true(measured > 0.0 && (lost || told > 0.6 * measured) && bound >= told);
    }
    /* One bounce leaves out about a third of the light in the Cornell box. */
    assert_true(number(&c, 0, "full.bias") < -0.1);
    assert_true(fabs(number(&c, 1, "full.bias")) < 0.05);
}

static void the_page_holds_every_row_and_fetches_nothing(void **state) {
    char *page = file_of("whole", "report.html"), *markdown = file_of("whole", "report.md");
    csv c = table_of("whole");
    assert_int_equal(c.rows, 2);
    for (size_t i = 0; i < c.rows; i++) {
        assert_non_null(strstr(page, field(&c, i, "arguments")));
        assert_non_null(strstr(markdown, field(&c, i, "curve")));
    }
    static const char space[] = "http://www.w3.org/2000/svg";
    for (const char *at = page; (at = strstr(at, "http")); at++)
        assert_memory_equal(at, space, sizeof space - 1);
    assert_null(strstr(page, " src=http"));
    assert_null(strstr(page, "@import"));
    assert_non_null(strstr(page, "\"picture\":\"iVBOR"));
    assert_non_null(strstr(page, "\\u003csvg"));
}

static void interrupted_it_goes_on_to_the_same_rows(void **state) {
    const struct timespec moment = {0, 5000000};
    pid_t child = start("halves", "");
    char *text = file_of("halves", "journal.jsonl");
    while (lines_of(text) < 2) {
        nanosleep(&moment, NULL);
        text = file_of("halves", "journal.jsonl");
    }
    kill(child, SIGINT);
    assert_int_equal(finish(child), 128 + SIGINT);
    text = file_of("halves", "journal.jsonl");
    size_t kept = lines_of(text);
    assert_true(kept >= 2 && kept < 6);
    assert_int_equal(finish(start("halves", "")), 0);
    char *more = file_of("halves", "journal.jsonl");
    assert_int_equal(lines_of(more), 6);
    assert_memory_equal(more, text, strlen(text));
    csv a = table_of("whole"), b = table_of("halves");
    assert_int_equal(b.rows, 2);
    for (size_t i = 0; i < a.rows; i++) {
        static const char *const same[] = {
            "file", "hash", "arguments", "end", "runs", "counter.rays", "counter.samples",
            "counter.fragments_shaded"};
        for (size_t k = 0; k < sizeof same / sizeof *same; k++)
            assert_string_equal(field(&a, i, same[k]), field(&b, i, same[k]));
    }
}

static void a_report_alone_runs_no_trial(void **state) {
    char *before = file_of("halves", "journal.jsonl");
    assert_int_equal(finish(start("halves", "--report-only -m direct-radiance,multi-mesh")), 0);
    assert_string_equal(before, file_of("halves", "journal.jsonl"));
    csv c = table_of("halves");
    assert_int_equal(c.rows, 1); /* of multi-mesh caching there is nothing to tell */
    assert_string_equal(field(&c, 0, "method"), "direct-radiance");
}

static void a_trial_without_memory_is_a_row_that_says_so(void **state) {
    assert_int_equal(finish(start("little", "--memory 16 -m direct-radiance")), 0);
    csv c = table_of("little");
    assert_int_equal(c.rows, 1);
    assert_true(strcmp(field(&c, 0, "end"), "failed") == 0 || strcmp(field(&c, 0, "end"), "crashed") == 0);
    assert_string_not_equal(field(&c, 0, "why"), "");
    assert_string_equal(field(&c, 0, "runs"), "0");
    assert_non_null(strstr(file_of("little", "report.html"), field(&c, 0, "end")));
}

/* The cheapest setting takes some tenths of a second. */
static void finer_settings_are_left_out_once_a_cheaper_one_was_stopped(void **state) {
    assert_int_equal(finish(start("hurried", "-m shading-cache -q draft,normal,high,curve --limit 0.1")), 0);
    csv c = table_of("hurried");
    assert_true(c.rows > 3);
    assert_string_equal(field(&c, 0, "end"), "stopped");
    for (size_t i = 1; i < c.rows; i++) {
        assert_string_equal(field(&c, i, "end"), "left out");
        assert_non_null(strstr(field(&c, i, "why"), "took most of the limit"));
    }
    assert_int_equal(lines_of(file_of("hurried", "journal.jsonl")), 1);
}

static void two_programs_measure_and_a_third_tells(void **state) {
    pid_t a = start("shared", "--trials-only -m direct-radiance -s 16x16"),
          b = start("shared", "--trials-only -m path -s 16x16");
    assert_int_equal(finish(a), 0);
    assert_int_equal(finish(b), 0);
    assert_int_equal(access(scene_file_path("shared/report.html"), F_OK), -1);
    assert_int_equal(finish(start("shared", "--report-only -s 16x16")), 0);
    char *tables = file_of("shared", "tables.md");
    csv c = table_of("shared");
    assert_int_equal(c.rows, 2);
    for (size_t i = 0; i < c.rows; i++)
        assert_true(strcmp(field(&c, i, "end"), "ran") == 0 &&
                    number(&c, i, "full") > 0.0);
    assert_non_null(strstr(tables, "<!-- table best -->"));
    assert_non_null(strstr(tables, "| cornell | diffuse |"));
}

static void a_file_of_trials_becomes_a_table_with_its_columns(void **state) {
    scene_file_text("my.trials", "truth matched:direct-radiance\nwith -m direct-radiance -q draft\n"
                                 "table light: cpu, matched, part.direct, counter.map_photons, nothing\n"
                                 "trial as it is =\ntrial polygons = --set weight=polygon\n");
    assert_int_equal(finish(start("trials", "--trials %/my.trials -q curve")), 0);
    char *text = file_of("trials", "tables.md"), cpu[32], error[32], direct[32];
    const char *row = strstr(text, "| cornell | as it is |");
    unsigned photons = 0;
    assert_non_null(strstr(text, "<!-- table light -->\n| scene | trial | cpu | matched | part.direct | "));
    assert_non_null(strstr(text, "| cornell | polygons |"));
    int found = sscanf(row, "| cornell | as it is | %31[^|]| %31[^|]| %31[^|]| %u |  |", cpu, error, direct,
                       &photons);
    assert_int_equal(found, 4);
    assert_true(strtod(cpu, NULL) > 0.0 && strchr(error, '%') && photons > 9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        /* first: what later tests freed would be memory to it */
        cmocka_unit_test(a_trial_without_memory_is_a_row_that_says_so),
        cmocka_unit_test(every_trial_is_a_row_with_its_time_and_its_errors),
        cmocka_unit_test(the_page_holds_every_row_and_fetches_nothing),
        cmocka_unit_test(interrupted_it_goes_on_to_the_same_rows),
        cmocka_unit_test(a_report_alone_runs_no_trial),
        cmocka_unit_test(finer_settings_are_left_out_once_a_cheaper_one_was_stopped),
        cmocka_unit_test(two_programs_measure_and_a_third_tells),
        cmocka_unit_test(a_file_of_trials_becomes_a_table_with_its_columns),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
