/* Gathers on trial teach which light sources are visible where: from points that the scene's camera sees,
 * then from what those gathers saw. Every light sample of theirs is a test of one source from one place. */
#include <stdlib.h>
#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/random.h"
#include "cache/hemisphere/light_scratch.h"

enum { ACROSS = 12, FIRST_POINTS = ACROSS * ACROSS, POINTS = 2 * FIRST_POINTS, SIZE = 16, WORKERS_MAX = 64 };

typedef struct trials {
    sl_gather gather; /* the caller's, with small rays and tables of its own */
    unsigned workers;
    sl_gather_scratch *scratch[WORKERS_MAX];
    sl_counters counters[WORKERS_MAX];
    size_t points, first, per_point;
    sl_gather_point point[POINTS];
    size_t count[POINTS];
    sl_light_trial *trial; /* per_point for each point */
} trials;

/* ---- points ---- */

/* One in each of ACROSS x ACROSS parts of the camera's picture. */
static void see_points(trials *t) {
    const sl_scene *scene = t->gather.scene;
    const sl_camera *c = &scene->camera;
    float tangent = (float)sl_tan(0.5 * (double)c->vertical_fov);
    float aspect = scene->film_height > 0 ? (float)scene->film_width / (float)scene->film_height : 1.0f;
    uint64_t key = sl_random_key(t->gather.settings.seed, 5);
    for (uint32_t i = 0; i < FIRST_POINTS; i++) {
        float x = 2.0f * ((float)(i % ACROSS) + sl_random_unit(key, 2 * i)) / (float)ACROSS - 1.0f;
        float y = 2.0f * ((float)(i / ACROSS) + sl_random_unit(key, 2 * i + 1)) / (float)ACROSS - 1.0f;
        sl_vec3 d = sl_sub(sl_mad(sl_scale(c->right, x * tangent * aspect), y * tangent, c->up), c->back);
        sl_ray16 rays = {.origin_x = {c->eye.x},
                         .origin_y = {c->eye.y},
                         .origin_z = {c->eye.z},
                         .direction_x = {d.x},
                         .direction_y = {d.y},
                         .direction_z = {d.z},
                         .far = {INFINITY},
                         .skip = {SL_NO_INDEX}};
        sl_hit16 hits;
        sl_trace(t->gather.tracer, &rays, 1, false, &hits, &t->counters[0]);
        if (hits.triangle[0] == SL_NO_INDEX) continue;
        sl_surface s;
        sl_scene_surface(scene, hits.triangle[0], hits.w1[0], hits.w2[0], sl_neg(d), &s);
        t->point[t->points++] = (sl_gather_point){.position = s.position,
                                                  .geometric_normal = s.geometric_normal,
                                                  .normal = s.normal,
                                                  .triangle = hits.triangle[0],
                                                  .key = sl_hash64(key + i)};
    }
}

/* What the first gathers saw, one for each of them. */
static void follow_points(trials *t) {
    size_t first = t->points;
    for (size_t i = 0; i < first; i++) {
        if (t->count[i] == 0) continue;
        const sl_light_trial *seen = &t->trial[i * t->per_point + sl_hash64(i) % t->count[i]];
        t->point[t->points++] = (sl_gather_point){.position = seen->position,
                                                  .geometric_normal = seen->normal,
                                                  .normal = seen->normal,
                                                  .triangle = SL_NO_INDEX,
                                                  .key = sl_hash64(t->point[i].key)};
    }
}

/* ---- gathers ---- */

static void try_point(void *context, size_t index, unsigned worker) {
    trials *t = context;
    size_t i = t->first + index;
    sl_irradiance unused;
    sl_counters *counters = &t->counters[worker];
    sl_gather_irradiance(&t->gather, &t->point[i], t->scratch[worker], &unused, counters);
    const sl_gather_hits *h = &t->scratch[worker]->hits;
    const sl_light_scratch *s = t->scratch[worker]->light;
    sl_light_trial *to = t->trial + i * t->per_point;
    for (size_t m = 0; m < s->samples && m < t->per_point; m++) {
        uint32_t k = s->sample_slot[m];
        to[t->count[i]++] = (sl_light_trial){{h->position_x[k], h->position_y[k], h->position_z[k]},
                                             {h->geometric_x[k], h->geometric_y[k], h->geometric_z[k]},
                                             (uint16_t)s->sample_source[m], s->arrived[m]};
    }
}

static void try_points(trials *t) {
    size_t count = t->points - t->first;
    sl_parallel_for(t->workers, count, try_point, t);
    t->first = t->points;
}

static sl_status prepare(trials *t, sl_error *error) {
    sl_gather *g = &t->gather;
    g->settings.kind = SL_GATHER_RAYS;
    g->settings.size = SIZE;
    g->settings.hit_samples = 1;
    g->settings.more_rays = 0.0f;
    g->settings.second = NULL;
    t->per_point = SIZE * SIZE + 2;
    sl_status status = sl_gather_tables_create(SL_GATHER_RAYS, SIZE, (double)g->half_tangent,
                                               g->settings.border, &g->tables, error);
    for (unsigned w = 0; status == SL_OK && w < t->workers; w++) {
        status = sl_gather_scratch_create(g, &t->scratch[w], error);
        if (status != SL_OK) break;
        sl_light_scratch_destroy(t->scratch[w]->light);
        t->scratch[w]->light = NULL;
        status = sl_light_scratch_create(g, g->tables->padded, true, &t->scratch[w]->light, error);
    }
    t->trial = sl_allocate(POINTS * t->per_point, sizeof *t->trial);
    return status == SL_OK && !t->trial ? sl_fail_memory(error, "light trials") : status;
}

/* Closes the gaps between the points' trials. */
static size_t compact(trials *t) {
    size_t count = 0;
    for (size_t i = 0; i < t->points; i++) {
        memmove(t->trial + count, t->trial + i * t->per_point, t->count[i] * sizeof *t->trial);
        count += t->count[i];
    }
    return count;
}

static sl_status learn(sl_gather *gather, trials *t, sl_counters *counters, sl_error *error) {
    see_points(t);
    try_points(t);
    follow_points(t);
    try_points(t);
    for (unsigned w = 0; w < t->workers; w++) {
        sl_count(counters, SL_COUNT_RAYS, t->counters[w].value[SL_COUNT_RAYS]);
        sl_count(counters, SL_COUNT_SHADOW_RAYS, t->counters[w].value[SL_COUNT_SHADOW_RAYS]);
    }
    sl_visible_lights *learnt;
    sl_status status = sl_visible_lights_create(gather->sources, t->trial, compact(t), &learnt, error);
    if (status != SL_OK) return status;
    sl_visible_lights_destroy(gather->visible);
    gather->visible = learnt;
    return SL_OK;
}

sl_status sl_gather_learn_lights(sl_gather *gather, unsigned threads, sl_counters *counters,
                                 sl_error *error) {
    sl_status status = sl_visible_lights_create(gather->sources, NULL, 0, &gather->visible, error);
    if (status != SL_OK) return status;
    trials *t = sl_allocate(1, sizeof *t);
    if (!t) return sl_fail_memory(error, "light trials");
    t->gather = *gather;
    t->workers = sl_thread_count(threads);
    if (t->workers > WORKERS_MAX) t->workers = WORKERS_MAX;
    status = prepare(t, error);
    if (status == SL_OK) status = learn(gather, t, counters, error);
    for (unsigned w = 0; w < t->workers; w++) sl_gather_scratch_destroy(t->scratch[w]);
    sl_gather_tables_destroy(t->gather.tables);
    sl_free(t->trial);
    sl_free(t);
    return status;
}
