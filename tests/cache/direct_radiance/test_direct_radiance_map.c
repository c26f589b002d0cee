/* The direct radiance map (passes 2a to 2c): what its pictures hold, which directions they cover, and light
 * by way of mirrors. */
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "cache/direct_radiance/map.h"
#include "radiance_maps.h"
#include "trace/trace.h"
#include "trace_scenes.h"

/* ---- a scene with its map ---- */

typedef struct {
    sl_scene *scene;
    sl_raster *raster;
    sl_map_lights *lights;
    sl_tracer *tracer;
    sl_radiance_map *map;
    sl_counters counters;
} world;

typedef struct {
    sl_radiance_map_settings settings;
    bool true_color, no_normals, traced;
    unsigned threads;
} how;

static how by_default(void) {
    return (how){.settings = {.samples = 4, .map_size = 16}, .threads = 1};
}

static void take(world *w, const how *h) {
    sl_error error = {0};
    sl_radiance_map_options options = {.lambertian = !h->true_color,
                                       .normals = !h->no_normals,
                                       .tracer = w->tracer,
                                       .threads = h->threads};
    sl_radiance_map_destroy(w->map);
    w->counters = (sl_counters){{0}};
    if (sl_radiance_map_render(w->scene, w->raster, w->lights, &h->settings, &options, &w->map, &w->counters,
                               &error) != SL_OK)
        fail_msg("%s", error.message);
}

static world world_of(trace_mesh *mesh, const how *h) {
    world w = {.scene = trace_mesh_build(mesh)};
    assert_int_equal(sl_raster_create(w.scene, 1, &w.raster, NULL), SL_OK);
    assert_int_equal(sl_map_lights_find(w.scene, 1, &w.lights, NULL), SL_OK);
    if (h->traced) w.tracer = tracer_of(w.scene);
    take(&w, h);
    return w;
}

static void discard(world *w) {
    sl_radiance_map_destroy(w->map);
    sl_tracer_destroy(w->tracer);
    sl_map_lights_destroy(w->lights);
    sl_raster_destroy(w->raster);
    sl_scene_destroy(w->scene);
}

static sl_vec3 at(float *const plane[3], size_t i) { return sl_v3(plane[0][i], plane[1][i], plane[2][i]); }

static sl_light light_at(sl_light_type type, float x, float y, float z) {
    return (sl_light){.type = type,
                      .position = {x, y, z},
                      .direction = {0, -1, 0},
                      .intensity = {3, 2, 1},
                      .cos_inner = 0.9f,
                      .cos_outer = 0.7f};
}

/* A closed room of 4 x 3 x 5 with a box and a ball in it. */
static trace_mesh furnished(void) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t m = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_box(&mesh, sl_v3(0, 0, 0), sl_v3(4, 3, 5), true, m);
    trace_mesh_box(&mesh, sl_v3(0.5f, 0, 0.7f), sl_v3(1.2f, 1.1f, 1.6f), false, m);
    trace_mesh_sphere(&mesh, sl_v3(2.2f, 0.6f, 1.3f), 0.45f, 12, 0, false, trace_mesh_diffuse(&mesh, 0.3f));
    return mesh;
}

static void add_panel(trace_mesh *mesh, float x, float y, float z, float size) {
    trace_mesh_quad(mesh, sl_v3(x, y, z), sl_v3(size, 0, 0), sl_v3(0, 0, size), trace_mesh_lamp(mesh, 5));
}

static world lit_by_every_kind(const how *h) {
    trace_mesh mesh = furnished();
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, 2.2f, 2, 2.6f);
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_SPOT, 1.1f, 2, 2.2f);
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_DIRECTIONAL, 0, 0, 0);
    add_panel(&mesh, 2.7f, 2.99f, 1.2f, 0.8f);
    return world_of(&mesh, h);
}

static uint64_t passes(const world *w) { return w->counters.value[SL_COUNT_RASTER_PASSES]; }
static uint64_t skipped(const world *w) { return w->counters.value[SL_COUNT_RASTER_PASSES_SKIPPED]; }

static size_t covered(const sl_radiance_map *map) {
    size_t count = 0;
    for (size_t i = 0; i < map->texels; i++) count += map->triangle[i] != SL_NO_INDEX;
    return count;
}

static bool all_finite(const sl_radiance_map *map) {
    bool finite = true;
    for (size_t i = 0; i < map->texels; i++) {
        finite &= sl_is_finite(at(map->position, i)) && sl_is_finite(at(map->color, i)) &&
                  sl_is_finite(at(map->geometric, i));
        finite &= isfinite(map->path[i]);
        finite &= !map->normal[0] || sl_is_finite(at(map->normal, i));
    }
    return finite;
}

/* The unit direction of a texel's ray. */
static sl_vec3 ray_of(const sl_map_face *f, size_t i) {
    size_t x = (i - f->first) % (size_t)f->width, y = (i - f->first) / (size_t)f->width;
    float u = (float)(f->left + (f->right - f->left) * ((double)x + 0.5) / f->width);
    float v = (float)(f->bottom + (f->top - f->bottom) * ((double)y + 0.5) / f->height);
    return sl_normalize_or(sl_frame_to_world(&f->frame, sl_v3(u, v, 1)), f->frame.z);
}

static size_t texels_of(const sl_map_face *f) { return (size_t)f->width * (size_t)f->height; }

static double distance_to_triangle(const sl_scene *s, uint32_t t, sl_vec3 p) {
    sl_vec3d a = sl_to_double(sl_scene_position(s, s->vertex[0][t])),
             b = sl_to_double(sl_scene_position(s, s->vertex[1][t]));
    sl_vec3d c = sl_to_double(sl_scene_position(s, s->vertex[2][t])), q = sl_to_double(p),
             n = sl_crossd(sl_subd(b, a), sl_subd(c, a));
    double area = sl_lengthd(n), worst = 0.0;
    n = sl_scaled(n, 1.0 / area);
    const sl_vec3d corner[3] = {a, b, c};
    worst = fabs(sl_dotd(n, sl_subd(q, a)));
    for (int k = 0; k < 3; k++) {
        sl_vec3d edge = sl_subd(corner[(k + 1) % 3], corner[k]);
        double outside = -sl_dotd(sl_crossd(n, edge), sl_subd(q, corner[k])) / sl_lengthd(edge);
        worst = outside > worst ? outside : worst;
    }
    return worst;
}

/* ---- positions ---- */

static void every_position_lies_on_its_triangle_where_its_ray_points(void **state) {
    how h = by_default();
    world w = lit_by_every_kind(&h);
    const sl_radiance_map *map = w.map;
    assert_int_equal(map->face_count, 6 + 1 + 1 + 5);
    for (size_t f = 0; f < map->face_count; f++) {
        const sl_map_face *face = &map->face[f];
        bool directional = map->lights->light[face->light].source.kind == SL_SOURCE_DIRECTIONAL;
        for (size_t i = face->first; i < face->first + texels_of(face); i++) {
            if (map->triangle[i] == SL_NO_INDEX) continue;
            sl_vec3 y = at(map->position, i), d = sl_sub(y, face->eye), g = at(map->geometric, i),
                    n = at(map->normal, i);
            assert_true(distance_to_triangle(w.scene, map->triangle[i], y) <
                        1e-5 * (double)w.scene->diagonal);
            assert_true(sl_dot(g, directional ? face->frame.z : d) <= 1e-5f && sl_dot(g, n) > 0.0f);
            assert_true(fabsf(sl_length(g) - 1.0f) < 1e-5f && fabsf(sl_length(n) - 1.0f) < 1e-5f);
            if (directional) continue;
            assert_true(fabsf(map->path[i] - sl_length(d)) < 1e-5f * map->path[i]);
            /* The drawn point may lie a hundredth of a texel beside the ray, where vertices are snapped. */
            assert_true(sl_length(sl_sub(sl_scale(d, 1.0f / map->path[i]), ray_of(face, i))) <
                        0.02f * 2.0f / 16.0f);
        }
    }
    discard(&w);
}

static void eight_bit_positions_err_by_at_most_a_510th_of_the_box(void **state) {
    trace_mesh mesh = furnished();
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, 2.2f, 2, 2.6f);
    how h = by_default();
    world w = world_of(&mesh, &h);
    float exact[3][6 * 256];
    for (int k = 0; k < 3; k++) memcpy(exact[k], w.map->position[k], sizeof exact[k]);
    h.settings.eight_bit_positions = true;
    take(&w, &h);
    const float extent[3] = {4, 3, 5};
    for (int k = 0; k < 3; k++) {
        float largest = 0.0f;
        for (size_t i = 0; i < 6 * 256; i++) {
            float error = fabsf(w.map->position[k][i] - exact[k][i]);
            largest = error > largest ? error : largest;
        }
        assert_true(largest <= extent[k] / 510.0f * 1.0001f && largest > extent[k] / 2000.0f);
    }
    discard(&w);
}

/* ---- radiance ---- */

/* (5) and (9) by hand. */
static sl_rgb direct_radiance(const world *w, const sl_map_light *light, size_t i, sl_rgb kd) {
    sl_vec3 y = at(w->map->position, i), to = sl_neg(light->source.direction), n = at(w->map->normal, i);
    double r = 1.0, strength = 1.0;
    if (light->source.kind != SL_SOURCE_DIRECTIONAL) {
        sl_vec3 d = sl_sub(light->source.position, y);
        r = (double)sl_length(d);
        to = sl_scale(d, (float)(1.0 / r));
    }
    double c = -(double)sl_dot(to, light->source.direction), cosine = (double)sl_dot(n, to);
    if (light->source.kind == SL_SOURCE_AREA) strength = c > 0.0 ? c : 0.0;
    if (light->source.kind == SL_SOURCE_SPOT) {
        const double outer = (double)light->source.cos_outer;
        double x = (c - outer) / ((double)light->source.cos_inner - outer);
        x = x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x;
        strength = x * x * (3.0 - 2.0 * x);
    }
    return sl_rgb_scale(sl_rgb_mul(kd, light->source.colour),
                        (float)(strength * (cosine > 0.0 ? cosine : 0.0) / (SL_PI * r * r)));
}

static void the_radiance_picture_is_direct_light_at_the_same_points(void **state) {
    how h = by_default();
    world w = lit_by_every_kind(&h);
    int lit = 0;
    for (size_t f = 0; f < w.map->face_count; f++) {
        const sl_map_face *face = &w.map->face[f];
        for (size_t i = face->first; i < face->first + texels_of(face); i++) {
            if (w.map->triangle[i] == SL_NO_INDEX) continue;
            sl_rgb kd = w.scene->materials[w.scene->material_index[w.map->triangle[i]]].diffuse;
            sl_rgb expected = direct_radiance(&w, &w.lights->light[face->light], i, kd);
            sl_vec3 found = at(w.map->color, i);
            assert_true(fabsf(found.x - expected.r) <= 2e-5f * expected.r + 1e-7f &&
                        fabsf(found.z - expected.b) <= 2e-5f * expected.b + 1e-7f);
            lit += found.x > 0.0f;
        }
    }
    assert_true(lit > 2000);
    assert_int_equal(w.counters.value[SL_COUNT_SHADOW_LOOKUPS], 0);
    discard(&w);
}

static void true_colour_and_normals_are_there_exactly_when_asked_for(void **state) {
    trace_mesh mesh = furnished();
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, 2.2f, 2, 2.6f);
    how h = by_default();
    h.true_color = true;
    world w = world_of(&mesh, &h);
    assert_false(w.map->lambertian);
    assert_non_null(w.map->normal[0]);
    for (size_t i = 0; i < w.map->texels; i++) {
        sl_rgb kd = w.scene->materials[w.scene->material_index[w.map->triangle[i]]].diffuse;
        assert_true(w.map->color[0][i] == kd.r && w.map->color[2][i] == kd.b);
    }
    h.true_color = false;
    h.no_normals = true;
    size_t bytes = sl_radiance_map_bytes(w.map);
    take(&w, &h);
    assert_true(w.map->lambertian);
    assert_null(w.map->normal[0]);
    assert_null(w.map->arrival[0]);
    assert_int_equal(bytes - sl_radiance_map_bytes(w.map), 3 * sizeof(float) * w.map->texels);
    discard(&w);
}

/* ---- faces ---- */

static double angles(const sl_radiance_map *map) {
    double sum = 0.0;
    for (size_t i = 0; i < map->texels; i++) sum += texel_size(map, i);
    return sum;
}

static double captured(world *w, const how *base, sl_map_shape shape, double degrees) {
    how h = *base;
    h.settings.shape = shape;
    h.settings.map_fov = degrees * SL_PI / 180.0;
    take(w, &h);
    return w->map->captured;
}

static void the_captured_share_of_the_flux_is_what_each_shape_can_hold(void **state) {
    how h = by_default();
    trace_mesh mesh = furnished();
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, 2.2f, 2, 2.6f);
    world w = world_of(&mesh, &h);
    assert_true(fabs(captured(&w, &h, SL_MAP_AUTO, 0) - 1.0) < 5e-4);
    assert_true(fabs(captured(&w, &h, SL_MAP_CUBE, 0) - 1.0) < 5e-4);
    assert_true(fabs(captured(&w, &h, SL_MAP_FRUSTUM, 0) - 1.0 / 6.0) < 5e-4);
    assert_true(fabs(captured(&w, &h, SL_MAP_FRUSTUM, 120) - 0.270) < 1e-3);
    discard(&w);
    mesh = furnished();
    add_panel(&mesh, 1.7f, 2.99f, 1.2f, 0.8f);
    w = world_of(&mesh, &h);
    assert_true(fabs(captured(&w, &h, SL_MAP_AUTO, 0) - 1.0) < 5e-4);
    assert_true(fabs(captured(&w, &h, SL_MAP_CUBE, 0) - 1.0) < 5e-4);
    assert_true(fabs(captured(&w, &h, SL_MAP_FRUSTUM, 0) - 0.554) < 5e-4);
    assert_true(fabs(captured(&w, &h, SL_MAP_FRUSTUM, 120) - 0.787) < 1e-3);
    discard(&w);
    for (int i = 0; i < 3; i++) { /* a spot's own frustum, hemicube, cube */
        mesh = furnished();
        mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_SPOT, 2.2f, 2, 2.6f);
        mesh.lights[0].cos_outer = i == 0 ? 0.7f : i == 1 ? 0.2f : -0.8f;
        w = world_of(&mesh, &h);
        assert_true(fabs(captured(&w, &h, SL_MAP_AUTO, 0) - 1.0) < 1e-3);
        assert_int_equal(w.map->face_count, i == 0 ? 1 : i == 1 ? 5 : 6);
        discard(&w);
    }
}

static void a_light_that_faces_the_void_has_no_faces_and_one_half_in_it_has_empty_texels(void **state) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t m = trace_mesh_diffuse(&mesh, 0.5f);
    trace_mesh_quad(&mesh, sl_v3(-1, 0, 1), sl_v3(2, 0, 0), sl_v3(0, 0, -2), m);
    mesh.lights[mesh.light_count] = light_at(SL_LIGHT_SPOT, 0, 1, 0);
    mesh.lights[mesh.light_count++].direction = sl_v3(0, 1, 0);
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, 0, 2, 0);
    how h = by_default();
    world w = world_of(&mesh, &h);
    assert_int_equal(passes(&w), 1);
    assert_int_equal(skipped(&w), 1 + 5);
    assert_int_equal(w.map->face_count, 1);
    assert_int_equal(w.map->face[0].light, 1);
    size_t seen = covered(w.map);
    assert_int_equal(seen, 64); /* half of the picture each way */
    for (size_t i = 0; i < w.map->texels; i++) {
        if (w.map->triangle[i] == SL_NO_INDEX)
            assert_true(w.map->color[0][i] == 0.0f && w.map->path[i] == 0.0f);
    }
    /* A light that has gone out. */
    w.lights->light[1].source.colour = sl_grey(0.0f);
    take(&w, &h);
    assert_int_equal(w.map->face_count, 0);
    assert_int_equal(passes(&w), 0);
    assert_int_equal(skipped(&w), 1 + 6);
    discard(&w);
}

/* ---- area lights ---- */

static void an_area_light_does_not_see_itself_and_what_lies_behind_it(void **state) {
    trace_mesh mesh = furnished();
    add_panel(&mesh, 1.7f, 2.9f, 1.2f, 0.8f);
    add_panel(&mesh, 0.4f, 2.7f, 3.2f, 0.8f); /* of another light: seen */
    how h = by_default();
    h.settings.map_size = 33;
    h.settings.samples = 3;
    world w = world_of(&mesh, &h);
    int others = 0;
    for (size_t f = 0; f < w.map->face_count; f++) {
        for (size_t i = w.map->face[f].first; i < w.map->face[f].first + texels_of(&w.map->face[f]); i++) {
            uint32_t t = w.map->triangle[i];
            if (t == SL_NO_INDEX) continue;
            const uint32_t lamp = w.lights->lamps->light_of_triangle[t];
            assert_int_not_equal(lamp, w.lights->light[w.map->face[f].light].lamp);
            others += lamp != SL_NO_INDEX;
            /* a row of texels lies in the horizon itself */
            assert_true(w.map->position[1][i] < w.map->face[f].eye.y + 1e-5f);
        }
    }
    assert_true(others > 0);
    discard(&w);
}

static void a_two_sided_light_has_a_hemicube_on_either_side(void **state) {
    trace_mesh mesh = furnished();
    trace_mesh_quad(&mesh, sl_v3(2, 1.7f, 2), sl_v3(0.5f, 0, 0), sl_v3(0, 0, 0.5f),
                    trace_mesh_lamp(&mesh, 5));
    mesh.materials[mesh.material_count - 1].emission_two_sided = true;
    how h = by_default();
    world w = world_of(&mesh, &h);
    assert_int_equal(w.map->face_count, 10);
    assert_true(covered(w.map) == w.map->texels);
    assert_true(fabs(w.map->captured - 1.0) < 5e-4);
    assert_true(fabs(angles(w.map) - 4.0 * SL_PI) < 1e-5);
    h.settings.shape = SL_MAP_FRUSTUM;
    take(&w, &h);
    assert_int_equal(w.map->face_count, 2);
    assert_true(fabs(w.map->captured - 0.554) < 5e-4);
    discard(&w);
}

/* ---- mirrors ---- */

/* A floor, a wall at x = -1, and a mirror beside the light at x = 1 that faces both; reflectance 0.8. */
static trace_mesh mirror_scene(bool with_mirror) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t m = trace_mesh_diffuse(&mesh, 0.5f), mirror = trace_mesh_material(&mesh, 0, 0, 0, 0.8f, 0);
    trace_mesh_quad(&mesh, sl_v3(-1, 0, 1), sl_v3(2, 0, 0), sl_v3(0, 0, -2), m);
    trace_mesh_quad(&mesh, sl_v3(-1, 0, 1), sl_v3(0, 0, -2), sl_v3(0, 2, 0), m);
    trace_mesh_quad(&mesh, sl_v3(1, 0.4f, 0.6f), sl_v3(0, 0, -1.2f), sl_v3(0, 1.2f, 0),
                    with_mirror ? mirror : m);
    return mesh;
}

static bool is_mirrored(const sl_radiance_map *map, size_t i) {
    return sl_length(at(map->arrival, i)) > 0.0f;
}

static size_t mirrored_texels(const sl_radiance_map *map) {
    size_t count = 0;
    for (size_t i = 0; i < map->texels; i++) count += is_mirrored(map, i);
    return count;
}

/* As if it came from the light's image L' behind the mirror. */
static void a_mirror_beside_the_light_shows_real_positions_at_unfolded_distances(void **state) {
    trace_mesh mesh = mirror_scene(true);
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, 0.4f, 1, 0.1f);
    how h = by_default();
    h.traced = true;
    world w = world_of(&mesh, &h);
    const sl_vec3 image = sl_v3(1.6f, 1, 0.1f);
    double angle = 0.0;
    for (size_t i = 0; i < w.map->texels; i++) {
        if (!is_mirrored(w.map, i)) continue;
        const sl_vec3 p = at(w.map->position, i), arrival = at(w.map->arrival, i);
        const float b = w.map->path[i], cosine = sl_dot(arrival, at(w.map->normal, i));
        angle += texel_size(w.map, i);
        assert_true(distance_to_triangle(w.scene, w.map->triangle[i], p) < 1e-5 * (double)w.scene->diagonal);
        assert_true(fabsf(b - sl_length(sl_sub(p, image))) < 1e-5f);
        assert_true(sl_length(sl_sub(arrival, sl_scale(sl_sub(image, p), 1.0f / b))) < 1e-5f);
        const float irradiance = 3.0f * 0.8f / (b * b); /* a plane mirror keeps solid angles */
        assert_true(fabsf(w.map->color[0][i] - 0.5f / (float)SL_PI * irradiance * cosine) < 1e-5f);
    }
    assert_true(mirrored_texels(w.map) > 60);
    /* All of the rectangle that the mirror is, as the light sees it, shows the floor or the wall but for what
     * passes them. */
    assert_true(angle > 0.8);
    discard(&w);
}

static void parallel_light_is_mirrored_too(void **state) {
    trace_mesh mesh = mirror_scene(true);
    sl_light light = light_at(SL_LIGHT_DIRECTIONAL, 0, 0, 0);
    light.direction = sl_normalize_or(sl_v3(1, -0.7f, 0.2f), sl_v3(0, -1, 0));
    mesh.lights[mesh.light_count++] = light;
    /* Light comes from the open side: the wall is taken away by being below. */
    how h = by_default();
    h.traced = true;
    h.settings.map_size = 32;
    world w = world_of(&mesh, &h);
    for (size_t i = 0; i < w.map->texels; i++) {
        if (!is_mirrored(w.map, i)) continue;
        const sl_vec3 p = at(w.map->position, i), back = at(w.map->arrival, i);
        assert_true(fabsf(back.x - light.direction.x) < 1e-6f && fabsf(back.y + light.direction.y) < 1e-6f);
        assert_true(distance_to_triangle(w.scene, w.map->triangle[i], p) < 1e-5 * (double)w.scene->diagonal);
        /* Back along the light lies the mirror. */
        const float t = (1.0f - p.x) / back.x;
        const sl_vec3 m = sl_mad(p, t, back);
        assert_true(t > 0.0f && m.y > 0.39f && m.y < 1.61f && fabsf(m.z) < 0.61f);
        const float cosine = sl_dot(back, at(w.map->normal, i));
        assert_true(fabsf(w.map->color[1][i] -
                          0.5f / (float)SL_PI * 2.0f * 0.8f * (cosine > 0.0f ? cosine : 0.0f)) < 1e-3f);
    }
    assert_true(mirrored_texels(w.map) > 20);
    discard(&w);
}

static void a_ball_throws_the_light_that_it_mirrors_onto_real_surfaces(void **state) {
    trace_mesh mesh = furnished();
    trace_mesh_sphere(&mesh, sl_v3(2.9f, 1.2f, 3.4f), 0.5f, 32, 0, false,
                      trace_mesh_material(&mesh, 0, 0, 0, 0.9f, 0));
    mesh.lights[mesh.light_count++] = light_at(SL_LIGHT_POINT, 2.2f, 2, 2.6f);
    how h = by_default();
    h.traced = true;
    h.settings.map_size = 32;
    world w = world_of(&mesh, &h);
    size_t traced = 0;
    for (size_t i = 0; i < w.map->texels; i++) {
        if (w.map->triangle[i] == SL_NO_INDEX) continue;
        assert_false(sl_material_is_mirror(
            &w.scene->materials[w.scene->material_index[w.map->triangle[i]]]));
        if (!is_mirrored(w.map, i)) continue;
        traced++;
        assert_true(distance_to_triangle(w.scene, w.map->triangle[i], at(w.map->position, i)) <
                    1e-5 * (double)w.scene->diagonal);
        assert_true(fabsf(sl_length(at(w.map->arrival, i)) - 1.0f) < 1e-5f &&
                    sl_dot(at(w.map->arrival, i), at(w.map->geometric, i)) > 0.0f);
    }
    assert_true(traced > 20);
    assert_true(all_finite(w.map));
    discard(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_position_lies_on_its_triangle_where_its_ray_points),
        cmocka_unit_test(eight_bit_positions_err_by_at_most_a_510th_of_the_box),
        cmocka_unit_test(the_radiance_picture_is_direct_light_at_the_same_points),
        cmocka_unit_test(true_colour_and_normals_are_there_exactly_when_asked_for),
        cmocka_unit_test(the_captured_share_of_the_flux_is_what_each_shape_can_hold),
        cmocka_unit_test(a_light_that_faces_the_void_has_no_faces_and_one_half_in_it_has_empty_texels),
        cmocka_unit_test(an_area_light_does_not_see_itself_and_what_lies_behind_it),
        cmocka_unit_test(a_two_sided_light_has_a_hemicube_on_either_side),
        cmocka_unit_test(a_mirror_beside_the_light_shows_real_positions_at_unfolded_distances),
        cmocka_unit_test(parallel_light_is_mirrored_too),
        cmocka_unit_test(a_ball_throws_the_light_that_it_mirrors_onto_real_surfaces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
