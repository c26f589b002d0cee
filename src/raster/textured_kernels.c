/* Texture coordinates and level of detail of a block of pixels, each by itself.
 *
 * Edge functions in 2D homogeneous coordinates (Olano and Greer 1997): with v_k = (x, y, w) of corner k in clip space,
 * e_k = a_k x + b_k y + c_k = (v_{k+1} x v_{k+2}) . (x, y, 1) is linear on the screen, and an attribute s is the quotient
 *
 *     s(x, y) = sum s_k e_k / sum e_k,     ds/dx = (sum s_k a_k - s sum a_k) / sum e_k,
 *
 * whose derivative is therefore known exactly at the pixel, without a neighbour.
 *
 * Since vertices are snapped, a pixel that was drawn may lie outside its triangle by a 512th of a pixel. The quotient is then that of
 * the triangle's plane beyond the edge, as in OpenGL; the same small part of the pixel's footprint away. Only where the plane
 * is seen so obliquely that a 512th of a pixel leads an eighth of the triangle away, or beyond the horizon, the weights of
 * sl_raster_barycentrics() are taken, which stay on the triangle. */
#include "raster/lookup_kernels.h"
#include "raster/texel_place.h"

enum { N = SL_TEXTURE_BLOCK };

static inline double clip_coordinate(const float row[4], sl_vec3 q) {
    return (((double)row[0] * (double)q.x + (double)row[1] * (double)q.y) + (double)row[2] * (double)q.z) + (double)row[3];
}

/* The three edge functions, with the pixel's centre as the origin and a pixel as unit. */
typedef struct {
    double a0, a1, a2, b0, b1, b2, c0, c1, c2;
} edges;

static inline edges edges_at(const float clip[4][4], sl_vec3 q0, sl_vec3 q1, sl_vec3 q2, double px, double py, double pixel_x,
                             double pixel_y) {
    double w0 = clip_coordinate(clip[3], q0), w1 = clip_coordinate(clip[3], q1), w2 = clip_coordinate(clip[3], q2);
    double x0 = clip_coordinate(clip[0], q0) - px * w0, y0 = clip_coordinate(clip[1], q0) - py * w0;
    double x1 = clip_coordinate(clip[0], q1) - px * w1, y1 = clip_coordinate(clip[1], q1) - py * w1;
    double x2 = clip_coordinate(clip[0], q2) - px * w2, y2 = clip_coordinate(clip[1], q2) - py * w2;
    return (edges){(y1 * w2 - w1 * y2) * pixel_x, (y2 * w0 - w2 * y0) * pixel_x, (y0 * w1 - w0 * y1) * pixel_x,
                   (w1 * x2 - x1 * w2) * pixel_y, (w2 * x0 - x2 * w0) * pixel_y, (w0 * x1 - x0 * w1) * pixel_y,
                   x1 * y2 - y1 * x2,             x2 * y0 - y2 * x0,             x0 * y1 - y0 * x1};
}

/* An attribute that is 0 in corner 0 and d1, d2 in the others, and its derivatives. 0 / 0 (a triangle seen edge-on) gives NaN,
 * which counts as no extent. */
typedef struct {
    double dx, dy;
} gradient;

static inline gradient gradient_of(const edges *e, double d1, double d2) {
    double over = 1.0 / ((e->c0 + e->c1) + e->c2);
    double value = (d1 * e->c1 + d2 * e->c2) * over;
    return (gradient){((d1 * e->a1 + d2 * e->a2) - value * ((e->a0 + e->a1) + e->a2)) * over,
                      ((d1 * e->b1 + d2 * e->b2) - value * ((e->b0 + e->b1) + e->b2)) * over};
}

/* The same attribute (x, y) pixels from here, on the triangle's plane. */
static inline double value_beside(const edges *e, double d1, double d2, double x, double y) {
    double e0 = (e->a0 * x + e->b0 * y) + e->c0, e1 = (e->a1 * x + e->b1 * y) + e->c1;
    double e2 = (e->a2 * x + e->b2 * y) + e->c2;
    return (d1 * e1 + d2 * e2) / ((e0 + e1) + e2);
}

/* Differences in the pixel's quad, whose first pixel is (-x, -y) from here: along its lower row and its left column. */
static inline gradient differences_of(const edges *e, double d1, double d2, double x, double y) {
    double first = value_beside(e, d1, d2, -x, -y);
    return (gradient){value_beside(e, d1, d2, 1.0 - x, -y) - first, value_beside(e, d1, d2, -x, 1.0 - y) - first};
}

/* Inlined twice, with a constant rule. */
__attribute__((always_inline)) static inline void coordinates(const sl_textured_block *restrict block, const sl_view *view,
                                                              double width, double height, bool exact, float *restrict s,
                                                              float *restrict t, float *restrict lod) {
    double pixel_x = 2.0 / (double)view->width, pixel_y = 2.0 / (double)view->height;
    const float *restrict c0 = block->corner[0], *restrict c1 = block->corner[1], *restrict c2 = block->corner[2],
                *restrict c3 = block->corner[3], *restrict c4 = block->corner[4], *restrict c5 = block->corner[5],
                *restrict c6 = block->corner[6], *restrict c7 = block->corner[7], *restrict c8 = block->corner[8];
    const float *restrict s_0 = block->s[0], *restrict s_1 = block->s[1], *restrict s_2 = block->s[2],
                *restrict t_0 = block->t[0], *restrict t_1 = block->t[1], *restrict t_2 = block->t[2];
    const float *restrict weight1 = block->w1, *restrict weight2 = block->w2;
    const int32_t *restrict x = block->x, *restrict y = block->y;
#pragma omp simd
    for (int n = 0; n < N; n++) {
        double s0 = (double)s_0[n], s1 = (double)s_1[n] - s0, s2 = (double)s_2[n] - s0;
        double t0 = (double)t_0[n], t1 = (double)t_1[n] - t0, t2 = (double)t_2[n] - t0;
        double px = ((double)x[n] + 0.5) * pixel_x - 1.0, py = ((double)y[n] + 0.5) * pixel_y - 1.0;
        edges e = edges_at(view->clip, sl_v3(c0[n], c1[n], c2[n]), sl_v3(c3[n], c4[n], c5[n]), sl_v3(c6[n], c7[n], c8[n]), px, py,
                           pixel_x, pixel_y);
        double over = 1.0 / ((e.c0 + e.c1) + e.c2), e0 = e.c0 * over, e1 = e.c1 * over, e2 = e.c2 * over;
        double least = e0 < e1 ? e0 : e1;
        bool near = least > -0.125 && e2 > -0.125; /* not for NaN */
        double w1 = near ? e1 : (double)weight1[n], w2 = near ? e2 : (double)weight2[n];
        s[n] = (float)(s0 + (w1 * s1 + w2 * s2));
        t[n] = (float)(t0 + (w1 * t1 + w2 * t2));
        double odd_x = (double)(x[n] & 1), odd_y = (double)(y[n] & 1);
        gradient ds = exact ? gradient_of(&e, s1, s2) : differences_of(&e, s1, s2, odd_x, odd_y);
        gradient dt = exact ? gradient_of(&e, t1, t2) : differences_of(&e, t1, t2, odd_x, odd_y);
        double u_x = ds.dx * width, v_x = dt.dx * height, u_y = ds.dy * width, v_y = dt.dy * height;
        double along_x = u_x * u_x + v_x * v_x, along_y = u_y * u_y + v_y * v_y;
        lod[n] = 0.5f * sl_log2f((float)(along_x > along_y ? along_x : along_y)); /* as sl_texture_lod() */
    }
}

void SL_KERNEL(sl_textured_coordinates)(const sl_textured_block *block, const sl_view *view, int width, int height,
                                        sl_lod_rule rule, float *s, float *t, float *lod);
void SL_KERNEL(sl_textured_coordinates)(const sl_textured_block *block, const sl_view *view, int width, int height,
                                        sl_lod_rule rule, float *s, float *t, float *lod) {
    if (rule == SL_LOD_EXACT) coordinates(block, view, (double)width, (double)height, true, s, t, lod);
    else coordinates(block, view, (double)width, (double)height, false, s, t, lod);
}
