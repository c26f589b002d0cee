/* The choice of pixels: hit-and-test, its bias, floods, equal steps along a curve, the highest first. */
#include <math.h>

#include "cache/shading_cache/selection.h"
#include "patch_support.h"

/* A picture of leaves, as an id map and priorities would give it. */
typedef struct picture {
    int width, height;
    uint32_t *leaf;
    sl_leaf_priority *leaves;
    size_t leaf_count;
    sl_choice *choice;
    size_t count;
    sl_counters counters;
} picture;

static picture picture_of(int width, int height, size_t leaf_count) {
    size_t pixels = (size_t)width * (size_t)height;
    picture p = {.width = width, .height = height, .leaf_count = leaf_count};
    p.leaf = malloc(pixels * sizeof *p.leaf);
    p.leaves = calloc(leaf_count + 1, sizeof *p.leaves);
    p.choice = malloc((2 * pixels + 1000) * sizeof *p.choice);
    assert_true(p.leaf && p.leaves && p.choice);
    memset(p.leaf, 0xff, pixels * sizeof *p.leaf);
    return p;
}

static void picture_discard(picture *p) {
    free(p->leaf);
    free(p->leaves);
    free(p->choice);
}

static void paint(picture *p, int x, int y, uint32_t leaf, float normal) {
    p->leaf[y * p->width + x] = leaf;
    p->leaves[leaf].patch = leaf;
    p->leaves[leaf].pixels++;
    p->leaves[leaf].normal = normal;
    p->leaves[leaf].priority = 100.0f * normal;
}

static sl_selection usual(int points) {
    return (sl_selection){.how = SL_PIXELS_HIT_AND_TEST,
                          .points = points,
                          .random_share = 0.03f,
                          .flood_threshold = 2.0f,
                          .per_patch = 10000,
                          .seed = 1};
}

/* Whatever the settings: no more choices than there may be, of pixels that show a leaf, each once, of no
 * patch more than its share. */
static void choose(picture *p, const sl_selection *s) {
    sl_counters zero = {0};
    size_t pixels = (size_t)p->width * (size_t)p->height;
    p->counters = zero;
    sl_selection made = *s;
    made.width = p->width, made.height = p->height;
    made.leaf = p->leaf, made.leaves = p->leaves, made.leaf_count = p->leaf_count;
    made.choice = p->choice, made.counters = &p->counters;
    assert_int_equal(sl_select_pixels(&made, NULL), SL_OK);
    p->count = made.count;
    assert_true(p->count <= 2 * (size_t)s->points);
    uint8_t *chosen = calloc(pixels, 1);
    int *in_leaf = calloc(p->leaf_count + 1, sizeof *in_leaf);
    assert_true(chosen && in_leaf);
    uint64_t kinds[3] = {0};
    for (size_t i = 0; i < p->count; i++) {
        const sl_choice *c = &p->choice[i];
        assert_true(c->pixel < pixels && c->leaf != SL_NO_INDEX);
        assert_int_equal(c->leaf, p->leaf[c->pixel]);
        assert_int_equal(chosen[c->pixel]++, 0);
        assert_true(++in_leaf[c->leaf] <= (int)s->per_patch);
        kinds[c->kind]++;
    }
    assert_int_equal(p->counters.value[SL_COUNT_PIXELS_HIT], kinds[SL_CHOICE_HIT]);
    assert_int_equal(p->counters.value[SL_COUNT_PIXELS_RANDOM], kinds[SL_CHOICE_RANDOM]);
    assert_int_equal(p->counters.value[SL_COUNT_PIXELS_FLOODED], kinds[SL_CHOICE_FLOOD]);
    assert_true(kinds[SL_CHOICE_FLOOD] <= (uint64_t)s->points);
    free(chosen);
    free(in_leaf);
}

/* ---- hit-and-test ---- */

static void patches_are_chosen_as_often_as_their_pixels_and_priorities_say(void **state) {
    enum { LEAVES = 6, UPDATES = 40000 };
    static const float normal[LEAVES] = {0.0f, 0.1f, 0.3f, 0.5f, 0.8f, 1.0f};
    picture p = picture_of(32, 24, LEAVES);
    for (int y = 0; y < 24; y++) {
        for (int x = 0; x < 28; x++) { /* the rest shows nothing */
            uint32_t leaf = (uint32_t)((x * x + y) / 60 % 7);
            if (leaf < LEAVES) paint(&p, x, y, leaf, normal[leaf]);
        }
    }
    sl_selection s = usual(1);
    double wanted[LEAVES], sum = 0.0, found[LEAVES] = {0}, chi = 0.0;
    for (int i = 0; i < LEAVES; i++)
        sum += wanted[i] = (double)p.leaves[i].pixels * (0.03 + 0.97 * (double)normal[i]);
    for (s.update = 0; s.update < UPDATES; s.update++) {
        choose(&p, &s);
        assert_int_equal(p.count, 1);
        found[p.choice[0].leaf] += 1.0;
    }
    for (int i = 0; i < LEAVES; i++) {
        double e = wanted[i] / sum * UPDATES;
        chi += (found[i] - e) * (found[i] - e) / e;
    }
    assert_true(chi < 20.5); /* 5 degrees of freedom, 0.1 % */
    picture_discard(&p);
}

static void tests_for_one_choice_are_the_inverse_of_the_mean_chance(void **state) {
    picture p = picture_of(320, 240, 320);
    double mean = 0.0;
    for (int x = 0; x < 320; x++) {
        float normal = 0.74193f * ((float)x / 319.0f) * ((float)x / 319.0f);
        for (int y = 0; y < 240; y++) paint(&p, x, y, (uint32_t)x, normal);
        mean += (0.03 + 0.97 * (double)normal) / 320.0;
    }
    assert_true(fabs(1.0 / mean - 3.700) < 5e-3);
    sl_selection s = usual(64);
    double tests = 0.0, choices = 0.0, random = 0.0;
    for (s.update = 0; s.update < 1500; s.update++) {
        choose(&p, &s);
        tests += (double)p.counters.value[SL_COUNT_PIXEL_TESTS];
        random += (double)p.counters.value[SL_COUNT_PIXELS_RANDOM];
        choices += (double)p.count;
    }
    assert_true(fabs(tests / choices - 3.700) < 0.03);
    assert_true(fabs(random / tests - 0.03) < 4.0 * sqrt(0.03 * 0.97 / tests)); /* epsilon of all tests */
    picture_discard(&p);
}

static void a_patch_without_any_priority_is_found_in_the_long_run_and_only_by_chance(void **state) {
    picture p = picture_of(64, 64, 2);
    for (int i = 0; i < 64 * 64; i++) paint(&p, i % 64, i / 64, i == 2000, i == 2000 ? 0.0f : 0.5f);
    sl_selection s = usual(64), none = usual(64);
    none.random_share = 0.0f;
    int found = 0;
    for (s.update = 0; s.update < 2000; s.update++) {
        choose(&p, &s);
        for (size_t i = 0; i < p.count; i++) {
            if (p.choice[i].leaf != 1) continue;
            assert_int_equal(p.choice[i].kind, SL_CHOICE_RANDOM);
            found++;
        }
        none.update = s.update;
        choose(&p, &none);
        for (size_t i = 0; i < p.count; i++) assert_int_equal(p.choice[i].leaf, 0);
    }
    assert_true(found >= 1); /* 1 - (1 - epsilon/N)^tests: 0.85 of 250,000 tests */
    picture_discard(&p);
}

static void tests_come_to_an_end_where_nothing_is_to_be_hit(void **state) {
    picture p = picture_of(200, 100, 1);
    sl_selection s = usual(64);
    choose(&p, &s); /* no visible patch */
    assert_int_equal(p.count, 0);
    paint(&p, 7, 7, 0, 1.0f); /* one pixel of 20,000 */
    choose(&p, &s);
    assert_true(p.count <= 1);
    assert_true(p.counters.value[SL_COUNT_PIXEL_TESTS] <= (uint64_t)ceil(8.0 * 64.0 / 0.03));
    for (int i = 0; i < 20000; i++) paint(&p, i % 200, i / 200, 0, 0.0f);
    s.random_share = 0.0f; /* nothing is to be had: as many as if it were 0.03 */
    choose(&p, &s);
    assert_int_equal(p.count, 0);
    assert_int_equal(p.counters.value[SL_COUNT_PIXEL_TESTS], (uint64_t)ceil(8.0 * 64.0 / 0.03));
    s.random_share = 0.03f;
    p.leaf_count = 0;
    choose(&p, &s);
    assert_int_equal(p.count, 0);
    assert_int_equal(p.counters.value[SL_COUNT_PIXEL_TESTS], 0);
    picture_discard(&p);
    p = picture_of(20, 10, 1);
    for (int i = 0; i < 200; i++) paint(&p, i % 20, i / 20, 0, 0.0f);
    choose(&p, &s); /* epsilon alone: 33 tests a choice */
    assert_int_equal(p.count, 64);
    assert_int_equal(p.counters.value[SL_COUNT_PIXELS_RANDOM], 64);
    s.random_share = 0.0f;
    choose(&p, &s);
    assert_int_equal(p.count, 0);
    for (int how = 0; how < 2; how++) { /* no choices are wanted */
        s = usual(how ? 64 : 0);
        s.how = (sl_pixel_selection)how;
        s.per_patch = how ? 0 : 16;
        choose(&p, &s);
        assert_int_equal(p.count, 0);
    }
    picture_discard(&p);
}

static void no_patch_gets_more_than_its_share_and_the_others_get_theirs(void **state) {
    for (int how = 0; how < 2; how++) {
        picture p = picture_of(60, 40, 3);
        for (int i = 0; i < 2400; i++)
            paint(&p, i % 60, i / 60, i < 2000 ? 0 : i < 2390 ? 1 : 2, i < 2000 ? 1.0f : 0.5f);
        sl_selection s = usual(64);
        s.how = (sl_pixel_selection)how;
        s.per_patch = 16;
        s.flood_threshold = 0.5f;
        int in_leaf[3] = {0};
        choose(&p, &s); /* which looks at the shares */
        for (size_t i = 0; i < p.count; i++) in_leaf[p.choice[i].leaf]++;
        assert_int_equal(in_leaf[0], 16);
        assert_int_equal(in_leaf[1], 16);
        assert_int_equal(in_leaf[2], 10);
        picture_discard(&p);
    }
}

/* ---- floods ---- */

static bool beside(const picture *p, uint32_t a, uint32_t b) {
    int dx = abs((int)(a % (uint32_t)p->width) - (int)(b % (uint32_t)p->width)),
        dy = abs((int)(a / (uint32_t)p->width) - (int)(b / (uint32_t)p->width));
    return dx + dy == 1;
}

/* A shadow's edge: one-pixel patches in steps through a picture of 640 x 480. */
static picture shadow_line(void) {
    picture p = picture_of(640, 480, 1 + 2 * 480);
    uint32_t next = 1;
    for (int y = 0; y < 480; y++) {
        for (int x = 0; x < 640; x++) {
            bool line = x == y || x == y + 1;
            paint(&p, x, y, line ? next++ : 0, line ? 1.0f : 0.0f);
        }
    }
    return p;
}

static void one_hit_on_a_shadow_line_spreads_along_it(void **state) {
    picture p = shadow_line();
    sl_selection s = usual(64);
    s.flood_threshold = 0.5f;
    s.random_share = 0.0f;
    for (s.update = 0; s.update < 20; s.update++) {
        choose(&p, &s);
        assert_true(p.counters.value[SL_COUNT_PIXELS_FLOODED] == p.counters.value[SL_COUNT_PIXELS_HIT] ||
                    p.counters.value[SL_COUNT_PIXELS_FLOODED] == 64);
        for (size_t i = 0; i < p.count; i++) {
            assert_true(p.choice[i].leaf > 0);
            bool reached = p.choice[i].kind != SL_CHOICE_FLOOD;
            for (size_t j = 0; j < i && !reached; j++)
                reached = beside(&p, p.choice[i].pixel, p.choice[j].pixel);
            assert_true(reached);
        }
    }
    s.flood_threshold = 2.0f;
    choose(&p, &s);
    assert_int_equal(p.counters.value[SL_COUNT_PIXELS_FLOODED], 0);
    picture_discard(&p);
}

static void floods_take_nothing_below_their_seed_or_the_threshold(void **state) {
    static const float normal[] = {0.3f, 0.6f, 0.9f, 0.8f, 0.45f};
    picture p = picture_of(50, 10, 5);
    for (int y = 0; y < 10; y++) {
        for (int x = 0; x < 50; x++) paint(&p, x, y, (uint32_t)(x / 10), normal[x / 10]);
    }
    sl_selection s = usual(1); /* one seed, one more */
    s.flood_threshold = 0.5f;
    int floods = 0, within = 0, upwards = 0;
    for (s.update = 0; s.update < 5000; s.update++) {
        choose(&p, &s);
        float seed = p.leaves[p.choice[0].leaf].normal;
        bool spreads = p.choice[0].kind == SL_CHOICE_HIT && seed >= 0.5f;
        assert_int_equal(p.count, spreads ? 2 : 1);
        if (!spreads) continue;
        assert_true(p.leaves[p.choice[1].leaf].normal >= seed);
        assert_true(beside(&p, p.choice[0].pixel, p.choice[1].pixel));
        floods++;
        within += p.choice[0].leaf == p.choice[1].leaf;
        upwards += p.leaves[p.choice[1].leaf].normal > seed;
    }
    /* also within one patch, where the paper's rule would stop, and into higher ones */
    assert_true(within > floods / 2 && upwards > 10);
    picture_discard(&p);
}

/* ---- the highest first ---- */

static void sorted_choices_are_those_of_highest_priority_and_one_of_each_patch_before_two(void **state) {
    picture p = picture_of(40, 30, 100);
    for (int i = 0; i < 1200; i++)
        paint(&p, i % 40, i / 40, (uint32_t)(i % 40 / 4 + i / 40 / 3 * 10),
              0.0f + (float)((i % 40 / 4 * 37 + i / 40 / 3 * 11) % 101) / 100.0f);
    sl_selection s = usual(30);
    s.how = SL_PIXELS_SORTED;
    p.leaves[50].priority = -1.0f; /* never evaluated */
    p.leaves[50].normal = 1.0f;
    choose(&p, &s);
    assert_int_equal(p.count, 30);
    bool chosen[100] = {false};
    float least = 1.0f;
    for (size_t i = 0; i < p.count; i++) {
        assert_false(chosen[p.choice[i].leaf]);
        chosen[p.choice[i].leaf] = true;
        least = fminf(least, p.leaves[p.choice[i].leaf].normal);
    }
    assert_true(chosen[50]);
    for (int i = 0; i < 100; i++) assert_true(chosen[i] || p.leaves[i].normal <= least);
    s.points = 250;
    choose(&p, &s);
    int in_leaf[100] = {0};
    for (size_t i = 0; i < p.count; i++) in_leaf[p.choice[i].leaf]++;
    assert_int_equal(p.count, 250);
    for (int i = 0; i < 100; i++) assert_true(in_leaf[i] == 2 || in_leaf[i] == 3);
    picture_discard(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patches_are_chosen_as_often_as_their_pixels_and_priorities_say),
        cmocka_unit_test(tests_for_one_choice_are_the_inverse_of_the_mean_chance),
        cmocka_unit_test(a_patch_without_any_priority_is_found_in_the_long_run_and_only_by_chance),
        cmocka_unit_test(tests_come_to_an_end_where_nothing_is_to_be_hit),
        cmocka_unit_test(no_patch_gets_more_than_its_share_and_the_others_get_theirs),
        cmocka_unit_test(one_hit_on_a_shadow_line_spreads_along_it),
        cmocka_unit_test(floods_take_nothing_below_their_seed_or_the_threshold),
        cmocka_unit_test(sorted_choices_are_those_of_highest_priority_and_one_of_each_patch_before_two),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
