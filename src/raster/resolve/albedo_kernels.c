/* Albedo: a run's material says it, times its texture where there is one; unfiltered to the bit as
 * sl_scene_diffuse().
 *
 * Where the four texels lie and how they are mixed is worked out in lanes; fetching and decoding their bytes
 * is not, since each is a load by itself on any instruction set. */
#include <string.h>

#include "raster/resolve/resolve.h"
#include "scene/surface_rules.h"
#include "scene/texture.h"
#include "scene/texture_rules.h"

enum { LANES = SL_LANES };

/* The lookups of some neighbours, side by side. */
typedef struct lookups {
    int32_t level[LANES], width[LANES], height[LANES];
    uint32_t texel[4][LANES]; /* lower left, lower right, upper left, upper right */
    float right[LANES], up[LANES];
    float value[3][4][LANES]; /* linear: channel, texel */
} lookups;

/* A sub-sample stands for a pixel's quarter at least. */
static const double footprint_squared = 0.25;

/* Squares of footprints' shorter sides, in texels: derivatives of w = e / (e0 + e1 + e2) along the picture's
 * columns and rows give those of u and v; the parallelogram's area over its longer side is the shorter one.
 */
static inline void measure(const sl_resolve_block *block, const sl_albedo_block *a, uint32_t r, uint32_t n,
                           float *restrict squared) {
    const double wide = (double)a->texture[r]->width, high = (double)a->texture[r]->height;
    const double u1 = wide * (double)(a->u[1][r] - a->u[0][r]), u2 = wide * (double)(a->u[2][r] - a->u[0][r]);
    const double v1 = high * (double)(a->v[1][r] - a->v[0][r]), v2 = high * (double)(a->v[2][r] - a->v[0][r]);
    const double a1 = block->a1[r], a2 = block->a2[r], b1 = block->b1[r], b2 = block->b2[r];
    const double a_sum = block->a0[r] + a1 + a2, b_sum = block->b0[r] + b1 + b2;
    const double *restrict e0 = block->e0 + n, *restrict e1 = block->e1 + n, *restrict e2 = block->e2 + n;
    const float *restrict w1 = block->w1 + n, *restrict w2 = block->w2 + n;
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        const double each = 1.0 / (e0[l] + e1[l] + e2[l]), p = (double)w1[l], q = (double)w2[l];
        const double x1 = (a1 - p * a_sum) * each, x2 = (a2 - q * a_sum) * each;
        const double y1 = (b1 - p * b_sum) * each, y2 = (b2 - q * b_sum) * each;
        const double ux = u1 * x1 + u2 * x2, vx = v1 * x1 + v2 * x2, uy = u1 * y1 + u2 * y2,
                     vy = v1 * y1 + v2 * y2;
        const double area = ux * vy - uy * vx, along_x = ux * ux + vx * vx, along_y = uy * uy + vy * vy;
        squared[l] = (float)(footprint_squared * area * area / (along_x > along_y ? along_x : along_y));
    }
}

static inline void choose_levels(const sl_resolve_block *block, const sl_albedo_block *a, uint32_t r,
                                 uint32_t n, lookups *at) {
    const sl_mip *mip = a->mip[r];
    float squared[LANES];
    if (!mip) {
        for (int l = 0; l < LANES; l++)
            at->level[l] = 0, at->width[l] = a->texture[r]->width, at->height[l] = a->texture[r]->height;
        return;
    }
    measure(block, a, r, n, squared);
    for (int l = 0; l < LANES; l++) {
        at->level[l] = sl_mip_level_for(squared[l], mip->count);
        at->width[l] = mip->level[at->level[l]].width;
        at->height[l] = mip->level[at->level[l]].height;
    }
}

static inline void place(const sl_albedo_block *a, uint32_t r, const float *restrict w1,
                         const float *restrict w2, lookups *at) {
    const float u0 = a->u[0][r], u1 = a->u[1][r] - u0, u2 = a->u[2][r] - u0;
    const float v0 = a->v[0][r], v1 = a->v[1][r] - v0, v2 = a->v[2][r] - v0;
    const int32_t *restrict width = at->width, *restrict height = at->height;
    uint32_t *restrict t0 = at->texel[0], *restrict t1 = at->texel[1], *restrict t2 = at->texel[2],
                       *restrict t3 = at->texel[3];
    float *restrict right = at->right, *restrict up = at->up;
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        sl_texel_pair column = sl_texel_pair_at(sl_interpolate(u0, u1, u2, w1[l], w2[l]), width[l]);
        sl_texel_pair row = sl_texel_pair_at(sl_interpolate(v0, v1, v2, w1[l], w2[l]), height[l]);
        uint32_t low = (uint32_t)(height[l] - 1 - row.texel) * (uint32_t)width[l];
        uint32_t high = (uint32_t)(height[l] - 1 - row.next) * (uint32_t)width[l];
        t0[l] = low + (uint32_t)column.texel;
        t1[l] = low + (uint32_t)column.next;
        t2[l] = high + (uint32_t)column.texel;
        t3[l] = high + (uint32_t)column.next;
        right[l] = column.beyond;
        up[l] = row.beyond;
    }
}

static inline void fetch(const uint8_t *texels, const sl_mip *mip, uint32_t lanes, lookups *at) {
    for (int k = 0; k < 4; k++) {
        for (uint32_t l = 0; l < lanes; l++) {
            const size_t texel = 4 * (size_t)at->texel[k][l];
            const uint8_t *plain = texels + texel;
            const uint16_t *mean = at->level[l] ? mip->level[at->level[l]].texels + texel : NULL;
            for (int c = 0; c < 3; c++)
                at->value[c][k][l] =
                    mean ? (float)mean[c] * (1.0f / SL_MIP_ONE) : sl_srgb_to_linear[plain[c]];
        }
    }
}

static inline void mix(const lookups *at, int channel, float kd, float *restrict out) {
    const float *restrict a = at->value[channel][0], *restrict b = at->value[channel][1],
                          *restrict c = at->value[channel][2], *restrict d = at->value[channel][3],
                          *restrict right = at->right, *restrict up = at->up;
#pragma omp simd
    for (int l = 0; l < LANES; l++) out[l] = kd * sl_texel_bilinear(a[l], b[l], c[l], d[l], right[l], up[l]);
}

void SL_KERNEL(sl_resolve_albedo)(const sl_resolve_block *block, const sl_albedo_block *a,
                                  sl_vector_planes *out) {
    lookups at;
    memset(&at, 0, sizeof at);
    for (uint32_t r = 0; r < block->runs; r++) {
        for (uint32_t n = block->start[r], end = block->start[r + 1]; n < end; n += LANES) {
            float *restrict red = out->x + n, *restrict green = out->y + n, *restrict blue = out->z + n;
            if (a->texture[r]) {
                choose_levels(block, a, r, n, &at);
                place(a, r, block->w1 + n, block->w2 + n, &at);
                fetch(a->texture[r]->texels, a->mip[r], end - n < LANES ? end - n : LANES, &at);
                mix(&at, 0, a->red[r], red);
                mix(&at, 1, a->green[r], green);
                mix(&at, 2, a->blue[r], blue);
                continue;
            }
            const float kd_red = a->red[r], kd_green = a->green[r], kd_blue = a->blue[r];
#pragma omp simd
            for (int l = 0; l < LANES; l++) {
                red[l] = kd_red;
                green[l] = kd_green;
                blue[l] = kd_blue;
            }
        }
    }
}
