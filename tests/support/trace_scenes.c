#include "unit_test.h"
#include "trace_scenes.h"

#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/random.h"
#include "scene_parts.h"
#include "trace/path_walk.h"

trace_mesh trace_mesh_begin(void) {
    trace_mesh mesh = {0};
    mesh.positions = calloc(3 * TRACE_VERTICES_MAX, sizeof(float));
    mesh.texture_coordinates = calloc(2 * TRACE_VERTICES_MAX, sizeof(float));
    mesh.indices = calloc(3 * TRACE_TRIANGLES_MAX, sizeof(uint32_t));
    mesh.material_index = calloc(TRACE_TRIANGLES_MAX, sizeof(uint32_t));
    assert_true(mesh.positions && mesh.texture_coordinates && mesh.indices && mesh.material_index);
    return mesh;
}

uint32_t trace_mesh_vertex(trace_mesh *mesh, float x, float y, float z) {
    assert_true(mesh->vertex_count < TRACE_VERTICES_MAX);
    float *p = mesh->positions + 3 * mesh->vertex_count;
    p[0] = x;
    p[1] = y;
    p[2] = z;
    return (uint32_t)mesh->vertex_count++;
}

void trace_mesh_triangle(trace_mesh *mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t material) {
    assert_true(mesh->triangle_count < TRACE_TRIANGLES_MAX);
    uint32_t *corner = mesh->indices + 3 * mesh->triangle_count;
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
    mesh->material_index[mesh->triangle_count++] = material;
}

static uint32_t add_vertex(trace_mesh *mesh, sl_vec3 p) { return trace_mesh_vertex(mesh, p.x, p.y, p.z); }

void trace_mesh_quad(trace_mesh *mesh, sl_vec3 corner, sl_vec3 a, sl_vec3 b, uint32_t material) {
    uint32_t v0 = add_vertex(mesh, corner), v1 = add_vertex(mesh, sl_add(corner, a));
    uint32_t v2 = add_vertex(mesh, sl_add(sl_add(corner, a), b)), v3 = add_vertex(mesh, sl_add(corner, b));
    const float uv[8] = {0, 0, 1, 0, 1, 1, 0, 1};
    for (int i = 0; i < 8; i++) mesh->texture_coordinates[2 * v0 + (uint32_t)i] = uv[i];
    trace_mesh_triangle(mesh, v0, v1, v2, material);
    trace_mesh_triangle(mesh, v0, v2, v3, material);
}

void trace_mesh_box(trace_mesh *mesh, sl_vec3 low, sl_vec3 high, bool inside, uint32_t material) {
    uint32_t v[8];
    for (int i = 0; i < 8; i++) {
        v[i] =
            trace_mesh_vertex(mesh, i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
    }
    /* Counter-clockwise from outside. */
    static const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int f = 0; f < 6; f++) {
        uint32_t a = v[faces[f][0]], b = v[faces[f][1]], c = v[faces[f][2]], d = v[faces[f][3]];
        if (inside) {
            uint32_t swap = b;
            b = d;
            d = swap;
        }
        trace_mesh_triangle(mesh, a, b, c, material);
        trace_mesh_triangle(mesh, a, c, d, material);
    }
}

void trace_mesh_sphere(trace_mesh *mesh, sl_vec3 centre, float radius, unsigned rings, float bump,
                       bool inside, uint32_t material) {
    unsigned columns = 2 * rings;
    uint32_t top = trace_mesh_vertex(mesh, centre.x, centre.y + radius, centre.z);
    uint32_t first = 0;
    for (unsigned r = 1; r < rings; r++) {
        for (unsigned c = 0; c < columns; c++) {
            double theta = SL_PI * r / rings, phi = 2.0 * SL_PI * c / columns;
            double size =
                (double)radius * (1.0 + (double)bump * ((double)sl_random_unit(7, r * columns + c) - 0.5));
            uint32_t v = trace_mesh_vertex(mesh, centre.x + (float)(size * sl_sin(theta) * sl_cos(phi)),
                                           centre.y + (float)(size * sl_cos(theta)),
                                           centre.z - (float)(size * sl_sin(theta) * sl_sin(phi)));
            if (r == 1 && c == 0) first = v;
        }
    }
    uint32_t bottom = trace_mesh_vertex(mesh, centre.x, centre.y - radius, centre.z);
    for (unsigned r = 0; r < rings; r++) {
        for (unsigned c = 0; c < columns; c++) {
            unsigned next = (c + 1) % columns;
            uint32_t a = r == 0 ? top : first + (r - 1) * columns + c,
                     b = r == 0 ? top : first + (r - 1) * columns + next;
            uint32_t d = r == rings - 1 ? bottom : first + r * columns + c,
                     e = r == rings - 1 ? bottom : first + r * columns + next;
            if (r > 0) trace_mesh_triangle(mesh, a, inside ? b : d, inside ? d : b, material);
            if (r < rings - 1) trace_mesh_triangle(mesh, b, inside ? e : d, inside ? d : e, material);
        }
    }
}

uint32_t trace_mesh_material(trace_mesh *mesh, float diffuse, float specular, float exponent, float mirror,
                             float emission) {
    assert_true(mesh->material_count < 16);
    mesh->materials[mesh->material_count] =
        (sl_material){.diffuse = sl_grey(diffuse), .specular = sl_grey(specular), .exponent = exponent,
                      .mirror = sl_grey(mirror), .emission = sl_grey(emission), .texture = SL_NO_INDEX,
                      .alpha_texture = SL_NO_INDEX};
    return (uint32_t)mesh->material_count++;
}

uint32_t trace_mesh_diffuse(trace_mesh *mesh, float diffuse) {
    return trace_mesh_material(mesh, diffuse, 0, 0, 0, 0);
}

uint32_t trace_mesh_lamp(trace_mesh *mesh, float emission) {
    return trace_mesh_material(mesh, 0, 0, 0, 0, emission);
}

void trace_mesh_discard(trace_mesh *mesh) {
    free(mesh->positions);
    free(mesh->texture_coordinates);
    free(mesh->indices);
    free(mesh->material_index);
    *mesh = (trace_mesh){0};
}

void trace_mesh_point_light(trace_mesh *mesh, sl_vec3 position, sl_rgb intensity) {
    mesh->lights[mesh->light_count++] =
        (sl_light){.type = SL_LIGHT_POINT, .position = position, .intensity = intensity};
}

sl_scene *trace_mesh_build(trace_mesh *mesh) {
    sl_scene_parts parts = {.vertex_count = mesh->vertex_count,
                            .positions = mesh->positions,
                            .texture_coordinates = mesh->texture_coordinates,
                            .triangle_count = mesh->triangle_count,
                            .indices = mesh->indices,
                            .material_index = mesh->material_index,
                            .material_count = mesh->material_count,
                            .materials = mesh->materials,
                            .light_count = mesh->light_count,
                            .lights = mesh->lights,
                            .texture_count = mesh->texture_count,
                            .textures = mesh->textures,
                            .environment = mesh->environment,
                            .camera = mesh->has_camera ? &mesh->camera : NULL};
    sl_scene *scene = scene_built(&parts);
    trace_mesh_discard(mesh);
    return scene;
}

bool emitter_point(const sl_scene *scene, uint32_t emitter, sl_vec3 p, float u1, float u2,
                   sl_light_sample *sample) {
    const sl_emitter *e = &scene->emitters[emitter];
    sl_vec3 a = sl_scene_position(scene, scene->vertex[0][e->triangle]),
            b = sl_sub(sl_scene_position(scene, scene->vertex[1][e->triangle]), a),
            c = sl_sub(sl_scene_position(scene, scene->vertex[2][e->triangle]), a);
    float root = sqrtf(u1);
    sl_vec3 to = sl_sub(sl_mad(sl_mad(a, root * (1.0f - u2), b), root * u2, c), p);
    sample->distance = sl_length(to);
    sample->to_light = sl_normalize_or(to, sl_v3(0, 1, 0));
    float cosine = -sl_dot(sl_scene_geometric_normal(scene, e->triangle), sample->to_light);
    if (e->two_sided) cosine = fabsf(cosine);
    if (!(cosine > 0.0f) || !(sample->distance > 0.0f)) return false;
    sample->radiance = sl_rgb_scale(e->radiance, e->area * cosine / (sample->distance * sample->distance));
    return true;
}

sl_scene *trace_scene_lit_by(unsigned lights, bool mirrors) {
    trace_mesh mesh = trace_mesh_begin();
    uint32_t wall = trace_mesh_diffuse(&mesh, 0.6f),
             glossy = trace_mesh_material(&mesh, 0.2f, 0.5f, 10, 0, 0);
    uint32_t mirror = trace_mesh_material(&mesh, 0, 0, 0, 0.9f, 0),
             lamp = trace_mesh_material(&mesh, 0.3f, 0, 0, 0, 9.0f);
    mesh.materials[lamp].emission_two_sided = lights >> 5 & 1;
    trace_mesh_quad(&mesh, sl_v3(-3, -1.2f, -3), sl_v3(0, 0, 6), sl_v3(6, 0, 0), wall);
    trace_mesh_quad(&mesh, sl_v3(-3, -0.7f, -3.5f), sl_v3(6, 0, 0), sl_v3(0, 4, 0),
                    mirrors ? mirror : glossy);
    trace_mesh_sphere(&mesh, sl_v3(0.4f, 0, 0), 0.8f, 8, 0.2f, false, glossy);
    if (mirrors) trace_mesh_sphere(&mesh, sl_v3(-1.4f, 0, 0.5f), 0.5f, 8, 0.0f, false, mirror);
    if (lights & 1) trace_mesh_quad(&mesh, sl_v3(-1.5f, 2.5f, -1.5f), sl_v3(3, 0, 0), sl_v3(0, 0, 3), lamp);
    if (lights & 2) {
        trace_mesh_point_light(&mesh, sl_v3(2, 2, 2), (sl_rgb){9, 8, 7});
    }
    if (lights & 4) {
        mesh.lights[mesh.light_count++] = (sl_light){.type = SL_LIGHT_SPOT,
                                                     .position = {-2, 2, 2},
                                                     .direction = {0.6f, -0.64f, -0.48f},
                                                     .intensity = {30, 20, 10},
                                                     .cos_inner = 0.95f,
                                                     .cos_outer = 0.7f};
    }
    if (lights & 8) {
        mesh.lights[mesh.light_count++] =
            (sl_light){.type = SL_LIGHT_DIRECTIONAL, .direction = {0, -0.6f, -0.8f}, .intensity = {1, 2, 3}};
    }
    static float texels[3 * 8 * 4];
    for (int i = 0; i < 3 * 8 * 4; i++) texels[i] = 0.2f + 0.1f * (float)(i / 3 % 5);
    sl_environment sky = {.present = true, .width = 8, .height = 4, .texels = texels};
    if (lights & 16) mesh.environment = &sky;
    mesh.has_camera = true;
    assert_true(sl_camera_look_at(&mesh.camera, sl_v3(1, 1, 4), sl_v3(0, 0.1f, 0), sl_v3(0, 1, 0), 0.9f));
    return trace_mesh_build(&mesh);
}

/* ---- pictures ---- */

sl_tracer *tracer_of(const sl_scene *scene) {
    sl_error error;
    sl_tracer *tracer;
    if (sl_tracer_create(scene, 1, NULL, &tracer, &error) != SL_OK) fail_msg("%s", error.message);
    return tracer;
}

sl_transport transport_of(const char *name) {
    sl_transport transport;
    assert_true(sl_transport_named(name, &transport));
    return transport;
}

trace_picture trace_picture_of(const sl_scene *scene, const sl_path_settings *settings, unsigned samples,
                               bool backwards) {
    const size_t pixels = (size_t)settings->width * (size_t)settings->height;
    trace_picture p = {.counters = {{0}}};
    float *planes = calloc(9 * pixels, sizeof *planes);
    sl_tracer *tracer;
    sl_path_tracer *path;
    assert_non_null(planes);
    assert_int_equal(sl_tracer_create(scene, settings->threads, NULL, &tracer, NULL), SL_OK);
    assert_int_equal(sl_path_tracer_create(scene, tracer, settings, &path, NULL), SL_OK);
    for (unsigned i = 0; i < samples; i++)
        assert_int_equal(sl_path_tracer_sample(path, backwards ? samples - 1 - i : i, &p.counters, NULL),
                         SL_OK);
    assert_int_equal(p.counters.value[SL_COUNT_NONFINITE], 0);
    for (int k = 0; k < 9; k++) p.plane[k / 3][k % 3] = planes + (size_t)k * pixels;
    for (int half = -1; half < 2; half++) {
        float **of = p.plane[half + 1];
        sl_path_tracer_mean(path, half, of[0], of[1], of[2]);
    }
    for (size_t i = 0; i < 9 * pixels; i++) assert_true(planes[i] >= 0.0f && isfinite(planes[i]));
    sl_path_tracer_destroy(path);
    sl_tracer_destroy(tracer);
    return p;
}

void trace_picture_free(trace_picture *picture) { free(picture->plane[0][0]); }

traced_radiance trace_along(const sl_scene *scene, const sl_tracer *tracer, const sl_transport *transport,
                            sl_vec3 origin, sl_vec3 direction, unsigned samples) {
    sl_light_sampler *lights;
    static sl_sequence sequence;
    sl_sequence_make(&sequence);
    assert_int_equal(sl_light_sampler_create_for(scene, transport, &lights, NULL), SL_OK);
    const sl_path_walk walk = {
        .scene = scene, .tracer = tracer, .lights = lights, .sequence = &sequence, .transport = *transport};
    sl_ray16 rays;
    sl_counters counters = {{0}};
    uint64_t key[SL_PACKET];
    double sums[SL_PACKET][3] = {{0.0}};
    traced_radiance traced = {{0.0}, {0.0}};
    for (unsigned i = 0; i < SL_PACKET; i++) {
        sl_ray16_set(&rays, i, origin, direction, 0.0f, INFINITY, SL_NO_INDEX);
        key[i] = sl_random_key(9, i);
    }
    for (unsigned s = 0; s < samples; s++) {
        sl_rgb found[SL_PACKET];
        sl_path_walk_radiance(&walk, &rays, SL_PACKET, false, key, s, found, &counters);
        for (unsigned i = 0; i < SL_PACKET; i++) {
            assert_true(sl_rgb_is_finite(found[i]));
            sums[i][0] += (double)found[i].r / samples;
            sums[i][1] += (double)found[i].g / samples;
            sums[i][2] += (double)found[i].b / samples;
        }
    }
    for (int c = 0; c < 3; c++) {
        double squares = 0.0;
        for (unsigned i = 0; i < SL_PACKET; i++) {
            traced.mean[c] += sums[i][c] / SL_PACKET;
            squares += sums[i][c] * sums[i][c] / SL_PACKET;
        }
        traced.variance[c] = fmax(squares - traced.mean[c] * traced.mean[c], 0.0) / (SL_PACKET - 1);
    }
    sl_light_sampler_destroy(lights);
    return traced;
}
