/* Coefficients seen from a tilted frame (Gautron et al. 2004; Krivanek et al. 2005):
 *
 *     D_ij(beta) = integral over the hemisphere of H_i(a) H_j(M R_y(beta) a) da
 *
 * R_y(beta) a = (cos beta a_x + sin beta a_z, a_y, -sin beta a_x + cos beta a_z) takes a direction of the tilted frame to the frame
 * that the coefficients were gathered in; M says what is seen where that lies below the horizon. The hemispherical harmonics are
 * not closed under tilting, so D is a projection and not exactly orthogonal. Both frames share the y axis, and y -> -y turns
 * neither: functions that are even in y never mix with odd ones. */
#include "cache/hemisphere/harmonics.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "cache/hemisphere/quadrature.h"

#include <math.h>
#include <string.h>

/* Nodes along the common axis, and about it in what lies above both horizons, grow with the order; so do those in what lies above
 * one alone, with the angle. Entries are then within 1e-7 of their integrals (tests/cache/hemisphere/test_harmonics_rotation.c). */
enum { AXIS_MAX = (2 * SL_HSH_ORDER_MAX + 4 + 3) / 4 * 4 };
static int axis_count(int order) { return (2 * order + 4 + 3) / 4 * 4; } /* whole groups of four */
static int above_count(int order) { return 4 * order + 12; }
static int below_count(int order, double beta) { return 8 + (int)(2.4 * order * beta); }

static const double step_angle = SL_PI / 360.0;

struct sl_hsh_rotation {
    int order, steps; /* tables 0 .. steps: table k is D(k step_angle) */
    sl_hsh_fill fill;
    size_t even_rows, even_width, odd_rows, odd_width, table_floats;
    float *tables; /* each: even rows, then odd rows */
};

/* ---- D of one angle ---------------------------------------------------------------------------------------------- */

/* What all steps share. */
typedef struct quadrature {
    sl_hsh_recurrence recurrence;
    int axis_count;
    double sin_axis[AXIS_MAX], cos_axis[AXIS_MAX], axis_weight[AXIS_MAX];
    double above[SL_GAUSS_MAX], above_weight[SL_GAUSS_MAX];
} quadrature;

enum { PART_ROWS = SL_HSH_ORDER_MAX * (SL_HSH_ORDER_MAX + 1) / 2, PART_WIDTH = (PART_ROWS + 15) / 16 * 16 };

/* What one worker needs. The functions stand along an arc from y = 0 to y = 1, padded vectors one behind the other. */
typedef struct scratch {
    double even[PART_ROWS * PART_WIDTH], odd[PART_ROWS * PART_WIDTH];               /* the sums */
    double tilted[AXIS_MAX * SL_HSH_STRIDE_MAX], other[AXIS_MAX * SL_HSH_STRIDE_MAX]; /* H_i(a) times weight; H_j(a') */
} scratch;

/* sum[i][j] += over the arc's nodes k of row[k][i] column[k][j]; four nodes at a time, so that the sums are fetched less often. */
static void add_products(size_t nodes, size_t rows, size_t width, size_t stride, const double *row, const double *column,
                         double *sum) {
    for (size_t k = 0; k < nodes; k += 4) {
        const double *r = row + k * stride, *restrict c = column + k * stride;
        for (size_t i = 0; i < rows; i++) {
            double *restrict s = sum + i * width, r0 = r[i], r1 = r[stride + i], r2 = r[2 * stride + i], r3 = r[3 * stride + i];
            for (size_t j = 0; j < width; j++)
                s[j] += (r0 * c[j] + r1 * c[stride + j]) + (r2 * c[2 * stride + j] + r3 * c[3 * stride + j]);
        }
    }
}

/* Adds the lune between two angles about the common axis, a = (cos eta sin xi, sin eta, cos eta cos xi), da = cos eta deta dxi; all
 * of it is above the tilted frame's horizon, and above or below the other's. */
static void add_lune(const sl_hsh_rotation *t, const quadrature *q, scratch *w, double beta, double xi_0, double xi_1, int count,
                     const double *nodes, const double *weights) {
    size_t stride = sl_hsh_stride(t->order), odd_start = sl_hsh_odd_start(t->order), arc = (size_t)q->axis_count;
    for (int i = 0; i < count; i++) {
        double xi = xi_0 + (xi_1 - xi_0) * nodes[i], turn = (xi_1 - xi_0) * weights[i];
        double sx = sl_sin(xi), cx = sl_cos(xi), sx_other = sl_sin(xi + beta), cx_other = fabs(sl_cos(xi + beta));
        for (size_t k = 0; k < arc; k++) {
            double ce = q->cos_axis[k], se = q->sin_axis[k], *tilted = w->tilted + k * stride;
            sl_hsh_evaluate_by(&q->recurrence, sl_v3d(ce * sx, se, ce * cx), tilted);
            sl_hsh_evaluate_by(&q->recurrence, sl_v3d(ce * sx_other, se, ce * cx_other), w->other + k * stride);
            for (size_t j = 0; j < stride; j++) tilted[j] *= turn * q->axis_weight[k];
        }
        add_products(arc, t->even_rows, t->even_width, stride, w->tilted, w->other, w->even);
        add_products(arc, t->odd_rows, t->odd_width, stride, w->tilted + odd_start, w->other + odd_start, w->odd);
    }
}

static void add_identity(size_t rows, size_t width, double *sum) {
    for (size_t i = 0; i < rows; i++) sum[i * width + i] = 1.0;
}

static void tabulate(const sl_hsh_rotation *t, const quadrature *q, scratch *w, double beta, float *table) {
    size_t even_count = t->even_rows * t->even_width, odd_count = t->odd_rows * t->odd_width;
    memset(w->even, 0, even_count * sizeof *w->even);
    memset(w->odd, 0, odd_count * sizeof *w->odd);
    if (beta > 0.0) {
        /* In the first lune M has nothing to do; in the second z' < 0. Functions of odd m behave like sqrt(cos) at either horizon. */
        double half = 0.5 * SL_PI, below[SL_GAUSS_MAX], weight[SL_GAUSS_MAX];
        int count = below_count(t->order, beta);
        sl_gauss_both_ends(count, below, weight);
        add_lune(t, q, w, beta, -half, half - beta, above_count(t->order), q->above, q->above_weight);
        if (t->fill == SL_HSH_MIRROR) add_lune(t, q, w, beta, half - beta, half, count, below, weight);
    } else {
        add_identity(t->even_rows, t->even_width, w->even);
        add_identity(t->odd_rows, t->odd_width, w->odd);
    }
    for (size_t i = 0; i < even_count; i++) table[i] = (float)w->even[i];
    for (size_t i = 0; i < odd_count; i++) table[even_count + i] = (float)w->odd[i];
}

/* ---- the tables -------------------------------------------------------------------------------------------------- */

typedef struct creation {
    const sl_hsh_rotation *rotation;
    quadrature quadrature;
    scratch *scratch; /* one a worker */
} creation;

static void quadrature_of(int order, quadrature *q) {
    double axis[AXIS_MAX];
    sl_hsh_recurrence_of(order, &q->recurrence);
    q->axis_count = axis_count(order);
    sl_gauss_upper_end(q->axis_count, axis, q->axis_weight);
    for (int k = 0; k < q->axis_count; k++) {
        double eta = 0.5 * SL_PI * axis[k];
        q->cos_axis[k] = sl_cos(eta);
        q->sin_axis[k] = sl_sin(eta);
        q->axis_weight[k] *= 0.5 * SL_PI * 2.0 * q->cos_axis[k]; /* y < 0 gives the same again */
    }
    sl_gauss_both_ends(above_count(order), q->above, q->above_weight);
}

static void tabulate_step(void *context, size_t index, unsigned worker) {
    creation *c = context;
    const sl_hsh_rotation *t = c->rotation;
    tabulate(t, &c->quadrature, &c->scratch[worker], (double)index * step_angle, t->tables + index * t->table_floats);
}

static sl_hsh_rotation rotation_of(int order, double largest_angle, sl_hsh_fill fill) {
    size_t even_width = sl_hsh_odd_start(order), odd_width = sl_hsh_stride(order) - even_width;
    double angle = largest_angle < 0.5 * SL_PI ? largest_angle : 0.5 * SL_PI;
    return (sl_hsh_rotation){.order = order,
                             .steps = 1 + (int)(angle / step_angle * (1.0 - 1e-12)),
                             .fill = fill,
                             .even_rows = sl_hsh_even_count(order),
                             .even_width = even_width,
                             .odd_rows = sl_hsh_odd_count(order),
                             .odd_width = odd_width,
                             .table_floats = sl_hsh_even_count(order) * even_width + sl_hsh_odd_count(order) * odd_width};
}

sl_status sl_hsh_rotation_create(int order, double largest_angle, sl_hsh_fill fill, unsigned threads, sl_hsh_rotation **rotation,
                                 sl_error *error) {
    *rotation = NULL;
    if (order < 1 || order > SL_HSH_ORDER_MAX)
        return sl_fail(error, SL_ERROR_USAGE, "order of hemispherical harmonics %d: expected 1 to %d", order, SL_HSH_ORDER_MAX);
    if (!(largest_angle >= 0.0)) return sl_fail(error, SL_ERROR_USAGE, "largest tilt %g: expected an angle of 0 or more", largest_angle);
    threads = sl_thread_count(threads);
    sl_hsh_rotation *t = sl_allocate(1, sizeof *t);
    creation *c = sl_allocate(1, sizeof *c);
    if (t) {
        *t = rotation_of(order, largest_angle, fill);
        t->tables = sl_allocate(((size_t)t->steps + 1) * t->table_floats, sizeof *t->tables);
    }
    if (c) c->scratch = sl_allocate(threads, sizeof *c->scratch);
    bool made = t && t->tables && c && c->scratch;
    if (made) {
        c->rotation = t;
        quadrature_of(order, &c->quadrature);
        sl_parallel_for(threads, (size_t)t->steps + 1, tabulate_step, c);
        *rotation = t;
    } else {
        sl_hsh_rotation_destroy(t);
    }
    if (c) sl_free(c->scratch);
    sl_free(c);
    return made ? SL_OK : sl_fail_memory(error, "tables of tilted hemispherical harmonics");
}

void sl_hsh_rotation_destroy(sl_hsh_rotation *rotation) {
    if (!rotation) return;
    sl_free(rotation->tables);
    sl_free(rotation);
}

size_t sl_hsh_rotation_bytes(const sl_hsh_rotation *rotation) {
    return sizeof *rotation + ((size_t)rotation->steps + 1) * rotation->table_floats * sizeof *rotation->tables;
}

sl_hsh_tilt sl_hsh_tilt_at(const sl_hsh_rotation *t, float beta) {
    float at = beta * (float)(360.0 / SL_PI);
    at = at > 0.0f ? at : 0.0f; /* not a number counts as 0 */
    at = at < (float)t->steps ? at : (float)t->steps;
    int step = (int)at;
    step = step < t->steps ? step : t->steps - 1;
    const float *first = t->tables + (size_t)step * t->table_floats, *second = first + t->table_floats;
    size_t odd = t->even_rows * t->even_width;
    return (sl_hsh_tilt){.even = {first, second}, .odd = {first + odd, second + odd}, .mix = at - (float)step};
}
