/* The same gather gives the same bits: with every instruction set, again, and whatever the scratch was used
 * for before. */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "gather_world.h"

static sl_gather_settings settings_of(sl_gather_kind kind) {
    sl_gather_settings s = sl_gather_defaults();
    s.kind = kind;
    s.size = kind == SL_GATHER_HEMICUBE ? 30 : 37; /* not whole lanes, tiles or packets */
    return s;
}

enum { POINTS = 12 };

static void gather_all(gatherer *g, const world *w, sl_irradiance *out) {
    memset(out, 0, POINTS * sizeof *out);
    for (uint64_t i = 0; i < POINTS; i++) {
        sl_gather_point p = world_surface_point(w, i);
        sl_gather_irradiance(g->gather, &p, g->scratch, &out[i], g->counters);
    }
}

static void scratch_remembers_nothing(void **state) {
    world *w = world_room(true);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = settings_of(gather_kinds[k]);
        gatherer g = gatherer_new(w, &s);
        sl_irradiance first[POINTS], again[POINTS], fresh[1];
        gather_all(&g, w, first);
        gather_all(&g, w, again);
        assert_memory_equal(first, again, sizeof first);
        gatherer clean = gatherer_new(w, &s);
        sl_gather_point p = world_surface_point(w, POINTS - 1);
        memset(fresh, 0, sizeof fresh);
        sl_gather_irradiance(clean.gather, &p, clean.scratch, fresh, clean.counters);
        assert_memory_equal(fresh, &first[POINTS - 1], sizeof fresh);
        gatherer_free(&g), gatherer_free(&clean);
    }
    world_free(w);
}

static void keys_choose_the_jitter(void **state) {
    world *w = world_room(true);
    sl_gather_settings s = settings_of(SL_GATHER_RAYS);
    gatherer g = gatherer_new(w, &s);
    sl_irradiance a = gather_at(&g, sl_v3(2, 1, 3), sl_v3(0, 1, 0), 1),
                  b = gather_at(&g, sl_v3(2, 1, 3), sl_v3(0, 1, 0), 2);
    sl_irradiance c = gather_at(&g, sl_v3(2, 1, 3), sl_v3(0, 1, 0), 1);
    assert_true(a.value.g != b.value.g && a.value.g == c.value.g);
    assert_true(fabs((double)(a.value.g / b.value.g) - 1) < 0.05);
    gatherer_free(&g);
    world_free(w);
}

/* The picture is what was summed: radiance and distance where something is seen, bottom row first. */
static void picture_shows_what_was_seen(void **state) {
    world *w = world_new();
    uint32_t shine = world_material(w, sl_grey(0), (sl_rgb){1, 2, 3}),
             dark = world_material(w, sl_grey(0), sl_grey(0));
    /* y > 0 above */
    world_quad(w, sl_v3(-90, 0, 1), sl_v3(-90, 90, 1), sl_v3(90, 90, 1), sl_v3(90, 0, 1), shine);
    world_quad(w, sl_v3(-90, -90, 2), sl_v3(-90, 0, 2), sl_v3(90, 0, 2), sl_v3(90, -90, 2), dark);
    world_build(w);
    for (int k = 0; k < 3; k++) {
        sl_gather_settings s = settings_of(gather_kinds[k]);
        s.emission = true;
        s.size = 32;
        s.jitter = false;
        gatherer g = gatherer_new(w, &s);
        gather_at(&g, sl_v3(0, 0, 0), sl_v3(0, 0, 1), 1); /* the frame of +z is the world's axes */
        sl_gather_picture p = sl_gather_last_picture(g.scratch);
        assert_int_equal(p.width, gather_kinds[k] == SL_GATHER_HEMICUBE ? 64 : 32);
        size_t centre = (size_t)(p.height / 2) * (size_t)p.width + (size_t)(p.width / 2),
               below = centre - 2 * (size_t)p.width;
        assert_true(p.r[centre] == 1 && p.g[centre] == 2 && p.b[centre] == 3);
        assert_true(p.r[below] == 0 && p.g[below] == 0);
        assert_true(fabsf(p.distance[centre] - 1) < 0.05f && fabsf(p.distance[below] - 2) < 0.2f);
        gatherer_free(&g);
    }
    world_free(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scratch_remembers_nothing),
        cmocka_unit_test(keys_choose_the_jitter),
        cmocka_unit_test(picture_shows_what_was_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
