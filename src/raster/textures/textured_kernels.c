/* Texture coordinates and level of detail of a block of pixels.
 *
 * With the edge functions e_k(x, y), linear on the screen (barycentrics.h), an attribute s is a quotient, and so its
 * derivative is known exactly at the pixel, without a neighbour:
 *
 *     s(x, y) = sum s_k e_k / sum e_k,     ds/dx = (sum s_k a_k - s sum a_k) / sum e_k      (e_k = a_k x + b_k y + c_k)
 *
 * Since vertices are snapped, a pixel that was drawn may lie outside its triangle by a 512th of a pixel. The quotient
 * is then that of the triangle's plane beyond the edge, as in OpenGL: the same small part of the pixel's footprint
 * away. Only where the plane is seen so obliquely that a 512th of a pixel leads an eighth of the triangle away, or
 * beyond the horizon, the block's weights are taken, which stay on the triangle. */
#include "raster/textures/lookup_kernels.h"
#include "raster/textures/texel_place.h"

/* Pixels of a run done together; the last ones go beyond its end, so no wider than the vectors. */
#if defined(__AVX512F__)
enum { LANES = 8 };
#elif defined(__AVX2__)
enum { LANES = 4 };
#else
enum { LANES = 2 };
#endif

/* A run's edge functions, their sum, and one of its attributes: 0 in corner 0, to_1 and to_2 more in the others. */
typedef struct {
    double a0, b0, a1, b1, a2, b2, a, b;
} slopes;
typedef struct {
    double first, to_1, to_2;
    double a, b; /* sum of the values times the edge functions' slopes */
} attribute;

static inline slopes slopes_of(const sl_resolve_block *block, uint32_t r) {
    const double a0 = block->a0[r], a1 = block->a1[r], a2 = block->a2[r], b0 = block->b0[r], b1 = block->b1[r], b2 = block->b2[r];
    return (slopes){a0, b0, a1, b1, a2, b2, (a0 + a1) + a2, (b0 + b1) + b2};
}

static inline attribute attribute_of(const slopes *e, sl_run_corners value, uint32_t r) {
    const double first = (double)value[0][r], to_1 = (double)value[1][r] - first, to_2 = (double)value[2][r] - first;
    return (attribute){first, to_1, to_2, to_1 * e->a1 + to_2 * e->a2, to_1 * e->b1 + to_2 * e->b2};
}

typedef struct {
    double dx, dy;
} gradient;

static inline gradient gradient_of(slopes e, attribute s, double e1, double e2, double over) {
    double value = (s.to_1 * e1 + s.to_2 * e2) * over;
    return (gradient){(s.a - value * e.a) * over, (s.b - value * e.b) * over};
}

/* The attribute (x, y) pixels from here, on the triangle's plane. */
static inline double value_beside(slopes e, attribute s, double e0, double e1, double e2, double x, double y) {
    double f0 = (e.a0 * x + e.b0 * y) + e0, f1 = (e.a1 * x + e.b1 * y) + e1, f2 = (e.a2 * x + e.b2 * y) + e2;
    return (s.to_1 * f1 + s.to_2 * f2) / ((f0 + f1) + f2);
}

/* Differences in the pixel's quad, whose first pixel is (-x, -y) from here: along its lower row and its left column. */
static inline gradient differences_of(slopes e, attribute s, double e0, double e1, double e2, double x, double y) {
    double first = value_beside(e, s, e0, e1, e2, -x, -y);
    return (gradient){value_beside(e, s, e0, e1, e2, 1.0 - x, -y) - first, value_beside(e, s, e0, e1, e2, -x, 1.0 - y) - first};
}

typedef enum { NO_LOD, EXACT, DIFFERENCES } kind;

/* Inlined with a constant kind. Pixels n to n + LANES of a run. */
__attribute__((always_inline)) static inline void coordinates(const sl_resolve_block *block, slopes e, attribute s, attribute t,
                                                              double width, double height, kind lod, const int corner[2],
                                                              sl_textured_block *out, uint32_t n) {
    const double *restrict e_0 = block->e0 + n, *restrict e_1 = block->e1 + n, *restrict e_2 = block->e2 + n;
    const double *restrict column = block->column + n, *restrict row = block->row + n;
    const float *restrict weight1 = block->w1 + n, *restrict weight2 = block->w2 + n;
    float *restrict out_s = out->s + n, *restrict out_t = out->t + n, *restrict out_lod = out->lod + n;
    const int32_t corner_x = corner[0], corner_y = corner[1];
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        double e0 = e_0[l], e1 = e_1[l], e2 = e_2[l], over = 1.0 / ((e0 + e1) + e2);
        double b0 = e0 * over, b1 = e1 * over, b2 = e2 * over, least = b0 < b1 ? b0 : b1;
        double near = (least > -0.125 ? 1.0 : 0.0) * (b2 > -0.125 ? 1.0 : 0.0); /* not for NaN */
        double w1 = near > 0.0 ? b1 : (double)weight1[l], w2 = near > 0.0 ? b2 : (double)weight2[l];
        out_s[l] = (float)(s.first + (w1 * s.to_1 + w2 * s.to_2));
        out_t[l] = (float)(t.first + (w1 * t.to_1 + w2 * t.to_2));
        if (lod == NO_LOD) continue;
        double odd_x = (double)(((int32_t)column[l] + corner_x) & 1), odd_y = (double)(((int32_t)row[l] + corner_y) & 1);
        gradient ds = lod == EXACT ? gradient_of(e, s, e1, e2, over) : differences_of(e, s, e0, e1, e2, odd_x, odd_y);
        gradient dt = lod == EXACT ? gradient_of(e, t, e1, e2, over) : differences_of(e, t, e0, e1, e2, odd_x, odd_y);
        double u_x = ds.dx * width, v_x = dt.dx * height, u_y = ds.dy * width, v_y = dt.dy * height;
        double along_x = u_x * u_x + v_x * v_x, along_y = u_y * u_y + v_y * v_y;
        out_lod[l] = (float)(along_x > along_y ? along_x : along_y);
    }
}

/* Squared axes to levels of detail, as sl_texture_lod(): the whole block's, in lanes of float. */
static void take_logarithms(uint32_t count, float *restrict lod) {
#pragma omp simd
    for (uint32_t n = 0; n < count; n++) lod[n] = 0.5f * sl_log2f(lod[n]);
}

void SL_KERNEL(sl_textured_coordinates)(const sl_resolve_block *block, const sl_view *view, sl_lod_rule rule, bool lod,
                                        sl_textured_block *textured);
void SL_KERNEL(sl_textured_coordinates)(const sl_resolve_block *block, const sl_view *view, sl_lod_rule rule, bool lod,
                                        sl_textured_block *textured) {
    const int corner[2] = {view->x & 1, view->y & 1}; /* quads are told from the target's corner */
    for (uint32_t r = 0; r < block->runs; r++) {
        if (!textured->image[r]) continue;
        slopes e = slopes_of(block, r);
        attribute s = attribute_of(&e, textured->corner_s, r), t = attribute_of(&e, textured->corner_t, r);
        double width = (double)textured->image[r]->width[0], height = (double)textured->image[r]->height[0];
        for (uint32_t n = block->start[r]; n < block->start[r + 1]; n += LANES) {
            if (!lod) coordinates(block, e, s, t, width, height, NO_LOD, corner, textured, n);
            else if (rule == SL_LOD_EXACT) coordinates(block, e, s, t, width, height, EXACT, corner, textured, n);
            else coordinates(block, e, s, t, width, height, DIFFERENCES, corner, textured, n);
        }
    }
    if (lod) take_logarithms(block->count, textured->lod);
}
