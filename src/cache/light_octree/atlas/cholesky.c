/* The linear system of least squares conformal maps. Conjugate gradients alone are slow on it: every
 * polynomial of the complex plane is nearly conformal on a fine mesh, so that many eigenvalues are nearly 0.
 * A complete Cholesky factor as preconditioner leaves one or two steps, and with rows in nested dissection
 * order (George 1973) its fill on a surface of n vertices is only O(n log n). */
#include "cache/light_octree/atlas/parts.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum { STEPS_MAX = 60, LEAF = 6 };

/* ---- nested dissection ---- */

typedef struct located {
    double key;
    uint32_t row;
} located;

static int by_key(const void *x, const void *y) {
    const located *a = x, *b = y;
    if (a->key != b->key) return a->key < b->key ? -1 : 1;
    return (a->row > b->row) - (a->row < b->row);
}

typedef struct dissection {
    const sl_hermitian *a;
    const double *place;
    located *item;
    uint32_t *side;         /* of each row: the number of the half it is in */
    uint32_t halves;
} dissection;

/* Orders item[0 .. count): one half, the other, and last the rows of the first half that touch the second. */
static void dissect(dissection *d, located *item, size_t count) {
    if (count <= LEAF) return;
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 2; k++) {
            double p = d->place[2 * (size_t)item[i].row + k];
            low[k] = p < low[k] ? p : low[k];
            high[k] = p > high[k] ? p : high[k];
        }
    size_t axis = high[1] - low[1] > high[0] - low[0], half = count / 2, keep = 0, separators = 0;
    for (size_t i = 0; i < count; i++) item[i].key = d->place[2 * (size_t)item[i].row + axis];
    qsort(item, count, sizeof *item, by_key);
    uint32_t right = d->halves + 1;
    d->halves += 2;
    for (size_t i = 0; i < count; i++) d->side[item[i].row] = i < half ? right - 1 : right;
    /* separators are gathered behind what stays, then moved past the second half */
    located *cut = item + half;
    for (size_t i = 0; i < half; i++) {
        uint32_t r = item[i].row;
        bool touches = false;
        for (size_t e = d->a->first[r]; e < d->a->first[r + 1]; e++)
            touches |= d->side[d->a->column[e]] == right;
        item[i].key = touches;
        separators += touches;
    }
    qsort(item, half, sizeof *item, by_key);
    keep = half - separators;
    /* rotate: swap the separators with the end of the second half */
    for (size_t i = 0; i < separators; i++) {
        located s = item[keep + i];
        item[keep + i] = cut[count - half - separators + i];
        cut[count - half - separators + i] = s;
    }
    if (separators * 2 > count) return; /* no shape to be cut */
    dissect(d, item, keep);
    dissect(d, item + keep, count - separators - keep);
}

static bool nested_dissection(const sl_hermitian *a, const double *place, uint32_t *row_at) {
    dissection d = {.a = a,
                    .place = place,
                    .item = sl_allocate(a->count, sizeof *d.item),
                    .side = sl_allocate(a->count, sizeof *d.side)};
    bool good = d.item && d.side;
    if (good) {
        for (uint32_t i = 0; i < a->count; i++) d.item[i].row = i;
        dissect(&d, d.item, a->count);
        for (size_t i = 0; i < a->count; i++) row_at[i] = d.item[i].row;
    }
    sl_free(d.item);
    sl_free(d.side);
    return good;
}

/* ---- the factor: P A P^T = L L^* ---- */

typedef struct factor {
    size_t count;
    uint32_t *row_at;       /* the order */
    uint32_t *at;           /* of each row of A */
    uint32_t *parent;       /* elimination tree */
    size_t *first, *end;    /* of each column of L below its diagonal */
    uint32_t *row;
    double *re, *im, *diagonal;
} factor;

/* The columns with an entry in row k of L, ascending along each path of the elimination tree: the paths from
 * A's entries to k (Liu 1990). They are written to the end of `list`; returns where they begin. */
static size_t row_pattern(const sl_hermitian *a, const factor *l, uint32_t k, uint32_t *mark, uint32_t *list,
                          uint32_t *path) {
    size_t top = l->count;
    uint32_t r = l->row_at[k];
    mark[k] = k + 1;
    for (size_t e = a->first[r]; e < a->first[r + 1]; e++) {
        uint32_t i = l->at[a->column[e]];
        size_t depth = 0;
        if (i > k) continue;
        for (; mark[i] != k + 1; i = l->parent[i]) {
            path[depth++] = i;
            mark[i] = k + 1;
        }
        while (depth) list[--top] = path[--depth];
    }
    return top;
}

static void elimination_tree(const sl_hermitian *a, factor *l, uint32_t *ancestor) {
    for (uint32_t k = 0; k < l->count; k++) {
        uint32_t r = l->row_at[k];
        l->parent[k] = ancestor[k] = SL_NO_INDEX;
        for (size_t e = a->first[r]; e < a->first[r + 1]; e++) {
            uint32_t next;
            for (uint32_t i = l->at[a->column[e]]; i < k; i = next) { /* with path compression */
                next = ancestor[i];
                ancestor[i] = k;
                if (next != SL_NO_INDEX) continue;
                l->parent[i] = k;
                break;
            }
        }
    }
}

/* Row k: solves L' y = (A's column k above the diagonal) along the pattern, then the row is y^* and the pivot
 * what is left of A's. */
static void factor_row(const sl_hermitian *a, factor *l, uint32_t k, const uint32_t *list, size_t top,
                       double *x_re, double *x_im) {
    uint32_t r = l->row_at[k];
    double pivot = 0.0, own = 0.0;
    for (size_t e = a->first[r]; e < a->first[r + 1]; e++) { /* A's column k is the conjugate of its row */
        uint32_t i = l->at[a->column[e]];
        if (i == k) own = pivot = a->re[e];
        if (i < k) x_re[i] = a->re[e], x_im[i] = -a->im[e];
    }
    for (size_t n = top; n < l->count; n++) {
        uint32_t i = list[n];
        double re = x_re[i] / l->diagonal[i], im = x_im[i] / l->diagonal[i];
        x_re[i] = x_im[i] = 0.0;
        for (size_t p = l->first[i]; p < l->end[i]; p++) {
            x_re[l->row[p]] -= l->re[p] * re - l->im[p] * im;
            x_im[l->row[p]] -= l->re[p] * im + l->im[p] * re;
        }
        pivot -= re * re + im * im;
        size_t p = l->end[i]++;
        l->row[p] = k;
        l->re[p] = re;
        l->im[p] = -im;
    }
    double least = 1e-14 * own; /* what rounding ate is put back: a preconditioner may be off a little */
    l->diagonal[k] = sqrt(pivot > least ? pivot : least > 0.0 ? least : 1.0);
}

static void release_factor(factor *l) {
    sl_free(l->row_at);
    sl_free(l->at);
    sl_free(l->parent);
    sl_free(l->first);
    sl_free(l->end);
    sl_free(l->row);
    sl_free(l->re);
    sl_free(l->im);
    sl_free(l->diagonal);
}

static bool allocate_entries(factor *l) {
    size_t entries = l->first[l->count];
    l->row = sl_allocate(entries, sizeof *l->row);
    l->re = sl_allocate(entries, sizeof *l->re);
    l->im = sl_allocate(entries, sizeof *l->im);
    return l->row && l->re && l->im;
}

static bool factorize(const sl_hermitian *a, const double *place, factor *l) {
    size_t n = a->count;
    *l = (factor){.count = n};
    l->row_at = sl_allocate(n, sizeof *l->row_at);
    l->at = sl_allocate(n, sizeof *l->at);
    l->parent = sl_allocate(n, sizeof *l->parent);
    l->first = sl_allocate(n + 1, sizeof *l->first);
    l->end = sl_allocate(n, sizeof *l->end);
    l->diagonal = sl_allocate(n, sizeof *l->diagonal);
    uint32_t *mark = sl_allocate(n, sizeof *mark), *list = sl_allocate(n, sizeof *list),
             *path = sl_allocate(n, sizeof *path);
    double *x = sl_allocate(n, 2 * sizeof *x);
    bool good = l->row_at && l->at && l->parent && l->first && l->end && l->diagonal && mark && list &&
                path && x && nested_dissection(a, place, l->row_at);
    if (good) {
        for (uint32_t k = 0; k < n; k++) l->at[l->row_at[k]] = k;
        elimination_tree(a, l, path);
        for (uint32_t k = 0; k < n; k++)
            for (size_t t = row_pattern(a, l, k, mark, list, path); t < n; t++) l->first[list[t] + 1]++;
        for (size_t k = 0; k < n; k++) l->first[k + 1] += l->first[k];
        good = allocate_entries(l);
    }
    if (good) {
        memcpy(l->end, l->first, n * sizeof *l->end);
        memset(mark, 0, n * sizeof *mark);
        for (uint32_t k = 0; k < n; k++)
            factor_row(a, l, k, list, row_pattern(a, l, k, mark, list, path), x, x + n);
    }
    sl_free(mark);
    sl_free(list);
    sl_free(path);
    sl_free(x);
    return good;
}

/* z = (L L^*)^-1 r; w is scratch. Complex vectors are pairs. */
static void precondition(const factor *l, const double *r, double *w, double *z) {
    for (size_t k = 0; k < l->count; k++) {
        w[2 * k] = r[2 * (size_t)l->row_at[k]];
        w[2 * k + 1] = r[2 * (size_t)l->row_at[k] + 1];
    }
    for (size_t k = 0; k < l->count; k++) {
        double re = w[2 * k] /= l->diagonal[k], im = w[2 * k + 1] /= l->diagonal[k];
        for (size_t p = l->first[k]; p < l->end[k]; p++) {
            w[2 * (size_t)l->row[p]] -= l->re[p] * re - l->im[p] * im;
            w[2 * (size_t)l->row[p] + 1] -= l->re[p] * im + l->im[p] * re;
        }
    }
    for (size_t k = l->count; k-- > 0;) {
        double re = w[2 * k], im = w[2 * k + 1];
        for (size_t p = l->first[k]; p < l->end[k]; p++) { /* conjugates */
            double x = w[2 * (size_t)l->row[p]], y = w[2 * (size_t)l->row[p] + 1];
            re -= l->re[p] * x + l->im[p] * y;
            im -= l->re[p] * y - l->im[p] * x;
        }
        w[2 * k] = re / l->diagonal[k];
        w[2 * k + 1] = im / l->diagonal[k];
    }
    for (size_t k = 0; k < l->count; k++) {
        z[2 * (size_t)l->row_at[k]] = w[2 * k];
        z[2 * (size_t)l->row_at[k] + 1] = w[2 * k + 1];
    }
}

/* ---- conjugate gradients ---- */

static void multiply(const sl_hermitian *a, const double *x, double *y) {
    for (size_t r = 0; r < a->count; r++) {
        double re = 0.0, im = 0.0;
        for (size_t e = a->first[r]; e < a->first[r + 1]; e++) {
            const double *v = x + 2 * (size_t)a->column[e];
            re += a->re[e] * v[0] - a->im[e] * v[1];
            im += a->re[e] * v[1] + a->im[e] * v[0];
        }
        y[2 * r] = re;
        y[2 * r + 1] = im;
    }
}

/* The real part of x^* y: all that conjugate gradients on a Hermitian matrix need. */
static double inner(const double *x, const double *y, size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += x[i] * y[i];
    return sum;
}

static void iterate(const sl_hermitian *a, const factor *l, double limit, double *x, double *r,
                    double *scratch, unsigned *iterations) {
    size_t n = 2 * a->count;
    double *z = scratch, *p = scratch + n, *ap = scratch + 2 * n, *w = scratch + 3 * n;
    double rz = 0.0;
    for (; *iterations < STEPS_MAX && inner(r, r, n) > limit; ++*iterations) {
        precondition(l, r, w, z);
        double next = inner(r, z, n), beta = *iterations && rz > 0.0 ? next / rz : 0.0;
        for (size_t i = 0; i < n; i++) p[i] = z[i] + beta * p[i];
        rz = next;
        multiply(a, p, ap);
        double curvature = inner(p, ap, n);
        if (!(curvature > 0.0) || !(rz > 0.0)) break;
        for (size_t i = 0; i < n; i++) {
            x[i] += rz / curvature * p[i];
            r[i] -= rz / curvature * ap[i];
        }
    }
}

bool sl_hermitian_solve(const sl_hermitian *a, const double *place, const double *b, double *x,
                        double tolerance, unsigned *iterations) {
    size_t n = 2 * a->count;
    double *r = sl_allocate(n, sizeof *r), *scratch = sl_allocate(n, 4 * sizeof *scratch);
    bool good = r && scratch;
    *iterations = 0;
    if (good) {
        multiply(a, x, r);
        for (size_t i = 0; i < n; i++) r[i] = b[i] - r[i];
        double limit = tolerance * tolerance * inner(b, b, n);
        if (inner(r, r, n) > limit) {
            factor l;
            good = factorize(a, place, &l);
            if (good) iterate(a, &l, limit, x, r, scratch, iterations);
            release_factor(&l);
        }
    }
    sl_free(r);
    sl_free(scratch);
    return good;
}
