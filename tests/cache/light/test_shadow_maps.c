/* Shadow maps against closed forms and against rays; what one cube says is tested with depth cubes. */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <string.h>

#include <math.h>

#include "unit_test.h"
#include "base/random.h"
#include "cache/light/shadow_maps.h"
#include "gather_world.h"
#include "polygon_truth.h"
#include "trace_scenes.h"

static const double pi = 3.14159265358979323846;

/* ---- points ------------------------------------------------------------ */

enum { POINTS = 128 };

typedef struct {
    float x[POINTS], y[POINTS], z[POINTS], nx[POINTS], ny[POINTS], nz[POINTS];
    float r[POINTS], g[POINTS], b[POINTS];
    size_t count;
} block;

static void add_point(block *b, sl_vec3 p, sl_vec3 n) {
    assert_true(b->count < POINTS);
    b->x[b->count] = p.x, b->y[b->count] = p.y, b->z[b->count] = p.z;
    b->nx[b->count] = n.x, b->ny[b->count] = n.y, b->nz[b->count] = n.z;
    b->count++;
}

static sl_light_points points_of(const block *b) {
    return (sl_light_points){b->count, b->x, b->y, b->z, b->nx, b->ny, b->nz, b->nx, b->ny, b->nz};
}

/* Returns how often it looked into a map. */
static uint64_t light_as(const sl_shadow_maps *maps, unsigned parts, block *b) {
    sl_light_points points = points_of(b);
    sl_counters counters = {{0}};
    memset(b->r, 0, sizeof b->r);
    memset(b->g, 0, sizeof b->g);
    memset(b->b, 0, sizeof b->b);
    sl_shadow_maps_irradiance(maps, &points, parts, b->r, b->g, b->b, &counters);
    return counters.value[SL_COUNT_SHADOW_LOOKUPS];
}

static void light_block(const sl_shadow_maps *maps, block *b) {
    light_as(maps, SL_MAPPED_LIGHTS | SL_MAPPED_SKY, b);
}

static sl_shadow_maps *maps_of(world *w, int size) {
    sl_shadow_map_settings settings = {.size = size,
                                       .threads = 2,
                                       .sky = w->environment.present ? &w->scene->environment : NULL};
    sl_shadow_maps *maps = NULL;
    sl_counters counters = {{0}};
    assert_int_equal(sl_shadow_maps_create(w->scene, w->raster, &settings, &maps, &counters, NULL), SL_OK);
    return maps;
}

static float uniform(uint64_t key, uint64_t i, float low, float high) {
    return low + (high - low) * sl_random_unit(key, i);
}

static sl_rgb grey(float v) { return (sl_rgb){v, v, v}; }

/* E = I cos / d^2 */
static double from_point(sl_vec3 light, double intensity, sl_vec3 p, sl_vec3 n) {
    sl_vec3d d = sl_subd(sl_to_double(light), sl_to_double(p));
    double squared = sl_dotd(d, d), cosine = sl_dotd(d, sl_to_double(n)) / sqrt(squared);
    return cosine > 0.0 ? intensity * cosine / squared : 0.0;
}

/* ---- no acne ------------------------------------------------------------ */

static const sl_vec3 lamp = {0.31f, 0.42f, -0.17f};

/* Also within a texel of the room's edges, where texels show the other wall. */
static void a_point_light_on_a_floor_and_walls_is_the_closed_form_everywhere(void **state) {
    const int sizes[] = {64, 1024};
    world *w = world_new();
    uint32_t m = world_material(w, grey(0.5f), grey(0.0f)), all[6] = {m, m, m, m, m, m};
    world_box(w, sl_v3(-2, -2, -2), sl_v3(2, 2, 2), true, all);
    world_point_light(w, lamp, 10.0f);
    world_build(w);
    for (int s = 0; s < 2; s++) {
        sl_shadow_maps *maps = maps_of(w, sizes[s]);
        for (uint64_t k = 0; k < 40; k++) {
            block b = {.count = 0};
            for (uint64_t i = 0; i < POINTS; i++) {
                float c[3], n[3] = {0, 0, 0};
                int axis = (int)(i % 3);
                for (uint64_t j = 0; j < 3; j++) c[j] = uniform(7 + k, 3 * i + j, -2.0f, 2.0f);
                if (i % 4 == 0) c[(axis + 1) % 3] = c[(axis + 1) % 3] > 0 ? 1.9999f : -1.9999f;
                c[axis] = i % 2 ? 2.0f : -2.0f;
                n[axis] = i % 2 ? -1.0f : 1.0f;
                add_point(&b, sl_v3(c[0], c[1], c[2]), sl_v3(n[0], n[1], n[2]));
            }
            light_block(maps, &b);
            for (size_t i = 0; i < b.count; i++) {
                double truth =
                    from_point(lamp, 10.0, sl_v3(b.x[i], b.y[i], b.z[i]), sl_v3(b.nx[i], b.ny[i], b.nz[i]));
                assert_true(fabs((double)b.r[i] - truth) < 1e-5 * truth + 1e-7);
            }
        }
        sl_shadow_maps_destroy(maps);
    }
    world_free(w);
}

/* Facets smaller and larger than texels: no facet of a convex body hides another from a light that both face;
 * in a hollow one some are darkened along the edges between them. */
static void facets_of_spheres_do_not_shadow_each_other(void **state) {
    const int sizes[] = {32, 512}, rings[] = {12, 100};
    for (int run = 0; run < 8; run++) {
        world *w = world_new();
        uint32_t m = world_material(w, grey(0.5f), grey(0.0f));
        double lost = 0.0, asked = 0.0;
        bool outside = run & 4;
        world_sphere(w, 1.0f, rings[run & 1], &m, 1);
        sl_vec3 light = outside ? sl_v3(1.5f, 2.0f, 1.0f) : sl_v3(0.3f, 0.2f, -0.4f);
        world_point_light(w, light, 1.0f);
        world_build(w);
        sl_shadow_maps *maps = maps_of(w, sizes[run >> 1 & 1]);
        const sl_scene *s = w->scene;
        for (uint32_t first = 0; first + POINTS <= s->triangle_count && first < 40 * POINTS;
             first += POINTS) {
            block b = {.count = 0};
            for (uint32_t t = first; t < first + POINTS; t++) {
                sl_vec3 a = sl_scene_position(s, s->vertex[0][t]), e = sl_scene_position(s, s->vertex[1][t]),
                        f = sl_scene_position(s, s->vertex[2][t]);
                float u = uniform(3, 2 * t, 0.0f, 0.5f), v = uniform(3, 2 * t + 1, 0.0f, 0.5f);
                sl_vec3 n = sl_scene_geometric_normal(s, t);
                add_point(&b, sl_mad(sl_mad(a, u, sl_sub(e, a)), v, sl_sub(f, a)), outside ? sl_neg(n) : n);
            }
            light_block(maps, &b);
            for (size_t i = 0; i < b.count; i++) {
                double truth =
                    from_point(light, 1.0, sl_v3(b.x[i], b.y[i], b.z[i]), sl_v3(b.nx[i], b.ny[i], b.nz[i]));
                if (outside) assert_true(fabs((double)b.r[i] - truth) < 1e-4 * truth + 1e-6);
                lost += truth > 0.0 ? 1.0 - (double)b.r[i] / truth : 0.0;
                asked += 1.0;
            }
        }
        assert_true(lost < 0.04 * asked);
        sl_shadow_maps_destroy(maps);
        world_free(w);
    }
}

/* ---- against rays ------------------------------------------------------------ */

static bool is_visible(const world *w, sl_vec3 p, sl_vec3 n, uint32_t triangle, sl_vec3 aim) {
    sl_ray16 ray;
    sl_counters counters = {{0}};
    sl_vec3 o = sl_mad(p, 1e-5f * w->scene->diagonal, n), d = sl_sub(aim, o);
    sl_ray16_set(&ray, 0, o, d, 0.0f, 0.9999f, triangle);
    return !(sl_trace_occluded(w->tracer, &ray, 1, false, &counters) & 1u);
}

/* Nothing in the way: what the closed form says, whatever the number of samples. Something in the way: what
 * very many rays say. */
static void a_quad_light_is_exact_where_seen_and_soft_where_half_hidden(void **state) {
    world *w = world_room(true);
    sl_shadow_maps *maps = maps_of(w, 1024);
    double error = 0.0, total = 0.0, squares = 0.0;
    int open_points = 0, exact_points = 0;
    for (uint64_t k = 0; k < 6; k++) {
        block b = {.count = 0};
        sl_gather_point gathered[POINTS];
        for (uint64_t i = 0; i < POINTS; i++) {
            gathered[i] = world_surface_point(w, 1000 + POINTS * k + i);
            add_point(&b, gathered[i].position, gathered[i].geometric_normal);
        }
        light_block(maps, &b);
        for (size_t i = 0; i < b.count; i++) {
            sl_vec3d n = sl_to_double(gathered[i].geometric_normal);
            double truth = 0.0, all = 0.0;
            for (size_t e = 0; e < w->scene->emitter_count; e++) {
                const sl_emitter *emitter = &w->scene->emitters[e];
                if (emitter->triangle == gathered[i].triangle) continue;
                enum { SIDE = 12 };
                double seen = 0.0, weights = 0.0;
                for (int s = 0; s < SIDE * SIDE; s++) {
                    sl_light_sample sample;
                    float u = ((float)(s % SIDE) + 0.5f) / SIDE, v = ((float)(s / SIDE) + 0.5f) / SIDE;
                    if (!emitter_point(w->scene, (uint32_t)e, gathered[i].position, u, v, &sample))
                        continue;
                    double f =
                        (double)sample.radiance.r * fmax(0.0, sl_dotd(n, sl_to_double(sample.to_light)));
                    weights += f;
                    sl_vec3 aim = sl_mad(gathered[i].position, sample.distance, sample.to_light);
                    if (f > 0.0 && is_visible(w, gathered[i].position, gathered[i].geometric_normal,
                                              gathered[i].triangle, aim))
                        seen += f;
                }
                sl_vec3d corners[3];
                for (int c = 0; c < 3; c++)
                    corners[c] =
                        sl_to_double(sl_scene_position(w->scene, w->scene->vertex[c][emitter->triangle]));
                double exact = (double)emitter->radiance.r *
                               polygon_irradiance(sl_to_double(gathered[i].position), n, corners, 3, NULL);
                all += exact;
                if (weights > 0.0) truth += exact * (seen / weights);
            }
            if (all > 0.0 && truth == all && fabs((double)b.r[i] / all - 1.0) < 1e-4) exact_points++;
            if (all > 0.0 && truth == all) open_points++;
            error += (double)b.r[i] - truth;
            squares += ((double)b.r[i] - truth) * ((double)b.r[i] - truth);
            total += truth;
        }
    }
    double mean = total / (6.0 * POINTS);
    print_message("bias %+.5f, rms %.5f of the mean; %d of %d points that see all are exact\n", error / total,
                  sqrt(squares / (6.0 * POINTS)) / mean, exact_points, open_points);
    assert_true(open_points > 100 && exact_points > 0.95 * open_points);
    assert_true(fabs(error / total) < 0.002);
    assert_true(sqrt(squares / (6.0 * POINTS)) < 0.02 * mean);
    sl_shadow_maps_destroy(maps);
    world_free(w);
}

/* A tile of the floor in parts, as pictures have it; the samples stand near enough for its shadows. */
static block floor_tile(float x, float z, float step) {
    block b = {.count = 0};
    for (int i = 0; i < POINTS; i++) {
        const int part = i / SL_MAPPED_PART, in = i % SL_MAPPED_PART, column = in % SL_MAPPED_COLUMNS,
                  row = in / SL_MAPPED_COLUMNS;
        add_point(&b, sl_v3(x + step * (float)(part / 2 * SL_MAPPED_COLUMNS + column), 0.0f,
                            z + step * (float)(part % 2 * SL_MAPPED_PART / SL_MAPPED_COLUMNS + row)),
                  sl_v3(0, 1, 0));
    }
    return b;
}

/* Tiles all over the floor, as such and point by point. */
typedef struct tiles {
    double apart, more, total;
    uint64_t as_tiles, alone; /* look-ups */
    int shadows;
} tiles;

/* every_other: the height of every other column of pixels. */
static tiles light_tiles(world *w, unsigned parts, float every_other) {
    sl_shadow_maps *maps = maps_of(w, 512);
    tiles t = {0};
    for (int k = 0; k < 400; k++) {
        block whole = floor_tile(0.02f + 0.19f * (float)(k % 20), 0.02f + 0.29f * (float)(k / 20), 0.01f);
        for (int i = 1; i < POINTS; i += 2) whole.y[i] = every_other;
        block alone = whole;
        t.as_tiles += light_as(maps, SL_MAPPED_LIGHTS | parts, &whole);
        t.alone += light_as(maps, SL_MAPPED_LIGHTS, &alone);
        for (int i = 0; i < POINTS; i++) {
            t.apart += fabs((double)whole.r[i] - (double)alone.r[i]);
            t.more += (double)whole.r[i] - (double)alone.r[i];
            t.total += (double)alone.r[i];
            t.shadows += alone.r[i] == 0.0f;
        }
    }
    print_message("%.5f apart, %+.5f more, %.2f of the look-ups, %d points in the dark\n", t.apart / t.total,
                  t.more / t.total, (double)t.as_tiles / (double)t.alone, t.shadows);
    sl_shadow_maps_destroy(maps);
    world_free(w);
    return t;
}

static void points_of_a_tile_have_the_light_that_they_have_by_themselves(void **state) {
    const tiles t = light_tiles(world_room(true), SL_MAPPED_TILE, 0.0f);
    assert_true(t.shadows > 1000 && t.apart < 0.002 * t.total);
}

static void interleaved_neighbours_share_samples_and_penumbrae_stay(void **state) {
    const tiles t = light_tiles(world_room(true), SL_MAPPED_TILE | SL_MAPPED_INTERLEAVED, 0.0f);
    assert_true(t.apart < 0.02 * t.total && fabs(t.more) < 0.002 * t.total);
    assert_true(t.as_tiles < t.alone / 5);
}

static void interleaved_pixels_share_samples_with_those_of_their_own_surface(void **state) {
    const tiles t = light_tiles(world_room(true), SL_MAPPED_TILE | SL_MAPPED_INTERLEAVED, 0.9f);
    assert_true(t.apart < 0.02 * t.total && fabs(t.more) < 0.002 * t.total);
}

/* A lamp that is half below a pixel's horizon may have none of the samples that this one asks above it. */
static void interleaved_pixels_that_face_a_lamp_in_part_are_not_dark(void **state) {
    world *w = world_room(true);
    sl_shadow_maps *maps = maps_of(w, 512);
    double all = 0.0, lost = 0.0;
    for (int k = 0; k < 400; k++) {
        block whole = floor_tile(0.02f + 0.19f * (float)(k % 20), 0.02f + 0.29f * (float)(k / 20), 0.01f);
        for (int i = 0; i < POINTS; i++) whole.nx[i] = 1.0f, whole.ny[i] = 0.0f;
        block alone = whole;
        light_as(maps, SL_MAPPED_LIGHTS | SL_MAPPED_TILE | SL_MAPPED_INTERLEAVED, &whole);
        light_as(maps, SL_MAPPED_LIGHTS, &alone);
        for (int i = 0; i < POINTS; i++) {
            all += (double)alone.r[i];
            lost += whole.r[i] > 0.0f ? 0.0 : (double)alone.r[i];
        }
    }
    print_message("%.6f of the light is lost\n", lost / all);
    assert_true(lost < 1.5e-4 * all);
    sl_shadow_maps_destroy(maps);
    world_free(w);
}

/* ---- lights far away ------------------------------------------------------------ */

static void an_open_plane_under_an_even_sky_gets_pi_times_its_radiance(void **state) {
    world *w = world_new();
    uint32_t m = world_material(w, grey(0.5f), grey(0.0f));
    world_quad(w, sl_v3(-5, 0, -5), sl_v3(-5, 0, 5), sl_v3(5, 0, 5), sl_v3(5, 0, -5), m);
    w->environment = (sl_environment){.present = true, .constant = {2, 2, 2}};
    world_build(w);
    sl_shadow_maps *maps = maps_of(w, 64);
    block b = {.count = 0};
    for (uint64_t i = 0; i < POINTS; i++)
        add_point(&b, sl_v3(uniform(77, 2 * i, -4, 4), 0.0f, uniform(77, 2 * i + 1, -4, 4)), sl_v3(0, 1, 0));
    light_block(maps, &b);
    for (size_t i = 0; i < b.count; i++)
        assert_true(fabs((double)b.r[i] / (2.0 * pi) - 1.0) < 0.02); /* 32 directions of the sphere */
    sl_shadow_maps_destroy(maps);
    world_free(w);
}

/* ---- points that are none, and the same bits ------------------------------------------------- */

static void points_at_the_light_without_normal_or_not_finite_do_no_harm(void **state) {
    world *w = world_room(false);
    sl_shadow_maps *maps = maps_of(w, 64);
    block b = {.count = 0};
    sl_vec3 light = w->lights[0].position, up = sl_v3(0, 1, 0);
    add_point(&b, light, up);
    add_point(&b, sl_v3(NAN, 0, 0), up);
    add_point(&b, sl_v3(0, INFINITY, 0), up);
    add_point(&b, sl_v3(0, 0.1f, 0), sl_v3(0, 0, 0));
    add_point(&b, sl_v3(0, 0.1f, 0), sl_v3(NAN, NAN, NAN));
    add_point(&b, sl_v3(light.x, light.y - 1e-30f, light.z), up);
    add_point(&b, sl_v3(1e30f, -1e30f, 1e30f), up);
    light_block(maps, &b);
    for (size_t i = 0; i < b.count; i++) assert_true(b.r[i] >= 0.0f && isfinite(b.r[i]));
    for (size_t i = 1; i < 5; i++) assert_true(b.r[i] == 0.0f);
    sl_shadow_maps_destroy(maps);
    world_free(w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_point_light_on_a_floor_and_walls_is_the_closed_form_everywhere),
        cmocka_unit_test(facets_of_spheres_do_not_shadow_each_other),
        cmocka_unit_test(a_quad_light_is_exact_where_seen_and_soft_where_half_hidden),
        cmocka_unit_test(points_of_a_tile_have_the_light_that_they_have_by_themselves),
        cmocka_unit_test(interleaved_neighbours_share_samples_and_penumbrae_stay),
        cmocka_unit_test(interleaved_pixels_share_samples_with_those_of_their_own_surface),
        cmocka_unit_test(interleaved_pixels_that_face_a_lamp_in_part_are_not_dark),
        cmocka_unit_test(an_open_plane_under_an_even_sky_gets_pi_times_its_radiance),
        cmocka_unit_test(points_at_the_light_without_normal_or_not_finite_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
