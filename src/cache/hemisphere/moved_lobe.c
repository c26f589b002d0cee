/* A pixel's lobe as coefficients in a record's frame, without rotating coefficients. What the lobe reflects
 * is
 *
 *     integral of L(w) (s+2)/(2 pi) max(0, r . w)^s max(0, n . w) dw
 *
 * with r and n seen from the record's frame, so its coefficients there are, but for what n . w < 0 cuts off,
 *
 *     sum over k = x, y, z of n_k F_k(r),   F_k,lm(r) = integral over the sphere of (s+2)/(2 pi) max(0, r .
 * w)^s w_k H_lm(M w) dw
 *
 * where M mirrors what lies below the record's horizon. F has a table over the polar angle of r alone, for
 * azimuth 0: F_x and F_z are even in y, F_y is odd. Mirroring r changes nothing but the sign of F_z, so the
 * table ends at 90 degrees. What is cut off,
 *
 *     C_lm = integral over n . w < 0 of (s+2)/(2 pi) max(0, r . w)^s (n . w) H_lm(M w) dw,
 *
 * is small but at grazing angles; it is taken as if the pixel's frame were the record's, at the azimuth of r.
 * Then a pixel with the record's normal gets exactly the coefficients of phong.c, and a white sky the right
 * albedo whatever the normals. */
#include "cache/hemisphere/harmonics.h"

#include "base/error.h"
#include "base/math.h"
#include "base/memory.h"
#include "cache/hemisphere/lobe_integral.h"

#include <math.h>
#include <string.h>

enum { ANGLES = SL_PHONG_ANGLES };
enum { X, Y, Z, CUT, VECTORS };

struct sl_moved_lobe {
    size_t width;
    float *rows; /* [ANGLES][VECTORS][width] */
};

typedef struct products {
    sl_hsh_recurrence recurrence;
    double sum[VECTORS][SL_HSH_STRIDE_MAX];
} products;

/* w = (sin theta cos phi, sin theta sin phi, cos theta), so a product with w_x or w_y takes the moments m - 1
 * and m + 1: 2 cos phi cos(m phi) = cos((m-1) phi) + cos((m+1) phi), 2 sin phi sin(m phi) = cos((m-1) phi) -
 * cos((m+1) phi). */
static void add_circle(void *context, const sl_lobe_circle *c) {
    products *p = context;
    double h[SL_HSH_STRIDE_MAX];
    sl_hsh_evaluate_by(&p->recurrence, sl_v3d(c->sine, 0.0, fabs(c->cosine)), h);
    for (int l = 0; l < p->recurrence.order; l++)
        for (int m = 0; m <= l; m++) {
            size_t i = sl_hsh_even(l, m);
            double before = c->moments[m > 0 ? m - 1 : 1], after = c->moments[m + 1],
                   weight = c->weight * h[i];
            p->sum[X][i] += weight * c->sine * 0.5 * (before + after);
            if (m > 0) p->sum[Y][i] += weight * c->sine * 0.5 * (before - after);
            p->sum[Z][i] += weight * c->cosine * c->moments[m];
            if (c->cosine < 0.0) p->sum[CUT][i] += weight * c->cosine * c->moments[m];
        }
}

sl_status sl_moved_lobe_create(int order, double exponent, sl_moved_lobe **out, sl_error *error) {
    *out = NULL;
    size_t width = sl_hsh_odd_start(order);
    sl_moved_lobe *t = sl_allocate(1, sizeof *t);
    float *rows = sl_allocate(ANGLES * VECTORS * width, sizeof *rows);
    if (!t || !rows) {
        sl_free(t);
        sl_free(rows);
        return sl_fail_memory(error, "a table of Phong lobes");
    }
    *t = (sl_moved_lobe){width, rows};
    sl_lobe lobe;
    products p;
    sl_lobe_make(exponent, &lobe);
    sl_hsh_recurrence_of(order, &p.recurrence);
    for (size_t row = 0; row < ANGLES; row++) {
        memset(p.sum, 0, sizeof p.sum);
        sl_lobe_visit_circles(&lobe, 0.5 * SL_PI * (double)row / (ANGLES - 1), true, order + 1, add_circle,
                              &p);
        for (size_t v = 0; v < VECTORS; v++)
            for (size_t i = 0; i < width; i++) rows[(row * VECTORS + v) * width + i] = (float)p.sum[v][i];
    }
    *out = t;
    return SL_OK;
}

void sl_moved_lobe_destroy(sl_moved_lobe *lobe) {
    if (!lobe) return;
    sl_free(lobe->rows);
    sl_free(lobe);
}

size_t sl_moved_lobe_bytes(const sl_moved_lobe *lobe) {
    return sizeof *lobe + ANGLES * VECTORS * lobe->width * sizeof *lobe->rows;
}

sl_phong_rows sl_moved_lobe_at(const sl_moved_lobe *lobe, float cosine) {
    return sl_phong_rows_at(lobe->rows, VECTORS * lobe->width, fabsf(cosine));
}
