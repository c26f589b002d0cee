/* From sums over cells and walls to irradiance with gradients in the world frame. The sums themselves are in
 * gather_kernels.c, the walls' vectors in gather_tables.c. */
#include "cache/hemisphere/gather_internal.h"

#include "base/math.h"

static sl_vec3 tangential(const sl_frame *f, const double v[2]) {
    return sl_to_float(sl_addd(sl_scaled(sl_to_double(f->x), v[0]), sl_scaled(sl_to_double(f->y), v[1])));
}

/* Eigenvalues of a symmetric 2 x 2 matrix. Of the two ways to write the first one's direction the one that
 * does not cancel. */
static void set_curvature(const sl_frame *f, const sl_gather_curvature *h, sl_irradiance *out) {
    double mean = 0.5 * (h->xx + h->yy), half = 0.5 * (h->xx - h->yy),
           radius = sqrt(half * half + h->xy * h->xy);
    double sign = mean < 0.0 ? -1.0 : 1.0, x = sign * half, y = sign * h->xy, along[2] = {1.0, 0.0};
    /* The angle of (x, y) halved: (radius + x, y) or (y, radius - x). */
    double a = x >= 0.0 ? radius + x : y, b = x >= 0.0 ? y : radius - x, length = sqrt(a * a + b * b);
    if (length > 0.0) along[0] = a / length, along[1] = b / length;
    out->curvature[0] = (float)(mean + sign * radius);
    out->curvature[1] = (float)(mean - sign * radius);
    out->curvature_axis = tangential(f, along);
}

void sl_gather_finish(const sl_gather_view *view, const sl_gather_sums *sums,
                      const sl_gather_curvature *curvature, sl_irradiance *out) {
    const sl_gather_tables *t = view->gather->tables;
    set_curvature(&view->frame, curvature, out);
    out->value = (sl_rgb){(float)sums->irradiance[0], (float)sums->irradiance[1], (float)sums->irradiance[2]};
    for (int c = 0; c < 3; c++) {
        out->rotational[c] = tangential(&view->frame, sums->rotational[c]);
        out->translational[c] = tangential(&view->frame, sums->translational[c]);
    }
    /* 1/R = (1/pi) sum W / r, the harmonic mean of distances (Ward et al. 1988), weighed by the cosine; W
     * need not sum to pi where a plane's border is left off. */
    out->harmonic_mean =
        sums->inverse_distance > 0.0 ? (float)(t->weight_sum / sums->inverse_distance) : INFINITY;
}
