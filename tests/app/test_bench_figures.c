/* The sources of the report's figures: the journal, errors against a noisy reference, curves and the times
 * read from them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "cache/frame/settings.h"
#include "app/bench/results.h"
#include "app/bench/journal.h"
#include "app/bench/judge.h"
#include "app/bench/references.h"
#include "app/bench/report.h"
#include "app/bench/trials.h"
#include "app/page.h"
#include "scene_files.h"

/* ---- the journal ---- */

static sl_journal *open_journal(const char *path) {
    sl_journal *journal;
    sl_error error;
    assert_int_equal(sl_journal_open(path, &journal, &error), SL_OK);
    return journal;
}

static void add(sl_journal *journal, const char *key, double value) {
    sl_error error;
    cJSON *entry = cJSON_CreateObject();
    cJSON_AddStringToObject(entry, "key", key);
    cJSON_AddNumberToObject(entry, "value", value);
    assert_int_equal(sl_journal_add(journal, entry, &error), SL_OK);
}

static double value_of(const sl_journal *journal, const char *key) {
    const cJSON *entry = sl_journal_find(journal, key);
    return entry ? cJSON_GetObjectItem(entry, "value")->valuedouble : -1.0;
}

static void what_is_added_is_there_in_the_next_run_and_a_line_cut_off_spoils_nothing(void **state) {
    const char *path = scene_file_text("journal.jsonl", "");
    sl_journal *journal = open_journal(path);
    add(journal, "a", 1.0);
    add(journal, "a", 3.0);
    sl_journal_close(journal);
    FILE *file = fopen(path, "a");
    assert_true(fputs("nonsense\n{\"value\":5}\n{\"key\":\"b\",\"val", file) >= 0);
    fclose(file);
    journal = open_journal(path);
    assert_true(value_of(journal, "a") == 3.0); /* the last word counts */
    assert_true(value_of(journal, "b") == -1.0);
    add(journal, "b", 2.0);
    sl_journal_close(journal);
    journal = open_journal(path);
    assert_true(value_of(journal, "a") == 3.0);
    assert_true(value_of(journal, "b") == 2.0);
    sl_journal_close(journal);
}

/* ---- errors ---- */

/* In [-1,1); a mixing of bits. */
static double noise_at(uint32_t i) {
    i = (i ^ (i >> 16)) * 0x85ebca6bu;
    i = (i ^ (i >> 13)) * 0xc2b2ae35u;
    return (double)((i ^ (i >> 16)) >> 8) / 8388608.0 - 1.0;
}

/* Truth 1 everywhere; halves with independent noise up to 0.2, and the picture wrong by a pattern of
 * +-`wrong`. */
static void make_pair(double wrong, sl_image **picture, sl_image **reference) {
    static const char *const names[] = {"R",      "G",     "B",     "even.R", "even.G",
                                        "even.B", "odd.R", "odd.G", "odd.B"};
    enum { SIZE = 64 };
    const size_t values = 3 * (size_t)SIZE * SIZE;
    sl_error error;
    assert_int_equal(sl_image_create(SIZE, SIZE, 3, NULL, picture, &error), SL_OK);
    assert_int_equal(sl_image_create(SIZE, SIZE, 9, names, reference, &error), SL_OK);
    for (size_t i = 0; i < values; i++) {
        /* one noise in all channels, as that of light is */
        uint32_t pixel = (uint32_t)(i % ((size_t)SIZE * SIZE));
        double a = 1.0 + 0.2 * noise_at(pixel + 1), b = 1.0 + 0.2 * noise_at(pixel + 7000001);
        (*picture)->planes[i] = (float)(1.0 + (i & 1 ? wrong : -wrong));
        (*reference)->planes[i] = (float)(0.5 * (a + b));
        (*reference)->planes[values + i] = (float)a;
        (*reference)->planes[2 * values + i] = (float)b;
    }
}

static sl_bench_error judge(double wrong) {
    sl_image *picture, *reference;
    sl_bench_error e;
    sl_error error;
    make_pair(wrong, &picture, &reference);
    assert_int_equal(sl_judge(picture, reference, &e, NULL, &error), SL_OK);
    sl_image_destroy(picture);
    sl_image_destroy(reference);
    return e;
}

static void the_noise_of_a_reference_is_no_error_of_the_picture(void **state) {
    sl_bench_error e = judge(0.1);
    double noise = 0.2 / sqrt(3.0) / sqrt(2.0); /* of the mean of two even distributions */
    assert_true(e.known && !e.lost);
    assert_true(fabs(e.noise - noise) < 0.02 * noise);
    assert_true(fabs(e.rel_rmse - 0.1) < 0.002);
}

static void an_error_far_below_the_noise_is_only_bounded(void **state) {
    sl_bench_error e = judge(0.0);
    assert_true(e.known && e.lost);
    assert_true(e.rel_rmse > 0.05 * e.noise && e.rel_rmse < 0.3 * e.noise);
    assert_true(e.doubt == e.rel_rmse);
}

/* Var (x-A)(x-B) = 2 e^2 s^2 + s^4 for each of n values, A and B with the variance s^2. */
static void what_noise_leaves_in_doubt_is_what_theory_says(void **state) {
    /* the channels of a pixel count as one */
    const double wrong = 0.1, variance = 0.2 * 0.2 / 3.0, values = 64.0 * 64.0;
    double doubt =
        2.0 * sqrt((2.0 * wrong * wrong * variance + variance * variance) / values) / (2.0 * wrong);
    sl_bench_error e = judge(wrong);
    assert_true(e.doubt > 0.8 * doubt && e.doubt < 1.1 * doubt);
    assert_true(fabs(e.rel_rmse - wrong) < e.doubt);
}

/* ---- light paths that are the same in a scene ---- */

static void sets_of_light_paths_that_a_scene_cannot_tell_apart_share_a_reference(void **state) {
    sl_bench_scene diffuse = {.base = "--bounces 1", .hash = "0123456789abcdef", .width = 8, .height = 8},
                   glossy = diffuse, mirrors = diffuse;
    char a[SL_BENCH_PATH], b[SL_BENCH_PATH];
    glossy.glossy = mirrors.mirrors = true;
    assert_true(sl_reference_is_same(&mirrors, "matched:splatting", "one-bounce"));
    assert_true(sl_reference_is_same(&diffuse, "matched:multi-mesh", "one-bounce"));
    /* its receivers are diffuse */
    assert_false(sl_reference_is_same(&glossy, "matched:multi-mesh", "one-bounce"));
    /* mirrors are black to it */
    assert_false(sl_reference_is_same(&mirrors, "matched:multi-mesh", "one-bounce"));
    assert_true(sl_reference_is_same(&mirrors, "matched:light-octree", "full"));
    /* ends after some surfaces */
    assert_false(sl_reference_is_same(&diffuse, "matched:shading-cache", "full"));
    /* sees through walls */
    assert_false(sl_reference_is_same(&diffuse, "matched:direct-radiance", "one-bounce"));
    assert_false(sl_reference_is_same(&diffuse, "direct", "one-bounce"));
    sl_reference_path("folder", &diffuse, "matched:multi-mesh", a);
    sl_reference_path("folder", &diffuse, "one-bounce", b);
    assert_string_equal(a, b);
    sl_reference_path("folder", &glossy, "matched:multi-mesh", a);
    assert_string_not_equal(a, b);
    /* Options change paths. */
    assert_false(sl_reference_is_same(&diffuse, "matched:splatting", "matched:splatting --bounces 2"));
    sl_reference_path("folder", &diffuse, "full", a);
    sl_reference_path("folder", &diffuse, "matched:light-octree", b);
    assert_string_equal(a, b);
}

/* ---- curves ---- */

static sl_bench_row row(const char *curve, double seconds, double error) {
    static sl_trial trials[8];
    static int next;
    sl_trial *t = &trials[next++ % 8];
    sl_bench_row r = {.trial = t, .end = SL_CHILD_DONE, .cpu = {1, seconds, seconds, seconds}};
    snprintf(t->curve, sizeof t->curve, "%s", curve);
    snprintf(t->method, sizeof t->method, "%.*s", (int)strcspn(curve, ","), curve);
    snprintf(t->arguments, sizeof t->arguments, "%g", seconds);
    r.error[SL_BENCH_FULL] = (sl_bench_error){.known = true, .rel_rmse = error};
    return r;
}

static void times_are_read_along_the_settings_that_pay(void **state) {
    sl_bench_row rows[] = {row("splatting", 10.0, 0.01),
                           row("splatting", 0.1, 0.1),
                           row("splatting", 5.0, 0.2) /* beaten */,
                           row("path, full", 1.0, 0.1),
                           row("path, full", 100.0, 0.01),
                           row("path, one-bounce", 0.01, 0.001) /* other paths */};
    sl_bench_scene scene = {.rows = rows, .row_count = sizeof rows / sizeof *rows};
    sl_curve curves[SL_CURVES];
    assert_int_equal(sl_curves_of(&scene, SL_BENCH_FULL, curves), 3);
    assert_true(curves[0].best[0] && !curves[0].best[1] && curves[0].best[2]);
    /* Straight on logarithmic axes: halfway in error is halfway in time. */
    assert_true(fabs(sl_curve_time_to(&curves[0], SL_BENCH_FULL, sqrt(0.001)) - 1.0) < 1e-9);
    assert_true(sl_curve_time_to(&curves[0], SL_BENCH_FULL, 0.5) == 0.1);
    assert_true(sl_curve_time_to(&curves[0], SL_BENCH_FULL, 0.001) == 0.0);
    sl_lead lead = sl_lead_at(&scene, SL_BENCH_FULL, 0.01);
    assert_string_equal(lead.method, "splatting");
    assert_true(fabs(lead.path_seconds / lead.seconds - 10.0) < 1e-9);
}

static void missing_light_is_never_told_as_no_error(void **state) {
    static const struct {
        double energy, missing;
        const char *text;
    } cases[] = {{0.757, 0.3619, "36.2 %"}, {0.828, 0.0, "≥ 17 %"}, {1.2, 0.1, "≥ 20 %"},
                 {0.875, 0.1249, "12.5 %"}, {1.0, 0.0, "0.0 %"},    {0.9999, 0.0, "0.0 %"},
                 {0.0, 1.4, "140.0 %"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const sl_bench_reference r = {
            .missing_known = true, .energy = cases[i].energy, .missing = cases[i].missing};
        char text[32];
        sl_missing_text(&r, text);
        assert_string_equal(text, cases[i].text);
    }
}

/* ---- trials ---- */

static void every_trial_s_arguments_are_its_own_and_name_its_light_paths(void **state) {
    sl_trials all;
    sl_error error;
    assert_int_equal(sl_trials_read(NULL, &all, &error), SL_OK);
    for (size_t i = 0; i < all.count; i++) {
        const sl_trial *t = &all.trial[i];
        sl_settings s;
        assert_true(sl_trial_settings(t->arguments, &s));
        for (size_t k = 0; k < i; k++) assert_string_not_equal(t->arguments, all.trial[k].arguments);
        if (strncmp(t->transport, "matched:", 8) == 0) assert_string_equal(t->transport + 8, t->method);
        else if (s.transport) assert_string_equal(s.transport, t->transport);
    }
    assert_true(all.truth[SL_BENCH_MATCHED] && all.truth[SL_BENCH_FULL] && all.estimates);
    sl_trials_free(&all);
}

static void a_file_of_trials_is_read_line_by_line(void **state) {
    sl_trials all;
    sl_error error;
    size_t length;
    const char *path = scene_file_text(
        "a.trials", "# two\nbase --bounces 1\nsize 8x6\nscenes a.json b.json\ntruth full\nwith -m path\n"
                    "trial draft = -q draft\ntable t: cpu, full, part.x\n"
                    "trial four, no options =\ncurve c\ntrial 2 = --spp 2\n");
    assert_int_equal(sl_trials_read(path, &all, &error), SL_OK);
    assert_true(all.count == 3 && all.table_count == 1 && all.width == 8 && all.height == 6);
    assert_true(all.truth[SL_BENCH_FULL] && !all.truth[SL_BENCH_MATCHED] && !all.estimates);
    assert_string_equal(all.trial[0].quality, "draft");
    assert_int_equal(all.trial[0].table, -1);
    assert_string_equal(all.trial[1].name, "four, no options");
    assert_string_equal(all.trial[1].arguments, "--bounces 1 -m path");
    assert_string_equal(all.trial[1].curve, "path");
    assert_true(all.trial[1].look && !all.trial[1].ordered && all.trial[2].ordered);
    assert_string_equal(all.trial[2].curve, "c");
    const char *at = all.trial[2].scenes, *scene = sl_next_item(&at, " ", &length);
    assert_true(length == 6 && strncmp(scene, "a.json", length) == 0);
    scene = sl_next_item(&at, " ", &length);
    assert_true(length == 6 && strncmp(scene, "b.json", length) == 0);
    assert_null(sl_next_item(&at, " ", &length));
    sl_trials_free(&all);
}

static void a_line_of_trials_that_means_nothing_is_named(void **state) {
    static const char *const lines[] = {"nonsense\n", "\ntrial a = -m path\n",
                                        "truth full\nwith -m path\ntrial a\n", "size 0x1\n", "table t\n"};
    static const char *const where[] = {
        "bad.trials:1: ", "bad.trials:2: ", "bad.trials:3: ", "bad.trials:1: ", "bad.trials:1: "};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        sl_trials all;
        sl_error error;
        assert_int_equal(sl_trials_read(scene_file_text("bad.trials", lines[i]), &all, &error),
                         SL_ERROR_INPUT);
        assert_non_null(strstr(error.message, where[i]));
        sl_trials_free(&all);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_added_is_there_in_the_next_run_and_a_line_cut_off_spoils_nothing),
        cmocka_unit_test(the_noise_of_a_reference_is_no_error_of_the_picture),
        cmocka_unit_test(an_error_far_below_the_noise_is_only_bounded),
        cmocka_unit_test(what_noise_leaves_in_doubt_is_what_theory_says),
        cmocka_unit_test(sets_of_light_paths_that_a_scene_cannot_tell_apart_share_a_reference),
        cmocka_unit_test(times_are_read_along_the_settings_that_pay),
        cmocka_unit_test(missing_light_is_never_told_as_no_error),
        cmocka_unit_test(every_trial_s_arguments_are_its_own_and_name_its_light_paths),
        cmocka_unit_test(a_file_of_trials_is_read_line_by_line),
        cmocka_unit_test(a_line_of_trials_that_means_nothing_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, scene_files_teardown);
}
