#include "cache/multi_mesh/gather_kernels.h"

/* Where the line from the eye through a pixel meets its triangle: with corner p and edges e1, e2 from it, t = eye - p and d the direction, corners 1 and 2
 * weigh d.(e2 x t) / -(d.n) and d.(t x e1) / -(d.n), n = e1 x e2 (Moeller and Trumbore 1997). The eye is in front of the triangle where t.n > 0. Vertices
 * were snapped to 1/256 pixel when it was drawn, so pixels on its rim may lie a little outside: weights are clamped to the triangle. */
typedef struct hit {
    float w1, w2;
    int back;
} hit;

static inline hit meet(const float *restrict v, int at, sl_vec3 eye, float dx, float dy, float dz) {
    float tx = eye.x - v[at], ty = eye.y - v[at + 1], tz = eye.z - v[at + 2];
    float ax = v[at + 3], ay = v[at + 4], az = v[at + 5], bx = v[at + 6], by = v[at + 7], bz = v[at + 8];
    float nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
    float across = -(dx * nx + dy * ny + dz * nz), over = 1.0f / (across != 0.0f ? across : 1.0f);
    float w1 = (dx * (by * tz - bz * ty) + dy * (bz * tx - bx * tz) + dz * (bx * ty - by * tx)) * over;
    float w2 = (dx * (ty * az - tz * ay) + dy * (tz * ax - tx * az) + dz * (tx * ay - ty * ax)) * over;
    w1 = w1 > 0.0f ? w1 : 0.0f; /* also where it is not a number */
    w2 = w2 > 0.0f ? w2 : 0.0f;
    w1 = w1 < 1.0f ? w1 : 1.0f;
    w2 = w2 < 1.0f ? w2 : 1.0f;
    float sum = w1 + w2, shrink = 1.0f / (sum > 1.0f ? sum : 1.0f);
    return (hit){w1 * shrink, w2 * shrink, !(tx * nx + ty * ny + tz * nz >= 0.0f)};
}

static void shade_row(const sl_mesh_gather_pixels *p, int row) {
    const size_t first = (size_t)row * (size_t)p->width;
    const uint32_t *restrict id = p->id + first;
    const float *restrict x = p->x, *restrict triangle = p->triangle, *restrict colour = p->colour, *restrict weight = p->weight + first;
    const sl_coarse_face *restrict face = p->face;
    float *restrict red = p->radiance[0] + first, *restrict green = p->radiance[1] + first, *restrict blue = p->radiance[2] + first;
    float *restrict wr = p->weighted[0] + first, *restrict wg = p->weighted[1] + first, *restrict wb = p->weighted[2] + first;
    const sl_frame f = p->frame;
    const sl_vec3 eye = p->eye, up = p->horizon;
    const float y = p->y[row], ox = y * f.y.x + f.z.x, oy = y * f.y.y + f.z.y, oz = y * f.y.z + f.z.z;
    const uint32_t nothing = p->triangle_count;
    const int width = p->width;
#pragma omp simd
    for (int k = 0; k < width; k++) {
        float dx = x[k] * f.x.x + ox, dy = x[k] * f.x.y + oy, dz = x[k] * f.x.z + oz;
        int seen = (int)(id[k] < nothing ? id[k] : nothing);
        hit h = meet(triangle, seen * SL_MESH_GATHER_FLOATS, eye, dx, dy, dz);
        int of = 2 * seen + h.back;
        float a, b;
        int at = (face[of].first + sl_coarse_locate(h.w1, h.w2, face[of].rows, &a, &b)) * SL_COARSE_FLOATS;
        float r = colour[at] + a * colour[at + 3] + b * colour[at + 6];
        float g = colour[at + 1] + a * colour[at + 4] + b * colour[at + 7];
        float l = colour[at + 2] + a * colour[at + 5] + b * colour[at + 8];
        float above = dx * up.x + dy * up.y + dz * up.z > 0.0f ? 1.0f : 0.0f;
        r = above * (r > 0.0f ? r : 0.0f);
        g = above * (g > 0.0f ? g : 0.0f);
        l = above * (l > 0.0f ? l : 0.0f);
        red[k] = r;
        green[k] = g;
        blue[k] = l;
        wr[k] = r * weight[k];
        wg[k] = g * weight[k];
        wb[k] = l * weight[k];
    }
}

void SL_KERNEL(sl_mesh_gather_shade)(const sl_mesh_gather_pixels *pixels) {
    for (int row = 0; row < pixels->height; row++) shade_row(pixels, row);
}
