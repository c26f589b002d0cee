/* The rule behind --method auto: measured scenes that are like this one say which method is first. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "app/auto_choice.h"
#include "app/auto_table.h"

enum { MEASURED = sizeof measured / sizeof *measured };

/* One where splatting is first, far from one where the light octree is, and path tracing second in both. */
static void make_two(sl_auto_scene two[2]) {
    two[0] = (sl_auto_scene){
        .name = "open",
        .kind = {.direct = 0.9, .second = 0.1, .lit = true, .triangles = 100.0, .lights = 1.0},
        .pixels = 10000.0};
    two[1] = (sl_auto_scene){
        .name = "hidden",
        .kind =
            {.direct = 0.1, .second = 0.1, .further = 0.8, .lit = true, .triangles = 100.0, .lights = 1.0},
        .pixels = 10000.0};
    for (int class = 0; class < SL_AUTO_CLASSES; class++) {
        for (int c = 0; c < SL_AUTO_CANDIDATES; c++)
            two[0].seconds[class][c] = two[1].seconds[class][c] = 50.0;
        two[0].seconds[class][SL_AUTO_SPLATTING] = 1.0, two[0].seconds[class][SL_AUTO_PATH] = 4.0;
        two[1].seconds[class][SL_AUTO_LIGHT_OCTREE] = 10.0, two[1].seconds[class][SL_AUTO_PATH] = 30.0;
    }
}

static sl_auto_verdict judge(const sl_auto_scene *two, const sl_auto_scene *left_out, sl_auto_kind kind,
                             double pixels) {
    return sl_auto_judge(two, 2, left_out, &kind, pixels, SL_AUTO_MIDDLE, 0.05);
}

static void a_scene_that_was_measured_gets_what_was_first_there(void **state) {
    (void)state;
    sl_auto_scene two[2];
    make_two(two);
    sl_auto_kind first = two[0].kind;
    first.further = 0.0;
    sl_auto_verdict a = judge(two, NULL, first, 10000.0), b = judge(two, NULL, two[1].kind, 10000.0);
    assert_int_equal(a.best, SL_AUTO_SPLATTING);
    assert_string_equal(a.like->name, "open");
    assert_true(fabs(a.cost[SL_AUTO_PATH] - 4.0) < 0.1 && a.cost[SL_AUTO_SPLATTING] == 1.0);
    assert_int_equal(b.best, SL_AUTO_LIGHT_OCTREE);
    assert_string_equal(b.like->name, "hidden");
}

static void what_is_left_out_has_no_say(void **state) {
    (void)state;
    sl_auto_scene two[2];
    make_two(two);
    sl_auto_verdict v = judge(two, &two[0], two[0].kind, 10000.0);
    assert_int_equal(v.best, SL_AUTO_LIGHT_OCTREE);
    assert_string_equal(v.like->name, "hidden");
}

static void a_method_that_leaves_out_too_much_light_is_not_chosen(void **state) {
    (void)state;
    sl_auto_scene two[2];
    make_two(two);
    sl_auto_kind kind = two[0].kind;
    kind.second = 0.06, kind.further = 0.04; /* twice that is above 5 % */
    sl_auto_verdict v = judge(two, NULL, kind, 10000.0);
    assert_int_not_equal(v.best, SL_AUTO_SPLATTING);
    assert_true(isinf(v.cost[SL_AUTO_SPLATTING]));
}

static void under_a_sky_what_takes_it_for_no_light_is_not_chosen(void **state) {
    (void)state;
    sl_auto_scene two[2];
    make_two(two);
    two[0].seconds[SL_AUTO_MIDDLE][SL_AUTO_DIRECT_RADIANCE] = 0.1;
    sl_auto_kind kind = two[0].kind;
    assert_int_equal(judge(two, NULL, kind, 10000.0).best, SL_AUTO_DIRECT_RADIANCE);
    kind.open = true;
    assert_true(isinf(judge(two, NULL, kind, 10000.0).cost[SL_AUTO_DIRECT_RADIANCE]));
}

static void larger_pictures_speak_for_caches(void **state) {
    (void)state;
    sl_auto_scene two[2];
    make_two(two);
    two[0].seconds[SL_AUTO_MIDDLE][SL_AUTO_PATH] = 0.8;
    assert_int_equal(judge(two, NULL, two[0].kind, 10000.0).best, SL_AUTO_PATH);
    assert_int_equal(judge(two, NULL, two[0].kind, 40000.0).best, SL_AUTO_SPLATTING);
}

static void without_any_measurement_paths_are_traced(void **state) {
    (void)state;
    sl_auto_scene two[2];
    make_two(two);
    sl_auto_verdict v = sl_auto_judge(two, 0, NULL, &two[0].kind, 1e4, SL_AUTO_ROUGH, 0.15);
    assert_null(v.like);
    assert_int_equal(v.best, SL_AUTO_PATH);
}

static void the_table_holds_measurements(void **state) {
    (void)state;
    assert_true(MEASURED >= 5);
    for (size_t i = 0; i < MEASURED; i++) {
        const sl_auto_scene *s = &measured[i];
        double sum = s->kind.direct + s->kind.second + s->kind.further + s->kind.mirrored;
        assert_true(!s->kind.lit || fabs(sum - 1.0) < 0.01);
        assert_true(s->pixels >= 1.0);
        assert_true(sl_auto_distance(&s->kind, &s->kind) == 0.0);
        for (int c = 0; c < SL_AUTO_CANDIDATES; c++) { /* a smaller error is not reached sooner */
            assert_true(s->seconds[SL_AUTO_ROUGH][c] > 0.0 &&
                        s->seconds[SL_AUTO_ROUGH][c] <= s->seconds[SL_AUTO_MIDDLE][c]);
            assert_true(s->seconds[SL_AUTO_MIDDLE][c] <= s->seconds[SL_AUTO_FINE][c]);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scene_that_was_measured_gets_what_was_first_there),
        cmocka_unit_test(what_is_left_out_has_no_say),
        cmocka_unit_test(a_method_that_leaves_out_too_much_light_is_not_chosen),
        cmocka_unit_test(under_a_sky_what_takes_it_for_no_light_is_not_chosen),
        cmocka_unit_test(larger_pictures_speak_for_caches),
        cmocka_unit_test(without_any_measurement_paths_are_traced),
        cmocka_unit_test(the_table_holds_measurements),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
