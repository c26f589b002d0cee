/* What pictures rest on has the same bits everywhere: hits of rays, and frames of the rasterizer. The numbers
 * here came out alike from gcc and clang, on every x86-64 and on 64-bit Arm (tests/other_processors.sh). */
#include "base/math.h"
#include "base/random.h"
#include "raster_support.h"
#include "tests/raster/raster_soup.h"
#include "trace/trace.h"
#include "trace_scenes.h"

static uint64_t hash_of(uint64_t hash, const void *words, size_t count) {
    const unsigned char *byte = words;
    for (size_t i = 0; i < count; i++) {
        uint32_t word;
        memcpy(&word, byte + i * sizeof word, sizeof word);
        hash = sl_hash64(hash ^ word);
    }
    return hash;
}

static void expect(uint64_t hash, uint64_t expected) {
    if (hash != expected) fail_msg("hash is 0x%016llxu", (unsigned long long)hash);
}

/* ---- rays ---- */

static float number(uint64_t key, uint64_t i) { return sl_random_unit(sl_random_key(key, 7), i); }

/* A point of a triangle: in turn a corner, of an edge, of its inside. */
static sl_vec3 target(const sl_scene *scene, uint64_t i) {
    uint32_t triangle = (uint32_t)(sl_hash64(i) % scene->triangle_count);
    sl_vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = sl_scene_position(scene, scene->vertex[k][triangle]);
    float a = i % 3 > 0 ? number(1, i) : 0.0f, b = i % 3 > 1 ? (1.0f - a) * number(2, i) : 0.0f;
    return sl_mad(sl_mad(p[0], a, sl_sub(p[1], p[0])), b, sl_sub(p[2], p[0]));
}

static uint64_t hash_packet(const sl_tracer *tracer, const sl_ray16 *packet, uint64_t turn, uint64_t hash) {
    sl_counters counters = {{0}};
    sl_hit16 hit;
    sl_trace(tracer, packet, SL_PACKET, turn % 2, &hit, &counters);
    hash = hash_of(hash, hit.t, SL_PACKET);
    hash = hash_of(hash, hit.w1, SL_PACKET);
    hash = hash_of(hash, hit.w2, SL_PACKET);
    hash = hash_of(hash, hit.triangle, SL_PACKET);
    return sl_hash64(hash ^ sl_trace_occluded(tracer, packet, SL_PACKET, turn % 2, &counters));
}

static uint64_t hash_hits(const sl_scene *scene, uint64_t rays) {
    sl_tracer *tracer = NULL;
    sl_error error;
    if (sl_tracer_create(scene, 1, NULL, &tracer, &error) != SL_OK) fail_msg("%s", error.message);
    uint64_t hash = 0;
    sl_ray16 packet;
    for (uint64_t i = 0; i < rays; i++) {
        sl_vec3 from = sl_v3(number(3, i) - 0.5f, number(4, i) - 0.5f, number(5, i) - 0.5f);
        sl_vec3 way = sl_sub(target(scene, i), from);
        float end = i % 5 ? INFINITY : 1.0f;
        sl_ray16_set(&packet, (unsigned)(i % SL_PACKET), from, way, 0.0f, end, SL_NO_INDEX);
        if (i % SL_PACKET == SL_PACKET - 1) hash = hash_packet(tracer, &packet, i / SL_PACKET, hash);
    }
    sl_tracer_destroy(tracer);
    return hash;
}

static void rays_at_vertices_edges_and_insides_hit_the_same(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_sphere(&mesh, sl_v3(0, 0, 0), 2.0f, 40, 0.3f, true, 0);
    sl_scene *scene = trace_mesh_build(&mesh);
    expect(hash_hits(scene, 48000), 0x1c1617909f8ee9d4u);
    sl_scene_destroy(scene);
}

/* ---- the rasterizer ---- */

enum { WIDTH = 96, HEIGHT = 80, PIXELS = WIDTH * HEIGHT };

static void frames_of_triangles_of_every_kind_are_the_same(void **state) {
    static uint32_t id[PIXELS];
    static float depth[PIXELS];
    uint64_t hash = 0;
    for (soup_kind kind = 0; kind < SOUP_KINDS; kind++) {
        soup s = soup_make(kind, 5, 2000, WIDTH, HEIGHT);
        sl_raster *raster = soup_raster(&s);
        render(raster, &s.view, 1, id, depth);
        hash = hash_of(hash_of(hash, id, PIXELS), depth, PIXELS);
        sl_raster_destroy(raster);
        soup_free(&s);
    }
    expect(hash, 0x966d123d05a2654eu);
}

/* Positions, normals, textures and materials of what a camera sees. */
static uint64_t hash_surfaces(const sl_scene *scene) {
    sl_raster *raster = raster_of(scene);
    sl_view view = sl_view_scene(scene, WIDTH, HEIGHT);
    sl_counters counters = {{0}};
    sl_gbuffer *g = NULL;
    assert_int_equal(sl_gbuffer_create(WIDTH, HEIGHT, &g, NULL), SL_OK);
    assert_int_equal(sl_raster_gbuffer(raster, &view, 1, g, &counters, NULL), SL_OK);
    const void *planes[] = {g->id,          g->depth,       g->position_x,  g->position_y,  g->position_z,
                            g->normal_x,    g->normal_y,    g->normal_z,    g->geometric_x, g->geometric_y,
                            g->geometric_z, g->diffuse_r,   g->diffuse_g,   g->diffuse_b,   g->material};
    uint64_t hash = 0;
    for (size_t k = 0; k < sizeof planes / sizeof *planes; k++) hash = hash_of(hash, planes[k], PIXELS);
    sl_gbuffer_destroy(g);
    sl_raster_destroy(raster);
    return hash;
}

static void surfaces_of_a_frame_are_the_same(void **state) {
    sl_scene *scene = NULL;
    sl_error error;
    if (sl_scene_load("scenes/bricks.json", &scene, &error) != SL_OK) fail_msg("%s", error.message);
    expect(hash_surfaces(scene), 0x59557534a1cede8fu);
    sl_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_at_vertices_edges_and_insides_hit_the_same),
        cmocka_unit_test(frames_of_triangles_of_every_kind_are_the_same),
        cmocka_unit_test(surfaces_of_a_frame_are_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
