#include "raster_workloads.h"

#include <stdio.h>
#include <string.h>

#include "base/counters.h"
#include "base/memory.h"
#include "common.h"
#include "base/parallel.h"

static const double wanted_id = 4.0, wanted_gbuffer = 3.0, wanted_gather = 5.0, wanted_cube = 3.0;

/* ---- large targets, parallel inside: ID map, depth cube -------------------------------------- */

typedef struct large_pass {
    const bench_scene *scene;
    sl_view view[6];
    size_t views;
    uint32_t *id; /* NULL: depth alone */
    float *depth; /* of all views */
} large_pass;

static void draw_large(void *context, unsigned threads, sl_counters *counters) {
    const large_pass *p = context;
    sl_error error;
    for (size_t i = 0; i < p->views; i++) {
        size_t pixels = (size_t)p->view[i].width * (size_t)p->view[i].height;
        sl_target target = {p->view[i].width, p->view[i].height, p->id, p->depth + i * pixels};
        bench_check(sl_raster_id(p->scene->raster, &p->view[i], threads, &target, counters, &error), &error);
    }
}

static double differing_ids(void *context, peer_pass *peer) {
    const large_pass *p = context;
    size_t pixels = (size_t)p->view[0].width * (size_t)p->view[0].height, differ = 0;
    peer_run_view(peer, 0);
    const uint32_t *id = peer_plane(peer, 0);
    for (size_t i = 0; i < pixels; i++) differ += id[i] != p->id[i];
    return (double)differ / (double)pixels;
}

void bench_id_map(measurer *m, bench_scene *scene, int width, int height) {
    size_t pixels = (size_t)width * (size_t)height;
    workload w = {.wanted = wanted_id, .renders = 1, .ours = draw_large, .differing = differing_ids};
    snprintf(w.name, sizeof w.name, "ID map and depth %dx%d, %s", width, height, scene->name);
    if (!measure_wants(m, w.name)) return;
    bench_scene_open(scene);
    large_pass p = {scene,
                    {bench_camera_view(scene, width, height)},
                    1,
                    bench_allocate(pixels, 4),
                    bench_allocate(pixels, 4)};
    w.context = &p;
    w.peer = peer_ids(&scene->mesh, p.view, 1, true);
    measure_row(m, &w);
    sl_free(p.id);
    sl_free(p.depth);
}

void bench_depth_cube(measurer *m, bench_scene *scene) {
    enum { SIZE = 512 };
    size_t pixels = (size_t)SIZE * SIZE;
    workload w = {.wanted = wanted_cube, .renders = 1, .ours = draw_large};
    snprintf(w.name, sizeof w.name, "depth cube 6 x %dx%d, %s", SIZE, SIZE, scene->name);
    if (!measure_wants(m, w.name)) return;
    bench_scene_open(scene);
    large_pass p = {.scene = scene, .views = 6, .depth = bench_allocate(6 * pixels, sizeof(float))};
    const sl_scene *s = scene->scene;
    sl_vec3 middle = sl_mad(s->box_min, 0.5f, sl_sub(s->box_max, s->box_min));
    for (int face = 0; face < 6; face++) {
        const float side = face % 2 ? -1.0f : 1.0f;
        sl_frame frame = sl_frame_from_normal(
            sl_v3(face / 2 == 0 ? side : 0.0f, face / 2 == 1 ? side : 0.0f, face / 2 == 2 ? side : 0.0f));
        p.view[face] = sl_view_pyramid(&frame, middle, -1, 1, -1, 1, SIZE, SIZE, 1e-3f * s->diagonal);
    }
    w.context = &p;
    w.peer = peer_ids(&scene->mesh, p.view, 6, false);
    measure_row(m, &w);
    sl_free(p.depth);
}

/* ---- G-buffer: position, normal, diffuse ----------------------------------------------------- */

typedef struct gbuffer_pass {
    const bench_scene *scene;
    sl_view view;
    sl_gbuffer planes;
} gbuffer_pass;

static void draw_gbuffer(void *context, unsigned threads, sl_counters *counters) {
    gbuffer_pass *p = context;
    sl_error error;
    bench_check(sl_raster_gbuffer(p->scene->raster, &p->view, threads, &p->planes, counters, &error), &error);
}

/* Share of the pixels where positions are apart by more than interpolation's rounding can be. Vertices that
 * stand in one place are one to OSMesa, with one of their normals. */
static double differing_surfaces(void *context, peer_pass *peer) {
    const gbuffer_pass *p = context;
    const sl_gbuffer *g = &p->planes;
    size_t pixels = (size_t)g->width * (size_t)g->height, differ = 0;
    peer_run_view(peer, 0);
    const float *position = peer_plane(peer, 0);
    for (size_t i = 0; i < pixels; i++) {
        sl_vec3 dp = sl_v3(position[4 * i] - g->position_x[i], position[4 * i + 1] - g->position_y[i],
                           position[4 * i + 2] - g->position_z[i]);
        differ += !(sl_length(dp) < 1e-3f * p->scene->scene->diagonal) ? 1 : 0;
    }
    return (double)differ / (double)pixels;
}

void bench_gbuffer(measurer *m, bench_scene *scene) {
    enum { SIZE = 1000 };
    workload w = {
        .wanted = wanted_gbuffer, .renders = 1, .ours = draw_gbuffer, .differing = differing_surfaces};
    snprintf(w.name, sizeof w.name, "G-buffer %dx%d, %s", SIZE, SIZE, scene->name);
    if (!measure_wants(m, w.name)) return;
    bench_scene_open(scene);
    sl_gbuffer *g;
    sl_error error;
    bench_check(sl_gbuffer_create(SIZE, SIZE, &g, &error), &error);
    gbuffer_pass p = {scene, bench_camera_view(scene, SIZE, SIZE), *g};
    p.planes.geometric_x = p.planes.geometric_y = p.planes.geometric_z = NULL;
    p.planes.material = NULL;
    w.context = &p;
    w.peer = peer_gbuffer(&scene->mesh, &p.view);
    measure_row(m, &w);
    sl_gbuffer_destroy(g);
}

/* ---- gathers: many small targets, a thread each ---------------------------------------------- */

enum { FACES = 5, THREADS = 2 };

typedef struct gather_pass {
    const bench_scene *scene;
    sl_view view[FACES * BENCH_POINTS];
    size_t each; /* views a point */
    sl_raster_scratch *scratch[THREADS];
    uint32_t *id[THREADS];
    float *depth[THREADS];
    sl_counters counters[THREADS];
} gather_pass;

static void draw_point(void *context, size_t point, unsigned worker) {
    gather_pass *p = context;
    for (size_t k = 0; k < p->each; k++) {
        const sl_view *view = &p->view[point * p->each + k];
        sl_target target = {view->width, view->height, p->id[worker], p->depth[worker]};
        sl_raster_id_small(p->scene->raster, view, &target, p->scratch[worker], &p->counters[worker]);
    }
}

static void draw_points(void *context, unsigned threads, sl_counters *counters) {
    gather_pass *p = context;
    memset(p->counters, 0, sizeof p->counters);
    sl_parallel_for(threads, p->scene->points, draw_point, p);
    for (int t = 0; t < THREADS; t++) sl_counters_add(counters, &p->counters[t]);
}

static double differing_gathers(void *context, peer_pass *peer) {
    gather_pass *p = context;
    double differ = 0, pixels = 0;
    for (size_t i = 0; i < p->scene->points * p->each; i++) {
        const sl_view *view = &p->view[i];
        size_t count = (size_t)view->width * (size_t)view->height;
        sl_target target = {view->width, view->height, p->id[0], p->depth[0]};
        sl_raster_id_small(p->scene->raster, view, &target, p->scratch[0], &p->counters[0]);
        peer_run_view(peer, i);
        const uint32_t *id = peer_plane(peer, 0);
        for (size_t k = 0; k < count; k++) differ += id[k] != p->id[0][k];
        pixels += (double)count;
    }
    return differ / pixels;
}

static void run_gathers(measurer *m, workload *w, gather_pass *p, int size) {
    size_t pixels = (size_t)size * (size_t)size;
    sl_error error;
    for (int t = 0; t < THREADS; t++) {
        p->id[t] = bench_allocate(pixels, sizeof(uint32_t));
        p->depth[t] = bench_allocate(pixels, sizeof(float));
        bench_check(sl_raster_scratch_create(p->scene->raster, size, size, &p->scratch[t], &error), &error);
    }
    w->context = p;
    w->ours = draw_points;
    w->differing = differing_gathers;
    w->wanted = wanted_gather;
    w->renders = (double)p->scene->points;
    w->peer = peer_ids(&p->scene->mesh, p->view, p->scene->points * p->each, true);
    measure_row(m, w);
    for (int t = 0; t < THREADS; t++) {
        sl_raster_scratch_destroy(p->scratch[t]);
        sl_free(p->id[t]);
        sl_free(p->depth[t]);
    }
}

void bench_hemisphere(measurer *m, bench_scene *scene, int size) {
    workload w = {0};
    gather_pass p = {.scene = scene, .each = 1};
    snprintf(w.name, sizeof w.name, "plane of 160 degrees %dx%d, %s", size, size, scene->name);
    if (!measure_wants(m, w.name)) return;
    bench_scene_open(scene);
    for (size_t i = 0; i < scene->points; i++) p.view[i] = bench_plane_view(scene, i, size, 160.0);
    run_gathers(m, &w, &p, size);
}

void bench_hemicube(measurer *m, bench_scene *scene, int size) {
    workload w = {0};
    gather_pass p = {.scene = scene, .each = FACES};
    snprintf(w.name, sizeof w.name, "hemicube %dx%d, %s", size, size, scene->name);
    if (!measure_wants(m, w.name)) return;
    bench_scene_open(scene);
    for (size_t i = 0; i < scene->points; i++) bench_hemicube_views(scene, i, size, &p.view[FACES * i]);
    run_gathers(m, &w, &p, size);
}
