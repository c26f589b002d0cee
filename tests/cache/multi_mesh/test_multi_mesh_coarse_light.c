/* Direct light on the coarse mesh's vertices: few rays, and of many lights those that matter. */
#include "light_sample_support.h"

#include "cache/multi_mesh/coarse.h"
#include "cache/patches/irradiance.h"

enum { LAMPS = 40, POINTS = 50 };

typedef struct lit_hall {
    light_world world;
    sl_primitives *primitives;
    sl_irradiance_settings light;
    sl_counters counters;
} lit_hall;

/* Takes the mesh. */
static lit_hall hall_of(trace_mesh *mesh) {
    lit_hall h = {.world = light_world_make(mesh)};
    assert_int_equal(sl_primitives_of_triangles(h.world.scene, &h.primitives, NULL), SL_OK);
    h.light = (sl_irradiance_settings){.scene = h.world.scene,
                                       .primitives = h.primitives,
                                       .tracer = h.world.tracer,
                                       .lights = h.world.lights,
                                       .sampling = h.world.sampling,
                                       .threads = 1};
    return h;
}

/* A floor of two triangles, and above it a row of lamps; those from `hidden` on have a plate below them that
 * hides them from all of the floor. */
static lit_hall hall(int hidden) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f), lamp = trace_mesh_lamp(&mesh, 1.0f);
    trace_mesh_quad(&mesh, sl_v3(-50, 0, -8), sl_v3(0, 0, 16), sl_v3(100, 0, 0), grey);
    for (int i = 0; i < LAMPS; i++) {
        float x = -50.0f + 100.0f * (float)i / LAMPS;
        trace_mesh_quad(&mesh, sl_v3(x, 3.0f + 0.02f * (float)i, -0.5f), sl_v3(1, 0, 0), sl_v3(0, 0, 1),
                        lamp);
        if (i >= hidden)
            trace_mesh_quad(&mesh, sl_v3(x - 0.4f, 2.99f + 0.02f * (float)i, -0.9f), sl_v3(0, 0, 1.8f),
                            sl_v3(1.8f, 0, 0), grey);
    }
    lit_hall h = hall_of(&mesh);
    assert_int_equal(h.world.lights->count, LAMPS);
    return h;
}

static void discard(lit_hall *h) {
    sl_primitives_destroy(h->primitives);
    light_world_free(&h->world);
}

/* pi U_dd without occluders, of the lights up to `count`. */
static double unoccluded(const lit_hall *h, const sl_root_place *v, size_t count) {
    sl_mesh_point at = sl_mesh_point_at(h->primitives, *v);
    sl_lit_point point = at.lit;
    double sum = 0.0;
    for (size_t l = 0; l < count; l++)
        sum += sl_light_unoccluded(&h->world.lights->light[l], &point) *
               (double)h->world.lights->light[l].colour.g;
    return sum;
}

static void take_light(lit_hall *h, size_t count, const sl_root_place *vertex, sl_rgb *radiance) {
    const sl_status status =
        sl_coarse_light_take(&h->light, count, vertex, false, NULL, radiance, &h->counters, NULL);
    assert_int_equal(status, SL_OK);
}

/* Takes the light at places all over the floor's upper side. */
static void take_light_all_over(lit_hall *h, sl_root_place vertex[POINTS], sl_rgb radiance[POINTS]) {
    for (int i = 0; i < POINTS; i++) {
        int p = 60 + 35 * i, q = 40 + (i * 7 % 23) * 80;
        q = q < SL_PATCH_DYADIC - p ? q : 10;
        vertex[i] = (sl_root_place){0, (uint16_t)p, (uint16_t)q};
    }
    take_light(h, POINTS, vertex, radiance);
}

static void where_nothing_is_between_all_lights_count_though_few_are_asked(void **state) {
    lit_hall h = hall(LAMPS);
    sl_root_place vertex[POINTS];
    sl_rgb radiance[POINTS];
    take_light_all_over(&h, vertex, radiance);
    for (int i = 0; i < POINTS; i++) {
        double expected = unoccluded(&h, &vertex[i], LAMPS);
        assert_true(fabs((double)radiance[i].g * SL_PI / expected - 1.0) < 1e-4);
    }
    uint64_t asked = h.counters.value[SL_COUNT_LIGHT_SAMPLES];
    print_message("%.1f of %d lights asked\n", (double)asked / POINTS, LAMPS);
    assert_true(asked < POINTS * LAMPS / 2);
    discard(&h);
}

/* Lights that are not asked could give a thirtieth of all at most. */
static void lights_that_are_not_asked_are_off_by_no_more_than_they_could_give(void **state) {
    lit_hall h = hall(LAMPS / 2);
    sl_root_place vertex[POINTS];
    sl_rgb radiance[POINTS];
    take_light_all_over(&h, vertex, radiance);
    for (int i = 0; i < POINTS; i++) {
        double seen = unoccluded(&h, &vertex[i], LAMPS / 2), all = unoccluded(&h, &vertex[i], LAMPS);
        assert_true(fabs((double)radiance[i].g * SL_PI - seen) < 0.0301 * all);
    }
    discard(&h);
}

/* ---- borders ---- */

/* Posts, which are no solids, stand on the corners of a floor; none of these sees the lamp, nearly all of the
 * floor does. */
static void things_that_stand_on_a_floors_corners_do_not_make_it_dark(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f), lamp = trace_mesh_lamp(&mesh, 1.0f);
    trace_mesh_quad(&mesh, sl_v3(-2, 0, -2), sl_v3(0, 0, 4), sl_v3(4, 0, 0), grey);
    trace_mesh_quad(&mesh, sl_v3(-0.5f, 4, -0.5f), sl_v3(1, 0, 0), sl_v3(0, 0, 1), lamp);
    for (int k = 0; k < 4; k++) {
        float x = k & 1 ? 1.8f : -2.2f, z = k & 2 ? 1.8f : -2.2f;
        trace_mesh_quad(&mesh, sl_v3(x, -0.1f, z), sl_v3(0.4f, 0, 0), sl_v3(0, 2, 0), grey);
        trace_mesh_quad(&mesh, sl_v3(x, -0.1f, z), sl_v3(0, 0, 0.4f), sl_v3(0, 2, 0), grey);
        trace_mesh_quad(&mesh, sl_v3(x + 0.4f, -0.1f, z), sl_v3(0, 0, 0.4f), sl_v3(0, 2, 0), grey);
        trace_mesh_quad(&mesh, sl_v3(x, -0.1f, z + 0.4f), sl_v3(0.4f, 0, 0), sl_v3(0, 2, 0), grey);
    }
    lit_hall h = hall_of(&mesh);
    sl_coarse *coarse;
    assert_int_equal(sl_coarse_create(h.world.scene, h.primitives, 100.0f, 0, &coarse, NULL), SL_OK);
    size_t floor = 0;
    for (size_t i = 0; i < coarse->vertex_count; i++) {
        sl_rgb radiance;
        const sl_root_place v = sl_coarse_lit_place(coarse, i);
        if (v.root != 0 && v.root != 2) continue;
        take_light(&h, 1, &v, &radiance);
        floor++;
        double open = unoccluded(&h, &v, 1) / SL_PI;
        assert_true((double)radiance.g > 0.9 * open);
    }
    assert_int_equal(floor, 4);
    sl_coarse_destroy(coarse);
    discard(&h);
}

/* ---- few rays ---- */

/* All over a penumbra: a single sample by 4 x 4 or 8 x 8 rays is off by some percent, a thousand of them
 * together by a third of a percent at most. */
static void few_rays_are_off_to_either_side_alike(void **state) {
    enum { POINTS_A_SIDE = 32 };
    trace_mesh mesh = trace_mesh_begin();
    uint32_t grey = trace_mesh_diffuse(&mesh, 0.5f);
    add_ceiling_light(&mesh, -0.5f, -0.5f, 1, 1, 3);
    trace_mesh_quad(&mesh, sl_v3(-0.3f, 1.5f, -0.4f), sl_v3(0.2f, 0, 1), sl_v3(0.9f, 0, -0.1f), grey);
    light_world w = light_world_make(&mesh);
    double sum = 0.0, by_rays[2] = {0.0, 0.0}, worst = 0.0;
    for (int i = 0; i < POINTS_A_SIDE * POINTS_A_SIDE; i++) {
        sl_vec3 p = sl_v3(-1.5f + 3.0f * ((float)(i % POINTS_A_SIDE) + 0.5f) / POINTS_A_SIDE, 0,
                          -1.5f + 3.0f * ((float)(i / POINTS_A_SIDE) + 0.5f) / POINTS_A_SIDE);
        sl_lit_point point = lit_point(p, sl_v3(0, 1, 0));
        double exact = sample_light(&w, 0, p, point.normal);
        sum += exact;
        for (int k = 0; k < 2; k++) {
            double some = (double)sl_light_sample_by_rays(w.sampling, 0, &point, k ? 8 : 4, &w.counters);
            by_rays[k] += some;
            worst = fmax(worst, fabs(some / exact - 1.0));
        }
    }
    print_message("4 x 4: %+.3f %%, 8 x 8: %+.3f %%; a single one up to %.0f %%\n",
                  100.0 * (by_rays[0] / sum - 1.0), 100.0 * (by_rays[1] / sum - 1.0), 100.0 * worst);
    for (int k = 0; k < 2; k++) assert_true(fabs(by_rays[k] / sum - 1.0) < 0.003);
    assert_true(worst > 0.02); /* or there would be nothing to see */
    light_world_free(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(where_nothing_is_between_all_lights_count_though_few_are_asked),
        cmocka_unit_test(lights_that_are_not_asked_are_off_by_no_more_than_they_could_give),
        cmocka_unit_test(things_that_stand_on_a_floors_corners_do_not_make_it_dark),
        cmocka_unit_test(few_rays_are_off_to_either_side_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
