/* Shared by the rasterizer's tests: scenes from triangle lists, plain views, small renders. */
#pragma once

#include <stdlib.h>
#include <string.h>

#include "unit_test.h"
#include "base/math.h"
#include "base/random.h"
#include "raster/raster.h"
#include "scene_parts.h"

/* Triangles as nine floats each, one grey material. NULL camera. */
static inline sl_scene *scene_of_triangles(const float *xyz, size_t count) {
    uint32_t *indices = malloc((3 * count + 1) * sizeof *indices);
    assert_non_null(indices);
    for (uint32_t i = 0; i < 3 * count; i++) indices[i] = i;
    sl_material grey = {.diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
    sl_scene_parts parts = {.vertex_count = 3 * count,
                            .positions = xyz,
                            .triangle_count = count,
                            .indices = indices,
                            .material_count = 1,
                            .materials = &grey};
    sl_scene *scene = scene_built(&parts);
    free(indices);
    return scene;
}

/* Clip coordinates are the positions themselves, w = 1. */
static inline sl_view flat_view(int width, int height) {
    sl_view view = {.width = width, .height = height, .depth = SL_DEPTH_WINDOW, .skip_triangle = SL_NO_INDEX};
    for (int k = 0; k < 4; k++) view.clip[k][k] = 1.0f;
    return view;
}

static inline void set_clip_row(float row[4], sl_vec3d a, double w) {
    const float values[4] = {(float)a.x, (float)a.y, (float)a.z, (float)w};
    memcpy(row, values, sizeof values);
}

/* Perspective camera with near and far planes, window depth: OpenGL's matrix on top of the camera's rotation;
 * the translation is the view's origin. */
static inline sl_view camera_view(const sl_camera *camera, int width, int height, float near, float far) {
    sl_view view = flat_view(width, height);
    double tangent = sl_tan(0.5 * (double)camera->vertical_fov), aspect = (double)width / (double)height,
           n = (double)near, f = (double)far;
    sl_vec3d forward = sl_scaled(sl_to_double(camera->back), -1.0);
    view.origin = camera->eye;
    set_clip_row(view.clip[0], sl_scaled(sl_to_double(camera->right), 1.0 / (tangent * aspect)), 0.0);
    set_clip_row(view.clip[1], sl_scaled(sl_to_double(camera->up), 1.0 / tangent), 0.0);
    set_clip_row(view.clip[2], sl_scaled(forward, (f + n) / (f - n)), -2.0 * f * n / (f - n));
    set_clip_row(view.clip[3], forward, 0.0);
    return view;
}

static inline sl_raster *raster_of(const sl_scene *scene) {
    sl_raster *raster = NULL;
    assert_int_equal(sl_raster_create(scene, 1, &raster, NULL), SL_OK);
    return raster;
}

static inline void destroy_raster(sl_raster *raster, sl_scene *scene) { /* and its scene */
    sl_raster_destroy(raster);
    sl_scene_destroy(scene);
}

static inline sl_counters render(const sl_raster *raster, const sl_view *view, unsigned threads, uint32_t *id,
                                 float *depth) {
    sl_counters counters = {{0}};
    sl_target target = {view->width, view->height, id, depth};
    assert_int_equal(sl_raster_id(raster, view, threads, &target, &counters, NULL), SL_OK);
    return counters;
}

static inline float random_between(uint64_t key, uint64_t index, float low, float high) {
    return low + (high - low) * sl_random_unit(key, index);
}

static inline sl_vec3 random_direction(uint64_t key, uint64_t index) {
    for (uint64_t n = 0;; n++) {
        sl_vec3 d = sl_v3(random_between(key, index * 64 + 3 * n, -1, 1),
                          random_between(key, index * 64 + 3 * n + 1, -1, 1),
                          random_between(key, index * 64 + 3 * n + 2, -1, 1));
        float r = sl_length(d);
        if ((r > 0.1f && r < 1.0f) || n == 20) return sl_normalize_or(d, sl_v3(0, 0, 1));
    }
}

/* ---- meshes, written as triangles of nine floats; return how many were added at `at` ---- */

/* Each face of the box [low, high], n x n squares of two triangles, turned inwards; vertices moved by
 * function `move` or not. */
typedef sl_vec3 move_vertex(const void *context, sl_vec3 p);
static inline size_t add_box(float *xyz, size_t at, sl_vec3 low, sl_vec3 high, int n, move_vertex *move,
                             const void *context) {
    size_t count = 0;
    for (int face = 0; face < 6; face++) {
        int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        const float l[3] = {low.x, low.y, low.z}, h[3] = {high.x, high.y, high.z};
        for (int j = 0; j < n; j++) {
            for (int i = 0; i < n; i++) {
                const int di[6] = {0, 1, 1, 0, 1, 0}, dj[6] = {0, 0, 1, 0, 1, 1};
                for (int c = 0; c < 6; c++) {
                    float p[3];
                    p[axis] = face % 2 ? h[axis] : l[axis];
                    p[u] = l[u] + (h[u] - l[u]) * ((float)(i + di[c]) / (float)n);
                    p[v] = l[v] + (h[v] - l[v]) * ((float)(j + dj[c]) / (float)n);
                    sl_vec3 q = move ? move(context, sl_v3(p[0], p[1], p[2])) : sl_v3(p[0], p[1], p[2]);
                    memcpy(&xyz[9 * (at + count) + 3 * (size_t)(c % 3)], &q, sizeof q);
                    count += c % 3 == 2;
                }
            }
        }
    }
    return count;
}

/* A box's vertices moved onto a sphere's surface. */
typedef struct ball {
    sl_vec3 centre;
    float radius;
} ball;
static inline sl_vec3 onto_ball(const void *context, sl_vec3 p) {
    const ball *b = context;
    return sl_mad(b->centre, b->radius, sl_normalize_or(sl_sub(p, b->centre), sl_v3(0, 0, 1)));
}

/* A room of 4 x 3 x 5 with `balls` tessellated balls of 12 n^2 triangles each; malloc'ed. */
static inline sl_scene *furnished_room(int balls, int n) {
    size_t room = 12 * 8 * 8, each = 12 * (size_t)n * (size_t)n, count = room + each * (size_t)balls, at;
    float *xyz = malloc(count * 9 * sizeof *xyz);
    assert_non_null(xyz);
    at = add_box(xyz, 0, sl_v3(0, 0, 0), sl_v3(4, 3, 5), 8, NULL, NULL);
    uint64_t key = sl_random_key(77, 0);
    for (uint64_t b = 0; b < (uint64_t)balls; b++) {
        ball shape = {sl_v3(random_between(key, 4 * b, 0.3f, 3.7f),
                            random_between(key, 4 * b + 1, 0.3f, 2.7f),
                            random_between(key, 4 * b + 2, 0.3f, 4.7f)),
                      random_between(key, 4 * b + 3, 0.05f, 0.3f)};
        sl_vec3 half = sl_v3(0.1f, 0.1f, 0.1f);
        at += add_box(xyz, at, sl_sub(shape.centre, half), sl_add(shape.centre, half), n, onto_ball, &shape);
    }
    assert_int_equal(at, count);
    sl_scene *scene = scene_of_triangles(xyz, count);
    free(xyz);
    return scene;
}
