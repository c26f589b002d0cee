/* Perspective-correct weights of one pixel by edge functions in 2D homogeneous coordinates (Olano and Greer
 * 1997, "Triangle scan conversion using 2D homogeneous coordinates"): with v_k = (x, y, w) of corner k and p
 * = (x, y, 1) the pixel's centre, p lies on the triangle at weights proportional to e_0 = (v_1 x v_2) . p,
 * e_1 = (v_2 x v_0) . p,   e_2 = (v_0 x v_1) . p. No vertex is divided by its w, so vertices behind the eye
 * do not matter and clipped triangles need no other corners.
 *
 * This is the plain form, for one pixel at a time: sl_edge_lines_make(), then sl_weights_at(). The resolution
 * of whole pictures (resolve_kernels.c) runs the same lines in vector lanes, over triangles and then over
 * pixels. A weight depends on the view, the pixel and the triangle and on nothing else. */
#pragma once

#include "raster/view.h"

/* The three lines e_k(x, y) = (a_k dx + b_k dy) + c_k, where dx and dy count pixels from an origin beside the
 * triangle: a small or thin triangle far from the origin would lose its digits to cancellation. */
typedef struct sl_edge_lines {
    double a0, b0, c0, a1, b1, c1, a2, b2, c2;
    double x, y; /* the origin: a pixel, told from the viewport's corner */
} sl_edge_lines;

static inline double sl_clip_coordinate(const float row[4], sl_vec3 q) {
    return (((double)row[0] * (double)q.x + (double)row[1] * (double)q.y) + (double)row[2] * (double)q.z) +
           (double)row[3];
}

/* A corner in homogeneous window coordinates: in front of the eye it shows (x, y) / w pixels from the
 * viewport's middle. */
typedef struct sl_window_corner {
    double x, y, w;
} sl_window_corner;

/* q: the corner relative to the eye. */
static inline sl_window_corner sl_window_corner_of(const sl_pass_view *view, sl_vec3 q) {
    return (sl_window_corner){sl_clip_coordinate(view->clip[0], q) * (double)view->half_width,
                              sl_clip_coordinate(view->clip[1], q) * (double)view->half_height,
                              sl_clip_coordinate(view->clip[3], q)};
}

/* With the centre of the viewport's pixel (x, y) as origin. */
static inline sl_edge_lines sl_edge_lines_about(const sl_pass_view *view, sl_window_corner v0,
                                                sl_window_corner v1, sl_window_corner v2, double x,
                                                double y) {
    const double right = ((double)view->half_width - 0.5) - x, up = ((double)view->half_height - 0.5) - y;
    double x0 = v0.x + v0.w * right, x1 = v1.x + v1.w * right, x2 = v2.x + v2.w * right;
    double y0 = v0.y + v0.w * up, y1 = v1.y + v1.w * up, y2 = v2.y + v2.w * up;
    return (sl_edge_lines){.a0 = y1 * v2.w - v1.w * y2, .b0 = v1.w * x2 - x1 * v2.w, .c0 = x1 * y2 - y1 * x2,
                           .a1 = y2 * v0.w - v2.w * y0, .b1 = v2.w * x0 - x2 * v0.w, .c1 = x2 * y0 - y2 * x0,
                           .a2 = y0 * v1.w - v0.w * y1, .b2 = v0.w * x1 - x0 * v1.w, .c2 = x0 * y1 - y0 * x1,
                           .x = x, .y = y};
}

/* The pixel nearest to a place that lies `from_middle` pixels from the viewport's middle, within the
 * viewport; 0 for NaN. Near 2^52 a double has no fraction left. */
static inline double sl_nearest_pixel(double from_middle, double half_size) {
    double place = from_middle + (half_size - 0.5), last = 2.0 * half_size - 1.0;
    double low = place > 0.0 ? place : 0.0, within = low < last ? low : last;
    return (within + 0x1.8p52) - 0x1.8p52;
}

/* The lines of a triangle, q0, q1, q2 relative to the eye. Their origin is the farthest corner's pixel: that
 * corner is in front of the eye if any is. */
static inline sl_edge_lines sl_edge_lines_make(const sl_pass_view *view, sl_vec3 q0, sl_vec3 q1, sl_vec3 q2) {
    sl_window_corner v0 = sl_window_corner_of(view, q0), v1 = sl_window_corner_of(view, q1);
    sl_window_corner v2 = sl_window_corner_of(view, q2);
    double x = v1.w > v0.w ? v1.x : v0.x, y = v1.w > v0.w ? v1.y : v0.y, w = v1.w > v0.w ? v1.w : v0.w;
    x = v2.w > w ? v2.x : x;
    y = v2.w > w ? v2.y : y;
    w = v2.w > w ? v2.w : w;
    const double over = 1.0 / (w > 1e-280 ? w : 1e-280);
    return sl_edge_lines_about(view, v0, v1, v2, sl_nearest_pixel(x * over, (double)view->half_width),
                               sl_nearest_pixel(y * over, (double)view->half_height));
}

static inline double sl_edge_at(double a, double b, double c, double dx, double dy) {
    return (a * dx + b * dy) + c;
}

/* The edge functions' values as weights of corners 1 and 2; false where the pixel is not inside: then they
 * mean nothing. The sum's sign is the side from which the triangle is seen. */
static inline bool sl_weights_inside(double e0, double e1, double e2, double *b1, double *b2) {
    double sum = (e0 + e1) + e2;
    bool sound = (fabs(sum) > 1e-280) & (fabs(sum) < 1e280);
    double over = 1.0 / (sound ? sum : 1.0);
    *b1 = e1 * over;
    *b2 = e2 * over;
    return sound & (e0 * over >= 0.0) & (*b1 >= 0.0) & (*b2 >= 0.0);
}

/* Since vertices are snapped, a pixel that was drawn may lie outside by a 512th of a pixel: then the nearest
 * point of the edge is taken (scaling the weights instead would slide far along a sliver), and what is still
 * negative is 0. A triangle seen edge-on has no weights: its middle. */
static inline void sl_weights_outside(const sl_edge_lines *l, double e0, double e1, double e2, double *b1,
                                      double *b2) {
    const double side = (e0 + e1) + e2 < 0.0 ? -1.0 : 1.0;
    const double a[3] = {l->a0, l->a1, l->a2}, b[3] = {l->b0, l->b1, l->b2};
    double e[3] = {e0 * side, e1 * side, e2 * side};
    const int edge = e[0] < 0.0 ? 0 : e[1] < 0.0 ? 1 : 2;
    const double length_squared = a[edge] * a[edge] + b[edge] * b[edge];
    if (e[edge] < 0.0 && length_squared > 1e-280) {
        const double step = -e[edge] / length_squared;
        for (int k = 0; k < 3; k++) e[k] = k == edge ? 0.0 : e[k] + (a[k] * a[edge] + b[k] * b[edge]) * step;
    }
    for (int k = 0; k < 3; k++) e[k] = e[k] > 0.0 ? e[k] : 0.0;
    const double sum = (e[0] + e[1]) + e[2];
    const bool sound = sum > 1e-280 && sum < 1e280;
    *b1 = sound ? e[1] / sum : 1.0 / 3.0;
    *b2 = sound ? e[2] / sum : 1.0 / 3.0;
}

/* Weights of corners 1 and 2 at a pixel's centre. */
static inline void sl_weights_at(const sl_edge_lines *l, double x, double y, float *w1, float *w2) {
    double dx = x - l->x, dy = y - l->y, b1, b2;
    double e0 = sl_edge_at(l->a0, l->b0, l->c0, dx, dy), e1 = sl_edge_at(l->a1, l->b1, l->c1, dx, dy);
    double e2 = sl_edge_at(l->a2, l->b2, l->c2, dx, dy);
    if (!sl_weights_inside(e0, e1, e2, &b1, &b2)) sl_weights_outside(l, e0, e1, e2, &b1, &b2);
    *w1 = (float)b1;
    *w2 = (float)b2;
}
