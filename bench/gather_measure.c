/* Scenes, points, references, and clocks. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/random.h"
#include "gather_bench.h"
#include "timing.h"

const int gather_sizes[SIZES] = {16, 32, 64, 128, 256};

void bench_stop(const char *what, const sl_error *error) {
    fprintf(stderr, "bench_gather: %s: %s\n", what, error->message);
    exit(1);
}

/* ---- scenes ---- */

/* Random directions through the film; every hit is a point, with the normals turned to the camera. */
static void choose_points(bench *b, size_t points) {
    const sl_camera *c = &b->scene->camera;
    float tangent = (float)sl_tan(0.5 * (double)c->vertical_fov);
    float aspect = (float)b->scene->film_width / (float)b->scene->film_height;
    uint64_t key = sl_random_key(1, 2);
    b->count = 0;
    for (uint64_t i = 0; i < 20 * points && b->count < points; i++) {
        float x = (2.0f * sl_random_unit(key, 2 * i) - 1.0f) * tangent * aspect;
        float y = (2.0f * sl_random_unit(key, 2 * i + 1) - 1.0f) * tangent;
        sl_vec3 d = sl_sub(sl_mad(sl_scale(c->right, x), y, c->up), c->back);
        sl_ray16 rays = {.origin_x = {c->eye.x}, .origin_y = {c->eye.y}, .origin_z = {c->eye.z}, .direction_x = {d.x},
                         .direction_y = {d.y}, .direction_z = {d.z}, .far = {INFINITY}, .skip = {SL_NO_INDEX}};
        sl_hit16 hits;
        sl_trace(b->tracer, &rays, 1, false, &hits, &b->counters);
        if (hits.triangle[0] == SL_NO_INDEX) continue;
        sl_surface s;
        sl_scene_surface(b->scene, hits.triangle[0], hits.w1[0], hits.w2[0], sl_neg(d), &s);
        b->points[b->count++] = (sl_gather_point){.position = s.position, .geometric_normal = s.geometric_normal,
                                                  .normal = s.normal, .triangle = hits.triangle[0], .key = sl_hash64(i)};
    }
}

void bench_open(bench *b, const char *path, size_t points) {
    sl_error error;
    if (sl_scene_load_with(path, &(sl_load_options){.allow_outside = true}, &b->scene, &error) != SL_OK) bench_stop(path, &error);
    if (sl_raster_create(b->scene, 1, &b->raster, &error) != SL_OK) bench_stop("rasterizer", &error);
    if (sl_tracer_create(b->scene, 1, NULL, &b->tracer, &error) != SL_OK) bench_stop("tracer", &error);
    choose_points(b, points);
}

void bench_close(bench *b) {
    sl_tracer_destroy(b->tracer);
    sl_raster_destroy(b->raster);
    sl_scene_destroy(b->scene);
}

/* ---- errors ---- */

double bench_relative_rms(const bench *b, double *excluded) {
    double mean = 0, sum = 0, used = 0;
    for (size_t i = 0; i < b->count; i++) mean += (double)sl_rgb_mean(b->reference[i].value) / (double)b->count;
    for (size_t i = 0; i < b->count; i++) {
        const float *x = &b->result[i].value.r, *r = &b->reference[i].value.r;
        for (int c = 0; c < 3; c++) {
            if (!((double)r[c] > 1e-3 * mean)) continue;
            double error = ((double)x[c] - (double)r[c]) / (double)r[c];
            sum += error * error;
            used++;
        }
    }
    if (excluded) *excluded = 1.0 - used / (3.0 * (double)b->count);
    return used > 0 ? sqrt(sum / used) : 0.0;
}

typedef struct instrument {
    sl_gather *gather;
    sl_gather_scratch *scratch;
} instrument;

static instrument make(bench *b, sl_gather_kind kind, int size) {
    sl_gather_settings s = sl_gather_defaults();
    instrument m;
    sl_error error;
    s.kind = kind;
    s.size = size;
    s.direct = SL_DIRECT_RAYS;
    if (sl_gather_create(b->scene, b->raster, b->tracer, &s, 1, &m.gather, &b->counters, &error) != SL_OK) bench_stop("gather", &error);
    if (sl_gather_scratch_create(m.gather, &m.scratch, &error) != SL_OK) bench_stop("scratch", &error);
    return m;
}

static void drop(instrument *m) {
    sl_gather_scratch_destroy(m->scratch);
    sl_gather_destroy(m->gather);
}

/* With keys of its own, or what is measured against it at 256 x 256 would be it. */
static void gather_all(bench *b, const instrument *m, uint64_t key, sl_irradiance *out) {
    for (size_t i = 0; i < b->count; i++) {
        sl_gather_point point = b->points[i];
        if (key) point.key = sl_hash64(point.key + key);
        sl_gather_irradiance(m->gather, &point, m->scratch, &out[i], &b->counters);
    }
}

double bench_reference(bench *b) {
    instrument m = make(b, SL_GATHER_RAYS, 256);
    gather_all(b, &m, 77, b->reference);
    gather_all(b, &m, 78, b->result);
    double left = 0.5 * bench_relative_rms(b, NULL);
    for (size_t i = 0; i < b->count; i++) {
        sl_irradiance *r = &b->reference[i], *x = &b->result[i];
        r->value = sl_rgb_scale(sl_rgb_add(r->value, x->value), 0.5f);
        for (int c = 0; c < 3; c++) r->translational[c] = sl_scale(sl_add(r->translational[c], x->translational[c]), 0.5f);
    }
    drop(&m);
    return left;
}

/* ---- rows ---- */

enum { TURNS_MAX = 7, ROWS = 6 };

/* The instruments take turns, so that whatever else the machine does disturbs them alike; the least time of all turns counts. */
static void measure_rows(bench *b, gather_row *rows[ROWS], int count, int turns) {
    instrument m[ROWS];
    for (int i = 0; i < count; i++) {
        m[i] = make(b, rows[i]->kind, rows[i]->size);
        rows[i]->see_ms = rows[i]->gather_ms = INFINITY;
    }
    for (int turn = 0; turn < turns; turn++) {
        for (int i = 0; i < count; i++) {
            double start = now_ms();
            for (size_t k = 0; k < b->count; k++) sl_gather_see(m[i].gather, &b->points[k], m[i].scratch, &b->counters);
            double middle = now_ms();
            gather_all(b, &m[i], 0, b->result);
            rows[i]->see_ms = fmin(rows[i]->see_ms, (middle - start) / (double)b->count);
            rows[i]->gather_ms = fmin(rows[i]->gather_ms, (now_ms() - middle) / (double)b->count);
            if (turn == 0) rows[i]->rms = bench_relative_rms(b, NULL);
        }
    }
    for (int i = 0; i < count; i++) {
        sl_error error;
        if (sl_gather_probe(m[i].gather, rows[i]->kind, rows[i]->size, &rows[i]->counts, &error) != SL_OK) bench_stop("probe", &error);
        drop(&m[i]);
    }
}

static int turns_at(int size) { return size <= 32 ? TURNS_MAX : size <= 64 ? 4 : 2; }

void gather_measure(bench *b, const char *name, gather_case cases[SIZES]) {
    for (int i = 0; i < SIZES; i++) {
        gather_case *c = &cases[i];
        gather_row *rows[ROWS];
        int count = 0;
        *c = (gather_case){.scene = name, .size = gather_sizes[i]};
        for (int kind = 1; kind < 4; kind++) {
            c->at_size[kind] = (gather_row){.kind = (sl_gather_kind)kind, .size = c->size};
            rows[count++] = &c->at_size[kind];
        }
        sl_gather_settings s = sl_gather_defaults();
        for (int kind = 1; kind < 3; kind++) {
            int size = sl_gather_size_for((sl_gather_kind)kind, c->size, sl_tan(0.5 * (double)s.plane_fov));
            c->as_good[kind] = (gather_row){.kind = (sl_gather_kind)kind, .size = size};
            if (size) rows[count++] = &c->as_good[kind];
        }
        measure_rows(b, rows, count, turns_at(c->size));
        c->as_good[SL_GATHER_RAYS] = c->at_size[SL_GATHER_RAYS];
        instrument m = make(b, SL_GATHER_AUTO, c->size);
        c->choice = sl_gather_kind_used(m.gather);
        drop(&m);
    }
}
