/* Values that come in slowly: how much is left after k updates, from where they start, and what ends it. */
#include "shading_cache_support.h"

#include <math.h>
#include <stdio.h>

#include "cache/shading_cache/change.h"
#include "rendering.h"

/* A square with irradiance 1, 3, 5, 3 at its corners, split; its middle has just got its first sample. */
typedef struct scene_with_middle {
    hierarchy h;
    uint32_t middle;
    sl_fades fades;
} scene_with_middle;

static const float sampled = 11.0f, beta = 0.25f;

static scene_with_middle begin(void) {
    scene_with_middle s = {.h = hierarchy_of(square_scene(), false)};
    uint32_t root = want_root(&s.h, 0);
    const float corner[4] = {1, 3, 5, 3};
    for (int c = 0; c < 4; c++) evaluate(&s.h, sl_patch_corner(s.h.patches, root, c), corner[c], 1);
    split(&s.h, root);
    s.middle = sl_patch_corner(s.h.patches, s.h.patches->patch[root].child, 2);
    float from[6];
    assert_true(sl_vertex_surroundings(s.h.patches, s.middle, from));
    assert_true(fabsf(from[1] - 3.0f) < 1e-6f); /* what the four have shown there */
    evaluate(&s.h, s.middle, sampled, 2);
    sl_fade_begin(&s.fades, s.h.patches, s.middle, from, beta);
    return s;
}

static float shown(const scene_with_middle *s) { return sl_vertex_value(s->h.patches, s->middle)[2]; }

static void end(scene_with_middle *s) {
    sl_fades_release(&s->fades);
    hierarchy_discard(&s->h);
}

static void after_k_updates_1_minus_beta_to_the_k_is_left(void **state) {
    scene_with_middle s = begin();
    int k = 1;
    for (; s.fades.count; k++) {
        double left = (double)(sampled - shown(&s)) / (double)(sampled - 3.0f);
        assert_true(fabs(left - pow(1.0 - (double)beta, k)) < 1e-5);
        assert_true(k < 40);
        sl_fades_go_on(&s.fades, s.h.patches, beta);
    }
    assert_true(k > 20 && shown(&s) == sampled);
    end(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(after_k_updates_1_minus_beta_to_the_k_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
