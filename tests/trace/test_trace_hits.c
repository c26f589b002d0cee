/* Which triangle a ray hits, and that it is the same everywhere: on every instruction set, in every company.
 */
#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/random.h"
#include "trace/triangle_test.h"
#include "trace_scenes.h"

enum { RAYS = 24000 };

typedef struct ray {
    sl_vec3 origin, direction;
} ray;

typedef struct hit {
    float t, w1, w2;
    uint32_t triangle;
} hit;

static float number(uint64_t key, uint64_t i) { return sl_random_unit(sl_random_key(key, 1), i); }

static sl_scene *bumpy_sphere(unsigned rings, sl_vec3 centre, float radius) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_sphere(&mesh, centre, radius, rings, 0.3f, true, 0);
    return trace_mesh_build(&mesh);
}

/* Rays from inside the sphere, in turn at vertices, at points of edges and at points of triangles. */
static ray aimed_ray(const sl_scene *scene, sl_vec3 centre, float radius, size_t i) {
    float span = radius * 0.4f;
    sl_vec3 origin = sl_add(centre, sl_v3(span * (number(1, i) - 0.5f), span * (number(2, i) - 0.5f),
                                          span * (number(3, i) - 0.5f)));
    uint32_t triangle =
        (uint32_t)(number(4, i) * (float)scene->triangle_count) % (uint32_t)scene->triangle_count;
    sl_vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_scene_position(scene, scene->vertex[k][triangle]);
    sl_vec3 target = p[i % 3];
    if (i / 3 % 3 == 1) target = sl_mad(target, number(5, i), sl_sub(p[(i + 1) % 3], target));
    if (i / 3 % 3 == 2) {
        float a = number(5, i), b = number(6, i);
        if (a + b > 1.0f) {
            a = 1.0f - a;
            b = 1.0f - b;
        }
        target = sl_mad(sl_mad(p[0], a, sl_sub(p[1], p[0])), b, sl_sub(p[2], p[0]));
    }
    return (ray){origin, sl_sub(target, origin)};
}

static void put_ray(sl_ray16 *packet, unsigned lane, ray r, float far) {
    sl_ray16_set(packet, lane, r.origin, r.direction, 0.0f, far, SL_NO_INDEX);
}

static void trace_all(const sl_tracer *tracer, const ray *rays, size_t count, unsigned width, bool coherent,
                      hit *hits) {
    sl_counters counters = {{0}};
    for (size_t first = 0; first < count; first += width) {
        unsigned n = count - first < width ? (unsigned)(count - first) : width;
        sl_ray16 packet;
        sl_hit16 found;
        for (unsigned i = 0; i < n; i++) put_ray(&packet, i, rays[first + i], INFINITY);
        sl_trace(tracer, &packet, n, coherent, &found, &counters);
        for (unsigned i = 0; i < n; i++)
            hits[first + i] = (hit){found.t[i], found.w1[i], found.w2[i], found.triangle[i]};
    }
    assert_int_equal(counters.value[SL_COUNT_RAYS], count);
}

/* Returns what Embree is told: nothing, its own choice, in place of AVX-512 where the processor has none, and
 * where it is no x86. */
static const char *embree_for(const char *config) {
#ifdef __x86_64__
    bool wide = config && strcmp(config, "isa=avx512") == 0;
    return wide && !__builtin_cpu_supports("avx512vl") ? NULL : config;
#else
    return NULL;
#endif
}

static sl_tracer *make_tracer(const sl_scene *scene, const char *config) {
    sl_tracer *tracer;
    sl_error error = {0};
    if (sl_tracer_create(scene, 2, embree_for(config), &tracer, &error) != SL_OK)
        fail_msg("%s", error.message);
    return tracer;
}

static ray *aimed_rays(const sl_scene *scene, sl_vec3 centre, float radius) {
    ray *rays = calloc(RAYS, sizeof *rays);
    for (size_t i = 0; i < RAYS; i++) rays[i] = aimed_ray(scene, centre, radius, i);
    return rays;
}

static void every_instruction_set_and_packet_shape_gives_the_same_bits(void **unused) {
    sl_vec3 centre = sl_v3(3.0f, -2.0f, 10.0f);
    sl_scene *scene = bumpy_sphere(40, centre, 5.0f);
    ray *rays = aimed_rays(scene, centre, 5.0f);
    hit *expected = calloc(RAYS, sizeof *expected), *got = calloc(RAYS, sizeof *got);
    static const char *const embree[] = {NULL, "isa=sse2", "isa=sse4.2", "isa=avx", "isa=avx2", "isa=avx512"};
    static const char *const ours[] = {"baseline", "avx2", "avx512"};
    sl_tracer *tracer = make_tracer(scene, NULL);
    trace_all(tracer, rays, RAYS, 16, true, expected);
    sl_tracer_destroy(tracer);
    for (size_t e = 0; e < sizeof embree / sizeof *embree; e++) {
        for (size_t o = 0; o < 3; o++) {
            setenv("SOFTLUX_ISA", ours[o], 1);
            tracer = make_tracer(scene, embree[e]);
            static const unsigned widths[] = {16, 16, 1, 5};
            for (int shape = 0; shape < 4; shape++) {
                trace_all(tracer, rays, RAYS, widths[shape], shape != 1, got);
                assert_memory_equal(expected, got, RAYS * sizeof *got);
            }
            sl_tracer_destroy(tracer);
        }
    }
    unsetenv("SOFTLUX_ISA");
    free(rays);
    free(expected);
    free(got);
    sl_scene_destroy(scene);
}

static void a_closed_mesh_is_never_missed_from_inside(void **unused) {
    static const sl_vec3 centres[] = {{0, 0, 0}, {1000.0f, -3000.0f, 500.0f}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0},
                                      {0, 0, 0}};
    static const float radii[] = {1.0f, 3.0f, 1e-6f, 1e12f, 1e-15f, 1e25f};
    for (int scale = 0; scale < 6; scale++) {
        sl_scene *scene = bumpy_sphere(30, centres[scale], radii[scale]);
        ray *rays = aimed_rays(scene, centres[scale], radii[scale]);
        hit *hits = calloc(RAYS, sizeof *hits);
        sl_tracer *tracer = make_tracer(scene, NULL);
        trace_all(tracer, rays, RAYS, 16, false, hits);
        for (size_t i = 0; i < RAYS; i++) {
            assert_int_not_equal(hits[i].triangle, SL_NO_INDEX);
            assert_true(hits[i].t > 0.0f && hits[i].t < 1.001f);
            if (hits[i].w1 < 0.0f || hits[i].w2 < 0.0f || hits[i].w1 + hits[i].w2 > 1.000001f) fail();
        }
        sl_tracer_destroy(tracer);
        free(hits);
        free(rays);
        sl_scene_destroy(scene);
    }
}

/* The specification of a hit, without any hierarchy. */
static hit nearest_of_all(const sl_scene *scene, ray r) {
    sl_ray_state state;
    sl_ray16 rays;
    memset(&state, 0, sizeof state);
    for (unsigned i = 0; i < SL_PACKET; i++)
        put_ray(&rays, i, r, INFINITY);
    sl_ray_frames_baseline(&state, &rays);
    const int valid = -1;
    const unsigned id = 0;
    hit best = {INFINITY, 0, 0, SL_NO_INDEX};
    for (uint32_t t = 0; t < scene->triangle_count; t++) {
        sl_triangle_corners corners;
        for (int k = 0; k < 3; k++) {
            sl_vec3 p = sl_scene_position(scene, scene->vertex[k][t]);
            corners.p[0][k] = p.x;
            corners.p[1][k] = p.y;
            corners.p[2][k] = p.z;
        }
        sl_candidates c;
        if (sl_triangle_test_baseline(&state, &corners, &valid, &id, 1, &c) && c.t[0] > 0.0f &&
            c.t[0] < best.t) {
            best = (hit){c.t[0], c.w1[0], c.w2[0], t};
        }
    }
    return best;
}

static void the_hierarchy_loses_no_hit(void **unused) {
    sl_vec3 centre = sl_v3(0.5f, 0.25f, 0.0f);
    sl_scene *scene = bumpy_sphere(24, centre, 2.0f);
    ray *rays = aimed_rays(scene, centre, 2.0f);
    enum { COMPARED = 6000 };
    hit *hits = calloc(COMPARED, sizeof *hits);
    sl_tracer *tracer = make_tracer(scene, NULL);
    trace_all(tracer, rays, COMPARED, 16, false, hits);
    for (size_t i = 0; i < COMPARED; i++) {
        hit expected = nearest_of_all(scene, rays[i]);
        assert_memory_equal(&expected, &hits[i], sizeof expected);
        /* And the distance is that of the triangle's plane. */
        sl_vec3d n = sl_to_double(sl_scene_geometric_normal(scene, expected.triangle));
        sl_vec3d corner = sl_to_double(sl_scene_position(scene, scene->vertex[0][expected.triangle]));
        double cosine = sl_dotd(n, sl_to_double(rays[i].direction));
        double plane = sl_dotd(n, sl_subd(corner, sl_to_double(rays[i].origin))) / cosine;
        assert_true(fabs(plane - (double)expected.t) < 1e-5 / fmin(1.0, fabs(cosine)));
    }
    sl_tracer_destroy(tracer);
    free(hits);
    free(rays);
    sl_scene_destroy(scene);
}

static void occlusion_agrees_with_the_closest_hit(void **unused) {
    sl_vec3 centre = sl_v3(0, 0, 0);
    sl_scene *scene = bumpy_sphere(30, centre, 1.0f);
    ray *rays = aimed_rays(scene, centre, 1.0f);
    static const char *const configs[] = {NULL, "isa=sse2", "isa=avx"};
    for (int c = 0; c < 3; c++) {
        sl_tracer *tracer = make_tracer(scene, configs[c]);
        sl_counters counters = {{0}};
        for (size_t first = 0; first < RAYS; first += 16) {
            sl_ray16 packet;
            sl_hit16 hits;
            for (unsigned i = 0; i < 16; i++) put_ray(&packet, i, rays[first + i], INFINITY);
            sl_trace(tracer, &packet, 16, false, &hits, &counters);
            /* The end is open: no hit at far itself, one where far is the next float. */
            for (unsigned i = 0; i < 16; i++)
                packet.far[i] = i % 2 ? hits.t[i] : nextafterf(hits.t[i], INFINITY);
            uint32_t expected = 0x5555;
            assert_int_equal(sl_trace_occluded(tracer, &packet, 16, c == 1, &counters), expected);
            assert_int_equal(sl_trace_occluded(tracer, &packet, 7, c == 1, &counters), expected & 0x7f);
            /* Nor at near, and not the triangle to be skipped. */
            for (unsigned i = 0; i < 16; i++) {
                packet.far[i] = hits.t[i] * 1.0001f;
                packet.near[i] = i % 2 ? hits.t[i] : 0.0f;
            }
            uint32_t from_near = sl_trace_occluded(tracer, &packet, 16, true, &counters);
            assert_int_equal(from_near & 0x5555, 0x5555);
            sl_hit16 beyond;
            sl_trace(tracer, &packet, 16, true, &beyond, &counters);
            for (unsigned i = 0; i < 16; i++) {
                assert_int_equal((from_near >> i) & 1, beyond.triangle[i] != SL_NO_INDEX);
                assert_true(i % 2 == 0 || beyond.t[i] > hits.t[i]);
                packet.near[i] = 0.0f;
                packet.skip[i] = hits.triangle[i];
            }
            sl_trace(tracer, &packet, 16, true, &beyond, &counters);
            for (unsigned i = 0; i < 16; i++) assert_true(beyond.triangle[i] != hits.triangle[i]);
        }
        sl_tracer_destroy(tracer);
    }
    free(rays);
    sl_scene_destroy(scene);
}

static void equal_distances_go_to_the_lower_index(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    for (int copy = 0; copy < 20; copy++)
        trace_mesh_quad(&mesh, sl_v3(-1, -1, 0), sl_v3(2, 0, 0), sl_v3(0, 2, 0), 0);
    sl_scene *scene = trace_mesh_build(&mesh);
    static const char *const configs[] = {NULL, "isa=sse2", "isa=avx2"};
    for (int c = 0; c < 3; c++) {
        sl_tracer *tracer = make_tracer(scene, configs[c]);
        for (int i = 0; i < 500; i++) {
            sl_vec3 target = sl_v3(2 * number(1, (uint64_t)i) - 1, 2 * number(2, (uint64_t)i) - 1, 0);
            sl_vec3 origin = sl_v3(0.3f, 0.1f, 2.0f);
            ray r = {origin, sl_sub(target, origin)};
            hit found;
            trace_all(tracer, &r, 1, 16, true, &found);
            assert_true(found.triangle < 2);
        }
        sl_tracer_destroy(tracer);
    }
    sl_scene_destroy(scene);
}

static void slivers_are_hit_inside_their_box_or_not_at_all(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    for (int i = 0; i < 2000; i++) {
        sl_vec3 a = sl_v3(number(11, (uint64_t)i), number(12, (uint64_t)i), number(13, (uint64_t)i));
        sl_vec3 along = sl_v3(number(14, (uint64_t)i) - 0.5f, number(15, (uint64_t)i) - 0.5f,
                              number(16, (uint64_t)i) - 0.5f);
        float width = i % 2 ? 1e-6f : 1e-4f;
        uint32_t v0 = trace_mesh_vertex(&mesh, a.x, a.y, a.z);
        uint32_t v1 = trace_mesh_vertex(&mesh, a.x + along.x, a.y + along.y, a.z + along.z);
        uint32_t v2 = trace_mesh_vertex(&mesh, a.x + 0.6f * along.x + width, a.y + 0.6f * along.y,
                                        a.z + 0.6f * along.z);
        trace_mesh_triangle(&mesh, v0, v1, v2, 0);
    }
    sl_scene *scene = trace_mesh_build(&mesh);
    ray *rays = calloc(RAYS, sizeof *rays);
    for (size_t i = 0; i < RAYS; i++) {
        uint32_t t = (uint32_t)(i % scene->triangle_count);
        sl_vec3 origin = sl_v3(3 * number(21, i) - 1, 3 * number(22, i) - 1, -1);
        sl_vec3 a = sl_scene_position(scene, scene->vertex[0][t]),
                b = sl_scene_position(scene, scene->vertex[1][t]);
        sl_vec3 target = sl_mad(a, number(23, i), sl_sub(b, a));
        rays[i] = (ray){origin, sl_sub(target, origin)};
        if (i % 5 == 0) rays[i] = (ray){sl_mad(a, -1.0f, sl_sub(b, a)), sl_sub(b, a)}; /* along the sliver */
    }
    hit *expected = calloc(RAYS, sizeof *expected), *got = calloc(RAYS, sizeof *got);
    static const char *const configs[] = {"isa=avx512", "isa=sse2", "isa=avx"};
    size_t hits = 0;
    for (int c = 0; c < 3; c++) {
        sl_tracer *tracer = make_tracer(scene, configs[c]);
        trace_all(tracer, rays, RAYS, c == 1 ? 1 : 16, false, c == 0 ? expected : got);
        if (c > 0) assert_memory_equal(expected, got, RAYS * sizeof *got);
        sl_tracer_destroy(tracer);
    }
    for (size_t i = 0; i < RAYS; i++) {
        if (expected[i].triangle == SL_NO_INDEX) continue;
        hits++;
        sl_vec3 p = sl_mad(rays[i].origin, expected[i].t, rays[i].direction);
        for (int axis = 0; axis < 3; axis++) {
            const float *position = axis == 0   ? scene->position_x
                                    : axis == 1 ? scene->position_y
                                                : scene->position_z;
            float low = INFINITY, high = -INFINITY;
            for (int k = 0; k < 3; k++) {
                float v = position[scene->vertex[k][expected[i].triangle]];
                low = fminf(low, v);
                high = fmaxf(high, v);
            }
            float at = axis == 0 ? p.x : axis == 1 ? p.y : p.z;
            assert_true(at >= low - 2e-6f && at <= high + 2e-6f);
        }
    }
    assert_true(hits > RAYS / 4);
    free(rays);
    free(expected);
    free(got);
    sl_scene_destroy(scene);
}

static void far_origins_and_extreme_directions_hit_the_same_point(void **unused) {
    sl_vec3 centre = sl_v3(0, 0, 0);
    sl_scene *scene = bumpy_sphere(30, centre, 1.0f);
    enum { COUNT = 4800 };
    ray *rays = calloc(COUNT, sizeof *rays);
    for (size_t i = 0; i < COUNT; i++) {
        ray r = aimed_ray(scene, centre, 1.0f, i);
        if (i % 4 == 0) r.direction = sl_scale(r.direction, 1e-30f);
        if (i % 4 == 1) r.direction = sl_scale(r.direction, 1e25f);
        if (i % 4 == 2) r.origin = sl_mad(r.origin, -1e3f, r.direction);
        if (i % 4 == 3) r.origin = sl_mad(r.origin, -1e6f, r.direction);
        rays[i] = r;
    }
    hit *expected = calloc(COUNT, sizeof *expected), *got = calloc(COUNT, sizeof *got);
    static const char *const configs[] = {"isa=avx512", "isa=sse2", "isa=avx"};
    for (int c = 0; c < 3; c++) {
        sl_tracer *tracer = make_tracer(scene, configs[c]);
        trace_all(tracer, rays, COUNT, 16, c == 2, c == 0 ? expected : got);
        if (c > 0) assert_memory_equal(expected, got, COUNT * sizeof *got);
        sl_tracer_destroy(tracer);
    }
    size_t missed = 0;
    for (size_t i = 0; i < COUNT; i++) {
        if (i % 4 < 2) assert_true(expected[i].triangle != SL_NO_INDEX);
        missed += expected[i].triangle == SL_NO_INDEX;
        if (i % 4 == 0) assert_true(expected[i].t > 0.0f && expected[i].t < 1.001e30f);
        if (i % 4 == 1) assert_true(expected[i].t > 0.0f && expected[i].t < 1.001e-25f);
        /* From outside the front of the far side or an earlier wall is hit, about 1e3 or 1e6 lengths away. */
        if (i % 4 == 2 && expected[i].triangle != SL_NO_INDEX)
            assert_true(fabsf(expected[i].t - 1e3f) < 10.0f);
    }
    assert_true(missed < COUNT / 8);
    free(rays);
    free(expected);
    free(got);
    sl_scene_destroy(scene);
}

static void rays_that_are_none_hit_nothing(void **unused) {
    sl_scene *scene = bumpy_sphere(10, sl_v3(0, 0, 0), 1.0f);
    sl_tracer *tracer = make_tracer(scene, NULL);
    sl_ray16 packet;
    sl_hit16 hits;
    sl_counters counters = {{0}};
    for (unsigned i = 0; i < 16; i++) put_ray(&packet, i, (ray){sl_v3(0, 0, 0), sl_v3(0, 0, 1)}, INFINITY);
    packet.direction_z[0] = 0.0f;
    packet.direction_x[1] = NAN;
    packet.origin_y[2] = INFINITY;
    packet.far[3] = -1.0f;
    packet.near[4] = INFINITY;
    packet.far[5] = NAN;
    packet.near[6] = NAN;
    packet.direction_y[7] = INFINITY;
    packet.near[8] = -5.0f; /* nothing behind the origin counts */
    sl_trace(tracer, &packet, 16, true, &hits, &counters);
    for (unsigned i = 0; i < 8; i++) assert_int_equal(hits.triangle[i], SL_NO_INDEX);
    for (unsigned i = 8; i < 16; i++) assert_true(hits.triangle[i] != SL_NO_INDEX && hits.t[i] > 0.0f);
    assert_int_equal(sl_trace_occluded(tracer, &packet, 16, true, &counters), 0xff00);
    assert_int_equal(counters.value[SL_COUNT_RAYS], 16);
    assert_int_equal(counters.value[SL_COUNT_SHADOW_RAYS], 16);
    assert_true(sl_tracer_memory_bytes(tracer) > scene->triangle_count * sizeof(sl_triangle_corners));
    sl_tracer_destroy(tracer);
    sl_scene_destroy(scene);
}

static void masked_texels_let_rays_through(void **unused) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t leaf = trace_mesh_diffuse(&mesh, 0.5f), wall = trace_mesh_diffuse(&mesh, 0.5f);
    /* right half clear */
    uint8_t texels[16] = {255, 255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 255, 255, 255, 255, 0};
    mesh.textures[0] = (sl_texture){NULL, 2, 2, true, texels};
    mesh.texture_count = 1;
    mesh.materials[leaf].alpha_texture = 0;
    trace_mesh_quad(&mesh, sl_v3(0, 0, 0), sl_v3(1, 0, 0), sl_v3(0, 1, 0), leaf);
    trace_mesh_quad(&mesh, sl_v3(-1, -1, -1), sl_v3(3, 0, 0), sl_v3(0, 3, 0), wall);
    sl_scene *scene = trace_mesh_build(&mesh);
    sl_tracer *tracer = make_tracer(scene, NULL);
    ray rays[2] = {{sl_v3(0.25f, 0.6f, 1.0f), sl_v3(0, 0, -1)}, {sl_v3(0.75f, 0.6f, 1.0f), sl_v3(0, 0, -1)}};
    hit hits[2];
    trace_all(tracer, rays, 2, 16, true, hits);
    assert_true(hits[0].t == 1.0f && hits[1].t == 2.0f);
    sl_ray16 packet;
    sl_counters counters = {{0}};
    for (unsigned i = 0; i < 2; i++) put_ray(&packet, i, rays[i], 1.5f);
    assert_int_equal(sl_trace_occluded(tracer, &packet, 2, true, &counters), 1);
    sl_tracer_destroy(tracer);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_instruction_set_and_packet_shape_gives_the_same_bits),
        cmocka_unit_test(a_closed_mesh_is_never_missed_from_inside),
        cmocka_unit_test(the_hierarchy_loses_no_hit),
        cmocka_unit_test(occlusion_agrees_with_the_closest_hit),
        cmocka_unit_test(equal_distances_go_to_the_lower_index),
        cmocka_unit_test(slivers_are_hit_inside_their_box_or_not_at_all),
        cmocka_unit_test(far_origins_and_extreme_directions_hit_the_same_point),
        cmocka_unit_test(rays_that_are_none_hit_nothing),
        cmocka_unit_test(masked_texels_let_rays_through),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
