/* The coarse mesh of the whole scene, some vertices an update: first the direct light of all of them; then, if two bounces are asked for, what each gathers
 * of that, which makes the light that it sends on (k_d / pi) (sum E_d + E_i). From then on indirect light has a mesh to gather from. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/multi_mesh/story.h"

enum { COARSE_VERTICES = 1024 }; /* an update's, beside refinement */

static sl_status ready_gather(sl_multi_mesh_state *s, sl_error *error) {
    const sl_multi_mesh_settings *m = &s->settings.multi_mesh;
    sl_mesh_gather_settings gather = {.size = s->settings.gather_size, .reduced = s->settings.gather_size < 16 ? s->settings.gather_size : 16,
                                      .fov = (float)m->gather_fov, .undivided = m->undivided_gather, .strips = m->side_strips,
                                      .noticed = sl_rgb_mean(s->ambient) * 0.01f};
    sl_status status = sl_mesh_gather_create(s->scene, s->raster, s->coarse, &gather, &s->gather, error);
    if (status == SL_OK && !s->gatherer) {
        s->gatherer = sl_allocate(s->settings.threads, sizeof *s->gatherer);
        if (!s->gatherer) return sl_fail_memory(error, "gathers");
    }
    for (unsigned t = 0; t < s->settings.threads && status == SL_OK; t++)
        if (!s->gatherer[t].scratch) status = sl_mesh_gather_scratch_create(s->gather, &s->gatherer[t].scratch, error);
    return status;
}

static void light_coarse(sl_multi_mesh_state *s, size_t count) {
    sl_rgb radiance[COARSE_VERTICES];
    sl_coarse_light_take(s->coarse_light, count, sl_coarse_vertices(s->coarse) + s->coarse_done, radiance, &s->counters);
    for (size_t i = 0; i < count; i++) sl_coarse_set(s->coarse, s->coarse_done + i, radiance[i]);
    sl_count(&s->counters, SL_COUNT_COARSE_SAMPLES, count);
}

/* All lights are hidden from all surfaces: nothing bounces, and there is nothing to be gathered. */
static bool is_dark(const sl_multi_mesh_state *s) {
    sl_rgb brightest = sl_coarse_brightest(s->coarse);
    return !s->scene->environment.present && !(brightest.r > 0.0f || brightest.g > 0.0f || brightest.b > 0.0f);
}

static void leave_out_indirect(sl_multi_mesh_state *s) {
    sl_displayed_destroy(s->part[SL_INDIRECT]);
    s->part[SL_INDIRECT] = NULL;
    s->plan.indirect = s->plan.coarse = false;
}

/* The direct light of the coarse mesh is there. A second bounce wants to know what light its vertices gather from it. */
static sl_status finish_direct(sl_multi_mesh_state *s, sl_error *error) {
    sl_coarse_finish(s->coarse, s->settings.threads);
    sl_announce_pass(&s->announcer, "coarse mesh", "for equation (7)");
    if (is_dark(s)) {
        leave_out_indirect(s);
        return SL_OK;
    }
    sl_status status = ready_gather(s, error);
    if (status != SL_OK || s->settings.bounces < 2) {
        s->coarse_whole = status == SL_OK;
        return status;
    }
    s->coarse_done = 0;
    s->coarse_indirect = sl_allocate(sl_coarse_vertex_count(s->coarse), sizeof *s->coarse_indirect);
    return s->coarse_indirect ? SL_OK : sl_fail_memory(error, "the second bounce");
}

static void gather_for_coarse(sl_multi_mesh_state *s, size_t count) {
    const sl_coarse_vertex *vertex = sl_coarse_vertices(s->coarse) + s->coarse_done;
    sl_mesh_point points[COARSE_VERTICES];
    for (size_t i = 0; i < count; i++) {
        sl_face_point x = {.face = vertex[i].face, .p = vertex[i].lit_p, .q = vertex[i].lit_q};
        points[i] = sl_face_point_in_world(s->topology, &x);
    }
    sl_multi_mesh_gather(s, count, points, s->coarse_indirect + s->coarse_done);
}

/* U_dd + E_i / pi is what gathers see from now on. */
static void finish_second_bounce(sl_multi_mesh_state *s) {
    for (size_t i = 0; i < sl_coarse_vertex_count(s->coarse); i++) {
        sl_rgb second = sl_rgb_scale(s->coarse_indirect[i], (float)(1.0 / SL_PI));
        sl_coarse_set(s->coarse, i, sl_rgb_add(sl_coarse_get(s->coarse, i), second));
    }
    sl_free(s->coarse_indirect);
    s->coarse_indirect = NULL;
    sl_coarse_finish(s->coarse, s->settings.threads);
    sl_announce_pass(&s->announcer, "coarse mesh, second bounce", "for equation (7)");
    s->coarse_whole = true;
}

sl_status sl_multi_mesh_extend_coarse(sl_multi_mesh_state *s, sl_error *error) {
    size_t all = s->plan.coarse ? sl_coarse_vertex_count(s->coarse) : 0, left = all - s->coarse_done;
    size_t count = left < COARSE_VERTICES ? left : COARSE_VERTICES;
    sl_status status = SL_OK;
    if (s->coarse_indirect) gather_for_coarse(s, count);
    else if (count) light_coarse(s, count);
    s->coarse_done += count;
    if (status != SL_OK || s->coarse_done < all) return status;
    if (s->coarse_indirect) finish_second_bounce(s);
    else status = finish_direct(s, error);
    if (!s->coarse_whole) return status;
    sl_multi_mesh_announce_gather(s);
    s->phase = SL_PHASE_FIRST; /* of the indirect mesh */
    s->priorities_stale = true;
    return status;
}
