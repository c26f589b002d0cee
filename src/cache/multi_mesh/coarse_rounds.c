/* The coarse mesh of the whole scene, some vertices an update: first the light of lamps at all of them; under
 * an environment what each gathers of that alone, past surfaces that are black as yet; then, if two bounces
 * are asked for, what each gathers of all, which makes the light that it sends on (k_d / pi) (sum E_d + E_i).
 * From then on indirect light has a mesh to gather from. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/multi_mesh/explanation.h"

enum { COARSE_VERTICES = 1024 }; /* an update's, beside refinement */

/* ---- gathers ---- */

typedef struct gathering {
    const sl_multi_mesh_state *s;
    const sl_mesh_point *point;
    sl_rgb *irradiance;
} gathering;

static void gather_one(void *context, size_t task, unsigned worker) {
    const gathering *g = context;
    sl_gather_worker *w = &g->s->gatherer[worker];
    g->irradiance[task] = sl_mesh_gather_take(g->s->gather, &g->point[task], w->scratch, &w->counters);
}

void sl_multi_mesh_gather(sl_multi_mesh_state *s, size_t count, const sl_mesh_point *points,
                          sl_rgb *irradiance) {
    gathering g = {s, points, irradiance};
    sl_parallel_for(s->settings.threads, count, gather_one, &g);
    for (unsigned t = 0; t < s->settings.threads; t++) {
        sl_counters_add(&s->counters, &s->gatherer[t].counters);
        s->gatherer[t].counters = (sl_counters){{0}};
    }
}

static sl_status ready_gather(sl_multi_mesh_state *s, sl_error *error) {
    const sl_multi_mesh_settings *m = &s->settings.multi_mesh;
    sl_mesh_gather_settings gather = {.size = s->settings.gather_size,
                                      .reduced = s->settings.gather_size < 16 ? s->settings.gather_size : 16,
                                      .fov = (float)m->gather_fov};
    sl_status status = sl_mesh_gather_create(s->scene, s->raster, s->coarse, &gather, &s->gather, error);
    if (status == SL_OK && !s->gatherer) {
        s->gatherer = sl_allocate(s->settings.threads, sizeof *s->gatherer);
        if (!s->gatherer) return sl_fail_memory(error, "gathers");
    }
    for (unsigned t = 0; t < s->settings.threads && status == SL_OK; t++)
        if (!s->gatherer[t].scratch)
            status = sl_mesh_gather_scratch_create(s->gather, &s->gatherer[t].scratch, error);
    return status;
}

/* ---- rounds ---- */

static void light_coarse(sl_multi_mesh_state *s, size_t count) {
    if (!s->coarse_light) return;
    sl_rgb *radiance = s->coarse_direct + s->coarse_done;
    sl_coarse_light_take(s->coarse_light, count, s->coarse->vertex + s->coarse_done, radiance,
                         &s->counters);
    sl_count(&s->counters, SL_COUNT_COARSE_SAMPLES, count);
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
    s->plan.indirect = s->plan.coarse = false;
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

/* The light of lamps is there. The environment's wants to be gathered, and so does a second bounce. */
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
    sl_status status = ready_gather(s, error);
    s->coarse_gathers = s->settings.bounces - 1 + (sky ? 1 : 0);
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
        sl_face_point x = {.face = vertex[i].face, .p = vertex[i].lit_p, .q = vertex[i].lit_q};
        points[i] = sl_face_point_in_world(s->primitives, &x);
    }
    sl_multi_mesh_gather(s, count, points, s->coarse_indirect + s->coarse_done);
}

static void finish_gathers(sl_multi_mesh_state *s) {
    bool sky = s->coarse_gathers == s->settings.bounces;
    set_coarse(s);
    sl_coarse_finish(s->coarse, s->settings.threads);
    sl_announce_pass(&s->announcer,
                     sky ? "coarse mesh, the environment's light" : "coarse mesh, second bounce",
                     "for equation (7)");
    if (--s->coarse_gathers) s->coarse_done = 0;
    else end_coarse(s);
}

sl_status sl_multi_mesh_extend_coarse(sl_multi_mesh_state *s, sl_error *error) {
    size_t all = s->plan.coarse ? s->coarse->vertex_count : 0, left = all - s->coarse_done;
    size_t count = left < COARSE_VERTICES ? left : COARSE_VERTICES;
    sl_status status = SL_OK;
    if (s->coarse_indirect) gather_for_coarse(s, count);
    else if (count) light_coarse(s, count);
    s->coarse_done += count;
    if (status != SL_OK || s->coarse_done < all) return status;
    if (s->coarse_indirect) finish_gathers(s);
    else status = finish_direct(s, error);
    if (!s->coarse_whole) return status;
    sl_multi_mesh_announce_gather(s);
    s->phase = SL_PHASE_FIRST; /* of the indirect mesh */
    s->priorities_stale = true;
    return status;
}
