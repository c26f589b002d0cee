#include "raster_scenes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster_support.h"

#include "base/math.h"
#include "base/memory.h"
#include "trace/trace.h"
#include "scene_parts.h"

enum { BALLS = 110 };

_Noreturn void bench_stop(const char *what, const char *why) {
    fprintf(stderr, "bench_raster: %s: %s\n", what, why);
    exit(1);
}

void *bench_allocate(size_t count, size_t size) {
    void *memory = sl_allocate(count, size);
    if (!memory) bench_stop("memory", "not enough");
    return memory;
}

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

static void corners_of(const peer_mesh *m, size_t triangle, sl_vec3 p[3]) {
    for (size_t k = 0; k < 3; k++) memcpy(&p[k], &m->position[3 * m->index[3 * triangle + k]], sizeof p[k]);
}

/* Winds triangles [first, end) of one convex part so that their fronts are seen from outside, or from inside.
 */
static void wind(peer_mesh *m, size_t first, size_t end, bool outside) {
    sl_vec3 p[3], sum = {0, 0, 0};
    for (size_t t = first; t < end; t++) {
        corners_of(m, t, p);
        sum = sl_add(sum, sl_add(p[0], sl_add(p[1], p[2])));
    }
    sl_vec3 middle = sl_scale(sum, 1.0f / (3.0f * (float)(end - first)));
    for (size_t t = first; t < end; t++) {
        corners_of(m, t, p);
        sl_vec3 n = sl_cross(sl_sub(p[1], p[0]), sl_sub(p[2], p[0]));
        if ((sl_dot(n, sl_sub(p[0], middle)) > 0.0f) == outside) continue;
        uint32_t *index = (uint32_t *)m->index + 3 * t, other = index[1];
        index[1] = index[2];
        index[2] = other;
    }
}

/* Area-weighted means of the normals around each vertex. */
static float *smooth_normals(const peer_mesh *m) {
    float *normals = bench_allocate(m->vertex_count, 3 * sizeof *normals);
    for (size_t t = 0; t < m->triangle_count; t++) {
        sl_vec3 p[3];
        corners_of(m, t, p);
        sl_vec3 n = sl_cross(sl_sub(p[1], p[0]), sl_sub(p[2], p[0]));
        for (size_t k = 0; k < 3; k++) {
            float *sum = &normals[3 * m->index[3 * t + k]];
            sum[0] += n.x;
            sum[1] += n.y;
            sum[2] += n.z;
        }
    }
    return normals;
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
    if (sl_raster_create(s->scene, 1, &s->raster, &error) != SL_OK) bench_stop("raster", error.message);
}

/* The tests' room has vertices of its own for every triangle; here it is built anew from shared ones. each:
 * triangles of a ball. */
static sl_scene *smooth_scene(sl_scene *raw, size_t each) {
    peer_mesh m = shared_vertices(raw);
    size_t walls = m.triangle_count - BALLS * each;
    wind(&m, 0, walls, false);
    for (size_t b = 0; b < BALLS; b++) wind(&m, walls + b * each, walls + (b + 1) * each, true);
    float *normals = smooth_normals(&m);
    sl_material grey = {.diffuse = {0.5f, 0.5f, 0.5f}, .texture = SL_NO_INDEX, .alpha_texture = SL_NO_INDEX};
    sl_camera camera;
    sl_camera_look_at(&camera, sl_v3(0.2f, 2.6f, 0.2f), sl_v3(2.2f, 1.2f, 3.0f), sl_v3(0, 1, 0), 1.3f);
    sl_scene_parts parts = {.vertex_count = m.vertex_count,
                            .positions = m.position,
                            .normals = normals,
                            .triangle_count = m.triangle_count,
                            .indices = m.index,
                            .material_count = 1,
                            .materials = &grey,
                            .camera = &camera};
    sl_scene *scene;
    sl_error error;
    if (sl_scene_build(&parts, &scene, &error) != SL_OK) bench_stop("room", error.message);
    sl_free(normals);
    free_mesh(&m);
    sl_scene_destroy(raw);
    return scene;
}

static void put_points_on_walls(bench_scene *s) {
    const float size[3] = {4.0f, 3.0f, 5.0f};
    uint64_t key = sl_random_key(5, 0);
    for (s->points = 0; s->points < BENCH_POINTS; s->points++) {
        int axis = (int)s->points % 3, high = (int)s->points / 3 % 2;
        float p[3], n[3] = {0};
        for (int k = 0; k < 3; k++)
            p[k] = random_between(key, 3 * s->points + (uint64_t)k, 0.1f, 0.9f) * size[k];
        p[axis] = high ? size[axis] : 0.0f;
        n[axis] = high ? -1.0f : 1.0f;
        s->point[s->points] = sl_v3(p[0], p[1], p[2]);
        s->normal[s->points] = sl_v3(n[0], n[1], n[2]);
    }
}

/* Random directions through the film; every hit is a point, with the normal turned to the camera. */
static void put_points_in_sight(bench_scene *s) {
    const sl_camera *c = &s->scene->camera;
    float tangent = (float)sl_tan(0.5 * (double)c->vertical_fov);
    float aspect = (float)s->scene->film_width / (float)s->scene->film_height;
    uint64_t key = sl_random_key(1, 2);
    sl_tracer *tracer;
    sl_counters counters = {{0}};
    if (sl_tracer_create(s->scene, 1, NULL, &tracer, NULL) != SL_OK) bench_stop(s->name, "no rays");
    for (uint64_t i = 0; i < 40 * BENCH_POINTS && s->points < BENCH_POINTS; i++) {
        float x = (2.0f * sl_random_unit(key, 2 * i) - 1.0f) * tangent * aspect;
        float y = (2.0f * sl_random_unit(key, 2 * i + 1) - 1.0f) * tangent;
        sl_vec3 d = sl_sub(sl_mad(sl_scale(c->right, x), y, c->up), c->back);
        sl_ray16 ray = {.origin_x = {c->eye.x},
                        .origin_y = {c->eye.y},
                        .origin_z = {c->eye.z},
                        .direction_x = {d.x},
                        .direction_y = {d.y},
                        .direction_z = {d.z},
                        .far = {INFINITY},
                        .skip = {SL_NO_INDEX}};
        sl_hit16 hit;
        sl_trace(tracer, &ray, 1, false, &hit, &counters);
        if (hit.triangle[0] == SL_NO_INDEX) continue;
        sl_surface surface;
        sl_scene_surface(s->scene, hit.triangle[0], hit.w1[0], hit.w2[0], sl_neg(d), &surface);
        s->normal[s->points] = surface.geometric_normal;
        s->point[s->points++] = surface.position;
    }
    sl_tracer_destroy(tracer);
}

static void open_room(bench_scene *s) {
    s->scene = smooth_scene(furnished_room(BALLS, s->n), 12 * (size_t)s->n * (size_t)s->n);
    put_points_on_walls(s);
}

static void open_file(bench_scene *s) {
    sl_error error;
    if (sl_scene_load_with(s->path, &(sl_load_options){.allow_outside = true}, &s->scene, &error) != SL_OK)
        bench_stop(s->path, error.message);
    put_points_in_sight(s);
}

void bench_scene_open(bench_scene *s) {
    if (s->scene) return;
    if (s->path) open_file(s);
    else open_room(s);
    make_raster(s);
    s->mesh = shared_vertices(s->scene);
}

void bench_scene_of_triangles(bench_scene *s, const float *xyz, const float *colours, size_t count) {
    size_t floats = 9 * count;
    s->scene = scene_of_triangles(xyz, count);
    if (s->scene->triangle_count != count) bench_stop(s->name, "a triangle without area");
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
    return sl_view_camera(&s->scene->camera, width, height, 1e-3f * s->scene->diagonal,
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
