#include "raster_scenes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster_support.h"

#include "base/math.h"
#include "base/memory.h"
#include "trace/trace.h"
#include "common.h"

/* ---- sharing vertices ------------------------------------------------------------------------ */

static uint64_t hash_position(sl_vec3 p) {
    return sl_hash64(sl_hash64(sl_float_bits(p.x) | (uint64_t)sl_float_bits(p.y) << 32) ^ sl_float_bits(p.z));
}

typedef struct welder {
    uint32_t *slot; /* a vertex + 1, or 0 */
    size_t mask;
    float *position, *normal;
    uint32_t count;
} welder;

/* The vertex at p, in order of first use; a new one takes normal n. */
static uint32_t weld(welder *w, sl_vec3 p, sl_vec3 n) {
    for (size_t at = hash_position(p) & w->mask;; at = (at + 1) & w->mask) {
        if (!w->slot[at]) {
            memcpy(&w->position[3 * w->count], &p, sizeof p);
            memcpy(&w->normal[3 * w->count], &n, sizeof n);
            w->slot[at] = ++w->count;
            return w->count - 1;
        }
        if (!memcmp(&w->position[3 * (w->slot[at] - 1)], &p, sizeof p)) return w->slot[at] - 1;
    }
}

/* Vertices at the same place become one, which is as few as there can be: hardware transforms each once. */
static peer_mesh shared_vertices(const sl_scene *scene) {
    size_t slots = 1, corners = 3 * scene->triangle_count;
    while (slots < 2 * corners) slots *= 2;
    welder w = {bench_allocate(slots, sizeof *w.slot), slots - 1, bench_allocate(corners, 3 * sizeof(float)),
                bench_allocate(corners, 3 * sizeof(float)), 0};
    uint32_t *index = bench_allocate(corners, sizeof *index);
    float *colour = bench_allocate(corners, 3 * sizeof *colour);
    for (size_t t = 0; t < scene->triangle_count; t++) {
        const sl_rgb *diffuse = &scene->materials[scene->material_index[t]].diffuse;
        for (size_t k = 0; k < 3; k++) {
            uint32_t from = scene->vertex[k][t];
            uint32_t v = index[3 * t + k] =
                weld(&w, sl_scene_position(scene, from), sl_scene_normal(scene, from));
            memcpy(&colour[3 * v], diffuse, sizeof *diffuse);
        }
    }
    sl_free(w.slot);
    return (peer_mesh){w.count, scene->triangle_count, w.position, w.normal, colour, index};
}

static void free_mesh(peer_mesh *m) {
    sl_free((void *)m->position);
    sl_free((void *)m->normal);
    sl_free((void *)m->colour);
    sl_free((void *)m->index);
}

/* ---- scenes ---------------------------------------------------------------------------------- */

static void make_raster(bench_scene *s) {
    sl_error error;
    bench_check(sl_raster_create(s->scene, 1, &s->raster, &error), &error);
}

/* Points of gathers: what the camera sees in random places, with the normal turned to it. */
static void find_points(bench_scene *s) {
    sl_gather_point points[BENCH_POINTS];
    sl_tracer *tracer;
    sl_error error;
    bench_check(sl_tracer_create(s->scene, 1, NULL, &tracer, &error), &error);
    s->points = bench_visible_points(s->scene, tracer, BENCH_POINTS, points);
    for (size_t i = 0; i < s->points; i++)
        s->point[i] = points[i].position, s->normal[i] = points[i].geometric_normal;
    sl_tracer_destroy(tracer);
}

void bench_scene_open(bench_scene *s) {
    if (s->scene) return;
    sl_error error;
    const sl_load_options load = {.allow_outside = true};
    bench_check(sl_scene_load_with(s->path, &load, &s->scene, &error), &error);
    find_points(s);
    make_raster(s);
    s->mesh = shared_vertices(s->scene);
}

void bench_scene_of_triangles(bench_scene *s, const float *xyz, const float *colours, size_t count) {
    size_t floats = 9 * count;
    s->scene = scene_of_triangles(xyz, count);
    if (s->scene->triangle_count != count) bench_fail("a triangle without area");
    make_raster(s);
    float *position = bench_allocate(floats, sizeof(float)), *colour = bench_allocate(floats, sizeof(float));
    uint32_t *index = bench_allocate(3 * count, sizeof *index);
    memcpy(position, xyz, floats * sizeof *xyz);
    memcpy(colour, colours, floats * sizeof *colours);
    for (uint32_t i = 0; i < 3 * count; i++) index[i] = i;
    s->mesh = (peer_mesh){3 * count, count, position, NULL, colour, index};
}

void bench_scene_close(bench_scene *s) {
    if (!s->scene) return;
    sl_raster_destroy(s->raster);
    sl_scene_destroy(s->scene);
    free_mesh(&s->mesh);
    s->scene = NULL;
}

/* ---- views ----------------------------------------------------------------------------------- */

sl_view bench_camera_view(const bench_scene *s, int width, int height) {
    return camera_view(&s->scene->camera, width, height, 1e-3f * s->scene->diagonal,
                          2.0f * s->scene->diagonal);
}

sl_view bench_flat_view(int width, int height) { return flat_view(width, height); }

/* A gather's: the eye is lifted a little, and as near is what cannot be told from the surface itself. */
static sl_view pyramid_over(const bench_scene *s, size_t i, const sl_frame *frame, const float side[4],
                            int width, int height) {
    float offset = 1e-5f * s->scene->diagonal;
    sl_vec3 eye = sl_mad(s->point[i], offset, s->normal[i]);
    return sl_view_pyramid(frame, eye, side[0], side[1], side[2], side[3], width, height, 2.0f * offset);
}

sl_view bench_plane_view(const bench_scene *s, size_t i, int size, double degrees) {
    sl_frame frame = sl_frame_from_normal(s->normal[i]);
    float t = (float)sl_tan(degrees * SL_PI / 360.0);
    return pyramid_over(s, i, &frame, (float[]){-t, t, -t, t}, size, size);
}

void bench_hemicube_views(const bench_scene *s, size_t i, int size, sl_view views[5]) {
    sl_frame f = sl_frame_from_normal(s->normal[i]);
    const sl_frame frame[5] = {f,
                               {sl_neg(f.z), f.y, f.x},
                               {f.z, f.y, sl_neg(f.x)},
                               {f.x, sl_neg(f.z), f.y},
                               {f.x, f.z, sl_neg(f.y)}};
    static const float side[5][4] = {
        {-1, 1, -1, 1}, {-1, 0, -1, 1}, {0, 1, -1, 1}, {-1, 1, -1, 0}, {-1, 1, 0, 1}};
    for (int k = 0; k < 5; k++) {
        int width = k == 1 || k == 2 ? size / 2 : size, height = k > 2 ? size / 2 : size;
        views[k] = pyramid_over(s, i, &frame[k], side[k], width, height);
    }
}
