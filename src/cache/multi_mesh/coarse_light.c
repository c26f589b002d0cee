#include "cache/multi_mesh/coarse.h"

#include <math.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/multi_mesh/direct.h"
#include "cache/multi_mesh/irradiance.h"
#include "cache/multi_mesh/lit_points.h"

enum { VERTICES_A_TASK = 8 };
/* Lights that are not asked could give no more than this share of all light. */
static const double UNASKED = 0.03;

typedef struct light_worker {
    sl_counters counters;
    float *share;              /* by light: F */
    double *most;              /* by light: the irradiance that it could give, mean of the channels */
    uint32_t *order;           /* lights that could give any, most first */
} light_worker;

struct sl_coarse_light {
    sl_coarse_light_settings settings;
    light_worker *worker;
};

/* ---- a point ---- */

/* Sorts the lights that could give any; returns how many, and what all of them could give. */
static size_t rank_lights(const sl_sampled_lights *lights, const sl_lit_point *point, light_worker *w,
                          double *all) {
    size_t count = 0;
    *all = 0.0;
    for (uint32_t l = 0; l < lights->count; l++) {
        double share = sl_light_unoccluded(&lights->light[l], point),
               most = share * (double)sl_rgb_mean(lights->light[l].colour);
        w->share[l] = (float)share;
        w->most[l] = most;
        if (!(most > 0.0 && most <= DBL_MAX)) {
            w->share[l] = 0.0f;
            continue;
        }
        *all += most;
        size_t at = count++;
        for (; at > 0 && w->most[w->order[at - 1]] < most; at--) w->order[at] = w->order[at - 1];
        w->order[at] = l;
    }
    return count;
}

/* n of n x n rays, by the part of all that lights could give that this one could. */
static int rays_to(double part) { return part > 0.3 ? 12 : part > 0.1 ? 8 : 4; }

/* F of all lights. Whether any light that could arrive does. */
static bool light_point(const sl_coarse_light *c, const sl_lit_point *point, light_worker *w) {
    double all, asked = 0.0, seen = 0.0;
    size_t count = rank_lights(c->settings.lights, point, w, &all), i = 0;
    for (; i < count && (i == 0 || asked < (1.0 - UNASKED) * all); i++) {
        uint32_t l = w->order[i];
        double most = (double)w->share[l];
        w->share[l] =
            sl_light_sample_by_rays(c->settings.sampling, l, point, rays_to(w->most[l] / all), &w->counters);
        asked += w->most[l];
        seen += w->most[l] * (double)w->share[l] / most;
    }
    double visible = asked > 0.0 ? fmin(seen / asked, 1.0) : 0.0;
    for (; i < count; i++) w->share[w->order[i]] *= (float)visible;
    return seen > 0.0 || count == 0;
}

/* ---- a vertex ---- */

static sl_mesh_point point_of(const sl_coarse_light *c, const sl_coarse_vertex *v, double nudge) {
    double third = SL_MESH_DYADIC / 3.0;
    sl_face_point x = {.face = v->face,
                       .p = (uint16_t)(v->lit_p + nudge * (third - v->lit_p)),
                       .q = (uint16_t)(v->lit_q + nudge * (third - v->lit_q))};
    sl_mesh_point at = sl_face_point_in_world(c->settings.primitives, &x);
    if (at.triangle == SL_NO_INDEX)
        sl_step_inside(c->settings.scene, 5.0 * sl_light_sampling_step(c->settings.sampling), &at);
    return at;
}

/* A vertex that nothing arrives at may lie inside other geometry: then it is asked for a little further
 * inside its face. */
static sl_rgb light_vertex(const sl_coarse_light *c, const sl_coarse_vertex *v, light_worker *w) {
    static const double nudge[] = {0.0, 0.01, 0.05, 0.2};
    const sl_coarse_light_settings *s = &c->settings;
    for (size_t i = 0; i < sizeof nudge / sizeof nudge[0]; i++) {
        sl_mesh_point at = point_of(c, v, nudge[i]);
        sl_lit_point point = sl_lit_point_of(&at);
        if (!light_point(c, &point, w) && sl_mesh_point_in_solid(s->primitives, s->tracer, &at, &w->counters))
            continue;
        return sl_direct_diffuse(s->lights, w->share);
    }
    return sl_grey(NAN);
}

typedef struct lighting {
    const sl_coarse_light *light;
    size_t count;
    const sl_coarse_vertex *vertex;
    sl_rgb *radiance;
} lighting;

static void light_some(void *context, size_t task, unsigned worker) {
    const lighting *job = context;
    size_t end = (task + 1) * VERTICES_A_TASK < job->count ? (task + 1) * VERTICES_A_TASK : job->count;
    for (size_t i = task * VERTICES_A_TASK; i < end; i++)
        job->radiance[i] = light_vertex(job->light, &job->vertex[i], &job->light->worker[worker]);
}

void sl_coarse_light_take(sl_coarse_light *c, size_t count, const sl_coarse_vertex *vertex, sl_rgb *radiance,
                          sl_counters *counters) {
    lighting job = {c, count, vertex, radiance};
    sl_parallel_for(c->settings.threads, (count + VERTICES_A_TASK - 1) / VERTICES_A_TASK, light_some, &job);
    for (unsigned t = 0; t < c->settings.threads; t++) {
        sl_counters_add(counters, &c->worker[t].counters);
        c->worker[t].counters = (sl_counters){{0}};
    }
}

/* ---- life ---- */

static sl_status make_worker(const sl_coarse_light *c, light_worker *w, sl_error *error) {
    size_t lights = c->settings.lights->count;
    w->share = sl_allocate(lights, sizeof *w->share);
    w->most = sl_allocate(lights, sizeof *w->most);
    w->order = sl_allocate(lights, sizeof *w->order);
    return w->share && w->most && w->order ? SL_OK : sl_fail_memory(error, "the coarse mesh's light");
}

sl_status sl_coarse_light_create(const sl_coarse_light_settings *settings, sl_coarse_light **light,
                                 sl_error *error) {
    *light = NULL;
    sl_coarse_light *c = sl_allocate(1, sizeof *c);
    if (!c) return sl_fail_memory(error, "the coarse mesh's light");
    c->settings = *settings;
    c->worker = sl_allocate(settings->threads, sizeof *c->worker);
    sl_status status = c->worker ? SL_OK : sl_fail_memory(error, "the coarse mesh's light");
    for (unsigned t = 0; t < settings->threads && status == SL_OK; t++)
        status = make_worker(c, &c->worker[t], error);
    if (status == SL_OK) *light = c;
    else sl_coarse_light_destroy(c);
    return status;
}

void sl_coarse_light_destroy(sl_coarse_light *c) {
    if (!c) return;
    for (unsigned t = 0; c->worker && t < c->settings.threads; t++) {
        sl_free(c->worker[t].share);
        sl_free(c->worker[t].most);
        sl_free(c->worker[t].order);
    }
    sl_free(c->worker);
    sl_free(c);
}

size_t sl_coarse_light_memory_bytes(const sl_coarse_light *c) {
    size_t by_light = sizeof *c->worker->share + sizeof *c->worker->most + sizeof *c->worker->order;
    return sizeof *c + c->settings.threads * (sizeof *c->worker + c->settings.lights->count * by_light);
}
