/* Pass 6: direct light of receivers, (3) to (9), against closed forms. */
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "receiver_support.h"
#include "trace_scenes.h"

/* ---- lights by hand ---- */

enum { LIGHTS = 4 };

typedef struct {
    sl_map_lights lights;
    sl_map_light light[LIGHTS];
} lamps;

static void add_lamp(lamps *l, sl_map_light light) {
    size_t i = l->lights.count++;
    l->light[i] = light;
    l->lights.light = l->light;
}

static sl_map_light point_light(sl_vec3 position) {
    return (sl_map_light){
        .source = {.kind = SL_SOURCE_POINT, .position = position, .colour = {3.0f, 2.0f, 1.0f}}};
}

static sl_map_light area_light(sl_vec3 position, sl_vec3 normal, float area, bool two_sided) {
    sl_rgb intensity = sl_rgb_scale((sl_rgb){3.0f, 2.0f, 1.0f}, area);
    return (sl_map_light){.source.kind = SL_SOURCE_AREA,
                          .source.position = position,
                          .source.direction = normal,
                          .source.colour = intensity,
                          .area = area,
                          .source.two_sided = two_sided};
}

static planes light_up(const sl_scene *scene, lamps *l, const sl_gbuffer *receivers,
                       unsigned threads) {
    sl_light_pass pass = {.scene = scene, .lights = &l->lights, .threads = threads};
    planes p = make_planes((size_t)receivers->width * (size_t)receivers->height);
    sl_lit_picture picture = {.direct = {p.value[0], p.value[1], p.value[2]}};
    sl_counters counters = {{0}};
    light_directly(&pass, receivers, &picture, &counters);
    return p;
}

/* Radiance from one receiver of material m at x. */
static sl_rgb radiance_at(const sl_scene *scene, sl_map_light light, sl_vec3 x, sl_vec3 n, sl_vec3 eye,
                          uint32_t material) {
    lamps l = {.lights = {.count = 0}};
    add_lamp(&l, light);
    sl_gbuffer *r = make_receivers(1, 1, eye);
    set_receiver(r, 0, x, n, n, scene->materials[material].diffuse, material);
    planes p = light_up(scene, &l, r, 1);
    sl_rgb radiance = {p.value[0][0], p.value[1][0], p.value[2][0]};
    free_planes(&p);
    sl_gbuffer_destroy(r);
    return radiance;
}

static const sl_vec3 up = {0, 0, 1}, origin = {0, 0, 0};

static double irradiance(const sl_scene *scene, sl_map_light light, sl_vec3 x, sl_vec3 n) {
    return (double)radiance_at(scene, light, x, n, sl_v3(0, 0, 5), DIFFUSE_MATERIAL).r / 0.5 * SL_PI;
}

static void assert_near(double got, double expected) {
    if (!(fabs(got - expected) <= 2e-6 * fabs(expected))) fail_msg("%.9g instead of %.9g", got, expected);
}

/* ---- irradiance ---- */

static void point_light_falls_with_cosine_and_squared_distance(void **state) {
    const sl_vec3 positions[] = {{0, 0, 2}, {1, 0, 2}, {-3, 4, 0.5f}, {0, 0, 1e4f}, {1e-4f, 0, 1e-4f}};
    for (size_t i = 0; i < sizeof positions / sizeof *positions; i++) {
        sl_vec3d d = sl_to_double(positions[i]);
        double r = sl_lengthd(d);
        assert_near(irradiance(*state, point_light(positions[i]), origin, up), 3.0 * (d.z / r) / (r * r));
    }
}

/* The error of taking an area light for "very distant": (9) over the exact irradiance of a square light of
 * side s, at height d above a parallel plane, d / s = 0.5, 1, 2, 5. E of a square is the sum over four
 * corners, (L/2) sum of x / sqrt(1 + x^2) atan(y / sqrt(1 + x^2)) + likewise. */
static double corner_factor(double x, double y) {
    double p = sqrt(1.0 + x * x), q = sqrt(1.0 + y * y);
    return 0.5 * (x / p * atan(y / p) + y / q * atan(x / q));
}

static double rectangle_irradiance(double x0, double x1, double y0, double y1) {
    return corner_factor(x1, y1) - corner_factor(x0, y1) - corner_factor(x1, y0) + corner_factor(x0, y0);
}

static void area_light_from_its_centre_has_the_error_of_a_very_distant_one(void **state) {
    const double table[4][4] = {{0.5, 2.30, 0.951, 0.729},
                                {1, 1.33, 0.943, 0.915},
                                {2, 1.083, 0.981, 0.977},
                                {5, 1.013, 0.997, 0.996}};
    for (int i = 0; i < 4; i++) {
        double d = table[i][0], half = 0.5 / d;
        sl_map_light light = area_light(sl_v3(0, 0, (float)d), sl_v3(0, 0, -1), 1.0f, false);
        for (int aside = 0; aside < 3; aside++) {
            double got = irradiance(*state, light, sl_v3((float)(aside * d), 0, 0), up);
            double exact = 3.0 * rectangle_irradiance(-half - aside, half - aside, -half, half);
            if (!(fabs(got / exact - table[i][1 + aside]) < 0.006 * table[i][1 + aside]))
                fail_msg("d/s = %g, %d d aside: %g", d, aside, got / exact);
        }
    }
}

static void emitters_back_is_dark_unless_it_has_two_sides(void **state) {
    sl_vec3 l = sl_v3(0.5f, 0, 2);
    double front = irradiance(*state, area_light(l, sl_v3(0, 0, -1), 1.0f, true), origin, up);
    assert_near(irradiance(*state, area_light(l, sl_v3(0, 0, -1), 1.0f, false), origin, up), front);
    assert_true(irradiance(*state, area_light(l, sl_v3(0, 0, 1), 1.0f, false), origin, up) == 0.0);
    assert_near(irradiance(*state, area_light(l, sl_v3(0, 0, 1), 1.0f, true), origin, up), front);
}

/* ---- lobes ---- */

static void glossy_receiver_has_the_modified_phong_lobe(void **state) {
    sl_vec3 eye = sl_v3(1.0f, 0.3f, 1.5f), light = sl_v3(-1.2f, 0.1f, 1.4f);
    sl_vec3d v = sl_to_double(eye), l = sl_to_double(light);
    double r = sl_lengthd(l), cosine = (-v.x * l.x - v.y * l.y + v.z * l.z) / (sl_lengthd(v) * r),
           e = 3.0 * l.z / (r * r * r);
    double expected = e * ((double)0.3f / SL_PI + (double)0.4f * 22.0 / (2.0 * SL_PI) * pow(cosine, 20.0));
    sl_rgb got = radiance_at(*state, point_light(light), origin, up, eye, GLOSSY_MATERIAL);
    assert_true(fabs((double)got.r - expected) < 1e-5 * expected);
}

/* A lamp of side 0.8 whole, and cut into 20 x 20: what its highlight is above the floor, below a lamp of two
 * sides too. */
static void highlight_of_an_area_light_is_as_wide_as_the_light(void **state) {
    enum { N = 20 };
    for (int below = 0; below < 2; below++) {
        const sl_vec3 eye = sl_v3(0, 0, 3), normal = sl_v3(0, 0, below ? 1 : -1);
        double whole = (double)radiance_at(*state, area_light(sl_v3(0, 0, 2), normal, 0.64f, below), origin,
                                           up, eye, GLOSSY_MATERIAL)
                           .r,
               parts = 0.0;
        for (int i = 0; i < N * N; i++) {
            sl_vec3 at = sl_v3(0.8f * (((float)(i % N) + 0.5f) / N - 0.5f),
                               0.8f * (((float)(i / N) + 0.5f) / N - 0.5f), 2);
            parts += (double)radiance_at(*state, area_light(at, normal, 0.64f / (N * N), below), origin, up,
                                         eye, GLOSSY_MATERIAL)
                         .r;
        }
        if (!(fabs(whole / parts - 1.0) < 0.12)) fail_msg("%g instead of %g", whole, parts);
    }
}

/* The brightest pixel of a glossy floor lies where the mirrored eye sees the light; two eyes in one picture.
 */
static void highlight_moves_with_the_eye(void **state) {
    enum { N = 200 };
    sl_gbuffer *r = make_receivers(N, 2, sl_v3(-1, 0, 1));
    for (int i = 0; i < 2 * N; i++) {
        if (i >= N) r->seen_from[i] = sl_v3(0.1f, 0, 3);
        set_receiver(r, (size_t)i, sl_v3(-1.0f + 2.0f * ((float)(i % N) + 0.5f) / N, 0, 0), up, up,
                     sl_grey(0), GLOSSY_MATERIAL);
    }
    lamps l = {.lights = {.count = 0}};
    add_lamp(&l, (sl_map_light){.source.kind = SL_SOURCE_DIRECTIONAL,
                                .source.direction = {-0.2f / sqrtf(1.04f), 0, -1.0f / sqrtf(1.04f)},
                                .source.colour = {1, 1, 1}});
    planes p = light_up(*state, &l, r, 1);
    for (int path = 0; path < 2; path++) {
        int best = 0;
        for (int i = 1; i < N; i++) best = p.value[0][path * N + i] > p.value[0][path * N + best] ? i : best;
        double x = -1.0 + 2.0 * (best + 0.5) / N,
               mirrored = (double)r->seen_from[path * N].x + 0.2 * (double)r->seen_from[path * N].z;
        assert_true(fabs(x - mirrored) < 1.5 / N);
    }
    free_planes(&p);
    sl_gbuffer_destroy(r);
}

/* Of one receiver in the origin whose mirrored eye looks along (x, y, 1), towards a disc of radius 0.2 there,
 * turned by a normal. */
static float lobe_towards(float x, float y, float exponent, sl_vec3 at, sl_vec3 normal) {
    static sl_receiver_tile t;
    float power[SL_TILE_PIXELS];
    sl_vec3 axis = sl_normalize_or(sl_v3(x, y, 1), sl_v3(0, 0, 1));
    t = (sl_receiver_tile){.count = 1, .padded = SL_TILE_LANES};
    t.mirrored_x[0] = axis.x, t.mirrored_y[0] = axis.y, t.mirrored_z[0] = axis.z, t.exponent[0] = exponent;
    const sl_lobe_target target = {.towards = at, .normal = normal, .extent = 0.01f}; /* A / 4 pi */
    SL_KERNEL_OF(sl_isa_best(), sl_receiver_lobe_power)(&t, &target, power);
    return power[0];
}

static void a_sharp_lobe_shows_a_lamps_point_as_a_disc_with_hard_rims(void **state) {
    const sl_vec3 middle = sl_v3(0, 0, 1), facing = sl_v3(0, 0, -1), turned = sl_v3(0, 0.8f, -0.6f);
    const float inside = 2.0f / (1e5f * 0.04f);
    assert_true(fabsf(lobe_towards(0.18f, 0, 1e5f, middle, facing) / inside - 1) < 0.01f);
    assert_true(lobe_towards(0.22f, 0, 1e5f, middle, facing) == 0);
    assert_true(lobe_towards(0, 0.18f, 1e5f, middle, turned) == 0 &&
                lobe_towards(0.18f, 0, 1e5f, middle, turned) > inside);
    assert_true(lobe_towards(-0.6f, 0, 1e5f, middle, facing) == 0);
}

static void a_lobe_is_finite_towards_discs_seen_from_their_edge_or_from_within(void **state) {
    const sl_vec3 at[] = {{0, 0, 1}, {0, 0, 0}, {0, 0, 1e-30f}, {0, 0, 1e18f}},
                  normal[] = {{0, 1, 0}, {0, 0, -1}, {0, 0, 0}, {0, 0, 1}};
    for (int i = 0; i < 4 * 4 * 3; i++) {
        float power = lobe_towards(0, 0,
                                   i / 16 == 0   ? 0.0f
                                   : i / 16 == 1 ? 30.0f
                                                 : 1e5f,
                                   at[i % 4], normal[i / 4 % 4]);
        assert_true(power >= 0 && power <= 1);
    }
}

/* ---- what stays as it is, hard cases, shadows ---- */

static void lights_on_the_surface_or_behind_it_give_nothing(void **state) {
    const sl_vec3 lights[] = {{0, 0, 0},      {1, 0, 0},   {0, 0, -1},      {0, 0, -1e-30f},
                              {0, 0, 1e-38f}, {NAN, 0, 1}, {0, 0, INFINITY}};
    for (size_t i = 0; i < sizeof lights / sizeof *lights; i++) {
        for (uint32_t material = DIFFUSE_MATERIAL; material <= GLOSSY_MATERIAL; material++) {
            sl_rgb p = radiance_at(*state, point_light(lights[i]), origin, up, sl_v3(0, 0, 1), material);
            sl_rgb a = radiance_at(*state, area_light(lights[i], sl_v3(0, 0, -1), 1.0f, true), origin, up,
                                   sl_v3(0, 0, 1), material);
            assert_true(p.r == 0.0f && p.g == 0.0f && p.b == 0.0f && a.r == 0.0f && a.g == 0.0f &&
                        a.b == 0.0f);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(point_light_falls_with_cosine_and_squared_distance),
        cmocka_unit_test(area_light_from_its_centre_has_the_error_of_a_very_distant_one),
        cmocka_unit_test(emitters_back_is_dark_unless_it_has_two_sides),
        cmocka_unit_test(glossy_receiver_has_the_modified_phong_lobe),
        cmocka_unit_test(highlight_of_an_area_light_is_as_wide_as_the_light),
        cmocka_unit_test(highlight_moves_with_the_eye),
        cmocka_unit_test(a_sharp_lobe_shows_a_lamps_point_as_a_disc_with_hard_rims),
        cmocka_unit_test(a_lobe_is_finite_towards_discs_seen_from_their_edge_or_from_within),
        cmocka_unit_test(lights_on_the_surface_or_behind_it_give_nothing),
    };
    return cmocka_run_group_tests(tests, make_receiver_scene, destroy_receiver_scene);
}
