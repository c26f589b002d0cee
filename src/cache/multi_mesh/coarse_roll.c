/* The coarse mesh while things move: it rolls. Some of its vertices an update are lit anew, by lamps through
 * few rays, and by what they gather of all others as these are, so that with each turn light comes a bounce
 * further. Vertices take turns in a scattered order: what a gather sees is everywhere as old as anywhere
 * else. What was gathered from it follows by its vertices' irradiance, and gathers anew beside that. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <string.h>

#include "base/counters.h"
#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"

enum { MOST_VERTICES = 4 * SL_COARSE_VERTICES };

/* ---- what the vertices have, anywhere between them ---- */

/* Interpolates values of the coarse mesh's vertices at a place. False: there are none. */
static bool between_vertices(const sl_coarse *coarse, const sl_rgb *of_vertex, sl_root_place at,
                             sl_rgb *value) {
    if (!of_vertex || coarse->level[at.root] == SL_COARSE_ABSENT) return false;
    const int n = coarse->face[at.root].rows;
    double u = (double)at.u * n / SL_PATCH_DYADIC, v = (double)at.v * n / SL_PATCH_DYADIC;
    int i = (int)fmin(u, n - 1), j = (int)fmin(v, n - 1 - i);
    double a = u - i, b = v - j;
    bool on_head = a + b > 1.0 && i + j < n - 1;
    if (on_head) i++, j++, a = 1.0 - a, b = 1.0 - b;
    int step = on_head ? -1 : 1;
    const double weight[3] = {1.0 - a - b, a, b};
    const int corner[3][2] = {{i, j}, {i + step, j}, {i, j + step}};
    *value = sl_grey(0.0f);
    for (int k = 0; k < 3; k++) {
        if (weight[k] == 0.0) continue; /* of what has no light */
        uint32_t vertex = sl_coarse_lattice_vertex(coarse, at.root, corner[k][0], corner[k][1]);
        *value = sl_rgb_add(*value, sl_rgb_scale(of_vertex[vertex], (float)weight[k]));
    }
    return true;
}

/* ---- indirect light that was gathered from it ---- */

/* Scales a value that was gathered before the light around it changed, by at most MOST. Gathers of few pixels
 * are rough: where the coarse meshes have less than the scene's mean their difference says little. */
static float scaled(float value, float before, float now, float mean) {
    static const float MOST = 4.0f;
    if (!(before >= 0.0f) || !(now >= 0.0f) || !(mean > 0.0f)) return value;
    return value * fminf(fmaxf((now + mean) / (before + mean), 1.0f / MOST), MOST);
}

void sl_multi_mesh_carry(sl_multi_mesh_state *s, const sl_coarse_rounds *before,
                         const sl_coarse_rounds *now) {
    sl_displayed *d = s->part[SL_INDIRECT];
    for (uint32_t v = 0; v < d->mesh->vertex_count; v++) {
        sl_rgb was, is;
        sl_root_place at = d->mesh->vertex[v].place;
        if (!d->mesh->vertex[v].references || sl_mesh_state(d->mesh, v) != SL_VERTEX_KNOWN) continue;
        if (!between_vertices(before->coarse, before->indirect, at, &was) ||
            !between_vertices(now->coarse, now->indirect, at, &is))
            continue;
        float *value = sl_vertex_value(d->mesh, v);
        value[0] = scaled(value[0], was.r, is.r, s->ambient.r);
        value[1] = scaled(value[1], was.g, is.g, s->ambient.g);
        value[2] = scaled(value[2], was.b, is.b, s->ambient.b);
    }
    d->dirty_all = true;
    sl_displayed_age(d, SL_WORLDS_AN_EDIT, NULL);
}

/* ---- a turn ---- */

/* As fine as a still picture's if a turn takes few updates, half as fine if it does not. */
static sl_status make(const sl_multi_mesh_state *s, sl_coarse **coarse, sl_error *error) {
    sl_status status = sl_multi_mesh_make_coarse(s, 0, coarse, error);
    if (status != SL_OK || (*coarse)->vertex_count <= MOST_VERTICES) return status;
    sl_coarse_destroy(*coarse);
    return sl_multi_mesh_make_coarse(s, 1, coarse, error);
}

/* Gives a rolling mesh's vertices what the mesh before it has there. */
static void take_over(const sl_multi_mesh_state *s, sl_coarse_rounds *r) {
    const sl_coarse_rounds *before = &s->whole;
    const sl_rgb unknown = s->settings.bounces > 1 ? s->ambient_in_motion : sl_grey(0.0f);
    for (size_t v = 0; v < r->coarse->vertex_count; v++) {
        const sl_root_place at = r->coarse->vertex[v];
        if (!between_vertices(before->coarse, before->direct, at, &r->direct[v]))
            r->direct[v] = sl_grey(0.0f);
        if (!between_vertices(before->coarse, before->indirect, at, &r->indirect[v]))
            r->indirect[v] = unknown;
    }
}

static sl_status begin(sl_multi_mesh_state *s, sl_error *error) {
    sl_coarse_rounds r = {.rolls = true, .world = s->whole.world, .lit = s->whole.lit};
    sl_status status = make(s, &r.coarse, error);
    if (status != SL_OK) return status;
    r.direct = sl_allocate(r.coarse->vertex_count, sizeof *r.direct);
    r.indirect = sl_allocate(r.coarse->vertex_count, sizeof *r.indirect);
    if (!r.direct || !r.indirect) {
        sl_multi_mesh_forget_coarse(&r);
        return sl_fail_memory(error, "the coarse mesh");
    }
    take_over(s, &r);
    sl_multi_mesh_colour_coarse(s, &r);
    sl_multi_mesh_forget_coarse(&s->whole);
    s->whole = r;
    return SL_OK;
}

/* Returns the vertex whose turn it is: a prime above any number of them scatters all. */
static uint32_t vertex_in_turn(const sl_coarse_rounds *r, size_t turn) {
    return (uint32_t)((uint64_t)turn * 2654435761u % r->coarse->vertex_count);
}

static sl_status light_some(sl_multi_mesh_state *s, size_t count, sl_error *error) {
    sl_coarse_rounds *r = &s->whole;
    sl_root_place place[SL_COARSE_VERTICES];
    sl_mesh_point point[SL_COARSE_VERTICES];
    sl_rgb direct[SL_COARSE_VERTICES], indirect[SL_COARSE_VERTICES];
    sl_status status = SL_OK;
    if (count == 0) return SL_OK;
    for (size_t i = 0; i < count; i++) {
        place[i] = sl_coarse_lit_place(r->coarse, vertex_in_turn(r, r->done + i));
        point[i] = sl_mesh_point_at(s->primitives, place[i]);
        direct[i] = sl_grey(0.0f);
    }
    if (s->plan.lights) {
        sl_count(&s->counters, SL_COUNT_COARSE_SAMPLES, count);
        status = sl_coarse_light_take(&s->light, count, place, true, NULL, direct, &s->counters, error);
    }
    if (status == SL_OK)
        status = sl_multi_mesh_gather(s, r, SL_GATHER_A_QUARTER, count, point, indirect, error);
    for (size_t i = 0; i < count && status == SL_OK; i++) {
        uint32_t vertex = vertex_in_turn(r, r->done + i);
        r->direct[vertex] = direct[i];
        r->indirect[vertex] = indirect[i];
    }
    return status;
}

static sl_status light_and_carry(sl_multi_mesh_state *s, sl_error *error) {
    sl_coarse_rounds *r = &s->whole, before = *r;
    const size_t all = r->coarse->vertex_count, share = sl_multi_mesh_share(s, SL_COARSE_VERTICES),
                 count = r->left < share ? r->left : share;
    before.indirect = sl_allocate_unset(all, sizeof *before.indirect);
    if (!before.indirect) return sl_fail_memory(error, "the coarse mesh");
    memcpy(before.indirect, r->indirect, all * sizeof *before.indirect);
    sl_status status = light_some(s, count, error);
    if (status == SL_OK) {
        r->done = (r->done + count) % all;
        r->left -= count;
        sl_multi_mesh_colour_coarse(s, r);
        sl_multi_mesh_carry(s, &before, r);
    }
    sl_free(before.indirect);
    return status;
}

sl_status sl_multi_mesh_roll(sl_multi_mesh_state *s, sl_error *error) {
    sl_coarse_rounds *r = &s->whole;
    sl_multi_mesh_forget_coarse(&s->next); /* of light as it was */
    sl_status status = r->rolls ? SL_OK : begin(s, error);
    if (status != SL_OK) return status;
    if (r->rolls_to != s->lit) r->left = r->coarse->vertex_count;
    r->rolls_to = s->lit;
    status = light_and_carry(s, error);
    if (status != SL_OK || r->left) return status;
    r->lit = s->lit;
    r->world = s->world;
    sl_announce_pass(&s->announcer, "coarse mesh, one more bounce", "for equation (7)");
    return SL_OK;
}
