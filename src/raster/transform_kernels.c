/* Transform: a cluster's vertices from world space to clip space, and those inside the view on to the window.
 *
 * The sequence of roundings is llvmpipe's, so that coverage is OSMesa's bit by bit: clip = ((c0 x + c1 y) +
 * c2 z) + c3 without fused operations, window = fma(x * (1/w), W/2, W/2 + x0), snapped to 1/256 pixel by
 * rounding to nearest even. */
#include <math.h>
#include <string.h>

#include "raster/triangles.h"

/* Rounds to the nearest integer, to even on a tie, for |x| <= 2^22: adding 1.5 * 2^23 leaves the integer in
 * the low bits. */
static inline int32_t snap(float x) {
    float shifted = x + 12582912.0f;
    int32_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    return bits - 0x4b400000;
}

static void transform_clip(const sl_pass_view *view, const float *restrict px, const float *restrict py,
                           const float *restrict pz, float *restrict out_x, float *restrict out_y,
                           float *restrict out_z, float *restrict out_w) {
    const float(*m)[4] = view->clip;
    const float m00 = m[0][0], m01 = m[0][1], m02 = m[0][2], m03 = m[0][3], m10 = m[1][0], m11 = m[1][1],
                m12 = m[1][2], m13 = m[1][3], m20 = m[2][0], m21 = m[2][1], m22 = m[2][2], m23 = m[2][3],
                m30 = m[3][0], m31 = m[3][1], m32 = m[3][2], m33 = m[3][3];
    const float ox = view->origin[0], oy = view->origin[1], oz = view->origin[2];
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float qx = px[l] - ox, qy = py[l] - oy, qz = pz[l] - oz;
        float x = ((m00 * qx + m01 * qy) + m02 * qz) + m03;
        float y = ((m10 * qx + m11 * qy) + m12 * qz) + m13;
        float z = ((m20 * qx + m21 * qy) + m22 * qz) + m23;
        float w = ((m30 * qx + m31 * qy) + m32 * qz) + m33;
        out_x[l] = x;
        out_y[l] = y;
        out_z[l] = z;
        out_w[l] = w;
    }
}

/* A view without a far plane has its near plane's distance in z alone (near_w 0, else 1). What lies behind
 * the eye is outside one of the sides, and need not lie before an oblique near plane: only a corner at the
 * eye is counted as before it. The coordinates are valid where none is NaN, infinite or huge. Selections of
 * integers only, without truth values between: that is what compilers vectorise. */
static void clip_codes(const float *restrict xs, const float *restrict ys, const float *restrict zs,
                       const float *restrict ws, float near_w, int32_t far_code, int32_t *restrict codes) {
    const float limit = 0x1p60f;
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float x = xs[l], y = ys[l], z = zs[l], w = ws[l];
        int32_t right = x > w ? SL_CLIP_RIGHT : 0, left = 0.0f > x + w ? SL_CLIP_LEFT : 0;
        int32_t top = y > w ? SL_CLIP_TOP : 0, bottom = 0.0f > y + w ? SL_CLIP_BOTTOM : 0;
        int32_t sides = right | left | top | bottom, at_eye = sides ? 0 : SL_CLIP_NEAR;
        int32_t near = 0.0f > z + w * near_w ? SL_CLIP_NEAR : 0, behind = w >= SL_LEAST_W ? 0 : at_eye;
        int32_t far = z > w ? far_code : 0;
        float largest = fabsf(x) + fabsf(y) + fabsf(z) + fabsf(w);
        int32_t all = sides | near | behind | far;
        codes[l] = largest < limit ? all : SL_CLIP_INVALID;
    }
}

/* One coordinate to the window. Vertices with any code set get a harmless place: they reach the screen
 * through clipping only. */
static void transform_window(const float *restrict x, const float *restrict oow, const int32_t *restrict code,
                             float half, float offset, float *restrict out, int32_t *restrict snapped) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float window = fmaf(x[l] * oow[l], half, offset);
        window = code[l] ? 0.5f : window;
        out[l] = window;
        snapped[l] = snap((window - 0.5f) * 256.0f);
    }
}

/* Depths of vertices inside the view leave [0,1] by rounding at most; OSMesa lets them (and bounds those of
 * pixels). */
static void transform_depth(const float *restrict z, const float *restrict oow, sl_depth_rule rule,
                            float *restrict depth) {
    const bool inverse_w = rule == SL_NEARER_IS_LARGER;
    const float slack = rule == SL_OPENGL_PLANE ? 1.0f : 0.0f, least = 0.0f - slack, most = 1.0f + slack;
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float window = fmaf(z[l] * oow[l], 0.5f, 0.5f);
        window = window > least ? window : least;
        window = window < most ? window : most;
        depth[l] = inverse_w ? oow[l] : window;
    }
}

/* Shifts of negative numbers round down. */
static void find_cells(const int32_t *restrict u, const int32_t *restrict v, int32_t *restrict cell) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) cell[l] = ((v[l] + 255) >> 8) << 16 | (u[l] + 255) >> 8;
}

static void reciprocals(const float *restrict w, const int32_t *restrict code, float *restrict oow) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) oow[l] = 1.0f / (code[l] ? 1.0f : w[l]);
}

static void transform_group(const sl_raster *r, size_t from, const sl_pass_view *view, sl_vertex_buffer *out,
                            size_t to) {
    transform_clip(view, r->vertex_x + from, r->vertex_y + from, r->vertex_z + from, out->x + to, out->y + to,
                   out->z + to, out->w + to);
    clip_codes(out->x + to, out->y + to, out->z + to, out->w + to, view->inverse_w ? 0.0f : 1.0f,
               view->inverse_w ? 0 : SL_CLIP_FAR, out->code + to);
    reciprocals(out->w + to, out->code + to, out->oow + to);
    transform_window(out->x + to, out->oow + to, out->code + to, view->half_width, view->offset_x,
                     out->window_x + to, out->snapped_u + to);
    transform_window(out->y + to, out->oow + to, out->code + to, view->half_height, view->offset_y,
                     out->window_y + to, out->snapped_v + to);
    transform_depth(out->z + to, out->oow + to, view->rule, out->depth + to);
    find_cells(out->snapped_u + to, out->snapped_v + to, out->cell + to);
}

void SL_KERNEL(sl_raster_transform)(const sl_raster *r, uint32_t cluster, const sl_pass_view *view,
                                    sl_vertex_buffer *out) {
    size_t first = r->first_vertex[cluster];
    for (size_t i = 0; i < r->vertices[cluster]; i += SL_LANES) transform_group(r, first + i, view, out, i);
}
