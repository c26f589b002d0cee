/* Light at a gather's hits by samples: their mean is the light that there is. */
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "gather_world.h"
#include "polygon_truth.h"

/* ---- a floor under lamps, some of them covered from below ---- */
#define FLOOR_ALBEDO 0.6
enum { ROW = 5 };

static sl_vec3 lamp_corner(int i, int corner, float z, float size, float pitch) {
    float x = -1.6f + pitch * (float)(i % ROW), y = -1.6f + pitch * (float)(i / ROW);
    return sl_v3(x + (corner == 1 || corner == 2 ? size : 0.0f), y + (corner >= 2 ? size : 0.0f), z);
}

/* Lamps face down; `covered` more of them lie far to the side, above an opaque plate. */
static world *lamps_over_floor(int lamps, int covered, float size, float pitch) {
    world *w = world_new();
    uint32_t floor = world_material(w, sl_grey((float)FLOOR_ALBEDO), sl_grey(0)),
             black = world_material(w, sl_grey(0), sl_grey(0));
    world_quad(w, sl_v3(-30, -30, 0), sl_v3(30, -30, 0), sl_v3(30, 30, 0), sl_v3(-30, 30, 0), floor);
    for (int i = 0; i < lamps + covered; i++) {
        uint32_t lamp = world_material(w, sl_grey(0), sl_grey(2.0f + (float)(i % 3)));
        sl_vec3 c[4], side = sl_v3(i < lamps ? 0.0f : 8.0f, 0.0f, 0.0f);
        for (int k = 0; k < 4; k++)
            c[k] = sl_add(lamp_corner(i < lamps ? i : i - lamps, k, 2.0f, size, pitch), side);
        world_quad(w, c[0], c[3], c[2], c[1], lamp);
    }
    if (covered)
        world_quad(w, sl_v3(5, -4, 1.9f), sl_v3(5, 4, 1.9f), sl_v3(14, 4, 1.9f), sl_v3(14, -4, 1.9f), black);
    world_build(w);
    return w;
}

typedef struct lamp {
    sl_vec3d corner[4];
    double radiance;
} lamp;

/* Irradiance of a receiver over the floor at (x, 0, h) that looks down, by the lamps' closed form at 256 x
 * 256 places. */
static double light_from_floor(int lamps, const lamp *lamps_of, double x, double h) {
    enum { N = 256 };
    double sum = 0;
    for (int i = 0; i < N * N; i++) {
        double u, v;
        sl_concentric_disc((2.0 * (i % N) + 1.0) / N - 1.0, (2.0 * (i / N) + 1.0) / N - 1.0, &u, &v);
        double z = sqrt(fmax(1e-12, 1 - u * u - v * v)), e = 0;
        sl_vec3d p = {x + h * u / z, -h * v / z, 0};
        if (fabs(p.x) > 30 || fabs(p.y) > 30) continue;
        for (int l = 0; l < lamps; l++)
            e += lamps_of[l].radiance * polygon_irradiance(p, sl_v3d(0, 0, 1), lamps_of[l].corner, 4, NULL);
        sum += e * FLOOR_ALBEDO / (N * N);
    }
    return sum;
}

/* Of those over the middle; the plate over the covered ones is far enough aside to take next to nothing of
 * what arrives. */
static double floor_light(int lamps, float size, float pitch, double h) {
    lamp of[140];
    assert_true(lamps <= 140);
    for (int l = 0; l < lamps; l++) {
        of[l].radiance = 2.0 + l % 3;
        for (int k = 0; k < 4; k++) of[l].corner[3 - k] = sl_to_double(lamp_corner(l, k, 2.0f, size, pitch));
    }
    return light_from_floor(lamps, of, 0.0, h);
}

typedef struct spread {
    double mean, deviation;
} spread;

static spread many_keys(world *w, const sl_gather_settings *s, sl_vec3 p, sl_vec3 n, int keys) {
    gatherer g = gatherer_new(w, s);
    double sum = 0, squares = 0;
    for (int i = 0; i < keys; i++) {
        double e = (double)gather_at(&g, p, n, 1000 + (uint64_t)i).value.g;
        sum += e;
        squares += e * e;
    }
    gatherer_free(&g);
    sum /= keys;
    return (spread){sum, sqrt(fmax(0.0, squares / keys - sum * sum))};
}

static sl_gather_settings rays_of(int size) {
    sl_gather_settings s = gather_settings(SL_GATHER_RAYS, size);
    s.emission = false;
    return s;
}

static void samples_mean_what_the_closed_form_says(void **state) {
    enum { KEYS = 60 };
    /* 40 emitters; 10 visible and 50 covered ones; more than are weighed at every hit. */
    const struct { int lamps, covered; float size, pitch; double allowed; } cases[3] = {
        {20, 0, 0.5f, 0.8f, 0.004}, {5, 25, 0.5f, 0.8f, 0.006}, {140, 0, 0.09f, 0.13f, 0.01}};
    for (int i = 0; i < 3; i++) {
        world *w = lamps_over_floor(cases[i].lamps, cases[i].covered, cases[i].size, cases[i].pitch);
        double truth = floor_light(cases[i].lamps, cases[i].size, cases[i].pitch, 0.5);
        for (uint32_t samples = 1; samples <= 3; samples += 2) {
            sl_gather_settings s = rays_of(24);
            s.hit_samples = samples;
            spread e = many_keys(w, &s, sl_v3(0, 0, 0.5f), sl_v3(0, 0, -1), KEYS);
            print_message("%d + %d lamps, %u samples: %.5f, truth %.5f, one gather's deviation %.2f %%\n",
                          cases[i].lamps, cases[i].covered, samples, e.mean, truth,
                          100 * e.deviation / truth);
            assert_true(fabs(e.mean / truth - 1) < cases[i].allowed);
            assert_true(e.deviation < 0.02 * truth);
        }
        world_free(w);
    }
}

/* The half of a lamp that is nearer to the hits, and gives most, is hidden by a plate right beneath it. */
static void what_is_hidden_of_a_lamp_counts_by_what_it_would_give(void **state) {
    enum { KEYS = 60 };
    world *w = world_new();
    uint32_t floor = world_material(w, sl_grey((float)FLOOR_ALBEDO), sl_grey(0)),
             black = world_material(w, sl_grey(0), sl_grey(0)),
             bright = world_material(w, sl_grey(0), sl_grey(2));
    world_quad(w, sl_v3(-30, -30, 0), sl_v3(30, -30, 0), sl_v3(30, 30, 0), sl_v3(-30, 30, 0), floor);
    world_quad(w, sl_v3(-1, -0.5f, 2), sl_v3(-1, 0.5f, 2), sl_v3(1, 0.5f, 2), sl_v3(1, -0.5f, 2), bright);
    world_quad(w, sl_v3(0, -2, 1.99f), sl_v3(0, 2, 1.99f), sl_v3(2, 2, 1.99f), sl_v3(2, -2, 1.99f), black);
    world_build(w);
    const lamp seen = {{{-1, -0.5, 2}, {-1, 0.5, 2}, {0, 0.5, 2}, {0, -0.5, 2}}, 2.0};
    double truth = light_from_floor(1, &seen, 3.0, 0.25);
    sl_gather_settings s = rays_of(24);
    s.hit_samples = 4;
    spread e = many_keys(w, &s, sl_v3(3, 0, 0.25f), sl_v3(0, 0, -1), KEYS);
    print_message("half hidden: %.6f, truth %.6f\n", e.mean, truth);
    assert_true(fabs(e.mean / truth - 1) < 0.04);
    world_free(w);
}

/* An open floor under an even sky: every hit gets pi L whatever direction is drawn. */
static void open_floor_under_an_even_sky_has_no_noise(void **state) {
    world *w = world_new();
    uint32_t floor = world_material(w, sl_grey(0.5f), sl_grey(0));
    world_quad(w, sl_v3(-3000, -3000, 0), sl_v3(3000, -3000, 0), sl_v3(3000, 3000, 0), sl_v3(-3000, 3000, 0),
               floor);
    w->environment = (sl_environment){.present = true, .constant = sl_grey(2)};
    world_build(w);
    sl_gather_settings s = rays_of(32);
    s.hit_samples = 4;
    spread e = many_keys(w, &s, sl_v3(0, 0, 1), sl_v3(0, 0, -1), 8);
    assert_true(fabs(e.mean / (SL_PI * 0.5 * 2) - 1) < 0.01);
    assert_true(e.deviation < 0.01 * e.mean);
    world_free(w);
}

/* ---- more rays ---- */

/* A small bright square overhead, whose irradiance is known. */
static void more_rays_keep_the_mean_and_scatter_less(void **state) {
    enum { KEYS = 300 };
    world *w = world_new();
    world_quad(w, sl_v3(0.31f, 0.2f, 2), sl_v3(0.31f, 0.9f, 2), sl_v3(1.0f, 0.9f, 2), sl_v3(1.0f, 0.2f, 2),
               world_material(w, sl_grey(0), sl_grey(5)));
    world_build(w);
    const sl_vec3d corner[4] = {{0.31, 0.2, 2}, {0.31, 0.9, 2}, {1.0, 0.9, 2}, {1.0, 0.2, 2}};
    double truth = 5 * polygon_irradiance(sl_v3d(0, 0, 0), sl_v3d(0, 0, 1), corner, 4, NULL);
    spread e[2];
    for (int more = 0; more < 2; more++) {
        sl_gather_settings s = rays_of(16);
        s.emission = true;
        s.more_rays = more ? 0.5f : 0.0f;
        e[more] = many_keys(w, &s, sl_v3(0, 0, 0), sl_v3(0, 0, 1), KEYS);
        print_message("%s rays: %.5f, truth %.5f, deviation %.2f %%\n", more ? "more" : "plain", e[more].mean,
                      truth, 100 * e[more].deviation / truth);
        assert_true(fabs(e[more].mean - truth) < 4 * e[more].deviation / sqrt(KEYS) + 1e-6 * truth);
    }
    assert_true(e[1].deviation < 0.6 * e[0].deviation);
    world_free(w);
}

static void more_rays_are_as_many_as_asked_for_at_most(void **state) {
    world *w = world_room(true);
    const float wanted[4] = {0.0f, 0.5f, 2.0f, NAN};
    for (int i = 0; i < 4; i++) {
        sl_gather_settings s = rays_of(20);
        s.more_rays = wanted[i];
        gatherer g = gatherer_new(w, &s);
        uint64_t before = w->counters.value[SL_COUNT_RAYS];
        gather_at(&g, sl_v3(2, 1, 3), sl_v3(0, 1, 0), 5);
        uint64_t rays = w->counters.value[SL_COUNT_RAYS] - before;
        assert_true(rays >= 400 && rays <= 400 + (i == 1 ? 200 : i == 2 ? 800 : 0));
        if (i == 1) assert_true(rays > 560);
        gatherer_free(&g);
    }
    world_free(w);
}

/* A row of lamps that stand on the floor, more than are weighed at every hit: half of what it gets arrives
 * within a lamp's height. */
static void what_many_lamps_give_close_by_is_not_cut(void **state) {
    enum { LAMPS = 40 };
    world *w = world_new();
    uint32_t floor = world_material(w, sl_grey((float)FLOOR_ALBEDO), sl_grey(0)),
             bright = world_material(w, sl_grey(0), sl_grey(2));
    world_quad(w, sl_v3(-30, -30, 0), sl_v3(30, -30, 0), sl_v3(30, 30, 0), sl_v3(-30, 30, 0), floor);
    for (int i = 0; i < LAMPS; i++) {
        const float y = 0.1f * (float)(i - LAMPS / 2);
        world_quad(w, sl_v3(0.2f, y, 0), sl_v3(0.2f, y, 0.1f), sl_v3(0.2f, y + 0.1f, 0.1f),
                   sl_v3(0.2f, y + 0.1f, 0), bright);
    }
    world_build(w);
    const lamp row = {{{0.2, -2, 0}, {0.2, -2, 0.1}, {0.2, 2, 0.1}, {0.2, 2, 0}}, 2.0};
    const double truth = light_from_floor(1, &row, 0.0, 0.5);
    const sl_gather_settings s = rays_of(24);
    const spread e = many_keys(w, &s, sl_v3(0, 0, 0.5f), sl_v3(0, 0, -1), 600);
    assert_within(e.mean / truth, 1.0, 0.025);
    world_free(w);
}

/* Of a lobe ks (n + 2) / (2 pi) cos^n lit from straight above, an eye that looks down gathers ks E. */
static void glossy_floors_send_back_what_their_lobes_reflect(void **state) {
    world *w = world_new();
    const uint32_t floor = world_material(w, sl_grey(0), sl_grey(0));
    w->materials[floor].specular = sl_grey(0.5f), w->materials[floor].exponent = 20.0f;
    world_quad(w, sl_v3(-30, -30, 0), sl_v3(30, -30, 0), sl_v3(30, 30, 0), sl_v3(-30, 30, 0), floor);
    w->lights[w->light_count++] =
        (sl_light){.type = SL_LIGHT_DIRECTIONAL, .direction = {0, 0, -1}, .intensity = sl_grey(3)};
    world_build(w);
    sl_gather_settings s = rays_of(24);
    assert_true(gather_once(w, &s, sl_v3(0, 0, 0.5f), sl_v3(0, 0, -1)).value.g == 0.0f);
    s.all_lobes = true;
    assert_within((double)gather_once(w, &s, sl_v3(0, 0, 0.5f), sl_v3(0, 0, -1)).value.g, 1.5, 0.015);
    world_free(w);
}

/* An eye that looks down on a mirror sees a lamp above it as if it were below. */
static void mirrors_show_lamps_to_gathers(void **state) {
    world *w = world_new();
    const uint32_t mirror = world_material(w, sl_grey(0), sl_grey(0)),
                   bright = world_material(w, sl_grey(0), sl_grey(2));
    w->materials[mirror].mirror = sl_grey(0.8f);
    world_quad(w, sl_v3(-30, -30, 0), sl_v3(30, -30, 0), sl_v3(30, 30, 0), sl_v3(-30, 30, 0), mirror);
    world_quad(w, sl_v3(-1, -1, 2), sl_v3(-1, 1, 2), sl_v3(1, 1, 2), sl_v3(1, -1, 2), bright);
    world_build(w);
    const sl_vec3d seen[4] = {{-1, -1, -2}, {1, -1, -2}, {1, 1, -2}, {-1, 1, -2}};
    const double truth = 0.8 * 2.0 * polygon_irradiance(sl_v3d(0, 0, 0.5), sl_v3d(0, 0, -1), seen, 4, NULL);
    sl_gather_settings s = rays_of(24);
    s.all_lobes = true;
    assert_within(many_keys(w, &s, sl_v3(0, 0, 0.5f), sl_v3(0, 0, -1), 60).mean / truth, 1.0, 0.01);
    world_free(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_mean_what_the_closed_form_says),
        cmocka_unit_test(what_is_hidden_of_a_lamp_counts_by_what_it_would_give),
        cmocka_unit_test(open_floor_under_an_even_sky_has_no_noise),
        cmocka_unit_test(more_rays_keep_the_mean_and_scatter_less),
        cmocka_unit_test(more_rays_are_as_many_as_asked_for_at_most),
        cmocka_unit_test(what_many_lamps_give_close_by_is_not_cut),
        cmocka_unit_test(glossy_floors_send_back_what_their_lobes_reflect),
        cmocka_unit_test(mirrors_show_lamps_to_gathers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
