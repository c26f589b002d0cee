/* From world positions to edge functions: culling of clusters, transform, classification, set-up. Every loop runs over independent
 * elements; every element is computed by the same sequence of roundings on all instruction sets.
 *
 * The sequence is llvmpipe's, so that coverage is OSMesa's bit by bit: clip = ((c0 x + c1 y) + c2 z) + c3 without fused
 * operations, window = fma(x * (1/w), W/2, W/2), snapped to 1/256 pixel by rounding to nearest even. */
#include <math.h>
#include <string.h>

#include "raster/internal.h"

/* ---- clusters ---- */

/* A cluster is outside a plane when its centre lies further behind it than box and sphere both reach. The slack covers the
 * rounding of this test and of the transform: what is rejected here would have been culled triangle by triangle. */
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

static uint32_t cull(const sl_raster *r, const sl_pass_view *view, uint32_t *visible) {
    uint32_t count = 0;
    for (size_t first = 0; first < r->cluster_count; first += SL_LANES) {
        int32_t inside[SL_LANES];
        cull_group(r, view, first, inside);
        size_t here = r->cluster_count - first < SL_LANES ? r->cluster_count - first : SL_LANES;
        for (size_t l = 0; l < here; l++) {
            visible[count] = (uint32_t)(first + l);
            count += (uint32_t)inside[l];
        }
    }
    return count;
}

/* ---- vertices ---- */

/* Rounds to the nearest integer, to even on a tie, for |x| <= 2^22: adding 1.5 * 2^23 leaves the integer in the low bits. */
static inline int32_t snap(float x) {
    float shifted = x + 12582912.0f;
    int32_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    return bits - 0x4b400000;
}

static inline int32_t clip_code(float x, float y, float z, float w, int32_t has_far) {
    const float limit = 0x1p60f;
    int32_t valid = (fabsf(x) < limit) & (fabsf(y) < limit) & (fabsf(z) < limit) & (fabsf(w) < limit);
    int32_t near = has_far ? (0.0f > z + w) : (0.0f > z);
    int32_t code = (x > w) * SL_CLIP_RIGHT | (0.0f > x + w) * SL_CLIP_LEFT | (y > w) * SL_CLIP_TOP |
                   (0.0f > y + w) * SL_CLIP_BOTTOM | (near | !(w > 0.0f)) * SL_CLIP_NEAR |
                   (has_far & (z > w)) * SL_CLIP_FAR;
    return valid ? code : SL_CLIP_INVALID;
}

static void transform_clip(const sl_pass_view *view, const float *restrict px, const float *restrict py,
                           const float *restrict pz, uint32_t count, sl_vertex_buffer *restrict out) {
    const float(*m)[4] = view->clip;
    const float ox = view->origin[0], oy = view->origin[1], oz = view->origin[2];
    const int32_t has_far = !view->inverse_w;
#pragma omp simd
    for (uint32_t i = 0; i < count; i++) {
        float qx = px[i] - ox, qy = py[i] - oy, qz = pz[i] - oz;
        float x = ((m[0][0] * qx + m[0][1] * qy) + m[0][2] * qz) + m[0][3];
        float y = ((m[1][0] * qx + m[1][1] * qy) + m[1][2] * qz) + m[1][3];
        float z = ((m[2][0] * qx + m[2][1] * qy) + m[2][2] * qz) + m[2][3];
        float w = ((m[3][0] * qx + m[3][1] * qy) + m[3][2] * qz) + m[3][3];
        out->x[i] = x;
        out->y[i] = y;
        out->z[i] = z;
        out->w[i] = w;
        out->code[i] = clip_code(x, y, z, w, has_far);
    }
}

/* Vertices with any code set get harmless zeros: they reach the screen through clipping only. */
static void transform_window(const sl_pass_view *view, uint32_t count, sl_vertex_buffer *restrict out) {
    const float half_width = view->half_width, half_height = view->half_height;
    const int32_t inverse_w = view->inverse_w;
    for (uint32_t i = 0; i < count; i++) {
        float safe_w = out->code[i] ? 1.0f : out->w[i];
        float oow = 1.0f / safe_w;
        float u = fmaf(out->x[i] * oow, half_width, half_width), v = fmaf(out->y[i] * oow, half_height, half_height);
        float window_depth = fmaf(out->z[i] * oow, 0.5f, 0.5f);
        window_depth = window_depth < 0.0f ? 0.0f : window_depth > 1.0f ? 1.0f : window_depth;
        u = out->code[i] ? 0.0f : (u - 0.5f) * 256.0f;
        v = out->code[i] ? 0.0f : (v - 0.5f) * 256.0f;
        out->u[i] = u;
        out->v[i] = v;
        out->depth[i] = inverse_w ? oow : window_depth;
        out->snapped_u[i] = snap(u);
        out->snapped_v[i] = snap(v);
    }
}

static void transform(const sl_raster *r, uint32_t cluster, const sl_pass_view *view, sl_vertex_buffer *out) {
    uint32_t first = r->first_vertex[cluster];
    uint32_t count = (r->vertices[cluster] + SL_LANES - 1) / SL_LANES * SL_LANES;
    transform_clip(view, r->vertex_x + first, r->vertex_y + first, r->vertex_z + first, count, out);
    transform_window(view, count, out);
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

/* Pixel centres lie at multiples of 256. The largest u and v are exclusive by the fill rule. */
static void classify_corners(const sl_raster *r, uint32_t first, uint32_t count, const sl_pass_view *view,
                             const sl_vertex_buffer *restrict b, uint8_t *restrict class) {
    const uint16_t *restrict c0 = r->corner[0] + first, *restrict c1 = r->corner[1] + first,
                   *restrict c2 = r->corner[2] + first;
    const int32_t *restrict code = b->code, *restrict u = b->snapped_u, *restrict v = b->snapped_v;
    const int32_t last_x = view->width - 1, last_y = view->height - 1;
    const int32_t region_y0 = view->y0, region_y1 = view->y1 - 1;
    for (uint32_t t = 0; t < count; t++) {
        uint32_t i = c0[t], j = c1[t], k = c2[t];
        int32_t any = code[i] | code[j] | code[k], all = code[i] & code[j] & code[k];
        int32_t x0 = (min3(u[i], u[j], u[k]) + 255) >> 8, x1 = (max3(u[i], u[j], u[k]) - 1) >> 8;
        int32_t y0 = (min3(v[i], v[j], v[k]) + 255) >> 8, y1 = (max3(v[i], v[j], v[k]) - 1) >> 8;
        x0 = x0 > 0 ? x0 : 0;
        y0 = y0 > 0 ? y0 : 0;
        x1 = x1 < last_x ? x1 : last_x;
        y1 = y1 < last_y ? y1 : last_y;
        int32_t covers = (x0 <= x1) & (y0 <= y1), here = (y0 <= region_y1) & (y1 >= region_y0);
        int32_t kind = covers ? (here ? ACCEPTED : ELSEWHERE) : CULLED;
        kind = any ? (all ? CULLED : CLIPPED) : kind;
        class[t] = (uint8_t)(any & SL_CLIP_INVALID ? DROPPED : kind);
    }
}

static sl_classes classify(const sl_raster *r, uint32_t cluster, const sl_pass_view *view, const sl_vertex_buffer *b,
                           uint8_t *accepted, uint8_t *clipped) {
    uint32_t first = r->first_triangle[cluster], count = r->triangles[cluster];
    uint8_t class[SL_CLUSTER_TRIANGLES];
    classify_corners(r, first, count, view, b, class);
    if (view->skip != SL_NO_INDEX) {
        for (uint32_t t = 0; t < count; t++) class[t] = r->triangle[first + t] == view->skip ? CULLED : class[t];
    }
    uint32_t accept = 0, clip = 0, kinds[5] = {0};
    for (uint32_t t = 0; t < count; t++) {
        accepted[accept] = clipped[clip] = (uint8_t)t;
        accept += class[t] == ACCEPTED;
        clip += class[t] == CLIPPED;
        kinds[class[t]]++;
    }
    return (sl_classes){accept, clip, kinds[CULLED], kinds[DROPPED]};
}

/* Edge k runs from corner k+1 to corner k+2; E(u, v) = a (u - u_P) + b (v - v_P) is positive inside once the signs are turned by
 * the area's. At pixel centres E = 256 (a i + b j) + c, so E >= 0 is a i + b j + floor(c / 256) >= 0. Edges that do not own
 * their points (all but left edges and lowest horizontal ones) ask for E >= 1. */
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

/* The plane through the three unsnapped vertices, in double, told at the snapped position of the corner with the smallest depth: for
 * 1/w that is the far end, where absolute rounding errors would hurt. Slivers may have wild slopes: the rasterizer clamps to
 * the corners' range, and slopes that could overflow count as none. */
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
