/* Perspective-correct weights of one pixel by edge functions in 2D homogeneous coordinates (Olano and Greer 1997, "Triangle
 * scan conversion using 2D homogeneous coordinates"): with v_k = (x, y, w) of corner k in clip space and p = (x, y, 1) the
 * pixel's centre, p lies on the triangle at weights proportional to
 *     e_0 = (v_1 x v_2) . p,   e_1 = (v_2 x v_0) . p,   e_2 = (v_0 x v_1) . p.
 * No vertex is divided by its w, so vertices behind the eye do not matter and clipped triangles need no other corners. */
#ifndef SL_RASTER_BARYCENTRICS_H
#define SL_RASTER_BARYCENTRICS_H

#include "raster/internal.h"

static inline double sl_clip_coordinate(const float row[4], double x, double y, double z) {
    return (((double)row[0] * x + (double)row[1] * y) + (double)row[2] * z) + (double)row[3];
}

/* q: three corners relative to the eye. A pixel may lie outside by the snapping of vertices: weights are clamped to the triangle.
 * A triangle seen edge-on has no weights: its middle. */
static inline void sl_barycentric_weights(const float clip[4][4], const float q[9], double px, double py, float *w1,
                                          float *w2) {
    double x[3], y[3], w[3];
    for (int k = 0; k < 3; k++) {
        double a = (double)q[3 * k], b = (double)q[3 * k + 1], c = (double)q[3 * k + 2];
        x[k] = sl_clip_coordinate(clip[0], a, b, c);
        y[k] = sl_clip_coordinate(clip[1], a, b, c);
        w[k] = sl_clip_coordinate(clip[3], a, b, c);
        x[k] -= px * w[k]; /* the pixel becomes the origin, p = (0, 0, 1): no cancellation afterwards */
        y[k] -= py * w[k];
    }
    double e0 = x[1] * y[2] - y[1] * x[2], e1 = x[2] * y[0] - y[2] * x[0], e2 = x[0] * y[1] - y[0] * x[1];
    double sum = (e0 + e1) + e2;
    double sign = sum < 0.0 ? -1.0 : 1.0;
    e0 = e0 * sign > 0.0 ? e0 * sign : 0.0;
    e1 = e1 * sign > 0.0 ? e1 * sign : 0.0;
    e2 = e2 * sign > 0.0 ? e2 * sign : 0.0;
    double positive = (e0 + e1) + e2;
    bool valid = (positive > 1e-280) & (positive < 1e280);
    double over = 1.0 / (valid ? positive : 1.0);
    *w1 = valid ? (float)(e1 * over) : (float)(1.0 / 3.0);
    *w2 = valid ? (float)(e2 * over) : (float)(1.0 / 3.0);
}

/* Pixel centre i of n in [-1,1]. */
static inline double sl_pixel_centre(uint32_t i, int n) { return ((double)i + 0.5) * (2.0 / (double)n) - 1.0; }

#endif
