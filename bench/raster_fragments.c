#include "raster_workloads.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "common.h"
#include "base/random.h"
#include "cache/splatting/splatting.h"

enum { SIDE = 1000, PIXELS = SIDE * SIDE };

static const double wanted_splats = 6.0, wanted_fill = 4.0, wanted_small = 3.5, wanted_reduction = 15.0;

/* ---- splats: 4000 records of radiance cache splatting on a G-buffer of the room -------------- */

enum { SPLATS = 4000, SUMS = 5 };

typedef struct splat_pass {
    const bench_scene *scene;
    sl_gbuffer *gbuffer;
    uint32_t *receives;
    sl_record record[SPLATS];
    sl_splat_rect rect[SPLATS];
    sl_record_pass rules;
    float *plane[SUMS];
    sl_splat_buffer sums;
    double fragments; /* area of the rectangles */
} splat_pass;

static void draw_splats(void *context, unsigned threads, sl_counters *counters) {
    splat_pass *p = context;
    sl_error error;
    p->rules.threads = threads;
    const sl_record_list list = {.records = p->record, .count = SPLATS, .capacity = SPLATS};
    bench_check(sl_splat_records(&p->rules, &list, 0, &p->sums, counters, &error), &error);
}

/* A record at a random pixel, so large that it is seen some 32 pixels to each side. */
static void make_record(splat_pass *p, size_t i, uint64_t key) {
    const sl_gbuffer *g = p->gbuffer;
    const sl_camera *camera = p->rules.camera;
    size_t pixel = sl_random_bits(key, 16 * i) % PIXELS;
    sl_record *r = &p->record[i];
    r->position = sl_v3(g->position_x[pixel], g->position_y[pixel], g->position_z[pixel]);
    r->normal = sl_v3(g->normal_x[pixel], g->normal_y[pixel], g->normal_z[pixel]);
    float depth = -sl_dot(camera->back, sl_sub(r->position, camera->eye));
    float pixels = 24.0f + 16.0f * sl_random_unit(key, 16 * i + 1);
    r->radius = pixels * p->rules.footprint_per_depth * depth / p->rules.weights.accuracy;
    r->stretch = 1.0f;
    float *e = &r->irradiance.r;
    for (size_t c = 0; c < 3; c++) {
        e[c] = 0.5f + sl_random_unit(key, 16 * i + 2 + c);
        r->rotational[c] = sl_scale(sl_v3(0.1f, -0.2f, 0.15f), e[c]);
        r->rotational_length[c] = sl_length(r->rotational[c]);
        r->translational[c] = sl_scale(sl_v3(-0.2f, 0.1f, 0.3f), e[c]);
    }
    p->rect[i] = sl_sphere_bounds(p->rules.camera, p->rules.receivers.width, p->rules.receivers.height,
                                  p->rules.near_distance, r->position,
                                  1.0001f * (float)p->rules.radii.accuracy * r->radius);
    p->fragments += (double)(p->rect[i].x1 - p->rect[i].x0) * (double)(p->rect[i].y1 - p->rect[i].y0);
}

static void make_gbuffer(splat_pass *p) {
    sl_view view = bench_camera_view(p->scene, SIDE, SIDE);
    sl_counters counters = {{0}};
    sl_error error;
    bench_check(sl_gbuffer_create(SIDE, SIDE, &p->gbuffer, &error), &error);
    bench_check(sl_raster_gbuffer(p->scene->raster, &view, 1, p->gbuffer, &counters, &error), &error);
    p->receives = bench_allocate(PIXELS, sizeof *p->receives);
    for (size_t i = 0; i < PIXELS; i++) p->receives[i] = p->gbuffer->material[i] != SL_NO_INDEX;
}

static void make_splats(splat_pass *p) {
    const sl_camera *camera = &p->scene->scene->camera;
    const float accuracy = 0.3f, scale = p->scene->scene->scale;
    make_gbuffer(p);
    const sl_gbuffer *g = p->gbuffer;
    p->rules = (sl_record_pass){
        .gbuffer = g,
        .receivers = {SIDE, SIDE, g->position_x, g->position_y, g->position_z, g->normal_x, g->normal_y,
                      g->normal_z, p->receives},
        .weights = {accuracy, 1.0f / accuracy, 1e-5f * scale},
        .radii = {.accuracy = (double)accuracy},
        .isa = sl_isa_best(),
        .camera = camera,
        .near_distance = 1e-5f * scale,
        .footprint_per_depth = 2.0f * (float)sl_tan(0.5 * (double)camera->vertical_fov) / SIDE,
    };
    for (size_t i = 0; i < SPLATS; i++) make_record(p, i, sl_random_key(3, 1));
    for (int k = 0; k < SUMS; k++) p->plane[k] = bench_allocate(PIXELS, sizeof(float));
    p->sums = (sl_splat_buffer){p->plane[0], p->plane[1], p->plane[2],
                                p->plane[3], p->plane[4], {NULL, NULL, NULL}};
}

/* Share of the pixels where the sums of weights are apart by more than a thousandth and the change of a
 * record at its edge. */
static double differing_sums(splat_pass *p, peer_pass *peer, void (*draw)(void *, unsigned, sl_counters *)) {
    sl_counters counters = {{0}};
    size_t differ = 0;
    for (int k = 0; k < SUMS; k++) memset(p->plane[k], 0, PIXELS * sizeof(float));
    draw(p, 1, &counters);
    peer_clear(peer);
    peer_run(peer, true);
    const float *sums = peer_plane(peer, 0);
    for (size_t i = 0; i < PIXELS; i++) {
        float ours = p->plane[3][i], theirs = sums[4 * i + 3];
        bool equal = fabsf(ours - theirs) <= 1e-3f * ours + 0.01f;
        differ += !equal;
    }
    return (double)differ / PIXELS;
}

static double differing_splats(void *context, peer_pass *peer) {
    return differing_sums(context, peer, draw_splats);
}

static void free_splats(splat_pass *p) {
    for (int k = 0; k < SUMS; k++) sl_free(p->plane[k]);
    sl_gbuffer_destroy(p->gbuffer);
    sl_free(p->receives);
    sl_free(p);
}

void bench_splats(measurer *m, bench_scene *scene) {
    workload w = {.name = "splats, 4000 records",
                  .wanted = wanted_splats,
                  .ours = draw_splats,
                  .differing = differing_splats};
    if (!measure_wants(m, w.name)) return;
    bench_scene_open(scene);
    splat_pass *p = bench_allocate(1, sizeof *p);
    peer_splat *splats = bench_allocate(SPLATS, sizeof *splats);
    p->scene = scene;
    make_splats(p);
    for (size_t i = 0; i < SPLATS; i++) splats[i] = (peer_splat){p->rect[i], &p->record[i]};
    w.peer = peer_splats(SIDE, SIDE, splats, SPLATS, &p->rules.weights, &p->rules.receivers);
    w.renders = 1;
    w.units = p->fragments;
    w.unit = "pixels";
    w.context = p;
    measure_row(m, &w);
    sl_free(splats);
    free_splats(p);
}

/* ---- Gouraud: interpolated colours behind a depth test --------------------------------------- */

typedef struct gouraud_pass {
    const bench_scene *scene;
    sl_view view;
    uint32_t *id;
    float *depth, *colour, *attributes;
} gouraud_pass;

static void draw_gouraud(void *context, unsigned threads, sl_counters *counters) {
    gouraud_pass *p = context;
    sl_target target = {SIDE, SIDE, p->id, p->depth};
    sl_error error;
    bench_check(sl_raster_id(p->scene->raster, &p->view, threads, &target, counters, &error), &error);
    sl_raster_gouraud(p->scene->raster, &p->view, threads, p->id,
                      &(sl_gouraud_pass){.channels = 3, .vertex = p->attributes, .out = p->colour}, counters);
}

static double differing_colours(void *context, peer_pass *peer) {
    gouraud_pass *p = context;
    sl_counters counters = {{0}};
    size_t differ = 0;
    memset(p->colour, 0, 3 * PIXELS * sizeof *p->colour);
    draw_gouraud(p, 1, &counters);
    peer_clear(peer);
    peer_run_view(peer, 0);
    const float *rgba = peer_plane(peer, 0);
    for (size_t i = 0; i < PIXELS; i++) {
        bool equal = true;
        for (size_t k = 0; k < 3; k++) equal &= fabsf(rgba[4 * i + k] - p->colour[k * PIXELS + i]) <= 2e-2f;
        differ += !equal;
    }
    return (double)differ / PIXELS;
}

static void measure_gouraud(measurer *m, workload *w, const float *xyz, const float *colours, size_t count) {
    bench_scene scene = {.name = w->name};
    bench_scene_of_triangles(&scene, xyz, colours, count);
    gouraud_pass p = {&scene,
                      bench_flat_view(SIDE, SIDE),
                      bench_allocate(PIXELS, sizeof(uint32_t)),
                      bench_allocate(PIXELS, sizeof(float)),
                      bench_allocate(3 * PIXELS, sizeof(float)),
                      bench_allocate(9 * count, sizeof(float))};
    memcpy(p.attributes, colours, 9 * count * sizeof(float));
    w->context = &p;
    w->renders = 1;
    w->ours = draw_gouraud;
    w->differing = differing_colours;
    w->peer = peer_gouraud(&scene.mesh, &p.view);
    measure_row(m, w);
    sl_free(p.id);
    sl_free(p.depth);
    sl_free(p.colour);
    sl_free(p.attributes);
    bench_scene_close(&scene);
}

static void random_colours(float *colours, size_t count, uint64_t key) {
    for (size_t i = 0; i < 9 * count; i++) colours[i] = sl_random_unit(key, i);
}

/* Each triangle covers one half of the screen, cut along a diagonal. Every one is nearer than the one before,
 * so that a depth test alone leaves nothing out; or depths are random at the corners, triangles go through
 * each other, and no order is right. */
typedef enum { NEARING, MIXED } fill_kind;

static void fill(measurer *m, const char *name, fill_kind kind) {
    enum { LAYERS = 100 };
    static const float corner[4][3][2] = {{{-1, -1}, {1, -1}, {1, 1}},
                                          {{-1, -1}, {1, 1}, {-1, 1}},
                                          {{-1, -1}, {1, -1}, {-1, 1}},
                                          {{1, -1}, {1, 1}, {-1, 1}}};
    workload w = {.wanted = wanted_fill, .units = 0.5 * LAYERS * PIXELS, .unit = "pixels"};
    snprintf(w.name, sizeof w.name, "%s", name);
    if (!measure_wants(m, w.name)) return;
    float xyz[9 * LAYERS], colours[9 * LAYERS];
    uint64_t key = sl_random_key(8, 8);
    for (size_t i = 0; i < 3 * LAYERS; i++) {
        size_t t = i / 3;
        xyz[3 * i] = corner[t % 4][i % 3][0];
        xyz[3 * i + 1] = corner[t % 4][i % 3][1];
        xyz[3 * i + 2] =
            kind == NEARING ? 0.9f - 1.8f * (float)t / LAYERS : 1.8f * sl_random_unit(key, i) - 0.9f;
    }
    random_colours(colours, LAYERS, sl_random_key(8, 9));
    measure_gouraud(m, &w, xyz, colours, LAYERS);
}

void bench_fill(measurer *m) {
    fill(m, "Gouraud, 100 x 500K pixels, nearing", NEARING);
    fill(m, "Gouraud, 100 x 500K pixels, mixed", MIXED);
}

/* The bits of n at even places. */
static uint32_t every_second_bit(uint32_t n) {
    n &= 0x55555555u;
    n = (n | n >> 1) & 0x33333333u;
    n = (n | n >> 2) & 0x0f0f0f0fu;
    n = (n | n >> 4) & 0x00ff00ffu;
    return (n | n >> 8) & 0x0000ffffu;
}

/* Right triangles of eight pixels, one near each pixel, in Morton order as a well prepared mesh would have
 * them. */
void bench_small_triangles(measurer *m) {
    enum { COUNT = 1 << 20 };
    workload w = {.name = "Gouraud, 1M triangles of 8 pixels",
                  .wanted = wanted_small,
                  .units = COUNT,
                  .unit = "triangles"};
    if (!measure_wants(m, w.name)) return;
    float *xyz = bench_allocate(9 * (size_t)COUNT, sizeof *xyz),
          *colours = bench_allocate(9 * (size_t)COUNT, sizeof *colours);
    uint64_t key = sl_random_key(8, 10);
    for (uint32_t t = 0; t < COUNT; t++) {
        float x = ((float)every_second_bit(t) + sl_random_unit(key, 8 * t)) * (1000.0f / 1024.0f);
        float y = ((float)every_second_bit(t >> 1) + sl_random_unit(key, 8 * t + 1)) * (1000.0f / 1024.0f);
        uint32_t turn = sl_random_bits(key, 8 * t + 2);
        float dx = turn & 1 ? 4.0f : -4.0f, dy = turn & 2 ? 4.0f : -4.0f;
        const float at[3][2] = {{x, y}, {x + dx, y}, {x, y + dy}};
        for (uint32_t k = 0; k < 3; k++) {
            xyz[9 * t + 3 * k] = at[k][0] * 0.002f - 1.0f;
            xyz[9 * t + 3 * k + 1] = at[k][1] * 0.002f - 1.0f;
            xyz[9 * t + 3 * k + 2] = 1.8f * sl_random_unit(key, 8 * t + 3 + k) - 0.9f;
        }
    }
    random_colours(colours, COUNT, sl_random_key(8, 11));
    measure_gouraud(m, &w, xyz, colours, COUNT);
    sl_free(xyz);
    sl_free(colours);
}

/* ---- reduction ------------------------------------------------------------------------------- */

enum { REDUCED = 256 };

typedef struct reduction_pass {
    float *planes, *scratch, *sums;
    int final;
} reduction_pass;

static void reduce(void *context, unsigned threads, sl_counters *counters) {
    reduction_pass *p = context;
    sl_raster_reduce(p->planes, REDUCED, 4, p->final, p->scratch, p->sums, counters);
}

static double differing_totals(void *context, peer_pass *peer) {
    const reduction_pass *p = context;
    size_t left = (size_t)p->final * (size_t)p->final, differ = 0;
    peer_run(peer, true);
    const float *rgba = peer_plane(peer, 0);
    for (size_t i = 0; i < 4 * left; i++) differ += rgba[i] != p->sums[i % 4 * left + i / 4];
    return (double)differ / (4.0 * (double)left);
}

/* The sums by the processor have another order. */
static double differing_added_up(void *context, peer_pass *peer) {
    const reduction_pass *p = context;
    size_t differ = 0;
    peer_run(peer, true);
    const float *total = peer_plane(peer, 1);
    for (size_t c = 0; c < 4; c++) {
        bool equal = fabsf(total[c] - p->sums[c]) <= 1e-4f * p->sums[c];
        differ += !equal;
    }
    return (double)differ / 4.0;
}

static void measure_reduction(measurer *m, reduction_pass *p, const float *rgba, const char *name,
                              int peer_final) {
    workload w = {.wanted = peer_final ? wanted_reduction : 0.0,
                  .renders = 1,
                  .context = p,
                  .ours = reduce,
                  .alone = true,
                  .differing = peer_final ? differing_totals : differing_added_up};
    snprintf(w.name, sizeof w.name, "%s", name);
    if (!measure_wants(m, name)) return;
    w.peer = peer_reduction(rgba, REDUCED, peer_final);
    measure_row(m, &w);
}

/* The third row is what a program would rather do with OSMesa, whose pbuffer is in the processor's memory
 * anyway. */
void bench_reduction(measurer *m) {
    size_t pixels = (size_t)REDUCED * REDUCED;
    float *rgba = bench_allocate(4 * pixels, sizeof *rgba);
    reduction_pass p = {bench_allocate(4 * pixels, sizeof(float)), bench_allocate(pixels / 2, sizeof(float)),
                        bench_allocate(4 * 16 * 16, sizeof(float)), 16};
    uint64_t key = sl_random_key(8, 12);
    for (size_t i = 0; i < 4 * pixels; i++)
        rgba[i] = p.planes[i % 4 * pixels + i / 4] = sl_random_unit(key, i);
    measure_reduction(m, &p, rgba, "reduction of 256x256 RGBA32F to 16x16", 16);
    p.final = 1;
    measure_reduction(m, &p, rgba, "reduction of 256x256 RGBA32F to 1x1", 1);
    measure_reduction(m, &p, rgba, "reduction to 1x1, OSMesa read and added", 0);
    sl_free(p.planes);
    sl_free(p.scratch);
    sl_free(p.sums);
    sl_free(rgba);
}
