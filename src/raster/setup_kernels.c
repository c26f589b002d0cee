/* From world positions to edge functions: culling of clusters, transform, classification, set-up. Every loop runs
 * over independent elements; every element is computed by the same sequence of roundings on all instruction sets.
 *
 * The sequence is llvmpipe's, so that coverage is OSMesa's bit by bit: clip = ((c0 x + c1 y) + c2 z) + c3 without
 * fused operations, window = fma(x * (1/w), W/2, W/2), snapped to 1/256 pixel by rounding to nearest even. */
#include <math.h>
#include <string.h>

#include "raster/internal.h"

/* ---- clusters ---- */

/* A cluster is outside a plane when its centre lies further behind it than box and sphere both reach. The slack
 * covers the rounding of this test and of the transform: what is rejected here would have been culled triangle by
 * triangle. */
static void cull_group(const sl_raster *r, const sl_pass_view *view, size_t first, int32_t *restrict inside) {
    const float *restrict cx = r->centre_x + first, *restrict cy = r->centre_y + first, *restrict cz = r->centre_z + first;
    const float *restrict hx = r->half_x + first, *restrict hy = r->half_y + first, *restrict hz = r->half_z + first;
    const float *restrict radius = r->radius + first;
    for (int l = 0; l < SL_LANES; l++) inside[l] = 1;
    for (int k = 0; k < view->planes; k++) {
        const float nx = view->plane[k][0], ny = view->plane[k][1], nz = view->plane[k][2], d = view->plane[k][3];
        const float length = view->plane_length[k];
        const float ox = view->origin[0], oy = view->origin[1], oz = view->origin[2];
#pragma omp simd
        for (int l = 0; l < SL_LANES; l++) {
            float x = nx * (cx[l] - ox), y = ny * (cy[l] - oy), z = nz * (cz[l] - oz);
            float box = fabsf(nx) * hx[l] + fabsf(ny) * hy[l] + fabsf(nz) * hz[l];
            float sphere = length * radius[l];
            float reach = box < sphere ? box : sphere;
            float slack = 1e-5f * (fabsf(x) + fabsf(y) + fabsf(z) + fabsf(d) + reach);
            inside[l] &= !(x + y + z + d < -(reach + slack));
        }
    }
}

/* A cluster between pixel centres: its box seen on the screen, by interval arithmetic, holds no centre in x or in y.
 * Only where the whole box lies before the eye. The hundredth of a pixel covers the snapping and all rounding. */
static void cull_between_centres(const sl_raster *r, const sl_pass_view *view, size_t first, int32_t *restrict inside) {
    const float *restrict cx = r->centre_x + first, *restrict cy = r->centre_y + first, *restrict cz = r->centre_z + first;
    const float *restrict hx = r->half_x + first, *restrict hy = r->half_y + first, *restrict hz = r->half_z + first;
    const float(*m)[4] = view->clip;
    const float ox = view->origin[0], oy = view->origin[1], oz = view->origin[2];
    const float half_width = view->half_width, half_height = view->half_height, margin = 0.01f;
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float px = cx[l] - ox, py = cy[l] - oy, pz = cz[l] - oz;
        float x = m[0][0] * px + m[0][1] * py + m[0][2] * pz + m[0][3];
        float y = m[1][0] * px + m[1][1] * py + m[1][2] * pz + m[1][3];
        float w = m[3][0] * px + m[3][1] * py + m[3][2] * pz + m[3][3];
        float rx = fabsf(m[0][0]) * hx[l] + fabsf(m[0][1]) * hy[l] + fabsf(m[0][2]) * hz[l];
        float ry = fabsf(m[1][0]) * hx[l] + fabsf(m[1][1]) * hy[l] + fabsf(m[1][2]) * hz[l];
        float rw = fabsf(m[3][0]) * hx[l] + fabsf(m[3][1]) * hy[l] + fabsf(m[3][2]) * hz[l];
        float slack = 1e-5f * (fabsf(x) + fabsf(y) + fabsf(w) + rx + ry + rw);
        rx += slack;
        ry += slack;
        float nearest = w - (rw + slack), farthest = w + (rw + slack);
        int32_t before = nearest > 0.0f;
        float over_near = 1.0f / (before ? nearest : 1.0f), over_far = 1.0f / (before ? farthest : 1.0f);
        float x_low = x - rx, x_high = x + rx, y_low = y - ry, y_high = y + ry;
        float u_low = x_low * (x_low < 0.0f ? over_near : over_far), u_high = x_high * (x_high > 0.0f ? over_near : over_far);
        float v_low = y_low * (y_low < 0.0f ? over_near : over_far), v_high = y_high * (y_high > 0.0f ? over_near : over_far);
        /* Pixel coordinates of the ends; ceil(low) > floor(high) means no centre. */
        float i_low = ceilf(u_low * half_width + (half_width - 0.5f) - margin);
        float i_high = floorf(u_high * half_width + (half_width - 0.5f) + margin);
        float j_low = ceilf(v_low * half_height + (half_height - 0.5f) - margin);
        float j_high = floorf(v_high * half_height + (half_height - 0.5f) + margin);
        inside[l] &= !(before & ((i_low > i_high) | (j_low > j_high)));
    }
}

static uint32_t cull(const sl_raster *r, const sl_pass_view *view, uint32_t *visible) {
    uint32_t count = 0;
    for (size_t first = 0; first < r->cluster_count; first += SL_LANES) {
        int32_t inside[SL_LANES];
        cull_group(r, view, first, inside);
        cull_between_centres(r, view, first, inside);
        size_t here = r->cluster_count - first < SL_LANES ? r->cluster_count - first : SL_LANES;
        for (size_t l = 0; l < here; l++) {
            visible[count] = (uint32_t)(first + l);
            count += (uint32_t)inside[l];
        }
    }
    return count;
}

/* ---- vertices ---- */

/* Rounds to the nearest integer, to even on a tie, for |x| <= 2^22: adding 1.5 * 2^23 leaves the integer in the low
 * bits. */
static inline int32_t snap(float x) {
    float shifted = x + 12582912.0f;
    int32_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    return bits - 0x4b400000;
}

/* A view without a far plane has its near plane's distance in z alone (near_w 0, else 1). The coordinates are valid
 * where none is NaN, infinite or huge. Selections of integers only, without truth values between: that is what
 * compilers vectorise. */
static void clip_codes(const float *restrict xs, const float *restrict ys, const float *restrict zs,
                       const float *restrict ws, float near_w, int32_t far_code, int32_t *restrict codes) {
    const float limit = 0x1p60f;
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float x = xs[l], y = ys[l], z = zs[l], w = ws[l];
        int32_t right = x > w ? SL_CLIP_RIGHT : 0, left = 0.0f > x + w ? SL_CLIP_LEFT : 0;
        int32_t top = y > w ? SL_CLIP_TOP : 0, bottom = 0.0f > y + w ? SL_CLIP_BOTTOM : 0;
        int32_t near = 0.0f > z + w * near_w ? SL_CLIP_NEAR : 0, behind = w > 0.0f ? 0 : SL_CLIP_NEAR;
        int32_t far = z > w ? far_code : 0;
        float largest = fabsf(x) + fabsf(y) + fabsf(z) + fabsf(w);
        int32_t all = right | left | top | bottom | near | behind | far;
        codes[l] = largest < limit ? all : SL_CLIP_INVALID;
    }
}

static void transform_clip(const sl_pass_view *view, const float *restrict px, const float *restrict py,
                           const float *restrict pz, float *restrict out_x, float *restrict out_y, float *restrict out_z,
                           float *restrict out_w) {
    const float(*m)[4] = view->clip;
    const float m00 = m[0][0], m01 = m[0][1], m02 = m[0][2], m03 = m[0][3], m10 = m[1][0], m11 = m[1][1], m12 = m[1][2],
                m13 = m[1][3], m20 = m[2][0], m21 = m[2][1], m22 = m[2][2], m23 = m[2][3], m30 = m[3][0], m31 = m[3][1],
                m32 = m[3][2], m33 = m[3][3];
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

/* One coordinate to the window, in 1/256 pixel. Vertices with any code set get harmless zeros: they reach the screen
 * through clipping only. */
static void transform_window(const float *restrict x, const float *restrict oow, const int32_t *restrict code, float half,
                             float *restrict out, int32_t *restrict snapped) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float window = fmaf(x[l] * oow[l], half, half);
        float u = (window - 0.5f) * 256.0f;
        u = code[l] ? 0.0f : u;
        out[l] = u;
        snapped[l] = snap(u);
    }
}

static void transform_depth(const float *restrict z, const float *restrict oow, bool inverse_w, float *restrict depth) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) {
        float window = fmaf(z[l] * oow[l], 0.5f, 0.5f);
        window = window > 0.0f ? window : 0.0f;
        window = window < 1.0f ? window : 1.0f;
        depth[l] = inverse_w ? oow[l] : window;
    }
}

/* See classify_inside(); shifts of negative numbers round down. */
static void find_cells(const int32_t *restrict u, const int32_t *restrict v, int32_t *restrict cell) {
#pragma omp simd
    for (int l = 0; l < SL_LANES; l++) cell[l] = ((v[l] + 255) >> 8) << 16 | (u[l] + 255) >> 8;
}

static void transform_group(const sl_raster *r, size_t from, const sl_pass_view *view, sl_vertex_buffer *out, size_t to) {
    float oow[SL_LANES];
    transform_clip(view, r->vertex_x + from, r->vertex_y + from, r->vertex_z + from, out->x + to, out->y + to, out->z + to,
                   out->w + to);
    clip_codes(out->x + to, out->y + to, out->z + to, out->w + to, view->inverse_w ? 0.0f : 1.0f,
               view->inverse_w ? 0 : SL_CLIP_FAR, out->code + to);
    for (int l = 0; l < SL_LANES; l++) {
        float w = out->w[to + (size_t)l];
        oow[l] = 1.0f / (out->code[to + (size_t)l] ? 1.0f : w);
    }
    transform_window(out->x + to, oow, out->code + to, view->half_width, out->u + to, out->snapped_u + to);
    transform_window(out->y + to, oow, out->code + to, view->half_height, out->v + to, out->snapped_v + to);
    transform_depth(out->z + to, oow, view->inverse_w, out->depth + to);
    find_cells(out->snapped_u + to, out->snapped_v + to, out->cell + to);
}

static void transform(const sl_raster *r, uint32_t cluster, const sl_pass_view *view, sl_vertex_buffer *out) {
    size_t first = r->first_vertex[cluster];
    for (size_t i = 0; i < r->vertices[cluster]; i += SL_LANES) transform_group(r, first + i, view, out, i);
}

/* ---- triangles ---- */

static inline int32_t min3(int32_t a, int32_t b, int32_t c) {
    int32_t m = a < b ? a : b;
    return m < c ? m : c;
}
static inline int32_t max3(int32_t a, int32_t b, int32_t c) {
    int32_t m = a > b ? a : b;
    return m > c ? m : c;
}

enum { CULLED, ACCEPTED, ELSEWHERE, CLIPPED, DROPPED }; /* ELSEWHERE: on the target, but not in this region */

/* A vertex's cell is (i, j) = (ceil(u / 256), ceil(v / 256)): pixel centres lie at multiples of 256, the least u is
 * inclusive and the largest exclusive by the fill rule, so a triangle's box holds a centre only if its corners'
 * cells differ in i and in j. Cells of vertices on the screen fit 16 bits, so one gathered word says it for each
 * corner. A whole group at a time: what lies beyond the cluster's last triangle is not looked at. */
static void classify_inside(const uint16_t *restrict c0, const uint16_t *restrict c1, const uint16_t *restrict c2,
                            const int32_t *restrict cell, int32_t y0, int32_t y1, uint8_t *restrict class) {
#pragma omp simd
    for (int t = 0; t < SL_LANES; t++) {
        int32_t p = cell[c0[t]], q = cell[c1[t]], r = cell[c2[t]];
        int32_t px = p & 0xffff, qx = q & 0xffff, rx = r & 0xffff, py = p >> 16, qy = q >> 16, ry = r >> 16;
        int32_t low_y = min3(py, qy, ry), high_y = max3(py, qy, ry);
        int32_t here = high_y > y0 ? ACCEPTED : ELSEWHERE; /* rows low_y to high_y - 1 */
        here = low_y < y1 ? here : ELSEWHERE;
        here = low_y < high_y ? here : CULLED;
        here = min3(px, qx, rx) < max3(px, qx, rx) ? here : CULLED;
        class[t] = (uint8_t)here;
    }
}

/* Where some vertex of the cluster is outside a plane or not valid. */
static void classify_crossing(const uint16_t *restrict c0, const uint16_t *restrict c1, const uint16_t *restrict c2,
                              uint32_t count, const int32_t *restrict code, uint8_t *restrict class) {
    for (uint32_t t = 0; t < count; t++) {
        int32_t p = code[c0[t]], q = code[c1[t]], r = code[c2[t]];
        int32_t any = p | q | r, all = p & q & r;
        uint8_t kind = any ? (all ? CULLED : CLIPPED) : class[t];
        class[t] = any & SL_CLIP_INVALID ? DROPPED : kind;
    }
}

static uint32_t count_class(const uint8_t *restrict class, uint32_t count, uint8_t which) {
    uint8_t found = 0; /* at most SL_CLUSTER_TRIANGLES */
    for (uint32_t t = 0; t < count; t++) found = (uint8_t)(found + (class[t] == which));
    return found;
}

static uint32_t list_class(const uint8_t *restrict class, uint32_t count, uint8_t which, uint8_t *restrict list) {
    uint32_t found = 0;
    for (uint32_t t = 0; t < count; t++) {
        list[found] = (uint8_t)t;
        found += class[t] == which;
    }
    return found;
}

static sl_classes classify(const sl_raster *r, uint32_t cluster, const sl_pass_view *view, const sl_vertex_buffer *b,
                           uint8_t *accepted, uint8_t *clipped) {
    uint32_t first = r->first_triangle[cluster], count = r->triangles[cluster];
    const uint16_t *corner[3] = {r->corner[0] + first, r->corner[1] + first, r->corner[2] + first};
    uint8_t class[SL_CLUSTER_TRIANGLES];
    sl_classes result = {0, 0, 0, 0};
    for (uint32_t t = 0; t < count; t += SL_LANES) {
        classify_inside(corner[0] + t, corner[1] + t, corner[2] + t, b->cell, view->y0, view->y1, class + t);
    }
    int32_t codes = 0;
    for (uint32_t i = 0; i < r->vertices[cluster]; i++) codes |= b->code[i];
    if (codes) classify_crossing(corner[0], corner[1], corner[2], count, b->code, class);
    if (view->skip != SL_NO_INDEX) {
        for (uint32_t t = 0; t < count; t++) class[t] = r->triangle[first + t] == view->skip ? CULLED : class[t];
    }
    result.culled = count_class(class, count, CULLED);
    if (result.culled < count) result.accepted = list_class(class, count, ACCEPTED, accepted);
    if (codes) {
        result.dropped = count_class(class, count, DROPPED);
        result.clipped = list_class(class, count, CLIPPED, clipped);
    }
    return result;
}

/* Edge k runs from corner k+1 to corner k+2; E(u, v) = a (u - u_P) + b (v - v_P) is positive inside once the signs
 * are turned by the area's. At pixel centres E = 256 (a i + b j) + c, so E >= 0 is a i + b j + floor(c / 256) >= 0.
 * Edges that do not own their points (all but left edges and lowest horizontal ones) ask for E >= 1. */
static void set_up_edges(sl_batch *restrict batch, uint32_t n) {
    for (uint32_t t = 0; t < n; t++) {
        int32_t u0 = batch->snapped_u[0][t], u1 = batch->snapped_u[1][t], u2 = batch->snapped_u[2][t];
        int32_t v0 = batch->snapped_v[0][t], v1 = batch->snapped_v[1][t], v2 = batch->snapped_v[2][t];
        int64_t area = (int64_t)(u1 - u0) * (v2 - v0) - (int64_t)(u2 - u0) * (v1 - v0);
        int32_t sign = area < 0 ? -1 : 1;
        int32_t a0 = (v1 - v2) * sign, a1 = (v2 - v0) * sign, a2 = (v0 - v1) * sign;
        int32_t b0 = (u2 - u1) * sign, b1 = (u0 - u2) * sign, b2 = (u1 - u0) * sign;
        int64_t c0 = -((int64_t)a0 * u1 + (int64_t)b0 * v1), c1 = -((int64_t)a1 * u2 + (int64_t)b1 * v2);
        int64_t c2 = -((int64_t)a2 * u0 + (int64_t)b2 * v0);
        batch->a[0][t] = a0;
        batch->a[1][t] = a1;
        batch->a[2][t] = a2;
        batch->b[0][t] = b0;
        batch->b[1][t] = b1;
        batch->b[2][t] = b2;
        batch->c[0][t] = (c0 - !((a0 > 0) | ((a0 == 0) & (b0 > 0)))) >> 8;
        batch->c[1][t] = (c1 - !((a1 > 0) | ((a1 == 0) & (b1 > 0)))) >> 8;
        batch->c[2][t] = (c2 - !((a2 > 0) | ((a2 == 0) & (b2 > 0)))) >> 8;
        batch->x1[t] = area == 0 ? -1 : 0; /* for set_up_bounds() */
    }
}

/* The pixels whose centres the box may hold, cut to the region; a box of one pixel is tested at once. */
static void set_up_bounds(const sl_pass_view *view, sl_batch *restrict batch, uint32_t n) {
    const int32_t region_x0 = view->x0, region_x1 = view->x1 - 1, region_y0 = view->y0, region_y1 = view->y1 - 1;
    for (uint32_t t = 0; t < n; t++) {
        int32_t u0 = batch->snapped_u[0][t], u1 = batch->snapped_u[1][t], u2 = batch->snapped_u[2][t];
        int32_t v0 = batch->snapped_v[0][t], v1 = batch->snapped_v[1][t], v2 = batch->snapped_v[2][t];
        int32_t x0 = (min3(u0, u1, u2) + 255) >> 8, x1 = (max3(u0, u1, u2) - 1) >> 8;
        int32_t y0 = (min3(v0, v1, v2) + 255) >> 8, y1 = (max3(v0, v1, v2) - 1) >> 8;
        x0 = x0 > region_x0 ? x0 : region_x0;
        y0 = y0 > region_y0 ? y0 : region_y0;
        x1 = x1 < region_x1 ? x1 : region_x1;
        y1 = y1 < region_y1 ? y1 : region_y1;
        int64_t e0 = batch->c[0][t] + (int64_t)batch->a[0][t] * x0 + (int64_t)batch->b[0][t] * y0;
        int64_t e1 = batch->c[1][t] + (int64_t)batch->a[1][t] * x0 + (int64_t)batch->b[1][t] * y0;
        int64_t e2 = batch->c[2][t] + (int64_t)batch->a[2][t] * x0 + (int64_t)batch->b[2][t] * y0;
        int32_t missed = (x0 == x1) & (y0 == y1) & ((e0 | e1 | e2) < 0);
        int32_t empty = (batch->x1[t] < 0) | (x0 > x1) | (y0 > y1) | missed;
        batch->x0[t] = empty ? 0 : x0;
        batch->y0[t] = y0;
        batch->x1[t] = empty ? -1 : x1;
        batch->y1[t] = y1;
    }
}

/* The plane through the three unsnapped vertices, in double, told at the snapped position of the corner with the
 * smallest depth: for 1/w that is the far end, where absolute rounding errors would hurt. Slivers may have wild
 * slopes: the rasterizer clamps to the corners' range, and slopes that could overflow count as none. */
static void set_up_depth(sl_batch *restrict batch, uint32_t n) {
    for (uint32_t t = 0; t < n; t++) {
        float z0 = batch->depth[0][t], z1 = batch->depth[1][t], z2 = batch->depth[2][t];
        double u0 = (double)batch->u[0][t], v0 = (double)batch->v[0][t];
        double du1 = (double)batch->u[1][t] - u0, dv1 = (double)batch->v[1][t] - v0;
        double du2 = (double)batch->u[2][t] - u0, dv2 = (double)batch->v[2][t] - v0;
        double dz1 = (double)z1 - (double)z0, dz2 = (double)z2 - (double)z0;
        double area = du1 * dv2 - dv1 * du2;
        double over = 1.0 / (area != 0.0 ? area : 1.0);
        double du = (dz1 * dv2 - dz2 * dv1) * over, dv = (dz2 * du1 - dz1 * du2) * over;
        bool steep = !((fabs(du) < 1e20) & (fabs(dv) < 1e20)) | (area == 0.0);
        du = steep ? 0.0 : du;
        dv = steep ? 0.0 : dv;
        bool use1 = z1 < z0, use2 = z2 < (use1 ? z1 : z0);
        int32_t origin_u = use2 ? batch->snapped_u[2][t] : use1 ? batch->snapped_u[1][t] : batch->snapped_u[0][t];
        int32_t origin_v = use2 ? batch->snapped_v[2][t] : use1 ? batch->snapped_v[1][t] : batch->snapped_v[0][t];
        float least = use2 ? z2 : use1 ? z1 : z0;
        float most = z0 > z1 ? z0 : z1;
        batch->depth_du[t] = (float)du;
        batch->depth_dv[t] = (float)dv;
        batch->depth_origin[t] = (float)((double)z0 + (du * ((double)origin_u - u0) + dv * ((double)origin_v - v0)));
        batch->depth_min[t] = least;
        batch->depth_max[t] = most > z2 ? most : z2;
        batch->origin_u[t] = origin_u;
        batch->origin_v[t] = origin_v;
    }
}

static void set_up(const sl_pass_view *view, sl_batch *batch) {
    uint32_t n = (batch->count + SL_LANES - 1) / SL_LANES * SL_LANES; /* what lies beyond the count was valid once */
    set_up_edges(batch, n);
    set_up_bounds(view, batch, n);
    set_up_depth(batch, n);
}

/* ---- the table ---- */

void SL_KERNEL(sl_raster_rasterize)(const sl_pass_view *view, const sl_batch *batch, uint32_t *id, float *depth);
void SL_KERNEL(sl_raster_barycentric_weights)(const sl_barycentric_block *block, const sl_pass_view *view, float *w1,
                                              float *w2);

extern const sl_raster_kernels SL_KERNEL(sl_raster_kernels);
const sl_raster_kernels SL_KERNEL(sl_raster_kernels) = {
    cull, transform, classify, set_up, SL_KERNEL(sl_raster_rasterize), SL_KERNEL(sl_raster_barycentric_weights)};
