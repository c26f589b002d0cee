/* Pixels lit from the atlas: a pixel costs two dot products with its position and one look-up on the side
 * that it shows, where the octree costs a descent for each of eight voxels. */
#include "cache/light_octree/atlas/bake.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"

enum { BATCH = SL_TEXTURE_BLOCK };

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

sl_atlas_side sl_atlas_side_seen(const sl_scene *scene, const sl_gbuffer *g, size_t pixel) {
    sl_vec3 seen = sl_v3(g->geometric_x[pixel], g->geometric_y[pixel], g->geometric_z[pixel]);
    return sl_dot(seen, sl_scene_geometric_normal(scene, g->id[pixel])) < 0.0f ? SL_ATLAS_BACK
                                                                               : SL_ATLAS_FRONT;
}

static void apply_row(void *context, size_t row, unsigned worker) {
    const application *a = context;
    const sl_gbuffer *g = a->gbuffer;
    look_ups l = {.count = 0};
    uint32_t last = SL_NO_INDEX;
    const sl_atlas_chart *chart = NULL;
    bool lit = false;
    for (size_t i = row * (size_t)g->width; i < (row + 1) * (size_t)g->width; i++) {
        for (int k = 0; k < 3; k++) a->out[k][i] = 0.0f;
        if (g->material[i] == SL_NO_INDEX) continue;
        if (g->id[i] != last) { /* a triangle shows one side to a view */
            last = g->id[i];
            chart = &a->canvas->atlas->chart[a->canvas->atlas->chart_of[last]];
            sl_atlas_side side = sl_atlas_side_seen(a->scene, g, i);
            lit = a->canvas->side[side] && !sl_material_is_mirror(&a->scene->materials[g->material[i]]);
            if (lit && side != l.side && l.count > 0) look_up(a, &l);
            if (lit) l.side = side;
        }
        if (!lit) continue;
        sl_atlas_point(chart, sl_v3(g->position_x[i], g->position_y[i], g->position_z[i]), &l.s[l.count],
                       &l.t[l.count]);
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
