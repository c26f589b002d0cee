/* Light from polygons in closed form, with gradients: what gathers and shadow maps are held against. */
#pragma once

#include "base/math.h"
#include "cache/hemisphere/gather_tables.h"

/* An edge from a to b seen from the origin: its line's foot h, its unit direction, and the integrals of s^k /
 * (h^2 + s^2)^2 along it (k = 1: j1, k = 0: j2). False where there is no edge, or the origin lies on its
 * line. */
typedef struct edge {
    sl_vec3d foot, along;
    double distance, angle, j1, j2;
} edge;

static inline bool make_edge(sl_vec3d a, sl_vec3d b, edge *e) {
    sl_vec3d difference = sl_subd(b, a);
    double length = sl_lengthd(difference);
    if (!(length > 0.0)) return false;
    e->along = sl_scaled(difference, 1.0 / length);
    double s0 = sl_dotd(a, e->along), s1 = s0 + length;
    e->foot = sl_subd(a, sl_scaled(e->along, s0));
    double h = sl_lengthd(e->foot);
    if (!(h >= 1e-9 * length)) return false;
    double r0 = h * h + s0 * s0, r1 = h * h + s1 * s1;
    e->distance = h;
    e->angle = sl_atan2(length * h, h * h + s0 * s1);
    e->j1 = 0.5 * (1.0 / r0 - 1.0 / r1);
    e->j2 = (s1 / r1 - s0 / r0) / (2.0 * h * h) + e->angle / (2.0 * h * h * h);
    return true;
}

enum { POLYGON_MAX = 16, CLIPPED_MAX = 2 * POLYGON_MAX };

/* Sutherland and Hodgman: what of the polygon lies above the horizon n . v = 0. */
static inline int clip_to_horizon(sl_vec3d n, const sl_vec3d *in, int count, sl_vec3d *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        sl_vec3d a = in[i], b = in[(i + 1) % count];
        double ha = sl_dotd(n, a), hb = sl_dotd(n, b);
        if (ha >= 0.0) out[kept++] = a;
        if ((ha >= 0.0) != (hb >= 0.0)) out[kept++] = sl_addd(a, sl_scaled(sl_subd(b, a), ha / (ha - hb)));
    }
    return kept;
}

/* Twice the area along the normal of the shining side. */
static inline sl_vec3d polygon_normal(const sl_vec3d *v, int count) {
    sl_vec3d sum = {0.0, 0.0, 0.0};
    for (int i = 1; i + 1 < count; i++)
        sum = sl_addd(sum, sl_crossd(sl_subd(v[i], v[0]), sl_subd(v[i + 1], v[0])));
    return sum;
}

/* Irradiance at p with unit normal n from a one-sided Lambertian polygon of radiance 1 (vertices
 * counter-clockwise seen from its shining side), clipped to the horizon, and its gradient with respect to p;
 * gradient may be NULL. count <= 16. Lambert's formula: with the corners v_i of what is left as p sees them,
 * E = -n . sl_cell_vector(v). */
static inline double polygon_irradiance(sl_vec3d p, sl_vec3d n, const sl_vec3d *vertices, int count,
                                        sl_vec3d *gradient) {
    sl_vec3d relative[POLYGON_MAX], v[CLIPPED_MAX], sum = {0.0, 0.0, 0.0};
    if (gradient) *gradient = sum;
    if (count < 3 || count > POLYGON_MAX) return 0.0;
    for (int i = 0; i < count; i++) relative[i] = sl_subd(vertices[i], p);
    /* seen from behind, or edge-on */
    if (!(sl_dotd(polygon_normal(relative, count), relative[0]) < 0.0)) return 0.0;
    int kept = clip_to_horizon(n, relative, count, v);
    for (int i = 0; gradient && i < kept; i++) {
        /* Lambert's formula wants the order that is clockwise for the receiver: each edge backwards. */
        edge e;
        if (!make_edge(v[(i + 1) % kept], v[i], &e)) continue;
        sl_vec3d turn = sl_scaled(sl_crossd(n, e.along), e.angle / e.distance);
        double swing = 2.0 * sl_dotd(n, sl_crossd(e.foot, e.along));
        sl_vec3d slide = sl_addd(sl_scaled(e.foot, e.j2), sl_scaled(e.along, e.j1));
        sum = sl_addd(sum, sl_addd(turn, sl_scaled(slide, swing)));
    }
    if (gradient) *gradient = sl_scaled(sum, 0.5);
    double irradiance = -sl_dotd(n, sl_cell_vector(v, kept));
    return irradiance > 0.0 ? irradiance : 0.0;
}
