/* The coarse mesh while things move: it rolls. Some of its vertices an update are lit anew, by lamps through
 * few rays, and by what they gather of all others as these are, so that with each turn light comes a bounce
 * further. Those that stand for large areas come first, and most often. What was gathered from it follows by
 * its vertices' irradiance, and gathers anew beside that. */
#include "cache/multi_mesh/multi_mesh_internal.h"

#include <string.h>

#include "base/code_sort.h"
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
    const size_t count = r.coarse->vertex_count;
    r.direct = sl_allocate(count, sizeof *r.direct);
    r.indirect = sl_allocate(count, sizeof *r.indirect);
    r.area = sl_allocate(count, sizeof *r.area);
    r.lit_in = sl_allocate(count, sizeof *r.lit_in);
    if (!r.direct || !r.indirect || !r.area || !r.lit_in) {
        sl_multi_mesh_forget_coarse(&r);
        return sl_fail_memory(error, "the coarse mesh");
    }
    sl_coarse_areas(r.coarse, r.area);
    take_over(s, &r);
    sl_multi_mesh_colour_coarse(s, &r);
    sl_multi_mesh_forget_coarse(&s->whole);
    s->whole = r;
    return SL_OK;
}

/* Gathers see areas, and errors grow with age: as of the Shading Cache's corners (renewal.c), those come
 * first that have the greatest area age^3. Those of one area and age come in a scattered order. */
static sl_coded turn_of(const sl_coarse_rounds *r, uint32_t vertex) {
    const float age = (float)(r->updates - r->lit_in[vertex]), urgency = r->area[vertex] * age * age * age;
    return (sl_coded){(uint64_t)~sl_float_bits(urgency) << 32 | (vertex + 1) * 2654435761u, vertex};
}

/* Returns how many vertices are from before the last edit; the most urgent ones first. */
static size_t list_old(const sl_coarse_rounds *r, sl_coded *list) {
    size_t count = 0;
    for (size_t v = 0; v < r->coarse->vertex_count; v++)
        if (r->lit_in[v] < r->old) list[count++] = turn_of(r, (uint32_t)v);
    sl_sort_coded(list, count);
    return count;
}

static sl_status light_some(sl_multi_mesh_state *s, size_t count, const sl_coded *turn, sl_error *error) {
    sl_coarse_rounds *r = &s->whole;
    sl_root_place place[SL_COARSE_VERTICES];
    sl_mesh_point point[SL_COARSE_VERTICES];
    sl_rgb direct[SL_COARSE_VERTICES], indirect[SL_COARSE_VERTICES];
    sl_status status = SL_OK;
    if (count == 0) return SL_OK;
    for (size_t i = 0; i < count; i++) {
        place[i] = sl_coarse_lit_place(r->coarse, turn[i].item);
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
        r->direct[turn[i].item] = direct[i];
        r->indirect[turn[i].item] = indirect[i];
        r->lit_in[turn[i].item] = r->updates;
    }
    return status;
}

/* left: how many vertices are older than the last edit. */
static sl_status light_and_carry(sl_multi_mesh_state *s, sl_coded *turn, sl_rgb *indirect, size_t *left,
                                 sl_error *error) {
    sl_coarse_rounds *r = &s->whole, before = *r;
    const size_t old = list_old(r, turn), count = sl_fewer(old, sl_multi_mesh_share(s, SL_COARSE_VERTICES));
    before.indirect = memcpy(indirect, r->indirect, r->coarse->vertex_count * sizeof *indirect);
    *left = old - count;
    sl_status status = light_some(s, count, turn, error);
    if (status != SL_OK) return status;
    sl_multi_mesh_colour_coarse(s, r);
    sl_multi_mesh_carry(s, &before, r);
    return SL_OK;
}

sl_status sl_multi_mesh_roll(sl_multi_mesh_state *s, sl_error *error) {
    sl_coarse_rounds *r = &s->whole;
    sl_multi_mesh_forget_coarse(&s->next); /* of light as it was */
    sl_status status = r->rolls ? SL_OK : begin(s, error);
    if (status != SL_OK) return status;
    r->updates++;
    if (r->rolls_to != s->lit) r->old = r->updates;
    r->rolls_to = s->lit;
    const size_t all = r->coarse->vertex_count;
    size_t left = 0;
    sl_coded *turn = sl_allocate_unset(all, sizeof *turn);
    sl_rgb *indirect = sl_allocate_unset(all, sizeof *indirect);
    status = turn && indirect ? light_and_carry(s, turn, indirect, &left, error)
                              : sl_fail_memory(error, "the coarse mesh");
    SL_FREE_ALL(turn, indirect);
    if (status != SL_OK || left) return status;
    r->lit = s->lit;
    r->world = s->world;
    sl_announce_pass(&s->announcer, "coarse mesh, one more bounce", "for equation (7)");
    return SL_OK;
}
