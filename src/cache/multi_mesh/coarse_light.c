/* Direct light on the coarse mesh: at one vertex, at many; and samples that still hold after an edit. */
#include "cache/multi_mesh/coarse.h"

#include <math.h>
#include <string.h>

#include "base/batch.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/light/moves.h"

/* Lights that are not asked could give no more than this share of all light. */
static const double UNASKED = 0.03;

typedef struct light_worker {
    float *share;              /* by light: F */
    double *most;              /* by light: the irradiance that it could give, mean of the channels */
    uint32_t *order;           /* lights that could give any, most first */
} light_worker;

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
static int rays_to(double part, bool quick) {
    const int rays = part > 0.3 ? 12 : part > 0.1 ? 8 : 4;
    return quick ? rays / 4 : rays;
}

/* Where a vertex is asked for light, and what of it is known there. */
typedef struct asked_place {
    const sl_lit_point *point;
    bool quick;
    uint32_t nudge;            /* how often it was moved to be there */
    sl_coarse_share *kept;     /* by light, or NULL */
} asked_place;

enum { NUDGES = 4 };

static float sample_by(const sl_irradiance_settings *c, const asked_place *at, uint32_t light, int rays,
                       sl_counters *counters) {
    const uint32_t by = NUDGES * (uint32_t)rays + at->nudge;
    if (at->kept && at->kept[light].by == by) return at->kept[light].share;
    const float share = sl_light_sample_by_rays(c->sampling, light, at->point, rays, counters);
    if (at->kept) at->kept[light] = (sl_coarse_share){share, by};
    return share;
}

/* F of all lights. Whether any light that could arrive does. */
static bool light_point(const sl_irradiance_settings *c, const asked_place *at, light_worker *w,
                        sl_counters *counters) {
    double all, asked = 0.0, seen = 0.0;
    size_t count = rank_lights(c->lights, at->point, w, &all), i = 0;
    for (; i < count && (i == 0 || asked < (1.0 - UNASKED) * all); i++) {
        uint32_t l = w->order[i];
        double most = (double)w->share[l];
        w->share[l] = sample_by(c, at, l, rays_to(w->most[l] / all, at->quick), counters);
        asked += w->most[l];
        seen += w->most[l] * (double)w->share[l] / most;
    }
    double visible = asked > 0.0 ? fmin(seen / asked, 1.0) : 0.0;
    for (; i < count; i++) w->share[w->order[i]] *= (float)visible;
    return seen > 0.0 || count == 0;
}

/* ---- a vertex ---- */

sl_rgb sl_direct_diffuse(const sl_sampled_lights *lights, const float *share) {
    double sum[3] = {0.0, 0.0, 0.0};
    for (size_t l = 0; l < lights->count; l++) sl_sum_colour(sum, (double)share[l], lights->light[l].colour);
    return sl_sum_over(sum, SL_PI);
}

static sl_mesh_point point_of(const sl_irradiance_settings *c, sl_root_place place, double nudge) {
    double third = SL_PATCH_DYADIC / 3.0;
    sl_root_place x = {place.root, (uint16_t)(place.u + nudge * (third - place.u)),
                       (uint16_t)(place.v + nudge * (third - place.v))};
    sl_mesh_point at = sl_mesh_point_at(c->primitives, x);
    if (at.lit.triangle == SL_NO_INDEX)
        sl_step_inside(c->scene, 5.0 * sl_light_sampling_step(c->sampling), &at);
    return at;
}

/* A vertex that nothing arrives at may lie inside other geometry: then it is asked for a little further
 * inside its face. */
static sl_rgb light_vertex(const sl_irradiance_settings *c, sl_root_place place, bool quick,
                           sl_coarse_share *kept, light_worker *w, sl_counters *counters) {
    static const double nudge[NUDGES] = {0.0, 0.01, 0.05, 0.2};
    uint32_t first = 0; /* where it was found last time */
    for (size_t l = 0; kept && l < c->lights->count; l++)
        first = kept[l].by % NUDGES > first ? kept[l].by % NUDGES : first;
    for (uint32_t i = first; i < NUDGES; i++) {
        sl_mesh_point at = point_of(c, place, nudge[i]);
        if (!light_point(c, &(asked_place){&at.lit, quick, i, kept}, w, counters) &&
            sl_solids_hold(c->primitives->solids, c->tracer, &at.lit, NULL, counters))
            continue;
        return sl_direct_diffuse(c->lights, w->share);
    }
    return sl_grey(NAN);
}

typedef struct lighting {
    const sl_irradiance_settings *light;
    light_worker *worker;
    const sl_root_place *place;
    bool quick;
    sl_coarse_share *kept;
} lighting;

static void light_one(void *context, size_t i, unsigned worker, void *result, sl_counters *counters) {
    const lighting *job = context;
    sl_coarse_share *kept = job->kept ? job->kept + i * job->light->lights->count : NULL;
    light_worker *w = &job->worker[worker];
    *(sl_rgb *)result = light_vertex(job->light, job->place[i], job->quick, kept, w, counters);
}

sl_status sl_coarse_light_take(const sl_irradiance_settings *light, size_t count,
                               const sl_root_place *place, bool quick, sl_coarse_share *kept,
                               sl_rgb *radiance, sl_counters *counters, sl_error *error) {
    size_t lights = light->lights->count, all = lights * light->threads;
    lighting job = {light, sl_allocate(light->threads, sizeof *job.worker), place, quick, kept};
    const sl_batch_plane shares = {kept, lights * sizeof *kept};
    const sl_batch batch = {.count = count, .work = light_one, .context = &job, .results = radiance,
                            .result_bytes = sizeof *radiance, .shared = true, .planes = &shares,
                            .plane_count = kept != NULL};
    double *most = sl_allocate(all, sizeof *most);
    float *share = sl_allocate(all, sizeof *share);
    uint32_t *order = sl_allocate(all, sizeof *order);
    bool room = job.worker && most && share && order;
    for (unsigned t = 0; t < light->threads && room; t++)
        job.worker[t] = (light_worker){share + t * lights, most + t * lights, order + t * lights};
    if (room) sl_batch_run(&batch, light->threads, counters);
    SL_FREE_ALL(job.worker, most, share, order);
    return room ? SL_OK : sl_fail_memory(error, "the coarse mesh's light");
}

/* ---- samples that hold ---- */

void sl_coarse_forget_kept(sl_coarse_kept *kept) {
    sl_free(kept->place);
    sl_free(kept->share);
    sl_sampled_lights_destroy(kept->lights);
    sl_object_places_destroy(kept->places);
    *kept = (sl_coarse_kept){.count = 0};
}

size_t sl_coarse_kept_bytes(const sl_coarse_kept *kept) {
    size_t shares = kept->lights ? kept->lights->count * sizeof *kept->share : 0;
    return kept->count * (sizeof *kept->place + shares);
}

sl_status sl_coarse_keep(const sl_irradiance_settings *light, const sl_coarse *coarse,
                         sl_coarse_share *shares, sl_coarse_kept *kept, sl_error *error) {
    sl_coarse_forget_kept(kept);
    *kept = (sl_coarse_kept){.count = coarse->vertex_count,
                             .place = sl_allocate(coarse->vertex_count, sizeof *kept->place),
                             .share = shares,
                             .scale = light->scene->scale,
                             .step = sl_light_sampling_step(light->sampling)};
    sl_status status = kept->place ? SL_OK : sl_fail_memory(error, "the coarse mesh's light");
    if (status == SL_OK) status = sl_light_places_take(light->scene, &kept->lights, error);
    if (status == SL_OK) status = sl_object_places_take(light->scene, &kept->places, error);
    for (size_t v = 0; status == SL_OK && v < kept->count; v++)
        kept->place[v] = sl_coarse_lit_place(coarse, v);
    if (status != SL_OK) sl_coarse_forget_kept(kept);
    return status;
}

static bool same_place(sl_root_place a, sl_root_place b) {
    return a.root == b.root && a.u == b.u && a.v == b.v;
}

/* Where something has moved a vertex that was asked for further inside its face may be free again. */
static bool vertex_holds(const sl_light_moves *moves, const sl_irradiance_settings *light,
                         sl_root_place place, const sl_coarse_share *share) {
    const double reach = 10.0 * sl_light_sampling_step(light->sampling);
    if (sl_has_triangle_moved(moves, place.root / 2)) return false;
    sl_vec3 point = point_of(light, place, 0.0).lit.position;
    for (size_t l = 0; l < light->lights->count; l++) {
        bool nudged = share[l].by % NUDGES != 0;
        if ((nudged && moves->box_count) || sl_light_may_differ(moves, l, point, reach)) return false;
    }
    return true;
}

typedef struct holding {
    const sl_light_moves *moves;
    const sl_irradiance_settings *light;
    const sl_coarse *coarse;
    const sl_coarse_kept *kept;
    sl_coarse_share *share;
} holding;

enum { VERTICES_A_TASK = 1024 };

static void copy_some(void *context, size_t task, unsigned worker) {
    (void)worker;
    const holding *h = context;
    const size_t lights = h->light->lights->count, end = (task + 1) * VERTICES_A_TASK;
    for (size_t v = task * VERTICES_A_TASK; v < end && v < h->coarse->vertex_count; v++) {
        const sl_root_place place = sl_coarse_lit_place(h->coarse, v);
        const sl_coarse_share *share = h->kept->share + v * lights;
        if (same_place(place, h->kept->place[v]) && vertex_holds(h->moves, h->light, place, share))
            memcpy(h->share + v * lights, share, lights * sizeof *share);
    }
}

sl_status sl_coarse_shares_that_hold(const sl_coarse_kept *kept, const sl_irradiance_settings *light,
                                     const sl_object_places *places, const sl_coarse *coarse,
                                     sl_coarse_share *shares, sl_error *error) {
    sl_light_moves *moves;
    bool same = kept->count == coarse->vertex_count && kept->scale == light->scene->scale &&
                kept->step == sl_light_sampling_step(light->sampling);
    if (!same) return SL_OK;
    sl_status status = sl_light_moves_find(light->scene, kept->places, places, kept->lights, light->lights,
                                           &moves, error);
    if (status != SL_OK || !moves) return status;
    holding h = {moves, light, coarse, kept, shares};
    sl_parallel_for(light->threads, (kept->count + VERTICES_A_TASK - 1) / VERTICES_A_TASK, copy_some, &h);
    sl_light_moves_destroy(moves);
    return SL_OK;
}
