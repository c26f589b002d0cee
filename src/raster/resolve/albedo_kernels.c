/* Albedo: a run's material says it, times its texture where there is one; to the bit as sl_scene_diffuse().
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
    uint32_t texel[4][LANES]; /* lower left, lower right, upper left, upper right */
    float right[LANES], up[LANES];
    float value[3][4][LANES]; /* linear: channel, texel */
} lookups;

static inline void place(const sl_albedo_block *a, uint32_t r, const float *restrict w1,
                         const float *restrict w2, lookups *at) {
    const float u0 = a->u[0][r], u1 = a->u[1][r] - u0, u2 = a->u[2][r] - u0;
    const float v0 = a->v[0][r], v1 = a->v[1][r] - v0, v2 = a->v[2][r] - v0;
    const int32_t width = a->texture[r]->width, height = a->texture[r]->height;
    uint32_t *restrict t0 = at->texel[0], *restrict t1 = at->texel[1], *restrict t2 = at->texel[2],
                       *restrict t3 = at->texel[3];
    float *restrict right = at->right, *restrict up = at->up;
#pragma omp simd
    for (int l = 0; l < LANES; l++) {
        sl_texel_pair column = sl_texel_pair_at(sl_interpolate(u0, u1, u2, w1[l], w2[l]), width);
        sl_texel_pair row = sl_texel_pair_at(sl_interpolate(v0, v1, v2, w1[l], w2[l]), height);
        uint32_t low = (uint32_t)(height - 1 - row.texel) * (uint32_t)width;
        uint32_t high = (uint32_t)(height - 1 - row.next) * (uint32_t)width;
        t0[l] = low + (uint32_t)column.texel;
        t1[l] = low + (uint32_t)column.next;
        t2[l] = high + (uint32_t)column.texel;
        t3[l] = high + (uint32_t)column.next;
        right[l] = column.beyond;
        up[l] = row.beyond;
    }
}

static inline void fetch(const uint8_t *texels, uint32_t lanes, lookups *at) {
    for (int k = 0; k < 4; k++) {
        for (uint32_t l = 0; l < lanes; l++) {
            const uint8_t *t = texels + 4 * (size_t)at->texel[k][l];
            for (int c = 0; c < 3; c++) at->value[c][k][l] = sl_srgb_to_linear[t[c]];
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
                place(a, r, block->w1 + n, block->w2 + n, &at);
                fetch(a->texture[r]->texels, end - n < LANES ? end - n : LANES, &at);
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
