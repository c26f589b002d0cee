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

/* A homogeneous line through two vertices, l . (x, y, 1) = 0. */
typedef struct sl_edge_line {
    double a, b, c;
} sl_edge_line;

static inline sl_edge_line sl_edge_through(double x1, double y1, double w1, double x2, double y2, double w2, double sign) {
    return (sl_edge_line){(y1 * w2 - w1 * y2) * sign, (w1 * x2 - x1 * w2) * sign, (x1 * y2 - y1 * x2) * sign};
}
static inline double sl_edge_at(sl_edge_line l, double x, double y) { return (l.a * x + l.b * y) + l.c; }

/* q: three corners relative to the eye. Since vertices are snapped, a pixel that was drawn may lie outside by a 512th of a pixel:
 * then the nearest point of the edge is taken (scaling the weights instead would slide far along a sliver), and what is still
 * negative is 0. A triangle seen edge-on has no weights: its middle. */
static inline void sl_barycentric_weights(const float clip[4][4], const float q[9], double px, double py, float *w1,
                                          float *w2) {
    double x[3], y[3], w[3];
    for (int k = 0; k < 3; k++) {
        double a = (double)q[3 * k], b = (double)q[3 * k + 1], c = (double)q[3 * k + 2];
        w[k] = sl_clip_coordinate(clip[3], a, b, c);
        x[k] = sl_clip_coordinate(clip[0], a, b, c) - px * w[k]; /* the pixel becomes the origin: p = (0, 0, 1) */
        y[k] = sl_clip_coordinate(clip[1], a, b, c) - py * w[k];
    }
    double determinant = ((x[1] * y[2] - y[1] * x[2]) + (x[2] * y[0] - y[2] * x[0])) + (x[0] * y[1] - y[0] * x[1]);
    double sign = determinant < 0.0 ? -1.0 : 1.0;
    sl_edge_line l0 = sl_edge_through(x[1], y[1], w[1], x[2], y[2], w[2], sign);
    sl_edge_line l1 = sl_edge_through(x[2], y[2], w[2], x[0], y[0], w[0], sign);
    sl_edge_line l2 = sl_edge_through(x[0], y[0], w[0], x[1], y[1], w[1], sign);
    bool out0 = l0.c < 0.0, out1 = l1.c < 0.0, out2 = l2.c < 0.0, out = out0 | out1 | out2;
    double a = out0 ? l0.a : out1 ? l1.a : l2.a, b = out0 ? l0.b : out1 ? l1.b : l2.b, c = out0 ? l0.c : out1 ? l1.c : l2.c;
    double length_squared = a * a + b * b;
    bool move = out & (length_squared > 1e-280);
    double step = move ? -c / (move ? length_squared : 1.0) : 0.0;
    double e0 = sl_edge_at(l0, a * step, b * step), e1 = sl_edge_at(l1, a * step, b * step);
    double e2 = sl_edge_at(l2, a * step, b * step);
    e0 = e0 > 0.0 ? e0 : 0.0;
    e1 = e1 > 0.0 ? e1 : 0.0;
    e2 = e2 > 0.0 ? e2 : 0.0;
    double sum = (e0 + e1) + e2;
    bool valid = (sum > 1e-280) & (sum < 1e280);
    double over = 1.0 / (valid ? sum : 1.0);
    *w1 = valid ? (float)(e1 * over) : (float)(1.0 / 3.0);
    *w2 = valid ? (float)(e2 * over) : (float)(1.0 / 3.0);
}

/* Pixel centre i of n in [-1,1]. */
static inline double sl_pixel_centre(uint32_t i, int n) { return ((double)i + 0.5) * (2.0 / (double)n) - 1.0; }

#endif
