/* Light on the coarse mesh: at one vertex, at many; and the rounds in which all of them get it. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <math.h>

#include "base/batch.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/multi_mesh/coarse.h"
#include "cache/multi_mesh/direct.h"
#include "cache/patches/irradiance.h"

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
static int rays_to(double part) { return part > 0.3 ? 12 : part > 0.1 ? 8 : 4; }

/* Where a vertex is asked for light, and what of it is known there. */
typedef struct asked_place {
    const sl_lit_point *point;
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
        w->share[l] = sample_by(c, at, l, rays_to(w->most[l] / all), counters);
        asked += w->most[l];
        seen += w->most[l] * (double)w->share[l] / most;
    }
    double visible = asked > 0.0 ? fmin(seen / asked, 1.0) : 0.0;
    for (; i < count; i++) w->share[w->order[i]] *= (float)visible;
    return seen > 0.0 || count == 0;
}

/* ---- a vertex ---- */

static sl_mesh_point point_of(const sl_irradiance_settings *c, const sl_coarse_vertex *v, double nudge) {
    double third = SL_PATCH_DYADIC / 3.0;
    sl_root_place x = {v->face, (uint16_t)(v->lit_p + nudge * (third - v->lit_p)),
                       (uint16_t)(v->lit_q + nudge * (third - v->lit_q))};
    sl_mesh_point at = sl_mesh_point_at(c->primitives, x);
    if (at.lit.triangle == SL_NO_INDEX)
        sl_step_inside(c->scene, 5.0 * sl_light_sampling_step(c->sampling), &at);
    return at;
}

/* A vertex that nothing arrives at may lie inside other geometry: then it is asked for a little further
 * inside its face. */
static sl_rgb light_vertex(const sl_irradiance_settings *c, const sl_coarse_vertex *v, sl_coarse_share *kept,
                           light_worker *w, sl_counters *counters) {
    static const double nudge[NUDGES] = {0.0, 0.01, 0.05, 0.2};
    uint32_t first = 0; /* where it was found last time */
    for (size_t l = 0; kept && l < c->lights->count; l++)
        first = kept[l].by % NUDGES > first ? kept[l].by % NUDGES : first;
    for (uint32_t i = first; i < NUDGES; i++) {
        sl_mesh_point at = point_of(c, v, nudge[i]);
        if (!light_point(c, &(asked_place){&at.lit, i, kept}, w, counters) &&
            sl_point_in_solid(c->primitives, c->tracer, NULL, &at.lit, counters))
            continue;
        return sl_direct_diffuse(c->lights, w->share);
    }
    return sl_grey(NAN);
}

typedef struct lighting {
    const sl_irradiance_settings *light;
    light_worker *worker;
    const sl_coarse_vertex *vertex;
    sl_coarse_share *kept;
} lighting;

static void light_one(void *context, size_t i, unsigned worker, void *result, sl_counters *counters) {
    const lighting *job = context;
    sl_coarse_share *kept = job->kept ? job->kept + i * job->light->lights->count : NULL;
    *(sl_rgb *)result = light_vertex(job->light, &job->vertex[i], kept, &job->worker[worker], counters);
}

sl_status sl_coarse_light_take(const sl_irradiance_settings *light, size_t count,
                               const sl_coarse_vertex *vertex, sl_coarse_share *kept, sl_rgb *radiance,
                               sl_counters *counters, sl_error *error) {
    size_t lights = light->lights->count, all = lights * light->threads;
    lighting job = {light, sl_allocate(light->threads, sizeof *job.worker), vertex, kept};
    const sl_batch batch = {count, light_one, &job, radiance, sizeof *radiance};
    double *most = sl_allocate(all, sizeof *most);
    float *share = sl_allocate(all, sizeof *share);
    uint32_t *order = sl_allocate(all, sizeof *order);
    bool room = job.worker && most && share && order;
    for (unsigned t = 0; t < light->threads && room; t++)
        job.worker[t] = (light_worker){share + t * lights, most + t * lights, order + t * lights};
    if (room) sl_batch_run(&batch, light->threads, counters);
    sl_free(job.worker);
    sl_free(most);
    sl_free(share);
    sl_free(order);
    return room ? SL_OK : sl_fail_memory(error, "the coarse mesh's light");
}

/* The coarse mesh of the whole scene, some vertices an update: first the light of lamps at all of them; under
 * an environment what each gathers of that alone, past surfaces that are black as yet; then, for each bounce
 * after the first, what each gathers of all, which makes the light that it sends on (k_d / pi) (sum E_d +
 * E_i). From then on indirect light has a mesh to gather from. */

enum { COARSE_VERTICES = 1024 }; /* an update's, beside refinement */

/* ---- gathers ---- */

/* A point on a crease lies in the plane of the faces beyond: it would see them edge-on, and half of what is
 * behind them. What is meant is the limit from within its own face, so the eye moves towards that face's
 * middle by a little. Where the face falls below the tangent plane (a bulge) the eye stays in the plane, so
 * as not to dive. Where it rises above it (a hollow) it is raised off the face and sees it: else it would
 * look out through it. On a flat face and a bulge it must not see its own, which it lies in. */
static void look_from_within(const sl_scene *scene, uint32_t face, sl_gather_point *point) {
    uint32_t triangle = face / 2;
    if (point->triangle == SL_NO_INDEX) point->triangle = triangle;
    if (triangle >= scene->triangle_count) return;
    sl_vec3d middle = sl_v3d(0.0, 0.0, 0.0), p = sl_to_double(point->position),
             n = sl_to_double(point->geometric_normal);
    for (int k = 0; k < 3; k++)
        middle = sl_addd(middle, sl_to_double(sl_scene_position(scene, scene->vertex[k][triangle])));
    sl_vec3d way = sl_subd(sl_scaled(middle, 1.0 / 3.0), p);
    double length = sl_lengthd(way), step = 4e-4 * (double)scene->scale;
    if (!(length > 0.0)) return;
    step = step < 0.25 * length ? step : 0.25 * length;
    way = sl_scaled(way, step / length);
    double rise = sl_dotd(way, n);
    if (rise < 0.0) way = sl_subd(way, sl_scaled(n, rise));
    if (rise > 0.02 * step) {
        point->triangle = SL_NO_INDEX;
        way = sl_addd(way, sl_scaled(sl_to_double(sl_scene_geometric_normal(scene, triangle)),
                                      (face % 2 ? -0.25 : 0.25) * step));
    }
    point->position = sl_to_float(sl_addd(p, way));
}

sl_rgb sl_coarse_gather(const sl_scene *scene, const sl_gather *gather, const sl_mesh_point *at,
                        sl_gather_scratch *scratch, sl_counters *counters) {
    const sl_lit_point *lit = &at->lit;
    sl_vec3 normal = sl_normalize_or(lit->normal, lit->geometric_normal);
    sl_gather_point point = {.position = lit->position,
                             .geometric_normal = sl_normalize_or(lit->geometric_normal, normal),
                             .normal = normal,
                             .triangle = lit->triangle};
    if (!sl_is_finite(lit->position) || !(sl_dot(normal, normal) > 0.5f)) { /* no number, no direction */
        sl_count(counters, SL_COUNT_NONFINITE, 1);
        return sl_grey(0.0f);
    }
    look_from_within(scene, at->face, &point);
    return sl_gather_known_colours(gather, &point, scratch, counters);
}

typedef struct gathering {
    const sl_multi_mesh_state *s;
    const sl_mesh_point *point;
} gathering;

static void gather_one(void *context, size_t i, unsigned worker, void *result, sl_counters *counters) {
    const gathering *g = context;
    sl_count(counters, SL_COUNT_INDIRECT_SAMPLES, 1);
    *(sl_rgb *)result =
        sl_coarse_gather(g->s->scene, g->s->gather, &g->point[i], g->s->gatherer[worker], counters);
}

void sl_multi_mesh_gather(sl_multi_mesh_state *s, size_t count, const sl_mesh_point *points,
                          sl_rgb *irradiance) {
    gathering g = {s, points};
    const sl_batch batch = {count, gather_one, &g, irradiance, sizeof *irradiance};
    sl_batch_run(&batch, s->settings.threads, &s->counters);
}

void sl_multi_mesh_forget_gather(sl_multi_mesh_state *s) {
    for (unsigned t = 0; s->gatherer && t < s->settings.threads; t++)
        sl_gather_scratch_destroy(s->gatherer[t]);
    sl_free(s->gatherer);
    sl_gather_destroy(s->gather);
    s->gatherer = NULL;
    s->gather = NULL;
}

static sl_status ready_gather(sl_multi_mesh_state *s, int size, sl_error *error) {
    const sl_multi_mesh_settings *m = &s->settings.multi_mesh;
    if (s->gather && s->gather_pixels == size) return SL_OK;
    sl_multi_mesh_forget_gather(s);
    s->gather_pixels = size;
    sl_lattice_colours colours = {s->coarse->face, s->coarse->colour};
    sl_gather_settings gather = {.kind = SL_GATHER_PLANE,
                                 .size = size,
                                 .plane_fov = (float)m->gather_fov,
                                 .border = SL_BORDER_LC04,
                                 .colours = &colours};
    sl_status status = sl_gather_create(s->scene, s->raster, NULL, &gather, s->settings.threads, &s->gather,
                                        &s->counters, error);
    s->gatherer = sl_allocate(s->settings.threads, sizeof *s->gatherer);
    if (status == SL_OK && !s->gatherer) status = sl_fail_memory(error, "gathers");
    for (unsigned t = 0; t < s->settings.threads && status == SL_OK; t++)
        status = sl_gather_scratch_create(s->gather, &s->gatherer[t], error);
    return status;
}

/* ---- rounds ---- */

/* Returns the pixels a side of a round's gathers: what the coarse mesh's vertices gather of each other is
 * seen by hundreds of them at once, so few pixels are enough; a sky may hold a sun. */
static int round_pixels(const sl_multi_mesh_state *s, uint32_t rounds_left) {
    const int size = s->settings.gather_size;
    const bool sky = rounds_left == s->settings.bounces;
    if (rounds_left == 0 || sky || size < 4 * SL_GATHER_COLOURED_LEAST) return size;
    return size / 4;
}

static sl_status light_coarse(sl_multi_mesh_state *s, size_t count, sl_error *error) {
    if (!s->plan.lights) return SL_OK;
    const size_t all = s->coarse->vertex_count * s->lights->count;
    if (!s->coarse_shares && !s->light.few_rays &&
        !(s->coarse_shares = sl_allocate(all, sizeof *s->coarse_shares)))
        return sl_fail_memory(error, "the coarse mesh's light");
    sl_count(&s->counters, SL_COUNT_COARSE_SAMPLES, count);
    return sl_coarse_light_take(
        &s->light, count, s->coarse->vertex + s->coarse_done,
        s->coarse_shares ? s->coarse_shares + s->coarse_done * s->lights->count : NULL,
        s->coarse_direct + s->coarse_done, &s->counters, error);
}

/* U_dd, and E_i / pi where it is known, is what gathers see. */
static void set_coarse(sl_multi_mesh_state *s) {
    for (size_t i = 0; i < s->coarse->vertex_count; i++) {
        sl_rgb more =
            s->coarse_indirect ? sl_rgb_scale(s->coarse_indirect[i], (float)(1.0 / SL_PI)) : sl_grey(0.0f);
        sl_coarse_set(s->coarse, i, sl_rgb_add(s->coarse_direct[i], more));
    }
}

/* All lights are hidden from all surfaces: nothing bounces, and there is nothing to be gathered. */
static bool is_dark(const sl_multi_mesh_state *s) {
    sl_rgb brightest = sl_coarse_brightest(s->coarse);
    return !s->scene->environment.present &&
           !(brightest.r > 0.0f || brightest.g > 0.0f || brightest.b > 0.0f);
}

static void leave_out_indirect(sl_multi_mesh_state *s) {
    sl_displayed_destroy(s->part[SL_INDIRECT]);
    s->part[SL_INDIRECT] = NULL;
    s->plan.indirect = false;
}

static void end_coarse(sl_multi_mesh_state *s) {
    sl_free(s->coarse_direct);
    sl_free(s->coarse_indirect);
    s->coarse_direct = s->coarse_indirect = NULL;
    s->coarse_whole = true;
}

/* The environment's light is gathered past surfaces that are black. */
static void blacken_coarse(sl_multi_mesh_state *s) {
    for (size_t i = 0; i < s->coarse->vertex_count; i++) sl_coarse_set(s->coarse, i, sl_grey(0.0f));
    sl_coarse_finish(s->coarse, s->settings.threads);
}

/* The light of lamps is there. The environment's is yet to be gathered, and so is each bounce after the
 * first. */
static sl_status finish_direct(sl_multi_mesh_state *s, sl_error *error) {
    bool sky = s->scene->environment.present;
    set_coarse(s);
    sl_coarse_finish(s->coarse, s->settings.threads);
    sl_announce_pass(&s->announcer, "coarse mesh", "for equation (7)");
    if (is_dark(s)) {
        leave_out_indirect(s);
        return SL_OK;
    }
    if (sky) blacken_coarse(s);
    s->coarse_gathers = s->settings.bounces - 1 + (sky ? 1 : 0);
    sl_status status = ready_gather(s, round_pixels(s, s->coarse_gathers), error);
    if (status != SL_OK) return status;
    if (s->coarse_gathers == 0) {
        end_coarse(s);
        return SL_OK;
    }
    s->coarse_done = 0;
    s->coarse_indirect = sl_allocate(s->coarse->vertex_count, sizeof *s->coarse_indirect);
    return s->coarse_indirect ? SL_OK : sl_fail_memory(error, "the coarse mesh's gathers");
}

static void gather_for_coarse(sl_multi_mesh_state *s, size_t count) {
    const sl_coarse_vertex *vertex = s->coarse->vertex + s->coarse_done;
    sl_mesh_point points[COARSE_VERTICES];
    for (size_t i = 0; i < count; i++) {
        sl_root_place x = {vertex[i].face, vertex[i].lit_p, vertex[i].lit_q};
        points[i] = sl_mesh_point_at(s->primitives, x);
    }
    sl_multi_mesh_gather(s, count, points, s->coarse_indirect + s->coarse_done);
}

static sl_status finish_gathers(sl_multi_mesh_state *s, sl_error *error) {
    bool sky = s->coarse_gathers == s->settings.bounces;
    set_coarse(s);
    sl_coarse_finish(s->coarse, s->settings.threads);
    sl_announce_pass(&s->announcer,
                     sky ? "coarse mesh, the environment's light" : "coarse mesh, one more bounce",
                     "for equation (7)");
    sl_status status = ready_gather(s, round_pixels(s, s->coarse_gathers - 1), error);
    if (status != SL_OK) return status;
    if (--s->coarse_gathers) s->coarse_done = 0;
    else end_coarse(s);
    return SL_OK;
}

sl_status sl_multi_mesh_extend_coarse(sl_multi_mesh_state *s, sl_error *error) {
    size_t all = s->coarse->vertex_count, left = all - s->coarse_done;
    size_t count = left < COARSE_VERTICES ? left : COARSE_VERTICES;
    sl_status status = SL_OK;
    if (s->coarse_indirect) gather_for_coarse(s, count);
    else if (count) status = light_coarse(s, count, error);
    s->coarse_done += count;
    if (status != SL_OK || s->coarse_done < all) return status;
    if (s->coarse_indirect) status = finish_gathers(s, error);
    else status = finish_direct(s, error);
    if (!s->coarse_whole) return status;
    sl_multi_mesh_announce_gather(s);
    s->phase = SL_PHASE_FIRST; /* of the indirect mesh */
    s->priorities_stale = true;
    return status;
}
