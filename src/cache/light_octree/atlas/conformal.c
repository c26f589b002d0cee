/* A chart in the plane by least squares conformal maps (Levy et al. 2002). With a face's corners x_j + i y_j
 * in its own plane and U_j = u_j + i v_j in the chart's, the map of the face is conformal where W_1 U_1 + W_2
 * U_2 + W_3 U_3 = 0, W_1 = (x_3 - x_2) + i (y_3 - y_2) and so on; the sum of |.|^2 / (2 area) over the faces
 * is minimised with two border vertices pinned. As a form in complex numbers that is Hermitian: H_jk = sum of
 * conj(W_j) W_k / (2 area). The first guess is the projection along the chart's normal: for a planar chart it
 * is the answer. */
#include "cache/light_octree/atlas/parts.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

#define TOLERANCE 1e-10
/* A sliver's weight 1 / (2 area) is held below what a face of this height over its longest edge has. */
#define THINNEST 1e-7

typedef struct flattening {
    const sl_atlas_faces *faces;
    const uint32_t *face;   /* of the chart */
    size_t count;
    size_t vertices;
    uint32_t *vertex;       /* of each corner: 3 a face, in the chart's order */
    uint32_t *corner;       /* of each vertex, the first of its corners in the scene */
    bool *border;           /* of each vertex */
    double *u;              /* u, v of each vertex */
} flattening;

/* ---- the chart's own vertices ---- */

static uint32_t root(uint32_t *up, uint32_t i) {
    while (up[i] != i) i = up[i] = up[up[i]];
    return i;
}

static void unite(uint32_t *up, uint32_t a, uint32_t b) {
    a = root(up, a);
    b = root(up, b);
    if (a < b) up[b] = a;
    else up[a] = b;
}

/* Corners are one vertex where an edge inside the chart glues them: a point that two borders of the chart
 * pass is two vertices. */
static bool gather_vertices(flattening *t, const uint32_t *of_face, uint32_t chart, uint32_t *local) {
    size_t corners = 3 * t->count;
    uint32_t *up = sl_allocate(corners, sizeof *up);
    t->vertex = sl_allocate(corners, sizeof *t->vertex);
    t->corner = sl_allocate(corners, sizeof *t->corner);
    t->border = sl_allocate(corners, sizeof *t->border);
    if (!up || !t->vertex || !t->corner || !t->border) {
        sl_free(up);
        return false;
    }
    for (uint32_t i = 0; i < t->count; i++) local[t->face[i]] = i;
    for (uint32_t c = 0; c < corners; c++) up[c] = c;
    for (uint32_t c = 0; c < corners; c++) {
        uint32_t opposite = t->faces->opposite[3 * t->face[c / 3] + c % 3];
        if (opposite == SL_NO_INDEX || of_face[opposite / 3] != chart) continue;
        uint32_t other = 3 * local[opposite / 3] + opposite % 3;
        unite(up, c, sl_atlas_next(other));
        unite(up, sl_atlas_next(c), other);
    }
    for (uint32_t c = 0; c < corners; c++) {
        if (up[c] == c) {
            t->corner[t->vertices] = 3 * t->face[c / 3] + c % 3;
            t->vertex[c] = (uint32_t)t->vertices++;
        } else {
            t->vertex[c] = t->vertex[root(up, c)]; /* roots are the lowest, so numbered before */
        }
    }
    for (uint32_t c = 0; c < corners; c++) {
        uint32_t opposite = t->faces->opposite[3 * t->face[c / 3] + c % 3];
        if (opposite == SL_NO_INDEX || of_face[opposite / 3] != chart)
            t->border[t->vertex[c]] = t->border[t->vertex[sl_atlas_next(c)]] = true;
    }
    sl_free(up);
    return true;
}

/* ---- projection ---- */

static sl_vec3d mean_normal(const flattening *t) {
    sl_vec3d sum = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < t->count; i++)
        sum = sl_addd(sum, sl_scaled(t->faces->normal[t->face[i]], t->faces->area[t->face[i]]));
    double length = sl_lengthd(sum);
    if (length > 0.0) return sl_scaled(sum, 1.0 / length);
    size_t c = 3 * (size_t)t->face[0]; /* slivers alone: the first one's plane */
    sl_vec3d p = sl_atlas_corner(t->faces, c);
    sl_vec3d n =
        sl_crossd(sl_subd(sl_atlas_corner(t->faces, c + 1), p), sl_subd(sl_atlas_corner(t->faces, c + 2), p));
    length = sl_lengthd(n);
    return length > 0.0 ? sl_scaled(n, 1.0 / length) : sl_v3d(0.0, 0.0, 1.0);
}

static void project(const flattening *t) {
    sl_vec3d n = mean_normal(t), o = sl_atlas_corner(t->faces, t->corner[0]);
    double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    sl_vec3d axis = x <= y && x <= z ? sl_v3d(1.0, 0.0, 0.0)
                    : y <= z         ? sl_v3d(0.0, 1.0, 0.0)
                                     : sl_v3d(0.0, 0.0, 1.0);
    sl_vec3d right = sl_crossd(axis, n);
    right = sl_scaled(right, 1.0 / sl_lengthd(right)); /* |axis x n| >= sqrt(2/3) */
    sl_vec3d up = sl_crossd(n, right);
    for (size_t v = 0; v < t->vertices; v++) {
        sl_vec3d p = sl_subd(sl_atlas_corner(t->faces, t->corner[v]), o);
        t->u[2 * v] = sl_dotd(right, p);
        t->u[2 * v + 1] = sl_dotd(up, p);
    }
}

/* ---- pins ---- */

static double distance_squared(const flattening *t, uint32_t a, uint32_t b) {
    sl_vec3d d = sl_subd(sl_atlas_corner(t->faces, t->corner[a]), sl_atlas_corner(t->faces, t->corner[b]));
    return sl_dotd(d, d);
}

/* The two border vertices farthest apart; from a long border, the end of a walk from farthest to farthest.
 * False: there is no border. */
static bool choose_pins(const flattening *t, uint32_t pin[2]) {
    enum { ALL_PAIRS = 3000, WALK = 8 };
    size_t count = 0;
    double best = -1.0;
    for (uint32_t v = 0; v < t->vertices; v++) {
        if (t->border[v] && !count) pin[0] = pin[1] = v;
        count += t->border[v];
    }
    for (uint32_t a = 0; count <= ALL_PAIRS && a < t->vertices; a++)
        for (uint32_t b = a + 1; t->border[a] && b < t->vertices; b++) {
            if (!t->border[b]) continue;
            double d = distance_squared(t, a, b);
            if (d > best) best = d, pin[0] = a, pin[1] = b;
        }
    for (int step = 0; count > ALL_PAIRS && step < WALK; step++) {
        uint32_t from = pin[1], to = from;
        double far = 0.0;
        for (uint32_t b = 0; b < t->vertices; b++) {
            double d = t->border[b] ? distance_squared(t, from, b) : 0.0;
            if (d > far) far = d, to = b;
        }
        if (far <= best) break;
        best = far;
        pin[0] = from;
        pin[1] = to;
    }
    return count > 1 && best > 0.0;
}

/* ---- the system ---- */

typedef struct entry {
    uint32_t column, order;
    double re, im;
} entry;

static int by_column(const void *x, const void *y) {
    const entry *a = x, *b = y;
    if (a->column != b->column) return a->column < b->column ? -1 : 1;
    return (a->order > b->order) - (a->order < b->order);
}

/* W_1, W_2, W_3 of a face as pairs; returns the weight 1 / (2 area). */
static double face_equation(const sl_atlas_faces *f, uint32_t face, double w[6]) {
    sl_vec3d p = sl_atlas_corner(f, 3 * (size_t)face);
    sl_vec3d a = sl_subd(sl_atlas_corner(f, 3 * (size_t)face + 1), p),
             b = sl_subd(sl_atlas_corner(f, 3 * (size_t)face + 2), p);
    double length = sl_lengthd(a), twice = sl_lengthd(sl_crossd(a, b));
    double x3 = length > 0.0 ? sl_dotd(a, b) / length : 0.0, y3 = length > 0.0 ? twice / length : 0.0;
    w[0] = x3 - length, w[1] = y3; /* corners (0,0), (length,0), (x3,y3) */
    w[2] = -x3, w[3] = -y3;
    w[4] = length, w[5] = 0.0;
    double longest = 0.0;
    for (size_t k = 0; k < 3; k++) {
        double squared = w[2 * k] * w[2 * k] + w[2 * k + 1] * w[2 * k + 1];
        longest = squared > longest ? squared : longest;
    }
    double least = THINNEST * longest;
    twice = twice > least ? twice : least;
    return twice > 0.0 ? 1.0 / twice : 0.0;
}

/* Writes conj(W_j) W_k / (2 area) of all faces into the rows of their vertices; first[v] becomes the end of
 * row v. */
static void fill_rows(const flattening *t, size_t *first, entry *all) {
    for (size_t i = 0; i < t->count; i++) {
        double w[6], weight = face_equation(t->faces, t->face[i], w);
        for (size_t j = 0; j < 3; j++)
            for (size_t k = 0; k < 3; k++) {
                size_t at = first[t->vertex[3 * i + j]]++;
                all[at] = (entry){t->vertex[3 * i + k], (uint32_t)i,
                                  weight * (w[2 * j] * w[2 * k] + w[2 * j + 1] * w[2 * k + 1]),
                                  weight * (w[2 * j] * w[2 * k + 1] - w[2 * j + 1] * w[2 * k])};
            }
    }
}

/* The rows of the free vertices: columns of free ones into the matrix, of pinned ones, times their place, to
 * the right hand side. */
static void assemble(const flattening *t, const uint32_t *row_of, const size_t *end, entry *all,
                     sl_hermitian *h, double *b) {
    size_t begin = 0, at = 0;
    for (size_t v = 0; v < t->vertices; begin = end[v++]) {
        uint32_t row = row_of[v];
        if (row == SL_NO_INDEX) continue;
        qsort(all + begin, end[v] - begin, sizeof *all, by_column);
        h->first[row] = at;
        for (size_t e = begin; e < end[v]; e++) {
            uint32_t column = row_of[all[e].column];
            if (column == SL_NO_INDEX) {
                const double *u = t->u + 2 * (size_t)all[e].column;
                b[2 * row] -= all[e].re * u[0] - all[e].im * u[1];
                b[2 * row + 1] -= all[e].re * u[1] + all[e].im * u[0];
            } else if (at > h->first[row] && h->column[at - 1] == column) {
                h->re[at - 1] += all[e].re;
                h->im[at - 1] += all[e].im;
            } else {
                h->column[at] = column;
                h->re[at] = all[e].re;
                h->im[at++] = all[e].im;
            }
        }
    }
    h->first[h->count] = at;
}

static bool solve(const flattening *t, const uint32_t pin[2]) {
    size_t n = t->vertices, entries = 9 * t->count;
    sl_hermitian h = {n - 2, sl_allocate(n, sizeof *h.first), sl_allocate(entries, sizeof *h.column),
                      sl_allocate(entries, sizeof *h.re), sl_allocate(entries, sizeof *h.im)};
    entry *all = sl_allocate(entries, sizeof *all);
    size_t *first = sl_allocate(n + 2, sizeof *first);
    uint32_t *row_of = sl_allocate(n, sizeof *row_of);
    double *x = sl_allocate(n, 6 * sizeof *x), *b = x ? x + 2 * n : NULL, *place = x ? x + 4 * n : NULL;
    bool good = h.first && h.column && h.re && h.im && all && first && row_of && x;
    if (good) {
        uint32_t row = 0;
        for (size_t c = 0; c < 3 * t->count; c++) first[t->vertex[c] + 1] += 3;
        for (size_t v = 0; v < n; v++) first[v + 1] += first[v];
        for (uint32_t v = 0; v < n; v++) row_of[v] = v == pin[0] || v == pin[1] ? SL_NO_INDEX : row++;
        fill_rows(t, first, all);
        assemble(t, row_of, first, all, &h, b);
        for (size_t v = 0; v < n; v++)
            if (row_of[v] != SL_NO_INDEX) memcpy(x + 2 * (size_t)row_of[v], t->u + 2 * v, 2 * sizeof *x);
        memcpy(place, x, 2 * (n - 2) * sizeof *place);
        unsigned iterations;
        good = sl_hermitian_solve(&h, place, b, x, TOLERANCE, &iterations);
        for (size_t v = 0; good && v < n; v++)
            if (row_of[v] != SL_NO_INDEX) memcpy(t->u + 2 * v, x + 2 * (size_t)row_of[v], 2 * sizeof *x);
    }
    sl_free(h.first);
    sl_free(h.column);
    sl_free(h.re);
    sl_free(h.im);
    sl_free(all);
    sl_free(first);
    sl_free(row_of);
    sl_free(x);
    return good;
}

/* ---- the chart ---- */

/* One face is laid out as it is. */
static void lay_out(const flattening *t) {
    double w[6];
    face_equation(t->faces, t->face[0], w);
    t->u[0] = t->u[1] = 0.0; /* corners 0, 1, 2 are vertices 0, 1, 2 */
    t->u[2] = w[4], t->u[3] = 0.0;
    t->u[4] = -w[2], t->u[5] = -w[3];
}

double sl_atlas_fit(sl_atlas_charts *charts, uint32_t id) {
    sl_atlas_chart *c = &charts->chart[id];
    double twice = 0.0, low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    for (size_t i = c->first; i < c->first + c->count; i++) {
        const double *p = charts->corner + 6 * (size_t)charts->face[i];
        twice += (p[2] - p[0]) * (p[5] - p[1]) - (p[3] - p[1]) * (p[4] - p[0]);
        for (size_t k = 0; k < 6; k++) {
            low[k % 2] = fmin(low[k % 2], p[k]);
            high[k % 2] = fmax(high[k % 2], p[k]);
        }
    }
    bool sane = twice > 0.0 && c->area > 0.0;
    double scale = sane ? sqrt(2.0 * c->area / twice) : 1.0;
    for (size_t i = 6 * c->first; i < 6 * (c->first + c->count); i++) {
        double *p = &charts->corner[6 * (size_t)charts->face[i / 6] + i % 6];
        *p = scale * (*p - low[i % 2]);
    }
    c->width = scale * (high[0] - low[0]);
    c->height = scale * (high[1] - low[1]);
    return sane ? scale : 0.0;
}

/* Where no map is found (no border, numbers beyond all bounds) the projection stays: the search for overlaps
 * finds what is wrong with it. */
static bool map(const flattening *t) {
    uint32_t pin[2] = {0, 0};
    project(t);
    if (!choose_pins(t, pin)) return true;
    const double *a = t->u + 2 * (size_t)pin[0];
    double *b = t->u + 2 * (size_t)pin[1], apart = distance_squared(t, pin[0], pin[1]);
    double seen = (b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]);
    if (seen < 1e-4 * apart) { /* one behind the other in the projection */
        b[0] = a[0] + sqrt(apart);
        b[1] = a[1];
    }
    if (t->vertices > 2 && !solve(t, pin)) return false;
    for (size_t i = 0; i < 2 * t->vertices; i++)
        if (!isfinite(t->u[i])) {
            project(t);
            break;
        }
    return true;
}

bool sl_atlas_flatten(sl_atlas_charts *charts, const sl_atlas_faces *faces, uint32_t id, uint32_t *local,
                      double *scale) {
    sl_atlas_chart *chart = &charts->chart[id];
    flattening t = {.faces = faces, .face = charts->face + chart->first, .count = chart->count};
    bool good = gather_vertices(&t, charts->of_face, id, local);
    t.u = good ? sl_allocate(t.vertices, 2 * sizeof *t.u) : NULL;
    good = t.u != NULL;
    if (good && t.count == 1) lay_out(&t);
    else good = good && map(&t);
    good = good && sl_atlas_smallest_box(t.u, t.vertices);
    for (size_t c = 0; good && c < 3 * t.count; c++)
        memcpy(charts->corner + 6 * (size_t)t.face[c / 3] + 2 * (c % 3), t.u + 2 * (size_t)t.vertex[c],
               2 * sizeof *t.u);
    chart->flat = good;
    *scale = good ? sl_atlas_fit(charts, id) : 0.0;
    sl_free(t.vertex);
    sl_free(t.corner);
    sl_free(t.border);
    sl_free(t.u);
    return good;
}
