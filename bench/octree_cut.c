/* The same surfaces in more triangles. */
#include <stdlib.h>

#include "octree_bench.h"

typedef struct cut_parts {
    float *positions, *normals, *uvs;
    uint32_t *indices, *material, *object;
    size_t triangles;
} cut_parts;

static void put_corner(const sl_scene *s, size_t t, const float w[3], cut_parts *parts, size_t vertex) {
    float *p = parts->positions + 3 * vertex, *n = parts->normals + 3 * vertex, *uv = parts->uvs + 2 * vertex;
    for (int k = 0; k < 3; k++) {
        uint32_t v = s->vertex[k][t];
        const float values[8] = {s->position_x[v], s->position_y[v], s->position_z[v], s->normal_x[v],
                                 s->normal_y[v],   s->normal_z[v],   s->texture_u[v],  s->texture_v[v]};
        for (int d = 0; d < 3; d++) {
            p[d] += w[k] * values[d];
            n[d] += w[k] * values[3 + d];
        }
        for (int d = 0; d < 2; d++) uv[d] += w[k] * values[6 + d];
    }
}

/* Corners at (i, j) of a grid of n steps along two of the triangle's edges. */
static void put_triangle(const sl_scene *s, size_t t, const int at[3][2], int n, cut_parts *parts) {
    for (size_t k = 0; k < 3; k++) {
        float u = (float)at[k][0] / (float)n, v = (float)at[k][1] / (float)n;
        put_corner(s, t, (const float[3]){1.0f - u - v, u, v}, parts, 3 * parts->triangles + k);
        parts->indices[3 * parts->triangles + k] = (uint32_t)(3 * parts->triangles + k);
    }
    parts->material[parts->triangles] = s->material_index[t];
    parts->object[parts->triangles++] = s->object_index[t];
}

static void cut_triangle(const sl_scene *s, size_t t, int n, cut_parts *parts) {
    for (int j = 0; j < n; j++) {
        for (int i = 0; i + j < n; i++) {
            put_triangle(s, t, (const int[3][2]){{i, j}, {i + 1, j}, {i, j + 1}}, n, parts);
            if (i + j + 1 < n)
                put_triangle(s, t, (const int[3][2]){{i + 1, j}, {i + 1, j + 1}, {i, j + 1}}, n, parts);
        }
    }
}

sl_scene *octree_cut_scene(const sl_scene *s, int times) {
    size_t most = s->triangle_count << (2 * times);
    cut_parts parts = {calloc(9 * most, sizeof(float)),
                       calloc(9 * most, sizeof(float)),
                       calloc(6 * most, sizeof(float)),
                       calloc(3 * most, sizeof(uint32_t)),
                       calloc(most, sizeof(uint32_t)),
                       calloc(most, sizeof(uint32_t)),
                       0};
    if (!parts.positions || !parts.normals || !parts.uvs || !parts.indices || !parts.material ||
        !parts.object)
        bench_fail("triangles", NULL);
    /* lamps stay: what is sampled of them is another matter */
    for (size_t t = 0; t < s->triangle_count; t++) {
        cut_triangle(s, t, sl_material_is_emitter(&s->materials[s->material_index[t]]) ? 1 : 1 << times,
                     &parts);
    }
    sl_scene_parts whole = {.vertex_count = 3 * parts.triangles,
                            .positions = parts.positions,
                            .normals = parts.normals,
                            .texture_coordinates = parts.uvs,
                            .triangle_count = parts.triangles,
                            .indices = parts.indices,
                            .material_index = parts.material,
                            .object_index = parts.object,
                            .material_count = s->material_count,
                            .materials = s->materials,
                            .texture_count = s->texture_count,
                            .textures = s->textures,
                            .light_count = s->light_count,
                            .lights = s->lights,
                            .environment = s->environment.present ? &s->environment : NULL,
                            .camera = &s->camera};
    sl_scene *scene;
    sl_error error;
    if (sl_scene_build(&whole, &scene, &error) != SL_OK) bench_fail("triangles", &error);
    void *blocks[] = {parts.positions, parts.normals, parts.uvs, parts.indices, parts.material, parts.object};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) free(blocks[i]);
    return scene;
}
