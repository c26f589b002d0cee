#include "cache/light/light_kernels.h"

/* The first side whose cumulative sum exceeds u0 of the whole; sums fall in no gap, since u0 < 1. */
static void choose(const sl_aim_block *block, int32_t *restrict chosen) {
    const size_t count = block->points->count;
    const float *restrict u0 = block->u0, *restrict total = block->sums + (block->sides - 1) * SL_LIGHT_BLOCK;
    for (size_t i = 0; i < count; i++) chosen[i] = 0;
    for (size_t side = 0; side + 1 < block->sides; side++) {
        const float *restrict sum = block->sums + side * SL_LIGHT_BLOCK;
#pragma omp simd
        for (size_t i = 0; i < count; i++) chosen[i] += u0[i] * total[i] >= sum[i] ? 1 : 0;
    }
}

void SL_KERNEL(sl_direct_aim)(const sl_aim_block *block) {
    const size_t count = block->points->count;
    int32_t *restrict chosen = block->chosen, base[SL_LIGHT_BLOCK], place[SL_LIGHT_BLOCK];
    choose(block, chosen);
    for (size_t i = 0; i < count; i++) {
        base[i] = (int32_t)block->side[chosen[i]] * SL_SIDE_VALUES;
        place[i] = chosen[i] * SL_LIGHT_BLOCK + (int32_t)i;
    }
    const float *restrict px = block->points->x, *restrict py = block->points->y,
                          *restrict pz = block->points->z;
    const float *restrict nx = block->points->normal_x, *restrict ny = block->points->normal_y,
                          *restrict nz = block->points->normal_z;
    const float *restrict gx = block->points->geometric_x, *restrict gy = block->points->geometric_y,
                          *restrict gz = block->points->geometric_z;
    const float *restrict u1 = block->u1, *restrict u2 = block->u2, *restrict share = block->share;
    const float *restrict total = block->sums + (block->sides - 1) * SL_LIGHT_BLOCK;
    const float *t0 = block->values, *t1 = t0 + 1, *t2 = t0 + 2, *t3 = t0 + 3, *t4 = t0 + 4, *t5 = t0 + 5,
                *t6 = t0 + 6, *t7 = t0 + 7;
    const float *t8 = t0 + 8, *t9 = t0 + 9, *t10 = t0 + 10, *t11 = t0 + 11, *t12 = t0 + 12, *t13 = t0 + 13,
                *t14 = t0 + 14, *t15 = t0 + 15;
    float *restrict x = block->x, *restrict y = block->y, *restrict z = block->z,
                    *restrict weight = block->weight;
    float *restrict r = block->r, *restrict g = block->g, *restrict b = block->b,
                    *restrict wanted = block->wanted;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        int32_t k = base[i];
        /* uniform on the triangle */
        float root = sqrtf(u1[i]), w1 = root * (1.0f - u2[i]), w2 = root * u2[i];
        float tx = t0[k] + w1 * t3[k] + w2 * t6[k] - px[i];
        float ty = t1[k] + w1 * t4[k] + w2 * t7[k] - py[i];
        float tz = t2[k] + w1 * t5[k] + w2 * t8[k] - pz[i];
        float squared = tx * tx + ty * ty + tz * tz;
        float cosine = nx[i] * tx + ny[i] * ty + nz[i] * tz,
              emitted = -(t9[k] * tx + t10[k] * ty + t11[k] * tz);
        float facing = gx[i] * tx + gy[i] * ty + gz[i] * tz, exact = share[place[i]];
        /* f / pdf = (cos cos' A / d^2) / (E_side / E_all), both cosines times d. */
        float form = t12[k] * cosine * emitted / (squared > 0.0f ? squared * squared : 1.0f);
        float relative = form / (exact > 0.0f ? exact : 1.0f);
        bool lit = cosine > 0.0f && emitted > 0.0f && exact > 0.0f && squared > 0.0f;
        x[i] = tx;
        y[i] = ty;
        z[i] = tz;
        r[i] = t13[k];
        g[i] = t14[k];
        b[i] = t15[k];
        weight[i] = lit ? relative * total[i] : 0.0f;
        wanted[i] = lit && facing > 0.0f ? 1.0f : 0.0f;
    }
}
