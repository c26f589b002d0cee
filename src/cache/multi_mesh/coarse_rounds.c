/* The coarse mesh of the whole scene, some vertices an update: first the light of lamps at all of them; under
 * an environment what each gathers of that alone, past surfaces that are black as yet; then, for each bounce
 * after the first, what each gathers of all, which makes the light that it sends on (k_d / pi) (sum E_d +
 * E_i). From then on indirect light has a mesh to gather from. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include "base/batch.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

/* Where most shares of light are kept an update takes so many times as many, as long as few are sampled. */
enum { KEPT_TIMES = 16 };

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
    const sl_gathers *eye;
    const sl_mesh_point *point;
} gathering;

static void gather_one(void *context, size_t i, unsigned worker, void *result, sl_counters *counters) {
    const gathering *g = context;
    sl_count(counters, SL_COUNT_INDIRECT_SAMPLES, 1);
    *(sl_rgb *)result =
        sl_coarse_gather(g->s->scene, g->eye->gather, &g->point[i], g->eye->scratch[worker], counters);
}

void sl_multi_mesh_forget_eyes(sl_coarse_rounds *rounds) {
    for (int i = 0; i < SL_GATHER_DETAILS; i++) sl_gathers_destroy(&rounds->eye[i]);
}

/* Fewer pixels a side, unless a quarter of them is too few to be drawn. */
static int pixels_of(const sl_multi_mesh_state *s, sl_gather_detail detail) {
    return sl_multi_mesh_has_quick(s) ? s->settings.gather_size >> detail : s->settings.gather_size;
}

bool sl_multi_mesh_has_quick(const sl_multi_mesh_state *s) {
    return s->settings.gather_size >= 4 * SL_GATHER_COLOURED_LEAST;
}

sl_status sl_multi_mesh_ready_eye(sl_multi_mesh_state *s, sl_coarse_rounds *rounds, sl_gather_detail detail,
                                  sl_error *error) {
    const sl_lattice_colours colours = {rounds->coarse->face, rounds->coarse->colour};
    const sl_gather_settings gather = {.kind = SL_GATHER_PLANE,
                                       .size = pixels_of(s, detail),
                                       .plane_fov = (float)s->settings.multi_mesh.gather_fov,
                                       .border = SL_BORDER_LC04,
                                       .colours = &colours};
    if (rounds->eye[detail].gather) return SL_OK;
    return sl_gathers_create(s->scene, s->raster, NULL, &gather, s->settings.threads, &rounds->eye[detail],
                             error);
}

sl_status sl_multi_mesh_gather(sl_multi_mesh_state *s, sl_coarse_rounds *rounds, sl_gather_detail detail,
                               size_t count, const sl_mesh_point *points, sl_rgb *irradiance,
                               sl_error *error) {
    const sl_gathers *eye = &rounds->eye[detail];
    sl_status status = sl_multi_mesh_ready_eye(s, rounds, detail, error);
    if (status != SL_OK) return status;
    gathering g = {s, eye, points};
    const sl_batch batch = {.count = count, .work = gather_one, .context = &g, .results = irradiance,
                            .result_bytes = sizeof *irradiance, .shared = true};
    sl_batch_run(&batch, s->settings.threads, &s->counters);
    return SL_OK;
}

/* ---- rounds ---- */

void sl_multi_mesh_forget_coarse(sl_coarse_rounds *rounds) {
    sl_multi_mesh_forget_eyes(rounds);
    SL_FREE_ALL(rounds->shares, rounds->direct, rounds->indirect, rounds->area, rounds->lit_in);
    sl_coarse_destroy(rounds->coarse);
    *rounds = (sl_coarse_rounds){.coarse = NULL};
}

/* Returns how often its vertices gather: the environment's light, and each bounce after the first. */
static uint32_t rounds_of(const sl_multi_mesh_state *s) {
    return s->settings.bounces - 1 + (s->scene->environment.present ? 1 : 0);
}

/* Room for the lights' shares, and those of the last whole mesh that hold. Of few rays none are kept. */
static sl_status begin_shares(sl_multi_mesh_state *s, sl_error *error) {
    sl_coarse_rounds *r = &s->next;
    if (!s->plan.lights || s->light.few_rays || r->hasty) return SL_OK;
    r->shares = sl_allocate(r->coarse->vertex_count * s->now.lights->count, sizeof *r->shares);
    if (!r->shares) return sl_fail_memory(error, "the coarse mesh's light");
    if (!s->kept.count) return SL_OK;
    return sl_coarse_shares_that_hold(&s->kept, &s->light, s->now.places, r->coarse, r->shares, error);
}

sl_status sl_multi_mesh_make_coarse(const sl_multi_mesh_state *s, int halvings, sl_coarse **coarse,
                                    sl_error *error) {
    const float edge = ldexpf((float)sl_multi_mesh_coarse_edge(s->scene, &s->settings), halvings);
    const int depth = s->settings.multi_mesh.coarse_depth - halvings;
    return sl_coarse_create(s->scene, s->primitives, edge, depth > 0 ? depth : 0, coarse, error);
}

sl_status sl_multi_mesh_begin_coarse(sl_multi_mesh_state *s, sl_error *error) {
    bool hasty = s->hastens && !s->whole.coarse;
    s->next = (sl_coarse_rounds){.world = s->world, .lit = s->lit, .hasty = hasty};
    sl_status status = sl_multi_mesh_make_coarse(s, hasty ? 2 : 0, &s->next.coarse, error);
    if (status == SL_OK) status = begin_shares(s, error);
    if (status != SL_OK) return status;
    s->next.direct = sl_allocate(s->next.coarse->vertex_count, sizeof *s->next.direct);
    return s->next.direct ? SL_OK : sl_fail_memory(error, "the coarse mesh");
}

/* Tells whether a round's gathers have few pixels: what the coarse mesh's vertices gather of each other is
 * seen by hundreds of them at once, so few are enough; a sky may hold a sun. */
static bool is_quick_round(const sl_multi_mesh_state *s) { return s->next.gathers != s->settings.bounces; }

static sl_status light_coarse(sl_multi_mesh_state *s, size_t count, sl_error *error) {
    if (!s->plan.lights) return SL_OK;
    size_t lights = s->now.lights->count;
    sl_coarse_rounds *r = &s->next;
    sl_root_place place[SL_COARSE_VERTICES];
    for (size_t i = 0; i < count; i++) place[i] = sl_coarse_lit_place(r->coarse, r->done + i);
    sl_count(&s->counters, SL_COUNT_COARSE_SAMPLES, count);
    return sl_coarse_light_take(&s->light, count, place, r->hasty,
                                r->shares ? r->shares + r->done * lights : NULL, r->direct + r->done,
                                &s->counters, error);
}

/* Gathers see U_dd and E_i / pi. Before E_i is known a hasty mesh of several bounces has the ambient term,
 * any other nothing. */
void sl_multi_mesh_colour_coarse(const sl_multi_mesh_state *s, const sl_coarse_rounds *r) {
    const sl_rgb unknown = r->hasty && s->settings.bounces > 1 ? s->ambient_in_motion : sl_grey(0.0f);
    for (size_t i = 0; i < r->coarse->vertex_count; i++) {
        const sl_rgb indirect = r->indirect ? r->indirect[i] : unknown;
        sl_coarse_set(r->coarse, i, sl_rgb_add(r->direct[i], sl_rgb_scale(indirect, (float)(1.0 / SL_PI))));
    }
    sl_coarse_finish(r->coarse, s->settings.threads);
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
    if (s->whole.coarse) sl_multi_mesh_carry(s, &s->whole, &s->next);
    sl_multi_mesh_forget_coarse(&s->whole);
    s->whole = s->next;
    s->next = (sl_coarse_rounds){.coarse = NULL};
}

/* The environment's light is gathered past surfaces that are black. */
static void blacken_coarse(sl_multi_mesh_state *s) {
    for (size_t i = 0; i < s->next.coarse->vertex_count; i++) sl_coarse_set(s->next.coarse, i, sl_grey(0.0f));
    sl_coarse_finish(s->next.coarse, s->settings.threads);
}

/* Keeps them if they were taken in one state of the scene; the rounds that follow have no use for them. */
static sl_status keep_shares(sl_multi_mesh_state *s, sl_error *error) {
    sl_coarse_share *shares = s->next.shares;
    s->next.shares = NULL;
    if (shares && s->next.lit == s->lit)
        return sl_coarse_keep(&s->light, s->next.coarse, shares, &s->kept, error);
    sl_free(shares);
    return SL_OK;
}

/* While things move, a first coarse mesh is taken as soon as it has any light: those that follow see it, and
 * add a bounce each. */
static bool is_awaited(const sl_multi_mesh_state *s) {
    return s->next.hasty || (!s->whole.coarse && s->next.world != s->world);
}

void sl_multi_mesh_hasten_coarse(sl_multi_mesh_state *s) {
    const sl_coarse_rounds *r = &s->next;
    s->hastens = true;
    if (s->whole.coarse || !r->coarse || r->hasty || r->indirect || 2 * r->done > r->coarse->vertex_count)
        return;
    sl_multi_mesh_forget_coarse(&s->next);
}

/* The light of lamps is there. The environment's is yet to be gathered, and so is each bounce after the
 * first. */
static sl_status finish_direct(sl_multi_mesh_state *s, sl_error *error) {
    bool sky = s->scene->environment.present;
    sl_status status = keep_shares(s, error);
    if (status != SL_OK) return status;
    sl_multi_mesh_colour_coarse(s, &s->next);
    sl_announce_pass(&s->announcer, "coarse mesh", "for equation (7)");
    if (!s->next.hasty && is_dark(s)) {
        leave_out_indirect(s);
        return SL_OK;
    }
    if (sky) blacken_coarse(s);
    s->next.gathers = rounds_of(s);
    if (s->next.gathers == 0 || (is_awaited(s) && !sky)) {
        end_coarse(s);
        return SL_OK;
    }
    s->next.done = 0;
    s->next.indirect = sl_allocate(s->next.coarse->vertex_count, sizeof *s->next.indirect);
    return s->next.indirect ? SL_OK : sl_fail_memory(error, "the coarse mesh's gathers");
}

static sl_status gather_for_coarse(sl_multi_mesh_state *s, size_t count, sl_error *error) {
    sl_mesh_point points[SL_COARSE_VERTICES];
    for (size_t i = 0; i < count; i++)
        points[i] = sl_mesh_point_at(s->primitives, sl_coarse_lit_place(s->next.coarse, s->next.done + i));
    return sl_multi_mesh_gather(s, &s->next, is_quick_round(s) ? SL_GATHER_A_QUARTER : SL_GATHER_ALL, count,
                                points, s->next.indirect + s->next.done, error);
}

static void finish_gathers(sl_multi_mesh_state *s) {
    sl_multi_mesh_colour_coarse(s, &s->next);
    sl_announce_pass(&s->announcer,
                     is_quick_round(s) ? "coarse mesh, one more bounce"
                                       : "coarse mesh, the environment's light",
                     "for equation (7)");
    s->next.done = 0;
    if (!--s->next.gathers || is_awaited(s)) end_coarse(s);
}

/* Few rays a vertex are soon traced. */
static size_t update_share(const sl_multi_mesh_state *s) {
    return s->world > 1 && !s->next.hasty ? sl_multi_mesh_share(s, SL_COARSE_VERTICES) : SL_COARSE_VERTICES;
}

static sl_status extend(sl_multi_mesh_state *s, sl_error *error) {
    size_t all = s->next.coarse->vertex_count, count = sl_fewer(all - s->next.done, update_share(s));
    sl_status status = SL_OK;
    if (count) status = s->next.indirect ? gather_for_coarse(s, count, error) : light_coarse(s, count, error);
    s->next.done += count;
    if (status != SL_OK || s->next.done < all) return status;
    if (!s->next.indirect) return finish_direct(s, error);
    finish_gathers(s);
    return SL_OK;
}

static sl_status extend_kept(sl_multi_mesh_state *s, sl_error *error) {
    const uint64_t *samples = &s->counters.value[SL_COUNT_LIGHT_SAMPLES], end = *samples + update_share(s);
    sl_status status = extend(s, error);
    for (int i = 1; i < KEPT_TIMES && status == SL_OK && s->next.shares && *samples < end; i++)
        status = extend(s, error);
    return status;
}

/* While things move the one there is rolls on; a still picture's is begun when they rest. */
static sl_status extend_or_roll(sl_multi_mesh_state *s, sl_error *error) {
    if (s->whole.coarse && s->whole.lit != s->lit && rounds_of(s) > 0) return sl_multi_mesh_roll(s, error);
    if (s->whole.rolls && !s->next.coarse && !sl_multi_mesh_rests(s)) return SL_OK;
    sl_status status = s->next.coarse ? SL_OK : sl_multi_mesh_begin_coarse(s, error);
    if (status == SL_OK) status = s->kept.count ? extend_kept(s, error) : extend(s, error);
    return status;
}

sl_status sl_multi_mesh_extend_coarse(sl_multi_mesh_state *s, sl_error *error) {
    const sl_coarse *before = s->whole.coarse;
    const uint32_t lit = s->whole.lit;
    sl_status status = extend_or_roll(s, error);
    bool ended = s->whole.coarse && (s->whole.rolls ? s->whole.lit != lit : s->whole.coarse != before);
    if (status != SL_OK || !ended) return status;
    sl_multi_mesh_announce_gather(s);
    s->gathers_wait = s->gathers_wait && s->whole.world != s->world;
    s->phase = SL_PHASE_FIRST; /* of the indirect mesh */
    s->priorities_stale = true;
    return status;
}
