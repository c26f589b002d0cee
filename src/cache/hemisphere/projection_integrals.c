#include "cache/hemisphere/projection_integrals.h"

#include <math.h>
#include <string.h>

#include "base/math.h"
#include "cache/hemisphere/quadrature.h"

static void make_rule(sl_rule *rule, int count) {
    rule->count = count;
    sl_gauss_legendre(count, rule->node, rule->weight);
}

/* The wider the cells the more nodes: the sums over all cells come out to 1e-12 up to 128 cells a side,
 * beyond to 1e-9. */
static int nodes_across(int size, sl_gather_kind kind) {
    /* below 16, 32, 64, ... 1024; beyond */
    const int plane[8] = {16, 9, 6, 4, 3, 3, 2, 2}, others[8] = {16, 9, 6, 6, 4, 3, 3, 2};
    int i = 0;
    for (int limit = 16; size >= limit && i < 7; limit *= 2) i++;
    return kind == SL_GATHER_PLANE ? plane[i] : others[i];
}

sl_instrument sl_instrument_of(const sl_gather_tables *tables, double half_tangent, sl_border border,
                               int order) {
    sl_instrument in = {.kind = tables->kind,
                        .size = tables->size,
                        .width = tables->width,
                        .half_tangent = half_tangent,
                        .border = border,
                        .order = order};
    sl_hsh_recurrence_of(order, &in.recurrence);
    make_rule(&in.fine, SL_RULE_MAX);
    make_rule(&in.coarse, nodes_across(in.size, in.kind));
    return in;
}

/* A sum under way. Half of every instrument is the other half with x and y exchanged. */
typedef struct integral {
    const sl_instrument *in;
    bool exchanged;
    double *sums;
} integral;

/* direction: of any length */
static void add_point(const integral *q, sl_vec3d d, double weight) {
    double values[SL_HSH_STRIDE_MAX], scale = 1.0 / sl_lengthd(d);
    size_t stride = sl_hsh_stride(q->in->order);
    sl_hsh_evaluate_by(&q->in->recurrence, sl_scaled(q->exchanged ? sl_v3d(d.y, d.x, d.z) : d, scale),
                       values);
    for (size_t i = 0; i < stride; i++) q->sums[i] += weight * values[i];
}

static double inverse_cube(sl_vec3d d) {
    double squared = sl_dotd(d, d);
    return 1.0 / (squared * sqrt(squared));
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* A range of both coordinates. */
typedef struct range {
    double a0, a1, b0, b1;
} range;

static range exchange(range r) { return (range){r.b0, r.b1, r.a0, r.a1}; }

/* The plane at unit distance, and the hemicube's top: d omega = du dv / l^3. */
static void add_plane_cell(const integral *q, range r) {
    const sl_rule *g = &q->in->coarse;
    for (int i = 0; i < g->count; i++) {
        for (int j = 0; j < g->count; j++) {
            sl_vec3d d = sl_v3d(r.a0 + (r.a1 - r.a0) * g->node[i], r.b0 + (r.b1 - r.b0) * g->node[j], 1.0);
            add_point(q, d, g->weight[i] * g->weight[j] * (r.a1 - r.a0) * (r.b1 - r.b0) * inverse_cube(d));
        }
    }
}

/* An upright face at distance t, b sideways, z from the top down: the hemicube's sides, and the radial
 * extension of the plane's outer edge, from z = 1 down to the horizon. H with odd m goes like the root of the
 * cosine, so the integral is over x, z = x^2. */
static void add_side_cell(const integral *q, double t, double b0, double b1, double top, double bottom) {
    double x0 = sqrt(bottom), x1 = sqrt(top);
    const sl_rule *g = &q->in->coarse, *f = bottom < 0.1 ? &q->in->fine : g;
    for (int i = 0; i < f->count; i++) {
        double x = x0 + (x1 - x0) * f->node[i];
        for (int j = 0; j < g->count; j++) {
            sl_vec3d d = sl_v3d(t, b0 + (b1 - b0) * g->node[j], x * x);
            add_point(q, d,
                      f->weight[i] * g->weight[j] * (x1 - x0) * 2.0 * x * (b1 - b0) * t * inverse_cube(d));
        }
    }
}

/* The concentric map where a > b: sin theta = a, phi = (pi / 4) b / a, d omega = (pi / 4) d theta db. Near
 * the horizon the integral is over the root of the cosine. A cell on the diagonal is cut by it. */
static void add_disc_cell(const integral *q, range r) {
    bool low = r.a1 > 0.9;
    double c0 = sqrt(1.0 - r.a0 * r.a0), c1 = sqrt(fmax(0.0, 1.0 - r.a1 * r.a1));
    double from = low ? sqrt(c1) : sl_asin(r.a0), to = low ? sqrt(c0) : sl_asin(r.a1);
    const sl_rule *g = &q->in->coarse, *f = low ? &q->in->fine : g;
    if (r.a1 <= r.b0) return;
    for (int i = 0; i < f->count; i++) {
        double x = from + (to - from) * f->node[i], c = low ? x * x : sl_cos(x),
               s = low ? sqrt(1.0 - c * c) : sl_sin(x);
        double stretch = low ? 2.0 * x / s : 1.0, height = fmin(r.b1, s) - r.b0;
        for (int j = 0; j < g->count && height > 0.0; j++) {
            double azimuth = 0.25 * SL_PI * (r.b0 + height * g->node[j]) / s;
            add_point(q, sl_v3d(s * sl_cos(azimuth), s * sl_sin(azimuth), c),
                      f->weight[i] * g->weight[j] * (to - from) * stretch * 0.25 * SL_PI * height);
        }
    }
}

/* Grid lines from -1 to 1 (rays), -t to t (plane), -2 to 2 (hemicube). */
static double grid_line(const sl_instrument *in, int i) {
    double half = in->kind == SL_GATHER_PLANE ? in->half_tangent : in->kind == SL_GATHER_HEMICUBE ? 2.0 : 1.0;
    return half * (2.0 * i - in->width) / in->width;
}

static range cell_range(const sl_instrument *in, int x, int y) {
    return (range){fmax(0.0, grid_line(in, x)), grid_line(in, x + 1), fmax(0.0, grid_line(in, y)),
                   grid_line(in, y + 1)};
}

void sl_cell_harmonics(const sl_instrument *in, int x, int y, double *sums) {
    range r = cell_range(in, x, y);
    integral q = {in, false, sums}, exchanged = {in, true, sums};
    memset(sums, 0, sl_hsh_stride(in->order) * sizeof *sums);
    if (in->kind == SL_GATHER_PLANE) {
        bool right = x == in->width - 1, top = y == in->width - 1;
        add_plane_cell(&q, r);
        if (in->border == SL_BORDER_RADIAL && right)
            add_side_cell(&q, in->half_tangent, r.b0, r.b1, 1.0, 0.0);
        if (in->border == SL_BORDER_RADIAL && top)
            add_side_cell(&exchanged, in->half_tangent, r.a0, r.a1, 1.0, 0.0);
    } else if (in->kind == SL_GATHER_HEMICUBE) {
        if (r.a1 > 1.0 && r.a0 >= 1.0) add_side_cell(&q, 1.0, r.b0, r.b1, 2.0 - r.a0, 2.0 - r.a1);
        else if (r.b0 >= 1.0) add_side_cell(&exchanged, 1.0, r.a0, r.a1, 2.0 - r.b0, 2.0 - r.b1);
        else add_plane_cell(&q, r);
    } else {
        add_disc_cell(&q, r);
        add_disc_cell(&exchanged, exchange(r));
    }
}

/* ---- walls ----------------------------------------------------------------------------------- */

/* The point w of a wall, |w| = 1, at distance r is seen to move by -delta_perp / r; an element dw of the arc
 * sweeps the solid angle (dw x w) . delta / r for what lies to its right. m: dw x w, tangential part. */
static void add_wall_point(const integral *q, sl_wall *wall, double *total, sl_vec3d d, double mx,
                           double my) {
    double size = sqrt(mx * mx + my * my);
    wall->x += q->exchanged ? my : mx;
    wall->y += q->exchanged ? mx : my;
    *total += size;
    add_point(q, d, size);
}

/* A straight edge from a to b, at depth 1: (e x d) / l^3 an element, and e x d is the same all along. One
 * that starts at the horizon is summed over the root of its height. */
static void add_edge(const integral *q, sl_wall *wall, double *total, sl_vec3d a, sl_vec3d b) {
    bool rooted = !(a.z > 0.0);
    const sl_rule *g = rooted ? &q->in->fine : &q->in->coarse;
    sl_vec3d e = sl_subd(b, a), normal = sl_crossd(e, a);
    for (int i = 0; i < g->count; i++) {
        double x = g->node[i];
        sl_vec3d d = sl_addd(a, sl_scaled(e, rooted ? x * x : x));
        double weight = g->weight[i] * (rooted ? 2.0 * x : 1.0) * inverse_cube(d);
        add_wall_point(q, wall, total, d, weight * normal.x, weight * normal.y);
    }
}

/* The concentric map's line a = const, b from b0 to b1: a ring where a > b, else a spiral phi = pi/2 - (pi/4)
 * a / sin theta along which w x dw is -d theta v + d phi sin theta cos theta u (u, v: tangential unit vectors
 * at phi and phi + pi/2). */
static void add_disc_line(const integral *q, sl_wall *wall, double *total, double a, double b0, double b1) {
    const sl_rule *g = &q->in->coarse;
    bool ring = a >= b1;
    double from = ring ? 0.25 * SL_PI * b0 / a : sl_asin(b0), to = ring ? 0.25 * SL_PI * b1 / a : sl_asin(b1);
    for (int i = 0; i < g->count; i++) {
        double x = from + (to - from) * g->node[i], weight = (to - from) * g->weight[i];
        double s = ring ? a : sl_sin(x), c = sqrt(fmax(0.0, 1.0 - s * s));
        double azimuth = ring ? x : 0.5 * SL_PI - 0.25 * SL_PI * a / s;
        double cos_phi = sl_cos(azimuth), sin_phi = sl_sin(azimuth);
        double outwards = ring ? s * c : 0.25 * SL_PI * a * c * c / s, backwards = ring ? 0.0 : 1.0;
        double mx = outwards * cos_phi + backwards * sin_phi, my = outwards * sin_phi - backwards * cos_phi;
        add_wall_point(q, wall, total, sl_v3d(s * cos_phi, s * sin_phi, c), weight * mx, weight * my);
    }
}

/* The wall a = const from b0 up to b1. */
static void add_column_wall(const integral *q, sl_wall *wall, double *total, double a, double b0, double b1) {
    if (q->in->kind == SL_GATHER_RAYS) {
        add_disc_line(q, wall, total, a, b0, b1);
    } else if (q->in->kind == SL_GATHER_HEMICUBE && a > 1.0) {
        add_edge(q, wall, total, sl_v3d(1.0, b0, 2.0 - a), sl_v3d(1.0, b1, 2.0 - a));
    } else if (q->in->kind == SL_GATHER_HEMICUBE && b0 >= 1.0) {
        add_edge(q, wall, total, sl_v3d(a, 1.0, 2.0 - b0), sl_v3d(a, 1.0, 2.0 - b1));
    } else {
        add_edge(q, wall, total, sl_v3d(a, b0, 1.0), sl_v3d(a, b1, 1.0));
    }
}

void sl_wall_harmonics(const sl_instrument *in, sl_wall_type type, int x, int y, sl_wall *wall) {
    integral q = {in, type == SL_WALL_ROW, wall->mean};
    double total = 0.0, half = 1.0;
    memset(wall, 0, sizeof *wall);
    if (type >= SL_WALL_BORDER_COLUMN) {
        bool column = type == SL_WALL_BORDER_COLUMN;
        double line = grid_line(in, column ? x : y);
        q.exchanged = column;
        if (line <= 0.0) half = 0.5;
        /* What stands there is taken to be upright, at the distance that it has at depth 1. */
        add_edge(&q, wall, &total, sl_v3d(in->half_tangent, line, 0.0), sl_v3d(in->half_tangent, line, 1.0));
    } else {
        range r = cell_range(in, x, y);
        double line = grid_line(in, type == SL_WALL_ROW ? y : x);
        if (line <= 0.0) half = 0.5; /* on the axis: its mirror image is itself */
        if (type == SL_WALL_ROW) r = exchange(r);
        add_column_wall(&q, wall, &total, line, r.b0, r.b1);
    }
    if (!(total > 0.0)) return;
    size_t stride = sl_hsh_stride(in->order);
    for (size_t i = 0; i < stride; i++) wall->mean[i] /= total;
    wall->x *= half;
    wall->y *= half;
}
