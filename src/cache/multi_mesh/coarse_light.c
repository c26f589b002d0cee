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
    const sl_coarse_eye *eye;
    const sl_mesh_point *point;
} gathering;

static void gather_one(void *context, size_t i, unsigned worker, void *result, sl_counters *counters) {
    const gathering *g = context;
    sl_count(counters, SL_COUNT_INDIRECT_SAMPLES, 1);
    *(sl_rgb *)result =
        sl_coarse_gather(g->s->scene, g->eye->gather, &g->point[i], g->eye->scratch[worker], counters);
}

static void forget_eye(sl_coarse_eye *eye, unsigned threads) {
    for (unsigned t = 0; eye->scratch && t < threads; t++) sl_gather_scratch_destroy(eye->scratch[t]);
    sl_free(eye->scratch);
    sl_gather_destroy(eye->gather);
    *eye = (sl_coarse_eye){.gather = NULL};
}

void sl_multi_mesh_forget_eyes(sl_coarse_rounds *rounds, unsigned threads) {
    for (int i = 0; i < 2; i++) forget_eye(&rounds->eye[i], threads);
}

static sl_status make_eye(sl_multi_mesh_state *s, const sl_coarse *coarse, sl_coarse_eye *eye,
                          sl_error *error) {
    sl_lattice_colours colours = {coarse->face, coarse->colour};
    sl_gather_settings gather = {.kind = SL_GATHER_PLANE,
                                 .size = eye->pixels,
                                 .plane_fov = (float)s->settings.multi_mesh.gather_fov,
                                 .border = SL_BORDER_LC04,
                                 .colours = &colours};
    sl_status status = sl_gather_create(s->scene, s->raster, NULL, &gather, s->settings.threads, &eye->gather,
                                        &s->counters, error);
    eye->scratch = sl_allocate(s->settings.threads, sizeof *eye->scratch);
    if (status == SL_OK && !eye->scratch) status = sl_fail_memory(error, "gathers");
    for (unsigned t = 0; t < s->settings.threads && status == SL_OK; t++)
        status = sl_gather_scratch_create(eye->gather, &eye->scratch[t], error);
    return status;
}

/* A quarter of the pixels, unless that is too few to be drawn. */
static int pixels_of(const sl_multi_mesh_state *s, bool quick) {
    const int size = s->settings.gather_size;
    return quick && size >= 4 * SL_GATHER_COLOURED_LEAST ? size / 4 : size;
}

sl_status sl_multi_mesh_ready_eye(sl_multi_mesh_state *s, sl_coarse_rounds *rounds, bool quick,
                                  sl_error *error) {
    sl_coarse_eye *eye = &rounds->eye[quick];
    eye->pixels = pixels_of(s, quick);
    sl_status status = eye->gather ? SL_OK : make_eye(s, rounds->coarse, eye, error);
    if (status != SL_OK) forget_eye(eye, s->settings.threads);
    return status;
}

sl_status sl_multi_mesh_gather(sl_multi_mesh_state *s, sl_coarse_rounds *rounds, bool quick, size_t count,
                               const sl_mesh_point *points, sl_rgb *irradiance, sl_error *error) {
    sl_coarse_eye *eye = &rounds->eye[quick];
    sl_status status = sl_multi_mesh_ready_eye(s, rounds, quick, error);
    if (status != SL_OK) return status;
    gathering g = {s, eye, points};
    const sl_batch batch = {count, gather_one, &g, irradiance, sizeof *irradiance};
    sl_batch_run(&batch, s->settings.threads, &s->counters);
    return SL_OK;
}

/* ---- rounds ---- */

void sl_multi_mesh_forget_coarse(sl_coarse_rounds *rounds, unsigned threads) {
    sl_multi_mesh_forget_eyes(rounds, threads);
    sl_free(rounds->shares);
    sl_free(rounds->direct);
    sl_free(rounds->indirect);
    sl_coarse_destroy(rounds->coarse);
    *rounds = (sl_coarse_rounds){.coarse = NULL};
}

/* Returns how often its vertices gather: the environment's light, and each bounce after the first. */
static uint32_t rounds_of(const sl_multi_mesh_state *s) {
    return s->settings.bounces - 1 + (s->scene->environment.present ? 1 : 0);
}

/* Of a coarse mesh that is the same but for colours. */
static void inherit_shares(sl_multi_mesh_state *s) {
    bool same = s->whole.coarse && !s->whole.rolls && s->whole.lit == s->lit &&
                s->whole.coarse->vertex_count == s->next.coarse->vertex_count;
    if (!same) return;
    s->next.shares = s->whole.shares;
    s->whole.shares = NULL;
}

sl_status sl_multi_mesh_begin_coarse(sl_multi_mesh_state *s, sl_error *error) {
    bool moves = s->whole.coarse && s->whole.lit != s->lit, rolls = moves && rounds_of(s) > 0;
    float edge = (float)sl_multi_mesh_coarse_edge(s->scene, &s->settings);
    /* a quarter of the vertices while things move: what has gone on is soon seen */
    sl_coarse_settings coarse = {rolls ? 2.0f * edge : edge, s->settings.multi_mesh.coarse_depth - rolls};
    if (coarse.depth < 0) coarse.depth = 0;
    s->next = (sl_coarse_rounds){.world = s->world, .lit = s->lit, .rolls = rolls};
    sl_status status = sl_coarse_create(s->scene, s->primitives, &coarse, &s->next.coarse, error);
    if (status != SL_OK) return status;
    size_t count = s->next.coarse->vertex_count;
    if (!rolls) inherit_shares(s);
    s->next.direct = sl_allocate(count, sizeof *s->next.direct);
    if (s->next.rolls) s->next.indirect = sl_allocate(count, sizeof *s->next.indirect);
    bool done = s->next.direct && (s->next.indirect || !s->next.rolls);
    return done ? SL_OK : sl_fail_memory(error, "the coarse mesh");
}

/* Tells whether a round's gathers have few pixels: what the coarse mesh's vertices gather of each other is
 * seen by hundreds of them at once, so few are enough; a sky may hold a sun. */
static bool is_quick_round(const sl_multi_mesh_state *s) { return s->next.gathers != s->settings.bounces; }

static sl_status light_coarse(sl_multi_mesh_state *s, size_t count, sl_error *error) {
    if (!s->plan.lights) return SL_OK;
    size_t lights = s->lights->count;
    sl_coarse_rounds *r = &s->next;
    if (!r->shares && !s->light.few_rays &&
        !(r->shares = sl_allocate(r->coarse->vertex_count * lights, sizeof *r->shares)))
        return sl_fail_memory(error, "the coarse mesh's light");
    sl_count(&s->counters, SL_COUNT_COARSE_SAMPLES, count);
    return sl_coarse_light_take(&s->light, count, r->coarse->vertex + r->done,
                                r->shares ? r->shares + r->done * lights : NULL, r->direct + r->done,
                                &s->counters, error);
}

/* U_dd, and E_i / pi where it is known, is what gathers see. */
static void set_coarse(sl_coarse_rounds *r, unsigned threads) {
    for (size_t i = 0; i < r->coarse->vertex_count; i++) {
        sl_rgb more = r->indirect ? sl_rgb_scale(r->indirect[i], (float)(1.0 / SL_PI)) : sl_grey(0.0f);
        sl_coarse_set(r->coarse, i, sl_rgb_add(r->direct[i], more));
    }
    sl_coarse_finish(r->coarse, threads);
}

/* All lights are hidden from all surfaces: nothing bounces, and there is nothing to be gathered. */
static bool is_dark(const sl_multi_mesh_state *s) {
    sl_rgb brightest = sl_coarse_brightest(s->next.coarse);
    return !s->scene->environment.present &&
           !(brightest.r > 0.0f || brightest.g > 0.0f || brightest.b > 0.0f);
}

static void leave_out_indirect(sl_multi_mesh_state *s) {
    sl_displayed_destroy(s->part[SL_INDIRECT]);
    s->part[SL_INDIRECT] = NULL;
    s->plan.indirect = false;
}

/* It takes the place of the one before. */
static void end_coarse(sl_multi_mesh_state *s) {
    if (s->whole.coarse) sl_multi_mesh_carry(s);
    sl_multi_mesh_forget_coarse(&s->whole, s->settings.threads);
    s->whole = s->next;
    s->next = (sl_coarse_rounds){.coarse = NULL};
    sl_free(s->whole.direct);
    s->whole.direct = NULL;
}

/* The environment's light is gathered past surfaces that are black. */
static void blacken_coarse(sl_multi_mesh_state *s) {
    for (size_t i = 0; i < s->next.coarse->vertex_count; i++) sl_coarse_set(s->next.coarse, i, sl_grey(0.0f));
    sl_coarse_finish(s->next.coarse, s->settings.threads);
}

/* The light of lamps is there. The environment's is yet to be gathered, and so is each bounce after the
 * first. */
static sl_status finish_direct(sl_multi_mesh_state *s, sl_error *error) {
    bool sky = s->scene->environment.present;
    set_coarse(&s->next, s->settings.threads);
    sl_announce_pass(&s->announcer, "coarse mesh", "for equation (7)");
    if (is_dark(s)) {
        leave_out_indirect(s);
        return SL_OK;
    }
    if (sky) blacken_coarse(s);
    s->next.gathers = rounds_of(s);
    if (s->next.gathers == 0) {
        end_coarse(s);
        return SL_OK;
    }
    s->next.done = 0;
    s->next.indirect = sl_allocate(s->next.coarse->vertex_count, sizeof *s->next.indirect);
    return s->next.indirect ? SL_OK : sl_fail_memory(error, "the coarse mesh's gathers");
}

static sl_status gather_for_coarse(sl_multi_mesh_state *s, sl_coarse_rounds *seen, size_t count,
                                   sl_error *error) {
    const sl_coarse_vertex *vertex = s->next.coarse->vertex + s->next.done;
    sl_mesh_point points[COARSE_VERTICES];
    for (size_t i = 0; i < count; i++) {
        sl_root_place x = {vertex[i].face, vertex[i].lit_p, vertex[i].lit_q};
        points[i] = sl_mesh_point_at(s->primitives, x);
    }
    return sl_multi_mesh_gather(s, seen, s->next.rolls || is_quick_round(s), count, points,
                                s->next.indirect + s->next.done, error);
}

static void finish_gathers(sl_multi_mesh_state *s) {
    set_coarse(&s->next, s->settings.threads);
    sl_announce_pass(&s->announcer,
                     is_quick_round(s) ? "coarse mesh, one more bounce"
                                       : "coarse mesh, the environment's light",
                     "for equation (7)");
    s->next.done = 0;
    if (!--s->next.gathers) end_coarse(s);
}

static sl_status extend(sl_multi_mesh_state *s, sl_error *error) {
    size_t all = s->next.coarse->vertex_count, left = all - s->next.done;
    size_t share = s->world > 1 ? sl_multi_mesh_share(s, COARSE_VERTICES) : COARSE_VERTICES;
    size_t count = left < share ? left : share;
    sl_status status = SL_OK;
    if (count && (s->next.rolls || !s->next.indirect)) status = light_coarse(s, count, error);
    if (status == SL_OK && s->next.indirect)
        status = gather_for_coarse(s, s->next.rolls ? &s->whole : &s->next, count, error);
    s->next.done += count;
    if (status != SL_OK || s->next.done < all) return status;
    if (s->next.rolls) s->next.gathers = 1;
    if (!s->next.indirect) return finish_direct(s, error);
    finish_gathers(s);
    return SL_OK;
}

sl_status sl_multi_mesh_extend_coarse(sl_multi_mesh_state *s, sl_error *error) {
    sl_status status = s->next.coarse ? SL_OK : sl_multi_mesh_begin_coarse(s, error);
    if (status == SL_OK) status = extend(s, error);
    if (status != SL_OK || s->next.coarse || !s->whole.coarse) return status;
    sl_multi_mesh_announce_gather(s);
    s->phase = SL_PHASE_FIRST; /* of the indirect mesh */
    s->priorities_stale = true;
    return status;
}
