/* Perspective-correct weights of one pixel by edge functions in 2D homogeneous coordinates (Olano and Greer 1997,
 * "Triangle scan conversion using 2D homogeneous coordinates"): with v_k = (x, y, w) of corner k in clip space and p
 * = (x, y, 1) the pixel's centre, p lies on the triangle at weights proportional to
 *     e_0 = (v_1 x v_2) . p,   e_1 = (v_2 x v_0) . p,   e_2 = (v_0 x v_1) . p.
 * No vertex is divided by its w, so vertices behind the eye do not matter and clipped triangles need no other
 * corners. */
#ifndef SL_RASTER_BARYCENTRICS_H
#define SL_RASTER_BARYCENTRICS_H

#include "raster/internal.h"

static inline double sl_clip_coordinate(const float row[4], sl_vec3 q) {
    return (((double)row[0] * (double)q.x + (double)row[1] * (double)q.y) + (double)row[2] * (double)q.z) + (double)row[3];
}

/* A homogeneous line through two vertices, l . (x, y, 1) = 0. */
typedef struct sl_edge_line {
    double a, b, c;
} sl_edge_line;

static inline sl_edge_line sl_edge_through(double x1, double y1, double w1, double x2, double y2, double w2, double sign) {
    return (sl_edge_line){(y1 * w2 - w1 * y2) * sign, (w1 * x2 - x1 * w2) * sign, (x1 * y2 - y1 * x2) * sign};
}
static inline double sl_edge_at(sl_edge_line l, double x, double y) { return (l.a * x + l.b * y) + l.c; }

/* q0, q1, q2: the corners relative to the eye. Since vertices are snapped, a pixel that was drawn may lie outside by
 * a 512th of a pixel: then the nearest point of the edge is taken (scaling the weights instead would slide far along
 * a sliver), and what is still negative is 0. A triangle seen edge-on has no weights: its middle. */
static inline void sl_barycentric_weights(const float clip[4][4], sl_vec3 q0, sl_vec3 q1, sl_vec3 q2, double px, double py,
                                          float *weight1, float *weight2) {
    double w0 = sl_clip_coordinate(clip[3], q0), w1 = sl_clip_coordinate(clip[3], q1), w2 = sl_clip_coordinate(clip[3], q2);
    /* The pixel becomes the origin: p = (0, 0, 1). */
    double x0 = sl_clip_coordinate(clip[0], q0) - px * w0, y0 = sl_clip_coordinate(clip[1], q0) - py * w0;
    double x1 = sl_clip_coordinate(clip[0], q1) - px * w1, y1 = sl_clip_coordinate(clip[1], q1) - py * w1;
    double x2 = sl_clip_coordinate(clip[0], q2) - px * w2, y2 = sl_clip_coordinate(clip[1], q2) - py * w2;
    double determinant = ((x1 * y2 - y1 * x2) + (x2 * y0 - y2 * x0)) + (x0 * y1 - y0 * x1);
    double sign = determinant < 0.0 ? -1.0 : 1.0;
    sl_edge_line l0 = sl_edge_through(x1, y1, w1, x2, y2, w2, sign);
    sl_edge_line l1 = sl_edge_through(x2, y2, w2, x0, y0, w0, sign);
    sl_edge_line l2 = sl_edge_through(x0, y0, w0, x1, y1, w1, sign);
    /* The edge to move to, as 0 or 1 a piece: sums of products vectorise where nested choices do not. */
    double out0 = l0.c < 0.0 ? 1.0 : 0.0, in0 = 1.0 - out0, out1 = l1.c < 0.0 ? in0 : 0.0, in1 = in0 - out1;
    double out2 = l2.c < 0.0 ? in1 : 0.0;
    double a = (l0.a * out0 + l1.a * out1) + l2.a * out2, b = (l0.b * out0 + l1.b * out1) + l2.b * out2;
    double c = (l0.c * out0 + l1.c * out1) + l2.c * out2, length_squared = a * a + b * b;
    double step = -c / (length_squared > 1e-280 ? length_squared : 1e280);
    double e0 = sl_edge_at(l0, a * step, b * step), e1 = sl_edge_at(l1, a * step, b * step);
    double e2 = sl_edge_at(l2, a * step, b * step);
    e0 = e0 > 0.0 ? e0 : 0.0;
    e1 = e1 > 0.0 ? e1 : 0.0;
    e2 = e2 > 0.0 ? e2 : 0.0;
    double sum = (e0 + e1) + e2, third = 1.0 / 3.0;
    double over = 1.0 / (sum > 1e-280 ? sum : 1.0);
    double b1 = sum > 1e-280 ? e1 * over : third, b2 = sum > 1e-280 ? e2 * over : third;
    *weight1 = (float)(sum < 1e280 ? b1 : third);
    *weight2 = (float)(sum < 1e280 ? b2 : third);
}

/* Pixel centre i of n in [-1,1]. */
static inline double sl_pixel_centre(uint32_t i, int n) { return ((double)i + 0.5) * (2.0 / (double)n) - 1.0; }

#endif
