#include "unit_test.h"
#include "gather_world.h"

#include "base/math.h"
#include "base/memory.h"
#include "base/random.h"
#include "scene_parts.h"

world *world_new(void) {
    world *w = sl_allocate(1, sizeof *w);
    assert_non_null(w);
    w->positions = sl_allocate(3 * WORLD_VERTICES_MAX, sizeof(float));
    w->normals = sl_allocate(3 * WORLD_VERTICES_MAX, sizeof(float));
    w->indices = sl_allocate(3 * WORLD_TRIANGLES_MAX, sizeof(uint32_t));
    w->material_of = sl_allocate(WORLD_TRIANGLES_MAX, sizeof(uint32_t));
    assert_true(w->positions && w->normals && w->indices && w->material_of);
    return w;
}

void world_free(world *w) {
    sl_tracer_destroy(w->tracer);
    sl_raster_destroy(w->raster);
    sl_scene_destroy(w->scene);
    sl_free(w->positions);
    sl_free(w->normals);
    sl_free(w->indices);
    sl_free(w->material_of);
    sl_free(w);
}

uint32_t world_material(world *w, sl_rgb diffuse, sl_rgb emission) {
    assert_true(w->material_count < WORLD_MATERIALS_MAX);
    w->materials[w->material_count] = (sl_material){.name = "m", .diffuse = diffuse, .emission = emission,
                                                    .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
    return (uint32_t)w->material_count++;
}

static uint32_t add_vertex(world *w, sl_vec3 p, sl_vec3 n) {
    assert_true(w->vertices < WORLD_VERTICES_MAX);
    float *to = w->positions + 3 * w->vertices, *normal = w->normals + 3 * w->vertices;
    to[0] = p.x, to[1] = p.y, to[2] = p.z;
    normal[0] = n.x, normal[1] = n.y, normal[2] = n.z;
    return (uint32_t)w->vertices++;
}

static void add_triangle(world *w, uint32_t a, uint32_t b, uint32_t c, uint32_t material) {
    assert_true(w->triangles < WORLD_TRIANGLES_MAX);
    uint32_t *to = w->indices + 3 * w->triangles;
    to[0] = a, to[1] = b, to[2] = c;
    w->material_of[w->triangles++] = material;
}

void world_quad(world *w, sl_vec3 a, sl_vec3 b, sl_vec3 c, sl_vec3 d, uint32_t material) {
    sl_vec3 n = sl_normalize_or(sl_cross(sl_sub(b, a), sl_sub(c, a)), sl_v3(0, 0, 1));
    uint32_t v[4] = {add_vertex(w, a, n), add_vertex(w, b, n), add_vertex(w, c, n), add_vertex(w, d, n)};
    add_triangle(w, v[0], v[1], v[2], material);
    add_triangle(w, v[0], v[2], v[3], material);
}

void world_wall(world *w, int side, float x0, float y0, float x1, float y1, float depth, uint32_t material) {
    const float scale = 2.0f * depth / (float)side;
    const sl_vec3 low = sl_v3(scale * (x0 - (float)(side / 2)), scale * (y0 - (float)(side / 2)), -depth),
                  high = sl_v3(scale * (x1 - (float)(side / 2)), scale * (y1 - (float)(side / 2)), -depth);
    world_quad(w, low, sl_v3(high.x, low.y, -depth), high, sl_v3(low.x, high.y, -depth), material);
}

void world_box(world *w, sl_vec3 l, sl_vec3 h, bool inside, const uint32_t m[6]) {
    /* x low, front inside */
    sl_vec3 q[6][4] = {{{l.x, l.y, l.z}, {l.x, h.y, l.z}, {l.x, h.y, h.z}, {l.x, l.y, h.z}},
                       {{h.x, l.y, l.z}, {h.x, l.y, h.z}, {h.x, h.y, h.z}, {h.x, h.y, l.z}},
                       {{l.x, l.y, l.z}, {l.x, l.y, h.z}, {h.x, l.y, h.z}, {h.x, l.y, l.z}},
                       {{l.x, h.y, l.z}, {h.x, h.y, l.z}, {h.x, h.y, h.z}, {l.x, h.y, h.z}},
                       {{l.x, l.y, l.z}, {h.x, l.y, l.z}, {h.x, h.y, l.z}, {l.x, h.y, l.z}},
                       {{l.x, l.y, h.z}, {l.x, h.y, h.z}, {h.x, h.y, h.z}, {h.x, l.y, h.z}}};
    for (int i = 0; i < 6; i++) {
        if (inside) world_quad(w, q[i][0], q[i][1], q[i][2], q[i][3], m[i]);
        else world_quad(w, q[i][3], q[i][2], q[i][1], q[i][0], m[i]);
    }
}

static uint32_t material_by_x(float x, float radius, const uint32_t *materials, uint32_t count) {
    int i = (int)((x / radius + 1.0f) * 0.5f * (float)count);
    return materials[i < 0 ? 0 : i >= (int)count ? (int)count - 1 : i];
}

/* Latitudes and longitudes about the x axis, so that the poles of y and z lie on equators. */
void world_sphere(world *w, float radius, int rings, const uint32_t *materials, uint32_t count) {
    int sectors = 2 * rings;
    uint32_t first = (uint32_t)w->vertices;
    for (int i = 0; i <= rings; i++) {
        for (int j = 0; j < sectors; j++) {
            double polar = SL_PI * i / rings, azimuth = 2.0 * SL_PI * j / sectors;
            sl_vec3 n = sl_to_float(
                sl_v3d(sl_cos(polar), sl_sin(polar) * sl_cos(azimuth), sl_sin(polar) * sl_sin(azimuth)));
            add_vertex(w, sl_scale(n, radius), sl_neg(n));
        }
    }
    for (int i = 0; i < rings; i++) {
        float x = radius * (float)sl_cos(SL_PI * (i + 0.5) / rings);
        uint32_t m = material_by_x(x, radius, materials, count);
        for (int j = 0; j < sectors; j++) {
            uint32_t a = first + (uint32_t)(i * sectors + j),
                     b = first + (uint32_t)(i * sectors + (j + 1) % sectors);
            uint32_t c = a + (uint32_t)sectors, d = b + (uint32_t)sectors;
            if (i > 0) add_triangle(w, a, b, d, m);
            if (i < rings - 1) add_triangle(w, a, d, c, m);
        }
    }
}

void world_point_light(world *w, sl_vec3 p, float intensity) {
    w->lights[w->light_count++] =
        (sl_light){.type = SL_LIGHT_POINT, .position = p, .intensity = sl_grey(intensity)};
}

world *world_room(bool quad_light) {
    world *w = world_new();
    sl_rgb black = {0, 0, 0};
    uint32_t red = world_material(w, (sl_rgb){0.7f, 0.15f, 0.1f}, black),
             green = world_material(w, (sl_rgb){0.2f, 0.6f, 0.2f}, black);
    uint32_t white = world_material(w, sl_grey(0.75f), black), grey = world_material(w, sl_grey(0.4f), black);
    world_box(w, sl_v3(0, 0, 0), sl_v3(4, 3, 6), true, (uint32_t[6]){red, green, grey, white, white, white});
    uint32_t all_white[6] = {white, white, white, white, white, white},
             all_grey[6] = {grey, grey, grey, grey, grey, grey};
    world_box(w, sl_v3(0.6f, 0.001f, 1.0f), sl_v3(1.5f, 1.2f, 2.0f), false, all_white);
    world_box(w, sl_v3(2.3f, 0.001f, 2.4f), sl_v3(3.3f, 0.7f, 3.2f), false, all_grey);
    world_box(w, sl_v3(1.2f, 0.001f, 4.2f), sl_v3(2.0f, 1.9f, 4.9f), false, all_white);
    if (quad_light) {
        uint32_t lamp = world_material(w, sl_grey(0.2f), sl_grey(12.0f));
        world_quad(w, sl_v3(1.5f, 2.95f, 2.5f), sl_v3(2.5f, 2.95f, 2.5f), sl_v3(2.5f, 2.95f, 3.5f),
                   sl_v3(1.5f, 2.95f, 3.5f), lamp);
    } else {
        world_point_light(w, sl_v3(2.1f, 2.6f, 2.9f), 10.0f);
    }
    world_build(w);
    return w;
}

void world_build(world *w) {
    sl_error error;
    sl_scene_parts parts = {.vertex_count = w->vertices,
                            .positions = w->positions,
                            .normals = w->normals,
                            .triangle_count = w->triangles,
                            .indices = w->indices,
                            .material_index = w->material_of,
                            .material_count = w->material_count,
                            .materials = w->materials,
                            .light_count = w->light_count,
                            .lights = w->lights,
                            .environment = w->environment.present ? &w->environment : NULL};
    if (sl_scene_build(&parts, &w->scene, &error) != SL_OK) fail_msg("%s", error.message);
    if (sl_raster_create(w->scene, 1, &w->raster, &error) != SL_OK) fail_msg("%s", error.message);
    if (sl_tracer_create(w->scene, 1, NULL, &w->tracer, &error) != SL_OK) fail_msg("%s", error.message);
}

sl_gather_settings gather_settings(sl_gather_kind kind, int size) {
    sl_gather_settings s = sl_gather_defaults();
    s.kind = kind;
    s.size = size;
    s.emission = true;
    return s;
}

void assert_within(double value, double expected, double most_apart) {
    if (!(fabs(value - expected) <= most_apart))
        fail_msg("%.12g is not %.12g (+- %g)", value, expected, most_apart);
}

gatherer gatherer_new(world *w, const sl_gather_settings *settings) {
    gatherer g = {.counters = &w->counters};
    sl_error error;
    if (sl_gather_create(w->scene, w->raster, w->tracer, settings, 1, &g.gather, &error) != SL_OK)
        fail_msg("%s", error.message);
    assert_int_equal(sl_gather_scratch_create(g.gather, &g.scratch, NULL), SL_OK);
    return g;
}

void gatherer_free(gatherer *g) {
    sl_gather_scratch_destroy(g->scratch);
    sl_gather_destroy(g->gather);
}

sl_irradiance gather_at(gatherer *g, sl_vec3 p, sl_vec3 n, uint64_t key) {
    sl_gather_point point = {
        .position = p, .geometric_normal = n, .normal = n, .triangle = SL_NO_INDEX, .key = key};
    sl_irradiance e;
    sl_gather_irradiance(g->gather, &point, g->scratch, &e, g->counters);
    return e;
}

sl_irradiance gather_once(world *w, const sl_gather_settings *settings, sl_vec3 p, sl_vec3 n) {
    gatherer g = gatherer_new(w, settings);
    sl_irradiance e = gather_at(&g, p, n, 7);
    gatherer_free(&g);
    return e;
}

sl_gather_point world_surface_point(const world *w, uint64_t number) {
    const sl_scene *s = w->scene;
    uint64_t key = sl_random_key(99, number);
    uint32_t triangle = sl_random_bits(key, 0) % (uint32_t)s->triangle_count;
    float u = sl_random_unit(key, 1), v = sl_random_unit(key, 2);
    if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
    sl_vec3 n = sl_scene_geometric_normal(s, triangle);
    sl_surface surface;
    sl_scene_surface(s, triangle, 0.02f + 0.94f * u, 0.02f + 0.94f * v, n, &surface);
    return (sl_gather_point){
        .position = surface.position, .geometric_normal = n, .normal = n, .triangle = triangle, .key = key};
}
