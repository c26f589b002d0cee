/* Multiple importance sampling (Veach and Guibas 1995). p_t is the density with which the way of t eye
 * vertices makes a path; the ways share the path by w_t = p_t^2 / sum p_i^2 (the power heuristic). Two ways
 * that are next to each other differ in who made one vertex:
 *
 *     p_(t+1) / p_t = pE(v_t) / pL(v_t),
 *
 * pE and pL the densities at v_t of walks from the eye and from the light. */
#include "trace/bidirectional/subpath.h"

/* v_i, and the densities at it of either walk. */
static const sl_path_vertex *vertex(const sl_connection *c, unsigned i) {
    return i < c->t ? &c->eye[i] : &c->light[c->s + c->t - 1 - i];
}

static double eye_density(const sl_connection *c, unsigned i) {
    if (i < c->t) return c->eye[i].pdf_forward;
    if (i == c->t) return c->light_last;
    if (i == c->t + 1) return c->light_before;
    return vertex(c, i)->pdf_reverse;
}

static double light_density(const sl_connection *c, unsigned i) {
    if (i >= c->t) return vertex(c, i)->pdf_forward;
    if (i + 1 == c->t) return c->eye_last;
    if (i + 2 == c->t) return c->eye_before;
    return c->eye[i].pdf_reverse;
}

/* The ways in which a path can have been made, and why. */
typedef struct ways {
    unsigned last;       /* m */
    unsigned first;      /* i of x1, the first vertex that is no mirror */
    bool delta_light;
    bool restricted;     /* some leg counts without visibility, which not every way can do */
} ways;

static ways ways_of(const sl_path_maker *m, const sl_connection *c) {
    ways w = {.last = c->s + c->t - 1, .first = 1};
    w.restricted = !(m->transport.direct_visibility && m->transport.bounce_visibility);
    if (c->s > 0) w.delta_light = sl_emission_is_delta(m, c->light[0].light);
    while (w.restricted && w.first < w.last && vertex(c, w.first)->kind == SL_VERTEX_MIRROR) w.first++;
    return w;
}

/* Where x1 sees the light without shadows, only a light sample does; where it sees x2 so, only the walk from
 * the eye. */
static bool sees_as_declared(const sl_path_maker *m, const ways *w, unsigned t) {
    unsigned s = w->last + 1 - t;
    if (w->first == w->last) return true;
    if (w->first + 1 < w->last) return m->transport.bounce_visibility || t >= w->first + 2;
    if (!m->transport.direct_visibility) return s == 1;
    return m->transport.bounce_visibility || s > 0;
}

static bool possible(const sl_path_maker *m, const sl_connection *c, const ways *w, unsigned t) {
    unsigned s = w->last + 1 - t;
    if (t < m->eye_vertices || t > SL_SUBPATH_VERTICES_MAX || s > SL_SUBPATH_VERTICES_MAX) return false;
    if (t == 1 && !(m->light_image && w->last >= 3)) return false;
    if (s == 0 ? w->delta_light
               : vertex(c, t - 1)->kind == SL_VERTEX_MIRROR || vertex(c, t)->kind == SL_VERTEX_MIRROR)
        return false;
    return !w->restricted || sees_as_declared(m, w, t);
}

double sl_connection_weight(const sl_path_maker *m, const sl_connection *c) {
    ways w = ways_of(m, c);
    if (!possible(m, c, &w, c->t)) return 0.0;
    double sum = 1.0, ratio = 1.0;
    for (unsigned t = c->t; t > m->eye_vertices; t--) { /* p_(t-1) / p_(c->t) */
        ratio *= light_density(c, t - 1) / eye_density(c, t - 1);
        if (possible(m, c, &w, t - 1)) sum += ratio * ratio;
    }
    ratio = 1.0;
    for (unsigned t = c->t; t <= w.last; t++) { /* p_(t+1) / p_(c->t) */
        ratio *= eye_density(c, t) / light_density(c, t);
        if (possible(m, c, &w, t + 1)) sum += ratio * ratio;
    }
    return sum <= DBL_MAX ? 1.0 / sum : 0.0;
}
