/* Pass R2: pixels lit from the atlas. A triangle's way into the atlas is an affine map, worked out once, so
 * that a pixel costs two dot products with its position, and one look-up on the side that it shows; where the
 * octree costs a descent for each of eight voxels. */
#include "cache/light_octree/atlas/bake.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

enum { TRIANGLES_A_TASK = 4096, BATCH = SL_TEXTURE_BLOCK };

/* A map that enlarges so many times more than the atlas as a whole is a sliver's, and noise. */
static const double most_stretch = 64.0;

/* ---- maps ---- */

typedef struct map_task {
    const sl_atlas *atlas;
    const sl_scene *scene;
    sl_atlas_map *map;
} map_task;

static sl_vec3d corner_of(const sl_scene *scene, int k, size_t t) {
    return sl_to_double(sl_scene_position(scene, scene->vertex[k][t]));
}

/* With edges e1 and e2 and n = e1 x e2 the weights of corners 1 and 2 grow along e2 x n / n^2 and n x e1 /
 * n^2. */
static sl_atlas_map map_of(const map_task *task, size_t t) {
    const float *c = task->atlas->coordinates + 6 * t;
    sl_vec3d a = corner_of(task->scene, 0, t), e1 = sl_subd(corner_of(task->scene, 1, t), a),
             e2 = sl_subd(corner_of(task->scene, 2, t), a);
    sl_vec3d n = sl_crossd(e1, e2), w1 = sl_crossd(e2, n), w2 = sl_crossd(n, e1);
    double square = sl_dotd(n, n),
           most = most_stretch * task->atlas->texels_per_unit / (double)task->atlas->size;
    sl_atlas_map map = {.centre = sl_to_float(sl_addd(a, sl_scaled(sl_addd(e1, e2), 1.0 / 3.0)))};
    for (int k = 0; k < 2; k++) {
        double from = (double)c[k], by1 = (double)c[2 + k] - from, by2 = (double)c[4 + k] - from;
        sl_vec3d along =
            sl_scaled(sl_addd(sl_scaled(w1, by1), sl_scaled(w2, by2)), square > 0.0 ? 1.0 / square : 0.0);
        map.at[k] = (float)(from + (by1 + by2) / 3.0);
        map.along[k] = sl_lengthd(along) <= most ? sl_to_float(along) : sl_v3(0.0f, 0.0f, 0.0f);
    }
    return map;
}

static void map_triangles(void *context, size_t index, unsigned worker) {
    (void)worker;
    const map_task *task = context;
    size_t first = index * TRIANGLES_A_TASK, count = task->scene->triangle_count;
    for (size_t t = first; t < first + TRIANGLES_A_TASK && t < count; t++) task->map[t] = map_of(task, t);
}

sl_status sl_atlas_maps_create(const sl_atlas *atlas, const sl_scene *scene, unsigned threads,
                               sl_atlas_map **maps, sl_error *error) {
    map_task task = {atlas, scene, sl_allocate(scene->triangle_count, sizeof *task.map)};
    if (!task.map) return sl_fail_memory(error, "the maps of an atlas");
    sl_parallel_for(sl_thread_count(threads),
                    (scene->triangle_count + TRIANGLES_A_TASK - 1) / TRIANGLES_A_TASK, map_triangles, &task);
    *maps = task.map;
    return SL_OK;
}

/* ---- pixels ---- */

typedef struct application {
    const sl_atlas_canvas *canvas;
    const sl_gbuffer *gbuffer;
    const sl_scene *scene;
    float *out[3];
    uint64_t *fetches; /* of each worker, a cache line apart */
} application;

enum { LINE = 8 };

/* Pixels that wait for their look-up, all on one side. */
typedef struct look_ups {
    sl_atlas_side side;
    size_t count;
    size_t pixel[BATCH];
    float s[BATCH], t[BATCH];
} look_ups;

static void look_up(const application *a, look_ups *l) {
    const sl_gbuffer *g = a->gbuffer;
    const float *const kd[3] = {g->diffuse_r, g->diffuse_g, g->diffuse_b};
    float irradiance[3][BATCH];
    float *const plane[4] = {irradiance[0], irradiance[1], irradiance[2], NULL};
    sl_texture_sample_many(a->canvas->side[l->side], l->count, l->s, l->t, NULL, plane);
    for (int k = 0; k < 3; k++) {
        for (size_t n = 0; n < l->count; n++)
            a->out[k][l->pixel[n]] = kd[k][l->pixel[n]] * (float)(1.0 / SL_PI) * irradiance[k][n];
    }
    l->count = 0;
}

static sl_atlas_side side_of(const application *a, const sl_atlas_map *map, size_t pixel) {
    const sl_gbuffer *g = a->gbuffer;
    sl_vec3 front = sl_cross(map->along[0], map->along[1]),
            seen = sl_v3(g->geometric_x[pixel], g->geometric_y[pixel], g->geometric_z[pixel]);
    /* a sliver */
    if (!(sl_dot(front, front) > 0.0f)) front = sl_scene_geometric_normal(a->scene, g->id[pixel]);
    return sl_dot(front, seen) < 0.0f ? SL_ATLAS_BACK : SL_ATLAS_FRONT;
}

static void apply_row(void *context, size_t row, unsigned worker) {
    const application *a = context;
    const sl_gbuffer *g = a->gbuffer;
    look_ups l = {.count = 0};
    uint32_t last = SL_NO_INDEX;
    sl_atlas_map map = {.at = {0.0f, 0.0f}};
    bool lit = false;
    for (size_t i = row * (size_t)g->width; i < (row + 1) * (size_t)g->width; i++) {
        for (int k = 0; k < 3; k++) a->out[k][i] = 0.0f;
        if (g->material[i] == SL_NO_INDEX) continue;
        if (g->id[i] != last) { /* a triangle shows one side to a view */
            last = g->id[i];
            map = a->canvas->map[last];
            sl_atlas_side side = side_of(a, &map, i);
            lit = a->canvas->side[side] && !sl_material_is_mirror(&a->scene->materials[g->material[i]]);
            if (lit && side != l.side && l.count > 0) look_up(a, &l);
            if (lit) l.side = side;
        }
        if (!lit) continue;
        sl_vec3 p = sl_sub(sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]), map.centre);
        l.s[l.count] = map.at[0] + sl_dot(map.along[0], p);
        l.t[l.count] = map.at[1] + sl_dot(map.along[1], p);
        l.pixel[l.count++] = i;
        a->fetches[worker * LINE]++;
        if (l.count == BATCH) look_up(a, &l);
    }
    if (l.count > 0) look_up(a, &l);
}

sl_status sl_atlas_apply(const sl_atlas_canvas *canvas, const sl_gbuffer *gbuffer, const sl_scene *scene,
                         unsigned threads, float *r, float *g, float *b, sl_counters *counters,
                         sl_error *error) {
    threads = sl_thread_count(threads);
    application a = {
        canvas, gbuffer, scene, {r, g, b}, sl_allocate((size_t)threads * LINE, sizeof *a.fetches)};
    if (!a.fetches) return sl_fail_memory(error, "an atlas's look-ups");
    sl_parallel_for(threads, (size_t)gbuffer->height, apply_row, &a);
    for (unsigned t = 0; t < threads; t++) {
        sl_count(counters, SL_COUNT_TEXTURE_FETCHES, a.fetches[t * LINE]); /* one a pixel */
        sl_count(counters, SL_COUNT_FRAGMENTS_SHADED, a.fetches[t * LINE]);
    }
    sl_free(a.fetches);
    return SL_OK;
}
