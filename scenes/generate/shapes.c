/* The shapes that the scenes are built of: grids, boxes, surfaces of revolution, swept profiles, balls. */
#include "mesh.h"

#include <math.h>
#include <stdlib.h>

#include "base/math.h"

/* ---- grids ----------------------------------------------------------------------------------- */

typedef struct grid {
    const v3 *points;
    int columns, rows, cells_u, cells_v;
    unsigned flags;
} grid;

static size_t at(const grid *g, int column, int row) {
    return (size_t)(row % g->rows) * (size_t)g->columns + (size_t)(column % g->columns);
}

static v3 facet_normal(v3 a, v3 b, v3 c) { return gen_cross(gen_sub(b, a), gen_sub(c, a)); }

/* A cell's two triangles as corners (column, row), in the order that shows the visible side. */
static void cell_corners(const grid *g, int c, int r, size_t corner[2][3]) {
    size_t a = at(g, c, r), b = at(g, c + 1, r), d = at(g, c + 1, r + 1), e = at(g, c, r + 1);
    bool flip = (g->flags & GEN_FLIP) != 0;
    corner[0][0] = a, corner[0][1] = flip ? d : b, corner[0][2] = flip ? b : d;
    corner[1][0] = a, corner[1][1] = flip ? e : d, corner[1][2] = flip ? d : e;
}

static bool same_point(v3 a, v3 b) { return fabs(a.x - b.x) + fabs(a.y - b.y) + fabs(a.z - b.z) < 1e-6; }

/* A row that is one point (a pole) has one normal: the sum of its copies'. */
static void join_pole(const grid *g, int row, v3 *normal) {
    v3 sum = {0, 0, 0};
    for (int c = 0; c < g->columns; c++) {
        if (!same_point(g->points[at(g, c, row)], g->points[at(g, 0, row)])) return;
        sum = gen_add(sum, normal[at(g, c, row)]);
    }
    for (int c = 0; c < g->columns; c++) normal[at(g, c, row)] = sum;
}

static v3 *smooth_normals(const grid *g) {
    size_t count = (size_t)g->columns * (size_t)g->rows;
    v3 *normal = gen_allocate(count * sizeof *normal);
    for (size_t i = 0; i < count; i++) normal[i] = gen_v3(0, 0, 0);
    for (int r = 0; r < g->cells_v; r++) {
        for (int c = 0; c < g->cells_u; c++) {
            size_t corner[2][3];
            cell_corners(g, c, r, corner);
            for (int t = 0; t < 2; t++) {
                v3 n =
                    facet_normal(g->points[corner[t][0]], g->points[corner[t][1]], g->points[corner[t][2]]);
                for (int i = 0; i < 3; i++) normal[corner[t][i]] = gen_add(normal[corner[t][i]], n);
            }
        }
    }
    join_pole(g, 0, normal);
    join_pole(g, g->rows - 1, normal);
    return normal;
}

void gen_grid(mesh *m, const v3 *points, int columns, int rows, unsigned flags) {
    grid g = {points, columns, rows, flags & GEN_WRAP_COLUMNS ? columns : columns - 1,
              flags & GEN_WRAP_ROWS ? rows : rows - 1, flags};
    size_t count = (size_t)columns * (size_t)rows;
    gen_corner *corners = gen_allocate(count * sizeof *corners);
    v3 *normal = flags & GEN_FLAT ? NULL : smooth_normals(&g);
    for (size_t i = 0; i < count; i++) {
        corners[i].position = gen_position(m, points[i]);
        corners[i].normal = normal ? gen_normal(m, normal[i]) : 0;
    }
    for (int r = 0; r < g.cells_v; r++) {
        for (int c = 0; c < g.cells_u; c++) {
            size_t corner[2][3];
            cell_corners(&g, c, r, corner);
            for (int t = 0; t < 2; t++) {
                gen_corner f[3] = {corners[corner[t][0]], corners[corner[t][1]], corners[corner[t][2]]};
                if (!normal) {
                    v3 n = facet_normal(points[corner[t][0]], points[corner[t][1]], points[corner[t][2]]);
                    if (gen_dot(n, n) == 0.0) continue;
                    f[0].normal = f[1].normal = f[2].normal = gen_normal(m, n);
                }
                gen_face(m, f[0], f[1], f[2]);
            }
        }
    }
    free(normal);
    free(corners);
}

void gen_surface(mesh *m, int nu, int nv, unsigned flags, gen_surface_function f, const void *context) {
    int columns = flags & GEN_WRAP_COLUMNS ? nu : nu + 1, rows = flags & GEN_WRAP_ROWS ? nv : nv + 1;
    v3 *points = gen_allocate((size_t)columns * (size_t)rows * sizeof *points);
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < columns; c++)
            points[(size_t)r * (size_t)columns + (size_t)c] = f((double)c / nu, (double)r / nv, context);
    gen_grid(m, points, columns, rows, flags);
    free(points);
}

/* ---- flat shapes ----------------------------------------------------------------------------- */

void gen_triangle(mesh *m, v3 a, v3 b, v3 c) {
    uint32_t n = gen_normal(m, facet_normal(a, b, c));
    gen_corner ca = {gen_position(m, a), n}, cb = {gen_position(m, b), n}, cc = {gen_position(m, c), n};
    gen_face(m, ca, cb, cc);
}

void gen_panel(mesh *m, v3 a, v3 b, v3 c, v3 d, int nu, int nv) {
    v3 *points = gen_allocate((size_t)(nu + 1) * (size_t)(nv + 1) * sizeof *points);
    for (int j = 0; j <= nv; j++)
        for (int i = 0; i <= nu; i++) {
            double u = (double)i / nu, v = (double)j / nv;
            points[j * (nu + 1) + i] = gen_lerp(gen_lerp(a, b, u), gen_lerp(d, c, u), v);
        }
    gen_grid(m, points, nu + 1, nv + 1, GEN_FLAT);
    free(points);
}

void gen_quad(mesh *m, v3 a, v3 b, v3 c, v3 d) { gen_panel(m, a, b, c, d, 1, 1); }

void gen_box(mesh *m, v3 l, v3 h) {
    gen_quad(m, gen_v3(l.x, l.y, h.z), gen_v3(h.x, l.y, h.z), gen_v3(h.x, h.y, h.z), gen_v3(l.x, h.y, h.z));
    gen_quad(m, gen_v3(h.x, l.y, l.z), gen_v3(l.x, l.y, l.z), gen_v3(l.x, h.y, l.z), gen_v3(h.x, h.y, l.z));
    gen_quad(m, gen_v3(h.x, l.y, h.z), gen_v3(h.x, l.y, l.z), gen_v3(h.x, h.y, l.z), gen_v3(h.x, h.y, h.z));
    gen_quad(m, gen_v3(l.x, l.y, l.z), gen_v3(l.x, l.y, h.z), gen_v3(l.x, h.y, h.z), gen_v3(l.x, h.y, l.z));
    gen_quad(m, gen_v3(l.x, h.y, h.z), gen_v3(h.x, h.y, h.z), gen_v3(h.x, h.y, l.z), gen_v3(l.x, h.y, l.z));
    gen_quad(m, gen_v3(l.x, l.y, l.z), gen_v3(h.x, l.y, l.z), gen_v3(h.x, l.y, h.z), gen_v3(l.x, l.y, h.z));
}

/* Each of the 8 corners is three points, one on each of the faces that meet there: corner c (bit i: high in
 * axis i) on the face across axis a is entry 3 c + a, with that face's normal, so that the bevels between
 * look round. */
typedef struct bevel { gen_corner corner[24]; v3 point[24]; v3 middle; } bevel;

static void bevel_triangle(mesh *m, const bevel *b, int i, int j, int k) {
    v3 n = facet_normal(b->point[i], b->point[j], b->point[k]);
    bool outwards = gen_dot(n, gen_sub(b->point[i], b->middle)) > 0.0;
    gen_face(m, b->corner[i], b->corner[outwards ? j : k], b->corner[outwards ? k : j]);
}

static void bevel_quad(mesh *m, const bevel *b, int i, int j, int k, int l) {
    bevel_triangle(m, b, i, j, k);
    bevel_triangle(m, b, i, k, l);
}

void gen_bevel_box(mesh *m, v3 low, v3 high, double size) {
    bevel b = {.middle = gen_scale(gen_add(low, high), 0.5)};
    for (int c = 0; c < 8; c++)
        for (int a = 0; a < 3; a++) {
            double s[3], p[3], n[3] = {0, 0, 0};
            for (int i = 0; i < 3; i++) s[i] = (c >> i & 1 ? -1.0 : 1.0) * (i == a ? 0.0 : size);
            p[0] = (c & 1 ? high.x : low.x) + s[0];
            p[1] = (c & 2 ? high.y : low.y) + s[1];
            p[2] = (c & 4 ? high.z : low.z) + s[2];
            n[a] = c >> a & 1 ? 1.0 : -1.0;
            b.point[3 * c + a] = gen_v3(p[0], p[1], p[2]);
            b.corner[3 * c + a].position = gen_position(m, b.point[3 * c + a]);
            b.corner[3 * c + a].normal = gen_normal(m, gen_v3(n[0], n[1], n[2]));
        }
    for (int a = 0; a < 3; a++) {
        int u = 1 << (a + 1) % 3, v = 1 << (a + 2) % 3, w = 1 << a, e = (a + 1) % 3, f = (a + 2) % 3;
        for (int side = 0; side <= w; side += w) /* the faces across axis a */
            bevel_quad(m, &b, 3 * side + a, 3 * (side | u) + a, 3 * (side | u | v) + a, 3 * (side | v) + a);
        for (int edge = 0; edge < 4; edge++) { /* the edges along axis a, between the faces across e and f */
            int c = (edge & 1 ? u : 0) | (edge & 2 ? v : 0);
            bevel_quad(m, &b, 3 * c + e, 3 * (c | w) + e, 3 * (c | w) + f, 3 * c + f);
        }
    }
    for (int c = 0; c < 8; c++) bevel_triangle(m, &b, 3 * c, 3 * c + 1, 3 * c + 2);
}

void gen_stone(mesh *m, v3 a, v3 b, v3 c, v3 d, double height) {
    v3 base[4] = {a, b, c, d}, top[4];
    v3 out = gen_scale(gen_unit(facet_normal(a, b, c)), height);
    v3 middle = gen_scale(gen_add(gen_add(a, b), gen_add(c, d)), 0.25);
    for (int i = 0; i < 4; i++) {
        v3 inwards = gen_unit(gen_sub(middle, base[i]));
        top[i] = gen_add(gen_add(base[i], gen_scale(inwards, 1.4 * height)), out);
    }
    gen_quad(m, top[0], top[1], top[2], top[3]);
    for (int i = 0; i < 4; i++) gen_quad(m, base[i], base[(i + 1) % 4], top[(i + 1) % 4], top[i]);
}

/* ---- revolution and sweeps ------------------------------------------------------------------- */

/* Calls of `piece` for the stretches of a profile between its sharp edges. */
static int piece_end(const v2 *p, int from, int count) {
    int end = from + 1;
    while (end < count && !(p[end].x == p[end - 1].x && p[end].y == p[end - 1].y)) end++;
    return end;
}

void gen_lathe(mesh *m, const v2 *profile, int count, int segments) {
    for (int from = 0, end; from < count; from = end) {
        end = piece_end(profile, from, count);
        int rows = end - from;
        if (rows < 2) continue;
        v3 *points = gen_allocate((size_t)rows * (size_t)segments * sizeof *points);
        for (int r = 0; r < rows; r++)
            for (int s = 0; s < segments; s++) {
                double angle = 2.0 * SL_PI * s / segments, radius = profile[from + r].x;
                points[r * segments + s] =
                    gen_v3(radius * sl_cos(angle), profile[from + r].y, -radius * sl_sin(angle));
            }
        gen_grid(m, points, segments, rows, GEN_WRAP_COLUMNS);
        free(points);
    }
}

/* To the right of the path at point i, as long as a mitre asks for. */
static v3 right_of_path(const v3 *path, int count, bool closed, int i, v3 normal) {
    int before = i > 0    ? i - 1
                 : closed ? count - 1
                          : 0,
        after = i < count - 1 ? i + 1
                : closed      ? 0
                              : count - 1;
    v3 in = gen_unit(gen_sub(path[i], path[before])), out = gen_unit(gen_sub(path[after], path[i]));
    if (before == i) in = out;
    if (after == i) out = in;
    v3 right_in = gen_unit(gen_cross(in, normal)), right_out = gen_unit(gen_cross(out, normal));
    v3 right = gen_unit(gen_add(right_in, right_out));
    return gen_scale(right, 1.0 / gen_max(gen_dot(right, right_in), 0.3));
}

void gen_sweep(mesh *m, const v3 *path, int path_count, v3 normal, const v2 *profile, int count,
               unsigned flags) {
    v3 up = gen_unit(normal);
    for (int from = 0, end; from < count; from = end) {
        end = piece_end(profile, from, count);
        int rows = end - from;
        if (rows < 2) continue;
        v3 *points = gen_allocate((size_t)rows * (size_t)path_count * sizeof *points);
        for (int i = 0; i < path_count; i++) {
            v3 right = right_of_path(path, path_count, (flags & GEN_WRAP_COLUMNS) != 0, i, up);
            for (int r = 0; r < rows; r++) {
                v2 p = profile[from + r];
                points[r * path_count + i] =
                    gen_add(path[i], gen_add(gen_scale(right, p.x), gen_scale(up, p.y)));
            }
        }
        gen_grid(m, points, path_count, rows, flags);
        free(points);
    }
}

void gen_rod(mesh *m, v3 from, v3 to, double radius_from, double radius_to, int segments) {
    v3 axis = gen_sub(to, from), up = gen_unit(axis);
    v3 helper = fabs(up.y) < 0.9 ? gen_v3(0, 1, 0) : gen_v3(1, 0, 0);
    v3 x = gen_unit(gen_cross(helper, up)), z = gen_cross(x, up);
    frame before = gen_move(m, from.x, from.y, from.z), moved = m->frame;
    v3 axes[3] = {x, up, z}, world[3];
    for (int i = 0; i < 3; i++)
        world[i] = gen_add(gen_add(gen_scale(moved.x, axes[i].x), gen_scale(moved.y, axes[i].y)),
                           gen_scale(moved.z, axes[i].z));
    m->frame.x = world[0], m->frame.y = world[1], m->frame.z = world[2];
    double length = gen_length(axis);
    v2 profile[] = {{0, 0},     {radius_from, 0}, {radius_from, 0}, {radius_to, length}, {radius_to, length},
                    {0, length}};
    gen_lathe(m, profile, 6, segments);
    m->frame = before;
}

void gen_ball(mesh *m, v3 centre, v3 radii, int segments, int rings, double rough, uint32_t seed) {
    v3 *points = gen_allocate((size_t)segments * (size_t)(rings + 1) * sizeof *points);
    for (int r = 0; r <= rings; r++) {
        double latitude = SL_PI * ((double)r / rings - 0.5);
        double across = r == 0 || r == rings ? 0.0 : sl_cos(latitude), height = sl_sin(latitude);
        for (int s = 0; s < segments; s++) {
            double angle = 2.0 * SL_PI * s / segments;
            v3 d = gen_v3(across * sl_cos(angle), height, -across * sl_sin(angle));
            double stretch = 1.0 + (rough > 0.0 ? rough * gen_fractal(gen_scale(d, 2.0), 3, seed) : 0.0);
            v3 p = gen_v3(d.x * radii.x * stretch, d.y * radii.y * stretch, d.z * radii.z * stretch);
            points[r * segments + s] = gen_add(centre, p);
        }
    }
    gen_grid(m, points, segments, rings + 1, GEN_WRAP_COLUMNS);
    free(points);
}

/* ---- profiles -------------------------------------------------------------------------------- */

void gen_to(outline *o, double x, double y) {
    if (o->count < (int)(sizeof o->p / sizeof o->p[0])) o->p[o->count++] = (v2){x, y};
}

void gen_sharp(outline *o, double x, double y) {
    gen_to(o, x, y);
    gen_to(o, x, y);
}

void gen_arc(outline *o, double cx, double cy, double rx, double ry, double from_deg, double to_deg,
             int steps) {
    for (int i = 0; i <= steps; i++) {
        double angle = gen_mix(from_deg, to_deg, (double)i / steps) * SL_PI / 180.0;
        gen_to(o, cx + rx * sl_cos(angle), cy + ry * sl_sin(angle));
    }
}
